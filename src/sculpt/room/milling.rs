//! A whole plate after its cutter.

use crate::cutter::Cutter;
use crate::progress::{Cancelled, Progress};
use crate::relief::open::OpenRelief;
use crate::relief::periodic::PeriodicRelief;
use crate::sculpt::filling::Filled;
use crate::sculpt::tool::{PLACES_ACROSS_CUTTER, Tool};
use crate::slope::Slope;

use super::plate_grid::PlateGrid;

/// Places along a side at the most: 25 million of them take 100 MB a copy.
pub(crate) const MOST_PLACES: usize = 5000;

/// A relief is nowhere steeper than this; the edge of the plate is.
const CLIFF: f64 = 20.0;

/// A plate after the cutter.
pub struct MilledPlate {
    /// The grid of the tool's places.
    pub grid: PlateGrid,
    /// Heights of its lattice.
    pub heights: Vec<f32>,
    /// Height of the machined surface above the written one, mm, for each of them; 0 beside the plate.
    pub left: Vec<f32>,
}

impl MilledPlate {
    /// The most that the machined surface lies above the written one, mm.
    pub fn most_left(&self) -> f64 {
        self.left.iter().fold(0.0, |most: f64, v| most.max(f64::from(*v)))
    }

    /// The machined surface.
    pub fn relief(&self) -> OpenRelief {
        self.grid.plate(&self.heights)
    }
}

/// A cutter over the places on which plates are proved, 50 across it, on the lattice of `grid`.
pub fn usual_tool(grid: &PlateGrid, cutter: Cutter) -> Tool {
    let places = (grid.lattice.cell().max_element() * PLACES_ACROSS_CUTTER / cutter.diameter()).ceil() as usize;
    Tool { cutter, places: places.next_multiple_of(2).clamp(16, MOST_PLACES) }
}

/// What `tool` leaves of heights `z` of the lattice of `grid`.
pub fn milled(grid: &PlateGrid, z: &[f32], tool: &Tool, progress: &Progress) -> Result<MilledPlate, Cancelled> {
    let relief = lattice_relief(grid, z);
    let fine = grid.refined(tool.places);
    let cliff = CLIFF * fine.lattice.step.max_element();
    let milled = tool.mill_below(&relief, cliff as f32, progress)?;
    let mut left = milled.left;
    fine.clear_around(&mut left, 0.0);
    Ok(MilledPlate { grid: fine, heights: milled.relief.heights, left })
}

/// What is filled of the lattice of `grid`: the plate.
pub(super) fn filled(grid: &PlateGrid) -> Filled {
    Filled { squares: grid.squares, cliff: CLIFF, hurries: false }
}

/// The lattice as one cell, for a [`Tool`].
pub fn lattice_relief(grid: &PlateGrid, z: &[f32]) -> PeriodicRelief {
    let lattice = grid.lattice;
    PeriodicRelief { nodes: lattice.n, heights: z.to_vec(), cell: lattice.cell(), cells: [1, 1], tilt: Slope::FLAT }
}
