//! Which triangles a ray may meet, asked of a tree of boxes.

use glam::{DVec3, UVec2, Vec3A};
use obvhs::{aabb::Aabb, cwbvh::CwBvh, fast_stack, faststack::FastStack, ray::Ray, traverse};

use super::box_tree::plant;
use super::line::double;

/// What the tree's boxes are widened by, in diagonals: some eight times what single precision can err.
pub(super) const WIDEN: f64 = 4e-6;

/// How far behind their start rays set out through the tree, in diagonals: it passes over boxes nearer than 1e-4.
const RUN_UP: f64 = 2e-4;

/// A tree of boxes over triangles.
#[derive(Clone)]
pub(super) struct Tree {
    /// Over the box around all vertices, moved to the origin and shrunk to a diagonal of 1.
    tree: CwBvh,
    /// Levels of the tree, and so the most that its search must remember.
    levels: usize,
    centre: DVec3,
    diagonal: f64,
}

impl Tree {
    /// A tree over triangles in the box from `low` to `high`, and the triangles' numbers in the order of its leaves, by
    /// which they are named from then on. Copies may be missing there.
    pub fn new(triangles: &[[[f32; 3]; 3]], low: DVec3, high: DVec3) -> (Self, Vec<u32>) {
        let (centre, diagonal) = (0.5 * (low + high), (high - low).length());
        let around = |corners: &[[f32; 3]; 3]| {
            let [a, b, c] = corners.map(double);
            let scaled = |v: DVec3, widen: f64| ((v - centre) / diagonal + widen).as_vec3a();
            Aabb::new(scaled(a.min(b).min(c), -WIDEN), scaled(a.max(b).max(c), WIDEN))
        };
        let boxes: Vec<Aabb> = triangles.iter().map(around).collect();
        let mut tree = plant(&boxes, triangles);
        let order = std::mem::take(&mut tree.primitive_indices);
        (Self { levels: levels(&tree), tree, centre, diagonal }, order)
    }

    /// Levels of nodes.
    #[cfg(test)]
    pub fn levels(&self) -> usize {
        self.levels
    }

    /// Shows `test` all triangles near the ray, except those beyond the distance that it returned last.
    pub fn search(&self, origin: DVec3, direction: DVec3, test: impl FnMut(u32) -> f64) {
        fast_stack!(UVec2, (32, 96), self.levels, stack, {
            self.search_with(origin, direction, stack, test);
        });
    }

    fn search_with<S: FastStack<UVec2>>(
        &self,
        origin: DVec3,
        direction: DVec3,
        stack: S,
        mut test: impl FnMut(u32) -> f64,
    ) {
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
