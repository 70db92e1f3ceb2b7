//! The report of the programs for a shop.

use serde::Serialize;

use super::MeshFacts;
use super::made::{MachiningFacts, MadeFacts};
use super::scores::Scores;
use crate::cutter::Cutter;
use crate::milling::machine::Machine;
use crate::shop::check::{Judgement, Trouble};
use crate::shop::programs::{Shop, ShopFile};
use crate::shop::surface::Left;

/// Programs that were written for a plate.
#[derive(Clone, Debug, Serialize)]
pub struct MillReport {
    /// The program and its version.
    pub program: &'static str,
    /// The mesh.
    pub plate: MeshFacts,
    /// How it is made; the machine is in the decimals and at the feed of its finishing program, the polish is assumed.
    #[serde(flatten)]
    pub machining: MachiningFacts,
    /// The control.
    pub dialect: String,
    /// What it is cut from.
    pub stock: String,
    /// Size of the stock, mm.
    pub stock_mm: [f64; 3],
    /// From the finished plate's highest point up to the stock's upper face, mm.
    pub stock_over_mm: f64,
    /// Where the programs count from, in words.
    pub zero: String,
    /// The programs, in the order of running.
    pub programs: Vec<ProgramFacts>,
    /// All of it in hours.
    pub hours: f64,
    /// The light of the plate as the machine makes it along the finishing program, if its drawing is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_made: Option<MadeFacts>,
    /// The same in a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<String>,
    /// What was made, in a sentence.
    pub verdict: String,
    /// What a person should know; empty if nothing is off.
    pub advice: Vec<String>,
}

/// One program.
#[derive(Clone, Debug, Serialize)]
pub struct ProgramFacts {
    /// What it is for.
    pub part: String,
    /// Its file.
    pub file: String,
    /// Its cutter.
    pub cutter: Cutter,
    /// Feed along its tracks, mm/min; a starting value.
    pub feed_mm_per_min: f64,
    /// Turns of the spindle a minute; a starting value.
    pub turns_per_min: f64,
    /// What reading it back said.
    #[serde(flatten)]
    pub read: ReadFacts,
}

/// What reading a program said.
#[derive(Clone, Debug, Serialize)]
pub struct ReadFacts {
    /// Lines of the file.
    pub lines: u32,
    /// Time from its first to its last line, hours.
    pub hours: f64,
    /// Most lines a second.
    pub lines_per_second: f64,
    /// Least and largest coordinates of all moves, mm.
    pub bounds_mm: Option<[[f64; 3]; 2]>,
    /// Length of all cuts, mm.
    pub cut_mm: f64,
    /// What it does that no program should.
    pub troubles: Vec<TroubleFacts>,
    /// What a person should know of it.
    pub notes: Vec<String>,
}

/// Something that no program should do.
#[derive(Clone, Debug, Serialize)]
pub struct TroubleFacts {
    /// Its name for programs.
    pub kind: &'static str,
    /// Line of its worst place, from 1; null if it is of the whole.
    pub line: Option<u32>,
    /// How many moves or lines do it.
    pub count: u64,
    /// By how much at the worst place, mm; null if it has no amount.
    pub by_mm: Option<f64>,
    /// That place, as the program counts, mm.
    pub place_mm: Option<[f64; 3]>,
    /// The same in a sentence.
    pub sentence: String,
}

impl MillReport {
    /// Of programs that were made in `shop`.
    pub fn new(plate: MeshFacts, shop: &Shop, files: &[ShopFile], advice: Vec<String>) -> Self {
        let machining = shop.finishing();
        let hours = files.iter().map(|file| file.judgement.timing.seconds).sum::<f64>() / 3600.0;
        Self {
            program: super::PROGRAM,
            plate,
            dialect: shop.dialect.to_string(),
            stock: shop.stock.to_string(),
            stock_mm: shop.blank.size().to_array(),
            stock_over_mm: shop.blank.over,
            zero: shop.blank.zero_in_words(),
            machining: (&machining).into(),
            programs: files.iter().map(ProgramFacts::new).collect(),
            hours,
            as_made: None,
            light: None,
            verdict: format!(
                "{} programs for {} on {}, {hours:.1} hours in all: each was read back, and does nothing that the check \
                 refuses.",
                files.len(),
                shop.name,
                shop.machining.machine.name
            ),
            advice,
        }
    }
}

impl ProgramFacts {
    pub(super) fn new(file: &ShopFile) -> Self {
        Self {
            part: file.part.name().to_owned(),
            file: file.name.to_owned(),
            cutter: file.cutter,
            feed_mm_per_min: file.pace.feed,
            turns_per_min: file.pace.speed,
            read: (&file.judgement).into(),
        }
    }
}

impl From<&Judgement> for ReadFacts {
    fn from(judgement: &Judgement) -> Self {
        let bounds = judgement.extent.all;
        Self {
            lines: judgement.lines,
            hours: judgement.timing.seconds / 3600.0,
            lines_per_second: judgement.timing.line_rate,
            bounds_mm: bounds.map(|bounds| [bounds.low.to_array(), bounds.high.to_array()]),
            cut_mm: judgement.extent.lengths[1],
            troubles: judgement.troubles.iter().map(TroubleFacts::from).collect(),
            notes: judgement.notes.clone(),
        }
    }
}

impl From<&Trouble> for TroubleFacts {
    fn from(trouble: &Trouble) -> Self {
        Self {
            kind: trouble.what.id(),
            line: (trouble.line > 0).then_some(trouble.line),
            count: trouble.count,
            by_mm: (trouble.by > 0.0).then_some(trouble.by),
            place_mm: trouble.place.map(|place| place.to_array()),
            sentence: trouble.to_string(),
        }
    }
}

/// A program of any origin, judged against a plate.
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport {
    /// The program and its version.
    pub program: &'static str,
    /// The file that was judged.
    pub gcode: String,
    /// The mesh that it is judged against.
    pub plate: MeshFacts,
    /// The cutter.
    pub cutter: Cutter,
    /// The control, if it is known.
    pub dialect: Option<String>,
    /// The machine.
    pub machine: Machine,
    /// What reading it said.
    pub read: ReadFacts,
    /// Where its zero was taken to lie, mm from the stock's lower left corner and its upper face.
    pub zero_mm: [f64; 3],
    /// The surface that it leaves, if it goes down to the plate.
    pub surface: Option<SurfaceFacts>,
    /// Standard deviation of the polish that was assumed, mm.
    pub polish_mm: Option<f64>,
    /// The light of that surface, if the plate's drawing is known.
    pub light: Option<Scores>,
    /// Whether the program should not be run.
    pub refused: bool,
    /// What was found, in a sentence.
    pub verdict: String,
    /// What a person should know; empty if nothing is off.
    pub advice: Vec<String>,
}

/// The surface that a program leaves, at places of the plate that its cutter can touch.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SurfaceFacts {
    /// What is left standing on the mean, µm: of a finished surface its cusps.
    pub left_mean_um: f64,
    /// What is left standing at the most, µm.
    pub left_most_um: f64,
    /// Where that is, as the program counts, mm.
    pub left_most_at_mm: [f64; 3],
    /// Line that passed lowest there.
    pub left_most_line: u32,
    /// The deepest below the plate, µm.
    pub below_um: f64,
    /// Share of the places over which nothing has passed.
    pub untouched: f64,
}

impl From<&Left> for SurfaceFacts {
    fn from(left: &Left) -> Self {
        Self {
            left_mean_um: 1000.0 * left.mean,
            left_most_um: 1000.0 * left.most,
            left_most_at_mm: left.place.to_array(),
            left_most_line: left.line,
            below_um: 1000.0 * left.deepest,
            untouched: left.untouched,
        }
    }
}
