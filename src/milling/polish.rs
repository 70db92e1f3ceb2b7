//! Polish, as what it does to heights: a Gaussian of a stated standard deviation.

/// Weights of a Gaussian whose standard deviation is `sigma` samples: of the middle and of those at 1, 2 … on either side,
/// to four standard deviations; their sum over both sides is 1.
pub(super) fn taps(sigma: f64) -> Vec<f64> {
    let reach = (4.0 * sigma).ceil() as usize;
    let mut taps: Vec<f64> = (0..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
    let sum = 2.0 * taps.iter().sum::<f64>() - taps[0];
    taps.iter_mut().for_each(|tap| *tap /= sum);
    taps
}

/// One line of heights smoothed, of which every `every`-th place is kept, the first and the last with it. Beyond its ends a
/// line goes on turned about them, so that ends keep their height and slope.
pub(super) fn thinned(line: &[f32], taps: &[f64], every: usize, out: &mut [f32]) {
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
