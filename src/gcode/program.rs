//! What a program does: moves in millimetres, each with the line that it comes from.

use glam::DVec3;

use super::arc::Arc;
use super::block::PathControl;

/// How a move goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// As fast as the machine can: G0.
    Rapid,
    /// Straight at its feed: G1.
    Line,
    /// Along one of [`Program::arcs`] at its feed: G2 and G3.
    Arc(u32),
}

/// One move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Where it ends, mm; an axis that no line has named yet counts as 0.
    pub to: DVec3,
    /// mm/min; 0 for rapids.
    pub feed: f64,
    /// Line of the file, from 1.
    pub line: u32,
    /// How it goes.
    pub kind: Kind,
    /// Which axes of the end are known, since a line has named them.
    pub known: [bool; 3],
}

/// Whether a program is as it was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Seal {
    /// It bears no checksum.
    #[default]
    None,
    /// Its checksum is right.
    Whole,
    /// Something was changed, added or left out behind the line with the checksum.
    Broken,
}

/// A program that was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// Its moves in order, without those that go nowhere.
    pub motions: Vec<Motion>,
    /// Arcs of moves along arcs.
    pub arcs: Vec<Arc>,
    /// Lines of the file.
    pub lines: u32,
    /// Seconds of dwelling (G4).
    pub dwell: f64,
    /// Tools, by their numbers, in order of their first change; at most a hundred.
    pub tools: Vec<u32>,
    /// Least and largest speed of the spindle while it cuts, turns a minute.
    pub speeds: Option<(f64, f64)>,
    /// What it says last of corners.
    pub path_control: Option<PathControl>,
    /// Whether it is as it was written.
    pub seal: Seal,
}

/// A move with where it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Where it begins, mm.
    pub from: DVec3,
    /// Which axes of the beginning are known.
    pub from_known: [bool; 3],
    /// The move.
    pub motion: Motion,
}

impl Move {
    /// Whether it is known where it goes along: its beginning in every axis.
    pub fn is_known(&self) -> bool {
        self.from_known == [true; 3]
    }

    /// Whether it cuts.
    pub fn cuts(&self) -> bool {
        self.motion.kind != Kind::Rapid
    }
}

impl Program {
    /// The same program with its zero elsewhere: all places moved by `by` mm.
    pub fn moved(mut self, by: DVec3) -> Self {
        self.motions.iter_mut().for_each(|motion| motion.to += by);
        self.arcs.iter_mut().for_each(|arc| {
            let [a, b, _] = arc.plane.axes();
            arc.start += by;
            arc.end += by;
            arc.centre = [arc.centre[0] + by[a], arc.centre[1] + by[b]];
        });
        self
    }

    /// The same program as a slide of z follows it that has `play` mm between its flanks: it stays where it is until a flank
    /// takes it along. Of arcs the ends alone are moved.
    pub fn lagging(mut self, play: f64) -> Self {
        let mut at: Option<f64> = None;
        for motion in self.motions.iter_mut().filter(|motion| motion.known[2]) {
            let z = motion.to.z;
            let slide = at.map_or(z, |at| at.clamp(z - 0.5 * play, z + 0.5 * play));
            (motion.to.z, at) = (slide, Some(slide));
        }
        self
    }

    /// Every move with where it begins.
    pub fn moves(&self) -> impl Iterator<Item = Move> {
        let mut from = (DVec3::ZERO, [false; 3]);
        self.motions.iter().map(move |&motion| {
            let (place, known) = std::mem::replace(&mut from, (motion.to, motion.known));
            Move { from: place, from_known: known, motion }
        })
    }

    /// The arc of a move, if it goes along one.
    pub fn arc(&self, motion: &Motion) -> Option<&Arc> {
        match motion.kind {
            Kind::Arc(k) => self.arcs.get(k as usize),
            Kind::Rapid | Kind::Line => None,
        }
    }

    /// The ends of straight pieces of a move: itself, or chords that are nowhere more than `chord` mm off its arc.
    pub fn pieces(&self, motion: &Motion, chord: f64) -> impl Iterator<Item = DVec3> {
        let arc = self.arc(motion).copied();
        let straight = arc.is_none().then_some(motion.to);
        straight.into_iter().chain(arc.into_iter().flat_map(move |arc| arc.flattened(chord)))
    }
}
