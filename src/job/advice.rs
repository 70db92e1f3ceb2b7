//! Sentences of advice to whoever made a design, where something is off.

use super::compare::FacetComparison;
use super::design::Design;
use super::findings::{RimProof, WallProof};
use super::sentences::{WORTH_TELLING, finer_than_the_blur, stray_sentence};
use crate::distribution::SlopeDistribution;
use crate::goal::spec::GoalPart;
use crate::recipe::{BorderFinish, Recipe, SurfaceKind};
use crate::report::goal::GoalFacts;
use crate::sharpen::SCORED_AT;
use crate::verify::verdict::Verdict;

/// What a person should know when something is off; empty when nothing is. `verdict` is absent if no light was sent.
pub fn advice(recipe: &Recipe, design: &Design, verdict: Option<&Verdict>) -> Vec<String> {
    let of_proof =
        |verdict| [finer_than_the_blur(verdict), detail(recipe, design, verdict), lost_light(design, verdict)];
    [below_plate(design), beyond_cap(recipe, design), mean_slope(recipe, design), no_cutter(recipe), straying(design)]
        .into_iter()
        .chain(verdict.into_iter().flat_map(of_proof))
        .flatten()
        .collect()
}

/// Height that is worth mounting a plate tilted for, mm: stock comes in steps of about a millimetre.
const WORTH_LEVELLING: f64 = 1.0;

/// Height that the mean slope alone costs from corner to corner, mm.
pub(super) fn mean_slope_costs(recipe: &Recipe, distribution: &SlopeDistribution) -> f64 {
    let [x, y] = recipe.plate.size;
    distribution.mean.p.abs() * x + distribution.mean.q.abs() * y
}

fn percent(share: f64) -> String {
    format!("{:.1}%", 100.0 * share)
}

/// Light that was painted where nobody can see it.
fn below_plate(design: &Design) -> Option<String> {
    let lost = percent(design.below_plate);
    (design.below_plate > 0.001).then(|| {
        format!(
            "{lost} of the picture's light lies below the plate and was left out: lower the light's angle or --half-field."
        )
    })
}

/// Light that needs too steep a slope.
fn beyond_cap(recipe: &Recipe, design: &Design) -> Option<String> {
    let (lost, cap) = (percent(design.distribution.beyond_cap), recipe.design.distribution.slope_cap);
    (design.distribution.beyond_cap > 0.001).then(|| {
        format!(
            "{lost} of the highlight needs slopes steeper than {cap}° and was cut: raise --slope-cap or lower --half-field."
        )
    })
}

/// A plate that is tilted as a whole, which makes the relief high or its walls large: the mirror direction of the lamp is not
/// where the drawing has its mean.
fn mean_slope(recipe: &Recipe, design: &Design) -> Option<String> {
    let costs = mean_slope_costs(recipe, &design.distribution);
    if costs <= WORTH_LEVELLING {
        return None;
    }
    let (low, high) = design.relief.optical_heights();
    if costs <= 0.5 * (high - low) {
        return None;
    }
    if design.sheet.is_none() && recipe.heights().is_cyclic() {
        return Some(
            "The plate's mean slope is not zero and the arrangement is cyclic, so that slope stands in walls: add --level."
                .into(),
        );
    }
    let tilt = design.distribution.mean.tilt().to_degrees();
    // Where lamp and wall have places, so has the plate.
    let cure = if recipe.is_near() {
        "moving the drawing there would spare it".into()
    } else {
        format!("--level mounts the plate tilted by {tilt:.1}° instead")
    };
    Some(format!(
        "{costs:.1} mm of the relief's height are a tilt of the whole plate, since the middle of its light is not the middle \
         of the picture: {cure}."
    ))
}

/// Light that no relief keeps together, where it is enough to be seen.
fn straying(design: &Design) -> Option<String> {
    let share = design.least_stray.map(|stray| stray.share).filter(|share| *share >= WORTH_TELLING)?;
    Some(stray_sentence(share))
}

fn no_cutter(recipe: &Recipe) -> Option<String> {
    let sentence = match recipe.surface() {
        SurfaceKind::Sheet => {
            "No cutter was named, so valleys are as sharp as triangles: --for-cutter ball:0.5 shapes the relief for a mill."
        }
        SurfaceKind::Facets => {
            "No cutter was named, so steps and valleys are as sharp as facets: --for-cutter ball:0.5 tells what a mill leaves \
             of their light."
        }
    };
    recipe.design.sheet.cutter.is_none().then(|| sentence.into())
}

/// More detail in the picture than lamp and metal, or the facets, can show.
fn detail(recipe: &Recipe, design: &Design, verdict: &Verdict) -> Option<String> {
    let tv = verdict.main().tv.value;
    let blurred = design.sharpening.map_or(0.0, |worth| worth.after);
    if blurred > 0.05 {
        return Some(format!(
            "Lamp and metal blur the picture by more than light can be sharpened (TV {blurred:.3} at {SCORED_AT}°): a smaller lamp, better polish, or a picture of coarser detail or larger --half-field."
        ));
    }
    let [columns, rows] = recipe.facets();
    (tv > 0.05 && design.sheet.is_none()).then(|| {
        format!(
            "The picture has more detail than {columns}x{rows} facets can show at a blur of 1° (TV {tv:.3}): try --facets {}x{}.",
            2 * columns,
            2 * rows
        )
    })
}

/// Light that walls and valleys of facets take or bounce twice.
fn lost_light(design: &Design, verdict: &Verdict) -> Option<String> {
    let (blocked, twice) = (verdict.blocked.value, verdict.multi_bounce.value);
    (blocked + twice > 0.02 && design.sheet.is_none()).then(|| {
        format!(
            "{} of the light is blocked and {} bounces twice, on walls and valleys: --arrange transport has the fewest.",
            percent(blocked),
            percent(twice)
        )
    })
}

/// What the rim does to the picture, or would do if it were not left dull.
pub(super) fn about_rim(recipe: &Recipe, rim: &RimProof) -> Option<String> {
    let (width, share) = (recipe.plate.border, percent(rim.into_picture.value));
    let lit = percent(rim.lit);
    match recipe.border_finish() {
        BorderFinish::Matt if rim.into_picture.value > 0.002 => Some(format!(
            "Leave the rim of {width} mm dull (blasted, sanded or blackened): polished it would throw {share} as much \
             light as the relief into the picture. --border-finish sloped makes one that may shine."
        )),
        BorderFinish::Polished => Some(format!(
            "The polished rim of {width} mm throws {share} as much light as the relief into the picture: \
             --border-finish matt leaves it dull, sloped sends its light past the picture."
        )),
        BorderFinish::Sloped(_) if rim.into_picture.value > 0.002 => Some(format!(
            "The sloped rim, which gets {lit} as much light as the relief, throws {share} into the picture: a steeper \
             one (--border-finish sloped:DEG) throws less."
        )),
        BorderFinish::Matt | BorderFinish::Sloped(_) => None,
    }
}

/// That the lamp stands in the way of the picture's light.
pub(super) fn lamp_in_the_beam(wall: &WallProof) -> Option<String> {
    (wall.stopped_by_lamp > 0.001).then(|| {
        format!(
            "The lamp stands between plate and picture: one of 30 mm across, or as large as it is, stops {} of the light, a \
             hand there more; a lamp aslant (--light 30,90) stands beside the beam.",
            percent(wall.stopped_by_lamp)
        )
    })
}

/// That flat facets are better than a sheet, and what follows.
pub(super) fn facets_are_better(recipe: &Recipe, design: &Design, comparison: &FacetComparison) -> String {
    let FacetComparison { facets: [columns, rows], flat, continuous, milled } = comparison;
    let figures = format!(
        "{columns}x{rows} of them misplace {:.2}% of the light at a blur of 1°{}, the sheet {:.2}%",
        100.0 * flat.misplaced,
        if *milled { " once cut" } else { "" },
        100.0 * continuous.misplaced
    );
    let Some(sheet) = &design.sheet else {
        return format!("Flat facets were made, since {figures}: --surface continuous makes the sheet all the same.");
    };
    let early = (sheet.stopped_early().is_some()).then_some("let the design come to its end");
    let remedies: Vec<&str> = early.into_iter().chain(recipe.remedies()).collect();
    let first = if remedies.is_empty() { String::new() } else { format!("{}, or ", remedies.join(", ")) };
    format!("Flat facets would do better, since {figures}: {first}take --surface flat.")
}

/// What a preview is not.
pub(super) fn no_plate() -> String {
    "A preview is no plate to be made: leave out --preview for one that is.".into()
}

/// What mirrors leave out of a goal, if it is worth telling.
pub(super) fn about_base(goal: &GoalFacts) -> Option<String> {
    let share = 100.0 * goal.left_out;
    (goal.part == GoalPart::Specular && share > 0.1).then(|| {
        format!(
            "Mirrors cannot scatter evenly: {share:.1} % of what the goal reflects (an albedo of {:.3}) is its even base and \
             is left out. A matt varnish or --goal-part all, which spreads that light over the field, would be nearer.",
            goal.albedo
        )
    })
}
