//! Filters of real periodic grids in single precision, for the inner loop of the design: a real grid's spectrum has only
//! half as many numbers of its own, and single precision halves their bytes against [`fourier`](crate::fourier).
//!
//! Two rows of real numbers are one row of complex ones; their spectra part again by symmetry, and only the half with
//! frequencies that are not negative along x is kept.

use std::sync::Arc;

use rayon::prelude::*;
use rustfft::num_complex::Complex32;
use rustfft::{Fft, FftPlanner};

use crate::relief::periodic::PeriodicRelief;

use super::edge_slopes::Lattice;

/// Rows of a spectrum that are transposed together: as many as fill a cache line of 64 bytes.
const BAND: usize = 8;

/// A planned filter of `side` × `side` grids whose opposite edges are joined.
pub struct PeriodicFilter {
    side: usize,
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
}

impl PeriodicFilter {
    /// For grids of `side` nodes a side, an even number.
    pub fn new(side: usize) -> Self {
        let mut planner = FftPlanner::new();
        Self { side, forward: planner.plan_fft_forward(side), inverse: planner.plan_fft_inverse(side) }
    }

    /// Nodes a side.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Gains `f(i, j)` laid out for [`filter`](Self::filter), the transforms' own factor included: i counts waves along
    /// a row from 0 to side/2, j those along a column, the upper half being the negative frequencies.
    pub fn gains(&self, f: impl Fn(usize, usize) -> f64 + Sync) -> Vec<f32> {
        let n = self.side;
        let share = 1.0 / (n * n) as f64;
        (0..(n / 2 + 1) * n).into_par_iter().map(|k| (share * f(k / n, k % n)) as f32).collect()
    }

    /// Gains that smooth heights on `lattice` by a Gaussian of standard deviation `sigma` mm.
    pub fn gaussian(&self, lattice: Lattice, sigma: f64) -> Vec<f32> {
        self.gains(|i, j| (-0.5 * (lattice.wave(i, j) * sigma).powi(2)).exp())
    }

    /// Multiplies every wave of `values` by its gain. `values` are rows of `width` numbers, at most `side` of each; the
    /// grid beyond them is taken as zero and what the filter brings there is dropped.
    pub fn filter(&self, values: &mut [f32], width: usize, gains: &[f32]) {
        let (n, half) = (self.side, self.side / 2 + 1);
        let rows = values.len() / width.max(1);
        let mut spectrum = vec![Complex32::ZERO; half * rows.next_multiple_of(2)];
        spectrum.par_chunks_mut(2 * half).zip(values.par_chunks(2 * width)).for_each_init(
            || self.scratch(),
            |(line, scratch), (out, pair)| {
                let (even, odd) = pair.split_at(width.min(pair.len()));
                line.fill(Complex32::ZERO);
                for (k, value) in line.iter_mut().take(width).enumerate() {
                    *value = Complex32::new(even[k], odd.get(k).copied().unwrap_or(0.0));
                }
                self.forward.process_with_scratch(line, scratch);
                let (a, b) = out.split_at_mut(half);
                for k in 0..half {
                    let (c, mirrored) = (line[k], line[(n - k) % n].conj());
                    a[k] = 0.5 * (c + mirrored);
                    b[k] = Complex32::new(0.0, -0.5) * (c - mirrored);
                }
            },
        );
        let rows_held = spectrum.len() / half;
        // Columns in rows, padded to the full side; transformed, weighted and brought back in one go.
        let mut columns = vec![Complex32::ZERO; half * n];
        columns.par_chunks_mut(BAND * n).zip(gains.par_chunks(BAND * n)).enumerate().for_each_init(
            || self.scratch().1,
            |scratch, (band, (columns, gains))| {
                for j in 0..rows_held {
                    let row = &spectrum[j * half + band * BAND..(j + 1) * half];
                    for (column, value) in columns.chunks_mut(n).zip(row) {
                        column[j] = *value;
                    }
                }
                self.forward.process_with_scratch(columns, scratch);
                for (wave, gain) in columns.iter_mut().zip(gains) {
                    *wave *= *gain;
                }
                self.inverse.process_with_scratch(columns, scratch);
            },
        );
        spectrum.par_chunks_mut(BAND * half).enumerate().for_each(|(band, rows)| {
            for (i, column) in columns.chunks(n).enumerate() {
                for (row, value) in rows.chunks_mut(half).zip(&column[band * BAND..]) {
                    row[i] = *value;
                }
            }
        });
        values.par_chunks_mut(2 * width).zip(spectrum.par_chunks(2 * half)).for_each_init(
            || self.scratch(),
            |(line, scratch), (pair, spectra)| {
                let (a, b) = spectra.split_at(half);
                for k in 0..half {
                    let (a, b) = (a[k], Complex32::I * b[k]);
                    line[k] = a + b;
                    if k > 0 && 2 * k < n {
                        line[n - k] = (a - b).conj();
                    }
                }
                self.inverse.process_with_scratch(line, scratch);
                let (even, odd) = pair.split_at_mut(width.min(pair.len()));
                for (k, value) in even.iter_mut().enumerate() {
                    *value = line[k].re;
                }
                for (k, value) in odd.iter_mut().enumerate() {
                    *value = line[k].im;
                }
            },
        );
    }

    fn scratch(&self) -> (Vec<Complex32>, Vec<Complex32>) {
        let needed = self.forward.get_inplace_scratch_len().max(self.inverse.get_inplace_scratch_len());
        (vec![Complex32::ZERO; self.side], vec![Complex32::ZERO; needed])
    }
}

/// Heights of `relief`'s cell smoothed by a Gaussian of standard deviation `sigma` mm, its edges joined.
pub fn smoothed(relief: &PeriodicRelief, sigma: f64) -> Vec<f32> {
    let lattice = Lattice::of(relief);
    let filter = PeriodicFilter::new(lattice.n);
    let mut heights = relief.heights.clone();
    filter.filter(&mut heights, lattice.n, &filter.gaussian(lattice, sigma));
    heights
}

#[cfg(test)]
mod tests {
    use rustfft::num_complex::Complex64;

    use super::*;
    use crate::fourier::{WaveTransform, frequency};

    #[test]
    fn filters_as_the_general_transform_does() {
        for (side, width, rows) in [(8, 8, 8), (10, 7, 5), (6, 4, 6), (40, 40, 33), (2, 2, 2), (4, 1, 1)] {
            let gain = |i: usize, j: usize| {
                let (x, y) = (frequency(i, side), frequency(j, side));
                1.0 / (1.0 + x * x + 0.5 * y * y + 0.3 * x * y)
            };
            let waves = PeriodicFilter::new(side);
            let mut values: Vec<f32> = (0..width * rows).map(|k| ((k * k * 7) % 31) as f32 - 11.0).collect();
            let mut whole = vec![0.0; side * side];
            for (k, v) in values.iter().enumerate() {
                whole[k / width * side + k % width] = f64::from(*v);
            }
            // The wave of half the side has no sign of its own: a real filter must treat both alike.
            let real = |i: usize, j: usize| 0.5 * (gain(i, j) + gain((side - i) % side, (side - j) % side));
            WaveTransform::new(side, side).filter(&mut whole, |i, j| Complex64::from(real(i, j)));
            waves.filter(&mut values, width, &waves.gains(real));
            for (k, v) in values.iter().enumerate() {
                let expected = whole[k / width * side + k % width];
                assert!((f64::from(*v) - expected).abs() < 1e-4, "{side} {k}: {v} {expected}");
            }
        }
    }

    #[test]
    fn a_filter_with_real_gains_is_its_own_transpose_to_rounding() {
        for (side, width, rows) in [(8, 8, 8), (40, 33, 40), (64, 64, 64)] {
            let filter = PeriodicFilter::new(side);
            let gains = filter.gains(|i, j| (-0.1 * (frequency(i, side).powi(2) + frequency(j, side).powi(2))).exp());
            let grid = |turn: f32| -> Vec<f32> { (0..width * rows).map(|k| (k as f32 * turn).sin()).collect() };
            let (x, y) = (grid(1.7), grid(0.9));
            let filtered = |values: &[f32]| {
                let mut values = values.to_vec();
                filter.filter(&mut values, width, &gains);
                values
            };
            let inner = |a: &[f32], b: &[f32]| -> (f64, f64) {
                let products = a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b));
                products.fold((0.0, 0.0), |(sum, size), v| (sum + v, size + v.abs()))
            };
            let ((there, size), (back, _)) = (inner(&filtered(&x), &y), inner(&x, &filtered(&y)));
            assert!((there - back).abs() < 1e-6 * size, "{side}: {there} {back} of {size}");
        }
    }
}
