//! Where the light of a slope at a place of the plate lands among the bins of the picture, and how that moves with the
//! slope; in single precision, for the inner loop.
//!
//! With l the direction to the lamp, N = 1 + p² + q² and k = 2 (l_z - p l_x - q l_y)/N the light leaves along
//! o = k (-p, -q, 1) - l, and meets the wall at t (o·u) and t (o·v) from below the place, t being the place's distance
//! from the wall over o·n. ∂k/∂p is 2 o_x/N, ∂k/∂q is 2 o_y/N.

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use crate::lamp::Lamp;
use crate::projection::View;
use crate::raster::{Raster, bilinear_weights};
use crate::scene::{Scene, Screen};
use crate::sculpt::slope_histogram::{Place, SlopeHistogram};
use crate::sculpt::target::SlopeTarget;
use crate::slope::Slope;

/// Degrees without wanted light around the picture, so that light falling there is followed; as for slopes.
const MARGIN: f64 = 4.0;

/// Bins a side at the most.
const MOST_BINS: usize = 1200;

/// Where light lands. All lengths are in bins but that of the lamp and of places, which are in mm.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// The bins, which also know about how many of them a unit of slope is.
    pub bins: SlopeHistogram,
    /// Of a lamp nearby its place, of one endlessly far its direction.
    lamp: [f32; 3],
    is_near: bool,
    /// Square of the lamp's distance from the plate's middle, over l_z there; 1/l_z of one endlessly far.
    unit: f32,
    n: [f32; 3],
    u: [f32; 3],
    v: [f32; 3],
    /// Distance of the middle from the wall, and its place along u and v.
    middle: [f32; 3],
    /// 1 where the place matters, 0 for a picture endlessly far.
    on_wall: f32,
}

/// The light of one slope at one place.
#[derive(Clone, Copy, Debug)]
pub struct Landed {
    /// Where it lands.
    pub at: Place,
    /// Light that a unit of area takes, relative to the flat plate's middle.
    pub mass: f32,
    /// ∂(x, y)/∂p and ∂(x, y)/∂q, bins.
    pub moves: [[f32; 2]; 2],
    /// ∂mass/∂p and ∂mass/∂q.
    pub grows: [f32; 2],
}

/// What is wanted in bins `bin` degrees wide, and where light lands among them. `flux` is the wanted light of the picture's
/// square. `None` if the scene has no image.
pub fn wanted(scene: &Scene, flux: &Raster, mean: Slope, bin: f64) -> Option<(SlopeTarget, Landing)> {
    let view = scene.view()?;
    let per_degree = view.blur_pixels(1f64.to_radians(), 2);
    let extent = 2.0 / per_degree + 2.0 * MARGIN;
    let bin = bin.max(extent / (MOST_BINS - 2) as f64);
    let side = (extent / bin).ceil() as usize + 2;
    let (per_uv, low) = (1.0 / (per_degree * bin), -0.5 * side as f64 * per_degree * bin);
    let pixel = 2.0 / flux.width.min(flux.height) as f64 * per_uv;
    let pieces = (2.0 * pixel).ceil().clamp(1.0, 64.0) as usize;
    let share = 1.0 / (pieces * pieces) as f64;
    let mut light = vec![0.0f64; side * side];
    for (k, value) in flux.values.iter().enumerate().filter(|(_, value)| **value > 0.0) {
        let (column, row) = (k % flux.width * pieces, k / flux.width * pieces);
        for piece in 0..pieces * pieces {
            let (x, y) = (column + piece % pieces, row + piece / pieces);
            let uv = View::pixel_centre(x, y, flux.width * pieces, flux.height * pieces);
            let at = (uv - low) * per_uv;
            let (i, j) = (at.x as usize, at.y as usize);
            let weights = bilinear_weights(at.x - i as f64, at.y - j as f64);
            for (k, weight) in [0, 1, side, side + 1].into_iter().zip(weights) {
                light[j * side + i + k] += value * share * weight;
            }
        }
    }
    let total: f64 = light.iter().sum();
    let wanted = light.par_iter().map(|w| (w / total) as f32).collect();
    let per_slope: DMat2 = scene.jacobian(DVec3::ZERO, mean)? * per_uv;
    let middle = (scene.thrown(DVec3::ZERO, mean)? - low) * per_uv;
    let degrees = DMat2::from_diagonal(DVec2::splat(bin));
    let target = SlopeTarget { side, bin, wanted, per_slope, degrees, middle };
    let landing = Landing::new(scene, &view, SlopeHistogram::new(&target), per_uv, low);
    Some((target, landing))
}

impl Landing {
    fn new(scene: &Scene, view: &View, bins: SlopeHistogram, per_uv: f64, low: f64) -> Self {
        let single = |v: DVec3| v.to_array().map(|v| v as f32);
        let light = scene.light(DVec3::ZERO).direction;
        let (lamp, is_near, unit) = match scene.lamp() {
            Lamp::Ball { middle, .. } => (*middle, true, middle.length_squared() / light.z),
            Lamp::Distant(_) => (light, false, 1.0 / light.z),
        };
        let zero = -low * per_uv;
        let (n, u, v, middle, on_wall) = match scene.screen() {
            Screen::Wall(wall) => {
                let (scale, n) = (per_uv / wall.half, wall.normal());
                let (u, v) = (scale * wall.u, scale * wall.v);
                (n, u, v, [wall.centre.dot(n), zero - wall.centre.dot(u), zero - wall.centre.dot(v)], 1.0)
            }
            Screen::Endless(_) => {
                let n = view.centre();
                // The screen at distance 1 and where its rims are.
                let rim = |uv: DVec2| view.inverse(uv).map_or(DVec3::ZERO, |o| o / o.dot(n) - n);
                let along = |rim: DVec3| per_uv * rim / rim.length_squared();
                (n, along(rim(DVec2::X)), along(rim(DVec2::Y)), [1.0, zero, zero], 0.0)
            }
        };
        let middle = middle.map(|v| v as f32);
        Self {
            bins,
            lamp: single(lamp),
            is_near,
            unit: unit as f32,
            n: single(n),
            u: single(u),
            v: single(v),
            middle,
            on_wall,
        }
    }

    /// Where slope (p, q) at `place`, mm from the plate's middle, sends its light.
    #[inline(always)]
    pub fn land(&self, place: [f32; 3], p: f32, q: f32) -> Landed {
        let dot = |a: &[f32; 3], b: &[f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (l, unit) = if self.is_near {
            let way = [self.lamp[0] - place[0], self.lamp[1] - place[1], self.lamp[2] - place[2]];
            let inverse = 1.0 / dot(&way, &way).sqrt();
            ([way[0] * inverse, way[1] * inverse, way[2] * inverse], self.unit * inverse * inverse)
        } else {
            (self.lamp, self.unit)
        };
        let meets = l[2] - p * l[0] - q * l[1];
        let over = 2.0 / (1.0 + p * p + q * q);
        let k = meets * over;
        let o = [-k * p - l[0], -k * q - l[1], k - l[2]];
        let (on, ou, ov) = (dot(&o, &self.n), dot(&o, &self.u), dot(&o, &self.v));
        let distance = self.middle[0] - self.on_wall * dot(&place, &self.n);
        // What never meets the wall is sent far beyond its rim.
        let t = distance / on.max(1e-6);
        let x = t * ou + self.middle[1] + self.on_wall * dot(&place, &self.u);
        let y = t * ov + self.middle[2] + self.on_wall * dot(&place, &self.v);
        let step = |dk: f32, dp: f32, dq: f32| {
            let d = [-dk * p - dp, -dk * q - dq, dk];
            let (dn, du, dv) = (dot(&d, &self.n), dot(&d, &self.u), dot(&d, &self.v));
            let back = dn / on.max(1e-6);
            [t * (du - ou * back), t * (dv - ov * back)]
        };
        let moves = [step(over * o[0], k, 0.0), step(over * o[1], 0.0, k)];
        Landed { at: Place { x, y }, mass: meets * unit, moves, grows: [-l[0] * unit, -l[1] * unit] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lamp::DistantLamp;
    use crate::slope::direction;

    #[test]
    fn light_lands_where_the_scene_says_and_moves_as_differences_do() {
        let toward = direction(0.7, 1.2);
        let near = Lamp::Ball { middle: 500.0 * toward, radius: 0.0 };
        let far: Lamp = DistantLamp::round(toward, 0.0).into();
        for scene in [
            Scene::across_mirror(near.clone(), 1400.0, -0.5, 350.0),
            Scene::across_mirror(far, 700.0, 0.0, 250.0),
            Scene::endless(near, 0.35),
        ] {
            let flux = Raster::from_fn(32, 32, |x, y| (x + 2 * y) as f64);
            let (target, landing) = wanted(&scene, &flux, Slope::FLAT, 0.25).unwrap();
            let sum: f64 = target.wanted.iter().map(|w| f64::from(*w)).sum();
            assert!((sum - 1.0).abs() < 1e-5 && target.wanted.len() == target.side * target.side);
            let per_uv = 1.0 / (scene.view().unwrap().blur_pixels(1f64.to_radians(), 2) * target.bin);
            for (place, slope) in [
                (DVec3::ZERO, Slope::FLAT),
                (DVec3::new(14.0, -9.0, 0.3), Slope::new(0.1, -0.05)),
                (DVec3::new(-14.0, 3.0, -0.2), Slope::new(-0.06, 0.12)),
            ] {
                let land = |p: f64, q: f64| landing.land(place.to_array().map(|v| v as f32), p as f32, q as f32);
                let Landed { at, mass, moves, grows } = land(slope.p, slope.q);
                let uv = scene.thrown(place, slope).unwrap() * per_uv + 0.5 * target.side as f64;
                assert!((f64::from(at.x) - uv.x).abs() < 2e-3 && (f64::from(at.y) - uv.y).abs() < 2e-3, "{at:?} {uv}");
                assert!((f64::from(mass) / scene.mass(place, slope) - 1.0).abs() < 1e-5);
                let jacobian = scene.jacobian(place, slope).unwrap() * per_uv;
                for (column, moves) in [jacobian.x_axis, jacobian.y_axis].into_iter().zip(moves) {
                    let error = (DVec2::new(moves[0].into(), moves[1].into()) - column).length();
                    assert!(error < 1e-3 * column.length(), "{moves:?} {column}");
                }
                let step = 1e-3;
                let growth = (scene.mass(place, Slope::new(slope.p + step, slope.q)) - scene.mass(place, slope)) / step;
                assert!((f64::from(grows[0]) - growth).abs() < 1e-3 * growth.abs() + 1e-6);
            }
        }
    }
}
