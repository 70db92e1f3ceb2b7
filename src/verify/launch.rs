//! Rays of a distant lamp, from a jittered grid above the plate.

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::lamp::Lamp;
use super::tally::PARTS;
use crate::trace::Surface;

/// Start points on a horizontal rectangle through which every ray that can meet the optical area passes.
#[derive(Debug)]
pub struct RayGrid<'a> {
    low: DVec2,
    size: DVec2,
    z: f64,
    /// Rays in a row.
    pub columns: usize,
    /// Rows of rays.
    pub rows: usize,
    light: DVec3,
    lamp: &'a Lamp,
}

impl<'a> RayGrid<'a> {
    /// About `rays` rays of `lamp`, whose middle lies toward `light` (unit, light.z > 0).
    pub fn new<S: Surface>(surface: &S, light: DVec3, lamp: &'a Lamp, rays: u64) -> Self {
        let (low, high) = surface.optical_area();
        let (bottom, top) = surface.height_range();
        let lift = 1e-6 * (high - low).length().max(top - bottom);
        let depth = top - bottom + 2.0 * lift;
        let steepest = (light.z.acos() + lamp.reach()).min(f64::to_radians(89.9));
        let (low, high) = if surface.is_endless() {
            (low, high)
        } else if !lamp.is_point() {
            let reach = DVec2::splat(steepest.tan() * depth);
            (low - reach, high + reach)
        } else {
            let shift = light.truncate() / light.z * depth;
            (low.min(low + shift), high.max(high + shift))
        };
        let size = high - low;
        // Square strata, as many rows in each part: parts that differ in rays would pass for scatter where light from
        // other sources is added to theirs.
        let rows = ((rays as f64 * size.y / size.x).sqrt().round() as usize).max(1).next_multiple_of(PARTS);
        let columns = ((rays as f64 / rows as f64).round() as usize).max(1);
        Self { low, size, z: top + lift, columns, rows, light, lamp }
    }

    /// Horizontal area for which a ray stands, mm².
    pub fn share(&self) -> f64 {
        self.size.element_product() / (self.columns * self.rows) as f64
    }

    /// A ray from its own jittered place: origin, direction, and weight beside that of a ray from the lamp's middle.
    #[inline]
    pub fn ray(&self, column: usize, row: usize, random: &mut Xoshiro256PlusPlus) -> (DVec3, DVec3, f64) {
        let (x, y) = (random.random::<f64>(), random.random::<f64>());
        let at = DVec2::new((column as f64 + x) / self.columns as f64, (row as f64 + y) / self.rows as f64);
        let origin = (self.low + self.size * at).extend(self.z);
        if self.lamp.is_point() {
            return (origin, -self.light, 1.0);
        }
        let l = self.lamp.sample(self.light, random);
        let weight = l.z.max(0.0) / self.light.z;
        (origin, -l.with_z(l.z.max(1e-6)).normalize(), weight)
    }
}
