//! Rough lobes: mirror facets too small to trace, as a distribution of normals with Smith's shadowing and masking.
//!
//! α of Beckmann is √2 times the RMS slope along that axis ([`Lobe::beckmann_of_rms`]); GGX has no RMS slope, its tail is
//! too heavy, and α is the slope that half of the area stays below.
//!
//! Facets hidden from the light and from the viewer are taken as independent, G = G₁(wi) G₁(wo), as Mitsuba 3's
//! `roughconductor` does, so that its pictures and ours may be compared pixel by pixel (the height-correlated form is up
//! to a few per cent brighter at grazing directions, and equal where one of them is the normal). G₁ of Beckmann is
//! Smith's exact one; Mitsuba uses a rational fit of it that is off by at most 0.35 %.

use std::f64::consts::{FRAC_2_SQRT_PI, PI};
use std::fmt;
use std::ops::RangeInclusive;

use glam::DVec3;
use thiserror::Error;

use libm::erf;

use super::erf::inverse_erf;

/// 1/√π.
const INV_SQRT_PI: f64 = 0.5 * FRAC_2_SQRT_PI;

/// The law of the facets' slopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MicrofacetDistribution {
    /// Trowbridge-Reitz, with a long tail. Walter et al., EGSR 2007.
    Ggx,
    /// Gaussian slopes. Beckmann & Spizzichino 1963.
    Beckmann,
}

impl MicrofacetDistribution {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Ggx, Self::Beckmann];

    /// Its name in flags and recipes.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ggx => "ggx",
            Self::Beckmann => "beckmann",
        }
    }

    /// The law called `name`, in lower case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.name() == name)
    }
}

/// A rough surface: the law of its slopes and how wide it is along x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    distribution: MicrofacetDistribution,
    alpha_x: f64,
    alpha_y: f64,
}

impl Lobe {
    /// What a roughness may be: below it a surface is a mirror for all purposes of this crate.
    pub const ALPHA: RangeInclusive<f64> = 1e-3..=2.0;

    /// Roughness `alpha_x` along the tangent and `alpha_y` across it, dimensionless slopes.
    ///
    /// # Errors
    /// When a roughness is outside [`Self::ALPHA`].
    pub fn new(distribution: MicrofacetDistribution, alpha_x: f64, alpha_y: f64) -> Result<Self, LobeError> {
        for alpha in [alpha_x, alpha_y] {
            if !Self::ALPHA.contains(&alpha) {
                return Err(LobeError::Roughness(alpha));
            }
        }
        Ok(Self { distribution, alpha_x, alpha_y })
    }

    /// Gaussian slopes of the given RMS along x and along y: α = √2 RMS, since exp(-p²/α²) is a Gaussian of variance α²/2.
    ///
    /// # Errors
    /// When a roughness is outside [`Self::ALPHA`].
    pub fn beckmann_of_rms(slope_x: f64, slope_y: f64) -> Result<Self, LobeError> {
        let root2 = std::f64::consts::SQRT_2;
        Self::new(MicrofacetDistribution::Beckmann, root2 * slope_x, root2 * slope_y)
    }

    /// The law of the slopes.
    pub const fn distribution(&self) -> MicrofacetDistribution {
        self.distribution
    }

    /// Roughness along x and y.
    pub const fn alpha(&self) -> (f64, f64) {
        (self.alpha_x, self.alpha_y)
    }

    /// Facet area per unit of plate and steradian of normals, at the unit normal `m`; ∫ d(m) m.z dω = 1.
    ///
    /// Walter et al., EGSR 2007, eq. 25 (Beckmann) and 33 (GGX), stretched along x and y as in Heitz, JCGT 3(2), 2014.
    pub fn d(&self, m: DVec3) -> f64 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let bent = (m.x / self.alpha_x).powi(2) + (m.y / self.alpha_y).powi(2);
        let area = PI * self.alpha_x * self.alpha_y;
        match self.distribution {
            MicrofacetDistribution::Ggx => 1.0 / (area * (bent + m.z * m.z).powi(2)),
            MicrofacetDistribution::Beckmann => {
                let z2 = m.z * m.z;
                let fall = (-bent / z2).exp();
                if fall > 0.0 { fall / (area * z2 * z2) } else { 0.0 }
            }
        }
    }

    /// Area of the facets that `v` sees, hidden ones included, projected along `v`, per unit of plate:
    /// ∫ d(m) max(0, v·m) dω = v.z (1 + Λ(v)). Finite and above zero down to grazing, where Λ itself is not.
    ///
    /// The cosine over G₁ of Walter et al. 2007, eq. 26 (Beckmann, with the error function) and 34 (GGX).
    pub fn seen_area(&self, v: DVec3) -> f64 {
        let wide2 = (self.alpha_x * v.x).powi(2) + (self.alpha_y * v.y).powi(2);
        match self.distribution {
            MicrofacetDistribution::Ggx => 0.5 * (v.z + (v.z * v.z + wide2).sqrt()),
            MicrofacetDistribution::Beckmann => {
                let wide = wide2.sqrt();
                if wide == 0.0 {
                    return v.z.max(0.0);
                }
                let a = v.z / wide;
                0.5 * (v.z * (1.0 + erf(a)) + wide * INV_SQRT_PI * (-a * a).exp())
            }
        }
    }

    /// Smith's Λ: hidden area over plate area seen along `v`, v.z > 0.
    pub fn lambda(&self, v: DVec3) -> f64 {
        self.seen_area(v) / v.z - 1.0
    }

    /// Smith's G₁: the share of the facets facing `v` that no other facet hides, 0 from below.
    pub fn g1(&self, v: DVec3) -> f64 {
        if v.z <= 0.0 { 0.0 } else { (v.z / self.seen_area(v)).min(1.0) }
    }

    /// Share of facets both lit and seen, the two taken as independent (see the head of this file).
    pub fn g2(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.g1(wi) * self.g1(wo)
    }

    /// Reflected radiance for F = 1 times the outgoing cosine, D G / (4 cos θi), 1/sr; 0 if either is below.
    ///
    /// Walter et al. 2007, eq. 20.
    pub fn reflected(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wo.z <= 0.0 { 0.0 } else { self.reflected_pdf(wi, wo) * self.g1(wo) }
    }

    /// Density, 1/sr, with which mirroring `wi` at [`sampled`](Self::sample) normals goes to `wo`; also below the surface
    /// where asked for. D G₁(wi) / (4 cos θi).
    ///
    /// Heitz & d'Eon, EGSR 2014.
    pub fn reflected_pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        let half = wi + wo;
        if wi.z <= 0.0 || half.z <= 0.0 {
            return 0.0;
        }
        self.d(half.normalize_or_zero()) / (4.0 * self.seen_area(wi))
    }

    /// Density, 1/sr, of the normals that [`sample`](Self::sample) draws: d(m) max(0, wi·m) / seen area.
    pub fn pdf(&self, wi: DVec3, m: DVec3) -> f64 {
        if wi.z <= 0.0 { 0.0 } else { self.d(m) * wi.dot(m).max(0.0) / self.seen_area(wi) }
    }

    /// A facet normal as `wi` (wi.z > 0) sees them, from two uniform numbers in [0, 1).
    ///
    /// Stretched to α = 1 (Heitz & d'Eon 2014), then for GGX the half vector of `wi` and a point of a
    /// spherical cap (Dupuy & Benyoub, HPG 2023), for Beckmann the slope along `wi` by inverting its
    /// distribution (as Jakob, "An improved visible normal sampling routine for the Beckmann distribution", 2014, but
    /// in the slope itself and times the cosine, which stays exact to grazing).
    pub fn sample(&self, wi: DVec3, u: [f64; 2]) -> DVec3 {
        let (ax, ay) = (self.alpha_x, self.alpha_y);
        let v = DVec3::new(ax * wi.x, ay * wi.y, wi.z).normalize();
        match self.distribution {
            MicrofacetDistribution::Ggx => {
                let (sin, cos) = (2.0 * PI * u[0]).sin_cos();
                // Height of the half vector; nearer to zero its sides would be differences of rounding errors.
                let rise = (1.0 - u[1]).max(1e-12) * (1.0 + v.z);
                let z = rise - v.z;
                let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
                DVec3::new(ax * (r * cos + v.x), ay * (r * sin + v.y), rise).normalize()
            }
            MicrofacetDistribution::Beckmann => {
                let across = (v.x * v.x + v.y * v.y).sqrt();
                let (cos, sin) = if across > 0.0 { (v.x / across, v.y / across) } else { (1.0, 0.0) };
                let along = visible_gaussian_slope(v.z, across, u[0]);
                let aside = inverse_erf(2.0 * u[1] - 1.0);
                let (p, q) = (cos * along - sin * aside, sin * along + cos * aside);
                DVec3::new(-ax * p, -ay * q, 1.0).normalize()
            }
        }
    }
}

impl fmt::Display for Lobe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.distribution.name(), self.alpha_x)?;
        if self.alpha_x == self.alpha_y { Ok(()) } else { write!(f, ",{}", self.alpha_y) }
    }
}

/// The slope s at which a share `u` of what is seen at (cos, sin) to the normal is reached, for slopes of density
/// exp(-s²)/√π: the root of C(s) = u C(cot) with C(s) = cos (1 + erf s)/2 + sin exp(-s²)/(2√π), climbing up to s = cot.
fn visible_gaussian_slope(cos: f64, sin: f64, u: f64) -> f64 {
    let seen = |s: f64| 0.5 * (cos * (1.0 + erf(s)) + sin * INV_SQRT_PI * (-s * s).exp());
    let (mut low, mut high) = (-6.0, if cos < 6.0 * sin { cos / sin } else { 6.0 });
    let wanted = u * seen(high);
    let mut s = inverse_erf(2.0 * u - 1.0).min(high - 0.1).max(low);
    for _ in 0..60 {
        let miss = seen(s) - wanted;
        if miss > 0.0 {
            high = s
        } else {
            low = s
        }
        let slope = (cos - sin * s) * INV_SQRT_PI * (-s * s).exp();
        let newton = s - miss / slope;
        // Newton where it stays inside the bracket, else its middle.
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let step = next - s;
        s = next;
        if step.abs() < 1e-12 {
            break;
        }
    }
    s
}

/// Why there is no such lobe.
#[derive(Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LobeError {
    /// Too smooth, too rough, or not a number.
    #[error("a roughness of {0} is outside {low} to {high}; a smoother surface needs no lobe", low = Lobe::ALPHA.start(), high = Lobe::ALPHA.end())]
    Roughness(f64),
}

#[cfg(test)]
mod tests;
