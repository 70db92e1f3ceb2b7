//! A plane per facet, vertical walls between: the exact object, of which meshes and rasters are only copies.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::depth::depth_about_plane;
use super::rim::Rim;
use crate::slope::Slope;

/// One planar facet over a rectangle of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Height at the middle of the rectangle, mm.
    pub height: f64,
    /// Gradient of the plane.
    pub slope: Slope,
}

/// Planar facets on a rectilinear grid; between neighbours whose heights differ stand vertical walls.
///
/// The optical area's lower-left corner is x = y = 0. A flat rim around it, if any, is an outer ring of cells
/// like all others, with x or y outside the optical area.
#[derive(Clone, Debug, PartialEq)]
pub struct FacetedRelief {
    /// Grid lines across x, ascending, mm: one more than cells in a row.
    pub x: Vec<f64>,
    /// Grid lines across y, ascending, mm: one more than cells in a column.
    pub y: Vec<f64>,
    /// Facets in rows of constant y, the lowest y first: cell (i, j) is `facets[j * (x.len() - 1) + i]`.
    pub facets: Vec<Facet>,
    /// Columns and rows of cells that belong to the optical area.
    pub optical: (Range<usize>, Range<usize>),
}

impl FacetedRelief {
    /// `columns` × `rows` equal cells over a plate of `size` mm, facets in rows from y = 0 up.
    pub fn uniform(columns: usize, rows: usize, size: DVec2, facets: Vec<Facet>) -> Self {
        assert_eq!(facets.len(), columns * rows, "one facet a cell");
        let lines = |n: usize, length: f64| (0..=n).map(|k| length * k as f64 / n as f64).collect();
        Self { x: lines(columns, size.x), y: lines(rows, size.y), facets, optical: (0..columns, 0..rows) }
    }

    /// The same relief with a rim around it that starts level with the lowest point; a width in mm is a flat one.
    pub fn with_rim(&self, rim: impl Into<Rim>) -> Self {
        let rim = rim.into();
        let width = rim.width;
        if width <= 0.0 {
            return self.clone();
        }
        let foot = self.height_range().0;
        // Sides fall by half of this from the foot to their middles, corners by all of it.
        let piece = |slope: Slope| {
            let steps = f64::from(u8::from(slope.p != 0.0) + u8::from(slope.q != 0.0));
            Facet { height: foot - 0.5 * steps * rim.fall * width, slope }
        };
        let [west, east, south, north, south_west, south_east, north_west, north_east] = rim.slopes().map(piece);
        let widened = |lines: &[f64]| {
            let (first, last) = (lines[0], lines[lines.len() - 1]);
            [&[first - width], lines, &[last + width]].concat()
        };
        let (nx, ny) = (self.columns(), self.rows());
        let row = |first: Facet, inner: &[Facet], last: Facet| [&[first], inner, &[last]].concat();
        let mut facets = row(south_west, &vec![south; nx], south_east);
        self.facets.chunks(nx).for_each(|inner| facets.extend(row(west, inner, east)));
        facets.extend(row(north_west, &vec![north; nx], north_east));
        Self { x: widened(&self.x), y: widened(&self.y), facets, optical: (1..nx + 1, 1..ny + 1) }
    }

    /// Cells in a row.
    pub fn columns(&self) -> usize {
        self.x.len() - 1
    }

    /// Cells in a column.
    pub fn rows(&self) -> usize {
        self.y.len() - 1
    }

    /// The facet of cell (i, j).
    pub fn facet(&self, i: usize, j: usize) -> Facet {
        self.facets[j * self.columns() + i]
    }

    /// Middle of cell (i, j), mm.
    pub fn middle(&self, i: usize, j: usize) -> DVec2 {
        DVec2::new(0.5 * (self.x[i] + self.x[i + 1]), 0.5 * (self.y[j] + self.y[j + 1]))
    }

    /// Height at `at` of the plane of cell (i, j), inside the cell or not, mm.
    pub fn plane_height(&self, i: usize, j: usize, at: DVec2) -> f64 {
        let facet = self.facet(i, j);
        facet.height + facet.slope.to_vec().dot(at - self.middle(i, j))
    }

    /// Heights of cell (i, j) at its corners, in the order (x0,y0), (x1,y0), (x1,y1), (x0,y1), mm.
    pub(crate) fn corner_heights(&self, i: usize, j: usize) -> [f64; 4] {
        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| self.plane_height(i, j, DVec2::new(self.x[i + a], self.y[j + b])))
    }

    /// Lowest and highest point of all facets, rim included, mm.
    pub fn height_range(&self) -> (f64, f64) {
        self.range_of(0..self.columns(), 0..self.rows())
    }

    /// How deep it is about the plane that fits the middles of its facets best, mm; a rim counts as facets do.
    pub fn depth(&self) -> f64 {
        let places = (0..self.rows()).flat_map(|j| (0..self.columns()).map(move |i| (i, j)));
        depth_about_plane(places.map(|(i, j)| self.middle(i, j).extend(self.facet(i, j).height)))
    }

    /// Lowest and highest point of the optical area, mm.
    pub fn optical_heights(&self) -> (f64, f64) {
        let (columns, rows) = self.optical.clone();
        self.range_of(columns, rows)
    }

    fn range_of(&self, columns: Range<usize>, rows: Range<usize>) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for j in rows {
            for i in columns.clone() {
                for z in self.corner_heights(i, j) {
                    range = (range.0.min(z), range.1.max(z));
                }
            }
        }
        range
    }

    /// Lower-left and upper-right corner of the optical area, mm.
    pub fn optical_area(&self) -> (DVec2, DVec2) {
        let (columns, rows) = &self.optical;
        (DVec2::new(self.x[columns.start], self.y[rows.start]), DVec2::new(self.x[columns.end], self.y[rows.end]))
    }

    /// The box around the relief's surface, mm.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let (low, high) = self.height_range();
        (DVec3::new(self.x[0], self.y[0], low), DVec3::new(self.x[self.columns()], self.y[self.rows()], high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_tilted_plane_has_no_steps_and_the_rim_lies_at_its_foot() {
        let slope = Slope::new(0.1, -0.2);
        let facets = (0..6)
            .map(|k| {
                let middle = DVec2::new((k % 3) as f64 + 0.5, (k / 3) as f64 + 0.5);
                Facet { height: slope.to_vec().dot(middle), slope }
            })
            .collect();
        let relief = FacetedRelief::uniform(3, 2, DVec2::new(3.0, 2.0), facets);
        assert!(
            (relief.plane_height(0, 0, DVec2::new(1.0, 0.3)) - relief.plane_height(1, 0, DVec2::new(1.0, 0.3))).abs()
                < 1e-12
        );
        let (low, high) = relief.height_range();
        assert!((low + 0.4).abs() < 1e-12 && (high - 0.3).abs() < 1e-12);
        let rimmed = relief.with_rim(2.0);
        assert_eq!((rimmed.columns(), rimmed.rows()), (5, 4));
        assert_eq!(rimmed.optical_area(), relief.optical_area());
        assert_eq!(rimmed.facet(1, 1), relief.facet(0, 0));
        assert_eq!(rimmed.height_range(), relief.height_range());
        let falling = relief.with_rim(Rim { width: 2.0, fall: 0.25 });
        assert!((falling.height_range().0 - (low - 1.0)).abs() < 1e-12);
        assert_eq!(falling.optical_heights(), relief.height_range());
        // One surface from piece to piece, and at the relief's foot.
        for (i, j) in [(0, 0), (2, 0), (4, 0), (0, 2), (4, 2), (0, 3), (1, 3), (4, 3)] {
            let x = [-2.0, 0.0, 1.0, 2.0, 3.0, 5.0];
            let y = [-2.0, 0.0, 1.0, 2.0, 4.0];
            for at in [DVec2::new(x[i], y[j]), DVec2::new(x[i + 1], y[j]), DVec2::new(x[i + 1], y[j + 1])] {
                let out = (-at).max(at - DVec2::new(3.0, 2.0)).max(DVec2::ZERO);
                assert!((falling.plane_height(i, j, at) - (low - 0.25 * (out.x + out.y))).abs() < 1e-12, "{i} {j}");
            }
        }
    }
}
