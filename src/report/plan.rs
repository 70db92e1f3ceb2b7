//! The report of a plan.

use serde::Serialize;

use super::PictureFacts;
use super::made::MadeFacts;
use crate::cutter::Cutter;
use crate::milling::machine::Machine;

/// What was planned.
#[derive(Clone, Debug, Serialize)]
pub struct PlanReport {
    /// The program and its version.
    pub program: &'static str,
    /// The drawing.
    pub picture: PictureFacts,
    /// The machine.
    pub machine: Machine,
    /// Hours of finishing that were given, or found.
    pub hours: f64,
    /// Share of misplaced light that was wanted, if that was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wanted: Option<f64>,
    /// By what share the polish was taken to be narrower or wider than meant.
    pub polish_tolerance: f64,
    /// The ways that were designed and proved, the best first.
    pub best: Vec<WayFacts>,
    /// For each cutter, hours and the light that is expected to be misplaced.
    pub by_cutter: Vec<CutterLine>,
    /// What would help most, if anything would.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub helps_most: Option<String>,
    /// Whether it was ended before all ways that were to be proved were.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub ended_early: bool,
    /// How the best light came out, in a sentence.
    pub verdict: String,
}

/// A way to make the plate.
#[derive(Clone, Debug, Serialize)]
pub struct WayFacts {
    /// The recipe's file.
    pub recipe: String,
    /// Optical area, mm.
    pub size_mm: [f64; 2],
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// Hours of finishing.
    pub hours: f64,
    /// Share of the light that was expected to be misplaced, at a blur of 1°.
    pub expected_tv_1deg: f64,
    /// The same where the polish is narrower or wider than meant.
    pub expected_tv_1deg_polish_off: f64,
    /// By scatter, cusps, and play with what the relief itself misplaces, each alone.
    pub expected_by: Parts,
    /// What of these is the most.
    pub limited_by: &'static str,
    /// Proved: light misplaced where the polish is narrower and where it is wider than meant.
    pub as_made_tv_1deg_polish_off: Vec<f64>,
    /// The proof.
    pub as_made: MadeFacts,
}

/// What parts would misplace alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parts {
    /// Heights that differ from pass to pass and from cut to cut.
    pub scatter: f64,
    /// Cusps between passes.
    pub cusps: f64,
    /// Play, rounding, and the relief itself.
    pub following: f64,
}

/// A line of the plan's picture.
#[derive(Clone, Debug, Serialize)]
pub struct CutterLine {
    /// The cutter.
    pub cutter: Cutter,
    /// Hours, and the share that is expected to be misplaced, in the mean over polish that is narrower, as meant, and wider.
    pub hours_and_tv_1deg: Vec<[f64; 2]>,
}
