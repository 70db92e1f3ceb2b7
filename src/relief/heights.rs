//! Heights at the crossings of a grid: a continuous relief of triangles.

use glam::DVec2;

/// Heights at the nodes of a rectilinear grid; each square is two triangles, cut from its lower right to its upper left
/// corner.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightGrid {
    /// Grid lines across x, ascending, mm.
    pub x: Vec<f64>,
    /// Grid lines across y, ascending, mm.
    pub y: Vec<f64>,
    /// Heights in rows of constant y, the lowest y first, mm: node (i, j) is `heights[j * x.len() + i]`.
    pub heights: Vec<f64>,
}

impl HeightGrid {
    /// Lowest and highest node, mm.
    pub fn height_range(&self) -> (f64, f64) {
        self.heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &z| (low.min(z), high.max(z)))
    }

    /// Lower-left and upper-right corner, mm.
    pub fn area(&self) -> (DVec2, DVec2) {
        let ends = |lines: &[f64]| (lines[0], lines[lines.len() - 1]);
        let ((west, east), (south, north)) = (ends(&self.x), ends(&self.y));
        (DVec2::new(west, south), DVec2::new(east, north))
    }
}
