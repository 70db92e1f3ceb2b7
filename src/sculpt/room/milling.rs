//! A whole plate after its cutter, and the filling of what the cutter cannot reach.

use crate::cutter::Cutter;
use crate::progress::{Cancelled, Progress};
use crate::raster::bilinear_weights;
use crate::relief::open::OpenRelief;
use crate::relief::periodic::PeriodicRelief;
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

/// Raises nodes of `z` until the machined surface lies nowhere more than `most` mm above the plate's triangles; returns
/// whether any node was raised. As `Tool::fill`.
pub fn fill(grid: &PlateGrid, z: &mut [f32], tool: &Tool, most: f64, progress: &Progress) -> Result<bool, Cancelled> {
    const ROUNDS: usize = 100;
    let (n, places) = (grid.lattice.n, tool.places);
    for round in 0..ROUNDS {
        let milled = milled(grid, z, tool, progress)?;
        let mut raise = vec![0.0f32; n * n];
        for (k, left) in milled.left.iter().enumerate().filter(|(_, left)| f64::from(**left) > most) {
            let at = [k % places, k / places].map(|c| (c * n / places, (c * n % places) as f32 / places as f32));
            let [(i, a), (j, b)] = at;
            let excess = left - 0.8 * most as f32;
            for ((x, y), share) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().zip(bilinear_weights(a, b)) {
                let node = &mut raise[(j + y) % n * n + (i + x) % n];
                *node = node.max(excess * share);
            }
        }
        grid.clear_around(&mut raise, 0.0);
        if raise.iter().all(|v| *v == 0.0) {
            return Ok(round > 0);
        }
        z.iter_mut().zip(&raise).for_each(|(z, v)| *z += v);
    }
    Ok(true)
}

/// The lattice as one cell, for a [`Tool`].
pub fn lattice_relief(grid: &PlateGrid, z: &[f32]) -> PeriodicRelief {
    let lattice = grid.lattice;
    PeriodicRelief { nodes: lattice.n, heights: z.to_vec(), cell: lattice.cell(), cells: [1, 1], tilt: Slope::FLAT }
}
