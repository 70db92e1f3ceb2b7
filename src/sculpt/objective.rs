//! How far a relief's light is from the wanted, as a function of well-conditioned numbers, with its exact gradient.
//!
//! ```text
//!    y ──► heights ──► closing ──► light ──► blurred difference ──► ½ Σ d · (W ∗ d)
//!       1/|k|       (the ball)  (triangles)
//! ```
//!
//! A wave of heights of frequency k changes slopes k times as much: dividing by |k| makes all waves of y alike. The
//! gain W = exp(-k²σ²)/(k² + k0²)^α over the slope plane sees the difference through a blur σ, and wide differences
//! better than narrow ones: at α = 1 it is nearly a transport distance, at α = 0 a sum of squares.

use std::f64::consts::{PI, TAU};

use crate::fourier::frequency;

use super::bins::Bins;
use super::closing::{Closing, Contacts};
use super::light::{Lattice, Light};
use super::target::SlopeTarget;
use super::waves::{Waves, smooth_side};

/// Longest difference that the loss feels, degrees.
const REACH: f64 = 40.0;

/// How a stage of the design looks at light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaze {
    /// Blur, degrees.
    pub blur: f64,
    /// Preference for wide differences.
    pub alpha: f64,
}

/// The tool of a design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Radius of the ball that the heights are closed by, mm: that of the cutter or a little more.
    pub closing: f64,
    /// Radius of the cutter, mm, which rounds the valleys between the triangles.
    pub cutter: f64,
    /// Width over which every edge is taken to be rounded, mm.
    pub rounding: f64,
}

/// The loss of reliefs on one lattice.
pub struct Objective {
    lattice: Lattice,
    target: SlopeTarget,
    light: Light,
    closing: Option<Closing>,
    heights: Waves,
    conditioner: Vec<f32>,
    plane: Waves,
    gaze: Vec<f32>,
    price: f64,
}

impl Objective {
    /// For reliefs on `lattice` whose light shall be `target`, seen as `gaze` says, cut with `ball` or taken as they
    /// are; waves shorter than about `finest` mm are damped.
    pub fn new(lattice: Lattice, target: SlopeTarget, gaze: Gaze, ball: Option<Ball>, finest: f64) -> Self {
        let heights = Waves::new(lattice.n);
        let conditioner = heights.gains(|i, j| conditioner(lattice, i, j, finest));
        // A third more room than the target, so that light at one rim hardly feels the opposite one.
        let plane = Waves::new(smooth_side(target.side * 4 / 3));
        let gaze = gaze_gains(&plane, &target, gaze);
        let light = Light::new(lattice, Bins::new(&target), ball.map(|b| b.cutter), ball.map_or(0.0, |b| b.rounding));
        let closing = ball.map(|b| Closing::new(lattice.n, lattice.step, b.closing));
        Self { lattice, target, light, closing, heights, conditioner, plane, gaze, price: 0.0 }
    }

    /// The numbers y whose heights are `z`, as far as waves are not damped.
    pub fn numbers(&self, z: &[f32]) -> Vec<f32> {
        let lattice = self.lattice;
        let inverse = self.heights.gains(|i, j| {
            let gain = conditioner(lattice, i, j, 0.0);
            if gain > 0.0 { 1.0 / gain } else { 0.0 }
        });
        let mut y = z.to_vec();
        self.heights.filter(&mut y, lattice.n, &inverse);
        y
    }

    /// Charges for the light of fillets, so that they cost `share` of the loss of heights `z` as it is now.
    pub fn charge_fillets(&mut self, z: &[f32], share: f64) {
        let fillets = self.light.fillets(z);
        self.price = if fillets > 0.0 { share * self.compare(z).0 / fillets } else { 0.0 };
    }

    /// The heights of numbers `y`, as the cutter leaves their nodes.
    pub fn relief(&self, y: &[f32]) -> Vec<f32> {
        self.closed(y).0
    }

    fn closed(&self, y: &[f32]) -> (Vec<f32>, Option<Contacts>) {
        let mut z = y.to_vec();
        self.heights.filter(&mut z, self.lattice.n, &self.conditioner);
        let contacts = self.closing.as_ref().map(|closing| closing.close(&mut z));
        (z, contacts)
    }

    /// The loss at `y`; its gradient goes to `gradient`.
    pub fn loss(&self, y: &[f32], gradient: &mut [f32]) -> f64 {
        let (z, contacts) = self.closed(y);
        let (loss, potential) = self.compare(&z);
        let loss = if self.price > 0.0 { loss + self.price * self.light.fillets(&z) } else { loss };
        let mut pull = self.light.pull(&z, &potential, self.price as f32);
        if let Some(contacts) = contacts {
            contacts.pull_back(&mut pull);
        }
        self.heights.filter(&mut pull, self.lattice.n, &self.conditioner);
        gradient.copy_from_slice(&pull);
        loss
    }

    /// The loss of heights `z` as they are, and the potential that pulls on their light.
    pub fn compare(&self, z: &[f32]) -> (f64, Vec<f32>) {
        let mut difference = self.light.shine(z);
        difference.iter_mut().zip(&self.target.wanted).for_each(|(d, w)| *d -= w);
        let mut potential = difference.clone();
        self.plane.filter(&mut potential, self.target.side, &self.gaze);
        let products = potential.iter().zip(&difference).map(|(p, d)| f64::from(*p) * f64::from(*d));
        (0.5 * products.sum::<f64>(), potential)
    }

    /// Share of the light that comes from fillets in the valleys.
    pub fn fillets(&self, z: &[f32]) -> f64 {
        self.light.fillets(z)
    }

    /// Half the sum of absolute differences of light, both seen through a blur of `blur` degrees.
    pub fn misplaced(&self, z: &[f32], blur: f64) -> f64 {
        let mut difference = self.light.shine(z);
        difference.iter_mut().zip(&self.target.wanted).for_each(|(d, w)| *d -= w);
        // The square root of the gain of a loss without preference.
        let gains = gaze_gains(&self.plane, &self.target, Gaze { blur: blur / 2f64.sqrt(), alpha: 0.0 });
        self.plane.filter(&mut difference, self.target.side, &gains);
        0.5 * difference.iter().map(|d| f64::from(d.abs())).sum::<f64>()
    }
}

/// 1/|k| of the differences that make slopes, 0 for the mean; below `finest` mm falling off as a Gaussian.
fn conditioner(lattice: Lattice, i: usize, j: usize, finest: f64) -> f64 {
    let Lattice { n, step } = lattice;
    let along = |k: usize, h: f64| 2.0 / h * (PI * k as f64 / n as f64).sin();
    let slope = along(i, step.x).hypot(along(j, step.y));
    if slope == 0.0 {
        return 0.0;
    }
    let wave = (frequency(i, n) / step.x).hypot(frequency(j, n) / step.y);
    // Half of the slope is left of a wave as long as `finest`.
    (-2f64.ln() * (wave * finest / TAU).powi(2)).exp() / slope
}

fn gaze_gains(plane: &Waves, target: &SlopeTarget, gaze: Gaze) -> Vec<f32> {
    let side = smooth_side(target.side * 4 / 3);
    plane.gains(|i, j| {
        let k2 = (frequency(i, side).powi(2) + frequency(j, side).powi(2)) / (target.bin * target.bin);
        (-k2 * gaze.blur * gaze.blur).exp() / (k2 + (TAU / REACH).powi(2)).powf(gaze.alpha)
    })
}
