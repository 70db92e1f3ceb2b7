//! The reports of a test piece: what was written for it, and what was read from it.

use serde::Serialize;

use super::mill::ProgramFacts;
use crate::coupon::Told;
use crate::coupon::findings::Findings;
use crate::coupon::layout::{Coupon, Kind};
use crate::cutter::Cutter;
use crate::milling::machine::Machine;
use crate::shop::programs::{Shop, ShopFile, duration};

/// A test piece that was written.
#[derive(Clone, Debug, Serialize)]
pub struct CouponReport {
    /// The program and its version.
    pub program: &'static str,
    /// The machine, as it is thought to be.
    pub machine: Machine,
    /// The cutter.
    pub cutter: Cutter,
    /// The control.
    pub dialect: String,
    /// What it is cut from.
    pub stock: String,
    /// Size of the stock, mm.
    pub stock_mm: [f64; 3],
    /// Bands of passes, from the lowest y on.
    pub bands: Vec<BandFacts>,
    /// Places x of the lines across the passes that a scan is asked for, mm.
    pub lines_mm: Vec<f64>,
    /// The programs, in the order of running.
    pub programs: Vec<ProgramFacts>,
    /// All of it in hours.
    pub hours: f64,
    /// What was made, in a sentence.
    pub verdict: String,
    /// What a person should know; empty if nothing is off.
    pub advice: Vec<String>,
}

/// Passes next to each other.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BandFacts {
    /// What they are for.
    pub kind: Kind,
    /// Where they begin and end across the piece, mm.
    pub y_mm: [f64; 2],
    /// From one to the next, mm.
    pub stepover_mm: f64,
    /// Number of passes.
    pub passes: usize,
}

impl CouponReport {
    /// Of a piece whose programs were made in `shop`.
    pub fn new(coupon: &Coupon, shop: &Shop, files: &[ShopFile], advice: Vec<String>) -> Self {
        let seconds: f64 = files.iter().map(|file| file.judgement.timing.seconds).sum();
        let band = |(band, begin): (&crate::coupon::layout::Band, f64)| BandFacts {
            kind: band.kind,
            y_mm: [begin, begin + band.width()],
            stepover_mm: band.stepover,
            passes: band.passes,
        };
        Self {
            program: super::PROGRAM,
            machine: coupon.machine.clone(),
            cutter: coupon.cutter,
            dialect: shop.dialect.to_string(),
            stock: shop.stock.to_string(),
            stock_mm: shop.blank.size().to_array(),
            bands: coupon.bands.iter().zip(coupon.begins()).map(band).collect(),
            lines_mm: coupon.lines().iter().map(|line| line.0).collect(),
            programs: files.iter().map(ProgramFacts::new).collect(),
            hours: seconds / 3600.0,
            verdict: format!(
                "A test piece for {} with {}: {} of cutting, {} passes.",
                coupon.machine.name,
                coupon.cutter,
                duration(seconds),
                coupon.tracks().len()
            ),
            advice,
        }
    }
}

/// What was read from a test piece.
#[derive(Clone, Debug, Serialize)]
pub struct CouponReading {
    /// The program and its version.
    pub program: &'static str,
    /// The piece's folder.
    pub against: String,
    /// The files that were read.
    pub files: Vec<String>,
    /// Lines across the passes that lie on a field.
    pub lines: usize,
    /// What was looked for.
    pub figures: Vec<FigureFacts>,
    /// The machine with what was measured in place of what was assumed.
    pub machine: Machine,
    /// What came of it, in a sentence.
    pub verdict: String,
    /// What a person should know; empty if nothing is off.
    pub advice: Vec<String>,
}

/// One figure of a machine.
#[derive(Clone, Debug, Serialize)]
pub struct FigureFacts {
    /// Its key in a machine's file.
    pub key: &'static str,
    /// What was measured, µm; null if it could not be told.
    pub measured_um: Option<f64>,
    /// Its standard error, µm.
    pub error_um: Option<f64>,
    /// What it was thought to be, µm; null of a polish that nothing was known of.
    pub assumed_um: Option<f64>,
    /// Why it could not be told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}

impl CouponReading {
    /// Of `findings` in `files`, beside what the machine of `coupon` was thought to be.
    pub fn new(coupon: &Coupon, findings: &Findings, (against, files): (String, Vec<String>), lines: usize) -> Self {
        let machine = &coupon.machine;
        let assumed = [
            Some(machine.backlash_xy),
            Some(machine.backlash_z),
            Some(machine.track_scatter),
            Some(machine.tooth_scatter),
            Some(machine.tip_flat),
            Some(machine.radius_error),
            machine.polish,
        ];
        let figure = |((key, told), assumed): ((&'static str, &Told), Option<f64>)| {
            let (measured, error, why) = match told {
                Told::Measured { value, error } => (Some(1000.0 * value), Some(1000.0 * error), None),
                Told::Untold(why) => (None, None, Some(why.clone())),
            };
            FigureFacts { key, measured_um: measured, error_um: error, assumed_um: assumed.map(|v| 1000.0 * v), why }
        };
        let figures: Vec<FigureFacts> = findings.by_key().into_iter().zip(assumed).map(figure).collect();
        let told = figures.iter().filter(|figure| figure.measured_um.is_some()).count();
        Self {
            program: super::PROGRAM,
            against,
            files,
            lines,
            machine: findings.laid_over(machine),
            verdict: format!(
                "{told} of {} figures of {} are measured; the rest stay as assumed.",
                figures.len(),
                machine.name
            ),
            figures,
            advice: Vec::new(),
        }
    }
}
