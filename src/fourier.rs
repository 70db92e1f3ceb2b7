//! Two-dimensional transforms of grids of numbers, into waves or into cosines, on top of rustfft.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};

/// A planned transform of `width` × `height` grids.
pub(crate) struct Fourier {
    rows: Line,
    columns: Line,
}

impl Fourier {
    /// Plans transforms of row-major grids, `width` numbers a row, into waves exp(i(ax + by)): opposite rims are joined.
    ///
    /// The angular frequencies a and b of index k are those of [`frequency`].
    pub fn new(width: usize, height: usize) -> Self {
        Self { rows: Line::waves(width), columns: Line::waves(height) }
    }

    /// The same into cosines cos(a(x + ½)) cos(b(y + ½)): the grid is continued mirrored at every rim.
    ///
    /// The angular frequency of index k of n is πk/n radians a sample.
    pub fn cosines(width: usize, height: usize) -> Self {
        Self { rows: Line::cosines(width), columns: Line::cosines(height) }
    }

    /// The waves (or cosines) that add up to the real grid `values`, of the planned size and not empty: that of
    /// frequency indices (i, j) is number i · height + j, for waves Σ value(x, y) exp(-i(ax + by)).
    pub(crate) fn spectrum(&self, values: &[f64]) -> Vec<Complex64> {
        let mut waves: Vec<Complex64> = values.iter().map(|&v| Complex64::new(v, 0.0)).collect();
        self.rows.forward(&mut waves);
        // Columns lie in rows of the transposed grid.
        let mut waves = transposed(&waves, self.rows.length);
        self.columns.forward(&mut waves);
        waves
    }

    /// Replaces the real grid `values`, of the planned size, by itself filtered: every wave (frequency indices i, j)
    /// times `gain(i, j)`.
    ///
    /// `gain` must be that of a real filter. For waves: gain(-i, -j) = conj(gain(i, j)), where indices run over
    /// 0..width and 0..height, the upper halves being the negative frequencies. For cosines: real.
    pub fn filter(&self, values: &mut [f64], gain: impl Fn(usize, usize) -> Complex64 + Sync) {
        if values.is_empty() {
            return;
        }
        let (width, height) = (self.rows.length, self.columns.length);
        let mut waves = self.spectrum(values);
        let scale = 1.0 / (width * height) as f64;
        in_pieces(&mut waves, height, |i, column| {
            for (j, wave) in column.iter_mut().enumerate() {
                *wave *= gain(i, j) * scale;
            }
        });
        self.columns.inverse(&mut waves);
        let mut waves = transposed(&waves, height);
        self.rows.inverse(&mut waves);
        for (value, wave) in values.iter_mut().zip(&waves) {
            *value = wave.re;
        }
    }
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

/// Transforms of all lines of a grid. Forward and inverse together multiply by the length.
struct Line {
    length: usize,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// For cosines exp(-iπk/2n), which turns the spectrum of the folded line into them; empty for waves.
    twiddles: Vec<Complex64>,
}

impl Line {
    fn waves(length: usize) -> Self {
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        Self { length, forward, inverse, twiddles: Vec::new() }
    }

    fn cosines(length: usize) -> Self {
        let twiddle = |k: usize| Complex64::cis(-PI * k as f64 / (2 * length) as f64);
        Self { twiddles: (0..length).map(twiddle).collect(), ..Self::waves(length) }
    }

    /// Waves or cosines of every line. For cosines the line is folded (even samples ascending, then odd ones
    /// descending), whose spectrum V gives C_k = (t_k V_k + t̄_k V_{n-k})/2 with t = `twiddles` (Makhoul 1980).
    fn forward(&self, lines: &mut [Complex64]) {
        let n = self.length;
        self.each(lines, &self.forward, |line, folded, transform| {
            if self.twiddles.is_empty() {
                return transform(line);
            }
            line.iter().enumerate().for_each(|(x, &value)| folded[fold(x, n)] = value);
            transform(folded);
            for (k, value) in line.iter_mut().enumerate() {
                *value = 0.5 * (self.twiddles[k] * folded[k] + self.twiddles[k].conj() * folded[(n - k) % n]);
            }
        });
    }

    /// Undoes [`forward`](Self::forward) but for the factor n: V_k = t̄_k (C_k - i C_{n-k}), C_n = 0.
    fn inverse(&self, lines: &mut [Complex64]) {
        let n = self.length;
        self.each(lines, &self.inverse, |line, folded, transform| {
            if self.twiddles.is_empty() {
                return transform(line);
            }
            for (k, value) in folded.iter_mut().enumerate() {
                let mirrored = if k == 0 { Complex64::ZERO } else { line[n - k] };
                *value = self.twiddles[k].conj() * (line[k] - Complex64::I * mirrored);
            }
            transform(folded);
            line.iter_mut().enumerate().for_each(|(x, value)| *value = folded[fold(x, n)]);
        });
    }

    /// `work(line, spare line, transform)` for every line.
    fn each(
        &self,
        lines: &mut [Complex64],
        plan: &Arc<dyn Fft<f64>>,
        work: impl Fn(&mut [Complex64], &mut [Complex64], &mut dyn FnMut(&mut [Complex64])) + Sync,
    ) {
        // Enough lines a piece that the scratch space is not the work.
        in_pieces(lines, self.length * 32, |_, piece| {
            let mut scratch = vec![Complex64::ZERO; plan.get_inplace_scratch_len()];
            let mut folded = vec![Complex64::ZERO; self.twiddles.len()];
            let mut transform = |line: &mut [Complex64]| plan.process_with_scratch(line, &mut scratch);
            piece.chunks_mut(self.length).for_each(|line| work(line, &mut folded, &mut transform));
        });
    }
}

/// Where sample x of a line of n goes when it is folded.
const fn fold(x: usize, n: usize) -> usize {
    if x.is_multiple_of(2) { x / 2 } else { n - 1 - x / 2 }
}

/// Lines of `length` become columns.
fn transposed(waves: &[Complex64], length: usize) -> Vec<Complex64> {
    /// Lines of the result that are filled together, so that every piece of memory fetched is used.
    const BAND: usize = 16;
    let lines = waves.len() / length;
    let mut out = vec![Complex64::ZERO; waves.len()];
    in_pieces(&mut out, lines * BAND, |band, columns| {
        for (j, line) in waves.chunks(length).enumerate() {
            for (i, column) in columns.chunks_mut(lines).enumerate() {
                column[j] = line[band * BAND + i];
            }
        }
    });
    out
}

/// Below so many numbers, handing pieces to threads costs more than it saves.
const WORTH_THREADS: usize = 1 << 14;

fn in_pieces(values: &mut [Complex64], size: usize, work: impl Fn(usize, &mut [Complex64]) + Sync) {
    if values.len() < WORTH_THREADS {
        values.chunks_mut(size).enumerate().for_each(|(k, piece)| work(k, piece));
    } else {
        values.par_chunks_mut(size).enumerate().for_each(|(k, piece)| work(k, piece));
    }
}

#[cfg(test)]
mod tests {
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
            Fourier::new(w, h).filter(&mut moved, |i, j| Complex64::cis(-frequency(i, w) - 2.0 * frequency(j, h)));
            for (k, value) in moved.iter().enumerate() {
                let from = (k % w + w - 1) % w + (k / w + h - 2) % h * w;
                assert!((value - grid[from]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_mean_is_the_wave_of_no_frequency() {
        for fourier in [Fourier::new(8, 5), Fourier::cosines(8, 5)] {
            let mut grid: Vec<f64> = (0..40).map(f64::from).collect();
            fourier.filter(&mut grid, |i, j| Complex64::from(f64::from(u8::from(i + j == 0))));
            assert!(grid.iter().all(|v| (v - 19.5).abs() < 1e-9));
        }
    }

    #[test]
    fn each_cosine_has_its_own_gain() {
        for (w, h) in [(6, 5), (1, 4), (9, 1), (160, 120)] {
            let cosine = |k: usize, x: usize, n: usize| (PI * k as f64 * (x as f64 + 0.5) / n as f64).cos();
            let (slow, fast) = ((w / 3, h / 4), (w - 1, h - 1));
            let at = |(i, j): (usize, usize), k: usize| cosine(i, k % w, w) * cosine(j, k / w, h);
            let mut grid: Vec<f64> = (0..w * h).map(|k| 2.0 * at(slow, k) + at(fast, k)).collect();
            Fourier::cosines(w, h).filter(&mut grid, |i, j| Complex64::from(10.0 * i as f64 + j as f64));
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
