//! `facetmill design --portrait` and by maps: a picture that stands on the plate.

use std::path::{Path, PathBuf};

use facetmill::job::exports;
use facetmill::job::patch_estimate::estimate_patches;
use facetmill::job::patches::{Asked, PatchError, design_patches, need, on_patches, tones};
use facetmill::memory::MemoryLimit;
use facetmill::patches::maps::Maps;
use facetmill::picture::{Picture, values};
use facetmill::progress::Progress;
use facetmill::raster::Raster;
use facetmill::recipe::Recipe;
use facetmill::report::patches::{PatchFacts, PatchScoreFacts, PatchesReport, ReachableFacts};

use crate::args::DesignArgs;
use crate::console::{Failure, Table, tell};
use crate::dry_run::tell_estimate;
use crate::files::{Place, Staged};
use crate::inputs;
use crate::interrupt::Run;
use crate::stages::Stages;
use crate::tables::{Row, percent, row, shown, told};

impl From<PatchError> for Failure {
    fn from(error: PatchError) -> Self {
        match error {
            PatchError::Cancelled(cancelled) => cancelled.into(),
            error @ (PatchError::Aspect { .. } | PatchError::Size { .. }) => Self::Input(error.to_string()),
            error => Self::Impossible(error.to_string()),
        }
    }
}

/// Does what `args` say for `recipe`, whose files are looked for beside `file` too.
pub fn run(args: &DesignArgs, recipe: &Recipe, file: Option<&Path>, run: &Run) -> Result<(), Failure> {
    if let Some(flag) = foreign(args) {
        return Err(Failure::Usage(format!("--{flag} is not for a plate of patches: leave it out")));
    }
    let limit = args.running.memory();
    let Some(folder) = args.output.as_deref().filter(|_| !args.dry_run) else {
        // Its files are read all the same: what is wrong with them is worth knowing.
        asked(recipe, &|name| beside(name, file), limit)?;
        let admitted = limit.admit(need(&recipe.patches()));
        return tell_estimate(args, recipe, estimate_patches(recipe, !args.no_verify), admitted);
    };
    let paths: Vec<PathBuf> = named(recipe).map(|(_, name)| beside(name, file)).collect();
    let mut read: Vec<&Path> = paths.iter().map(PathBuf::as_path).chain(file).collect();
    read.dedup();
    let own = exports::names();
    let mut staged = Staged::new(&Place::new(folder, args.running.force, &own, &read), &run.gate)?;
    let (asked, picture) = asked(recipe, &|name| beside(name, file), limit)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: facetmill::progress::Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    let made = design_patches(recipe, &asked, !args.no_verify, limit, &progress)?;
    let keep = &mut |name, content: facetmill::job::Content| Ok::<_, Failure>(staged.write(name, |out| content(out))?);
    let report = made.report(picture.as_ref());
    made.write(&report, keep, &progress)?;
    staged.publish()?;
    stages.finish();
    tell(&args.running, &report, |report| Table {
        title: report.verdict.clone().unwrap_or_else(|| "Designed; nobody looked at it (--no-verify).".into()),
        rows: in_short(folder, report),
        more: more(report),
        notes: [report.picture.as_ref().map(|picture| &picture.notes[..]).unwrap_or(&[]), &report.advice[..]].concat(),
    })?;
    Ok(())
}

/// A flag that has no meaning here.
fn foreign(args: &DesignArgs) -> Option<&'static str> {
    let given = [
        (args.picture.is_some(), "portrait and PICTURE: one of the two"),
        (args.goal.is_some(), "goal"),
        (args.goal_part.is_some(), "goal-part"),
        (args.method.is_some(), "method"),
        (args.scene.is_some(), "scene"),
        (args.snapshots, "snapshots"),
        (args.resume, "resume"),
    ];
    given.into_iter().find_map(|(given, flag)| given.then_some(flag))
}

/// The files that a recipe names, by their settings.
pub fn named(recipe: &Recipe) -> impl Iterator<Item = (&'static str, &str)> {
    let patches = &recipe.patches;
    let all = [
        ("portrait", &patches.portrait),
        ("gloss", &patches.gloss),
        ("normal", &patches.normal),
        ("anisotropy", &patches.anisotropy),
        ("albedo", &patches.albedo),
    ];
    all.into_iter().filter_map(|(setting, name)| Some((setting, name.as_deref()?)))
}

/// The file beside the recipe's, if it is there.
fn beside(name: &str, recipe: Option<&Path>) -> PathBuf {
    let near = recipe.map(|recipe| inputs::beside(recipe, Path::new(name)));
    near.filter(|path| path.exists()).unwrap_or_else(|| name.into())
}

/// What is to be shown, and the picture of a portrait; `place` is where a file of that name is.
pub fn asked(
    recipe: &Recipe,
    place: &dyn Fn(&str) -> PathBuf,
    limit: MemoryLimit,
) -> Result<(Asked, Option<Picture>), Failure> {
    if let Some(name) = &recipe.patches.portrait {
        let picture = inputs::picture(&place(name), &recipe.reading(), limit)?;
        let tones = tones(recipe, &picture.light, picture.original_size)?;
        return Ok((Asked::Portrait(tones), Some(picture)));
    }
    let mut maps = Maps::default();
    for (setting, name) in named(recipe) {
        let channels = values(&place(name))?;
        let on = |channel: &Raster| on_patches(recipe, channel, name);
        let [red, green, blue] = [on(&channels[0])?, on(&channels[1])?, on(&channels[2])?];
        match setting {
            "gloss" => maps.gloss = Some(mean(&red, &green, &blue)),
            "albedo" => maps.albedo = Some(mean(&red, &green, &blue)),
            "normal" => maps.normal = Some([red, green, blue]),
            _ => maps.anisotropy = Some([red, green, blue]),
        }
    }
    Ok((Asked::Maps(Box::new(maps)), None))
}

/// Of a coloured map of one number, the mean of its colours.
fn mean(red: &Raster, green: &Raster, blue: &Raster) -> Raster {
    Raster::from_fn(red.width, red.height, |x, y| (red.at(x, y) + green.at(x, y) + blue.at(x, y)) / 3.0)
}

fn in_short(folder: &Path, report: &PatchesReport) -> Vec<Row> {
    let PatchFacts { count: [columns, rows], size_mm: [x, y], relief_height_mm, .. } = report.patches;
    let [width, height] = report.recipe.plate.size;
    let mut told_of = vec![told(
        "plate",
        format!(
            "{width} × {height} mm of {columns} × {rows} patches of {x:.2} × {y:.2} mm, relief {relief_height_mm:.3} mm"
        ),
    )];
    told_of.extend(report.reachable.as_ref().map(contrast));
    told_of.extend(report.designed.iter().map(|scores| looks("as written", scores)));
    told_of.extend(report.as_milled.iter().map(|scores| looks("as cut", scores)));
    let (triangles, megabytes) = (report.stl.triangles, report.stl.bytes as f64 / 1e6);
    told_of
        .push(told("file", format!("{}, {triangles} triangles, {megabytes:.1} MB", shown(&folder.join("plate.stl")))));
    let first = match (&report.as_milled, &report.designed) {
        (Some(_), _) => "comparison_milled.png",
        (None, Some(_)) => "comparison.png",
        (None, None) => "target.png",
    };
    told_of.push(told("look", format!("at {} first; --verbose tells more", shown(&folder.join(first)))));
    told_of
}

/// What a portrait can show.
pub fn contrast(reachable: &ReachableFacts) -> Row {
    let ReachableFacts { white, black, contrast } = reachable;
    told("contrast", format!("{contrast:.0} to 1; white is {white:.3}/sr, black {black:.4}/sr"))
}

/// How near a plate looks to what is wanted.
pub fn looks(name: &str, scores: &PatchScoreFacts) -> Row {
    let likeness = scores.scores.ssim.map(|ssim| format!("likeness {ssim:.3}, ")).unwrap_or_default();
    told(name, format!("{likeness}{} of the light in other patches", percent(scores.scores.tv)))
}

fn more(report: &PatchesReport) -> Vec<Row> {
    let facts = &report.patches;
    let mut rows = vec![
        row("nodes", facts.nodes.to_string(), "along each side of a patch"),
        row("walls", format!("{:.2}°", facts.walls_deg), "tilt of what throws light past the viewer"),
        row(
            "lobe",
            format!("{:.2}°", facts.lobe_deg[0]),
            "half width of a bowl's slopes; the picture holds twice as far around",
        ),
        row("metal", format!("{}°", facts.metal_lobe_deg), "its own scatter"),
        row(
            "largest bowls",
            percent(facts.most_share[0]),
            format!("of a patch at least, {} at most", percent(facts.most_share[1])),
        ),
        row("bowls", percent(facts.bowls_share), "of the plate; the rest is walls"),
        row("sharpest bowl", format!("{:.3} mm", facts.sharpest_bowl_mm), "radius"),
        row(
            "diffraction",
            format!("{:.3}°", facts.diffraction_deg[0]),
            format!("spreads a whole patch's light, {:.3}° the smallest bowl's", facts.diffraction_deg[1]),
        ),
    ];
    rows.extend(
        facts.spare_share.map(|share| row("spare", percent(share), "of the plate sends light where --spare says")),
    );
    rows.extend([("as written", &report.designed), ("as cut", &report.as_milled)].into_iter().flat_map(in_full));
    rows
}

/// Every figure of how a plate looks, if it was looked at.
pub fn in_full((name, scores): (&'static str, &Option<PatchScoreFacts>)) -> Vec<Row> {
    let Some(PatchScoreFacts { scores, left_mm, paths_a_pixel, .. }) = scores else { return Vec::new() };
    let noise = format!("of white, of one patch; {paths_a_pixel} paths a pixel");
    let mut rows = vec![
        row(name, format!("{:.4}", scores.light), "light of all patches over the wanted"),
        row("noise", percent(scores.noise), noise),
    ];
    rows.extend(left_mm.map(|left| row("left", format!("{left:.4} mm"), "by the cutter at the most")));
    rows
}
