//! `facetmill cutters`: the cutters that are known by name.

use facetmill::cutter::library::{Library, SoldCutter};
use facetmill::report::text;

use crate::args::CuttersArgs;
use crate::console::{Failure, print};
use crate::machining;

/// Does what `args` say.
pub fn run(args: &CuttersArgs) -> Result<(), Failure> {
    let library = machining::library(args.cutters.as_deref())?;
    print(&if args.json { text(&library) } else { table(&library) })?;
    Ok(())
}

/// A line for each.
fn table(library: &Library) -> String {
    let length = |length: Option<f64>| length.map_or("-".into(), |mm| mm.to_string());
    let row = |(name, cutter): (&str, &SoldCutter)| {
        let SoldCutter { shape, flutes, neck, worn_tip } = cutter;
        [name.to_owned(), shape.to_string(), length(*flutes), length(*neck), length(*worn_tip)]
    };
    let heading = ["name", "shape", "flutes", "neck", "worn tip"].map(str::to_owned);
    let rows: Vec<_> = std::iter::once(heading).chain(library.iter().map(row)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let [names, shapes, ..] = [width(0), width(1)];
    let line = |[name, shape, flutes, neck, worn]: &[String; 5]| {
        format!("  {name:names$}  {shape:shapes$}  {flutes:>6}  {neck:>5}  {worn:>8}\n")
    };
    let lines: String = rows.iter().map(line).collect();
    format!("Cutters as commonly sold, in mm; the worn tip is the flat that wear leaves, assumed.\n{lines}")
}
