//! The fillets that a cutter leaves at the concave edges of a plate, and where their light lands.
//!
//! As for slopes ([`concave_edges`](crate::sculpt::concave_edges)), with the light of a fillet spread evenly over the
//! straight line between where both of its ends land. Its mass is that of its middle, and its change is left out of the
//! gradient: fillets are a few percent of the light.

use crate::sculpt::concave_edges::{ConcaveEdge, ConcaveEdges};
use crate::sculpt::edge_slopes::{EdgeRow, EdgeRowSums};

use super::landing::{Landed, Landing};

/// Fillets of one plate.
#[derive(Clone, Copy, Debug)]
pub struct Fillets {
    /// What they take and cost.
    pub edges: ConcaveEdges,
    /// Squares along x and y.
    pub squares: [usize; 2],
}

impl Fillets {
    /// The edges of square (i, j) between two squares of the plate.
    #[inline]
    fn of(&self, row: &EdgeRow<'_>, i: usize, j: usize) -> impl Iterator<Item = ConcaveEdge> + use<> {
        let [x, y] = ConcaveEdges::of(row, i);
        let within = [i + 1 < self.squares[0], j + 1 < self.squares[1]];
        [x, y].into_iter().zip(within).filter(|(edge, within)| *within && edge.to > edge.from).map(|(edge, _)| edge)
    }

    #[inline]
    fn ends(edge: ConcaveEdge, landing: &Landing, place: [f32; 3]) -> [Landed; 2] {
        [edge.from, edge.to].map(|s| {
            let (p, q) = if edge.axis == 0 { (s, edge.along) } else { (edge.along, s) };
            landing.land(place, p, q)
        })
    }

    /// Adds to `light` what the fillets of row `j` move; `place` is where square i stands.
    pub fn forward(
        &self,
        (row, j): (&EdgeRow<'_>, usize),
        landing: &Landing,
        place: impl Fn(usize) -> [f32; 3],
        light: &mut [f32],
    ) {
        let bins = &landing.bins;
        let slope_per_bin = bins.slope_per_bin();
        for i in 0..self.squares[0] {
            for edge in self.of(row, i, j).filter(|edge| edge.moves_light(slope_per_bin)) {
                let [near, far] = Self::ends(edge, landing, place(i));
                let mass = self.edges.share(edge.axis) * (edge.to - edge.from) * 0.5 * (near.mass + far.mass);
                bins.splat(light, near.at, -0.5 * mass);
                bins.splat(light, far.at, -0.5 * mass);
                let (pieces, points) = bins.points_between(near.at, far.at);
                let each = mass / pieces as f32;
                points.for_each(|(_, at)| bins.splat(light, at, each));
            }
        }
    }

    /// Adds to `sums` the gradient of Σ `potential` · light + `weight` · penalty with respect to the edges of row `j`;
    /// returns their penalty.
    pub fn adjoint(
        &self,
        (row, j): (&EdgeRow<'_>, usize),
        landing: &Landing,
        place: impl Fn(usize) -> [f32; 3],
        (potential, weight): (&[f32], f32),
        sums: &mut EdgeRowSums<'_>,
    ) -> f64 {
        let slope_per_bin = landing.bins.slope_per_bin();
        let mut penalty = 0.0;
        for i in 0..self.squares[0] {
            for edge in self.of(row, i, j) {
                let share = self.edges.share(edge.axis);
                let (cost, rate) = self.edges.jump_cost(edge.to - edge.from);
                penalty += f64::from(share * cost);
                let [from, to, along] = match edge.moves_light(slope_per_bin) {
                    true => Self::strip(edge, landing, place(i), potential).map(|v| share * v),
                    false => [0.0; 3],
                };
                let priced = weight * share * rate;
                edge.add_gradient(row, i, [from - priced, to + priced, along], sums);
            }
        }
        penalty
    }

    /// Gradient of Δs · mass · (mean of the potential along the fillet - mean of it at both ends) with respect to the
    /// slopes `from`, `to` and `along`.
    fn strip(edge: ConcaveEdge, landing: &Landing, place: [f32; 3], potential: &[f32]) -> [f32; 3] {
        let bins = &landing.bins;
        let ends = Self::ends(edge, landing, place);
        let (across, along) = (edge.axis, 1 - edge.axis);
        let moved = |end: &Landed, axis: usize, g: [f32; 2]| g[0] * end.moves[axis][0] + g[1] * end.moves[axis][1];
        let [(near, near_g), (far, far_g)] = [&ends[0], &ends[1]].map(|end| bins.sample(potential, end.at));
        let mut value = -0.5 * (near + far);
        let mut from = -0.5 * moved(&ends[0], across, near_g);
        let mut to = -0.5 * moved(&ends[1], across, far_g);
        let mut sideways = -0.5 * (moved(&ends[0], along, near_g) + moved(&ends[1], along, far_g));
        let (pieces, points) = bins.points_between(ends[0].at, ends[1].at);
        let each = 1.0 / pieces as f32;
        for (t, at) in points {
            let (here, g) = bins.sample(potential, at);
            value += each * here;
            from += each * (1.0 - t) * moved(&ends[0], across, g);
            to += each * t * moved(&ends[1], across, g);
            sideways += each * ((1.0 - t) * moved(&ends[0], along, g) + t * moved(&ends[1], along, g));
        }
        let mass = 0.5 * (ends[0].mass + ends[1].mass);
        let width = edge.to - edge.from;
        [mass * (width * from - value), mass * (width * to + value), mass * width * sideways]
    }

    /// Penalty of row `j`.
    pub fn penalty(&self, row: &EdgeRow<'_>, j: usize) -> f64 {
        let each =
            |edge: ConcaveEdge| f64::from(self.edges.share(edge.axis) * self.edges.jump_cost(edge.to - edge.from).0);
        (0..self.squares[0]).map(|i| self.of(row, i, j).map(each).sum::<f64>()).sum()
    }
}
