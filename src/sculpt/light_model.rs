//! Where the triangles of a periodic relief send light, and how that answers to the heights.
//!
//! Every square of the grid is cut along its higher diagonal ([`edge_slopes`](super::edge_slopes)). All triangles have the same
//! footprint, so each is one point of the slope plane with the same mass. Where the cut turns over, the square is
//! plane: light answers smoothly.

use rayon::prelude::*;

use super::concave_edges::ConcaveEdges;
use super::edge_slopes::{BANDS, EdgeSlopes, Lattice, SquareEdges};
use super::slope_histogram::{Place, SlopeHistogram};

/// The light of a lattice's triangles among the bins of a target.
pub struct LightModel {
    lattice: Lattice,
    bins: SlopeHistogram,
    /// Mass of a triangle cut as written, and of one cut the other way.
    mass: [f32; 2],
    concave: Option<ConcaveEdges>,
}

impl LightModel {
    /// For the triangles of `lattice`.
    ///
    /// A share `crossed` of the light goes as if squares were cut along their lower diagonals: whoever looks at the
    /// relief on a grid of points of his own cuts it as he likes. With `concave edges`, a cutter rounds what turns upward.
    pub fn new(lattice: Lattice, bins: SlopeHistogram, crossed: f64, concave: Option<ConcaveEdges>) -> Self {
        let mass = 0.5 / (lattice.n * lattice.n) as f64;
        Self { lattice, bins, mass: [(mass * (1.0 - crossed)) as f32, (mass * crossed) as f32], concave }
    }

    /// The light of a relief: shares in the bins, sum 1.
    pub fn forward(&self, edges: &EdgeSlopes) -> Vec<f32> {
        let bins = &self.bins;
        let lay = |band: usize| {
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
        let bands: Vec<Vec<f32>> = (0..BANDS).into_par_iter().map(lay).collect();
        let mut light = vec![0.0f32; bins.side * bins.side];
        light.par_chunks_mut(1 << 13).enumerate().for_each(|(k, piece)| {
            for band in &bands {
                piece.iter_mut().zip(&band[k << 13..]).for_each(|(sum, v)| *sum += v);
            }
        });
        light
    }

    /// The gradient with respect to the heights of Σ `potential` · light + `weight` · penalty of the concave edges; and that penalty.
    pub fn adjoint(&self, edges: &EdgeSlopes, potential: &[f32], weight: f32) -> (Vec<f32>, f64) {
        let bins = &self.bins;
        edges.adjoint(self.lattice, |row, sums| {
            for i in 0..self.lattice.n {
                let square = row.square(i);
                let mut answers = [[[0.0; 2]; 2]; 2];
                for (answers, (mass, places)) in answers.iter_mut().zip(self.triangles(square)) {
                    if mass == 0.0 {
                        continue;
                    }
                    for (answer, at) in answers.iter_mut().zip(places) {
                        let (_, [x, y]) = bins.sample(potential, at);
                        *answer = bins.to_slope([mass * x, mass * y]);
                    }
                }
                let [kept, crossed] = answers;
                sums.p[0][i] += kept[0][0] + crossed[0][0];
                sums.p[1][i] += kept[1][0] + crossed[1][0];
                let (aside, ahead) = (kept[0][1] + crossed[1][1], kept[1][1] + crossed[0][1]);
                let (left, right) = if square.rises() { (ahead, aside) } else { (aside, ahead) };
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

    /// Mass and places of a square's lower and upper triangle, as written and cut the other way.
    #[inline]
    fn triangles(&self, square: SquareEdges) -> [(f32, [Place; 2]); 2] {
        let SquareEdges { bottom, top, left, right } = square;
        let (aside, ahead) = if square.rises() { (right, left) } else { (left, right) };
        let places = |low: f32, up: f32| [self.bins.place(bottom, low), self.bins.place(top, up)];
        [(self.mass[0], places(aside, ahead)), (self.mass[1], places(ahead, aside))]
    }
}

#[cfg(test)]
mod tests;
