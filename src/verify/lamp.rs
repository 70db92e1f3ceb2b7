//! Distant lamps: a point of light, a disc such as the sun, or a picture on the sky.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::projection::{Projection, View, carried_axes};
use crate::raster::Raster;
use crate::slope::angle_between;

/// The shape of a distant lamp around its middle.
#[derive(Clone, Debug, Default)]
pub enum Lamp {
    /// All light comes from one direction.
    #[default]
    Point,
    /// A disc of even radiance.
    Disc {
        /// Angular radius, radians.
        radius: f64,
    },
    /// Radiance as in a picture.
    Picture(Arc<PictureLamp>),
}

/// A picture on the sky, ready to be sampled.
#[derive(Clone, Debug)]
pub struct PictureLamp {
    width: usize,
    height: usize,
    half_field: f64,
    /// Light up to and including each pixel.
    cumulative: Vec<f64>,
}

impl Lamp {
    /// A point, or a disc where the angular `radius` (radians) is more than 0.
    pub fn round(radius: f64) -> Self {
        if radius > 0.0 { Self::Disc { radius } } else { Self::Point }
    }

    /// `radiance` on the sky around the lamp's middle, laid out like an equidistant highlight image whose rim is
    /// `half_field` (radians) away. `None` if the picture is all dark.
    pub fn picture(radiance: &Raster, half_field: f64) -> Option<Self> {
        let (width, height) = (radiance.width, radiance.height);
        let view = View::new(Projection::Equidistant, half_field, DVec3::Z);
        let mut sum = 0.0;
        let flux = |k: usize| {
            let uv = View::pixel_centre(k % width, k / width, width, height);
            radiance.values[k].max(0.0) * view.solid_angle_density(uv)
        };
        let cumulative: Vec<f64> = (0..width * height)
            .map(|k| {
                sum += flux(k);
                sum
            })
            .collect();
        (sum > 0.0 && sum.is_finite())
            .then(|| Self::Picture(Arc::new(PictureLamp { width, height, half_field, cumulative })))
    }

    /// Whether all light comes from one direction.
    pub fn is_point(&self) -> bool {
        matches!(self, Self::Point)
    }

    /// The largest angle between its light and its middle, radians.
    pub fn reach(&self) -> f64 {
        match self {
            Self::Point => 0.0,
            Self::Disc { radius } => *radius,
            // The picture's corners.
            Self::Picture(lamp) => lamp.half_field * std::f64::consts::SQRT_2,
        }
    }

    /// Density, 1/sr, with which [`sample`](Self::sample) draws the unit vector `l`: the lamp's radiance toward it if all
    /// of its light adds up to 1. A point has none anywhere.
    pub fn density(&self, middle: DVec3, l: DVec3) -> f64 {
        match self {
            Self::Point => 0.0,
            Self::Disc { radius } => {
                let within = angle_between(middle, l) <= *radius;
                // 1 - cos without cancellation.
                if within { 1.0 / (2.0 * TAU * (0.5 * radius).sin().powi(2)) } else { 0.0 }
            }
            Self::Picture(lamp) => {
                let view = View::new(Projection::Equidistant, lamp.half_field, middle);
                let (width, height) = (lamp.width, lamp.height);
                let Some(uv) = view.forward(l) else { return 0.0 };
                let Some((column, row)) = View::pixel_at(uv, width, height) else { return 0.0 };
                let pixel = row * width + column;
                let before = if pixel == 0 { 0.0 } else { lamp.cumulative[pixel - 1] };
                let share = (lamp.cumulative[pixel] - before) / lamp.cumulative[width * height - 1];
                let size = 4.0 / (width * height) as f64 * view.solid_angle_density(uv);
                if size > 0.0 { share / size } else { 0.0 }
            }
        }
    }

    /// A direction to the lamp around its `middle` (unit vectors), with a density in proportion to radiance.
    pub fn sample(&self, middle: DVec3, random: &mut Xoshiro256PlusPlus) -> DVec3 {
        match self {
            Self::Point => middle,
            Self::Disc { radius } => {
                // Uniform over the cap of the disc's solid angle.
                let cosine = 1.0 - random.random::<f64>() * (1.0 - radius.cos());
                let (sine, azimuth) = ((1.0 - cosine * cosine).max(0.0).sqrt(), TAU * random.random::<f64>());
                let (e1, e2) = carried_axes(middle);
                cosine * middle + sine * (azimuth.cos() * e1 + azimuth.sin() * e2)
            }
            Self::Picture(lamp) => {
                let whole = lamp.cumulative[lamp.cumulative.len() - 1];
                let at = random.random::<f64>() * whole;
                let pixel = lamp.cumulative.partition_point(|&sum| sum <= at).min(lamp.cumulative.len() - 1);
                let (column, row) = (pixel % lamp.width, pixel / lamp.width);
                let jitter = DVec2::new(random.random::<f64>() - 0.5, 0.5 - random.random::<f64>()) * 2.0;
                let size = DVec2::new(lamp.width as f64, lamp.height as f64);
                let uv = View::pixel_centre(column, row, lamp.width, lamp.height) + jitter / size;
                let view = View::new(Projection::Equidistant, lamp.half_field, middle);
                view.inverse(uv).unwrap_or(middle)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::slope::direction;

    #[test]
    fn a_disc_is_even_over_its_solid_angle() {
        let (middle, radius) = (direction(0.7, 2.0), 0.3);
        let lamp = Lamp::round(radius);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let inner = (1.0 - 0.5 * (1.0 - radius.cos())).acos();
        let n = 40_000;
        let within = (0..n).filter(|_| angle_between(lamp.sample(middle, &mut random), middle) < inner).count();
        let z = (within as f64 - 0.5 * f64::from(n)) / (0.25 * f64::from(n)).sqrt();
        assert!(z.abs() < 3.5, "{z}");
    }

    #[test]
    fn a_picture_sends_light_from_its_bright_pixels_only() {
        let mut picture = Raster::zeros(4, 4);
        picture.values[1] = 3.0;
        picture.values[15] = 1.0;
        let lamp = Lamp::picture(&picture, 0.2).unwrap();
        let middle = direction(0.4, -1.0);
        let view = View::new(Projection::Equidistant, 0.2, middle);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
        let mut counts = [0; 16];
        for _ in 0..10_000 {
            let (column, row) = View::pixel_at(view.forward(lamp.sample(middle, &mut random)).unwrap(), 4, 4).unwrap();
            counts[4 * row + column] += 1;
        }
        assert_eq!(counts[1] + counts[15], 10_000);
        assert!((f64::from(counts[1]) / 10_000.0 - 0.75).abs() < 0.02);
        assert!(Lamp::picture(&Raster::zeros(4, 4), 0.2).is_none());
    }

    #[test]
    fn the_density_is_that_of_the_samples_and_adds_up_to_one() {
        let picture = Raster::from_fn(5, 3, |x, y| (x + 2 * y) as f64);
        let middle = direction(0.4, -1.0);
        for lamp in [Lamp::round(0.25), Lamp::picture(&picture, 0.3).unwrap()] {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
            // Half of the cap around the middle, by chance and by integration on a fine grid of directions.
            let view = View::new(Projection::Equidistant, 0.45, middle);
            let n = 300;
            let (mut half, mut all) = (0.0, 0.0);
            for k in 0..n * n {
                let uv = View::pixel_centre(k % n, k / n, n, n);
                let l = view.inverse(uv).unwrap();
                let share = lamp.density(middle, l) * view.solid_angle_density(uv) * 4.0 / (n * n) as f64;
                all += share;
                half += if uv.x > 0.1 { share } else { 0.0 };
            }
            assert!((all - 1.0).abs() < 0.01, "{lamp:?} {all}");
            let within = |l: DVec3| view.forward(l).unwrap().x > 0.1;
            let count = (0..40_000).filter(|_| within(lamp.sample(middle, &mut random))).count();
            assert!((count as f64 / 40_000.0 - half).abs() < 0.012, "{lamp:?} {half} {count}");
        }
        assert_eq!(Lamp::Point.density(middle, middle), 0.0);
    }
}
