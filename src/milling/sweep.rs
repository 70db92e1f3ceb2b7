//! What a cutter leaves that goes along tracks: at each place the lowest underside that passes over it.
//!
//! The tracks are samples on one grid along the passes, and so are the places that are asked, up to a shift that they all
//! share. So the underside over each pair of track and distance is looked up once a row, and the rest is sums and least
//! values of rows, which a compiler turns into wide instructions.

use glam::DVec2;
use rayon::prelude::*;

use super::machine::Machine;
use super::passes::{Frame, Pass, Ways};
use super::track::{Samples, Which, whole};
use crate::cutter::Profile;

/// Places handled at once, so that they stay in the nearest cache.
const BLOCK: usize = 1024;

/// A cut lower than its neighbours by so many standard deviations is as low as any of a plate's million.
const DEVIATIONS: f64 = 6.0;

/// A cutter as it turns: worn, and off the spindle's axis.
#[derive(Clone, Copy)]
struct Turning {
    profile: Profile,
    runout: f64,
    /// Radius of the flat at its tip, mm, and how far that is above the tip that it had.
    flat: f64,
    worn: f64,
}

impl Turning {
    fn new(profile: Profile, machine: &Machine) -> Self {
        let flat = machine.tip_flat.min(profile.reach);
        Self { profile, runout: machine.runout, flat, worn: profile.underside(flat) }
    }

    /// Height of what it sweeps above its tip, mm, at `r` ≥ 0 mm from the spindle's axis.
    fn underside(&self, r: f64) -> f64 {
        (self.profile.underside((r - self.runout).max(0.0)) - self.worn).max(0.0)
    }

    /// Rise of that outward.
    fn rise(&self, r: f64) -> f64 {
        let r = r - self.runout;
        if r <= self.flat { 0.0 } else { self.profile.rise(r) }
    }

    /// Beyond its own size, how far from the axis it can be the lowest.
    fn wider_by(&self) -> f64 {
        self.runout + self.flat.max(self.profile.flat)
    }
}

/// One pass as it was cut.
struct Track {
    /// Its place across the frame, mm.
    y: f64,
    /// Heights of the tip, mm, infinite where no tooth cuts.
    tips: Vec<f32>,
}

/// A track over some places of a row, each of them as far from the cutter's axis when it is at one of the track's samples.
#[derive(Clone, Copy)]
struct Over<'a> {
    /// From the axis to the place, mm.
    from_axis: DVec2,
    /// Height of the cutter's underside above its tip there, mm.
    above: f32,
    /// Places of the row that it misses, and the tips' heights over those that follow.
    skipped: usize,
    tips: &'a [f32],
    /// All of the track, and its sample over the first place of the row.
    track: &'a [f32],
    begin: isize,
}

/// All passes over a plate, as one machine cut them.
pub struct Sweep {
    frame: Frame,
    cutter: Turning,
    tracks: Vec<Track>,
    samples: Samples,
    /// Farthest from its axis that a cutter leaves anything, mm.
    window: f64,
}

impl Sweep {
    /// Passes along `ways` by `machine` with a cutter of `profile`, samples `step` mm apart; its random errors follow from
    /// `seed`.
    pub fn new(ways: &Ways, (profile, machine): (Profile, &Machine), step: f64, seed: u64) -> Self {
        let cutter = Turning::new(profile, machine);
        let tooth = ((machine.feed_per_tooth / step).round() as usize).max(1);
        let apart = ways.stepover.hypot(step * tooth as f64);
        let lowest = profile.radius_at(DEVIATIONS * machine.scatter());
        let window =
            (profile.contact(ways.steepest) + cutter.wider_by() + lowest + apart).min(profile.reach + machine.runout);
        let ahead = (ways.overrun / step).ceil();
        let count = (ways.frame.size.x / step).round() as usize + 1 + 2 * ahead as usize;
        let samples = Samples { from: -ahead * step, step, count, tooth };
        let cut = |(k, Pass { y, backward, way }): (usize, &Pass)| {
            let which = Which { index: k as u64, backward: *backward };
            // Across the passes the machine goes in whole steps too.
            Track { y: whole(*y, machine.step), tips: way.cut(machine, seed, which, samples) }
        };
        let tracks = ways.ways.par_iter().enumerate().map(cut).collect();
        Self { frame: ways.frame, cutter, tracks, samples, window }
    }

    /// The rectangle of passes.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// From one sample along a pass to the next, mm.
    pub fn step(&self) -> f64 {
        self.samples.step
    }

    /// Places along the frame at which a row is known, one a sample, both ends included.
    pub fn columns(&self) -> usize {
        (self.frame.size.x / self.samples.step).round() as usize + 1
    }

    /// Heights, mm, of a row at `y` mm across the frame, at each of its [`columns`](Self::columns) places.
    pub fn row(&self, y: f64, heights: &mut [f32]) {
        heights.fill(f32::INFINITY);
        for (block, out) in heights.chunks_mut(BLOCK).enumerate() {
            self.passing(y, 0.0, block * BLOCK, out.len(), |over| {
                for (out, tip) in out[over.skipped..].iter_mut().zip(over.tips) {
                    let z = tip + over.above;
                    *out = if z < *out { z } else { *out };
                }
            });
        }
    }

    /// Height at a place of the frame, mm; infinite where nothing is cut.
    pub fn height(&self, place: DVec2) -> f64 {
        let Samples { from, step, count, .. } = self.samples;
        let first = self.tracks.partition_point(|track| track.y < place.y - self.window);
        let last = self.tracks.partition_point(|track| track.y <= place.y + self.window);
        let mut passed: Vec<&Track> = self.tracks[first..last].iter().collect();
        // The nearest first: it says how far others can matter.
        passed.sort_by(|a, b| (a.y - place.y).abs().total_cmp(&(b.y - place.y).abs()));
        let mut lowest = f64::INFINITY;
        for track in passed {
            let across = place.y - track.y;
            let within = |reach: f64| {
                let [first, last] = [place.x - reach, place.x + reach].map(|x| (x - from) / step);
                let last = (last.floor() + 1.0).clamp(0.0, count as f64) as usize;
                (first.ceil().max(0.0) as usize).min(last)..last
            };
            let reach = (self.window * self.window - across * across).max(0.0).sqrt();
            let tip = track.tips[within(reach)].iter().copied().fold(f32::INFINITY, f32::min);
            // Where no tooth cuts nothing is left, nor where the underside is higher than what is found.
            let above = lowest - f64::from(tip);
            if above <= 0.0 || !tip.is_finite() {
                continue;
            }
            let high = if above.is_finite() { self.cutter.profile.radius_at(above + self.cutter.worn) } else { reach };
            let near = (high + self.cutter.runout).min(self.window);
            let reach = (near * near - across * across).max(0.0).sqrt().min(reach);
            for k in within(reach) {
                let tip = f64::from(track.tips[k]);
                let along = place.x - (from + step * k as f64);
                lowest = lowest.min(tip + self.cutter.underside(along.hypot(across)));
            }
        }
        lowest
    }

    /// Slopes along and across the frame of a row at `y` mm, its places shifted by `shift` mm along it; not a number where
    /// nothing is cut.
    pub fn slopes(&self, y: f64, shift: f64, slopes: &mut [DVec2]) {
        let mut heights = [f32::INFINITY; BLOCK];
        let mut winners = [0u32; BLOCK];
        for (block, out) in slopes.chunks_mut(BLOCK).enumerate() {
            let (heights, winners) = (&mut heights[..out.len()], &mut winners[..out.len()]);
            heights.fill(f32::INFINITY);
            let mut passed: Vec<Over> = Vec::new();
            self.passing(y, shift, block * BLOCK, out.len(), |over| {
                let name = passed.len() as u32;
                passed.push(over);
                let places = heights[over.skipped..].iter_mut().zip(&mut winners[over.skipped..]);
                for ((height, winner), tip) in places.zip(over.tips) {
                    let z = tip + over.above;
                    let lower = z < *height;
                    *height = if lower { z } else { *height };
                    *winner = if lower { name } else { *winner };
                }
            });
            for (place, (out, height)) in out.iter_mut().zip(heights.iter()).enumerate() {
                let touching = || self.touching(&passed[winners[place] as usize], place);
                *out = if height.is_finite() { self.slope_at(touching()) } else { DVec2::NAN };
            }
        }
    }

    /// From the axis of the cutter that passes lowest over a place of a row to that place, mm. One whose teeth are not told
    /// apart touches between two samples, where the parabola through three of them is lowest.
    fn touching(&self, over: &Over, place: usize) -> DVec2 {
        if self.samples.tooth > 1 {
            return over.from_axis;
        }
        let along = |samples: f64| over.from_axis - DVec2::X * (self.samples.step * samples);
        let height = |aside: isize| {
            let k = usize::try_from(over.begin + place as isize + aside).ok()?;
            Some(f64::from(*over.track.get(k)?) + self.cutter.underside(along(aside as f64).length()))
        };
        let (Some(before), Some(here), Some(after)) = (height(-1), height(0), height(1)) else { return over.from_axis };
        let bend = before - 2.0 * here + after;
        let bends = bend > 0.0 && bend.is_finite();
        along(if bends { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 })
    }

    /// Slope that the cutter leaves at a place so far from its axis.
    fn slope_at(&self, from_axis: DVec2) -> DVec2 {
        let r = from_axis.length();
        if r > 0.0 { from_axis * (self.cutter.rise(r) / r) } else { DVec2::ZERO }
    }

    /// Tells `visit`, of `count` places of a row from place `first` on, every sample of every track that can be over them.
    fn passing<'a>(&'a self, y: f64, shift: f64, first: usize, count: usize, mut visit: impl FnMut(Over<'a>)) {
        let Samples { from, step, count: all, .. } = self.samples;
        // Sample over the first place of the row.
        let ahead = (-from / step).round() as isize + first as isize;
        let low = self.tracks.partition_point(|track| track.y < y - self.window);
        for track in self.tracks[low..].iter().take_while(|track| track.y <= y + self.window) {
            let across = y - track.y;
            let reach = (self.window * self.window - across * across).max(0.0).sqrt();
            let places = (reach / step).ceil() as isize;
            for m in -places..=places {
                let from_axis = DVec2::new(shift - m as f64 * step, across);
                let above = self.cutter.underside(from_axis.length());
                // Of the row, the part that has samples of the track over it.
                let begin = ahead + m;
                let [low, high] = [-begin, all as isize - begin].map(|k| k.clamp(0, count as isize));
                if low < high && above.is_finite() {
                    let tips = &track.tips[(begin + low) as usize..(begin + high) as usize];
                    let (above, skipped) = (above as f32, low as usize);
                    visit(Over { from_axis, above, skipped, tips, track: &track.tips, begin });
                }
            }
        }
    }
}
