//! Which plate, cutter, passes and polish bring a drawing out best on a machine in so many hours.
//!
//! A fast model ([`model`]) tells what is to be expected of hundreds of ways ([`search`]); the best of them are designed and
//! proved as made.

mod follow;
mod grain;
pub mod model;

pub mod search;

pub mod report;

use glam::DVec2;

use super::design::{DesignError, design};
use super::findings::MadeProof;
use super::made::{Lighting, prove_as_made};
use super::memory;
use crate::cutter::Cutter;
use crate::highlight::scored_target;
use crate::memory::MemoryLimit;
use crate::milling::machine::Machine;
use crate::milling::made::Machining;
use crate::milling::polish::in_words;
use crate::picture::Picture;
use crate::progress::{Progress, Stage};
use crate::recipe::{Cells, PassAngle, PassOrder, Recipe, RecipeError, SurfaceKind};
use model::Model;
use search::{Choice, Free};

/// By what share a polish is narrower or wider than meant, where nothing else is said.
pub const TOLERANCE: f64 = 0.25;

/// Ways that are designed and proved.
const PROVED: usize = 3;

/// Nodes a side of a cell at the most: of 1024 designs take minutes. As milled a portrait on 3 × 3 cells of 10 mm misplaces
/// 0.0008 with 256 nodes and 0.0006 with 400.
const MOST_NODES: usize = 320;

/// Hours for which the picture of a plan asks, as many times those that were given: half as many to sixteen times as few.
const AROUND: [f64; 9] = [0.0625, 0.125, 0.25, 0.5, 0.71, 1.0, 1.41, 2.0, 4.0];

/// Hours between which those are looked for that a wanted figure takes.
const HOURS: [f64; 2] = [0.02, 200.0];

/// By how much hours that are looked for are narrowed down.
const NARROWED: f64 = 1.05;

/// What is to be planned.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// What is fixed of the plate; what it does not say of cells, cutter, polish and direction of passes is searched for.
    pub recipe: &'a Recipe,
    /// Whether its size is searched for too.
    pub any_size: bool,
    /// The drawing.
    pub picture: &'a Picture,
    /// The machine.
    pub machine: &'a Machine,
    /// What is asked.
    pub goal: Goal,
    /// By what share the polish may be narrower or wider than meant.
    pub tolerance: f64,
    /// The most memory that designs may take.
    pub memory: MemoryLimit,
}

/// What is asked of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The best light in so many hours.
    Within(f64),
    /// The fewest hours for no more misplaced light than this share.
    Wanted(f64),
}

/// A cutter, and hours with the light that is expected to be misplaced in them.
pub type Line = (Cutter, Vec<[f64; 2]>);

/// What was planned.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Hours that were given, or found.
    pub hours: f64,
    /// The best ways, those first that were proved best.
    pub best: Vec<Proved>,
    /// For each cutter, hours and the least light that is expected to be misplaced in them, in the mean over polish that is
    /// narrower, as meant, and wider.
    pub lines: Vec<Line>,
    /// What would help most: what, and light misplaced then.
    pub helps: Option<(String, f64)>,
    /// Direction of the passes, radians.
    pub angle: f64,
    /// Whether it was told to finish before the last way was proved.
    pub ended_early: bool,
}

/// A way that was designed and proved.
#[derive(Clone, Debug)]
pub struct Proved {
    /// The way, and what was expected of it.
    pub choice: Choice,
    /// The recipe by which a design makes it.
    pub recipe: Recipe,
    /// The proof.
    pub made: MadeProof,
    /// Light misplaced where the polish is narrower and where it is wider than meant; empty without polish or tolerance.
    pub polish_off: Vec<f64>,
}

impl Task<'_> {
    /// Plans. From the first time on that `on_proved` hears of a way, a wish to finish ends the plan with the ways that are
    /// proved by then.
    ///
    /// # Errors
    /// Nothing fits the hours, the figure or the depth; a design cannot be made; the work was abandoned.
    pub fn plan(&self, on_proved: impl Fn(&Proved), progress: &Progress) -> Result<Plan, PlanError> {
        progress.stage(Stage::Planning);
        let mut model = Model::new(self.recipe, self.picture, self.tolerance, progress)?;
        let free = Free::of(self.recipe, self.any_size, &model);
        let (hours, choices) = match self.goal {
            Goal::Within(hours) => (hours, free.best((&mut model, self.machine), hours, progress)?),
            Goal::Wanted(wanted) => self.fewest_hours(wanted, &free, &mut model, progress)?,
        };
        if choices.is_empty() {
            let least = free.least_hours(self.machine).ok_or_else(|| free.nothing_fits())?;
            return Err(PlanError::TooFewHours { hours, least });
        }
        let counted = |choice: &Choice| -> Result<Choice, DesignError> {
            let expected = model.counted(self.machine, &choice.way, progress)?;
            Ok(Choice { expected, ..*choice })
        };
        let counted = choices.iter().take(2 * PROVED).map(counted).collect::<Result<Vec<_>, _>>()?;
        let lines = self.lines(hours, &free, &mut model, progress)?;
        let helps = self.helps(&counted[0], &free, &mut model, progress)?;
        let (best, ended_early) = self.best_proved(&counted, model.angle, on_proved, progress)?;
        Ok(Plan { hours, best, lines, helps, angle: model.angle, ended_early })
    }

    /// The first of `choices` that can be made, designed and proved, the best first; and whether there would have been more.
    fn best_proved(
        &self,
        choices: &[Choice],
        angle: f64,
        on_proved: impl Fn(&Proved),
        progress: &Progress,
    ) -> Result<(Vec<Proved>, bool), PlanError> {
        let (mut best, mut dropped, mut ended_early) = (Vec::<Proved>::new(), None, false);
        let ways = PROVED.min(choices.len());
        for choice in choices {
            if best.len() == ways {
                break;
            }
            progress.stage_with(Stage::Sculpting, &format!("way {} of {ways}", best.len() + 1));
            // The first is made to its end; a later one is dropped on a wish to finish, since half-made it would prove nothing.
            let until = if best.is_empty() { progress.to_the_end() } else { progress.until_finish() };
            match self.proved(choice, angle, &until) {
                Ok(proved) => {
                    on_proved(&proved);
                    best.push(proved);
                }
                Err(PlanError::Design(DesignError::Cancelled(_))) if !progress.is_abandoned() => {
                    ended_early = true;
                    break;
                }
                Err(
                    error @ (PlanError::Memory
                    | PlanError::Design(
                        DesignError::TooDeep { .. } | DesignError::Recipe(RecipeError::BeyondFlutes { .. }),
                    )),
                ) => dropped = Some(error),
                Err(error) => return Err(error),
            }
        }
        if best.is_empty() {
            return Err(dropped.unwrap_or(PlanError::Memory));
        }
        best.sort_by(|a, b| a.mean().total_cmp(&b.mean()));
        Ok((best, ended_early))
    }

    /// The fewest hours in which no more light is expected to be misplaced than `wanted`.
    fn fewest_hours(
        &self,
        wanted: f64,
        free: &Free,
        model: &mut Model,
        progress: &Progress,
    ) -> Result<(f64, Vec<Choice>), PlanError> {
        let mut at = |hours: f64| free.best((&mut *model, self.machine), hours, progress);
        let figure = |choices: &[Choice]| choices.iter().map(|c| c.expected.misplaced).fold(f64::INFINITY, f64::min);
        let mut low = HOURS[0];
        let (mut high, mut found) = (low, at(low)?);
        while figure(&found) > wanted {
            if high > HOURS[1] {
                return Err(PlanError::Unreachable { wanted, least: figure(&found), hours: high });
            }
            (low, high) = (high, 2.0 * high);
            found = at(high)?;
        }
        while high / low > NARROWED {
            let middle = (low * high).sqrt();
            let choices = at(middle)?;
            if figure(&choices) > wanted { low = middle } else { (high, found) = (middle, choices) }
        }
        found.sort_by(|a, b| a.expected.misplaced.total_cmp(&b.expected.misplaced));
        Ok((high, found))
    }

    /// Light expected to be misplaced over hours, for each cutter, in the mean over polish that is narrower, as meant and wider.
    fn lines(&self, hours: f64, free: &Free, model: &mut Model, progress: &Progress) -> Result<Vec<Line>, DesignError> {
        let mut lines: Vec<Line> = Vec::new();
        for hours in AROUND.map(|times| times * hours) {
            for choice in free.best((&mut *model, self.machine), hours, progress)? {
                let (cutter, figure) = (choice.way.cutter, choice.expected.mean());
                match lines.iter_mut().find(|(of, _)| *of == cutter) {
                    None => lines.push((cutter, vec![[hours, figure]])),
                    Some((_, points)) => match points.iter_mut().find(|point| point[0] == hours) {
                        None => points.push([hours, figure]),
                        Some(point) => point[1] = point[1].min(figure),
                    },
                }
            }
        }
        lines.sort_by(|a, b| a.0.diameter().total_cmp(&b.0.diameter()));
        Ok(lines)
    }

    /// What would help most of a wider plate, twice the hours, a machine that scatters half as much, and an even polish.
    fn helps(
        &self,
        choice: &Choice,
        free: &Free,
        model: &mut Model,
        progress: &Progress,
    ) -> Result<Option<(String, f64)>, DesignError> {
        let Choice { way, hours, expected } = *choice;
        let mut changes = vec![("an even polish".to_owned(), expected.misplaced)];
        let calmer = Machine {
            track_scatter: 0.5 * self.machine.track_scatter,
            tooth_scatter: 0.5 * self.machine.tooth_scatter,
            backlash_z: 0.5 * self.machine.backlash_z,
            ..self.machine.clone()
        };
        let other = model.expected(&calmer, &way, progress)?;
        changes.push(("a machine that scatters and plays half as much".into(), other.mean()));
        if let Some((stepover, takes)) = free.passes(self.machine, way.size, way.cutter, 2.0 * hours) {
            let other = model.expected(self.machine, &model::Way { stepover, ..way }, progress)?;
            changes.push((format!("{takes:.1} h in place of {hours:.1}"), other.mean()));
        }
        for (times, polish) in [(1.5, 1.5), (2.0, 2.0)] {
            let (size, polish) = (times * way.size, polish * way.polish);
            if let Some((stepover, _)) = free.passes(self.machine, size, way.cutter, hours) {
                let larger = model::Way { size, polish, stepover, ..way };
                let other = model.expected(self.machine, &larger, progress)?;
                let polished = if polish > 0.0 { format!(", {},", in_words(Some(polish))) } else { String::new() };
                changes.push((
                    format!("a plate of {:.0} × {:.0} mm{polished} in the same time", size.x, size.y),
                    other.mean(),
                ));
            }
        }
        let best = changes.into_iter().filter(|(_, figure)| *figure < 0.95 * expected.mean());
        Ok(best.min_by(|a, b| a.1.total_cmp(&b.1)))
    }

    /// Designs `choice` and proves it as made.
    fn proved(&self, choice: &Choice, angle: f64, progress: &Progress) -> Result<Proved, PlanError> {
        let recipe = self.recipe_of(choice, angle);
        recipe.check().map_err(DesignError::from)?;
        if self.memory.admit(memory::need(&recipe, self.picture.light.width, true)).is_err() {
            return Err(PlanError::Memory);
        }
        let Some(machining) = recipe.machining().map_err(DesignError::from)? else { return Err(PlanError::NoCutter) };
        let made = design(&recipe, &self.picture.light, progress)?;
        let setup = &made.distribution.setup;
        let resolution = recipe.measuring().resolution;
        let target = scored_target(&self.picture.light, recipe.highlight.quantity, setup, resolution);
        let lighting = Lighting::new(&recipe, setup);
        let (seen, mirrored) = (lighting.seen(&target, None), lighting.mirrored(progress));
        let plate = (&made.mesh, DVec2::from(recipe.plate.size), recipe.plate.border);
        let made = prove_as_made(&machining, plate, seen, recipe.draws(), mirrored)?;
        let mut polish_off = Vec::new();
        let polish = machining.polish.filter(|_| self.tolerance > 0.0);
        let widths = polish.map(|sigma| [1.0 - self.tolerance, 1.0 + self.tolerance].map(|times| times * sigma));
        for polish in widths.into_iter().flatten() {
            let machining = Machining { polish: Some(polish), ..machining.clone() };
            let other = prove_as_made(&machining, plate, seen, 1, mirrored)?;
            polish_off.push(other.verdict.main().tv_incident.value);
        }
        Ok(Proved { choice: *choice, recipe, made, polish_off })
    }

    fn recipe_of(&self, choice: &Choice, angle: f64) -> Recipe {
        let way = &choice.way;
        let mut recipe = self.recipe.clone().only_for(SurfaceKind::Sheet);
        (recipe.plate.size, recipe.plate.cells) = (way.size.to_array(), Some(Cells(way.cells)));
        recipe.design.sheet.cutter = Some(way.cutter);
        recipe.design.sheet.polish = Some(way.polish).filter(|polish| *polish > 0.0);
        recipe.plate.grid = Some(recipe.sculpting().grid.min(MOST_NODES));
        let machining = &mut recipe.machining;
        machining.machine = Some(self.machine.clone());
        (machining.stepover, machining.pass_angle) =
            (Some(way.stepover), Some(PassAngle::Degrees(angle.to_degrees().round())));
        machining.pass_order = machining.pass_order.filter(|order| *order == PassOrder::Zigzag);
        recipe
    }
}

impl Proved {
    /// Share of the light that is misplaced or lost, in the mean over draws.
    pub fn misplaced(&self) -> f64 {
        self.made.draws.iter().sum::<f64>() / self.made.draws.len().max(1) as f64
    }

    /// The mean of that and of what is misplaced where the polish is narrower or wider than meant.
    pub fn mean(&self) -> f64 {
        (self.misplaced() + self.polish_off.iter().sum::<f64>()) / (1 + self.polish_off.len()) as f64
    }
}

/// Why nothing was planned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// No way takes so little time.
    #[error(
        "{hours} h are too few: the passes would lie wider apart than any polish or cutter here allows; {least:.2} h would do, or a smaller --size"
    )]
    TooFewHours {
        /// What was given.
        hours: f64,
        /// What would do.
        least: f64,
    },
    /// No way misplaces so little.
    #[error(
        "{wanted} cannot be reached: {least:.4} is the least that is expected, in {hours:.0} h; a larger --size, a better machine or a polish more even would do"
    )]
    Unreachable {
        /// What was wanted.
        wanted: f64,
        /// The least found.
        least: f64,
        /// In which time.
        hours: f64,
    },
    /// No cutter for the cells.
    #[error("no ball that is sold suits a plate so small or so large: name one with --for-cutter")]
    NoCutter,
    /// Every relief is too deep.
    #[error(
        "every relief would be deeper than {most} mm, the shallowest {least:.2} mm: raise --max-depth, name a cutter that reaches deeper, or take a smaller --size or more --cells"
    )]
    TooDeep {
        /// What is allowed, mm.
        most: f64,
        /// What the shallowest is expected to have, mm.
        least: f64,
    },
    /// All that was found is too large.
    #[error("the designs would take more memory than there is: raise --memory, or take a smaller --size")]
    Memory,
    /// The quick design, or a design.
    #[error(transparent)]
    Design(#[from] DesignError),
}

impl From<RecipeError> for PlanError {
    fn from(error: RecipeError) -> Self {
        Self::Design(error.into())
    }
}
