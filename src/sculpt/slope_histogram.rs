//! A histogram over the plane of slopes: light is splatted into its bins bilinearly, and a potential over the bins is
//! interpolated in the same way, so that each is the other's adjoint.

use glam::DMat2;

use super::target::SlopeTarget;

/// Where slopes fall among the bins of a target.
#[derive(Clone, Copy, Debug)]
pub struct SlopeHistogram {
    /// Bins a side.
    pub side: usize,
    /// Where the mean slope lies, bins.
    middle: [f32; 2],
    /// Bins along x and y per unit of slope p and q, columns p and q.
    per_slope: [[f32; 2]; 2],
    /// Largest coordinate that still has a bin beyond it.
    last: f32,
}

/// A point of the slope plane in bins; what lies beyond the rim counts as on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// In bins along x.
    pub x: f32,
    /// In bins along y.
    pub y: f32,
}

impl SlopeHistogram {
    /// Over the bins of `target`.
    pub fn new(target: &SlopeTarget) -> Self {
        let DMat2 { x_axis, y_axis } = target.per_slope;
        Self {
            side: target.side,
            middle: [target.middle.x as f32, target.middle.y as f32],
            per_slope: [[x_axis.x as f32, x_axis.y as f32], [y_axis.x as f32, y_axis.y as f32]],
            last: target.side as f32 - 1.001,
        }
    }

    /// The place of a slope relative to the mean.
    #[inline]
    pub fn place(&self, p: f32, q: f32) -> Place {
        let [[xp, yp], [xq, yq]] = self.per_slope;
        Place { x: self.middle[0] + xp * p + xq * q, y: self.middle[1] + yp * p + yq * q }
    }

    /// The changes of p alone and of q alone that lead one bin further.
    #[inline]
    pub(crate) fn slope_per_bin(&self) -> [f32; 2] {
        self.per_slope.map(|[x, y]| 1.0 / x.abs().max(y.abs()))
    }

    #[inline(always)]
    fn corner(&self, at: Place) -> (usize, f32, f32) {
        // In this order, a coordinate that is not a number becomes 0.
        let (x, y) = (at.x.max(0.0).min(self.last), at.y.max(0.0).min(self.last));
        // To and from i32 there are single instructions, to and from usize there are not.
        let (i, j) = (x as i32, y as i32);
        (j as usize * self.side + i as usize, x - i as f32, y - j as f32)
    }

    /// Adds `mass` to the four bins around a place, to each the more the nearer it is. Of [`bilinear_weights`](crate::raster::bilinear_weights)'s
    /// products these are the same with fewer multiplications.
    #[inline(always)]
    pub fn splat(&self, light: &mut [f32], at: Place, mass: f32) {
        let (k, a, b) = self.corner(at);
        let (upper, lower) = (mass * b, mass - mass * b);
        let four = &mut light[k..k + self.side + 2];
        four[0] += lower - lower * a;
        four[1] += lower * a;
        four[self.side] += upper - upper * a;
        four[self.side + 1] += upper * a;
    }

    /// The potential at a place, and its gradient in bins.
    #[inline(always)]
    pub fn sample(&self, potential: &[f32], at: Place) -> (f32, [f32; 2]) {
        let (k, a, b) = self.corner(at);
        let four = &potential[k..k + self.side + 2];
        let [p00, p10, p01, p11] = [four[0], four[1], four[self.side], four[self.side + 1]];
        let (lower, upper) = (p00 + a * (p10 - p00), p01 + a * (p11 - p01));
        let along = (1.0 - b) * (p10 - p00) + b * (p11 - p01);
        (lower + b * (upper - lower), [along, upper - lower])
    }

    /// How many equal pieces the line between two places is cut into, and the middle of each with its share of the way.
    pub(crate) fn points_between(&self, from: Place, to: Place) -> (usize, impl Iterator<Item = (f32, Place)> + use<>) {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        // About two bins a piece: no blur of the design is narrower than two bins (see `Work::objective`), so that
        // neither the potential nor the blurred light tells such pieces from a line.
        let pieces = (0.5 * dx.abs().max(dy.abs()) + 1.0).min(2.0 * self.side as f32) as i32;
        let each = 1.0 / pieces as f32;
        let points = (0..pieces).map(move |k| {
            let t = (k as f32 + 0.5) * each;
            (t, Place { x: from.x + t * dx, y: from.y + t * dy })
        });
        (pieces as usize, points)
    }
}
