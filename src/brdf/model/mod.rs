//! Analytic BRDFs by name: the shelf of reflectance models, each with the same few methods.
//!
//! 1. [`diffuse`] holds even scattering: Lambert, and Oren-Nayar for rough pigment.
//! 2. [`phong`] and [`lafortune`] are lobes about a mirrored direction.
//! 3. [`ward`] and [`ashikhmin_shirley`] are lobes about the half vector, each with a factor of its own.
//! 4. [`normals`] and [`painted`] are densities of normals, by formula or by a table, with Smith's shadowing; [`microfacets`]
//!    makes BRDFs of them.
//! 5. [`parts`] changes and adds models: turned, weakened, summed. [`named`] is their textual form.
//!
//! Values are f_r in 1/sr: reflected radiance over irradiance. A density of normals d is per unit of plate and steradian,
//! ∫ d(m) m.z dω = 1, so that the lecture's ρs/π · F D G/((n·l)(n·v)) with Cook and Torrance's D is ours with 1/4 for 1/π
//! (their D is π times as large, and without the 4 their sum can reflect more light than it gets).

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::golden::golden;

pub mod parts;

pub mod diffuse;

pub mod phong;

pub mod lafortune;

pub mod ward;

pub mod ashikhmin_shirley;

pub mod normals;

pub mod painted;

pub mod microfacets;

mod kinds;

pub mod named;

/// A BRDF without light that leaves in one direction exactly. Directions are unit vectors away from the surface.
pub trait Model: Send + Sync {
    /// f_r, 1/sr, for light from `wi` seen from `wo`; 0 if either is below.
    fn value(&self, wi: DVec3, wo: DVec3) -> f64;

    /// A direction for light from `wi` (above), from numbers uniform in [0, 1); it may lie below the surface.
    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3;

    /// Density, 1/sr, with which [`sample`](Self::sample) draws `wo` above; the rest of 1 goes below.
    fn density(&self, wi: DVec3, wo: DVec3) -> f64;

    /// Share of the light from `wi` that leaves, by quadrature.
    fn albedo(&self, wi: DVec3) -> f64 {
        albedo_by_quadrature(self, wi)
    }
}

/// Cells a side of [`albedo_by_quadrature`].
const STRATA: usize = 48;

/// ∫ f_r cos θo dωo over a grid of the sampler's two first numbers and one of the cosine law's, each point counted as the
/// balance heuristic of Veach and Guibas (SIGGRAPH 1995) has it, so that neither a narrow lobe nor a wide tail is missed.
fn albedo_by_quadrature<M: Model + ?Sized>(model: &M, wi: DVec3) -> f64 {
    let at = |k: usize| (k as f64 + 0.5) / STRATA as f64;
    let mut sum = 0.0;
    for k in 0..STRATA * STRATA {
        let u = [at(k % STRATA), at(k / STRATA)];
        // Whichever part of a sum the third number chooses is met in its turn.
        let third = golden(k);
        for wo in [model.sample(wi, [u[0], u[1], third]), even(u)] {
            if wo.z > 0.0 {
                let density = model.density(wi, wo).max(0.0) + wo.z / PI;
                sum += model.value(wi, wo) * wo.z / density;
            }
        }
    }
    sum / (STRATA * STRATA) as f64
}

/// A direction by the cosine law, from two uniform numbers (Malley: even in the disc below).
fn even(u: [f64; 2]) -> DVec3 {
    let (r, (sin, cos)) = (u[0].sqrt(), (TAU * u[1]).sin_cos());
    DVec3::new(r * cos, r * sin, (1.0 - u[0]).max(0.0).sqrt())
}

/// The greatest albedo over 15 polar angles from 0° to 88° and `turns` azimuths of a half turn, and the polar angle where it
/// is, radians.
pub fn greatest_albedo(model: &dyn Model, turns: usize) -> (f64, f64) {
    let mut greatest = (0.0, 0.0);
    for k in 0..15 {
        let theta = f64::to_radians((6.5 * k as f64).min(88.0));
        for turn in 0..turns {
            let albedo = model.albedo(crate::slope::direction(theta, PI * turn as f64 / turns as f64));
            if albedo > greatest.0 {
                greatest = (albedo, theta);
            }
        }
    }
    greatest
}

#[cfg(test)]
mod tests;
