//! Nodes of a relief raised where its cutter does not reach.
//!
//! A tool is led over all places once. From then on it is led only over those whose surface can have changed: what a node
//! raises lies within a square of it, and both sweeps of the tool reach as far as the part of the profile that can touch the
//! relief. That part is chosen by the steepest rises of the whole relief; where those change it, all places are milled anew.
//! Elsewhere every number is the one of before, so that a relief is filled as if all of it were milled each time.

use crate::progress::{Cancelled, Progress};
use crate::raster::bilinear_weights;
use crate::relief::periodic::PeriodicRelief;

use super::objective::CLEARANCE;
use super::places::{Places, Rectangle};
use super::resample::{sampled, sampled_at};
use super::rises::Rises;
use super::sweep::{milled_heights, milled_places, reach};
use super::tool::Tool;

/// How often nodes are raised for one tool until it is the other's turn, at the most.
const ROUNDS: usize = 100;

/// Rounds after which filling goes on in longer strides.
const PATIENCE: usize = 10;

/// How often nodes are raised for the tool on its grid and between its places in turns, at the most; two or three are usual.
const TURNS: usize = 20;

/// What is filled of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Filled {
    /// Squares along x and y, from the lower left, that are the relief: all, or those of a plate that stands in the cell.
    pub squares: [usize; 2],
    /// Rises of this slope or steeper are no part of the relief.
    pub cliff: f64,
    /// Whether strides become longer after [`PATIENCE`] rounds.
    pub hurries: bool,
}

impl Filled {
    /// A whole cell of `nodes` nodes a side.
    pub fn whole(nodes: usize) -> Self {
        Self { squares: [nodes; 2], cliff: f64::INFINITY, hurries: true }
    }
}

/// Raises nodes of `relief` until neither of two tools, one on its grid and one between its places, leaves more than
/// [`CLEARANCE`] above its triangles.
///
/// In a valley that runs along neither axis nor diagonal the lowest points lie between the tool's places; a node raised for
/// them may be too high for the tool on its grid, and so on.
pub(super) fn clear(
    relief: &mut PeriodicRelief,
    filled: Filled,
    tools: [Tool; 2],
    progress: &Progress,
) -> Result<(), Cancelled> {
    let [mut stepping, mut finer] = tools.map(|tool| Filling::new(tool, filled, CLEARANCE));
    for _ in 0..TURNS {
        let raised = stepping.fill(relief, progress)?;
        finer.note(&raised);
        let raised = finer.fill(relief, progress)?;
        if raised.is_empty() {
            break;
        }
        stepping.note(&raised);
    }
    Ok(())
}

/// A tool whose unreached nodes are raised.
pub(super) struct Filling {
    tool: Tool,
    filled: Filled,
    /// How much may be left above the relief, mm.
    most: f64,
    /// What the last milling went by.
    last: Option<Steepest>,
    /// Nodes raised since then.
    raised: Vec<usize>,
}

/// How steeply the whole relief rises, and the parts of the tool's profile along x and y that can then touch it.
struct Steepest {
    rises: Rises,
    profiles: [Vec<(isize, f32)>; 2],
}

impl Filling {
    pub fn new(tool: Tool, filled: Filled, most: f64) -> Self {
        Self { tool, filled, most, last: None, raised: Vec::new() }
    }

    /// Hears of nodes that were raised by others.
    pub fn note(&mut self, raised: &[usize]) {
        self.raised.extend_from_slice(raised);
    }

    /// Raises nodes of `relief` until the machined surface lies nowhere too far above its triangles; returns which, some of
    /// them more than once.
    ///
    /// About one node in a thousand needs it, in a few rounds. Where nodes lie far apart for the cutter, a valley is filled
    /// slowly: its ends must rise by many times as much as the machined surface comes down. After [`PATIENCE`] rounds they
    /// may be raised by half of that: a sheet of 16 nodes in 30 mm for a ball of 1 mm did not end within a hundred rounds
    /// before.
    pub fn fill(&mut self, relief: &mut PeriodicRelief, progress: &Progress) -> Result<Vec<usize>, Cancelled> {
        let longer = (0.5 * self.rise_for_clearance(relief)).max(1.0);
        let mut all = Vec::new();
        for round in 0..ROUNDS {
            let hurries = self.filled.hurries && round >= PATIENCE;
            self.raise(relief, if hurries { longer } else { 1.0 }, progress)?;
            if self.raised.is_empty() {
                break;
            }
            all.extend_from_slice(&self.raised);
        }
        Ok(all)
    }

    /// Raises nodes once, by `stride` times what the machined surface lies too high, and notes which.
    fn raise(&mut self, relief: &mut PeriodicRelief, stride: f32, progress: &Progress) -> Result<(), Cancelled> {
        let (n, places) = (relief.nodes, self.tool.places);
        let mut raise = vec![0.0f32; n * n];
        for (k, left) in self.left(relief, progress)? {
            let at = [k % places, k / places].map(|c| (c * n / places, (c * n % places) as f32 / places as f32));
            let [(i, a), (j, b)] = at;
            // A fifth more than is needed, so that few rounds are.
            let excess = stride * (left - 0.8 * self.most as f32);
            for ((x, y), share) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().zip(bilinear_weights(a, b)) {
                let node = &mut raise[(j + y) % n * n + (i + x) % n];
                *node = node.max(excess * share);
            }
        }
        let [columns, rows] = self.filled.squares;
        self.raised = (0..n * n).filter(|k| raise[*k] != 0.0 && k % n <= columns && k / n <= rows).collect();
        self.raised.iter().for_each(|k| relief.heights[*k] += raise[*k]);
        Ok(())
    }

    /// By how much the bottom of a straight valley must rise for each mm that the machined surface shall lie lower above
    /// it, where that is 0.8 of what may be left: a ball of radius R stays R Δs²/8 above the edge of two slopes Δs apart, and
    /// a rise by z takes 2z over the distance of nodes from Δs.
    fn rise_for_clearance(&self, relief: &PeriodicRelief) -> f32 {
        let radius = self.tool.cutter.valley_radius();
        let jump = (8.0 * 0.8 * self.most / radius).sqrt();
        (2.0 * relief.step().min_element() / (radius * jump)) as f32
    }

    /// Places where the machined surface lies too far above `relief`, and by how many mm it lies above.
    fn left(&mut self, relief: &PeriodicRelief, progress: &Progress) -> Result<Vec<(usize, f32)>, Cancelled> {
        let n = self.tool.places;
        if let (Some(rectangles), Some(Steepest { profiles: [along_x, along_y], .. })) =
            (self.stale(relief), &self.last)
        {
            let around = |x, y| Places::around(&rectangles, [x * reach(along_x), y * reach(along_y)], [n, n]);
            let written = sampled_at(relief, n, &around(4, 4));
            let swept = [(3, 4), (3, 3), (2, 3), (2, 2)].map(|(x, y)| around(x, y));
            let z = milled_places(&written, n, [along_x, along_y], swept.each_ref(), progress)?;
            return Ok(self.too_much(relief.nodes, &z, &written, &swept[3]));
        }
        let written = sampled(relief, n);
        let cliff = self.filled.cliff * (relief.cell / n as f64).max_element();
        let rises = Rises::of(&written, n, cliff as f32);
        let profiles = self.tool.profiles(relief, rises.extremes());
        let z = milled_heights(&written, n, &profiles[0], &profiles[1], progress)?;
        self.last = Some(Steepest { rises, profiles });
        Ok(self.too_much(relief.nodes, &z, &written, &Places::all([n, n])))
    }

    /// Where `relief` has changed since the last milling; `None` if all of it is to be milled.
    fn stale(&mut self, relief: &PeriodicRelief) -> Option<Vec<Rectangle>> {
        let n = self.tool.places;
        let Steepest { rises, profiles } = self.last.as_mut()?;
        let rectangles = changed(&self.raised, relief.nodes, n);
        let rows: usize = rectangles.iter().map(|[_, rows]| rows.len() + 8 * reach(&profiles[1])).sum();
        // More rows of rectangles would take more memory than all places.
        if rows > n * n / 16 {
            return None;
        }
        rises.update(relief, &rectangles);
        (self.tool.profiles(relief, rises.extremes()) == *profiles).then_some(rectangles)
    }

    /// Of some `places`, those where the surface `z` lies too far above the heights `written`.
    fn too_much(&self, nodes: usize, z: &[f32], written: &[f32], places: &Places) -> Vec<(usize, f32)> {
        let n = self.tool.places;
        let [columns, rows] = self.filled.squares.map(|squares| squares * n / nodes);
        let mut found = Vec::new();
        for (j, ranges) in places.rows.iter().enumerate().take(rows + 1) {
            for i in ranges.iter().cloned().flatten().take_while(|i| *i <= columns) {
                let left = z[j * n + i] - written[j * n + i];
                if f64::from(left) > self.most {
                    found.push((j * n + i, left));
                }
            }
        }
        found
    }
}

/// The places, `places` a side, of all squares that meet at the nodes `raised` of a cell of `nodes` nodes a side: a rectangle
/// for those beside each other.
fn changed(raised: &[usize], nodes: usize, places: usize) -> Vec<Rectangle> {
    let mut sorted = raised.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let begins = |node: usize| (node as isize - 1) * places as isize;
    let from = |node: usize| begins(node).div_euclid(nodes as isize);
    let to = |node: usize| ((node + 1) * places).div_ceil(nodes) as isize + 1;
    let together = |a: &usize, b: &usize| a + 1 == *b && !b.is_multiple_of(nodes);
    let runs = sorted.chunk_by(together);
    runs.map(|run| {
        let (row, first) = (run[0] / nodes, run[0] % nodes);
        [from(first)..to(first + run.len() - 1), from(row)..to(row)]
    })
    .collect()
}

#[cfg(test)]
mod tests;
