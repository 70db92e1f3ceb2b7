//! What is said of a sheet in parts, and of its smallest patches.

use serde::Serialize;

/// Misplaced light in windows of a sheet, at a blur of 1°.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WindowFacts {
    /// Windows of one cell.
    pub one_cell: MisplacedFacts,
    /// Windows of half a cell along each side.
    pub half_cell: MisplacedFacts,
}

/// Misplaced light in windows of one size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MisplacedFacts {
    /// Over all windows.
    pub mean: f64,
    /// In the worst window.
    pub largest: f64,
}

/// What diffraction does to a sheet's light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DiffractionFacts {
    /// The smallest patch on which the light depends, mm.
    pub smallest_patch_mm: Option<f64>,
    /// By how much diffraction spreads its light, degrees.
    pub its_blur_deg: Option<f64>,
    /// Share of the light from patches that it spreads by more than a degree.
    pub share_beyond_1deg: f64,
}
