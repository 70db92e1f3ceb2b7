//! The programs of a plate: roughing, finishing and a run in the air, each read back and judged before it is handed out.

use glam::DVec3;

use super::blank::Blank;
use super::check::{Against, CONTROL, Judgement, PLAY, TOOL, Trouble, judged};
use super::feeds::{Pace, SOURCE, Spindle, Stock, bites};
use crate::cutter::Cutter;
use crate::gcode::check::Bounds;
use crate::gcode::dialect::Dialect;
use crate::gcode::findings::NotGcode;
use crate::gcode::read::read;
use crate::gcode::write::{Cutting, WriteError, body, sealed};
use crate::milling::machine::Machine;
use crate::milling::made::Machining;
use crate::milling::passes::Ways;
use crate::milling::roughing::{Block, Roughing};
use crate::milling::tip::TipHeights;
use crate::progress::{Cancelled, Progress};
use crate::relief::mesh::Mesh;

/// Above the stock nothing is in the way at the first height, mm, and rapids go at the second.
const SAFE: f64 = 5.0;
const TRAVEL: f64 = 1.0;

/// How far a cut may pass below the plate, mm: chord and rounding of a program of three decimals.
const TOLERANCE: f64 = 1e-3;

/// By what share hours of a program and those of passes alone differ that are worth a word.
const HOURS_APART: f64 = 0.05;

/// Which program it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A run above the stock, the spindle standing.
    AirCut,
    /// What takes the stock away.
    Roughing,
    /// What leaves the relief.
    Finishing,
}

impl Part {
    /// In the order of running.
    pub const ALL: [Self; 3] = [Self::AirCut, Self::Roughing, Self::Finishing];

    /// What it is for.
    pub const fn name(self) -> &'static str {
        match self {
            Self::AirCut => "air cut",
            Self::Roughing => "roughing",
            Self::Finishing => "finishing",
        }
    }

    /// Its file, with the ending that shops with such a control expect.
    pub const fn file(self, dialect: Dialect) -> &'static str {
        match (self, dialect) {
            (Self::AirCut, Dialect::LinuxCnc) => "air-cut.ngc",
            (Self::AirCut, Dialect::Mach3) => "air-cut.tap",
            (Self::AirCut, _) => "air-cut.nc",
            (Self::Roughing, Dialect::LinuxCnc) => "roughing.ngc",
            (Self::Roughing, Dialect::Mach3) => "roughing.tap",
            (Self::Roughing, _) => "roughing.nc",
            (Self::Finishing, Dialect::LinuxCnc) => "finishing.ngc",
            (Self::Finishing, Dialect::Mach3) => "finishing.tap",
            (Self::Finishing, _) => "finishing.nc",
        }
    }
}

/// How a plate is milled in a shop.
#[derive(Clone, Debug)]
pub struct Shop {
    /// The finishing passes, and the machine.
    pub machining: Machining,
    /// The control.
    pub dialect: Dialect,
    /// What it is cut from.
    pub stock: Stock,
    /// The spindle.
    pub spindle: Spindle,
    /// The plate within its stock.
    pub blank: Blank,
    /// How the stock is taken away.
    pub roughing: Roughing,
    /// What the plate is called.
    pub name: String,
    /// Its finishing passes in words, where they are not all as far apart.
    pub passes: Option<String>,
}

/// A program on its way to its file.
#[derive(Clone, Debug)]
pub struct ShopFile {
    /// Which it is.
    pub part: Part,
    /// Its file's name.
    pub name: &'static str,
    /// Its text.
    pub text: String,
    /// With what it is cut.
    pub cutter: Cutter,
    /// How fast.
    pub pace: Pace,
    /// What reading it back said.
    pub judgement: Judgement,
}

/// Decimals of a finishing program: four leave 0.03 µm, which shows where cusps are lower than a tenth of a micrometre and
/// the machine follows so far.
pub fn decimals(machining: &Machining) -> u32 {
    let fine = machining.cusp_height() < 1e-4;
    if fine { machining.machine.decimals.clamp(4, 6) } else { 4 }
}

/// The dialect that machines like `machine` mostly take.
pub fn usual_dialect(machine: &Machine) -> Dialect {
    if machine.name.starts_with("desktop") { Dialect::Grbl } else { Dialect::Iso }
}

/// How stock is roughed out with `cutter`, leaving `allowance` mm.
pub fn usual_roughing(cutter: Cutter, allowance: f64) -> Roughing {
    let [step, stepover] = bites(cutter);
    Roughing { cutter, stepover, step, allowance }
}

impl Shop {
    /// The machining of the finishing program: in its decimals, and at its feed.
    pub fn finishing(&self) -> Machining {
        let mut machining = self.machining.clone();
        machining.machine.decimals = decimals(&machining);
        machining.machine.feed = self.stock.finishing(machining.cutter, &machining.machine, self.spindle).feed;
        if let Some(most) = self.dialect.line_rate() {
            machining.machine.lines_per_second = machining.machine.lines_per_second.min(most);
        }
        machining
    }

    /// Every program of the plate `mesh`, in the order of running; `tips` are those of the finishing cutter over it, moved
    /// so that its optical area begins at x = y = 0, and `ways` its passes.
    ///
    /// # Errors
    /// A program cannot be written, or does what no program should, or the work is abandoned.
    pub fn programs(
        &self,
        mesh: &Mesh,
        tips: &TipHeights,
        ways: &Ways,
        progress: &Progress,
    ) -> Result<Vec<ShopFile>, ShopError> {
        let machining = self.finishing();
        let origin = self.blank.origin_of_optical();
        let mut finishing = ways.programs(&machining.machine);
        finishing.iter_mut().flatten().for_each(|point| *point += origin);
        // Roughing is judged against the plate with its allowance, which is more than against the plate itself.
        let rough_tips = self.roughing.tips(&Block { mesh, optical: self.blank.optical() });
        progress.check()?;
        let mut roughing = self.roughing.tracks(&rough_tips, self.blank.corners(), self.blank.top(), progress)?;
        roughing.iter_mut().flatten().for_each(|point| *point -= self.blank.zero());
        let air = self.in_the_air(&finishing);
        let mut files = Vec::new();
        for part in Part::ALL {
            progress.check()?;
            let (tracks, own) = match part {
                Part::AirCut => (&air, (tips, origin)),
                Part::Finishing => (&finishing, (tips, origin)),
                Part::Roughing => (&roughing, (&rough_tips, -self.blank.zero())),
            };
            files.push(self.file(part, tracks, own)?);
        }
        Ok(files)
    }

    /// The rectangle around all passes, its diagonals, and the first, the middle and the last pass, above the stock.
    fn in_the_air(&self, tracks: &[Vec<DVec3>]) -> Vec<Vec<DVec3>> {
        let size = self.blank.size();
        let corner = |x: f64, y: f64| DVec3::new(x * size.x, y * size.y, SAFE);
        let mut air = vec![
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0), (1.0, 1.0)]
                .map(|(x, y)| corner(x, y))
                .to_vec(),
            vec![corner(1.0, 0.0), corner(0.0, 1.0)],
        ];
        let chosen = [0, tracks.len() / 2, tracks.len().saturating_sub(1)];
        for track in chosen.iter().filter_map(|k| tracks.get(*k)) {
            let high = track.iter().map(|point| point.z).fold(f64::NEG_INFINITY, f64::max);
            air.push(track.iter().map(|point| *point + DVec3::Z * (SAFE - high)).collect());
        }
        // None of it lower than rapids go.
        air.iter_mut().flatten().for_each(|point| point.z = point.z.max(TRAVEL));
        air
    }

    /// One program, written, read back and judged.
    fn file(
        &self,
        part: Part,
        tracks: &[Vec<DVec3>],
        (tips, origin): (&TipHeights, DVec3),
    ) -> Result<ShopFile, ShopError> {
        let mut machining = self.finishing();
        if part != Part::Finishing {
            // Play is made up for where the surface is left, and nowhere else.
            machining.machine.compensation_z = 0.0;
        }
        let (cutter, pace) = match part {
            Part::Roughing => {
                let cutter = self.roughing.cutter;
                (cutter, self.stock.roughing(cutter, &machining.machine, self.spindle))
            }
            _ => (machining.cutter, self.stock.finishing(machining.cutter, &machining.machine, self.spindle)),
        };
        let (feed, plunge, speed) = match part {
            // Nothing is cut: the spindle stands.
            Part::AirCut => (pace.feed, machining.machine.feed, 0.0),
            _ => (pace.feed, pace.plunge, pace.speed),
        };
        let travel = if part == Part::AirCut { SAFE } else { TRAVEL };
        let decimals = if part == Part::Finishing { machining.machine.decimals as u8 } else { 4 };
        let cutting = Cutting { dialect: self.dialect, decimals, feed, plunge, speed, safe: SAFE, travel };
        let body = body(tracks, &cutting)?;
        let against = Against {
            tips,
            origin,
            blank: &self.blank,
            cutter,
            machine: &machining.machine,
            dialect: Some(self.dialect),
            tolerance: TOLERANCE,
            flutes: None,
        };
        // What the heading tells of it; it is judged once it has its heading.
        let first = against.measured(&read(body.as_bytes(), against.dialect)?);
        let text = sealed(self.dialect, &self.heading(part, (cutter, &pace), &first), &body);
        let judgement = judged_text(text.as_bytes(), &against)?;
        match judgement.troubles.first() {
            None => Ok(ShopFile { part, name: part.file(self.dialect), text, cutter, pace, judgement }),
            Some(trouble) => Err(ShopError::Refused { part: part.name(), trouble: Box::new(trouble.clone()) }),
        }
    }

    /// What stands above a program.
    fn heading(&self, part: Part, (cutter, pace): (Cutter, &Pace), judgement: &Judgement) -> Vec<String> {
        let machining = self.finishing();
        let size = self.blank.size();
        let mut heading = vec![
            format!("facetmill {}: {} of {}", env!("CARGO_PKG_VERSION"), part.name(), self.name),
            format!("Machine {}{CONTROL}{}; {TOOL}{cutter}", machining.machine.name, self.dialect),
            format!("Stock {} {:.3} x {:.3} x {:.3} mm", self.stock, size.x, size.y, size.z),
            format!("Zero: {}", self.blank.zero_in_words()),
            bounds_in_words(judgement),
            format!(
                "Takes {}, {} lines, at most {:.0} lines a second",
                duration(judgement.timing.seconds),
                judgement.lines,
                judgement.timing.line_rate
            ),
        ];
        match part {
            Part::AirCut => heading.push(format!(
                "Nothing is cut: the spindle stands, and all moves are {TRAVEL} mm and more above the stock. It shows the \
                 outline, its diagonals, and the first, middle and last finishing pass"
            )),
            Part::Roughing => {
                let Roughing { stepover, step, allowance, .. } = self.roughing;
                // To a tenth of a micrometre, without the digits that a sum of decimals leaves.
                let [stepover, step, allowance] = [stepover, step, allowance].map(|mm| (1e4 * mm).round() / 1e4);
                heading.push(format!(
                    "Levels up to {step} mm deep, passes {stepover} mm apart; leaves {allowance} mm over the optical area"
                ));
            }
            Part::Finishing => heading.extend(self.about_finishing(&machining)),
        }
        if part != Part::AirCut {
            heading.push(format!("Feed {:.0} mm/min, {:.0} turns a minute: {SOURCE}", pace.feed, pace.speed));
        }
        heading
    }

    /// Why finishing takes longer than is told of a plate that is designed for it, if it does: what is told there knows
    /// passes and feed alone.
    pub fn hours_beside(&self, ways: &Ways, files: &[ShopFile]) -> Option<String> {
        let finishing = files.iter().find(|file| file.part == Part::Finishing)?;
        let hours = finishing.judgement.timing.seconds / 3600.0;
        let Machining { machine, passes, .. } = &self.machining;
        let told = ways.hours(machine, passes.zigzag);
        (hours > (1.0 + HOURS_APART) * told).then(|| {
            format!(
                "Finishing takes {hours:.2} h, where design, verify and plan tell {told:.2} h: they reckon every pass at \
                 {:.0} mm/min and the way back as a rapid; the program's own lifts, descents, corners and feed of {:.0} \
                 mm/min are in these.",
                machine.feed, finishing.pace.feed
            )
        })
    }

    fn about_finishing(&self, machining: &Machining) -> Vec<String> {
        let Machining { machine, passes, polish, .. } = machining;
        let way = if passes.zigzag { "to and fro" } else { "one way" };
        let play = 1000.0 * machine.compensation_z;
        let play =
            (play > 0.0).then(|| format!("{PLAY}{play} µm of play in z, measured of this machine: not for another"));
        let passes = self.passes.clone().unwrap_or_else(|| {
            format!(
                "Passes {} mm apart at {:.1} deg, {way}; cusps {:.4} µm",
                passes.stepover,
                passes.angle.to_degrees(),
                1000.0 * machining.cusp_height()
            )
        });
        let mut about = vec![
            format!(
                "{passes}; chords within 0.05 µm where segments as short as the control takes allow it; {} decimals: no \
                 sender may cut them",
                machine.decimals
            ),
            match polish {
                Some(sigma) => {
                    format!("Assumes a polish of {:.0} µm afterwards: it takes the cusps away", 1000.0 * sigma)
                }
                None => "Assumes no polish afterwards".to_owned(),
            },
        ];
        about.extend(play);
        about
    }
}

fn judged_text(text: &[u8], against: &Against) -> Result<Judgement, ShopError> {
    Ok(judged(&read(text, against.dialect)?, against))
}

fn bounds_in_words(judgement: &Judgement) -> String {
    let Some(Bounds { low, high }) = judgement.extent.all else { return "Bounds: none".to_owned() };
    let axis = |name: char, low: f64, high: f64| format!("{name} {low:.3} to {high:.3}");
    format!("Bounds: {}, {}, {} mm", axis('X', low.x, high.x), axis('Y', low.y, high.y), axis('Z', low.z, high.z))
}

/// A time as a person reads it.
pub fn duration(seconds: f64) -> String {
    match seconds {
        short if short < 100.0 => format!("{short:.0} s"),
        short if short < 6000.0 => format!("{:.0} min", short / 60.0),
        long => format!("{:.1} h", long / 3600.0),
    }
}

/// A plate that does not become programs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShopError {
    /// A program that cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A program that is none.
    #[error(transparent)]
    NotGcode(#[from] NotGcode),
    /// A program that does what no program should.
    #[error("the {part} program is refused by the check: {trouble}")]
    Refused {
        /// Which program.
        part: &'static str,
        /// What it does.
        trouble: Box<Trouble>,
    },
    /// Nobody wants it any more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
