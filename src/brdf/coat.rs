//! Paint: a Lambertian base under a clear dielectric coat, smooth or rough.
//!
//! What the coat does not reflect, T(ω) = 1 − E(ω) with E the coat's own albedo, enters, is scattered by the pigment,
//! part of it is thrown back at the coat from below, and what leaves is spread as T(ωo) cos θo: the coupling of
//! Kelemen & Szirmay-Kalos (Eurographics 2001 short papers), reciprocal, and with a white pigment exactly without
//! loss. The colour inside is deepened by a (1 − Fᵢ)/(1 − a Fᵢ), Fᵢ the diffuse reflectance of the coat from below.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::fresnel::dielectric;
use super::microfacet::Lobe;
use crate::slope::{direction, mirror};

/// Intervals of the table in √cos and, for unequal roughness, in a quarter turn of azimuth.
const RISES: usize = 32;
const TURNS: usize = 8;
/// Sub-intervals a side when the albedo of the lobe at one direction is integrated.
const STRATA: usize = 24;

/// The coat and the pigment under it.
pub(super) struct Coat {
    eta: f64,
    /// Share of the light that enters and leaves again.
    inner: f64,
    /// inner / ∫ T cos dω, so that f = scale T(ωi) T(ωo).
    scale: f64,
    /// Albedo of a rough coat: rows of √cos = i/RISES, one column for equal roughness, else TURNS + 1.
    table: Option<Vec<Vec<f64>>>,
}

impl Coat {
    /// Coat of index `eta` >= 1 over pigment of reflectance `albedo` in [0, 1].
    pub(super) fn new(albedo: f64, eta: f64, lobe: Option<&Lobe>) -> Self {
        let smooth = Self { eta, inner: 0.0, scale: 0.0, table: None };
        // From below, total reflection included, by reciprocity of the crossing: 1 - F = (1 - F outside)/eta².
        let inside = 1.0 - smooth.mean_entered() / (eta * eta);
        let inner = albedo * (1.0 - inside) / (1.0 - albedo * inside);
        let coat = Self { inner, table: lobe.map(|lobe| albedo_table(lobe, eta)), ..smooth };
        let mean = coat.mean_entered();
        Self { scale: if mean > 0.0 { inner / (PI * mean) } else { 0.0 }, ..coat }
    }

    /// Share of the light along `w` that the coat lets in; `w` above the surface.
    pub(super) fn entered(&self, w: DVec3) -> f64 {
        let Some(table) = &self.table else { return 1.0 - dielectric(w.z, self.eta) };
        let (row, t) = cell(w.z.clamp(0.0, 1.0).sqrt() * RISES as f64, RISES);
        let along = |row: &[f64]| {
            if row.len() == 1 {
                return row[0];
            }
            let (column, t) = cell(w.y.abs().atan2(w.x.abs()) / FRAC_PI_2 * TURNS as f64, TURNS);
            row[column] + t * (row[column + 1] - row[column])
        };
        let (low, high) = (along(&table[row]), along(&table[row + 1]));
        1.0 - (low + t * (high - low))
    }

    /// Share of the light along `w` that comes back out of the pigment, all directions together.
    pub(super) fn returned(&self, w: DVec3) -> f64 {
        self.inner * self.entered(w)
    }

    /// The pigment's f_r cos θo, 1/sr; both above the surface.
    pub(super) fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.scale * self.entered(wi) * self.entered(wo) * wo.z
    }

    /// ∫ T cos dω / π.
    fn mean_entered(&self) -> f64 {
        let turns = if self.table.as_ref().is_some_and(|table| table[0].len() > 1) { 4 * TURNS } else { 1 };
        let steps = 2048;
        let mut sum = 0.0;
        for turn in 0..turns {
            let (sin, cos) = ((turn as f64 + 0.5) / turns as f64 * FRAC_PI_2).sin_cos();
            for step in 0..steps {
                // Even in √cos, as the table: 2 cos dcos = 4 r³ dr.
                let r = (step as f64 + 0.5) / steps as f64;
                let z = r * r;
                let across = (1.0 - z * z).sqrt();
                sum += 4.0 * r * z * self.entered(DVec3::new(across * cos, across * sin, z));
            }
        }
        sum / (turns * steps) as f64
    }
}

/// Which of `count` intervals `at` falls in, and where in it.
fn cell(at: f64, count: usize) -> (usize, f64) {
    let index = (at as usize).min(count - 1);
    (index, at - index as f64)
}

/// Albedo of the rough coat alone at the nodes.
fn albedo_table(lobe: &Lobe, eta: f64) -> Vec<Vec<f64>> {
    let (ax, ay) = lobe.alpha();
    let columns = if ax == ay { 1 } else { TURNS + 1 };
    let node = |rise: usize, turn: usize| {
        let z = (rise as f64 / RISES as f64).powi(2).max(1e-6);
        lobe_albedo(lobe, eta, direction(z.acos(), turn as f64 / TURNS as f64 * (TAU / 4.0)))
    };
    (0..=RISES).map(|rise| (0..columns).map(|turn| node(rise, turn)).collect()).collect()
}

/// Share of the light along `wi` that the lobe reflects: the sampler's mean weight over a grid of its two numbers.
fn lobe_albedo(lobe: &Lobe, eta: f64, wi: DVec3) -> f64 {
    let at = |index: usize| (index as f64 + 0.5) / STRATA as f64;
    let mut sum = 0.0;
    for i in 0..STRATA {
        for j in 0..STRATA {
            let m = lobe.sample(wi, [at(i), at(j)]);
            sum += dielectric(wi.dot(m), eta) * lobe.g1(mirror(wi, m));
        }
    }
    sum / (STRATA * STRATA) as f64
}

#[cfg(test)]
mod tests {
    use super::super::microfacet::MicrofacetDistribution;
    use super::*;

    #[test]
    fn the_diffuse_reflectance_of_a_smooth_coat_is_the_published_one() {
        // Outside 0.092, inside 0.596 for an index of 1.5: Judd, J. Res. NBS 29, 329 (1942).
        let coat = Coat::new(1.0, 1.5, None);
        let mean = coat.mean_entered();
        assert!((1.0 - mean - 0.0918).abs() < 2e-4, "{}", 1.0 - mean);
        assert!((1.0 - mean / 2.25 - 0.596).abs() < 1e-3);
    }

    #[test]
    fn white_pigment_returns_all_that_enters() {
        let rough = Lobe::new(MicrofacetDistribution::Ggx, 0.3, 0.1).unwrap();
        for lobe in [None, Some(&rough)] {
            let coat = Coat::new(1.0, 1.5, lobe);
            assert!((coat.inner - 1.0).abs() < 1e-12);
            for w in [DVec3::Z, direction(1.5, 0.3), direction(0.7, -2.0)] {
                assert!((coat.returned(w) - coat.entered(w)).abs() < 1e-12);
                assert!((0.0..=1.0).contains(&coat.entered(w)));
            }
        }
        assert_eq!(Coat::new(0.0, 1.5, None).returned(DVec3::Z), 0.0);
    }
}
