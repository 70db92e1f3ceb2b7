//! A plate of facets as milled: fillets at the foot of walls and along valleys, ridges and upper edges kept.
//!
//! Grid and sweeps are those of `tool.rs`, but the plate does not repeat: beyond its rim nothing carries the cutter, which
//! goes down past it. At a wall a ball of radius R rests on the upper edge and on the lower facet: a step of height h < R
//! ends in an arc √(2Rh - h²) wide, and nothing of the wall is left.

use std::ops::Range;

use rayon::prelude::*;

use crate::cutter::Cutter;
use crate::progress::{Cancelled, Progress};
use crate::relief::faceted::FacetedRelief;
use crate::relief::height_grid::HeightGrid;

use super::sweep::milled_heights;
use super::tool::PLACES_ACROSS_CUTTER;

/// Places of the cutter over the optical area at the most: 64 MB a copy, four of them at a time.
const MOST: f64 = 1.6e7;

/// Fewest places across a cutter. With ten, the slopes of a ball's fillet are 0.2 apart: fewer say nothing of where its
/// light goes.
const LEAST_ACROSS_CUTTER: f64 = 10.0;

/// The optical area of a plate after the cutter.
#[derive(Clone, Debug, PartialEq)]
pub struct MilledFacets {
    /// The machined surface, a node for each place of the tool.
    pub surface: HeightGrid,
    /// The most that the machined surface lies above the facets, mm.
    pub most_left: f64,
}

/// About how many places `cutter` has over a plate of `area` mm².
pub fn places(area: f64, cutter: Cutter) -> f64 {
    (area * (PLACES_ACROSS_CUTTER / cutter.diameter()).powi(2)).min(MOST)
}

/// The smallest cutter whose fillets can be followed over a plate of `area` mm²: its diameter, mm.
pub(crate) fn least_diameter(area: f64) -> f64 {
    LEAST_ACROSS_CUTTER * (area / MOST).sqrt()
}

/// The optical area of `relief` after `cutter` was led over the whole plate.
pub fn milled_facets(relief: &FacetedRelief, cutter: Cutter, progress: &Progress) -> Result<MilledFacets, Cancelled> {
    let (columns, rows) = &relief.optical;
    let (low, high) = relief.optical_area();
    let facets = [columns.len(), rows.len()];
    let Places { intervals, step, .. } = Places::new((high - low).to_array(), facets, cutter);
    let x = Axis::new(&relief.x, low.x, step[0], intervals[0], cutter);
    let y = Axis::new(&relief.y, low.y, step[1], intervals[1], cutter);
    let width = x.pieces.len();
    let mut z = vec![f32::NEG_INFINITY; width * y.pieces.len()];
    z.par_chunks_mut(width).enumerate().with_min_len(16).try_for_each(|(j, row)| {
        for (i, z) in row.iter_mut().enumerate() {
            *z = highest(relief, &x, &y, i, j) as f32;
        }
        progress.check()
    })?;
    let written = x.inner(&y, &z);
    let cut = x.inner(&y, &milled_heights(&z, width, &x.profile, &y.profile, progress)?);
    let most_left = cut.iter().zip(&written).map(|(a, b)| a - b).fold(0.0, f32::max).into();
    progress.check()?;
    let heights = cut.into_iter().map(f64::from).collect();
    Ok(MilledFacets { surface: HeightGrid::new(x.lines(), y.lines(), heights, progress)?, most_left })
}

/// How finely a cutter is followed over a plate of facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Places {
    /// Distance of places along x and y, mm.
    step: [f64; 2],
    /// Intervals over the optical area.
    intervals: [usize; 2],
    /// Places to either side of the axis that the cutter reaches.
    reach: [usize; 2],
}

impl Places {
    /// For `cutter` over an optical area of `size` mm that `facets` along x and y share.
    pub(crate) fn new(size: [f64; 2], facets: [usize; 2], cutter: Cutter) -> Self {
        // A whole number of places a facet, so that edges lie on places.
        let facets = facets.map(|n| n as f64);
        let wanted = cutter.diameter() / PLACES_ACROSS_CUTTER;
        let pitch = [size[0] / facets[0], size[1] / facets[1]];
        let each = pitch.map(|pitch| (pitch / wanted).ceil());
        let many = facets[0] * each[0] * facets[1] * each[1];
        let each = if many <= MOST { each } else { each.map(|n| (n * (MOST / many).sqrt()).floor().max(1.0)) };
        let step = [pitch[0] / each[0], pitch[1] / each[1]];
        let intervals = [0, 1].map(|axis| (facets[axis] * each[axis]) as usize);
        Self { step, intervals, reach: step.map(|step| reach(cutter, step)) }
    }

    /// All places, those beside the plate too.
    pub(crate) fn all(&self) -> f64 {
        let [x, y] = [0, 1].map(|axis| (self.intervals[axis] + 4 * self.reach[axis] + 1) as f64);
        x * y
    }

    /// Whether they cannot be swept in some seconds, or not in a gigabyte or two: a cutter that is wide for its facets has
    /// far to go beside the plate, and touches thousands of places at once.
    pub(crate) fn are_too_many(&self) -> bool {
        let sweeps = 2.0 * self.all() * self.reach.map(|reach| (2 * reach + 1) as f64).iter().sum::<f64>();
        self.all() > 4.0 * MOST || sweeps > 4e10
    }
}

/// Places that `cutter` reaches to either side, where they are `step` mm apart.
fn reach(cutter: Cutter, step: f64) -> usize {
    (cutter.reach() / step * (1.0 + 1e-12)) as usize
}

/// Places along one side of the plate: over the optical area, and twice the cutter's reach beyond it.
struct Axis {
    low: f64,
    step: f64,
    /// Intervals over the optical area.
    intervals: usize,
    /// Places beyond it on either side.
    margin: usize,
    /// The cells of the relief's grid that each place touches: none beyond the plate, two on a line.
    pieces: Vec<Range<usize>>,
    /// The cutter's profile in steps of the places.
    profile: Vec<(isize, f32)>,
}

impl Axis {
    fn new(lines: &[f64], low: f64, step: f64, intervals: usize, cutter: Cutter) -> Self {
        let reach = reach(cutter, step) as isize;
        let profile = (-reach..=reach).map(|aside| (aside, -cutter.underside(aside as f64 * step) as f32)).collect();
        let margin = 2 * reach as usize;
        let touched = |k: usize| {
            let (at, slack) = (low + (k as f64 - margin as f64) * step, 1e-6 * step);
            let cells = lines.len() - 1;
            let from = lines[1..].partition_point(|line| *line < at - slack);
            let to = lines[..cells].partition_point(|line| *line <= at + slack);
            from..to
        };
        let pieces = (0..=intervals + 2 * margin).map(touched).collect();
        Self { low, step, intervals, margin, pieces, profile }
    }

    /// Grid lines over the optical area, mm.
    fn lines(&self) -> Vec<f64> {
        (0..=self.intervals).map(|k| self.low + k as f64 * self.step).collect()
    }

    /// What of `z`, rows along this axis, lies over the optical area.
    fn inner(&self, across: &Self, z: &[f32]) -> Vec<f32> {
        let rows = z.chunks(self.pieces.len()).skip(across.margin).take(across.intervals + 1);
        rows.flat_map(|row| &row[self.margin..=self.margin + self.intervals]).copied().collect()
    }
}

/// The highest that stands at a place; nothing, far down, beyond the plate.
fn highest(relief: &FacetedRelief, x: &Axis, y: &Axis, i: usize, j: usize) -> f64 {
    let at = |axis: &Axis, k: usize| axis.low + (k as f64 - axis.margin as f64) * axis.step;
    let at = glam::DVec2::new(at(x, i), at(y, j));
    let cells = y.pieces[j].clone().flat_map(|row| x.pieces[i].clone().map(move |column| (column, row)));
    cells.map(|(column, row)| relief.plane_height(column, row, at)).fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::relief::faceted::Facet;
    use crate::slope::Slope;

    const RADIUS: f64 = 0.25;
    const BALL: Cutter = Cutter::Ball { diameter: 2.0 * RADIUS };

    /// Two facets side by side of 1 × 2 mm, planes through the heights `middle` mm at x = 1.
    fn pair(middle: [f64; 2], rises: [f64; 2]) -> FacetedRelief {
        let facet = |k: usize| {
            let height = middle[k] + rises[k] * (k as f64 - 0.5);
            Facet { height, slope: Slope::new(rises[k], 0.0) }
        };
        FacetedRelief::uniform(2, 1, DVec2::splat(2.0), vec![facet(0), facet(1)])
    }

    /// Compares all rows of a milled plate with a profile.
    fn assert_profile(plate: &MilledFacets, height: impl Fn(f64) -> f64) {
        let HeightGrid { x, y, heights, .. } = &plate.surface;
        assert_eq!((x[0], y[0], x.len(), y.len()), (0.0, 0.0, 201, 201));
        for (k, z) in heights.iter().enumerate() {
            let x = x[k % x.len()];
            assert!((z - height(x)).abs() < 1e-6, "{z} instead of {} at {x}", height(x));
        }
    }

    #[test]
    fn a_step_ends_in_the_balls_arc() {
        // 0.25² = 0.2² + 0.15²: the ball on the floor touches the edge of a step of 0.05 mm at 0.15 mm.
        let plate = milled_facets(&pair([0.05, 0.0], [0.0, 0.0]), BALL, &Progress::silent()).unwrap();
        assert_profile(&plate, |x| match x - 1.0 {
            d if d < 1e-9 => 0.05,
            d if d < 0.15 => RADIUS - (RADIUS * RADIUS - (0.15 - d) * (0.15 - d)).sqrt(),
            _ => 0.0,
        });
    }

    #[test]
    fn a_groove_gets_its_fillet() {
        // Sine 0.28, cosine 0.96: the fillet reaches R sin α = 0.07 mm to either side.
        let rise = 0.28 / 0.96;
        let plate = milled_facets(&pair([0.0, 0.0], [-rise, rise]), BALL, &Progress::silent()).unwrap();
        assert_profile(&plate, |x| match (x - 1.0).abs() {
            d if d < 0.07 => RADIUS / 0.96 - (RADIUS * RADIUS - d * d).sqrt(),
            d => rise * d,
        });
        assert!((plate.most_left - RADIUS * (1.0 / 0.96 - 1.0)).abs() < 1e-6);
    }

    #[test]
    fn the_plate_ends_at_its_rim() {
        // A ramp that began anew beyond the rim would have a fillet at its foot.
        let ramp = pair([0.0, 0.0], [0.3, 0.3]);
        let bare = milled_facets(&ramp, BALL, &Progress::silent()).unwrap();
        assert!(bare.most_left < 1e-6);
        // A border level with the foot: half the turn of slope lies in the ramp. tan(α/2) = 0.2, and the ball that
        // touches both stands 0.05 mm before the foot.
        let rise = 0.4 / (1.0 - 0.04);
        let bordered = pair([0.0, 0.0], [rise, rise]).with_rim(1.0);
        let cut = milled_facets(&bordered, BALL, &Progress::silent()).unwrap();
        assert_eq!(cut.surface.x, bare.surface.x);
        let at_foot = RADIUS - (RADIUS * RADIUS - 0.05 * 0.05).sqrt();
        assert!((cut.most_left - at_foot).abs() < 1e-6, "{} {at_foot}", cut.most_left);
        assert!((cut.surface.heights[0] - (at_foot - rise)).abs() < 1e-6);
    }

    #[test]
    fn a_small_ball_on_a_large_plate_has_fewer_places() {
        let facets = vec![Facet { height: 0.0, slope: Slope::FLAT }; 12];
        let plate = FacetedRelief::uniform(4, 3, DVec2::new(400.0, 300.0), facets);
        let coarse = milled_facets(&plate, Cutter::ball(0.2), &Progress::silent()).unwrap().surface;
        assert_eq!(((coarse.x.len() - 1) % 4, (coarse.y.len() - 1) % 3), (0, 0));
        let places = (coarse.x.len() * coarse.y.len()) as f64;
        assert!((0.9..1.01).contains(&(places / MOST)), "{places}");
        assert_eq!((coarse.x[coarse.x.len() - 1], coarse.y[coarse.y.len() - 1]), (400.0, 300.0));
        assert!((least_diameter(400.0 * 300.0) / 10.0 - 400.0 / (coarse.x.len() - 1) as f64).abs() < 0.01);
    }
}
