//! Our own programs: tracks of the tool's tip to lines.
//!
//! Lines are as short as can be: a word that is in force is not said again. Every track is reached the same way, up to the
//! travel height, across, and down at the plunging feed, so that play in Z lies on one side. Arcs are not written: GRBL would
//! cut them into chords of its own, and G18 is read differently by several controls.

use std::fmt::Write;

use glam::DVec3;

use super::dialect::Dialect;
use super::seal::Sum;

/// How tracks are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutting {
    /// The control.
    pub dialect: Dialect,
    /// Decimals of coordinates, 3 to 7.
    pub decimals: u8,
    /// Along tracks, mm/min.
    pub feed: f64,
    /// Down to their beginnings, mm/min.
    pub plunge: f64,
    /// Turns of the spindle a minute; 0 leaves it standing, for a run in the air.
    pub speed: f64,
    /// Height at which nothing is in the way, mm: for the first and the last move.
    pub safe: f64,
    /// Height of rapids between tracks, mm.
    pub travel: f64,
}

/// Seconds for the spindle to come up to speed.
const SPIN_UP: u32 = 4;

/// Characters of a line of comment.
const COMMENT: usize = 80;

/// The lines of a program that leads the tip along `tracks`, mm, one after the other.
///
/// # Errors
/// There is nothing to cut, or a number that no line can say.
pub fn body(tracks: &[Vec<DVec3>], cutting: &Cutting) -> Result<String, WriteError> {
    cutting.check()?;
    if tracks.iter().all(Vec::is_empty) {
        return Err(WriteError::Nothing);
    }
    let farthest = tracks.iter().flatten().map(|point| point.abs().max_element()).fold(0.0, f64::max);
    let finite = tracks.iter().flatten().all(|point| point.is_finite());
    if !finite || farthest > 1e5 {
        return Err(WriteError::Far);
    }
    let mut lines = Lines::new(cutting);
    lines.begin(cutting);
    for (k, track) in tracks.iter().filter(|track| !track.is_empty()).enumerate() {
        let start = track[0];
        let over = [Some(start.x), Some(start.y), None];
        let up = [None, None, Some(cutting.travel)];
        // The first is reached at the safe height.
        for rapid in if k == 0 { [over, up] } else { [up, over] } {
            lines.go("G0", rapid, None);
        }
        lines.go("G1", [None, None, Some(start.z)], Some(cutting.plunge));
        for point in &track[1..] {
            lines.go("G1", point.to_array().map(Some), Some(cutting.feed));
        }
    }
    lines.go("G0", [None, None, Some(cutting.safe)], None);
    lines.end(cutting);
    Ok(lines.text)
}

impl Cutting {
    fn check(&self) -> Result<(), WriteError> {
        if !(3..=7).contains(&self.decimals) {
            return Err(WriteError::Decimals(self.decimals));
        }
        let within = |value: f64, most: f64| value.is_finite() && value > 0.0 && value <= most;
        if !within(self.feed, 1e5) || !within(self.plunge, 1e5) {
            return Err(WriteError::Feed);
        }
        if self.speed != 0.0 && !within(self.speed, 1e6) {
            return Err(WriteError::Speed(self.speed));
        }
        if !(self.safe.is_finite() && self.travel.is_finite() && self.safe >= self.travel && self.safe < 1e5) {
            return Err(WriteError::Heights { safe: self.safe, travel: self.travel });
        }
        Ok(())
    }
}

/// Lines on their way, and what is in force.
struct Lines {
    text: String,
    decimals: u8,
    /// Whole numbers bear a point: controls of the ISO family may read them in thousandths without.
    point: bool,
    mode: &'static str,
    /// Place, in units of the last decimal.
    place: [Option<i64>; 3],
    feed: Option<f64>,
}

impl Lines {
    fn new(cutting: &Cutting) -> Self {
        let point = cutting.dialect == Dialect::Iso;
        Self { text: String::new(), decimals: cutting.decimals, point, mode: "", place: [None; 3], feed: None }
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn begin(&mut self, cutting: &Cutting) {
        self.line("G21 G17 G90 G94");
        self.line("G40 G49 G80");
        self.line("G54");
        match cutting.dialect {
            // Corners within 0.5 µm, and no point left out.
            Dialect::LinuxCnc => self.line("G64 P0.0005 Q0"),
            Dialect::Mach3 | Dialect::Iso => self.line("G64"),
            Dialect::Grbl => {}
        }
        self.go("G0", [None, None, Some(cutting.safe)], None);
        if cutting.speed > 0.0 {
            let point = if self.point { "." } else { "" };
            let pause = if self.point { format!("G4 X{SPIN_UP}.") } else { format!("G4 P{SPIN_UP}") };
            self.line(&format!("S{:.0}{point} M3", cutting.speed.max(1.0)));
            self.line(&pause);
        }
    }

    fn end(&mut self, cutting: &Cutting) {
        if cutting.speed > 0.0 {
            self.line("M5");
        }
        self.line(if cutting.dialect == Dialect::Iso { "M30" } else { "M2" });
    }

    /// A move to a place, as far as it is another one.
    fn go(&mut self, mode: &'static str, to: [Option<f64>; 3], feed: Option<f64>) {
        let scale = 10_f64.powi(i32::from(self.decimals));
        let units = to.map(|value| value.map(|value| (value * scale).round() as i64));
        let moves = |axis: usize| units[axis].is_some() && units[axis] != self.place[axis];
        let moving = [0, 1, 2].map(moves);
        if moving == [false; 3] {
            return;
        }
        if self.mode != mode {
            self.text.push_str(mode);
            self.mode = mode;
        }
        for (axis, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if let (true, Some(value)) = (moving[axis], units[axis]) {
                self.text.push(letter);
                self.number(value);
                self.place[axis] = Some(value);
            }
        }
        if feed.is_some() && feed != self.feed {
            self.feed = feed;
            // Writing into memory fails for no reason.
            let _ = write!(self.text, "F{}", said(feed.unwrap_or_default(), self.point));
        }
        self.text.push('\n');
    }

    /// A number of units, without zeros that say nothing.
    fn number(&mut self, units: i64) {
        let scale = 10_u64.pow(u32::from(self.decimals));
        let (whole, mut rest) = (units.unsigned_abs() / scale, units.unsigned_abs() % scale);
        let mut digits = usize::from(self.decimals);
        while digits > 0 && rest % 10 == 0 {
            rest /= 10;
            digits -= 1;
        }
        let sign = if units < 0 { "-" } else { "" };
        let _ = match (digits, self.point) {
            (0, true) => write!(self.text, "{sign}{whole}."),
            (0, false) => write!(self.text, "{sign}{whole}"),
            _ => write!(self.text, "{sign}{whole}.{rest:0digits$}"),
        };
    }
}

/// A feed to a tenth.
fn said(feed: f64, point: bool) -> String {
    let text = format!("{:.1}", feed.max(0.1));
    match text.strip_suffix(".0") {
        Some(whole) if point => format!("{whole}."),
        Some(whole) => whole.to_owned(),
        None => text,
    }
}

/// The whole program: what a control wants before, the checksum over all that follows, `heading` as comments, and `body`.
///
/// A sentence longer than a line goes on in the next one. Characters beyond ASCII and brackets, which comments may not
/// hold, are written otherwise.
pub fn sealed(dialect: Dialect, heading: &[String], body: &str) -> String {
    let mut rest = String::new();
    for sentence in heading {
        comment(&mut rest, sentence);
    }
    rest += body;
    let frame = if dialect == Dialect::Iso { ("%\nO0001\n", "%\n") } else { ("", "") };
    rest += frame.1;
    let mut sum = Sum::default();
    rest.lines().for_each(|line| sum.add(line.as_bytes()));
    format!("{}{}\n{rest}", frame.0, sum.comment())
}

/// Adds a sentence in lines of comment, each in its brackets.
fn comment(text: &mut String, sentence: &str) {
    let mut line = String::new();
    let clean = plain(sentence);
    let mut flush = |line: &mut String| {
        let _ = writeln!(text, "({line})");
        line.clear();
    };
    for word in clean.split_whitespace() {
        // A word that fills lines by itself is cut.
        for piece in word.as_bytes().chunks(COMMENT - 4) {
            let piece = std::str::from_utf8(piece).unwrap_or_default();
            if !line.is_empty() && line.len() + 1 + piece.len() > COMMENT - 2 {
                flush(&mut line);
                line.push(' ');
            }
            if !line.trim().is_empty() {
                line.push(' ');
            }
            line.push_str(piece);
        }
    }
    flush(&mut line);
}

/// The same in characters that a comment may hold.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    for c in text.chars() {
        match c {
            'µ' | 'μ' => plain.push('u'),
            '°' => plain.push_str(" deg"),
            '²' => plain.push('2'),
            '×' => plain.push('x'),
            '(' | '[' | '{' => plain.push_str("- "),
            ')' | ']' | '}' => plain.push_str(" -"),
            ';' | '%' => plain.push(','),
            c if c.is_ascii() && !c.is_control() => plain.push(c),
            _ => plain.push('_'),
        }
    }
    plain
}

/// What cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WriteError {
    /// No track.
    #[error("there is nothing to cut")]
    Nothing,
    /// A place that is no number, or beyond any machine.
    #[error("a track leaves every machine's reach: check the plate's size")]
    Far,
    /// Too few or too many decimals.
    #[error("{0} decimals cannot be written: take 3 to 7")]
    Decimals(u8),
    /// A feed that is none.
    #[error("feeds must be above 0 and at most 100000 mm/min")]
    Feed,
    /// A speed that is none.
    #[error("a spindle cannot turn at {0} a minute: take 1 to 1000000, or 0 to leave it standing")]
    Speed(f64),
    /// Heights in disorder.
    #[error("the safe height {safe} mm must be at least that of rapids, {travel} mm")]
    Heights {
        /// Safe height, mm.
        safe: f64,
        /// Height of rapids, mm.
        travel: f64,
    },
}

#[cfg(test)]
mod tests;
