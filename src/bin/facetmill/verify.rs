//! `facetmill verify`: light over any closed STL, scored against a picture.

use facetmill::highlight::scored_target;
use facetmill::job::exports;
use facetmill::job::on_wall::{RoomProof, rim_proof};
use facetmill::job::pictures::{ProofPictures, target_picture};
use facetmill::job::proof::{Proof, RimProof};
use facetmill::picture;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::raster::Raster;
use facetmill::recipe::{BorderFinish, Recipe};
use facetmill::report::verify::VerifyReport;
use facetmill::report::{PROGRAM, PictureFacts, text};
use facetmill::scene::Scene;
use facetmill::setup::Setup;
use facetmill::slope::direction;
use facetmill::verify::experiment::Measuring;
use facetmill::verify::measure::Mirrored;
use facetmill::verify::rim::OverRim;
use facetmill::verify::verdict::Verdict;

use crate::args::VerifyArgs;
use crate::console::{Failure, Stages, Table, tell};
use crate::files::{Place, Staged};
use crate::interrupt::Run;
use crate::plates::Opened;
use crate::{inputs, plates, tables};

/// Does what `args` say.
pub fn run(args: &VerifyArgs, run: &Run) -> Result<(), Failure> {
    let mut recipe = Recipe::default();
    args.settings.apply(&mut recipe);
    recipe.picture = Some(args.against.to_string_lossy().into_owned());
    if let Some(file) = &args.scene {
        recipe.scene.room = Some(inputs::room(file)?);
    }
    let mut recipe = args.settings.implied(recipe)?;
    recipe.check().map_err(|error| match error.is_impossible() {
        true => Failure::Impossible(error.to_string()),
        false => Failure::Usage(format!("--{error}")),
    })?;
    if recipe.is_near() && args.mount.is_some() {
        return Err(Failure::Usage(
            "--mount has no meaning beside a lamp or a wall nearby: their pose is the plate's".into(),
        ));
    }
    let read = inputs::given([Some(&args.plate), Some(&args.against)])?;
    plates::spare_design(&args.plate, &args.output)?;
    let mut staged = Staged::new(&Place::new(&args.output, args.running.force, exports::VERIFY, &read), &run.gate)?;
    let stages = Stages::new(args.running.quiet);
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Reading);
    let name = args.plate.display();
    let margin = args.margin.unwrap_or(0.0);
    let opened = plates::open(&args.plate, margin)?;
    let picture = picture::read(&args.against, &recipe.reading())?;
    recipe.note_drawing(picture.original_size);
    let setup = mounted(recipe.setup(), args.mount)?;
    progress.stage(Stage::Tracing);
    let measuring = Measuring { rays: recipe.verify.rays, seed: recipe.design.seed, ..Measuring::default() };
    let no_light = || {
        Failure::Impossible(format!(
            "{name}: no light reaches the highlight image: check units, orientation and --light"
        ))
    };
    let metal = recipe.metal();
    let task = Mirrored { setup: &setup, metal: &metal, measuring: &measuring, progress: &progress };
    let proof = match recipe.scene().ok().flatten() {
        Some(scene) => in_room(&mut recipe, &scene, &opened, &picture.light, margin, task)?,
        None => {
            let measurement = opened.plate.run(task).ok_or_else(no_light)?;
            let over = OverRim { mirrored: task, width: margin, scene: None };
            let rim = (margin > 0.0).then(|| RimProof::dull(opened.plate.run(over), &measurement));
            progress.stage(Stage::Scoring);
            let target = scored_target(&picture.light, recipe.highlight.quantity, &setup, measuring.resolution);
            let verdict = Verdict::new(&measurement, &target, setup.view(), &progress).ok_or_else(no_light)?;
            Proof { target, measurement, verdict, sheet: None, milled: None, rim, wall: None }
        }
    };

    progress.stage(Stage::Files);
    let size = opened.size;
    let report = VerifyReport {
        program: PROGRAM,
        plate: opened.facts.clone(),
        picture: PictureFacts::new(&picture, recipe.picture.clone()),
        highlight: recipe.highlight,
        light: recipe.light,
        lobe_deg: recipe.plate.lobe,
        metal,
        margin_mm: margin,
        margin_into_picture_if_polished: proof.rim.as_ref().map(|rim| rim.into_picture.value),
        on_wall: proof.wall.as_ref().map(|wall| wall.facts(&recipe)),
        measured: (&proof.verdict).into(),
        advice: advice(&opened, &proof),
    };
    staged.write_png("target.png", &target_picture(&proof.target, &recipe))?;
    let footer = format!(
        "{:.2} × {:.2} mm, {} triangles   ·   light at {}°, {}°   ·   half field {}°",
        size.x, size.y, opened.triangles, recipe.light.theta, recipe.light.phi, recipe.highlight.half_field
    );
    let pictures = ProofPictures::new(&proof, &recipe, setup.view(), &footer);
    staged.write_png("simulated.png", &pictures.simulated)?;
    staged.write_png("comparison.png", &pictures.comparison)?;
    staged.write_bytes("report.json", text(&report).as_bytes())?;
    staged.publish()?;
    stages.finish();
    tell(&args.running, &report, |report| Table {
        title: format!("Wrote {}; look at comparison.png first", args.output.display()),
        rows: tables::verify(report),
        notes: [&report.picture.notes[..], &report.advice[..]].concat(),
    })?;
    Ok(())
}

/// The proof of a plate in its room.
fn in_room(
    recipe: &mut Recipe,
    scene: &Scene,
    opened: &Opened,
    light: &Raster,
    margin: f64,
    mirrored: Mirrored,
) -> Result<Proof, Failure> {
    recipe.plate.size = (opened.size.truncate() - 2.0 * margin).to_array();
    // Nobody knows of a file where its cells end.
    recipe.plate.cells = Some(1);
    let room = RoomProof { recipe, light, scene, mirrored };
    let plate = opened.bare.as_ref().unwrap_or(&opened.plate);
    let (thrown, elsewhere) = (plate.run(room.throwing()), plate.run(room.elsewhere()));
    let rim = thrown.as_ref().filter(|_| margin > 0.0).map(|thrown| {
        let light = opened.plate.run(OverRim { mirrored, width: margin, scene: Some(scene) });
        rim_proof(light, thrown, BorderFinish::Matt)
    });
    let (measurement, verdict, designed) = room.judged(thrown, None)?;
    let (target, wall) = (room.target(measurement.whole.image.width), room.wall_proof(designed, elsewhere));
    Ok(Proof { target, measurement, verdict, sheet: None, milled: None, rim, wall })
}

/// The setup with the plate mounted at the angles that were given, degrees.
fn mounted(setup: Setup, mount: Option<[f64; 2]>) -> Result<Setup, Failure> {
    let Some([theta, phi]) = mount else { return Ok(setup) };
    if !((0.0..=80.0).contains(&theta) && phi.abs() <= 360.0) {
        return Err(Failure::Usage("--mount takes an angle from 0 to 80 and an azimuth from -360 to 360".into()));
    }
    let setup = setup.mounted(direction(theta.to_radians(), phi.to_radians()));
    if setup.light().z <= 0.0 {
        return Err(Failure::Impossible("the light is behind the plate as mounted: lower --light or --mount".into()));
    }
    Ok(setup)
}

/// What a person should know of the mesh.
fn advice(opened: &Opened, proof: &Proof) -> Vec<String> {
    let mut advice = opened.advice.clone();
    let verdict = &proof.verdict;
    if let Some(share) = proof.rim.as_ref().map(|rim| rim.into_picture.value).filter(|share| *share > 0.002) {
        advice.push(format!(
            "The margin was counted as dark: polished it would throw {:.1}% as much light as the rest into the picture.",
            100.0 * share
        ));
    }
    if verdict.backface > 1e-4 {
        advice.push(format!(
            "{:.2}% of the light meets faces from behind: the mesh leaks or is turned inside out.",
            100.0 * verdict.backface
        ));
    }
    advice
}
