//! What is wrong with a program, and what a person should know of it.

use super::arc::ArcFault;
use super::block::BlockFault;
use super::dialect::Dialect;
use super::words::WordFault;

/// Something about a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding<T> {
    /// Its number, from 1; of a note that holds for several the first.
    pub line: u32,
    /// How many lines it holds for.
    pub count: u32,
    /// What it is.
    pub what: T,
}

/// A line that cannot be carried out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// It cannot be cut into words.
    #[error(transparent)]
    Word(#[from] WordFault),
    /// Its words cannot be obeyed.
    #[error(transparent)]
    Block(#[from] BlockFault),
    /// Its arc is none.
    #[error(transparent)]
    Arc(#[from] ArcFault),
    /// A cut without a feed.
    #[error("a cutting move has no feed: write F with this move or before it")]
    NoFeed,
    /// A cut at no feed.
    #[error("a cutting move has a feed of 0, which is no motion: write an F above 0")]
    ZeroFeed,
    /// Axis words without a word for how to move.
    #[error("X, Y or Z without G0, G1, G2 or G3 in force: write one of them")]
    NoMode,
    /// Words of an arc elsewhere.
    #[error("{0} is a word of arcs, and none is cut here: take it out, or write G2 or G3")]
    NoArc(char),
    /// An arc without a centre.
    #[error("an arc has neither a centre nor a radius: write I, J, K of its plane, or R")]
    NoCentre,
    /// An arc with both.
    #[error("an arc has a centre and a radius: leave out R, or I, J, K")]
    Both,
    /// A word of a centre that its plane does not have.
    #[error("{letter} is no word of an arc in {plane}: choose the plane first, or take it out")]
    OtherPlane {
        /// The word.
        letter: char,
        /// The plane's word.
        plane: &'static str,
    },
    /// An absolute centre of which a word is missing.
    #[error("an absolute centre (G90.1) has one word of two: write both")]
    HalfCentre,
    /// Turns that are no whole number.
    #[error("P{0} is no number of turns: write a whole one, from 1 to 1000")]
    Turns(f64),
    /// A place out of any machine's reach.
    #[error("{axis} goes to {value:.0} mm, beyond any machine: check units and digits")]
    Far {
        /// The axis.
        axis: char,
        /// mm.
        value: f64,
    },
    /// A dwell without its time.
    #[error("G4 has no P: write how many seconds to wait")]
    NoDwell,
    /// A tool that is no number.
    #[error("T{0} is no tool: write a whole number")]
    Tool(f64),
}

/// What is no fault, and yet should be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Note {
    /// G20 and G21 are missing.
    #[error("moves before any G20 or G21: read as mm; the machine may be set otherwise")]
    NoUnit,
    /// G90 and G91 are missing.
    #[error("moves before any G90 or G91: read as absolute")]
    NoDistance,
    /// Another unit within the program.
    #[error("the unit changes half-way: read so, but a program in one unit is safer")]
    UnitsSwitched,
    /// F in the line of another unit.
    #[error(
        "F stands in the line that changes the unit: controls differ on whether it is in the old or the new one; write it in the next line"
    )]
    FeedWithUnits,
    /// Another zero within the program.
    #[error("the zero changes (G54 to G59) after moves: read as if all zeros were one")]
    CoordinatesSwitched,
    /// Steps before a place is known.
    #[error("a step (G91) or an arc from where no line has led: read as from 0")]
    NoPlace,
    /// Lines that a switch leaves out.
    #[error("lines begin with /, which a switch of the control leaves out: read as carried out")]
    Deletable,
    /// Lines too long.
    #[error(
        "longer than the {0} characters that the control may take: shorten comments, or give words lines of their own"
    )]
    LongLine(usize),
    /// A %.
    #[error("% is no word of GRBL: take it out unless the sender does")]
    Tape,
    /// Words behind the end.
    #[error("words stand behind the end of the program (M2, M30 or %): they are not carried out")]
    AfterEnd,
    /// No end.
    #[error("the program does not end with M2 or M30: it may be cut short")]
    NoEnd,
    /// Cuts with a standing spindle.
    #[error("cuts while the spindle stands: write M3 with an S above 0 before")]
    SpindleStands,
    /// More than one tool.
    #[error(
        "a second tool: its length is not known here, so heights behind the change may be wrong; one tool a file is safer"
    )]
    SecondTool,
    /// A change of tool without its number.
    #[error("M6 changes a tool that no T names")]
    NamelessTool,
}

/// Bytes that are no program.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotGcode {
    /// Bytes that no text has.
    #[error("line {line}: a byte {byte:#04x} that no text has: this is no G-code; name a program that is plain text")]
    Binary {
        /// Line, from 1.
        line: u32,
        /// The byte.
        byte: u8,
    },
    /// Two bytes a letter.
    #[error("the text is in UTF-16, which no control reads: save it as plain text (ASCII)")]
    Utf16,
    /// A line without end.
    #[error("line {0} has more than 65536 characters: this is no G-code, or its line ends were lost")]
    EndlessLine(u32),
    /// No words.
    #[error("there is no word of G-code in it: name a program such as G21 G90 G1 X1 F100")]
    Empty,
    /// More lines than are counted.
    #[error("more than four billion lines: cut the program into parts")]
    TooMany,
}

/// Characters of a line after which no end is looked for.
pub(super) const ENDLESS_LINE: usize = 65_536;

/// The most faults and kinds of notes that are kept.
pub const MOST_FINDINGS: usize = 50;

impl Note {
    /// Of a line of `length` characters, if it is too long for `dialect`.
    pub(super) fn of_length(length: usize, dialect: Option<Dialect>) -> Option<Self> {
        dialect?.longest_line().filter(|longest| length > *longest).map(Self::LongLine)
    }
}
