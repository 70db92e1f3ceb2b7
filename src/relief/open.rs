//! One continuous sheet over a whole plate of which nothing is repeated: heights at the nodes of a grid, its rims free.

use glam::{DVec2, DVec3};

use super::faceted::{Facet, FacetedRelief};
use super::height_grid::{self, HeightGrid};
use super::periodic::PeriodicRelief;
use crate::progress::{Cancelled, Progress};
use crate::slope::Slope;

/// Heights at all nodes of a plate, two triangles a square, cut along its higher diagonal as in [`PeriodicRelief`].
///
/// The optical area's lower-left corner is x = y = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenRelief {
    /// Nodes along x and y, both rims included.
    pub nodes: [usize; 2],
    /// Distance of nodes along x and y, mm.
    pub step: DVec2,
    /// Heights, mm, in rows of constant y, the lowest y first.
    pub heights: Vec<f32>,
}

/// A sheet whose triangles are known by their nodes: what solids and pictures are made of.
pub trait NodeGrid {
    /// Nodes along x and y on the whole plate, both rims included.
    fn plate_nodes(&self) -> [usize; 2];
    /// Distance of nodes along x and y, mm.
    fn step(&self) -> DVec2;
    /// Place of node (i, j) of the plate, mm.
    fn node(&self, i: usize, j: usize) -> DVec3;
    /// Whether square (i, j) is cut from its lower left to its upper right corner.
    fn rises(&self, i: usize, j: usize) -> bool;

    /// Size of the optical area, mm.
    fn size(&self) -> DVec2 {
        let [nx, ny] = self.plate_nodes();
        self.step() * DVec2::new((nx - 1) as f64, (ny - 1) as f64)
    }

    /// Lowest and highest point, mm.
    fn height_range(&self) -> (f64, f64) {
        let [nx, ny] = self.plate_nodes();
        (0..nx * ny)
            .map(|k| self.node(k % nx, k / nx).z)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |r, z| (r.0.min(z), r.1.max(z)))
    }

    /// A plane for each square, through the middles of its four sides: for pictures and height maps.
    fn faceted(&self) -> FacetedRelief {
        let [columns, rows] = self.plate_nodes().map(|n| n - 1);
        let step = self.step();
        let facets = (0..columns * rows)
            .map(|k| {
                let (i, j) = (k % columns, k / columns);
                let [z00, z10, z01, z11] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(a, b)| self.node(i + a, j + b).z);
                let slope = DVec2::new(z10 - z00 + z11 - z01, z01 - z00 + z11 - z10) / (2.0 * step);
                Facet { height: 0.25 * (z00 + z10 + z01 + z11), slope: Slope::from_vec(slope) }
            })
            .collect();
        FacetedRelief::uniform(columns, rows, self.size(), facets)
    }
}

impl NodeGrid for OpenRelief {
    fn plate_nodes(&self) -> [usize; 2] {
        self.nodes
    }

    fn step(&self) -> DVec2 {
        self.step
    }

    fn node(&self, i: usize, j: usize) -> DVec3 {
        let at = DVec2::new(i as f64, j as f64) * self.step;
        at.extend(f64::from(self.heights[j * self.nodes[0] + i]))
    }

    fn rises(&self, i: usize, j: usize) -> bool {
        let height = |a: usize, b: usize| f64::from(self.heights[(j + b) * self.nodes[0] + i + a]);
        height_grid::rises([(0, 0), (1, 0), (0, 1), (1, 1)].map(|(a, b)| height(a, b)))
    }
}

impl NodeGrid for PeriodicRelief {
    fn plate_nodes(&self) -> [usize; 2] {
        self.plate_nodes()
    }

    fn step(&self) -> DVec2 {
        self.step()
    }

    fn node(&self, i: usize, j: usize) -> DVec3 {
        self.node(i, j)
    }

    fn rises(&self, i: usize, j: usize) -> bool {
        self.rises(i, j)
    }
}

impl OpenRelief {
    /// The relief of `height` (mm, of a place from the plate's middle) at the nodes of a plate.
    pub fn from_fn(nodes: [usize; 2], step: DVec2, height: impl Fn(DVec2) -> f64) -> Self {
        let middle = 0.5 * step * DVec2::new((nodes[0] - 1) as f64, (nodes[1] - 1) as f64);
        let at = |k: usize| DVec2::new((k % nodes[0]) as f64, (k / nodes[0]) as f64) * step - middle;
        Self { nodes, step, heights: (0..nodes[0] * nodes[1]).map(|k| height(at(k)) as f32).collect() }
    }

    /// The same on grid lines.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn height_grid(&self, progress: &Progress) -> Result<HeightGrid, Cancelled> {
        let lines = |nodes: usize, step: f64| (0..nodes).map(|k| k as f64 * step).collect();
        let [nx, ny] = self.nodes;
        let heights = self.heights.iter().map(|z| f64::from(*z)).collect();
        HeightGrid::new(lines(nx, self.step.x), lines(ny, self.step.y), heights, progress)
    }

    /// Heights about their mean, so that the middle of the plate's mean height is 0.
    pub fn about_mean(mut self) -> Self {
        let mean = self.heights.iter().map(|z| f64::from(*z)).sum::<f64>() / self.heights.len() as f64;
        self.heights.iter_mut().for_each(|z| *z = (f64::from(*z) - mean) as f32);
        self
    }

    /// How far the relief rises from its lowest to its highest point, mm.
    pub fn depth(&self) -> f64 {
        let (low, high) = self.height_range();
        high - low
    }
}
