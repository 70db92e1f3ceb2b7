//! The facts of a design for people and machines, and a sentence of advice where one is due.

use std::f64::consts::PI;

use serde_json::{Map, Value, json};

use super::compare::FacetComparison;
use super::design::Design;
use super::proof::Proof;
use crate::distribution::SlopeDistribution;
use crate::export::stl::stl_bytes;
use crate::picture::Picture;
use crate::projection::View;
use crate::recipe::{Recipe, SurfaceKind};
use crate::sculpt::detail::Detail;
use crate::sculpt::stages::Sheet;
use crate::sharpen::{SCORED_AT, Sharpening, seen};
use crate::verify::verdict::Verdict;
use crate::verify::windows::Misplaced;

/// Everything that is known of a design, as the object that `report.json` holds. `proof` is absent if nothing was traced,
/// `comparison` if there was nothing to compare; a design of facets has one if a relief that was made first lost against it.
pub fn report(
    recipe: &Recipe,
    picture: &Picture,
    design: &Design,
    proof: Option<&Proof>,
    comparison: Option<&FacetComparison>,
) -> Value {
    let Design { distribution, relief, mesh, .. } = design;
    let steps = design.facets.as_ref().map(|facets| facets.steps);
    let (low, high) = relief.height_range();
    let pitch = design.sheet.as_ref().map_or_else(|| recipe.pitch(), |s| s.relief.step());
    let mean = distribution.mean;
    let normal = distribution.setup.plate_normal();
    let mut seconds: Map<String, Value> =
        design.seconds.iter().map(|(stage, s)| ((*stage).to_owned(), json!(s))).collect();
    seconds.insert("total".into(), json!(design.seconds.iter().map(|(_, s)| s).sum::<f64>()));
    let mut report = json!({
        "program": concat!("facetmill ", env!("CARGO_PKG_VERSION")),
        "picture": {
            "file": recipe.picture,
            "width": picture.original_size.0,
            "height": picture.original_size.1,
            "notes": picture.notes,
        },
        "recipe": recipe,
        "highlight": {
            "below_plate": design.below_plate,
            "beyond_cap": distribution.beyond_cap,
            "brightest_vs_white_paper": brightest_vs_white_paper(recipe, distribution),
        },
        "blur": {
            "light_radius_deg": recipe.light.radius,
            "lobe_deg": recipe.plate.lobe,
            "metal": recipe.metal(),
            "sharpening": design.sharpening.map(sharpening),
        },
        "design": {
            "surface": match comparison {
                Some(_) if design.sheet.is_none() => "facets: they are better here than the sheet was".into(),
                _ => recipe.why_this_surface(),
            },
            "pitch_mm": [pitch.x, pitch.y],
            "relief_height_mm": high - low,
            "mean_slope": [mean.p, mean.q],
            "mean_slope_deg": mean.tilt().to_degrees(),
            "mean_slope_costs_mm": mean_slope_costs(recipe, distribution),
            "slope_spread": distribution.spread,
            "mount_theta_deg": normal.z.min(1.0).acos().to_degrees(),
            "mount_phi_deg": if normal.z < 1.0 { normal.y.atan2(normal.x).to_degrees() } else { 0.0 },
            // A sheet has no steps, and no edges that could be counted as valleys.
            "step_rms_mm": steps.map_or(0.0, |s| s.rms),
            "step_rms_pitch": steps.map_or(0.0, |s| s.rms / pitch.min_element()),
            "wall_area_ratio": steps.map_or(0.0, |s| s.wall_area_ratio),
            "valleys": steps.map(|s| s.valleys),
            "inner_valleys": steps.map(|s| s.inner_valleys),
            "seconds": seconds,
        },
        "stl": {
            "units": "mm",
            "triangles": mesh.triangles.len(),
            "bytes": stl_bytes(mesh.triangles.len()),
            "z_base_mm": low - recipe.plate.thickness,
            "z_low_mm": low,
            "z_high_mm": high,
        },
    });
    if let Some(sheet) = &design.sheet {
        report["design"]["continuous"] = continuous(recipe, design, sheet);
    }
    if let Some(proof) = proof {
        report["designed"] = proof.verdict.to_json();
        if let Some(sheet) = &proof.sheet {
            let misplaced = |m: Misplaced| json!({ "mean": m.mean, "largest": m.largest });
            report["windows_tv_1deg"] = json!({
                "one_cell": misplaced(sheet.windows.cell),
                "half_cell": misplaced(sheet.windows.half_cell),
            });
            report["diffraction"] = json!({
                "smallest_patch_mm": sheet.detail.map(Detail::patch),
                "its_blur_deg": sheet.detail.map(Detail::blur),
                "share_beyond_1deg": sheet.diffracted,
            });
        }
        if let Some(milled) = &proof.milled {
            report["as_milled"] = milled.verdict.to_json();
            report["as_milled"]["left_by_cutter_um"] = json!(1000.0 * milled.left);
        }
    }
    if let Some(FacetComparison { facets, flat, continuous, milled }) = comparison {
        report["beside_facets"] = json!({
            "facets": facets,
            "as_milled": milled,
            "tv_incident_1deg": { "flat": flat.misplaced, "continuous": continuous.misplaced },
            "ssim_1deg": { "flat": flat.ssim, "continuous": continuous.ssim },
        });
    }
    let mut advice = advice(recipe, design, proof.map(|p| &p.verdict));
    advice.extend(comparison.filter(|c| c.facets_are_better()).map(|c| facets_are_better(recipe, design, c)));
    report["advice"] = json!(advice);
    report
}

/// What sharpening the light against lamp and metal is worth, as far as the light is as wanted.
fn sharpening(worth: Sharpening) -> Value {
    let at_judge = |value: f64| -> Value { Map::from_iter([(SCORED_AT.to_string(), json!(value))]).into() };
    json!({ "tv_without": at_judge(worth.before), "tv_with": at_judge(worth.after), "steps": worth.steps })
}

/// The facts of a sheet.
fn continuous(recipe: &Recipe, design: &Design, sheet: &Sheet) -> Value {
    let relief = &sheet.relief;
    json!({
        "grid": relief.nodes,
        "cells": relief.cells,
        "cell_mm": relief.cell.to_array(),
        "cutter": recipe.design.cutter,
        "start": sheet.start,
        "misplaced_by_stage": sheet.misplaced,
        "fillet_share": sheet.fillets,
        "least_stray": design.least_stray.map(|stray| json!({
            "share": stray.share,
            "gap_deg": stray.gap.map(|s| s.atan().to_degrees()),
            "along_cells": stray.along,
        })),
        "depth_mm": relief.depth(),
        "stopped_early": sheet.stopped_early().map(|[done, all]| json!({ "steps_done": done, "steps": all })),
    })
}

/// Height that the mean slope alone costs from corner to corner, mm.
fn mean_slope_costs(recipe: &Recipe, distribution: &SlopeDistribution) -> f64 {
    let [x, y] = recipe.plate.size;
    distribution.mean.p.abs() * x + distribution.mean.q.abs() * y
}

/// How many times as bright as white paper under the same lamp the highlight's brightest spot looks.
///
/// The drawing fixes the highlight only up to a factor, and the plate's area fixes that factor (∫ p ds = 1): white
/// paper of albedo 1 sends E cosθi / π everywhere, a pixel that gets the share f of all flux f E cosθi / (cosθo dω).
fn brightest_vs_white_paper(recipe: &Recipe, distribution: &SlopeDistribution) -> f64 {
    let blurred = recipe.blur(&distribution.setup).map(|blur| seen(&distribution.flux, &blur));
    let flux = blurred.as_ref().unwrap_or(&distribution.flux);
    let pixel = 4.0 / (flux.width * flux.height) as f64;
    let ratios = flux.values.iter().enumerate().filter(|(_, f)| **f > 0.0).filter_map(|(k, f)| {
        let uv = View::pixel_centre(k % flux.width, k / flux.width, flux.width, flux.height);
        let o = distribution.setup.viewer_at(uv)?;
        let foreshortened = o.z * pixel * distribution.setup.view().solid_angle_density(uv);
        (foreshortened > 0.0).then_some(PI * f / foreshortened)
    });
    ratios.fold(0.0, f64::max)
}

/// That flat facets are better than a sheet, and what follows.
fn facets_are_better(recipe: &Recipe, design: &Design, comparison: &FacetComparison) -> String {
    let FacetComparison { facets: [columns, rows], flat, continuous, milled } = comparison;
    let figures = format!(
        "{columns}x{rows} of them misplace {:.2}% of the light at a blur of 1°{}, the sheet {:.2}%",
        100.0 * flat.misplaced,
        if *milled { " once cut" } else { "" },
        100.0 * continuous.misplaced
    );
    let Some(sheet) = &design.sheet else {
        return format!("Flat facets were made, since {figures}: --surface continuous makes the relief all the same.");
    };
    let remedies = [
        (sheet.stopped_early().is_some(), "let the design come to its end"),
        (recipe.design.max_depth.is_some(), "raise --max-depth"),
        (recipe.design.min_feature > 0.0, "lower --min-feature"),
        (recipe.plate.grid.is_some(), "raise --grid"),
        (recipe.plate.max_triangles.is_some(), "raise --max-triangles"),
        (recipe.design.cutter.is_some(), "take a smaller cutter"),
    ];
    let remedies: String = remedies.iter().filter(|(helps, _)| *helps).map(|(_, what)| format!("{what}, ")).collect();
    format!("Flat facets would do better, since {figures}: {remedies}or take --surface flat.")
}

/// What a person should know when something is off; empty when nothing is.
pub fn advice(recipe: &Recipe, design: &Design, verdict: Option<&Verdict>) -> Vec<String> {
    let mut advice = Vec::new();
    let mut say = |sentence: String| advice.push(sentence);
    let percent = |share: f64| format!("{:.1}%", 100.0 * share);
    if design.below_plate > 0.001 {
        let lost = percent(design.below_plate);
        say(format!(
            "{lost} of the picture's light lies below the plate and was left out: lower the light's angle or --half-field."
        ));
    }
    if design.distribution.beyond_cap > 0.001 {
        let (lost, cap) = (percent(design.distribution.beyond_cap), recipe.design.distribution.slope_cap);
        say(format!(
            "{lost} of the highlight needs facets steeper than {cap}° and was cut: raise --slope-cap or lower --half-field."
        ));
    }
    let costs = mean_slope_costs(recipe, &design.distribution);
    let (low, high) = design.relief.height_range();
    if costs > 0.5 && costs > 0.5 * (high - low) {
        if design.sheet.is_none() && recipe.heights().is_cyclic() {
            say("The highlight is off centre and the arrangement is cyclic, so its mean slope stands in walls: add --level.".into());
        } else {
            say(format!(
                "The highlight is off centre, which tilts the whole relief by {costs:.1} mm: --level mounts the plate at {:.1}° instead.",
                design.distribution.mean.tilt().to_degrees()
            ));
        }
    }
    if recipe.surface() == SurfaceKind::Sheet && recipe.design.cutter.is_none() {
        say("No cutter was named, so valleys are as sharp as triangles: --for-cutter ball:0.5 shapes the relief for a mill.".into());
    }
    if let Some(verdict) = verdict {
        let tv = verdict.main().tv.value;
        let blurred = design.sharpening.map_or(0.0, |worth| worth.after);
        if blurred > 0.05 {
            say(format!(
                "Lamp and metal blur the picture by more than light can be sharpened (TV {blurred:.3} at {SCORED_AT}°): a smaller lamp, better polish, or a picture of coarser detail or larger --half-field."
            ));
        } else if tv > 0.05 && design.sheet.is_none() {
            let [columns, rows] = recipe.facets();
            say(format!(
                "The picture has more detail than {columns}x{rows} facets can show at a blur of 1° (TV {tv:.3}): try --facets {}x{}.",
                2 * columns,
                2 * rows
            ));
        }
        if verdict.blocked.value + verdict.multi_bounce.value > 0.02 && design.sheet.is_none() {
            say(format!(
                "{} of the light is blocked and {} bounces twice, on walls and valleys: --arrange transport has the fewest.",
                percent(verdict.blocked.value),
                percent(verdict.multi_bounce.value)
            ));
        }
    }
    advice
}
