//! Rays of a lamp at a finite distance: a ball of even radiance, as an opal bulb.

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::lamp::Lamp;
use super::launch::RayGrid;
use super::tally::PARTS;
use crate::trace::Surface;

/// Where a ray starts, its unit direction, and its weight beside that of a ray to the plate's middle from the lamp's.
pub type Ray = (DVec3, DVec3, f64);

/// A grid of rays from a distant lamp, or from one nearby.
#[derive(Debug)]
pub enum Rays<'a> {
    /// Distant.
    Far(RayGrid<'a>),
    /// Nearby.
    Near(NearGrid),
}

impl Rays<'_> {
    /// Rays in a row.
    pub fn columns(&self) -> usize {
        match self {
            Self::Far(grid) => grid.columns,
            Self::Near(grid) => grid.columns,
        }
    }

    /// Rows of rays.
    pub fn rows(&self) -> usize {
        match self {
            Self::Far(grid) => grid.rows,
            Self::Near(grid) => grid.rows,
        }
    }

    /// Horizontal area for which a ray stands, mm².
    pub fn share(&self) -> f64 {
        match self {
            Self::Far(grid) => grid.share(),
            Self::Near(grid) => grid.size.element_product() / (grid.columns * grid.rows) as f64,
        }
    }

    /// A ray from its own jittered place.
    #[inline]
    pub fn ray(&self, column: usize, row: usize, random: &mut Xoshiro256PlusPlus) -> Ray {
        match self {
            Self::Far(grid) => grid.ray(column, row, random),
            Self::Near(grid) => grid.ray(column, row, random),
        }
    }
}

/// Start points on a horizontal rectangle above the plate, and the ball from which light comes to them.
#[derive(Debug)]
pub struct NearGrid {
    low: DVec2,
    size: DVec2,
    z: f64,
    columns: usize,
    rows: usize,
    lamp: DVec3,
    radius: f64,
    /// Weight of a ray from straight above at unit distance (of unit solid angle, for a ball).
    unit: f64,
}

impl NearGrid {
    /// About `rays` rays from a ball around `lamp`, mm, wholly above the surface, its light at `middle` worth 1.
    pub fn new<S: Surface>(surface: &S, middle: DVec3, lamp: DVec3, radius: f64, rays: u64) -> Self {
        let (low, high) = surface.optical_area();
        let (bottom, top) = surface.height_range();
        let lift = 1e-6 * (high - low).length().max(top - bottom);
        let depth = top - bottom + 2.0 * lift;
        let steepest = [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)]
            .map(|corner| {
                let way = lamp - corner.extend(top);
                (way.z / way.length()).acos() + (radius / way.length()).min(1.0).asin()
            })
            .into_iter()
            .fold(0.0, f64::max);
        let reach = DVec2::splat(steepest.min(f64::to_radians(89.9)).tan() * depth);
        let (low, high) = if surface.is_endless() { (low, high) } else { (low - reach, high + reach) };
        let size = high - low;
        let rows = ((rays as f64 * size.y / size.x).sqrt().round() as usize).max(PARTS);
        let columns = ((rays as f64 / rows as f64).round() as usize).max(1);
        let way = lamp - middle;
        let unit = way.length() / way.z / solid_angle(radius, way.length());
        Self { low, size, z: top + lift, columns, rows, lamp, radius, unit }
    }

    #[inline]
    fn ray(&self, column: usize, row: usize, random: &mut Xoshiro256PlusPlus) -> Ray {
        let (x, y) = (random.random::<f64>(), random.random::<f64>());
        let at = DVec2::new((column as f64 + x) / self.columns as f64, (row as f64 + y) / self.rows as f64);
        let origin = (self.low + self.size * at).extend(self.z);
        let way = self.lamp - origin;
        let distance = way.length();
        let l = Lamp::round((self.radius / distance).min(1.0).asin()).sample(way / distance, random);
        let weight = l.z.max(0.0) * solid_angle(self.radius, distance) * self.unit;
        (origin, -l.with_z(l.z.max(1e-6)).normalize(), weight)
    }
}

/// Solid angle of a ball over 2π; for a point, of one of unit radius far away: half of 1/distance².
fn solid_angle(radius: f64, distance: f64) -> f64 {
    let sine = if radius > 0.0 { (radius / distance).min(1.0) } else { 1.0 / distance };
    // 1 - cos without cancellation; only ratios at one radius count.
    if radius > 0.0 { sine * sine / (1.0 + (1.0 - sine * sine).sqrt()) } else { 0.5 * sine * sine }
}
