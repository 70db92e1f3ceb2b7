//! The tables of programs for a shop.

use std::path::Path;

use facetmill::report::mill::{MillReport, ProgramFacts};
use facetmill::shop::programs::duration;

use crate::tables::{Row, row, shown, told};

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

fn program_row(folder: &Path, program: &ProgramFacts) -> Row {
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
        row("machine", report.machine.name.clone(), format!("control {}", report.dialect)),
        row("stepover", format!("{} mm", report.stepover_mm), "from one finishing pass to the next"),
        row("cusps", format!("{:.4} µm", report.cusp_height_um), "between them, over a level plate"),
        row("decimals", report.machine.decimals.to_string(), "of the finishing program"),
    ];
    for program in &report.programs {
        let name = &program.part;
        rows.push(row(name, format!("{:.0}", program.read.lines_per_second), "lines a second at the most"));
        rows.push(row(name, format!("{:.1} m", 1e-3 * program.read.cut_mm), "along its cuts"));
        if let Some([low, high]) = program.read.bounds_mm {
            let axis = |k: usize| format!("{:.3} to {:.3}", low[k], high[k]);
            rows.push(row(name, "bounds", format!("x {}, y {}, z {} mm", axis(0), axis(1), axis(2))));
        }
    }
    rows
}
