//! The lines of a rectilinear grid along one axis, and which interval a coordinate falls into.

/// Ascending coordinates, mm; neighbours bound an interval.
///
/// Where the lines are evenly spaced (all of them, or all but a rim) the interval is found by arithmetic.
#[derive(Clone, Debug, PartialEq)]
pub struct GridLines {
    at: Vec<f64>,
    /// Where interval 0 would begin if all were as long as the one in the middle.
    origin: f64,
    /// Intervals per mm there.
    density: f64,
}

impl GridLines {
    /// At least two ascending coordinates.
    pub fn new(at: &[f64]) -> Self {
        assert!(at.len() >= 2, "a grid has at least one interval");
        // A rim, if any, is the first and the last interval: the others tell the spacing.
        let (first, last) = if at.len() > 4 { (1, at.len() - 2) } else { (0, at.len() - 1) };
        let density = (last - first) as f64 / (at[last] - at[first]);
        Self { at: at.to_vec(), origin: at[first] - first as f64 / density, density }
    }

    /// Number of intervals.
    pub(crate) fn intervals(&self) -> usize {
        self.at.len() - 1
    }

    /// The line below interval `k`, or above the last.
    #[inline]
    pub fn at(&self, k: usize) -> f64 {
        self.at[k]
    }

    /// First and last line.
    pub fn ends(&self) -> (f64, f64) {
        (self.at[0], self.at[self.at.len() - 1])
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.at.as_slice())
    }

    /// The shortest interval.
    pub fn shortest(&self) -> f64 {
        self.at.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
    }

    /// The interval that holds `x`, a line belonging to the interval above it; the nearest for what lies outside.
    #[inline]
    pub(crate) fn interval(&self, x: f64) -> usize {
        // A cast takes what is negative or no number to 0.
        let guess = (((x - self.origin) * self.density) as usize).min(self.intervals() - 1);
        if self.at[guess] <= x && x < self.at[guess + 1] {
            return guess;
        }
        self.at.partition_point(|&line| line <= x).clamp(1, self.intervals()) - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_coordinate_falls_where_a_search_finds_it() {
        let even: Vec<f64> = (0..=10).map(|k| 0.3 * k as f64).collect();
        let rimmed = [&[-5.0][..], &even, &[9.0]].concat();
        let uneven = [0.0, 0.1, 0.7, 2.0, 2.1, 2.2, 3.0];
        for lines in [&even[..], &rimmed, &uneven, &[0.0, 1.0], &[0.0, 1.0, 5.0]] {
            let axis = GridLines::new(lines);
            let (low, high) = axis.ends();
            for x in lines.iter().copied().chain((-50..150).map(|k| low + (high - low) * k as f64 / 100.0)) {
                let expected = (0..axis.intervals()).rev().find(|&k| lines[k] <= x).unwrap_or(0);
                assert_eq!(axis.interval(x), expected, "{x} in {lines:?}");
            }
            for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!(axis.interval(x) < axis.intervals());
            }
        }
    }
}
