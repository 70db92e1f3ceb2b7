//! A design for a lamp and a wall nearby: how far it follows them, and what comes of it.

use glam::DVec2;

use crate::distribution::SlopeDistribution;
use crate::facets::SlopeGrid;
use crate::near::{NearField, Warping};
use crate::progress::{Cancelled, Progress};
use crate::recipe::{NearMethod, Recipe};
use crate::relief::open::OpenRelief;
use crate::sculpt::room::exact::exact;
use crate::sculpt::room::placed::placed;
use crate::sculpt::stages::Sheet;
use crate::setup::Setup;
use crate::slope::Slope;

/// A far design follows lamp and wall well enough where its light misses by less, degrees, root mean square: a tenth of the
/// blur at which highlights are compared.
pub const GOOD_ENOUGH: f64 = 0.05;

/// How a design follows lamp and wall.
#[derive(Clone, Debug)]
pub struct NearDesign {
    /// The base, the warp and the scene.
    pub field: NearField,
    /// How far it goes.
    pub method: NearMethod,
    /// Why, in a sentence.
    pub why: String,
    /// By how many degrees a far design's light misses, root mean square: as it is, on the base, and warped on it.
    pub miss: [f64; 3],
    /// The sheet over the whole plate, if the relief is one.
    pub sheet: Option<NearSheet>,
}

/// A sheet over the whole plate.
#[derive(Clone, Debug)]
pub struct NearSheet {
    /// The relief, triangle for triangle as it is written.
    pub relief: OpenRelief,
    /// Total variation between its light as modelled and the wanted light at a blur of 0.5°, before the descent over the
    /// whole plate and after each of its stages.
    pub misplaced: Vec<f64>,
    /// About the share of the plate that the cutter fills with fillets.
    pub fillets: f64,
}

impl NearDesign {
    /// How `recipe` is to follow its scene; `None` of a far one, and of a picture that the plate does not see.
    pub fn new(recipe: &Recipe, distribution: &SlopeDistribution) -> Option<Self> {
        let scene = recipe.scene().ok().flatten()?;
        let field = NearField::new(&scene, recipe.plate.size.into(), distribution.mean)?;
        let miss = [None, Some(Warping::Base), Some(Warping::Warp)].map(|warping| field.miss(warping));
        let (method, why) = chosen(recipe, miss);
        Some(Self { field, method, why, miss, sheet: None })
    }

    /// `sheet` on the base, and as far as the method goes.
    pub fn finish(
        &mut self,
        recipe: &Recipe,
        flux: &SlopeDistribution,
        sheet: &Sheet,
        progress: &Progress,
    ) -> Result<(), Cancelled> {
        let warping = if self.method == NearMethod::Base { Warping::Base } else { Warping::Warp };
        let start = placed(&sheet.relief, &self.field, warping);
        let settings = &recipe.design.sheet;
        let descended = match self.method {
            NearMethod::Exact => exact(start.clone(), &self.field, &flux.flux, settings, progress)?,
            NearMethod::Base | NearMethod::Warp => None,
        };
        let finished = match descended {
            Some(exact) => NearSheet { relief: exact.relief, misplaced: exact.misplaced, fillets: exact.fillets },
            None => NearSheet { relief: start, misplaced: Vec::new(), fillets: sheet.fillets },
        };
        self.sheet = Some(NearSheet { relief: finished.relief.about_mean(), ..finished });
        Ok(())
    }

    /// Facets in their places, each turned so that its light goes from there to where the far design sends it: their
    /// slopes, and those less the base's.
    pub fn facets(&self, setup: &Setup, grid: &SlopeGrid, pitch: DVec2) -> [Vec<Slope>; 2] {
        let each = |k: usize| {
            let (slope, at) = (grid.slopes[k], facet_place(grid, k, pitch));
            let base = self.field.base_slope(at).unwrap_or(Slope::FLAT);
            let uv = setup.image_of_slope(slope);
            let exact = uv.and_then(|uv| self.field.scene().slope_for(self.field.place(at), uv)).unwrap_or(slope);
            [exact, Slope::from_vec(exact.to_vec() - base.to_vec())]
        };
        let both: Vec<[Slope; 2]> = (0..grid.slopes.len()).map(each).collect();
        [0, 1].map(|which| both.iter().map(|slopes| slopes[which]).collect())
    }

    /// Height of the base under each facet of `grid`, mm.
    pub fn facet_bases(&self, grid: &SlopeGrid, pitch: DVec2) -> Vec<f64> {
        (0..grid.slopes.len()).map(|k| self.field.base(facet_place(grid, k, pitch))).collect()
    }

    /// How much the sheet rises above its base, mm; of facets none.
    pub fn depth(&self) -> f64 {
        let Some(sheet) = &self.sheet else { return 0.0 };
        let relief = &sheet.relief;
        let middle = 0.5 * relief.step * DVec2::new((relief.nodes[0] - 1) as f64, (relief.nodes[1] - 1) as f64);
        let above = relief.heights.iter().enumerate().map(|(k, z)| {
            let at = DVec2::new((k % relief.nodes[0]) as f64, (k / relief.nodes[0]) as f64) * relief.step;
            f64::from(*z) - self.field.base(at - middle)
        });
        let (low, high) = above.fold((f64::INFINITY, f64::NEG_INFINITY), |r, z| (r.0.min(z), r.1.max(z)));
        high - low
    }
}

/// How a design of `recipe` follows its scene, as far as is known without a drawing: as for one whose mean slope lights the
/// picture's middle. `None` of a far one.
pub(super) fn likely_method(recipe: &Recipe) -> Option<NearMethod> {
    let scene = recipe.scene().ok().flatten()?;
    let mean = recipe.setup().slope_at(DVec2::ZERO)?;
    let field = NearField::new(&scene, recipe.plate.size.into(), mean)?;
    Some(chosen(recipe, [None, Some(Warping::Base), None].map(|warping| field.miss(warping))).0)
}

/// Middle of facet `k`, mm from the plate's middle.
fn facet_place(grid: &SlopeGrid, k: usize, pitch: DVec2) -> DVec2 {
    let from_middle = |k: usize, of: usize| k as f64 + 0.5 - 0.5 * of as f64;
    DVec2::new(from_middle(k % grid.columns, grid.columns), from_middle(k / grid.columns, grid.rows)) * pitch
}

/// The method, as asked or as is needed, and why. Warping by itself is never chosen: on the nodes of a grid it averages
/// triangles that were shaped one by one, which puts 4 % of a word's light in the wrong place at 256 nodes a cell, and more
/// on fewer.
fn chosen(recipe: &Recipe, [_, base, _]: [f64; 3]) -> (NearMethod, String) {
    match recipe.scene.near {
        _ if recipe.scene.focus.is_some() => (NearMethod::Base, "base: as --focus asks".into()),
        Some(NearMethod::Base) => (NearMethod::Base, "base: as --near asks".into()),
        Some(NearMethod::Warp) => (NearMethod::Warp, "warp: as --near asks".into()),
        Some(NearMethod::Exact) => (NearMethod::Exact, "exact: as --near asks".into()),
        None if base < GOOD_ENOUGH => {
            (NearMethod::Base, format!("base: its light misses by {base:.3}° rms, less than {GOOD_ENOUGH}°"))
        }
        None => {
            let why = format!("exact: light on the base alone misses by {base:.3}° rms, not less than {GOOD_ENOUGH}°");
            (NearMethod::Exact, why)
        }
    }
}
