//! Numbers that fill an interval evenly, however many of them are taken.

/// The `k`-th of a sequence in [0, 1): multiples of the golden section, which keep no step with anything.
pub fn golden(k: usize) -> f64 {
    (k as f64 * 0.618_033_988_749_894_9).fract()
}

/// The smaller part of a whole turn cut by the golden section, radians: points turned by it from one to the next, their
/// distances from the middle growing with the root of their number, fill a disc evenly.
pub const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_run_fills_the_interval_evenly() {
        for (first, count) in [(0, 100), (1234, 100), (77, 13)] {
            let mut values: Vec<f64> = (first..first + count).map(golden).collect();
            values.sort_by(f64::total_cmp);
            let gaps = values.windows(2).map(|pair| pair[1] - pair[0]);
            // Gaps have three lengths at the most; the widest is below 2.7 times the mean.
            assert!(gaps.fold(0.0, f64::max) < 2.7 / count as f64);
        }
    }
}
