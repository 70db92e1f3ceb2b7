//! A first relief whose slopes are nearly the wanted ones, by Douglas-Rachford iterations between two sets: fields of
//! slopes that have the wanted distribution, whatever their places, and slopes of reliefs that the cutter can mill.
//!
//! The step to the first set is sliced matching (Pitié, Kokaram, Dahyot 2007): along one direction, every slope moves
//! toward the wanted one of the same rank. The step to the second is the relief whose slopes are the nearest in the least
//! squares, and its closing. Unlike a descent, this moves light between parts of the picture with nothing in between.

use std::f64::consts::PI;

use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use crate::fourier::frequency;
use crate::progress::Progress;

use super::closing::Closing;
use super::edge_slopes::Lattice;
use super::periodic_filter::PeriodicFilter;

/// Pairs of perpendicular directions in one sliced matching; the trial programs of the method used 3 as well.
const PAIRS: usize = 3;

/// Share of the way to the slope of the same rank that slopes go at a time. All of it would undo what the direction before
/// had brought; the trials were run with 0.7, and other values were not compared since.
const STEP: f64 = 0.7;

/// Bins in which slopes are ranked along a direction: some 0.01° each in a picture 40° wide.
const RANK_BINS: usize = 4096;

/// The iterations on one lattice.
pub(crate) struct Matching {
    lattice: Lattice,
    filter: PeriodicFilter,
    /// Gains of the inverse of ∇ᵀ∇.
    poisson: Vec<f32>,
    wanted: Vec<[f32; 2]>,
}

impl Matching {
    /// For `wanted` slopes relative to the mean, one a square of `lattice`, in any order.
    pub fn new(lattice: Lattice, wanted: &[DVec2]) -> Self {
        let n = lattice.n;
        let filter = PeriodicFilter::new(n);
        let poisson = filter.gains(|i, j| {
            let half = |k: usize| 0.5 * frequency(k, n);
            let (x, y) = (half(i).sin() * half(j).cos(), half(j).sin() * half(i).cos());
            let squares = 4.0 * ((x / lattice.step.x).powi(2) + (y / lattice.step.y).powi(2));
            // Waves whose squares all have a mean slope of 0 cannot be told from slopes.
            if squares * lattice.step.length_squared() > 1e-9 { 1.0 / squares } else { 0.0 }
        });
        Self { lattice, filter, poisson, wanted: wanted.iter().map(|s| [s.x as f32, s.y as f32]).collect() }
    }

    /// `rounds` iterations from heights `z`, mm.
    pub fn run(&self, z: &mut Vec<f32>, closing: Option<&Closing>, rounds: usize, seed: u64, progress: &Progress) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut slopes = self.slopes(z);
        let mut state = slopes.clone();
        for _ in 0..rounds {
            if progress.is_to_finish() {
                break;
            }
            // x ← x + match(2s - x) - s, s = the slopes of the relief nearest to x.
            let mut matched: Vec<[f32; 2]> = blend(&slopes, &state, |s, x| 2.0 * s - x);
            for _ in 0..PAIRS {
                let angle = PI * rng.random::<f64>();
                self.match_along(&mut matched, angle);
                self.match_along(&mut matched, angle + 0.5 * PI);
            }
            state = blend(&blend(&state, &matched, |x, m| x + m), &slopes, |x, s| x - s);
            *z = self.nearest_relief(&state);
            if let Some(closing) = closing {
                closing.close(z);
            }
            slopes = self.slopes(z);
        }
    }

    /// Moves slopes along one direction toward the wanted ones of the same rank.
    fn match_along(&self, slopes: &mut [[f32; 2]], angle: f64) {
        let (c, s) = (angle.cos() as f32, angle.sin() as f32);
        let along = |v: &[f32; 2]| c * v[0] + s * v[1];
        let range = |of: &[[f32; 2]]| {
            of.iter().map(along).fold((f32::INFINITY, f32::NEG_INFINITY), |r, v| (r.0.min(v), r.1.max(v)))
        };
        let (ours, theirs) = (range(slopes), range(&self.wanted));
        let (low, high) = (ours.0.min(theirs.0), ours.1.max(theirs.1));
        let per_slope = RANK_BINS as f32 / (high - low);
        if !per_slope.is_finite() {
            return;
        }
        let place = |v: &[f32; 2]| (per_slope * (along(v) - low)).clamp(0.0, RANK_BINS as f32 - 0.001);
        // The share of all slopes below each bin's lower end.
        let ranks = |of: &[[f32; 2]]| {
            let mut ranks = vec![0.0f64; RANK_BINS + 1];
            of.iter().for_each(|v| ranks[place(v) as usize + 1] += 1.0 / of.len() as f64);
            (1..=RANK_BINS).for_each(|k| ranks[k] += ranks[k - 1]);
            ranks
        };
        let (ours, theirs) = (ranks(slopes), ranks(&self.wanted));
        // Where the wanted slopes have the rank that ours have at each bin's lower end, in bins.
        let mut bin = 0;
        let wanted: Vec<f32> = ours
            .iter()
            .map(|rank| {
                while bin + 1 < RANK_BINS && theirs[bin + 1] < *rank {
                    bin += 1;
                }
                let width = theirs[bin + 1] - theirs[bin];
                let within = if width > 0.0 { ((rank - theirs[bin]) / width).clamp(0.0, 1.0) } else { 0.0 };
                (bin as f64 + within) as f32
            })
            .collect();
        let step = STEP as f32 / per_slope;
        slopes.par_iter_mut().with_min_len(1 << 13).for_each(|slope| {
            let at = place(slope);
            let (k, t) = (at as usize, at.fract());
            let way = step * (wanted[k] + t * (wanted[k + 1] - wanted[k]) - at);
            *slope = [slope[0] + way * c, slope[1] + way * s];
        });
    }

    /// Mean slope of each square.
    fn slopes(&self, z: &[f32]) -> Vec<[f32; 2]> {
        let n = self.lattice.n;
        let [x, y] = (0.5 / self.lattice.step).to_array().map(|v| v as f32);
        (0..n * n)
            .map(|k| {
                let (right, top) = ((k % n + 1) % n, (k / n + 1) % n * n);
                let (z00, z10, z01, z11) = (z[k], z[k / n * n + right], z[top + k % n], z[top + right]);
                [x * (z10 - z00 + z11 - z01), y * (z01 - z00 + z11 - z10)]
            })
            .collect()
    }

    /// Heights whose squares have these mean slopes as nearly as can be: ∇ᵀ∇ z = ∇ᵀ s.
    fn nearest_relief(&self, slopes: &[[f32; 2]]) -> Vec<f32> {
        let n = self.lattice.n;
        let [x, y] = (0.5 / self.lattice.step).to_array().map(|v| v as f32);
        let mut z: Vec<f32> = (0..n * n)
            .map(|k| {
                let (i, j) = (k % n, k / n);
                let (left, below) = ((i + n - 1) % n, (j + n - 1) % n * n);
                let [a, b, c, d] = [below + left, below + i, j * n + left, k].map(|at| slopes[at]);
                x * (a[0] + c[0] - b[0] - d[0]) + y * (a[1] + b[1] - c[1] - d[1])
            })
            .collect();
        self.filter.filter(&mut z, n, &self.poisson);
        z
    }
}

fn blend(a: &[[f32; 2]], b: &[[f32; 2]], f: impl Fn(f32, f32) -> f32) -> Vec<[f32; 2]> {
    a.iter().zip(b).map(|(a, b)| [f(a[0], b[0]), f(a[1], b[1])]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_come_back_from_their_slopes() {
        let lattice = Lattice { n: 24, step: DVec2::new(0.5, 0.3) };
        let matching = Matching::new(lattice, &[DVec2::ZERO; 576]);
        // Without the waves that leave all squares level: the mean and the fastest.
        let wave = |k: usize, m: f32| (std::f32::consts::TAU * m * k as f32 / 24.0).sin();
        let z: Vec<f32> = (0..576).map(|k| wave(k % 24, 2.0) * wave(k / 24, 3.0) + wave(k / 24, 1.0)).collect();
        let back = matching.nearest_relief(&matching.slopes(&z));
        assert!(z.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-4));
    }

    #[test]
    fn slopes_come_near_those_that_a_relief_has() {
        // Wanted are the slopes of a known relief; the start is another.
        let n = 32;
        let lattice = Lattice { n, step: DVec2::splat(0.1) };
        let tau = std::f32::consts::TAU;
        let bumps: Vec<f32> = (0..n * n)
            .map(|k| 0.05 * ((tau * (k % n) as f32 / n as f32).cos() + (tau * (k / n) as f32 / n as f32).cos()))
            .collect();
        let plain = Matching::new(lattice, &vec![DVec2::ZERO; n * n]);
        let wanted: Vec<DVec2> =
            plain.slopes(&bumps).iter().map(|s| DVec2::new(f64::from(s[0]), f64::from(s[1]))).collect();
        let matching = Matching::new(lattice, &wanted);
        let mut z: Vec<f32> = (0..n * n).map(|k| 0.02 * ((k * 7 % 13) as f32 - 6.0) / 13.0).collect();
        let spread = |slopes: &[[f32; 2]], power: i32| {
            slopes.iter().map(|s| f64::from(s[0].hypot(s[1]).powi(power))).sum::<f64>() / (n * n) as f64
        };
        matching.run(&mut z, None, 40, 1, &Progress::silent());
        let (got, asked) = (matching.slopes(&z), &matching.wanted);
        for power in [2, 4] {
            assert!((spread(&got, power) / spread(asked, power) - 1.0).abs() < 0.1, "{power}");
        }
    }
}
