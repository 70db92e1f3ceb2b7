//! A cell of a sheet as cutter and polish leave it.

use crate::progress::{Cancelled, Progress};
use crate::recipe::Recipe;
use crate::relief::periodic::PeriodicRelief;
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
