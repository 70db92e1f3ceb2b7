//! The colour grid of `.bsdf` files: not the table at the grid's nodes but the grid that comes nearest to the table.
//!
//! Measured tables are noisy. After the warp every part of the unit square holds as much light as any other, so that a
//! mean over the square weighs cells by the rays they counted: the least scatter the counts allow. The nodes are those
//! whose bilinear surface is the least-squares fit; unlike means around the nodes they are exact for bilinear data.

use nalgebra::{Cholesky, DMatrix, Dyn};

/// Points each way over the whole square, at least: about as fine as the tables themselves.
const POINTS: usize = 128;

/// Least-squares fit of a bilinear surface over the unit square.
///
/// A hat function of the square is the product of one along s1 and one along s2, so that the normal equations of the
/// nodes X are G X G = S, with the Gram matrix G of the hat functions along one side and the sums S of what the points
/// say of each node.
pub(super) struct GridFit {
    /// Nodes a side.
    side: usize,
    /// Points between two nodes.
    points: usize,
    /// G, ready to be solved.
    gram: Cholesky<f64, Dyn>,
}

impl GridFit {
    /// For `side` × `side` nodes; `None` for fewer than 2 a side.
    pub(super) fn new(side: usize) -> Option<Self> {
        let points = POINTS.div_ceil(side.checked_sub(1).filter(|&gaps| gaps > 0)?).max(2);
        // The points' own sums, not integrals: so bilinear data comes back exactly.
        let (mut own, mut shared) = (0.0, 0.0);
        for k in 0..points {
            let t = (k as f64 + 0.5) / points as f64;
            own += t * t;
            shared += t * (1.0 - t);
        }
        let gram = DMatrix::from_fn(side, side, |i, j| match i.abs_diff(j) {
            0 if i == 0 || i == side - 1 => own,
            0 => 2.0 * own,
            1 => shared,
            _ => 0.0,
        });
        Some(Self { side, points, gram: gram.cholesky()? })
    }

    /// Points a side.
    fn across(&self) -> usize {
        self.points * (self.side - 1)
    }

    /// `place(s1, s2)` at the points of the fit, s1 fastest.
    pub(super) fn places<T>(&self, place: impl Fn(f64, f64) -> T) -> Vec<T> {
        let n = self.across();
        let at = |k: usize| (k as f64 + 0.5) / n as f64;
        (0..n * n).map(|k| place(at(k % n), at(k / n))).collect()
    }

    /// The nodes for `values` at those points.
    pub(super) fn nodes(&self, values: impl IntoIterator<Item = f64>) -> Vec<f32> {
        let (n, side) = (self.across(), self.side);
        let mut sums = vec![0.0; side * side];
        let split = |k: usize| (k / self.points, ((k % self.points) as f64 + 0.5) / self.points as f64);
        for (k, value) in values.into_iter().enumerate() {
            let ((x, s), (y, t)) = (split(k % n), split(k / n));
            let first = x + side * y;
            sums[first] += (1.0 - s) * (1.0 - t) * value;
            sums[first + 1] += s * (1.0 - t) * value;
            sums[first + side] += (1.0 - s) * t * value;
            sums[first + side + 1] += s * t * value;
        }
        // Read by columns or by rows, S is the same equation in s1 or s2.
        let mut sums = DMatrix::from_vec(side, side, sums);
        self.gram.solve_mut(&mut sums);
        let mut sums = sums.transpose();
        self.gram.solve_mut(&mut sums);
        sums.transpose().iter().map(|value| *value as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_bilinear_between_nodes_comes_back() {
        for side in [2, 3, 17, 40] {
            let wanted: Vec<f64> = (0..side * side).map(|k| f64::from(k as u32 * 7919 % 101) - 50.0).collect();
            let fit = GridFit::new(side).unwrap();
            let values = fit.places(|s, t| {
                let (x, y) = (s * (side - 1) as f64, t * (side - 1) as f64);
                let near = |a: f64, node: usize| (1.0 - (a - node as f64).abs()).max(0.0);
                wanted.iter().enumerate().map(|(k, w)| near(x, k % side) * near(y, k / side) * w).sum::<f64>()
            });
            for (got, wanted) in fit.nodes(values).iter().zip(&wanted) {
                assert!((f64::from(*got) - wanted).abs() < 1e-4, "{side}: {got} {wanted}");
            }
        }
    }

    #[test]
    fn noise_shrinks_as_points_are_many() {
        let fit = GridFit::new(17).unwrap();
        let mut state = 1u64;
        let values: Vec<f64> = fit
            .places(|_, _| ())
            .iter()
            .map(|()| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
            })
            .collect();
        let nodes = fit.nodes(values);
        let rms = (nodes.iter().map(|v| f64::from(v * v)).sum::<f64>() / nodes.len() as f64).sqrt();
        // 64 points a node, of 0.289 each: alone their mean would have 0.036; a fit has √3 of that along either axis.
        assert!((0.04..0.13).contains(&rms), "{rms}");
    }
}
