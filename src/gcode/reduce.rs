//! A sampled track as few straight segments.
//!
//! A track is straight seen from above: heights over the way along it. A segment from one sample to another is allowed if
//! no sample between them is more than the tolerance above or below it; perpendicular to the segment they are nearer still.
//! Of all choices the one with the least cost is taken, exactly, by dynamic programming: a segment costs 1, and one that is
//! shorter than wanted `SHORT_COST` more. So none is short where that can be helped.

/// What a segment shorter than wanted costs beside its 1: on a roof whose kinks are 30 µm apart ten long detours for a short
/// one were still too few to matter, and beyond this nothing changed.
const SHORT_COST: u32 = 16;

/// Most samples that one segment may leave out, which bounds the time: a segment of 2048 steps of 5 µm is 10 mm long.
const LONGEST_REACH: usize = 2048;

/// The samples of `track`, (way, height) with rising ways in mm, at which segments begin and end: the first and the last are
/// among them, every other sample is within `tolerance` mm of the height of its segment, and segments are at least
/// `shortest` mm long as far as the tolerance lets them.
pub fn reduced(track: &[[f64; 2]], tolerance: f64, shortest: f64) -> Vec<usize> {
    if track.len() < 3 {
        return (0..track.len()).collect();
    }
    // Least cost to reach each sample, and from where.
    let mut best = vec![(u32::MAX, 0_u32); track.len()];
    best[0] = (0, 0);
    for from in 0..track.len() - 1 {
        let cost = best[from].0;
        let [x, z] = track[from];
        // Slopes that pass every sample so far.
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for to in from + 1..track.len().min(from + 1 + LONGEST_REACH) {
            let (run, rise) = (track[to][0] - x, track[to][1] - z);
            let slope = rise / run;
            if to == from + 1 || (slope >= low && slope <= high) {
                let whole = cost.saturating_add(if run < shortest { 1 + SHORT_COST } else { 1 });
                if whole < best[to].0 {
                    best[to] = (whole, from as u32);
                }
            }
            low = low.max((rise - tolerance) / run);
            high = high.min((rise + tolerance) / run);
            if low > high {
                break;
            }
        }
    }
    let mut kept = vec![track.len() - 1];
    let mut at = track.len() - 1;
    while at > 0 {
        at = best[at].1 as usize;
        kept.push(at);
    }
    kept.reverse();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(heights: impl Fn(f64) -> f64, length: f64, step: f64) -> Vec<[f64; 2]> {
        let n = (length / step).round() as usize;
        (0..=n).map(|k| k as f64 * step).map(|x| [x, heights(x)]).collect()
    }

    /// Largest distance of a sample from its segment, and the shortest segment.
    fn measured(track: &[[f64; 2]], kept: &[usize]) -> (f64, f64) {
        assert_eq!((kept[0], kept[kept.len() - 1]), (0, track.len() - 1));
        let (mut off, mut shortest) = (0.0_f64, f64::INFINITY);
        for pair in kept.windows(2) {
            let ([x0, z0], [x1, z1]) = (track[pair[0]], track[pair[1]]);
            shortest = shortest.min(x1 - x0);
            for [x, z] in &track[pair[0]..=pair[1]] {
                off = off.max((z0 + (z1 - z0) * (x - x0) / (x1 - x0) - z).abs());
            }
        }
        (off, shortest)
    }

    #[test]
    fn every_sample_is_within_the_tolerance_and_no_segment_is_short_where_that_can_be() {
        // A wave as a relief's, with the kinks that a ball of radius 1 leaves over valleys.
        let wave = |x: f64| 0.02 * (4.0 * x).sin() + 0.003 * (11.0 * x).cos().abs();
        let track = sampled(wave, 10.0, 0.001);
        for tolerance in [1e-5, 1e-4, 1e-3] {
            let kept = reduced(&track, tolerance, 0.025);
            let (off, shortest) = measured(&track, &kept);
            assert!(off <= tolerance * (1.0 + 1e-9), "{off}");
            assert!(tolerance < 1e-4 || shortest >= 0.025 - 1e-12, "{shortest} at {tolerance}");
            // About as few as the law of a curve's chords asks for, w = √(16 t / z''), since errors may be of either sign;
            // ends on the curve itself allow half of that square.
            let bend = |x: f64| (16.0 * 0.02 * (4.0 * x).sin() + 121.0 * 0.003 * (11.0 * x).cos().abs()).abs();
            let law: f64 = track.iter().map(|[x, _]| 0.001 / (8.0 * tolerance / bend(*x).max(1e-3)).sqrt()).sum();
            assert!((kept.len() as f64) < 1.2 * law + 20.0, "{} {law}", kept.len());
        }
    }

    #[test]
    fn a_straight_track_is_one_segment_and_a_roof_two() {
        let flat = sampled(|x| 0.1 * x, 5.0, 0.005);
        assert_eq!(reduced(&flat, 1e-6, 0.025), [0, 1000]);
        let roof = sampled(|x| -(x - 2.0).abs(), 4.0, 0.005);
        assert_eq!(reduced(&roof, 1e-6, 0.025), [0, 400, 800]);
        assert_eq!(reduced(&roof[..2], 1e-6, 0.025), [0, 1]);
        assert_eq!(reduced(&roof[..1], 1e-6, 0.025), [0]);
    }

    #[test]
    fn the_tolerance_goes_before_the_length() {
        // A cap of radius 0.1 mm cannot be followed to 0.1 µm by segments of 25 µm.
        let track = sampled(|x| (0.01 - (x - 0.05).powi(2)).max(0.0).sqrt(), 0.1, 0.001);
        let kept = reduced(&track, 1e-4, 0.025);
        let (off, shortest) = measured(&track, &kept);
        assert!(off <= 1e-4 && shortest < 0.025, "{off} {shortest}");
    }
}
