//! What `design --dry-run` tells.

use facetmill::job::clock::wanted_threads;
use facetmill::job::speed::relative_speed;
use facetmill::memory::TooMuchMemory;
use facetmill::recipe::Recipe;
use facetmill::report::estimate::EstimateReport;

use crate::args::DesignArgs;
use crate::console::{Failure, Table, tell};
use crate::tables;

/// Tells what a design of `recipe` would be, on this machine, and whether it would be refused.
pub fn tell_estimate(
    args: &DesignArgs,
    recipe: &Recipe,
    report: EstimateReport,
    admitted: Result<(), TooMuchMemory>,
) -> Result<(), Failure> {
    let report = report.on_machine(relative_speed(), wanted_threads(args.running.threads));
    tell(&args.running, &report, |report| Table {
        title: "Dry run: nothing was designed or written".into(),
        rows: tables::estimate(recipe, report),
        notes: admitted.err().iter().map(|refused| format!("This would be refused: {refused}.")).collect(),
        ..Table::default()
    })?;
    Ok(())
}
