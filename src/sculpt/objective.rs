//! How far a relief's light is from the wanted, as a function of well-conditioned numbers, with its exact gradient.
//!
//! ```text
//!    y ──► heights ──► closing ──► polish ──► light ──► weighed, blurred difference ──► ½ Σ d · (W ∗ d)
//!       1/|k|       (the ball)   (polish, paint) (triangles)
//! ```
//!
//! A wave of heights of frequency k changes slopes k times as much: dividing by |k| makes all waves of y alike. The
//! gain W = exp(-k²σ²)/(k² + k0²)^α over the slope plane sees the difference through a blur σ, and wide differences
//! better than narrow ones: at α = 1 it is nearly a transport distance, at α = 0 a sum of squares.

use std::f64::consts::{PI, TAU};

use crate::cutter::Cutter;
use crate::fourier::{even_smooth_size, frequency};
use crate::progress::Progress;
use crate::relief::periodic::PeriodicRelief;
use crate::slope::Slope;

use super::closing::{Closing, Contacts};
use super::concave_edges::ConcaveEdges;
use super::edge_slopes::{EdgeSlopes, Lattice};
use super::light_model::LightModel;
use super::periodic_filter::PeriodicFilter;
use super::slope_histogram::SlopeHistogram;
use super::target::SlopeTarget;
use super::tool::{Tool, polished};

/// Longest difference that the loss feels, degrees.
const REACH: f64 = 40.0;

/// Dark degrees beyond the target's own, so that light at one rim hardly feels the opposite one.
const ROOM: f64 = 6.0;

/// Differences in the dark count more, as they do to the eye: by 1 over the brightness there, as a share of the peak,
/// plus this.
const DARK: f64 = 0.3;

/// How a stage of the design looks at light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LossScale {
    /// Blur, degrees.
    pub blur: f64,
    /// Preference for wide differences.
    pub alpha: f64,
    /// Whether differences in the dark count more.
    pub weighed: bool,
}

impl LossScale {
    /// Whether it sees what the tool's grid does to light: to wider looks it is not worth the work.
    pub const fn is_fine(self) -> bool {
        self.blur < 0.4
    }
}

/// What happens to the written relief before light falls on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManufacturingModel {
    /// The cutter.
    pub cutter: Option<Cutter>,
    /// Polish or paint: heights are smoothed by a Gaussian of this standard deviation, mm.
    pub polish: f64,
    /// Waves shorter than about this are damped in the design, mm.
    pub finest: f64,
    /// The most that a cell may rise, mm.
    pub max_depth: Option<f64>,
    /// Mean slope of the plate.
    pub tilt: Slope,
}

/// The loss of reliefs on one lattice.
pub struct Objective {
    lattice: Lattice,
    manufacturing: ManufacturingModel,
    target: SlopeTarget,
    light: LightModel,
    closing: Option<Closing>,
    heights: PeriodicFilter,
    conditioner: Vec<f32>,
    polish: Option<Vec<f32>>,
    plane: PeriodicFilter,
    scale: Vec<f32>,
    dark_weight: Option<Vec<f32>>,
    /// What the tool is known to add to the light, beyond the fillets of the concave edges.
    tool_residual: Option<Vec<f32>>,
    valley_weight: f64,
    /// Heights between which nothing is charged for depth, mm, and the charge for a mean square of one beyond.
    depth: Option<([f32; 2], f64)>,
}

impl Objective {
    /// For reliefs on `lattice` whose light shall be `target`, seen as `scale` says and made as `manufacturing` says.
    pub fn new(lattice: Lattice, target: SlopeTarget, scale: LossScale, manufacturing: ManufacturingModel) -> Self {
        let heights = PeriodicFilter::new(lattice.n);
        let conditioner = heights.gains(|i, j| conditioner(lattice, i, j, manufacturing.finest));
        let polish = (manufacturing.polish > 0.0).then(|| heights.gaussian(lattice, manufacturing.polish));
        let plane = PeriodicFilter::new(even_smooth_size(target.side + (ROOM / target.bin).ceil() as usize));
        let gains = loss_gains(&plane, target.bin, scale);
        let dark_weight = scale.weighed.then(|| weight(&plane, &target));
        let concave =
            manufacturing.cutter.map(|cutter| ConcaveEdges::new(lattice, cutter, sharpest_fold(lattice, cutter)));
        let crossed = manufacturing.cutter.filter(|_| scale.is_fine()).map_or(0.0, |cutter| crossed(lattice, cutter));
        let light = LightModel::new(lattice, SlopeHistogram::new(&target), crossed, concave);
        let closing = manufacturing.cutter.map(|cutter| Closing::new(lattice, cutter));
        Self {
            lattice,
            manufacturing,
            target,
            light,
            closing,
            heights,
            conditioner,
            polish,
            plane,
            scale: gains,
            dark_weight,
            tool_residual: None,
            valley_weight: 0.0,
            depth: None,
        }
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

    /// Charges for concave edges that turn upward, so that they cost `share` of the loss of heights `z` as it is now; and for
    /// what is too deep, so that it costs as much as the loss where it is so by 3 % on average.
    pub fn charge(&mut self, z: &[f32], share: f64) {
        let edges = self.edges(z);
        let (loss, penalty) = (self.compare(&edges).0, self.light.penalty(&edges));
        self.valley_weight = if penalty > 0.0 { share * loss / penalty } else { 0.0 };
        self.depth = self.manufacturing.max_depth.map(|most| {
            let (low, high) = range(z);
            let middle = 0.5 * f64::from(low + high);
            let bounds = [-0.48, 0.48].map(|share| (middle + share * most) as f32);
            (bounds, loss / ((0.03 * most).powi(2) * z.len() as f64))
        });
    }

    /// How much deeper than allowed heights `z` are, as a share of what is allowed.
    pub fn too_deep(&self, z: &[f32]) -> f64 {
        let (low, high) = range(z);
        self.manufacturing.max_depth.map_or(0.0, |most| (f64::from(high - low) / most - 1.0).max(0.0))
    }

    /// Takes account of what the tool really makes of heights `z`: the light of its work less that of the model is
    /// added to all light from now on.
    pub fn update_tool_residual(&mut self, z: &[f32], progress: &Progress) {
        let Some(cutter) = self.manufacturing.cutter else { return };
        let cell = self.lattice.cell();
        let relief = relief(self.lattice, z, self.manufacturing.tilt);
        let made = polished(Tool::new(cell, cutter).mill(&relief, progress).relief, self.manufacturing.polish);
        let fine = Lattice { n: made.nodes, step: made.step() };
        // Whoever looks at the tool's grid may cut its squares either way.
        let really = LightModel::new(fine, SlopeHistogram::new(&self.target), 0.5, None)
            .forward(&EdgeSlopes::new(fine, &made.heights));
        let thought = self.light.forward(&self.edges(z));
        self.tool_residual = Some(really.iter().zip(&thought).map(|(a, b)| a - b).collect());
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

    /// Slopes of heights `z` after polish.
    fn edges(&self, z: &[f32]) -> EdgeSlopes {
        match &self.polish {
            None => EdgeSlopes::new(self.lattice, z),
            Some(gains) => {
                let mut level = z.to_vec();
                self.heights.filter(&mut level, self.lattice.n, gains);
                EdgeSlopes::new(self.lattice, &level)
            }
        }
    }

    /// The loss at `y`; its gradient goes to `gradient`.
    pub fn loss(&self, y: &[f32], gradient: &mut [f32]) -> f64 {
        let (z, contacts) = self.closed(y);
        let edges = self.edges(&z);
        let (loss, potential) = self.compare(&edges);
        let (mut at_heights, penalty) = self.light.adjoint(&edges, &potential, self.valley_weight as f32);
        if let Some(gains) = &self.polish {
            self.heights.filter(&mut at_heights, self.lattice.n, gains);
        }
        let mut depth = 0.0;
        if let Some(([low, high], weight)) = self.depth {
            for (slope, z) in at_heights.iter_mut().zip(&z) {
                let beyond = z - z.clamp(low, high);
                depth += weight * f64::from(beyond).powi(2);
                *slope += 2.0 * weight as f32 * beyond;
            }
        }
        if let Some(contacts) = contacts {
            contacts.adjoint(&mut at_heights);
        }
        self.heights.filter(&mut at_heights, self.lattice.n, &self.conditioner);
        gradient.copy_from_slice(&at_heights);
        loss + self.valley_weight * penalty + depth
    }

    /// The loss without penalties, and the potential that pulls on light.
    fn compare(&self, edges: &EdgeSlopes) -> (f64, Vec<f32>) {
        let weigh = |values: &mut [f32]| {
            if let Some(weight) = &self.dark_weight {
                values.iter_mut().zip(weight).for_each(|(v, w)| *v *= w);
            }
        };
        let mut difference = self.difference(edges);
        weigh(&mut difference);
        let mut potential = difference.clone();
        self.plane.filter(&mut potential, self.target.side, &self.scale);
        let products = potential.iter().zip(&difference).map(|(p, d)| f64::from(*p) * f64::from(*d));
        let loss = 0.5 * products.sum::<f64>();
        weigh(&mut potential);
        (loss, potential)
    }

    /// Light less what is wanted.
    fn difference(&self, edges: &EdgeSlopes) -> Vec<f32> {
        let mut difference = self.light.forward(edges);
        difference.iter_mut().zip(&self.target.wanted).for_each(|(d, w)| *d -= w);
        if let Some(tool_residual) = &self.tool_residual {
            difference.iter_mut().zip(tool_residual).for_each(|(d, w)| *d += w);
        }
        difference
    }

    /// Half the sum of absolute differences of light, both seen through a blur of `blur` degrees.
    pub fn misplaced(&self, z: &[f32], blur: f64) -> f64 {
        let mut difference = self.difference(&self.edges(z));
        self.plane.filter(&mut difference, self.target.side, &blurring(&self.plane, self.target.bin, blur));
        0.5 * difference.iter().map(|d| f64::from(d.abs())).sum::<f64>()
    }

    /// About the share of the plate that the cutter fills with fillets.
    pub fn fillets(&self, z: &[f32]) -> f64 {
        self.light.penalty(&self.edges(z))
    }
}

/// One cell of heights `z` about a mean slope.
pub fn relief(lattice: Lattice, z: &[f32], tilt: Slope) -> PeriodicRelief {
    PeriodicRelief { nodes: lattice.n, heights: z.to_vec(), cell: lattice.cell(), cells: [1, 1], tilt }
}

/// Lowest and highest of `z`.
fn range(z: &[f32]) -> (f32, f32) {
    z.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |r, v| (r.0.min(*v), r.1.max(*v)))
}

/// How far the cutter may stay above a written valley, mm.
pub const CLEARANCE: f64 = 0.45e-3;

/// The sharpest edge in which a ball of `radius` mm comes as near as [`CLEARANCE`], R Δs²/8 above its bottom; or that of
/// a hollow as round as the ball.
fn sharpest_fold(lattice: Lattice, cutter: Cutter) -> f64 {
    let radius = cutter.valley_radius();
    let alone = (8.0 * CLEARANCE / radius).sqrt();
    0.7 * alone.min(lattice.step.min_element() / radius)
}

/// Share of the light that a tool's grid sends as if squares were cut the other way: half of that of the tool's squares
/// which a diagonal crosses.
fn crossed(lattice: Lattice, cutter: Cutter) -> f64 {
    let cell = lattice.cell();
    let across = cell.max_element() / Tool::new(cell, cutter).places as f64;
    (0.5 * across / lattice.step.max_element()).min(0.5)
}

/// 1/|k| of the differences that make slopes, 0 for the mean; below `finest` mm falling off as a Gaussian.
fn conditioner(lattice: Lattice, i: usize, j: usize, finest: f64) -> f64 {
    let Lattice { n, step } = lattice;
    let along = |k: usize, h: f64| 2.0 / h * (PI * k as f64 / n as f64).sin();
    let slope = along(i, step.x).hypot(along(j, step.y));
    if slope == 0.0 {
        return 0.0;
    }
    // A quarter of the slope is left of a wave as long as `finest`.
    (-4f64.ln() * (lattice.wave(i, j) * finest / TAU).powi(2)).exp() / slope
}

fn loss_gains(plane: &PeriodicFilter, bin: f64, scale: LossScale) -> Vec<f32> {
    let side = plane.side();
    plane.gains(|i, j| {
        let k2 = (frequency(i, side).powi(2) + frequency(j, side).powi(2)) / (bin * bin);
        (-k2 * scale.blur * scale.blur).exp() / (k2 + (TAU / REACH).powi(2)).powf(scale.alpha)
    })
}

/// Gains of a Gaussian of standard deviation `blur` degrees over light.
fn blurring(plane: &PeriodicFilter, bin: f64, blur: f64) -> Vec<f32> {
    // The square root of the gain of a loss without preference.
    loss_gains(plane, bin, LossScale { blur: blur / 2f64.sqrt(), alpha: 0.0, weighed: false })
}

/// 1 at the peak of the target, seen through half a degree, and more where it is darker.
fn weight(plane: &PeriodicFilter, target: &SlopeTarget) -> Vec<f32> {
    let mut seen = target.wanted.clone();
    plane.filter(&mut seen, target.side, &blurring(plane, target.bin, 0.5));
    let peak = f64::from(seen.iter().fold(f32::MIN_POSITIVE, |m, v| m.max(*v)));
    seen.iter().map(|v| ((1.0 + DARK) / (f64::from(v.max(0.0)) / peak + DARK)) as f32).collect()
}
