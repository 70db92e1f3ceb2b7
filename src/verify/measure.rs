//! Light over a surface, collected as a highlight image: rays, bounces, and where they end.
//!
//! The accounting is that of the independent referee. Rays come in on a jittered grid above the plate; a ray is
//! incident if the first thing that it meets is relief or an inner wall inside the optical area. Every share is a
//! share of incident flux. Where a smooth facet under a point of light sends its beam is known without rays: then rays
//! only find what shadows and further bounces change.

use glam::DVec3;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::first_bounce;
use super::lamp::Lamp;
use super::launch::RayGrid;
use super::near_lamp::Rays;
use super::tally::{Measurement, PARTS, Tally};
use crate::brdf::material::Material;
use crate::progress::Progress;
use crate::projection::View;
use crate::setup::Setup;
use crate::trace::path::{End, Follower};
use crate::trace::traced_plate::Task;
use crate::trace::{Hit, Kind, Surface};

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
    /// Go on until [`Measurement::image_noise`] is no more than this.
    pub error: Option<f64>,
}

impl Default for Measuring {
    fn default() -> Self {
        Self { rays: 2_000_000, resolution: 256, max_bounces: 8, seed: 1, error: None }
    }
}

/// A surface of some material under a distant lamp.
#[derive(Clone, Debug)]
pub struct Experiment<'a, S> {
    /// What light falls on.
    pub surface: &'a S,
    /// Where light comes from, and the highlight image around its mirror direction.
    pub setup: &'a Setup,
    /// What the surface is made of.
    pub material: Material,
    /// The lamp's shape around the setup's light.
    pub lamp: Lamp,
}

impl<'a, S: Surface> Experiment<'a, S> {
    /// An ideal mirror under the setup's own round lamp.
    pub fn new(surface: &'a S, setup: &'a Setup) -> Self {
        Self { surface, setup, material: Material::MIRROR, lamp: Lamp::round(setup.light_radius()) }
    }
}

/// What light that leaves upward is collected on: directions sorted into pixels.
pub trait Screen: Sync {
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

impl Screen for HighlightImage<'_> {
    fn size(&self) -> (usize, usize) {
        (self.resolution, self.resolution)
    }

    fn pixel(&self, direction: DVec3) -> Option<usize> {
        let n = self.resolution;
        let (column, row) = View::pixel_at(self.setup.image_of(direction)?, n, n)?;
        Some(row * n + column)
    }
}

/// Rounds of a measurement that is to reach an error, each as long as all before it.
const MOST_ROUNDS: u32 = 12;

/// Sends light over the surface and collects it in the highlight image of its setup.
///
/// `None` if no ray met the optical area, or the work was cancelled.
pub fn measure<S: Surface>(
    experiment: &Experiment<'_, S>,
    measuring: &Measuring,
    progress: &Progress,
) -> Option<Measurement> {
    let screen = HighlightImage { setup: experiment.setup, resolution: measuring.resolution };
    collect(experiment, &screen, measuring, progress)
}

/// Any plate of some metal under the setup's own round lamp: [`measure`] for [`Plate::run`](crate::trace::traced_plate::TracedPlate::run).
#[derive(Clone, Copy)]
pub struct Mirrored<'a> {
    /// Light and image.
    pub setup: &'a Setup,
    /// What the plate is made of.
    pub metal: &'a Material,
    /// How finely.
    pub measuring: &'a Measuring,
    /// Who listens.
    pub progress: &'a Progress<'a>,
}

impl Task for Mirrored<'_> {
    type Output = Option<Measurement>;

    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let experiment = Experiment { material: self.metal.clone(), ..Experiment::new(surface, self.setup) };
        measure(&experiment, self.measuring, self.progress)
    }
}

/// Sends light over the surface and collects it on `screen`; the same for any number of threads.
///
/// `None` if no ray met the optical area, or the work was cancelled.
pub fn collect<S: Surface, C: Screen>(
    experiment: &Experiment<'_, S>,
    screen: &C,
    measuring: &Measuring,
    progress: &Progress,
) -> Option<Measurement> {
    until_error(measuring, |measuring| round(experiment, screen, measuring, progress))
}

/// One round, and if an error is asked for, more of them with other random numbers until it is reached.
pub(super) fn until_error(
    measuring: &Measuring,
    round: impl Fn(&Measuring) -> Option<Measurement>,
) -> Option<Measurement> {
    let mut measurement = round(measuring)?;
    let Some(error) = measuring.error else { return Some(measurement) };
    for k in 0..MOST_ROUNDS {
        if measurement.image_noise() <= error {
            break;
        }
        let seed = measuring.seed.wrapping_add(u64::from(k + 1) << 32);
        measurement.merge(&round(&Measuring { rays: measuring.rays << k, seed, ..*measuring })?);
    }
    Some(measurement)
}

fn round<S: Surface, C: Screen>(
    experiment: &Experiment<'_, S>,
    screen: &C,
    measuring: &Measuring,
    progress: &Progress,
) -> Option<Measurement> {
    let known = experiment.lamp.is_point() && experiment.material.is_smooth() && experiment.surface.facets() > 0;
    let parts = if known {
        first_bounce::parts(experiment, screen, measuring, progress)
    } else {
        sent(experiment, screen, measuring, |_| true, progress)
    };
    Measurement::of_parts(parts).filter(|_| !progress.is_abandoned())
}

/// Rays of the distant lamp, those that first meet what `wanted` says, collected on `screen`.
pub(super) fn sent<S: Surface, C: Screen>(
    experiment: &Experiment<'_, S>,
    screen: &C,
    measuring: &Measuring,
    wanted: impl Fn(Kind) -> bool + Sync,
    progress: &Progress,
) -> Vec<Tally> {
    let Experiment { surface, setup, lamp, .. } = experiment;
    let rays = Rays::Far(RayGrid::new(*surface, setup.light(), lamp, measuring.rays));
    let landing = || {
        let mut pixels = Pixels::new(screen);
        move |end: &mut End| pixels.of(end.direction)
    };
    follow_all(experiment, &rays, screen.size(), measuring, wanted, landing, progress)
}

/// Follows `rays`, those that first meet what `wanted` says: tallies of [`PARTS`] parts, in mm² of horizontal area.
///
/// Each part makes itself a `landing`, which says on which pixel of the picture of `size` light falls at its end, and
/// may think better of how it ended.
pub(super) fn follow_all<S: Surface, L: FnMut(&mut End) -> Option<usize>>(
    experiment: &Experiment<'_, S>,
    rays: &Rays<'_>,
    size: (usize, usize),
    measuring: &Measuring,
    wanted: impl Fn(Kind) -> bool + Sync,
    landing: impl Fn() -> L + Sync,
    progress: &Progress,
) -> Vec<Tally> {
    let surface = experiment.surface;
    let (low, high) = surface.optical_area();
    let incident = |hit: &Hit<S::Place>| {
        let (at, kind) = (hit.point.truncate(), surface.kind(hit.place));
        kind != Kind::Outer && wanted(kind) && (at.cmpge(low) & at.cmple(high)).all()
    };
    (0..PARTS)
        .into_par_iter()
        .map(|part| {
            let mut follower = Follower::new(surface, &experiment.material, measuring.max_bounces);
            let mut land = landing();
            let mut tally = Tally::empty(size);
            // Part k takes rows k, k + PARTS, … of the grid.
            for row in (part..rays.rows()).step_by(PARTS) {
                if progress.is_abandoned() {
                    break;
                }
                // One stream a row: neither threads nor the number of parts touch the bytes.
                let stream = measuring.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ row as u64;
                let mut random = Xoshiro256PlusPlus::seed_from_u64(stream);
                for column in 0..rays.columns() {
                    let (origin, direction, weight) = rays.ray(column, row, &mut random);
                    let Some(hit) = surface.first(origin, direction).filter(incident) else { continue };
                    let weight = weight * rays.share();
                    tally.incident += weight;
                    tally.rays += 1;
                    if surface.kind(hit.place) == Kind::Wall {
                        tally.first_hit_wall += weight;
                    }
                    let mut end = follower.follow(hit, direction, &mut random);
                    let pixel = land(&mut end);
                    tally.count(&end, weight, pixel);
                }
                if part == 0 {
                    progress.fraction(row as f64 / rays.rows() as f64);
                }
            }
            tally
        })
        .collect()
}

/// A screen that remembers its last answer: neighbouring paths often leave alike.
pub(super) struct Pixels<'a, C> {
    screen: &'a C,
    last: (DVec3, Option<usize>),
}

impl<'a, C: Screen> Pixels<'a, C> {
    pub(super) fn new(screen: &'a C) -> Self {
        Self { screen, last: (DVec3::ZERO, None) }
    }

    #[inline]
    pub(super) fn of(&mut self, direction: DVec3) -> Option<usize> {
        if direction != self.last.0 {
            self.last = (direction, self.screen.pixel(direction));
        }
        self.last.1
    }
}
