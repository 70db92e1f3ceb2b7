//! How fast this machine is beside the one on which times were measured.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use glam::{DMat2, DVec2};
use rayon::ThreadPoolBuilder;

use crate::cutter::Cutter;
use crate::progress::Progress;
use crate::sculpt::edge_slopes::Lattice;
use crate::sculpt::objective::Objective;
use crate::sculpt::settings::SheetSettings;
use crate::sculpt::slope_loss::LossScale;
use crate::sculpt::target::SlopeTarget;
use crate::slope::Slope;

/// CPU seconds of one evaluation of [`Kernel`] on a machine of speed 1, on which the constants of `estimate` were measured.
const REFERENCE: f64 = 5.5e-3;

/// The longest that measuring may take.
const LONGEST: Duration = Duration::from_millis(40);

/// Nodes a side of the kernel's grid, and bins a side of its light: as of the first descents of a design.
const NODES: usize = 128;
const BINS: usize = 200;

/// Width of a bin, degrees.
const BIN: f64 = 0.25;

/// How many times as fast a thread of this machine is as one of the machine on which times were measured, by the fastest of
/// some evaluations of a sheet's loss, which is what designs spend their time on. Takes about 50 ms, and changes nothing else.
///
/// A kernel of its own, slopes of a grid and a table, once found a machine half as fast as it was with real designs.
pub fn relative_speed() -> f64 {
    // On one thread, whose time is that of all the work; where there can be none, nothing is known.
    let fastest = ThreadPoolBuilder::new().num_threads(1).build().map(|pool| pool.install(fastest)).unwrap_or(0.0);
    // Nor is it where a clock is too coarse.
    if fastest > 0.0 { REFERENCE / fastest } else { 1.0 }
}

/// CPU seconds of the fastest evaluation.
fn fastest() -> f64 {
    let begun = Instant::now();
    let mut kernel = Kernel::new();
    let mut fastest = f64::INFINITY;
    // The first finds nothing in the caches.
    kernel.evaluate();
    while begun.elapsed() < LONGEST || fastest.is_infinite() {
        let from = ThreadTime::now();
        kernel.evaluate();
        fastest = fastest.min(from.elapsed().as_secs_f64());
    }
    fastest
}

/// The loss of a sheet of two waves for a ball of 0.5 mm, whose light shall be a ring, with its gradient.
struct Kernel {
    objective: Objective,
    unknowns: Vec<f32>,
    gradient: Vec<f32>,
}

impl Kernel {
    fn new() -> Self {
        let lattice = Lattice { n: NODES, step: DVec2::splat(10.0 / NODES as f64) };
        let middle = DVec2::splat(0.5 * (BINS - 1) as f64);
        let ring = |k: usize| {
            let radius = (DVec2::new((k % BINS) as f64, (k / BINS) as f64) - middle).length() * BIN;
            if (8.0..16.0).contains(&radius) { 1.0 } else { 0.0 }
        };
        let wanted: Vec<f32> = (0..BINS * BINS).map(ring).collect();
        let sum: f32 = wanted.iter().sum();
        let target = SlopeTarget {
            side: BINS,
            bin: BIN,
            wanted: wanted.iter().map(|share| share / sum).collect(),
            // A slope turns light by twice its angle.
            per_slope: DMat2::from_diagonal(DVec2::splat(2.0f64.to_degrees() / BIN)),
            degrees: DMat2::from_diagonal(DVec2::splat(BIN)),
            middle,
        };
        let scale = LossScale { blur: 2.0 * BIN, alpha: 0.5, weighed: true };
        let settings = SheetSettings { cutter: Some(Cutter::ball(0.5)), ..SheetSettings::default() };
        let mut objective = Objective::new(lattice, Slope::FLAT, target, scale, &settings);
        let wave = |k: usize, m: f64| (TAU * m * k as f64 / NODES as f64).sin();
        let height = |k: usize| {
            let (x, y) = (k % NODES, k / NODES);
            (0.1 * (wave(x, 1.0) + wave(y, 1.0)) + 0.03 * wave(x, 3.0) * wave(y, 4.0)) as f32
        };
        let heights: Vec<f32> = (0..NODES * NODES).map(height).collect();
        objective.set_penalties(&heights, 0.3);
        let unknowns = objective.unknowns(&heights);
        Self { objective, unknowns, gradient: vec![0.0; NODES * NODES] }
    }

    /// The loss; its gradient stays.
    fn evaluate(&mut self) -> f64 {
        // Nobody cancels it.
        self.objective.loss(&self.unknowns, &mut self.gradient, &Progress::silent()).unwrap_or(f64::NAN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // How fast it is and how much it varies hangs on what else the machine does: `cargo bench --bench design` shows both.
    #[test]
    fn a_machine_has_a_speed_and_the_kernel_does_the_same_work_each_time() {
        let speed = relative_speed();
        assert!(speed.is_finite() && speed > 0.0, "{speed}");
        let mut kernel = Kernel::new();
        let first = (kernel.evaluate(), kernel.gradient.clone());
        let again = (kernel.evaluate(), kernel.gradient.clone());
        assert_eq!(first, again);
        assert!(first.0 > 0.0 && first.1.iter().any(|slope| *slope != 0.0), "it is at no minimum");
    }
}
