//! Wavefront OBJ: a mesh as text, vertices shared, read by nearly everything that shows or edits meshes.

use std::io::{self, BufWriter, Write};

use super::stl::whole;
use crate::relief::mesh::Mesh;

/// Writes `mesh` in mm, each coordinate by the fewest digits that read back as the same number.
///
/// # Errors
/// When writing fails; `InvalidInput` when a triangle names a vertex that does not exist.
pub fn write_obj(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    whole(mesh)?;
    let mut out = BufWriter::with_capacity(1 << 16, out);
    writeln!(out, "# facetmill {}, unit mm, right-handed, z up", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "o plate")?;
    for [x, y, z] in &mesh.vertices {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for [a, b, c] in &mesh.triangles {
        // The first vertex is 1.
        writeln!(out, "f {} {} {}", u64::from(*a) + 1, u64::from(*b) + 1, u64::from(*c) + 1)?;
    }
    out.flush()
}
