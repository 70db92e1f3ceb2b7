//! `facetmill verify`: light over any closed mesh, or over a design once more, scored against a picture.

use std::path::Path;

use facetmill::export::sheet::sheet_solid;
use facetmill::export::stl::write_stl;
use facetmill::highlight::scored_target;
use facetmill::job::design::DesignError;
use facetmill::job::findings::{MadeProof, MilledProof, Proof, RimProof};
use facetmill::job::goal::GoalProof;
use facetmill::job::pictures::{ProofPictures, target_picture};
use facetmill::job::proof::send_over_milled_mesh;
use facetmill::job::{finer_than_the_blur, in_a_sentence};
use facetmill::memory::Need;
use facetmill::picture::Picture;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::recipe::{BorderFinish, MachiningSettings, Recipe};
use facetmill::relief::open::OpenRelief;
use facetmill::report::design::MilledFacts;
use facetmill::report::verify::{Allowed, VerifyReport};
use facetmill::report::{PROGRAM, PictureFacts, text};
use facetmill::setup::Setup;
use facetmill::slope::direction;
use facetmill::verify::experiment::Measuring;
use facetmill::verify::measure::Mirrored;
use facetmill::verify::rim::OverRim;
use facetmill::verify::score::blurred_scores;
use facetmill::verify::tally::{self, Measurement};
use facetmill::verify::verdict::Verdict;

use crate::against::{Against, folder, goal_proof};
use crate::args::VerifyArgs;
use crate::astray::astray;
use crate::console::{Failure, Table, tell};
use crate::files::Staged;
use crate::in_room::{in_its_scene, in_room};
use crate::interrupt::Run;
use crate::plates::{Named, Opened};
use crate::stages::Stages;
use crate::tables::percent;
use crate::values::Limit;
use crate::{inputs, machining, plates, portrait_proof, tables};

/// So much of the light misplaced that plate, lamp, field or picture do not belong together.
const ASTRAY: f64 = 0.5;

/// Does what `args` say.
pub fn run(args: &VerifyArgs, run: &Run) -> Result<(), Failure> {
    inputs::given([Some(&args.plate), None])?;
    let named = plates::named(&args.plate)?;
    if named.recipe.patches.are_wanted() {
        return portrait_proof::run(args, named, run);
    }
    let Named { stl, recipe: own, mount } = named;
    let (mut recipe, making, against) = asked(args, &own)?;
    if args.settings.has("as-made-stl") && args.output.is_none() {
        return Err(Failure::Usage("--as-made-stl needs a folder to write into: name one with -o".into()));
    }
    let machining = machining::proved(&args.machining, &making, &recipe)?;
    if args.settings.has("as-made-stl") && machining.as_ref().is_some_and(|machining| machining.polish.is_none()) {
        return Err(Failure::Usage("--as-made-stl is for a plate that is polished: give --polish too".into()));
    }
    let read = inputs::given([Some(&args.plate), against.path()])?;
    let mut staged = folder(args, &read, run)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Reading);
    let limit = args.running.memory();
    let pixels = Measuring::default().resolution.pow(2);
    let image = Need::new(tally::bytes(pixels), "the image of the light", "decimate the plate's mesh");
    let margin = plates::margin(args.margin, &args.plate, &recipe);
    let opened = plates::open(&stl, margin, &args.placing, (limit, image), &progress)?;
    let plate = opened.size.truncate() - 2.0 * margin;
    let task = machining.map(|machining| machining::Task::new(machining, making.draws, plate, limit)).transpose()?;
    let pose = |recipe: &Recipe| match (args.mount, mount) {
        (None, Some(normal)) => lit(recipe.setup().mounted(normal)),
        (mount, _) => mounted(recipe.setup(), mount),
    };
    let (picture, goal) = against.picture(&mut recipe, &pose, limit)?;
    recipe.note_drawing(picture.original_size);
    let task = task.map(|task| task.along_best(&recipe, &making, &picture.light)).transpose()?;
    let setup = pose(&recipe)?;
    let mut proof = proof(&args.plate, &mut recipe, &opened, (&picture, &setup, margin), &progress)?;
    let goal = match &goal {
        Some(goal) => {
            // Nobody knows of a file for which lamp it was designed: for the one that it is proved under.
            let designed = if args.plate.is_dir() { own.setup() } else { recipe.setup() };
            Some(goal_proof(&recipe, &designed, goal, (&opened, margin), &progress)?)
        }
        None => None,
    };
    if let Some(task) = task {
        proof.made = Some(task.done((&recipe, &opened, margin), (&picture.light, &proof, &setup), &progress)?);
    }
    if staged.is_some() {
        progress.stage(Stage::Files);
    }
    let report = report(args, &recipe, (&opened, margin), (&proof, goal.as_ref()), (&picture, &setup));
    if let Some(staged) = &mut staged {
        let surface = proof.made.as_ref().and_then(|made| made.surface.as_ref()).filter(|_| making.as_made_stl);
        write(staged, (&proof, goal.as_ref()), &recipe, &opened, (&report, &setup), (surface, &progress))?;
    }
    if let Some(staged) = staged {
        staged.publish()?;
    }
    stages.finish();
    tell(&args.running, &report, |report| Table {
        title: report.verdict.clone(),
        rows: tables::verify_in_short(args.output.as_deref(), report),
        more: tables::verify(report),
        notes: [&report.picture.notes[..], &report.advice[..]].concat(),
    })?;
    within_limit(report.at_most)
}

/// The folder's `own` recipe as flags change it, how it is made, and what its light is scored against.
fn asked(args: &VerifyArgs, own: &Recipe) -> Result<(Recipe, MachiningSettings, Against), Failure> {
    let mut recipe = own.clone();
    args.settings.apply(&mut recipe);
    args.aim(&mut recipe);
    if recipe.goal.is_none() && args.goal_part.is_some() {
        return Err(Failure::Usage("--goal-part is for a --goal, and there is none: leave it out".into()));
    }
    let against = Against::new(args, &recipe)?;
    if let Against::Picture(path) = &against {
        recipe.name_picture(path);
    }
    machining::named(&args.machining.by, &mut recipe)?;
    // Its cutter need not be the recipe's: what is wrong with it is told by itself.
    let making = std::mem::take(&mut recipe.machining);
    let recipe = in_its_scene(args, recipe, &own.scene)?;
    if recipe.is_near() && matches!(against, Against::Goal(_)) {
        let what = "a goal is for a lamp and viewers far away";
        return Err(Failure::Usage(format!(
            "{what}: leave out lamp and wall nearby, or name a picture with --against"
        )));
    }
    // A pose that cannot be is told before anything is read.
    mounted(recipe.setup(), args.mount)?;
    Ok((recipe, making, against))
}

/// Everything that is known of the light.
fn report(
    args: &VerifyArgs,
    recipe: &Recipe,
    (opened, margin): (&Opened, f64),
    (proof, goal): (&Proof, Option<&GoalProof>),
    (picture, setup): (&Picture, &Setup),
) -> VerifyReport {
    VerifyReport {
        program: PROGRAM,
        plate: opened.facts.clone(),
        picture: PictureFacts::new(picture, recipe.picture_path().map(|path| path.to_string_lossy().into_owned())),
        highlight: recipe.highlight,
        light: recipe.light,
        lobe_deg: recipe.plate.lobe,
        metal: recipe.metal(),
        margin_mm: margin,
        margin_into_picture_if_polished: proof.rim.as_ref().map(|rim| rim.into_picture.value),
        on_wall: proof.wall.as_ref().map(|wall| wall.facts(recipe)),
        measured: (&proof.verdict).into(),
        as_milled: proof
            .milled
            .as_ref()
            .map(|milled| MilledFacts { scores: (&milled.verdict).into(), left_by_cutter_um: 1000.0 * milled.left }),
        goal: goal.map(|goal| goal.facts.clone()),
        as_made: proof.made.as_ref().map(MadeProof::facts),
        at_most: args.at_most.and_then(|limit| allowed(limit, proof, setup)),
        verdict: one_sentence(args, recipe, proof),
        advice: advice(args, recipe, opened, proof, (picture, setup)),
    }
}

/// Whether no more light is misplaced than was allowed, if a limit was given.
fn within_limit(allowed: Option<Allowed>) -> Result<(), Failure> {
    match allowed {
        Some(allowed) if !allowed.kept => Err(Failure::Beyond(format!(
            "{} of the light is misplaced or lost at a blur of {}°{}, more than the {} of --at-most",
            percent(allowed.tv_incident),
            allowed.blur_deg,
            match (allowed.as_made, allowed.as_milled) {
                (true, _) => " as made",
                (false, true) => " as milled",
                _ => "",
            },
            percent(allowed.share)
        ))),
        _ => Ok(()),
    }
}

/// The setup with the plate mounted at the angles that were given, degrees.
fn mounted(setup: Setup, mount: Option<[f64; 2]>) -> Result<Setup, Failure> {
    let Some([theta, phi]) = mount else { return Ok(setup) };
    if !((0.0..=80.0).contains(&theta) && phi.abs() <= 360.0) {
        return Err(Failure::Usage("--mount takes an angle from 0 to 80 and an azimuth from -360 to 360".into()));
    }
    lit(setup.mounted(direction(theta.to_radians(), phi.to_radians())))
}

fn lit(setup: Setup) -> Result<Setup, Failure> {
    if setup.light().z <= 0.0 {
        return Err(Failure::Impossible("the light is behind the plate as mounted: lower --light or --mount".into()));
    }
    Ok(setup)
}

/// Light over the plate as it stands in its file, and as the recipe's cutter leaves it.
fn proof(
    plate: &Path,
    recipe: &mut Recipe,
    opened: &Opened,
    (picture, setup, margin): (&Picture, &Setup, f64),
    progress: &Progress,
) -> Result<Proof, Failure> {
    progress.stage(Stage::Tracing);
    let measuring = recipe.measuring();
    let unlit = |error| {
        let name = plate.display();
        let what = format!("{name}: no light reaches the highlight image: check units, orientation and --light");
        Failure::of_measure(error, what)
    };
    let metal = recipe.metal();
    let mirrored = Mirrored { setup, metal: &metal, measuring: &measuring, progress };
    if let Some(scene) = recipe.scene().ok().flatten() {
        if !plate.is_dir() {
            // Nobody knows of a file where its cells end.
            recipe.plate.cells = Some(1.into());
        }
        return in_room(recipe, &scene, opened, (&picture.light, margin), mirrored);
    }
    let target = scored_target(&picture.light, recipe.highlight.quantity, setup, measuring.resolution);
    let measurement = opened.plate.run(mirrored).map_err(unlit)?;
    let over = OverRim { mirrored, width: margin, scene: None };
    let over_rim = if margin > 0.0 { Some(opened.plate.run(over)?) } else { None };
    let rim = over_rim.map(|light| RimProof {
        counts: plate.is_dir() && recipe.border_finish() != BorderFinish::Matt,
        ..RimProof::dull(light, &measurement)
    });
    let judged = |measurement: Measurement| {
        progress.stage(Stage::Scoring);
        let measurement = RimProof::over(rim.as_ref(), measurement);
        let verdict = Verdict::new(&measurement, &target, setup.view(), progress).map_err(unlit)?;
        Ok::<_, Failure>((measurement, verdict))
    };
    let (measurement, verdict) = judged(measurement)?;
    let milled = match send_over_milled_mesh(recipe, &opened.mesh, margin, mirrored)? {
        None => None,
        Some((measurement, left)) => {
            let (measurement, verdict) = judged(measurement)?;
            Some(MilledProof { left, measurement, verdict })
        }
    };
    Ok(Proof { target, measurement, verdict, sheet: None, milled, made: None, rim, wall: None })
}

/// How the light came out: of the plate as it is cut, if that is known.
fn one_sentence(args: &VerifyArgs, recipe: &Recipe, proof: &Proof) -> String {
    let name = plates::name(&args.plate);
    if let Some(made) = &proof.made {
        return in_a_sentence(&made.verdict, &format!("On {name} as {}", made.how()));
    }
    match (&proof.milled, recipe.design.sheet.cutter) {
        (Some(milled), Some(cutter)) => in_a_sentence(&milled.verdict, &format!("On {name} cut by {cutter}")),
        (Some(milled), None) => in_a_sentence(&milled.verdict, &format!("On {name}, polished")),
        (None, _) => in_a_sentence(&proof.verdict, &format!("On {name}")),
    }
}

/// What is allowed, beside what came of it.
fn allowed(limit: Limit, proof: &Proof, setup: &Setup) -> Option<Allowed> {
    let milled = proof.milled.as_ref().map_or(&proof.measurement, |milled| &milled.measurement);
    let measurement = proof.made.as_ref().map_or(milled, |made| &made.measurement);
    let whole = &measurement.whole;
    let blur = limit.blur.to_radians();
    let scores = blurred_scores(&whole.share_image(), whole.up(), &proof.target, setup.view(), blur)?;
    Some(Allowed {
        share: limit.share,
        blur_deg: limit.blur,
        tv_incident: scores.tv_incident,
        as_milled: proof.milled.is_some() && proof.made.is_none(),
        as_made: proof.made.is_some(),
        kept: scores.tv_incident <= limit.share,
    })
}

fn write(
    staged: &mut Staged,
    (proof, goal): (&Proof, Option<&GoalProof>),
    recipe: &Recipe,
    opened: &Opened,
    (report, setup): (&VerifyReport, &Setup),
    (surface, progress): (Option<&OpenRelief>, &Progress),
) -> Result<(), Failure> {
    let size = opened.size;
    staged.write_png("target.png", &target_picture(&proof.target, recipe))?;
    let footer = format!(
        "{:.2} × {:.2} mm, {} triangles   ·   light at {}°, {}°   ·   half field {}°",
        size.x, size.y, opened.triangles, recipe.light.theta, recipe.light.phi, recipe.highlight.half_field
    );
    let pictures = ProofPictures::new(proof, recipe, setup.view(), &footer, progress)?;
    staged.write_png("simulated.png", &pictures.simulated)?;
    staged.write_png("comparison.png", &pictures.comparison)?;
    if let Some(milled) = &pictures.milled {
        staged.write_png("comparison_milled.png", milled)?;
    }
    if let Some(made) = &pictures.made {
        staged.write_png("comparison_made.png", made)?;
    }
    if let Some(goal) = goal {
        staged.write_png("goal.png", &goal.picture())?;
    }
    if let Some(surface) = surface {
        let solid = sheet_solid(surface, recipe.plate.thickness, 0.0, progress).map_err(DesignError::from)?;
        staged.write("as-made.stl", |out| write_stl(&solid, out))?;
    }
    staged.write_bytes("report.json", text(report).as_bytes())?;
    Ok(())
}

/// What a person should know of the mesh and of its light.
fn advice(
    args: &VerifyArgs,
    recipe: &Recipe,
    opened: &Opened,
    proof: &Proof,
    (picture, setup): (&Picture, &Setup),
) -> Vec<String> {
    let mut advice = opened.advice.clone();
    let dark = proof.rim.as_ref().filter(|rim| !rim.counts && rim.into_picture.value > 0.002);
    if let Some(rim) = dark {
        advice.push(format!(
            "The margin was counted as dark: polished it would throw {:.1}% as much light as the rest into the picture.",
            100.0 * rim.into_picture.value
        ));
    }
    if proof.verdict.backface > 1e-4 {
        advice.push(format!(
            "{:.2}% of the light meets faces from behind: the mesh leaks or is turned inside out.",
            100.0 * proof.verdict.backface
        ));
    }
    advice.extend(finer_than_the_blur(&proof.verdict));
    let cuts = recipe.design.sheet.cutter.is_some() || recipe.design.sheet.polish.is_some();
    if args.plate.is_dir() && cuts && proof.milled.is_none() {
        advice.push("The plate in the folder is none of its recipe's: it was not milled again, only traced.".into());
    }
    let misplaced = proof.verdict.main().tv_incident.value;
    if misplaced > ASTRAY {
        advice.push(astray(misplaced, proof, recipe, (picture, setup)));
    }
    advice
}
