//! The stages of a continuous relief: first tries on a coarse grid, matching, then descent on finer and finer grids.

use glam::DVec2;
use serde::Serialize;

use crate::descent::{Descent, minimise};
use crate::distribution::Distribution;
use crate::progress::Progress;
use crate::relief::periodic::PeriodicRelief;

use super::closing::Closing;
use super::light::Lattice;
use super::matching::Matching;
use super::objective::{Ball, Gaze, Objective};
use super::start::Start;
use super::target::SlopePlane;

/// A step of the descent.
struct Stage {
    gaze: Gaze,
    steps: usize,
    /// What light from fillets costs at the stage's start, as a share of all loss.
    fillets: f64,
}

const fn stage(blur: f64, alpha: f64, steps: usize, fillets: f64) -> Stage {
    Stage { gaze: Gaze { blur, alpha }, steps, fillets }
}

/// Nodes a side of the first tries, and of the matching.
const COARSE: usize = 128;
const MIDDLE: usize = 256;

/// What is tried first, and how long.
const STARTS: [Start; 4] = [Start::Hills(4), Start::Hills(2), Start::Cone, Start::Roof];
/// For a cutter, with as few valleys as can be.
const STARTS_TO_CUT: [Start; 2] = [Start::Hills(1), Start::Cone];
const TRIES: [Stage; 2] = [stage(3.0, 1.0, 40, 0.3), stage(1.5, 1.0, 40, 1.0)];

/// Width over which edges are taken to be rounded, radii of the cutter: no edge survives sharper, and a relief that is
/// judged on a grid has no sharper ones. Counted in stages whose blur is below the second number, degrees.
const ROUNDING: f64 = 0.04;
const ROUNDED_BELOW: f64 = 0.4;

/// Blur at which tries are compared, degrees.
const TRIED_AT: f64 = 0.5;

/// With a cutter, tries go on with some rounds of matching and this descent.
const TRIAL_ROUNDS: usize = 15;
const TRIAL_DESCENT: [Stage; 1] = [stage(0.5, 0.75, 30, 1.0)];

/// Rounds of matching.
const ROUNDS: usize = 50;

/// The descent after the matching, and on every finer grid.
const DESCENT: [Stage; 3] = [stage(0.5, 0.75, 60, 1.0), stage(0.35, 0.5, 100, 0.5), stage(0.25, 0.25, 100, 0.2)];
const FINISH: [Stage; 2] = [stage(0.35, 0.5, 40, 0.5), stage(0.25, 0.25, 60, 0.2)];

/// What a continuous relief shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sculpting {
    /// Size of a cell, mm.
    pub cell: DVec2,
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// Nodes along each side of a cell, an even number.
    pub grid: usize,
    /// Radius of the ball cutter that the relief is for, mm.
    pub cutter: Option<f64>,
    /// Waves shorter than this are damped, mm; 0 damps none.
    pub min_feature: f64,
    /// Seed of everything random.
    pub seed: u64,
}

/// A continuous relief, and how it came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Sculpture {
    /// The relief, triangle for triangle as it is written.
    pub relief: PeriodicRelief,
    /// What was started from.
    pub start: Start,
    /// Light in the wrong place as the design sees it, at a blur of 0.5°, after each stage.
    pub misplaced: Vec<f64>,
    /// Share of the plate that the cutter fills with fillets.
    pub fillets: f64,
}

/// Nodes a side of a cell that suit a plate: fine enough for the picture and the cutter, and few enough for a file that
/// can be handled.
///
/// `most_triangles` is for the whole plate.
pub fn suitable_grid(cell: DVec2, cells: [usize; 2], cutter: Option<f64>, most_triangles: usize) -> usize {
    let by_file = (most_triangles as f64 / (2 * cells[0] * cells[1]) as f64).sqrt();
    let wanted = match cutter {
        None => MIDDLE as f64,
        // A ball turns by the distance of two nodes over its radius from one triangle to the next.
        Some(radius) => (cell.max_element() / (0.05 * radius)).clamp(MIDDLE as f64, 1024.0),
    };
    let sides =
        [64, 96, 128, 160, 192, 200, 240, 256, 288, 320, 360, 384, 400, 432, 480, 512, 576, 640, 768, 864, 1024];
    let fitting = sides.iter().copied().filter(|&n| n as f64 <= by_file.max(64.0));
    let enough = fitting.clone().find(|&n| n as f64 >= wanted);
    enough.or_else(|| fitting.max()).unwrap_or(64)
}

/// Designs the relief whose light is `distribution`'s.
///
/// `None` if the distribution's image is too narrow to be laid out, or the work was cancelled before its first result.
pub fn sculpt(distribution: &Distribution, sculpting: &Sculpting, progress: &Progress) -> Option<Sculpture> {
    let plane = SlopePlane::new(distribution, 0.1)?;
    let work = Work { sculpting, plane };
    let mut misplaced = Vec::new();
    let n = sculpting.grid;
    let lattice = |n: usize| Lattice { n, step: sculpting.cell / n as f64 };

    let coarse = lattice(n.min(COARSE));
    let mut best: Option<(f64, Start, Vec<f32>)> = None;
    let starts: &[Start] = if sculpting.cutter.is_some() { &STARTS_TO_CUT } else { &STARTS };
    for (k, &start) in starts.iter().enumerate() {
        progress.fraction(0.2 * k as f64 / starts.len() as f64);
        let z = start.heights(coarse, work.plane.spread(), sculpting.seed);
        let mut z = work.descend(coarse, z, &TRIES, progress);
        if sculpting.cutter.is_some() {
            // Only then can be told which will end with the fewest valleys.
            work.matching(coarse, &mut z, TRIAL_ROUNDS, progress);
            z = work.descend(coarse, z, &TRIAL_DESCENT, progress);
        }
        let wrong = work.misplaced(coarse, &z) + work.fillets(coarse, &z);
        if best.as_ref().is_none_or(|(least, ..)| wrong < *least) {
            best = Some((wrong, start, z));
        }
        if progress.is_cancelled() {
            break;
        }
    }
    let (wrong, start, mut z) = best?;
    misplaced.push(wrong);

    let middle = lattice(n.min(MIDDLE));
    z = resampled(&z, coarse.n, middle.n);
    work.matching(middle, &mut z, ROUNDS, progress);
    misplaced.push(work.misplaced(middle, &z));
    progress.fraction(0.3);
    z = work.descend(middle, z, &DESCENT, progress);
    misplaced.push(work.misplaced(middle, &z));

    let mut present = middle;
    while present.n < n && !progress.is_cancelled() {
        let finer = lattice(n.min(2 * present.n));
        z = resampled(&z, present.n, finer.n);
        z = work.descend(finer, z, &FINISH, progress);
        misplaced.push(work.misplaced(finer, &z));
        present = finer;
    }
    if let Some(closing) = work.closing(present) {
        closing.settle(&mut z, 30);
    }
    let fillets = work.fillets(present, &z);
    let mean = (z.iter().map(|v| f64::from(*v)).sum::<f64>() / z.len() as f64) as f32;
    z.iter_mut().for_each(|v| *v -= mean);
    let Sculpting { cell, cells, .. } = *sculpting;
    let relief = PeriodicRelief { nodes: n, heights: z, cell, cells, tilt: distribution.mean };
    Some(Sculpture { relief, start, misplaced, fillets })
}

/// What all stages share.
struct Work<'a> {
    sculpting: &'a Sculpting,
    plane: SlopePlane,
}

impl Work<'_> {
    fn ball(&self, lattice: Lattice, fine: bool) -> Option<Ball> {
        self.sculpting.cutter.map(|cutter| Ball {
            cutter,
            closing: closing_radius(lattice, cutter),
            rounding: if fine { ROUNDING * cutter } else { 0.0 },
        })
    }

    fn closing(&self, lattice: Lattice) -> Option<Closing> {
        self.ball(lattice, false).map(|ball| Closing::new(lattice.n, lattice.step, ball.closing))
    }

    fn objective(&self, lattice: Lattice, gaze: Gaze) -> Objective {
        let target = self.plane.target((0.5 * gaze.blur).max(0.125));
        Objective::new(lattice, target, gaze, self.ball(lattice, gaze.blur < ROUNDED_BELOW), self.sculpting.min_feature)
    }

    fn descend(&self, lattice: Lattice, mut z: Vec<f32>, stages: &[Stage], progress: &Progress) -> Vec<f32> {
        for stage in stages {
            if progress.is_cancelled() {
                break;
            }
            let mut objective = self.objective(lattice, stage.gaze);
            objective.charge_fillets(&z, stage.fillets);
            let mut y = objective.numbers(&z);
            let largest = y.iter().fold(0.0f32, |m, v| m.max(v.abs()));
            let first_move = 0.02 * f64::from(largest);
            let settings = Descent { steps: stage.steps, memory: 12, tolerance: 1e-6, first_move };
            minimise(&mut y, &settings, |y, gradient| objective.loss(y, gradient));
            z = objective.relief(&y);
        }
        z
    }

    fn matching(&self, lattice: Lattice, z: &mut Vec<f32>, rounds: usize, progress: &Progress) {
        let matching = Matching::new(lattice, &self.plane.samples(lattice.n * lattice.n));
        matching.run(z, self.closing(lattice).as_ref(), rounds, self.sculpting.seed, progress);
    }

    fn fillets(&self, lattice: Lattice, z: &[f32]) -> f64 {
        if self.sculpting.cutter.is_none() {
            return 0.0;
        }
        self.objective(lattice, TRIES[0].gaze).fillets(z)
    }

    fn misplaced(&self, lattice: Lattice, z: &[f32]) -> f64 {
        self.objective(lattice, Gaze { blur: TRIED_AT, alpha: 0.0 }).misplaced(z, TRIED_AT)
    }
}

/// How far the cutter may stay above the middle of a written valley, mm.
const CLEARANCE: f64 = 0.4e-3;

/// Radius by which nodes are closed so that a ball of `cutter` mm radius meets every triangle between them to within
/// [`CLEARANCE`]: over a bowl whose nodes lie on a ball of radius r it stays R h²/4r² above the corners.
fn closing_radius(lattice: Lattice, cutter: f64) -> f64 {
    let h2 = lattice.step.length_squared() / 2.0;
    cutter.max((cutter * h2 / (4.0 * CLEARANCE)).sqrt()).min(2.0 * cutter)
}

/// Heights of a periodic grid on another, by Catmull-Rom splines.
fn resampled(z: &[f32], from: usize, to: usize) -> Vec<f32> {
    if from == to {
        return z.to_vec();
    }
    let weights: Vec<([usize; 4], [f32; 4])> = (0..to)
        .map(|k| {
            let at = k as f64 * from as f64 / to as f64;
            let (i, t) = (at as usize, at.fract());
            let nodes = [from - 1, 0, 1, 2].map(|d| (i + d) % from);
            let w = [
                0.5 * t * (-1.0 + t * (2.0 - t)),
                0.5 * (2.0 + t * t * (3.0 * t - 5.0)),
                0.5 * t * (1.0 + t * (4.0 - 3.0 * t)),
                0.5 * t * t * (t - 1.0),
            ];
            (nodes, w.map(|w| w as f32))
        })
        .collect();
    let along_x: Vec<f32> = z
        .chunks(from)
        .flat_map(|row| weights.iter().map(move |(k, w)| (0..4).map(|d| w[d] * row[k[d]]).sum::<f32>()))
        .collect();
    weights
        .iter()
        .flat_map(|(k, w)| {
            let along_x = &along_x;
            (0..to).map(move |i| (0..4).map(|d| w[d] * along_x[k[d] * to + i]).sum::<f32>())
        })
        .collect()
}

impl Serialize for Start {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Cone => serializer.serialize_str("cone"),
            Self::Roof => serializer.serialize_str("roof"),
            Self::Hills(n) => serializer.serialize_str(&format!("hills {n}")),
        }
    }
}
