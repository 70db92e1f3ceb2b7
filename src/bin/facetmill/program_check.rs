//! `facetmill mill --check`: a program of any origin, judged against a plate.

use std::path::Path;

use facetmill::cutter::Cutter;
use facetmill::gcode::dialect::Dialect;
use facetmill::gcode::read::{self, Read, read};
use facetmill::glam::{DVec2, DVec3};
use facetmill::job::design::DesignError;
use facetmill::job::made::Lighting;
use facetmill::job::pictures::{ProofPictures, target_picture};
use facetmill::job::swept::{SweptProof, prove_swept};
use facetmill::job::{exports, in_a_sentence};
use facetmill::memory::{MemoryLimit, Need};
use facetmill::milling::machine::Machine;
use facetmill::milling::polish::in_words;
use facetmill::milling::swept::Swept;
use facetmill::milling::tip::TipHeights;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::recipe::Recipe;
use facetmill::report::mill::{CheckReport, ReadFacts, SurfaceFacts};
use facetmill::report::{PROGRAM, text};
use facetmill::shop::blank::Blank;
use facetmill::shop::check::{Against, Judgement, Trouble, What, judged, said_of_itself, trouble};
use facetmill::shop::surface::{Left, Wanted, strokes};

use crate::args::MillArgs;
use crate::console::{Failure, Table, tell};
use crate::drawn::Drawn;
use crate::files::{Place, Staged};
use crate::interrupt::Run;
use crate::plates::{Named, Opened};
use crate::stages::Stages;
use crate::{drawn, inputs, machining, mill_tables, plates};

/// What numbers of few decimals are off by, mm: half of the last of four of an inch, in x, y and z, and some slack.
const ROUNDED: f64 = 0.004;

/// What is known of the program before it is judged.
struct Given {
    bytes: Vec<u8>,
    cutter: Cutter,
    dialect: Option<Dialect>,
    machine: Machine,
    polish: Option<f64>,
    /// Play of z that it makes up for, mm.
    play: f64,
}

/// What came of it.
struct Found {
    judgement: Judgement,
    left: Option<Left>,
    light: Option<(SweptProof, Drawn)>,
    advice: Vec<String>,
}

/// Judges the program in `file`.
pub fn run(args: &MillArgs, file: &Path, run: &Run) -> Result<(), Failure> {
    let against = args.the_plate();
    let inputs_given = inputs::given([Some(against), Some(file)])?;
    let Named { stl, mut recipe, mount } = plates::named(against)?;
    machining::named(&args.machining().by, &mut recipe)?;
    let limit = args.running.memory();
    let given = given(args, file, &recipe, limit)?;
    let mut staged = match &args.output {
        None => None,
        Some(output) => {
            plates::spare_design(against, output)?;
            Some(Staged::new(&Place::new(output, args.running.force, exports::CHECK, &inputs_given), &run.gate)?)
        }
    };
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Reading);
    let margin = plates::margin(args.margin, against, &recipe);
    let sweeping = Need::new(
        Swept::bytes(given.bytes.len() / 8),
        "the surface that the program leaves",
        "cut the program into parts",
    );
    let opened = plates::open(&stl, margin, &args.placing, (limit, sweeping), &progress)?;
    progress.stage(Stage::Programs);
    let name = file.display();
    let program = read(&given.bytes, given.dialect).map_err(|error| Failure::Input(format!("{name}: {error}")))?;
    let drawing = Drawing { recipe: &mut recipe, mount, limit, folder: against };
    let found = found(args, &given, program, (&opened, margin), drawing, &progress)?;
    if staged.is_some() {
        progress.stage(Stage::Files);
    }
    let report = report((file, args.zero), &given, &opened, &found);
    if let Some(staged) = &mut staged {
        if let Some((proof, drawn)) = &found.light {
            write_pictures(staged, (proof, drawn), (&recipe, &report.verdict), &progress)?;
        }
        staged.write_bytes("report.json", text(&report).as_bytes())?;
    }
    if let Some(staged) = staged {
        staged.publish()?;
    }
    stages.finish();
    tell(&args.running, &report, |report| Table {
        title: report.verdict.clone(),
        rows: mill_tables::check_in_short(report),
        more: mill_tables::check(report),
        notes: [&report.read.notes[..], &report.advice[..]].concat(),
    })?;
    match report.read.troubles.first() {
        None => Ok(()),
        Some(first) => Err(Failure::Beyond(format!("{name}: {}", first.sentence))),
    }
}

/// The program's bytes, and what flags, its heading and the recipe say of it, in this order.
fn given(args: &MillArgs, file: &Path, recipe: &Recipe, limit: MemoryLimit) -> Result<Given, Failure> {
    let needs = |length| Need::new(read::bytes_for(length), "a program of this length", "cut the program into parts");
    let bytes = inputs::bytes(file, limit, needs)?;
    let (tool, control, play) = said_of_itself(&bytes);
    let sheet = &recipe.design.sheet;
    let how = args.machining();
    let named = machining::cutter("cutter", how.cutter.as_deref(), how.by.cutters.as_deref())?;
    let cutter = named.map(|named| named.shape).or(tool).or(sheet.cutter).ok_or_else(|| {
        Failure::Usage(
            "--cutter: say with what the program cuts, such as ball:0.5; neither it nor a recipe does".into(),
        )
    })?;
    if !(cutter.diameter() > 0.0 && cutter.diameter().is_finite()) {
        return Err(Failure::Usage(format!("--cutter: {cutter} has no width: name one wider than 0")));
    }
    let mut machine = recipe.machining.machine.clone().unwrap_or_else(Machine::ideal);
    // Its places are moved by it at once, before they are judged.
    machine.compensation_z = 0.0;
    let polish = args.polish.or(sheet.polish).filter(|polish| *polish > 0.0);
    Ok(Given { bytes, cutter, dialect: args.dialect.or(control), machine, polish, play })
}

/// What the light is scored against.
struct Drawing<'a> {
    recipe: &'a mut Recipe,
    mount: Option<DVec3>,
    limit: MemoryLimit,
    folder: &'a Path,
}

fn found(
    args: &MillArgs,
    given: &Given,
    mut program: Read,
    (opened, margin): (&Opened, f64),
    drawing: Drawing,
    progress: &Progress,
) -> Result<Found, Failure> {
    let zero = DVec3::from_array(args.zero.unwrap_or_default());
    program.program = program.program.moved(zero).lagging(given.play);
    let blank = Blank::new(&opened.mesh, margin, args.stock_over);
    let tips = TipHeights::new(&opened.mesh.at_optical_corner(margin), given.cutter.profile());
    let origin = blank.origin_of_optical();
    let against = Against {
        tips: &tips,
        origin,
        blank: &blank,
        cutter: given.cutter,
        machine: &given.machine,
        dialect: given.dialect,
        tolerance: 1e-3 * args.tolerance,
        flutes: args.flutes,
    };
    let mut judgement = judged(&program, &against);
    progress.check()?;
    let mut advice = opened.advice.clone();
    let plate = blank.optical_size();
    let wanted = Wanted { tips: &tips, origin, optical: [DVec2::ZERO, plate] };
    let cuts = strokes(&program.program, origin);
    // What stays above the stock leaves no surface.
    let cuts_into = cuts.iter().any(|stroke| stroke.from.z.min(stroke.to.z) < -origin.z);
    let (mut left, mut light) = (None, None);
    if cuts_into {
        let swept = Swept::new(&cuts, given.cutter.profile());
        drop(cuts);
        let surface = wanted.left(&swept, progress)?;
        let allowed = 1e-3 * args.tolerance + args.allowance.unwrap_or(0.0);
        let missed = wanted.missed(&program.program, (&swept, &surface), allowed, progress)?;
        if !missed.is_none() {
            judgement.troubles.push(trouble(What::Standing, &missed));
        }
        if surface.untouched > 0.0 {
            advice.push(format!(
                "Over {:.1} % of the plate nothing has passed: stock stands there.",
                (100.0 * surface.untouched).max(0.1)
            ));
        }
        left = Some(surface);
        advice.extend(rounding(&judgement, args.tolerance));
        light = lit(&swept, (plate, -origin.z), given.polish, drawing, (&mut advice, progress))?;
    } else {
        advice.push("It cuts nothing: all of it is above the stock.".into());
    }
    judgement.troubles.sort_by_key(|trouble| trouble.what.rank());
    judgement.troubles.iter_mut().filter_map(|trouble| trouble.place.as_mut()).for_each(|place| *place -= zero);
    Ok(Found { judgement, left, light, advice })
}

/// What a program of coarse decimals is off by everywhere, in a sentence: finer than anybody would cut for, if it is alone.
fn rounding(judgement: &Judgement, tolerance: f64) -> Option<String> {
    let off = |trouble: &Trouble| matches!(trouble.what, What::Gouge | What::Standing) && trouble.by < ROUNDED;
    let most = judgement.troubles.iter().filter(|trouble| off(trouble)).map(|trouble| 1000.0 * trouble.by);
    let most = most.fold(0.0, f64::max);
    (most > 0.0 && judgement.troubles.iter().all(|trouble| off(trouble) || !trouble.what.is_of_the_surface())).then(
        || {
            format!(
                "It is off by {most:.1} µm at the most, as numbers of few decimals are (four of an inch: 2.5 µm); \
             --tolerance {:.0} in place of {tolerance} lets that pass.",
                (most + 0.5).ceil()
            )
        },
    )
}

/// The light of the surface, if the plate's drawing is known.
fn lit(
    swept: &Swept,
    (plate, uncut): (DVec2, f64),
    polish: Option<f64>,
    Drawing { recipe, mount, limit, folder }: Drawing,
    (advice, progress): (&mut Vec<String>, &Progress),
) -> Result<Option<(SweptProof, Drawn)>, Failure> {
    let drawn = match drawn::of(folder, recipe, mount, limit)? {
        Ok(drawn) => drawn,
        Err(why) => {
            advice.push(why);
            return Ok(None);
        }
    };
    let lighting = Lighting::new(recipe, &drawn.setup);
    let seen = lighting.seen(&drawn.target, None);
    match prove_swept(swept, (plate, uncut), polish, seen, lighting.mirrored(progress)) {
        Ok(proof) => Ok(Some((proof, drawn))),
        Err(DesignError::NoLight) => {
            advice.push("None of its light reaches the picture.".into());
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

fn report((file, zero): (&Path, Option<[f64; 3]>), given: &Given, opened: &Opened, found: &Found) -> CheckReport {
    let Found { judgement, left, light, advice } = found;
    let name = plates::name(file);
    let polish = in_words(given.polish);
    let verdict = match (judgement.troubles.len(), light) {
        (0, Some((proof, _))) => in_a_sentence(&proof.verdict, &format!("{name} can be run: on its surface, {polish}")),
        (0, None) => format!("{name} can be run: nothing is wrong with it."),
        (1, _) => format!("{name} should not be run: {}.", judgement.troubles[0]),
        (n, _) => format!("{name} should not be run for {n} reasons, the first: {}.", judgement.troubles[0]),
    };
    CheckReport {
        program: PROGRAM,
        gcode: file.to_string_lossy().into_owned(),
        plate: opened.facts.clone(),
        cutter: given.cutter,
        dialect: given.dialect.map(|dialect| dialect.to_string()),
        machine: given.machine.clone(),
        read: ReadFacts::from(judgement),
        zero_mm: zero.unwrap_or_default(),
        surface: left.as_ref().map(SurfaceFacts::from),
        polish_mm: given.polish,
        light: light.as_ref().map(|(proof, ..)| (&proof.verdict).into()),
        refused: !judgement.troubles.is_empty(),
        verdict,
        advice: advice.clone(),
    }
}

fn write_pictures(
    staged: &mut Staged,
    (proof, drawn): (&SweptProof, &Drawn),
    (recipe, footer): (&Recipe, &str),
    progress: &Progress,
) -> Result<(), Failure> {
    let proof = drawn.proof(&proof.measurement, &proof.verdict);
    staged.write_png("target.png", &target_picture(&drawn.target, recipe))?;
    let pictures = ProofPictures::new(&proof, recipe, drawn.setup.view(), footer, progress)?;
    staged.write_png("comparison.png", &pictures.comparison)?;
    Ok(())
}
