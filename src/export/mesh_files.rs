//! Meshes from files of others: STL, OFF, and with the feature `meshes` OBJ, PLY and 3MF.
//!
//! The format is told by content, never by name. Polygons are cut into triangles that share their first corner. Vertices
//! at exactly the same position become one, in the order of the file. Only a 3MF file says its unit; it comes out in mm.

mod names;

mod off;

#[cfg(feature = "meshes")]
mod obj;

#[cfg(feature = "meshes")]
mod ply;

#[cfg(feature = "meshes")]
mod three_mf;

#[cfg(test)]
mod tests;

use std::io::{self, Read, Seek, SeekFrom};

use thiserror::Error;

use self::names::Kind;
use super::stl::merge::MergedTriangles;
use super::stl::{StlError, is_binary_stl, read_stl_noted};
#[cfg(feature = "meshes")]
use crate::fence::fenced;
use crate::relief::mesh::Mesh;

/// The largest file of text that is held in memory, bytes.
const LARGEST_TEXT: u64 = 2 << 30;

/// A mesh that was read, and what is to be said of its file.
#[derive(Clone, Debug)]
pub struct ReadMesh {
    /// The triangles, in the unit of the file, which is mm where the format says.
    pub mesh: Mesh,
    /// How people call the format.
    pub format: &'static str,
    /// Whether the format says its unit, so that the mesh is in mm.
    pub has_unit: bool,
    /// What was passed over or put right, as sentences.
    pub notes: Vec<String>,
}

/// Reads a mesh of any format that is known here.
///
/// # Errors
/// When reading fails, or the file is none of these, is damaged, has no triangles or has coordinates that are not finite.
pub fn read_mesh(file: &mut (impl Read + Seek)) -> Result<ReadMesh, MeshFileError> {
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(0))?;
    let mut head = Vec::new();
    file.by_ref().take(names::ENOUGH).read_to_end(&mut head)?;
    file.seek(SeekFrom::Start(0))?;
    // A binary STL may say anything in its header: its length decides.
    let kind = if is_binary_stl(&head, length) { Kind::Stl } else { names::kind(&head) };
    let (format, mesh) = match kind {
        Kind::Stl => return stl(file),
        Kind::Other(found, remedy) => return Err(MeshFileError::Other { found, remedy }),
        Kind::Off => ("OFF", off::read(&text(file, length, "OFF")?)),
        #[cfg(feature = "meshes")]
        Kind::Obj => ("OBJ", fence("OBJ", || obj::read(file))),
        #[cfg(feature = "meshes")]
        Kind::Ply => ("PLY", fence("PLY", || ply::read(file, length))),
        #[cfg(feature = "meshes")]
        Kind::Zip => {
            let (mesh, notes) = fence("3MF", || three_mf::read(file))?;
            return Ok(ReadMesh { mesh: filled(mesh, "3MF")?, format: "3MF", has_unit: true, notes });
        }
    };
    Ok(ReadMesh { mesh: filled(mesh?, format)?, format, has_unit: false, notes: Vec::new() })
}

fn stl(file: &mut (impl Read + Seek)) -> Result<ReadMesh, MeshFileError> {
    let (mesh, notes) = read_stl_noted(file)?;
    Ok(ReadMesh { mesh, format: "STL", has_unit: false, notes })
}

/// A parser of others, whose panics are a damaged file.
#[cfg(feature = "meshes")]
fn fence<T>(format: &'static str, work: impl FnOnce() -> Result<T, MeshFileError>) -> Result<T, MeshFileError> {
    fenced(work).unwrap_or_else(|panicked| Err(MeshFileError::Damaged { format, reason: panicked.to_string() }))
}

/// The whole of a text file; bytes that are no UTF-8 stand in comments and names at most.
fn text(file: &mut impl Read, length: u64, format: &'static str) -> Result<String, MeshFileError> {
    if length > LARGEST_TEXT {
        return Err(MeshFileError::TooLarge { format });
    }
    let mut bytes = Vec::new();
    file.take(LARGEST_TEXT).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// A mesh that has triangles.
fn filled(triangles: MergedTriangles, format: &'static str) -> Result<Mesh, MeshFileError> {
    if triangles.len() == 0 { Err(MeshFileError::Empty { format }) } else { Ok(triangles.into_mesh()) }
}

/// Adds a polygon as triangles that share its first corner.
fn add_polygon(
    triangles: &mut MergedTriangles,
    vertices: &[[f32; 3]],
    polygon: &[usize],
    format: &'static str,
) -> Result<(), MeshFileError> {
    let corner = |k: usize| vertices.get(polygon[k]).copied();
    for k in 2..polygon.len() {
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(k - 1), corner(k)) else {
            let reason =
                format!("a face names vertex {} of {}", polygon.iter().max().unwrap_or(&0) + 1, vertices.len());
            return Err(MeshFileError::Damaged { format, reason });
        };
        triangles.add([a, b, c])?;
    }
    Ok(())
}

/// Why a file is not read as a mesh.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeshFileError {
    /// The file could not be read.
    #[error("the file cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is an STL, or nothing else either, and not read as one.
    #[error(transparent)]
    Stl(#[from] StlError),
    /// Something else, by its name.
    #[error("this is {found}, and only {} meshes are read; {remedy}", names::READ)]
    Other {
        /// What it is.
        found: &'static str,
        /// What would do.
        remedy: &'static str,
    },
    /// The content contradicts the format.
    #[error("the {format} data are damaged or cut short ({reason}); export the mesh again, best as binary STL")]
    Damaged {
        /// Its format.
        format: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// Not a single triangle.
    #[error("the {format} file has no faces: export the plate as a closed mesh, best as binary STL")]
    Empty {
        /// Its format.
        format: &'static str,
    },
    /// More than is held in memory.
    #[error("the {format} file is too large to be read as text; export the mesh as binary STL")]
    TooLarge {
        /// Its format.
        format: &'static str,
    },
}
