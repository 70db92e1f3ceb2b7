//! The loss of a relief as a function of unknowns that are all alike to a descent, with its exact gradient.
//!
//! ```text
//!    y ──► heights ──► closing ──► polish ──► light ──► + tool residual - wanted ──► E, plus penalties
//!       1/|k|       (the cutter)  (Gaussian)  (triangles,                        (slope_loss)
//!                                              fillets)
//! ```
//!
//! The formula of the whole stands at the head of [`sculpt`](super). A wave of the heights with frequency k changes slopes
//! by |k| times its amplitude; the unknowns y are the heights with every wave multiplied by |k|, so that equal changes of y
//! change slopes equally. The gradient goes the same way back through the adjoint of each step.

use std::f64::consts::{PI, TAU};

use crate::cutter::Cutter;
use crate::progress::{Cancelled, Progress};
use crate::relief::periodic::PeriodicRelief;
use crate::slope::Slope;

use super::axis_histogram::AxisHistogram;
use super::closing::{Closing, Contacts};
use super::concave_edges::ConcaveEdges;
use super::depth_limit::{DepthLimit, excess_depth};
use super::edge_slopes::{EdgeSlopes, Lattice};
use super::light_model::LightModel;
use super::periodic_filter::PeriodicFilter;
use super::settings::SheetSettings;
use super::slope_loss::{LossScale, SlopeLoss};
use super::target::SlopeTarget;
use super::tool::{Tool, polished};

/// The loss of reliefs on one lattice, at one scale.
pub(crate) struct Objective {
    lattice: Lattice,
    settings: SheetSettings,
    /// Mean slope of the plate.
    tilt: Slope,
    target: SlopeTarget,
    loss: SlopeLoss,
    light: LightModel,
    closing: Option<Closing>,
    filter: PeriodicFilter,
    /// Gains from the unknowns to heights.
    conditioner: Vec<f32>,
    /// Gains of the polish.
    polish: Option<Vec<f32>>,
    /// The light of the relief as milled less that of the model, when last looked at.
    tool_residual: Option<Vec<f32>>,
    /// Weight of the penalty on concave edges.
    valley_weight: f64,
    depth_limit: Option<DepthLimit>,
}

impl Objective {
    /// For reliefs on `lattice` about the mean slope `tilt` whose light shall be `target`, compared as `scale` says and made
    /// as `settings` say.
    pub fn new(lattice: Lattice, tilt: Slope, target: SlopeTarget, scale: LossScale, settings: &SheetSettings) -> Self {
        let cutter = settings.cutter;
        let finest = settings.min_feature.unwrap_or(0.0);
        let filter = PeriodicFilter::new(lattice.n);
        let conditioner = filter.gains(|i, j| conditioner(lattice, i, j, finest));
        let polish = settings.polish.map(|sigma| filter.gaussian(lattice, sigma));
        let concave = cutter.map(|cutter| ConcaveEdges::new(lattice, cutter, sharpest_jump(lattice, cutter)));
        let lower = cutter.filter(|_| scale.is_fine()).map_or(0.0, |cutter| lower_diagonals(lattice, cutter));
        Self {
            lattice,
            settings: *settings,
            tilt,
            loss: SlopeLoss::new(&target, scale),
            light: LightModel::new(lattice, AxisHistogram::new(&target), lower, concave),
            target,
            closing: cutter.map(|cutter| Closing::new(lattice, cutter)),
            filter,
            conditioner,
            polish,
            tool_residual: None,
            valley_weight: 0.0,
            depth_limit: None,
        }
    }

    /// The unknowns y whose heights are `z`, mm; waves that the design damps are not damped here.
    pub fn unknowns(&self, z: &[f32]) -> Vec<f32> {
        let lattice = self.lattice;
        let inverse = self.filter.gains(|i, j| {
            let gain = conditioner(lattice, i, j, 0.0);
            if gain > 0.0 { 1.0 / gain } else { 0.0 }
        });
        let mut y = z.to_vec();
        self.filter.filter(&mut y, lattice.n, &inverse);
        y
    }

    /// Sets the weights of the penalties: that on concave edges shall be `valley_share` of the loss of heights `z`, and
    /// the depth limit is laid about their middle.
    pub(crate) fn set_penalties(&mut self, z: &[f32], valley_share: f64) {
        let edges = self.edges(z);
        let (loss, penalty) = (self.compare(&edges).0, self.light.penalty(&edges));
        self.valley_weight = if penalty > 0.0 { valley_share * loss / penalty } else { 0.0 };
        self.depth_limit = self.settings.max_depth.map(|most| DepthLimit::new(z, most, loss));
    }

    /// How much deeper than allowed heights `z` are, as a share of what is allowed.
    pub(crate) fn excess_depth(&self, z: &[f32]) -> f64 {
        self.settings.max_depth.map_or(0.0, |most| excess_depth(z, most))
    }

    /// Mills heights `z` on the tool's grid: from now on, the light of that surface less the light of the model is added
    /// to the light of any relief. Its gradient is that of the model alone.
    pub(crate) fn update_tool_residual(&mut self, z: &[f32], progress: &Progress) -> Result<(), Cancelled> {
        let Some(cutter) = self.settings.cutter else { return Ok(()) };
        let relief = relief(self.lattice, z, self.tilt);
        let milled = Tool::new(relief.cell, cutter).mill(&relief, progress)?.relief;
        let milled = polished(milled, self.settings.polish);
        let fine = Lattice::of(&milled);
        // Milled heights are known at the tool's places only, and a square of them may be cut along either diagonal.
        let light = LightModel::new(fine, AxisHistogram::new(&self.target), 0.5, None);
        let edges = EdgeSlopes::new(fine, &milled.heights);
        progress.check()?;
        let milled = light.forward(&edges);
        progress.check()?;
        let modelled = self.light.forward(&self.edges(z));
        self.tool_residual = Some(milled.iter().zip(&modelled).map(|(a, b)| a - b).collect());
        progress.check()
    }

    /// The heights, mm, of unknowns `y`, closed.
    pub fn relief(&self, y: &[f32]) -> Vec<f32> {
        self.closed(y).0
    }

    fn closed(&self, y: &[f32]) -> (Vec<f32>, Option<Contacts>) {
        let mut z = y.to_vec();
        self.filter.filter(&mut z, self.lattice.n, &self.conditioner);
        let contacts = self.closing.as_ref().map(|closing| closing.close(&mut z));
        (z, contacts)
    }

    /// Slopes of heights `z` after polish.
    fn edges(&self, z: &[f32]) -> EdgeSlopes {
        match &self.polish {
            None => EdgeSlopes::new(self.lattice, z),
            Some(gains) => {
                let mut polished = z.to_vec();
                self.filter.filter(&mut polished, self.lattice.n, gains);
                EdgeSlopes::new(self.lattice, &polished)
            }
        }
    }

    /// The loss at `y`; its gradient goes to `gradient`.
    pub fn loss(&self, y: &[f32], gradient: &mut [f32], progress: &Progress) -> Result<f64, Cancelled> {
        progress.check()?;
        let (z, contacts) = self.closed(y);
        progress.check()?;
        let edges = self.edges(&z);
        let (loss, potential) = self.compare(&edges);
        progress.check()?;
        let (mut at_heights, penalty) = self.light.adjoint(&edges, &potential, self.valley_weight as f32);
        progress.check()?;
        if let Some(gains) = &self.polish {
            self.filter.filter(&mut at_heights, self.lattice.n, gains);
        }
        let depth = self.depth_limit.map_or(0.0, |limit| limit.penalty(&z, &mut at_heights));
        if let Some(contacts) = contacts {
            contacts.adjoint(&mut at_heights);
        }
        self.filter.filter(&mut at_heights, self.lattice.n, &self.conditioner);
        gradient.copy_from_slice(&at_heights);
        Ok(loss + self.valley_weight * penalty + depth)
    }

    /// E, and its gradient with respect to the light.
    fn compare(&self, edges: &EdgeSlopes) -> (f64, Vec<f32>) {
        self.loss.compare(self.difference(edges))
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

    /// Total variation between the light of heights `z` and the wanted light, both blurred by `blur` degrees.
    pub fn misplaced(&self, z: &[f32], blur: f64) -> f64 {
        self.loss.total_variation(self.difference(&self.edges(z)), blur)
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

/// How far the machined surface may lie above a written valley, mm: just under the half micrometre that docs/relief.md
/// promises. The sharpest jump of slope that is wanted grows as its root.
pub(crate) const CLEARANCE: f64 = 0.45e-3;

/// The jump of slope at a concave edge from which on it costs more than its area.
///
/// A ball in an edge with a jump Δs that stands alone stays R Δs²/8 above its bottom, and in a hollow as round as itself
/// every edge jumps by the distance of nodes over R. The smaller of both is the sharpest that is wanted; the cost begins at
/// 0.7 of it, since a descent ends where cost and light balance, beyond the point at which the cost begins.
pub(super) fn sharpest_jump(lattice: Lattice, cutter: Cutter) -> f64 {
    let radius = cutter.valley_radius();
    let alone = (8.0 * CLEARANCE / radius).sqrt();
    0.7 * alone.min(lattice.step.min_element() / radius)
}

/// Share of the light that goes as if the relief's squares were cut along their lower diagonals.
///
/// The tool knows a relief at its places only. Of its squares those that a diagonal of the relief crosses, as many along a
/// diagonal as places lie along a step of the nodes, may be cut either way: half of them the wrong way.
fn lower_diagonals(lattice: Lattice, cutter: Cutter) -> f64 {
    let cell = lattice.cell();
    let between_places = cell.max_element() / Tool::new(cell, cutter).places as f64;
    (0.5 * between_places / lattice.step.max_element()).min(0.5)
}

/// 1/|k| of wave (i, j) as differences between neighbours see it, mm; 0 for the mean. Waves shorter than `finest` mm are
/// damped by a Gaussian.
pub(super) fn conditioner(lattice: Lattice, i: usize, j: usize, finest: f64) -> f64 {
    let Lattice { n, step } = lattice;
    let along = |k: usize, h: f64| 2.0 / h * (PI * k as f64 / n as f64).sin();
    let slope = along(i, step.x).hypot(along(j, step.y));
    if slope == 0.0 {
        return 0.0;
    }
    // A quarter of the slope is left of a wave as long as `finest`. With a half, more light stayed on
    // smaller mirrors; a quarter for 0.1 mm costs 0.0012 in total variation at 1° (docs/relief.md).
    (-4f64.ln() * (lattice.wave(i, j) * finest / TAU).powi(2)).exp() / slope
}

#[cfg(test)]
mod tests;
