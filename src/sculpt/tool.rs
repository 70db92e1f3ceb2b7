//! A sheet as milled: the surface that a cutter leaves of its triangles, found another way than by the hulls of the
//! design.
//!
//! The cutter stands only over the points of a grid, as on a machine that counts steps, and sweeps over the triangles'
//! heights there ([`sweep`](super::sweep)). Its underside is taken as u(x) + u(y) in place of u(√(x² + y²)): the same along
//! both axes, for a ball of radius R lower by x²y²/4R³ between them, and separable. Only the part of the profile that can
//! touch the relief's slopes is swept.
//!
//! A cutter on a grid of places h apart leaves a hollow not as its own round but as a polygon, whose slopes are h/R apart
//! for a ball. Their light falls on the same few places of the picture from every hollow; no model of smooth fillets has
//! it, so that the design takes it from here (`Objective::update_tool_residual`).

use glam::DVec2;

use crate::cutter::Cutter;
use crate::progress::{Cancelled, Progress};
use crate::relief::periodic::PeriodicRelief;

use super::periodic_filter::smoothed;
use super::resample::sampled;
use super::rises::{Extremes, Rises};
use super::sweep::milled_heights;

/// Places along a side of a cell at the most: 4 million of them take 16 MB a copy, and 0.1 s to sweep.
const MOST: usize = 2000;

/// Places of the tool across a cutter, unless a cell would have more than [`MOST`].
///
/// What a plate is proved on: 0.01 mm for a ball of 0.5. On finer grids the same plate looks better (before the design knew
/// of the grid, SSIM at 0.5° was 0.895, 0.931 and 0.974 with 50, 100 and 400 places), so that this is a cautious choice.
pub(super) const PLACES_ACROSS_CUTTER: f64 = 50.0;

/// Places along a side of a cell without steps at the most: 268 million of them take 1 GB a copy, and seconds to sweep.
const MOST_FINE: usize = 1 << 14;

/// Height of the ridge left between two places of the tool without steps, mm: a twentieth of the clearance that the
/// design keeps.
const RIDGE: f64 = 0.025e-3;

/// A cutter over a grid of places.
#[derive(Clone, Debug)]
pub struct Tool {
    pub(super) cutter: Cutter,
    /// Places along a side of a cell, an even number.
    pub places: usize,
}

/// A relief after the cutter.
#[derive(Clone, Debug, PartialEq)]
pub struct Milled {
    /// One cell of the machined surface on the tool's grid.
    pub relief: PeriodicRelief,
    /// Height of the machined surface above the written one, mm, node for node of `relief`.
    pub left: Vec<f32>,
}

impl Milled {
    /// The most that the machined surface lies above the written one, mm: 0 if the cutter can follow it everywhere.
    pub(crate) fn most_left(&self) -> f64 {
        self.left.iter().fold(0.0, |most: f64, v| most.max(f64::from(*v)))
    }
}

impl Tool {
    /// `cutter` over cells of `cell` mm.
    pub fn new(cell: DVec2, cutter: Cutter) -> Self {
        let places = (cell.max_element() * PLACES_ACROSS_CUTTER / cutter.tip_diameter()).ceil() as usize;
        Self { cutter, places: places.next_multiple_of(2).clamp(16, MOST) }
    }

    /// `cutter` over places so close together that the ridges between them, h²/8R high, are about 0.025 µm: as good as
    /// without steps. Each of the `nodes` a side of a relief is a place, since that is where pits have their bottoms.
    pub(crate) fn without_steps(cell: DVec2, nodes: usize, cutter: Cutter) -> Self {
        let step = (cell / nodes as f64).max_element();
        let between_nodes = step / (8.0 * cutter.valley_radius() * RIDGE).sqrt();
        Self { cutter, places: nodes * between_nodes.round().max(1.0) as usize }
    }

    /// The diameter, mm, of the smallest ball that can be followed over cells of `cell` mm and `nodes` nodes a side: with a
    /// smaller one, [`without_steps`](Self::without_steps) would have more than [`MOST_FINE`] places a side.
    pub(crate) fn least_diameter(cell: DVec2, nodes: usize) -> f64 {
        let step = (cell / nodes as f64).max_element();
        // Places between nodes are rounded to the nearest whole number.
        let between_nodes = (MOST_FINE / nodes).max(1) as f64 + 0.5;
        (step / between_nodes).powi(2) / (4.0 * RIDGE)
    }

    /// Places over a whole cell.
    pub(crate) fn all_places(&self) -> f64 {
        (self.places as f64).powi(2)
    }

    /// One cell of `relief` as the cutter leaves it.
    pub fn mill(&self, relief: &PeriodicRelief, progress: &Progress) -> Result<Milled, Cancelled> {
        self.mill_below(relief, f32::INFINITY, progress)
    }

    /// The same, where rises of `cliff` mm or more from one place to the next are no part of the relief.
    pub(super) fn mill_below(
        &self,
        relief: &PeriodicRelief,
        cliff: f32,
        progress: &Progress,
    ) -> Result<Milled, Cancelled> {
        let n = self.places;
        let written = sampled(relief, n);
        let [along_x, along_y] = self.profiles(relief, Rises::of(&written, n, cliff).extremes());
        let z = milled_heights(&written, n, &along_x, &along_y, progress)?;
        let left = z.iter().zip(&written).map(|(a, b)| a - b).collect();
        let relief = PeriodicRelief { nodes: n, heights: z, cell: relief.cell, cells: [1, 1], tilt: relief.tilt };
        Ok(Milled { relief, left })
    }

    /// The parts of the profile along x and y that can touch `relief`, which rises by at least and at the most so many mm from
    /// place to place along either. Its mean plane is taken off, as it is off the heights.
    pub(super) fn profiles(&self, relief: &PeriodicRelief, rises: Extremes) -> [Vec<(isize, f32)>; 2] {
        let step = relief.cell / self.places as f64;
        [(step.x, relief.tilt.p, rises[0]), (step.y, relief.tilt.q, rises[1])].map(|(step, mean, [low, high])| {
            let touched = |rise: f32| self.cutter.contact(f64::from(rise) / step + mean) / step;
            let (from, to) = (touched(low).floor() as isize - 1, touched(high).ceil() as isize + 1);
            (from..=to)
                .map(|aside| {
                    let x = aside as f64 * step;
                    (aside, (mean * x - self.cutter.underside(x)) as f32)
                })
                .collect()
        })
    }
}

/// One cell of `relief` after polish or paint, if there is any, that smooths heights by a Gaussian of standard deviation
/// `sigma` mm.
pub fn polished(mut relief: PeriodicRelief, sigma: Option<f64>) -> PeriodicRelief {
    if let Some(sigma) = sigma {
        relief.heights = smoothed(&relief, sigma);
    }
    relief
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relief::periodic::drawn;
    use crate::slope::Slope;

    fn relief(nodes: usize, height: impl Fn(f64, f64) -> f64) -> PeriodicRelief {
        let heights = drawn(nodes, height);
        PeriodicRelief { nodes, heights, cell: DVec2::new(2.0, 1.0), cells: [3, 3], tilt: Slope::new(0.1, 0.0) }
    }

    #[test]
    fn ridges_stay_and_a_groove_gets_its_fillet() {
        // Slopes ±0.2 about the tilt, 0.1: at the bottom of the valley the ball stays R s²/2 above it, a little less
        // where its slopes are steeper.
        let roof = relief(40, |x, _| 0.4 * (x - 0.5).abs());
        let cut = Tool { cutter: Cutter::ball(0.5), places: 400 }.mill(&roof, &Progress::silent()).unwrap();
        assert!((cut.most_left() / (0.25 * 0.04 / 2.0) - 1.0).abs() < 0.03, "{}", cut.most_left());
        assert!((f64::from(cut.relief.heights[0]) - 0.2).abs() < 1e-6);
        assert_eq!((cut.relief.tilt, cut.relief.cells), (roof.tilt, [1, 1]));
    }

    #[test]
    fn the_sweeps_are_those_of_whole_balls() {
        let rough = relief(12, |x, y| ((x * 91.0 + y * 57.0).sin() * 43.0).fract() * 0.02);
        let (n, radius) = (24, 0.6);
        let cut = Tool { cutter: Cutter::ball(2.0 * radius), places: n }.mill(&rough, &Progress::silent()).unwrap();
        let step = rough.cell / n as f64;
        let z = sampled(&rough, n);
        // Steps from a place to another, the short way round.
        let way = |a: usize, b: usize| {
            let d = (b + n - a) % n;
            if 2 * d < n { d as f64 } else { d as f64 - n as f64 }
        };
        let drop = |a: usize, b: usize| {
            let (x, y) = (way(a % n, b % n) * step.x, way(a / n, b / n) * step.y);
            let arc = |x: f64| if x.abs() < radius { radius - (radius * radius - x * x).sqrt() } else { f64::INFINITY };
            arc(x) + arc(y) - 0.1 * x
        };
        let all = || 0..n * n;
        let path: Vec<f64> =
            all().map(|a| all().map(|b| f64::from(z[b]) - drop(a, b)).fold(f64::MIN, f64::max)).collect();
        for b in all().step_by(5) {
            let expected = all().map(|a| path[a] + drop(a, b)).fold(f64::MAX, f64::min);
            assert!((f64::from(cut.relief.heights[b]) - expected).abs() < 1e-6, "{b}");
        }
    }
}
