//! One groove of a pass: what is fitted to it, and what a cutter with single teeth leaves at its bottom.

use nalgebra::Vector3;
use rand::RngExt;

use super::least_squares::{LinearFit, linear_fit};
use crate::cutter::Profile;
use crate::milling::random::{normal, stream};

/// A groove is looked at to this share of the way to its neighbours on either side: beyond it they may have cut deeper.
const SHARE: f64 = 0.35;

/// Of that, what is nearer to the middle than this share is left out of the fit: there a worn tip is flat.
const CORE: f64 = 0.3;

/// Parts from the middle to the end in which what the fit leaves is kept.
pub const PARTS: usize = 20;

/// Fewest points on either side of a groove that is read.
const FEWEST: usize = 4;

/// Places along a pass at which a groove is simulated: its variance is then known to 2 %, a fraction of a scan's own error.
const DRAWS: usize = 5000;

/// Points over a simulated groove: one in the middle of each part, on either side.
const POINTS: usize = 2 * PARTS;

/// How many standard deviations a tooth's height is followed.
const DEVIATIONS: f64 = 4.0;

/// Where a groove is looked at, and the shape that it is compared with.
#[derive(Clone, Copy)]
pub struct Window {
    profile: Profile,
    /// To either side of the middle, mm.
    half: f64,
}

/// A fitted groove.
#[derive(Clone, Debug, PartialEq)]
pub struct Groove {
    /// Height of its bottom, as its flanks say it, mm.
    pub bottom: f64,
    /// Where its middle lies beside the place that it was looked for at, mm.
    pub aside: f64,
    /// Its roundness as a multiple of the cutter's own.
    pub roundness: f64,
    /// What the fit leaves in each part from the middle outward, mm, points of that part, and squares of their places (as
    /// shares of the way from the middle to the end): sums of each.
    pub left: [[f64; 3]; PARTS],
    /// How much of the variance of single points is in the bottom's own.
    pub noise_share: f64,
}

/// A curve over the parts, known in their middles, at `place` (a share of the way from the middle to the end).
pub fn at_place(curve: &[f64; PARTS], place: f64) -> f64 {
    let k = (place * PARTS as f64 - 0.5).clamp(0.0, (PARTS - 1) as f64);
    let before = (k as usize).min(PARTS - 2);
    curve[before] + (k - before as f64) * (curve[before + 1] - curve[before])
}

impl Window {
    /// For passes `apart` mm with a cutter of `profile`.
    pub fn new(profile: Profile, apart: f64) -> Self {
        Self { profile, half: SHARE * apart }
    }

    /// To either side of the middle, mm.
    pub fn half(&self) -> f64 {
        self.half
    }

    /// Heights over the middle: level, tilt, and the cutter's own shape.
    fn basis(&self, u: f64) -> Vector3<f64> {
        Vector3::new(1.0, u / self.half, self.profile.underside(u.abs()) / self.profile.underside(self.half))
    }

    /// Fits points (from the groove's middle, height), mm; none if there are too few on either side.
    pub fn fit(&self, points: impl Iterator<Item = [f64; 2]> + Clone) -> Option<Groove> {
        let flanks = || points.clone().filter(|[u, _]| u.abs() <= self.half && u.abs() >= CORE * self.half);
        let mut sides = [0; 2];
        flanks().for_each(|[u, _]| sides[usize::from(u > 0.0)] += 1);
        if sides.iter().any(|side| *side < FEWEST) {
            return None;
        }
        let LinearFit { of: fit, inverse } = linear_fit(flanks().map(|[u, z]| (self.basis(u), z)), 0.0)?;
        let mut left = [[0.0; 3]; PARTS];
        for [u, z] in points.filter(|[u, _]| u.abs() <= self.half) {
            let part = ((u.abs() / self.half * PARTS as f64) as usize).min(PARTS - 1);
            left[part][0] += z - fit.dot(&self.basis(u));
            left[part][1] += 1.0;
            left[part][2] += (u / self.half).powi(2);
        }
        let bend = fit.z / self.profile.underside(self.half);
        // The cutter's shape is a parabola near its tip.
        let radius = self.half * self.half / (2.0 * self.profile.underside(self.half));
        let aside = -fit.y / self.half * radius / bend.max(0.1);
        Some(Groove { bottom: fit.x, aside, roundness: bend, left, noise_share: inverse[(0, 0)] })
    }
}

/// What grooves are like whose teeth scatter.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// Variance of their bottoms, mm².
    pub variance: f64,
    /// Mean roundness.
    pub roundness: f64,
    /// Mean of what the fit leaves in each part, mm.
    pub left: [f64; PARTS],
}

/// A cutter whose teeth cut one after another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Teeth {
    /// From one cut to the next, mm.
    pub feed: f64,
    /// Standard deviation of their heights, mm.
    pub scatter: f64,
    /// Radius of the flat at the tip, mm.
    pub flat: f64,
}

/// Grooves of `teeth` of the cutter that `window` is for, at many places; the same numbers are drawn for all teeth, so that
/// what comes of them changes as evenly as they do.
pub fn simulated(window: &Window, teeth: Teeth) -> Simulated {
    let worn = window.profile.underside(teeth.flat);
    let underside = |r: f64| (window.profile.underside(r) - worn).max(0.0);
    let deep = worn + 2.0 * DEVIATIONS * teeth.scatter;
    let reach = window.profile.radius_at(deep) + teeth.feed;
    let ahead = if teeth.feed > 0.0 { (reach / teeth.feed).ceil().min(200.0) as i64 } else { 0 };
    let place = |k: usize| window.half * ((k as f64 + 0.5) / PARTS as f64 - 1.0);
    let (mut sum, mut squares, mut roundness, mut left) = (0.0, 0.0, 0.0, [[0.0; 2]; PARTS]);
    let mut count = 0.0;
    for draw in 0..DRAWS {
        let mut random = stream(0x9e0f, draw as u64);
        let phase: f64 = random.random::<f64>() - 0.5;
        let mut heights = [f64::INFINITY; POINTS];
        // From the nearest tooth outward: each draws its number in the same place whatever the reach.
        for k in 0..=2 * ahead {
            let tooth = if k % 2 == 0 { k / 2 } else { -(k + 1) / 2 };
            let (along, own) = ((tooth as f64 + phase) * teeth.feed, teeth.scatter * normal(&mut random));
            for (k, height) in heights.iter_mut().enumerate() {
                *height = height.min(own + underside(along.hypot(place(k))));
            }
        }
        let Some(groove) = window.fit(heights.iter().enumerate().map(|(k, z)| [place(k), *z])) else { continue };
        count += 1.0;
        sum += groove.bottom;
        squares += groove.bottom * groove.bottom;
        roundness += groove.roundness;
        for (all, own) in left.iter_mut().zip(&groove.left) {
            all[0] += own[0];
            all[1] += own[1];
        }
    }
    let count = f64::max(count, 1.0);
    let mean = sum / count;
    Simulated {
        variance: (squares / count - mean * mean).max(0.0),
        roundness: roundness / count,
        left: left.map(|[sum, count]| sum / f64::max(count, 1.0)),
    }
}

/// The scatter of teeth that gives bottoms a `variance` (mm²), and by what power it goes with that.
pub fn scatter_of(variance: f64, window: &Window, teeth: Teeth) -> (f64, f64) {
    let of = |scatter: f64| simulated(window, Teeth { scatter, ..teeth }).variance.max(f64::MIN_POSITIVE).ln();
    let wanted = variance.ln();
    let mut at = 0.5 * wanted + 0.5;
    let mut slope = 1.6;
    for _ in 0..5 {
        let (here, there) = (of(at.exp()), of((at + 0.1).exp()));
        slope = ((there - here) / 0.1).clamp(0.5, 4.0);
        let step = (wanted - here) / slope;
        at += step.clamp(-1.0, 1.0);
        if step.abs() < 1e-3 {
            break;
        }
    }
    (at.exp(), 1.0 / slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::Cutter;

    #[test]
    fn a_round_groove_is_fitted_with_its_bottom_middle_and_roundness() {
        let profile = Cutter::ball(0.5).profile();
        let window = Window::new(profile, 0.15);
        let points = (0..200).map(|k| f64::from(k) * 1e-3 - 0.1);
        let groove = window.fit(points.map(|u| [u, 0.02 + profile.underside((u - 2e-4_f64).abs())])).unwrap();
        assert!((groove.bottom - 0.02).abs() < 1e-6 && (groove.aside - 2e-4).abs() < 2e-5, "{groove:?}");
        assert!((groove.roundness - 1.0).abs() < 1e-3);
        assert!(window.fit([[0.03, 0.0]; 9].into_iter()).is_none());
    }

    #[test]
    fn scatter_of_teeth_is_found_from_the_variance_that_it_gives() {
        let window = Window::new(Cutter::ball(0.5).profile(), 0.15);
        let teeth = Teeth { feed: 0.01, scatter: 4e-4, flat: 0.004 };
        let (found, power) = scatter_of(simulated(&window, teeth).variance, &window, teeth);
        assert!((found / 4e-4 - 1.0).abs() < 0.01 && (0.3..1.0).contains(&power), "{found} {power}");
    }
}
