//! BRDFs from densities of normals: f_r = d(h) G(wi, wo)/(4 wi.z wo.z), h the half vector, of facets that reflect everything.
//! Fresnel's share is multiplied to it by [`Weakened`](super::parts::Weakened).

use glam::DVec3;

use super::Model;
use super::normals::Normals;
use crate::slope::mirror;

/// Which share of facets is both lit and seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shadowing {
    /// Smith's, light and viewer taken as independent: G₁(wi) G₁(wo).
    Smith,
    /// V-grooves, min(1, 2 h.z wo.z/(wo·h), 2 h.z wi.z/(wo·h)): Torrance and Sparrow 1967; Cook and Torrance, "A reflectance
    /// model for computer graphics" (SIGGRAPH 1981).
    Grooves,
}

/// A density of normals and its shadowing.
#[derive(Clone, Debug)]
pub struct Microfacets<N> {
    /// Where the facets look.
    pub normals: N,
    /// What of them is hidden.
    pub shadowing: Shadowing,
}

impl<N: Normals> Model for Microfacets<N> {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let h = (wi + wo).normalize_or(DVec3::Z);
        let d = self.normals.density(h);
        match self.shadowing {
            Shadowing::Smith => {
                // v.z/G₁ is the seen area, but never less than what G₁ ≤ 1 allows.
                let seen = |v: DVec3| self.normals.seen_area(v).max(v.z);
                d / (4.0 * seen(wi) * seen(wo))
            }
            Shadowing::Grooves => {
                let lit = 2.0 * h.z * wi.z.min(wo.z) / wo.dot(h);
                d * lit.min(1.0) / (4.0 * wi.z * wo.z)
            }
        }
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        mirror(wi, self.normals.sample(wi, [u[0], u[1]]))
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        let h = (wi + wo).normalize_or(DVec3::Z);
        let cosine = wi.dot(h);
        if cosine > 0.0 { self.normals.sampled_density(wi, h) / (4.0 * cosine) } else { 0.0 }
    }
}
