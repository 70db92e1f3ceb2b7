//! Light of a point lamp off smooth facets: the first bounce in closed form, rays only for what shadows and bounces change.
//!
//! Each facet of footprint A takes A (l·m)/(m·z) of the beam and sends its mirror share of it one way. Rays start on
//! the facets: what they find shadowed, or meeting the surface again, is taken from that closed form and added where it
//! truly ends. Where nothing is in the way nothing is random. Light that first meets a wall has no facet to start from:
//! rays from above find it.

use glam::DVec3;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::experiment::{Experiment, LastPixel, Measuring, Sensor};
use super::follow::follow_to_sensor;
use super::tally::{PARTS, Tally};
use crate::progress::{Cancelled, Progress};
use crate::slope::mirror;
use crate::trace::path::{End, Fate, PathFollower};
use crate::trace::{Hit, PieceKind, Surface};

/// Least tilt of the light at which walls are lit.
const SLANT: f64 = 1e-9;

/// Tallies in mm² of horizontal area, [`PARTS`] of them, of light that all comes from `light` (a unit vector).
pub(super) fn parts<S: Surface, C: Sensor>(
    experiment: &Experiment<'_, S>,
    light: DVec3,
    sensor: &C,
    measuring: &Measuring,
    progress: &Progress,
) -> Result<Vec<Tally>, Cancelled> {
    let slanting = light.truncate().length() > SLANT;
    // Half of the rays for what little meets walls: there each counts in full.
    let rays = if slanting { measuring.rays / 2 } else { measuring.rays };
    let measuring = Measuring { rays: rays.max(PARTS as u64), ..*measuring };
    let mut tallies = over_facets(experiment, light, sensor, &measuring, progress)?;
    if slanting {
        let walls = follow_to_sensor(experiment, sensor, &measuring, |kind| kind == PieceKind::Wall, progress)?;
        tallies.iter_mut().zip(&walls).for_each(|(tally, more)| tally.add(more, 1.0));
    }
    Ok(tallies)
}

fn over_facets<S: Surface, C: Sensor>(
    experiment: &Experiment<'_, S>,
    light: DVec3,
    sensor: &C,
    measuring: &Measuring,
    progress: &Progress,
) -> Result<Vec<Tally>, Cancelled> {
    let &Experiment { surface, ref material, .. } = experiment;
    let beams = Beams::new(surface, light, progress)?;
    let step = beams.whole() / measuring.rays as f64;
    let known = closed_form(experiment, light, sensor, &beams, progress)?;
    let samples = beams.turn(beams.whole(), step, measuring.seed);
    (0..PARTS)
        .into_par_iter()
        .map(|part| {
            let mut follower = PathFollower::new(surface, material, measuring.max_bounces);
            let mut pixels = LastPixel::new(sensor);
            let mut tally = Tally::empty(sensor.size());
            tally.add(&known, 1.0 / PARTS as f64);
            // A smooth material looks at no random number.
            let mut idle = Xoshiro256PlusPlus::seed_from_u64(0);
            // Samples come in order, and so do their facets.
            let mut k = 0;
            for sample in (part as u64..samples).step_by(PARTS) {
                if (sample as usize / PARTS).is_multiple_of(4096) {
                    progress.check()?;
                    if part == 0 {
                        progress.fraction(sample as f64 / samples as f64);
                    }
                }
                k = beams.facet_of(sample, (step, measuring.seed), k);
                let Some((place, end)) = first_bounce(experiment, light, k) else { continue };
                // Where each facet has its sample, all samples together stand for just its flux.
                let (flux, of_facet) = (beams.of(k), beams.samples(k, step, measuring.seed));
                let weight = if flux >= step { flux / of_facet.len() as f64 } else { step };
                let (shift, m) =
                    (hash(measuring.seed, k as u64), sample - beams.turn(beams.before(k), step, measuring.seed));
                let pixel = pixels.of(end.direction);
                tally.rays += 1;
                let hit = Hit { point: surface.point_on(k, scattered(shift, m)), place };
                if surface.next(&hit, light).is_some() {
                    tally.incident -= weight;
                    tally.count(&end, -weight, pixel);
                    continue;
                }
                let found = follower.follow(hit, -light, &mut idle);
                if found.bounces != 1 || found.fate != end.fate {
                    tally.count(&end, -weight, pixel);
                    tally.count(&found, weight, pixels.of(found.direction));
                }
            }
            Ok(tally)
        })
        .collect()
}

/// Where the light of facet `k` would go if nothing stood in its way; the facet's name with it.
fn first_bounce<S: Surface>(experiment: &Experiment<'_, S>, light: DVec3, k: usize) -> Option<(S::Place, End)> {
    let (place, _) = experiment.surface.facet(k)?;
    let normal = experiment.surface.normal(place);
    let direction = mirror(light, normal);
    let weight = experiment.material.smooth_share(DVec3::new(0.0, 0.0, light.dot(normal)));
    let fate = if direction.z > 0.0 { Fate::Up } else { Fate::Down };
    Some((place, End { fate, weight, bounces: 1, point: DVec3::ZERO, direction }))
}

/// The light of all facets if nothing stood in its way, in mm² of horizontal area.
fn closed_form<S: Surface, C: Sensor>(
    experiment: &Experiment<'_, S>,
    light: DVec3,
    sensor: &C,
    beams: &Beams,
    progress: &Progress,
) -> Result<Tally, Cancelled> {
    let facets = experiment.surface.facets();
    // A fixed number of stretches, so that sums do not depend on threads.
    let stretch = |part: usize| {
        let mut pixels = LastPixel::new(sensor);
        let mut tally = Tally::empty(sensor.size());
        let first = part * facets / PARTS;
        for some in progress.stretches((part + 1) * facets / PARTS - first) {
            for k in some?.map(|k| first + k) {
                let flux = beams.of(k);
                if let Some((_, end)) = first_bounce(experiment, light, k).filter(|_| flux > 0.0) {
                    tally.incident += flux;
                    tally.count(&end, flux, pixels.of(end.direction));
                }
            }
        }
        Ok(tally)
    };
    let stretches = (0..PARTS).into_par_iter().map(stretch).collect::<Result<Vec<Tally>, Cancelled>>()?;
    let mut all = Tally::empty(sensor.size());
    stretches.iter().for_each(|tally| all.add(tally, 1.0));
    Ok(all)
}

/// What each facet takes of the beam, as horizontal area, mm².
pub(super) struct Beams {
    /// Up to and including each facet.
    cumulative: Vec<f64>,
}

impl Beams {
    pub(super) fn new<S: Surface>(surface: &S, light: DVec3, progress: &Progress) -> Result<Self, Cancelled> {
        let mut sum = 0.0;
        let mut cumulative = Vec::with_capacity(surface.facets());
        for some in progress.stretches(surface.facets()) {
            cumulative.extend(some?.map(|k| {
                if let Some((place, footprint)) = surface.facet(k) {
                    let normal = surface.normal(place);
                    sum += footprint * (light.dot(normal) / (normal.z * light.z)).max(0.0);
                }
                sum
            }));
        }
        Ok(Self { cumulative })
    }

    fn before(&self, k: usize) -> f64 {
        if k == 0 { 0.0 } else { self.cumulative[k - 1] }
    }

    fn of(&self, k: usize) -> f64 {
        self.cumulative[k] - self.before(k)
    }

    /// The samples, each for `step` mm² of the beam, whose turn comes within the share of facet `k`: the facet's own shift
    /// and the sample's rank on the facet, for [`scattered`].
    pub(super) fn samples(&self, k: usize, step: f64, seed: u64) -> impl ExactSizeIterator<Item = (u64, u64)> + use<> {
        let before = self.before(k);
        let count = self.turn(before + self.of(k), step, seed) - self.turn(before, step, seed);
        let shift = hash(seed, k as u64);
        (0..count as usize).map(move |m| (shift, m as u64))
    }

    /// The facet on which the sample lies that comes as number `sample`, looked for from facet `from` on.
    fn facet_of(&self, sample: u64, (step, seed): (f64, u64), from: usize) -> usize {
        let offset = unit(hash(seed, u64::MAX));
        // Whose turn comes before: a number rounded up is at most a whole number just where it is itself.
        let is_before = |flux: &f64| flux / step - offset <= sample as f64;
        let ahead = &self.cumulative[from..];
        // Facets near the one before are likely, so that the stretch looked at is doubled until it holds the one.
        let mut stretch = 16;
        while stretch < ahead.len() && is_before(&ahead[stretch - 1]) {
            stretch *= 2;
        }
        from + ahead[..stretch.min(ahead.len())].partition_point(is_before)
    }

    /// Samples whose turn comes before `flux` of the beam is gone through.
    fn turn(&self, flux: f64, step: f64, seed: u64) -> u64 {
        // Where the first of all lies within its stratum.
        let offset = unit(hash(seed, u64::MAX));
        (flux / step - offset).ceil().max(0.0) as u64
    }

    pub(super) fn whole(&self) -> f64 {
        self.cumulative[self.cumulative.len() - 1]
    }
}

/// Point `m` of the evenest of additive sequences in the square (Roberts' R2), shifted at random.
pub(super) fn scattered(shift: u64, m: u64) -> [f64; 2] {
    // 1/g and 1/g² of g³ = g + 1, in units of 2⁻⁶⁴: wrapping addition keeps the fraction.
    const STEPS: [u64; 2] = [0xc13f_a9a9_02a6_328f, 0x91e1_0da5_c79e_7b1d];
    let shifts = [shift, shift.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (shift >> 31)];
    [0, 1].map(|axis| unit(shifts[axis].wrapping_add(STEPS[axis].wrapping_mul(m))))
}

fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

/// Bits that look random, of a stream and an index (the finaliser of SplitMix64, Steele et al. 2014).
fn hash(seed: u64, index: u64) -> u64 {
    let mut bits = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index.wrapping_mul(0xd1b5_4a32_d192_ed03));
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}
