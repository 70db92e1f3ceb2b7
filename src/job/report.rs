//! The report of a design, filled in from what the job knows.

use std::f64::consts::PI;

use super::advice::{about_base, about_rim, advice, facets_are_better, lamp_in_the_beam, mean_slope_costs, no_plate};
use super::compare::FacetComparison;
use super::design::Design;
use super::findings::{MadeProof, MilledProof, Proof, SheetProof};
use super::lighter::{Lighter, lighter};
use super::near::NearDesign;
use super::product::Product;
use super::sentences::in_a_sentence;
use super::thinning::Thinning;
use crate::distribution::SlopeDistribution;
use crate::export::stl::stl_bytes;
use crate::picture::Picture;
use crate::projection::View;
use crate::recipe::Recipe;
use crate::report::design::*;
use crate::report::thinned::ThinnedFacts;
use crate::report::{Named, PROGRAM, PictureFacts};
use crate::sculpt::detail::Detail;
use crate::sculpt::stages::Sheet;
use crate::sharpen::{SCORED_AT, Sharpening, seen};
use crate::verify::windows::Misplaced;

/// Blur by the plate's own size up to which the figures of a far design hold, radians.
const MOST_BLUR: f64 = 0.005;

impl Product {
    /// Everything that is known of it, which was made for `picture`, as `report.json` holds it.
    pub fn report(&self, picture: &Picture) -> DesignReport {
        report(self, picture)
    }
}

fn report(product: &Product, picture: &Picture) -> DesignReport {
    let Product { recipe, design, proof, comparison, .. } = product;
    let heights = design.relief.optical_heights();
    let distribution = &design.distribution;
    let verdict = proof.as_ref().map(|proof| &proof.verdict);
    let sheet_proof = proof.as_ref().and_then(|proof| proof.sheet.as_ref());
    let milled = proof.as_ref().and_then(|proof| proof.milled.as_ref());
    let mut said = advice(recipe, design, verdict);
    said.extend(proof.as_ref().and_then(|proof| about_rim(recipe, proof.rim.as_ref()?)));
    said.extend(proof.as_ref().and_then(|proof| lamp_in_the_beam(proof.wall.as_ref()?)));
    said.extend(comparison.filter(|c| c.facets_are_better()).map(|c| facets_are_better(recipe, design, &c)));
    said.extend(recipe.design.sheet.preview.then(no_plate));
    said.extend(product.goal.as_ref().and_then(|goal| about_base(&goal.facts)));
    DesignReport {
        program: PROGRAM,
        picture: PictureFacts::new(picture, recipe.picture_path().map(|path| path.to_string_lossy().into_owned())),
        recipe: recipe.clone(),
        highlight: HighlightFacts {
            below_plate: design.below_plate,
            beyond_cap: distribution.beyond_cap,
            brightest_vs_white_paper: brightest_vs_white_paper(recipe, distribution),
        },
        blur: BlurFacts {
            light_radius_deg: recipe.light.radius,
            lobe_deg: recipe.plate.lobe,
            metal: recipe.metal(),
            sharpening: design.sharpening.map(sharpening),
        },
        design: plate(recipe, design, comparison.as_ref(), heights.1 - heights.0),
        holds_beyond: (!recipe.is_near()).then(|| holds_beyond(recipe)),
        on_wall: proof.as_ref().and_then(|proof| proof.wall.as_ref()).map(|wall| wall.facts(recipe)),
        rim: product.about_rim().map(|for_the_shop| rim(product, for_the_shop)),
        stl: stl(product, heights),
        designed: verdict.map(Into::into),
        windows_tv_1deg: sheet_proof.map(windows),
        diffraction: sheet_proof.map(diffraction),
        as_milled: milled.map(as_milled),
        goal: product.goal.as_ref().map(|goal| goal.facts.clone()),
        as_made: proof.as_ref().and_then(|proof| proof.made.as_ref()).map(MadeProof::facts),
        beside_facets: comparison.as_ref().map(beside_facets),
        verdict: proof.as_ref().map(|proof| one_sentence(recipe, proof)),
        advice: said,
    }
}

/// How the light of the plate came out: as it is made, if that is known.
fn one_sentence(recipe: &Recipe, proof: &Proof) -> String {
    if let Some(made) = &proof.made {
        return in_a_sentence(&made.verdict, &format!("As {}", made.how()));
    }
    if recipe.design.sheet.preview {
        return in_a_sentence(&proof.verdict, "In this preview");
    }
    match (&proof.milled, recipe.design.sheet.cutter) {
        (Some(milled), Some(cutter)) => in_a_sentence(&milled.verdict, &format!("Cut by {cutter}")),
        (Some(milled), None) => in_a_sentence(&milled.verdict, "Polished"),
        (None, _) => in_a_sentence(&proof.verdict, ""),
    }
}

/// The plate itself.
fn plate(recipe: &Recipe, design: &Design, comparison: Option<&FacetComparison>, height: f64) -> PlateFacts {
    let Design { distribution, sheet, .. } = design;
    let steps = design.facets.as_ref().map(|facets| facets.steps);
    let pitch = sheet.as_ref().map_or_else(|| recipe.pitch(), |sheet| sheet.relief.step());
    let mean = distribution.mean;
    let normal = distribution.setup.plate_normal();
    let total = ("total", design.seconds.iter().map(|(_, s)| s).sum::<f64>());
    PlateFacts {
        surface: match comparison {
            Some(_) if sheet.is_none() => "facets: they are better here than the sheet was".into(),
            _ => recipe.why_this_surface(),
        },
        pitch_mm: pitch.to_array(),
        relief_height_mm: height,
        mean_slope: [mean.p, mean.q],
        mean_slope_deg: mean.tilt().to_degrees(),
        mean_slope_costs_mm: mean_slope_costs(recipe, distribution),
        slope_spread: distribution.spread,
        mount: Mount {
            theta: normal.z.min(1.0).acos().to_degrees(),
            phi: if normal.z < 1.0 { normal.y.atan2(normal.x).to_degrees() } else { 0.0 },
        },
        step_rms_mm: steps.map_or(0.0, |s| s.rms),
        step_rms_pitch: steps.map_or(0.0, |s| s.rms / pitch.min_element()),
        wall_area_ratio: steps.map_or(0.0, |s| s.wall_area_ratio),
        valleys: steps.map(|s| s.valleys),
        inner_valleys: steps.map(|s| s.inner_valleys),
        seconds: Named::from_iter(design.seconds.iter().copied().chain([total])),
        continuous: sheet.as_ref().map(|sheet| continuous(recipe, design, sheet)),
        near: design.near.as_ref().map(near),
    }
}

/// What is said of lamp and wall nearby.
fn near(near: &NearDesign) -> NearFacts {
    let scene = near.field.scene();
    let finite = |mm: f64| Some(mm).filter(|mm| mm.is_finite());
    NearFacts {
        method: near.why.clone(),
        lamp_distance_mm: finite(scene.lamp_distance()),
        wall_distance_mm: finite(scene.wall_distance()),
        focus_mm: scene.focal_length(),
        sag_mm: near.field.sag(),
        mirror_miss_mm: scene.mirror_miss(),
        miss_deg: near.miss,
        misplaced_by_stage: near.sheet.as_ref().map(|sheet| sheet.misplaced.clone()).unwrap_or_default(),
    }
}

/// What is said of a sheet alone.
fn continuous(recipe: &Recipe, design: &Design, sheet: &Sheet) -> SheetFacts {
    let relief = &sheet.relief;
    SheetFacts {
        grid: relief.nodes,
        preview: recipe.design.sheet.preview,
        cells: relief.cells,
        cell_mm: relief.cell.to_array(),
        cutter: recipe.design.sheet.cutter,
        start: sheet.start,
        misplaced_by_stage: sheet.misplaced.clone(),
        fillet_share: sheet.fillets,
        least_stray: design.least_stray.map(|stray| StrayFacts {
            share: stray.share,
            gap_deg: stray.gap.map(|s| s.atan().to_degrees()),
            along_cells: stray.along,
        }),
        depth_mm: relief.depth(),
        stopped_early: sheet.stopped_early().map(|[steps_done, steps]| StoppedEarly { steps_done, steps }),
    }
}

/// A plate S wide that knows neither lamp nor wall is blurred by S (1/a + 1/b): by 0.005 rad, the blur of a third of a
/// degree at which a picture of 40° begins to suffer, where both are 400 S away, or the wall 200 S under the sun.
fn holds_beyond(recipe: &Recipe) -> HoldsBeyond {
    let side = recipe.plate.size[0].max(recipe.plate.size[1]);
    HoldsBeyond { lamp_and_wall_mm: 2.0 * side / MOST_BLUR, wall_under_sun_mm: side / MOST_BLUR }
}

fn rim(product: &Product, for_the_shop: String) -> RimFacts {
    let Product { recipe, design, proof, .. } = product;
    let light = proof.as_ref().and_then(|proof| proof.rim.as_ref());
    let counted = |figure: f64| light.map(|rim| if rim.counts { figure } else { 0.0 });
    RimFacts {
        width_mm: recipe.plate.border,
        finish: recipe.border_finish(),
        slope_deg: recipe.rim(&design.distribution.setup).fall.atan().to_degrees(),
        for_the_shop,
        light_on_it: light.map(|rim| rim.lit),
        into_picture: light.and_then(|rim| counted(rim.into_picture.value)),
        into_picture_if_polished: light.map(|rim| rim.into_picture.value),
        error: light.map(|rim| rim.into_picture.error),
    }
}

fn stl(Product { recipe, design, proof, .. }: &Product, (low, high): (f64, f64)) -> StlFacts {
    let lowest = design.relief.height_range().0;
    let triangles = design.mesh.triangles.len();
    StlFacts {
        units: "mm",
        triangles,
        bytes: stl_bytes(triangles),
        z_base_mm: lowest - recipe.plate.thickness,
        z_low_mm: low,
        z_high_mm: high,
        thinned: design.thinning.as_ref().map(thinned_facts),
        lighter: proof.as_ref().and_then(|proof| lighter(recipe, design, &proof.target)).map(lighter_facts),
    }
}

fn thinned_facts(thinning: &Thinning) -> ThinnedFacts {
    let Thinning { full, misplaced: [of_this, of_whole], within_limits, .. } = *thinning;
    ThinnedFacts {
        whole_triangles: full,
        whole_bytes: stl_bytes(full),
        tv_incident_1deg_of_whole: of_whole,
        tv_incident_1deg_of_this: of_this,
        within_limits,
    }
}

fn lighter_facts(lighter: Lighter) -> LighterFacts {
    let Lighter { grid, triangles, bytes, misplaced: [of_it, of_this] } = lighter;
    LighterFacts { grid, triangles, bytes, tv_incident_1deg: of_it, tv_incident_1deg_of_this: of_this }
}

/// What sharpening the light against lamp and metal is worth, as far as the light is as wanted.
fn sharpening(worth: Sharpening) -> SharpeningFacts {
    let at_its_blur = |value: f64| Named::from_iter([(SCORED_AT, value)]);
    SharpeningFacts { tv_without: at_its_blur(worth.before), tv_with: at_its_blur(worth.after), steps: worth.steps }
}

fn windows(proof: &SheetProof) -> WindowFacts {
    let misplaced = |m: Misplaced| MisplacedFacts { mean: m.mean, largest: m.largest };
    WindowFacts { one_cell: misplaced(proof.windows.cell), half_cell: misplaced(proof.windows.half_cell) }
}

fn diffraction(proof: &SheetProof) -> DiffractionFacts {
    DiffractionFacts {
        smallest_patch_mm: proof.detail.map(Detail::patch),
        its_blur_deg: proof.detail.map(Detail::blur),
        share_beyond_1deg: proof.diffracted,
    }
}

fn as_milled(milled: &MilledProof) -> MilledFacts {
    MilledFacts { scores: (&milled.verdict).into(), left_by_cutter_um: 1000.0 * milled.left }
}

fn beside_facets(comparison: &FacetComparison) -> BesideFacets {
    let FacetComparison { facets, flat, continuous, milled } = *comparison;
    BesideFacets {
        facets,
        as_milled: milled,
        tv_incident_1deg: OfEither { flat: flat.misplaced, continuous: continuous.misplaced },
        ssim_1deg: OfEither { flat: flat.ssim, continuous: continuous.ssim },
    }
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
