//! Densities of facet normals: what a microfacet model is made of.
//!
//! Each is d(m) per unit of plate and steradian with ∫ d(m) m.z dω = 1, and Smith's shadowing follows from it alone: the facets
//! that a direction v sees, hidden ones included, have the area σ(v) = ∫ d(m) max(0, v·m) dω, and the share of them that no
//! other hides is G₁ = v.z/σ(v). For laws without a closed form σ is integrated once and kept in a table.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use crate::brdf::microfacet::Lobe;
use crate::slope::{direction, polar_angle};

/// A density of normals that can be seen and drawn from.
pub trait Normals: Send + Sync {
    /// d(m), 1/sr, at the unit normal `m`; 0 below.
    fn density(&self, m: DVec3) -> f64;

    /// σ(v): area seen along `v` (above) per unit of plate.
    fn seen_area(&self, v: DVec3) -> f64;

    /// A normal, from two uniform numbers; `wi` is where the light comes from, which a law may make use of or not.
    fn sample(&self, wi: DVec3, u: [f64; 2]) -> DVec3;

    /// Density, 1/sr, of [`sample`](Self::sample).
    fn sampled_density(&self, wi: DVec3, m: DVec3) -> f64;

    /// Smith's G₁: share of the facets facing `v` that no other hides.
    fn smith(&self, v: DVec3) -> f64 {
        if v.z > 0.0 { (v.z / self.seen_area(v)).min(1.0) } else { 0.0 }
    }
}

impl Normals for Lobe {
    fn density(&self, m: DVec3) -> f64 {
        self.d(m)
    }

    fn seen_area(&self, v: DVec3) -> f64 {
        self.seen_area(v)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> DVec3 {
        self.sample(wi, u)
    }

    fn sampled_density(&self, wi: DVec3, m: DVec3) -> f64 {
        self.pdf(wi, m)
    }
}

/// A law of the normals' tilt alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// d ∝ cosⁿ: Blinn, "Models of light reflection for computer synthesized pictures" (SIGGRAPH 1977), after Torrance and
    /// Sparrow. Normalised over projected area it is (n + 2)/(2π) cosⁿ; over solid angle, as a density of half vectors, it
    /// would be (n + 1)/(2π) cosⁿ.
    Power(f64),
    /// d ∝ exp(-(θ/s)²), θ the tilt in radians: Torrance and Sparrow, "Theory for off-specular reflection from roughened
    /// surfaces" (JOSA 57, 1967), whose c is 1/s.
    Gaussian(f64),
    /// d = P(tan²θ)/(π cos⁴θ), P(x) ∝ exp(-(α² + x)/α)/(α² + x)^p: Bagher, Soler, Holzschuch, "Accurate fitting of measured
    /// reflectances using a shifted gamma micro-facet distribution" (EGSR 2012).
    ShiftedGamma {
        /// α.
        alpha: f64,
        /// p.
        power: f64,
    },
}

impl Profile {
    /// d at a tilt, up to a factor.
    fn shape(self, theta: f64) -> f64 {
        match self {
            Self::Power(n) => theta.cos().max(0.0).powf(n),
            Self::Gaussian(s) => (-(theta / s).powi(2)).exp(),
            Self::ShiftedGamma { alpha, power } => {
                let x = theta.tan().powi(2);
                let value = (-x / alpha).exp() * (1.0 + x / (alpha * alpha)).powf(-power);
                if value > 0.0 { value / theta.cos().powi(4) } else { 0.0 }
            }
        }
    }
}

/// Intervals of the tilt, even in its square root: narrow laws and grazing normals are both met.
const TILTS: usize = 2048;
/// Intervals of the polar angle at which σ is kept, and rings that count as one for it: it is known to 1e-4.
const SEEN: usize = 128;
const TOGETHER: usize = 4;

/// A [`Profile`] with its norm, its table of σ and what is needed to draw from it.
#[derive(Clone, Debug)]
pub struct ProfileNormals {
    profile: Profile,
    /// 1/∫ shape cos dω.
    norm: f64,
    /// Share of d cos below the tilt i/[`TILTS`] of the scale.
    below: Vec<f64>,
    seen: Vec<f64>,
}

impl ProfileNormals {
    /// The density of `profile`; its numbers are above 0 (the power of a shifted gamma may be any).
    pub fn new(profile: Profile) -> Self {
        let tilt = |k: f64| FRAC_PI_2 * (k / TILTS as f64).powi(2);
        // Midpoints: polar angle, and area of the ring's facets up to the norm.
        let rings: Vec<(f64, f64)> = (0..TILTS)
            .map(|k| {
                let (low, high) = (tilt(k as f64), tilt((k + 1) as f64));
                let middle = tilt(k as f64 + 0.5);
                // Simpson's rule over the ring.
                let part = |theta: f64| profile.shape(theta) * theta.sin();
                let area = TAU * (high - low) / 6.0 * (part(low) + 4.0 * part(0.5 * (low + high)) + part(high));
                (middle, if area.is_finite() { area } else { 0.0 })
            })
            .collect();
        let mut below = vec![0.0];
        for (theta, area) in &rings {
            below.push(below[below.len() - 1] + area * theta.cos());
        }
        let whole = below[TILTS];
        below.iter_mut().for_each(|share| *share /= whole);
        let wider: Vec<(f64, f64)> = rings
            .chunks(TOGETHER)
            .map(|rings| {
                let area: f64 = rings.iter().map(|(_, area)| area).sum();
                let theta: f64 = rings.iter().map(|(theta, area)| theta * area).sum();
                (if area > 0.0 { theta / area } else { rings[0].0 }, area)
            })
            .collect();
        let seen = (0..=SEEN).map(|k| {
            let v = FRAC_PI_2 * k as f64 / SEEN as f64;
            wider.iter().map(|(theta, area)| area / whole * ring_seen(*theta, v)).sum()
        });
        let seen = seen.collect();
        Self { profile, norm: 1.0 / whole, below, seen }
    }
}

/// Mean over azimuths of max(0, v·m), for a normal tilted by `theta` and a direction at the polar angle `v`.
fn ring_seen(theta: f64, v: f64) -> f64 {
    let (along, across) = (theta.cos() * v.cos(), theta.sin() * v.sin());
    if along >= across {
        return along;
    }
    let edge = (-along / across).clamp(-1.0, 1.0).acos();
    (along * edge + across * edge.sin()) / PI
}

impl Normals for ProfileNormals {
    fn density(&self, m: DVec3) -> f64 {
        if m.z <= 0.0 { 0.0 } else { self.norm * self.profile.shape(polar_angle(m)) }
    }

    fn seen_area(&self, v: DVec3) -> f64 {
        let at = polar_angle(v).clamp(0.0, FRAC_PI_2) / FRAC_PI_2 * SEEN as f64;
        let low = (at as usize).min(SEEN - 1);
        self.seen[low] + (at - low as f64) * (self.seen[low + 1] - self.seen[low])
    }

    fn sample(&self, _: DVec3, u: [f64; 2]) -> DVec3 {
        let ring = self.below.partition_point(|share| *share <= u[0]).clamp(1, TILTS) - 1;
        let (low, high) = (self.below[ring], self.below[ring + 1]);
        let within = if high > low { ((u[0] - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
        // Even in the square of the sine within a ring, as d cos dω is where d does not change.
        let sine2 = |k: usize| (FRAC_PI_2 * (k as f64 / TILTS as f64).powi(2)).sin().powi(2);
        let across2 = sine2(ring) + within * (sine2(ring + 1) - sine2(ring));
        direction(across2.sqrt().min(1.0).asin(), TAU * u[1])
    }

    fn sampled_density(&self, _: DVec3, m: DVec3) -> f64 {
        self.density(m) * m.z
    }
}
