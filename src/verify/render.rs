//! What a person sees: a picture of the plate, or of a ball or cylinder that wears its relief, as a camera takes it.
//!
//! Radiance is stated for a lamp whose irradiance across its own beam is 1: a white matt plate in light from straight
//! above shows 1/π. What is not simulated: depth of field, glare, and the lamp itself where it would be seen directly. The
//! sides of the plate are black, and left out below the lowest point of its relief.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DMat3, DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use thiserror::Error;

pub use super::camera::Shape;

use super::camera::Camera;
use super::experiment::Experiment;
use super::path_tracer::{PathLight, PathTracer};
use crate::lamp::Lamp;
use crate::progress::{Cancelled, Progress};
use crate::projection::View;
use crate::raster::Raster;
use crate::slope::direction;
use crate::trace::{PieceKind, Surface};

/// Where the camera stands, what it looks at, and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSettings {
    /// Angle of the camera from the plate's normal, degrees.
    pub theta: f64,
    /// Its azimuth from +x, counter-clockwise seen from above, degrees.
    pub phi: f64,
    /// From the plate's middle, or from the centre of what it is wrapped on, mm.
    pub distance: f64,
    /// Angle across the longer side of the picture, degrees.
    pub field_of_view: f64,
    /// Columns and rows of the picture.
    pub size: [usize; 2],
    /// What the relief is on.
    pub shape: Shape,
    /// Radiance of everything around, the same from everywhere; the lamp's irradiance is 1.
    pub ambient: f64,
    /// Paths a pixel, about: the next square number is taken.
    pub rays: u32,
    /// Bounces followed.
    pub max_bounces: u32,
    /// Seed of all chance.
    pub seed: u64,
}

impl Default for ViewSettings {
    /// A plate of 30 mm at arm's length, from straight above, in a dark room.
    fn default() -> Self {
        Self {
            theta: 0.0,
            phi: 0.0,
            distance: 500.0,
            field_of_view: 4.0,
            size: [256, 256],
            shape: Shape::Flat,
            ambient: 0.0,
            rays: 64,
            max_bounces: 8,
            seed: 1,
        }
    }
}

/// A picture, pixel by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedView {
    /// Mean radiance, 1/sr for a lamp of irradiance 1 across its beam.
    pub radiance: Raster,
    /// Its standard error, on the safe side: that of paths strewn without order, which they are not.
    pub errors: Raster,
    /// Mean share of light that wanted more bounces than were followed.
    pub trapped: Raster,
}

impl ViewSettings {
    /// What the distance of the camera and the radius of a shape may be, mm.
    pub const LENGTH: std::ops::RangeInclusive<f64> = 1e-3..=1e9;
    /// What the field of view may be, degrees.
    pub const FIELD_OF_VIEW: std::ops::RangeInclusive<f64> = 1e-6..=160.0;
    /// Columns or rows at the most.
    pub const MOST_PIXELS: usize = 4096;

    /// Whether the experiment can be looked at so.
    ///
    /// # Errors
    /// A value out of its range; a camera inside the plate or the shape; a shape that is to wear a relief that ends; a
    /// smooth material in the light of a mere point.
    pub fn check<S: Surface>(&self, experiment: &Experiment<'_, S>) -> Result<(), RenderError> {
        let length = |what, value: f64| {
            if Self::LENGTH.contains(&value) { Ok(()) } else { Err(RenderError::Length { what, value }) }
        };
        length("distance of the camera", self.distance)?;
        if !((0.0..90.0).contains(&self.theta) && self.phi.is_finite()) {
            return Err(RenderError::Direction { theta: self.theta, phi: self.phi });
        }
        if !Self::FIELD_OF_VIEW.contains(&self.field_of_view) {
            return Err(RenderError::FieldOfView(self.field_of_view));
        }
        if !self.size.iter().all(|side| (1..=Self::MOST_PIXELS).contains(side)) {
            return Err(RenderError::Size(self.size));
        }
        if !(self.ambient >= 0.0 && self.ambient.is_finite()) {
            return Err(RenderError::Ambient(self.ambient));
        }
        if self.rays == 0 || self.rays > 1 << 24 {
            return Err(RenderError::Rays(self.rays));
        }
        match self.shape.radius() {
            Some(radius) => {
                length("radius of what is looked at", radius)?;
                if !experiment.surface.is_endless() {
                    return Err(RenderError::Ends);
                }
                if !matches!(experiment.lamp, Lamp::Distant(_)) {
                    return Err(RenderError::LampNearby);
                }
                // Of a cylinder the distance from its axis counts.
                let camera = self.toward() * self.distance;
                let away = if matches!(self.shape, Shape::Cylinder { .. }) { camera.with_y(0.0) } else { camera };
                if away.length() <= radius * (1.0 + 1e-9) {
                    return Err(RenderError::Inside { distance: self.distance });
                }
            }
            None => {
                if self.camera(experiment).position.z <= experiment.surface.height_range().1 {
                    return Err(RenderError::Inside { distance: self.distance });
                }
            }
        }
        if !experiment.lamp_is_above() {
            return Err(RenderError::LampInPlate);
        }
        if experiment.lamp.is_point() && experiment.material.is_smooth() && self.ambient == 0.0 {
            return Err(RenderError::PointOnSmooth { material: experiment.material.to_string() });
        }
        Ok(())
    }

    fn toward(&self) -> DVec3 {
        direction(self.theta.to_radians(), self.phi.to_radians())
    }

    fn camera<S: Surface>(&self, experiment: &Experiment<'_, S>) -> Camera {
        let target = if self.shape == Shape::Flat { experiment.surface.middle() } else { DVec3::ZERO };
        Camera::new(target, self.toward(), self.distance, self.field_of_view.to_radians(), self.size)
    }
}

/// Takes the picture; the same for any number of threads.
///
/// # Errors
/// See [`ViewSettings::check`]; also if the work was cancelled.
pub fn render<S: Surface>(
    experiment: &Experiment<'_, S>,
    settings: &ViewSettings,
    progress: &Progress,
) -> Result<RenderedView, RenderError> {
    settings.check(experiment)?;
    let pixels = PixelTracer {
        camera: settings.camera(experiment),
        tracer: PathTracer {
            surface: experiment.surface,
            material: &experiment.material,
            lamp: &experiment.lamp,
            reference: experiment.lamp.at(experiment.surface.middle()).irradiance,
            ambient: settings.ambient,
            max_bounces: settings.max_bounces,
        },
        settings,
    };
    let [width, height] = settings.size;
    let done = AtomicUsize::new(0);
    let rows: Vec<Vec<[f64; 3]>> = (0..height)
        .into_par_iter()
        .map(|row| {
            progress.check()?;
            let stream = settings.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ row as u64;
            let mut random = Xoshiro256PlusPlus::seed_from_u64(stream);
            let values = (0..width).map(|column| pixels.pixel(column, row, &mut random)).collect();
            progress.fraction((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / height as f64);
            Ok(values)
        })
        .collect::<Result<_, Cancelled>>()?;
    let raster = |k: usize| Raster { width, height, values: rows.iter().flatten().map(|pixel| pixel[k]).collect() };
    Ok(RenderedView { radiance: raster(0), errors: raster(1), trapped: raster(2) })
}

/// Steps of the sequence that fills the unit square evenly at any length: 1/g and 1/g² with g³ = g + 1, after Roberts,
/// "The Unreasonable Effectiveness of Quasirandom Sequences" (2018).
const EVENLY: DVec2 = DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_2);

struct PixelTracer<'a, S> {
    camera: Camera,
    tracer: PathTracer<'a, S>,
    settings: &'a ViewSettings,
}

impl<S: Surface> PixelTracer<'_, S> {
    /// Mean radiance of a pixel, its standard error, and the mean trapped share.
    fn pixel(&self, column: usize, row: usize, random: &mut Xoshiro256PlusPlus) -> [f64; 3] {
        let [width, height] = self.settings.size;
        let middle = View::pixel_centre(column, row, width, height);
        let half = 1.0 / DVec2::new(width as f64, height as f64);
        // Strata over the pixel, so that edges come out smooth.
        let strata = f64::from(self.settings.rays).sqrt().ceil() as u32;
        let n = f64::from(strata * strata);
        let (mut mean, mut squares, mut trapped) = (0.0, 0.0, 0.0);
        let shift = DVec2::new(random.random::<f64>(), random.random::<f64>());
        for k in 0..strata * strata {
            let place = DVec2::new(
                f64::from(k % strata) + random.random::<f64>(),
                f64::from(k / strata) + random.random::<f64>(),
            );
            let direction = self.camera.direction(middle + half * (2.0 * place / f64::from(strata) - 1.0));
            let path = self.path(direction, (shift + f64::from(k) * EVENLY).fract(), random);
            // Welford's running mean and squares.
            let off = path.radiance - mean;
            mean += off / f64::from(k + 1);
            squares += off * (path.radiance - mean);
            trapped += path.trapped / n;
        }
        let error = if n > 1.0 { (squares / (n * (n - 1.0))).sqrt() } else { f64::INFINITY };
        [mean, error, trapped]
    }

    /// One path against `direction`; on a shape it meets the relief's period at the share `start` of it.
    fn path(&self, direction: DVec3, start: DVec2, random: &mut Xoshiro256PlusPlus) -> PathLight {
        let surface = self.tracer.surface;
        let background = PathLight { radiance: self.settings.ambient, trapped: 0.0 };
        if self.settings.shape == Shape::Flat {
            let Some(hit) = surface.first(self.camera.position, direction) else { return background };
            // A relief's grid ends in sides that know no base: below the lowest point there is nothing to be seen.
            if surface.kind(hit.place) == PieceKind::Outer && hit.point.z < surface.height_range().0 {
                return background;
            }
            return self.tracer.radiance(hit, direction, &DMat3::IDENTITY, random);
        }
        let Some(frame) = self.settings.shape.frame(self.camera.position, direction) else { return background };
        let along = (frame.transpose() * direction).normalize();
        // Anywhere in the period: the relief is too fine for the eye to see where. But evenly over the pixel's paths: how
        // much facets differ from each other would be most of the noise.
        let (low, high) = surface.optical_area();
        let (_, top) = surface.height_range();
        let start = low + (high - low) * start;
        let above = top + 1e-6 * (high - low).length();
        match surface.first(start.extend(above), along) {
            Some(hit) => self.tracer.radiance(hit, along, &frame, random),
            // At the very rim of the shape a ray may skim over the relief for longer than is followed.
            None => background,
        }
    }
}

/// Why there is nothing to be seen.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RenderError {
    /// A length out of range.
    #[error("the {what} must be {low} to {high} mm, not {value}", low = ViewSettings::LENGTH.start(), high = ViewSettings::LENGTH.end())]
    Length {
        /// Which.
        what: &'static str,
        /// What it is, mm.
        value: f64,
    },
    /// A camera at or below the plate's horizon.
    #[error(
        "the camera must be 0 to less than 90 degrees from the plate's normal, at any azimuth, not at {theta},{phi}"
    )]
    Direction {
        /// Degrees.
        theta: f64,
        /// Degrees.
        phi: f64,
    },
    /// Too narrow or too wide.
    #[error("the field of view must be {low} to {high} degrees, not {0}", low = ViewSettings::FIELD_OF_VIEW.start(), high = ViewSettings::FIELD_OF_VIEW.end())]
    FieldOfView(f64),
    /// No pixels or too many.
    #[error("a picture must be 1 to {most} pixels wide and high, not {} × {}", .0[0], .0[1], most = ViewSettings::MOST_PIXELS)]
    Size([usize; 2]),
    /// Negative or endless.
    #[error("the surroundings' radiance must be a number from 0 up, not {0}")]
    Ambient(f64),
    /// None or too many.
    #[error("a pixel needs 1 to 16777216 paths, not {0}")]
    Rays(u32),
    /// The camera is inside what it looks at.
    #[error("a camera {distance} mm away is inside what it looks at: move it away")]
    Inside {
        /// mm.
        distance: f64,
    },
    /// A finite plate on a shape.
    #[error("only an endless panel can be wrapped on a sphere or a cylinder: take the relief as a panel")]
    Ends,
    /// A lamp nearby over a shape that wears a relief without end.
    #[error("a sphere or a cylinder is lit from far away only: take a distant lamp")]
    LampNearby,
    /// The lamp is too near for its size and angle.
    #[error("the lamp would dip below the top of the plate: move it away or make it smaller")]
    LampInPlate,
    /// A mirror image of a point has no extent.
    #[error(
        "a point of light is not seen in smooth {material}: give the lamp a radius (the sun has 0.2665°), or the \
         material a roughness, as in aluminium:ggx:0.2"
    )]
    PointOnSmooth {
        /// The material as it is written.
        material: String,
    },
    /// The caller wanted nothing more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

#[cfg(test)]
mod tests;
