//! From a recipe and its picture to a plate.

mod error;

pub use error::DesignError;

use super::clock::Clock;
use super::near::{NearDesign, NearSheet};
use super::sentences::{WORTH_TELLING, stray_sentence};
use super::thinning::{Thinning, thinned, thinned_in_room};
use crate::distribution::SlopeDistribution;
use crate::export::sheet::{sheet_solid, thinned_solid};
use crate::export::solid::solid;
use crate::facets::SlopeGrid;
use crate::facets::arrange::{anneal::anneal_best, per_cell::arrange_per_cell, random_order, transport};
use crate::facets::heights::{least_squares, weyrich2009};
use crate::facets::sample::sample;
use crate::facets::steps::{Steps, steps};
use crate::highlight::Highlight;
use crate::progress::{Progress, Stage};
use crate::raster::Raster;
use crate::recipe::{Arrangement, Heights, Recipe, SurfaceKind};
use crate::relief::faceted::{Facet, FacetedRelief};
use crate::relief::mesh::Mesh;
use crate::relief::open::NodeGrid;
use crate::relief::rim::Rim;
use crate::relief::thinned::{Thinned, Tiled};
use crate::sculpt::bound::Unavoidable;
use crate::sculpt::checkpoint::Checkpoint;
use crate::sculpt::stages::{Sheet, least_stray, sculpt};
use crate::setup::Setup;
use crate::sharpen::{Sharpening, sharpen};
use crate::slope::Slope;

/// Light painted below the plate beyond which a design is refused.
const MOST_BELOW: f64 = 0.5;

/// By how much a sheet may be deeper than asked, as a share: descents end close to the limit, not at it.
const DEPTH_ALLOWANCE: f64 = 0.02;

/// A plate, and how it came about.
#[derive(Clone, Debug)]
pub struct Design {
    /// Share of the picture's light painted where no direction above the plate is.
    pub below_plate: f64,
    /// What sharpening was worth, if lamp or metal blur.
    pub sharpening: Option<Sharpening>,
    /// The slopes that were wanted.
    pub distribution: SlopeDistribution,
    /// Facets in their places, if the relief is made of them.
    pub facets: Option<Facets>,
    /// The continuous sheet, if the relief is one.
    pub sheet: Option<Sheet>,
    /// Light that its cutter cannot keep from straying, if it is for one.
    pub least_stray: Option<Unavoidable>,
    /// Its fewer triangles, if it is a sheet that was thinned.
    pub thinning: Option<Thinning>,
    /// How it follows lamp and wall, if they are near.
    pub near: Option<NearDesign>,
    /// The relief with its rim; of a continuous one, a plane for each square of its grid.
    pub relief: FacetedRelief,
    /// The closed solid.
    pub mesh: Mesh,
    /// Whether it was told to finish before its end: it is the best so far.
    pub ended_early: bool,
    /// CPU seconds by stage, in order.
    pub seconds: Vec<(&'static str, f64)>,
}

/// Facets and how they meet.
#[derive(Clone, Debug)]
pub struct Facets {
    /// The slopes that the facets have, in their places.
    pub grid: SlopeGrid,
    /// Steps, walls and valleys of the optical area.
    pub steps: Steps,
}

/// Designs the plate of `recipe` for `light`, the picture's linear light on a square.
pub fn design(recipe: &Recipe, light: &Raster, progress: &Progress) -> Result<Design, DesignError> {
    design_with_checkpoints(recipe, light, None, &mut |_, _| {}, progress)
}

/// Who is told of every step of a sheet: what slopes are wanted, and what has been reached.
pub(crate) type OnStep<'a> = &'a mut (dyn FnMut(&SlopeDistribution, &Checkpoint) + Send);

/// The same, for sheets that take long: goes on from where an earlier run of the same recipe had come, and
/// tells `on_step` of every step that is done.
///
/// Told to finish, it ends with the best so far, facets less well arranged or a sheet less well shaped; abandoned, in
/// [`DesignError::Cancelled`].
pub(crate) fn design_with_checkpoints(
    recipe: &Recipe,
    light: &Raster,
    from: Option<Checkpoint>,
    on_step: OnStep<'_>,
    progress: &Progress,
) -> Result<Design, DesignError> {
    recipe.check()?;
    let mut clock = Clock::start();
    progress.stage(Stage::Distribution);
    let setup = recipe.setup();
    let (highlight, sharpening) = wanted(recipe, light, &setup, progress)?;
    if sharpening.is_some() {
        clock.lap(Stage::Sharpening);
    }
    let distribution = SlopeDistribution::new(&highlight, &setup, &recipe.design.distribution, |_| 1.0)?;
    clock.lap(Stage::Distribution);
    let made = match recipe.surface() {
        SurfaceKind::Facets => faceted(recipe, &distribution, &mut clock, progress)?,
        SurfaceKind::Sheet => {
            let on_step = &mut |at: &Checkpoint| on_step(&distribution, at);
            continuous(recipe, &distribution, Stepwise { light, from, on_step }, &mut clock, progress)?
        }
    };
    progress.check()?;
    let Shaped { facets, sheet, least_stray, thinning, near, relief, mesh, ended_early } = made;
    let seconds = clock.into_laps();
    Ok(Design {
        below_plate: highlight.below_plate,
        sharpening,
        distribution,
        facets,
        sheet,
        least_stray,
        thinning,
        near,
        relief,
        mesh,
        ended_early,
        seconds,
    })
}

/// Light that no relief of `recipe` keeps from straying once its cutter has cut it; `None` without a cutter, and of facets.
pub fn unavoidable_light(recipe: &Recipe, light: &Raster) -> Result<Option<Unavoidable>, DesignError> {
    recipe.check()?;
    if recipe.surface() == SurfaceKind::Facets || recipe.design.sheet.cutter.is_none() {
        return Ok(None);
    }
    Ok(least_stray(&slopes(recipe, light, &Progress::silent())?, &recipe.sculpting()))
}

/// The slopes that send the drawing's `light`, and how much of the plate each gets.
///
/// # Errors
/// No slopes send it, or the work is cancelled.
pub(super) fn slopes(recipe: &Recipe, light: &Raster, progress: &Progress) -> Result<SlopeDistribution, DesignError> {
    let setup = recipe.setup();
    let (highlight, _) = wanted(recipe, light, &setup, progress)?;
    Ok(SlopeDistribution::new(&highlight, &setup, &recipe.design.distribution, |_| 1.0)?)
}

/// The light that is to be sent, sharpened if lamp or metal blur it, if most of it lies above the plate.
fn wanted(
    recipe: &Recipe,
    light: &Raster,
    setup: &Setup,
    progress: &Progress,
) -> Result<(Highlight, Option<Sharpening>), DesignError> {
    let mut highlight =
        Highlight::new(&shrunk(light), recipe.highlight.quantity, setup).ok_or(DesignError::AllBelow)?;
    if highlight.below_plate > MOST_BELOW {
        return Err(DesignError::MostlyBelow { share: highlight.below_plate });
    }
    let sharpening = recipe.blur(setup).map(|blur| {
        progress.stage(Stage::Sharpening);
        sharpen(&mut highlight.flux, &blur, progress)
    });
    Ok((highlight, sharpening))
}

/// What comes of either kind of relief.
struct Shaped {
    facets: Option<Facets>,
    sheet: Option<Sheet>,
    least_stray: Option<Unavoidable>,
    thinning: Option<Thinning>,
    near: Option<NearDesign>,
    relief: FacetedRelief,
    mesh: Mesh,
    ended_early: bool,
}

/// What a sheet is judged by, where it goes on from, and who hears of its steps.
struct Stepwise<'a> {
    light: &'a Raster,
    from: Option<Checkpoint>,
    on_step: &'a mut dyn FnMut(&Checkpoint),
}

fn continuous(
    recipe: &Recipe,
    distribution: &SlopeDistribution,
    stepwise: Stepwise,
    clock: &mut Clock,
    progress: &Progress,
) -> Result<Shaped, DesignError> {
    let sculpting = recipe.sculpting();
    let least_stray = least_stray(distribution, &sculpting);
    match least_stray.map(|stray| stray.share).filter(|share| *share >= WORTH_TELLING) {
        Some(share) => progress.stage_with(Stage::Sculpting, &stray_sentence(share)),
        None => progress.stage(Stage::Sculpting),
    }
    let mut sheet = sculpt(distribution, &sculpting, stepwise.from, stepwise.on_step, progress)?;
    let ended_early = sheet.stopped_early().is_some();
    clock.lap(Stage::Sculpting);
    shallow_enough(sheet.relief.depth(), recipe)?;
    let mut near = NearDesign::new(recipe, distribution);
    if let Some(near) = &mut near {
        progress.stage_with(Stage::Room, &near.why);
        near.finish(recipe, distribution, &sheet, progress)?;
        progress.check()?;
        clock.lap(Stage::Room);
        shallow_enough(near.depth(), recipe)?;
    }
    let ended_early = ended_early || near.is_some() && progress.is_to_finish();
    progress.stage(Stage::Solid);
    let (thickness, rim) = (recipe.plate.thickness, recipe.rim(&distribution.setup));
    let (light, setup) = (stepwise.light, &distribution.setup);
    let room = near.as_mut().and_then(|near| Some((near.sheet.as_mut()?, near.field.scene())));
    let (mesh, thinning) = match room {
        Some((NearSheet { relief, .. }, scene)) => {
            let thinned = thinned_in_room(recipe, relief, (light, setup, scene), progress)?;
            closed(relief, thinned, (thickness, rim), progress)?
        }
        None => {
            let thinned = thinned(recipe, &sheet.relief, (light, setup), progress)?;
            closed(&mut sheet.relief, thinned, (thickness, rim), progress)?
        }
    };
    progress.check()?;
    let planes = match near.as_ref().and_then(|near| near.sheet.as_ref()) {
        Some(near) => near.relief.faceted(),
        None => sheet.relief.faceted(),
    };
    let relief = planes.with_rim(rim);
    clock.lap(Stage::Solid);
    Ok(Shaped { facets: None, sheet: Some(sheet), least_stray, thinning, near, relief, mesh, ended_early })
}

/// The solid body of a sheet, which becomes as it is thinned.
fn closed<R: Tiled>(
    relief: &mut R,
    thinned: Option<(Thinned<R>, Thinning)>,
    (thickness, rim): (f64, Rim),
    progress: &Progress,
) -> Result<(Mesh, Option<Thinning>), DesignError> {
    let Some((thinned, found)) = thinned else { return Ok((sheet_solid(relief, thickness, rim, progress)?, None)) };
    let mesh = thinned_solid(&thinned, thickness, rim, progress)?;
    *relief = thinned.relief;
    Ok((mesh, Some(found)))
}

/// Refuses a relief that is deeper about its mean plane than it may be, or than its cutter reaches.
fn shallow_enough(depth: f64, recipe: &Recipe) -> Result<(), DesignError> {
    recipe.reaches(depth)?;
    match recipe.design.sheet.max_depth.filter(|most| depth > (1.0 + DEPTH_ALLOWANCE) * most) {
        Some(most) => Err(DesignError::TooDeep { depth, most }),
        None => Ok(()),
    }
}

fn faceted(
    recipe: &Recipe,
    distribution: &SlopeDistribution,
    clock: &mut Clock,
    progress: &Progress,
) -> Result<Shaped, DesignError> {
    let [columns, rows] = recipe.facets();
    let (pitch, seed) = (recipe.pitch(), recipe.design.seed);
    progress.stage(Stage::Sampling);
    let points = sample(distribution, columns * rows, recipe.sampling(), seed, progress);
    let slopes = points.iter().map(|uv| distribution.setup.slope_at(*uv).unwrap_or(Slope::FLAT)).collect();
    clock.lap(Stage::Sampling);

    progress.stage(Stage::Arrangement);
    let grid = arranged(recipe, slopes, progress);
    clock.lap(Stage::Arrangement);
    progress.check()?;
    let ended_early = progress.is_to_finish();

    progress.stage(Stage::Heights);
    let near = NearDesign::new(recipe, distribution);
    let [turned, above] = match &near {
        Some(near) => near.facets(&distribution.setup, &grid, pitch),
        None => [grid.slopes.clone(), grid.slopes.clone()],
    };
    let (grid, above) = (SlopeGrid { slopes: turned, ..grid }, SlopeGrid { slopes: above, ..grid });
    let (periodic, mut heights) = match recipe.heights() {
        Heights::Free => (false, least_squares(&above, pitch, false)),
        Heights::Cyclic => (true, least_squares(&above, pitch, true)),
        Heights::Weyrich2009 => (true, weyrich2009(&above, pitch)),
    };
    if let Some(near) = &near {
        heights.iter_mut().zip(near.facet_bases(&grid, pitch)).for_each(|(height, base)| *height += base);
    }
    let steps = steps(&grid, &heights, pitch, periodic && near.is_none());
    let facets = heights.iter().zip(&grid.slopes).map(|(&height, &slope)| Facet { height, slope }).collect();
    let relief = FacetedRelief::uniform(columns, rows, recipe.plate.size.into(), facets);
    recipe.reaches(relief.depth())?;
    let relief = relief.with_rim(recipe.rim(&distribution.setup));
    clock.lap(Stage::Heights);

    progress.stage(Stage::Solid);
    let mesh = solid(&relief, recipe.plate.thickness, progress)?;
    clock.lap(Stage::Solid);
    let facets = Some(Facets { grid, steps });
    Ok(Shaped { facets, sheet: None, least_stray: None, thinning: None, near, relief, mesh, ended_early })
}

fn arranged(recipe: &Recipe, slopes: Vec<Slope>, progress: &Progress) -> SlopeGrid {
    let [columns, rows] = recipe.facets();
    let pitch = recipe.pitch();
    arrange_per_cell(slopes, columns, rows, recipe.cells(), |slopes, columns, rows, cell| {
        let seed = recipe.design.seed.wrapping_add(cell as u64);
        if recipe.arrangement() == Arrangement::Transport {
            return transport::dome(slopes, columns, rows, pitch, progress);
        }
        let mut grid = SlopeGrid { columns, rows, slopes };
        random_order(&mut grid, seed);
        if recipe.arrangement() == Arrangement::Anneal {
            anneal_best(&mut grid, &recipe.annealing(), seed, progress);
        }
        grid
    })
}

/// Pictures finer than this are averaged for the design (the score always uses every pixel).
const FINEST: usize = 1024;

fn shrunk(light: &Raster) -> Raster {
    let side = light.width.min(FINEST);
    if side == light.width { light.clone() } else { light.resampled(side, side) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reliefs_deeper_than_allowed_are_refused() {
        let mut recipe = Recipe::default();
        assert!(shallow_enough(9.0, &recipe).is_ok());
        recipe.design.sheet.max_depth = Some(0.5);
        assert!(shallow_enough(0.509, &recipe).is_ok());
        let error = shallow_enough(0.511, &recipe).unwrap_err().to_string();
        assert!(
            ["0.511", "0.5 mm", "of a cell about its mean plane", "--max-depth", "--cells"]
                .iter()
                .all(|part| error.contains(part)),
            "{error}"
        );
    }
}
