//! Rays over a surface: what they meet first, and next.

pub mod grid_lines;

pub mod escape_bounds;

pub mod height_field;

pub mod grid;

mod line;

mod box_tree;

mod tree_search;

mod horizon;

mod cells;

mod sorted;

pub mod mesh;

pub mod path;

pub mod traced_plate;

use glam::{DVec2, DVec3};

/// What a piece of surface is, for the accounting of light. The rules are those of the independent referee.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceKind {
    /// Faces up: normal.z > 1e-3.
    Relief,
    /// Vertical, inside the plate: |normal.z| <= 1e-3.
    Wall,
    /// The solid's underside and its outer sides: light that meets it first was never incident; later it is absorbed.
    Outer,
}

/// A point where a ray meets the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<Place> {
    /// Where, mm.
    pub point: DVec3,
    /// The surface's own name for the piece that was met: it tells normal and kind, and the next stretch starts there.
    pub place: Place,
}

/// A surface that rays can be followed over.
///
/// A path is one [`first`](Surface::first) and then a [`next`](Surface::next) for each bounce; starting from the
/// last hit's own place rather than from a point nearby is what keeps a ray from meeting its own facet again.
pub trait Surface: Sync {
    /// Names a planar piece of the surface.
    type Place: Copy + PartialEq + Send + Sync;

    /// The first hit of a ray from outside the surface's box. `direction` is a unit vector.
    fn first(&self, origin: DVec3, direction: DVec3) -> Option<Hit<Self::Place>>;

    /// The next hit of a ray that leaves `from` along the unit vector `direction`.
    fn next(&self, from: &Hit<Self::Place>, direction: DVec3) -> Option<Hit<Self::Place>>;

    /// Unit normal of a piece, out of the solid.
    fn normal(&self, place: Self::Place) -> DVec3;

    /// What a piece is.
    fn kind(&self, place: Self::Place) -> PieceKind;

    /// Lower-left and upper-right corner of the optical area, mm.
    fn optical_area(&self) -> (DVec2, DVec2);

    /// Whether the surface continues into itself beyond the optical area, which is then one period of it.
    fn is_endless(&self) -> bool {
        false
    }

    /// Planar pieces that face up and make up all relief of the optical area; 0 if the surface cannot list them.
    fn facets(&self) -> usize {
        0
    }

    /// Piece `k` below [`facets`](Self::facets): its name, and what it covers of the optical area, mm².
    fn facet(&self, _k: usize) -> Option<(Self::Place, f64)> {
        None
    }

    /// The point of that piece for `u` in the unit square, even in footprint.
    fn point_on(&self, _k: usize, _u: [f64; 2]) -> DVec3 {
        DVec3::NAN
    }

    /// Lowest and highest z at which light inside the optical area can meet the relief, mm.
    fn height_range(&self) -> (f64, f64);

    /// The middle of the optical area, halfway between lowest and highest, mm.
    fn middle(&self) -> DVec3 {
        let ((low, high), (bottom, top)) = (self.optical_area(), self.height_range());
        (0.5 * (low + high)).extend(0.5 * (bottom + top))
    }

    /// The corners of the optical area, mm.
    fn corners(&self) -> [DVec2; 4] {
        let (low, high) = self.optical_area();
        [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)]
    }
}
