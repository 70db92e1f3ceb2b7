//! PLY (Polygon File Format), binary and little-endian: a mesh with shared vertices, in about 40 % of the bytes of
//! a binary STL file.
//!
//! The crate that parses PLY here encodes each element through a map of its properties, and only with the feature `meshes`.

use std::io::{self, BufWriter, Write};

use super::stl::whole;
use crate::relief::mesh::Mesh;

/// Writes `mesh` in mm.
///
/// # Errors
/// When writing fails; `InvalidInput` when a triangle names a vertex that does not exist.
pub fn write_ply(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    write(mesh, None, out)
}

/// The same, each vertex of a grey of its own, from 0 to 1.
///
/// # Errors
/// When writing fails; `InvalidInput` when a triangle names a vertex that does not exist, or greys are too few.
pub(super) fn write_grey_ply(mesh: &Mesh, greys: &[f32], out: &mut impl Write) -> io::Result<()> {
    if greys.len() != mesh.vertices.len() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "as many greys as vertices are needed"));
    }
    write(mesh, Some(greys), out)
}

fn write(mesh: &Mesh, greys: Option<&[f32]>, out: &mut impl Write) -> io::Result<()> {
    whole(mesh)?;
    let mut out = BufWriter::with_capacity(1 << 16, out);
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "comment facetmill {}, unit mm, right-handed, z up", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "element vertex {}", mesh.vertices.len())?;
    writeln!(out, "property float x\nproperty float y\nproperty float z")?;
    if greys.is_some() {
        writeln!(out, "property float r\nproperty float g\nproperty float b")?;
    }
    writeln!(out, "element face {}", mesh.triangles.len())?;
    writeln!(out, "property list uchar int vertex_indices\nend_header")?;
    for (k, place) in mesh.vertices.iter().enumerate() {
        let colour = greys.map(|greys| [greys[k]; 3]);
        for number in place.iter().chain(colour.iter().flatten()) {
            out.write_all(&number.to_le_bytes())?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        for corner in triangle {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    out.flush()
}
