//! Triangles as they stand in an STL file: single precision, vertices shared exactly.

use glam::DVec3;

/// An indexed triangle mesh, mm. Triangles turn counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions as they are written.
    pub vertices: Vec<[f32; 3]>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Corners of triangle `k`, in double precision.
    pub fn corners(&self, k: usize) -> [DVec3; 3] {
        self.triangles[k].map(|v| {
            let [x, y, z] = self.vertices[v as usize];
            DVec3::new(f64::from(x), f64::from(y), f64::from(z))
        })
    }

    /// The box around all vertices (inverted if there are none), mm.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.vertices.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &[x, y, z]| {
            let v = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            (low.min(v), high.max(v))
        })
    }

    /// Triangles without area.
    pub fn degenerate(&self) -> usize {
        let flat = |k: &usize| {
            let [a, b, c] = self.corners(*k);
            (b - a).cross(c - a).length() == 0.0
        };
        (0..self.triangles.len()).filter(flat).count()
    }
}
