//! The nodes of a whole plate within a square lattice whose opposite rims are joined, so that what works on cells works on
//! a plate: around the plate stands nothing, in heights so low that no cutter and no hull meets them.

use glam::DVec2;

use crate::cutter::Cutter;
use crate::fourier::even_smooth_size;
use crate::relief::open::OpenRelief;
use crate::sculpt::edge_slopes::{BANDS, Lattice};

/// Cutter radii by which the surroundings lie below the lowest node, and mm more; and 40 steps of the nodes at least, so
/// that the plate's edge is steeper than any relief.
const BELOW: f64 = 4.0;

/// The grid of a plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateGrid {
    /// Squares along x and y.
    pub squares: [usize; 2],
    /// The lattice that holds the plate in its lower left corner.
    pub lattice: Lattice,
    /// By how much what is around the plate lies below its lowest node, mm.
    below: f64,
}

impl PlateGrid {
    /// For a plate of `squares` of `step` mm; a hull or a cutter from one rim does not reach the opposite one.
    pub fn new(squares: [usize; 2], step: DVec2, cutter: Option<Cutter>) -> Self {
        let radius = cutter.map_or(0.0, Cutter::valley_radius);
        // A paraboloid over a gap w wide leaves the rim at a slope of w/2R; 1.2 is steeper than any relief.
        let gap = (2.4 * radius / step.min_element()).ceil() as usize + 4;
        let n = even_smooth_size(squares[0].max(squares[1]) + 1 + gap);
        Self { squares, lattice: Lattice { n, step }, below: (BELOW * radius + 1.0).max(40.0 * step.max_element()) }
    }

    /// The grid of `relief`.
    pub fn of(relief: &OpenRelief, cutter: Option<Cutter>) -> Self {
        Self::new(relief.nodes.map(|n| n - 1), relief.step, cutter)
    }

    /// The same plate on a lattice of `n` nodes a side.
    pub fn refined(&self, n: usize) -> Self {
        let step = self.lattice.cell() / n as f64;
        Self { squares: self.squares.map(|k| k * n / self.lattice.n), lattice: Lattice { n, step }, below: self.below }
    }

    /// Rows of squares in one of the [`BANDS`].
    pub fn band(&self, band: usize) -> std::ops::Range<usize> {
        self.squares[1] * band / BANDS..self.squares[1] * (band + 1) / BANDS
    }

    /// Half of the plate's size, mm.
    pub fn half(&self) -> DVec2 {
        0.5 * self.lattice.step * DVec2::new(self.squares[0] as f64, self.squares[1] as f64)
    }

    /// Calls `change` with every node of the plate: its place in the lattice, and in the relief.
    pub fn each(&self, mut change: impl FnMut(usize, usize)) {
        let [columns, rows] = self.squares.map(|n| n + 1);
        for j in 0..rows {
            for i in 0..columns {
                change(j * self.lattice.n + i, j * columns + i);
            }
        }
    }

    /// Heights of the lattice whose plate is `relief`.
    pub fn embedded(&self, relief: &OpenRelief) -> Vec<f32> {
        let low = relief.heights.iter().fold(f32::INFINITY, |m, z| m.min(*z));
        let mut z = vec![low - self.below as f32; self.lattice.n * self.lattice.n];
        self.each(|at, node| z[at] = relief.heights[node]);
        z
    }

    /// The plate of heights of the lattice.
    pub fn plate(&self, z: &[f32]) -> OpenRelief {
        let nodes = self.squares.map(|n| n + 1);
        let mut heights = vec![0.0; nodes[0] * nodes[1]];
        self.each(|at, node| heights[node] = z[at]);
        OpenRelief { nodes, step: self.lattice.step, heights }
    }

    /// Sets everything around the plate to `value`.
    pub fn clear_around(&self, z: &mut [f32], value: f32) {
        let n = self.lattice.n;
        for (j, row) in z.chunks_mut(n).enumerate() {
            let from = if j > self.squares[1] { 0 } else { self.squares[0] + 1 };
            row[from..].fill(value);
        }
    }
}
