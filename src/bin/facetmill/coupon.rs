//! `facetmill coupon`: a test piece for a machine, and what is read from it.

use std::path::Path;

use facetmill::coupon::layout::{Coupon, CouponError, POLISHED_FROM};
use facetmill::coupon::photograph::DISTANCE;
use facetmill::cutter::Cutter;
use facetmill::export::sheet::sheet_solid;
use facetmill::export::stl::write_stl;
use facetmill::job::exports;
use facetmill::milling::made::Machining;
use facetmill::progress::{Event, Progress, Stage};
use facetmill::report::coupon::CouponReport;
use facetmill::report::text;
use facetmill::shop::blank::Blank;
use facetmill::shop::feeds::Spindle;
use facetmill::shop::programs::{Shop, ShopFile, duration, usual_dialect, usual_roughing};
use facetmill::shop::sheet::Sheet;

use crate::args::CouponArgs;
use crate::console::{Failure, Table, tell};
use crate::files::{Place, Staged};
use crate::interrupt::Run;
use crate::mill_tables::program_row;
use crate::ranges::within;
use crate::stages::Stages;
use crate::tables::{Row, row, told};
use crate::{coupon_reading, machining};

/// Solid metal under the lowest point of the piece, mm.
const THICKNESS: f64 = 3.0;

/// What takes the stock away, and what it leaves standing, mm.
const ROUGHING: Cutter = Cutter::Flat { diameter: 3.0 };
const ALLOWANCE: f64 = 0.08;

/// Does what `args` say.
pub fn run(args: &CouponArgs, run: &Run) -> Result<(), Failure> {
    within("spindle", Some(args.spindle), (100.0, 500_000.0))?;
    within("teeth", Some(args.teeth), (1.0, 20.0))?;
    within("stock-over", Some(args.stock_over), (0.0, 20.0))?;
    match (&args.machine, &args.output) {
        _ if !args.read.is_empty() => coupon_reading::read(args, run),
        (Some(machine), Some(output)) => written(args, (machine, output), run),
        // The command line asks for both.
        _ => Err(Failure::Usage("say with --machine for which machine, and with -o into which folder".into())),
    }
}

/// A piece for the machine `name`, into the folder `output`.
fn written(args: &CouponArgs, (name, output): (&str, &Path), run: &Run) -> Result<(), Failure> {
    let machine = machining::machine(name)?;
    let spindle = Spindle { fastest: args.spindle, teeth: args.teeth };
    let cutter = machining::by_name("for-cutter", &args.for_cutter, args.cutters.as_deref())?;
    let pace = args.material.finishing(cutter.shape, &machine, spindle);
    let coupon = Coupon::new(&machine, cutter.shape, pace.feed)?;
    let depth = coupon.relief().depth();
    if let Some(flutes) = cutter.deepest().filter(|flutes| depth > *flutes) {
        return Err(Failure::Impossible(format!(
            "the test piece is {depth:.3} mm deep, and the cutter reaches {flutes} mm: name with --for-cutter one that reaches \
             deeper (facetmill cutters lists them)"
        )));
    }
    let read = if Path::new(name).exists() { vec![Path::new(name)] } else { Vec::new() };
    let mut staged = Staged::new(&Place::new(output, args.running.force, exports::COUPON, &read), &run.gate)?;
    let stages = run.shows(Stages::new(&args.running));
    let listen = |event: Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &run.cancel);
    progress.stage(Stage::Programs);
    let solid = sheet_solid(&coupon.relief(), THICKNESS, 0.0, &progress);
    let mesh = solid.map_err(|error| Failure::Impossible(error.to_string()))?;
    let dialect = args.dialect.unwrap_or_else(|| usual_dialect(&machine));
    let machining = Machining { machine, cutter: coupon.cutter, passes: coupon.passes(), polish: None, seed: 1 };
    let shop = Shop {
        machining,
        dialect,
        stock: args.material,
        spindle,
        blank: Blank::new(&mesh, 0.0, args.stock_over),
        roughing: usual_roughing(ROUGHING, ALLOWANCE),
        name: format!("test piece for {}", coupon.machine.name),
        passes: Some(passes_in_words(&coupon)),
    };
    let machining = shop.finishing();
    machining.check(coupon.size()).map_err(|error| Failure::Impossible(error.to_string()))?;
    let tips = machining.tips(&mesh);
    let ways = coupon.ways(&machining, &tips, &progress)?;
    let files = shop.programs(&mesh, &tips, &ways, &progress)?;
    progress.stage(Stage::Files);
    let report = CouponReport::new(&coupon, &shop, &files, advice(&files));
    for file in &files {
        staged.write_bytes(file.name, file.text.as_bytes())?;
    }
    staged.write("plate.stl", |mut out| write_stl(&mesh, &mut out))?;
    staged.write_bytes("coupon.toml", coupon.to_toml().as_bytes())?;
    staged.write_bytes("setup.html", sheet(&coupon, &shop, &files, &report).page().as_bytes())?;
    staged.write_bytes("report.json", text(&report).as_bytes())?;
    staged.publish()?;
    stages.finish();
    tell(&args.running, &report, |report| Table {
        title: report.verdict.clone(),
        rows: in_short(output, report),
        more: in_full(report),
        notes: report.advice.clone(),
    })?;
    Ok(())
}

/// What a person should know.
fn advice(files: &[ShopFile]) -> Vec<String> {
    let seconds = files.iter().map(|file| file.judgement.timing.seconds).sum::<f64>();
    let slow = seconds > 2400.0;
    let told = || {
        format!(
            "It takes {} in place of 20 min: the machine's teeth cut so close that it goes slowly, and fewer passes would \
             tell too little.",
            duration(seconds)
        )
    };
    slow.then(told).into_iter().collect()
}

/// Passes for the heading of the program.
fn passes_in_words(coupon: &Coupon) -> String {
    let bands: Vec<String> =
        coupon.bands.iter().map(|band| format!("{} of {} mm", band.passes, band.stepover)).collect();
    format!("Passes along x, from the lowest y on: {}; those of the second band to and fro", bands.join(", "))
}

/// The page for whoever makes, polishes and scans the piece.
fn sheet<'a>(coupon: &Coupon, shop: &'a Shop, files: &'a [ShopFile], report: &'a CouponReport) -> Sheet<'a> {
    let size = coupon.size();
    let lines: Vec<String> =
        coupon.lines().iter().map(|(x, place)| format!("{x} ({})", Coupon::in_words(*place))).collect();
    let scan = vec![
        format!(
            "Scan lines across the passes, along y from 0 to {:.2} mm, at x = {} mm. Each may lie 0.2 mm beside its place. \
             Points 0.5 to 2 µm apart; noise of the heights under a tenth of a micrometre shows the finest machines.",
            size.y,
            lines.join(", ")
        ),
        "One file with the columns x, y, z in mm and a line of text for each point; a grid of heights is as good as \
         lines. Zero and direction as the program has them; y may be off by 1 mm, z by anything, and the piece may lie \
         tilted."
            .to_owned(),
        "Read it with: facetmill coupon --read scan.csv --against (this folder) -o mine. Without lines in the polished \
         half the polish is not told, without ramps the play of x; everything else is."
            .to_owned(),
    ];
    Sheet {
        shop,
        files,
        rim: None,
        verdict: Some(report.verdict.clone()),
        polish: Some(format!(
            "Polish only the right half, from x = {POLISHED_FROM} mm on, in the way in which the plate will be polished: same \
             stuff, same time for each square centimetre. Cover the left half with tape up to x = {POLISHED_FROM} mm, and \
             do not touch it. Leave the piece as it is cut if nothing is to be polished later."
        )),
        more: vec![("Scanning it".to_owned(), scan), ("Or photographing it".to_owned(), photograph(coupon))],
        pictures: Vec::new(),
        advice: &report.advice,
    }
}

/// How a photograph is taken.
fn photograph(coupon: &Coupon) -> Vec<String> {
    let pixel = 1000.0 * coupon.bands.first().map_or(0.12, |band| band.stepover) / 12.0;
    vec![
        format!(
            "A photograph tells the scatter from pass to pass, the play of z, the tip's flat and the polish, less surely than a \
             scan. Lay the piece on black ground in a dark room, x to the right, low y at the bottom. Stand the camera \
             {DISTANCE} mm above it, tilted by 10° so that it sees neither itself nor its shade; the piece fills the \
             photograph, a pixel is at most {pixel:.0} µm, the lens is stopped down to an opening of 2 to 3 mm, and nothing is \
             sharpened or compressed much."
        ),
        format!(
            "The lamp is one evenly lit white board, wider than the piece is long by a factor of three, with a straight edge \
             along x, {DISTANCE} mm from the piece where a mirror would show it to the camera, on the side of high y. Move it \
             until its edge, as the grooves mirror it, lies in the middle of the two bands of passes that are far apart: on one \
             side of there the grooves' bottoms are bright, on the other dark. Every groove then has a bright and a dark side."
        ),
        "Several photographs with the edge moved a little are better than one: facetmill coupon --read a.png b.png --against \
         (this folder) -o mine."
            .to_owned(),
    ]
}

fn in_short(folder: &Path, report: &CouponReport) -> Vec<Row> {
    let [width, height, thickness] = report.stock_mm;
    let mut rows = vec![told("stock", format!("{} {width:.2} × {height:.2} × {thickness:.2} mm", report.stock))];
    rows.extend(report.programs.iter().map(|program| program_row(folder, program)));
    rows.push(told("then", "setup.html says which half to polish, and how to scan or photograph it".to_owned()));
    rows
}

fn in_full(report: &CouponReport) -> Vec<Row> {
    let band = |band: &facetmill::report::coupon::BandFacts| {
        let [from, to] = band.y_mm;
        row("passes", band.passes.to_string(), format!("{} mm apart, y {from:.3} to {to:.3} mm", band.stepover_mm))
    };
    report.bands.iter().map(band).collect()
}

impl From<CouponError> for Failure {
    fn from(error: CouponError) -> Self {
        match error {
            CouponError::Toml(_) | CouponError::Version(_) => Self::Input(error.to_string()),
            _ => Self::Impossible(error.to_string()),
        }
    }
}
