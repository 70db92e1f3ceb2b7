//! What a person sees of a plate, pixel by pixel beside Mitsuba 3's own path tracer: no code in common.
//!
//! FACETMILL_PYTHON names a Python with mitsuba, numpy and trimesh. Where they are missing the test is skipped, visibly;
//! with FACETMILL_REQUIRE_CHECKERS=1 that is a failure. FACETMILL_LOOKS names a folder in which the pictures are left.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use facetmill::brdf::metals::Metal;
use facetmill::export::bsdf::{BsdfColour, BsdfSettings, write_bsdf};
use facetmill::export::pixels::{common_white, encode_png, tone_mapped};
use facetmill::export::stl::write_stl;
use facetmill::job::design::design;
use facetmill::job::patches::{Asked, design_patches};
use facetmill::lamp::Extent;
use facetmill::memory::MemoryLimit;
use facetmill::picture::read;
use facetmill::progress::Progress;
use facetmill::projection::{Projection, carried_axes};
use facetmill::raster::Raster;
use facetmill::recipe::Recipe;
use facetmill::relief::faceted::{Facet, FacetedRelief};
use facetmill::relief::open::NodeGrid;
use facetmill::setup::Setup;
use facetmill::slope::{Slope, direction};
use facetmill::trace::Surface;
use facetmill::trace::grid::GridSurface;
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::goniometer::sweep::sweep;
use facetmill::verify::goniometer::table::{BrdfAxes, BrdfTable};
use facetmill::verify::patch_view::PatchView;
use facetmill::verify::render::{RenderedView, Shape, ViewSettings, render};
use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use crate::asking;

/// Tells on the terminal itself, past the test harness, that nobody was asked.
#[allow(clippy::explicit_write, reason = "the harness hides what a passing test says with eprintln")]
fn say(what: &str) {
    writeln!(std::io::stderr(), "{what}").unwrap();
}

/// Mean and variance of every pixel as Mitsuba renders the scene, or why it cannot.
fn rendered(scene: &Value) -> Result<[Raster; 2], String> {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["scene.json", "seen.json"].map(|name| folder.path().join(name));
    std::fs::write(&input, scene.to_string()).unwrap();
    asking::ask("look_in_mitsuba.py", &[&input, &output])?;
    let seen: Value = serde_json::from_reader(File::open(output).unwrap()).unwrap();
    let [width, height] = [0, 1].map(|k| scene["size"][k].as_u64().unwrap() as usize);
    Ok(["mean", "variance"].map(|key| {
        let values = seen[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        Raster { width, height, values }
    }))
}

/// Camera and lamp of an experiment, as the scene of the script.
fn scene<S: Surface>(experiment: &Experiment<'_, S>, settings: &ViewSettings, target: DVec3, object: Value) -> Value {
    let toward = direction(settings.theta.to_radians(), settings.phi.to_radians());
    let mut scene = json!({
        "eye": (target + settings.distance * toward).to_array(), "target": target.to_array(),
        "up": carried_axes(toward).1.to_array(), "light_goes": (-experiment.setup.light()).to_array(),
        "field_of_view": settings.field_of_view, "size": settings.size,
        "bounces": settings.max_bounces, "passes": 16, "paths": 64,
    });
    scene.as_object_mut().unwrap().extend(object.as_object().unwrap().clone());
    scene
}

/// Leaves both pictures where the environment says, in the same tones.
fn keep(name: &str, ours: &Raster, theirs: &Raster) {
    if let Ok(folder) = std::env::var("FACETMILL_LOOKS") {
        for (whose, raster) in [("ours", ours), ("mitsuba", theirs)] {
            let png = encode_png(&tone_mapped(raster, common_white(ours))).unwrap();
            std::fs::write(Path::new(&folder).join(format!("{name}_{whose}.png")), png).unwrap();
        }
    }
}

/// Both pictures of one experiment, and whether they agree; `object` is what the scene says of shape and roughness.
fn seen_alike<S: Surface>(
    experiment: &Experiment<'_, S>,
    settings: &ViewSettings,
    metal: &str,
    object: Value,
    target: DVec3,
) {
    let (eta, k) = Metal::named(metal).unwrap().at(550.0);
    let mut scene = scene(experiment, settings, target, object);
    (scene["eta"], scene["k"]) = (json!(eta), json!(k));
    let [theirs, variance] = match rendered(&scene) {
        Ok(seen) => seen,
        Err(why) => return asking::skip("Mitsuba", &why),
    };
    let ours = render(experiment, settings, &Progress::silent()).unwrap();
    keep(metal, &ours.radiance, &theirs);
    judge(metal, &ours, &theirs, &variance);
}

fn judge(name: &str, ours: &RenderedView, theirs: &Raster, variance: &Raster) {
    let pixels = ours.radiance.values.len();
    let total = theirs.sum();
    let apart: f64 = ours.radiance.values.iter().zip(&theirs.values).map(|(a, b)| (a - b).abs()).sum();
    // Of errors that are themselves estimated: 5.5 is the Šidák bound that all 14400 normal deviates together pass with a
    // chance of more than 99.9 %, widened for Mitsuba's sixteen passes.
    let z: Vec<f64> = (0..pixels)
        .map(|k| {
            let error = (ours.errors.values[k].powi(2) + variance.values[k]).sqrt();
            (ours.radiance.values[k] - theirs.values[k]).abs() / error.max(1e-4 * total / pixels as f64)
        })
        .collect();
    let within = |most: f64| z.iter().filter(|z| **z <= most).count() as f64 / pixels as f64;
    let squares = z.iter().map(|z| z * z).sum::<f64>() / pixels as f64;
    let sums = ours.radiance.sum() / total - 1.0;
    say(&format!(
        "{name}, ours against Mitsuba: mean |difference| {:.5} of the mean, sums differ by {sums:.6}, mean z² {squares:.3}, \
         within 3 standard errors {:.5}, largest z {:.2}",
        apart / total,
        within(3.0),
        z.iter().copied().fold(0.0, f64::max)
    ));
    let mean = total / pixels as f64;
    let [dark, bright] = [0.6, 1.4].map(|share| theirs.values.iter().filter(|v| **v < share * mean).count());
    assert!(dark * 20 > pixels && (pixels - bright) * 20 > pixels, "a picture worth comparing: {dark} {bright}");
    assert!(sums.abs() < 2e-3, "{sums}");
    assert!(within(3.0) > 0.995, "{}", within(3.0));
    assert!(within(5.5) > 0.9975 && apart < 0.006 * total, "{} {apart} {total}", within(5.5));
}

#[test]
fn a_rough_plate_looks_as_in_mitsuba() {
    let recipe = Recipe::from_toml("design = { arrange = 'random' }\nlight = { theta = 30, phi = 70 }").unwrap();
    let path = format!("{}/examples/highlights/letter.png", env!("CARGO_MANIFEST_DIR"));
    let light = read(path.as_ref(), &recipe.reading()).unwrap().light;
    let plate = design(&recipe, &light, &Progress::silent()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let stl = folder.path().join("plate.stl");
    write_stl(&plate.mesh, &mut BufWriter::new(File::create(&stl).unwrap())).unwrap();

    let (surface, setup) = (GridSurface::new(&plate.relief, &Progress::silent()).unwrap(), recipe.setup());
    let material = "aluminium:ggx:0.2".parse().unwrap();
    let experiment =
        Experiment { surface: &surface, setup: &setup, material, lamp: setup.lamp().with_extent(Extent::Point).into() };
    // Near enough for perspective to show, and only the plate's upper side in the picture: its sides count as black here.
    let settings = ViewSettings {
        theta: 25.0,
        phi: 230.0,
        distance: 80.0,
        field_of_view: 14.0,
        size: [120, 120],
        rays: 1024,
        ..ViewSettings::default()
    };
    let (low, high) = plate.relief.bounds();
    seen_alike(&experiment, &settings, "aluminium", json!({"stl": stl, "alpha": [0.2, 0.2]}), 0.5 * (low + high));
}

#[test]
fn a_portrait_on_the_metal_looks_as_in_mitsuba() {
    let text =
        "plate = { size = [14, 14] }\nlight = { theta = 40 }\nverify = { rays = 400000 }\npatches = { portrait = '-' }";
    let recipe = Recipe::from_toml(text).unwrap();
    let tones = Raster::from_fn(14, 14, |x, y| match (x, y) {
        (2..5, 1..12) | (2..11, 9..12) => 1.0,
        (8..12, 2..5) => 0.4,
        _ => 0.05,
    });
    let asked = Asked::Portrait(tones);
    let plate = design_patches(&recipe, &asked, true, MemoryLimit::NONE, &Progress::silent()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let stl = folder.path().join("plate.stl");
    write_stl(&plate.mesh, &mut BufWriter::new(File::create(&stl).unwrap())).unwrap();
    let proof = plate.proof.as_ref().unwrap();
    let (settings, (low, high)) = (&proof.settings, plate.relief.height_range());
    let middle = DVec3::new(7.0, 7.0, 0.5 * (low + high));
    let toward = direction(settings.theta.to_radians(), settings.phi.to_radians());
    // A purely imaginary index reflects everything; Beckmann's width is √2 times the standard deviation of slopes.
    let width = 2f64.sqrt() * f64::to_radians(0.75);
    let scene = json!({
        "eye": (middle + settings.distance * toward).to_array(), "target": middle.to_array(),
        "up": carried_axes(toward).1.to_array(), "light_goes": (-recipe.setup().light()).to_array(),
        "field_of_view": settings.field_of_view, "size": settings.size, "bounces": settings.max_bounces,
        "passes": 16, "paths": 16, "stl": stl, "alpha": [width, width], "distribution": "beckmann", "eta": 0.0, "k": 1.0,
    });
    let [radiance, variance] = match rendered(&scene) {
        Ok(seen) => seen,
        Err(why) => return asking::skip("Mitsuba", &why),
    };
    keep("portrait", &proof.written.view.radiance, &radiance);
    let errors = Raster { values: variance.values.iter().map(|v| v.sqrt()).collect(), ..variance };
    let trapped = Raster::zeros(radiance.width, radiance.height);
    let theirs = RenderedView { radiance, errors, trapped };
    let level = plate.relief.heights.iter().map(|z| f64::from(*z)).sum::<f64>() / plate.relief.heights.len() as f64;
    let (ours, theirs) = (&proof.written.seen, PatchView::new(&theirs, settings, &plate.patches, middle, level));
    let beyond = |most: f64| {
        let far = |k: &usize| {
            let error = ours.errors.values[*k].hypot(theirs.errors.values[*k]).max(1e-3 * plate.wanted.max());
            (ours.seen.values[*k] - theirs.seen.values[*k]).abs() > most * error
        };
        (0..ours.seen.values.len()).filter(far).count()
    };
    let sums = ours.seen.sum() / theirs.seen.sum() - 1.0;
    let scores = [ours.scores(&plate.wanted), theirs.scores(&plate.wanted)];
    say(&format!(
        "portrait, ours against Mitsuba: sums differ by {sums:.5}, beyond 3 errors {}, {scores:?}",
        beyond(3.0)
    ));
    assert!(sums.abs() < 0.01, "{sums}");
    assert!(beyond(3.0) <= 4 && beyond(5.0) == 0, "{} {}", beyond(3.0), beyond(5.0));
    assert!(scores.iter().all(|scores| scores.ssim.unwrap() > 0.93 && scores.tv < 0.06), "{scores:?}");
}

#[test]
fn a_brushed_ball_looks_as_in_mitsuba() {
    let flat = FacetedRelief::uniform(1, 1, DVec2::ONE, vec![Facet { height: 0.0, slope: Slope::FLAT }]);
    let setup = Setup::new(0.6, 1.2, 0.0, Projection::Equidistant, 0.3);
    let panel = GridSurface::panel(&flat, &Progress::silent()).unwrap();
    let material = "brass:ggx:0.15,0.4".parse().unwrap();
    let experiment =
        Experiment { surface: &panel, setup: &setup, material, lamp: setup.lamp().with_extent(Extent::Point).into() };
    let settings = ViewSettings {
        theta: 40.0,
        phi: 300.0,
        distance: 200.0,
        field_of_view: 18.0,
        size: [90, 70],
        shape: Shape::Sphere { radius: 30.0 },
        rays: 1024,
        ..ViewSettings::default()
    };
    seen_alike(&experiment, &settings, "brass", json!({"ball": 30.0, "alpha": [0.15, 0.4]}), DVec3::ZERO);
}

/// The `.bsdf` measured on a plate makes a ball in Mitsuba look as our own ball that wears the relief itself.
#[test]
fn a_ball_of_the_exported_bsdf_looks_as_one_that_wears_the_relief() {
    let recipe = Recipe::from_toml("highlight = { half-field = 15 }\ndesign = { arrange = 'transport' }").unwrap();
    let path = format!("{}/examples/highlights/letter.png", env!("CARGO_MANIFEST_DIR"));
    let light = read(path.as_ref(), &recipe.reading()).unwrap().light;
    let panel =
        GridSurface::panel(&design(&recipe, &light, &Progress::silent()).unwrap().relief, &Progress::silent()).unwrap();
    let setup = Setup::new(f64::to_radians(30.0), f64::to_radians(70.0), 0.0, Projection::Equidistant, 0.3);
    let material = "aluminium:ggx:0.2".parse().unwrap();
    let experiment =
        Experiment { surface: &panel, setup: &setup, material, lamp: setup.lamp().with_extent(Extent::Point).into() };
    let settings = ViewSettings {
        distance: 200.0,
        field_of_view: 18.0,
        size: [32, 32],
        shape: Shape::Sphere { radius: 30.0 },
        rays: 25_600,
        ..ViewSettings::default()
    };
    // Without Mitsuba nothing is to be measured: asked first with a BRDF that needs no time.
    let flat = |wi: DVec3, _: DVec3| 0.1 / wi.z.max(0.1);
    let small = BrdfAxes::isotropic(BrdfAxes::polar_nodes(4, 1.4), 8, 8).unwrap();
    let ball_of = |table: &BrdfTable| {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plate.bsdf");
        let mut bytes = Vec::new();
        write_bsdf(BsdfColour::Grey(table), &BsdfSettings::measured(), &mut bytes).unwrap();
        std::fs::write(&file, bytes).unwrap();
        rendered(&scene(&experiment, &settings, DVec3::ZERO, json!({"bsdf": file, "ball": 30.0})))
    };
    if let Err(why) = ball_of(&BrdfTable::from_fn(small, flat)) {
        return asking::skip("Mitsuba", &why);
    }

    // The grids and rays of `facetmill measure --brdf`.
    let polar = BrdfAxes::polar_nodes(16, f64::to_radians(88.0));
    let axes = BrdfAxes::anisotropic(polar, 16, 128, 64).unwrap();
    let measuring = Measuring { rays: 200_000, ..Measuring::default() };
    let swept = sweep(&panel, &experiment.material, axes, &measuring, &Progress::silent()).unwrap();
    let [theirs, _] = ball_of(&swept.table).unwrap();
    let ours = render(&experiment, &settings, &Progress::silent()).unwrap();
    keep("bsdf", &ours.radiance, &theirs);

    let peak = ours.radiance.values.iter().copied().fold(0.0, f64::max);
    let pairs = ours.radiance.values.iter().zip(&theirs.values);
    let mut apart: Vec<f64> = pairs.filter(|(a, _)| **a > 0.01 * peak).map(|(a, b)| (b / a - 1.0).abs()).collect();
    apart.sort_by(f64::total_cmp);
    let mean = apart.iter().sum::<f64>() / apart.len() as f64;
    let p99 = apart[apart.len() * 99 / 100];
    say(&format!(
        "a ball of the .bsdf, Mitsuba against ours: mean error {mean:.4}, p99 {p99:.4}, {} pixels",
        apart.len()
    ));
    assert!(apart.len() > 400, "{}", apart.len());
    assert!(mean <= 0.03 && p99 <= 0.2, "{mean} {p99}");
}
