//! The words of one line, sorted by what they set.

use super::arc::Plane;
use super::dialect::Dialect;
use super::words::Word;

/// How axis words move the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// G0.
    Rapid,
    /// G1.
    Line,
    /// G2 and G3.
    Arc { clockwise: bool },
    /// G80: axis words have no meaning.
    Off,
}

/// Where the control takes the path between two lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathControl {
    /// G61 and G61.1: exactly through every point.
    Exact,
    /// G64: corners are rounded by up to `tolerance` mm if P says so; `naive` is Q, within which points are left out.
    Blend {
        /// P, mm.
        tolerance: Option<f64>,
        /// Q, mm.
        naive: Option<f64>,
    },
}

/// What a line asks for.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Block {
    pub mode: Option<Mode>,
    pub plane: Option<Plane>,
    /// mm to a unit.
    pub unit: Option<f64>,
    pub absolute: Option<bool>,
    pub centre_absolute: Option<bool>,
    /// 540 is G54.
    pub coordinates: Option<i32>,
    /// G61 or G61.1: true; G64: false.
    pub exact: Option<bool>,
    pub dwell: bool,
    pub axes: [Option<f64>; 3],
    pub centre: [Option<f64>; 3],
    pub radius: Option<f64>,
    pub feed: Option<f64>,
    pub speed: Option<f64>,
    pub tool: Option<f64>,
    pub p: Option<f64>,
    pub q: Option<f64>,
    /// M3 and M4: true; M5: false.
    pub spindle: Option<bool>,
    pub tool_change: bool,
    /// G43.
    pub tool_length: bool,
    /// M2 and M30.
    pub ends: bool,
    /// O and its number.
    pub program: Option<f64>,
}

/// Where a word's number goes, which may be said once in a line.
fn set<T>(place: &mut Option<T>, value: T, letter: char) -> Result<(), BlockFault> {
    if place.is_some() {
        return Err(BlockFault::Twice(letter));
    }
    *place = Some(value);
    Ok(())
}

impl Block {
    /// What `words` ask for, as `dialect` understands them if it is known.
    pub fn new(words: &[Word], dialect: Option<Dialect>) -> Result<Self, BlockFault> {
        let mut block = Self::default();
        let (mut groups, mut numbered, mut offset) = (Groups::default(), None, None);
        for &Word { letter, value } in words {
            match letter {
                'G' => {
                    let code = tenths(value).ok_or(BlockFault::UnknownG(value))?;
                    groups.enter(g_group(code), letter)?;
                    block.take_g(code, dialect)?;
                }
                'M' => {
                    let code = tenths(value).filter(|code| code % 10 == 0).ok_or(BlockFault::UnknownM(value))? / 10;
                    groups.enter(m_group(code), letter)?;
                    block.take_m(code, dialect)?;
                }
                'X' | 'Y' | 'Z' => set(&mut block.axes[letter as usize - 'X' as usize], value, letter)?,
                'I' | 'J' | 'K' => set(&mut block.centre[letter as usize - 'I' as usize], value, letter)?,
                'A' | 'B' | 'C' | 'U' | 'V' | 'W' => return Err(BlockFault::Axis(letter)),
                'R' => set(&mut block.radius, value, letter)?,
                'F' => set(&mut block.feed, value, letter)?,
                'S' => set(&mut block.speed, value, letter)?,
                'T' => set(&mut block.tool, value, letter)?,
                'P' => set(&mut block.p, value, letter)?,
                'Q' => set(&mut block.q, value, letter)?,
                'H' => set(&mut offset, value, letter)?,
                'N' => set(&mut numbered, value, letter)?,
                'O' => set(&mut block.program, value, letter)?,
                _ => return Err(BlockFault::Unknown(letter)),
            }
        }
        block.checked(offset, dialect)
    }

    fn take_g(&mut self, code: i32, dialect: Option<Dialect>) -> Result<(), BlockFault> {
        match code {
            0 => self.mode = Some(Mode::Rapid),
            10 => self.mode = Some(Mode::Line),
            20 | 30 => self.mode = Some(Mode::Arc { clockwise: code == 20 }),
            40 => self.dwell = true,
            170 => self.plane = Some(Plane::Xy),
            180 => self.plane = Some(Plane::Zx),
            190 => self.plane = Some(Plane::Yz),
            200 => self.unit = Some(25.4),
            210 => self.unit = Some(1.0),
            430 => self.tool_length = true,
            400 | 490 | 921 | 940 | 970 | 980 | 990 => {}
            540 | 550 | 560 | 570 | 580 | 590 | 591 | 592 | 593 => self.coordinates = Some(code),
            610 | 611 | 640 => self.exact = Some(code != 640),
            800 => self.mode = Some(Mode::Off),
            900 | 910 => self.absolute = Some(code == 900),
            901 | 911 => self.centre_absolute = Some(code == 901),
            _ => return Err(refused_g(code)),
        }
        match dialect {
            Some(dialect) if !dialect.knows_g(code) => Err(BlockFault::NotOfDialect('G', said(code), dialect)),
            _ => Ok(()),
        }
    }

    fn take_m(&mut self, code: i32, dialect: Option<Dialect>) -> Result<(), BlockFault> {
        match code {
            0 | 1 | 7 | 8 | 9 | 48 | 49 => {}
            2 | 30 => self.ends = true,
            3 | 4 => self.spindle = Some(true),
            5 => self.spindle = Some(false),
            6 => self.tool_change = true,
            96..=99 => return Err(BlockFault::Subprogram(code)),
            _ => return Err(BlockFault::UnknownM(f64::from(code))),
        }
        match dialect {
            Some(dialect) if !dialect.knows_m(code) => Err(BlockFault::NotOfDialect('M', code.to_string(), dialect)),
            _ => Ok(()),
        }
    }

    /// What words need of each other.
    fn checked(self, offset: Option<f64>, dialect: Option<Dialect>) -> Result<Self, BlockFault> {
        match (self.tool_length, offset) {
            (true, Some(0.0)) | (false, None) => {}
            (true, _) => return Err(BlockFault::ToolLength),
            (false, Some(_)) => return Err(BlockFault::Idle('H')),
        }
        let blends = self.exact == Some(false);
        let turns = matches!(self.mode, None | Some(Mode::Arc { .. })) && self.axes != [None; 3];
        if self.p.is_some() && !(self.dwell || blends || turns || self.centre != [None; 3]) {
            return Err(BlockFault::Idle('P'));
        }
        if self.q.is_some() && !blends {
            return Err(BlockFault::Idle('Q'));
        }
        for (letter, value) in [('F', self.feed), ('S', self.speed), ('T', self.tool)] {
            if value.is_some_and(|value| value < 0.0) {
                return Err(BlockFault::Negative(letter));
            }
        }
        if self.program.is_some() && dialect == Some(Dialect::Grbl) {
            return Err(BlockFault::Unknown('O'));
        }
        Ok(self)
    }
}

/// A G or M number in tenths, if it has no further digits.
fn tenths(value: f64) -> Option<i32> {
    let code = 10.0 * value;
    let whole = code.round();
    ((code - whole).abs() < 1e-6 && (0.0..10_000.0).contains(&whole)).then_some(whole as i32)
}

/// A number in tenths as it is written.
fn said(code: i32) -> String {
    (f64::from(code) / 10.0).to_string()
}

/// Words of one group exclude each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    /// Those that may stand together with any.
    Free,
    Once,
    Motion,
    Plane,
    Distance,
    CentreDistance,
    FeedMode,
    Units,
    ToolRadius,
    ToolLength,
    Return,
    Coordinates,
    Path,
    SpindleMode,
    Stop,
    Spindle,
    ToolChange,
    Override,
}

/// Those that a line has words of.
#[derive(Default)]
struct Groups(u32);

impl Groups {
    fn enter(&mut self, group: Group, letter: char) -> Result<(), BlockFault> {
        if group != Group::Free && self.has(group) {
            return Err(BlockFault::Together(letter));
        }
        self.0 |= 1 << group as u32;
        Ok(())
    }

    fn has(&self, group: Group) -> bool {
        self.0 & (1 << group as u32) != 0
    }
}

fn g_group(code: i32) -> Group {
    match code {
        0 | 10 | 20 | 30 | 800 => Group::Motion,
        40 | 921 => Group::Once,
        170..=190 => Group::Plane,
        200 | 210 => Group::Units,
        400 => Group::ToolRadius,
        430 | 490 => Group::ToolLength,
        540..=593 => Group::Coordinates,
        610..=640 => Group::Path,
        900 | 910 => Group::Distance,
        901 | 911 => Group::CentreDistance,
        940 => Group::FeedMode,
        970 => Group::SpindleMode,
        980 | 990 => Group::Return,
        _ => Group::Free,
    }
}

fn m_group(code: i32) -> Group {
    match code {
        0 | 1 | 2 | 30 => Group::Stop,
        3..=5 => Group::Spindle,
        6 => Group::ToolChange,
        48 | 49 => Group::Override,
        _ => Group::Free,
    }
}

/// Why a G word is not read.
fn refused_g(code: i32) -> BlockFault {
    let (why, cure) = match code {
        50 | 51 | 52 | 53 | 330 | 331 => ("moves along a curve or thread", "post lines and arcs"),
        100 | 520 | 920 | 922 | 923 => ("shifts the zero", "set the zero at the machine and leave it out"),
        171 | 181 | 191 => ("is a plane of further axes", "take G17, G18 or G19"),
        280 | 281 | 300 | 301 => {
            ("moves to a place that only the machine knows", "end with a move to a safe height in its place")
        }
        380..=389 => ("probes", "take it out of the program"),
        410..=429 => ("shifts the path by a cutter's radius", "post the path of the tool's centre"),
        431..=449 => ("shifts heights by a tool's length", "measure the tool at the zero and leave it out"),
        500 | 510 | 680 | 690 => ("scales or turns the path", "post it as it is cut"),
        530 => ("moves in the machine's own coordinates", "move in those of the workpiece"),
        730 | 740 | 760 | 810..=899 => ("is a drilling or canned cycle", "post its single moves"),
        930 => ("is feed by time", "post feeds for a minute (G94)"),
        950 | 960 => ("counts by turns of the spindle", "post feeds for a minute (G94) and speeds in turns"),
        _ => return BlockFault::UnknownG(f64::from(code) / 10.0),
    };
    BlockFault::RefusedG { word: said(code), why, cure }
}

/// Words that cannot be obeyed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BlockFault {
    /// A letter that means nothing.
    #[error("{0} is a word that is not read: take it out, or say in G-code of three axes what it does")]
    Unknown(char),
    /// A further axis.
    #[error("{0} moves a further axis, and only X, Y and Z are read: post for three axes")]
    Axis(char),
    /// A G word that means nothing.
    #[error("G{0} is not read: lines, arcs, planes, units, G54 to G59 and G61 to G64 are")]
    UnknownG(f64),
    /// A G word whose meaning is not carried out.
    #[error("G{word} {why}: {cure}")]
    RefusedG {
        /// Its number.
        word: String,
        /// What it does.
        why: &'static str,
        /// What would do.
        cure: &'static str,
    },
    /// An M word that means nothing.
    #[error("M{0} is not read: M0 to M9, M30, M48 and M49 are")]
    UnknownM(f64),
    /// An M word that calls other programs.
    #[error("M{0} calls or ends a subprogram, which is not read: post everything in line")]
    Subprogram(i32),
    /// A word that the control does not know.
    #[error("{0}{1} is unknown to {2}, which would stop there: take it out, or post for another control")]
    NotOfDialect(char, String, Dialect),
    /// A letter twice.
    #[error("{0} stands twice in the line: leave one of them out")]
    Twice(char),
    /// Two words that exclude each other.
    #[error("two {0} words in the line exclude each other: leave one of them out")]
    Together(char),
    /// G43 without H0.
    #[error(
        "G43 shifts heights by a table of tools that the file does not hold: measure the tool at the zero, and leave G43 and H out (H0 is read)"
    )]
    ToolLength,
    /// A word that belongs to another.
    #[error("{0} belongs to no word of its line: take it out, or add the word that it is for")]
    Idle(char),
    /// A number below zero.
    #[error("{0} is negative: write what it is without the minus")]
    Negative(char),
}
