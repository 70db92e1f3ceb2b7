//! A sheet beside the flat facets that the same recipe would make: which of the two puts more light right.

use super::design::{Design, DesignError, design};
use super::findings::{Proof, RimProof};
use super::proof::send_over_milled_facets;
use super::sentences::WORTH_TELLING;
use crate::progress::{Cancelled, Progress, Stage};
use crate::raster::Raster;
use crate::recipe::{Recipe, SurfaceKind};
use crate::trace::grid::GridSurface;
use crate::trace::traced_plate::Task;
use crate::verify::experiment::Measuring;
use crate::verify::measure::Mirrored;
use crate::verify::score::blurred_scores;
use crate::verify::verdict::MAIN_BLUR;

/// Rays over the facets at the most: the light of first bounces is known without.
const RAYS: u64 = 200_000;

/// Share of the misplaced light.
const CLEARLY: f64 = 0.1;

/// Light in the wrong place at a blur of [`MAIN_BLUR`], lost light counted, and likeness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Total variation.
    pub misplaced: f64,
    /// Structural similarity.
    pub ssim: f64,
}

/// A sheet and flat facets, both as milled if a cutter is named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetComparison {
    /// Facets along x and y.
    pub facets: [usize; 2],
    /// What they reach.
    pub flat: Score,
    /// What the relief reaches.
    pub continuous: Score,
    /// Whether both were judged as their cutter leaves them.
    pub milled: bool,
}

impl FacetComparison {
    /// Whether the facets misplace clearly less light: for less than a tenth nobody wants their steps, and rays
    /// have their noise.
    pub(crate) fn facets_are_better(&self) -> bool {
        self.flat.misplaced < (1.0 - CLEARLY) * self.continuous.misplaced
    }
}

/// Compares `plate`, which `recipe` made and `proof` judged, with the facets of the same recipe.
///
/// `None` if it is of facets itself, if it is so good that no eye would see that facets are better, if it is to be polished,
/// which facets are not made for, if lamp or wall are near, or if there are no such facets.
pub fn beside_facets(
    recipe: &Recipe,
    light: &Raster,
    plate: &Design,
    proof: &Proof,
    progress: &Progress,
) -> Result<Option<FacetComparison>, Cancelled> {
    if plate.sheet.is_none() || recipe.is_near() || recipe.design.sheet.polish.is_some() {
        return Ok(None);
    }
    let verdict = proof.milled.as_ref().map_or(&proof.verdict, |milled| &milled.verdict).main();
    let continuous = Score { misplaced: verdict.tv_incident.value, ssim: verdict.ssim.value };
    if continuous.misplaced < WORTH_TELLING {
        return Ok(None);
    }
    progress.stage(Stage::Comparison);
    let recipe = of_facets(recipe);
    let flat = match scored(&recipe, light, proof, progress) {
        Ok(Some(flat)) => flat,
        Err(DesignError::Cancelled(cancelled)) => return Err(cancelled),
        Ok(None) | Err(_) => return Ok(None),
    };
    Ok(Some(FacetComparison { facets: recipe.facets(), flat, continuous, milled: proof.milled.is_some() }))
}

/// The same recipe for flat facets, in one dome: the best that facets can do.
pub(crate) fn of_facets(recipe: &Recipe) -> Recipe {
    let mut recipe = recipe.clone().only_for(SurfaceKind::Facets);
    recipe.plate.cells = None;
    recipe
}

/// The score of a recipe's facets.
fn scored(recipe: &Recipe, light: &Raster, proof: &Proof, progress: &Progress) -> Result<Option<Score>, DesignError> {
    let plate = design(recipe, light, &progress.to_the_end().hushed())?;
    let setup = &plate.distribution.setup;
    let measuring = Measuring { rays: recipe.verify.rays.min(RAYS), ..recipe.measuring() };
    let metal = recipe.metal();
    let mirrored = Mirrored { setup, metal: &metal, measuring: &measuring, progress };
    let measurement = match recipe.design.sheet.cutter {
        None => mirrored.on(&GridSurface::new(&plate.relief, progress)?)?,
        Some(cutter) => send_over_milled_facets(&plate.relief, cutter, mirrored)?.0,
    };
    // The rim is the same.
    let measurement = RimProof::over(proof.rim.as_ref(), measurement);
    let (image, up) = (measurement.whole.lit_image(), measurement.whole.up());
    let scores = blurred_scores(&image, up, &proof.target, setup.view(), MAIN_BLUR.to_radians());
    Ok(scores.map(|scores| Score { misplaced: scores.tv_incident, ssim: scores.ssim }))
}
