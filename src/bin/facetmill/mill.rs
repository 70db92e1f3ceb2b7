//! `facetmill mill`: the programs by which a shop makes a plate.

use facetmill::cutter::Cutter;
use facetmill::gcode::dialect::Dialect;
use facetmill::job::exports;
use facetmill::memory::Need;
use facetmill::milling::made::Machining;
use facetmill::milling::roughing::Roughing;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::recipe::{BorderFinish, Recipe};
use facetmill::report::mill::MillReport;
use facetmill::report::text;
use facetmill::shop::blank::Blank;
use facetmill::shop::feeds::Spindle;
use facetmill::shop::programs::{Shop, ShopError, usual_roughing};

use crate::args::MillArgs;
use crate::console::{Failure, Table, tell};
use crate::files::{Place, Staged};
use crate::interrupt::Run;
use crate::plates::{Named, Opened};
use crate::stages::Stages;
use crate::{inputs, machining, mill_tables, plates};

/// Bytes of a program for each place of a pass, at the most: a segment each, of twenty letters, and its moves once read.
const PLACE: f64 = 300.0;

/// Does what `args` say.
pub fn run(args: &MillArgs, run: &Run) -> Result<(), Failure> {
    inputs::given([Some(&args.plate), None])?;
    let Named { stl, mut recipe, .. } = plates::named(&args.plate)?;
    within(args)?;
    let how = args.machining();
    args.settings.apply(&mut recipe);
    machining::named(&how.by, &mut recipe)?;
    if recipe.machining.machine.is_none() {
        return Err(Failure::Usage(
            "say with --machine which machine makes it, such as desktop-good or vmc; no recipe names one".into(),
        ));
    }
    let machining = machining::of(&how, &recipe.machining.clone(), &recipe)?
        .ok_or_else(|| Failure::Usage("--machine none makes nothing: name a machine".into()))?;
    let read = inputs::given([Some(&args.plate), None])?;
    plates::spare_design(&args.plate, &args.output)?;
    let mut staged = Staged::new(&Place::new(&args.output, args.running.force, exports::MILL, &read), &run.gate)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Reading);
    let border = if args.plate.is_dir() { recipe.plate.border } else { 0.0 };
    let margin = args.margin.unwrap_or(border);
    let limit = args.running.memory();
    let nothing = Need::new(0.0, "the programs", "take a wider --stepover");
    let opened = plates::open(&stl, margin, &args.placing, (limit, nothing), &progress)?;
    let shop = shop(args, machining, &opened, margin)?;
    let machining = shop.finishing();
    let plate = shop.blank.optical_size();
    machining.check(plate).map_err(|error| Failure::Impossible(error.to_string()))?;
    let places = plate.x * plate.y / machining.passes.stepover / machining.machine.shortest_segment();
    limit.admit(Need::new(PLACE * places, "the programs", "take a wider --stepover"))?;
    progress.stage(Stage::Programs);
    let tips = machining.tips(&opened.mesh.at_optical_corner(margin));
    let ways = machining.ways_over(&tips, plate, &progress);
    progress.check()?;
    let files = shop.programs(&opened.mesh, &tips, &ways, &progress)?;
    progress.stage(Stage::Files);
    let report = MillReport::new(opened.facts.clone(), &shop, &files, advice(&shop, &opened, &recipe, margin));
    for file in &files {
        staged.write_bytes(file.name, file.text.as_bytes())?;
    }
    staged.write_bytes("report.json", text(&report).as_bytes())?;
    staged.publish()?;
    stages.finish();
    tell(&args.running, &report, |report| Table {
        title: report.verdict.clone(),
        rows: mill_tables::mill_in_short(&args.output, report),
        more: mill_tables::mill(report),
        notes: report.advice.clone(),
    })?;
    Ok(())
}

/// Refuses numbers that no shop means.
fn within(args: &MillArgs) -> Result<(), Failure> {
    let given = [
        ("spindle", Some(args.spindle), [100.0, 500_000.0]),
        ("teeth", Some(args.teeth), [1.0, 20.0]),
        ("stock-over", Some(args.stock_over), [0.0, 20.0]),
        ("allowance", Some(args.allowance), [0.01, 5.0]),
        ("rough-step", args.rough_step, [0.01, 50.0]),
        ("rough-stepover", args.rough_stepover, [0.01, 50.0]),
    ];
    for (flag, value, [least, most]) in given {
        if let Some(value) = value.filter(|value| !(least..=most).contains(value)) {
            return Err(Failure::Usage(format!("--{flag} is {value}: it must be from {least} to {most}")));
        }
    }
    Ok(())
}

/// The shop that the flags say.
fn shop(args: &MillArgs, machining: Machining, opened: &Opened, margin: f64) -> Result<Shop, Failure> {
    let small = machining.machine.name.starts_with("desktop");
    let dialect = args.dialect.unwrap_or(if small { Dialect::Grbl } else { Dialect::Iso });
    let blank = Blank::new(&opened.mesh, margin, args.stock_over);
    let side = blank.size().truncate().min_element();
    // Half millimetres are what cutters are sold in.
    let usual = Cutter::Flat { diameter: ((0.2 * side).floor() / 2.0).clamp(1.0, 6.0) };
    let cutter = args.rough_cutter.unwrap_or(usual);
    if !(cutter.diameter() > 0.0 && cutter.diameter() <= side) {
        return Err(Failure::Impossible(format!(
            "the cutter {cutter} does not fit: name with --rough-cutter one no wider than the plate's smaller side, \
             {side:.3} mm"
        )));
    }
    let usual = usual_roughing(cutter, args.allowance);
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
        name: plates::name(&args.plate),
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
