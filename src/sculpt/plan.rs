//! What a sheet shall be, the steps to it, and what each costs.

use glam::DVec2;

use crate::cutter::Cutter;

use super::settings::SheetSettings;
use super::slope_loss::LossScale;

/// What a sheet shall be: its cells and nodes, and what it was told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetSpec {
    /// Size of a cell, mm.
    pub cell: DVec2,
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// Nodes along each side of a cell, an even number.
    pub grid: usize,
    /// Seed of everything random.
    pub seed: u64,
    /// What it was told.
    pub settings: SheetSettings,
}

/// Nodes a side of the first tries, at the most: all starts together then cost less than the
/// descents on 256² nodes.
const COARSE: usize = 128;

/// Nodes a side of the matching and of the first whole descent, at the most.
const MIDDLE: usize = 256;

/// Length of a descent's first move, as a share of the largest unknown. It matters for one step: L-BFGS scales all others
/// by the curvature that it has met.
pub(crate) const DESCENT_FIRST_MOVE: f64 = 0.02;

/// Moves that a descent remembers: 5 to 20 are usual, and each takes two more grids of memory.
pub(crate) const MEMORY: usize = 10;

/// A descent ends when a step lowers the loss by less than this share of it. Few do: the number of steps decides.
pub(crate) const TOLERANCE: f64 = 1e-6;

/// A descent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// How it compares light.
    pub scale: LossScale,
    /// Steps at the most.
    pub steps: usize,
    /// The penalty on concave edges at its start, as a share of the loss without it.
    pub concave: f64,
}

const fn stage(blur: f64, alpha: f64, steps: usize, concave: f64) -> Stage {
    Stage { scale: LossScale { blur, alpha, weighed: blur < 0.6 }, steps, concave }
}

/// The descents of every start on the coarse grid, from a blur as wide as the picture's parts, where every start finds the
/// same rough relief. Then follow some rounds of matching and one more descent: after these two alone the start that looked
/// best was often not the one that ended best.
pub const TRIES: [Stage; 2] = [stage(3.0, 1.0, 40, 0.3), stage(1.5, 1.0, 40, 1.0)];

/// Rounds of matching of a try: of `ROUNDS` the part that brings most.
pub(crate) const TRIAL_ROUNDS: usize = 15;

/// The descent after them. A logo of sixteen pieces needed 80 steps to tell which start is best; with a cutter a step costs
/// twice as much, and 30 do.
pub(crate) fn trial_descent(sculpting: &SheetSpec) -> Stage {
    stage(0.5, 0.75, if sculpting.settings.cutter.is_some() { 30 } else { 80 }, 1.0)
}

/// Rounds of matching on the middle grid: the trials of the method used 50 to 75, and more did not change what the descent
/// ends with.
const ROUNDS: usize = 50;

/// The descents after the matching, and on every finer grid: blur, α, steps, share of the penalty on concave edges.
///
/// Blur and α are those of the trials. The steps were halved until scores changed (100 in place of 60 to 80 end no better);
/// finer grids were given a few more again. The penalty falls, since at the end light that a fillet moves is in the loss
/// itself, and what the penalty is still needed for is the tool's grid.
const DESCENT: [Stage; 3] = [stage(0.5, 0.75, 60, 1.0), stage(0.35, 0.5, 80, 0.3), stage(0.25, 0.25, 60, 0.1)];
const FINISH: [Stage; 2] = [stage(0.35, 0.5, 60, 0.3), stage(0.25, 0.25, 90, 0.1)];

/// Nodes a side of a preview, and of its first tries.
pub const PREVIEW_NODES: usize = 64;
const PREVIEW_TRIES: usize = 32;

/// The last descent of a preview's tries, in place of matching and of that of [`trial_descent`], and its descents. With α = 0.5
/// in the first two a word of sixteen pieces ended at 0.0032 of its light misplaced at 1°, and at 0.0025 with these; a
/// photograph with 0.6° in the last at 0.0034 to 0.0036, and at 0.0026.
pub(crate) const PREVIEW_TRIAL: Stage = stage(1.0, 0.75, 20, 1.0);
const PREVIEW: [Stage; 3] = [stage(1.0, 0.75, 60, 0.3), stage(0.7, 0.75, 80, 0.3), stage(0.5, 0.5, 70, 0.3)];

/// Steps after which a preview that has a relief of a similar one goes on.
pub const PREVIEW_WARM: usize = PREVIEW.len();

/// One step of a design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Several starts, of which the best is kept.
    Tries {
        /// Nodes a side.
        nodes: usize,
    },
    /// Rounds of matching.
    Matching {
        /// Nodes a side.
        nodes: usize,
        /// Rounds.
        rounds: usize,
    },
    /// A descent.
    Descent {
        /// Nodes a side.
        nodes: usize,
        /// Scale, steps and penalty.
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
pub fn plan(sculpting: &SheetSpec) -> Vec<Step> {
    if sculpting.settings.preview {
        let tries = Step::Tries { nodes: halved(sculpting.grid, PREVIEW_TRIES) };
        let descents = PREVIEW.map(|stage| Step::Descent { nodes: sculpting.grid, stage });
        return std::iter::once(tries).chain(descents).collect();
    }
    let mut nodes = halved(sculpting.grid, MIDDLE);
    let mut steps = vec![Step::Tries { nodes: halved(nodes, COARSE) }];
    // Without a cutter a descent alone ends as well, and better for logos of many pieces (0.0075 and 0.0079 in total
    // variation at 0.5° for one of sixteen).
    if sculpting.settings.cutter.is_some() {
        steps.push(Step::Matching { nodes, rounds: ROUNDS });
    }
    steps.extend(DESCENT.map(|stage| Step::Descent { nodes, stage }));
    while nodes < sculpting.grid {
        nodes = halved(sculpting.grid, 2 * nodes + 2);
        steps.extend(FINISH.map(|stage| Step::Descent { nodes, stage }));
    }
    steps
}

/// `grid` halved until it is no more than `most`, an even number: a triangle of a grid is a plane on its double too.
fn halved(grid: usize, most: usize) -> usize {
    let mut nodes = grid;
    while nodes > most {
        nodes = (nodes / 2).next_multiple_of(2);
    }
    nodes
}

/// Nodes a side of a cell that suit a plate: fine enough for the picture and the cutter, and few enough for a file that
/// can be handled, which is where `fits` says yes; the least there are if it never does.
pub(crate) fn suitable_grid(cell: DVec2, cutter: Option<Cutter>, fits: impl Fn(usize) -> bool) -> usize {
    /// Enough for a picture: at half as many, details of a quarter of a degree are grainy.
    const FOR_A_PICTURE: f64 = 400.0;
    // Transforms are fast where all factors are small, and grids are halved once or twice on the way.
    const SIDES: [usize; 24] =
        [16, 20, 24, 32, 40, 48, 56, 60, 64, 80, 96, 128, 160, 200, 240, 256, 320, 360, 400, 480, 512, 640, 800, 1024];
    // In a hollow as round as the cutter, slopes differ by the distance of nodes over its radius from one triangle to the
    // next: by 0.05, about as much as from one place of the tool to the next (0.04).
    let by_cutter = cutter.map_or(0.0, |cutter| cell.max_element() / (0.05 * cutter.valley_radius()));
    let wanted = by_cutter.clamp(FOR_A_PICTURE, 1024.0);
    let fitting = SIDES.into_iter().filter(|&n| fits(n));
    fitting.clone().find(|&n| n as f64 >= wanted).or(fitting.max()).unwrap_or(SIDES[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(grid: usize, cutter: Option<Cutter>) -> SheetSpec {
        let cell = DVec2::splat(10.0);
        SheetSpec { cell, cells: [3, 3], grid, seed: 1, settings: SheetSettings { cutter, ..SheetSettings::default() } }
    }

    /// A step in a few letters: what it is, nodes, rounds or steps.
    fn short(step: &Step) -> String {
        match step {
            Step::Tries { nodes } => format!("T{nodes}"),
            Step::Matching { nodes, rounds } => format!("M{nodes}x{rounds}"),
            Step::Descent { nodes, stage } => format!("D{nodes}@{}x{}", stage.scale.blur, stage.steps),
        }
    }

    #[test]
    fn plans_go_from_coarse_grids_to_the_asked_one() {
        // The grids of the tries, of the descent after them and of the finer ones.
        let grids: [(usize, usize, usize, &[usize]); 12] = [
            (16, 16, 16, &[]),
            (64, 64, 64, &[]),
            (128, 128, 128, &[]),
            (130, 66, 130, &[]),
            (250, 126, 250, &[]),
            (256, 128, 256, &[]),
            (258, 66, 130, &[258]),
            (400, 100, 200, &[400]),
            (512, 128, 256, &[512]),
            (1000, 126, 250, &[500, 1000]),
            (1024, 128, 256, &[512, 1024]),
            (4096, 128, 256, &[512, 1024, 2048, 4096]),
        ];
        for (grid, tries, first, finer) in grids {
            for cutter in [None, Some(Cutter::ball(0.5))] {
                let mut expected = vec![format!("T{tries}")];
                expected.extend(cutter.map(|_| format!("M{first}x50")));
                expected.extend(["0.5x60", "0.35x80", "0.25x60"].map(|stage| format!("D{first}@{stage}")));
                for nodes in finer {
                    expected.extend(["0.35x60", "0.25x90"].map(|stage| format!("D{nodes}@{stage}")));
                }
                let steps = plan(&sheet(grid, cutter));
                assert_eq!(steps.iter().map(short).collect::<Vec<_>>(), expected);
                assert!(steps.iter().all(|step| step.nodes().is_multiple_of(2) && step.cost() > 0.0));
            }
        }
    }

    #[test]
    fn scales_go_from_wide_to_narrow_and_the_dark_weighs_more_where_they_are_narrow() {
        for cutter in [None, Some(Cutter::ball(0.5))] {
            let descents = [TRIES[0], TRIES[1], trial_descent(&sheet(256, cutter))].into_iter().chain(DESCENT);
            let scales: Vec<LossScale> = descents.map(|stage| stage.scale).collect();
            assert!(scales.iter().all(|scale| scale.weighed == (scale.blur < 0.6)));
            for pair in scales.windows(2) {
                assert!(pair[1].blur <= pair[0].blur && pair[1].alpha <= pair[0].alpha, "{pair:?}");
            }
        }
    }

    #[test]
    fn grids_suit_the_picture_the_cutter_and_the_file() {
        // 18 triangles a node of nine cells.
        let suitable = |cutter: Option<f64>, most: usize| {
            suitable_grid(DVec2::splat(10.0), cutter.map(Cutter::ball), |n| 18 * n * n <= most)
        };
        assert_eq!(suitable(None, 4_000_000), 400);
        assert_eq!([1.0, 0.5, 0.2].map(|ball| suitable(Some(ball), 40_000_000)), [400, 800, 1024]);
        assert_eq!([256, 100, 40].map(|n| suitable(None, 18 * n * n)), [256, 96, 40]);
        assert_eq!(suitable(None, 1000), 16);
    }
}
