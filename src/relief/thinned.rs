//! A sheet in fewer triangles: large ones where its slopes change little, small ones where they do.

use std::collections::BTreeSet;

use super::periodic::PeriodicRelief;

/// A relief whose triangles are larger than its grid's squares where that serves.
///
/// Corners are nodes of the grid. Sides run along the axes or halfway between them, so that each triangle covers whole
/// squares and halves of squares; neighbours share whole sides. The triangles of a cell repeat with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Thinned {
    /// Heights of all nodes of a cell: on the triangles, where no corner stands. Its own squares differ from the triangles
    /// in one thing: a valley along a diagonal of squares is folded the other way within each, half as high there as
    /// its fold.
    pub relief: PeriodicRelief,
    /// Columns and rows of the corners of a cell's triangles, counter-clockwise seen from above, each 0 to the number of
    /// nodes a side.
    pub triangles: Vec<[[u32; 2]; 3]>,
}

impl Thinned {
    /// Triangles of the whole plate's upper side.
    pub fn count(&self) -> usize {
        self.relief.cells[0] * self.relief.cells[1] * self.triangles.len()
    }

    /// Columns of the corners on a cell's lower side, and rows of those on its left one, ascending, both ends included: on
    /// the opposite sides they are the same.
    pub fn along_sides(&self) -> [Vec<usize>; 2] {
        [0, 1].map(|axis| {
            let corners = self.triangles.iter().flatten().filter(|corner| corner[1 - axis] == 0);
            corners.map(|corner| corner[axis] as usize).collect::<BTreeSet<_>>().into_iter().collect()
        })
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
