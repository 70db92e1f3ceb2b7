//! Rays of a lamp, each followed from its first hit to its end, and all of them tallied.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::experiment::{Experiment, LastPixel, Measuring, Sensor};
use super::ray_grid::RayGrid;
use super::tally::{PARTS, Tally};
use crate::progress::{Cancelled, Progress};
use crate::trace::path::{End, PathFollower};
use crate::trace::{Hit, PieceKind, Surface};

/// Which rays count, and where they are counted.
pub(super) struct Collection<W, L> {
    /// Pixels across and down.
    pub size: (usize, usize),
    /// Whether rays count that first meet a piece of this kind.
    pub wanted: W,
    /// Makes, for each part of the work, what says on which pixel the light of a path falls; it may also think better of
    /// how the path ended.
    pub landing: L,
}

/// Rays of the experiment's lamp, those that first meet what `wanted` says, collected on `sensor`.
pub(super) fn follow_to_sensor<S: Surface, C: Sensor>(
    experiment: &Experiment<'_, S>,
    sensor: &C,
    measuring: &Measuring,
    wanted: impl Fn(PieceKind) -> bool + Sync,
    progress: &Progress,
) -> Result<Vec<Tally>, Cancelled> {
    let landing = || {
        let mut pixels = LastPixel::new(sensor);
        move |end: &mut End| pixels.of(end.direction)
    };
    follow_all(experiment, measuring, &Collection { size: sensor.size(), wanted, landing }, progress)
}

/// Follows rays of the experiment's lamp to their ends: tallies of [`PARTS`] parts, in mm² of horizontal area.
pub(super) fn follow_all<S, W, L, P>(
    experiment: &Experiment<'_, S>,
    measuring: &Measuring,
    collection: &Collection<W, L>,
    progress: &Progress,
) -> Result<Vec<Tally>, Cancelled>
where
    S: Surface,
    W: Fn(PieceKind) -> bool + Sync,
    L: Fn() -> P + Sync,
    P: FnMut(&mut End) -> Option<usize>,
{
    let surface = experiment.surface;
    let rays = RayGrid::new(surface, &experiment.lamp, measuring.rays);
    let (low, high) = surface.optical_area();
    let incident = |hit: &Hit<S::Place>| {
        let (at, kind) = (hit.point.truncate(), surface.kind(hit.place));
        kind != PieceKind::Outer && (collection.wanted)(kind) && (at.cmpge(low) & at.cmple(high)).all()
    };
    let part = |part: usize| {
        let mut follower = PathFollower::new(surface, &experiment.material, measuring.max_bounces);
        let mut pixel_of = (collection.landing)();
        let mut tally = Tally::empty(collection.size);
        // Part k takes rows k, k + PARTS, … of the grid.
        for row in (part..rays.rows).step_by(PARTS) {
            progress.check()?;
            // One stream a row: neither threads nor the number of parts touch the bytes.
            let stream = measuring.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ row as u64;
            let mut random = Xoshiro256PlusPlus::seed_from_u64(stream);
            for column in 0..rays.columns {
                let (origin, direction, weight) = rays.ray(column, row, &mut random);
                let Some(hit) = surface.first(origin, direction).filter(incident) else { continue };
                let weight = weight * rays.share();
                tally.incident += weight;
                tally.rays += 1;
                if surface.kind(hit.place) == PieceKind::Wall {
                    tally.first_hit_wall += weight;
                }
                let mut end = follower.follow(hit, direction, &mut random);
                let pixel = pixel_of(&mut end);
                tally.count(&end, weight, pixel);
            }
            if part == 0 {
                progress.fraction(row as f64 / rays.rows as f64);
            }
        }
        Ok(tally)
    };
    (0..PARTS).into_par_iter().map(part).collect()
}
