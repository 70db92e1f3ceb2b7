//! Parallel passes over a plate: where they lie, and where the cutter's tip should be along each.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::machine::Machine;
use super::tip::TipHeights;
use super::track::{Way, whole};
use crate::cutter::Profile;
use crate::progress::{Cancelled, Progress};

/// Slope up to which contacts beyond the plate's rim are wanted: steeper than any relief that throws a highlight.
const STEEPEST: f64 = 0.6;

/// How a plate is gone over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passes {
    /// Direction of the passes, radians from +x toward +y.
    pub angle: f64,
    /// From one pass to the next, mm.
    pub stepover: f64,
    /// Whether every other pass is cut on the way back.
    pub zigzag: bool,
}

/// The rectangle of passes around a plate, in its own axes: along the passes and across them, from its lower left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    middle: DVec2,
    along: DVec2,
    /// Size along and across, mm.
    pub size: DVec2,
}

impl Frame {
    /// Around a plate of `plate` mm whose lower left corner is x = y = 0, turned by `angle` radians.
    pub fn new(plate: DVec2, angle: f64) -> Self {
        // Of right angles the cosine is not quite zero.
        let tidy = |v: f64| if v.abs() < 1e-12 { 0.0 } else { v };
        let along = DVec2::new(tidy(angle.cos()), tidy(angle.sin()));
        let across = along.perp();
        let size = DVec2::new(plate.dot(along.abs()), plate.dot(across.abs()));
        Self { middle: 0.5 * plate, along, size }
    }

    /// A place of the frame on the plate, mm.
    pub fn on_plate(&self, place: DVec2) -> DVec2 {
        self.middle + self.turned(place - 0.5 * self.size)
    }

    /// Size of the plate, mm.
    pub fn plate(&self) -> DVec2 {
        2.0 * self.middle
    }

    /// Whether a place in the plate's own axes, mm, lies on it.
    pub fn is_on_plate(&self, place: DVec2) -> bool {
        place.cmpge(DVec2::ZERO).all() && place.cmple(self.plate()).all()
    }

    /// A place of the plate in the frame, mm.
    pub fn of_plate(&self, place: DVec2) -> DVec2 {
        let from = place - self.middle;
        DVec2::new(from.dot(self.along), from.dot(self.along.perp())) + 0.5 * self.size
    }

    /// From where to where a pass at `y` mm across the frame, which begins and ends `overrun` mm beyond it, runs no farther than
    /// that and a `stepover` beside the plate, mm along the frame; `None` if nowhere.
    fn beside_plate(&self, y: f64, overrun: f64, stepover: f64) -> Option<[f64; 2]> {
        let start = self.on_plate(DVec2::new(0.0, y));
        let (low, high) = (DVec2::splat(-overrun - stepover), self.plate() + overrun + stepover);
        let mut ends = [-overrun, self.size.x + overrun];
        for axis in 0..2 {
            let (at, along) = (start[axis], self.along[axis]);
            if along == 0.0 {
                (low[axis]..=high[axis]).contains(&at).then_some(())?;
            } else {
                let [a, b] = [(low[axis] - at) / along, (high[axis] - at) / along];
                ends = [ends[0].max(a.min(b)), ends[1].min(a.max(b))];
            }
        }
        (ends[0] < ends[1]).then_some(ends)
    }

    /// A vector of the frame, such as a slope, on the plate.
    pub fn turned(&self, vector: DVec2) -> DVec2 {
        vector.x * self.along + vector.y * self.along.perp()
    }
}

/// One pass.
pub(super) struct Pass {
    /// Its place across the frame, mm.
    pub(super) y: f64,
    /// Whether it is cut against the direction in which places count.
    pub(super) backward: bool,
    /// Heights of the tip.
    pub(super) way: Way,
}

/// Where the tip of a cutter should be along every pass.
pub struct Ways {
    /// The rectangle of passes.
    pub(super) frame: Frame,
    /// How far passes and their ends lie beyond it, mm.
    pub(super) overrun: f64,
    /// From one pass to the next, mm, at the most.
    pub(super) stepover: f64,
    /// The passes, in the order of cutting.
    pub(super) ways: Vec<Pass>,
    /// The steepest that tips rise from place to place.
    pub(super) steepest: f64,
}

impl Ways {
    /// Leads the cutter over a plate of `plate` mm whose lower left corner is x = y = 0, at places `step` mm apart along
    /// each pass, and passes at whole multiples of `quantum` mm.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn new(
        tips: &TipHeights,
        plate: DVec2,
        passes: &Passes,
        [step, quantum]: [f64; 2],
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let frame = Frame::new(plate, passes.angle);
        let (beyond, count) = count(&frame, overrun(tips.profile()), passes.stepover);
        let place = |k: usize| ((k as f64 + 0.5 - beyond) * passes.stepover, passes.zigzag && k % 2 == 1);
        let places: Vec<(f64, bool)> = (0..count).map(place).collect();
        Self::at(tips, (frame, passes.stepover), &places, [step, quantum], progress)
    }

    /// The same along x at stated places y (mm), each with whether it is cut on the way back, in ascending order and no
    /// farther apart than `widest` mm.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn along_x(
        tips: &TipHeights,
        (plate, widest): (DVec2, f64),
        places: &[(f64, bool)],
        [step, quantum]: [f64; 2],
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        Self::at(tips, (Frame::new(plate, 0.0), widest), places, [step, quantum], progress)
    }

    fn at(
        tips: &TipHeights,
        (frame, stepover): (Frame, f64),
        places: &[(f64, bool)],
        [step, quantum]: [f64; 2],
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let overrun = overrun(tips.profile());
        let along = ((frame.size.x + 2.0 * overrun) / step).ceil() as usize + 1;
        let ways = places
            .par_iter()
            .enumerate()
            .map(|(k, (y, backward))| {
                let y = whole(*y, quantum);
                let at = |i: usize| DVec2::new(step * i as f64 - overrun, y);
                progress.check()?;
                let tip = |i: usize| tips.at(frame.on_plate(at(i)));
                if k % 64 == 0 {
                    progress.fraction(k as f64 / places.len() as f64);
                }
                let heights = (0..along).map(tip).collect();
                Ok(Pass { y, backward: *backward, way: Way { from: -overrun, step, heights } })
            })
            .collect::<Result<Vec<Pass>, Cancelled>>()?;
        let steepest = steepest(&ways, &frame);
        Ok(Self { frame, overrun, stepover, steepest, ways }.grounded())
    }

    /// Size of the plate, mm.
    pub fn plate(&self) -> DVec2 {
        self.frame.plate()
    }

    /// The tip's way along every pass as the program of `machine` says it, mm, on the plate, in the order of cutting. Where
    /// passes of a turned frame run beside the plate, nothing is left to cut, and no stock may be there.
    pub fn programs(&self, machine: &Machine) -> Vec<Vec<DVec3>> {
        let program = |Pass { y, backward, way }: &Pass| {
            let ends = self.frame.beside_plate(*y, self.overrun, self.stepover)?;
            let [first, last] = ends.map(|x| ((x - way.from) / way.step).clamp(0.0, (way.heights.len() - 1) as f64));
            let heights = way.heights.get(first.floor() as usize..=last.ceil() as usize).filter(|way| way.len() > 1)?;
            let way = Way { from: way.from + way.step * first.floor(), step: way.step, heights: heights.to_vec() };
            let ends = way.programmed(machine, *backward).into_iter();
            let mut ends: Vec<DVec3> = ends.map(|[x, z]| self.frame.on_plate(DVec2::new(x, *y)).extend(z)).collect();
            if *backward {
                ends.reverse();
            }
            Some(ends)
        };
        self.ways.par_iter().filter_map(program).collect()
    }

    /// Time of cutting, hours: every pass at the feed, one way with a rapid back, and stops at both ends.
    pub fn hours(&self, machine: &Machine, zigzag: bool) -> f64 {
        let places = self.ways.iter().map(|pass| pass.y);
        hours(machine, &self.frame, places, ([self.overrun, self.stepover], zigzag))
    }

    /// Beside a turned plate nothing carries the cutter: it stays at its lowest there.
    fn grounded(mut self) -> Self {
        let heights = || self.ways.iter().flat_map(|pass| &pass.way.heights).copied().filter(|z| z.is_finite());
        let lowest = heights().fold(f64::INFINITY, f64::min);
        let lowest = if lowest.is_finite() { lowest } else { 0.0 };
        let all = self.ways.iter_mut().flat_map(|pass| &mut pass.way.heights);
        all.filter(|z| !z.is_finite()).for_each(|z| *z = lowest);
        self
    }
}

/// How far passes and their ends lie beyond the frame, mm: at a corner of the plate the tip still stands over it.
fn overrun(profile: &Profile) -> f64 {
    profile.contact(STEEPEST).min(0.7 * profile.reach)
}

/// Passes before the frame, and all of them.
fn count(frame: &Frame, overrun: f64, stepover: f64) -> (f64, usize) {
    let beyond = (overrun / stepover).ceil();
    (beyond, (frame.size.y / stepover).ceil() as usize + 2 * beyond as usize)
}

/// Time of cutting passes at places across the frame, hours.
fn hours(
    machine: &Machine,
    frame: &Frame,
    places: impl Iterator<Item = f64>,
    ([overrun, stepover], zigzag): ([f64; 2], bool),
) -> f64 {
    let lengths = places.filter_map(|y| frame.beside_plate(y, overrun, stepover)).map(|[from, to]| to - from);
    lengths.map(|length| pass_hours(machine, length, zigzag)).sum()
}

/// Time of a pass `length` mm long and of the way back, hours.
fn pass_hours(machine: &Machine, length: f64, zigzag: bool) -> f64 {
    let move_at = |mm_per_min: f64| {
        let speed = mm_per_min / 60.0;
        length / speed + speed / machine.acceleration
    };
    (move_at(machine.feed) + if zigzag { 0.0 } else { move_at(machine.rapid) }) / 3600.0
}

/// What [`Ways::hours`] will be, before there are any: for a plate of `plate` mm, a cutter of `profile`, and passes at an angle
/// (radians), mm apart, zigzag or not.
pub fn finishing_hours(
    machine: &Machine,
    profile: Profile,
    plate: DVec2,
    (angle, stepover, zigzag): (f64, f64, bool),
) -> f64 {
    let (frame, overrun) = (Frame::new(plate, angle), overrun(&profile));
    let (beyond, count) = count(&frame, overrun, stepover);
    let places = (0..count).map(|k| (k as f64 + 0.5 - beyond) * stepover);
    hours(machine, &frame, places, ([overrun, stepover], zigzag))
}

/// Over the plate; beyond its rim the cutter rolls down, and leaves nothing there.
fn steepest(ways: &[Pass], frame: &Frame) -> f64 {
    let over = |a: DVec2, b: DVec2| [a, b].iter().all(|at| frame.is_on_plate(frame.on_plate(*at)));
    let rises = |[Pass { y, way, .. }, Pass { y: next_y, way: next, .. }]: [&Pass; 2]| {
        let rise = |a: DVec2, b: DVec2, rise: f64| if over(a, b) { (rise / (b - a).length()).abs() } else { 0.0 };
        let at = |i: usize| DVec2::new(way.from + way.step * i as f64, *y);
        (1..way.heights.len()).fold(DVec2::ZERO, |most: DVec2, i| {
            let along = rise(at(i - 1), at(i), way.heights[i] - way.heights[i - 1]);
            let across = rise(at(i), DVec2::new(at(i).x, *next_y), next.heights[i] - way.heights[i]);
            most.max(DVec2::new(along, across))
        })
    };
    let most = ways.par_windows(2).map(|pair| rises([&pair[0], &pair[1]])).reduce(|| DVec2::ZERO, DVec2::max);
    most.length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_hold_the_plate_and_turn_back() {
        let plate = DVec2::new(3.0, 2.0);
        for degrees in [0.0f64, 90.0, 180.0, 37.0, -110.0] {
            let frame = Frame::new(plate, degrees.to_radians());
            for corner in [DVec2::ZERO, plate, DVec2::new(3.0, 0.0), DVec2::new(0.0, 2.0)] {
                let there = frame.of_plate(corner);
                assert!((frame.on_plate(there) - corner).length() < 1e-12);
                assert!(there.cmpge(DVec2::splat(-1e-12)).all() && there.cmple(frame.size + 1e-12).all(), "{degrees}");
            }
        }
        // Passes of a turned frame end beside the plate, not at the frame's corners; along x nothing changes.
        let turned = Frame::new(DVec2::splat(2.0), f64::to_radians(45.0));
        let [from, to] = turned.beside_plate(0.5, 0.1, 0.05).unwrap();
        assert!((to - from - (1.0 + 0.3 * 2f64.sqrt())).abs() < 1e-12, "{from} {to}");
        assert_eq!(turned.beside_plate(-0.3, 0.1, 0.05), None);
        assert_eq!(Frame::new(plate, 0.0).beside_plate(-0.12, 0.1, 0.05), Some([-0.1, 3.1]));
        assert_eq!(Frame::new(plate, f64::to_radians(90.0)).size, DVec2::new(2.0, 3.0));
        assert_eq!(Frame::new(plate, f64::to_radians(90.0)).turned(DVec2::X), DVec2::Y);
    }
}
