//! Concave edges, which a cutter rounds: the light of their fillets, and a penalty on them.
//!
//! A square's own diagonal is a ridge, since it is the higher of the two; a relief is concave at the edges of squares
//! only. At an edge along y the slope p jumps upward by Δs, the larger p of the square after it less the smaller p of the
//! one before; at an edge along x likewise with q.
//!
//! There a tip of valley radius R leaves a fillet: a strip R·Δs wide, half of it taken from each side, whose slopes are
//! spread evenly between the two sides' (a paraboloid in place of the ball). Both sides have the same slope along the
//! edge, so that the fillet's light lies on a line parallel to an axis of the slope plane. A fillet whose ends are less
//! than a bin apart moves no light.
//!
//! The penalty is the sum over all concave edges of their strip's share of the plate, R·Δs times a step over the area,
//! with Δs replaced by a function of it, `ConcaveEdges::jump_cost`, that is smooth at 0 and steeper beyond
//! the sharpest jump allowed.

use crate::cutter::Cutter;

use super::axis_histogram::{Along, AxisHistogram, Potential, StripLight};
use super::edge_slopes::{EdgeRow, EdgeRowSums, Lattice};

/// Growth of the cost per unit of Δs when a jump is twice the sharpest one allowed, beside the 1 of its own area.
///
/// It trades light for reach. Sharper jumps than allowed were to be so rare that raising nodes at the end touches one in
/// a thousand, which it does (docs/relief.md); no search for the value is on record.
const STIFFNESS: f32 = 20.0;

/// Jumps of slope much smaller than this cost less than in proportion, as Δs²/SOFTNESS.
///
/// Without it the penalty has a kink at Δs = 0, where most edges of a smooth valley lie, and L-BFGS needs a continuous
/// gradient. 0.02 is half of the 0.04 that a tool turns by from one of its places to the next.
const SOFTNESS: f32 = 0.02;

/// The fillets that a cutter leaves on one lattice.
#[derive(Clone, Copy, Debug)]
pub struct ConcaveEdges {
    /// Share of the plate that the fillet of one edge takes per unit of Δs, for jumps of p and of q.
    share: [f32; 2],
    /// Largest Δs that is allowed.
    most: f32,
    /// Its inverse.
    per_most: f32,
}

/// An edge of a square and the slopes on both sides of it; concave where `to` is above `from`.
#[derive(Clone, Copy)]
pub(super) struct ConcaveEdge {
    /// Which slope jumps: 0 for p, 1 for q.
    pub axis: usize,
    pub from: f32,
    pub to: f32,
    /// The slope along the edge, which both sides share.
    pub along: f32,
}

impl ConcaveEdge {
    /// Whether its ends are more than one bin apart.
    #[inline]
    pub fn moves_light(self, slope_per_bin: [f32; 2]) -> bool {
        self.to - self.from > slope_per_bin[self.axis]
    }

    /// Adds a gradient with respect to `from`, `to` and `along` of this edge of square `i`.
    #[inline]
    pub fn add_gradient(self, row: &EdgeRow<'_>, i: usize, [from, to, along]: [f32; 3], sums: &mut EdgeRowSums<'_>) {
        if self.axis == 0 {
            sums.p[usize::from(row.p[1][i] < row.p[0][i])][i] += from;
            sums.p[usize::from(row.p[1][i + 1] > row.p[0][i + 1])][i + 1] += to;
            sums.q[0][i + 1] += along;
        } else {
            sums.q[0][i + usize::from(row.q[0][i + 1] < row.q[0][i])] += from;
            sums.q[1][i + usize::from(row.q[1][i + 1] > row.q[1][i])] += to;
            sums.p[1][i] += along;
        }
    }

    /// Where its ends lie along p and q.
    #[inline(always)]
    fn ends(self, bins: &AxisHistogram) -> [[Along; 2]; 2] {
        if self.axis == 0 {
            let along = bins.y(self.along);
            [[bins.x(self.from), along], [bins.x(self.to), along]]
        } else {
            let along = bins.x(self.along);
            [[along, bins.y(self.from)], [along, bins.y(self.to)]]
        }
    }
}

/// Gradients with respect to the slopes of a row's edges at which p, or q, jumps: at both ends of the jump, and along it.
struct EdgeGradients {
    ends: Vec<[f32; 2]>,
    along: Vec<f32>,
}

impl EdgeGradients {
    /// Adds them to the slopes that they are of: of two the lower before an edge, and the higher one after it.
    fn add_to(&self, axis: usize, row: &EdgeRow<'_>, sums: &mut EdgeRowSums<'_>) {
        let n = self.ends.len();
        let ([p0, p1], [q0, q1]) = (row.p.map(|p| &p[..n + 1]), row.q.map(|q| &q[..n + 1]));
        let [of_p0, of_p1] = sums.p.each_mut().map(|sums| &mut sums[..n + 1]);
        let [of_q0, of_q1] = sums.q.each_mut().map(|sums| &mut sums[..n + 1]);
        // Without branches: which of two is lower no processor foresees.
        let part = |first: bool, value: f32| if first { [value, 0.0] } else { [0.0, value] };
        for (i, (ends, along)) in self.ends.iter().zip(&self.along).enumerate() {
            if axis == 0 {
                let from = part(p1[i] < p0[i], ends[0]);
                let to = part(p1[i + 1] > p0[i + 1], ends[1]);
                (of_p0[i], of_p1[i]) = (of_p0[i] + from[1], of_p1[i] + from[0]);
                (of_p0[i + 1], of_p1[i + 1]) = (of_p0[i + 1] + to[1], of_p1[i + 1] + to[0]);
                of_q0[i + 1] += along;
            } else {
                let from = part(q0[i + 1] < q0[i], ends[0]);
                let to = part(q1[i + 1] > q1[i], ends[1]);
                (of_q0[i], of_q0[i + 1]) = (of_q0[i] + from[1], of_q0[i + 1] + from[0]);
                (of_q1[i], of_q1[i + 1]) = (of_q1[i] + to[1], of_q1[i + 1] + to[0]);
                of_p1[i] += along;
            }
        }
    }
}

impl ConcaveEdges {
    /// For the tip of `cutter`, where a jump of slope of more than `most` is too sharp.
    pub fn new(lattice: Lattice, cutter: Cutter, most: f64) -> Self {
        let share =
            (cutter.valley_radius() / lattice.step / (lattice.n * lattice.n) as f64).to_array().map(|v| v as f32);
        Self { share, most: most as f32, per_most: (1.0 / most) as f32 }
    }

    /// The same over `squares` squares in place of the lattice's own.
    pub(super) fn over(self, lattice: Lattice, squares: usize) -> Self {
        let factor = (lattice.n * lattice.n) as f32 / squares as f32;
        Self { share: self.share.map(|share| share * factor), ..self }
    }

    /// Share of the plate that the fillet of an edge takes per unit of its jump.
    #[inline]
    pub(super) fn share(&self, axis: usize) -> f32 {
        self.share[axis]
    }

    /// The edges at the right side and at the top of square `i`.
    #[inline]
    pub(super) fn of(row: &EdgeRow<'_>, i: usize) -> [ConcaveEdge; 2] {
        let ([p0, p1], [q0, q1]) = (row.p, row.q);
        let x = ConcaveEdge { axis: 0, from: p0[i].min(p1[i]), to: p0[i + 1].max(p1[i + 1]), along: q0[i + 1] };
        let y = ConcaveEdge { axis: 1, from: q0[i].min(q0[i + 1]), to: q1[i].max(q1[i + 1]), along: p1[i] };
        [x, y]
    }

    /// Adds to `light` what the fillets of a row move: their strips' light less what was there without them.
    pub(super) fn forward(&self, row: &EdgeRow<'_>, bins: &AxisHistogram, to: &mut StripLight) {
        let per_slope = bins.per_slope();
        let slope_per_bin = bins.slope_per_bin();
        for i in 0..row.p[0].len() - 1 {
            for edge in Self::of(row, i).into_iter().filter(|edge| edge.moves_light(slope_per_bin)) {
                let (axis, share) = (edge.axis, self.share[edge.axis]);
                let (half, density) = (0.5 * share * (edge.to - edge.from), share / per_slope[axis]);
                let [near, far] = edge.ends(bins);
                // What would lie beyond the rim lies on it.
                bins.splat(&mut to.light, near[0], near[1], -half - density * near[axis].beyond);
                bins.splat(&mut to.light, far[0], far[1], density * far[axis].beyond - half);
                bins.end_strip(to, axis, near, -density);
                bins.end_strip(to, axis, far, density);
            }
        }
    }

    /// Penalty of a row: about the share of the plate that its fillets take, and more where they are too sharp.
    pub fn penalty(&self, row: &EdgeRow<'_>) -> f64 {
        let each = |edge: ConcaveEdge| f64::from(self.share[edge.axis] * self.jump_cost(edge.to - edge.from).0);
        (0..row.p[0].len() - 1).map(|i| Self::of(row, i).into_iter().map(each).sum::<f64>()).sum()
    }

    /// Adds to `sums` the gradient of Σ `potential` · light + `weight` · penalty with respect to the slopes of a row's
    /// edges, as far as its fillets go; returns their penalty.
    pub(super) fn adjoint(
        &self,
        row: &EdgeRow<'_>,
        bins: &AxisHistogram,
        potential: &Potential,
        weight: f32,
        sums: &mut EdgeRowSums<'_>,
    ) -> f64 {
        let n = row.p[0].len() - 1;
        let mut of_edges = EdgeGradients { ends: vec![[0.0; 2]; n], along: vec![0.0; n] };
        let mut penalty = 0.0;
        for axis in 0..2 {
            penalty += self.penalise(axis, row, weight, &mut of_edges);
            self.add_strips(axis, row, bins, potential, &mut of_edges);
            of_edges.add_to(axis, row, sums);
        }
        penalty
    }

    /// What the edges of a row at which p, or q, jumps cost, several reckoned side by side; `weight` times its gradient
    /// goes to `of_edges`.
    fn penalise(&self, axis: usize, row: &EdgeRow<'_>, weight: f32, of_edges: &mut EdgeGradients) -> f64 {
        let n = of_edges.ends.len();
        let ([p0, p1], [q0, q1]) = (row.p.map(|p| &p[..n + 1]), row.q.map(|q| &q[..n + 1]));
        let share = self.share[axis];
        let mut costs = 0.0f32;
        for (i, ends) in of_edges.ends.iter_mut().enumerate() {
            let (from, to) = if axis == 0 {
                (p0[i].min(p1[i]), p0[i + 1].max(p1[i + 1]))
            } else {
                (q0[i].min(q0[i + 1]), q1[i].max(q1[i + 1]))
            };
            let (cost, rate) = self.jump_cost(to - from);
            costs += cost;
            *ends = [-weight * share * rate, weight * share * rate];
        }
        f64::from(share * costs)
    }

    /// Adds the gradients of the light of the few edges whose fillets move light.
    fn add_strips(
        &self,
        axis: usize,
        row: &EdgeRow<'_>,
        bins: &AxisHistogram,
        potential: &Potential,
        of_edges: &mut EdgeGradients,
    ) {
        let slope_per_bin = bins.slope_per_bin();
        for (i, (ends, along)) in of_edges.ends.iter_mut().zip(&mut of_edges.along).enumerate() {
            let edge = Self::of(row, i)[axis];
            *along = 0.0;
            if edge.moves_light(slope_per_bin) {
                let [from, to, aside] = Self::strip(edge, bins, potential).map(|v| self.share[axis] * v);
                *ends = [ends[0] + from, ends[1] + to];
                *along = aside;
            }
        }
    }

    /// Gradient of Δs · (mean of the potential along the fillet - mean of it at both ends) with respect to the slopes
    /// `from`, `to` and `along`.
    #[inline(always)]
    fn strip(edge: ConcaveEdge, bins: &AxisHistogram, potential: &Potential) -> [f32; 3] {
        let (axis, per_slope) = (edge.axis, bins.per_slope());
        let (per_across, per_along) = (per_slope[axis], per_slope[1 - axis]);
        let ends = edge.ends(bins);
        let [near, far] = ends.map(|end| bins.sample_strip(potential, axis, end));
        let (half, mean) = (0.5 * (edge.to - edge.from), 0.5 * (near.value + far.value));
        // The integral of the potential along the strip, moved aside; beyond the rim it is that on the rim.
        let integral = far.across_integral - near.across_integral + ends[1][axis].beyond * far.across
            - ends[0][axis].beyond * near.across;
        [
            mean - near.value - half * per_across * near.along,
            far.value - mean - half * per_across * far.along,
            per_along * (integral / per_across - half * (near.across + far.across)),
        ]
    }

    /// What a jump Δs costs, and the derivative of that: Δs²/(Δs + SOFTNESS), and beyond the largest one allowed
    /// ½ STIFFNESS · most · (Δs/most - 1)² more.
    #[inline(always)]
    pub(super) fn jump_cost(&self, jump: f32) -> (f32, f32) {
        // Of a convex edge all terms are 0.
        let jump = jump.max(0.0);
        let inverse = 1.0 / (jump + SOFTNESS);
        let part = jump * inverse;
        let over = (jump * self.per_most - 1.0).max(0.0);
        (
            jump * part + 0.5 * STIFFNESS * self.most * over * over,
            part * (jump + 2.0 * SOFTNESS) * inverse + STIFFNESS * over,
        )
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat2, DVec2};

    use super::*;
    use crate::sculpt::edge_slopes::EdgeSlopes;
    use crate::sculpt::light_model::LightModel;
    use crate::sculpt::target::SlopeTarget;

    #[test]
    fn a_groove_has_its_fillet_between_its_flanks() {
        // z falls to the middle and rises again: slopes -0.4 and 0.4, one valley and one ridge a cell.
        let (n, h, radius) = (16, 0.05, 0.03);
        let lattice = Lattice { n, step: DVec2::splat(h) };
        let z: Vec<f32> = (0..n * n).map(|k| 0.4 * h as f32 * ((k % n) as f32 - 8.0).abs()).collect();
        let per_slope = DMat2::from_diagonal(DVec2::splat(0.45 * 128.0));
        let (degrees, middle) = (DMat2::IDENTITY, DVec2::splat(63.5));
        let target = SlopeTarget { side: 128, bin: 1.0, wanted: vec![], per_slope, degrees, middle };
        let bins = AxisHistogram::new(&target);
        let concave = ConcaveEdges::new(lattice, Cutter::ball(2.0 * radius), 10.0);
        let edges = EdgeSlopes::new(lattice, &z);
        let light = LightModel::new(lattice, bins, 0.0, Some(concave)).forward(&edges);
        let share_near = |p: f64| {
            let [x, y] = [bins.x(p as f32), bins.y(0.0)].map(|at| at.bin as f32 + at.part);
            let near = |k: usize| ((k % 128) as f32 - x).hypot((k / 128) as f32 - y) < 1.9;
            light.iter().enumerate().filter(|(k, _)| near(*k)).map(|(_, v)| f64::from(*v)).sum::<f64>()
        };
        // R Δs = 0.024 of the cell's 0.8 mm.
        let fillet = radius * 0.8 / (n as f64 * h);
        let flank = 0.5 * (1.0 - fillet);
        for p in [-0.4, 0.4] {
            assert!(share_near(p) > flank - 1e-6 && share_near(p) < flank + 0.1 * fillet, "{p}: {}", share_near(p));
        }
        // A disc 3.8 bins across on a way of 46 bins.
        let per_bin = fillet / (0.8 * 0.45 * 128.0);
        for p in [-0.25, 0.0, 0.3] {
            assert!((share_near(p) / per_bin - 3.8).abs() < 1.0, "{p}: {}", share_near(p) / per_bin);
        }
        // Smooth at 0, the penalty counts a little less than the strip.
        let penalty: f64 = (0..n).map(|j| concave.penalty(&edges.row(j))).sum();
        assert!(penalty < fillet && penalty > 0.9 * fillet, "{penalty} {fillet}");
    }
}
