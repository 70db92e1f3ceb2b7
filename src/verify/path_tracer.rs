//! Light that comes back along a ray of sight: a path from the eye, lamp and surroundings looked for at every bounce.

use glam::{DMat3, DVec3};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::brdf::material::Material;
use crate::lamp::Lamp;
use crate::slope::flat_mirror;
use crate::trace::path::frame;
use crate::trace::{Hit, PieceKind, Surface};

/// What a surface is made of and what shines on it.
pub(super) struct PathTracer<'a, S> {
    pub surface: &'a S,
    pub material: &'a Material,
    /// In the frame of the world.
    pub lamp: &'a Lamp,
    /// The lamp's irradiance across its beam where that is said to be 1.
    pub reference: f64,
    /// Radiance of everything around.
    pub ambient: f64,
    pub max_bounces: u32,
}

/// Light of one path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PathLight {
    pub radiance: f64,
    /// What is left of light that wants more bounces.
    pub trapped: f64,
}

impl<S: Surface> PathTracer<'_, S> {
    /// Radiance toward where a ray came from that has met the surface at `hit` along `direction`; `world` takes the
    /// surface's frame to that of the lamp.
    ///
    /// The lamp is looked for both at random points of it and where the material would send light, each weighted by its
    /// share of the two densities (Veach & Guibas, SIGGRAPH 1995, balance heuristic). BRDFs being reciprocal, the path
    /// may as well run from the eye.
    pub fn radiance(
        &self,
        mut hit: Hit<S::Place>,
        mut direction: DVec3,
        world: &DMat3,
        random: &mut Xoshiro256PlusPlus,
    ) -> PathLight {
        let Self { surface, material, lamp, reference, ambient, max_bounces } = self;
        let (smooth, point, endless) = (material.is_smooth(), lamp.is_point(), surface.is_endless());
        let to_local = world.transpose();
        let mut sum = PathLight::default();
        let mut throughput = 1.0;
        for bounce in 0.. {
            if surface.kind(hit.place) == PieceKind::Outer {
                break;
            }
            let axes = frame(surface.normal(hit.place));
            let wi = axes.transpose() * -direction;
            if wi.z <= 0.0 {
                break;
            }
            if bounce == *max_bounces {
                sum.trapped = throughput;
                break;
            }
            // A shape that wears the relief is lit as a whole: its lamp is far away, whatever the place.
            let light = lamp.at(hit.point);
            let irradiance = light.irradiance / reference;
            if !smooth {
                let l = light.sample(random);
                let out = to_local * l;
                let wo = axes.transpose() * out;
                let returned = material.eval(wi, wo);
                let lit = returned > 0.0 && (!endless || out.z > 0.0) && surface.next(&hit, out).is_none();
                if lit {
                    // Radiance is irradiance times the density of the sample, and the density cancels.
                    let weight = if point { 1.0 } else { share(light.density(l), material.pdf(wi, wo)) };
                    sum.radiance += throughput * returned * weight * irradiance;
                }
            }
            let u = [random.random::<f64>(), random.random::<f64>(), random.random::<f64>()];
            let Some((wo, weight)) = material.scatter(wi, u) else { break };
            throughput *= weight;
            direction = (axes * wo).normalize();
            match surface.next(&hit, direction) {
                Some(next) => hit = next,
                None if endless && direction.z <= 0.0 => {
                    sum.trapped = throughput;
                    break;
                }
                None => {
                    let density = light.density(*world * direction);
                    let mirrored = material.lobe().is_none() && wo == flat_mirror(wi);
                    let weight = if density > 0.0 && !mirrored { share(material.pdf(wi, wo), density) } else { 1.0 };
                    sum.radiance += throughput * (ambient + weight * density * irradiance);
                    break;
                }
            }
        }
        sum
    }
}

/// The first's share of two densities.
fn share(own: f64, other: f64) -> f64 {
    if own > 0.0 { own / (own + other) } else { 0.0 }
}
