//! The tree of boxes over the triangles of a mesh, in a time that is about in proportion to their number, whatever they are.
//!
//! The crate's builder (PLOC: Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy
//! Construction", 2018) joins, in each of its rounds, those neighbours along a space-filling curve of which each is the
//! other's best partner. Where boxes are equal, or stand one within the other, nearly all want the same partner: a round
//! joins a pair or two, and the time goes with the square. Such crowds are found beforehand. Copies of a triangle are left
//! out, since no ray can tell them apart; what is still crowded is built in pieces of [`PIECE`], then the pieces are.

use std::collections::HashSet;

use glam::DVec3;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision, morton::morton_encode_u64_unorm},
};

/// Boxes that overlap others this far along the curve are crowded.
const APART: usize = 32;

/// Fewer crowded boxes than these cost less than a tenth of a second, however they lie (4000 copies: 0.08 s).
const CROWD: usize = 4000;

/// Boxes of a piece. With 256, nested triangles took 5.4 times as long as a clean mesh, and their chains made trees of more
/// than 32 levels.
const PIECE: usize = 16;

/// The tree over `boxes`, one of each of `triangles`. Its shape is that of the crate's `fast_build`, than which slower ones
/// were measured to search no faster; but a tree too deep for the crate's own search is no fault here.
pub fn plant(boxes: &[Aabb], triangles: &[[[f32; 3]; 3]]) -> CwBvh {
    let all: Vec<u32> = (0..boxes.len() as u32).collect();
    let pairs = if crowded(boxes, &all) < CROWD {
        well_shaped(boxes, all)
    } else {
        let single = without_copies(triangles);
        if crowded(boxes, &single) < CROWD { well_shaped(boxes, single) } else { in_pieces(boxes, single) }
    };
    bvh2_to_cwbvh(&pairs, 3, true, false)
}

fn well_shaped(boxes: &[Aabb], which: Vec<u32>) -> Bvh2 {
    let mut pairs = clustered(boxes, which);
    ReinsertionOptimizer::default().run(&mut pairs, 0.02, None);
    pairs
}

fn clustered(boxes: &[Aabb], which: Vec<u32>) -> Bvh2 {
    let chosen: Vec<Aabb> = which.iter().map(|&k| boxes[k as usize]).collect();
    let builder = &mut PlocBuilder::with_capacity(chosen.len());
    let ranks = (0..chosen.len() as u32).collect();
    let mut pairs = builder.build(PlocSearchDistance::Low, &chosen, ranks, SortPrecision::U64, 2);
    // Leaves name a place in this list.
    pairs.primitive_indices = which;
    pairs
}

/// The numbers of all triangles but those with the same corners in the same sense as an earlier one.
fn without_copies(triangles: &[[[f32; 3]; 3]]) -> Vec<u32> {
    let mut met = HashSet::with_capacity(triangles.len());
    let mut is_new = |corners: &[[f32; 3]; 3]| {
        let mut corners = corners.map(|corner| corner.map(f32::to_bits));
        // From the least corner on, whichever was written first.
        let least = (0..3).min_by_key(|k| corners[*k]).unwrap_or(0);
        corners.rotate_left(least);
        met.insert(corners)
    };
    (0..triangles.len() as u32).filter(|k| is_new(&triangles[*k as usize])).collect()
}

/// How many of the boxes overlap the one that stands [`APART`] places on along a space-filling curve.
fn crowded(boxes: &[Aabb], which: &[u32]) -> usize {
    if which.len() < CROWD {
        return 0;
    }
    let order = along_curve(boxes, which);
    let overlap = |a: u32, b: u32| {
        let (a, b) = (boxes[a as usize], boxes[b as usize]);
        a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
    };
    order.iter().zip(&order[APART..]).filter(|(a, b)| overlap(**a, **b)).count()
}

/// The same boxes in the order of their middles along Morton's curve; equals as before.
fn along_curve(boxes: &[Aabb], which: &[u32]) -> Vec<u32> {
    let whole = which.iter().fold(Aabb::empty(), |mut all, &k| {
        all.extend(boxes[k as usize].min);
        all.extend(boxes[k as usize].max);
        all
    });
    let size = whole.diagonal().as_dvec3().max(DVec3::splat(f64::MIN_POSITIVE));
    let code = |k: u32| {
        let Aabb { min, max } = boxes[k as usize];
        let at = (0.5 * (min + max) - whole.min).as_dvec3() / size;
        // The code has 21 bits for each axis, of which 1 itself is one too many.
        morton_encode_u64_unorm(at.clamp(DVec3::ZERO, DVec3::splat(1.0 - 1e-7)))
    };
    let mut coded: Vec<(u64, u32)> = which.iter().map(|&k| (code(k), k)).collect();
    coded.sort_unstable();
    coded.into_iter().map(|(_, k)| k).collect()
}

/// A tree of trees over pieces of boxes that stand together along the curve.
fn in_pieces(boxes: &[Aabb], which: Vec<u32>) -> Bvh2 {
    if which.len() <= PIECE {
        return clustered(boxes, which);
    }
    let order = along_curve(boxes, &which);
    let pieces: Vec<Bvh2> = order.chunks(PIECE).map(|piece| clustered(boxes, piece.to_vec())).collect();
    let roots: Vec<Aabb> = pieces.iter().map(|piece| *piece.nodes[0].aabb()).collect();
    let mut tree = in_pieces(&roots, (0..roots.len() as u32).collect());
    // Every leaf of the upper tree stands for a piece: its root takes the leaf's place, the rest goes to the end. Brothers
    // stand side by side, the first at an odd place, as in every tree of the crate.
    let upper = tree.nodes.len();
    let mut indices = Vec::with_capacity(order.len());
    for leaf in 0..upper {
        if !tree.nodes[leaf].is_leaf() {
            continue;
        }
        let piece = &pieces[tree.primitive_indices[tree.nodes[leaf].first_index as usize] as usize];
        let (behind, before) = (tree.nodes.len() as u32 - 1, indices.len() as u32);
        let mut moved = piece.nodes.iter().map(|node| {
            let mut node = *node;
            node.first_index += if node.is_leaf() { before } else { behind };
            node
        });
        if let Some(root) = moved.next() {
            tree.nodes[leaf] = root;
        }
        tree.nodes.extend(moved);
        indices.extend_from_slice(&piece.primitive_indices);
    }
    tree.primitive_indices = indices;
    tree.children_are_ordered_after_parents = false;
    // What the crate's own searches would have to remember at the most.
    tree.max_depth = tree.max_depth.max(tree.depth(0) + 1);
    tree
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use cpu_time::ThreadTime;
    use glam::Vec3A;

    use super::*;

    fn boxed(triangles: &[[[f32; 3]; 3]]) -> Vec<Aabb> {
        let corner = |[x, y, z]: [f32; 3]| Vec3A::new(x, y, z);
        let around = |t: &[[f32; 3]; 3]| {
            let [a, b, c] = t.map(corner);
            Aabb::new(a.min(b).min(c) - 1e-5, a.max(b).max(c) + 1e-5)
        };
        triangles.iter().map(around).collect()
    }

    /// A clean mesh: squares of a sheet, cut once.
    fn sheet(side: usize) -> Vec<[[f32; 3]; 3]> {
        let node = |i: usize, j: usize| [i as f32, j as f32, ((i * i + 3 * j) % 7) as f32].map(|c| c / side as f32);
        let square = |k: usize| {
            let (i, j) = (k % side, k / side);
            [[node(i, j), node(i + 1, j), node(i + 1, j + 1)], [node(i, j), node(i + 1, j + 1), node(i, j + 1)]]
        };
        (0..side * side).flat_map(square).collect()
    }

    fn nested(n: usize) -> Vec<[[f32; 3]; 3]> {
        let grown = |k: usize| (k + 1) as f32 / n as f32;
        (0..n).map(|k| [[0.0; 3], [grown(k), 0.0, 0.1], [0.0, grown(k), 0.2]]).collect()
    }

    /// Every triangle of `which` hangs once in the tree, within the boxes above it.
    fn assert_whole(tree: &CwBvh, boxes: &[Aabb], count: usize) {
        let mut leaves = tree.primitive_indices.clone();
        leaves.sort_unstable();
        leaves.dedup();
        assert_eq!(leaves.len(), count);
        tree.validate(boxes, false);
    }

    #[test]
    fn crowds_hang_whole_in_the_tree_and_copies_once() {
        for triangles in [nested(20_000), [nested(9000), sheet(50)].concat()] {
            let boxes = boxed(&triangles);
            assert!(crowded(&boxes, &(0..boxes.len() as u32).collect::<Vec<_>>()) >= CROWD);
            assert_whole(&plant(&boxes, &triangles), &boxes, boxes.len());
        }
        let [a, b, c] = [[0.5, 0.5, 0.0], [0.6, 0.5, 0.0], [0.5, 0.6, 0.1]];
        let copies: Vec<_> = [[a, b, c], [b, c, a], [c, a, b]].into_iter().cycle().take(9000).collect();
        let triangles = [sheet(50), copies, vec![[a, c, b]]].concat();
        let boxes = boxed(&triangles);
        let tree = plant(&boxes, &triangles);
        let mut leaves = tree.primitive_indices.clone();
        leaves.sort_unstable();
        // All of the sheet, the first of the copies, and what is turned over.
        assert_eq!(leaves, (0..5001).chain([14_000]).collect::<Vec<u32>>());
    }

    #[test]
    fn crowds_take_no_longer_than_twice_a_clean_mesh_of_their_size() {
        let n = 80_000;
        let time = |(triangles, boxes): &(Vec<[[f32; 3]; 3]>, Vec<Aabb>)| {
            let from = ThreadTime::now();
            plant(boxes, triangles);
            from.elapsed()
        };
        let with_boxes = |triangles: Vec<[[f32; 3]; 3]>| (triangles.clone(), boxed(&triangles));
        let clean = with_boxes(sheet(200));
        let copies = vec![[[0.1, 0.2, 0.3], [0.5, 0.2, 0.3], [0.1, 0.7, 0.4]]; n];
        // Bunches of equal middles and different sizes.
        let around = |k: usize| {
            [[-1.0, -1.0], [1.0, -1.0], [0.0, 2.0]].map(|[x, y]: [f32; 2]| [x * k as f32, y * k as f32, 0.0])
        };
        let concentric: Vec<_> = (1..=n).map(around).collect();
        for (what, crowd) in [("copies", copies), ("nested", nested(n)), ("concentric", concentric)] {
            // In turn, and the least of each: a machine may be twice as slow for a while.
            let crowd = with_boxes(crowd);
            let mut least = [Duration::MAX; 2];
            let holds = (1..=12).any(|round| {
                least = [least[0].min(time(&clean)), least[1].min(time(&crowd))];
                round >= 3 && least[1] < 2 * least[0]
            });
            assert!(holds, "{what}: {:?}, a clean mesh {:?}", least[1], least[0]);
        }
    }
}
