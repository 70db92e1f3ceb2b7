//! `facetmill plan`: which way of making a plate brings its drawing out best.

use std::path::{Path, PathBuf};

use facetmill::job::exports;
use facetmill::job::plan::report::in_short;
use facetmill::job::plan::{Goal, Plan, PlanError, TOLERANCE, Task};
use facetmill::progress::{Event, Progress, Stage};
use facetmill::recipe::{MachiningSettings, Recipe};
use facetmill::report::plan::PlanReport;
use facetmill::report::scores::Scores;
use facetmill::report::text;

use crate::args::PlanArgs;
use crate::console::{Failure, Table, tell};
use crate::files::{Place, Staged};
use crate::interrupt::Run;
use crate::ranges::within;
use crate::stages::Stages;
use crate::tables::{Row, percent, row};
use crate::{inputs, machining};

/// Hours that are believed.
const HOURS: (f64, f64) = (0.001, 10_000.0);

/// Does what `args` say.
pub fn run(args: &PlanArgs, run: &Run) -> Result<(), Failure> {
    inputs::given([Some(&args.picture), None])?;
    let (mut recipe, path) = recipe(args)?;
    recipe.check().map_err(Failure::of_flags)?;
    machining::named(&args.machine, &mut recipe)?;
    let machine = recipe.machining.machine.clone().ok_or_else(|| {
        Failure::Usage("plan is for a machine: name one with --machine, such as vmc or a TOML file".into())
    })?;
    if recipe.is_near() {
        return Err(Failure::Usage(
            "plan is for lamps and walls far away: name a picture, or a folder without them".into(),
        ));
    }
    let (goal, tolerance) = asked(args)?;
    let read = inputs::given([Some(&args.picture), Some(&path)])?;
    let mut staged = Staged::new(&Place::new(&args.output, args.running.force, exports::PLAN, &read), &run.gate)?;
    let memory = args.running.memory();
    let picture = inputs::picture(&path, &recipe.reading(), memory)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    let any_size = !args.settings.has("size");
    let task = Task { recipe: &recipe, any_size, picture: &picture, machine: &machine, goal, tolerance, memory };
    // Once a way is proved, Ctrl-C ends with what there is.
    let plan = task.plan(|_| run.keep(|| ()), &progress).map_err(failure)?;
    run.design_is_over();
    progress.stage(Stage::Files);
    let report = plan.report(&task, Some(path.to_string_lossy().into_owned()));
    write(&mut staged, &plan, &report, &path)?;
    staged.publish()?;
    stages.finish();
    let few = || format!("Ended early: {} of the best ways proved; the others might be better.", plan.best.len());
    let ended = plan.ended_early.then(few);
    tell(&args.running, &report, |report| Table {
        title: report.verdict.clone(),
        rows: in_rows(&plan, report),
        more: Vec::new(),
        notes: ended.iter().chain(&report.helps_most).chain(&report.picture.notes).cloned().collect(),
    })?;
    Ok(())
}

/// What is fixed, and the file of the picture.
fn recipe(args: &PlanArgs) -> Result<(Recipe, PathBuf), Failure> {
    let (mut recipe, path) = match args.picture.is_dir() {
        false => (Recipe::default(), args.picture.clone()),
        true => {
            let file = args.picture.join("recipe.toml");
            let recipe = inputs::recipe(&file)?;
            let path = inputs::picture_of(&recipe, &file)?;
            (fresh(recipe), path)
        }
    };
    machining::cut_for(args.settings.cutter(), &args.machine, &mut recipe)?;
    args.settings.apply(&mut recipe);
    recipe.name_picture(&path);
    Ok((recipe, path))
}

/// Of a design what is no question of making: drawing, lamp, field, rim.
fn fresh(recipe: Recipe) -> Recipe {
    let Recipe { mut plate, mut design, machining, .. } = recipe.clone();
    (plate.cells, plate.facets, plate.grid, plate.surface) = (None, None, None, None);
    design.sheet = Recipe::default().design.sheet;
    (design.flutes, design.worn_tip) = (None, None);
    (design.sample, design.arrange, design.heights, design.annealing) = (None, None, None, None);
    let machining = MachiningSettings { machine: machining.machine, ..MachiningSettings::default() };
    Recipe { plate, design, machining, ..recipe }
}

fn asked(args: &PlanArgs) -> Result<(Goal, f64), Failure> {
    within("polish-tolerance", args.polish_tolerance, (0.0, 0.5))?;
    within("hours", args.hours, HOURS)?;
    within("wanted", args.wanted, (1e-4, 0.5))?;
    let goal = match (args.hours, args.wanted) {
        (Some(hours), _) => Goal::Within(hours),
        (None, Some(wanted)) => Goal::Wanted(wanted),
        // The command line asks for one of them.
        (None, None) => return Err(Failure::Usage("say with --hours how long finishing may take".into())),
    };
    Ok((goal, args.polish_tolerance.unwrap_or(TOLERANCE)))
}

fn failure(error: PlanError) -> Failure {
    match error {
        PlanError::Design(error) => error.into(),
        PlanError::TooFewHours { .. } => Failure::Impossible(format!("--hours: {error}")),
        PlanError::Unreachable { .. } => Failure::Impossible(format!("--wanted: {error}")),
        error => Failure::Impossible(error.to_string()),
    }
}

fn write(staged: &mut Staged, plan: &Plan, report: &PlanReport, path: &Path) -> Result<(), Failure> {
    let drawing = path.file_name().unwrap_or_default().to_string_lossy();
    let heading = format!("{drawing} made by {}: light that is misplaced, over hours", report.machine.name);
    staged.write_png("plan.png", &plan.picture(&heading))?;
    let recipes = ["recipe-1.toml", "recipe-2.toml", "recipe-3.toml"];
    for (name, best) in recipes.into_iter().zip(&plan.best) {
        staged.write_bytes(name, best.recipe.to_toml().as_bytes())?;
    }
    staged.write_bytes("report.json", text(report).as_bytes())?;
    Ok(())
}

/// The ways, two lines each.
fn in_rows(plan: &Plan, report: &PlanReport) -> Vec<Row> {
    let mut rows = Vec::new();
    for (proved, facts) in plan.best.iter().zip(&report.best) {
        rows.push(row(&facts.recipe, "", in_short(proved)));
        let off = percent(proved.polish_off.iter().fold(proved.misplaced(), |most: f64, v| most.max(*v)));
        let (made, expected) = (percent(proved.misplaced()), percent(facts.expected_tv_1deg));
        let likeness = Scores::main(&facts.as_made.scores.ssim);
        rows.push(row(
            "",
            "",
            format!(
                "{:.2} h; {made} misplaced as made ({expected} expected), at most {off} with {:.0} % more or less polish; \
                 likeness {likeness:.3}; limited by {}",
                facts.hours,
                100.0 * report.polish_tolerance,
                facts.limited_by
            ),
        ));
    }
    rows
}
