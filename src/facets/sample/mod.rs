//! N facets of equal area that stand in for a distribution.
//!
//! All methods work on the image plane, where a distance is an angle that the eye sees, and return image positions;
//! [`Setup::slope_at`](crate::setup::Setup::slope_at) turns each into its slope.

pub mod kd;

pub mod cells;

pub mod refine;

use glam::DVec2;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::distribution::Distribution;
use crate::progress::Progress;
use crate::raster::Raster;

/// How the facets are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampling {
    /// Centres of centroidal cells of equal mass, then moved until the blurred light agrees.
    #[default]
    Voronoi,
    /// Independent draws.
    Random,
    /// A scrambled Sobol sequence through the inverse of the distribution.
    Sobol,
}

/// `n` image positions of facets of equal area that together show the distribution.
pub fn sample(distribution: &Distribution, n: usize, sampling: Sampling, seed: u64, progress: &Progress) -> Vec<DVec2> {
    let footprint = &distribution.footprint;
    let mut points = match sampling {
        Sampling::Random => {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let inverse = Inverse::new(footprint);
            (0..n).map(|_| inverse.at([unit(&mut rng), unit(&mut rng)])).collect()
        }
        Sampling::Sobol => {
            let inverse = Inverse::new(footprint);
            (0..n).map(|k| inverse.at(sobol(k, seed))).collect()
        }
        Sampling::Voronoi => {
            let centres = cells::equal_mass_centres(footprint, n, progress);
            refine::refined(distribution, centres, progress)
        }
    };
    // Blurred edges and refinement can carry a point off the lit directions by a fraction of a pixel.
    for point in &mut points {
        *point = nearest_lit(distribution, *point);
    }
    points
}

/// `point`, or the middle of the nearest pixel that holds light if no direction above the plate projects to it.
fn nearest_lit(distribution: &Distribution, point: DVec2) -> DVec2 {
    let light = distribution.setup.light();
    let good = |uv: DVec2| distribution.setup.slope_at(uv).is_some_and(|s| s.intercept(light) > 0.0);
    if good(point) {
        return point;
    }
    let Raster { width, height, .. } = distribution.footprint;
    let lit = distribution.footprint.values.iter().enumerate().filter(|(_, f)| **f > 0.0);
    lit.map(|(k, _)| crate::projection::View::pixel_centre(k % width, k / width, width, height))
        .min_by(|a, b| a.distance_squared(point).total_cmp(&b.distance_squared(point)))
        .unwrap_or(point)
}

fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// Point `k` of an Owen-scrambled Sobol sequence. One sequence holds 2^16 points; each further 2^16 take fresh dimensions.
fn sobol(k: usize, seed: u64) -> [f64; 2] {
    let (index, block) = ((k & 0xffff) as u32, (k >> 16) as u32);
    let key = (seed ^ (seed >> 32)) as u32;
    [0, 1].map(|d| f64::from(sobol_burley::sample(index, (2 * block + d) % sobol_burley::NUM_DIMENSIONS, key)))
}

/// The inverse of a distribution: rows by their sums, then columns within the row.
struct Inverse<'a> {
    density: &'a Raster,
    rows: Vec<f64>,
    columns: Vec<f64>,
}

impl<'a> Inverse<'a> {
    fn new(density: &'a Raster) -> Self {
        let running = |values: &[f64]| {
            values
                .iter()
                .scan(0.0, |sum, v| {
                    *sum += v;
                    Some(*sum)
                })
                .collect::<Vec<f64>>()
        };
        let columns: Vec<f64> = density.values.chunks(density.width).flat_map(running).collect();
        let sums: Vec<f64> = columns.chunks(density.width).map(|row| row[row.len() - 1]).collect();
        Self { density, rows: running(&sums), columns }
    }

    /// Image position of a point of the unit square.
    fn at(&self, [a, b]: [f64; 2]) -> DVec2 {
        let (row, down) = invert(&self.rows, a);
        let (column, right) = invert(&self.columns[row * self.density.width..][..self.density.width], b);
        DVec2::new(
            (column as f64 + right) / self.density.width as f64 * 2.0 - 1.0,
            1.0 - (row as f64 + down) / self.density.height as f64 * 2.0,
        )
    }
}

/// The interval in which running sums pass the share `x` of their total, and where in it.
fn invert(running: &[f64], x: f64) -> (usize, f64) {
    let wanted = x * running[running.len() - 1];
    let k = running.partition_point(|&sum| sum <= wanted).min(running.len() - 1);
    let before = if k > 0 { running[k - 1] } else { 0.0 };
    let width = running[k] - before;
    (k, if width > 0.0 { ((wanted - before) / width).clamp(0.0, 1.0) } else { 0.5 })
}
