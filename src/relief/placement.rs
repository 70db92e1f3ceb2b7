//! How a mesh lies: which way its relief looks, and whether its faces look outward; and turning it to lie as it should.
//!
//! A plate is flat below. Seen along each of the six axes, a side is flat as far as its faces lie in the plane of the
//! bounding box there. The relief is opposite to a flat side, and not flat itself.

use super::mesh::Mesh;

/// A side is flat if faces in one plane make up this share of it.
const FLAT: f64 = 0.95;

/// It is no relief if that share is more than this; a border may be wide.
const NO_RELIEF: f64 = 0.9;

/// A vertex belongs to a side's plane if it is this near, in sizes of the box: single precision of coordinates that are
/// some sizes from the origin.
const NEAR: f64 = 1e-5;

/// A direction along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Toward +x.
    X,
    /// Toward -x.
    MinusX,
    /// Toward +y.
    Y,
    /// Toward -y.
    MinusY,
    /// Toward +z.
    Z,
    /// Toward -z.
    MinusZ,
}

impl Axis {
    /// All six.
    pub const ALL: [Self; 6] = [Self::X, Self::MinusX, Self::Y, Self::MinusY, Self::Z, Self::MinusZ];

    /// How it is written: `x`, `-x` and so on.
    pub fn name(self) -> &'static str {
        ["x", "-x", "y", "-y", "z", "-z"][self as usize]
    }
}

/// Where a mesh's relief looks, if it has one flat side and a relief opposite to it; the largest such relief.
pub fn relief_side(mesh: &Mesh) -> Option<Axis> {
    let (low, high) = mesh.bounds();
    let size = high - low;
    let flat = Axis::ALL.map(|axis| flat_share(mesh, axis));
    let relief = |axis: &Axis| {
        let (own, opposite) = (*axis as usize, *axis as usize ^ 1);
        flat[opposite] >= FLAT && flat[own] < NO_RELIEF
    };
    let side = |axis: Axis| size.x * size.y * size.z / size[axis as usize / 2].max(f64::MIN_POSITIVE);
    let area = |axis: &Axis| side(*axis) * (1.0 - flat[*axis as usize]);
    Axis::ALL.into_iter().filter(relief).max_by(|a, b| area(a).total_cmp(&area(b)))
}

/// Share of the bounding box's side that is covered by faces in its plane.
fn flat_share(mesh: &Mesh, axis: Axis) -> f64 {
    let (low, high) = mesh.bounds();
    let size = high - low;
    let along = axis as usize / 2;
    let side = size.x * size.y * size.z / size[along];
    let plane = if (axis as usize).is_multiple_of(2) { high[along] } else { low[along] };
    let near = NEAR * (size.max_element() + low.abs().max(high.abs()).max_element());
    let area = |k: usize| {
        let [a, b, c] = mesh.corners(k);
        let within = [a, b, c].iter().all(|v| (v[along] - plane).abs() <= near);
        if within { 0.5 * (b - a).cross(c - a).length() } else { 0.0 }
    };
    let covered: f64 = (0..mesh.triangles.len()).map(area).sum();
    if side > 0.0 { covered / side } else { 0.0 }
}

/// Whether the faces of a closed mesh look inward: the volume that they enclose is negative.
pub fn is_inside_out(mesh: &Mesh) -> bool {
    let (low, high) = mesh.bounds();
    let middle = 0.5 * (low + high);
    let volume = |k: usize| {
        let [a, b, c] = mesh.corners(k).map(|v| v - middle);
        a.dot(b.cross(c))
    };
    (0..mesh.triangles.len()).map(volume).sum::<f64>() < 0.0
}

/// Every face turned over.
pub fn faces_turned(mesh: Mesh) -> Mesh {
    let triangles = mesh.triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect();
    Mesh { triangles, ..mesh }
}

/// The mesh turned so that what looked along `up` looks toward +z. Coordinates are exchanged, not computed: a grid stays
/// one. `-z` turns about the x axis, the others about the axis that is neither theirs nor z.
pub fn upright(mesh: Mesh, up: Axis) -> Mesh {
    let turn = |[x, y, z]: [f32; 3]| match up {
        Axis::X => [-z, y, x],
        Axis::MinusX => [z, y, -x],
        Axis::Y => [x, -z, y],
        Axis::MinusY => [x, z, -y],
        Axis::Z => [x, y, z],
        Axis::MinusZ => [x, -y, -z],
    };
    // Adding zero makes -0 and 0 one.
    let vertices = mesh.vertices.into_iter().map(|v| turn(v).map(|c| c + 0.0)).collect();
    Mesh { vertices, ..mesh }
}

/// The mesh times `factor`.
pub fn scaled(mesh: Mesh, factor: f64) -> Mesh {
    let times = |c: f32| (f64::from(c) * factor) as f32;
    let vertices = mesh.vertices.into_iter().map(|v| v.map(times)).collect();
    Mesh { vertices, ..mesh }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::solid::solid;
    use crate::progress::Progress;
    use crate::relief::faceted::{Facet, FacetedRelief};
    use crate::slope::Slope;
    use glam::{DVec2, DVec3};

    /// A plate of 9 × 9 tilted mirrors, 20 × 30 mm.
    fn plate(border: f64) -> Mesh {
        let facets = (0..81).map(|k| {
            let slope = Slope::new(0.1 * f64::from(k % 9 - 4), 0.05 * f64::from(k / 9 - 4));
            Facet { height: 1.0 + 0.1 * f64::from(k % 5), slope }
        });
        let relief = FacetedRelief::uniform(9, 9, DVec2::new(20.0, 30.0), facets.collect());
        solid(&if border > 0.0 { relief.with_rim(border) } else { relief }, 3.0, &Progress::silent()).unwrap()
    }

    #[test]
    fn the_relief_is_found_however_the_plate_lies_and_upright_puts_it_on_top() {
        for mesh in [plate(0.0), plate(4.0)] {
            assert_eq!(relief_side(&mesh), Some(Axis::Z));
            assert!(!is_inside_out(&mesh) && is_inside_out(&faces_turned(mesh.clone())));
            // Turned so that the relief looks elsewhere, and back.
            for up in Axis::ALL {
                let away = upright(mesh.clone(), up);
                let side = relief_side(&away).unwrap();
                assert!(!is_inside_out(&away), "{up:?}");
                let back = upright(away, side);
                assert_eq!(relief_side(&back), Some(Axis::Z), "{up:?}");
                assert!(!is_inside_out(&back) && back.open_edges() == 0);
                if side == up {
                    // Half turns and no turn undo themselves.
                    assert_eq!(back.bounds().1 - back.bounds().0, mesh.bounds().1 - mesh.bounds().0);
                }
            }
        }
    }

    /// The unit vector along an axis.
    fn vector(axis: Axis) -> DVec3 {
        let along = [DVec3::X, DVec3::Y, DVec3::Z][axis as usize / 2];
        if (axis as usize).is_multiple_of(2) { along } else { -along }
    }

    #[test]
    fn what_looks_along_the_axis_comes_to_look_up() {
        for up in Axis::ALL {
            let tip = vector(up).as_vec3().to_array();
            let mesh = Mesh { vertices: vec![tip], triangles: vec![] };
            assert_eq!(upright(mesh, up).vertices, [[0.0, 0.0, 1.0]], "{}", up.name());
        }
    }

    #[test]
    fn a_block_has_no_relief_and_a_factor_scales() {
        let flat =
            FacetedRelief::uniform(1, 1, DVec2::splat(25.4), vec![Facet { height: 0.0, slope: Slope::default() }]);
        let block = solid(&flat, 2.0, &Progress::silent()).unwrap();
        assert_eq!(relief_side(&block), None);
        assert_eq!(relief_side(&Mesh::default()), None);
        let inches = scaled(block.clone(), 1.0 / 25.4);
        assert!((inches.bounds().1.x - 1.0).abs() < 1e-6);
        assert!((scaled(inches, 25.4).bounds().1 - block.bounds().1).length() < 1e-5);
    }
}
