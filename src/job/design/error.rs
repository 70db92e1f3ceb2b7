//! Why no plate came of a recipe.

use crate::distribution::DistributionError;
use crate::export::sheet::SheetError;
use crate::export::solid::SolidError;
use crate::memory::TooMuchMemory;
use crate::progress::Cancelled;
use crate::recipe::RecipeError;
use crate::sculpt::stages::{SculptError, TooNarrow};
use crate::trace::mesh::MeshSurfaceError;
use crate::trace::traced_plate::TracedPlateError;
use crate::verify::tally::MeasureError;

/// Why no plate came of a recipe.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DesignError {
    /// The recipe itself.
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    /// No direction above the plate.
    #[error("none of the picture's light lies above the plate: lower the light's angle or --half-field")]
    AllBelow,
    /// More than half of the light below the plate.
    #[error(
        "{:.0}% of the picture's light lies below the plate, where nothing can be seen: lower the light's angle or --half-field",
        100.0 * share
    )]
    MostlyBelow {
        /// Share of the picture's light.
        share: f64,
    },
    /// No slopes.
    #[error(transparent)]
    SlopeDistribution(#[from] DistributionError),
    /// No solid.
    #[error(transparent)]
    Solid(SolidError),
    /// No solid of a sheet.
    #[error(transparent)]
    Sheet(SheetError),
    /// The sheet's triangles cannot be traced.
    #[error(transparent)]
    Mesh(#[from] MeshSurfaceError),
    /// No sheet has the slopes.
    #[error(transparent)]
    TooNarrow(#[from] TooNarrow),
    /// The relief sends nothing into the image.
    #[error("no light reaches the highlight image: the relief shades itself completely")]
    NoLight,
    /// The sheet did not become as shallow as asked.
    #[error(
        "the relief is {depth:.3} mm deep where {most} mm were allowed, from the lowest to the highest point of a cell about its mean plane: raise --max-depth, or --cells, since smaller cells are shallower"
    )]
    TooDeep {
        /// What was reached about the mean plane, mm.
        depth: f64,
        /// What was allowed, mm.
        most: f64,
    },
    /// It would take more memory than it may.
    #[error(transparent)]
    Memory(#[from] TooMuchMemory),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<SculptError> for DesignError {
    fn from(error: SculptError) -> Self {
        match error {
            SculptError::Cutter(cutter) => RecipeError::from(cutter).into(),
            SculptError::TooNarrow(narrow) => narrow.into(),
            SculptError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}

impl From<SolidError> for DesignError {
    fn from(error: SolidError) -> Self {
        match error {
            SolidError::Cancelled(cancelled) => cancelled.into(),
            error => Self::Solid(error),
        }
    }
}

impl From<SheetError> for DesignError {
    fn from(error: SheetError) -> Self {
        match error {
            SheetError::Cancelled(cancelled) => cancelled.into(),
            error => Self::Sheet(error),
        }
    }
}

impl From<TracedPlateError> for DesignError {
    fn from(error: TracedPlateError) -> Self {
        match error {
            TracedPlateError::Cancelled(cancelled) => cancelled.into(),
            TracedPlateError::Mesh(error) => error.into(),
        }
    }
}

impl From<MeasureError> for DesignError {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::Cancelled(cancelled) => cancelled.into(),
            MeasureError::NoLight => Self::NoLight,
        }
    }
}
