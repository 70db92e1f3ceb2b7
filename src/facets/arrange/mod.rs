//! Which slope goes where on the plate.

pub mod assignment;

mod exchange;

mod split;

mod unwind;

pub mod transport;

mod annealing_grid;

pub mod anneal;

pub mod per_cell;

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::facets::SlopeGrid;

/// Shuffles the slopes over the grid, every order alike (Fisher-Yates).
pub fn random_order(grid: &mut SlopeGrid, seed: u64) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    for k in (1..grid.slopes.len()).rev() {
        grid.slopes.swap(k, below(random.next_u64(), k + 1));
    }
}

/// The integer below `n` that the 64 random `bits` stand for; uneven by less than n in 2^64.
fn below(bits: u64, n: usize) -> usize {
    ((u128::from(bits) * n as u128) >> 64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slope::Slope;

    #[test]
    fn every_order_of_four_slopes_comes_equally_often() {
        let trials = 24_000;
        let mut counts = std::collections::HashMap::new();
        for seed in 0..trials {
            let mut grid = SlopeGrid::from_fn(2, 2, |i, j| Slope::new((2 * j + i) as f64, 0.0));
            random_order(&mut grid, seed);
            *counts.entry(grid.slopes.iter().fold(0, |code, s| 4 * code + s.p as u32)).or_insert(0u32) += 1;
        }
        assert_eq!(counts.len(), 24);
        // χ² with 23 degrees of freedom exceeds 50 in one of a thousand cases; the seeds are fixed.
        let chi2: f64 = counts.values().map(|&c| (f64::from(c) - 1000.0).powi(2) / 1000.0).sum();
        assert!(chi2 < 50.0, "{chi2}");
    }

    #[test]
    fn bits_cover_all_integers_below() {
        assert_eq!((below(0, 7), below(u64::MAX, 7), below(1 << 63, 7)), (0, 6, 3));
    }
}
