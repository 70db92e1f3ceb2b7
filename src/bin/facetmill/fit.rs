//! `facetmill fit`: models of reflectance fitted to a measured one.

use std::path::{Path, PathBuf};

use facetmill::brdf::model::Model;
use facetmill::export::polar_slices::{PolarCurve, STEPS, polar_diagram};
use facetmill::fit::{Fitted, Samples, fit};
use facetmill::glam::DVec3;
use facetmill::goal::Goal;
use facetmill::goal::spec::{GoalFile, GoalPart, GoalSpec};
use facetmill::job::exports;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::report::fit::{FitFacts, FitReport, Parameter};
use facetmill::report::{PROGRAM, text};
use facetmill::slope::direction;

use crate::args::FitArgs;
use crate::console::{Failure, Table, tell};
use crate::files::{Place, Staged};
use crate::inputs;
use crate::interrupt::Run;
use crate::stages::Stages;
use crate::tables::row;

/// Polar angles of the slices that are drawn, degrees.
const DRAWN: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];

/// Fits that are told without --verbose, and drawn.
const SHORT: usize = 3;

/// Does what `args` say.
pub fn run(args: &FitArgs, run: &Run) -> Result<(), Failure> {
    let (kind, path) = data(&args.data)?;
    let read = inputs::given([Some(&path), None])?;
    let mut staged = Staged::new(&Place::new(&args.output, args.running.force, exports::FIT, &read), &run.gate)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Reading);
    let spec = GoalSpec::File { kind, path: path.clone(), tilt: None };
    let goal = Goal::read(&spec, GoalPart::All, DVec3::Z).map_err(|error| Failure::Input(error.to_string()))?;
    let dark = || Failure::Input(format!("{}: nothing in it reflects any light; measure it again", path.display()));
    let samples = Samples::new(|wi, wo| goal.value(wi, wo), goal.is_isotropic).ok_or_else(dark)?;
    progress.stage(Stage::Scoring);
    let fits = fit(&samples, &progress)?;
    progress.stage(Stage::Files);
    for (name, found) in ["fit.png", "fit_2.png", "fit_3.png"].into_iter().zip(&fits) {
        staged.write_png(name, &picture(&goal, found))?;
    }
    let report = FitReport {
        program: PROGRAM,
        file: path.to_string_lossy().into_owned(),
        directions: samples.len(),
        isotropic: samples.is_isotropic(),
        notes: goal.notes.clone(),
        fits: fits.iter().map(facts).collect(),
    };
    staged.write_bytes("report.json", text(&report).as_bytes())?;
    staged.publish()?;
    stages.finish();
    tell(&args.running, &report, |report| {
        let told = |fit: &FitFacts| row(&format!("{:.4}", fit.error), "", fit.spec.clone());
        Table {
            title: report.fits.first().map_or("No model fits.".into(), |best| {
                format!("Best of {}: {} (error {:.4}, ranked by it below).", report.fits.len(), best.spec, best.error)
            }),
            rows: report.fits.iter().take(SHORT).map(told).collect(),
            more: report
                .fits
                .iter()
                .skip(SHORT)
                .map(told)
                .chain(report.fits.iter().take(SHORT).flat_map(numbers))
                .collect(),
            notes: report.notes.clone(),
        }
    })?;
    Ok(())
}

/// The numbers of a fit with their standard errors.
fn numbers(fit: &FitFacts) -> Vec<crate::tables::Row> {
    let told = |own: &Parameter| row(&own.name, "", format!("{:.5} ± {:.5}", own.value, own.standard_error));
    fit.parameters.iter().map(told).collect()
}

/// What of the data is read, and as what.
fn data(path: &Path) -> Result<(GoalFile, PathBuf), Failure> {
    if !path.exists() {
        return Err(Failure::Input(format!("{}: there is no such file or folder", path.display())));
    }
    if path.is_dir() {
        return Ok((GoalFile::Csv, path.join("brdf.csv")));
    }
    match path.extension().and_then(|end| end.to_str()).map(str::to_lowercase).as_deref() {
        Some("binary") => Ok((GoalFile::Merl, path.to_owned())),
        Some("bsdf") => Ok((GoalFile::Bsdf, path.to_owned())),
        Some("csv") => Ok((GoalFile::Csv, path.to_owned())),
        _ => Err(Failure::Input(format!(
            "{}: this is no BRDF that is read; name a MERL .binary, an RGL .bsdf, a brdf.csv, or a folder of measure --brdf",
            path.display()
        ))),
    }
}

fn facts(found: &Fitted) -> FitFacts {
    let parameter = |(name, value, error): &(String, f64, f64)| Parameter {
        name: name.clone(),
        value: *value,
        standard_error: *error,
    };
    FitFacts {
        spec: found.model.to_string(),
        lobes: found.lobes,
        error: found.error,
        parameters: found.parameters.iter().map(parameter).collect(),
    }
}

/// Slices of data and fit in one diagram.
fn picture(goal: &Goal, found: &Fitted) -> facetmill::image::RgbImage {
    let curve = |theta: f64, dashed: bool| {
        let wi = direction(theta.to_radians(), 0.0);
        let value = |k: usize| {
            let wo = direction((k as f64 / STEPS as f64 - 0.5) * std::f64::consts::PI, 0.0);
            if dashed { goal.value(wi, wo) } else { found.model.value(wi, wo) }
        };
        PolarCurve { theta: theta.to_radians(), values: (0..=STEPS).map(value).collect(), dashed }
    };
    let curves: Vec<PolarCurve> =
        DRAWN.into_iter().flat_map(|theta| [curve(theta, false), curve(theta, true)]).collect();
    polar_diagram(&curves, 0.0, &format!("data dashed, fit solid: {}", found.model))
}
