//! First reliefs, from which the design descends: which one ends best depends on the picture, so that several are tried.

use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::fourier::frequency;

use super::edge_slopes::Lattice;
use super::periodic_filter::PeriodicFilter;

/// A shape to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// A cone in each cell, for shapes in one piece.
    Cone,
    /// Two crossed roofs, for letters.
    Roof,
    /// Random hills, this many to a side of the cell, for photographs.
    Hills(u32),
}

impl Start {
    /// What is worth trying: with few valleys for a cutter, with many hills for a shallow relief.
    ///
    /// Thin shapes end best from a cone, letters from a roof (a letter F reached a total variation of 0.010 so, and 0.029
    /// from hills), photographs from hills. More hills of the same slopes are lower in proportion.
    pub(crate) fn suitable(to_cut: bool, shallow: bool) -> &'static [Self] {
        match (to_cut, shallow) {
            (true, false) => &[Self::Hills(1), Self::Cone, Self::Roof],
            (false, false) => &[Self::Hills(1), Self::Hills(4), Self::Hills(2), Self::Cone, Self::Roof],
            (_, true) => &[Self::Hills(1), Self::Hills(2), Self::Hills(4), Self::Hills(8)],
        }
    }

    /// Heights, mm, whose slopes have about the root mean squares `spread` along x and y.
    pub fn heights(self, lattice: Lattice, spread: DVec2, seed: u64) -> Vec<f32> {
        let n = lattice.n;
        let side = lattice.step * n as f64;
        let at = |k: usize| side * (DVec2::new((k % n) as f64 + 0.5, (k / n) as f64 + 0.5) / n as f64 - 0.5);
        match self {
            // √2 times the spread on the flanks has the spread as its mean square along either axis. The tip is rounded over
            // 0.3 % of the side, since a sharp one would be a point that no descent moves.
            Self::Cone => (0..n * n)
                .map(|k| {
                    let rounding = (0.003 * side * spread).length();
                    (-1.4 * (spread * at(k)).length().hypot(rounding)) as f32
                })
                .collect(),
            Self::Roof => (0..n * n).map(|k| -(spread * at(k).abs()).element_sum() as f32).collect(),
            Self::Hills(hills) => {
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ u64::from(hills));
                let mut unit = || rng.random::<f64>() - 0.5;
                let mut z: Vec<f32> = (0..n * n).map(|_| unit() as f32).collect();
                let filter = PeriodicFilter::new(n);
                // Waves of about as many periods a side as hills are wanted, within a standard deviation of 0.7 periods:
                // narrow enough to count, wide enough not to repeat.
                let gains = filter.gains(|i, j| {
                    let k = frequency(i, n).hypot(frequency(j, n)) * n as f64 / std::f64::consts::TAU;
                    (-(k - f64::from(hills)).powi(2) / (2.0 * 0.7 * 0.7)).exp()
                });
                filter.filter(&mut z, n, &gains);
                let squares = |dx: usize, dy: usize, step: f64| {
                    let change = |k: usize| z[(k / n + dy) % n * n + (k % n + dx) % n] - z[k];
                    let sum: f64 = (0..n * n).map(|k| f64::from(change(k)).powi(2)).sum();
                    sum / (n * n) as f64 / (step * step)
                };
                let slope = (squares(1, 0, lattice.step.x) + squares(0, 1, lattice.step.y)).sqrt();
                let scale = if slope > 0.0 { spread.length() / slope } else { 0.0 };
                z.iter().map(|v| (f64::from(*v) * scale) as f32).collect()
            }
        }
    }
}

impl Serialize for Start {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Cone => serializer.serialize_str("cone"),
            Self::Roof => serializer.serialize_str("roof"),
            Self::Hills(n) => serializer.serialize_str(&format!("hills {n}")),
        }
    }
}

impl<'de> Deserialize<'de> for Start {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let hills = || name.strip_prefix("hills ")?.parse().ok().map(Self::Hills);
        match name.as_str() {
            "cone" => Some(Self::Cone),
            "roof" => Some(Self::Roof),
            _ => hills(),
        }
        .ok_or_else(|| D::Error::custom(format!("no start is called {name:?}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_as_steep_as_asked_and_the_same_every_time() {
        let lattice = Lattice { n: 64, step: DVec2::new(0.2, 0.1) };
        let spread = DVec2::new(0.05, 0.08);
        for start in [Start::Cone, Start::Roof, Start::Hills(2), Start::Hills(4)] {
            let z = start.heights(lattice, spread, 7);
            let steepness = |dx: usize, dy: usize, step: f64| {
                let change = |k: usize| f64::from(z[(k / 64 + dy) % 64 * 64 + (k % 64 + dx) % 64] - z[k]) / step;
                (0..4096).map(|k| change(k).powi(2)).sum::<f64>() / 4096.0
            };
            let slope = (steepness(1, 0, 0.2) + steepness(0, 1, 0.1)).sqrt();
            assert!((slope / spread.length() - 1.0).abs() < 0.25, "{start:?}: {slope}");
            assert_eq!(z, start.heights(lattice, spread, 7));
        }
    }
}
