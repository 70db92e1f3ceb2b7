//! The stages of a sheet: first tries on a coarse grid, matching, then descent on finer and finer grids.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::cutter::{Cutter, UnmodelledCutter};
use crate::descent::{Descent, Past, minimise_on};
use crate::distribution::SlopeDistribution;
use crate::progress::{Cancelled, Progress, SheetSoFar};
use crate::relief::periodic::PeriodicRelief;
use crate::slope::Slope;

use super::bound::{Unavoidable, unavoidable};
use super::checkpoint::Checkpoint;
use super::closing::Closing;
use super::edge_slopes::Lattice;
use super::filling::{Filled, clear};
use super::matching::Matching;
use super::objective::{Objective, relief};
use super::plan::{
    DESCENT_FIRST_MOVE, MEMORY, PREVIEW_TRIAL, SheetSpec, Stage, Step, TOLERANCE, TRIAL_ROUNDS, TRIES, plan,
    trial_descent,
};
use super::resample::sampled;
use super::slope_loss::LossScale;
use super::start::Start;
use super::target::SlopePlane;
use super::tool::Tool;

/// Blur at which reliefs are compared, degrees: that of the likeness promised in docs/relief.md.
const COMPARED_AT: f64 = 0.5;

/// Steps of a descent between two updates of the tool residual. An update takes about as long as three evaluations, so that
/// all of them add a tenth; fewer leave light of hollows that moved since the last one.
const STEPS_PER_RESIDUAL: usize = 30;

/// Narrowest bins of the histogram over slopes, degrees: half of the narrowest blur of the design.
const FINEST_BIN: f64 = 0.125;

/// Widest pieces in which pixels of the drawing are carried over to slopes, degrees: narrower than a bin; and of a preview.
const PIECES: f64 = 0.1;
const PREVIEW_PIECES: f64 = 0.3;

/// How much slopes are moved at random on the way to a finer grid, up to ±half of this: 0.1° in tilt, 0.2° in the picture, a
/// little less than the narrowest blur of the design. Triangles that are equal move alike from then on, and a half-sized
/// grid's four times fewer spots of light look grainy: 0.0085 in total variation at 0.27° in place of 0.0059.
const UNEVENNESS: f64 = 0.004;

/// The light that no relief cut as `sculpting` says can send where it is wanted; `None` without a cutter, or if the
/// distribution's image is too narrow to be laid out.
pub fn least_stray(distribution: &SlopeDistribution, sculpting: &SheetSpec) -> Option<Unavoidable> {
    const SAMPLES: usize = 1 << 16;
    let cutter = sculpting.settings.cutter?;
    Some(unavoidable(&SlopePlane::new(distribution, PIECES)?.samples(SAMPLES), sculpting.cell, cutter))
}

/// A sheet, and how it came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// The relief, triangle for triangle as it is written.
    pub relief: PeriodicRelief,
    /// What was started from.
    pub start: Start,
    /// Total variation between the relief's light as modelled and the wanted light, at a blur of 0.5°, of a preview 1°, after
    /// each step.
    pub misplaced: Vec<f64>,
    /// About the share of the plate that the cutter fills with fillets.
    pub fillets: f64,
    /// Steps of the plan that were done, and all of them: fewer if the work was stopped.
    pub steps: [usize; 2],
}

impl Sheet {
    /// Steps that were done and all of them, if the work was stopped before its end.
    pub fn stopped_early(&self) -> Option<[usize; 2]> {
        Some(self.steps).filter(|[done, all]| done < all)
    }
}

/// Designs the relief whose light is `distribution`'s, from the beginning or from the checkpoint of an earlier run.
///
/// `on_step` is told of every step that is done. A checkpoint that does not suit `sculpting` is not used. Told to finish, it
/// ends with the best relief so far, be it the first one tried.
pub fn sculpt(
    distribution: &SlopeDistribution,
    sculpting: &SheetSpec,
    from: Option<Checkpoint>,
    on_step: &mut dyn FnMut(&Checkpoint),
    progress: &Progress,
) -> Result<Sheet, SculptError> {
    sculpting.settings.cutter.map_or(Ok(()), Cutter::suits_sheets)?;
    let work = Work::new(distribution, sculpting, progress).ok_or(TooNarrow)?;
    let steps = plan(sculpting);
    let whole: f64 = steps.iter().map(|step| step.cost()).sum();
    let mut present = from.filter(|at| at.suits(sculpting));
    let mut spent = 0.0;
    for (k, step) in steps.iter().enumerate() {
        let share = Share { from: spent / whole, whole: step.cost() / whole };
        spent += step.cost();
        if present.as_ref().is_some_and(|at| at.done > k) {
            continue;
        }
        progress.check()?;
        if present.is_some() && progress.is_to_finish() {
            break;
        }
        // On a worker's thread: from any other, each of the many short parallel loops would wake a worker and wait for it.
        let mut reached = rayon::scope(|_| work.take(*step, present.clone(), share))?;
        progress.check()?;
        if progress.is_to_finish() {
            // A step that was cut short is not done, but its relief may be better than the one before.
            reached.done = k;
            let error = |at: &Checkpoint| at.misplaced.last().copied().unwrap_or(1.0);
            if present.as_ref().is_none_or(|before| error(&reached) <= error(before)) {
                present = Some(reached);
            }
            break;
        }
        on_step(&reached);
        present = Some(reached);
    }
    let last = present.ok_or(TooNarrow)?;
    let steps = [last.done, steps.len()];
    Ok(work.finished(last, steps)?)
}

/// The part of the whole work that a step is.
#[derive(Clone, Copy)]
struct Share {
    from: f64,
    whole: f64,
}

impl Share {
    fn part(self, done: usize, of: usize) -> Self {
        Self { from: self.from + self.whole * done as f64 / of as f64, whole: self.whole / of as f64 }
    }
}

/// What all steps share.
struct Work<'a> {
    sculpting: &'a SheetSpec,
    plane: SlopePlane,
    /// Mean slope of the plate.
    tilt: Slope,
    progress: &'a Progress<'a>,
}

impl<'a> Work<'a> {
    fn new(distribution: &SlopeDistribution, sculpting: &'a SheetSpec, progress: &'a Progress<'a>) -> Option<Self> {
        let finest = if sculpting.settings.preview { PREVIEW_PIECES } else { PIECES };
        let plane = SlopePlane::new(distribution, finest)?;
        Some(Self { sculpting, plane, tilt: distribution.mean, progress })
    }

    fn lattice(&self, n: usize) -> Lattice {
        Lattice { n, step: self.sculpting.cell / n as f64 }
    }

    /// Takes one step of the plan.
    fn take(&self, step: Step, before: Option<Checkpoint>, share: Share) -> Result<Checkpoint, SculptError> {
        let nodes = step.nodes();
        let Some(mut at) = before else { return self.tried(nodes, share) };
        let lattice = self.lattice(nodes);
        let mut z = self.resampled(&at, nodes);
        self.progress.check()?;
        match step {
            Step::Tries { .. } => {}
            Step::Matching { rounds, .. } => self.match_slopes(lattice, &mut z, rounds, share),
            Step::Descent { stage, .. } => z = self.descend(lattice, z, &stage, share)?,
        }
        at.misplaced.push(self.misplaced(lattice, &z)?);
        at.done += 1;
        (at.nodes, at.heights) = (nodes, z);
        Ok(at)
    }

    /// Heights on another grid: those of the same triangles, which keeps every slope where the old grid divides the new
    /// one, then moved by [`UNEVENNESS`].
    fn resampled(&self, at: &Checkpoint, nodes: usize) -> Vec<f32> {
        if at.nodes == nodes {
            return at.heights.clone();
        }
        let mut z = sampled(&relief(self.lattice(at.nodes), &at.heights, self.tilt), nodes);
        let range = UNEVENNESS * self.lattice(nodes).step.min_element();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.sculpting.seed ^ nodes as u64);
        z.iter_mut().for_each(|z| *z += (range * (rng.random::<f64>() - 0.5)) as f32);
        z
    }

    /// Blur at which reliefs are compared, degrees.
    fn compared_at(&self) -> f64 {
        if self.sculpting.settings.preview { 1.0 } else { COMPARED_AT }
    }

    /// The best of several starts on the coarse grid.
    fn tried(&self, nodes: usize, share: Share) -> Result<Checkpoint, SculptError> {
        let lattice = self.lattice(nodes);
        let mut best: Option<(f64, Checkpoint)> = None;
        let settings = &self.sculpting.settings;
        let starts = Start::suitable(settings.cutter.is_some() || settings.preview, settings.max_depth.is_some());
        for (k, &start) in starts.iter().enumerate() {
            let share = share.part(k, starts.len());
            let mut z = start.heights(lattice, self.plane.spread(), self.sculpting.seed);
            for (k, stage) in TRIES.iter().enumerate() {
                z = self.descend(lattice, z, stage, share.part(k, 3))?;
            }
            if settings.preview {
                z = self.descend(lattice, z, &PREVIEW_TRIAL, share.part(2, 3))?;
            } else {
                self.match_slopes(lattice, &mut z, TRIAL_ROUNDS, share.part(2, 3));
                z = self.descend(lattice, z, &trial_descent(self.sculpting), share.part(2, 3))?;
            }
            let blur = self.compared_at();
            let objective = self.objective(lattice, LossScale { blur, alpha: 0.0, weighed: false });
            let misplaced = objective.misplaced(&z, blur);
            // Light in the wrong place, on fillets and beyond the depth counts alike: what is left of each at the end
            // goes with what there is of it now.
            let error = misplaced + objective.fillets(&z) + objective.excess_depth(&z);
            if best.as_ref().is_none_or(|(least, _)| error < *least) {
                let at = Checkpoint { done: 1, start, nodes, heights: z, misplaced: vec![misplaced] };
                best = Some((error, at));
            }
            if self.progress.is_to_finish() {
                break;
            }
        }
        Ok(best.map(|(_, at)| at).ok_or(TooNarrow)?)
    }

    fn objective(&self, lattice: Lattice, scale: LossScale) -> Objective {
        // Two bins to a blur: what is finer than a bin is then damped to e^-5 or less, and no more bins are needed.
        let bin = (0.5 * scale.blur).max(FINEST_BIN);
        Objective::new(lattice, self.tilt, self.plane.target(bin), scale, &self.sculpting.settings)
    }

    /// The best that is reached until the stage ends, or the work is to finish.
    fn descend(&self, lattice: Lattice, z: Vec<f32>, stage: &Stage, share: Share) -> Result<Vec<f32>, Cancelled> {
        let mut objective = self.objective(lattice, stage.scale);
        self.progress.check()?;
        objective.set_penalties(&z, stage.concave);
        self.progress.check()?;
        let mut y = objective.unknowns(&z);
        let largest = y.iter().fold(0.0f32, |m, v| m.max(v.abs()));
        let with_tool = stage.scale.is_fine() && self.sculpting.settings.cutter.is_some();
        let parts = if with_tool { stage.steps.div_ceil(STEPS_PER_RESIDUAL) } else { 1 };
        let first_move = DESCENT_FIRST_MOVE * f64::from(largest);
        let settings = Descent { steps: stage.steps / parts, memory: MEMORY, tolerance: TOLERANCE, first_move };
        // Between two updates only what is added to the light changes: what a part has learnt of curvature serves the next.
        let mut past = Past::default();
        // What is cut short leaves `y` at the best so far.
        let cut_short = self.progress.until_finish();
        for part in 0..parts {
            if cut_short.is_abandoned()
                || with_tool && objective.update_tool_residual(&objective.relief(&y), &cut_short).is_err()
            {
                break;
            }
            let share = share.part(part, parts);
            let descended = minimise_on(
                &mut y,
                &mut past,
                &settings,
                |y, gradient| {
                    self.progress.offer_relief(|| self.so_far(lattice, objective.relief(y)));
                    objective.loss(y, gradient, &cut_short)
                },
                |step| {
                    self.progress.fraction(share.from + share.whole * step as f64 / settings.steps as f64);
                    !self.progress.is_to_finish()
                },
            );
            if descended.is_err() {
                break;
            }
        }
        self.progress.check()?;
        Ok(objective.relief(&y))
    }

    fn so_far(&self, lattice: Lattice, heights: Vec<f32>) -> SheetSoFar {
        SheetSoFar { nodes: lattice.n, cell: self.sculpting.cell, heights }
    }

    fn match_slopes(&self, lattice: Lattice, z: &mut Vec<f32>, rounds: usize, share: Share) {
        let matching = Matching::new(lattice, &self.plane.samples(lattice.n * lattice.n));
        let closing = self.sculpting.settings.cutter.map(|cutter| Closing::new(lattice, cutter));
        matching.run(z, closing.as_ref(), rounds, self.sculpting.seed, self.progress);
        self.progress.fraction(share.from + share.whole);
    }

    fn misplaced(&self, lattice: Lattice, z: &[f32]) -> Result<f64, Cancelled> {
        let blur = self.compared_at();
        let mut objective = self.objective(lattice, LossScale { blur, alpha: 0.0, weighed: false });
        if !self.sculpting.settings.preview {
            objective.update_tool_residual(z, self.progress)?;
        }
        Ok(objective.misplaced(z, blur))
    }

    /// The relief as it is written.
    fn finished(&self, at: Checkpoint, steps: [usize; 2]) -> Result<Sheet, Cancelled> {
        let SheetSpec { cell, cells, grid, settings, .. } = *self.sculpting;
        let lattice = self.lattice(grid);
        let z = self.resampled(&at, grid);
        let mut relief = relief(lattice, &z, self.tilt);
        if let Some(cutter) = settings.cutter.filter(|_| !settings.preview) {
            let tools = [Tool::new(cell, cutter), Tool::without_steps(cell, grid, cutter)];
            clear(&mut relief, Filled::whole(grid), tools, self.progress)?;
        }
        let objective = self.objective(lattice, LossScale { blur: COMPARED_AT, alpha: 0.0, weighed: false });
        let fillets = objective.fillets(&relief.heights);
        let mean = (relief.heights.iter().map(|v| f64::from(*v)).sum::<f64>() / relief.heights.len() as f64) as f32;
        relief.heights.iter_mut().for_each(|v| *v -= mean);
        relief.cells = cells;
        Ok(Sheet { relief, start: at.start, misplaced: at.misplaced, fillets, steps })
    }
}

/// Why no sheet came about.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SculptError {
    /// The design has no model of the cutter.
    #[error(transparent)]
    Cutter(#[from] UnmodelledCutter),
    /// The slopes have no extent.
    #[error(transparent)]
    TooNarrow(#[from] TooNarrow),
    /// The caller wanted nothing more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The highlight has no extent on the slope plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the highlight cannot be laid out as slopes around its mean: raise --half-field, or take --surface flat")]
pub struct TooNarrow;
