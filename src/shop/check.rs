//! What is wrong with a program for a plate: each trouble with its line.

use std::fmt;

use glam::{DVec2, DVec3};

use super::blank::Blank;
use super::standing::hit_rapids;
use crate::cutter::Cutter;
use crate::gcode::check::{Amiss, Extent, blind_moves, extent, gouges, strays};
use crate::gcode::dialect::Dialect;
use crate::gcode::findings::Note;
use crate::gcode::program::{Program, Seal};
use crate::gcode::read::Read;
use crate::gcode::timing::{Kinematics, Timing, timing};
use crate::milling::machine::Machine;
use crate::milling::tip::TipHeights;

/// How far from one place to the next a cut is looked at, mm.
const STEP: f64 = 0.1;

/// How far beside the stock a cutter may go, beyond its own width, mm: to go down and to turn.
const BESIDE: f64 = 1.0;

/// How much deeper than its teeth are long a cutter may go before it counts, mm: half of the last of three decimals.
const HAIR: f64 = 5e-4;

/// Moves that a control looks ahead: GRBL's buffer, and what larger controls have at the least.
const SMALL_LOOK_AHEAD: usize = 16;
const LOOK_AHEAD: usize = 100;

/// Bytes within which a heading says its tool.
const HEADING: usize = 2000;

/// How a heading says its tool.
pub const TOOL: &str = "one tool: ";

/// How a heading says its control.
pub const CONTROL: &str = ", control ";

/// How a heading says the play that it makes up for, µm.
pub const PLAY: &str = "Makes up for ";

/// What a program is judged against.
#[derive(Clone, Copy)]
pub struct Against<'a> {
    /// How low the cutter can stand over the plate.
    pub tips: &'a TipHeights,
    /// The zero of that plate's frame, as the program counts, mm.
    pub origin: DVec3,
    /// The plate in its stock.
    pub blank: &'a Blank,
    /// The cutter of the program.
    pub cutter: Cutter,
    /// The machine.
    pub machine: &'a Machine,
    /// The control, if it is known.
    pub dialect: Option<Dialect>,
    /// How far a cut may pass below the plate, mm.
    pub tolerance: f64,
    /// Length of the cutter's teeth, mm, if it is known.
    pub flutes: Option<f64>,
}

/// A kind of trouble.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A line that cannot be carried out, and why.
    Unread(String),
    /// A cut below the plate.
    Gouge,
    /// A rapid through material.
    RapidInMaterial,
    /// A move far beside the stock.
    OutOfStock,
    /// A move below the stock.
    BelowFloor,
    /// A cut deeper than the cutter's teeth are long.
    BeyondFlutes,
    /// A move from a place that no line has named.
    Blind,
    /// Cuts while the spindle stands.
    SpindleStands,
    /// Lines faster than the control takes them in.
    LineRate(f64),
    /// The surface is left standing where it should have been cut.
    Standing,
    /// Something was changed since it was written.
    Broken,
}

/// Something that no program should do.
#[derive(Clone, Debug, PartialEq)]
pub struct Trouble {
    /// What it is.
    pub what: What,
    /// Line of its worst place, from 1; 0 if it is of the whole.
    pub line: u32,
    /// How many moves or lines do it.
    pub count: u64,
    /// By how much at the worst place, mm.
    pub by: f64,
    /// That place, as the program counts, mm.
    pub place: Option<DVec3>,
}

/// A program, judged.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// What it must not do, and does.
    pub troubles: Vec<Trouble>,
    /// What a person should know.
    pub notes: Vec<String>,
    /// How far it goes.
    pub extent: Extent,
    /// How long it takes.
    pub timing: Timing,
    /// Lines of its file.
    pub lines: u32,
}

impl What {
    /// The worse, the lower: what breaks things, what spoils the plate, what stops the machine.
    pub const fn rank(&self) -> u8 {
        match self {
            Self::RapidInMaterial => 0,
            Self::BelowFloor => 1,
            Self::Gouge => 2,
            Self::OutOfStock => 3,
            Self::BeyondFlutes => 4,
            Self::SpindleStands => 5,
            Self::Broken => 6,
            Self::Unread(_) => 7,
            Self::Blind => 8,
            Self::Standing => 9,
            Self::LineRate(_) => 10,
        }
    }

    /// Whether it is about the surface that is left.
    pub const fn is_of_the_surface(&self) -> bool {
        matches!(self, Self::Gouge | Self::Standing)
    }

    /// A name for programs, which stays the same.
    pub const fn id(&self) -> &'static str {
        match self {
            Self::Unread(_) => "unread",
            Self::Gouge => "gouge",
            Self::RapidInMaterial => "rapid-in-material",
            Self::OutOfStock => "out-of-stock",
            Self::BelowFloor => "below-floor",
            Self::BeyondFlutes => "beyond-flutes",
            Self::Blind => "blind",
            Self::SpindleStands => "spindle-stands",
            Self::LineRate(_) => "line-rate",
            Self::Standing => "left-standing",
            Self::Broken => "changed",
        }
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line > 0 {
            write!(out, "line {}: ", self.line)?;
        }
        match &self.what {
            What::Unread(why) => out.write_str(why)?,
            What::Gouge => write!(out, "cuts {} below the plate", length(self.by))?,
            What::RapidInMaterial => write!(out, "a rapid passes {} below what is still standing", length(self.by))?,
            What::OutOfStock => write!(out, "goes {} beyond the stock and the cutter's own width", length(self.by))?,
            What::BelowFloor => write!(out, "goes {} below the stock's lower face", length(self.by))?,
            What::BeyondFlutes => write!(out, "cuts {} deeper than the cutter's teeth are long", length(self.by))?,
            What::Blind => write!(out, "a move begins where no line has led: first name z, then x and y")?,
            What::SpindleStands => write!(out, "cuts while the spindle stands: write M3 with an S above 0 before")?,
            What::LineRate(most) => write!(
                out,
                "lines come at {:.0} a second, and the control takes {most:.0}: lower the feed, or write longer segments",
                self.by
            )?,
            What::Standing => write!(out, "leaves {} standing above the plate", length(self.by))?,
            What::Broken => write!(
                out,
                "its checksum is not that of its lines: something was changed since it was written; write it again"
            )?,
        }
        if let Some(place) = self.place {
            write!(out, ", at X{:.3} Y{:.3} Z{:.4}", place.x, place.y, place.z)?;
        }
        match self.count {
            0 | 1 => Ok(()),
            count => write!(out, " ({count} lines in all)"),
        }
    }
}

/// A length as a person reads it.
fn length(mm: f64) -> String {
    if mm < 0.1 { format!("{:.1} µm", 1000.0 * mm) } else { format!("{mm:.2} mm") }
}

/// What a program of our own says of itself in its heading: its tool, its control, and the play of z that it makes up for.
pub fn said_of_itself(text: &[u8]) -> (Option<Cutter>, Option<Dialect>, f64) {
    let head = String::from_utf8_lossy(&text[..text.len().min(HEADING)]);
    let after = |words: &str| head.split_once(words).map(|(_, rest)| rest.split([',', ')']).next().unwrap_or_default());
    // A cutter may have commas of its own.
    let tool = head.split_once(TOOL).and_then(|(_, rest)| rest.split(')').next());
    let play = head.split_once(PLAY).and_then(|(_, rest)| rest.split(' ').next()?.parse().ok());
    let play: f64 = play.filter(|play: &f64| (0.0..=1000.0).contains(play)).unwrap_or_default();
    let (tool, control) = (tool.and_then(|tool| tool.trim().parse().ok()), after(CONTROL));
    (tool, control.and_then(|control| control.parse().ok()), 1e-3 * play)
}

/// Judges a program that was read.
pub fn judged(read: &Read, against: &Against) -> Judgement {
    let program = &read.program;
    let Judgement { timing, extent, lines, .. } = against.measured(read);
    let mut troubles: Vec<Trouble> = read
        .faults
        .iter()
        .map(|fault| Trouble {
            what: What::Unread(fault.what.to_string()),
            line: fault.line,
            count: 1,
            by: 0.0,
            place: None,
        })
        .collect();
    if program.seal == Seal::Broken {
        troubles.push(Trouble { what: What::Broken, line: 0, count: 1, by: 0.0, place: None });
    }
    let cuts_low = extent.cuts.is_some_and(|bounds| bounds.low.z < 0.0);
    let mut notes = Vec::new();
    for note in &read.notes {
        if note.what == Note::SpindleStands {
            // In the air it may.
            if cuts_low {
                let count = u64::from(note.count);
                troubles.push(Trouble { what: What::SpindleStands, line: note.line, count, by: 0.0, place: None });
            }
            continue;
        }
        notes.push(format!("line {}: {}", note.line, note.what));
    }
    // What makes up for play goes where it should on a slide that has it.
    let play = against.machine.compensation_z;
    if play > 0.0 {
        troubles.extend(against.places(&program.clone().lagging(play)));
    } else {
        troubles.extend(against.places(program));
    }
    let most = against.line_rate();
    if timing.line_rate > most {
        let (line, by) = (timing.busiest_line, timing.line_rate);
        troubles.push(Trouble { what: What::LineRate(most), line, count: 1, by, place: None });
    }
    Judgement { troubles, notes, extent, timing, lines }
}

impl Against<'_> {
    /// Only how far it goes and how long it takes, with nothing judged.
    pub fn measured(&self, read: &Read) -> Judgement {
        Judgement {
            troubles: Vec::new(),
            notes: Vec::new(),
            extent: extent(&read.program),
            timing: timing(&read.program, &self.kinematics()),
            lines: read.program.lines,
        }
    }

    /// How the machine moves.
    fn kinematics(&self) -> Kinematics {
        let small = matches!(self.dialect, None | Some(Dialect::Grbl));
        Kinematics {
            speed: DVec3::splat(self.machine.rapid),
            acceleration: DVec3::splat(self.machine.acceleration),
            look_ahead: if small { SMALL_LOOK_AHEAD } else { LOOK_AHEAD },
            ..Kinematics::small()
        }
    }

    /// Most lines a second, and a hundredth for rounding.
    fn line_rate(&self) -> f64 {
        let control = self.dialect.and_then(Dialect::line_rate).unwrap_or(f64::INFINITY);
        1.01 * control.min(self.machine.lines_per_second)
    }

    /// Troubles that have places.
    fn places(&self, program: &Program) -> Vec<Trouble> {
        let size = self.blank.size();
        let origin = self.origin;
        let lowest =
            |place: DVec2| Some(self.tips.at(place - origin.truncate()) + origin.z).filter(|height| height.is_finite());
        let reach = self.cutter.reach();
        let over_stock = |place: DVec2| place.clamp(DVec2::ZERO, size.truncate()).distance(place) < reach;
        let wide = DVec3::new(1.0, 1.0, 0.0) * (2.0 * reach + BESIDE);
        let unbounded = DVec3::new(0.0, 0.0, 1e6);
        let sides = strays(program, -wide - unbounded, size.with_z(0.0) + wide + unbounded);
        let far = DVec3::new(1e6, 1e6, 0.0);
        let floor = strays(program, -far - DVec3::Z * size.z, far + DVec3::Z * 1e6);
        let mut found = vec![
            (What::Gouge, gouges(program, lowest, self.tolerance, STEP)),
            (What::RapidInMaterial, hit_rapids(program, size.truncate(), self.cutter.profile())),
            (What::OutOfStock, sides),
            (What::BelowFloor, floor),
            (What::Blind, blind_moves(program)),
        ];
        if let Some(flutes) = self.flutes {
            let within = |place: DVec2| Some(-flutes).filter(|_| over_stock(place));
            found.push((What::BeyondFlutes, gouges(program, within, HAIR, f64::INFINITY)));
        }
        found.into_iter().filter(|(_, amiss)| !amiss.is_none()).map(|(what, amiss)| trouble(what, &amiss)).collect()
    }
}

/// What is amiss, as a trouble.
pub fn trouble(what: What, amiss: &Amiss) -> Trouble {
    // A move from nowhere has no worst place.
    let line = if amiss.line > 0 { amiss.line } else { amiss.first_line };
    let place = (amiss.line > 0).then_some(amiss.place);
    Trouble { what, line, count: amiss.moves as u64, by: amiss.worst, place }
}
