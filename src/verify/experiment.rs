//! What is measured, how finely, and on which pixels light is collected.

use glam::DVec3;

use crate::brdf::material::Material;
use crate::lamp::Lamp;
use crate::projection::View;
use crate::scene::Scene;
use crate::setup::Setup;
use crate::trace::Surface;

/// How finely light is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measuring {
    /// Rays sent, about; with an `error`, those of the first round.
    pub rays: u64,
    /// Pixels a side of the image.
    pub resolution: usize,
    /// Bounces followed; light that wants more is counted as trapped.
    pub max_bounces: u32,
    /// Seed of the rays' jitter.
    pub seed: u64,
    /// Go on until [`Measurement::image_noise`](super::tally::Measurement::image_noise) is no more than this.
    pub error: Option<f64>,
}

impl Default for Measuring {
    fn default() -> Self {
        Self { rays: 2_000_000, resolution: 256, max_bounces: 8, seed: 1, error: None }
    }
}

/// A surface of some material under a lamp.
#[derive(Clone, Debug)]
pub struct Experiment<'a, S> {
    /// What light falls on.
    pub surface: &'a S,
    /// The highlight image, and how the plate is mounted in it.
    pub setup: &'a Setup,
    /// What the surface is made of.
    pub material: Material,
    /// Where light comes from, in the plate's frame.
    pub lamp: Lamp,
}

impl<'a, S: Surface> Experiment<'a, S> {
    /// An ideal mirror under the setup's own lamp.
    pub fn new(surface: &'a S, setup: &'a Setup) -> Self {
        Self { surface, setup, material: Material::MIRROR, lamp: setup.lamp().into() }
    }

    /// A ball of `radius` mm as lamp, its middle `distance` mm from the plate's toward the middle of the setup's light.
    pub fn under_ball(self, distance: f64, radius: f64) -> Self {
        let middle = self.surface.middle() + distance * self.setup.light();
        Self { lamp: Lamp::Ball { middle, radius }, ..self }
    }

    /// The lamp of a scene, which lies in the plate's frame with its origin at `origin`.
    pub fn in_scene(self, scene: &Scene, origin: DVec3) -> Self {
        let lamp = match scene.lamp().clone() {
            Lamp::Ball { middle, radius } => Lamp::Ball { middle: middle + origin, radius },
            distant => distant,
        };
        Self { lamp, ..self }
    }

    /// Whether all of the lamp lies above the plate, by more than rounding.
    pub(super) fn lamp_is_above(&self) -> bool {
        match &self.lamp {
            Lamp::Ball { middle, radius } => middle.z - radius > self.surface.height_range().1 + LEAST_GAP,
            _ => true,
        }
    }
}

/// From the top of the plate to the lowest point of a lamp at the least, mm.
const LEAST_GAP: f64 = 1e-6;

/// What light that leaves upward is collected on: directions sorted into pixels.
pub trait Sensor: Sync {
    /// Pixels across and down.
    fn size(&self) -> (usize, usize);

    /// The pixel of a direction, row by row, if there is one.
    fn pixel(&self, direction: DVec3) -> Option<usize>;
}

/// The highlight image of a setup.
#[derive(Clone, Copy, Debug)]
pub struct HighlightImage<'a> {
    /// Its projection.
    pub setup: &'a Setup,
    /// Pixels a side.
    pub resolution: usize,
}

impl Sensor for HighlightImage<'_> {
    fn size(&self) -> (usize, usize) {
        (self.resolution, self.resolution)
    }

    fn pixel(&self, direction: DVec3) -> Option<usize> {
        let n = self.resolution;
        let (column, row) = View::pixel_at(self.setup.image_of(direction)?, n, n)?;
        Some(row * n + column)
    }
}

/// A sensor that remembers its last answer: neighbouring paths often leave alike.
pub(super) struct LastPixel<'a, C> {
    sensor: &'a C,
    last: (DVec3, Option<usize>),
}

impl<'a, C: Sensor> LastPixel<'a, C> {
    pub(super) fn new(sensor: &'a C) -> Self {
        Self { sensor, last: (DVec3::ZERO, None) }
    }

    #[inline]
    pub(super) fn of(&mut self, direction: DVec3) -> Option<usize> {
        if direction != self.last.0 {
            self.last = (direction, self.sensor.pixel(direction));
        }
        self.last.1
    }
}
