//! A plate of patches as its cutter leaves it.

use glam::DVec2;

use super::plate::Patches;
use crate::cutter::Cutter;
use crate::progress::{Cancelled, Progress};
use crate::relief::open::OpenRelief;
use crate::relief::periodic::PeriodicRelief;
use crate::sculpt::room::milling::MOST_PLACES;
use crate::sculpt::tool::Tool;
use crate::slope::Slope;

/// Places of the cutter between two nodes, where the plate is not too large for it: 0.025 mm on nodes of 0.05 mm, a
/// twentieth of a ball of 0.5 mm. Three of them took twice the memory and time.
const BETWEEN_NODES: usize = 2;

/// A plate after the cutter.
#[derive(Clone, Debug, PartialEq)]
pub struct MilledPatches {
    /// The machined surface, on the grid of the cutter's places.
    pub relief: OpenRelief,
    /// The most that it lies above the written one, mm.
    pub most_left: f64,
}

/// What `cutter` leaves of `relief`, whose patches are level at their rims: around the plate it goes on level.
pub fn milled(
    patches: &Patches,
    relief: &OpenRelief,
    cutter: Cutter,
    progress: &Progress,
) -> Result<MilledPatches, Cancelled> {
    let n = relief.nodes[0].max(relief.nodes[1]) - 1;
    let finer = (MOST_PLACES / n).clamp(1, BETWEEN_NODES);
    // One square cell, in which the plate lies at the lower left.
    let mut heights = vec![0.0f32; n * n];
    for (row, own) in heights.chunks_mut(n).zip(relief.heights.chunks(relief.nodes[0])) {
        let width = own.len().min(n);
        row[..width].copy_from_slice(&own[..width]);
    }
    let cell = DVec2::splat(n as f64) * patches.step();
    let square = PeriodicRelief { nodes: n, heights, cell, cells: [1, 1], tilt: Slope::FLAT };
    let mut tool = Tool::new(cell, cutter);
    tool.places = n * finer;
    let cut = tool.mill(&square, progress)?;
    let nodes = relief.nodes.map(|nodes| (nodes - 1) * finer + 1);
    let places = n * finer;
    let at = |i: usize, j: usize| cut.relief.heights[j % places * places + i % places];
    let heights = (0..nodes[0] * nodes[1]).map(|k| at(k % nodes[0], k / nodes[0])).collect();
    let most_left = cut.left.iter().fold(0.0, |most: f64, left| most.max(f64::from(*left)));
    Ok(MilledPatches { relief: OpenRelief { nodes, step: relief.step / finer as f64, heights }, most_left })
}
