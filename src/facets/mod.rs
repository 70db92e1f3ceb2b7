//! From slopes to facets: which slope goes where, and how high each facet stands.

pub mod sample;

pub mod heights;

pub mod steps;

pub mod arrange;

use crate::slope::Slope;

/// One slope a facet, on a grid of equal cells. The size of a cell, `pitch` in mm, is passed beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct SlopeGrid {
    /// Cells in a row.
    pub columns: usize,
    /// Cells in a column.
    pub rows: usize,
    /// Slopes in rows of constant y, the lowest y first: cell (i, j) is `slopes[j * columns + i]`.
    pub slopes: Vec<Slope>,
}

impl SlopeGrid {
    /// Slope `f(i, j)` in cell (i, j).
    pub fn from_fn(columns: usize, rows: usize, mut f: impl FnMut(usize, usize) -> Slope) -> Self {
        let slopes = (0..columns * rows).map(|k| f(k % columns, k / columns)).collect();
        Self { columns, rows, slopes }
    }

    /// Cells in all.
    pub const fn cells(&self) -> usize {
        self.columns * self.rows
    }

    /// The slope of cell (i, j).
    pub fn at(&self, i: usize, j: usize) -> Slope {
        self.slopes[j * self.columns + i]
    }

    /// The mean slope (flat for an empty grid).
    pub fn mean(&self) -> Slope {
        let sum: glam::DVec2 = self.slopes.iter().map(|s| s.to_vec()).sum();
        Slope::from_vec(sum / self.slopes.len().max(1) as f64)
    }

    /// Pairs of x-neighbours (left, right), as indices into `slopes`. A grid of one column has none;
    /// `periodic` adds the pair that closes each row.
    pub(crate) fn x_pairs(&self, periodic: bool) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (columns, rows) = (self.columns, self.rows);
        let pairs = pairs_along(columns, periodic);
        (0..rows).flat_map(move |j| (0..pairs).map(move |i| (j * columns + i, j * columns + (i + 1) % columns)))
    }

    /// Pairs of y-neighbours (lower, upper), as indices into `slopes`. A grid of one row has none;
    /// `periodic` adds the pair that closes each column.
    pub(crate) fn y_pairs(&self, periodic: bool) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (columns, rows) = (self.columns, self.rows);
        let pairs = pairs_along(rows, periodic);
        (0..pairs).flat_map(move |j| (0..columns).map(move |i| (j * columns + i, (j + 1) % rows * columns + i)))
    }
}

/// Neighbour pairs along a line of `n` cells; a cell is never its own neighbour.
fn pairs_along(n: usize, periodic: bool) -> usize {
    if periodic && n > 1 { n } else { n.saturating_sub(1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_close_only_where_they_may() {
        let grid = |columns, rows| SlopeGrid::from_fn(columns, rows, |_, _| Slope::FLAT);
        let x = |columns, rows, periodic| grid(columns, rows).x_pairs(periodic).collect::<Vec<_>>();
        let y = |columns, rows, periodic| grid(columns, rows).y_pairs(periodic).collect::<Vec<_>>();
        assert_eq!(x(3, 2, false), [(0, 1), (1, 2), (3, 4), (4, 5)]);
        assert_eq!(x(3, 1, true), [(0, 1), (1, 2), (2, 0)]);
        assert_eq!(y(2, 3, true), [(0, 2), (1, 3), (2, 4), (3, 5), (4, 0), (5, 1)]);
        assert_eq!(x(2, 1, true), [(0, 1), (1, 0)]);
        assert_eq!((x(1, 5, true), y(5, 1, true)), (vec![], vec![]));
        assert_eq!((x(0, 0, true), y(0, 0, false)), (vec![], vec![]));
    }
}
