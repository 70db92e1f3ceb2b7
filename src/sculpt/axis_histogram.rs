//! A histogram over the plane of slopes whose rows are q and whose columns are p: where a slope falls is known from its p
//! and its q one at a time, and light that is spread along an axis between two places is added at its ends alone.
//!
//! Light is splatted bilinearly. Light spread evenly from a to b along a row gives bin i, with the integral H of the hat
//! function, the share H(b - i) - H(a - i) of the light per bin. As a sum over all bins from i on, H(x - i) has three terms,
//! at the bins around x; so the ends are noted in a grid of differences, six numbers each, and one sum along each row at
//! the end makes light of them, however long the strips were. Read backward, sums of the potential along each row are made
//! first, and a strip reads them at its ends.

use super::edge_slopes::added;
use super::target::SlopeTarget;

/// Where slopes fall along one axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// Bins per unit of slope.
    per_slope: f32,
    /// Where the mean slope lies, bins.
    middle: f32,
    /// Largest coordinate that still has a bin beyond it.
    last: f32,
}

/// A coordinate among bins: the bin before it, and how far beyond that, 0 to 1.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Along {
    pub bin: usize,
    pub part: f32,
    /// Bins by which it would lie beyond the rim; it counts as on it.
    pub beyond: f32,
}

impl Axis {
    #[inline(always)]
    fn locate(self, slope: f32) -> Along {
        let x = self.middle + self.per_slope * slope;
        // In this order, a coordinate that is not a number becomes 0.
        let within = x.max(0.0).min(self.last);
        // To and from i32 there are single instructions, to and from usize there are not.
        let bin = within as i32;
        Along { bin: bin as usize, part: within - bin as f32, beyond: x - within }
    }
}

/// Where a row of slopes lies along an axis.
#[derive(Clone, Debug, Default)]
pub(crate) struct AlongRow {
    bins: Vec<u32>,
    parts: Vec<f32>,
}

impl AlongRow {
    /// Where slope `i` lies; what is beyond the rim is not told.
    #[inline(always)]
    pub fn at(&self, i: usize) -> Along {
        Along { bin: self.bins[i] as usize, part: self.parts[i], beyond: 0.0 }
    }
}

/// Where slopes fall among the bins of a target whose axes are p and q.
#[derive(Clone, Copy, Debug)]
pub struct AxisHistogram {
    /// Bins a side.
    pub side: usize,
    axes: [Axis; 2],
}

/// The potential, and its sums along both axes.
pub(crate) struct Potential<'a> {
    values: &'a [f32],
    /// Of each bin the sum over the bins before it in its row, and in its column.
    before: [Vec<f32>; 2],
}

/// Light, and the differences of light that is spread along an axis.
pub(crate) struct StripLight {
    pub light: Vec<f32>,
    /// Rows of `side + 1`, and `side + 1` rows: the first of each is the bin before the first.
    differences: [Vec<f32>; 2],
}

impl AxisHistogram {
    /// Over the bins of `target`, whose `per_slope` is diagonal.
    pub fn new(target: &SlopeTarget) -> Self {
        let axis = |per_slope: f64, middle: f64| Axis {
            per_slope: per_slope as f32,
            middle: middle as f32,
            last: target.side as f32 - 1.001,
        };
        let (per_slope, middle) = (target.per_slope, target.middle);
        Self { side: target.side, axes: [axis(per_slope.x_axis.x, middle.x), axis(per_slope.y_axis.y, middle.y)] }
    }

    /// Where p lies along x.
    #[inline(always)]
    pub(crate) fn x(&self, p: f32) -> Along {
        self.axes[0].locate(p)
    }

    /// Where q lies along y.
    #[inline(always)]
    pub(crate) fn y(&self, q: f32) -> Along {
        self.axes[1].locate(q)
    }

    /// Where a row of slopes lies along x, if `axis` is 0, or along y: several are found side by side.
    pub(crate) fn locate_row(&self, axis: usize, slopes: &[f32], row: &mut AlongRow) {
        let axis = self.axes[axis];
        row.bins.clear();
        row.parts.clear();
        row.bins.extend(slopes.iter().map(|slope| axis.locate(*slope).bin as u32));
        row.parts.extend(slopes.iter().map(|slope| axis.locate(*slope).part));
    }

    /// Bins per unit of p along x and of q along y.
    #[inline(always)]
    pub(crate) fn per_slope(&self) -> [f32; 2] {
        self.axes.map(|axis| axis.per_slope)
    }

    /// The changes of p alone and of q alone that lead one bin further.
    #[inline(always)]
    pub(crate) fn slope_per_bin(&self) -> [f32; 2] {
        self.per_slope().map(|per_slope| 1.0 / per_slope.abs())
    }

    /// Adds `mass` to the four bins around a place, to each the more the nearer it is. Of
    /// [`bilinear_weights`](crate::raster::bilinear_weights)'s products these are the same with fewer multiplications.
    #[inline(always)]
    pub(crate) fn splat(&self, light: &mut [f32], x: Along, y: Along, mass: f32) {
        let k = y.bin * self.side + x.bin;
        let (upper, lower) = (mass * y.part, mass - mass * y.part);
        let (upper_right, lower_right) = (upper * x.part, lower * x.part);
        let four = &mut light[k..k + self.side + 2];
        four[0] += lower - lower_right;
        four[1] += lower_right;
        four[self.side] += upper - upper_right;
        four[self.side + 1] += upper_right;
    }

    /// The potential at a place, and its gradient in bins.
    #[inline(always)]
    pub(crate) fn sample(&self, potential: &[f32], x: Along, y: Along) -> (f32, [f32; 2]) {
        let k = y.bin * self.side + x.bin;
        let four = &potential[k..k + self.side + 2];
        let [p00, p10, p01, p11] = [four[0], four[1], four[self.side], four[self.side + 1]];
        let (rise, upper_rise) = (p10 - p00, p11 - p01);
        let (lower, upper) = (p00 + x.part * rise, p01 + x.part * upper_rise);
        (lower + y.part * (upper - lower), [rise + y.part * (upper_rise - rise), upper - lower])
    }

    /// No light.
    pub(crate) fn dark(&self, with_strips: bool) -> StripLight {
        let room = if with_strips { self.side * (self.side + 1) } else { 0 };
        StripLight { light: vec![0.0; self.side * self.side], differences: [vec![0.0; room], vec![0.0; room]] }
    }

    /// Notes that light of `density` a bin ends at a place, or with a density below 0 that it begins there; it is spread
    /// along `axis`.
    #[inline(always)]
    pub(crate) fn end_strip(&self, to: &mut StripLight, axis: usize, [x, y]: [Along; 2], density: f32) {
        let (along, across) = if axis == 0 { (x, y) } else { (y, x) };
        let t = along.part;
        let after = 0.5 * t * t;
        let before = 0.5 - t + after;
        let three = [before, 1.0 - before - after, after].map(|weight| density * weight);
        let (upper, lower) = (across.part, 1.0 - across.part);
        let differences = &mut to.differences[axis];
        if axis == 0 {
            let width = self.side + 1;
            let k = y.bin * width + x.bin;
            let six = &mut differences[k..k + width + 3];
            for (m, value) in three.into_iter().enumerate() {
                six[m] += lower * value;
                six[width + m] += upper * value;
            }
        } else {
            for (m, value) in three.into_iter().enumerate() {
                let k = (y.bin + m) * self.side + x.bin;
                let two = &mut differences[k..k + 2];
                two[0] += lower * value;
                two[1] += upper * value;
            }
        }
    }

    /// The light of strips and of all else.
    pub(crate) fn gathered(&self, StripLight { mut light, differences }: StripLight) -> Vec<f32> {
        let side = self.side;
        let [along_x, along_y] = differences;
        if along_x.is_empty() {
            return light;
        }
        for (light, differences) in light.chunks_mut(side).zip(along_x.chunks(side + 1)) {
            let mut sum = 0.0f64;
            for (light, difference) in light.iter_mut().zip(&differences[1..]).rev() {
                sum += f64::from(*difference);
                *light += sum as f32;
            }
        }
        let mut sums = vec![0.0f64; side];
        for (light, differences) in light.chunks_mut(side).zip(along_y[side..].chunks(side)).rev() {
            for ((light, difference), sum) in light.iter_mut().zip(differences).zip(&mut sums) {
                *sum += f64::from(*difference);
                *light += *sum as f32;
            }
        }
        light
    }

    /// `values` over the bins, ready to be read along strips if `with_strips`.
    pub(crate) fn potential<'a>(&self, values: &'a [f32], with_strips: bool) -> Potential<'a> {
        let side = self.side;
        if !with_strips {
            return Potential { values, before: [Vec::new(), Vec::new()] };
        }
        let [mut in_row, mut in_column] = [vec![0.0f32; values.len()], vec![0.0f32; values.len()]];
        for (before, values) in in_row.chunks_mut(side).zip(values.chunks(side)) {
            let mut sum = 0.0f64;
            for (before, value) in before.iter_mut().zip(values) {
                *before = sum as f32;
                sum += f64::from(*value);
            }
        }
        let mut sums = vec![0.0f64; side];
        for (before, values) in in_column.chunks_mut(side).zip(values.chunks(side)) {
            for ((before, value), sum) in before.iter_mut().zip(values).zip(&mut sums) {
                *before = *sum as f32;
                *sum += f64::from(*value);
            }
        }
        Potential { values, before: [in_row, in_column] }
    }

    /// The potential at a place with its gradient in bins along `axis` and across it, and the gradient across of the
    /// potential's integral along `axis` up to there.
    #[inline(always)]
    pub(crate) fn sample_strip(&self, potential: &Potential, axis: usize, [x, y]: [Along; 2]) -> StripEnd {
        let (value, gradient) = self.sample(potential.values, x, y);
        let k = y.bin * self.side + x.bin;
        let values = &potential.values[k..k + self.side + 2];
        let before = &potential.before[axis][k..k + self.side + 2];
        // To the bin beyond along the axis, and across it.
        let (on, aside, t) = if axis == 0 { (1, self.side, x.part) } else { (self.side, 1, y.part) };
        let upto = |k: usize| before[k] + (0.5 + t - 0.5 * t * t) * values[k] + 0.5 * t * t * values[k + on];
        let across_integral = upto(aside) - upto(0);
        StripEnd { value, along: gradient[axis], across: gradient[1 - axis], across_integral }
    }
}

/// What a strip of light reads at one of its ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StripEnd {
    pub value: f32,
    pub along: f32,
    pub across: f32,
    pub across_integral: f32,
}

impl StripLight {
    /// That of all bands together.
    pub(crate) fn added(bands: &[Self]) -> Self {
        let sum = |part: fn(&Self) -> &[f32]| {
            let parts: Vec<&[f32]> = bands.iter().map(part).collect();
            added(parts.first().map_or(0, |part| part.len()), &parts)
        };
        Self { light: sum(|band| &band.light), differences: [sum(|b| &b.differences[0]), sum(|b| &b.differences[1])] }
    }
}
