//! N facets of equal area that stand in for a distribution.
//!
//! All methods work on the image plane, where a distance is an angle that the eye sees, and return image positions;
//! [`Setup::slope_at`](crate::setup::Setup::slope_at) turns each into its slope.

pub mod kd;

mod nearest;

pub mod equal_mass;

pub mod refine;

use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::distribution::SlopeDistribution;
use crate::progress::Progress;
use crate::raster::Raster;

/// How the facets are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
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
pub fn sample(
    distribution: &SlopeDistribution,
    n: usize,
    sampling: Sampling,
    seed: u64,
    progress: &Progress,
) -> Vec<DVec2> {
    let footprint = &distribution.footprint;
    let mut points = match sampling {
        Sampling::Random => {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let inverse = Inverse::new(footprint);
            (0..n).map(|_| inverse.at([rng.random(), rng.random()])).collect()
        }
        Sampling::Sobol => {
            let inverse = Inverse::new(footprint);
            (0..n).map(|k| inverse.at(sobol(k, seed))).collect()
        }
        Sampling::Voronoi => {
            let centres = equal_mass::equal_mass_centres(footprint, n, progress);
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
fn nearest_lit(distribution: &SlopeDistribution, point: DVec2) -> DVec2 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::SlopeDistributionSettings;
    use crate::highlight::{Highlight, Quantity};
    use crate::projection::Projection;
    use crate::setup::Setup;

    const ALL: [Sampling; 3] = [Sampling::Voronoi, Sampling::Random, Sampling::Sobol];

    fn distribution(light: &Raster, theta: f64, half_field: f64) -> SlopeDistribution {
        let setup = Setup::new(theta, 0.7, 0.0, Projection::Equidistant, half_field);
        let highlight = Highlight::new(light, Quantity::Flux, &setup).unwrap();
        SlopeDistribution::new(&highlight, &setup, &SlopeDistributionSettings::default(), |_| 1.0).unwrap()
    }

    /// A soft blot off centre, with a bright speck.
    fn blot(side: usize) -> Raster {
        Raster::from_fn(side, side, |x, y| {
            let uv = crate::projection::View::pixel_centre(x, y, side, side);
            let soft = (-12.0 * (uv - DVec2::new(-0.3, 0.2)).length_squared()).exp();
            if soft < 0.1 { 0.0 } else { soft + f64::from(u8::from(uv.distance(DVec2::new(-0.1, 0.4)) < 0.1)) }
        })
    }

    fn bits(points: &[DVec2]) -> Vec<[u64; 2]> {
        points.iter().map(|p| [p.x.to_bits(), p.y.to_bits()]).collect()
    }

    #[test]
    fn any_number_of_facets_is_drawn_on_lit_directions() {
        // At 60° a corner of this field lies below the plate.
        for (theta, half_field) in [(0.0, 0.3), (1.05, 0.5)] {
            for light in [blot(40), Raster::from_fn(1, 1, |_, _| 1.0), Raster::from_fn(1, 9, |_, y| y as f64)] {
                let wanted = distribution(&light, theta, half_field);
                for sampling in ALL {
                    for n in [1, 2, 7, 150] {
                        let points = sample(&wanted, n, sampling, 5, &Progress::silent());
                        assert_eq!(points.len(), n);
                        for uv in points {
                            let slope = wanted.setup.slope_at(uv).expect("a direction above the plate");
                            assert!(slope.intercept(wanted.setup.light()) > 0.0 && uv.abs().max_element() <= 1.1);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn one_lit_pixel_holds_every_facet() {
        let light = Raster::from_fn(64, 64, |x, y| f64::from(u8::from((x, y) == (50, 9))));
        let (wanted, middle) = (distribution(&light, 0.5, 0.3), crate::projection::View::pixel_centre(50, 9, 64, 64));
        for sampling in ALL {
            for n in [1, 2, 7, 150] {
                for uv in sample(&wanted, n, sampling, 3, &Progress::silent()) {
                    assert!((uv - middle).abs().max_element() < 1.01 / 64.0, "{sampling:?} {n}: {uv}");
                }
            }
        }
    }

    #[test]
    fn far_apart_spots_get_facets_in_proportion_and_the_dark_between_none() {
        let light = Raster::from_fn(128, 128, |x, y| match (x, y) {
            (10..13, 110..113) => 1.0,
            (110..113, 20..23) => 2.0,
            _ => 0.0,
        });
        let wanted = distribution(&light, 0.0, 0.3);
        let [one, two] = [(11, 111), (111, 21)].map(|(x, y)| crate::projection::View::pixel_centre(x, y, 128, 128));
        for n in [3, 99, 900, 901, 902] {
            let points = sample(&wanted, n, Sampling::Voronoi, 1, &Progress::silent());
            let near = |spot: DVec2| points.iter().filter(|p| p.distance(spot) < 0.08).count();
            let (first, second) = (near(one), near(two));
            assert!(first.abs_diff((n as f64 / 3.0).round() as usize) <= 1, "{n}: {first} and {second}");
            assert_eq!(first + second, n, "{n}: {first} and {second}");
        }
    }

    #[test]
    fn a_mirrored_drawing_is_drawn_as_well() {
        let light = blot(48);
        let mirrored = Raster::from_fn(48, 48, |x, y| light.at(47 - x, y));
        let mean = |light: &Raster| {
            let points = sample(&distribution(light, 0.0, 0.3), 200, Sampling::Voronoi, 1, &Progress::silent());
            points.iter().sum::<DVec2>() / 200.0
        };
        let (a, b) = (mean(&light), mean(&mirrored));
        assert!((a.x + b.x).abs() < 1e-3 && (a.y - b.y).abs() < 1e-3 && a.x < -0.2, "{a} {b}");
    }

    #[test]
    fn threads_change_nothing_and_seeds_only_what_is_random() {
        let wanted = distribution(&blot(200), 0.6, 0.3);
        for (sampling, seeded) in [(Sampling::Voronoi, false), (Sampling::Random, true), (Sampling::Sobol, true)] {
            let drawn = |threads, seed| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                bits(&pool.install(|| sample(&wanted, 500, sampling, seed, &Progress::silent())))
            };
            let first = drawn(1, 1);
            assert_eq!(first, drawn(3, 1), "{sampling:?}");
            assert_eq!(first != drawn(1, 2), seeded, "{sampling:?}");
        }
    }

    #[test]
    fn a_million_points_of_sobol_do_not_repeat() {
        // One sequence ends after 2^16 points; the next must be another.
        let points: Vec<[f64; 2]> = [0, 1, 65_535, 65_536, 65_537, 131_072].iter().map(|&k| sobol(k, 1)).collect();
        for (k, a) in points.iter().enumerate() {
            assert!(points[..k].iter().all(|b| a != b), "{points:?}");
        }
        assert_ne!(sobol(5, 1), sobol(5, 1 << 40));
    }

    #[test]
    fn running_sums_are_inverted_past_rows_that_hold_nothing() {
        let running = [0.0, 0.0, 1.0, 1.0, 4.0, 4.0];
        assert_eq!(invert(&running, 0.0), (2, 0.0));
        assert_eq!(invert(&running, 0.125), (2, 0.5));
        assert_eq!(invert(&running, 0.25), (4, 0.0));
        assert_eq!(invert(&running, 1.0 - f64::EPSILON / 2.0).0, 4);
        assert_eq!(invert(&[0.0], 0.3), (0, 0.5));
    }
}
