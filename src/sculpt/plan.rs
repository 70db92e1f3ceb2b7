//! What a sheet shall be, the steps to it, and what each costs.

use glam::DVec2;

use crate::cutter::Cutter;

use super::objective::LossScale;

/// What a sheet shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetSettings {
    /// Size of a cell, mm.
    pub cell: DVec2,
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// Nodes along each side of a cell, an even number.
    pub grid: usize,
    /// The cutter that the relief is for.
    pub cutter: Option<Cutter>,
    /// Polish or paint after the cutter: a Gaussian over the heights of this standard deviation, mm.
    pub polish: f64,
    /// Waves shorter than this are damped, mm; 0 damps none.
    pub min_feature: f64,
    /// The most that a cell may rise from its lowest to its highest point about its mean plane, mm.
    pub max_depth: Option<f64>,
    /// Seed of everything random.
    pub seed: u64,
}

/// Nodes a side, at the most, of the first tries and of the matching.
const COARSE: usize = 128;
const MIDDLE: usize = 256;

/// Length of a descent's first move, as a share of the largest number that it moves.
pub const DESCENT_FIRST_MOVE: f64 = 0.02;

/// Moves that a descent remembers.
pub const MEMORY: usize = 10;

/// A descent ends when a step gains less than this share.
pub const TOLERANCE: f64 = 1e-6;

/// A descent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// How it looks at light.
    pub scale: LossScale,
    /// Steps at the most.
    pub steps: usize,
    /// What concave edges that turn upward cost at its start, as a share of all loss.
    pub concave: f64,
}

const fn stage(blur: f64, alpha: f64, steps: usize, concave: f64) -> Stage {
    Stage { scale: LossScale { blur, alpha, weighed: blur < 0.6 }, steps, concave }
}

/// What every start goes through on the coarse grid, before some rounds of matching and a last descent: only then can be
/// told which will end best.
pub const TRIES: [Stage; 2] = [stage(3.0, 1.0, 40, 0.3), stage(1.5, 1.0, 40, 1.0)];

/// Rounds of matching of a try.
pub const TRIAL_ROUNDS: usize = 15;

/// What follows them: where steps are cheap, as many as it takes to tell which start is best for a logo of many pieces.
pub fn trial_descent(sculpting: &SheetSettings) -> Stage {
    stage(0.5, 0.75, if sculpting.cutter.is_some() { 30 } else { 80 }, 1.0)
}

/// Rounds of matching on the middle grid.
const ROUNDS: usize = 50;

/// The descent after the matching, and on every finer grid.
const DESCENT: [Stage; 3] = [stage(0.5, 0.75, 60, 1.0), stage(0.35, 0.5, 80, 0.3), stage(0.25, 0.25, 60, 0.1)];
const FINISH: [Stage; 2] = [stage(0.35, 0.5, 60, 0.3), stage(0.25, 0.25, 90, 0.1)];

/// One step of a design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Several starts.
    Tries {
        /// Nodes a side.
        nodes: usize,
    },
    /// Exchanges between wanted slopes and reliefs.
    Matching {
        /// Nodes a side.
        nodes: usize,
        /// Exchanges.
        rounds: usize,
    },
    /// A descent.
    Descent {
        /// Nodes a side.
        nodes: usize,
        /// How.
        stage: Stage,
    },
}

impl Step {
    /// Nodes along a side of the cell.
    pub fn nodes(&self) -> usize {
        match *self {
            Self::Tries { nodes } | Self::Matching { nodes, .. } | Self::Descent { nodes, .. } => nodes,
        }
    }

    /// What is done in it, in one word.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Tries { .. } => "tries",
            Self::Matching { .. } => "matching",
            Self::Descent { .. } => "descent",
        }
    }

    /// About how long it takes, in any unit: evaluations of the loss times nodes.
    pub fn cost(&self) -> f64 {
        let evaluations = match *self {
            Self::Tries { .. } => 500,
            Self::Matching { rounds, .. } => rounds,
            Self::Descent { stage, .. } => stage.steps,
        };
        evaluations as f64 * self.nodes().pow(2) as f64
    }
}

/// The steps to a relief of `sculpting`, in order.
pub fn plan(sculpting: &SheetSettings) -> Vec<Step> {
    let mut nodes = halved(sculpting.grid, MIDDLE);
    let mut steps = vec![Step::Tries { nodes: halved(nodes, COARSE) }];
    // Where valleys may be sharp a descent alone gets as far, and logos of many pieces further.
    if sculpting.cutter.is_some() {
        steps.push(Step::Matching { nodes, rounds: ROUNDS });
    }
    steps.extend(DESCENT.map(|stage| Step::Descent { nodes, stage }));
    while nodes < sculpting.grid {
        nodes = halved(sculpting.grid, 2 * nodes + 2);
        steps.extend(FINISH.map(|stage| Step::Descent { nodes, stage }));
    }
    steps
}

/// `grid` halved until it is no more than `most`, an even number: what is level on a grid is level on its double.
fn halved(grid: usize, most: usize) -> usize {
    let mut nodes = grid;
    while nodes > most {
        nodes = (nodes / 2).next_multiple_of(2);
    }
    nodes
}

/// Nodes a side of a cell that suit a plate: fine enough for the picture and the cutter, and few enough for a file that
/// can be handled.
///
/// `most_triangles` is for the whole plate.
pub fn suitable_grid(cell: DVec2, cells: [usize; 2], cutter: Option<Cutter>, most_triangles: usize) -> usize {
    /// Enough for a picture: at half as many, details of a quarter of a degree are grainy.
    const FOR_A_PICTURE: f64 = 400.0;
    // Transforms are fast where all factors are small, and grids are halved once or twice on the way.
    const SIDES: [usize; 16] = [64, 80, 96, 128, 160, 200, 240, 256, 320, 360, 400, 480, 512, 640, 800, 1024];
    let by_file = (most_triangles as f64 / (2 * cells[0] * cells[1]) as f64).sqrt();
    // From one triangle to the next a ball turns by the distance of nodes over its radius.
    let by_cutter = cutter.map_or(0.0, |cutter| cell.max_element() / (0.05 * cutter.valley_radius()));
    let wanted = by_cutter.clamp(FOR_A_PICTURE, 1024.0);
    let fitting = SIDES.into_iter().filter(|&n| n as f64 <= by_file.max(64.0));
    fitting.clone().find(|&n| n as f64 >= wanted).or(fitting.max()).unwrap_or(64)
}
