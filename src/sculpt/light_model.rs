//! The light of a periodic relief, as a histogram over slopes, and the gradient of a function of it.
//!
//! Every square of the grid is cut along its higher diagonal ([`edge_slopes`](super::edge_slopes)). All triangles have
//! the same footprint, so that each is a point of the slope plane with the same mass, 1/2n² of the plate. A square whose
//! higher diagonal changes from one to the other is plane at that moment, and its light the same with either: the light
//! is a continuous function of the heights.

use rayon::prelude::*;

use crate::relief::height_grid::top_rises_more;

use super::axis_histogram::{AlongRow, AxisHistogram, StripLight};
use super::concave_edges::ConcaveEdges;
use super::edge_slopes::{BANDS, EdgeRow, EdgeRowSums, EdgeSlopes, Lattice};

/// The light of a lattice's triangles among the bins of a target.
pub struct LightModel {
    lattice: Lattice,
    bins: AxisHistogram,
    /// Mass of each triangle along the higher diagonals, and along the lower ones.
    mass: [f32; 2],
    concave: Option<ConcaveEdges>,
}

/// Where the edges of a row of squares lie among the bins.
#[derive(Default)]
struct Places {
    bottoms: AlongRow,
    tops: AlongRow,
    sides: AlongRow,
}

impl Places {
    fn find(&mut self, bins: &AxisHistogram, row: &EdgeRow<'_>) {
        bins.locate_row(0, row.p[0], &mut self.bottoms);
        bins.locate_row(0, row.p[1], &mut self.tops);
        bins.locate_row(1, row.q[0], &mut self.sides);
    }
}

impl LightModel {
    /// For the triangles of `lattice`.
    ///
    /// A share `lower` of the light goes as if squares were cut along their lower diagonals: that of a surface whose
    /// squares may be cut either way (see `objective.rs`). With `concave`, a cutter rounds concave edges.
    pub fn new(lattice: Lattice, bins: AxisHistogram, lower: f64, concave: Option<ConcaveEdges>) -> Self {
        let mass = 0.5 / (lattice.n * lattice.n) as f64;
        Self { lattice, bins, mass: [(mass * (1.0 - lower)) as f32, (mass * lower) as f32], concave }
    }

    /// The light of a relief: the share of the plate in each bin, sum 1.
    pub fn forward(&self, edges: &EdgeSlopes) -> Vec<f32> {
        let bins = &self.bins;
        let splat = |band: usize| {
            let mut to = bins.dark(self.concave.is_some());
            let mut places = Places::default();
            for j in self.lattice.band(band) {
                let row = edges.row(j);
                places.find(bins, &row);
                self.splat_row(&row, &places, &mut to.light);
                if let Some(concave) = &self.concave {
                    concave.forward(&row, bins, &mut to);
                }
            }
            to
        };
        let bands: Vec<StripLight> = (0..BANDS).into_par_iter().map(splat).collect();
        bins.gathered(StripLight::added(&bands))
    }

    fn splat_row(&self, row: &EdgeRow<'_>, places: &Places, light: &mut [f32]) {
        let (bins, [higher, lower]) = (&self.bins, self.mass);
        let n = self.lattice.n;
        let [p0, p1] = row.p.map(|p| &p[..n]);
        let mut left = places.sides.at(0);
        for i in 0..n {
            let (bottom, top, right) = (places.bottoms.at(i), places.tops.at(i), places.sides.at(i + 1));
            let (with_bottom, with_top) = if top_rises_more(p0[i], p1[i]) { (right, left) } else { (left, right) };
            bins.splat(light, bottom, with_bottom, higher);
            bins.splat(light, top, with_top, higher);
            if lower > 0.0 {
                bins.splat(light, bottom, with_top, lower);
                bins.splat(light, top, with_bottom, lower);
            }
            left = right;
        }
    }

    /// The gradient with respect to the heights, per mm, of Σ `potential` · light + `weight` · penalty of the concave
    /// edges; and that penalty.
    pub fn adjoint(&self, edges: &EdgeSlopes, potential: &[f32], weight: f32) -> (Vec<f32>, f64) {
        let bins = &self.bins;
        let along_strips = bins.potential(potential, self.concave.is_some());
        edges.adjoint(self.lattice, |_, row, sums| {
            self.sample_row(&row, potential, sums);
            self.concave.as_ref().map_or(0.0, |concave| concave.adjoint(&row, bins, &along_strips, weight, sums))
        })
    }

    fn sample_row(&self, row: &EdgeRow<'_>, potential: &[f32], sums: &mut EdgeRowSums<'_>) {
        let (bins, n) = (&self.bins, self.lattice.n);
        let [per_p, per_q] = bins.per_slope();
        // Of each mass the gradient with respect to p and to q.
        let [higher, lower] = self.mass.map(|mass| [mass * per_p, mass * per_q]);
        let [p0, p1] = row.p.map(|p| &p[..n]);
        let mut places = Places::default();
        places.find(bins, row);
        let [of_bottom, of_top] = &mut sums.p;
        let of_side = &mut sums.q[0][..n + 1];
        let mut left = places.sides.at(0);
        for i in 0..n {
            let (bottom, top, right) = (places.bottoms.at(i), places.tops.at(i), places.sides.at(i + 1));
            let rises = top_rises_more(p0[i], p1[i]);
            let (with_bottom, with_top) = if rises { (right, left) } else { (left, right) };
            let (_, [bx, by]) = bins.sample(potential, bottom, with_bottom);
            let (_, [tx, ty]) = bins.sample(potential, top, with_top);
            let (mut at_bottom, mut at_top) = (higher[0] * bx, higher[0] * tx);
            let (mut first, mut second) = (higher[1] * by, higher[1] * ty);
            if lower[0] != 0.0 {
                let (_, [bx, by]) = bins.sample(potential, bottom, with_top);
                let (_, [tx, ty]) = bins.sample(potential, top, with_bottom);
                at_bottom += lower[0] * bx;
                at_top += lower[0] * tx;
                second += lower[1] * by;
                first += lower[1] * ty;
            }
            of_bottom[i] += at_bottom;
            of_top[i] += at_top;
            let (at_left, at_right) = if rises { (second, first) } else { (first, second) };
            of_side[i] += at_left;
            of_side[i + 1] += at_right;
            left = right;
        }
    }

    /// The penalty of a relief's concave edges: see [`ConcaveEdges`].
    pub fn penalty(&self, edges: &EdgeSlopes) -> f64 {
        let Some(concave) = &self.concave else { return 0.0 };
        let rows: Vec<f64> = (0..self.lattice.n).into_par_iter().map(|j| concave.penalty(&edges.row(j))).collect();
        rows.iter().sum()
    }
}

#[cfg(test)]
mod tests;
