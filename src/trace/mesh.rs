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

use glam::{DVec2, DVec3, UVec2, Vec3A};
use obvhs::{aabb::Aabb, cwbvh::CwBvh, fast_stack, faststack::FastStack, ray::Ray, traverse};

use super::box_tree::plant;
use super::{Hit, PieceKind, Surface};
use crate::relief::mesh::Mesh;

/// A triangle faces up, or down, only beyond this part of its unit normal along z; in between it is vertical.
const UPRIGHT: f64 = 1e-3;

/// Least distance of a hit from the edges of its triangle, in diagonals of the mesh's box.
const INSET: f64 = 1e-10;

/// How much nearer than a front a back must be to count, in diagonals.
const BACK: f64 = 1e-9;

/// What the tree's boxes are widened by, in diagonals: some eight times what single precision can err.
const WIDEN: f64 = 4e-6;

/// How far behind their start rays set out through the tree, in diagonals: it passes over boxes nearer than 1e-4.
const RUN_UP: f64 = 2e-4;

/// A triangle mesh with a tree of boxes over it.
///
/// Kinds are the referee's: [`PieceKind::Relief`] for normal.z > 1e-3; [`PieceKind::Outer`] for normal.z < -1e-3 and for
/// triangles with all corners on one side of the xy bounding box; [`PieceKind::Wall`] for the other vertical ones.
#[derive(Clone)]
pub struct MeshSurface {
    /// In the order of the tree's leaves, in single precision as they are in the file: exact, and half the memory.
    triangles: Vec<[[f32; 3]; 3]>,
    kinds: Vec<PieceKind>,
    /// Over the box around all vertices, moved to the origin and shrunk to a diagonal of 1.
    tree: CwBvh,
    /// Levels of the tree, and so the most that its search must remember.
    levels: usize,
    /// The box around all vertices, widened.
    bounds: (DVec3, DVec3),
    centre: DVec3,
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

        let (centre, diagonal) = (0.5 * (low + high), (high - low).length());
        let (mut triangles, mut kinds, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        let mut lowest = f64::INFINITY;
        for k in 0..mesh.triangles.len() {
            let corners = mesh.corners(k);
            let Some(kind) = classify(&corners, low, high) else { continue };
            let (below, above) =
                (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
            if kind == PieceKind::Relief {
                lowest = lowest.min(below.z);
            }
            let scaled = |v: DVec3, widen: f64| ((v - centre) / diagonal + widen).as_vec3a();
            boxes.push(Aabb::new(scaled(below, -WIDEN), scaled(above, WIDEN)));
            kinds.push(kind);
            triangles.push(mesh.triangles[k].map(|v| mesh.vertices[v as usize]));
        }
        if lowest == f64::INFINITY {
            return Err(MeshSurfaceError::NoRelief);
        }

        let tree = plant(&boxes, &triangles);
        let (leaves, degenerate) = (&tree.primitive_indices, mesh.triangles.len() - triangles.len());
        Ok(Self {
            triangles: leaves.iter().map(|&k| triangles[k as usize]).collect(),
            kinds: leaves.iter().map(|&k| kinds[k as usize]).collect(),
            degenerate,
            levels: levels(&tree),
            tree,
            bounds: (low - WIDEN * diagonal, high + WIDEN * diagonal),
            centre,
            diagonal,
            optical,
            heights: (lowest, high.z),
        })
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
        fast_stack!(UVec2, (32, 96), self.levels, stack, {
            self.search(origin, direction, stack, |k| {
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
            });
        });
        best.map(|(k, weights)| self.hit(k, weights))
    }

    /// Shows `test` all triangles near the ray, except those beyond the distance that it returned last.
    fn search<S: FastStack<UVec2>>(&self, origin: DVec3, direction: DVec3, stack: S, mut test: impl FnMut(u32) -> f64) {
        let scale = 1.0 / self.diagonal;
        let start = (origin - self.centre) * scale - RUN_UP * direction;
        // The tree takes the sign of a zero for a direction, but not everywhere: adding zero makes it positive.
        let mut ray = Ray::new_inf(start.as_vec3a(), direction.as_vec3a() + Vec3A::ZERO);
        let mut state = Search {
            stack,
            current_group: UVec2::new(0, 1 << 31),
            primitive_group: UVec2::ZERO,
            oct_inv4: self.tree.new_traversal(ray.direction).oct_inv4,
            primitive_id: 0,
            hitmask: 0,
        };
        let mut node;
        traverse!(self.tree, node, state, node.intersect_ray(&ray, state.oct_inv4), {
            ray.tmax = (test(state.primitive_id) * scale + RUN_UP) as f32;
        });
    }

    /// The weights of corners of points that stand `INSET` off the opposite edge, less in slivers.
    fn rim(&self, k: u32) -> DVec3 {
        let [a, b, c] = self.triangles[k as usize].map(double);
        let twice_area = (b - a).cross(c - a).length();
        // A weight is the distance from the opposite edge over the height above it, twice the area by the edge.
        let edges = DVec3::new((c - b).length(), (a - c).length(), (b - a).length());
        (INSET * self.diagonal / twice_area * edges).min(DVec3::splat(0.1))
    }

    fn is_on_rim(&self, k: u32, weights: DVec3) -> bool {
        weights.cmplt(self.rim(k)).any()
    }

    fn hit(&self, k: u32, weights: DVec3) -> Hit<u32> {
        let [a, b, c] = self.triangles[k as usize].map(double);
        let mut weights = weights;
        if weights.min_element() < 0.1 {
            weights = weights.max(self.rim(k));
            weights /= weights.element_sum();
        }
        // From one corner, so that what all three share is kept exactly: off its plane by rounding, light that grazes a
        // wall at its foot would slip under the floor.
        Hit { point: a + weights.y * (b - a) + weights.z * (c - a), place: k }
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
        let direction = unit(direction)?;
        let start = self.entrance(origin, direction).filter(|_| origin.is_finite())?;
        self.nearest(start, direction, None)
    }

    fn next(&self, from: &Hit<u32>, direction: DVec3) -> Option<Hit<u32>> {
        self.nearest(from.point, unit(direction)?, Some(from.place))
    }

    fn normal(&self, place: u32) -> DVec3 {
        let [a, b, c] = self.triangles[place as usize].map(double);
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

/// Where a search through the tree stands. The crate's own remembers 32 groups of nodes and overwrites the last one when
/// there are more; trees over fans of long thin triangles, such as fill the underside of plates, can be deeper.
struct Search<S> {
    stack: S,
    current_group: UVec2,
    primitive_group: UVec2,
    oct_inv4: u32,
    primitive_id: u32,
    hitmask: u32,
}

/// Levels of nodes in a tree.
fn levels(tree: &CwBvh) -> usize {
    let mut deepest = 1;
    let mut open = vec![(0, 1)];
    while let Some((node, level)) = open.pop() {
        deepest = deepest.max(level);
        let node = &tree.nodes[node as usize];
        open.extend((0..8).filter(|&k| !node.is_leaf(k)).map(|k| (node.child_node_index(k), level + 1)));
    }
    deepest
}

/// The kind of a triangle in a mesh with the given box, or none if it has no area.
fn classify(corners: &[DVec3; 3], low: DVec3, high: DVec3) -> Option<PieceKind> {
    let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let length = cross.length();
    if length == 0.0 {
        return None;
    }
    let tolerance = 1e-6 * (high - low).max_element() + 1e-7;
    let on_side = |axis: usize, side: DVec3| corners.iter().all(|v| (v[axis] - side[axis]).abs() < tolerance);
    let up = cross.z / length;
    Some(if up < -UPRIGHT || [0, 1].iter().any(|&axis| on_side(axis, low) || on_side(axis, high)) {
        PieceKind::Outer
    } else if up <= UPRIGHT {
        PieceKind::Wall
    } else {
        PieceKind::Relief
    })
}

/// A ray in the frame in which it is the third axis: the one along which it is longest, the others sheared.
struct Line {
    origin: [f64; 3],
    axes: [usize; 3],
    shear: DVec2,
    stretch: f64,
}

impl Line {
    fn new(origin: DVec3, direction: DVec3) -> Self {
        let w = direction.abs().max_position();
        // Turned axes in place of mirrored ones keep the sense of rotation.
        let (u, v) = if direction[w] < 0.0 { ((w + 2) % 3, (w + 1) % 3) } else { ((w + 1) % 3, (w + 2) % 3) };
        let stretch = 1.0 / direction[w];
        Self {
            origin: origin.to_array(),
            axes: [u, v, w],
            shear: DVec2::new(direction[u], direction[v]) * stretch,
            stretch,
        }
    }

    /// Distance, weights of the corners, and whether it is the front that is met.
    fn meet(&self, corners: &[[f32; 3]; 3]) -> Option<(f64, DVec3, bool)> {
        let [a, b, c] = corners.map(|corner| {
            let [u, v, w] = self.axes.map(|axis| f64::from(corner[axis]) - self.origin[axis]);
            DVec3::new(u - self.shear.x * w, v - self.shear.y * w, w)
        });
        let edges = DVec3::new(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
        if edges.min_element() < 0.0 && edges.max_element() > 0.0 {
            return None;
        }
        let sum = edges.element_sum();
        if sum == 0.0 {
            return None;
        }
        let weights = edges / sum;
        Some((weights.dot(DVec3::new(a.z, b.z, c.z)) * self.stretch, weights, sum > 0.0))
    }
}

fn double(corner: [f32; 3]) -> DVec3 {
    DVec3::from_array(corner.map(f64::from))
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
