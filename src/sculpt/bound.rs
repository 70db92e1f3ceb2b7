//! A lower bound on the light that falls outside the drawing on every relief that a cutter can reach everywhere.
//!
//! A tip of valley radius R reaches every point of a relief z exactly where |x|²/2R - z is convex (a paraboloid in place
//! of the ball, as in `closing.rs`). On the way along any straight line the slope may fall at once, at a ridge, but rises by
//! no more than t/R over a way t. Along a direction of the lattice of cells the line closes after one period L, so that
//! the slope s along it, counted from the mean slope, has mean 0. Take a < 0 < b. On such a line, of three things one
//! holds:
//!
//! - it comes down to a and up to b: then it climbs from a to b, which takes it a way of (b - a)·R at least;
//! - it never reaches b: then of its length a share T lies above a, and 0 = ∫ s ≤ b·T + a·(1 - T), so that
//!   T ≥ -a/(b - a);
//! - it never comes down to a: then a share of b/(b - a) at least lies below b, by the same sum.
//!
//! Lines of one direction cover the plate evenly, so of its area
//!
//! ```text
//!     at least  min((b - a)·R/L, -a/(b - a), b/(b - a))  has a slope between a and b,
//! ```
//!
//! and if the drawing wants only m(a, b) there, the excess falls where it is not wanted: it is total variation, of which a
//! blur much narrower than the gap hides little. The first of the three is nearly always the smallest; without the other two the bound is wrong,
//! since a line may keep just below 0 on most of its way and make up for it by a short climb. For light at
//! ±s along x alone the bound 2s·R/L is met by a roof.
//!
//! A true ball turns faster than its parabola where it touches at a slope s, at most by the factor (1 + s²)^(3/2): 5 % at
//! 10°. By so much may its fillets be narrower. Shares are of the plate's area, which is the light at normal incidence.

use glam::DVec2;
use rayon::prelude::*;

use crate::cutter::Cutter;

/// Directions of the lines, as cells along x and y to one period: the two axes, the two diagonals, and what lies between.
const DIRECTIONS: [[i32; 2]; 8] = [[1, 0], [0, 1], [1, 1], [1, -1], [2, 1], [2, -1], [1, 2], [1, -2]];

/// Ends of a gap that are tried on either side of 0: each of 256² pairs, which takes milliseconds. More narrow the bound's
/// loss, at most the share that one in 256 of the width holds.
const ENDS: usize = 256;

/// Light that cannot fall where it is wanted, and what shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unavoidable {
    /// Share of the plate's area whose light cannot be where it is wanted; 0 if nothing stands in the way.
    pub share: f64,
    /// Cells along x and y to one period of the lines that show it.
    pub along: [i32; 2],
    /// The slopes along these lines, relative to the mean slope, between which that light falls: a < 0 < b, or both 0.
    pub gap: [f64; 2],
}

/// The largest of the bounds for every periodic relief that the tip of `cutter` can follow.
///
/// `slopes` are the wanted ones relative to their mean, equal shares each, as of
/// [`SlopePlane::samples`](super::target::SlopePlane::samples); `cell` is the size of a cell, mm. Gaps between
/// neighbouring samples pass for gaps of the drawing: with 65 536 of them that is an error of some 10⁻⁵.
pub(crate) fn unavoidable(slopes: &[DVec2], cell: DVec2, cutter: Cutter) -> Unavoidable {
    let nothing = Unavoidable { share: 0.0, along: DIRECTIONS[0], gap: [0.0; 2] };
    let bounds: Vec<Unavoidable> = DIRECTIONS
        .into_par_iter()
        .map(|along| {
            let period = cell * DVec2::new(f64::from(along[0]), f64::from(along[1]));
            let length = period.length();
            let components: Vec<f64> = slopes.iter().map(|s| s.dot(period) / length).collect();
            let (share, gap) = along_lines(components, cutter.valley_radius() / length);
            Unavoidable { share, along, gap }
        })
        .collect();
    bounds.into_iter().fold(nothing, |most, bound| if bound.share > most.share { bound } else { most })
}

/// An end of a gap, on one side of 0.
#[derive(Clone, Copy)]
struct End {
    /// Distance from 0.
    at: f64,
    /// Share of the samples between 0 and here.
    inside: f64,
}

/// The bound from slopes along lines on which `climb` of the length passes per unit of slope.
fn along_lines(slopes: Vec<f64>, climb: f64) -> (f64, [f64; 2]) {
    let each = 1.0 / slopes.len() as f64;
    let (mut above, mut below) = (Vec::new(), Vec::new());
    let mut level = 0.0;
    for s in slopes {
        match s {
            s if s > 0.0 => above.push(s),
            s if s < 0.0 => below.push(-s),
            _ => level += each,
        }
    }
    let [above, below] = [above, below].map(|side| ends(side, each, climb));
    let mut most = (0.0, [0.0; 2]);
    for a in &below {
        for b in &above {
            let width = a.at + b.at;
            let share = (width * climb).min(a.at.min(b.at) / width) - a.inside - b.inside - level;
            if share > most.0 {
                most = (share, [-a.at, b.at]);
            }
        }
    }
    most
}

/// Where gaps may end on one side of 0: in each of many short pieces the best place, just before a sample.
fn ends(mut side: Vec<f64>, each: f64, climb: f64) -> Vec<End> {
    side.sort_unstable_by(f64::total_cmp);
    let Some(&farthest) = side.last() else { return Vec::new() };
    let mut ends: Vec<Option<End>> = vec![None; ENDS];
    for (k, &at) in side.iter().enumerate() {
        let end = End { at, inside: each * k as f64 };
        let place = &mut ends[((at / farthest * ENDS as f64) as usize).min(ENDS - 1)];
        // Of samples at the same place the first counts: none of them lies inside.
        if place.is_none_or(|held| climb * end.at - end.inside > climb * held.at - held.inside) {
            *place = Some(end);
        }
    }
    ends.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELL: DVec2 = DVec2::new(10.0, 8.0);
    const BALL: Cutter = Cutter::Ball { diameter: 1.0 };

    /// Slopes of a picture of `side`² pixels that cover ±`steepest`, about their mean.
    fn picture(side: usize, steepest: f64, lit: impl Fn(f64, f64) -> bool) -> Vec<DVec2> {
        let place = |k: usize| (2.0 * k as f64 + 1.0) / side as f64 - 1.0;
        let mut slopes: Vec<DVec2> = (0..side * side)
            .map(|k| DVec2::new(place(k % side), place(k / side)))
            .filter(|uv| lit(uv.x, uv.y))
            .map(|uv| steepest * uv)
            .collect();
        let mean = slopes.iter().sum::<DVec2>() / slopes.len() as f64;
        slopes.iter_mut().for_each(|s| *s -= mean);
        slopes
    }

    #[test]
    fn two_points_cost_the_climb_between_them() {
        let s = 0.1;
        for (point, along, length) in [(DVec2::X, [1, 0], 10.0), (DVec2::Y, [0, 1], 8.0)] {
            let bound = unavoidable(&[s * point, -s * point], CELL, BALL);
            assert!((bound.share - 2.0 * s * 0.5 / length).abs() < 1e-15, "{bound:?}");
            assert_eq!((bound.along, bound.gap), (along, [-s, s]));
        }
        // Across the axes of the cell a diagonal shows it best, if its period is not too long.
        let across = DVec2::new(1.0, -1.0) / f64::sqrt(2.0);
        let bound = unavoidable(&[s * across, -s * across], DVec2::ONE, Cutter::ball(0.2));
        let [axis, diagonal] = [2.0 * s * 0.1 / f64::sqrt(2.0); 2];
        assert!((bound.share - axis.max(diagonal)).abs() < 1e-12, "{bound:?}");
    }

    /// The slopes, along x, of a line that climbs as the ball lets it from `low` to `high`, where it stays as long as its
    /// mean of 0 asks, and falls back at a ridge to where it came from.
    fn line(low: f64, high: f64, climb: f64) -> Vec<DVec2> {
        let ramp = climb * (high - low);
        let rest = 1.0 - ramp;
        let at_high = (-0.5 * ramp * (low + high) - rest * low) / (high - low);
        assert!((0.0..=rest).contains(&at_high));
        let slope = |t: f64| (low + (t - (rest - at_high)).max(0.0) / climb).min(high);
        let slopes: Vec<DVec2> = (0..50_000).map(|k| DVec2::new(slope((f64::from(k) + 0.5) / 5e4), 0.0)).collect();
        assert!(slopes.iter().sum::<DVec2>().length() < 5e4 * 1e-6);
        slopes
    }

    #[test]
    fn slopes_of_lines_that_can_be_cut_cost_nothing() {
        // Lines lie side by side along x: any mixture of them is a relief without stray light.
        let climb: f64 = 0.1;
        let kinds = [(-0.001, 0.04), (-0.01, 0.14), (-0.1, 0.1), (-0.05, 0.002), (-0.000_12, 0.045), (-0.17, 0.17)]
            .map(|(low, high)| line(low, high, climb));
        for a in &kinds {
            for b in &kinds {
                let bound =
                    unavoidable(&[a.as_slice(), b.as_slice()].concat(), DVec2::splat(10.0), Cutter::ball(20.0 * climb));
                assert!(bound.share < 5e-5, "{bound:?}");
            }
        }
    }

    #[test]
    fn slopes_with_no_gap_cost_nothing() {
        let square = picture(256, 0.17, |_, _| true);
        let disc = picture(256, 0.17, |u, v| u.hypot(v) < 0.9);
        let ring = picture(256, 0.17, |u, v| (0.6..0.8).contains(&u.hypot(v)));
        let l = picture(256, 0.17, |u, v| u.abs().max(v.abs()) < 0.8 && (u < -0.4 || v < -0.4));
        for slopes in [square, disc, ring, l] {
            // A pixel's width is a gap too, as far as samples tell.
            assert!(unavoidable(&slopes, CELL, Cutter::ball(0.2)).share < 2e-5);
        }
        assert_eq!(unavoidable(&[], CELL, BALL).share, 0.0);
        assert_eq!(unavoidable(&[DVec2::ZERO; 9], CELL, BALL).share, 0.0);
    }

    #[test]
    fn two_discs_cost_what_lies_between_them_and_more_with_a_blunter_ball() {
        let discs = picture(256, 0.17, |u, v| (u.abs() - 0.6).hypot(v) < 0.3);
        let mut last = 0.0;
        for radius in [0.1, 0.3, 0.5, 1.0, 3.0, 10.0] {
            let bound = unavoidable(&discs, CELL, Cutter::ball(2.0 * radius));
            assert!(bound.share > last && bound.share <= 0.5, "{radius}: {bound:?}");
            assert_eq!(bound.along, [1, 0]);
            // The gap is 0.102 wide; the edges of the discs are so dim that it pays to count a little of them.
            let gap = bound.gap[1] - bound.gap[0];
            let plain = 0.102 * radius / CELL.x;
            assert!(gap >= 0.1 && bound.share > 0.97 * plain && bound.share < 1.7 * plain, "{radius}: {bound:?}");
            last = bound.share;
        }
    }
}
