//! Bounds on height by which a rising ray is known to escape without following it.
//!
//! For a steepness S and a cell c, let C be the highest that any other cell still reaches after falling by S for every
//! mm of its horizontal gap to c. A ray over c at a height of C or more that climbs at least S for every mm of way
//! passes over everything but c itself. (A cone over each cell, as in the cone maps of Dummer, "Cone Step Mapping", 2006,
//! but turned round: theirs say how far a ray may go, these that it need not be followed at all.)
//!
//! Gaps are taken as multiples of the shortest pitch in the larger of the two axes, which is never more than the true
//! gap, so the bounds are safe; two sweeps over the grid find them exactly in this metric (Rosenfeld and Pfaltz 1968).

use glam::DVec3;

use crate::progress::{Cancelled, Progress};

/// The steepnesses for which bounds are kept, dz over horizontal way: within 18°, 45° and 76° of the normal.
const STEEPNESS: [f64; 3] = [3.0, 1.0, 0.25];

/// The bounds of each cell, one a steepness.
#[derive(Clone, Debug)]
pub(crate) struct EscapeBounds {
    bounds: Vec<[f32; STEEPNESS.len()]>,
}

impl EscapeBounds {
    /// From the highest point of each cell, rows of `columns`, and the shortest way across a cell. `periodic` grids
    /// continue into themselves.
    pub fn new(
        tops: &[f64],
        columns: usize,
        pitch: f64,
        periodic: bool,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let mut bounds = vec![[0.0; STEEPNESS.len()]; tops.len()];
        for (k, steepness) in STEEPNESS.iter().enumerate() {
            let fallen = fall(tops, columns, steepness * pitch, periodic, progress)?;
            for some in progress.stretches(tops.len()) {
                for index in some? {
                    let around = neighbours(index, columns, tops.len() / columns, periodic, &ALL);
                    let highest = around.map(|n| fallen[n]).fold(f64::NEG_INFINITY, f64::max);
                    bounds[index][k] = (highest as f32).next_up();
                }
            }
        }
        Ok(Self { bounds })
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.bounds.as_slice())
    }

    /// Which bound holds for rays along `direction`, if any does.
    #[inline]
    pub fn level(direction: DVec3) -> Option<usize> {
        let flat = direction.x * direction.x + direction.y * direction.y;
        let steep = direction.z * direction.z;
        if direction.z <= 0.0 {
            return None;
        }
        STEEPNESS.iter().position(|s| steep >= s * s * flat)
    }

    /// The height over cell `index` from which rays of a [`level`](Self::level) pass over all other cells.
    #[inline]
    pub fn bound(&self, index: usize, level: usize) -> f64 {
        f64::from(self.bounds[index][level])
    }
}

const BEFORE: [(isize, isize); 4] = [(-1, -1), (0, -1), (1, -1), (-1, 0)];
const AFTER: [(isize, isize); 4] = [(1, 1), (0, 1), (-1, 1), (1, 0)];
const ALL: [(isize, isize); 8] = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 1), (0, 1), (-1, 1), (1, 0)];

/// The highest of: each cell's own top, and every other's less `drop` for each step of a chess king between them.
fn fall(tops: &[f64], columns: usize, drop: f64, periodic: bool, progress: &Progress) -> Result<Vec<f64>, Cancelled> {
    let rows = tops.len() / columns;
    let mut heights = tops.to_vec();
    let mut settled = false;
    // One round settles a bounded grid. What comes round a periodic one needs another; the last finds nothing to do.
    while !settled {
        settled = true;
        let mut sweep = |index: usize, from: &[(isize, isize)]| {
            let highest = neighbours(index, columns, rows, periodic, from)
                .map(|n| heights[n] - drop)
                .fold(heights[index], f64::max);
            settled &= highest == heights[index];
            heights[index] = highest;
        };
        for some in progress.stretches(tops.len()) {
            some?.for_each(|index| sweep(index, &BEFORE));
        }
        for some in progress.stretches(tops.len()) {
            some?.for_each(|index| sweep(tops.len() - 1 - index, &AFTER));
        }
        settled |= !periodic;
    }
    Ok(heights)
}

fn neighbours(
    index: usize,
    columns: usize,
    rows: usize,
    periodic: bool,
    steps: &[(isize, isize)],
) -> impl Iterator<Item = usize> {
    let (i, j) = ((index % columns) as isize, (index / columns) as isize);
    steps.iter().filter_map(move |(di, dj)| {
        let (i, j) = (i + di, j + dj);
        if periodic {
            let (i, j) = (i.rem_euclid(columns as isize), j.rem_euclid(rows as isize));
            return Some(j as usize * columns + i as usize);
        }
        let inside = (0..columns as isize).contains(&i) && (0..rows as isize).contains(&j);
        inside.then(|| j as usize * columns + i as usize)
    })
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn bounds_are_what_a_search_over_all_cells_finds() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(4);
        for (columns, rows, periodic) in [(9, 7, false), (7, 5, true), (1, 6, false), (1, 1, false)] {
            let tops: Vec<f64> = (0..columns * rows).map(|_| 3.0 * random.random::<f64>().powi(3)).collect();
            let bounds = EscapeBounds::new(&tops, columns, 0.5, periodic, &Progress::silent()).unwrap();
            for (index, level) in (0..tops.len()).flat_map(|index| (0..STEEPNESS.len()).map(move |k| (index, k))) {
                let apart = |a: usize, b: usize, n: usize| {
                    let d = a.abs_diff(b);
                    if periodic { d.min(n - d) } else { d }
                };
                let expected = (0..tops.len())
                    .filter(|&other| other != index)
                    .map(|other| {
                        let (dx, dy) = (
                            apart(index % columns, other % columns, columns),
                            apart(index / columns, other / columns, rows),
                        );
                        tops[other] - STEEPNESS[level] * 0.5 * (dx.max(dy) - 1) as f64
                    })
                    .fold(f64::NEG_INFINITY, f64::max);
                let bound = bounds.bound(index, level);
                // What wraps round to a cell itself, or a neighbour's neighbour, may lift a bound, never lower it.
                assert!(bound >= expected, "{bound} {expected}");
                if !periodic && tops.len() > 1 && tops[index] < expected {
                    assert!(bound - expected < 1e-6, "{bound} {expected}");
                }
            }
        }
    }

    #[test]
    fn levels_go_from_steep_to_grazing() {
        assert_eq!(EscapeBounds::level(DVec3::Z), Some(0));
        assert_eq!(EscapeBounds::level(DVec3::new(1.0, 0.0, 1.0).normalize()), Some(1));
        assert_eq!(EscapeBounds::level(DVec3::new(1.0, 0.0, 0.9)), Some(2));
        assert_eq!(EscapeBounds::level(DVec3::new(1.0, 0.0, 0.1)), None);
        assert_eq!(EscapeBounds::level(-DVec3::Z), None);
        assert_eq!(EscapeBounds::level(DVec3::new(f64::NAN, 0.0, f64::NAN)), None);
    }
}
