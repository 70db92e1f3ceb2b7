//! The triangles of a periodic relief, sampled on another grid.

use rayon::prelude::*;

use crate::relief::height_grid::rises;
use crate::relief::periodic::PeriodicRelief;

use super::places::Places;

/// Heights of a cell's triangles about the mean plane at `n` × `n` places, rows of constant y.
pub fn sampled(relief: &PeriodicRelief, n: usize) -> Vec<f32> {
    sampled_at(relief, n, &Places::all([n, n]))
}

/// The same at some of them alone; elsewhere 0.
pub(super) fn sampled_at(relief: &PeriodicRelief, n: usize, places: &Places) -> Vec<f32> {
    let nodes = relief.nodes;
    // Square and place in it, 0 to 1, along either side.
    let at: Vec<(usize, f32)> = (0..n).map(|k| (k * nodes / n, (k * nodes % n) as f32 / n as f32)).collect();
    let mut samples = vec![0.0f32; n * n];
    samples.par_chunks_mut(n).zip(&places.rows).zip(&at).with_min_len(16).for_each(|((row, ranges), &(j, b))| {
        let row_of = |j: usize| &relief.heights[j % nodes * nodes..][..nodes];
        let (lower, upper) = (row_of(j), row_of(j + 1));
        for range in ranges {
            for (z, &(i, a)) in row[range.clone()].iter_mut().zip(&at[range.clone()]) {
                let next = if i + 1 == nodes { 0 } else { i + 1 };
                let [z00, z10, z01, z11] = [lower[i], lower[next], upper[i], upper[next]];
                *z = match rises([z00, z10, z01, z11].map(f64::from)) {
                    true if b <= a => z00 + a * (z10 - z00) + b * (z11 - z10),
                    true => z00 + a * (z11 - z01) + b * (z01 - z00),
                    false if a + b <= 1.0 => z00 + a * (z10 - z00) + b * (z01 - z00),
                    false => z11 + (1.0 - a) * (z01 - z11) + (1.0 - b) * (z10 - z11),
                };
            }
        }
    });
    samples
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::slope::Slope;

    #[test]
    fn a_doubled_grid_has_the_same_triangles() {
        let heights: Vec<f32> = (0..64).map(|k| (k * k * 7 % 31) as f32 * 0.1).collect();
        let relief =
            PeriodicRelief { nodes: 8, heights: heights.clone(), cell: DVec2::ONE, cells: [1, 1], tilt: Slope::FLAT };
        let finer = sampled(&relief, 16);
        for (k, z) in heights.iter().enumerate() {
            let (i, j) = (k % 8, k / 8);
            assert_eq!(finer[2 * j * 16 + 2 * i], *z);
            let right = heights[j * 8 + (i + 1) % 8];
            assert!((finer[2 * j * 16 + 2 * i + 1] - 0.5 * (z + right)).abs() < 1e-6);
            let above = [heights[(j + 1) % 8 * 8 + i], heights[(j + 1) % 8 * 8 + (i + 1) % 8]];
            // The middle lies on the higher diagonal.
            let middle = 0.5 * (z + above[1]).max(right + above[0]);
            assert!((finer[(2 * j + 1) * 16 + 2 * i + 1] - middle).abs() < 1e-6);
        }
        assert_eq!(sampled(&relief, 8), heights);
    }
}
