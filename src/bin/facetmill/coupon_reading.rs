//! `facetmill coupon --read`: what a finished test piece says of its machine.

use std::io::Read as _;
use std::path::Path;

use facetmill::coupon::findings::Findings;
use facetmill::coupon::layout::Coupon;
use facetmill::coupon::{lines, photograph, scan};
use facetmill::job::exports;
use facetmill::memory::Need;
use facetmill::picture::Reading;
use facetmill::raster::Raster;
use facetmill::report::coupon::{CouponReading, FigureFacts};
use facetmill::report::text;

use crate::args::CouponArgs;
use crate::console::{Failure, Table, tell};
use crate::files::{Place, Staged};
use crate::inputs;
use crate::interrupt::Run;
use crate::tables::{Row, row};

/// What shows that a folder is a test piece's.
const FILE: &str = "coupon.toml";

/// Memory for each byte of a scan: its numbers, and what is made of them.
const BYTE: f64 = 4.0;

/// Reads what `args` name.
pub fn read(args: &CouponArgs, run: &Run) -> Result<(), Failure> {
    let Some(folder) = &args.against else {
        // The command line asks for it.
        return Err(Failure::Usage("say with --against into which folder the piece was written".into()));
    };
    let mut given = inputs::given([Some(folder), None])?;
    given.extend(args.read.iter().map(std::path::PathBuf::as_path));
    let coupon = coupon(folder)?;
    let mut staged = match &args.output {
        None => None,
        Some(output) => {
            if output.join(FILE).exists() {
                return Err(Failure::Usage(format!(
                    "-o {} is the piece's own folder, whose report.json would be lost: choose another folder",
                    output.display()
                )));
            }
            Some(Staged::new(&Place::new(output, args.running.force, exports::COUPON_READ, &given), &run.gate)?)
        }
    };
    let names: Vec<String> = args.read.iter().map(|file| file.to_string_lossy().into_owned()).collect();
    let (findings, lines) = findings(args, &coupon)?;
    let report = CouponReading::new(&coupon, &findings, (folder.to_string_lossy().into_owned(), names), lines);
    if let Some(staged) = &mut staged {
        staged.write_bytes("machine.toml", findings.file(&coupon.machine, facetmill::report::PROGRAM).as_bytes())?;
        staged.write_bytes("report.json", text(&report).as_bytes())?;
    }
    if let Some(staged) = staged {
        staged.publish()?;
    }
    tell(&args.running, &report, |report| Table {
        title: report.verdict.clone(),
        rows: report.figures.iter().map(in_short).collect(),
        more: Vec::new(),
        notes: report.advice.clone(),
    })?;
    Ok(())
}

/// What the files say, and how many lines across the passes were read.
fn findings(args: &CouponArgs, coupon: &Coupon) -> Result<(Findings, usize), Failure> {
    let limit = args.running.memory();
    let needs = |length: u64| {
        let cure = "leave out points, or lines that are not asked for";
        Need::new(BYTE * length as f64, "a scan of this length", cure)
    };
    let (mut lines, mut photographs) = (Vec::new(), Vec::new());
    for file in &args.read {
        let name = file.display();
        if is_text(file)? {
            let bytes = inputs::bytes(file, limit, needs)?;
            lines.extend(scan::read(&bytes).map_err(|error| Failure::Input(format!("{name}: {error}")))?);
        } else {
            photographs.push((name, inputs::picture(file, &Reading::default(), limit)?.light));
        }
    }
    match (lines.is_empty(), photographs.is_empty()) {
        (false, true) => {
            lines.sort_by(|a, b| a.x.total_cmp(&b.x));
            let found =
                lines::found(coupon, &lines).map_err(|error| Failure::Input(format!("{}: {error}", listed(args))))?;
            Ok((Findings::of(coupon, &found), found.len()))
        }
        (true, _) => {
            let light: Vec<Raster> = photographs.into_iter().map(|one| one.1).collect();
            let found = photograph::findings(coupon, &light);
            Ok((found.map_err(|error| Failure::Input(format!("{}: {error}", listed(args))))?, 0))
        }
        (false, false) => Err(Failure::Usage(
            "--read takes scans or photographs, not both at once: read each, and take the smaller errors".into(),
        )),
    }
}

/// The files that are read.
fn listed(args: &CouponArgs) -> String {
    args.read.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// Whether a file begins as text does.
fn is_text(file: &Path) -> Result<bool, Failure> {
    let mut begin = Vec::new();
    let cannot = |error| Failure::Input(format!("{}: the file cannot be read ({error})", file.display()));
    inputs::open(file)?.take(512).read_to_end(&mut begin).map_err(cannot)?;
    let odd = begin.iter().filter(|byte| **byte < 9 || (14..32).contains(*byte)).count();
    Ok(odd == 0)
}

/// The piece that was written into `folder`.
fn coupon(folder: &Path) -> Result<Coupon, Failure> {
    let file = folder.join(FILE);
    if !file.is_file() {
        return Err(Failure::Input(format!(
            "{}: no {FILE} stands in this folder: name the one that `facetmill coupon --machine` wrote",
            folder.display()
        )));
    }
    let text = inputs::text(&file, "test piece's file", FILE)?;
    Coupon::from_toml(&text).map_err(|error| Failure::Input(format!("{}: {error}", file.display())))
}

/// A figure with its error, or why there is none.
fn in_short(figure: &FigureFacts) -> Row {
    let assumed = figure.assumed_um.map_or("nothing was assumed".to_owned(), |um| format!("{um:.3} µm was assumed"));
    match (figure.measured_um, figure.error_um, &figure.why) {
        (Some(value), Some(error), _) => {
            row(figure.key, format!("{value:.3} µm"), format!("± {error:.3} µm; {assumed}"))
        }
        (.., why) => row(figure.key, "not told", format!("{}; {assumed}", why.clone().unwrap_or_default())),
    }
}
