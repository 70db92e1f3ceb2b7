//! The loss of a whole plate's heights, with its gradient: as the far design's ([`objective`](crate::sculpt::objective)),
//! over bins of the picture on the wall.
//!
//! The unknowns are changes of the relief that the descent starts from, every wave divided by its frequency. Waves are
//! those of the square lattice that holds the plate; of their sum what lies on the plate is taken, so that rims are free.

use crate::cutter::Cutter;
use crate::near::NearField;
use crate::progress::{Cancelled, Progress};
use crate::relief::open::OpenRelief;
use crate::sculpt::closing::{Closing, Contacts};
use crate::sculpt::concave_edges::ConcaveEdges;
use crate::sculpt::depth_limit::DepthLimit;
use crate::sculpt::edge_slopes::EdgeSlopes;
use crate::sculpt::objective::{conditioner, sharpest_jump};
use crate::sculpt::periodic_filter::PeriodicFilter;
use crate::sculpt::settings::SheetSettings;
use crate::sculpt::slope_loss::{LossScale, SlopeLoss};
use crate::sculpt::target::SlopeTarget;

use super::fillets::Fillets;
use super::landing::Landing;
use super::light::PlateLight;
use super::milling::{milled, usual_tool};
use super::plate_grid::PlateGrid;

/// The loss of plates on one grid, at one scale.
pub struct PlateObjective {
    grid: PlateGrid,
    settings: SheetSettings,
    /// Heights of the lattice that are started from.
    start: Vec<f32>,
    /// Heights of the base, from which depth counts.
    base: Option<Vec<f32>>,
    wanted: Vec<f32>,
    landing: Landing,
    loss: SlopeLoss,
    light: PlateLight,
    /// The light that the plate takes in all, by which its light is divided.
    taken: f32,
    closing: Option<Closing>,
    filter: PeriodicFilter,
    conditioner: Vec<f32>,
    /// Gains of the polish, and over each node of the plate how much of the Gaussian lies on the plate.
    polish: Option<(Vec<f32>, Vec<f32>)>,
    tool_residual: Option<Vec<f32>>,
    valley_weight: f64,
    depth_limit: Option<DepthLimit>,
}

impl PlateObjective {
    /// For changes of `start`, whose light shall be `target`, compared as `scale` says and made as `settings` say.
    pub fn new(
        start: &OpenRelief,
        near: &NearField,
        (target, landing): (SlopeTarget, Landing),
        scale: LossScale,
        settings: &SheetSettings,
    ) -> Self {
        let cutter = settings.cutter;
        let grid = PlateGrid::of(start, cutter);
        let lattice = grid.lattice;
        let filter = PeriodicFilter::new(lattice.n);
        let finest = settings.min_feature.unwrap_or(0.0);
        let gains = filter.gains(|i, j| conditioner(lattice, i, j, finest));
        let squares = grid.squares[0] * grid.squares[1];
        let fillets = cutter.map(|cutter| Fillets {
            edges: ConcaveEdges::new(lattice, cutter, sharpest_jump(lattice, cutter)).over(lattice, squares),
            squares: grid.squares,
        });
        let lower = cutter.filter(|_| scale.is_fine()).map_or(0.0, |cutter| lower_diagonals(&grid, cutter));
        let polish = settings.polish.map(|sigma| {
            let gains = filter.gaussian(lattice, sigma);
            let mut within = vec![1.0; lattice.n * lattice.n];
            grid.clear_around(&mut within, 0.0);
            filter.filter(&mut within, lattice.n, &gains);
            (gains, within)
        });
        let base = settings.max_depth.map(|_| {
            let base = OpenRelief::from_fn(start.nodes, start.step, |at| near.base(at));
            grid.embedded(&base)
        });
        let mut objective = Self {
            grid,
            settings: *settings,
            start: grid.embedded(start),
            base,
            loss: SlopeLoss::new(&target, scale),
            wanted: target.wanted,
            landing,
            light: PlateLight::new(grid, landing, lower, fillets),
            taken: 1.0,
            closing: cutter.map(|cutter| Closing::new(lattice, cutter)),
            filter,
            conditioner: gains,
            polish,
            tool_residual: None,
            valley_weight: 0.0,
            depth_limit: None,
        };
        let z = objective.start.clone();
        objective.taken = objective.light.forward(&z, &objective.edges(&z)).iter().sum();
        objective
    }

    /// How many unknowns there are.
    pub fn unknowns(&self) -> usize {
        self.grid.lattice.n * self.grid.lattice.n
    }

    /// Sets the weights of the penalties at the start: that on concave edges shall be `valley_share` of the loss.
    pub fn set_penalties(&mut self, valley_share: f64) {
        let z = self.start.clone();
        let edges = self.edges(&z);
        let (loss, penalty) = (self.loss.compare(self.difference(&z, &edges)).0, self.light.penalty(&edges));
        self.valley_weight = if penalty > 0.0 { valley_share * loss / penalty } else { 0.0 };
        self.depth_limit = self.settings.max_depth.map(|most| DepthLimit::new(&self.above_base(&z), most, loss));
    }

    /// Heights above the base on the plate; in the middle of their range around it.
    fn above_base(&self, z: &[f32]) -> Vec<f32> {
        let Some(base) = &self.base else { return Vec::new() };
        let mut above: Vec<f32> = z.iter().zip(base).map(|(z, base)| z - base).collect();
        self.grid.clear_around(&mut above, 0.0);
        above
    }

    /// Mills the relief of `y` on the tool's grid: from now on, the light of that surface less the light of the model is
    /// added to the light of any relief.
    pub fn update_tool_residual(&mut self, y: &[f32], progress: &Progress) -> Result<(), Cancelled> {
        let Some(cutter) = self.settings.cutter else { return Ok(()) };
        let z = self.closed(y).0;
        let tool = usual_tool(&self.grid, cutter);
        let milled = milled(&self.grid, &z, &tool, progress)?;
        let heights = match &self.polish {
            None => milled.heights,
            Some(_) => self.polished_finely(&milled.grid, milled.heights),
        };
        let light = PlateLight::new(milled.grid, self.landing, 0.5, None);
        let milled = light.forward(&heights, &EdgeSlopes::new(milled.grid.lattice, &heights));
        progress.check()?;
        let modelled = self.light.forward(&z, &self.edges(&z));
        let scaled = self.taken / milled.iter().sum::<f32>().max(f32::MIN_POSITIVE);
        self.tool_residual = Some(milled.iter().zip(&modelled).map(|(a, b)| (a * scaled - b) / self.taken).collect());
        Ok(())
    }

    /// Heights of a finer lattice after the polish.
    fn polished_finely(&self, fine: &PlateGrid, heights: Vec<f32>) -> Vec<f32> {
        let Some(sigma) = self.settings.polish else { return heights };
        polished(fine, heights, sigma)
    }

    /// The relief of unknowns `y`, closed.
    pub fn relief(&self, y: &[f32]) -> OpenRelief {
        self.grid.plate(&self.closed(y).0)
    }

    fn closed(&self, y: &[f32]) -> (Vec<f32>, Option<Contacts>) {
        let mut z = y.to_vec();
        self.filter.filter(&mut z, self.grid.lattice.n, &self.conditioner);
        self.grid.clear_around(&mut z, 0.0);
        z.iter_mut().zip(&self.start).for_each(|(z, start)| *z += start);
        let contacts = self.closing.as_ref().map(|closing| closing.close(&mut z));
        (z, contacts)
    }

    /// Slopes of heights `z` after polish.
    fn edges(&self, z: &[f32]) -> EdgeSlopes {
        let lattice = self.grid.lattice;
        match &self.polish {
            None => EdgeSlopes::new(lattice, z),
            Some((gains, within)) => {
                let mut smooth = z.to_vec();
                self.grid.clear_around(&mut smooth, 0.0);
                self.filter.filter(&mut smooth, lattice.n, gains);
                smooth.iter_mut().zip(within).for_each(|(z, part)| *z /= part.max(0.1));
                EdgeSlopes::new(lattice, &smooth)
            }
        }
    }

    /// The loss at `y`; its gradient goes to `gradient`.
    pub fn loss(&self, y: &[f32], gradient: &mut [f32]) -> f64 {
        let n = self.grid.lattice.n;
        let (z, contacts) = self.closed(y);
        let edges = self.edges(&z);
        let (loss, mut potential) = self.loss.compare(self.difference(&z, &edges));
        potential.iter_mut().for_each(|v| *v /= self.taken);
        let (mut at_heights, penalty) = self.light.adjoint(&z, &edges, &potential, self.valley_weight as f32);
        if let Some((gains, within)) = &self.polish {
            at_heights.iter_mut().zip(within).for_each(|(g, part)| *g /= part.max(0.1));
            self.filter.filter(&mut at_heights, n, gains);
        }
        let depth = self.depth_limit.map_or(0.0, |limit| limit.penalty(&self.above_base(&z), &mut at_heights));
        self.grid.clear_around(&mut at_heights, 0.0);
        if let Some(contacts) = contacts {
            contacts.adjoint(&mut at_heights);
            self.grid.clear_around(&mut at_heights, 0.0);
        }
        self.filter.filter(&mut at_heights, n, &self.conditioner);
        self.grid.clear_around(&mut at_heights, 0.0);
        gradient.copy_from_slice(&at_heights);
        loss + self.valley_weight * penalty + depth
    }

    /// Light less what is wanted.
    fn difference(&self, z: &[f32], edges: &EdgeSlopes) -> Vec<f32> {
        let mut difference = self.light.forward(z, edges);
        difference.iter_mut().zip(&self.wanted).for_each(|(d, w)| *d = *d / self.taken - w);
        if let Some(tool_residual) = &self.tool_residual {
            difference.iter_mut().zip(tool_residual).for_each(|(d, w)| *d += w);
        }
        difference
    }

    /// Total variation between the light of the relief of `y` and the wanted light, both blurred by `blur` degrees.
    pub fn misplaced(&self, y: &[f32], blur: f64) -> f64 {
        let z = self.closed(y).0;
        self.loss.total_variation(self.difference(&z, &self.edges(&z)), blur)
    }

    /// About the share of the plate that the cutter fills with fillets.
    pub fn fillets(&self, y: &[f32]) -> f64 {
        self.light.penalty(&self.edges(&self.closed(y).0))
    }
}

/// Heights of the lattice of `grid` after a polish of standard deviation `sigma` mm, what is around the plate left out.
pub fn polished(grid: &PlateGrid, mut heights: Vec<f32>, sigma: f64) -> Vec<f32> {
    let n = grid.lattice.n;
    let even = n + n % 2;
    let filter = PeriodicFilter::new(even);
    let gains = filter.gaussian(grid.lattice, sigma);
    let mut within = vec![1.0; n * n];
    grid.clear_around(&mut within, 0.0);
    grid.clear_around(&mut heights, 0.0);
    filter.filter(&mut within, n, &gains);
    filter.filter(&mut heights, n, &gains);
    heights.iter_mut().zip(&within).for_each(|(z, part)| *z /= part.max(0.1));
    heights
}

/// Share of the light that goes as if squares were cut along their lower diagonals: see the far design's objective.
fn lower_diagonals(grid: &PlateGrid, cutter: Cutter) -> f64 {
    let between_places = grid.lattice.cell().max_element() / usual_tool(grid, cutter).places as f64;
    (0.5 * between_places / grid.lattice.step.max_element()).min(0.5)
}
