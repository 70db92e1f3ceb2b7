//! Even scattering: Lambert's law, and the rough pigment of Oren and Nayar, "Generalization of Lambert's reflectance model"
//! (SIGGRAPH 1994), V-grooves whose sides are Lambertian and whose slope angles have the standard deviation σ.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Model, even};
use crate::slope::polar_angle;

/// f_r = ρ/π.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    /// ρ, 0 to 1.
    pub albedo: f64,
}

impl Model for Lambert {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z > 0.0 && wo.z > 0.0 { self.albedo / PI } else { 0.0 }
    }

    fn sample(&self, _: DVec3, u: [f64; 3]) -> DVec3 {
        even([u[0], u[1]])
    }

    fn density(&self, _: DVec3, wo: DVec3) -> f64 {
        wo.z.max(0.0) / PI
    }
}

/// Oren and Nayar's rough pigment.
#[derive(Clone, Copy, Debug)]
pub struct OrenNayar {
    /// ρ of the grooves' sides, 0 to 1.
    pub albedo: f64,
    /// σ, radians.
    pub sigma: f64,
    /// The paper's eq. 30 without light between the grooves, in place of its eq. 27 and 28.
    pub qualitative: bool,
}

impl Model for OrenNayar {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let (ti, to) = (polar_angle(wi), polar_angle(wo));
        let (alpha, beta) = (ti.max(to), ti.min(to));
        let across = wi.truncate().length() * wo.truncate().length();
        let cosine = if across > 0.0 { (wi.truncate().dot(wo.truncate()) / across).clamp(-1.0, 1.0) } else { 0.0 };
        let s2 = self.sigma * self.sigma;
        let (c1, wide) = (1.0 - 0.5 * s2 / (s2 + 0.33), s2 / (s2 + 0.09));
        if self.qualitative {
            return self.albedo / PI * (c1 + 0.45 * wide * cosine.max(0.0) * alpha.sin() * beta.tan());
        }
        let back = if cosine >= 0.0 { 0.0 } else { (2.0 * beta / PI).powi(3) };
        let c2 = 0.45 * wide * (alpha.sin() - back);
        let c3 = 0.125 * wide * (4.0 * alpha * beta / (PI * PI)).powi(2);
        let once = c1 + cosine * c2 * beta.tan() + (1.0 - cosine.abs()) * c3 * (0.5 * (alpha + beta)).tan();
        let twice = 0.17 * s2 / (s2 + 0.13) * (1.0 - cosine * (2.0 * beta / PI).powi(2));
        (self.albedo * once + self.albedo * self.albedo * twice) / PI
    }

    fn sample(&self, _: DVec3, u: [f64; 3]) -> DVec3 {
        even([u[0], u[1]])
    }

    fn density(&self, _: DVec3, wo: DVec3) -> f64 {
        wo.z.max(0.0) / PI
    }
}
