//! Rays over a relief on a grid: a walk from cell to cell, walls where heights differ, and bounds that end it early.
//!
//! A path never meets its own piece again by rounding: it starts in the cell it left, and a ray that climbs away from
//! a plane does not meet that plane. Nothing leaks between cells: a ray leaves a cell only through a grid line, where
//! the neighbour's height at that very point decides between wall and passage. A ray that climbs past the cone bounds
//! of its cell has escaped and is not followed further.

use glam::{DVec2, DVec3};

use super::escape_bounds::EscapeBounds;
use super::grid_lines::GridLines;
use super::height_field::{FacetPlanes, HeightField, NodeTriangles, Stretch};
use super::{Hit, PieceKind, Surface};
use crate::progress::{Cancelled, Progress};
use crate::relief::faceted::FacetedRelief;
use crate::relief::height_grid::HeightGrid;

/// A relief on a grid, ready for rays.
#[derive(Clone, Debug)]
pub struct GridSurface<F = FacetPlanes> {
    x: GridLines,
    y: GridLines,
    field: F,
    escape: EscapeBounds,
    optical: (DVec2, DVec2),
    heights: (f64, f64),
    periodic: bool,
}

/// A cell, and what of it a path stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridPlace {
    i: u32,
    j: u32,
    face: Face,
}

/// One of the faces over and around a cell, in a byte, so that places are compared at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Face(u8);

impl Face {
    const WALLS: u8 = 2;
    const OUTER: u8 = 6;

    /// A piece of the cell's surface.
    fn piece(piece: u8) -> Self {
        Self(piece)
    }

    /// A wall that rises from the cell's edge to the neighbour; its normal.
    fn wall(side: Side) -> Self {
        Self(Self::WALLS + side as u8)
    }

    /// The plate's outer side; its normal.
    fn outer(side: Side) -> Self {
        Self(Self::OUTER + side as u8)
    }

    fn kind(self) -> PieceKind {
        match self.0 {
            0..Self::WALLS => PieceKind::Relief,
            Self::WALLS..Self::OUTER => PieceKind::Wall,
            _ => PieceKind::Outer,
        }
    }

    /// The normal of what is no piece of the cell's surface.
    fn upright(self) -> DVec3 {
        [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y][usize::from(self.0 - Self::WALLS) % 4]
    }
}

/// Directions along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    East,
    West,
    North,
    South,
}

impl GridSurface<FacetPlanes> {
    /// The facets of `relief` and the walls between them.
    pub fn new(relief: &FacetedRelief, progress: &Progress) -> Result<Self, Cancelled> {
        let (x, y) = (GridLines::new(&relief.x), GridLines::new(&relief.y));
        let planes = FacetPlanes::new(relief, progress)?;
        let surface = Self::over((x, y), planes, relief.height_range(), false, progress)?;
        Ok(surface.lit_within(relief.optical_area()))
    }

    /// The same relief repeated without end in both directions, walls where plate meets plate.
    pub fn panel(relief: &FacetedRelief, progress: &Progress) -> Result<Self, Cancelled> {
        Self::new(relief, progress)?.endless(progress)
    }
}

impl GridSurface<NodeTriangles> {
    /// The triangles of a sheet.
    pub fn continuous(grid: &HeightGrid, progress: &Progress) -> Result<Self, Cancelled> {
        let (x, y) = (GridLines::new(&grid.x), GridLines::new(&grid.y));
        Self::over((x, y), NodeTriangles::new(grid), grid.height_range(), false, progress)
    }
}

impl<F: HeightField> GridSurface<F> {
    fn over(
        (x, y): (GridLines, GridLines),
        field: F,
        heights: (f64, f64),
        periodic: bool,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let columns = x.intervals();
        let mut tops = Vec::with_capacity(columns * y.intervals());
        for j in 0..y.intervals() {
            progress.check()?;
            tops.extend((0..columns).map(|i| field.top(i, j)));
        }
        let pitch = x.shortest().min(y.shortest());
        let escape = EscapeBounds::new(&tops, columns, pitch, periodic, progress)?;
        let optical = (DVec2::new(x.ends().0, y.ends().0), DVec2::new(x.ends().1, y.ends().1));
        Ok(Self { x, y, field, escape, optical, heights, periodic })
    }

    /// The same relief repeated without end in both directions, walls where copies meet at different heights.
    pub fn endless(self, progress: &Progress) -> Result<Self, Cancelled> {
        Self::over((self.x, self.y), self.field, self.heights, true, progress)
    }

    /// The same surface, only light that falls between the corners `optical` counted.
    pub fn lit_within(self, optical: (DVec2, DVec2)) -> Self {
        Self { optical, ..self }
    }

    /// Memory that the surface takes, bytes.
    pub fn bytes(&self) -> usize {
        self.x.bytes() + self.y.bytes() + self.field.bytes() + self.escape.bytes()
    }

    fn columns(&self) -> usize {
        self.x.intervals()
    }

    fn rows(&self) -> usize {
        self.y.intervals()
    }

    /// GridPlace and piece of facet `k`.
    fn split(&self, k: usize) -> (usize, usize, u8) {
        let cell = k / F::PIECES;
        (cell % self.columns(), cell / self.columns(), (k % F::PIECES) as u8)
    }

    /// What of a cell belongs to the optical area; inverted if nothing does.
    fn lit(&self, i: usize, j: usize) -> (DVec2, DVec2) {
        let low = DVec2::new(self.x.at(i), self.y.at(j)).max(self.optical.0);
        (low, DVec2::new(self.x.at(i + 1), self.y.at(j + 1)).min(self.optical.1))
    }

    /// First and last lines of the grid, as corners.
    fn corners(&self) -> (DVec2, DVec2) {
        let ((west, east), (south, north)) = (self.x.ends(), self.y.ends());
        (DVec2::new(west, south), DVec2::new(east, north))
    }

    /// What a ray from `origin` straight down meets.
    #[inline]
    fn below(&self, origin: DVec3) -> Option<Hit<GridPlace>> {
        let (low, high) = self.corners();
        let mut at = origin.truncate();
        if !(at.cmpge(low) & at.cmple(high)).all() {
            if !self.periodic || !at.is_finite() {
                return None;
            }
            at = low + (at - low).rem_euclid(high - low);
        }
        let (i, j) = (self.x.interval(at.x), self.y.interval(at.y));
        let (z, piece) = self.field.surface(i, j, at.x, at.y);
        Some(hit(at.extend(z), i, j, Face::piece(piece)))
    }

    /// Where a ray comes to the box that holds the relief, and through which side of it, if not from above.
    fn entrance(&self, origin: DVec3, direction: DVec3) -> Option<(DVec3, Option<Side>)> {
        let (low, high) = self.corners();
        let mut entry = if origin.z > self.heights.1 { (self.heights.1 - origin.z) / direction.z } else { 0.0 };
        let mut side = None;
        if !self.periodic {
            for (line, at, d, outside, face) in [
                (low.x, origin.x, direction.x, origin.x < low.x, Side::West),
                (high.x, origin.x, direction.x, origin.x > high.x, Side::East),
                (low.y, origin.y, direction.y, origin.y < low.y, Side::South),
                (high.y, origin.y, direction.y, origin.y > high.y, Side::North),
            ] {
                if outside && (line - at) / d > entry {
                    (entry, side) = ((line - at) / d, Some(face));
                }
            }
        }
        if !(entry >= 0.0 && entry.is_finite()) {
            return None;
        }
        let point = origin + entry * direction;
        if !point.is_finite() {
            return None;
        }
        if self.periodic {
            return Some((point, None));
        }
        let slack = 1e-9 * (high - low).max_element();
        let at = point.truncate();
        let inside = (at.cmpge(low - slack) & at.cmple(high + slack)).all();
        inside.then(|| (at.clamp(low, high).extend(point.z), side))
    }

    /// Follows the ray from `from` (inside cell (i, j), on or above its surface) to its next hit.
    #[inline]
    fn walk(&self, mut i: usize, mut j: usize, mut from: DVec3, d: DVec3) -> Option<Hit<GridPlace>> {
        let level = EscapeBounds::level(d);
        let escapes = |i: usize, j: usize, z: f64| {
            level.is_some_and(|level| z >= self.escape.bound(j * self.columns() + i, level))
                && self.field.clears(i, j, d)
        };
        if escapes(i, j, from.z) {
            return None;
        }
        let inverse = DVec2::new(1.0 / d.x, 1.0 / d.y);
        let (east, north) = (usize::from(d.x > 0.0), usize::from(d.y > 0.0));
        let mut entered = 0.0;
        // A straight line crosses each grid line once at the most; along a panel it may go round and round.
        let most = (self.columns() + self.rows()) * if self.periodic { MOST_PERIODS } else { 1 };
        for _ in 0..=most {
            let (edge_x, edge_y) = (self.x.at(i + east), self.y.at(j + north));
            let to_x = if d.x == 0.0 { f64::INFINITY } else { (edge_x - from.x) * inverse.x };
            let to_y = if d.y == 0.0 { f64::INFINITY } else { (edge_y - from.y) * inverse.y };
            let left = to_x.min(to_y).max(entered);
            if let Some((t, piece)) = self.field.meet(i, j, Stretch { from, direction: d, entered, left }) {
                let point = from + t * d;
                // Only a direction of infinite length goes nowhere in no time.
                return point.is_finite().then(|| hit(point, i, j, Face::piece(piece)));
            }
            let mut point = from + left * d;
            if left == f64::INFINITY || (d.z >= 0.0 && point.z >= self.heights.1) {
                return None;
            }
            // Through the nearer grid line; at a corner through x first, then through y at the same point.
            let (mut next_i, mut next_j) = (i, j);
            let wall = if to_x <= to_y {
                point.x = edge_x;
                next_i = if east == 1 { i + 1 } else { i.wrapping_sub(1) };
                if east == 1 { Side::West } else { Side::East }
            } else {
                point.y = edge_y;
                next_j = if north == 1 { j + 1 } else { j.wrapping_sub(1) };
                if north == 1 { Side::South } else { Side::North }
            };
            if next_i >= self.columns() || next_j >= self.rows() {
                if !self.periodic {
                    return None;
                }
                // Into the next copy: the ray starts anew at the other side.
                let before = point;
                (next_i, next_j) = (wrapped(&mut point.x, next_i, &self.x), wrapped(&mut point.y, next_j, &self.y));
                if before.z < self.field.height(next_i, next_j, point.x, point.y) - SEAM {
                    return before.is_finite().then(|| hit(before, i, j, Face::wall(wall)));
                }
                (i, j, from, entered) = (next_i, next_j, point, 0.0);
            } else {
                if point.z < self.field.height(next_i, next_j, point.x, point.y) - SEAM {
                    return point.is_finite().then(|| hit(point, i, j, Face::wall(wall)));
                }
                (i, j, entered) = (next_i, next_j, left);
            }
            if escapes(i, j, point.z) {
                return None;
            }
        }
        None
    }
}

/// The cell index on the other side of the period if `next` is beyond the lines, `at` moved there.
fn wrapped(at: &mut f64, next: usize, lines: &GridLines) -> usize {
    if next < lines.intervals() {
        return next;
    }
    let (low, high) = lines.ends();
    let westward = next == usize::MAX;
    *at = if westward { high } else { low };
    if westward { lines.intervals() - 1 } else { 0 }
}

fn hit(point: DVec3, i: usize, j: usize, face: Face) -> Hit<GridPlace> {
    Hit { point, place: GridPlace { i: i as u32, j: j as u32, face } }
}

/// Steps lower than this, in mm, are rounding and not walls.
const SEAM: f64 = 1e-12;

/// Copies of a panel after which a ray that skims along it is let go.
const MOST_PERIODS: usize = 1000;

impl<F: HeightField> Surface for GridSurface<F> {
    type Place = GridPlace;

    #[inline]
    fn first(&self, origin: DVec3, direction: DVec3) -> Option<Hit<GridPlace>> {
        if direction.x == 0.0 && direction.y == 0.0 && direction.z < 0.0 && origin.z >= self.heights.1 {
            return self.below(origin);
        }
        let (mut point, side) = self.entrance(origin, direction)?;
        if self.periodic {
            let (low, high) = self.corners();
            let size = high - low;
            let at = low + (point.truncate() - low).rem_euclid(size);
            point = at.clamp(low, high).extend(point.z);
        }
        let (i, j) = (self.x.interval(point.x), self.y.interval(point.y));
        match side {
            Some(side) if point.z < self.field.height(i, j, point.x, point.y) - SEAM => {
                Some(hit(point, i, j, Face::outer(side)))
            }
            _ => self.walk(i, j, point, direction),
        }
    }

    #[inline]
    fn next(&self, from: &Hit<GridPlace>, direction: DVec3) -> Option<Hit<GridPlace>> {
        self.walk(from.place.i as usize, from.place.j as usize, from.point, direction)
    }

    #[inline]
    fn normal(&self, place: GridPlace) -> DVec3 {
        if place.face.kind() != PieceKind::Relief {
            return place.face.upright();
        }
        let (p, q) = self.field.gradient(place.i as usize, place.j as usize, place.face.0);
        DVec3::new(-p, -q, 1.0).normalize()
    }

    #[inline]
    fn kind(&self, place: GridPlace) -> PieceKind {
        place.face.kind()
    }

    fn optical_area(&self) -> (DVec2, DVec2) {
        self.optical
    }

    fn is_endless(&self) -> bool {
        self.periodic
    }

    fn facets(&self) -> usize {
        // Triangles that the rim of the optical area cuts would have to be clipped.
        let whole = F::PIECES == 1 || self.optical == self.corners();
        if whole { self.columns() * self.rows() * F::PIECES } else { 0 }
    }

    fn facet(&self, k: usize) -> Option<(GridPlace, f64)> {
        let (i, j, piece) = self.split(k);
        let (low, high) = self.lit(i, j);
        let footprint = (high - low).max(DVec2::ZERO).element_product() / F::PIECES as f64;
        Some((GridPlace { i: i as u32, j: j as u32, face: Face::piece(piece) }, footprint))
    }

    fn point_on(&self, k: usize, u: [f64; 2]) -> DVec3 {
        let (i, j, piece) = self.split(k);
        let (low, high) = self.lit(i, j);
        let mut u = DVec2::from(u);
        if self.field.piece(i, j, u) != piece {
            // Half a turn of the cell takes either of its triangles to the other.
            u = 1.0 - u;
        }
        let at = low + (high - low) * u;
        at.extend(self.field.height_of(i, j, piece, at.x, at.y))
    }

    fn height_range(&self) -> (f64, f64) {
        self.heights
    }
}

#[cfg(test)]
mod tests;
