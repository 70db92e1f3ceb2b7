//! Phong's lobe about the mirrored direction ("Illumination for computer generated pictures", CACM 18(6), 1975), in the form
//! that keeps reciprocity and energy: f_r = ρ (n + 2)/(2π) cosⁿ γ, γ the angle between viewer and mirrored light
//! (Lafortune and Willems, "Using the modified Phong reflectance model for physically based rendering", 1994).

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::Model;
use crate::projection::carried_axes;
use crate::slope::flat_mirror;

/// The normalised lobe with ρ = 1.
#[derive(Clone, Copy, Debug)]
pub struct Phong {
    /// n.
    pub exponent: f64,
}

impl Model for Phong {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let cosine = wo.dot(flat_mirror(wi));
        if cosine > 0.0 { (self.exponent + 2.0) / TAU * cosine.powf(self.exponent) } else { 0.0 }
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        sample_about(flat_mirror(wi), self.exponent, [u[0], u[1]])
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        density_about(flat_mirror(wi), self.exponent, wo)
    }
}

/// A direction about the unit vector `axis` (not straight down), with a density of (n + 1)/(2π) cosⁿ.
pub(super) fn sample_about(axis: DVec3, exponent: f64, u: [f64; 2]) -> DVec3 {
    // (1 - u)^(1/(n + 1)), and what it lacks of 1 without a difference of near numbers.
    let lift = -((-u[0]).ln_1p() / (exponent + 1.0)).exp_m1();
    let (sine, (sin, cos)) = ((lift * (2.0 - lift)).max(0.0).sqrt(), (TAU * u[1]).sin_cos());
    let (e1, e2) = carried_axes(axis);
    DMat3::from_cols(e1, e2, axis) * DVec3::new(sine * cos, sine * sin, 1.0 - lift)
}

/// The density of [`sample_about`].
pub(super) fn density_about(axis: DVec3, exponent: f64, w: DVec3) -> f64 {
    let cosine = w.dot(axis);
    if cosine > 0.0 { (exponent + 1.0) / TAU * cosine.powf(exponent) } else { 0.0 }
}
