//! A limit on how far a cell rises from its lowest to its highest point, as a penalty that a descent can follow.

/// Half of the part of the allowed depth that costs nothing, as a share of it.
///
/// A descent ends where the penalty's gradient balances the light's, that is a little beyond where it begins: with 0.48 to
/// either side, 4 % before the limit, it ends close to the limit, and within the 2 % beyond that a design is allowed.
const FREE: f64 = 0.48;

/// The penalty costs as much as the whole loss where heights lie this share of the allowed depth beyond the free range, in
/// the root mean square. A firmer wall slows the descent, and a softer one is passed by more than those 2 %.
const FIRMNESS: f64 = 0.03;

/// The range of heights without a penalty, and the price of what lies beyond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthLimit {
    /// mm.
    low: f32,
    /// mm.
    high: f32,
    /// Per mm².
    weight: f64,
}

impl DepthLimit {
    /// Allows `most` mm about the middle of the heights `z`, whose light has the given loss.
    pub fn new(z: &[f32], most: f64, loss: f64) -> Self {
        let (low, high) = range(z);
        let middle = 0.5 * f64::from(low + high);
        let [low, high] = [-FREE, FREE].map(|share| (middle + share * most) as f32);
        Self { low, high, weight: loss / ((FIRMNESS * most).powi(2) * z.len() as f64) }
    }

    /// The penalty of heights `z`; adds its gradient, per mm, to `gradient`.
    pub fn penalty(&self, z: &[f32], gradient: &mut [f32]) -> f64 {
        let mut penalty = 0.0;
        for (slope, z) in gradient.iter_mut().zip(z) {
            let beyond = z - z.clamp(self.low, self.high);
            penalty += self.weight * f64::from(beyond).powi(2);
            *slope += 2.0 * self.weight as f32 * beyond;
        }
        penalty
    }
}

/// How much deeper than `most` mm heights `z` are, as a share of it.
pub(crate) fn excess_depth(z: &[f32], most: f64) -> f64 {
    let (low, high) = range(z);
    (f64::from(high - low) / most - 1.0).max(0.0)
}

/// Lowest and highest of `z`.
fn range(z: &[f32]) -> (f32, f32) {
    z.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |r, v| (r.0.min(*v), r.1.max(*v)))
}
