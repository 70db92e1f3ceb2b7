//! `facetmill verify`: light over any closed STL, scored against a picture.

use facetmill::highlight::scored_target;
use facetmill::job::pictures::{ProofPictures, target_picture};
use facetmill::job::proof::{Proof, RimProof};
use facetmill::job::{exports, finer_than_the_blur, in_a_sentence};
use facetmill::picture;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::recipe::Recipe;
use facetmill::report::verify::VerifyReport;
use facetmill::report::{PROGRAM, PictureFacts, text};
use facetmill::setup::Setup;
use facetmill::slope::direction;
use facetmill::verify::experiment::Measuring;
use facetmill::verify::measure::Mirrored;
use facetmill::verify::rim::OverRim;
use facetmill::verify::verdict::Verdict;

use crate::args::VerifyArgs;
use crate::console::{Failure, Table, tell};
use crate::files::{Place, Staged};
use crate::interrupt::Run;
use crate::plates::Opened;
use crate::stages::Stages;
use crate::{inputs, plates, tables};

/// Does what `args` say.
pub fn run(args: &VerifyArgs, run: &Run) -> Result<(), Failure> {
    let mut recipe = Recipe::default();
    args.settings.apply(&mut recipe);
    recipe.name_picture(&args.against);
    recipe.check().map_err(|error| Failure::Usage(format!("--{error}")))?;
    let setup = mounted(recipe.setup(), args.mount)?;
    let read = inputs::given([Some(&args.plate), Some(&args.against)])?;
    plates::spare_design(&args.plate, &args.output)?;
    let mut staged = Staged::new(&Place::new(&args.output, args.running.force, exports::VERIFY, &read), &run.gate)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Reading);
    let name = args.plate.display();
    let margin = args.margin.unwrap_or(0.0);
    let opened = plates::open(&args.plate, margin)?;
    let picture = picture::read(&args.against, &recipe.reading())?;
    progress.stage(Stage::Tracing);
    let measuring = Measuring { rays: recipe.verify.rays, seed: recipe.design.seed, ..Measuring::default() };
    let no_light = || {
        Failure::Impossible(format!(
            "{name}: no light reaches the highlight image: check units, orientation and --light"
        ))
    };
    let metal = recipe.metal();
    let task = Mirrored { setup: &setup, metal: &metal, measuring: &measuring, progress: &progress };
    let measurement = opened.plate.run(task).ok_or_else(no_light)?;
    let rim = (margin > 0.0).then(|| opened.plate.run(OverRim { mirrored: task, width: margin, scene: None }));
    let rim = rim.map(|light| RimProof::dull(light, &measurement));
    progress.stage(Stage::Scoring);
    let target = scored_target(&picture.light, recipe.highlight.quantity, &setup, measuring.resolution);
    let verdict = Verdict::new(&measurement, &target, setup.view(), &progress).ok_or_else(no_light)?;
    let proof = Proof { target, measurement, verdict, sheet: None, milled: None, rim };

    progress.stage(Stage::Files);
    let size = opened.size;
    let report = VerifyReport {
        program: PROGRAM,
        plate: opened.facts.clone(),
        picture: PictureFacts::new(&picture, Some(args.against.to_string_lossy().into_owned())),
        highlight: recipe.highlight,
        light: recipe.light,
        lobe_deg: recipe.plate.lobe,
        metal,
        margin_mm: margin,
        margin_into_picture_if_polished: proof.rim.as_ref().map(|rim| rim.into_picture.value),
        measured: (&proof.verdict).into(),
        verdict: in_a_sentence(&proof.verdict, &format!("On {}", plates::name(&args.plate))),
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
        title: report.verdict.clone(),
        rows: tables::verify_in_short(&args.output, report),
        more: tables::verify(report),
        notes: [&report.picture.notes[..], &report.advice[..]].concat(),
    })?;
    Ok(())
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
    advice.extend(finer_than_the_blur(verdict));
    advice
}
