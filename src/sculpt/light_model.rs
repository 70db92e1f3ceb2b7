//! The light of a periodic relief, as a histogram over slopes, and the gradient of a function of it.
//!
//! Every square of the grid is cut along its higher diagonal ([`edge_slopes`](super::edge_slopes)). All triangles have
//! the same footprint, so that each is a point of the slope plane with the same mass, 1/2n² of the plate. A square whose
//! higher diagonal changes from one to the other is plane at that moment, and its light the same with either: the light
//! is a continuous function of the heights.

use rayon::prelude::*;

use super::concave_edges::ConcaveEdges;
use super::edge_slopes::{EdgeSlopes, Lattice, SquareEdges, added_bands};
use super::slope_histogram::{Place, SlopeHistogram};

/// The light of a lattice's triangles among the bins of a target.
pub struct LightModel {
    lattice: Lattice,
    bins: SlopeHistogram,
    /// Mass of each triangle along the higher diagonals, and along the lower ones.
    mass: [f32; 2],
    concave: Option<ConcaveEdges>,
}

impl LightModel {
    /// For the triangles of `lattice`.
    ///
    /// A share `lower` of the light goes as if squares were cut along their lower diagonals: that of a surface whose
    /// squares may be cut either way (see `objective.rs`). With `concave`, a cutter rounds concave edges.
    pub fn new(lattice: Lattice, bins: SlopeHistogram, lower: f64, concave: Option<ConcaveEdges>) -> Self {
        let mass = 0.5 / (lattice.n * lattice.n) as f64;
        Self { lattice, bins, mass: [(mass * (1.0 - lower)) as f32, (mass * lower) as f32], concave }
    }

    /// The light of a relief: the share of the plate in each bin, sum 1.
    pub fn forward(&self, edges: &EdgeSlopes) -> Vec<f32> {
        let bins = &self.bins;
        let splat = |band: usize| {
            let mut light = vec![0.0f32; bins.side * bins.side];
            for j in self.lattice.band(band) {
                let row = edges.row(j);
                for i in 0..self.lattice.n {
                    for (mass, places) in self.triangles(row.square(i)).into_iter().filter(|(mass, _)| *mass > 0.0) {
                        places.into_iter().for_each(|at| bins.splat(&mut light, at, mass));
                    }
                }
                if let Some(concave) = &self.concave {
                    concave.forward(&row, bins, &mut light);
                }
            }
            light
        };
        added_bands(bins.side * bins.side, splat)
    }

    /// The gradient with respect to the heights, per mm, of Σ `potential` · light + `weight` · penalty of the concave
    /// edges; and that penalty.
    pub fn adjoint(&self, edges: &EdgeSlopes, potential: &[f32], weight: f32) -> (Vec<f32>, f64) {
        let bins = &self.bins;
        edges.adjoint(self.lattice, |_, row, sums| {
            for i in 0..self.lattice.n {
                let square = row.square(i);
                // Of both cuts and of the lower and the upper triangle, with respect to p and q.
                let mut gradients = [[[0.0; 2]; 2]; 2];
                for (gradients, (mass, places)) in gradients.iter_mut().zip(self.triangles(square)) {
                    if mass == 0.0 {
                        continue;
                    }
                    for (gradient, at) in gradients.iter_mut().zip(places) {
                        let (_, [x, y]) = bins.sample(potential, at);
                        *gradient = bins.to_slope([mass * x, mass * y]);
                    }
                }
                let [higher, lower] = gradients;
                sums.p[0][i] += higher[0][0] + lower[0][0];
                sums.p[1][i] += higher[1][0] + lower[1][0];
                let (first, second) = (higher[0][1] + lower[1][1], higher[1][1] + lower[0][1]);
                let (left, right) = if square.rises() { (second, first) } else { (first, second) };
                sums.q[0][i] += left;
                sums.q[0][i + 1] += right;
            }
            self.concave.as_ref().map_or(0.0, |concave| concave.adjoint(&row, bins, potential, weight, sums))
        })
    }

    /// The penalty of a relief's concave edges: see [`ConcaveEdges`].
    pub fn penalty(&self, edges: &EdgeSlopes) -> f64 {
        let Some(concave) = &self.concave else { return 0.0 };
        let rows: Vec<f64> = (0..self.lattice.n).into_par_iter().map(|j| concave.penalty(&edges.row(j))).collect();
        rows.iter().sum()
    }

    /// Mass and places of a square's lower and upper triangle, cut along the higher diagonal and along the lower one.
    #[inline]
    fn triangles(&self, square: SquareEdges) -> [(f32, [Place; 2]); 2] {
        let SquareEdges { bottom, top, left, right } = square;
        let (with_bottom, with_top) = if square.rises() { (right, left) } else { (left, right) };
        let places = |low: f32, up: f32| [self.bins.place(bottom, low), self.bins.place(top, up)];
        [(self.mass[0], places(with_bottom, with_top)), (self.mass[1], places(with_top, with_bottom))]
    }
}

#[cfg(test)]
mod tests;
