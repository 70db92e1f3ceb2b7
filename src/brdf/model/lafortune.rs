//! Lobes about any linear image of the light: Lafortune, Foo, Torrance, Greenberg, "Non-linear approximation of reflectance
//! functions" (SIGGRAPH 1997), f_r = Σ (Cx wi.x wo.x + Cy wi.y wo.y + Cz wi.z wo.z)ⁿ, negative sums as zero.
//!
//! Cx = Cy = -Cz is Phong's lobe, Cz > -Cx leans it toward grazing directions, Cx = Cy > 0 sends light back to the lamp.

use glam::DVec3;

use super::phong::{density_about, sample_about};
use super::{Model, albedo_by_quadrature};

/// One of the lobes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LafortuneLobe {
    /// Cx, Cy, Cz. Values are (their size)ⁿ high, in 1/sr.
    pub direction: DVec3,
    /// n.
    pub exponent: f64,
}

/// The sum of any number of lobes.
#[derive(Clone, Debug)]
pub struct Lafortune {
    lobes: Vec<LafortuneLobe>,
}

impl Lafortune {
    /// `lobes`, at least one.
    pub fn new(lobes: Vec<LafortuneLobe>) -> Option<Self> {
        (!lobes.is_empty()).then_some(Self { lobes })
    }
}

impl LafortuneLobe {
    /// Where light from `wi` goes most, of what height.
    fn axis(&self, wi: DVec3) -> DVec3 {
        self.direction * wi
    }
}

impl Model for LafortuneLobe {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        let sum = self.axis(wi).dot(wo);
        if wi.z > 0.0 && wo.z > 0.0 && sum > 0.0 { sum.powf(self.exponent) } else { 0.0 }
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        sample_about(self.axis(wi).normalize_or(DVec3::Z), self.exponent, [u[0], u[1]])
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        density_about(self.axis(wi).normalize_or(DVec3::Z), self.exponent, wo)
    }
}

impl Model for Lafortune {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.lobes.iter().map(|lobe| lobe.value(wi, wo)).sum()
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        // The third number chooses a lobe, all alike.
        let chosen = ((u[2] * self.lobes.len() as f64) as usize).min(self.lobes.len() - 1);
        self.lobes[chosen].sample(wi, u)
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        let sum: f64 = self.lobes.iter().map(|lobe| lobe.density(wi, wo)).sum();
        sum / self.lobes.len() as f64
    }

    fn albedo(&self, wi: DVec3) -> f64 {
        self.lobes.iter().map(|lobe| albedo_by_quadrature(lobe, wi)).sum()
    }
}
