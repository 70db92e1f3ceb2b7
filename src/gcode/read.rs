//! An interpreter: lines to moves.
//!
//! It reads what controls of mills have in common, and refuses by name what it does not carry out. Where controls differ it
//! follows LinuxCNC 2.9 and notes it.

use glam::DVec3;

use super::arc::{Arc, Plane};
use super::block::{Block, BlockFault, Mode, PathControl};
use super::dialect::Dialect;
use super::findings::{ENDLESS_LINE, Fault, Finding, MOST_FINDINGS, NotGcode, Note};
use super::program::{Kind, Motion, Program, Seal};
use super::{seal, words};

/// A program, and what is to be said of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Read {
    /// Its moves; where there are faults only those of lines without any.
    pub program: Program,
    /// Lines that cannot be carried out, the first [`MOST_FINDINGS`].
    pub faults: Vec<Finding<Fault>>,
    /// How many there are.
    pub fault_count: u64,
    /// What should be known, each kind once.
    pub notes: Vec<Finding<Note>>,
}

/// Farthest place from the zero, mm.
const FARTHEST: f64 = 1e5;

/// Most turns of one helix.
const MOST_TURNS: f64 = 1000.0;

/// Most tools that are told apart.
const MOST_TOOLS: usize = 100;

/// Memory for a program of `length` bytes, bytes: a move and an arc take 200, and no line is shorter than `X1` and its end,
/// nor one with an arc than `I1`; vectors double as they grow.
pub fn bytes_for(length: u64) -> f64 {
    2.0 * 200.0 / 3.0 * length as f64
}

/// Reads a program for `dialect`, or for any control if none is named. It fails on what is no text, or holds no word.
pub fn read(bytes: &[u8], dialect: Option<Dialect>) -> Result<Read, NotGcode> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(NotGcode::Utf16);
    }
    let mut rest = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let mut control = Control::new(dialect);
    let mut sum = None;
    let mut number: u32 = 0;
    while !rest.is_empty() {
        let length = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len());
        number = number.checked_add(1).ok_or(NotGcode::TooMany)?;
        if length > ENDLESS_LINE {
            return Err(NotGcode::EndlessLine(number));
        }
        let line = &rest[..length];
        rest = &rest[length..];
        rest = rest.strip_prefix(b"\r\n").unwrap_or_else(|| rest.get(1..).unwrap_or_default());
        if let Some(&byte) = line.iter().find(|byte| is_binary(**byte)) {
            return Err(NotGcode::Binary { line: number, byte });
        }
        sum = seal::Reading::line(sum, line);
        control.line(number, line);
    }
    control.program.lines = number;
    control.finish(seal::Reading::seal(sum.as_ref()))
}

/// Tabs, form feeds, tape controls (XON, XOFF) and DOS's end of a file are in texts, other control characters not.
fn is_binary(byte: u8) -> bool {
    byte.is_ascii_control() && !matches!(byte, b'\t' | 0x0c | 0x11 | 0x13 | 0x1a)
}

/// A control that carries out line after line.
struct Control {
    dialect: Option<Dialect>,
    program: Program,
    faults: Vec<Finding<Fault>>,
    fault_count: u64,
    notes: Vec<Finding<Note>>,
    words: Vec<words::Word>,
    /// Line that is carried out.
    line: u32,
    begun: bool,
    ended: bool,
    place: DVec3,
    known: [bool; 3],
    mode: Option<Mode>,
    plane: Plane,
    /// mm to a unit, if one was said.
    unit: Option<f64>,
    absolute: Option<bool>,
    centre_absolute: bool,
    coordinates: i32,
    /// mm/min.
    feed: Option<f64>,
    speed: f64,
    turns: bool,
    tool: Option<u32>,
}

impl Control {
    fn new(dialect: Option<Dialect>) -> Self {
        Self {
            dialect,
            program: Program::default(),
            faults: Vec::new(),
            fault_count: 0,
            notes: Vec::new(),
            words: Vec::new(),
            line: 0,
            begun: false,
            ended: false,
            place: DVec3::ZERO,
            known: [false; 3],
            mode: None,
            plane: Plane::Xy,
            unit: None,
            absolute: None,
            centre_absolute: false,
            coordinates: 540,
            feed: None,
            speed: 0.0,
            turns: false,
            tool: None,
        }
    }

    fn note(&mut self, what: Note) {
        match self.notes.iter_mut().find(|note| note.what == what) {
            Some(note) => note.count = note.count.saturating_add(1),
            None => self.notes.push(Finding { line: self.line, count: 1, what }),
        }
    }

    fn line(&mut self, number: u32, line: &[u8]) {
        self.line = number;
        let line = line.trim_ascii_end();
        let line = line.strip_suffix(&[0x1a]).unwrap_or(line);
        if let Some(note) = Note::of_length(line.len(), self.dialect) {
            self.note(note);
        }
        let mut words = std::mem::take(&mut self.words);
        let marks = words::cut(line, &mut words);
        let done = match marks {
            _ if self.ended => {
                if marks.is_err() || !words.is_empty() {
                    self.note(Note::AfterEnd);
                }
                Ok(())
            }
            Ok(marks) => self.carry_out(marks, &words),
            Err(fault) => Err(fault.into()),
        };
        self.words = words;
        if let Err(what) = done {
            self.begun = true;
            self.fault_count += 1;
            if self.faults.len() < MOST_FINDINGS {
                self.faults.push(Finding { line: number, count: 1, what });
            }
        }
    }

    fn carry_out(&mut self, marks: words::Marks, words: &[words::Word]) -> Result<(), Fault> {
        if marks.tape {
            self.ended = self.begun;
            self.begun = true;
            if self.dialect == Some(Dialect::Grbl) {
                self.note(Note::Tape);
            }
            return Ok(());
        }
        if words.is_empty() {
            return Ok(());
        }
        self.begun = true;
        if marks.deletable {
            self.note(Note::Deletable);
        }
        let mut block = Block::new(words, self.dialect)?;
        self.set_units(&block);
        self.set_spindle(&block)?;
        self.dwell(&mut block)?;
        self.set_modes(&block);
        self.go(&block)?;
        self.ended = block.ends;
        Ok(())
    }

    /// Unit and feed.
    fn set_units(&mut self, block: &Block) {
        let before = self.unit.unwrap_or(1.0);
        let now = block.unit.unwrap_or(before);
        if now != before && !self.program.motions.is_empty() {
            self.note(Note::UnitsSwitched);
        }
        if let Some(feed) = block.feed {
            if now != before {
                self.note(Note::FeedWithUnits);
            }
            // LinuxCNC obeys F before G20, GRBL behind it.
            let unit = if self.dialect == Some(Dialect::LinuxCnc) { before } else { now };
            self.feed = Some(unit * feed);
        }
        self.unit = block.unit.or(self.unit);
    }

    /// Speed, tool and spindle.
    fn set_spindle(&mut self, block: &Block) -> Result<(), Fault> {
        if let Some(tool) = block.tool {
            if tool.fract() != 0.0 || tool > 1e9 {
                return Err(Fault::Tool(tool));
            }
            self.tool = Some(tool as u32);
        }
        self.speed = block.speed.unwrap_or(self.speed);
        self.turns = block.spindle.unwrap_or(self.turns);
        if block.tool_change {
            match self.tool {
                None => self.note(Note::NamelessTool),
                Some(tool) if self.program.tools.contains(&tool) => {}
                Some(tool) => {
                    if !self.program.tools.is_empty() {
                        self.note(Note::SecondTool);
                    }
                    if self.program.tools.len() < MOST_TOOLS {
                        self.program.tools.push(tool);
                    }
                }
            }
        }
        Ok(())
    }

    fn dwell(&mut self, block: &mut Block) -> Result<(), Fault> {
        if !block.dwell {
            return Ok(());
        }
        let has_x = matches!(self.dialect, None | Some(Dialect::Iso));
        let seconds = match (block.p.take(), block.axes[0]) {
            // Milliseconds in the ISO dialect.
            (Some(p), _) => p * if self.dialect == Some(Dialect::Iso) { 1e-3 } else { 1.0 },
            (None, Some(x)) if has_x && block.mode.is_none() => {
                block.axes[0] = None;
                x
            }
            _ => return Err(Fault::NoDwell),
        };
        if !(0.0..1e6).contains(&seconds) {
            return Err(Fault::NoDwell);
        }
        self.program.dwell += seconds;
        Ok(())
    }

    /// Everything that stays in force, but for how to move.
    fn set_modes(&mut self, block: &Block) {
        self.plane = block.plane.unwrap_or(self.plane);
        self.absolute = block.absolute.or(self.absolute);
        self.centre_absolute = block.centre_absolute.unwrap_or(self.centre_absolute);
        if let Some(coordinates) = block.coordinates {
            if coordinates != self.coordinates && !self.program.motions.is_empty() {
                self.note(Note::CoordinatesSwitched);
            }
            self.coordinates = coordinates;
        }
        if let Some(exact) = block.exact {
            let unit = self.unit.unwrap_or(1.0);
            let [tolerance, naive] = [block.p, block.q].map(|value| value.map(|value| value * unit));
            let path = if exact { PathControl::Exact } else { PathControl::Blend { tolerance, naive } };
            self.program.path_control = Some(path);
        }
    }

    /// Moves, if there is anything to move.
    fn go(&mut self, block: &Block) -> Result<(), Fault> {
        self.mode = block.mode.or(self.mode);
        let about = block.centre != [None; 3] || block.radius.is_some();
        if block.axes == [None; 3] && !about {
            return Ok(());
        }
        let mode = self.mode.filter(|mode| *mode != Mode::Off).ok_or(Fault::NoMode)?;
        if !matches!(mode, Mode::Arc { .. }) {
            for (letter, value) in ['I', 'J', 'K', 'R'].into_iter().zip(block.centre.iter().chain([&block.radius])) {
                if value.is_some() {
                    return Err(Fault::NoArc(letter));
                }
            }
            if block.p.is_some() && block.exact != Some(false) {
                return Err(BlockFault::Idle('P').into());
            }
        }
        let (to, known) = self.target(block)?;
        let kind = match mode {
            Mode::Rapid => Kind::Rapid,
            Mode::Arc { clockwise } => {
                let arc = self.arc(block, to, clockwise)?;
                let k = u32::try_from(self.program.arcs.len()).unwrap_or(u32::MAX);
                self.program.arcs.push(arc);
                Kind::Arc(k)
            }
            Mode::Line | Mode::Off => Kind::Line,
        };
        let feed = if kind == Kind::Rapid { 0.0 } else { self.cutting_feed()? };
        let nowhere = to == self.place && known == self.known && !matches!(kind, Kind::Arc(_));
        if !nowhere {
            self.program.motions.push(Motion { to, feed, line: self.line, kind, known });
        }
        (self.place, self.known) = (to, known);
        Ok(())
    }

    /// The place that axis words name, and which of its axes are known.
    fn target(&mut self, block: &Block) -> Result<(DVec3, [bool; 3]), Fault> {
        let unit = self.unit.unwrap_or(1.0);
        let absolute = self.absolute.unwrap_or(true);
        if self.unit.is_none() {
            self.note(Note::NoUnit);
        }
        if self.absolute.is_none() {
            self.note(Note::NoDistance);
        }
        let (mut to, mut known) = (self.place, self.known);
        for axis in 0..3 {
            let Some(value) = block.axes[axis] else { continue };
            if !absolute && !known[axis] {
                self.note(Note::NoPlace);
            }
            to[axis] = value * unit + if absolute { 0.0 } else { self.place[axis] };
            known[axis] = true;
            if to[axis].abs() > FARTHEST {
                return Err(Fault::Far { axis: ['X', 'Y', 'Z'][axis], value: to[axis] });
            }
        }
        Ok((to, known))
    }

    fn cutting_feed(&mut self) -> Result<f64, Fault> {
        let feed = self.feed.ok_or(Fault::NoFeed)?;
        if feed == 0.0 {
            return Err(Fault::ZeroFeed);
        }
        if !self.turns || self.speed == 0.0 {
            self.note(Note::SpindleStands);
        } else {
            let (least, most) = self.program.speeds.unwrap_or((self.speed, self.speed));
            self.program.speeds = Some((least.min(self.speed), most.max(self.speed)));
        }
        Ok(feed)
    }

    fn arc(&mut self, block: &Block, to: DVec3, clockwise: bool) -> Result<Arc, Fault> {
        let unit = self.unit.unwrap_or(1.0);
        let [a, b, other] = self.plane.axes();
        if !(self.known[a] && self.known[b]) {
            self.note(Note::NoPlace);
        }
        if block.centre[other].is_some() {
            return Err(Fault::OtherPlane { letter: ['I', 'J', 'K'][other], plane: self.plane.word() });
        }
        let turns = block.p.unwrap_or(1.0);
        if turns.fract() != 0.0 || !(1.0..=MOST_TURNS).contains(&turns) {
            return Err(Fault::Turns(turns));
        }
        let (ends, turns) = ((self.place, to), turns as u32);
        let centre = [block.centre[a], block.centre[b]];
        match (block.radius, centre) {
            (None, [None, None]) => Err(Fault::NoCentre),
            (Some(radius), [None, None]) => Ok(Arc::of_radius(self.plane, ends, radius * unit, clockwise, turns)?),
            (Some(_), _) => Err(Fault::Both),
            (None, [first, second]) => {
                if self.centre_absolute && (first.is_none() || second.is_none()) {
                    return Err(Fault::HalfCentre);
                }
                let from = if self.centre_absolute { DVec3::ZERO } else { self.place };
                let offset = |value: Option<f64>| value.unwrap_or(0.0) * unit;
                let centre = [from[a] + offset(first), from[b] + offset(second)];
                Ok(Arc::about(self.plane, ends, centre, clockwise, turns)?)
            }
        }
    }

    fn finish(mut self, seal: Seal) -> Result<Read, NotGcode> {
        if !self.begun {
            return Err(NotGcode::Empty);
        }
        if !self.ended {
            self.note(Note::NoEnd);
        }
        self.program.seal = seal;
        let Self { program, faults, fault_count, notes, .. } = self;
        Ok(Read { program, faults, fault_count, notes })
    }
}

#[cfg(test)]
mod tests;
