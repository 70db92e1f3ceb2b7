//! Lobes about any linear image of the light: Lafortune, Foo, Torrance, Greenberg, "Non-linear approximation of reflectance
//! functions" (SIGGRAPH 1997), f_r = Σ (Cx wi.x wo.x + Cy wi.y wo.y + Cz wi.z wo.z)ⁿ, negative sums as zero.
//!
//! Cx = Cy = -Cz is Phong's lobe, Cz > -Cx leans it toward grazing directions, Cx = Cy > 0 sends light back to the lamp.

use std::sync::Arc;

use glam::DVec3;

use super::Model;
use super::parts::Sum;
use super::phong::{density_about, sample_about};

/// One of the lobes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LafortuneLobe {
    /// Cx, Cy, Cz. Values are (their size)ⁿ high, in 1/sr.
    pub direction: DVec3,
    /// n.
    pub exponent: f64,
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

/// The sum of any number of lobes, at least one.
pub fn lafortune(lobes: Vec<LafortuneLobe>) -> Option<Sum> {
    let model = |lobe| Arc::new(lobe) as Arc<dyn Model>;
    (!lobes.is_empty()).then(|| Sum(lobes.into_iter().map(model).collect()))
}
