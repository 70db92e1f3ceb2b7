//! Rays of a lamp, from a jittered grid above the plate.

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::tally::PARTS;
use crate::lamp::Lamp;
use crate::trace::Surface;

/// The steepest light, radians from the plate's normal, for which the grid is widened: its tangent must stay finite.
const STEEPEST: f64 = f64::to_radians(89.9);

/// The least climb of a ray against its way; light from below the horizon weighs nothing but must go down all the same.
const LEAST_CLIMB: f64 = 1e-6;

/// Start points on a horizontal rectangle through which every ray that can meet the optical area passes.
#[derive(Debug)]
pub(crate) struct RayGrid<'a> {
    low: DVec2,
    size: DVec2,
    z: f64,
    /// Rays in a row.
    pub columns: usize,
    /// Rows of rays.
    pub rows: usize,
    lamp: &'a Lamp,
    /// Irradiance on a horizontal mm² at the plate's middle, as the lamp counts it.
    reference: f64,
}

impl<'a> RayGrid<'a> {
    /// About `rays` rays of `lamp`, which lies wholly above the surface.
    pub fn new<S: Surface>(surface: &S, lamp: &'a Lamp, rays: u64) -> Self {
        let (low, high) = surface.optical_area();
        let (bottom, top) = surface.height_range();
        let lift = 1e-6 * (high - low).length().max(top - bottom);
        let depth = top - bottom + 2.0 * lift;
        let (low, high) = if surface.is_endless() {
            (low, high)
        } else if let Some(light) = lamp.only_direction() {
            let shift = light.truncate() / light.z * depth;
            (low.min(low + shift), high.max(high + shift))
        } else {
            let steepest = surface
                .corners()
                .map(|corner| {
                    let light = lamp.at(corner.extend(top));
                    light.direction.z.acos() + light.extent.reach()
                })
                .into_iter()
                .fold(0.0, f64::max);
            let reach = DVec2::splat(steepest.min(STEEPEST).tan() * depth);
            (low - reach, high + reach)
        };
        let size = high - low;
        // Square strata, as many rows in each part: parts that differ in rays would pass for scatter where light from
        // other sources is added to theirs.
        let rows = ((rays as f64 * size.y / size.x).sqrt().round() as usize).max(1).next_multiple_of(PARTS);
        let columns = ((rays as f64 / rows as f64).round() as usize).max(1);
        let light = lamp.at(surface.middle());
        Self { low, size, z: top + lift, columns, rows, lamp, reference: light.direction.z * light.irradiance }
    }

    /// Horizontal area for which a ray stands, mm².
    pub fn share(&self) -> f64 {
        self.size.element_product() / (self.columns * self.rows) as f64
    }

    /// A ray from its own jittered place: origin, unit direction, and weight beside that of a ray from the lamp's middle to
    /// the plate's.
    #[inline]
    pub fn ray(&self, column: usize, row: usize, random: &mut Xoshiro256PlusPlus) -> (DVec3, DVec3, f64) {
        let (x, y) = (random.random::<f64>(), random.random::<f64>());
        let at = DVec2::new((column as f64 + x) / self.columns as f64, (row as f64 + y) / self.rows as f64);
        let origin = (self.low + self.size * at).extend(self.z);
        if let Some(light) = self.lamp.only_direction() {
            return (origin, -light, 1.0);
        }
        let light = self.lamp.at(origin);
        let l = light.sample(random);
        let weight = l.z.max(0.0) * light.irradiance / self.reference;
        (origin, -l.with_z(l.z.max(LEAST_CLIMB)).normalize(), weight)
    }
}
