//! Where a relief turns upward, which a ball cutter rounds: the light of the fillets, and a penalty on them.
//!
//! A square's own edge is a ridge, since it is cut along its higher diagonal; the relief turns upward at the edges of
//! squares only. Across a rim along y by the larger p of the square after it less the smaller p of the one before, and
//! likewise across a rim along x.
//!
//! There a ball of radius R leaves a fillet, a strip R·Δs wide, half of it taken from each side, whose light is spread
//! evenly between the two slopes (a parabola in place of the sphere). The two triangles at a rim share its slope along
//! it, so the way from one to the other runs along an axis of the slope plane. Ends less than a bin apart are as good as
//! one place: such fillets move no light.

use crate::cutter::Cutter;

use super::edge_slopes::{EdgeRow, EdgeRowSums, Lattice};
use super::slope_histogram::{Place, SlopeHistogram};

/// How strongly concave edges of more than what is allowed are charged, beside their share of the plate.
const STIFFNESS: f32 = 20.0;

/// Concave edges much smaller than this are charged less than in proportion, so that the penalty is smooth at 0.
const SOFTNESS: f32 = 0.02;

/// The fillets that a ball leaves on one lattice.
#[derive(Clone, Copy, Debug)]
pub struct ConcaveEdges {
    /// Share of the plate that a edge of 1 along x and y takes.
    share: [f32; 2],
    /// Sharpest edge that is allowed.
    most: f32,
}

/// A rim at which the relief turns upward.
#[derive(Clone, Copy)]
struct ConcaveEdge {
    /// Across which axis it turns: 0 where p changes, 1 where q does.
    axis: usize,
    from: f32,
    to: f32,
    /// The slope that both sides have along the rim.
    along: f32,
}

impl ConcaveEdge {
    /// Whether its ends are further apart than the bins `apart`.
    #[inline]
    fn moves_light(self, apart: [f32; 2]) -> bool {
        self.to - self.from > apart[self.axis]
    }

    fn ends(self, bins: &SlopeHistogram) -> [Place; 2] {
        let place = |s: f32| if self.axis == 0 { bins.place(s, self.along) } else { bins.place(self.along, s) };
        [place(self.from), place(self.to)]
    }
}

impl ConcaveEdges {
    /// For the tip of `cutter`, which shall meet no edge sharper than `most`.
    pub fn new(lattice: Lattice, cutter: Cutter, most: f64) -> Self {
        let share =
            (cutter.valley_radius() / lattice.step / (lattice.n * lattice.n) as f64).to_array().map(|v| v as f32);
        Self { share, most: most as f32 }
    }

    /// The concave edges at the right side and at the top of square `i`.
    #[inline]
    fn of(row: &EdgeRow<'_>, i: usize) -> [ConcaveEdge; 2] {
        let ([p0, p1], [q0, q1]) = (row.p, row.q);
        let x = ConcaveEdge { axis: 0, from: p0[i].min(p1[i]), to: p0[i + 1].max(p1[i + 1]), along: q0[i + 1] };
        let y = ConcaveEdge { axis: 1, from: q0[i].min(q0[i + 1]), to: q1[i].max(q1[i + 1]), along: p1[i] };
        [x, y]
    }

    /// Moves the light of a row's fillets.
    pub fn forward(&self, row: &EdgeRow<'_>, bins: &SlopeHistogram, light: &mut [f32]) {
        let apart = bins.apart();
        for i in 0..row.p[0].len() - 1 {
            for edge in Self::of(row, i).into_iter().filter(|edge| edge.moves_light(apart)) {
                let mass = self.share[edge.axis] * (edge.to - edge.from);
                let [near, far] = edge.ends(bins);
                bins.splat(light, near, -0.5 * mass);
                bins.splat(light, far, -0.5 * mass);
                let (pieces, points) = bins.walk(near, far);
                let each = mass / pieces as f32;
                points.for_each(|(_, at)| bins.splat(light, at, each));
            }
        }
    }

    /// Toll of a row: about the share of the plate that its fillets take, and more where they are too sharp.
    pub fn penalty(&self, row: &EdgeRow<'_>) -> f64 {
        let each = |edge: ConcaveEdge| f64::from(self.share[edge.axis] * self.charge(edge.to - edge.from).0);
        (0..row.p[0].len() - 1).map(|i| Self::of(row, i).into_iter().map(each).sum::<f64>()).sum()
    }

    /// Adds how Σ `potential` · light + `weight` · penalty answers to a row's edges; returns its penalty.
    pub fn adjoint(
        &self,
        row: &EdgeRow<'_>,
        bins: &SlopeHistogram,
        potential: &[f32],
        weight: f32,
        sums: &mut EdgeRowSums<'_>,
    ) -> f64 {
        let mut penalty = 0.0;
        let apart = bins.apart();
        for i in 0..row.p[0].len() - 1 {
            for edge in Self::of(row, i).into_iter().filter(|edge| edge.to > edge.from) {
                let share = self.share[edge.axis];
                let (cost, rate) = self.charge(edge.to - edge.from);
                penalty += f64::from(share * cost);
                let strip = if edge.moves_light(apart) { Self::strip(edge, bins, potential) } else { [0.0; 3] };
                let [from, to, along] = strip.map(|v| share * v);
                let (from, to) = (from - weight * share * rate, to + weight * share * rate);
                if edge.axis == 0 {
                    sums.p[usize::from(row.p[1][i] < row.p[0][i])][i] += from;
                    sums.p[usize::from(row.p[1][i + 1] > row.p[0][i + 1])][i + 1] += to;
                    sums.q[0][i + 1] += along;
                } else {
                    sums.q[0][i + usize::from(row.q[0][i + 1] < row.q[0][i])] += from;
                    sums.q[1][i + usize::from(row.q[1][i + 1] > row.q[1][i])] += to;
                    sums.p[1][i] += along;
                }
            }
        }
        penalty
    }

    /// How width · (mean of the potential along the way - mean of its ends) answers to a edge's ends and to the slope
    /// along its rim.
    fn strip(edge: ConcaveEdge, bins: &SlopeHistogram, potential: &[f32]) -> [f32; 3] {
        let ends = edge.ends(bins);
        let read = |at: Place| {
            let (value, gradient) = bins.sample(potential, at);
            let slopes = bins.to_slope(gradient);
            [value, slopes[edge.axis], slopes[1 - edge.axis]]
        };
        let [near, far] = ends.map(read);
        let mut sums = [-0.5 * (near[0] + far[0]), -0.5 * near[1], -0.5 * far[1], -0.5 * (near[2] + far[2])];
        let (pieces, points) = bins.walk(ends[0], ends[1]);
        let each = 1.0 / pieces as f32;
        for (t, at) in points {
            let [value, across, along] = read(at);
            sums[0] += each * value;
            sums[1] += each * (1.0 - t) * across;
            sums[2] += each * t * across;
            sums[3] += each * along;
        }
        let width = edge.to - edge.from;
        [width * sums[1] - sums[0], width * sums[2] + sums[0], width * sums[3]]
    }

    /// What a edge costs, and how that grows.
    fn charge(&self, edge: f32) -> (f32, f32) {
        if edge <= 0.0 {
            return (0.0, 0.0);
        }
        let whole = edge + SOFTNESS;
        let over = (edge / self.most - 1.0).max(0.0);
        (
            edge * edge / whole + 0.5 * STIFFNESS * self.most * over * over,
            edge * (edge + 2.0 * SOFTNESS) / (whole * whole) + STIFFNESS * over,
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
        let per_slope = DMat2::from_angle(0.3) * (0.45 * 128.0);
        let target = SlopeTarget { side: 128, bin: 1.0, wanted: vec![], per_slope, middle: DVec2::splat(63.5) };
        let bins = SlopeHistogram::new(&target);
        let concave = ConcaveEdges::new(lattice, Cutter::ball(2.0 * radius), 10.0);
        let edges = EdgeSlopes::new(lattice, &z);
        let light = LightModel::new(lattice, bins, 0.0, Some(concave)).forward(&edges);
        let share_near = |p: f64| {
            let at = bins.place(p as f32, 0.0);
            let near = |k: usize| ((k % 128) as f32 - at.x).hypot((k / 128) as f32 - at.y) < 1.9;
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
