//! `facetmill design`: a picture becomes a plate.

use std::path::PathBuf;

use facetmill::job::design::unavoidable_light;
use facetmill::job::estimate::estimate;
use facetmill::job::{Job, Outcome, Product, exports, memory};
use facetmill::progress::{Cancelled, Event, Progress, Stage};
use facetmill::recipe::{Recipe, SurfaceKind};
use facetmill::report::estimate::EstimateReport;
use facetmill::sculpt::checkpoint::Checkpoint;

use crate::args::DesignArgs;
use crate::console::{Failure, Table, tell};
use crate::files::{OutputError, Place, Staged};
use crate::interrupt::Run;
use crate::snapshots::{self, Snapshots};
use crate::stages::Stages;
use crate::{inputs, machining, tables};

/// Does what `args` say.
pub fn run(args: &DesignArgs, run: &Run) -> Result<(), Failure> {
    inputs::given([args.recipe.as_deref(), None])?;
    let (mut recipe, path) = recipe(args)?;
    let read = inputs::given([Some(&path), args.recipe.as_deref()])?;
    let limit = args.running.memory();
    let Some(folder) = args.output.as_deref().filter(|_| !args.dry_run) else {
        let picture = inputs::picture(&path, &recipe.reading(), limit)?;
        let stray = unavoidable_light(&recipe, &picture.light)?;
        let share = stray.map(|stray| stray.share);
        let report =
            EstimateReport { least_stray_share: share, ..estimate(&recipe, picture.light.width, !args.no_verify) };
        let refused = limit.admit(memory::need(&recipe, picture.light.width, !args.no_verify)).err();
        tell(&args.running, &report, |report| Table {
            title: "Dry run: nothing was designed or written".into(),
            rows: tables::estimate(&recipe, report),
            notes: refused.iter().map(|refused| format!("This would be refused: {refused}.")).collect(),
            ..Table::default()
        })?;
        return Ok(());
    };
    // Before any work: a folder that cannot be written should not cost a minute.
    let inner: &[_] = if args.snapshots || args.resume { &[snapshots::FOLDER] } else { &[] };
    let own = exports::names();
    let place = Place { inner, goes_on: args.resume, ..Place::new(folder, args.running.force, &own, &read) };
    let mut staged = Staged::new(&place, &run.gate)?;
    if folder.join(snapshots::FOLDER).is_file() && (args.snapshots || args.resume) {
        return Err(OutputError::NotAFolder(folder.join(snapshots::FOLDER)).into());
    }
    let picture = inputs::picture(&path, &recipe.reading(), limit)?;
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
    let from = if args.resume { Some(snapshots::resume(folder, &recipe, &picture.light)?) } else { None };
    let kept = (args.snapshots || args.resume).then(|| Snapshots::new(folder, &recipe, &picture.light));
    let made = made(job, from, kept, run, &progress)?;
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

/// The effective recipe, and the file of its picture.
fn recipe(args: &DesignArgs) -> Result<(Recipe, PathBuf), Failure> {
    let from_file = args.recipe.as_deref().map(inputs::recipe).transpose()?;
    // As text: what is not a number does not equal itself.
    let fault = from_file.as_ref().and_then(|recipe| recipe.check().err()).map(|error| error.to_string());
    let mut recipe = match (from_file, args.surface()) {
        // What a file says of facets is not meant for a sheet that a flag asks for, nor the other way round.
        (Some(recipe), Some(kind)) => recipe.only_for(kind),
        (Some(recipe), None) => recipe,
        (None, _) => args.base(),
    };
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
            (true, None) => Failure::Impossible(error.to_string()),
            (true, Some(file)) => Failure::Impossible(format!("{}: {error}", file.display())),
            (false, Some(file)) => Failure::Input(format!("{}: {error}", file.display())),
            (false, None) => Failure::Usage(format!("--{error}")),
        }
    })?;
    if (args.snapshots || args.resume) && recipe.surface() == SurfaceKind::Facets {
        let flag = if args.resume { "--resume" } else { "--snapshots" };
        return Err(Failure::Usage(format!(
            "{flag} is for a sheet, and this plate is one of flat facets: leave it out, or take --surface continuous"
        )));
    }
    let path = match (&args.picture, &args.recipe) {
        (Some(path), _) => path.clone(),
        (None, Some(file)) => inputs::picture_of(&recipe, file)?,
        (None, None) => return Err(Failure::Usage("no picture was given: name one".into())),
    };
    Ok((recipe, path))
}
