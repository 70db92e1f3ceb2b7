//! The triangles of a sheet's file: fewer of them where slopes change little, as few as its light or the recipe allows.

use super::cut_sheet::CutSheet;
use crate::highlight::scored_target;
use crate::progress::{Cancelled, Progress};
use crate::raster::Raster;
use crate::recipe::Recipe;
use crate::recipe::file_size::FileSize;
use crate::relief::periodic::PeriodicRelief;
use crate::relief::thinned::Thinned;
use crate::sculpt::bisection::Bisection;
use crate::setup::Setup;
use crate::sharpen::seen;
use crate::verify::score::blurred_scores;
use crate::verify::verdict::MAIN_BLUR;
use crate::verify::windows::FirstBounce;

/// By how much a thinned sheet's figures may be worse than the whole one's: misplaced light at 1° and at 0.5°, likeness at
/// 0.5°. What a cutter of 0.5 mm loses beside the drawing is several times as much.
const WORSE: [f64; 3] = [0.0015, 0.002, 0.005];

/// The blur at which detail is compared, degrees.
const DETAIL_BLUR: f64 = 0.5;

/// By how much more triangles there are from one trial to the next.
const MORE: f64 = 1.4;

/// A sheet in fewer triangles than its grid has.
#[derive(Clone, Debug)]
pub struct Thinning {
    /// The sheet.
    pub thinned: Thinned,
    /// Triangles of the whole file without it.
    pub full: usize,
    /// Misplaced light at 1° by first bounces, as made: of the thinned sheet, and of the whole one.
    pub misplaced: [f64; 2],
    /// Whether the figures are within their limits of the whole sheet's.
    pub within_limits: bool,
}

/// `relief` in as few triangles as `recipe` wants; `None` if it is to be written whole, or must be to keep its light.
///
/// # Errors
/// The work is abandoned.
pub(super) fn thinning(
    recipe: &Recipe,
    relief: &PeriodicRelief,
    (light, setup): (&Raster, &Setup),
    progress: &Progress,
) -> Result<Option<Thinning>, Cancelled> {
    let full = recipe.triangles(relief.nodes);
    let (mut most, kept) = match recipe.file_size() {
        FileSize::Whole => return Ok(None),
        FileSize::AtMost(most) => (most as f64, true),
        FileSize::AsLightAllows(first) => (first as f64, false),
    };
    if full <= most {
        return Ok(None);
    }
    let Some(mut cover) = Bisection::new(relief) else { return Ok(None) };
    let target = scored_target(light, recipe.highlight.quantity, setup, recipe.measuring().resolution);
    let figures = |relief: &PeriodicRelief| figures(recipe, relief, setup, &target, progress);
    let Some(whole) = figures(relief)? else { return Ok(None) };
    // Sides and base, of a plate whose rim all nodes are corners of.
    let cells = relief.cells.iter().product::<usize>();
    let around = full - recipe.surface_triangles(relief.nodes);
    loop {
        cover.refine(((most - around) / cells as f64) as usize, progress)?;
        let thinned = cover.thinned();
        let Some(now) = figures(&thinned.relief)? else { return Ok(None) };
        let within_limits = now.iter().zip(&whole).all(|(now, whole)| within(now, whole));
        if within_limits || kept {
            let misplaced = [&now, &whole].map(|figures| figures.last().map_or(f64::NAN, |made| made[0]));
            return Ok(Some(Thinning { thinned, full: full as usize, misplaced, within_limits }));
        }
        most *= MORE;
        // A file that saves little is no reason to change the relief.
        if MORE * most > 2.0 * full {
            return Ok(None);
        }
    }
}

fn within(now: &[f64; 3], whole: &[f64; 3]) -> bool {
    let [tv, tv_detail, ssim] = [now[0] - whole[0], now[1] - whole[1], whole[2] - now[2]];
    tv <= WORSE[0] && tv_detail <= WORSE[1] && ssim <= WORSE[2]
}

/// Misplaced light at 1° and at 0.5° and the likeness at 0.5°, by first bounces: as written, and as made if it is for a cutter
/// or polish. `None` if no light falls on it.
fn figures(
    recipe: &Recipe,
    relief: &PeriodicRelief,
    setup: &Setup,
    target: &Raster,
    progress: &Progress,
) -> Result<Option<Vec<[f64; 3]>>, Cancelled> {
    let blur = recipe.blur(setup);
    let of = |relief: &PeriodicRelief| {
        let light = FirstBounce::new(relief, setup, (target.width, target.height), progress)?;
        let Some(sent) = light.window([0, 0], relief.nodes) else { return Ok(None) };
        let image = blur.as_ref().map_or_else(|| sent.clone(), |blur| seen(&sent, blur));
        let at = |blur: f64| blurred_scores(&image, 1.0, target, setup.view(), blur.to_radians());
        Ok(at(MAIN_BLUR).zip(at(DETAIL_BLUR)).map(|(main, fine)| [main.tv_incident, fine.tv_incident, fine.ssim]))
    };
    let mut all = vec![of(relief)?];
    if recipe.design.sheet.cutter.is_some() || recipe.design.sheet.polish.is_some() {
        all.push(of(&CutSheet::of(recipe, relief, progress)?.relief)?);
    }
    Ok(all.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::design::design;
    use crate::recipe::Cutter;
    use crate::sculpt::resample::sampled;

    #[test]
    fn a_file_is_as_small_as_its_light_or_its_budget_allows() {
        let silent = Progress::silent();
        let ring = Raster::from_fn(64, 64, |x, y| {
            let radius = (x as f64 - 31.5).hypot(y as f64 - 31.5) / 32.0;
            f64::from(u8::from((0.4..0.6).contains(&radius)))
        });
        let mut recipe = Recipe::default();
        (recipe.plate.grid, recipe.plate.cells) = (Some(48), Some(2.into()));
        let plate = design(&recipe, &ring, &silent).unwrap();
        assert!(plate.thinning.is_none(), "a grid that was asked for is written");
        let sheet = plate.sheet.unwrap().relief;
        let relief = PeriodicRelief { nodes: 384, heights: sampled(&sheet, 384), ..sheet };
        let thin = |recipe: &Recipe| thinning(recipe, &relief, (&ring, &plate.distribution.setup), &silent).unwrap();
        assert!(thin(&recipe).is_none());
        recipe.plate.grid = None;
        let made = thin(&recipe).unwrap();
        // Triangles of 8 squares are this sheet's own.
        assert!(made.within_limits && made.full == 1_188_864, "{}", made.full);
        assert!((400_000..=490_784).contains(&made.thinned.count()), "{}", made.thinned.count());
        assert!((made.misplaced[0] - made.misplaced[1]).abs() < WORSE[0], "{:?}", made.misplaced);
        let fine = Recipe { plate: crate::recipe::PlateSettings { fine: true, ..recipe.plate }, ..recipe.clone() };
        assert!(thin(&fine).is_none());
        recipe.design.sheet.cutter = Some(Cutter::ball(0.5));
        recipe.plate.max_triangles = Some(200_000);
        let made = thin(&recipe).unwrap();
        assert!((180_000..=190_784).contains(&made.thinned.count()), "{}", made.thinned.count());
        // What is too few for this sheet is left to a design on a coarser grid.
        recipe.plate.max_triangles = Some(50_000);
        assert!(thin(&recipe).is_none());
        assert!(recipe.triangles(recipe.sculpting().grid) <= 50_000.0);
    }
}
