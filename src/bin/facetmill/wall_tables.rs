//! What a person is told of a wall nearby.

use facetmill::report::on_wall::{OnWallFacts, WallScores};

use crate::rows::{Row, percent, row, told};

/// With more of its light misplaced a picture on a wall is not called sharp.
const FOCUSED: f64 = 0.05;

/// The light on a wall nearby, and where that may stand.
pub fn on_wall_in_short(facts: &OnWallFacts) -> Vec<Row> {
    let shown = [("on the wall", "wall"), ("  as milled", "as milled"), ("in focus", "in focus")];
    let of_name = |[name, value, meaning]: Row| {
        let (_, short) = shown.iter().find(|(long, _)| *long == name)?;
        Some(told(short, format!("{value} {meaning}")))
    };
    on_wall(facts).into_iter().filter_map(of_name).collect()
}

/// A plate in its room.
pub fn on_wall(facts: &OnWallFacts) -> Vec<Row> {
    let metres = |mm: f64| format!("{:.2} m", 1e-3 * mm);
    let figure = |scores: &WallScores, name: &str| scores.tv_incident.get(name).unwrap_or(f64::NAN);
    let likeness = |scores: &WallScores| scores.ssim.get("eye").unwrap_or(f64::NAN);
    let mut table = vec![
        row("lamp", facts.lamp_distance_mm.map_or("far".into(), metres), facts.lamp.clone()),
        row("wall", metres(facts.wall_distance_mm), facts.wall.clone()),
    ];
    let mut scores = |name: &str, scores: &WallScores| {
        let eye = percent(figure(scores, "eye"));
        let meaning = format!(
            "misplaced on the wall at a blur of 0.5°; {eye} to an eye {} away, likeness {:.3}",
            metres(facts.eye_distance_mm),
            likeness(scores)
        );
        table.push(row(name, percent(figure(scores, "0.5deg")), meaning));
    };
    scores("on the wall", &facts.designed);
    facts.as_milled.iter().for_each(|milled| scores("  as milled", milled));
    table.push(row("grain", percent(facts.designed.grain), "of the drawing's light, seen by that eye and not at 0.5°"));
    // A picture that is not there is in focus nowhere.
    let in_focus = facts.in_focus_tv.filter(|limit| *limit <= FOCUSED);
    if let (Some([nearest, farthest]), Some(limit)) = (facts.in_focus_mm, in_focus) {
        let ends = match (nearest.map(metres), farthest.map(metres)) {
            (Some(near), Some(far)) => format!("{near} to {far}"),
            (Some(near), None) => format!("{near} or more"),
            (None, Some(far)) => format!("up to {far}"),
            (None, None) => "anywhere".into(),
        };
        let meaning = format!("where the wall may stand, the lamp as it is: up to {} misplaced", percent(limit));
        table.push(row("in focus", ends, meaning));
    }
    if let Some(sun) = &facts.under_sun {
        let meaning = format!("the wall that is sharp under the sun; {} misplaced there", percent(sun.tv));
        table.push(row("under the sun", metres(sun.wall_mm), meaning));
    }
    if let Some(cells) = &facts.cells_tv {
        let meaning = format!("misplaced by the worst cell alone, {} on average", percent(cells.mean));
        table.push(row("one cell", percent(cells.largest), meaning));
    }
    if let Some(patch) = &facts.diffraction {
        let meaning = format!(
            "the smallest patches that count; they spread light over {:.1} mm: likeness {:.3} to that eye if all did",
            patch.its_spread_mm, patch.ssim_eye_if_all_spread
        );
        table.push(row("diffraction", format!("{:.3} mm", patch.smallest_patch_mm), meaning));
    }
    if let Some(miss) = facts.mirror_miss_mm.filter(|miss| *miss > 1.0) {
        table.push(row(
            "mirror point",
            format!("{miss:.0} mm"),
            "beside the picture's middle: tilt the plate to spare relief",
        ));
    }
    table
}
