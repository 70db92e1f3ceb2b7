//! `facetmill design`: a picture becomes a plate.

use std::path::{Path, PathBuf};

use facetmill::goal::spec::GoalSpec;
use facetmill::goal::{Goal, GoalError};
use facetmill::job::design::unavoidable_light;
use facetmill::job::estimate::estimate;
use facetmill::job::{Job, Outcome, Product, exports, memory};
use facetmill::memory::MemoryLimit;
use facetmill::picture::Picture;
use facetmill::progress::{Cancelled, Event, Progress, Stage};
use facetmill::recipe::{Recipe, SurfaceKind};
use facetmill::report::estimate::EstimateReport;
use facetmill::sculpt::checkpoint::Checkpoint;

use crate::args::DesignArgs;
use crate::console::{Failure, Table, tell};
use crate::dry_run::tell_estimate;
use crate::files::{OutputError, Place, Staged};
use crate::interrupt::Run;
use crate::snapshots::{self, Snapshots};
use crate::stages::Stages;
use crate::{inputs, machining, portrait, tables};

/// Does what `args` say.
pub fn run(args: &DesignArgs, run: &Run) -> Result<(), Failure> {
    inputs::given([args.recipe.as_deref(), None])?;
    let (mut recipe, from) = recipe(args)?;
    if recipe.patches.are_wanted() {
        return portrait::run(args, &recipe, args.recipe.as_deref(), run);
    }
    let read = inputs::given([from.path(), args.recipe.as_deref()])?;
    let limit = args.running.memory();
    let Some(folder) = args.output.as_deref().filter(|_| !args.dry_run) else {
        let picture = from.picture(args, &mut recipe, limit)?.0;
        let stray = unavoidable_light(&recipe, &picture.light)?;
        let share = stray.map(|stray| stray.share);
        let about = estimate(&recipe, picture.light.width, !args.no_verify);
        let report = EstimateReport { least_stray_share: share, ..about };
        let need = memory::need(&recipe, picture.light.width, !args.no_verify);
        return tell_estimate(args, &recipe, report, limit.admit(need));
    };
    // Before any work: a folder that cannot be written should not cost a minute.
    let inner: &[_] = if args.snapshots || args.resume { &[snapshots::FOLDER] } else { &[] };
    let own = exports::names();
    let place = Place { inner, goes_on: args.resume, ..Place::new(folder, args.running.force, &own, &read) };
    let mut staged = Staged::new(&place, &run.gate)?;
    if folder.join(snapshots::FOLDER).is_file() && (args.snapshots || args.resume) {
        return Err(OutputError::NotAFolder(folder.join(snapshots::FOLDER)).into());
    }
    let (picture, goal) = from.picture(args, &mut recipe, limit)?;
    recipe.note_drawing(picture.original_size);
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| {
        if matches!(event, Event::Stage(stage, _) if ![Stage::Sculpting, Stage::Room].contains(&stage)) {
            run.design_is_over();
        }
        stages.hear(event);
    };
    let progress = Progress::new(&listen, &run.cancel);
    let job = Job { recipe: &recipe, picture: &picture, proved: !args.no_verify, memory: limit };
    let checkpoint = if args.resume { Some(snapshots::resume(folder, &recipe, &picture.light)?) } else { None };
    let kept = (args.snapshots || args.resume).then(|| Snapshots::new(folder, &recipe, &picture.light));
    let mut made = made(job, checkpoint, kept, run, &progress)?;
    if let Some(goal) = &goal {
        made.prove_goal(goal, &progress)?;
    }
    made.write(&picture, &mut |name, content| Ok::<_, Failure>(staged.write(name, |out| content(out))?), &progress)?;
    staged.publish()?;
    stages.finish();
    tell(&args.running, &made.report(&picture), |report| Table {
        title: report.verdict.clone().unwrap_or_else(|| "Designed; no light was sent over it (--no-verify).".into()),
        rows: tables::design_in_short(folder, report),
        more: tables::design(report),
        notes: [&report.picture.notes[..], &report.advice[..]].concat(),
    })?;
    Ok(())
}

/// What comes of the job, with snapshots on its way if they are wanted.
fn made(
    job: Job,
    from: Option<Checkpoint>,
    mut kept: Option<Snapshots>,
    run: &Run,
    progress: &Progress,
) -> Result<Product, Failure> {
    let outcome = job.run(
        from,
        &mut |distribution, at| {
            let goes_on = run.keep(|| kept.as_mut().is_none_or(|kept| kept.take(distribution, at)));
            match (goes_on, &kept) {
                (true, Some(kept)) => run.snapshots_stay(kept.folder().to_owned()),
                (true, None) => {}
                // There is no need to design to the end what ends in an error.
                (false, _) => run.cancel.abandon(),
            }
        },
        progress,
    );
    kept.map_or(Ok(()), Snapshots::finish)?;
    match outcome? {
        Outcome::Finished(product) | Outcome::FinishedEarly(product) => Ok(product),
        Outcome::Abandoned => Err(Cancelled.into()),
    }
}

/// Where the highlight comes from.
enum From {
    /// A picture's file.
    Picture(PathBuf),
    /// A goal, its file in place.
    Goal(GoalSpec),
    /// A portrait or maps, which the recipe names.
    Patches,
}

impl From {
    fn path(&self) -> Option<&Path> {
        match self {
            Self::Picture(path) => Some(path),
            Self::Goal(spec) => spec.path(),
            Self::Patches => None,
        }
    }

    /// The picture, and the goal whose slice it is; the field that the goal needs is set where none was asked for.
    fn picture(
        &self,
        args: &DesignArgs,
        recipe: &mut Recipe,
        limit: MemoryLimit,
    ) -> Result<(Picture, Option<Goal>), Failure> {
        let spec = match self {
            Self::Picture(path) => return Ok((inputs::picture(path, &recipe.reading(), limit)?, None)),
            Self::Goal(spec) => spec,
            Self::Patches => return Err(Failure::Usage("no picture was given: name one".into())),
        };
        let cannot = |error: GoalError| match spec.path() {
            Some(_) => Failure::Input(error.to_string()),
            None => Failure::Impossible(error.to_string()),
        };
        let goal = Goal::read(spec, recipe.goal_part, recipe.setup().light()).map_err(cannot)?;
        if args.chooses_field() {
            recipe.highlight.half_field = goal.half_field(&recipe.setup()).map_err(cannot)?.into();
        }
        let picture = goal.picture(&recipe.setup()).map_err(cannot)?;
        Ok((picture, Some(goal)))
    }
}

/// The effective recipe, and where its highlight comes from.
fn recipe(args: &DesignArgs) -> Result<(Recipe, From), Failure> {
    let from_file = args.recipe.as_deref().map(inputs::recipe).transpose()?;
    // As text: what is not a number does not equal itself.
    let fault = from_file.as_ref().and_then(|recipe| recipe.check().err()).map(|error| error.to_string());
    let mut recipe = match (from_file, args.surface()) {
        // What a file says of facets is not meant for a sheet that a flag asks for, nor the other way round.
        (Some(recipe), Some(kind)) => recipe.only_for(kind),
        (Some(recipe), None) => recipe,
        (None, _) => args.base(),
    };
    // What flags say of the cutter counts before what the library does.
    machining::cut_for(args.settings.cutter(), &args.machine, &mut recipe)?;
    args.apply(&mut recipe);
    machining::named(&args.machine, &mut recipe)?;
    if let Some(file) = &args.scene {
        recipe.scene.room = Some(inputs::room(file)?);
    }
    let recipe = args.implied(recipe).map_err(Failure::Usage)?;
    if args.method.is_some() && recipe.surface() == SurfaceKind::Sheet {
        let what = "--method is for flat facets, and --surface makes this plate a sheet";
        return Err(Failure::Usage(format!("{what}: leave out one of the two")));
    }
    recipe.check().map_err(|error| {
        // Flags may mend a recipe; what they do not mend is the recipe's fault, and the file is to be named.
        let file = args.recipe.as_deref().filter(|_| fault.as_ref() == Some(&error.to_string()));
        match (error.is_impossible(), file) {
            (true, Some(file)) => Failure::Impossible(format!("{}: {error}", file.display())),
            (false, Some(file)) => Failure::Input(format!("{}: {error}", file.display())),
            (_, None) => Failure::of_flags(error),
        }
    })?;
    if (args.snapshots || args.resume) && recipe.surface() == SurfaceKind::Facets {
        let flag = if args.resume { "--resume" } else { "--snapshots" };
        return Err(Failure::Usage(format!(
            "{flag} is for a sheet, and this plate is one of flat facets: leave it out, or take --surface continuous"
        )));
    }
    let from = match (&recipe.goal, &args.picture, &args.recipe) {
        _ if recipe.patches.are_wanted() => From::Patches,
        (Some(goal), None, file) => From::Goal(goal_beside(args, &recipe, goal, file.as_deref())?),
        (None, Some(path), _) | (Some(_), Some(path), _) => From::Picture(path.clone()),
        (None, None, Some(file)) => From::Picture(inputs::picture_of(&recipe, file)?),
        (None, None, None) => return Err(Failure::Usage("no picture was given: name one".into())),
    };
    if recipe.goal.is_none() && args.goal_part.is_some() {
        return Err(Failure::Usage("--goal-part is for a --goal, and there is none: leave it out".into()));
    }
    Ok((recipe, from))
}

/// The goal, its file beside the recipe's if it is there.
fn goal_beside(args: &DesignArgs, recipe: &Recipe, goal: &GoalSpec, file: Option<&Path>) -> Result<GoalSpec, Failure> {
    if let Some(name) = args.of_picture() {
        let what = "is for a picture, and this plate has a goal in place of one";
        return Err(Failure::Usage(format!("--{name} {what}: leave out one of the two")));
    }
    if recipe.is_near() {
        let what = "--goal is for a lamp and viewers far away";
        return Err(Failure::Usage(format!("{what}: leave out lamp and wall nearby, or draw the highlight")));
    }
    if recipe.design.distribution.level {
        let what = "--level turns the plate, and a goal is for a plate that lies";
        return Err(Failure::Usage(format!("{what}: leave out one of the two")));
    }
    let named = goal.path().filter(|_| args.goal.is_none());
    let beside = file.zip(named).map(|(file, named)| inputs::beside(file, named));
    Ok(beside.filter(|path| path.exists()).map_or_else(|| goal.clone(), |path| goal.with_path(path)))
}
