//! Rays over any triangle mesh: what stands in an STL file, whoever wrote it.
//!
//! Three rules make the tracing sound for a closed mesh.
//!
//! *No gaps.* Corners are sheared into the ray's own frame (Woop, Benthin, Wald, "Watertight Ray/Triangle
//! Intersection", JCGT 2(1), 2013), where a triangle is met if three edge functions agree in sign. Each is a
//! difference of two products; rounding is monotonic, so a computed sign is right or zero, a shared edge gives its
//! two triangles exactly opposite values, and zero counts as met. Between triangles that share corners nothing slips.
//!
//! *Inset.* A hit is moved inside its triangle until it stands `INSET` diagonals off each edge (less in slivers):
//! for a plate of 100 mm some 10 pm, far below light. The way on from an edge or a vertex is then decided by the
//! geometry and not by rounding: a neighbour across a valley lies ahead and is met, one across a ridge lies behind
//! and is not.
//!
//! *Fronts first.* The triangle just left is never met again. A front must lie ahead of the start. A back
//! (direction · normal >= 0: the mesh is open or turned inside out) is reported too, so that the caller can count
//! it, but only beyond `BACK` diagonals and only if no front lies within `BACK` of it, and only off its edges by
//! `INSET`: coplanar neighbours of a grazing ray are no leaks, nor is a silhouette edge that a ray along a wall touches.

use glam::{DVec2, DVec3};

use super::cells::Cells;
use super::line::{Line, areas_under, doubles};
use super::sorted::Sorted;
use super::tree_search::{Tree, WIDEN};
use super::{Hit, PieceKind, Surface};
use crate::relief::mesh::Mesh;

/// Least distance of a hit from the edges of its triangle, in diagonals of the mesh's box.
const INSET: f64 = 1e-10;

/// How much nearer than a front a back must be to count, in diagonals.
const BACK: f64 = 1e-9;

/// A triangle mesh, ready for rays: in a grid of cells if it is a height field, else in a tree of boxes.
///
/// Kinds are the referee's: [`PieceKind::Relief`] for normal.z > 1e-3; [`PieceKind::Outer`] for normal.z < -1e-3 and for
/// triangles with all corners on one side of the xy bounding box; [`PieceKind::Wall`] for the other vertical ones.
///
/// The grid holds what faces up and what is vertical, whether it overlaps or not; triangles that face down stand in a tree
/// that is asked only about rays that come below the highest of them, and a mesh of which one stands above the lowest relief
/// is no height field. Both find the same hits.
#[derive(Clone)]
pub struct MeshSurface {
    /// First those of the grid, then those of the tree, each in its own order; in single precision as they are in the
    /// file: exact, and half the memory.
    triangles: Vec<[[f32; 3]; 3]>,
    kinds: Vec<PieceKind>,
    cells: Option<Cells>,
    tree: Option<Tree>,
    /// Rank of the tree's first triangle.
    in_tree: u32,
    /// Height of the tree's highest triangle, mm.
    tree_top: f64,
    /// The box around all vertices, widened.
    bounds: (DVec3, DVec3),
    diagonal: f64,
    optical: (DVec2, DVec2),
    heights: (f64, f64),
    degenerate: usize,
}

impl MeshSurface {
    /// A surface over all triangles of `mesh`; its optical area is the xy bounding box less `margin` mm on each side.
    ///
    /// Fails if the mesh has no triangle that faces up, a vertex that is not finite or an index past its vertices,
    /// or if the margin is negative or leaves nothing.
    pub fn new(mesh: &Mesh, margin: f64) -> Result<Self, MeshSurfaceError> {
        Self::indexed(mesh, margin, true)
    }

    /// The same in a tree of boxes alone, whatever it is.
    pub fn in_tree(mesh: &Mesh, margin: f64) -> Result<Self, MeshSurfaceError> {
        Self::indexed(mesh, margin, false)
    }

    fn indexed(mesh: &Mesh, margin: f64, as_field: bool) -> Result<Self, MeshSurfaceError> {
        if mesh.triangles.is_empty() {
            return Err(MeshSurfaceError::Empty);
        }
        if let Some(vertex) = mesh.vertices.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(MeshSurfaceError::NotFinite { vertex });
        }
        if let Some(triangle) = mesh.triangles.iter().position(|t| t.iter().any(|&v| v as usize >= mesh.vertices.len()))
        {
            return Err(MeshSurfaceError::NoSuchVertex { triangle });
        }
        let (low, high) = mesh.bounds();
        let optical = (low.truncate() + margin, high.truncate() - margin);
        if !(margin >= 0.0 && optical.0.cmplt(optical.1).all()) {
            return Err(MeshSurfaceError::Margin { margin });
        }

        let found = Sorted::new(mesh, low, high);
        if found.lowest == f64::INFINITY {
            return Err(MeshSurfaceError::NoRelief);
        }
        let mut surface = Self {
            triangles: Vec::with_capacity(found.kinds.len()),
            kinds: Vec::with_capacity(found.kinds.len()),
            cells: None,
            tree: None,
            in_tree: 0,
            tree_top: f64::NEG_INFINITY,
            bounds: (low - WIDEN * (high - low).length(), high + WIDEN * (high - low).length()),
            diagonal: (high - low).length(),
            optical,
            heights: (found.lowest, high.z),
            degenerate: mesh.triangles.len() - found.kinds.len(),
        };
        surface.fill(found, (low, high), as_field);
        Ok(surface)
    }

    /// Whether its triangles stand in a grid of cells, and not in a tree alone.
    pub fn is_field(&self) -> bool {
        self.cells.is_some()
    }

    fn fill(&mut self, found: Sorted, (low, high): (DVec3, DVec3), as_field: bool) {
        let Sorted { mut above, parts, mut below, mut kinds, .. } = found;
        let top = below.iter().flatten().map(|corner| f64::from(corner[2])).fold(f64::NEG_INFINITY, f64::max);
        let grid = if as_field && top <= self.heights.0 { Cells::new(&above, &parts, low, high) } else { None };
        let mut kinds_below = kinds.split_off(above.len());
        if let Some((cells, order)) = grid {
            self.take(&order, &above, &kinds);
            self.cells = Some(cells);
        } else {
            above.append(&mut below);
            kinds.append(&mut kinds_below);
            (below, kinds_below) = (above, kinds);
        }
        if !below.is_empty() {
            let (tree, order) = Tree::new(&below, low, high);
            self.in_tree = self.triangles.len() as u32;
            self.take(&order, &below, &kinds_below);
            self.tree = Some(tree);
            self.tree_top = if self.is_field() { top + WIDEN * self.diagonal } else { f64::INFINITY };
        }
    }

    fn take(&mut self, order: &[u32], triangles: &[[[f32; 3]; 3]], kinds: &[PieceKind]) {
        self.triangles.extend(order.iter().map(|&k| triangles[k as usize]));
        self.kinds.extend(order.iter().map(|&k| kinds[k as usize]));
    }

    /// Triangles without area, which were left out.
    pub fn degenerate(&self) -> usize {
        self.degenerate
    }

    /// The nearest hit ahead of `origin`, in the box, along a unit vector; triangle `left` is passed over.
    fn nearest(&self, origin: DVec3, direction: DVec3, left: Option<u32>) -> Option<Hit<u32>> {
        let line = Line::new(origin, direction);
        let back = BACK * self.diagonal;
        let mut best = None;
        let mut reach = f64::INFINITY;
        let mut test = |k: u32| {
            if left != Some(k)
                && let Some((distance, weights, front)) = line.meet(&self.triangles[k as usize])
            {
                if !front && self.is_on_rim(k, weights) {
                    return reach;
                }
                let handicap = if front { 0.0 } else { back };
                let key = distance + handicap;
                // Equals go to the lower rank, so that the order of the search is of no account.
                if distance > handicap && (key < reach || best.is_some_and(|(j, _)| key == reach && k < j)) {
                    reach = key;
                    best = Some((k, weights));
                }
            }
            reach
        };
        let mut met = f64::INFINITY;
        if let Some(cells) = &self.cells {
            cells.walk(origin, direction, |k| {
                met = test(k);
                met
            });
        }
        if let Some(tree) = &self.tree
            && lowest(origin.z, direction.z, met) <= self.tree_top
        {
            tree.search(origin, direction, |k| test(self.in_tree + k));
        }
        best.map(|(k, weights)| self.hit(k, weights))
    }

    /// What a ray straight down from above everything meets, where one surface stands alone.
    #[inline]
    fn below(&self, origin: DVec3) -> Option<Hit<u32>> {
        let list = self.cells.as_ref()?.plain(origin.x, origin.y)?;
        // No edge is longer than the diagonal: what is farther off all edges than this needs no inset.
        let clear = INSET * self.diagonal * self.diagonal;
        for &k in list {
            let areas = areas_under(&self.triangles[k as usize], origin.x, origin.y);
            let least = areas.min_element();
            if least >= 0.0 {
                let weights = areas * (1.0 / areas.element_sum());
                return Some(if least > clear { self.point_of(k, weights) } else { self.hit(k, weights) });
            }
        }
        None
    }

    /// The weights of corners of points that stand `INSET` off the opposite edge, less in slivers.
    fn rim(&self, k: u32) -> DVec3 {
        let [a, b, c] = doubles(&self.triangles[k as usize]);
        let twice_area = (b - a).cross(c - a).length();
        // A weight is the distance from the opposite edge over the height above it, twice the area by the edge.
        let edges = DVec3::new((c - b).length(), (a - c).length(), (b - a).length());
        (INSET * self.diagonal / twice_area * edges).min(DVec3::splat(0.1))
    }

    #[inline]
    fn inset(&self, k: u32, weights: DVec3) -> DVec3 {
        let weights = weights.max(self.rim(k));
        weights / weights.element_sum()
    }

    fn is_on_rim(&self, k: u32, weights: DVec3) -> bool {
        weights.cmplt(self.rim(k)).any()
    }

    #[inline]
    fn hit(&self, k: u32, weights: DVec3) -> Hit<u32> {
        let weights = if weights.min_element() < 0.1 { self.inset(k, weights) } else { weights };
        self.point_of(k, weights)
    }

    #[inline]
    fn point_of(&self, k: u32, weights: DVec3) -> Hit<u32> {
        let [a, b, c] = doubles(&self.triangles[k as usize]);
        // From one corner, so that what all three share is kept exactly: off its plane by rounding, light that grazes a
        // wall at its foot would slip under the floor.
        Hit { point: a + weights.y * (b - a) + weights.z * (c - a), place: k }
    }

    fn is_over(&self, point: DVec3) -> bool {
        let (low, high) = self.bounds;
        (point.truncate().cmpge(low.truncate()) & point.truncate().cmple(high.truncate())).all()
    }

    /// Where a ray from outside comes to the box, or its start if that is inside.
    fn entrance(&self, origin: DVec3, direction: DVec3) -> Option<DVec3> {
        let (low, high) = self.bounds;
        let (mut from, mut to) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            if d != 0.0 {
                let (a, b) = ((low[axis] - o) / d, (high[axis] - o) / d);
                (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
            } else if o < low[axis] || o > high[axis] {
                return None;
            }
        }
        let start = origin + from * direction;
        (from <= to && start.is_finite()).then(|| start.clamp(low, high))
    }
}

impl Surface for MeshSurface {
    /// A triangle's rank in the surface's own order.
    type Place = u32;

    /// A start or direction that is not finite, or a direction without length, meets nothing.
    fn first(&self, origin: DVec3, direction: DVec3) -> Option<Hit<u32>> {
        if direction == -DVec3::Z
            && origin.z >= self.bounds.1.z
            && self.is_over(origin)
            && let Some(hit) = self.below(origin)
        {
            return Some(hit);
        }
        let direction = unit(direction)?;
        let start = self.entrance(origin, direction).filter(|_| origin.is_finite())?;
        self.nearest(start, direction, None)
    }

    fn next(&self, from: &Hit<u32>, direction: DVec3) -> Option<Hit<u32>> {
        let direction = unit(direction)?;
        if let Some(cells) = &self.cells
            && self.kinds[from.place as usize] == PieceKind::Relief
            && cells.escapes(from.point, direction)
        {
            return None;
        }
        self.nearest(from.point, direction, Some(from.place))
    }

    fn normal(&self, place: u32) -> DVec3 {
        let [a, b, c] = doubles(&self.triangles[place as usize]);
        (b - a).cross(c - a).normalize()
    }

    fn kind(&self, place: u32) -> PieceKind {
        self.kinds[place as usize]
    }

    fn optical_area(&self) -> (DVec2, DVec2) {
        self.optical
    }

    fn height_range(&self) -> (f64, f64) {
        self.heights
    }
}

/// The lowest height of a ray from `z` that goes `climb` up for each mm, within `reach` mm.
fn lowest(z: f64, climb: f64, reach: f64) -> f64 {
    if climb < 0.0 { z + climb * reach } else { z }
}

fn unit(direction: DVec3) -> Option<DVec3> {
    if (direction.length_squared() - 1.0).abs() < 1e-12 { Some(direction) } else { direction.try_normalize() }
}

/// Why a mesh cannot be traced.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshSurfaceError {
    /// No triangles at all.
    #[error("the mesh has no triangles")]
    Empty,
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} of the mesh has a coordinate that is not a finite number")]
    NotFinite {
        /// Its index.
        vertex: usize,
    },
    /// An index points past the list of vertices.
    #[error("triangle {triangle} of the mesh names a vertex that does not exist")]
    NoSuchVertex {
        /// Its index.
        triangle: usize,
    },
    /// Nothing would reflect light upward.
    #[error(
        "no triangle of the mesh faces up, so there is no relief to trace: is it upside down or turned inside out?"
    )]
    NoRelief,
    /// The optical area would be empty, or wider than the plate.
    #[error("a margin of {margin} mm is negative or leaves nothing of the plate")]
    Margin {
        /// As asked for, mm.
        margin: f64,
    },
}

#[cfg(test)]
mod tests;
