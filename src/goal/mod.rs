//! A goal that is not drawn: reflectance by name, by measurement or by a map of normals, whose slice at the lamp is the
//! highlight.
//!
//! 1. [`spec`] is how one is asked for: `ward:0.1,0.3`, `merl:gold.binary`, `ndf:star.png`.
//! 2. [`Goal`] is what was asked for, read.
//! 3. `slice` lays it out: as a picture for the design, over the hemisphere for a proof, and how wide a field it needs.

pub mod spec;

mod read;

mod slice;

use std::sync::Arc;

use glam::DVec3;

pub use read::GoalError;
pub use slice::hemisphere_view;
pub(crate) use slice::in_plane;
use spec::{GoalPart, GoalSpec};

use crate::brdf::model::Model;

/// A BRDF as a function of light and viewer, 1/sr.
type Reflectance = Arc<dyn Fn(DVec3, DVec3) -> f64 + Send + Sync>;

/// Reflectance that a plate is to have.
#[derive(Clone)]
pub struct Goal {
    /// How it was asked for.
    pub spec: GoalSpec,
    /// Which part of it is wanted.
    pub part: GoalPart,
    /// What a person should know of how it was read.
    pub notes: Vec<String>,
    /// Whether it looks the same however it is turned.
    pub is_isotropic: bool,
    all: Reflectance,
    wanted: Reflectance,
    /// Light, as seen from the plate, that the design is for.
    light: DVec3,
}

impl Goal {
    /// Reads what `spec` names, for a plate lit from `light`.
    ///
    /// # Errors
    /// A file that cannot be read or holds no reflectance, or nothing left of a goal without its even part.
    pub fn read(spec: &GoalSpec, part: GoalPart, light: DVec3) -> Result<Self, GoalError> {
        let read::Read { all, specular, mut notes, is_isotropic, even } = read::read(spec)?;
        if part == GoalPart::Specular && even > 0.0 {
            let albedo = even * std::f64::consts::PI;
            notes.push(format!("Taken as scattering evenly: {even:.4} 1/sr, an albedo of {albedo:.3}."));
        }
        let wanted = match part {
            GoalPart::All => all.clone(),
            GoalPart::Specular => specular.ok_or_else(|| GoalError::OnlyBase(spec.to_string()))?,
        };
        Ok(Self { spec: spec.clone(), part, notes, is_isotropic, all, wanted, light })
    }

    /// The part that is wanted, f_r in 1/sr.
    pub fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        let value = if wi.z > 0.0 && wo.z > 0.0 { (self.wanted)(wi, wo) } else { 0.0 };
        if value.is_finite() { value.max(0.0) } else { 0.0 }
    }

    /// Toward the light that the design is for.
    pub fn light(&self) -> DVec3 {
        self.light
    }
}

impl std::fmt::Debug for Goal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Goal({}, {:?})", self.spec, self.part)
    }
}

/// A model as a function.
fn of_model(model: impl Model + 'static) -> Reflectance {
    Arc::new(move |wi, wo| model.value(wi, wo))
}

#[cfg(test)]
mod tests;
