//! `facetmill design`: a picture becomes a plate.

use std::path::{Path, PathBuf};

use facetmill::job::clock::on_own_threads;
use facetmill::job::compare::FacetComparison;
use facetmill::job::design::unavoidable_light;
use facetmill::job::{FILES, Job, Outcome, Product};
use facetmill::picture::{self, Picture};
use facetmill::progress::{Cancelled, Event, Progress, Stage};
use facetmill::recipe::{Recipe, SurfaceKind};
use facetmill::sculpt::checkpoint::Checkpoint;
use facetmill::sculpt::stages::Sheet;
use facetmill::sharpen::SCORED_AT;
use serde_json::Value;

use crate::args::DesignArgs;
use crate::console::{Failure, Stages, print_json, print_table, row, verdict_rows};
use crate::files::{OutputError, Staged};
use crate::interrupt::Run;
use crate::snapshots::{self, Snapshots};
use crate::{estimate, inputs};

/// Does what `args` say.
pub fn run(args: &DesignArgs, run: &Run) -> Result<(), Failure> {
    let (recipe, path) = recipe(args)?;
    let (to_json, quiet) = (args.running.json, args.running.quiet);
    let Some(folder) = args.output.as_deref().filter(|_| !args.dry_run) else {
        let picture = picture::read(&path, &recipe.reading())?;
        let stray = unavoidable_light(&recipe, &picture.light)?;
        return Ok(estimate::tell(&recipe, stray, !args.no_verify, to_json, quiet)?);
    };
    // Before any work: a folder that cannot be written should not cost a minute.
    let may_replace = args.running.force || (args.resume && snapshots::are_all(folder));
    let mut staged = Staged::new(folder, may_replace, FILES, &run.gate)?;
    if folder.join(snapshots::FOLDER).is_file() && (args.snapshots || args.resume) {
        return Err(OutputError::NotAFolder(folder.join(snapshots::FOLDER)).into());
    }
    let mut picture = picture::read(&path, &recipe.reading())?;
    if recipe.picture.is_none() {
        let note = "The picture's name is not Unicode, so recipe.toml is without it: name it beside --recipe.";
        picture.notes.push(note.into());
    }
    let stages = Stages::new(quiet);
    let listen = |event: Event<'_>| {
        if matches!(event, Event::Stage(stage, _) if stage != Stage::Sculpting) {
            run.design_is_over();
        }
        stages.hear(event);
    };
    let progress = Progress::new(&listen, &run.cancel);
    let job = Job { recipe: &recipe, picture: &picture, proved: !args.no_verify };
    let from = if args.resume { Some(snapshots::resume(folder, &recipe, &picture.light)?) } else { None };
    let kept = (args.snapshots || args.resume).then(|| Snapshots::new(folder, &recipe, &picture.light));
    let work = || {
        let made = made(job, from, kept, run, &progress)?;
        made.write(
            &picture,
            &mut |name, content| Ok::<_, Failure>(staged.write(name, |out| content(out))?),
            &progress,
        )?;
        Ok::<_, Failure>(made)
    };
    let (made, _) = on_own_threads(args.running.threads, work)
        .map_err(|error| Failure::Impossible(format!("no threads can be started ({error}): lower --threads")))?;
    let made = made?;
    staged.publish()?;
    stages.finish();
    let report = made.report(&picture);
    if to_json {
        print_json(&report)?;
    } else if !quiet {
        print_result(folder, &picture, &made, &report)?;
    }
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
    let path = match (&args.picture, &recipe.picture, &args.recipe) {
        (Some(path), _, _) => path.clone(),
        (None, Some(name), _) if !name.is_empty() => PathBuf::from(name),
        (None, _, Some(file)) => {
            let name = file.display();
            return Err(Failure::Input(format!("{name}: the recipe names no picture: give one on the command line")));
        }
        (None, _, None) => return Err(Failure::Usage("no picture was given: name one".into())),
    };
    Ok((recipe, path))
}

fn print_result(folder: &Path, picture: &Picture, product: &Product, report: &Value) -> Result<(), OutputError> {
    let Product { recipe, design: made, proof, comparison } = product;
    let [width, height] = recipe.plate.size;
    let (low, high) = made.relief.height_range();
    let pitch = made.sheet.as_ref().map_or_else(|| recipe.pitch(), |s| s.relief.step());
    let each = if made.sheet.is_some() { "nodes every" } else { "each" };
    let mut table = vec![
        row(
            "plate",
            format!("{width} × {height} mm"),
            format!("of {}, {each} {:.3} × {:.3} mm", product.made_of(), pitch.x, pitch.y),
        ),
        row("relief", format!("{:.3} mm", high - low), "from its lowest to its highest point"),
    ];
    if let Some(facets) = &made.facets {
        let (steps, valleys) = (format!("{:.4} mm", facets.steps.rms), facets.steps.inner_valleys.to_string());
        table.push(row("steps", steps, "between neighbours, root mean square; 0 is seamless"));
        table.push(row("valleys", valleys, "edges inside the plate where a cutter leaves its radius"));
    }
    let normal = made.distribution.setup.plate_normal();
    if normal.z < 1.0 {
        let toward = normal.y.atan2(normal.x).to_degrees();
        let tilt = format!("{:.2}°", normal.z.acos().to_degrees());
        table.push(row("mount", tilt, format!("tilted so, its normal toward azimuth {toward:.1}°")));
    }
    if let Some(worth) = made.sharpening {
        let tv = format!("{:.2} %", 100.0 * worth.after);
        let without = 100.0 * worth.before;
        let what = format!("misplaced by lamp and metal, seen at {SCORED_AT}°; {without:.2} % if not sharpened");
        table.push(row("blur (TV)", tv, what));
    }
    if let Some(proof) = proof {
        table.extend(verdict_rows(&proof.verdict));
        if let Some(sheet) = &proof.sheet {
            let half = sheet.windows.half_cell.mean;
            let whole = format!("{:.2} %", 100.0 * sheet.windows.cell.largest);
            table.push(row(
                "window of a cell",
                whole,
                format!("misplaced, anywhere on the plate; half a cell: {:.0} %", 100.0 * half),
            ));
            let share = format!("{:.2} %", 100.0 * sheet.diffracted);
            table.push(row("small mirrors", share, "of the light comes from patches that diffract it by more than 1°"));
        }
        if let Some(milled) = &proof.milled {
            let main = milled.verdict.main();
            let left = format!("{:.2} µm", 1000.0 * milled.left);
            table.push(row("left by cutter", left, "at the most, above the written surface"));
            let tv = format!("{:.2} %", 100.0 * main.tv_incident.value);
            table.push(row("misplaced as milled", tv, format!("likeness {:.3}", main.ssim.value)));
        }
        if let Some(FacetComparison { facets: [across, up], flat, continuous, milled }) = comparison {
            let (other, score, what) = match made.sheet {
                Some(_) => ("flat facets", flat, format!("{across} × {up} of them")),
                None => ("sheet", continuous, "one sheet".into()),
            };
            let (tv, how) = (format!("{:.2} %", 100.0 * score.misplaced), if *milled { ", milled alike" } else { "" });
            table.push(row(other, tv, format!("misplaced by {what} instead{how}")));
        }
    }
    if let Some([done, all]) = made.sheet.as_ref().and_then(Sheet::stopped_early) {
        table.push(row("stopped early", format!("{done} of {all}"), "steps of the design were done"));
    }
    let cpu: f64 = made.seconds.iter().map(|(_, s)| s).sum();
    table.push(row("design", format!("{cpu:.2} s"), "of CPU time, before tracing"));
    let advice = report["advice"].as_array().into_iter().flatten().filter_map(Value::as_str).map(Into::into);
    let notes: Vec<String> = picture.notes.iter().cloned().chain(advice).collect();
    let look = if proof.is_some() { "; look at comparison.png first" } else { "" };
    let triangles = made.mesh.triangles.len();
    print_table(&format!("Wrote {}: plate.stl of {triangles} triangles{look}", folder.display()), &table, &notes)
}
