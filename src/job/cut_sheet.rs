//! A sheet as cutter and polish leave it: one cell, or the whole plate where no cell is as another.

use crate::progress::{Cancelled, Progress};
use crate::recipe::Recipe;
use crate::relief::open::OpenRelief;
use crate::relief::periodic::PeriodicRelief;
use crate::sculpt::room::milling::{milled, usual_tool};
use crate::sculpt::room::objective;
use crate::sculpt::room::plate_grid::PlateGrid;
use crate::sculpt::tool::{Tool, polished};

/// A sheet as it is made.
pub(super) struct CutSheet {
    /// One cell, after cutter and polish; as written, if it was not designed for them.
    pub(super) relief: PeriodicRelief,
    /// The most that the cutter stays above the written surface, mm.
    pub(super) left: f64,
}

impl CutSheet {
    pub(super) fn of(recipe: &Recipe, relief: &PeriodicRelief, progress: &Progress) -> Result<Self, Cancelled> {
        let (cut, left) = match recipe.design.sheet.cutter {
            None => (PeriodicRelief { cells: [1, 1], ..relief.clone() }, 0.0),
            Some(cutter) => {
                let milled = Tool::new(relief.cell, cutter).mill(relief, progress)?;
                let left = milled.most_left();
                (milled.relief, left)
            }
        };
        Ok(Self { relief: polished(cut, recipe.design.sheet.polish), left })
    }
}

/// A sheet over a whole plate after cutter and polish, and the most that the cutter stays above the written surface, mm.
///
/// # Errors
/// The work is abandoned.
pub(super) fn cut_plate(
    recipe: &Recipe,
    relief: &OpenRelief,
    progress: &Progress,
) -> Result<(OpenRelief, f64), Cancelled> {
    let (cutter, polish) = (recipe.design.sheet.cutter, recipe.design.sheet.polish);
    let grid = PlateGrid::of(relief, cutter);
    let written = grid.embedded(relief);
    let (grid, heights, left) = match cutter {
        None => (grid, written, 0.0),
        Some(cutter) => {
            let cut = milled(&grid, &written, &usual_tool(&grid, cutter), progress)?;
            let left = cut.most_left();
            (cut.grid, cut.heights, left)
        }
    };
    let heights = match polish {
        Some(sigma) => objective::polished(&grid, heights, sigma),
        None => heights,
    };
    Ok((grid.plate(&heights), left))
}
