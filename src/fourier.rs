//! Two-dimensional Fourier transforms of grids of numbers, on top of rustfft.

use std::sync::Arc;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};

/// A planned transform of `width` × `height` grids.
pub struct Fourier {
    width: usize,
    height: usize,
    /// Along rows and along columns, forward and inverse.
    plans: [[Arc<dyn Fft<f64>>; 2]; 2],
}

impl Fourier {
    /// Plans transforms of row-major grids, `width` numbers a row.
    pub fn new(width: usize, height: usize) -> Self {
        let mut planner = FftPlanner::new();
        let mut both = |n| [planner.plan_fft_forward(n), planner.plan_fft_inverse(n)];
        Self { width, height, plans: [both(width), both(height)] }
    }

    /// Replaces the real grid `values` by itself filtered: every wave (frequency indices i, j) times `gain(i, j)`.
    ///
    /// `gain` must have the symmetry of a real filter, gain(-i, -j) = conj(gain(i, j)); indices run over
    /// 0..width and 0..height, the upper halves being the negative frequencies.
    pub fn filter(&self, values: &mut [f64], gain: impl Fn(usize, usize) -> Complex64 + Sync) {
        let mut waves: Vec<Complex64> = values.iter().map(|&v| Complex64::new(v, 0.0)).collect();
        rows(&mut waves, self.width, &self.plans[0][0]);
        // Columns lie in rows of the transposed grid.
        let mut waves = transposed(&waves, self.width);
        rows(&mut waves, self.height, &self.plans[1][0]);
        let scale = 1.0 / (self.width * self.height) as f64;
        waves.par_chunks_mut(self.height).enumerate().for_each(|(i, column)| {
            for (j, wave) in column.iter_mut().enumerate() {
                *wave *= gain(i, j) * scale;
            }
        });
        rows(&mut waves, self.height, &self.plans[1][1]);
        let mut waves = transposed(&waves, self.height);
        rows(&mut waves, self.width, &self.plans[0][1]);
        for (value, wave) in values.iter_mut().zip(&waves) {
            *value = wave.re;
        }
    }
}

/// The angular frequency, radians a sample, of index `k` of `n`.
pub fn frequency(k: usize, n: usize) -> f64 {
    let signed = if 2 * k <= n { k as f64 } else { k as f64 - n as f64 };
    std::f64::consts::TAU * signed / n as f64
}

fn rows(waves: &mut [Complex64], length: usize, plan: &Arc<dyn Fft<f64>>) {
    // Enough rows a piece that the scratch space is not the work.
    waves.par_chunks_mut(length * 32).for_each(|piece| {
        let mut scratch = vec![Complex64::ZERO; plan.get_inplace_scratch_len()];
        piece.chunks_mut(length).for_each(|row| plan.process_with_scratch(row, &mut scratch));
    });
}

fn transposed(waves: &[Complex64], width: usize) -> Vec<Complex64> {
    let height = waves.len() / width;
    let mut out = vec![Complex64::ZERO; waves.len()];
    out.par_chunks_mut(height * 16).enumerate().for_each(|(band, columns)| {
        for (j, row) in waves.chunks(width).enumerate() {
            for (i, column) in columns.chunks_mut(height).enumerate() {
                column[j] = row[band * 16 + i];
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_by_phase_is_a_shift() {
        // Odd lengths: in even ones the fastest wave has no phase of its own.
        for (w, h) in [(7, 5), (1, 7), (33, 41)] {
            let grid: Vec<f64> = (0..w * h).map(|k| ((k * k) % 17) as f64).collect();
            let mut moved = grid.clone();
            Fourier::new(w, h).filter(&mut moved, |i, j| Complex64::cis(-frequency(i, w) - 2.0 * frequency(j, h)));
            for (k, value) in moved.iter().enumerate() {
                let from = (k % w + w - 1) % w + (k / w + h - 2) % h * w;
                assert!((value - grid[from]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_mean_is_the_wave_of_no_frequency() {
        let mut grid: Vec<f64> = (0..40).map(f64::from).collect();
        Fourier::new(8, 5).filter(&mut grid, |i, j| Complex64::from(f64::from(u8::from(i + j == 0))));
        assert!(grid.iter().all(|v| (v - 19.5).abs() < 1e-9));
    }
}
