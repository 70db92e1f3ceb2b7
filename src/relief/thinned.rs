//! A sheet in fewer triangles: large ones where its slopes change little, small ones where they do.

use std::collections::BTreeSet;

use super::open::{NodeGrid, OpenRelief};
use super::periodic::PeriodicRelief;

/// A sheet of equal tiles, of which one tells all: the cells of a periodic one, or an open one that is a single tile.
pub trait Tiled: NodeGrid + Clone {
    /// Tiles along x and y.
    fn tiles(&self) -> [usize; 2];

    /// Whether a tile goes on into itself across its opposite sides.
    fn is_joined(&self) -> bool;

    /// Which of [`heights`](Self::heights) is that of node `at` of the first tile, all four sides included.
    fn index(&self, at: [usize; 2]) -> usize;

    /// Heights of a tile about its mean plane, mm.
    fn heights(&self) -> &[f32];

    /// The same sheet of other heights.
    fn with_heights(&self, heights: Vec<f32>) -> Self;

    /// Squares of a tile along x and y.
    fn squares(&self) -> [usize; 2] {
        let (nodes, tiles) = (self.plate_nodes(), self.tiles());
        [0, 1].map(|axis| (nodes[axis] - 1) / tiles[axis])
    }
}

impl Tiled for PeriodicRelief {
    fn tiles(&self) -> [usize; 2] {
        self.cells
    }

    fn is_joined(&self) -> bool {
        true
    }

    fn index(&self, [i, j]: [usize; 2]) -> usize {
        j % self.nodes * self.nodes + i % self.nodes
    }

    fn heights(&self) -> &[f32] {
        &self.heights
    }

    fn with_heights(&self, heights: Vec<f32>) -> Self {
        Self { heights, ..self.clone() }
    }
}

impl Tiled for OpenRelief {
    fn tiles(&self) -> [usize; 2] {
        [1, 1]
    }

    fn is_joined(&self) -> bool {
        false
    }

    fn index(&self, [i, j]: [usize; 2]) -> usize {
        j * self.nodes[0] + i
    }

    fn heights(&self) -> &[f32] {
        &self.heights
    }

    fn with_heights(&self, heights: Vec<f32>) -> Self {
        Self { heights, ..self.clone() }
    }
}

/// A relief whose triangles are larger than its grid's squares where that serves.
///
/// Corners are nodes of the grid. Sides run along the axes or halfway between them, so that each triangle covers whole
/// squares and halves of squares; neighbours share whole sides. The triangles of a tile repeat with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Thinned<R> {
    /// Heights of all nodes of a tile: on the triangles, where no corner stands. Its own squares differ from the triangles
    /// in one thing: a valley along a diagonal of squares is folded the other way within each, half as high there as
    /// its fold.
    pub relief: R,
    /// Columns and rows of the corners of a tile's triangles, counter-clockwise seen from above, each 0 to the number of
    /// squares a side.
    pub triangles: Vec<[[u32; 2]; 3]>,
}

impl<R: Tiled> Thinned<R> {
    /// Triangles of the whole plate's upper side.
    pub fn count(&self) -> usize {
        self.relief.tiles().iter().product::<usize>() * self.triangles.len()
    }

    /// Where corners stand along the rim of the plate, in squares from its lower left corner, ascending, both ends included:
    /// along its lower, right, upper and left side.
    pub fn along_rim(&self) -> [Vec<usize>; 4] {
        let (tiles, squares) = (self.relief.tiles(), self.relief.squares());
        let along = |axis: usize, line: usize| {
            let corners = self.triangles.iter().flatten().filter(|corner| corner[1 - axis] as usize == line);
            let of_tile: BTreeSet<usize> = corners.map(|corner| corner[axis] as usize).collect();
            let over = |tile: usize| of_tile.iter().map(move |at| tile * squares[axis] + at);
            (0..tiles[axis]).flat_map(over).collect::<BTreeSet<_>>().into_iter().collect()
        };
        [along(0, 0), along(1, squares[0]), along(0, squares[1]), along(1, 0)]
    }
}

/// Visits the nodes of a triangle whose corners are nodes, counter-clockwise and its sides included, until one says no; whether
/// none did. With each node come the corners' shares of it, as twice the area of the triangle opposite.
pub(crate) fn all_nodes([a, b, c]: [[i64; 2]; 3], mut visit: impl FnMut([i64; 2], [i64; 3]) -> bool) -> bool {
    let range = |axis: usize| {
        let [p, q, r] = [a, b, c].map(|corner| corner[axis]);
        p.min(q).min(r)..=p.max(q).max(r)
    };
    range(1).all(|y| {
        range(0).all(|x| {
            let at = [x, y];
            let shares = [twice_area(b, c, at), twice_area(c, a, at), twice_area(a, b, at)];
            shares.iter().any(|share| *share < 0) || visit(at, shares)
        })
    })
}

/// Twice the area of a triangle, positive where it is counter-clockwise.
pub(crate) fn twice_area(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}
