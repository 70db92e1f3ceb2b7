//! What a surface is made of and how finely it is finished: [`Material`].

use std::f64::consts::{PI, TAU};
use std::fmt;
use std::ops::RangeInclusive;
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::coat::Coat;
use super::fresnel;
use super::metals::Metal;
use super::microfacet::Lobe;
use super::model::Model;
use super::model::named::{Named, NamedError};
use crate::slope::{flat_mirror, mirror};

/// What reflects.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Substance {
    /// Reflects everything at every angle.
    Mirror,
    /// A metal of the table at a wavelength, nm.
    Metal(Metal, f64),
    /// Complex index of refraction `eta` + i `k`.
    Conductor {
        /// Real part, in [`Substance::INDEX`].
        eta: f64,
        /// Imaginary part, in [`Substance::ABSORPTION`].
        k: f64,
    },
    /// Opaque black plastic or glass: what is not reflected is absorbed.
    Dielectric {
        /// Index of refraction, in [`Substance::COAT_INDEX`].
        eta: f64,
    },
    /// Pigment that scatters evenly, under a clear coat.
    Paint {
        /// Reflectance of the pigment, 0 to 1.
        albedo: f64,
        /// Index of refraction of the coat, in [`Substance::COAT_INDEX`].
        eta: f64,
    },
    /// Lambert's law.
    Diffuse {
        /// Share of light reflected, 0 to 1.
        albedo: f64,
    },
    /// An analytic BRDF by name, which has its own finish.
    Model(Named),
}

impl Substance {
    /// What `eta` of a conductor may be.
    pub const INDEX: RangeInclusive<f64> = 1e-3..=100.0;
    /// What `k` of a conductor may be.
    pub const ABSORPTION: RangeInclusive<f64> = 0.0..=100.0;
    /// What the index of a dielectric or of a coat may be: no less than air.
    pub const COAT_INDEX: RangeInclusive<f64> = 1.0..=5.0;
    /// What a share of reflected light may be.
    pub const ALBEDO: RangeInclusive<f64> = 0.0..=1.0;
    /// Wavelength, nm, of a metal named without one: the middle of what the eye sees.
    pub const WAVELENGTH: f64 = 550.0;
    /// Index of refraction of acrylic (PMMA) at that wavelength.
    pub const ACRYLIC: f64 = 1.49;
    /// Index of refraction of a paint's binder where none is given.
    pub const BINDER: f64 = 1.5;

    fn check(&self) -> Result<(), MaterialError> {
        let within = |what: &'static str, value: f64, range: RangeInclusive<f64>| {
            if range.contains(&value) { Ok(()) } else { Err(MaterialError::OutOfRange { what, value, range }) }
        };
        match *self {
            Self::Mirror => Ok(()),
            Self::Model(ref model) => Ok(model.keep_energy()?),
            Self::Metal(_, wavelength) => within("wavelength in nm", wavelength, Metal::WAVELENGTHS),
            Self::Conductor { eta, k } => within("index of refraction", eta, Self::INDEX)
                .and_then(|()| within("absorption k", k, Self::ABSORPTION)),
            Self::Dielectric { eta } => within("index of refraction", eta, Self::COAT_INDEX),
            Self::Paint { albedo, eta } => {
                within("albedo", albedo, Self::ALBEDO)?;
                within("index of refraction", eta, Self::COAT_INDEX)
            }
            Self::Diffuse { albedo } => within("albedo", albedo, Self::ALBEDO),
        }
    }
}

/// A substance and its finish: smooth, or rough as a [`Lobe`] says. Values are checked when it is made.
///
/// In flags and recipes it is a string: `mirror`, `aluminium`, `brass:ggx:0.2`, `gold@650:beckmann:0.1,0.3`, `acrylic`,
/// `dielectric:1.6`, `conductor:1.2,6.9:ggx:0.1`, `paint:0.8`, `paint:0.8,1.6:ggx:0.3`, `diffuse:0.5`, and every
/// [model by name](Named), as `ward:0.1,0.3:0.8`. Parsing and [`Display`](fmt::Display) are inverse.
///
/// ```
/// use facetmill::brdf::material::Material;
/// use facetmill::slope::direction;
///
/// let brass: Material = "brass:ggx:0.2".parse()?;
/// let (wi, wo) = (direction(0.3, 0.0), direction(0.4, 3.0));
/// assert!((brass.eval(wi, wo) / wo.z - brass.eval(wo, wi) / wi.z).abs() < 1e-12); // reciprocal
/// assert_eq!(brass.to_string(), "brass:ggx:0.2");
/// # Ok::<(), facetmill::brdf::material::MaterialError>(())
/// ```
#[derive(Clone, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Material {
    substance: Substance,
    lobe: Option<Lobe>,
    reflection: Reflection,
}

/// The substance with all look-ups done.
#[derive(Clone)]
enum Reflection {
    Full,
    Conductor { eta: f64, k: f64 },
    Dielectric { eta: f64 },
    Coated { eta: f64, coat: Arc<Coat> },
    Diffuse { albedo: f64 },
    Model(Named),
}

impl Material {
    /// The ideal mirror.
    pub const MIRROR: Self = Self { substance: Substance::Mirror, lobe: None, reflection: Reflection::Full };

    /// `substance` with the finish `lobe`, smooth if `None`.
    ///
    /// # Errors
    /// When a value is out of its range, or a lobe is given to [`Substance::Diffuse`], which has no mirror facets.
    pub fn new(substance: Substance, lobe: Option<Lobe>) -> Result<Self, MaterialError> {
        substance.check()?;
        let reflection = match &substance {
            Substance::Model(_) if lobe.is_some() => return Err(MaterialError::RoughModel),
            Substance::Model(model) => Reflection::Model(model.clone()),
            Substance::Mirror => Reflection::Full,
            &Substance::Metal(metal, wavelength) => {
                let (eta, k) = metal.at(wavelength);
                Reflection::Conductor { eta, k }
            }
            &Substance::Conductor { eta, k } => Reflection::Conductor { eta, k },
            &Substance::Dielectric { eta } => Reflection::Dielectric { eta },
            &Substance::Paint { albedo, eta } => {
                Reflection::Coated { eta, coat: Arc::new(Coat::new(albedo, eta, lobe.as_ref())) }
            }
            Substance::Diffuse { .. } if lobe.is_some() => return Err(MaterialError::RoughDiffuse),
            &Substance::Diffuse { albedo } => Reflection::Diffuse { albedo },
        };
        Ok(Self { substance, lobe, reflection })
    }

    /// What reflects.
    pub const fn substance(&self) -> &Substance {
        &self.substance
    }

    /// The finish; `None` is smooth (or, for [`Substance::Diffuse`] and [`Substance::Model`], as those scatter).
    pub const fn lobe(&self) -> Option<&Lobe> {
        self.lobe.as_ref()
    }

    /// Whether it is [`Self::MIRROR`]: light goes one way with weight 1 and no random number is looked at.
    pub const fn is_mirror(&self) -> bool {
        matches!(self.reflection, Reflection::Full) && self.lobe.is_none()
    }

    /// Whether all that it returns leaves in the mirror direction exactly, and no random number is looked at.
    pub const fn is_smooth(&self) -> bool {
        let scatters =
            matches!(self.reflection, Reflection::Coated { .. } | Reflection::Diffuse { .. } | Reflection::Model(_));
        self.lobe.is_none() && !scatters
    }

    /// Mirror share of one smooth facet for light at `cosine` to its normal: Fresnel's, of the coat for paint.
    pub fn facet_share(&self, cosine: f64) -> f64 {
        match self.reflection {
            Reflection::Full => 1.0,
            Reflection::Conductor { eta, k } => fresnel::conductor(cosine, eta, k),
            Reflection::Dielectric { eta } | Reflection::Coated { eta, .. } => fresnel::dielectric(cosine, eta),
            Reflection::Diffuse { .. } | Reflection::Model(_) => 0.0,
        }
    }

    /// Share of the light from `wi` that leaves in the mirror direction exactly; 0 for rough and diffuse surfaces and
    /// from below.
    pub fn smooth_share(&self, wi: DVec3) -> f64 {
        if self.lobe.is_some() || wi.z <= 0.0 { 0.0 } else { self.facet_share(wi.z) }
    }

    /// f_r cos θo, 1/sr, without the exact mirror direction of smooth surfaces; 0 when either direction is below.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let facets = self.lobe.as_ref().map_or(0.0, |lobe| {
            let half = (wi + wo).normalize_or_zero();
            self.facet_share(wi.dot(half)) * lobe.reflected(wi, wo)
        });
        facets
            + match &self.reflection {
                Reflection::Coated { coat, .. } => coat.eval(wi, wo),
                Reflection::Diffuse { albedo } => albedo / PI * wo.z,
                Reflection::Model(model) => model.value(wi, wo) * wo.z,
                Reflection::Full | Reflection::Conductor { .. } | Reflection::Dielectric { .. } => 0.0,
            }
    }

    /// Density, 1/sr, with which [`scatter`](Self::scatter) chooses `wo`, without the exact mirror direction of smooth
    /// surfaces. Its integral is 1 less the chance of `None` and of the mirror direction.
    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        if let Reflection::Model(model) = &self.reflection {
            return model.density(wi, wo);
        }
        let facets = self.facet_chance(wi);
        let rough = self.lobe.as_ref().map_or(0.0, |lobe| facets * lobe.reflected_pdf(wi, wo));
        rough + (1.0 - facets) * wo.z / PI
    }

    /// One random outgoing direction for light from `wi` and its weight, f_r cos θo / density; `None` when the light is
    /// absorbed or would go below the surface. `u` are uniform in [0, 1); a smooth surface without pigment looks at
    /// none of them. The mean weight, `None` as 0, is the albedo.
    pub fn scatter(&self, wi: DVec3, u: [f64; 3]) -> Option<(DVec3, f64)> {
        if wi.z <= 0.0 {
            return None;
        }
        let facets = self.facet_chance(wi);
        let (wo, weight) = if let Reflection::Model(model) = &self.reflection {
            let wo = model.sample(wi, u);
            (wo, self.ratio(wi, wo))
        } else if u[2] < facets {
            match &self.lobe {
                None => (flat_mirror(wi), self.facet_share(wi.z) / facets),
                Some(lobe) => {
                    let m = lobe.sample(wi, [u[0], u[1]]);
                    let wo = mirror(wi, m);
                    // The one weight that a mixture needs the whole of; alone it is F G₁(wo), without any quotient.
                    let weight =
                        if facets < 1.0 { self.ratio(wi, wo) } else { self.facet_share(wi.dot(m)) * lobe.g1(wo) };
                    (wo, weight)
                }
            }
        } else {
            // Even in the disc below the cosine law (Malley).
            let (r, (sin, cos)) = (u[0].sqrt(), (TAU * u[1]).sin_cos());
            let wo = DVec3::new(r * cos, r * sin, (1.0 - u[0]).sqrt());
            (wo, self.ratio(wi, wo))
        };
        (wo.z > 0.0 && weight > 0.0).then_some((wo, weight))
    }

    /// eval / pdf, 0 where nothing goes.
    fn ratio(&self, wi: DVec3, wo: DVec3) -> f64 {
        let pdf = self.pdf(wi, wo);
        if pdf > 0.0 { self.eval(wi, wo) / pdf } else { 0.0 }
    }

    /// Chance that `scatter` mirrors the light at a facet rather than diffusing it: in proportion to what each returns.
    fn facet_chance(&self, wi: DVec3) -> f64 {
        match &self.reflection {
            Reflection::Full | Reflection::Conductor { .. } | Reflection::Dielectric { .. } => 1.0,
            Reflection::Diffuse { .. } | Reflection::Model(_) => 0.0,
            Reflection::Coated { coat, .. } => {
                let (mirrored, diffused) = (1.0 - coat.entered(wi), coat.returned(wi));
                if diffused > 0.0 { (mirrored / (mirrored + diffused)).clamp(0.0, 1.0) } else { 1.0 }
            }
        }
    }
}

impl Default for Material {
    fn default() -> Self {
        Self::MIRROR
    }
}

impl PartialEq for Material {
    fn eq(&self, other: &Self) -> bool {
        self.substance == other.substance && self.lobe == other.lobe
    }
}

impl fmt::Debug for Material {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Material({self})")
    }
}

/// Why there is no such material.
#[derive(Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MaterialError {
    /// The first word names nothing.
    #[error("'{0}' is not a material; known are {known}", known = Material::known())]
    Unknown(String),
    /// A number is missing or there are too many.
    #[error("'{word}' takes {takes}, as in {example}")]
    Numbers {
        /// The part of the text in question.
        word: String,
        /// How many numbers, and which.
        takes: &'static str,
        /// One that would do.
        example: &'static str,
    },
    /// Not a decimal number.
    #[error("'{0}' in a material is not a number; write as in brass:ggx:0.2")]
    NotANumber(String),
    /// Neither GGX nor Beckmann.
    #[error("'{0}' is not a kind of roughness; use ggx or beckmann, as in brass:ggx:0.2")]
    MicrofacetDistribution(String),
    /// Something after the end.
    #[error("'{0}' is one part too many in a material; write as in brass:ggx:0.2")]
    TooMuch(String),
    /// A value that no such substance has.
    #[error("{what} must be {low} to {high}, not {value}", low = range.start(), high = range.end())]
    OutOfRange {
        /// What is out of range.
        what: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        range: RangeInclusive<f64>,
    },
    /// A roughness out of range.
    #[error(transparent)]
    Lobe(#[from] super::microfacet::LobeError),
    /// Diffuse with a lobe.
    #[error("diffuse has no mirror facets to roughen; use paint:ALBEDO:ggx:ALPHA for a lobe over a diffuse base")]
    RoughDiffuse,
    /// A model by name with a lobe.
    #[error("a model such as ward:0.1,0.3 has its own lobe: leave out the second")]
    RoughModel,
    /// No model of that name with these numbers.
    #[error(transparent)]
    Model(#[from] NamedError),
}

#[cfg(test)]
mod tests;
