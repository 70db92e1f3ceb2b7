//! The tables of programs for a shop.

use std::path::Path;

use facetmill::milling::polish::in_words;
use facetmill::report::mill::{CheckReport, MillReport, ProgramFacts, ReadFacts};
use facetmill::shop::programs::duration;

use crate::tables::{Row, light, row, scores, shown, told};

/// Programs that were written into `folder`, in a few lines.
pub fn mill_in_short(folder: &Path, report: &MillReport) -> Vec<Row> {
    let [width, height, thickness] = report.stock_mm;
    let mut rows = vec![
        told("stock", format!("{} {width:.2} × {height:.2} × {thickness:.2} mm", report.stock)),
        told("zero", report.zero.clone()),
    ];
    rows.extend(report.programs.iter().map(|program| program_row(folder, program)));
    rows
}

/// One program: its file, how fast it goes and how long it takes.
pub fn program_row(folder: &Path, program: &ProgramFacts) -> Row {
    let ProgramFacts { cutter, feed_mm_per_min, turns_per_min, read, .. } = program;
    let pace = match program.part.as_str() {
        "air cut" => "the spindle standing".to_owned(),
        _ => format!("{cutter}, {feed_mm_per_min:.0} mm/min, {turns_per_min:.0} turns a minute"),
    };
    let time = duration(3600.0 * read.hours);
    told(&program.part, format!("{}: {pace}; {time}, {} lines", shown(&folder.join(&program.file)), read.lines))
}

/// All figures of programs.
pub fn mill(report: &MillReport) -> Vec<Row> {
    let mut rows = vec![
        row("machine", report.machining.machine.name.clone(), format!("control {}", report.dialect)),
        row("stepover", format!("{} mm", report.machining.stepover_mm), "from one finishing pass to the next"),
        row("cusps", format!("{:.4} µm", report.machining.cusp_height_um), "between them, over a level plate"),
        row("decimals", report.machining.machine.decimals.to_string(), "of the finishing program"),
    ];
    for program in &report.programs {
        let name = &program.part;
        rows.push(row(name, format!("{:.0}", program.read.lines_per_second), "lines a second at the most"));
        rows.push(row(name, format!("{:.1} m", 1e-3 * program.read.cut_mm), "along its cuts"));
        rows.extend(bounds(&program.read).map(|bounds| row(name, "bounds", bounds)));
    }
    rows
}

/// How far a program goes, if it moves at all.
fn bounds(read: &ReadFacts) -> Option<String> {
    let [low, high] = read.bounds_mm?;
    let axis = |k: usize| format!("{:.3} to {:.3}", low[k], high[k]);
    Some(format!("x {}, y {}, z {} mm", axis(0), axis(1), axis(2)))
}

/// Findings that are told without --verbose.
const FINDINGS: usize = 10;

/// A program that was judged, in a few lines: its findings, its surface, its light.
pub fn check_in_short(report: &CheckReport) -> Vec<Row> {
    let CheckReport { read, surface, .. } = report;
    let mut rows: Vec<Row> =
        read.troubles.iter().take(FINDINGS).map(|trouble| told(trouble.kind, trouble.sentence.clone())).collect();
    if let Some(surface) = surface {
        let (mean, most, line) = (surface.left_mean_um, surface.left_most_um, surface.left_most_line);
        let figures = match mean < 0.0 {
            true => format!("{:.2} µm too deep on the mean, up to {most:.2} µm left standing (line {line})", -mean),
            false => format!("{mean:.2} µm left standing on the mean, {most:.2} µm at the most (line {line})"),
        };
        rows.push(told("surface", figures));
    }
    rows.extend(report.light.as_ref().map(light));
    let [x, y, z] = report.zero_mm;
    rows.push(told(
        "judged as",
        format!(
            "cut by {}, {}, zero at {x}, {y}, {z} mm; its light without play or scatter",
            report.cutter,
            in_words(report.polish_mm)
        ),
    ));
    rows.push(told(
        "time",
        format!("{} on {}, {} lines", duration(3600.0 * read.hours), report.machine.name, read.lines),
    ));
    rows
}

/// All figures of a program that was judged.
pub fn check(report: &CheckReport) -> Vec<Row> {
    let ReadFacts { troubles, lines_per_second, cut_mm, .. } = &report.read;
    let mut rows: Vec<Row> =
        troubles.iter().skip(FINDINGS).map(|trouble| told(trouble.kind, trouble.sentence.clone())).collect();
    rows.push(row("cutter", report.cutter.to_string(), report.dialect.clone().unwrap_or_default()));
    rows.push(row("lines", format!("{lines_per_second:.0}"), "a second at the most"));
    rows.push(row("cuts", format!("{:.1} m", 1e-3 * cut_mm), "long in all"));
    rows.extend(bounds(&report.read).map(|bounds| row("bounds", "", bounds)));
    rows.extend(report.light.iter().flat_map(scores));
    rows
}
