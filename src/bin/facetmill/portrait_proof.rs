//! `facetmill verify` of the folder of a plate of patches: the viewer looks at its file once more.

use std::path::{Path, PathBuf};

use facetmill::job::patch_check::{FoundPlate, check_patches};
use facetmill::job::patches::PatchProduct;
use facetmill::memory::Need;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::recipe::Recipe;
use facetmill::report::patches::{AllowedInPatches, PatchesVerifyReport};
use facetmill::report::text;
use facetmill::verify::verdict::MAIN_BLUR;

use crate::against::folder;
use crate::args::VerifyArgs;
use crate::console::{Failure, Table, tell};
use crate::files::Staged;
use crate::interrupt::Run;
use crate::plates::Named;
use crate::portrait::{asked, contrast, in_full, looks, named};
use crate::stages::Stages;
use crate::tables::{Row, percent, row, shown, told};
use crate::{inputs, plates};

/// Does what `args` say of the folder of a plate of patches, whose STL and recipe were found.
pub fn run(args: &VerifyArgs, found: Named, run: &Run) -> Result<(), Failure> {
    let Named { stl, recipe: mut designed, .. } = found;
    if let Some(what) = foreign(args) {
        return Err(Failure::Usage(format!("{what} is not for a plate of patches: leave it out")));
    }
    if args.against.is_some() && designed.patches.portrait.is_none() {
        let what = "--against names the picture of a portrait, and this plate of patches is one by maps";
        return Err(Failure::Usage(format!("{what}: leave it out")));
    }
    let files = files(args, &designed)?;
    if let Some(path) = &args.against {
        designed.patches.portrait = Some(path.to_string_lossy().into_owned());
    }
    let mut recipe = designed.clone();
    args.settings.apply(&mut recipe);
    recipe.check().map_err(Failure::of_flags)?;
    let read: Vec<&Path> = files.iter().map(|(_, path)| path.as_path()).chain([args.plate.as_path()]).collect();
    let staged = folder(args, &read, run)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Reading);
    let limit = args.running.memory();
    let margin = plates::margin(args.margin, &args.plate, &recipe);
    let nothing = Need::new(0.0, "looking at the plate", "decimate its mesh");
    let opened = plates::open(&stl, margin, &args.placing, (limit, nothing), &progress)?;
    let place = |name: &str| files.iter().find(|(own, _)| own == name).map_or(name.into(), |(_, path)| path.clone());
    let (asked, picture) = asked(&designed, &place, limit)?;
    let plate = FoundPlate { mesh: &opened.mesh, margin, recipe: &recipe };
    let checked = check_patches(&designed, &asked, plate, limit, &progress)?;
    let mut report = checked.verified(opened.facts, picture.as_ref(), args.at_most.map(|limit| limit.share));
    report.advice.splice(..0, opened.advice);
    if let Some(mut staged) = staged {
        progress.stage(Stage::Files);
        write(&mut staged, &checked, &report)?;
        staged.publish()?;
    }
    stages.finish();
    tell(&args.running, &report, |report| Table {
        title: report.verdict.clone().unwrap_or_default(),
        rows: in_short(args.output.as_deref(), report),
        more: more(report),
        notes: [report.picture.as_ref().map(|picture| &picture.notes[..]).unwrap_or(&[]), &report.advice[..]].concat(),
    })?;
    within_limit(report.at_most)
}

/// What was given and has no meaning here.
fn foreign(args: &VerifyArgs) -> Option<&'static str> {
    let making = &args.machining;
    let given = [
        (making.by.machine.is_some(), "--machine"),
        (making.cutter.is_some(), "--cutter"),
        (making.by.cutters.is_some(), "--cutters"),
        (making.polish.is_some(), "--polish"),
        (args.scene.is_some(), "--scene"),
        (args.goal.is_some() || args.goal_part.is_some(), "--goal"),
        (args.mount.is_some(), "--mount"),
        (args.at_most.is_some_and(|limit| limit.blur != MAIN_BLUR), "a blur behind --at-most"),
    ];
    given.into_iter().find_map(|(given, what)| given.then_some(what))
}

/// The files that the recipe names, and where they are: of a portrait as given, else near the folder.
fn files(args: &VerifyArgs, recipe: &Recipe) -> Result<Vec<(String, PathBuf)>, Failure> {
    if let Some(path) = &args.against {
        return Ok(vec![(path.to_string_lossy().into_owned(), path.clone())]);
    }
    let found = |(setting, name): (&str, &str)| match inputs::near_folder(&args.plate, Path::new(name)) {
        Some(path) => Ok((name.to_owned(), path)),
        None => {
            let or = if setting == "portrait" { ": say with --against where it is" } else { ": put it back" };
            let folder = args.plate.display();
            Err(Failure::Input(format!(
                "{folder}: {name}, which its recipe names as {setting}, is neither in the folder nor beside it nor here{or}"
            )))
        }
    };
    named(recipe).map(found).collect()
}

fn write(staged: &mut Staged, checked: &PatchProduct, report: &PatchesVerifyReport) -> Result<(), Failure> {
    let keep = &mut |name, content: facetmill::job::Content| Ok::<_, Failure>(staged.write(name, |out| content(out))?);
    checked.write_pictures(keep)?;
    Ok(staged.write_bytes("report.json", text(report).as_bytes())?)
}

fn in_short(folder: Option<&Path>, report: &PatchesVerifyReport) -> Vec<Row> {
    let [width, height, _] = report.plate.size_mm;
    let (triangles, relief) = (report.plate.triangles, report.plate.relief_height_mm);
    let mut rows =
        vec![told("plate", format!("{width:.2} × {height:.2} mm of {triangles} triangles, relief {relief:.3} mm"))];
    rows.extend(report.reachable.as_ref().map(contrast));
    rows.extend(report.measured.iter().map(|scores| looks("as written", scores)));
    rows.extend(report.as_milled.iter().map(|scores| looks("as cut", scores)));
    let picture = if report.as_milled.is_some() { "comparison_milled.png" } else { "comparison.png" };
    rows.push(told(
        "look",
        match folder {
            Some(folder) => format!("at {} first; --verbose tells more", shown(&folder.join(picture))),
            None => "with -o DIR there are pictures; --verbose tells more".into(),
        },
    ));
    rows
}

fn more(report: &PatchesVerifyReport) -> Vec<Row> {
    let both = [("as written", &report.measured), ("as cut", &report.as_milled)];
    let mut rows: Vec<Row> = both.into_iter().flat_map(in_full).collect();
    if let Some(allowed) = &report.at_most {
        let kept = if allowed.kept { "kept" } else { "not kept" };
        rows.push(row("allowed", percent(allowed.tv), format!("at most {}: {kept}", percent(allowed.share))));
    }
    rows
}

/// Whether no more light is in other patches than was allowed, if a limit was given.
fn within_limit(allowed: Option<AllowedInPatches>) -> Result<(), Failure> {
    match allowed {
        Some(allowed) if !allowed.kept => Err(Failure::Beyond(format!(
            "{} of the light is in other patches than it should be{}, more than the {} of --at-most",
            percent(allowed.tv),
            if allowed.as_milled { " as milled" } else { "" },
            percent(allowed.share)
        ))),
        _ => Ok(()),
    }
}
