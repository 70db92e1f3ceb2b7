//! One continuous sheet over a plate of equal cells: heights at the nodes of a grid, two triangles a square.

use glam::{DVec2, DVec3};

use super::height_grid::{self, HeightGrid};
use crate::progress::{Cancelled, Progress};
use crate::slope::Slope;

/// A periodic height grid repeated over a plate, with a mean slope of its own.
///
/// Every square of the grid is cut along its higher diagonal into two plane triangles (see [`rises`](Self::rises)):
/// these, and no smoother surface, are the relief. The optical area's lower-left corner is x = y = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicRelief {
    /// Nodes along each side of a cell.
    pub nodes: usize,
    /// Heights of one cell's nodes about its mean plane, mm, in rows of constant y, the lowest y first.
    pub heights: Vec<f32>,
    /// Size of a cell, mm.
    pub cell: DVec2,
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// Slope of the mean plane.
    pub tilt: Slope,
}

impl PeriodicRelief {
    /// Distance of nodes along x and y, mm.
    pub fn step(&self) -> DVec2 {
        self.cell / self.nodes as f64
    }

    /// Nodes along x and y on the whole plate, both rims included.
    pub fn plate_nodes(&self) -> [usize; 2] {
        self.cells.map(|cells| cells * self.nodes + 1)
    }

    /// Place of node (i, j) of the plate, mm.
    pub fn node(&self, i: usize, j: usize) -> DVec3 {
        let at = DVec2::new(i as f64, j as f64) * self.step();
        at.extend(self.height(i, j) + self.tilt.to_vec().dot(at - 0.5 * self.size()))
    }

    /// Whether square (i, j) of the plate, its lower left corner node (i, j), is cut from there to its upper right corner;
    /// else it is cut from its lower right to its upper left one.
    ///
    /// The cut is the higher diagonal, falling where both are as high, so that a square's own fold is a ridge and never
    /// a valley: ridges come out clean whichever way they run, and no cutter has to reach into a square. It is told from
    /// the cell's heights: the tilt raises both diagonals alike.
    pub fn rises(&self, i: usize, j: usize) -> bool {
        height_grid::rises(self.corners(i, j))
    }

    /// By how much, in mm, both triangles of square (i, j) of the plate rise along x and along y over one distance of nodes,
    /// about the mean plane: the lower one first; and whether the square [`rises`](Self::rises).
    pub fn triangle_rises(&self, i: usize, j: usize) -> ([[f64; 2]; 2], bool) {
        height_grid::triangle_rises(self.corners(i, j))
    }

    /// Heights of the corners of square (i, j), as [`height_grid::rises`] takes them.
    fn corners(&self, i: usize, j: usize) -> [f64; 4] {
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(a, b)| self.height(i + a, j + b))
    }

    /// Height of node (i, j) of the plate about the mean plane, mm.
    fn height(&self, i: usize, j: usize) -> f64 {
        let n = self.nodes;
        f64::from(self.heights[j % n * n + i % n])
    }

    /// Size of the optical area, mm.
    pub fn size(&self) -> DVec2 {
        self.cell * DVec2::new(self.cells[0] as f64, self.cells[1] as f64)
    }

    /// The same on grid lines.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn height_grid(&self, progress: &Progress) -> Result<HeightGrid, Cancelled> {
        let ([nx, ny], step) = (self.plate_nodes(), self.step());
        let lines = |nodes: usize, step: f64| (0..nodes).map(|k| k as f64 * step).collect();
        let heights = (0..nx * ny).map(|k| self.node(k % nx, k / nx).z).collect();
        HeightGrid::new(lines(nx, step.x), lines(ny, step.y), heights, progress)
    }

    /// How far a cell rises from its lowest to its highest point about the mean plane, mm.
    pub fn depth(&self) -> f64 {
        let range = (f32::INFINITY, f32::NEG_INFINITY);
        let (low, high) = self.heights.iter().fold(range, |r, z| (r.0.min(*z), r.1.max(*z)));
        f64::from(high) - f64::from(low)
    }

    /// Lowest and highest point, mm.
    pub fn height_range(&self) -> (f64, f64) {
        let [nx, ny] = self.plate_nodes();
        (0..nx * ny)
            .map(|k| self.node(k % nx, k / nx).z)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |r, z| (r.0.min(z), r.1.max(z)))
    }
}

/// Heights of `nodes` × `nodes` nodes of a cell, drawn at x and y from 0 to 1 across it.
#[cfg(test)]
pub(crate) fn drawn(nodes: usize, height: impl Fn(f64, f64) -> f64) -> Vec<f32> {
    let at = |k: usize| [k % nodes, k / nodes].map(|at| at as f64 / nodes as f64);
    (0..nodes * nodes).map(at).map(|[x, y]| height(x, y) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relief::open::NodeGrid as _;

    #[test]
    fn a_tilted_plane_is_one_plane_over_all_cells() {
        let relief = PeriodicRelief {
            nodes: 4,
            heights: vec![0.5; 16],
            cell: DVec2::new(2.0, 1.0),
            cells: [3, 2],
            tilt: Slope::new(0.1, -0.2),
        };
        assert_eq!((relief.plate_nodes(), relief.size()), ([13, 9], DVec2::new(6.0, 2.0)));
        let (low, high) = relief.height_range();
        assert!((low - 0.0).abs() < 1e-12 && (high - 1.0).abs() < 1e-12, "{low} {high}");
        let planes = relief.faceted();
        assert_eq!((planes.columns(), planes.rows()), (12, 8));
        for facet in &planes.facets {
            assert!((facet.slope.to_vec() - relief.tilt.to_vec()).length() < 1e-12);
        }
        assert!((planes.plane_height(5, 3, DVec2::new(1.0, 1.0)) - (0.5 + 0.1 * (1.0 - 3.0))).abs() < 1e-12);
    }

    #[test]
    fn cells_repeat() {
        let heights: Vec<f32> = (0..9).map(|k| (k * k % 7) as f32).collect();
        let relief = PeriodicRelief { nodes: 3, heights, cell: DVec2::ONE, cells: [2, 2], tilt: Slope::FLAT };
        for (i, j) in [(0, 0), (1, 2), (2, 1)] {
            assert_eq!(relief.node(i, j).z, relief.node(i + 3, j).z);
            assert_eq!(relief.node(i, j).z, relief.node(i + 3, j + 3).z);
        }
    }

    #[test]
    fn a_square_folds_in_a_ridge_or_not_at_all() {
        let heights: Vec<f32> = (0..25).map(|k| (k * k % 11) as f32 * 0.01).collect();
        let level = PeriodicRelief { nodes: 5, heights, cell: DVec2::ONE, cells: [2, 2], tilt: Slope::FLAT };
        let tilted = PeriodicRelief { tilt: Slope::new(0.3, -0.7), ..level.clone() };
        for (i, j) in (0..100).map(|k| (k % 10, k / 10)) {
            let z = |a: usize, b: usize| level.node(i + a, j + b).z;
            let (rising, falling) = (z(0, 0) + z(1, 1), z(1, 0) + z(0, 1));
            let [cut, other] = if level.rises(i, j) { [rising, falling] } else { [falling, rising] };
            assert!(cut >= other, "({i}, {j})");
            assert_eq!(level.rises(i, j), tilted.rises(i, j));
            assert_eq!(level.rises(i, j), level.rises(i % 5, j % 5));
        }
        let flat = PeriodicRelief { heights: vec![0.1; 25], ..tilted };
        assert!((0..100).all(|k| !flat.rises(k % 10, k / 10)));
    }
}
