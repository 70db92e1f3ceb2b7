//! A rectangle of numbers, row 0 at the top.

use std::ops::{Mul, Sub};

/// Numbers on a grid, row-major, row 0 at the top of the picture (v = +1).
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row-major values, `width * height` of them.
    pub values: Vec<f64>,
}

impl Raster {
    /// All zero.
    pub fn zeros(width: usize, height: usize) -> Self {
        Self { width, height, values: vec![0.0; width * height] }
    }

    /// Value `f(column, row)` everywhere.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> f64) -> Self {
        let values = (0..width * height).map(|i| f(i % width, i / width)).collect();
        Self { width, height, values }
    }

    /// The value at (column, row).
    pub fn at(&self, column: usize, row: usize) -> f64 {
        self.values[row * self.width + column]
    }

    /// Sum of all values.
    pub fn sum(&self) -> f64 {
        self.values.iter().sum()
    }

    /// Largest value (0 for an empty raster).
    pub fn max(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }

    /// Every value times `factor`.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.values.iter_mut().for_each(|v| *v *= factor);
        self
    }

    /// Every value divided by their sum, which must not be zero. Dividing serves sums that have no finite reciprocal.
    pub fn normalised(mut self) -> Self {
        let total = self.sum();
        self.values.iter_mut().for_each(|v| *v /= total);
        self
    }

    /// Resampled to `width` × `height` by areas: the sum of all values does not change.
    pub fn resampled(&self, width: usize, height: usize) -> Self {
        let columns = Overlap::new(self.width, width);
        let rows = Overlap::new(self.height, height);
        let mut wide = Self::zeros(width, self.height);
        for row in 0..self.height {
            let source = &self.values[row * self.width..][..self.width];
            let target = &mut wide.values[row * width..][..width];
            columns.each(|from, to, share| target[to] += source[from] * share);
        }
        let mut out = Self::zeros(width, height);
        rows.each(|from, to, share| {
            let source = &wide.values[from * width..][..width];
            let target = &mut out.values[to * width..][..width];
            for (t, s) in target.iter_mut().zip(source) {
                *t += s * share;
            }
        });
        out
    }
}

/// Weights of the lower left, lower right, upper left and upper right corner of a square for bilinear interpolation at
/// (a, b) in it, each from 0 to 1.
pub fn bilinear_weights<T: Copy + From<u8> + Sub<Output = T> + Mul<Output = T>>(a: T, b: T) -> [T; 4] {
    let one = T::from(1);
    [(one - a) * (one - b), a * (one - b), (one - a) * b, a * b]
}

/// Which share of each of `from` equal intervals falls into each of `to` equal intervals of the same whole.
struct Overlap {
    from: usize,
    to: usize,
}

impl Overlap {
    fn new(from: usize, to: usize) -> Self {
        Self { from, to }
    }

    /// Exact in integers: positions are multiples of 1/(from·to).
    fn each(&self, mut visit: impl FnMut(usize, usize, f64)) {
        let (mut i, mut j, mut at) = (0, 0, 0);
        while i < self.from && j < self.to {
            let (end_i, end_j) = ((i + 1) * self.to, (j + 1) * self.from);
            let end = end_i.min(end_j);
            visit(i, j, (end - at) as f64 / self.to as f64);
            at = end;
            i += usize::from(end == end_i);
            j += usize::from(end == end_j);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resampling_keeps_the_sum_and_the_moments() {
        let a = Raster::from_fn(7, 5, |x, y| (x * x + 3 * y) as f64);
        for (w, h) in [(7, 5), (3, 11), (1, 1), (14, 10), (256, 256)] {
            let b = a.resampled(w, h);
            assert!((a.sum() - b.sum()).abs() < 1e-9 * a.sum());
        }
        let flat = Raster::from_fn(6, 6, |_, _| 1.0).resampled(4, 4);
        assert!(flat.values.iter().all(|v| (v - 2.25).abs() < 1e-12));
        assert_eq!(a.resampled(7, 5), a);
    }
}
