//! What a viewer sees of a patch: the light of its written triangles, by their first bounce.
//!
//! Every triangle is a plane of the plate's material, so that what it sends to the viewer is known in closed form; the
//! radiance of a patch is the mean over its triangles, weighted by how large the viewer sees them. Shadows and second bounces
//! are left to the proof.

use glam::{DVec2, DVec3};

use super::plate::Patches;
use crate::brdf::material::Material;
use crate::golden::GOLDEN_ANGLE;
use crate::lamp::on_cap;
use crate::projection::carried_axes;
use crate::relief::height_grid::rises;
use crate::slope::Slope;

/// Directions that stand for a lamp of some size: the golden angle between them, each for the same area of the disc. With a
/// lobe as wide as the lamp 24 of them are right to 1 %.
const LIGHTS: u32 = 24;

/// How far from the half vector a normal still sends light, in standard deviations of the metal's own normals: Beckmann's
/// density is 3e-7 of its peak there.
const REACH: f64 = 5.5;

/// Lamp, metal and viewer.
#[derive(Clone, Debug)]
pub struct Viewer {
    material: Material,
    /// Unit vectors to parts of the lamp of equal light.
    lights: Vec<DVec3>,
    /// Its middle.
    light: DVec3,
    /// Where the viewer's eye is, mm, in the frame of the plate.
    eye: DVec3,
    /// Cosine of the largest angle between a normal and the half vector that still sends light.
    reach: f64,
}

impl Viewer {
    /// A distant lamp toward `light` with an angular radius of `radius` (radians), metal whose normals are spread by
    /// `spread` (standard deviation along each axis, radians) as `material` has them, and an eye at `eye` mm.
    pub fn new(material: Material, spread: f64, light: DVec3, radius: f64, eye: DVec3) -> Self {
        let part = |k: u32| {
            let share = (f64::from(k) + 0.5) / f64::from(LIGHTS);
            on_cap(light, radius, share, f64::from(k) * GOLDEN_ANGLE)
        };
        let lights = if radius > 0.0 { (0..LIGHTS).map(part).collect() } else { vec![light] };
        // A half vector turns by half as much as the light.
        let reach = (REACH * spread + 0.5 * radius).min(1.5).cos();
        Self { material, lights, light, eye, reach }
    }

    /// The direction from a place of the plate to the eye.
    pub fn toward(&self, place: DVec2) -> DVec3 {
        (self.eye - place.extend(0.0)).normalize()
    }

    /// The slope that mirrors the lamp's middle to the eye from a place of the plate.
    pub fn mirroring(&self, place: DVec2) -> Option<Slope> {
        Slope::reflecting(self.light, self.toward(place))
    }

    /// Radiance for a lamp of irradiance 1 across its beam, 1/sr, of a patch with its own `heights` around `place`.
    pub fn radiance(&self, patches: &Patches, heights: &[f32], place: DVec2) -> f64 {
        let (n, step) = (patches.nodes, patches.step());
        let o = self.toward(place);
        let half = (self.light + o).normalize();
        let mut sum = 0.0;
        for k in 0..n * n {
            let at = k / n * (n + 1) + k % n;
            let z = [at, at + 1, at + n + 1, at + n + 2].map(|at| f64::from(heights[at]));
            let [z00, z10, z01, z11] = z;
            let slopes = if rises(z) {
                [(z10 - z00, z11 - z10), (z11 - z01, z01 - z00)]
            } else {
                [(z10 - z00, z01 - z00), (z11 - z01, z11 - z10)]
            };
            for (x, y) in slopes {
                sum += self.of_slope(Slope::new(x / step.x, y / step.y), o, half);
            }
        }
        // Half a square each; the patch as a whole is level.
        sum / (2 * n * n) as f64 / o.z
    }

    /// Radiance toward `o` of a plane of slope `slope`, times the area that is seen of each mm² of the plate below it.
    #[inline]
    fn of_slope(&self, slope: Slope, o: DVec3, half: DVec3) -> f64 {
        let normal = slope.normal();
        if normal.dot(half) < self.reach {
            return 0.0;
        }
        let (x, y) = carried_axes(normal);
        let local = |v: DVec3| DVec3::new(v.dot(x), v.dot(y), v.dot(normal));
        let wi = local(o);
        let light: f64 = self.lights.iter().map(|l| self.material.eval(wi, local(*l))).sum();
        light / self.lights.len() as f64 * wi.z.max(0.0) / normal.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::dimple::{Dimple, PatchLobe, Walls};
    use crate::recipe::Recipe;
    use crate::slope::direction;

    #[test]
    fn a_bowl_is_as_bright_as_its_share_of_its_lobe() {
        let mut recipe = Recipe::default();
        recipe.plate.lobe = 1.5;
        let patches = Patches { count: [1, 1], size: DVec2::ONE, nodes: 24 };
        let walls = Walls { half: DVec2::splat(0.5), steep: 0.3, spare: None };
        let light = direction(f64::to_radians(40.0), 0.0);
        for (theta, radius) in [(40.0, 0.0), (30.0, 0.0), (40.0, f64::to_radians(1.0))] {
            let o = direction(f64::to_radians(theta), std::f64::consts::PI);
            let eye = DVec3::new(0.5, 0.5, 0.0) + 1e6 * o;
            let viewer = Viewer::new(recipe.metal(), f64::to_radians(0.75), light, radius, eye);
            let place = DVec2::splat(0.5);
            let tilt = viewer.mirroring(place).unwrap();
            // A mirror's normals have the density s/A over slopes, s/(A cos⁴) over directions and projected area: light over
            // 4 cos of the viewer.
            let lobe = PatchLobe::round(f64::to_radians(3.0).tan(), tilt);
            for share in [0.1, 0.3, 0.45] {
                let dimple = Dimple::new(walls, &lobe, share);
                let seen = viewer.radiance(&patches, &patches.heights(&dimple), place);
                let known = share / lobe.area() / (4.0 * o.z * tilt.normal().z.powi(4));
                assert!((seen / known - 1.0).abs() < 0.03, "{theta} {radius} {share}: {seen} {known}");
            }
            let dark = viewer.radiance(&patches, &patches.heights(&Dimple::new(walls, &lobe, 0.0)), place);
            assert!(dark < 1e-3, "{dark}");
        }
    }
}
