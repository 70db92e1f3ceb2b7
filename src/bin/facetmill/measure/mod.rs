//! `facetmill measure`: what light does on a plate, in one of five ways.

mod brdf;
mod check;
mod highlight;
mod memory;
mod ndf;
mod render;
mod wall;

use facetmill::brdf::material::Material;
use facetmill::job::exports;
use facetmill::lamp::Extent;
use facetmill::picture::Reading;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::recipe::{BorderFinish, Recipe};
use facetmill::report::measure::{LampFacts, MeasureReport, Measured};
use facetmill::report::{PROGRAM, text};
use facetmill::scene::Scene;
use facetmill::setup::Setup;
use facetmill::trace::Surface;
use facetmill::trace::traced_plate::TracedPlate;
use facetmill::verify::experiment::{Experiment, Measuring};

use crate::args::MeasureArgs;
use crate::console::{Failure, Table, tell};
use crate::files::{Place, Staged};
use crate::inputs;
use crate::interrupt::Run;
use crate::plates::{self, Opened};
use crate::stages::Stages;
use crate::tables::Row;
use crate::values::ExtentArg;

/// All that every measurement needs, read and checked.
struct Bench {
    opened: Opened,
    /// Of the file or folder, without its path.
    name: String,
    plate: TracedPlate,
    endless: bool,
    recipe: Recipe,
    setup: Setup,
    /// Lamp and wall of the design, if they are near and nothing else is asked for.
    scene: Option<Scene>,
    material: Material,
    /// The material, as a caption says it.
    made_of: String,
    lamp: Extent,
    measuring: Measuring,
}

impl Bench {
    /// The plate's surface as it is to be lit.
    fn experiment<'a, S: Surface>(&'a self, surface: &'a S) -> Experiment<'a, S> {
        let lamp = self.setup.lamp().with_extent(self.lamp.clone()).into();
        Experiment { surface, setup: &self.setup, material: self.material.clone(), lamp }
    }
}

/// Figures that are told without --verbose.
const SHORT: usize = 5;

/// What a measurement has to say, its files being written already.
struct Outcome {
    measured: Measured,
    rows: Vec<Row>,
    notes: Vec<String>,
    look_at: &'static str,
}

/// Does what `args` say.
pub fn run(args: &MeasureArgs, run: &Run) -> Result<(), Failure> {
    check::check(args)?;
    let read = inputs::given([Some(&args.plate), args.lamp.as_deref()])?;
    let named = plates::named(&args.plate)?;
    let recipe = recipe(args, named.recipe)?;
    // A rim that is left dull lights nothing.
    let dull_rim = if recipe.border_finish() == BorderFinish::Matt { recipe.plate.border } else { 0.0 };
    let measuring = measuring(args, &recipe);
    let memory = (args.running.memory(), memory::need(args, measuring.resolution)?);
    memory.0.admit(memory.1)?;
    let mut setup = recipe.setup();
    if let Some(normal) = named.mount {
        setup = setup.mounted(normal);
        if setup.light().z <= 0.0 {
            return Err(Failure::Impossible("the light is behind the plate as mounted: lower --light".into()));
        }
    }
    plates::spare_design(&args.plate, &args.output)?;
    let mut staged = Staged::new(&Place::new(&args.output, args.running.force, exports::MEASURE, &read), &run.gate)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Reading);
    let opened = plates::open(&named.stl, args.margin.unwrap_or(dull_rim), &args.placing, memory, &progress)?;
    let (plate, endless) = extent(args, &recipe, &opened, &progress)?;
    let elsewhere = args.wall.is_some() || args.brdf || args.ndf || args.look || args.lamp.is_some();
    let scene = recipe.scene().ok().flatten().filter(|scene| !elsewhere && scene.wall().is_some());
    let bench = Bench {
        scene,
        plate,
        endless,
        name: plates::name(&args.plate),
        made_of: made_of(args, &recipe),
        material: args.material.clone().unwrap_or_else(|| recipe.metal()),
        lamp: lamp(args, &recipe)?,
        opened,
        recipe,
        setup,
        measuring,
    };
    let mut outcome = measured(args, &bench, &mut staged, &progress)?;
    let report = MeasureReport {
        program: PROGRAM,
        plate: bench.opened.facts.clone(),
        extent: if bench.endless { "endless" } else { "finite" },
        material: bench.material.clone(),
        // Light from all sides, and none, have no lamp.
        light: (!args.brdf && !args.ndf).then_some(bench.recipe.light),
        lamp: args.lamp.as_ref().map(|path| LampFacts {
            picture: path.to_string_lossy().into_owned(),
            half_field: args.lamp_half_field.unwrap_or(LAMP_HALF_FIELD),
        }),
        max_bounces: bench.measuring.max_bounces,
        seed: bench.measuring.seed,
        measured: outcome.measured,
        advice: [&bench.opened.advice[..], &outcome.notes[..]].concat(),
    };
    staged.write_bytes("report.json", text(&report).as_bytes())?;
    staged.publish()?;
    stages.finish();
    let more = outcome.rows.split_off(outcome.rows.len().min(SHORT));
    tell(&args.running, &report, |report| Table {
        title: format!("Wrote {}; look at {} first", args.output.display(), outcome.look_at),
        rows: outcome.rows,
        more,
        notes: report.advice.clone(),
    })?;
    Ok(())
}

/// Measures what the flags ask for.
fn measured(args: &MeasureArgs, bench: &Bench, staged: &mut Staged, progress: &Progress) -> Result<Outcome, Failure> {
    if args.brdf {
        brdf::measure(args, bench, staged, progress)
    } else if args.ndf {
        ndf::measure(args, bench, staged, progress)
    } else if args.wall.is_some() || bench.scene.is_some() {
        wall::measure(args, bench, staged, progress)
    } else if args.look {
        render::measure(args, bench, staged, progress)
    } else {
        highlight::measure(bench, staged, progress)
    }
}

/// The flags laid over what the folder of a design says.
fn recipe(args: &MeasureArgs, mut recipe: Recipe) -> Result<Recipe, Failure> {
    // How long and with which chance the design was proven says nothing of this measurement.
    let usual = Recipe::default();
    (recipe.design.seed, recipe.verify) = (usual.design.seed, usual.verify);
    args.settings.apply(&mut recipe);
    if args.look {
        // There it is a number for each pixel, with a range of its own.
        recipe.verify = usual.verify;
    }
    recipe.check().map_err(|error| Failure::Usage(format!("--{error}")))?;
    Ok(recipe)
}

/// What the plate is made of, in the words that were used for it.
fn made_of(args: &MeasureArgs, recipe: &Recipe) -> String {
    match (&args.material, recipe.plate.lobe) {
        (Some(material), _) => material.to_string(),
        (None, 0.0) => "mirror".into(),
        (None, lobe) => format!("mirror, lobe {lobe}°"),
    }
}

fn measuring(args: &MeasureArgs, recipe: &Recipe) -> Measuring {
    let usual = Measuring::default();
    Measuring {
        rays: recipe.verify.rays,
        resolution: args.resolution.unwrap_or(usual.resolution),
        max_bounces: args.max_bounces.and_then(|n| n.try_into().ok()).unwrap_or(usual.max_bounces),
        seed: recipe.design.seed,
        error: args.error,
    }
}

/// The plate as it is to be taken, and whether it goes on without end.
fn extent(
    args: &MeasureArgs,
    recipe: &Recipe,
    opened: &Opened,
    progress: &Progress,
) -> Result<(TracedPlate, bool), Failure> {
    let endless = opened.plate.clone().endless(progress)?;
    let differ = recipe.is_near();
    if differ && (args.extent == Some(ExtentArg::Endless) || args.wrap.is_some()) {
        return Err(Failure::Impossible(format!(
            "{}: its cells differ, since each knows where lamp and wall are, so it cannot be repeated: use --extent finite",
            args.plate.display()
        )));
    }
    match (args.extent, endless.filter(|_| !differ)) {
        (Some(ExtentArg::Endless), None) => Err(Failure::Impossible(format!(
            "{}: this relief stands on no grid and cannot be repeated: use --extent finite",
            args.plate.display()
        ))),
        (Some(ExtentArg::Endless), Some(plate)) => Ok((plate, true)),
        // What is to stand for a material has no edges, where that can be had; what is wrapped on a shape must not.
        (None, Some(plate)) if args.brdf || args.wrap.is_some() => Ok((plate, true)),
        _ => Ok((opened.plate.clone(), false)),
    }
}

/// From the middle of a picture-shaped lamp to its rim, degrees.
const LAMP_HALF_FIELD: f64 = 5.0;

fn lamp(args: &MeasureArgs, recipe: &Recipe) -> Result<Extent, Failure> {
    let Some(path) = &args.lamp else { return Ok(Extent::round(recipe.light.radius.to_radians())) };
    let half_field = args.lamp_half_field.unwrap_or(LAMP_HALF_FIELD);
    let picture = inputs::picture(path, &Reading::default(), args.running.memory())?;
    Extent::picture(&picture.light, half_field.to_radians())
        .ok_or_else(|| Failure::Input(format!("{}: the picture is all dark: a lamp needs light", path.display())))
}
