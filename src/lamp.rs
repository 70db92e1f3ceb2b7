//! Lamps, asked for their light at a place: a point, a disc or a picture far away, or a ball nearby.
//!
//! A lamp far away shows the same to every place of a plate. A ball nearby is seen from each place in a direction of its
//! own, and the larger and brighter the nearer it is. [`Lamp::at`] says what a lamp is from one place; whoever sends or
//! looks for light asks that, and need not know which lamp it is.

use std::borrow::Cow;
use std::f64::consts::{SQRT_2, TAU};
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::projection::{Projection, View, carried_axes};
use crate::raster::Raster;
use crate::slope::angle_between;

/// Where light comes from, in the frame of the plate.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Lamp {
    /// So far away that it sends the same light to every place.
    Distant(DistantLamp),
    /// A ball of even radiance, as an opal bulb.
    Ball {
        /// Its middle, mm.
        middle: DVec3,
        /// Its radius, mm; 0 is a point that shines alike to all sides.
        radius: f64,
    },
}

/// A lamp far away.
#[derive(Clone, Debug, PartialEq)]
pub struct DistantLamp {
    /// Unit vector to its middle.
    pub direction: DVec3,
    /// What it shows around its middle.
    pub extent: Extent,
}

/// What a lamp is to a place that it shines on, around the direction of its middle.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Extent {
    /// All light comes from one direction.
    #[default]
    Point,
    /// A disc of even radiance.
    Disc {
        /// Angular radius, radians.
        radius: f64,
    },
    /// Radiance as in a picture.
    Picture(Arc<SkyPicture>),
}

/// A picture on the sky, ready to be sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyPicture {
    width: usize,
    height: usize,
    half_field: f64,
    /// Light up to and including each pixel.
    cumulative: Vec<f64>,
}

/// A lamp as it is from one place.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalLight<'a> {
    /// Unit vector to the lamp's middle.
    pub direction: DVec3,
    /// Irradiance across the beam, in a unit that is the same for all places under one lamp.
    pub irradiance: f64,
    /// What the lamp shows around its middle.
    pub extent: Cow<'a, Extent>,
}

impl Lamp {
    /// What the lamp is from `place`, mm.
    #[inline]
    pub fn at(&self, place: DVec3) -> LocalLight<'_> {
        match self {
            Self::Distant(DistantLamp { direction, extent }) => {
                LocalLight { direction: *direction, irradiance: 1.0, extent: Cow::Borrowed(extent) }
            }
            Self::Ball { middle, radius } => {
                let way = *middle - place;
                let distance = way.length();
                let extent = Cow::Owned(Extent::round((radius / distance).min(1.0).asin()));
                LocalLight { direction: way / distance, irradiance: ball_irradiance(*radius, distance), extent }
            }
        }
    }

    /// The direction that all of its light comes from, if there is one for all places.
    pub fn only_direction(&self) -> Option<DVec3> {
        match self {
            Self::Distant(DistantLamp { direction, extent: Extent::Point }) => Some(*direction),
            _ => None,
        }
    }

    /// Whether all light that comes to a place comes from one direction.
    pub fn is_point(&self) -> bool {
        match self {
            Self::Distant(lamp) => lamp.extent.is_point(),
            Self::Ball { radius, .. } => *radius <= 0.0,
        }
    }
}

impl From<DistantLamp> for Lamp {
    fn from(lamp: DistantLamp) -> Self {
        Self::Distant(lamp)
    }
}

impl DistantLamp {
    /// A point toward `direction`, or a disc where the angular `radius` (radians) is more than 0.
    pub fn round(direction: DVec3, radius: f64) -> Self {
        Self { direction, extent: Extent::round(radius) }
    }

    /// The lamp in the same place with another extent.
    pub fn with_extent(self, extent: Extent) -> Self {
        Self { extent, ..self }
    }
}

/// Irradiance across the beam of a ball of radiance 1/2π: its solid angle over 2π. For a point, half of 1/distance².
/// Both only serve to compare places under the same lamp.
fn ball_irradiance(radius: f64, distance: f64) -> f64 {
    let sine = if radius > 0.0 { (radius / distance).min(1.0) } else { 1.0 / distance };
    // 1 - cos without cancellation.
    if radius > 0.0 { sine * sine / (1.0 + (1.0 - sine * sine).sqrt()) } else { 0.5 * sine * sine }
}

impl Extent {
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
            .then(|| Self::Picture(Arc::new(SkyPicture { width, height, half_field, cumulative })))
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
            Self::Picture(picture) => picture.half_field * SQRT_2,
        }
    }
}

impl LocalLight<'_> {
    /// Density, 1/sr, with which [`sample`](Self::sample) draws the unit vector `l`: the lamp's radiance toward it if its
    /// irradiance across the beam is 1. A point has none anywhere.
    pub fn density(&self, l: DVec3) -> f64 {
        match &*self.extent {
            Extent::Point => 0.0,
            Extent::Disc { radius } => {
                let within = angle_between(self.direction, l) <= *radius;
                // 1 - cos without cancellation.
                if within { 1.0 / (2.0 * TAU * (0.5 * radius).sin().powi(2)) } else { 0.0 }
            }
            Extent::Picture(picture) => picture.density(self.direction, l),
        }
    }

    /// A unit vector toward the lamp, with a density in proportion to radiance.
    #[inline]
    pub fn sample(&self, random: &mut Xoshiro256PlusPlus) -> DVec3 {
        match &*self.extent {
            Extent::Point => self.direction,
            Extent::Disc { radius } => {
                let share = random.random::<f64>();
                on_cap(self.direction, *radius, share, TAU * random.random::<f64>())
            }
            Extent::Picture(picture) => picture.sample(self.direction, random),
        }
    }
}

/// The unit vector within `radius` (radians) of `middle` that has the share `share` of that cap's solid angle nearer to the
/// middle, at the angle `azimuth` about it: over both even shares are even over a disc of light.
#[inline]
pub(crate) fn on_cap(middle: DVec3, radius: f64, share: f64, azimuth: f64) -> DVec3 {
    let cosine = 1.0 - share * (1.0 - radius.cos());
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (e1, e2) = carried_axes(middle);
    cosine * middle + sine * (azimuth.cos() * e1 + azimuth.sin() * e2)
}

impl SkyPicture {
    fn density(&self, middle: DVec3, l: DVec3) -> f64 {
        let view = View::new(Projection::Equidistant, self.half_field, middle);
        let (width, height) = (self.width, self.height);
        let Some(uv) = view.forward(l) else { return 0.0 };
        let Some((column, row)) = View::pixel_at(uv, width, height) else { return 0.0 };
        let pixel = row * width + column;
        let before = if pixel == 0 { 0.0 } else { self.cumulative[pixel - 1] };
        let share = (self.cumulative[pixel] - before) / self.cumulative[width * height - 1];
        let size = 4.0 / (width * height) as f64 * view.solid_angle_density(uv);
        if size > 0.0 { share / size } else { 0.0 }
    }

    fn sample(&self, middle: DVec3, random: &mut Xoshiro256PlusPlus) -> DVec3 {
        let whole = self.cumulative[self.cumulative.len() - 1];
        let at = random.random::<f64>() * whole;
        let pixel = self.cumulative.partition_point(|&sum| sum <= at).min(self.cumulative.len() - 1);
        let (column, row) = (pixel % self.width, pixel / self.width);
        let jitter = DVec2::new(random.random::<f64>() - 0.5, 0.5 - random.random::<f64>()) * 2.0;
        let size = DVec2::new(self.width as f64, self.height as f64);
        let uv = View::pixel_centre(column, row, self.width, self.height) + jitter / size;
        let view = View::new(Projection::Equidistant, self.half_field, middle);
        view.inverse(uv).unwrap_or(middle)
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::slope::direction;

    fn lit(extent: Extent, direction: DVec3) -> LocalLight<'static> {
        LocalLight { direction, irradiance: 1.0, extent: Cow::Owned(extent) }
    }

    #[test]
    fn a_disc_is_even_over_its_solid_angle() {
        let (middle, radius) = (direction(0.7, 2.0), 0.3);
        let light = lit(Extent::round(radius), middle);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let inner = (1.0 - 0.5 * (1.0 - radius.cos())).acos();
        let n = 40_000;
        let within = (0..n).filter(|_| angle_between(light.sample(&mut random), middle) < inner).count();
        let z = (within as f64 - 0.5 * f64::from(n)) / (0.25 * f64::from(n)).sqrt();
        assert!(z.abs() < 3.5, "{z}");
    }

    #[test]
    fn a_picture_sends_light_from_its_bright_pixels_only() {
        let mut picture = Raster::zeros(4, 4);
        picture.values[1] = 3.0;
        picture.values[15] = 1.0;
        let middle = direction(0.4, -1.0);
        let light = lit(Extent::picture(&picture, 0.2).unwrap(), middle);
        let view = View::new(Projection::Equidistant, 0.2, middle);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
        let mut counts = [0; 16];
        for _ in 0..10_000 {
            let (column, row) = View::pixel_at(view.forward(light.sample(&mut random)).unwrap(), 4, 4).unwrap();
            counts[4 * row + column] += 1;
        }
        assert_eq!(counts[1] + counts[15], 10_000);
        assert!((f64::from(counts[1]) / 10_000.0 - 0.75).abs() < 0.02);
        assert!(Extent::picture(&Raster::zeros(4, 4), 0.2).is_none());
    }

    #[test]
    fn the_density_is_that_of_the_samples_and_adds_up_to_one() {
        let picture = Raster::from_fn(5, 3, |x, y| (x + 2 * y) as f64);
        let middle = direction(0.4, -1.0);
        for extent in [Extent::round(0.25), Extent::picture(&picture, 0.3).unwrap()] {
            let light = lit(extent, middle);
            let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
            // Half of the cap around the middle, by chance and by integration on a fine grid of directions.
            let view = View::new(Projection::Equidistant, 0.45, middle);
            let n = 300;
            let (mut half, mut all) = (0.0, 0.0);
            for k in 0..n * n {
                let uv = View::pixel_centre(k % n, k / n, n, n);
                let l = view.inverse(uv).unwrap();
                let share = light.density(l) * view.solid_angle_density(uv) * 4.0 / (n * n) as f64;
                all += share;
                half += if uv.x > 0.1 { share } else { 0.0 };
            }
            assert!((all - 1.0).abs() < 0.01, "{light:?} {all}");
            let within = |l: DVec3| view.forward(l).unwrap().x > 0.1;
            let count = (0..40_000).filter(|_| within(light.sample(&mut random))).count();
            assert!((count as f64 / 40_000.0 - half).abs() < 0.012, "{light:?} {half} {count}");
        }
        assert_eq!(lit(Extent::Point, middle).density(middle), 0.0);
    }
    #[test]
    fn a_ball_shines_as_the_integral_over_what_is_seen_of_it_and_a_point_as_the_inverse_square() {
        let middle = DVec3::new(3.0, -2.0, 40.0);
        let (ball, point) = (Lamp::Ball { middle, radius: 12.0 }, Lamp::Ball { middle, radius: 0.0 });
        let ratio = |lamp: &Lamp, a: DVec3, b: DVec3| lamp.at(a).irradiance / lamp.at(b).irradiance;
        let (near, far) = (DVec3::new(1.0, 1.0, 20.0), DVec3::new(-9.0, 4.0, 0.0));
        let square = |place: DVec3| (middle - place).length_squared();
        assert!((ratio(&point, near, far) / (square(far) / square(near)) - 1.0).abs() < 1e-12);
        assert!(point.at(near).extent.is_point() && point.is_point() && !ball.is_point());
        for place in [near, far] {
            let light = ball.at(place);
            assert!((place + light.direction * square(place).sqrt() - middle).length() < 1e-12);
            // The ball's rim touches the ray that leaves at its reach.
            assert!((light.extent.reach().sin() - 12.0 / square(place).sqrt()).abs() < 1e-12);
            // An even radiance, the same from everywhere: irradiance times density.
            let radiance = light.irradiance * light.density(light.direction);
            assert!((radiance * TAU - 1.0).abs() < 1e-12, "{radiance}");
        }
        // Far away, at the same place in the sky, it is a distant disc.
        let from = 1e6 * direction(0.3, 0.4);
        let small = Lamp::Ball { middle: from, radius: 1e4 };
        let disc = Lamp::from(DistantLamp::round(direction(0.3, 0.4), 0.01f64.asin()));
        assert!((ratio(&small, DVec3::ZERO, DVec3::X) - 1.0).abs() < 1e-5);
        let (a, b) = (small.at(DVec3::X), disc.at(DVec3::X));
        assert!((a.direction - b.direction).length() < 1e-5 && (a.extent.reach() - b.extent.reach()).abs() < 1e-7);
        assert_eq!((small.only_direction(), disc.only_direction()), (None, None));
    }
}
