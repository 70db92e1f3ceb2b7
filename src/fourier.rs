//! Two-dimensional transforms of grids of real numbers, into waves (realfft, rustfft) or into cosines (rustdct).

use std::f64::consts::TAU;
use std::sync::Arc;

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustdct::{DctPlanner, TransformType2And3};
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};

/// A planned transform of `width` × `height` grids into waves exp(i(ax + by)): opposite rims are joined.
pub(crate) struct WaveTransform {
    width: usize,
    height: usize,
    rows: Arc<dyn RealToComplex<f64>>,
    columns: Arc<dyn Fft<f64>>,
    columns_back: Arc<dyn Fft<f64>>,
    rows_back: Arc<dyn ComplexToReal<f64>>,
}

impl WaveTransform {
    /// Plans transforms of row-major grids, `width` numbers a row.
    ///
    /// The angular frequencies a and b of index k are those of [`frequency`].
    pub fn new(width: usize, height: usize) -> Self {
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        Self {
            width,
            height,
            rows: real.plan_fft_forward(width),
            columns: complex.plan_fft_forward(height),
            columns_back: complex.plan_fft_inverse(height),
            rows_back: real.plan_fft_inverse(width),
        }
    }

    /// How many frequencies along x are kept: 0 to half the width. Those of the rest are the conjugates of these, for the
    /// grid is real.
    const fn kept(&self) -> usize {
        self.width / 2 + 1
    }

    /// The waves that add up to the real grid `values`, of the planned size and not empty: that of frequency indices
    /// (i, j), i from 0 to half the width, is number i · height + j, Σ value(x, y) exp(-i(ax + by)).
    pub fn spectrum(&self, values: &[f64]) -> Vec<Complex64> {
        let mut waves = vec![Complex64::ZERO; self.kept() * self.height];
        in_pieces(&mut waves, self.kept() * LINES, |piece, waves| {
            let mut line = self.rows.make_input_vec();
            let mut scratch = self.rows.make_scratch_vec();
            let from = values[piece * LINES * self.width..].chunks(self.width);
            for (values, waves) in from.zip(waves.chunks_mut(self.kept())) {
                line.copy_from_slice(values);
                // Fails for wrong lengths alone, which the plan excludes.
                let _ = self.rows.process_with_scratch(&mut line, waves, &mut scratch);
            }
        });
        // Columns lie in rows of the transposed grid.
        let mut waves = transposed(&waves, self.kept());
        self.each_column(&mut waves, &self.columns);
        waves
    }

    /// Replaces the real grid `values`, of the planned size, by itself filtered: every wave (frequency indices i, j, as in
    /// [`spectrum`](Self::spectrum)) times `gain(i, j)`.
    ///
    /// `gain` must be that of a real filter, gain(-i, -j) = conj(gain(i, j)), for which negative frequencies are not asked.
    pub fn filter(&self, values: &mut [f64], gain: impl Fn(usize, usize) -> Complex64 + Sync) {
        if values.is_empty() {
            return;
        }
        let mut waves = self.spectrum(values);
        let scale = 1.0 / (self.width * self.height) as f64;
        in_pieces(&mut waves, self.height, |i, column| {
            for (j, wave) in column.iter_mut().enumerate() {
                *wave *= gain(i, j) * scale;
            }
        });
        self.each_column(&mut waves, &self.columns_back);
        let waves = transposed(&waves, self.height);
        in_pieces(values, self.width * LINES, |piece, values| {
            let mut line = self.rows_back.make_input_vec();
            let mut scratch = self.rows_back.make_scratch_vec();
            let from = waves[piece * LINES * self.kept()..].chunks(self.kept());
            for (waves, values) in from.zip(values.chunks_mut(self.width)) {
                line.copy_from_slice(waves);
                // The mean and, of even widths, the fastest wave are real but for rounding; realfft asks for zeros.
                line[0].im = 0.0;
                if self.width.is_multiple_of(2) {
                    line[self.width / 2].im = 0.0;
                }
                let _ = self.rows_back.process_with_scratch(&mut line, values, &mut scratch);
            }
        });
    }

    fn each_column(&self, columns: &mut [Complex64], plan: &Arc<dyn Fft<f64>>) {
        in_pieces(columns, self.height * LINES, |_, columns| {
            let mut scratch = vec![Complex64::ZERO; plan.get_inplace_scratch_len()];
            plan.process_with_scratch(columns, &mut scratch);
        });
    }
}

/// A planned transform of `width` × `height` grids into cosines cos(a(x + ½)) cos(b(y + ½)): the grid is continued
/// mirrored at every rim.
pub(crate) struct CosineTransform {
    width: usize,
    height: usize,
    rows: Arc<dyn TransformType2And3<f64>>,
    columns: Arc<dyn TransformType2And3<f64>>,
}

impl CosineTransform {
    /// Plans transforms of row-major grids, `width` numbers a row.
    ///
    /// The angular frequency of index k of n is πk/n radians a sample.
    pub fn new(width: usize, height: usize) -> Self {
        let mut planner = DctPlanner::new();
        Self { width, height, rows: planner.plan_dct2(width), columns: planner.plan_dct2(height) }
    }

    /// Replaces the real grid `values`, of the planned size, by itself filtered: every cosine (frequency indices i, j)
    /// times `gain(i, j)`.
    pub fn filter(&self, values: &mut [f64], gain: impl Fn(usize, usize) -> f64 + Sync) {
        if values.is_empty() {
            return;
        }
        each_line(values, &self.rows, |rows, line, scratch| rows.process_dct2_with_scratch(line, scratch));
        let mut cosines = transposed(values, self.width);
        each_line(&mut cosines, &self.columns, |columns, line, scratch| {
            columns.process_dct2_with_scratch(line, scratch)
        });
        // There and back multiplies by half the length, along x and along y.
        let scale = 4.0 / (self.width * self.height) as f64;
        in_pieces(&mut cosines, self.height, |i, column| {
            for (j, cosine) in column.iter_mut().enumerate() {
                *cosine *= gain(i, j) * scale;
            }
        });
        each_line(&mut cosines, &self.columns, |columns, line, scratch| {
            columns.process_dct3_with_scratch(line, scratch)
        });
        values.copy_from_slice(&transposed(&cosines, self.height));
        each_line(values, &self.rows, |rows, line, scratch| rows.process_dct3_with_scratch(line, scratch));
    }
}

/// `work(plan, line, scratch space)` for every line of `lines`.
fn each_line(
    lines: &mut [f64],
    plan: &Arc<dyn TransformType2And3<f64>>,
    work: impl Fn(&dyn TransformType2And3<f64>, &mut [f64], &mut [f64]) + Sync,
) {
    in_pieces(lines, plan.len() * LINES, |_, piece| {
        let mut scratch = vec![0.0; plan.get_scratch_len()];
        piece.chunks_mut(plan.len()).for_each(|line| work(plan.as_ref(), line, &mut scratch));
    });
}

/// The angular frequency, radians a sample, of wave `k` of `n`.
pub(crate) fn frequency(k: usize, n: usize) -> f64 {
    let signed = if 2 * k <= n { k as f64 } else { k as f64 - n as f64 };
    TAU * signed / n as f64
}

/// The next number from `n` up with no prime factor above 5, for which transforms are fast.
pub(crate) fn smooth_size(n: usize) -> usize {
    let divided = |mut m: usize, prime: usize| {
        while m.is_multiple_of(prime) {
            m /= prime;
        }
        m
    };
    (n.max(1)..).find(|&m| [2, 3, 5].into_iter().fold(m, divided) == 1).unwrap_or(n)
}

/// The next even number from `n` up with no prime factor above 5.
pub(crate) fn even_smooth_size(n: usize) -> usize {
    2 * smooth_size(n.div_ceil(2))
}

/// Lines that share one scratch space: enough that making it is not the work.
const LINES: usize = 32;

/// Lines of `length` become columns.
fn transposed<T: Copy + Default + Send + Sync>(grid: &[T], length: usize) -> Vec<T> {
    /// Lines of the result that are filled together, so that every piece of memory fetched is used.
    const BAND: usize = 16;
    let lines = grid.len() / length;
    let mut out = vec![T::default(); grid.len()];
    in_pieces(&mut out, lines * BAND, |band, columns| {
        for (j, line) in grid.chunks(length).enumerate() {
            for (i, column) in columns.chunks_mut(lines).enumerate() {
                column[j] = line[band * BAND + i];
            }
        }
    });
    out
}

/// Below so many numbers, handing pieces to threads costs more than it saves.
const WORTH_THREADS: usize = 1 << 14;

/// `work(index, piece)` for every piece of `size` values, on several threads where that is worth it.
fn in_pieces<T: Send>(values: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    if values.len() < WORTH_THREADS {
        values.chunks_mut(size).enumerate().for_each(|(k, piece)| work(k, piece));
    } else {
        values.par_chunks_mut(size).enumerate().for_each(|(k, piece)| work(k, piece));
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn sizes_are_smooth() {
        assert_eq!([0, 1, 7, 11, 97, 121, 301].map(smooth_size), [1, 1, 8, 12, 100, 125, 320]);
        assert_eq!([1, 31, 97, 148, 257, 400].map(even_smooth_size), [2, 32, 100, 150, 270, 400]);
    }

    #[test]
    fn a_shift_by_phase_is_a_shift() {
        // Odd lengths: in even ones the fastest wave has no phase of its own. The last is large enough for threads.
        for (w, h) in [(7, 5), (1, 7), (33, 41), (149, 115)] {
            let grid: Vec<f64> = (0..w * h).map(|k| ((k * k) % 17) as f64).collect();
            let mut moved = grid.clone();
            WaveTransform::new(w, h)
                .filter(&mut moved, |i, j| Complex64::cis(-frequency(i, w) - 2.0 * frequency(j, h)));
            for (k, value) in moved.iter().enumerate() {
                let from = (k % w + w - 1) % w + (k / w + h - 2) % h * w;
                assert!((value - grid[from]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_mean_is_the_wave_of_no_frequency() {
        let mean = |i: usize, j: usize| f64::from(u8::from(i + j == 0));
        let grid: Vec<f64> = (0..40).map(f64::from).collect();
        let (mut waves, mut cosines) = (grid.clone(), grid);
        WaveTransform::new(8, 5).filter(&mut waves, |i, j| Complex64::from(mean(i, j)));
        CosineTransform::new(8, 5).filter(&mut cosines, mean);
        assert!(waves.iter().chain(&cosines).all(|v| (v - 19.5).abs() < 1e-9));
    }

    #[test]
    fn each_cosine_has_its_own_gain() {
        for (w, h) in [(6, 5), (1, 4), (9, 1), (160, 120)] {
            let cosine = |k: usize, x: usize, n: usize| (PI * k as f64 * (x as f64 + 0.5) / n as f64).cos();
            let (slow, fast) = ((w / 3, h / 4), (w - 1, h - 1));
            let at = |(i, j): (usize, usize), k: usize| cosine(i, k % w, w) * cosine(j, k / w, h);
            let mut grid: Vec<f64> = (0..w * h).map(|k| 2.0 * at(slow, k) + at(fast, k)).collect();
            CosineTransform::new(w, h).filter(&mut grid, |i, j| 10.0 * i as f64 + j as f64);
            let gain = |(i, j): (usize, usize)| (10 * i + j) as f64;
            for (k, value) in grid.iter().enumerate() {
                let expected = 2.0 * gain(slow) * at(slow, k) + gain(fast) * at(fast, k);
                assert!(
                    (value - expected).abs() < 1e-12 * gain(fast).max(1.0) * 100.0,
                    "{w} x {h}: {value} {expected}"
                );
            }
        }
    }
}
