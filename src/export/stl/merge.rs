//! Triangles one by one, made into a mesh whose vertices are shared.

use std::hash::{BuildHasher, RandomState};

use super::StlError;
use crate::relief::mesh::Mesh;

/// Triangles whose vertices are merged by position.
pub(crate) struct MergedTriangles {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Open addressing: ids of vertices, or [`FREE`]. Less memory than a map that keeps the positions once more.
    table: Vec<u32>,
    seed: u64,
}

const FREE: u32 = u32::MAX;

impl Default for MergedTriangles {
    fn default() -> Self {
        // A seed no file can know keeps a hostile one from filling a single chain; the mesh does not depend on it.
        let seed = RandomState::new().hash_one(0);
        Self { vertices: Vec::new(), triangles: Vec::new(), table: vec![FREE; 64], seed }
    }
}

impl MergedTriangles {
    /// Sets memory aside for `count` triangles.
    pub(crate) fn reserve(&mut self, count: usize) {
        self.triangles.reserve_exact(count);
    }

    /// Number of triangles.
    pub(crate) fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Adds a triangle; fails if a coordinate is not finite or there are too many vertices.
    pub(crate) fn add(&mut self, corners: [[f32; 3]; 3]) -> Result<(), StlError> {
        if !corners.as_flattened().iter().all(|c| c.is_finite()) {
            return Err(StlError::NotFinite(self.triangles.len() + 1));
        }
        let mut triangle = [0; 3];
        for (id, position) in triangle.iter_mut().zip(corners) {
            *id = self.vertex(position)?;
        }
        self.triangles.push(triangle);
        Ok(())
    }

    /// The least and greatest coordinates.
    pub(crate) fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for vertex in &self.vertices {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(vertex[k]), high[k].max(vertex[k]));
            }
        }
        (low, high)
    }

    /// All of them as a mesh.
    pub(crate) fn into_mesh(self) -> Mesh {
        Mesh { vertices: self.vertices, triangles: self.triangles }
    }

    /// The id of the vertex at `position`.
    fn vertex(&mut self, position: [f32; 3]) -> Result<u32, StlError> {
        // Adding zero makes -0 and 0 one.
        let position = position.map(|c| c + 0.0);
        if 2 * self.vertices.len() >= self.table.len() {
            self.table = vec![FREE; 2 * self.table.len()];
            for id in 0..self.vertices.len() {
                let slot = self.slot(self.vertices[id]);
                self.table[slot] = id as u32;
            }
        }
        let slot = self.slot(position);
        if self.table[slot] == FREE {
            let id = u32::try_from(self.vertices.len()).ok().filter(|&id| id != FREE).ok_or(StlError::TooMany)?;
            self.table[slot] = id;
            self.vertices.push(position);
        }
        Ok(self.table[slot])
    }

    /// The slot that holds the vertex at `position`, or a free one for it.
    fn slot(&self, position: [f32; 3]) -> usize {
        let [x, y, z] = position.map(|c| u64::from(c.to_bits()));
        let mut hash = ((x << 32 | y) ^ self.seed).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        hash = (hash ^ hash >> 32 ^ z).wrapping_mul(0xd6e8_feb8_6659_fd93);
        let mask = self.table.len() - 1;
        let mut slot = (hash ^ hash >> 32) as usize & mask;
        while self.table[slot] != FREE && self.vertices[self.table[slot] as usize] != position {
            slot = (slot + 1) & mask;
        }
        slot
    }
}
