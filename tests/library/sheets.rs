//! Whole sheets, small ones: their proofs stay below one and a half times what was measured when this was written.

use std::path::Path;

use facetmill::cutter::Cutter;
use facetmill::job::design::design;
use facetmill::job::preview::{Preview, preview};
use facetmill::job::proof::prove;
use facetmill::picture::read;
use facetmill::progress::Progress;
use facetmill::raster::Raster;
use facetmill::recipe::{Recipe, SurfaceKind};
use facetmill::verify::verdict::Verdict;

fn light_of(picture: &str, recipe: &Recipe) -> Raster {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/highlights/{picture}.png"));
    read(&path, &recipe.reading()).unwrap().light
}

/// TV counting lost light, and 1 - SSIM, both at 0.5°: of the sheet as milled if it is for a cutter, else as written.
fn scores(picture: &str, ball: Option<f64>) -> [f64; 2] {
    let mut recipe = Recipe::default();
    recipe.plate.surface = Some(SurfaceKind::Sheet);
    recipe.plate.cells = Some(1.into());
    recipe.plate.size = [10.0, 10.0];
    recipe.plate.grid = Some(96);
    recipe.design.sheet.cutter = ball.map(Cutter::ball);
    recipe.verify.rays = 1_000_000;
    let light = light_of(picture, &recipe);
    let plate = design(&recipe, &light, &Progress::silent()).unwrap();
    let proof = prove(&recipe, &light, &plate, &Progress::silent()).unwrap();
    let half = |verdict: &Verdict| [verdict.at(0.5).tv_incident.value, 1.0 - verdict.at(0.5).ssim.value];
    half(proof.milled.as_ref().map_or(&proof.verdict, |milled| &milled.verdict))
}

fn assert_near(picture: &str, ball: Option<f64>, measured: [f64; 2]) {
    let found = scores(picture, ball);
    let below = found.iter().zip(measured).all(|(found, measured)| *found < 1.5 * measured);
    assert!(below, "{picture}: {found:?}, and {measured:?} was measured");
}

#[test]
fn a_sheet_shows_a_portrait() {
    assert_near("portrait", None, [0.0041, 0.0030]);
}

#[test]
fn a_sheet_shows_a_ring() {
    assert_near("ring", None, [0.0041, 0.0046]);
}

#[test]
fn a_milled_sheet_shows_a_letter() {
    assert_near("letter", Some(1.0), [0.0099, 0.053]);
}

#[test]
fn a_preview_is_near_the_drawing_and_one_made_after_another_goes_on_from_it() {
    let mut recipe = Recipe::default();
    let light = light_of("portrait", &recipe);
    let look =
        |recipe: &Recipe, before: Option<&Preview>| preview(recipe, &light, before, &Progress::silent()).unwrap();
    let cold = look(&recipe, None);
    assert_eq!(cold.relief.nodes, 64);
    assert!(cold.scores[0].tv_incident < 0.003, "{:?}", cold.scores);
    recipe.light.theta = 10.0;
    let warm = look(&recipe, Some(&cold));
    assert!(warm.scores[0].tv_incident < 0.003, "{:?}", warm.scores);
    // The same again, and not what comes without one before.
    assert!(warm.relief.heights == look(&recipe, Some(&cold)).relief.heights);
    assert!(warm.relief.heights != look(&recipe, None).relief.heights);
}
