//! What a person is told of a wall nearby.

use facetmill::report::made::MadeFacts;
use facetmill::report::on_wall::{OnWallFacts, WallScores};

use crate::rows::{Row, percent, row, told};

/// With more of its light misplaced a picture on a wall is not called sharp.
const FOCUSED: f64 = 0.05;

/// The light on a wall nearby, and where that may stand.
pub fn on_wall_in_short(facts: &OnWallFacts, made: Option<&MadeFacts>) -> Vec<Row> {
    let in_a_line = |short: &str, [_, value, meaning]: Row| told(short, format!("{value} {meaning}"));
    let mut rows = vec![in_a_line("wall", light("on the wall", facts, &facts.designed))];
    rows.extend(facts.as_milled.iter().map(|milled| in_a_line("as milled", light("  as milled", facts, milled))));
    rows.extend(made_on_wall(facts, made).map(|row| in_a_line("as made", row)));
    rows.extend(in_focus(facts).map(|row| in_a_line("in focus", row)));
    rows
}

fn metres(mm: f64) -> String {
    format!("{:.2} m", 1e-3 * mm)
}

/// What an eye sees of the light on the wall.
fn light(name: &str, facts: &OnWallFacts, scores: &WallScores) -> Row {
    let figure = |name: &str| scores.tv_incident.get(name).unwrap_or(f64::NAN);
    let meaning = format!(
        "misplaced on the wall at a blur of 0.5°; {} to an eye {} away, likeness {:.3}",
        percent(figure("eye")),
        metres(facts.eye_distance_mm),
        scores.ssim.get("eye").unwrap_or(f64::NAN)
    );
    row(name, percent(figure("0.5deg")), meaning)
}

/// Where the wall may stand; none for a picture that is not there, which is in focus nowhere.
fn in_focus(facts: &OnWallFacts) -> Option<Row> {
    let limit = facts.in_focus_tv.filter(|limit| *limit <= FOCUSED)?;
    let [nearest, farthest] = facts.in_focus_mm?;
    let ends = match (nearest.map(metres), farthest.map(metres)) {
        (Some(near), Some(far)) => format!("{near} to {far}"),
        (Some(near), None) => format!("{near} or more"),
        (None, Some(far)) => format!("up to {far}"),
        (None, None) => "anywhere".into(),
    };
    let meaning = format!("where the wall may stand, the lamp as it is: up to {} misplaced", percent(limit));
    Some(row("in focus", ends, meaning))
}

/// What an eye sees of the light of the plate as made.
fn made_on_wall(facts: &OnWallFacts, made: Option<&MadeFacts>) -> Option<Row> {
    made.and_then(|made| made.on_wall.as_ref()).map(|scores| light("  as made", facts, scores))
}

/// A plate in its room, as a machine makes it too if one does.
pub fn on_wall(facts: &OnWallFacts, made: Option<&MadeFacts>) -> Vec<Row> {
    let mut table = vec![
        row("lamp", facts.lamp_distance_mm.map_or("far".into(), metres), facts.lamp.clone()),
        row("wall", metres(facts.wall_distance_mm), facts.wall.clone()),
        light("on the wall", facts, &facts.designed),
    ];
    table.extend(facts.as_milled.iter().map(|milled| light("  as milled", facts, milled)));
    table.extend(made_on_wall(facts, made));
    table.push(row("grain", percent(facts.designed.grain), "of the drawing's light, seen by that eye and not at 0.5°"));
    table.extend(in_focus(facts));
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
