//! Ashikhmin and Shirley, "An anisotropic Phong BRDF model" (JGT 5(2), 2000): a lobe of the half vector h with exponents along
//! x and y, Schlick's Fresnel, and a diffuse part that takes what the lobe leaves,
//!
//! √((nx + 1)(ny + 1))/(8π) h.z^((nx h.x² + ny h.y²)/(1 - h.z²)) F(wi·h)/((wi·h) max(wi.z, wo.z))
//! + 28 ρd/(23π) (1 - ρs) (1 - (1 - wi.z/2)⁵) (1 - (1 - wo.z/2)⁵).

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{Model, albedo_by_quadrature, even};
use crate::brdf::fresnel::schlick;
use crate::slope::mirror;

/// The lobe, and below it the pigment.
#[derive(Clone, Copy, Debug)]
pub struct AshikhminShirley {
    /// Exponents along x and y.
    pub exponents: [f64; 2],
    /// Reflectance of the lobe straight on, 0 to 1.
    pub specular: f64,
    /// Reflectance of the pigment, 0 to 1.
    pub diffuse: f64,
}

impl AshikhminShirley {
    /// Density of half vectors, 1/sr.
    fn half_density(&self, h: DVec3) -> f64 {
        if h.z <= 0.0 {
            return 0.0;
        }
        let [nx, ny] = self.exponents;
        let across = h.x * h.x + h.y * h.y;
        let exponent = if across > 0.0 { (nx * h.x * h.x + ny * h.y * h.y) / across } else { nx };
        ((nx + 1.0) * (ny + 1.0)).sqrt() / TAU * h.z.powf(exponent)
    }

    fn lobe(&self, wi: DVec3, wo: DVec3) -> f64 {
        let h = (wi + wo).normalize_or(DVec3::Z);
        let cosine = wi.dot(h);
        self.half_density(h) * schlick(cosine, self.specular) / (4.0 * cosine * wi.z.max(wo.z))
    }

    fn pigment(&self, wi: DVec3, wo: DVec3) -> f64 {
        let through = |cosine: f64| 1.0 - (1.0 - 0.5 * cosine).powi(5);
        28.0 * self.diffuse / (23.0 * PI) * (1.0 - self.specular) * through(wi.z) * through(wo.z)
    }

    /// Chance that the lobe is sampled.
    fn lobe_chance(&self) -> f64 {
        if self.diffuse > 0.0 { 0.5 } else { 1.0 }
    }
}

impl Model for AshikhminShirley {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 { 0.0 } else { self.lobe(wi, wo) + self.pigment(wi, wo) }
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        if u[2] >= self.lobe_chance() {
            return even([u[0], u[1]]);
        }
        let [nx, ny] = self.exponents;
        // The azimuth of half vectors, the same in every quarter; then their polar angle.
        let (quarter, within) = ((4.0 * u[0]).floor(), (4.0 * u[0]).fract());
        let phi = (((nx + 1.0) / (ny + 1.0)).sqrt() * (0.5 * PI * within).tan()).atan();
        let phi = match quarter as u32 {
            0 => phi,
            1 => PI - phi,
            2 => PI + phi,
            _ => TAU - phi,
        };
        let (sin, cos) = phi.sin_cos();
        let exponent = nx * cos * cos + ny * sin * sin;
        let z = (1.0 - u[1]).powf(1.0 / (exponent + 1.0));
        let across = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        mirror(wi, DVec3::new(across * cos, across * sin, z))
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        let h = (wi + wo).normalize_or(DVec3::Z);
        let cosine = wi.dot(h);
        let lobe = if cosine > 0.0 { self.half_density(h) / (4.0 * cosine) } else { 0.0 };
        let chance = self.lobe_chance();
        chance * lobe + (1.0 - chance) * wo.z.max(0.0) / PI
    }

    fn albedo(&self, wi: DVec3) -> f64 {
        let lobe = Self { diffuse: 0.0, ..*self };
        // ∫ (1 - (1 - c/2)⁵) c dω = 23π/28: with the other factor, what of the pigment's light leaves.
        let pigment = self.diffuse * (1.0 - self.specular) * (1.0 - (1.0 - 0.5 * wi.z).powi(5));
        albedo_by_quadrature(&lobe, wi) + pigment
    }
}
