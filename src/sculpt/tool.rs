//! The relief as a ball cutter would really leave it, found another way than by the hulls of the design: its triangles
//! sampled where the tool can stand, and closed exactly.
//!
//! The tool stands only over points of a grid, as on a machine that counts steps. Its path is the highest ball over all
//! samples, and the surface left is the lowest ball along the path. The ball is taken as R - √(R² - x²) along x plus the
//! same along y: exact along both axes, between them blunter by x²y²/4R³, and separable, so that both sweeps part into
//! rows and columns. Only so much of the ball takes part as the relief has slopes.
//!
//! A tool on a grid leaves hollows of few slopes: the chords of its ball, h/R apart. This comb of light is not in the
//! picture, and where it falls is known only here.

use glam::DVec2;

use crate::cutter::Cutter;
use crate::progress::Progress;
use crate::relief::periodic::PeriodicRelief;

use super::periodic_filter::smoothed;
use super::resample::sampled;
use super::sweep::milled_heights;

/// Places along a side of a cell at the most.
const MOST: usize = 2000;

/// Places of the tool across a cutter, unless a cell would have more than [`MOST`].
pub(super) const PLACES_ACROSS_CUTTER: f64 = 50.0;

/// mm.
const SAG: f64 = 0.025e-3;

/// A ball cutter over a grid of places.
#[derive(Clone, Debug)]
pub struct Tool {
    cutter: Cutter,
    /// Places along a side of a cell, an even number.
    pub places: usize,
}

/// A relief after the cutter.
#[derive(Clone, Debug, PartialEq)]
pub struct Milled {
    /// One cell of the machined surface on the tool's grid.
    pub relief: PeriodicRelief,
    /// How far the cutter stays above the written surface, mm, node for node of `relief`.
    pub left: Vec<f32>,
}

impl Milled {
    /// The most that the cutter stays above the written surface, mm: 0 if it can follow it everywhere.
    pub fn most_left(&self) -> f64 {
        self.left.iter().fold(0.0, |most: f64, v| most.max(f64::from(*v)))
    }
}

impl Tool {
    /// `cutter` over cells of `cell` mm.
    pub fn new(cell: DVec2, cutter: Cutter) -> Self {
        let places = (cell.max_element() * PLACES_ACROSS_CUTTER / cutter.diameter()).ceil() as usize;
        Self { cutter, places: places.next_multiple_of(2).clamp(16, MOST) }
    }

    /// The same ball over places so close that its path between them sags by about 0.025 µm, h²/8R: as good as one that
    /// moves without steps. Each node of `relief` is one of them, since pits are at nodes.
    pub fn without_steps(relief: &PeriodicRelief, cutter: Cutter) -> Self {
        let between_nodes = relief.step().max_element() / (8.0 * cutter.valley_radius() * SAG).sqrt();
        Self { cutter, places: relief.nodes * between_nodes.round().max(1.0) as usize }
    }

    /// One cell of `relief` as the tool leaves it; abandoned, what nobody should use.
    pub fn mill(&self, relief: &PeriodicRelief, progress: &Progress) -> Milled {
        let n = self.places;
        let written = sampled(relief, n);
        let step = relief.cell / n as f64;
        let rise = |k: usize, next: usize| written[next] - written[k];
        let along_x = self.profile((0..n * n).map(|k| rise(k, k / n * n + (k + 1) % n)), step.x, relief.tilt.p);
        let along_y = self.profile((0..n * n).map(|k| rise(k, (k + n) % (n * n))), step.y, relief.tilt.q);
        let z = milled_heights(&written, n, &along_x, &along_y, progress);
        let left = z.iter().zip(&written).map(|(a, b)| a - b).collect();
        let relief = PeriodicRelief { nodes: n, heights: z, cell: relief.cell, cells: [1, 1], tilt: relief.tilt };
        Milled { relief, left }
    }

    /// The part of the ball that can touch a relief which rises by `rises` from sample to sample, `step` mm apart, about a
    /// mean slope: steps aside, and how far the ball lies below its tip there, the mean slope taken off.
    fn profile(&self, rises: impl Iterator<Item = f32>, step: f64, mean: f64) -> Vec<(isize, f32)> {
        let (low, high) = rises.fold((0.0f32, 0.0f32), |r, v| (r.0.min(v), r.1.max(v)));
        let touched = |rise: f32| self.cutter.contact(f64::from(rise) / step + mean) / step;
        let (from, to) = (touched(low).floor() as isize - 1, touched(high).ceil() as isize + 1);
        (from..=to)
            .map(|aside| {
                let x = aside as f64 * step;
                (aside, (mean * x - self.cutter.underside(x)) as f32)
            })
            .collect()
    }

    /// Raises nodes of `relief` wherever the cutter stays more than `most` mm above its triangles, until it does nowhere.
    ///
    /// Few nodes need it; a hundred rounds are the limit, which nothing met so far has come near. Returns whether any did.
    pub fn fill(&self, relief: &mut PeriodicRelief, most: f64, progress: &Progress) -> bool {
        const ROUNDS: usize = 100;
        let (n, places) = (relief.nodes, self.places);
        for round in 0..ROUNDS {
            let milled = self.mill(relief, progress);
            if progress.is_abandoned() {
                return false;
            }
            let mut raise = vec![0.0f32; n * n];
            for (k, left) in milled.left.iter().enumerate().filter(|(_, left)| f64::from(**left) > most) {
                let at = [k % places, k / places].map(|c| (c * n / places, (c * n % places) as f32 / places as f32));
                let [(i, a), (j, b)] = at;
                let excess = left - 0.8 * most as f32;
                for (x, y, share) in
                    [(0, 0, (1.0 - a) * (1.0 - b)), (1, 0, a * (1.0 - b)), (0, 1, (1.0 - a) * b), (1, 1, a * b)]
                {
                    let node = &mut raise[(j + y) % n * n + (i + x) % n];
                    *node = node.max(excess * share);
                }
            }
            if raise.iter().all(|v| *v == 0.0) {
                return round > 0;
            }
            relief.heights.iter_mut().zip(&raise).for_each(|(z, v)| *z += v);
        }
        true
    }
}

/// One cell of `relief` after polish or paint that smooths heights by a Gaussian of standard deviation `sigma` mm.
pub fn polished(mut relief: PeriodicRelief, sigma: f64) -> PeriodicRelief {
    if sigma > 0.0 {
        relief.heights = smoothed(&relief, sigma);
    }
    relief
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slope::Slope;

    fn relief(nodes: usize, height: impl Fn(f64, f64) -> f64) -> PeriodicRelief {
        let heights = (0..nodes * nodes)
            .map(|k| height((k % nodes) as f64 / nodes as f64, (k / nodes) as f64 / nodes as f64) as f32)
            .collect();
        PeriodicRelief { nodes, heights, cell: DVec2::new(2.0, 1.0), cells: [3, 3], tilt: Slope::new(0.1, 0.0) }
    }

    #[test]
    fn ridges_stay_and_a_groove_gets_its_fillet() {
        // Slopes ±0.2 about the tilt, 0.1: at the bottom of the valley the ball stays R s²/2 above it, a little less
        // where its slopes are steeper.
        let roof = relief(40, |x, _| 0.4 * (x - 0.5).abs());
        let cut = Tool { cutter: Cutter::ball(0.5), places: 400 }.mill(&roof, &Progress::silent());
        assert!((cut.most_left() / (0.25 * 0.04 / 2.0) - 1.0).abs() < 0.03, "{}", cut.most_left());
        assert!((f64::from(cut.relief.heights[0]) - 0.2).abs() < 1e-6);
        assert_eq!((cut.relief.tilt, cut.relief.cells), (roof.tilt, [1, 1]));
    }

    #[test]
    fn the_sweeps_are_those_of_whole_balls() {
        let rough = relief(12, |x, y| ((x * 91.0 + y * 57.0).sin() * 43.0).fract() * 0.02);
        let (n, radius) = (24, 0.6);
        let cut = Tool { cutter: Cutter::ball(2.0 * radius), places: n }.mill(&rough, &Progress::silent());
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

    #[test]
    fn what_the_cutter_cannot_reach_is_filled() {
        let mut rough = relief(40, |x, y| 0.05 * (x - 0.5).abs() + 0.002 * (9.0 * y).sin().max(0.7));
        let tool = Tool::new(rough.cell, Cutter::ball(0.5));
        let before = rough.clone();
        assert!(tool.mill(&rough, &Progress::silent()).most_left() > 2e-4);
        tool.fill(&mut rough, 2e-4, &Progress::silent());
        assert!(tool.mill(&rough, &Progress::silent()).most_left() <= 2e-4);
        assert!(rough.heights.iter().zip(&before.heights).all(|(a, b)| a >= b));
    }
}
