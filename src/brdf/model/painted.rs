//! A density of normals from a table, painted or computed: Ashikhmin, Premože, Shirley, "A microfacet-based BRDF generator"
//! (SIGGRAPH 2000). Any density gives a BRDF; its shadowing follows from it by integration.
//!
//! The table is a map of normals seen from above: a square whose rim is a given tilt, (m.x, m.y) = sin(rim) (u, v), row 0 on
//! top. There cells of equal area are equal parts of the plate (∫ d m.z dω = ∫ d dm.x dm.y), so a cell's value is d up to one
//! factor, and drawing a normal is choosing a cell by its value.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};
use thiserror::Error;

use super::normals::Normals;
use crate::projection::View;
use crate::raster::Raster;
use crate::slope::{direction, polar_angle};

/// Intervals of the table of σ: polar angles, even in the angle, and azimuths.
const POLAR: usize = 64;
const AROUND: usize = 72;
/// Blocks a side that the table is gathered into for σ.
const BLOCKS: usize = 128;

/// A tabulated density of normals.
#[derive(Clone, Debug)]
pub struct PaintedNormals {
    table: Raster,
    /// Sine of the tilt at the rim.
    reach: f64,
    /// Shares of the plate up to each cell.
    below: Vec<f64>,
    /// σ, polar angle by polar angle, azimuths from 0.
    seen: Vec<f64>,
}

impl PaintedNormals {
    /// The density `painted` (up to a factor) on a map whose rim is `tilt` radians from the normal.
    ///
    /// # Errors
    /// A value that is negative or no number, no value above 0, a rim beyond 90° or at 0.
    pub fn new(painted: &Raster, tilt: f64) -> Result<Self, PaintedError> {
        if !(tilt > 0.0 && tilt <= FRAC_PI_2 + 1e-9) {
            return Err(PaintedError::Rim(tilt.to_degrees()));
        }
        if let Some(bad) = painted.values.iter().find(|value| !(**value >= 0.0 && value.is_finite())) {
            return Err(PaintedError::Value(*bad));
        }
        let reach = tilt.sin().min(1.0);
        let mut table = painted.clone();
        let (width, height) = (table.width, table.height);
        for (k, value) in table.values.iter_mut().enumerate() {
            let m = reach * View::pixel_centre(k % width, k / width, width, height);
            if m.length_squared() >= 1.0 {
                *value = 0.0;
            }
        }
        let whole = table.sum();
        if !(whole > 0.0 && whole.is_finite()) {
            return Err(PaintedError::Empty);
        }
        let cell = 4.0 * reach * reach / (width * height) as f64;
        let mut sum = 0.0;
        let below = table.values.iter().map(|value| {
            sum += value / whole;
            sum
        });
        let below = below.collect();
        table.values.iter_mut().for_each(|value| *value /= whole * cell);
        let seen = seen_areas(&table, reach);
        Ok(Self { table, reach, below, seen })
    }

    fn cell(&self, m: DVec3) -> Option<usize> {
        let (column, row) = View::pixel_at(m.truncate() / self.reach, self.table.width, self.table.height)?;
        Some(row * self.table.width + column)
    }
}

/// σ at the nodes. Blocks of cells stand for their facets with the mean of their normals, which is exact where a direction
/// sees all of a block.
fn seen_areas(table: &Raster, reach: f64) -> Vec<f64> {
    let (width, height) = (table.width, table.height);
    let mut blocks = vec![DVec3::ZERO; BLOCKS * BLOCKS];
    let cell = 4.0 * reach * reach / (width * height) as f64;
    for (k, value) in table.values.iter().enumerate().filter(|(_, value)| **value > 0.0) {
        let across = reach * View::pixel_centre(k % width, k / width, width, height);
        let z = (1.0 - across.length_squared()).max(0.0).sqrt();
        // Facet area is plate area over m.z; times the normal it is (m.x/m.z, m.y/m.z, 1).
        let block = (k / width * BLOCKS / height) * BLOCKS + k % width * BLOCKS / width;
        blocks[block] += value * cell * (across / z.max(1e-3)).extend(1.0);
    }
    blocks.retain(|block| *block != DVec3::ZERO);
    let node = |k: usize| {
        let (polar, around) = (k / (AROUND + 1), k % (AROUND + 1));
        let v = direction(FRAC_PI_2 * polar as f64 / POLAR as f64, TAU * (around % AROUND) as f64 / AROUND as f64);
        blocks.iter().map(|block| block.dot(v).max(0.0)).sum::<f64>().max(v.z).max(1e-12)
    };
    (0..(POLAR + 1) * (AROUND + 1)).map(node).collect()
}

impl Normals for PaintedNormals {
    fn density(&self, m: DVec3) -> f64 {
        if m.z <= 0.0 { 0.0 } else { self.cell(m).map_or(0.0, |cell| self.table.values[cell]) }
    }

    fn seen_area(&self, v: DVec3) -> f64 {
        let polar = polar_angle(v).clamp(0.0, FRAC_PI_2) / FRAC_PI_2 * POLAR as f64;
        let around = v.y.atan2(v.x).rem_euclid(TAU) / TAU * AROUND as f64;
        let (row, column) = ((polar as usize).min(POLAR - 1), (around as usize).min(AROUND - 1));
        let (s, t) = (polar - row as f64, around - column as f64);
        let at = |row: usize| {
            let k = row * (AROUND + 1) + column;
            self.seen[k] + t * (self.seen[k + 1] - self.seen[k])
        };
        at(row) + s * (at(row + 1) - at(row))
    }

    fn sample(&self, _: DVec3, u: [f64; 2]) -> DVec3 {
        let (width, height) = (self.table.width, self.table.height);
        let cell = self.below.partition_point(|share| *share <= u[0]).min(self.below.len() - 1);
        let before = if cell > 0 { self.below[cell - 1] } else { 0.0 };
        let within = ((u[0] - before) / (self.below[cell] - before).max(1e-300)).clamp(0.0, 1.0);
        let at = DVec2::new(
            ((cell % width) as f64 + within) / width as f64 * 2.0 - 1.0,
            1.0 - ((cell / width) as f64 + u[1]) / height as f64 * 2.0,
        );
        let across = self.reach * at;
        across.extend((1.0 - across.length_squared()).max(1e-12).sqrt()).normalize()
    }

    fn sampled_density(&self, _: DVec3, m: DVec3) -> f64 {
        self.density(m) * m.z
    }
}

/// Why a table is no density of normals.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PaintedError {
    /// A negative or infinite share of normals.
    #[error("a density of normals holds the value {0}: all must be finite and not negative")]
    Value(f64),
    /// No normals at all.
    #[error("a density of normals holds nothing but zeros within the hemisphere: paint some of it bright")]
    Empty,
    /// A map of more than the hemisphere, or of nothing.
    #[error("the rim of a map of normals must be above 0 and at most 90 degrees from the plate's own, not {0}")]
    Rim(f64),
}
