//! Slopes along the edges of a lattice's squares, a linear function of the heights, and its adjoint.
//!
//! Light and concave edges depend on the heights through these alone.
//!
//! ```text
//!    z01 ─ top ─ z11      bottom = p(i, j),  top   = p(i, j + 1):  rise along x over hx
//!     │           │       left   = q(i, j),  right = q(i + 1, j):  rise along y over hy
//!    left       right
//!     │           │       Cut along the higher diagonal:
//!    z00 ─ bot ─ z10      ╱ where top > bottom: triangles (bottom, right), (top, left)
//!                         ╲ else:               triangles (bottom, left),  (top, right)
//! ```

use glam::DVec2;
use rayon::prelude::*;

use crate::fourier::frequency;
use crate::relief::height_grid::top_rises_more;
use crate::relief::periodic::PeriodicRelief;

/// Pieces of the grid that are worked on at the same time and summed in order: sums are the same for any number of
/// threads. More would need more copies of the histogram; the machines that this was measured on have two cores.
pub const BANDS: usize = 4;

/// A grid of heights over one cell, `n` × `n` nodes, periodic in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Nodes a side.
    pub n: usize,
    /// Distance of nodes along x and y, mm.
    pub step: DVec2,
}

impl Lattice {
    /// The grid of one cell of `relief`.
    pub fn of(relief: &PeriodicRelief) -> Self {
        Self { n: relief.nodes, step: relief.step() }
    }

    /// Size of the cell, mm.
    pub fn cell(&self) -> DVec2 {
        self.step * self.n as f64
    }

    /// Angular frequency of wave (i, j) of the heights, radians a mm.
    pub fn wave(&self, i: usize, j: usize) -> f64 {
        (frequency(i, self.n) / self.step.x).hypot(frequency(j, self.n) / self.step.y)
    }

    /// Rows of squares in one of the [`BANDS`].
    pub fn band(&self, band: usize) -> std::ops::Range<usize> {
        self.n * band / BANDS..self.n * (band + 1) / BANDS
    }
}

/// Slopes along all edges. Rows are `n + 1` long, the last column and the last row being the first again.
pub struct EdgeSlopes {
    n: usize,
    p: Vec<f32>,
    q: Vec<f32>,
}

/// The slopes of a square's edges.
#[derive(Clone, Copy, Debug)]
pub struct SquareEdges {
    /// p along the bottom.
    pub bottom: f32,
    /// p along the top.
    pub top: f32,
    /// q along the left side.
    pub left: f32,
    /// q along the right side.
    pub right: f32,
}

impl SquareEdges {
    /// Whether the square is cut from its lower left to its upper right corner.
    #[inline]
    pub fn rises(self) -> bool {
        top_rises_more(self.bottom, self.top)
    }
}

/// The edges of a row of squares, and of the row above.
pub struct EdgeRow<'a> {
    /// p along the bottoms and the tops.
    pub p: [&'a [f32]; 2],
    /// q along the sides of this row and of the next.
    pub q: [&'a [f32]; 2],
}

impl EdgeRow<'_> {
    /// Square `i` of the row.
    #[inline]
    pub fn square(&self, i: usize) -> SquareEdges {
        SquareEdges { bottom: self.p[0][i], top: self.p[1][i], left: self.q[0][i], right: self.q[0][i + 1] }
    }
}

/// Gradients with respect to the edges of a row of squares and of the row above, to be added to.
pub struct EdgeRowSums<'a> {
    /// Of bottoms and tops.
    pub p: [&'a mut [f32]; 2],
    /// Of the sides of this row and of the next.
    pub q: [&'a mut [f32]; 2],
}

impl EdgeSlopes {
    /// The edges of heights `z`, mm, rows of constant y.
    pub fn new(lattice: Lattice, z: &[f32]) -> Self {
        let n = lattice.n;
        let [px, py] = (1.0 / lattice.step).to_array().map(|v| v as f32);
        let (mut p, mut q) = (vec![0.0; (n + 1) * (n + 1)], vec![0.0; (n + 1) * (n + 1)]);
        let rows = p.par_chunks_mut(n + 1).zip(q.par_chunks_mut(n + 1)).enumerate().with_min_len(32);
        rows.for_each(|(j, (p, q))| {
            let (here, above) = (&z[j % n * n..][..n], &z[(j + 1) % n * n..][..n]);
            for i in 0..n - 1 {
                p[i] = px * (here[i + 1] - here[i]);
            }
            p[n - 1] = px * (here[0] - here[n - 1]);
            for i in 0..n {
                q[i] = py * (above[i] - here[i]);
            }
            (p[n], q[n]) = (p[0], q[0]);
        });
        Self { n, p, q }
    }

    /// Row `j` of squares.
    #[inline]
    pub fn row(&self, j: usize) -> EdgeRow<'_> {
        let width = self.n + 1;
        EdgeRow {
            p: [&self.p[j * width..][..width], &self.p[(j + 1) * width..][..width]],
            q: [&self.q[j * width..][..width], &self.q[(j + 1) * width..][..width]],
        }
    }

    /// The gradient with respect to the heights, per mm, of a function of the edges; and the sum of what `visit` returns.
    ///
    /// `visit` is given each row of squares and its number, and adds the gradient with respect to its edges.
    pub fn adjoint(
        &self,
        lattice: Lattice,
        visit: impl Fn(usize, EdgeRow<'_>, &mut EdgeRowSums<'_>) -> f64 + Sync,
    ) -> (Vec<f32>, f64) {
        let (n, width) = (self.n, self.n + 1);
        let band = |band: usize| {
            let rows = lattice.band(band);
            let room = (rows.len() + 1) * width;
            let (mut p, mut q, mut sum) = (vec![0.0; room], vec![0.0; room], 0.0);
            for j in rows.clone() {
                let at = (j - rows.start) * width;
                let (p0, p1) = p[at..].split_at_mut(width);
                let (q0, q1) = q[at..].split_at_mut(width);
                let mut sums = EdgeRowSums { p: [p0, &mut p1[..width]], q: [q0, &mut q1[..width]] };
                sum += visit(j, self.row(j), &mut sums);
            }
            (p, q, sum)
        };
        let bands: Vec<_> = (0..BANDS).into_par_iter().map(band).collect();
        let (mut p, mut q) = (vec![0.0f32; width * width], vec![0.0f32; width * width]);
        for (k, band) in bands.iter().enumerate() {
            let at = lattice.band(k).start * width;
            p[at..].iter_mut().zip(&band.0).for_each(|(sum, v)| *sum += v);
            q[at..].iter_mut().zip(&band.1).for_each(|(sum, v)| *sum += v);
        }
        // The last column and row are the first ones.
        for edges in [&mut p, &mut q] {
            for j in 0..width {
                edges[j * width] += edges[j * width + n];
            }
            let (first, last) = edges.split_at_mut(n * width);
            first.iter_mut().zip(last).for_each(|(sum, v)| *sum += *v);
        }
        let [px, py] = (1.0 / lattice.step).to_array().map(|v| v as f32);
        let mut heights = vec![0.0; n * n];
        heights.par_chunks_mut(n).enumerate().with_min_len(32).for_each(|(j, row)| {
            let (p, q, below) = (&p[j * width..], &q[j * width..], &q[(j + n - 1) % n * width..]);
            for (i, z) in row.iter_mut().enumerate() {
                let left = if i == 0 { n - 1 } else { i - 1 };
                *z = px * (p[left] - p[i]) + py * (below[i] - q[i]);
            }
        });
        (heights, bands.iter().map(|band| band.2).sum())
    }
}

/// The light of all bands, each as `splat` gives it in `bins` bins, added in their order whatever the threads.
pub(crate) fn added_bands(bins: usize, splat: impl Fn(usize) -> Vec<f32> + Sync + Send) -> Vec<f32> {
    let bands: Vec<Vec<f32>> = (0..BANDS).into_par_iter().map(splat).collect();
    added(bins, &bands)
}

/// The sums, number by number, of all `bands` of so many numbers, added in their order whatever the threads.
pub(crate) fn added<B: AsRef<[f32]> + Sync>(count: usize, bands: &[B]) -> Vec<f32> {
    /// Numbers that a thread adds at a time.
    const PIECE: usize = 1 << 13;
    let mut sums = vec![0.0f32; count];
    sums.par_chunks_mut(PIECE).enumerate().for_each(|(k, piece)| {
        for band in bands {
            piece.iter_mut().zip(&band.as_ref()[k * PIECE..]).for_each(|(sum, v)| *sum += v);
        }
    });
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_has_its_slopes_on_every_edge_but_where_the_cell_begins_again() {
        let lattice = Lattice { n: 8, step: DVec2::new(0.5, 0.25) };
        let z: Vec<f32> = (0..64).map(|k| 0.3 * 0.5 * (k % 8) as f32 - 0.2 * 0.25 * (k / 8) as f32).collect();
        let edges = EdgeSlopes::new(lattice, &z);
        let square = edges.row(3).square(4);
        for (slope, expected) in [(square.bottom, 0.3), (square.top, 0.3), (square.left, -0.2), (square.right, -0.2)] {
            assert!((slope - expected).abs() < 1e-6);
        }
        assert!((edges.row(0).square(7).bottom + 7.0 * 0.3).abs() < 1e-5);
    }

    #[test]
    fn the_adjoint_is_the_transpose_of_the_slopes_to_rounding() {
        for n in [2, 5, 12, 64] {
            let lattice = Lattice { n, step: DVec2::new(0.05, 0.04) };
            let z: Vec<f32> = (0..n * n).map(|k| (k as f32 * 1.7).sin()).collect();
            let edges = EdgeSlopes::new(lattice, &z);
            // A number for each way in which a square is asked: its bottom, top, left and right edge.
            let weight = |j: usize, i: usize, side: usize| ((j * n + i) as f32 * 0.37 + side as f32).cos();
            let mut forward = 0.0;
            for (j, i) in (0..n * n).map(|k| (k / n, k % n)) {
                let SquareEdges { bottom, top, left, right } = edges.row(j).square(i);
                for (side, slope) in [bottom, top, left, right].into_iter().enumerate() {
                    forward += f64::from(slope) * f64::from(weight(j, i, side));
                }
            }
            let (back, visited) = edges.adjoint(lattice, |j, _, sums| {
                for i in 0..n {
                    sums.p[0][i] += weight(j, i, 0);
                    sums.p[1][i] += weight(j, i, 1);
                    sums.q[0][i] += weight(j, i, 2);
                    sums.q[0][i + 1] += weight(j, i, 3);
                }
                1.0
            });
            let products: Vec<f64> = back.iter().zip(&z).map(|(a, b)| f64::from(*a) * f64::from(*b)).collect();
            let size: f64 = products.iter().map(|v| v.abs()).sum();
            assert_eq!(visited, n as f64);
            assert!((forward - products.iter().sum::<f64>()).abs() < 1e-5 * size, "{n}");
        }
    }
}
