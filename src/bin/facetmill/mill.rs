//! `facetmill mill`: the programs by which a shop makes a plate.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use facetmill::cutter::Cutter;
use facetmill::export::pixels::encode_png;
use facetmill::glam::{DVec2, DVec3};
use facetmill::image::RgbImage;
use facetmill::job::design::DesignError;
use facetmill::job::findings::MadeProof;
use facetmill::job::made::{Lighting, prove_along};
use facetmill::job::pictures::ProofPictures;
use facetmill::job::{exports, in_a_sentence};
use facetmill::memory::{MemoryLimit, Need};
use facetmill::milling::made::Machining;
use facetmill::milling::passes::Ways;
use facetmill::milling::roughing::Roughing;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::recipe::{BorderFinish, PassAngle, Recipe};
use facetmill::relief::depth::depth_about_plane;
use facetmill::report::mill::MillReport;
use facetmill::report::text;
use facetmill::shop::blank::Blank;
use facetmill::shop::feeds::Spindle;
use facetmill::shop::programs::{Shop, ShopError, ShopFile, usual_dialect, usual_roughing};
use facetmill::shop::sheet::Sheet;

use crate::args::MillArgs;
use crate::console::{Failure, Table, tell};
use crate::drawn::Drawn;
use crate::files::{Place, Staged};
use crate::interrupt::Run;
use crate::plates::{Named, Opened};
use crate::ranges::within;
use crate::stages::Stages;
use crate::{drawn, inputs, machining, mill_tables, plates, program_check};

/// Bytes of a program for each place of a pass, at the most: a segment each, of twenty letters, and its moves once read.
const PLACE: f64 = 300.0;

/// What roughing leaves standing, mm: more than a flat end's steps between two levels are off over a relief's slopes.
const ALLOWANCE: f64 = 0.1;

/// Does what `args` say.
pub fn run(args: &MillArgs, run: &Run) -> Result<(), Failure> {
    check(args)?;
    match (&args.check, &args.output) {
        (Some(file), _) => program_check::run(args, file, run),
        (None, Some(output)) => written(args, output, run),
        // The command line asks for it.
        (None, None) => Err(Failure::Usage("say with -o into which folder the programs go".into())),
    }
}

/// Programs for the plate, into the folder `output`.
fn written(args: &MillArgs, output: &Path, run: &Run) -> Result<(), Failure> {
    let plate = args.the_plate();
    inputs::given([Some(plate), None])?;
    inputs::given([Some(plate), None])?;
    let Named { stl, mut recipe, mount } = plates::named(plate)?;
    let machining = asked(args, &mut recipe)?;
    let read = inputs::given([Some(plate), None])?;
    plates::spare_design(plate, output)?;
    let mut staged = Staged::new(&Place::new(output, args.running.force, exports::MILL, &read), &run.gate)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Reading);
    if recipe.design.sheet.preview {
        return Err(Failure::Impossible(format!(
            "{} is a preview, no plate to be made: design it without --preview",
            plate.display()
        )));
    }
    let margin = plates::margin(args.margin, plate, &recipe);
    let limit = args.running.memory();
    let nothing = Need::new(0.0, "the programs", "take a wider --stepover");
    let opened = plates::open(&stl, margin, &args.placing, (limit, nothing), &progress)?;
    let shop = shop(args, machining, &opened, margin)?;
    let machining = shop.finishing();
    let plate = shop.blank.optical_size();
    machining.check(plate).map_err(|error| Failure::Impossible(error.to_string()))?;
    let places = plate.x * plate.y / machining.passes.stepover / machining.machine.shortest_segment();
    limit.admit(Need::new(PLACE * places, "the programs", "take a wider --stepover"))?;
    let drawn = drawn::of(args.the_plate(), &mut recipe, mount, limit)?;
    let drawn = drawn.as_ref().map_err(String::as_str).and_then(|drawn| match args.no_verify {
        true => Err(""),
        false => Ok(drawn),
    });
    progress.stage(Stage::Programs);
    let tips = machining.tips(&opened.mesh.at_optical_corner(margin));
    let ways = machining.ways_over(&tips, plate, &progress)?;
    recipe.reaches(depth(&machining, &ways)).map_err(Failure::of_flags)?;
    let files = shop.programs(&opened.mesh, &tips, &ways, &progress)?;
    let mut advice = advice(&shop, &opened, &recipe, margin);
    advice.extend(shop.hours_beside(&ways, &files));
    let made = match drawn {
        Ok(drawn) => made(&machining, &ways, drawn, &recipe, (limit, &progress))?,
        Err(why) => {
            advice.extend(Some(why.to_owned()).filter(|why| !why.is_empty()));
            None
        }
    };
    progress.stage(Stage::Files);
    let mut report = MillReport::new(opened.facts.clone(), &shop, &files, advice);
    report.as_made = made.as_ref().map(MadeProof::facts);
    report.light = made.as_ref().map(|made| in_a_sentence(&made.verdict, &format!("As {}", made.how())));
    let picture = match (&made, drawn) {
        (Some(made), Ok(drawn)) => Some(picture(made, drawn, (&recipe, &shop), &progress)?),
        _ => None,
    };
    write(&mut staged, (&shop, &files), &recipe, (&report, picture.as_ref()))?;
    staged.publish()?;
    stages.finish();
    tell(&args.running, &report, |report| Table {
        title: report.verdict.clone(),
        rows: mill_tables::mill_in_short(output, report),
        more: mill_tables::mill(report),
        notes: report.light.iter().chain(&report.advice).cloned().collect(),
    })?;
    Ok(())
}

/// How the flags say that it is made, over what the recipe says.
fn asked(args: &MillArgs, recipe: &mut Recipe) -> Result<Machining, Failure> {
    let how = args.machining();
    args.settings.apply(recipe);
    machining::named(&how.by, recipe)?;
    let none = || {
        Failure::Usage(
            "say with --machine which machine makes it, such as desktop-good or vmc; no recipe names one".into(),
        )
    };
    if recipe.machining.machine.is_none() {
        return Err(none());
    }
    if recipe.machining.pass_angle == Some(PassAngle::Best) {
        return Err(Failure::Usage(
            "--pass-angle best is found by design, plan and verify, which tell its degrees: give those here".into(),
        ));
    }
    let mut machining = machining::of(&how, &recipe.machining, recipe)?.ok_or_else(none)?;
    if let Some(cutter) = machining::cutter("cutter", how.cutter.as_deref(), how.by.cutters.as_deref())? {
        recipe.take_cutter(&cutter);
    }
    if args.compensate {
        machining.machine.compensation_z = machining.machine.backlash_z;
    }
    Ok(machining)
}

/// How deep the finishing passes go about the plane that they lie on, mm, where they are over the plate.
fn depth(machining: &Machining, ways: &Ways) -> f64 {
    let (programs, plate) = (ways.programs(&machining.machine), ways.plate());
    let over = |point: &DVec3| point.truncate().clamp(DVec2::ZERO, plate) == point.truncate();
    depth_about_plane(programs.iter().flatten().copied().filter(over))
}

/// Every file of the folder.
fn write(
    staged: &mut Staged,
    (shop, files): (&Shop, &[ShopFile]),
    recipe: &Recipe,
    (report, picture): (&MillReport, Option<&RgbImage>),
) -> Result<(), Failure> {
    for file in files {
        staged.write_bytes(file.name, file.text.as_bytes())?;
    }
    if let Some(picture) = picture {
        staged.write_png("comparison_made.png", picture)?;
    }
    staged.write_bytes("setup.html", sheet(shop, files, recipe, (report, picture)).page().as_bytes())?;
    staged.write_bytes("report.json", text(report).as_bytes())?;
    Ok(())
}

/// Light of the plate as its machine makes it along the finishing passes; none if none reaches the picture.
fn made(
    machining: &Machining,
    ways: &Ways,
    drawn: &Drawn,
    recipe: &Recipe,
    (limit, progress): (MemoryLimit, &Progress),
) -> Result<Option<MadeProof>, Failure> {
    let remedy = "take a wider --stepover or --polish, or leave the proof out with --no-verify";
    limit.admit(Need::new(machining.bytes(ways.plate()), "the surface as made", remedy))?;
    let lighting = Lighting::new(recipe, &drawn.setup);
    progress.stage(Stage::Milling);
    match prove_along(machining, ways, lighting.seen(&drawn.target, None), 1, lighting.mirrored(progress)) {
        Ok(made) => Ok(Some(made)),
        Err(DesignError::NoLight) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// What was asked for beside what the machine makes.
fn picture(
    made: &MadeProof,
    drawn: &Drawn,
    (recipe, shop): (&Recipe, &Shop),
    progress: &Progress,
) -> Result<RgbImage, Failure> {
    let proof = drawn.proof(&made.measurement, &made.verdict);
    let footer = format!("{}: {}", shop.name, made.how());
    Ok(ProofPictures::new(&proof, recipe, drawn.setup.view(), &footer, progress)?.comparison)
}

/// The page for whoever stands at the machine.
fn sheet<'a>(
    shop: &'a Shop,
    files: &'a [ShopFile],
    recipe: &Recipe,
    (report, picture): (&'a MillReport, Option<&RgbImage>),
) -> Sheet<'a> {
    let margin = shop.blank.margin;
    let rim = (margin > 0.0).then(|| match recipe.border_finish() {
        BorderFinish::Matt => {
            format!("a flat rim of {margin} mm, cut by roughing, to be left dull: blasted, sanded or blackened")
        }
        BorderFinish::Polished => format!("a flat rim of {margin} mm, cut by roughing, to be polished with the rest"),
        BorderFinish::Sloped(_) => format!("a rim of {margin} mm that falls outward, to be filed and polished"),
    });
    let caption = "As drawn, as the machine makes it, and the difference: sharp above, through a blur of 1° below";
    let address = |png: Vec<u8>| format!("data:image/png;base64,{}", STANDARD.encode(png));
    let picture = picture.and_then(|picture| Some((caption.to_owned(), address(encode_png(picture).ok()?))));
    Sheet {
        shop,
        files,
        rim,
        verdict: report.light.clone(),
        polish: None,
        more: Vec::new(),
        pictures: picture.into_iter().collect(),
        advice: &report.advice,
    }
}

/// Refuses numbers that no shop means.
fn check(args: &MillArgs) -> Result<(), Failure> {
    within("spindle", Some(args.spindle), (100.0, 500_000.0))?;
    within("teeth", Some(args.teeth), (1.0, 20.0))?;
    within("stock-over", Some(args.stock_over), (0.0, 20.0))?;
    within("allowance", args.allowance, (0.01, 5.0))?;
    within("tolerance", Some(args.tolerance), (0.1, 1000.0))?;
    within("flutes", args.flutes, (0.01, 1000.0))?;
    within("rough-step", args.rough_step, (0.01, 50.0))?;
    within("rough-stepover", args.rough_stepover, (0.01, 50.0))
}

/// The shop that the flags say.
fn shop(args: &MillArgs, machining: Machining, opened: &Opened, margin: f64) -> Result<Shop, Failure> {
    let dialect = args.dialect.unwrap_or_else(|| usual_dialect(&machining.machine));
    let blank = Blank::new(&opened.mesh, margin, args.stock_over);
    let side = blank.size().truncate().min_element();
    // Half millimetres are what cutters are sold in.
    let usual = Cutter::Flat { diameter: ((0.2 * side).floor() / 2.0).clamp(1.0, 6.0) };
    let file = args.cutters.as_deref().filter(|_| args.rough_cutter.is_some());
    let cutter =
        machining::cutter("rough-cutter", args.rough_cutter.as_deref(), file)?.map_or(usual, |named| named.shape);
    if !(cutter.diameter() > 0.0 && cutter.diameter() <= side) {
        return Err(Failure::Impossible(format!(
            "the cutter {cutter} does not fit: name with --rough-cutter one no wider than the plate's smaller side, \
             {side:.3} mm"
        )));
    }
    let usual = usual_roughing(cutter, args.allowance.unwrap_or(ALLOWANCE));
    let roughing = Roughing {
        step: args.rough_step.unwrap_or(usual.step),
        stepover: args.rough_stepover.unwrap_or(usual.stepover),
        ..usual
    };
    if roughing.stepover > cutter.diameter() {
        return Err(Failure::Usage(format!(
            "--rough-stepover is {}: with {cutter} it may be up to {}, or ribs are left standing",
            roughing.stepover,
            cutter.diameter()
        )));
    }
    Ok(Shop {
        machining,
        dialect,
        stock: args.material,
        spindle: Spindle { fastest: args.spindle, teeth: args.teeth },
        blank,
        roughing,
        name: plates::name(args.the_plate()),
        passes: None,
    })
}

/// What a person should know.
fn advice(shop: &Shop, opened: &Opened, recipe: &Recipe, margin: f64) -> Vec<String> {
    let mut advice = opened.advice.clone();
    let machining = shop.finishing();
    let (said, written) = (shop.machining.machine.decimals, machining.machine.decimals);
    if said < written {
        advice.push(format!(
            "The finishing program has {written} decimals, where the machine is said to have {said}: see that its sender \
             cuts none off."
        ));
    }
    if shop.machining.machine.feed > 1.01 * machining.machine.feed {
        advice.push(format!(
            "The finishing feed is {:.0} mm/min instead of {:.0}: with {:.0} turns a minute and {} teeth the cuts would lie \
             farther apart than the machine's {:.1} µm.",
            machining.machine.feed,
            shop.machining.machine.feed,
            shop.spindle.fastest,
            shop.spindle.teeth,
            1000.0 * machining.machine.feed_per_tooth
        ));
    }
    if margin > 0.0 && matches!(recipe.border_finish(), BorderFinish::Sloped(_)) {
        advice.push("The rim slopes, and only roughing cuts it: its steps are to be filed or polished away.".into());
    }
    advice
}

impl From<ShopError> for Failure {
    fn from(error: ShopError) -> Self {
        match error {
            ShopError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Impossible(other.to_string()),
        }
    }
}
