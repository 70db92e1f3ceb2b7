//! Which ways of making a plate there are, and which of them put most light right.

use glam::DVec2;

use super::PlanError;
use super::model::{Expected, Model, Way, cell_side};
use crate::cutter::Cutter;
use crate::job::design::DesignError;
use crate::milling::machine::Machine;
use crate::milling::made::LEAST_STEPOVER;
use crate::milling::passes::finishing_hours;
use crate::progress::Progress;
use crate::recipe::{PassOrder, Recipe};

/// Shorter sides of plates that are tried where none is given, mm.
const SIDES: [f64; 6] = [20.0, 30.0, 40.0, 50.0, 70.0, 100.0];

/// Balls as they are sold, mm.
const BALLS: [f64; 9] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0];

/// Diameters of a ball for each of a cell's shorter side: smaller ones cut for long, wider ones leave too much in valleys.
/// A photograph as milled misplaces 0.003 at a blur of 0.5° with a twentieth and 0.004 with a tenth.
const BALL_A_CELL: [f64; 2] = [0.015, 0.07];

/// Widths of polish that are tried, mm.
const POLISHES: [f64; 17] =
    [0.01, 0.015, 0.02, 0.025, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5];

/// Most of a cell that a polish may smooth. Of a portrait designs of 64 × 64 nodes that know of it misplace 0.0020 without,
/// 0.0021 and 0.0019 at half of this and at this, and 0.0035 at twice that.
const POLISH_A_CELL: f64 = 0.01;

/// Least polish for a stepover: with less its cusps stand.
const POLISH_A_STEPOVER: f64 = 0.35;

/// Machines that scatter less than this, mm, are planned for without polish too.
const FINE: f64 = 1e-4;

/// No passes closer than this, mm: more take hours and their cusps are gone already.
const CLOSEST: f64 = 0.005;

/// What is left open, and what is not.
#[derive(Clone, Debug)]
pub struct Free {
    sizes: Vec<DVec2>,
    cells: Vec<[usize; 2]>,
    cutters: Option<Cutter>,
    polish: Option<f64>,
    zigzag: bool,
    angle: f64,
    /// The deepest relief that is allowed, mm.
    most_depth: Option<f64>,
    /// Depth of a relief for each of its cell's shorter side.
    depth_a_cell: f64,
}

/// A way, the time that it takes, and what is expected of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The way.
    pub way: Way,
    /// Hours of finishing.
    pub hours: f64,
    /// What is expected.
    pub expected: Expected,
}

impl Free {
    /// All that `recipe` does not say; its size too, if `any_size`.
    pub fn of(recipe: &Recipe, any_size: bool, model: &Model) -> Self {
        let size = DVec2::from(recipe.plate.size);
        let shape = size / size.min_element();
        let sheet = &recipe.design.sheet;
        let deepest = recipe.cutter().and_then(|cutter| cutter.deepest());
        Self {
            sizes: if any_size { SIDES.map(|side| side * shape).to_vec() } else { vec![size] },
            cells: recipe.plate.cells.map_or(vec![[1, 1], [2, 2], [3, 3]], |cells| vec![cells.0]),
            cutters: sheet.cutter,
            polish: sheet.polish,
            zigzag: recipe.machining.pass_order == Some(PassOrder::Zigzag),
            angle: model.angle,
            most_depth: [sheet.max_depth, deepest].into_iter().flatten().reduce(f64::min),
            depth_a_cell: model.depth_a_cell(),
        }
    }

    /// Why there is no plate at all.
    pub fn nothing_fits(&self) -> PlanError {
        let sides = self.sizes.iter().flat_map(|size| self.cells.iter().map(|cells| cell_side(*size, *cells)));
        let least = self.depth_a_cell * sides.reduce(f64::min).unwrap_or(0.0);
        match self.most_depth {
            Some(most) if least > most => PlanError::TooDeep { most, least },
            _ => PlanError::NoCutter,
        }
    }

    /// Sizes, cells and cutters that go together.
    fn plates(&self) -> Vec<(DVec2, [usize; 2], Cutter)> {
        let mut all = Vec::new();
        for size in &self.sizes {
            for cells in &self.cells {
                let cell = cell_side(*size, *cells);
                if self.most_depth.is_some_and(|most| self.depth_a_cell * cell > most) {
                    continue;
                }
                let fits = |ball: &f64| (BALL_A_CELL[0]..=BALL_A_CELL[1]).contains(&(ball / cell));
                let balls = BALLS.iter().copied().filter(fits).map(Cutter::ball);
                all.extend(
                    self.cutters.map_or(balls.collect(), |cutter| vec![cutter]).into_iter().map(|c| (*size, *cells, c)),
                );
            }
        }
        all
    }

    /// The closest passes for which `hours` do, mm, and what they take; `None` if they would be wider than the cutter's radius.
    pub fn passes(&self, machine: &Machine, size: DVec2, cutter: Cutter, hours: f64) -> Option<(f64, f64)> {
        let takes =
            |stepover: f64| finishing_hours(machine, cutter.profile(), size, (self.angle, stepover, self.zigzag));
        let mut stepover = CLOSEST.max(LEAST_STEPOVER);
        // Time is in proportion to the number of passes, up to the few beyond the rim.
        for _ in 0..4 {
            if takes(stepover) <= hours {
                break;
            }
            stepover *= (takes(stepover) / hours).max(1.0);
            stepover = (1e4 * stepover).ceil() / 1e4;
        }
        (stepover <= cutter.reach() && takes(stepover) <= hours * 1.001).then(|| (stepover, takes(stepover)))
    }

    fn polishes(&self, machine: &Machine, cell: f64, stepover: f64) -> Vec<f64> {
        if let Some(polish) = self.polish {
            return vec![polish];
        }
        let wide = POLISHES.into_iter();
        let wide = wide.filter(|sigma| *sigma >= POLISH_A_STEPOVER * stepover && *sigma <= POLISH_A_CELL * cell);
        let none = Some(0.0).filter(|_| machine.scatter() < FINE);
        none.into_iter().chain(wide).collect()
    }

    /// The best polish for every size, number of cells and cutter within `hours`, those first of which most is expected.
    ///
    /// # Errors
    /// The work was abandoned.
    pub fn best(
        &self,
        (model, machine): (&mut Model, &Machine),
        hours: f64,
        progress: &Progress,
    ) -> Result<Vec<Choice>, DesignError> {
        let mut all: Vec<Choice> = Vec::new();
        for (size, cells, cutter) in self.plates() {
            let Some((stepover, takes)) = self.passes(machine, size, cutter, hours) else { continue };
            let mut best: Option<Choice> = None;
            let way = Way { size, cells, cutter, stepover, polish: 0.0 };
            for polish in self.polishes(machine, way.cell(), stepover) {
                let way = Way { polish, ..way };
                let choice = Choice { way, hours: takes, expected: model.expected(machine, &way, progress)? };
                if best.is_none_or(|best| choice.expected.mean() < best.expected.mean()) {
                    best = Some(choice);
                }
            }
            all.extend(best);
        }
        all.sort_by(|a, b| a.expected.mean().total_cmp(&b.expected.mean()));
        Ok(all)
    }

    /// The fewest hours in which any of these plates can be gone over at all.
    pub fn least_hours(&self, machine: &Machine) -> Option<f64> {
        let widest = |(size, cells, cutter): (DVec2, [usize; 2], Cutter)| {
            let cell = Way { size, cells, cutter, stepover: 0.0, polish: 0.0 }.cell();
            let polish = self.polish.unwrap_or(POLISH_A_CELL * cell);
            let stepover = cutter.reach().min(polish / POLISH_A_STEPOVER);
            finishing_hours(machine, cutter.profile(), size, (self.angle, stepover.max(LEAST_STEPOVER), self.zigzag))
        };
        self.plates().into_iter().map(widest).reduce(f64::min)
    }
}
