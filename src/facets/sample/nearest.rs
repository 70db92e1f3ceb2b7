//! Which points lie next to which, in time that no clustering of the points can spoil.

use glam::Vec2;
use rayon::prelude::*;

use crate::progress::{Cancelled, Progress};

/// Pairs (a, b), a < b, in ascending order, of points of which one is among the `count` nearest of the other
/// (`count` at most [`MOST`]).
pub fn neighbours(points: &[Vec2], count: usize, progress: &Progress) -> Result<Vec<(usize, usize)>, Cancelled> {
    let tree = Tree::new(points);
    let near = |a: usize| {
        let mut nearest = Nearest::new(count);
        tree.search(0..points.len(), points[a], a, &mut nearest);
        nearest.found.into_iter().take(nearest.len).map(move |(_, b)| (a.min(b), a.max(b)))
    };
    let stretch = |k: usize| {
        progress.check()?;
        Ok((STRETCH * k..(STRETCH * (k + 1)).min(points.len())).flat_map(near).collect())
    };
    let stretches = points.len().div_ceil(STRETCH);
    let pairs = (0..stretches).into_par_iter().map(stretch).collect::<Result<Vec<Vec<_>>, Cancelled>>()?;
    in_order(&pairs, points.len(), progress)
}

/// All `pairs` of numbers below `n`, each once and in ascending order: dealt out by their first numbers.
fn in_order(pairs: &[Vec<(usize, usize)>], n: usize, progress: &Progress) -> Result<Vec<(usize, usize)>, Cancelled> {
    // Each list's end is found by filling it, and is the next one's start.
    let mut starts = vec![0usize; n + 2];
    for some in pairs {
        some.iter().for_each(|(a, _)| starts[a + 2] += 1);
    }
    progress.check()?;
    for a in 1..starts.len() {
        starts[a] += starts[a - 1];
    }
    let mut seconds = vec![0usize; starts[n + 1]];
    for some in pairs {
        progress.check()?;
        for &(a, b) in some {
            seconds[starts[a + 1]] = b;
            starts[a + 1] += 1;
        }
    }
    let mut ordered = Vec::with_capacity(seconds.len());
    for some in progress.stretches(n) {
        for a in some? {
            let seconds = &mut seconds[starts[a]..starts[a + 1]];
            seconds.sort_unstable();
            let from = ordered.len();
            for &mut b in seconds {
                if ordered[from..].last() != Some(&(a, b)) {
                    ordered.push((a, b));
                }
            }
        }
    }
    Ok(ordered)
}

/// Points whose neighbours are found between two questions whether to go on.
const STRETCH: usize = 1024;

/// Neighbours of one point at the most.
pub const MOST: usize = 8;

/// Runs of points shorter than this are searched through.
const LEAF: usize = 8;

/// Indices of points in the order of a balanced tree: each run is split at its middle across the longer side of its
/// box, down to leaves.
struct Tree<'a> {
    points: &'a [Vec2],
    order: Vec<u32>,
    /// For the middle of each run, whether it is split across y.
    across_y: Vec<bool>,
}

impl<'a> Tree<'a> {
    fn new(points: &'a [Vec2]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let mut across_y = vec![false; points.len()];
        split(points, &mut order, &mut across_y);
        Self { points, order, across_y }
    }

    /// Offers every point of the run that can be among the nearest to `at`, but for point `own`.
    fn search(&self, run: std::ops::Range<usize>, at: Vec2, own: usize, nearest: &mut Nearest) {
        let mut offer = |k: u32| {
            if k as usize != own {
                nearest.offer(at.distance_squared(self.points[k as usize]), k as usize);
            }
        };
        if run.len() < LEAF {
            return self.order[run].iter().for_each(|&k| offer(k));
        }
        let middle = usize::midpoint(run.start, run.end);
        offer(self.order[middle]);
        let split = self.points[self.order[middle] as usize];
        let beyond = if self.across_y[middle] { at.y - split.y } else { at.x - split.x };
        let (low, high) = (run.start..middle, middle + 1..run.end);
        let (near, far) = if beyond < 0.0 { (low, high) } else { (high, low) };
        self.search(near, at, own, nearest);
        if beyond * beyond < nearest.reach() {
            self.search(far, at, own, nearest);
        }
    }
}

fn split(points: &[Vec2], order: &mut [u32], across_y: &mut [bool]) {
    if order.len() < LEAF {
        return;
    }
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for &k in order.iter() {
        (low, high) = (low.min(points[k as usize]), high.max(points[k as usize]));
    }
    let extent = high - low;
    let middle = order.len() / 2;
    across_y[middle] = extent.y > extent.x;
    let axis = usize::from(across_y[middle]);
    order.select_nth_unstable_by(middle, |&a, &b| points[a as usize][axis].total_cmp(&points[b as usize][axis]));
    let ((left, right), (left_y, right_y)) = (order.split_at_mut(middle), across_y.split_at_mut(middle));
    split(points, left, left_y);
    split(points, &mut right[1..], &mut right_y[1..]);
}

/// The nearest points met so far, in ascending order.
struct Nearest {
    found: [(f32, usize); MOST],
    len: usize,
    count: usize,
}

impl Nearest {
    fn new(count: usize) -> Self {
        Self { found: [(f32::INFINITY, 0); MOST], len: 0, count: count.clamp(1, MOST) }
    }

    /// Squared distance below which a point is still wanted.
    fn reach(&self) -> f32 {
        if self.len < self.count { f32::INFINITY } else { self.found[self.len - 1].0 }
    }

    fn offer(&mut self, squared: f32, k: usize) {
        if squared >= self.reach() {
            return;
        }
        let place = self.found[..self.len].partition_point(|near| near.0 <= squared);
        self.len = (self.len + 1).min(self.count);
        self.found.copy_within(place..self.len - 1, place + 1);
        self.found[place] = (squared, k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_looking_at_every_point_finds() {
        let noise = |x: f32| (43_758.547 * (12.9898 * x).sin()).fract();
        let spread = |k: usize| Vec2::new(noise(k as f32), noise(k as f32 + 0.5));
        // Even over a square, along a line, in two far-apart specks, on one spot.
        let line = |k: usize| Vec2::new(spread(k).x, 0.5);
        let specks = |k: usize| Vec2::splat((k % 2) as f32) + 1e-3 * spread(k);
        let spot = |_| Vec2::ONE;
        for n in [1, 2, 7, 8, 9, 200] {
            for place in [&spread as &dyn Fn(usize) -> Vec2, &line, &specks, &spot] {
                let points: Vec<Vec2> = (0..n).map(place).collect();
                let tree = Tree::new(&points);
                for (own, &at) in points.iter().enumerate() {
                    let mut others = points.clone();
                    others.remove(own);
                    let mut distances: Vec<f32> = others.iter().map(|b| at.distance_squared(*b)).collect();
                    distances.sort_by(f32::total_cmp);
                    for count in [1, 8] {
                        let mut nearest = Nearest::new(count);
                        tree.search(0..n, at, own, &mut nearest);
                        let found: Vec<f32> = nearest.found[..nearest.len].iter().map(|near| near.0).collect();
                        assert_eq!(found, distances[..count.min(n - 1)], "{n} points, {count} nearest");
                        for (squared, k) in &nearest.found[..nearest.len] {
                            assert!(*k != own && *squared == at.distance_squared(points[*k]));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn pairs_are_named_once_and_in_order() {
        assert_eq!(neighbours(&[], 8, &Progress::silent()), Ok(vec![]));
        let corners = [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(5.0, 0.0)];
        assert_eq!(neighbours(&corners, 1, &Progress::silent()), Ok(vec![(0, 1), (1, 2)]));
        let pairs = neighbours(&[Vec2::ONE; 50], 8, &Progress::silent()).unwrap();
        assert!(pairs.len() >= 50 * 8 / 2 && pairs.iter().all(|&(a, b)| a < b && b < 50));
        assert!(pairs.windows(2).all(|w| w[0] < w[1]));
    }
}
