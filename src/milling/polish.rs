//! Polish, as what it does to heights: a Gaussian of a stated standard deviation.

use glam::DVec2;
use rayon::prelude::*;

use crate::progress::{Cancelled, Progress};

/// Nodes of a polished surface are so many standard deviations of the polish apart: of waves of two nodes, the shortest
/// that they hold, e^-20 is left.
pub(super) const NODES: f64 = 0.5;

/// What becomes of a surface in a few words, polished by `sigma` mm or not.
pub fn in_words(sigma: Option<f64>) -> String {
    sigma.map_or("not polished".into(), |sigma| format!("polished {:.0} µm", 1e3 * sigma))
}

/// The nodes of a polished surface, both ends of each side included.
pub(super) struct Nodes {
    /// Columns and rows.
    pub(super) count: [usize; 2],
    /// From one to the next, mm.
    pub(super) apart: DVec2,
    /// Standard deviation of the polish, mm.
    sigma: f64,
}

impl Nodes {
    /// Over `size` mm, for a polish of `sigma` mm.
    pub(super) fn new(size: DVec2, sigma: f64) -> Self {
        let squares = (size / (NODES * sigma)).ceil().max(DVec2::ONE);
        Self { count: squares.to_array().map(|n| n as usize + 1), apart: size / squares, sigma }
    }

    /// Heights at the nodes, mm, of a surface that is sampled `every` times from one node to the next along x and along y:
    /// `row` fills a row of samples of the given number.
    pub(super) fn polished(
        &self,
        every: [usize; 2],
        row: impl Fn(usize, &mut [f32]) + Sync,
        progress: &Progress,
    ) -> Result<Vec<f32>, Cancelled> {
        let [columns, rows] = self.count;
        let (width, count) = ((columns - 1) * every[0] + 1, (rows - 1) * every[1] + 1);
        let fine = self.apart / DVec2::from(every.map(|n| n as f64));
        let along = taps(self.sigma / fine.x);
        let mut thin = vec![0.0f32; columns * count];
        thin.par_chunks_mut(columns).enumerate().try_for_each_init(
            || vec![0.0; width],
            |line, (k, out)| {
                progress.check()?;
                if k % 256 == 0 {
                    progress.fraction(k as f64 / count as f64);
                }
                row(k, line);
                thinned(line, &along, every[0], out);
                Ok(())
            },
        )?;
        Ok(down(&thin, columns, &taps(self.sigma / fine.y), every[1]))
    }
}

/// Weights of a Gaussian whose standard deviation is `sigma` samples: of the middle and of those at 1, 2 … on either side,
/// to four standard deviations; their sum over both sides is 1.
pub(crate) fn taps(sigma: f64) -> Vec<f64> {
    let reach = (4.0 * sigma).ceil() as usize;
    let mut taps: Vec<f64> = (0..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
    let sum = 2.0 * taps.iter().sum::<f64>() - taps[0];
    taps.iter_mut().for_each(|tap| *tap /= sum);
    taps
}

/// One line of heights smoothed, of which every `every`-th place is kept, the first and the last with it. Beyond its ends a
/// line goes on turned about them, so that ends keep their height and slope.
fn thinned(line: &[f32], taps: &[f64], every: usize, out: &mut [f32]) {
    let last = line.len() as isize - 1;
    let at = |k: isize| -> f64 {
        let within = |k: isize| f64::from(line[k.clamp(0, last) as usize]);
        if k < 0 {
            2.0 * within(0) - within(-k)
        } else if k > last {
            2.0 * within(last) - within(2 * last - k)
        } else {
            within(k)
        }
    };
    let reach = taps.len() as isize - 1;
    for (n, out) in out.iter_mut().enumerate() {
        let k = (n * every) as isize;
        let sum = if k >= reach && k + reach <= last {
            let k = k as usize;
            let (before, after) = (&line[k + 1 - taps.len()..=k], &line[k..k + taps.len()]);
            let both = before.iter().rev().zip(after).map(|(a, b)| f64::from(a + b));
            both.zip(taps).skip(1).map(|(both, tap)| both * tap).sum::<f64>()
        } else {
            taps.iter().enumerate().skip(1).map(|(j, tap)| tap * (at(k - j as isize) + at(k + j as isize))).sum()
        };
        *out = (taps[0] * at(k) + sum) as f32;
    }
}

/// Columns smoothed, of whose rows every `every`-th is kept.
fn down(rows: &[f32], columns: usize, taps: &[f64], every: usize) -> Vec<f32> {
    let count = rows.len() / columns;
    let kept = (count - 1) / every + 1;
    let mut out = vec![0.0f32; columns * kept];
    out.par_chunks_mut(columns).enumerate().for_each_init(
        || vec![0.0f64; columns],
        |sum, (n, out)| {
            let at = (n * every) as isize;
            sum.fill(0.0);
            for (j, tap) in taps.iter().enumerate() {
                let sides: &[isize] = if j == 0 { &[0] } else { &[-1, 1] };
                for side in sides {
                    add(sum, rows, columns, (at + side * j as isize, count as isize - 1), *tap);
                }
            }
            out.iter_mut().zip(sum.iter()).for_each(|(out, sum)| *out = *sum as f32);
        },
    );
    out
}

/// Adds `weight` times row `k` of rows up to `last`; beyond the first and the last they go on turned about these.
fn add(sum: &mut [f64], rows: &[f32], columns: usize, (k, last): (isize, isize), weight: f64) {
    let row = |k: isize| {
        let begin = k.clamp(0, last) as usize * columns;
        &rows[begin..begin + columns]
    };
    let mut one =
        |k: isize, weight: f64| sum.iter_mut().zip(row(k)).for_each(|(sum, z)| *sum += weight * f64::from(*z));
    if (0..=last).contains(&k) {
        one(k, weight);
    } else {
        let rim = if k < 0 { 0 } else { last };
        one(rim, 2.0 * weight);
        one(2 * rim - k, -weight);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_those_of_a_gaussian() {
        let taps = taps(6.0);
        let variance = 2.0 * taps.iter().enumerate().map(|(k, tap)| (k * k) as f64 * tap).sum::<f64>();
        assert!((variance.sqrt() / 6.0 - 1.0).abs() < 1e-3);
        assert!((2.0 * taps.iter().sum::<f64>() - taps[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn waves_fade_as_their_length_says_and_straight_lines_stay() {
        let (sigma, every) = (5.0, 4);
        let smooth = |line: &[f32]| {
            let mut out = vec![0.0; (line.len() - 1) / every + 1];
            thinned(line, &taps(sigma), every, &mut out);
            out
        };
        let straight: Vec<f32> = (0..101).map(|k| 0.25 + 0.01 * k as f32).collect();
        for (n, z) in smooth(&straight).iter().enumerate() {
            assert!((z - straight[4 * n]).abs() < 1e-6, "{n}");
        }
        let wave = |k: usize| (std::f64::consts::TAU * k as f64 / 40.0).cos();
        let line: Vec<f32> = (0..401).map(|k| wave(k) as f32).collect();
        let gain = (-0.5 * (std::f64::consts::TAU * sigma / 40.0).powi(2)).exp();
        let smoothed = smooth(&line);
        for (n, z) in smoothed.iter().enumerate().skip(8).take(85) {
            assert!((f64::from(*z) - gain * wave(4 * n)).abs() < 3e-4, "{n}");
        }
    }
}
