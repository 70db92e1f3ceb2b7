//! How high each facet stands so that the walls between neighbours come out low: Poisson's equation on the grid.

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use rustfft::num_complex::Complex64;

use crate::facets::SlopeGrid;
use crate::fourier::{CosineTransform, WaveTransform};

/// Heights (mm, at the middles of the cells, in the grid's order, mean zero) whose walls are lowest in the least
/// squares: they minimise the integral of the squared step over all shared edges, those across the rim included if
/// `periodic`. `pitch` is the size of a cell, mm.
///
/// Between x-neighbours a and b, of height c and slope (p, q), the step along their edge, t from its middle, is
///
/// ```text
/// h(t) = [c_b - c_a - pitch.x (p_a + p_b)/2] + (q_b - q_a) t,    |t| <= pitch.y/2,
/// ∫ h² dt = pitch.y [c_b - c_a - pitch.x (p_a + p_b)/2]² + (q_b - q_a)² pitch.y³/12
/// ```
///
/// and likewise in y with the roles exchanged. The last term does not depend on heights, so x-edges weigh pitch.y,
/// y-edges pitch.x, and the minimum solves the weighted Poisson problem of the grid's graph
///
/// ```text
/// Σ_edges at k  w (c_k - c_n) = Σ_edges at k  ± w d,    d = pitch (s_a + s_b)/2 along the edge
/// ```
///
/// which cosines diagonalise on a free grid and waves on a cyclic one. Both are solved exactly, by fast transforms of
/// any length. On a cyclic grid the mean slope has no heights: what it climbs on the way is left as equal steps.
pub fn least_squares(grid: &SlopeGrid, pitch: DVec2, periodic: bool) -> Vec<f64> {
    LeastSquares::new(grid.columns, grid.rows, pitch, periodic).heights(grid)
}

/// [`least_squares`] for many grids of one size.
pub struct LeastSquares {
    pitch: DVec2,
    periodic: bool,
    poisson: Poisson,
}

impl LeastSquares {
    /// For grids of `columns` × `rows` cells of `pitch` mm.
    pub fn new(columns: usize, rows: usize, pitch: DVec2, periodic: bool) -> Self {
        Self { pitch, periodic, poisson: Poisson::new(columns, rows, DVec2::new(pitch.y, pitch.x), periodic) }
    }

    /// Heights of the facets of `grid`, which must have the size announced.
    pub fn heights(&self, grid: &SlopeGrid) -> Vec<f64> {
        let cell = self.pitch.x * self.pitch.y;
        let mut field = vec![0.0; grid.cells()];
        let mut add = |a: usize, b: usize, climb: f64| {
            field[b] += 0.5 * cell * climb;
            field[a] -= 0.5 * cell * climb;
        };
        for (a, b) in grid.x_pairs(self.periodic) {
            add(a, b, grid.slopes[a].p + grid.slopes[b].p);
        }
        for (a, b) in grid.y_pairs(self.periodic) {
            add(a, b, grid.slopes[a].q + grid.slopes[b].q);
        }
        self.poisson.solve(field)
    }
}

/// Heights (mm, at the middles of the cells, in the grid's order, mean zero) as printed by Weyrich et al. 2009:
/// ∇²z = div g on a cyclic grid with g_x(x) = ¼p(x-1) + ½p(x) + ¼p(x+1), and likewise g_y from q along y.
///
/// The paper leaves the differences open. These are the usual ones: the 5-point Laplacian and central differences
/// (g_x(x+1) - g_x(x-1))/2. On square cells [`least_squares`] is the same equation without the smoothing, p in place
/// of g, and so the one whose walls are lower.
pub fn weyrich2009(grid: &SlopeGrid, pitch: DVec2) -> Vec<f64> {
    let mut field = vec![0.0; grid.cells()];
    let (columns, rows) = (grid.columns, grid.rows);
    // ½(g(+1) - g(-1)) with the smoothing written out: ⅛s(+2) + ¼s(+1) - ¼s(-1) - ⅛s(-2).
    const TAPS: [(usize, f64); 2] = [(2, 0.125), (1, 0.25)];
    for (k, value) in field.iter_mut().enumerate() {
        let (i, j) = (k % columns, k / columns);
        for (reach, tap) in TAPS {
            // The offset is taken modulo the size first: a cyclic grid may be narrower than the stencil.
            let (x, y) = (reach % columns, reach % rows);
            let dp = grid.at((i + x) % columns, j).p - grid.at((i + columns - x) % columns, j).p;
            let dq = grid.at(i, (j + y) % rows).q - grid.at(i, (j + rows - y) % rows).q;
            *value -= tap * (dp / pitch.x + dq / pitch.y);
        }
    }
    Poisson::new(columns, rows, DVec2::new(pitch.x.powi(-2), pitch.y.powi(-2)), true).solve(field)
}

/// Σ_n w (c_k - c_n) = field_k on a grid, with `weight.x` on x-edges and `weight.y` on y-edges, ready to be solved.
struct Poisson {
    weight: DVec2,
    transform: Transform,
    /// What the second difference does to each wave along x and y.
    eigenvalues: [Vec<f64>; 2],
}

/// What diagonalises the second difference.
enum Transform {
    Cyclic(WaveTransform),
    Free(CosineTransform),
}

impl Poisson {
    /// On a cyclic grid waves diagonalise the second difference, on a free one cosines.
    fn new(columns: usize, rows: usize, weight: DVec2, periodic: bool) -> Self {
        let (transform, turn) = match periodic {
            true => (Transform::Cyclic(WaveTransform::new(columns, rows)), TAU),
            false => (Transform::Free(CosineTransform::new(columns, rows)), PI),
        };
        // 4 sin² of half the phase from cell to cell, exactly 0 for the mean.
        let eigenvalue = |k: usize, n: usize| 4.0 * (0.5 * turn * k as f64 / n as f64).sin().powi(2);
        let eigenvalues = [columns, rows].map(|n| (0..n).map(|k| eigenvalue(k, n)).collect());
        Self { weight, transform, eigenvalues }
    }

    /// The mean-zero solution c for one field, in the grid's order.
    fn solve(&self, mut field: Vec<f64>) -> Vec<f64> {
        let Self { weight, transform, eigenvalues: [x, y] } = self;
        let gain = |i: usize, j: usize| {
            let eigenvalue = weight.x * x[i] + weight.y * y[j];
            if eigenvalue > 0.0 { 1.0 / eigenvalue } else { 0.0 }
        };
        match transform {
            Transform::Cyclic(waves) => waves.filter(&mut field, |i, j| Complex64::from(gain(i, j))),
            Transform::Free(cosines) => cosines.filter(&mut field, gain),
        }
        field
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::facets::steps::steps;
    use crate::slope::Slope;

    const PITCH: DVec2 = DVec2::new(0.7, 1.9);

    /// Slopes that are the gradient of nothing.
    fn rough(columns: usize, rows: usize) -> SlopeGrid {
        let noise = |k: usize| ((k * k * 31 + k * 17) % 101) as f64 / 101.0 - 0.4;
        SlopeGrid::from_fn(columns, rows, |i, j| Slope::new(noise(j * columns + i), noise(i * rows + j + 7)))
    }

    fn assert_close(a: &[f64], b: &[f64], what: &str) {
        assert_eq!(a.len(), b.len());
        for (k, (a, b)) in a.iter().zip(b).enumerate() {
            assert!((a - b).abs() < 1e-10, "{what}: cell {k}, {a} instead of {b}");
        }
    }

    fn centred(mut values: Vec<f64>) -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter_mut().for_each(|v| *v -= mean);
        values
    }

    /// The heights c of mean zero that minimise Σ w (c_b - c_a - d)² over the edges (a, b, w, d), by the pseudo-inverse
    /// of the whole matrix of edges.
    fn dense(n: usize, edges: &[(usize, usize, f64, f64)]) -> Vec<f64> {
        let mut climbs = DMatrix::zeros(edges.len() + 1, n);
        let mut wanted = DVector::zeros(edges.len() + 1);
        for (row, &(a, b, w, d)) in edges.iter().enumerate() {
            climbs[(row, a)] -= w.sqrt();
            climbs[(row, b)] += w.sqrt();
            wanted[row] = w.sqrt() * d;
        }
        // The last row asks for a sum of zero.
        climbs.row_mut(edges.len()).fill(1.0);
        climbs.svd(true, true).solve(&wanted, 1e-12).unwrap().iter().copied().collect()
    }

    #[test]
    fn planted_planes_and_paraboloids_come_back_exactly() {
        let surface = |x: f64, y: f64| 0.3 * x - 0.1 * y + 0.05 * x * x - 0.02 * y * y + 0.04 * x * y;
        for (columns, rows) in [(7, 5), (1, 6), (9, 1), (1, 1), (16, 13), (30, 30)] {
            let middle = |i: usize, j: usize| (PITCH.x * (i as f64 + 0.5), PITCH.y * (j as f64 + 0.5));
            let grid = SlopeGrid::from_fn(columns, rows, |i, j| {
                let (x, y) = middle(i, j);
                Slope::new(0.3 + 0.1 * x + 0.04 * y, -0.1 - 0.04 * y + 0.04 * x)
            });
            let planted = (0..columns * rows).map(|k| middle(k % columns, k / columns)).map(|(x, y)| surface(x, y));
            assert_close(&least_squares(&grid, PITCH, false), &centred(planted.collect()), "planted");
        }
    }

    #[test]
    fn slopes_without_a_surface_get_the_heights_of_a_dense_least_squares_solver() {
        for (columns, rows) in [(5, 7), (4, 6), (1, 8), (11, 1), (2, 2), (3, 2), (2, 5), (1, 1)] {
            for periodic in [false, true] {
                let grid = rough(columns, rows);
                let s = &grid.slopes;
                let x = grid.x_pairs(periodic).map(|(a, b)| (a, b, PITCH.y, PITCH.x * 0.5 * (s[a].p + s[b].p)));
                let y = grid.y_pairs(periodic).map(|(a, b)| (a, b, PITCH.x, PITCH.y * 0.5 * (s[a].q + s[b].q)));
                let wanted = dense(grid.cells(), &x.chain(y).collect::<Vec<_>>());
                let what = format!("{columns} x {rows}, periodic {periodic}");
                assert_close(&least_squares(&grid, PITCH, periodic), &wanted, &what);
            }
        }
    }

    #[test]
    fn no_other_heights_have_lower_walls() {
        for periodic in [false, true] {
            let grid = rough(6, 5);
            let heights = least_squares(&grid, PITCH, periodic);
            let best = steps(&grid, &heights, PITCH, periodic).rms;
            for k in 0..30 {
                for push in [-0.01, 0.01] {
                    let mut other = heights.clone();
                    other[k] += push;
                    assert!(steps(&grid, &other, PITCH, periodic).rms > best);
                }
            }
            if periodic {
                assert!(steps(&grid, &weyrich2009(&grid, PITCH), PITCH, true).rms > best);
            }
        }
    }

    #[test]
    fn a_cyclic_plate_loses_its_mean_slope() {
        let (grid, tilt) = (rough(5, 4), Slope::new(0.3, -0.2));
        let tilted = SlopeGrid::from_fn(5, 4, |i, j| Slope::from_vec(grid.at(i, j).to_vec() + tilt.to_vec()));
        assert_close(&least_squares(&tilted, PITCH, true), &least_squares(&grid, PITCH, true), "least squares");
        assert_close(&weyrich2009(&tilted, PITCH), &weyrich2009(&grid, PITCH), "Weyrich");
    }

    #[test]
    fn the_printed_equation_holds_in_every_cell() {
        for (columns, rows) in [(6, 5), (7, 3), (2, 4), (1, 5), (5, 1)] {
            let grid = rough(columns, rows);
            let z = weyrich2009(&grid, PITCH);
            let wrap = |k: usize, by: isize, n: usize| (k as isize + by).rem_euclid(n as isize) as usize;
            let height = |i, j| z[j * columns + i];
            let gx = |i: usize, j: usize| {
                let p = |by| grid.at(wrap(i, by, columns), j).p;
                0.25 * p(-1) + 0.5 * p(0) + 0.25 * p(1)
            };
            let gy = |i: usize, j: usize| {
                let q = |by| grid.at(i, wrap(j, by, rows)).q;
                0.25 * q(-1) + 0.5 * q(0) + 0.25 * q(1)
            };
            for j in 0..rows {
                for i in 0..columns {
                    let [l, r] = [-1, 1].map(|by| wrap(i, by, columns));
                    let [d, u] = [-1, 1].map(|by| wrap(j, by, rows));
                    let here = 2.0 * height(i, j);
                    let laplacian = (height(l, j) + height(r, j) - here) / PITCH.x.powi(2)
                        + (height(i, d) + height(i, u) - here) / PITCH.y.powi(2);
                    let divergence = (gx(r, j) - gx(l, j)) / (2.0 * PITCH.x) + (gy(i, u) - gy(i, d)) / (2.0 * PITCH.y);
                    assert!((laplacian - divergence).abs() < 1e-10, "{columns} x {rows}, cell ({i}, {j})");
                }
            }
            assert!(z.iter().sum::<f64>().abs() < 1e-10);
        }
    }

    #[test]
    fn large_and_prime_sizes_keep_a_planted_bowl() {
        // Large enough for threads.
        for (columns, rows) in [(257, 101), (128, 130)] {
            let grid = SlopeGrid::from_fn(columns, rows, |i, j| Slope::new(0.01 * i as f64, -0.02 * j as f64));
            let bowl = |k: usize| 0.005 * ((k % columns) as f64).powi(2) - 0.01 * ((k / columns) as f64).powi(2);
            let planted = centred((0..columns * rows).map(bowl).collect());
            let found = least_squares(&grid, DVec2::ONE, false);
            assert!(found.iter().zip(&planted).all(|(a, b)| (a - b).abs() < 1e-8));
        }
    }

    #[test]
    fn no_cells_have_no_heights() {
        let none = SlopeGrid { columns: 0, rows: 3, slopes: vec![] };
        assert!(least_squares(&none, PITCH, true).is_empty() && weyrich2009(&none, PITCH).is_empty());
    }
}
