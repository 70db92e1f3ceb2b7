//! The fast model: how much light plates misplace as a machine makes them, without making any.
//!
//! Light is smeared by the slopes that passes, cuts and cusps leave (`grain`); what play, rounding and a polish that
//! is not as meant do to the relief is read off a cell that is quickly designed (`follow`). Both scale: slopes
//! do not know how large a plate is.

use std::collections::BTreeMap;

use glam::DVec2;

use super::follow::{followed, scaled};
use super::grain::{Grain, cusps};
use crate::cutter::Cutter;
use crate::job::design::{DesignError, design};
use crate::job::smeared::{Besides, Drawing, Spread};
use crate::milling::machine::Machine;
use crate::picture::Picture;
use crate::progress::Progress;
use crate::recipe::{MachiningSettings, PassAngle, Recipe, SurfaceKind};
use crate::relief::periodic::PeriodicRelief;
use crate::sculpt::tool::polished;

/// Nodes a side of the quick cell, its shorter side, mm, and the polish that it knows of, mm: wider than its nodes are apart,
/// so that what is left of it is smooth, and no wider than [designs know without loss](super::search).
const QUICK: usize = 160;
const QUICK_SIDE: f64 = 10.0;
const QUICK_POLISH: f64 = 0.1;

/// Stepovers at which planes are made, mm: the first, and each next one so many times as wide.
const FIRST: f64 = 0.005;
const TIMES: f64 = 2.0;

/// What light misplaced by spread slopes is tabulated at: the first spread, and each next one so many times as wide.
const LEAST_SPREAD: f64 = 2e-4;
const WIDER: f64 = 1.4;
const SPREADS: usize = 22;

/// How a plate may be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// The plate, mm.
    pub size: DVec2,
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// The cutter.
    pub cutter: Cutter,
    /// Passes, mm apart.
    pub stepover: f64,
    /// Standard deviation of the polish, mm; 0 is none.
    pub polish: f64,
}

impl Way {
    /// The shorter side of a cell, mm.
    pub fn cell(&self) -> f64 {
        cell_side(self.size, self.cells)
    }
}

/// The shorter side of one of `cells` on a plate of `size`, mm.
pub fn cell_side(size: DVec2, cells: [usize; 2]) -> f64 {
    (size / DVec2::from(cells.map(|n| n as f64))).min_element()
}

/// What is expected of a way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Expected {
    /// Light misplaced as made.
    pub misplaced: f64,
    /// The same if the polish is wider or narrower than meant.
    pub polish_off: f64,
    /// By scatter alone.
    pub scatter: f64,
    /// By cusps alone.
    pub cusps: f64,
    /// By play, rounding and the relief itself alone.
    pub following: f64,
}

impl Expected {
    /// What ways are chosen by: the mean over polish that is narrower, as meant, and wider.
    pub fn mean(&self) -> f64 {
        (self.misplaced + 2.0 * self.polish_off) / 3.0
    }

    /// What limits it, in a word.
    pub fn limit(&self) -> &'static str {
        let off = self.polish_off - self.misplaced;
        let parts =
            [("scatter", self.scatter), ("cusps", self.cusps), ("play", self.following), ("uneven polish", off)];
        parts.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or("", |(name, _)| name)
    }
}

/// The model for one picture.
pub struct Model {
    drawing: Drawing,
    /// A cell, quickly designed and polished as it was meant.
    cell: PeriodicRelief,
    /// Light misplaced by a polish that is narrower or wider than meant, in the mean, for a polish as wide as the cell: it
    /// grows with the width.
    uneven: f64,
    /// How steep it is, along x and y.
    slope: DVec2,
    /// Direction of the passes, radians.
    pub angle: f64,
    /// By what share a polish may be narrower or wider than meant.
    tolerance: f64,
    by_spread: Vec<(f64, f64)>,
    grains: BTreeMap<(String, String, usize), Grain>,
    /// What the relief itself misplaces as it is followed, by machine, cell and polish.
    following: BTreeMap<(String, [u64; 2]), (f64, Besides)>,
}

impl Model {
    /// Designs the quick cell of `recipe` for `picture`.
    ///
    /// # Errors
    /// There is no such design, or the work was abandoned.
    pub fn new(recipe: &Recipe, picture: &Picture, tolerance: f64, progress: &Progress) -> Result<Self, DesignError> {
        let mut quick = recipe.clone().only_for(SurfaceKind::Sheet);
        let shape =
            DVec2::from(recipe.plate.size) / DVec2::from(recipe.plate.cells.map_or([1, 1], |c| c.0).map(|n| n as f64));
        quick.plate.size = (QUICK_SIDE * shape / shape.min_element()).to_array();
        (quick.plate.cells, quick.plate.grid, quick.plate.border) = (Some(1.into()), Some(QUICK), 0.0);
        (quick.plate.border_finish, quick.plate.max_triangles) = (None, None);
        (quick.design.sheet.cutter, quick.design.sheet.polish) = (None, Some(QUICK_POLISH));
        quick.design.sheet.max_depth = None;
        quick.machining = MachiningSettings::default();
        let made = design(&quick, &picture.light, &progress.hushed())?;
        let sheet = made.sheet.ok_or(DesignError::NoLight)?;
        let drawing = Drawing::new(recipe, &picture.light, made.distribution.mean).ok_or(DesignError::NoLight)?;
        // Of many slopes one that is as steep as they are on the mean square; steps and decimals show on a slant.
        let slope = made.distribution.mean.to_vec() + made.distribution.spread * DVec2::new(0.6, 0.8);
        let mut model = Self {
            drawing,
            cell: polished(sheet.relief.clone(), Some(QUICK_POLISH)),
            uneven: 0.0,
            slope,
            angle: 0.0,
            tolerance,
            by_spread: Vec::new(),
            grains: BTreeMap::new(),
            following: BTreeMap::new(),
        };
        let times = [1.0 - tolerance, 1.0 + tolerance];
        let meant = model.drawing.besides(&model.cell, progress)?;
        let mut uneven = 0.0;
        for polish in times.map(|times| times * QUICK_POLISH).into_iter().filter(|polish| *polish > 0.0) {
            let other = model.drawing.besides(&polished(sheet.relief.clone(), Some(polish)), progress)?;
            uneven += 0.5 * model.drawing.misplaced(Spread::default(), 0.0, Some(&other.less(&meant)));
        }
        model.uneven = uneven * QUICK_SIDE / QUICK_POLISH;
        model.angle = match recipe.machining.pass_angle {
            Some(PassAngle::Degrees(degrees)) => degrees.to_radians(),
            Some(PassAngle::Best) | None => model.drawing.best_angle(),
        };
        let spreads = (0..SPREADS).map(|k| LEAST_SPREAD * WIDER.powi(k as i32));
        model.by_spread = spreads.map(|s| (s, model.smeared(s, model.angle))).collect();
        Ok(model)
    }

    /// How deep a relief is for each of its cell's shorter side.
    pub fn depth_a_cell(&self) -> f64 {
        self.cell.depth() / QUICK_SIDE
    }

    fn smeared(&self, across: f64, angle: f64) -> f64 {
        self.drawing.misplaced(Spread { along: 0.0, across }, angle, None)
    }

    /// Light misplaced where slopes are spread by `s`.
    fn by_spread(&self, s: f64) -> f64 {
        let table = &self.by_spread;
        let next = table.partition_point(|(at, _)| *at < s);
        match (next.checked_sub(1).and_then(|k| table.get(k)), table.get(next)) {
            (Some((a, low)), Some((b, high))) => low + (s - a) / (b - a) * (high - low),
            // Very little grows with the square.
            (None, Some((b, high))) => high * (s / b).powi(2),
            (Some((_, most)), None) => *most,
            (None, None) => 0.0,
        }
    }

    /// What `machine` leaves with the cutter of `way` on its passes.
    fn grain(&mut self, machine: &Machine, way: &Way, progress: &Progress) -> Result<Grain, DesignError> {
        let most = way.cutter.reach();
        let steps = ((most / FIRST).ln() / TIMES.ln()).floor().max(1.0) as usize;
        let below = ((way.stepover / FIRST).ln() / TIMES.ln()).floor().clamp(0.0, (steps - 1) as f64) as usize;
        let mut of = |k: usize| -> Result<Grain, DesignError> {
            let key = (machine.to_toml(), way.cutter.to_string(), k);
            if let Some(grain) = self.grains.get(&key) {
                return Ok(*grain);
            }
            let across = DVec2::from_angle(-self.angle).rotate(self.slope);
            let grain = Grain::new(machine, way.cutter, FIRST * TIMES.powi(k as i32), across, progress)?;
            self.grains.insert(key, grain);
            Ok(grain)
        };
        Ok(of(below)?.between(&of(below + 1)?, way.stepover))
    }

    /// What play, rounding and the relief itself misplace where `machine` follows it.
    fn following(&mut self, machine: &Machine, way: &Way, progress: &Progress) -> Result<&(f64, Besides), DesignError> {
        let key = followed_key(machine, way);
        if !self.following.contains_key(&key) {
            let cell = scaled(&self.cell, way.cell() / self.cell.cell.min_element());
            // Passes nearer to y than to x meet the relief along y.
            let upright = self.angle.sin().abs() > self.angle.cos().abs();
            let besides = self.drawing.besides(&followed(&cell, machine, upright, way.polish), progress)?;
            let alone = self.drawing.misplaced(Spread::default(), 0.0, Some(&besides));
            self.following.insert(key.clone(), (alone, besides));
        }
        self.following.get(&key).ok_or(DesignError::NoLight)
    }

    /// Slopes that `way` leaves by scatter and by cusps, where its polish is `times` as wide as meant.
    fn spreads(grain: &Grain, way: &Way, times: f64) -> (Spread, f64) {
        let polish = times * way.polish;
        // Without polish scatter and cusps cannot be told apart: each surface is the lowest of what passed.
        let cusps = cusps(way.stepover, way.cutter.valley_radius().max(0.01), polish);
        (grain.after(polish), cusps)
    }

    /// What is expected of `way` made by `machine`.
    ///
    /// # Errors
    /// The work was abandoned.
    pub fn expected(&mut self, machine: &Machine, way: &Way, progress: &Progress) -> Result<Expected, DesignError> {
        let grain = self.grain(machine, way, progress)?;
        let off = self.tolerance;
        let as_meant = self.following(machine, way, progress)?.0;
        let not_as_meant = as_meant.hypot(self.uneven * way.polish / way.cell());
        let all = |spread: Spread, cusps: f64| {
            let s = spread.along.hypot(spread.across);
            if way.polish > 0.0 { s.hypot(cusps) } else { s }
        };
        let smeared = |times: f64| {
            let (spread, cusps) = Self::spreads(&grain, way, times);
            self.by_spread(all(spread, cusps))
        };
        let (spread, cusps) = Self::spreads(&grain, way, 1.0);
        let narrow_and_wide = [1.0 - off, 1.0 + off].map(|times| smeared(times).hypot(not_as_meant));
        Ok(Expected {
            misplaced: smeared(1.0).hypot(as_meant),
            polish_off: 0.5 * narrow_and_wide.iter().sum::<f64>(),
            scatter: self.by_spread(spread.along.hypot(spread.across)),
            cusps: self.by_spread(cusps),
            following: as_meant,
        })
    }

    /// The same, its light counted pixel by pixel.
    ///
    /// # Errors
    /// The work was abandoned.
    pub fn counted(&mut self, machine: &Machine, way: &Way, progress: &Progress) -> Result<Expected, DesignError> {
        let expected = self.expected(machine, way, progress)?;
        let (mut spread, cusps) = Self::spreads(&self.grain(machine, way, progress)?, way, 1.0);
        if way.polish > 0.0 {
            spread.across = spread.across.hypot(cusps);
        }
        let angle = self.angle;
        let besides = self.following.get(&followed_key(machine, way)).map(|(_, besides)| besides);
        Ok(Expected { misplaced: self.drawing.misplaced(spread, angle, besides), ..expected })
    }
}

/// What ways have in common whose relief is followed alike: machine, cell and polish.
fn followed_key(machine: &Machine, way: &Way) -> (String, [u64; 2]) {
    (machine.to_toml(), [way.cell(), way.polish].map(|mm| (1e5 * mm).round() as u64))
}
