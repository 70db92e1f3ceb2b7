//! Heights at the crossings of a grid: a sheet of triangles.

use glam::DVec2;

use crate::progress::{Cancelled, Progress};

/// Heights at the nodes of a rectilinear grid; each square is cut along one of its diagonals into two triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightGrid {
    /// Grid lines across x, ascending, mm.
    pub x: Vec<f64>,
    /// Grid lines across y, ascending, mm.
    pub y: Vec<f64>,
    /// Heights in rows of constant y, the lowest y first, mm: node (i, j) is `heights[j * x.len() + i]`.
    pub heights: Vec<f64>,
    /// Which squares are cut from their lower left to their upper right corner, in rows of constant y, the lowest y
    /// first: square (i, j) is `rising[j * (x.len() - 1) + i]`. All others are cut from lower right to upper left.
    pub rising: Vec<bool>,
}

impl HeightGrid {
    /// Nodes over the grid lines `x` and `y`, `heights` in rows of constant y; every square is cut along its higher
    /// diagonal.
    pub fn new(x: Vec<f64>, y: Vec<f64>, heights: Vec<f64>, progress: &Progress) -> Result<Self, Cancelled> {
        assert_eq!(heights.len(), x.len() * y.len(), "one height a node");
        let columns = x.len() - 1;
        let mut rising = Vec::with_capacity(columns * (y.len() - 1));
        for j in 0..y.len() - 1 {
            progress.check()?;
            rising.extend(
                (j * x.len()..j * x.len() + columns)
                    .map(|at| rises([heights[at], heights[at + 1], heights[at + x.len()], heights[at + x.len() + 1]])),
            );
        }
        Ok(Self { rising, x, y, heights })
    }

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

/// By how much both triangles of a square rise along x and along y over one distance of nodes, in the unit of its corners'
/// heights: the lower one first; and whether it [`rises`].
pub fn triangle_rises(corners: [f64; 4]) -> ([[f64; 2]; 2], bool) {
    let ([z00, z10, z01, z11], rises) = (corners, rises(corners));
    let triangles = match rises {
        true => [[z10 - z00, z11 - z10], [z11 - z01, z01 - z00]],
        false => [[z10 - z00, z01 - z00], [z11 - z01, z11 - z10]],
    };
    (triangles, rises)
}

/// Whether the higher diagonal of a square runs from its lower left to its upper right corner; where both are alike it
/// does not.
///
/// `corners` are the heights at lower left, lower right, upper left and upper right, in one unit. Cut along the higher
/// diagonal, the square's own fold is a ridge, which any tool can leave sharp; along the lower one it would be a valley,
/// which a ball cutter fills.
pub fn rises(corners: [f64; 4]) -> bool {
    let [z00, z10, z01, z11] = corners;
    top_rises_more(z10 - z00, z11 - z01)
}

/// The same rule told from how much, or how steeply, a square rises along its bottom and along its top.
#[inline]
pub(crate) fn top_rises_more<T: PartialOrd>(bottom: T, top: T) -> bool {
    top > bottom
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_are_cut_along_their_higher_diagonal() {
        assert!(rises([1.0, 0.0, 0.0, 1.0]) && !rises([0.0, 1.0, 1.0, 0.0]));
        assert!(!rises([0.0, 0.25, 0.5, 0.75]), "a plane square counts as falling");
        // Two by one squares: a saddle, then one lower corner.
        let grid = HeightGrid::new(
            vec![0.0, 1.0, 2.0],
            vec![0.0, 3.0],
            vec![1.0, 0.0, 1.0, 0.0, 1.0, 1.0],
            &Progress::silent(),
        )
        .unwrap();
        assert_eq!(grid.rising, [true, false]);
        assert_eq!((grid.height_range(), grid.area()), ((0.0, 1.0), (DVec2::ZERO, DVec2::new(2.0, 3.0))));
    }
}
