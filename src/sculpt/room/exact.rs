//! The descent over a whole plate, from wide blurs to the eye's.

use glam::DVec2;

use crate::cutter::Cutter;
use crate::descent::{Descent, minimise};
use crate::near::NearField;
use crate::progress::{Cancelled, Progress};
use crate::raster::Raster;
use crate::relief::open::OpenRelief;
use crate::sculpt::filling::clear;
use crate::sculpt::plan::{MEMORY, TOLERANCE};
use crate::sculpt::settings::SheetSettings;
use crate::sculpt::slope_loss::LossScale;
use crate::sculpt::tool::Tool;

use super::landing::wanted;
use super::milling::{filled, lattice_relief, usual_tool};
use super::objective::PlateObjective;
use super::plate_grid::PlateGrid;

/// What the eye blurs on the wall, mm: 2.3 arc-minutes from 3 m. Detail finer than that is not worth a step.
pub const EYE: f64 = 2.0;

/// Blurs, degrees, beyond which there is no end of the descent: as fine as the far design's, and as fine as diffraction of
/// patches of half a millimetre leaves anything.
const COARSEST_END: f64 = 0.25;
const FINEST_END: f64 = 0.06;

/// Blur at which plates are compared, degrees.
const COMPARED_AT: f64 = 0.5;

/// Largest first move of an unknown, in units of slope: a warped design misses by about as much.
const FIRST_MOVE: f64 = 2e-3;

/// Steps between two updates of the tool residual, as in the far design.
const STEPS_PER_RESIDUAL: usize = 40;

/// Nodes along the longer side of a plate at the most on which the wide blurs are descended.
const COARSE: usize = 640;

/// A plate whose light lands where it is wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct ExactSheet {
    /// Heights, mm, from where the middle of the base was.
    pub relief: OpenRelief,
    /// Total variation between its light as modelled and the wanted light, at a blur of 0.5°, before the descent and after
    /// each stage.
    pub misplaced: Vec<f64>,
    /// About the share of the plate that the cutter fills with fillets.
    pub fillets: f64,
}

/// One descent.
struct RoomStage {
    scale: LossScale,
    steps: usize,
    concave: f64,
    /// Whether it is done on the coarse grid, where there is one.
    coarse: bool,
}

/// Blur, α, steps. The first three are those of the trials; they end where the far design ends. The last two go down to the
/// eye's blur on the wall: in a room of 1.4 m a photograph's likeness at 2 mm rose from 0.63 to 0.94 by them.
/// Their α keeps what lies far apart in view: at 0.1 and 0, a word's misplaced light at 0.5° rose again from 0.0016 to
/// 0.0027, at 0.25 to 0.0023.
fn stages(eye: f64) -> [RoomStage; 5] {
    let end = eye.clamp(FINEST_END, COARSEST_END);
    let stage = |blur: f64, alpha, steps, concave, weighed, coarse| {
        let scale = LossScale { blur, alpha, weighed };
        RoomStage { scale, steps, concave, coarse }
    };
    [
        stage(0.5, 0.5, 30, 1.0, false, true),
        stage(0.35, 0.4, 30, 0.3, true, true),
        stage(0.25, 0.25, 40, 0.1, true, true),
        stage((COARSEST_END * end).sqrt(), 0.5, 40, 0.1, true, false),
        stage(end, 0.5, 40, 0.1, true, false),
    ]
}

/// Descends from `start` until the light of each triangle, where it lands, makes up `flux`, the wanted light of the
/// picture's square.
///
/// `None` if the scene has no image. Told to finish, it ends with the best so far.
pub fn exact(
    start: OpenRelief,
    near: &NearField,
    flux: &Raster,
    settings: &SheetSettings,
    progress: &Progress,
) -> Result<Option<ExactSheet>, Cancelled> {
    let eye = (EYE / near.scene().wall_distance()).atan().to_degrees();
    let halved = is_halved(start.nodes.map(|n| n - 1));
    let mut sheet = ExactSheet { relief: start, misplaced: Vec::new(), fillets: 0.0 };
    let stages = stages(eye);
    let all: f64 = stages.iter().map(|stage| cost(stage, halved)).sum();
    let mut spent = 0.0;
    let mut coarse = halved.then(|| every_second(&sheet.relief));
    let before = coarse.clone();
    for stage in &stages {
        let share = (spent / all, cost(stage, halved) / all);
        spent += cost(stage, halved);
        if let (Some(descended), Some(before), false) = (&coarse, &before, stage.coarse) {
            add_difference(&mut sheet.relief, before, descended);
            coarse = None;
        }
        let relief = coarse.as_ref().unwrap_or(&sheet.relief);
        let done = descend(relief, near, flux, (stage, share), settings, progress);
        let Some((descended, misplaced, fillets)) = done else { return Ok(None) };
        if sheet.misplaced.is_empty() {
            sheet.misplaced.push(misplaced[0]);
        }
        sheet.misplaced.push(misplaced[1]);
        sheet.fillets = fillets;
        *coarse.as_mut().unwrap_or(&mut sheet.relief) = descended;
        if progress.is_to_finish() {
            break;
        }
    }
    if let (Some(descended), Some(before)) = (&coarse, &before) {
        add_difference(&mut sheet.relief, before, descended);
    }
    cleared(&mut sheet.relief, settings, progress)?;
    Ok(Some(sheet))
}

/// About how long a stage takes, in any unit.
fn cost(stage: &RoomStage, halved: bool) -> f64 {
    stage.steps as f64 * if stage.coarse && halved { 0.25 } else { 1.0 }
}

/// Evaluations of the loss that a descent over a plate of `squares` of `step` mm takes, times the nodes of its lattice; and that
/// lattice.
pub(crate) fn evaluations(squares: [usize; 2], step: DVec2, cutter: Option<Cutter>) -> (f64, PlateGrid) {
    let grid = PlateGrid::new(squares, step, cutter);
    let halved = is_halved(squares);
    // The eye's blur changes no stage's steps.
    let steps: f64 = stages(FINEST_END).iter().map(|stage| cost(stage, halved)).sum();
    (steps * (grid.lattice.n as f64).powi(2), grid)
}

/// Whether the wide blurs of a plate of so many squares are descended on every second node.
fn is_halved(squares: [usize; 2]) -> bool {
    squares[0].max(squares[1]) > COARSE && squares.iter().all(|n| n.is_multiple_of(2))
}

/// One stage from `relief`: what comes of it, the misplaced light before and after, and the share of fillets.
fn descend(
    relief: &OpenRelief,
    near: &NearField,
    flux: &Raster,
    (stage, share): (&RoomStage, (f64, f64)),
    settings: &SheetSettings,
    progress: &Progress,
) -> Option<(OpenRelief, [f64; 2], f64)> {
    // A blur of two bins is the narrowest that bins show.
    let target = wanted(near.scene(), flux, near.mean(), 0.5 * stage.scale.blur.min(COARSEST_END))?;
    let mut objective = PlateObjective::new(relief, near, target, stage.scale, settings);
    objective.set_penalties(stage.concave);
    let mut y = vec![0.0f32; objective.unknowns()];
    let before = objective.misplaced(&y, COMPARED_AT);
    let with_tool = stage.scale.is_fine() && settings.cutter.is_some();
    let parts = if with_tool { stage.steps.div_ceil(STEPS_PER_RESIDUAL) } else { 1 };
    let descent = Descent { steps: stage.steps / parts, memory: MEMORY, tolerance: TOLERANCE, first_move: FIRST_MOVE };
    // What is cut short leaves `y` at the best so far.
    let cut_short = progress.until_finish();
    for part in 0..parts {
        if cut_short.is_abandoned() || with_tool && objective.update_tool_residual(&y, &cut_short).is_err() {
            break;
        }
        let done = |step: usize| (part as f64 + step as f64 / descent.steps as f64) / parts as f64;
        let descended = minimise(
            &mut y,
            &descent,
            |y, gradient| {
                cut_short.check()?;
                Ok(objective.loss(y, gradient))
            },
            |step| {
                progress.fraction(share.0 + share.1 * done(step));
                !progress.is_to_finish()
            },
        );
        if descended.is_err() {
            break;
        }
    }
    let after = objective.misplaced(&y, COMPARED_AT);
    Some((objective.relief(&y), [before, after], objective.fillets(&y)))
}

/// Raises what the cutter does not reach.
fn cleared(relief: &mut OpenRelief, settings: &SheetSettings, progress: &Progress) -> Result<(), Cancelled> {
    let Some(cutter) = settings.cutter else { return Ok(()) };
    let grid = PlateGrid::of(relief, Some(cutter));
    let mut lattice = lattice_relief(&grid, &grid.embedded(relief));
    let finer = Tool::without_steps(grid.lattice.cell(), grid.lattice.n, cutter);
    clear(&mut lattice, filled(&grid), [usual_tool(&grid, cutter), finer], progress)?;
    *relief = grid.plate(&lattice.heights);
    Ok(())
}

/// Every second node of a plate whose squares are even in number.
fn every_second(relief: &OpenRelief) -> OpenRelief {
    let nodes = relief.nodes.map(|n| n.div_ceil(2));
    let at = |k: usize| 2 * (k / nodes[0]) * relief.nodes[0] + 2 * (k % nodes[0]);
    let heights = (0..nodes[0] * nodes[1]).map(|k| relief.heights[at(k)]).collect();
    OpenRelief { nodes, step: 2.0 * relief.step, heights }
}

/// Adds to `relief` how `after` differs from `before`, both on every second node, bilinear between them.
fn add_difference(relief: &mut OpenRelief, before: &OpenRelief, after: &OpenRelief) {
    let [columns, rows] = before.nodes;
    let change = |i: usize, j: usize| {
        let k = j.min(rows - 1) * columns + i.min(columns - 1);
        after.heights[k] - before.heights[k]
    };
    let width = relief.nodes[0];
    for (k, z) in relief.heights.iter_mut().enumerate() {
        let (i, j) = (k % width, k / width);
        let (right, up) = (i.div_ceil(2), j.div_ceil(2));
        *z += 0.25 * (change(i / 2, j / 2) + change(right, j / 2) + change(i / 2, up) + change(right, up));
    }
}
