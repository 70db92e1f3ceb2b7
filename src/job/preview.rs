//! A preview: relief, light and figures of a sheet in a fraction of a second, in memory, for a page or a script that asks
//! again at every change of a setting.
//!
//! The relief has few nodes and few steps ([`plan`](crate::sculpt::plan)), and its light is that of the first bounce off
//! every triangle, without rays: nothing is known of shadows, of second bounces or of what a cutter leaves. A preview that
//! is made after another begins from that one's relief.

use super::design::{Design, DesignError, slopes};
use super::findings::Proof;
use crate::highlight::scored_target;
use crate::progress::{Progress, Stage};
use crate::raster::Raster;
use crate::recipe::Recipe;
use crate::relief::periodic::PeriodicRelief;
use crate::sculpt::checkpoint::Checkpoint;
use crate::sculpt::plan::{PREVIEW_WARM, SheetSpec};
use crate::sculpt::stages::sculpt;
use crate::sculpt::start::Start;
use crate::setup::Setup;
use crate::sharpen::seen;
use crate::verify::score::{BlurredScores, blurred_scores};
use crate::verify::tally::{MeasureError, Measurement, PARTS, Tally};
use crate::verify::verdict::Verdict;
use crate::verify::windows::FirstBounce;

/// Pixels a side of the drawing that a preview is designed for. With 128 a word was misplaced by 0.0049 at 1° in place of 0.0036.
const DRAWING: usize = 256;

/// Blurs of a preview's figures, degrees.
pub const BLURS: [f64; 2] = [1.0, 0.5];

/// What a preview shows. It is no plate to be made.
#[derive(Clone, Debug)]
pub struct Preview {
    /// The relief.
    pub relief: PeriodicRelief,
    /// Where its light goes: the share of all light in each pixel, row 0 on top.
    pub light: Raster,
    /// What was wanted, sum 1.
    pub target: Raster,
    /// Figures at [`BLURS`].
    pub scores: [BlurredScores; BLURS.len()],
    start: Start,
    slope: f64,
}

/// The preview of `recipe`'s sheet for `light`, the picture's linear light on a square; from the relief of one `before` if
/// there is one, which is quicker.
///
/// The recipe need not ask for a preview. The same recipe, picture and preview before give the same one. `progress` is
/// offered reliefs on the way, and may end it, as in a design.
///
/// # Errors
/// Those of a design; a recipe of facets, or for a lamp or a wall nearby, has no preview.
pub fn preview(
    recipe: &Recipe,
    light: &Raster,
    before: Option<&Preview>,
    progress: &Progress,
) -> Result<Preview, DesignError> {
    let mut recipe = recipe.clone();
    recipe.design.sheet.preview = true;
    recipe.check()?;
    let side = light.width.min(DRAWING);
    let drawing = if side < light.width { light.resampled(side, side) } else { light.clone() };
    let distribution = slopes(&recipe, &drawing, progress)?;
    let sculpting = recipe.sculpting();
    let from = before.and_then(|before| before.adapted(&sculpting, distribution.spread));
    let sheet = sculpt(&distribution, &sculpting, from, &mut |_| {}, progress)?;
    let setup = &distribution.setup;
    let target = scored_target(light, recipe.highlight.quantity, setup, recipe.measuring().resolution);
    let light = first_light(&recipe, &sheet.relief, setup, &target, progress)?;
    let scores = BLURS.map(|blur| blurred_scores(&light, 1.0, &target, setup.view(), blur.to_radians()));
    let [Some(first), Some(second)] = scores else { return Err(MeasureError::NoLight.into()) };
    Ok(Preview {
        relief: sheet.relief,
        light,
        target,
        scores: [first, second],
        start: sheet.start,
        slope: distribution.spread,
    })
}

impl Preview {
    /// Its relief as where a preview of `sculpting` begins whose slopes spread by `spread`; `None` if it has other nodes.
    fn adapted(&self, sculpting: &SheetSpec, spread: f64) -> Option<Checkpoint> {
        let relief = &self.relief;
        let steeper = spread / self.slope * sculpting.cell.length() / relief.cell.length();
        if relief.nodes != sculpting.grid || !steeper.is_finite() {
            return None;
        }
        let heights = relief.heights.iter().map(|z| (f64::from(*z) * steeper) as f32).collect();
        Some(Checkpoint { done: PREVIEW_WARM, start: self.start, nodes: relief.nodes, heights, misplaced: Vec::new() })
    }
}

/// The share of all light that the first bounce off `relief` sends into each pixel of `target`, as lamp and metal blur it.
fn first_light(
    recipe: &Recipe,
    relief: &PeriodicRelief,
    setup: &Setup,
    target: &Raster,
    progress: &Progress,
) -> Result<Raster, DesignError> {
    let sent = FirstBounce::new(relief, setup, (target.width, target.height), progress)?.window([0, 0], relief.nodes);
    let sent = sent.ok_or(MeasureError::NoLight)?;
    Ok(recipe.blur(setup).map_or_else(|| sent.clone(), |blur| seen(&sent, &blur)))
}

/// The proof of a preview that was designed as a plate is: the light of the first bounce, in closed form. `None` of facets.
pub(super) fn previewed(
    recipe: &Recipe,
    light: &Raster,
    design: &Design,
    progress: &Progress,
) -> Result<Option<Proof>, DesignError> {
    let Some(relief) = design.sheet.as_ref().map(|sheet| &sheet.relief) else { return Ok(None) };
    let setup = &design.distribution.setup;
    progress.stage(Stage::Scoring);
    let target = scored_target(light, recipe.highlight.quantity, setup, recipe.measuring().resolution);
    let image = first_light(recipe, relief, setup, &target, progress)?;
    let share = 1.0 / PARTS as f64;
    let mut part = Tally::empty((target.width, target.height));
    (part.incident, part.up_single) = (share, share);
    part.outside_image = share * (1.0 - image.sum()).max(0.0);
    part.image = image.scaled(share);
    let measurement = Measurement::of_parts(vec![part; PARTS])?;
    let verdict = Verdict::new(&measurement, &target, setup.view(), progress)?;
    let (sheet, milled, made, rim, wall) = (None, None, None, None, None);
    Ok(Some(Proof { target, measurement, verdict, sheet, milled, made, rim, wall }))
}
