//! The triangles of a mesh by what they are: relief, walls, outer sides; above or below; shared edges or a rim.

use glam::DVec3;

use super::PieceKind;
use super::cells::Part;
use crate::relief::mesh::Mesh;

/// A triangle faces up, or down, only beyond this part of its unit normal along z; in between it is vertical.
const UPRIGHT: f64 = 1e-3;

/// The triangles of a mesh that have an area, those that face down by themselves.
pub(super) struct Sorted {
    pub above: Vec<[[f32; 3]; 3]>,
    pub parts: Vec<Part>,
    pub below: Vec<[[f32; 3]; 3]>,
    /// Of both, one after the other.
    pub kinds: Vec<PieceKind>,
    /// Lowest height of relief, mm; infinite if there is none.
    pub lowest: f64,
}

impl Sorted {
    pub fn new(mesh: &Mesh, low: DVec3, high: DVec3) -> Self {
        let (mut above, mut parts, mut below) = (Vec::new(), Vec::new(), Vec::new());
        let (mut kinds, mut kinds_below, mut up) = (Vec::new(), Vec::new(), Vec::new());
        let mut lowest = f64::INFINITY;
        for (k, triangle) in mesh.triangles.iter().enumerate() {
            let corners = mesh.corners(k);
            let Some((kind, climb)) = classify(&corners, low, high) else { continue };
            if kind == PieceKind::Relief {
                lowest = corners.iter().fold(lowest, |least, corner| least.min(corner.z));
            }
            let written = triangle.map(|v| mesh.vertices[v as usize]);
            if climb < -UPRIGHT {
                below.push(written);
                kinds_below.push(kind);
                continue;
            }
            above.push(written);
            kinds.push(kind);
            up.push(if climb > UPRIGHT { *triangle } else { NO_TRIANGLE });
            parts.push(if climb > UPRIGHT { Part::Inner } else { Part::Wall });
        }
        let unpaired = unpaired(&up, mesh.vertices.len());
        for (part, triangle) in parts.iter_mut().zip(&up) {
            if *part == Part::Inner && triangle.iter().any(|&v| unpaired[v as usize] != 0) {
                *part = Part::Rim;
            }
        }
        kinds.append(&mut kinds_below);
        Self { above, parts, below, kinds, lowest }
    }
}

/// In place of a triangle that does not face up.
const NO_TRIANGLE: [u32; 3] = [u32::MAX; 3];

/// For each vertex a number that is 0 where every edge of `triangles` is run both ways: of the vertices at the other ends,
/// hashed, those of edges that leave less those of edges that come.
fn unpaired(triangles: &[[u32; 3]], vertices: usize) -> Vec<u64> {
    let hash = |v: u32| {
        let mixed = (u64::from(v) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9)
    };
    let mut sums = vec![0u64; vertices];
    for &[a, b, c] in triangles.iter().filter(|triangle| **triangle != NO_TRIANGLE) {
        for (v, next, last) in [(a, b, c), (b, c, a), (c, a, b)] {
            let sum = &mut sums[v as usize];
            *sum = sum.wrapping_add(hash(next)).wrapping_sub(hash(last));
        }
    }
    sums
}

/// The kind of a triangle in a mesh with the given box and its unit normal along z, or none if it has no area.
fn classify(corners: &[DVec3; 3], low: DVec3, high: DVec3) -> Option<(PieceKind, f64)> {
    let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let length = cross.length();
    if length == 0.0 {
        return None;
    }
    let tolerance = 1e-6 * (high - low).max_element() + 1e-7;
    let on_side = |axis: usize, side: DVec3| corners.iter().all(|v| (v[axis] - side[axis]).abs() < tolerance);
    let up = cross.z / length;
    let kind = if up < -UPRIGHT || [0, 1].iter().any(|&axis| on_side(axis, low) || on_side(axis, high)) {
        PieceKind::Outer
    } else if up <= UPRIGHT {
        PieceKind::Wall
    } else {
        PieceKind::Relief
    };
    Some((kind, up))
}
