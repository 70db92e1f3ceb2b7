//! The tables that a person sees, made from the reports.

use std::path::Path;

use facetmill::job::pictures::rays;
use facetmill::memory::said;
use facetmill::milling::polish::in_words;
use facetmill::recipe::{BorderFinish, Recipe};
use facetmill::report::design::{DesignReport, PlateFacts};
use facetmill::report::estimate::{EstimateReport, Parts};
use facetmill::report::goal::GoalFacts;
use facetmill::report::made::{MachiningFacts, MadeFacts};
use facetmill::report::scores::Scores;
use facetmill::report::thinned::ThinnedFacts;
use facetmill::report::verify::VerifyReport;
use facetmill::report::{MeshFacts, Named};
use facetmill::sharpen::SCORED_AT;
use facetmill::verify::verdict::{BLURS, MAIN_BLUR};

pub use crate::rows::{Row, percent, row, told};
use crate::wall_tables::{on_wall, on_wall_in_short};

/// A design that was written into `folder`, in five lines.
pub fn design_in_short(folder: &Path, report: &DesignReport) -> Vec<Row> {
    let PlateFacts { mount, relief_height_mm, .. } = &report.design;
    let [width, height] = report.recipe.plate.size;
    let stock = report.stl.z_high_mm - report.stl.z_base_mm;
    // What shows as 0.00° is level.
    let mounted = match mount.theta >= 0.005 {
        true => format!("; mounted tilted by {:.2}° toward azimuth {:.1}°", mount.theta, mount.phi),
        false => String::new(),
    };
    let made_of = report.made_of();
    let mut rows = vec![
        told("plate", format!("{width} × {height} mm of {made_of}, relief {relief_height_mm:.3} mm")),
        told("stock", format!("{stock:.2} mm thick{mounted}")),
    ];
    let milled = report.as_milled.as_ref().map(|milled| (&milled.scores, "comparison_milled.png"));
    let made = report.as_made.as_ref().map(|made| (&made.scores, "comparison_made.png"));
    let scored = made.or(milled).or(report.designed.as_ref().map(|scores| (scores, "comparison.png")));
    rows.extend(scored.map(|(scores, _)| light(scores)));
    rows.extend(report.as_made.as_ref().map(made_in_short));
    rows.extend(report.on_wall.iter().flat_map(|facts| on_wall_in_short(facts, report.as_made.as_ref())));
    rows.extend(report.goal.iter().filter_map(goal_in_short));
    rows.push(told("file", file(folder, report)));
    let picture = scored.map_or("relief.png", |(_, picture)| picture);
    rows.push(told("look", format!("at {} first; --verbose tells more", shown(&folder.join(picture)))));
    rows
}

/// How it is made.
fn made_in_short(made: &MadeFacts) -> Row {
    let MachiningFacts { machine, cutter, stepover_mm, pass_angle_deg, polish_mm, .. } = &made.machining;
    let polish = in_words(*polish_mm);
    let along = if *pass_angle_deg == 0.0 { String::new() } else { format!(" at {pass_angle_deg:.0}°") };
    let passes = format!("{} with {cutter}, passes {stepover_mm} mm apart{along}", machine.name);
    told("made", format!("by {passes}, {:.1} h at {} mm/min; {polish}", made.finishing_hours, machine.feed))
}

/// The plate's file and its size.
fn file(folder: &Path, report: &DesignReport) -> String {
    let (triangles, megabytes) = (report.stl.triangles, report.stl.bytes as f64 / 1e6);
    let file = format!("{}, {triangles} triangles, {megabytes:.1} MB", shown(&folder.join("plate.stl")));
    if let Some(ThinnedFacts {
        whole_bytes, tv_incident_1deg_of_whole: whole, tv_incident_1deg_of_this: this, ..
    }) = report.stl.thinned
    {
        let (whole, this) = (percent(whole), percent(this));
        let (most, way) = match report.recipe.plate.max_triangles {
            Some(_) => ("as many triangles as asked", "without --max-triangles and with --fine"),
            None => ("as few triangles as keep its light", "with --fine"),
        };
        let full = whole_bytes as f64 / 1e6;
        return format!("{file}, {most}: {this} misplaced in place of {whole} {way} in {full:.0} MB");
    }
    let Some(lighter) = &report.stl.lighter else { return file };
    let flag = match report.recipe.plate.grid {
        Some(_) => format!("--grid {}", lighter.grid),
        None => format!("--max-triangles {}", lighter.triangles.next_multiple_of(10_000)),
    };
    let (smaller, light) = (lighter.bytes as f64 / 1e6, percent(lighter.tv_incident_1deg));
    let now = percent(lighter.tv_incident_1deg_of_this);
    format!("{file}: heavy for CAM; {flag} gives {smaller:.0} MB and about {light} misplaced in place of {now}")
}

/// How near the light is to the drawing.
pub fn light(scores: &Scores) -> Row {
    let sharp = BLURS[0].to_string();
    let at = |figures: &Named, blur: &str| figures.get(blur).unwrap_or(f64::NAN);
    let main = MAIN_BLUR.to_string();
    let pair = |blur: &str| {
        format!("{} misplaced, likeness {:.3}", percent(at(&scores.tv_incident, blur)), at(&scores.ssim, blur))
    };
    told("light", format!("{} at a blur of {main}°; {} at {sharp}°", pair(&main), pair(&sharp)))
}

/// A mesh that was scored against a picture, in a few lines; `folder` holds the pictures, if they are wanted.
pub fn verify_in_short(folder: Option<&Path>, report: &VerifyReport) -> Vec<Row> {
    let MeshFacts { size_mm: [width, height, _], relief_height_mm, triangles, .. } = report.plate;
    let scores = &report.measured;
    let lost = format!(
        "{} blocked, {} bounced more than once, {} past the picture",
        percent(scores.blocked),
        percent(scores.multi_bounce),
        percent(scores.outside_image)
    );
    let milled = report.as_milled.as_ref().map_or((scores, "comparison.png"), |m| (&m.scores, "comparison_milled.png"));
    let (scored, picture) = report.as_made.as_ref().map_or(milled, |made| (&made.scores, "comparison_made.png"));
    let look = match folder {
        Some(folder) => format!("at {} first; --verbose tells more", shown(&folder.join(picture))),
        None => "with -o DIR there are pictures; --verbose tells more".into(),
    };
    let mut rows = vec![
        told("plate", format!("{width:.2} × {height:.2} mm of {triangles} triangles, relief {relief_height_mm:.3} mm")),
        light(scored),
        told("lost", lost),
    ];
    rows.extend(report.on_wall.iter().flat_map(|facts| on_wall_in_short(facts, report.as_made.as_ref())));
    rows.extend(report.goal.iter().filter_map(goal_in_short));
    rows.push(told("look", look));
    rows
}

/// How near a plate, as cut if it has a cutter, is to its goal.
fn goal_in_short(facts: &GoalFacts) -> Option<Row> {
    let verdict = facts.as_milled.as_ref().map(|milled| &milled.verdict).or(facts.verdict.as_ref())?;
    Some(told("goal", verdict.clone()))
}

/// A goal and the plate beside it.
fn goal(facts: &GoalFacts) -> Vec<Row> {
    let mut rows = vec![told("goal", format!("{}, albedo {:.3}", facts.spec, facts.albedo))];
    for (k, slice) in facts.slices.iter().enumerate() {
        let meaning = format!(
            "misplaced under a lamp at {}°, {:.0}°: {} by what no mirrors can follow, {} by the rest; albedo {:.3} of {:.3}",
            slice.theta,
            slice.phi,
            percent(slice.mirrors_cannot),
            percent(slice.rest.value),
            slice.albedo_plate,
            slice.albedo_goal
        );
        rows.push(row("  of its light", percent(slice.tv_1deg.value), meaning));
        if let Some(cut) = facts.as_milled.as_ref().and_then(|milled| milled.slices.get(k)) {
            let meaning = format!("as cut: {} by the rest; albedo {:.3}", percent(cut.rest.value), cut.albedo_plate);
            rows.push(row("  as milled", percent(cut.tv_1deg.value), meaning));
        }
    }
    rows
}

/// A path, as it is told.
pub fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// A design that was written.
pub fn design(report: &DesignReport) -> Vec<Row> {
    let mut table = plate(report);
    table.extend(report.designed.iter().flat_map(scores));
    if let (Some(windows), Some(diffraction)) = (&report.windows_tv_1deg, &report.diffraction) {
        let half = 100.0 * windows.half_cell.mean;
        let meaning = format!("misplaced, anywhere on the plate; half a cell: {half:.0} %");
        table.push(row("window of a cell", percent(windows.one_cell.largest), meaning));
        let meaning = "of the light comes from patches that diffract it by more than 1°";
        table.push(row("small mirrors", percent(diffraction.share_beyond_1deg), meaning));
    }
    if let Some(holds) = &report.holds_beyond {
        let meaning = format!(
            "lamp and wall each; under the sun the wall {:.0} m; for nearer ones give --lamp-distance and --wall",
            1e-3 * holds.wall_under_sun_mm
        );
        table.push(row("holds beyond", format!("{:.0} m", 1e-3 * holds.lamp_and_wall_mm), meaning));
    }
    table.extend(report.on_wall.iter().flat_map(|facts| on_wall(facts, report.as_made.as_ref())));
    table.extend(report.goal.iter().flat_map(goal));
    if let Some(milled) = &report.as_milled {
        let left = format!("{:.2} µm", milled.left_by_cutter_um);
        table.push(row("left by cutter", left, "at the most, above the written surface"));
        let scores = &milled.scores;
        let likeness = format!("likeness {:.3}", Scores::main(&scores.ssim));
        table.push(row("misplaced as milled", percent(Scores::main(&scores.tv_incident)), likeness));
    }
    table.extend(report.as_made.iter().flat_map(made));
    if let Some(beside) = &report.beside_facets {
        let ([across, up], tv) = (beside.facets, beside.tv_incident_1deg);
        let (other, misplaced, what) = match report.design.continuous {
            Some(_) => ("flat facets", tv.flat, format!("{across} × {up} of them")),
            None => ("sheet", tv.continuous, "one sheet".into()),
        };
        let how = if beside.as_milled { ", milled alike" } else { "" };
        table.push(row(other, percent(misplaced), format!("misplaced by {what} instead{how}")));
    }
    if let Some(near) = &report.design.near {
        let focus = format!("{:.0} mm", near.focus_mm);
        let sag = report.on_wall.as_ref().map_or(String::new(), |wall| format!(", {:.3} mm deep", wall.sag_mm));
        table.push(row("focal length", focus, format!("of the bowl{sag}: 1/f = 1/lamp + 1/wall")));
        let method = near.method.split(':').next().unwrap_or_default();
        table.push(row("lamp and wall", method, near.method.split_once(": ").map_or("", |(_, why)| why)));
    }
    if let Some(stopped) = report.design.continuous.as_ref().and_then(|sheet| sheet.stopped_early) {
        let steps = format!("{} of {}", stopped.steps_done, stopped.steps);
        table.push(row("stopped early", steps, "steps of the design were done"));
    }
    let cpu = report.design.seconds.get("total").unwrap_or(0.0);
    table.push(row("design", format!("{cpu:.2} s"), "of CPU time, before tracing"));
    table
}

/// The plate itself, before light is sent over it.
fn plate(report: &DesignReport) -> Vec<Row> {
    let PlateFacts { pitch_mm: [x, y], mount, relief_height_mm, step_rms_mm, .. } = &report.design;
    let [width, height] = report.recipe.plate.size;
    let each = if report.design.continuous.is_some() { "nodes every" } else { "each" };
    let meaning = format!("of {}, {each} {x:.3} × {y:.3} mm", report.made_of());
    let mut table = vec![
        row("plate", format!("{width} × {height} mm"), meaning),
        row("relief", format!("{relief_height_mm:.3} mm"), "from its lowest to its highest point"),
    ];
    if let Some(valleys) = report.design.inner_valleys {
        let steps = format!("{step_rms_mm:.4} mm");
        table.push(row("steps", steps, "between neighbours, root mean square; 0 is seamless"));
        let meaning = "edges inside the plate where a cutter leaves its radius";
        table.push(row("valleys", valleys.to_string(), meaning));
    }
    if mount.theta > 0.0 {
        let meaning = format!("tilted so, its normal toward azimuth {:.1}°", mount.phi);
        table.push(row("mount", format!("{:.2}°", mount.theta), meaning));
    }
    if let Some(rim) = &report.rim {
        let meaning = match rim.finish {
            BorderFinish::Matt => "left dull, counted as dark".to_owned(),
            BorderFinish::Polished | BorderFinish::Sloped(_) => {
                let (slope, share) = (rim.slope_deg, rim.into_picture.map(percent));
                let thrown = share.map(|share| format!(", throws {share} of the relief's light into the picture"));
                let how = if slope > 0.0 { format!("falls outward by {slope:.2}°") } else { "polished".into() };
                how + &thrown.unwrap_or_default()
            }
        };
        table.push(row("rim", format!("{} mm", rim.width_mm), meaning));
    }
    if let Some(worth) = &report.blur.sharpening {
        let at = |figures: &Named| figures.get(&SCORED_AT.to_string()).unwrap_or(f64::NAN);
        let without = 100.0 * at(&worth.tv_without);
        let meaning = format!("misplaced by lamp and metal, seen at {SCORED_AT}°; {without:.2} % if not sharpened");
        table.push(row("blur (TV)", percent(at(&worth.tv_with)), meaning));
    }
    table
}

/// What a design of `recipe` would be.
pub fn estimate(recipe: &Recipe, report: &EstimateReport) -> Vec<Row> {
    let ([width, height], [x, y]) = (report.plate_mm, report.pitch_mm);
    let pieces = match report.parts {
        Parts::Facets { .. } => {
            let [columns, rows] = recipe.facets();
            row("facets", format!("{columns} × {rows}"), format!("each {x:.3} × {y:.3} mm"))
        }
        Parts::Sheet { grid, cells: [across, up] } => {
            row("cells", format!("{across} × {up}"), format!("of {grid} × {grid} nodes"))
        }
        Parts::Patches { grid, patches: [across, up] } => {
            row("patches", format!("{across} × {up}"), format!("of {grid} × {grid} nodes"))
        }
    };
    let about = |seconds: f64| format!("about {seconds:.1} s");
    let proof = report.verify_cpu_seconds_about;
    let sent = if proof > 0.0 { format!("for {} rays", rays(recipe.verify.rays)) } else { "not asked for".into() };
    let megabytes = format!("about {:.1} MB", report.stl_bytes_about as f64 / 1e6);
    let mut table = vec![
        row("plate", format!("{width} × {height} mm"), "with its rim"),
        pieces,
        row("plate.stl", megabytes, format!("{} triangles", report.stl_triangles_about)),
        row("design", about(report.design_cpu_seconds_about), "of CPU time"),
        row("proof", about(proof), sent),
        row("files", about(report.files_cpu_seconds_about), "mostly for pictures"),
        row("time", about(report.wall_seconds_about), on_machine(report)),
        row("memory", format!("about {}", said(report.memory_bytes_about)), "at once, at the most"),
    ];
    if report.comparison_cpu_seconds_about > 0.0 {
        let more = about(report.comparison_cpu_seconds_about);
        table.push(row("comparison", more, "of CPU time more, if over 0.5 % goes astray: with facets"));
    }
    if let Some(share) = report.least_stray_share {
        let meaning = "of the light at least falls into gaps of the drawing, since the ball must turn there";
        table.push(row("straying", percent(share), meaning));
    }
    table
}

/// On what the time was told.
fn on_machine(report: &EstimateReport) -> String {
    let threads = if report.threads == 1 { "1 thread".into() } else { format!("{} threads", report.threads) };
    format!("on {threads} with nothing beside; {:.1} CPU s in all", report.cpu_seconds())
}

/// A mesh that was scored against a picture.
pub fn verify(report: &VerifyReport) -> Vec<Row> {
    let plate = &report.plate;
    let [width, height, _] = plate.size_mm;
    let relief = format!("{:.3} mm", plate.relief_height_mm);
    let mut table = vec![
        row("plate", format!("{width:.2} × {height:.2} mm"), format!("of {} triangles", plate.triangles)),
        row("relief", relief, "from its lowest to its highest point"),
    ];
    table.extend(scores(&report.measured));
    table.extend(report.on_wall.iter().flat_map(|facts| on_wall(facts, report.as_made.as_ref())));
    table.extend(report.goal.iter().flat_map(goal));
    if let Some(milled) = &report.as_milled {
        let likeness = format!("likeness {:.3}", Scores::main(&milled.scores.ssim));
        table.push(row("misplaced as milled", percent(Scores::main(&milled.scores.tv_incident)), likeness));
    }
    table.extend(report.as_made.iter().flat_map(made));
    if let Some(allowed) = &report.at_most {
        let kept = if allowed.kept { "kept" } else { "not kept" };
        let limit = format!("at most {} at a blur of {}°: {kept}", percent(allowed.share), allowed.blur_deg);
        table.push(row("allowed", percent(allowed.tv_incident), limit));
    }
    table
}

/// A plate as a machine makes it.
fn made(made: &MadeFacts) -> Vec<Row> {
    let mut table = Vec::new();
    let likeness = format!("likeness {:.3}", Scores::main(&made.scores.ssim));
    table.push(row("misplaced as made", percent(Scores::main(&made.scores.tv_incident)), likeness));
    if let [_, .., last] = made.tv_incident_1deg_by_draw.as_slice() {
        let draws = &made.tv_incident_1deg_by_draw;
        let [low, high] = draws.iter().fold([*last; 2], |[low, high], v| [low.min(*v), high.max(*v)]);
        let from = format!("{} to {}", percent(low), percent(high));
        table.push(row("other plates", from, format!("misplaced on {} plates made alike", draws.len())));
    }
    let MachiningFacts { machine, stepover_mm, cusp_height_um, .. } = &made.machining;
    let cusps = format!("between passes {stepover_mm} mm apart, before any polish");
    table.push(row("cusps", format!("{cusp_height_um:.3} µm"), cusps));
    table.push(row("false spot", percent(made.central_spot), "of the light goes where a level plate throws it"));
    let finishing =
        format!("of passes by {} at {} mm/min; mill tells what lifts and corners add", machine.name, machine.feed);
    table.push(row("time", format!("{:.2} h", made.finishing_hours), finishing));
    table
}

/// The figures of a highlight against its drawing.
pub fn scores(scores: &Scores) -> Vec<Row> {
    let error = 100.0 * Scores::main(&scores.error.tv_incident);
    let likeness = format!("{:.3}", Scores::main(&scores.ssim));
    vec![
        row("rays", rays(scores.rays), format!("traced; the highlight is scored through a blur of {MAIN_BLUR}°")),
        row(
            "misplaced (TV)",
            percent(Scores::main(&scores.tv_incident)),
            format!("of the light falls in the wrong place or is lost (± {error:.2}); 0 is perfect"),
        ),
        row("likeness (SSIM)", likeness, "to the drawing; 1 is the same picture"),
        row("shift (W1)", format!("{:.2}°", scores.w1_deg), "that light must move on average to be the drawing"),
        row("efficiency", percent(scores.efficiency), "of the light lands where the drawing is lit"),
        row("bounced twice", percent(scores.multi_bounce), "of what leaves the plate has met it more than once"),
        row("blocked", percent(scores.blocked), "of the light never leaves the plate upward"),
    ]
}
