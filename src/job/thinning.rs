//! The triangles of a sheet's file: fewer of them where slopes change little, as few as its light or the recipe allows.

use super::cut_sheet::{CutSheet, cut_plate};
use crate::highlight::{Quantity, scored_target};
use crate::progress::{Cancelled, Progress};
use crate::raster::Raster;
use crate::recipe::Recipe;
use crate::recipe::file_size::FileSize;
use crate::relief::open::OpenRelief;
use crate::relief::periodic::PeriodicRelief;
use crate::relief::thinned::{Thinned, Tiled};
use crate::scene::Scene;
use crate::sculpt::bisection::{Bisection, HALF_LOST, HALF_LOST_ON_WALL};
use crate::setup::Setup;
use crate::sharpen::seen;
use crate::trace::grid::GridSurface;
use crate::verify::elsewhere::scored_directly;
use crate::verify::score::blurred_scores;
use crate::verify::thrown::ACROSS;
use crate::verify::verdict::MAIN_BLUR;
use crate::verify::windows::FirstBounce;

/// What a thinned sheet is held to.
struct Standard {
    /// By how much its figures may be worse than the whole one's.
    worse: Figures,
    /// Difference of slopes at which half of the light counts as lost.
    half_lost: f64,
    /// By how much more triangles there are from one trial to the next.
    more: f64,
}

/// Far away, likeness is at 0.5°. What a cutter of 0.5 mm loses beside the drawing is several times as much.
const FAR: Standard = Standard { worse: [0.0015, 0.002, 0.005], half_lost: HALF_LOST, more: 1.4 };

/// On a wall, likeness is at the eye's blur: it wants so many triangles that smaller strides are worth their trials.
const ON_WALL: Standard = Standard { worse: [0.0015, 0.002, 0.01], half_lost: HALF_LOST_ON_WALL, more: 1.25 };

/// The blur at which detail is compared, degrees.
const DETAIL_BLUR: f64 = 0.5;

/// The share of the whole file's triangles beyond which it is written whole.
const WORTH_IT: f64 = 0.7;

/// What was found of a sheet in fewer triangles than its grid has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thinning {
    /// Triangles of the whole file without it.
    pub full: usize,
    /// Misplaced light at 1° by first bounces, as made: of the thinned sheet, and of the whole one.
    pub misplaced: [f64; 2],
    /// Whether the figures are within their limits of the whole sheet's.
    pub within_limits: bool,
}

/// Misplaced light at 1° and at 0.5°, and likeness.
type Figures = [f64; 3];

/// How sheets are judged.
struct Judging<'a, R> {
    /// The figures of a surface; `None` if no light falls on it.
    figures: &'a dyn Fn(&R) -> Result<Option<Figures>, Cancelled>,
    /// A sheet as its cutter and polish leave it.
    made: &'a dyn Fn(&R) -> Result<R, Cancelled>,
    standard: Standard,
}

/// `relief`, which is lit from far away, in as few triangles as `recipe` wants; `None` if it is to be written whole, or must be
/// to keep its light.
///
/// # Errors
/// The work is abandoned.
pub(super) fn thinned(
    recipe: &Recipe,
    relief: &PeriodicRelief,
    (light, setup): (&Raster, &Setup),
    progress: &Progress,
) -> Result<Option<(Thinned<PeriodicRelief>, Thinning)>, Cancelled> {
    let target = || scored_target(light, recipe.highlight.quantity, setup, recipe.measuring().resolution);
    let target = std::cell::LazyCell::new(target);
    let blur = recipe.blur(setup);
    let figures = |relief: &PeriodicRelief| {
        let light = FirstBounce::new(relief, setup, (target.width, target.height), progress)?;
        let Some(sent) = light.window([0, 0], relief.nodes) else { return Ok(None) };
        let image = blur.as_ref().map_or_else(|| sent.clone(), |blur| seen(&sent, blur));
        let at = |blur: f64| blurred_scores(&image, 1.0, &target, setup.view(), blur.to_radians());
        Ok(at(MAIN_BLUR).zip(at(DETAIL_BLUR)).map(|(main, fine)| [main.tv_incident, fine.tv_incident, fine.ssim]))
    };
    let made = |relief: &PeriodicRelief| Ok(CutSheet::of(recipe, relief, progress)?.relief);
    fewest(recipe, relief, &Judging { figures: &figures, made: &made, standard: FAR }, progress)
}

/// The same of a sheet over a whole plate, whose light lands on the wall of `scene`.
///
/// # Errors
/// The work is abandoned.
pub(super) fn thinned_in_room(
    recipe: &Recipe,
    relief: &OpenRelief,
    (light, setup, scene): (&Raster, &Setup, &Scene),
    progress: &Progress,
) -> Result<Option<(Thinned<OpenRelief>, Thinning)>, Cancelled> {
    let target = std::cell::LazyCell::new(|| scored_target(light, Quantity::Flux, setup, ACROSS));
    let figures = |relief: &OpenRelief| {
        let surface = GridSurface::continuous(&relief.height_grid(progress)?, progress)?;
        let scores = scored_directly(&surface, scene, (&target, recipe.eye_distance()), progress);
        progress.check()?;
        Ok(scores.map(|scores| [scores.tv[1], scores.tv[0], scores.ssim_eye]))
    };
    let made = |relief: &OpenRelief| Ok(cut_plate(recipe, relief, progress)?.0);
    fewest(recipe, relief, &Judging { figures: &figures, made: &made, standard: ON_WALL }, progress)
}

fn fewest<R: Tiled>(
    recipe: &Recipe,
    relief: &R,
    judging: &Judging<R>,
    progress: &Progress,
) -> Result<Option<(Thinned<R>, Thinning)>, Cancelled> {
    let (tiles, squares) = (relief.tiles(), relief.squares());
    let surface = [0, 1].map(|axis| tiles[axis] * squares[axis]);
    let full = recipe.file_triangles(surface);
    let (mut most, kept) = match recipe.file_size() {
        FileSize::Whole => return Ok(None),
        FileSize::AtMost(most) => (most as f64, true),
        FileSize::AsLightAllows(first) => (first as f64, false),
    };
    if full <= most {
        return Ok(None);
    }
    let Judging { figures, made, standard } = judging;
    let Some(mut cover) = Bisection::new(relief, standard.half_lost) else { return Ok(None) };
    let is_made = recipe.design.sheet.cutter.is_some() || recipe.design.sheet.polish.is_some();
    let Some(written) = figures(relief)? else { return Ok(None) };
    let Some(whole) = (if is_made { figures(&made(relief)?)? } else { Some(written) }) else { return Ok(None) };
    let within = |now: &Figures, whole: &Figures| {
        let by = [now[0] - whole[0], now[1] - whole[1], whole[2] - now[2]];
        by.iter().zip(standard.worse).all(|(by, worse)| *by <= worse)
    };
    // Sides and base, of a plate whose rim all nodes are corners of.
    let around = full - 2.0 * surface.map(|n| n as f64).iter().product::<f64>();
    loop {
        cover.refine(((most - around) / tiles.iter().product::<usize>() as f64) as usize, progress)?;
        let thinned = cover.thinned();
        let Some(mut now) = figures(&thinned.relief)? else { return Ok(None) };
        let mut within_limits = within(&now, &written);
        // A cutter led over it takes longer than all else, and is not asked in vain.
        if is_made && (within_limits || kept) {
            let Some(cut) = figures(&made(&thinned.relief)?)? else { return Ok(None) };
            (now, within_limits) = (cut, within_limits && within(&cut, &whole));
        }
        if within_limits || kept {
            let found = Thinning { full: full as usize, misplaced: [now[0], whole[0]], within_limits };
            return Ok(Some((thinned, found)));
        }
        most *= standard.more;
        // A file that saves little is no reason to change the relief.
        if most > WORTH_IT * full {
            return Ok(None);
        }
    }
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
        let thin = |recipe: &Recipe| {
            let made = thinned(recipe, &relief, (&ring, &plate.distribution.setup), &silent).unwrap();
            made.map(|(thinned, found)| (thinned.count(), found))
        };
        assert!(thin(&recipe).is_none());
        recipe.plate.grid = None;
        let (count, made) = thin(&recipe).unwrap();
        // Triangles of 8 squares are this sheet's own.
        assert!(made.within_limits && made.full == 1_188_864, "{}", made.full);
        assert!((400_000..=490_784).contains(&count), "{}", count);
        assert!((made.misplaced[0] - made.misplaced[1]).abs() < FAR.worse[0], "{:?}", made.misplaced);
        let fine = Recipe { plate: crate::recipe::PlateSettings { fine: true, ..recipe.plate }, ..recipe.clone() };
        assert!(thin(&fine).is_none());
        recipe.design.sheet.cutter = Some(Cutter::ball(0.5));
        recipe.plate.max_triangles = Some(200_000);
        let (count, _) = thin(&recipe).unwrap();
        assert!((180_000..=190_784).contains(&count), "{}", count);
        // What is too few for this sheet is left to a design on a coarser grid.
        recipe.plate.max_triangles = Some(50_000);
        assert!(thin(&recipe).is_none());
        assert!(recipe.triangles(recipe.sculpting().grid) <= 50_000.0);
    }
}
