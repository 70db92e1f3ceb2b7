//! What is held true of every file, whatever its bytes: one function for each kind of file that is read.
//!
//! They panic if the library is wrong. The answer says what became of the file, for statistics.

use std::io::Cursor;

use facetmill::export::mesh_files::{MeshFileError, ReadMesh, read_mesh};
use facetmill::export::stl::StlError;
use facetmill::picture::{Picture, PictureError, PictureFit, Reading, from_bytes};

/// What became of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It was read.
    Read,
    /// It was refused by an error.
    Refused,
    /// It was refused because code of others panicked on it and the fence held.
    Fenced,
}

/// A way from bytes to an answer.
pub type Target = fn(&[u8]) -> Fate;

/// All kinds of files, each with the folder of its corpus.
pub const TARGETS: [(&str, Target); 2] = [("picture", picture), ("stl", mesh)];

/// A picture: light on a square, or a sentence.
pub fn picture(bytes: &[u8]) -> Fate {
    // Turned, inverted and cropped by one bit of the file's length, so that half of the mutants take that way.
    let reading = match bytes.len() % 2 {
        0 => Reading::default(),
        _ => Reading { rotate: 30.0, invert: true, fit: PictureFit::Crop, ..Reading::default() },
    };
    match from_bytes(bytes, "odd", &reading) {
        Ok(Picture { light, original_size: (width, height), .. }) => {
            assert!(width.min(height) >= 2 && width.max(height) <= 10_000);
            assert_eq!((light.width, light.values.len()), (light.height, light.width * light.height));
            assert!(light.values.iter().all(|v| v.is_finite() && *v >= 0.0) && light.max() > 0.0);
            Fate::Read
        }
        Err(error) => {
            use PictureError::*;
            assert!(!matches!(error, Missing { .. } | NotAFile { .. } | Unreadable { .. } | Heavy { .. }), "{error}");
            let message = error.to_string();
            assert!(message.starts_with("odd: ") && message.len() < 600 && !message.contains('\n'), "{message}");
            if message.contains("its decoder failed") { Fate::Fenced } else { Fate::Refused }
        }
    }
}

/// A plate: a mesh of finite, numbered vertices no larger than the file allows, or a sentence.
pub fn mesh(bytes: &[u8]) -> Fate {
    match read_mesh(&mut Cursor::new(bytes)) {
        Ok(ReadMesh { mesh, format, .. }) => {
            assert!(!mesh.triangles.is_empty());
            // Of the others a polygon takes a few bytes, and a packed model can name one object often.
            assert!(format != "STL" || 50 * mesh.triangles.len() <= 2 * bytes.len());
            assert!(mesh.vertices.len() <= 3 * mesh.triangles.len());
            assert!(mesh.vertices.as_flattened().iter().all(|x| x.is_finite()));
            assert!(mesh.triangles.as_flattened().iter().all(|v| (*v as usize) < mesh.vertices.len()));
            Fate::Read
        }
        Err(MeshFileError::Stl(StlError::Parser)) => Fate::Fenced,
        Err(MeshFileError::Io(error)) => panic!("reading from memory fails: {error}"),
        Err(error) => {
            let message = error.to_string();
            assert!(message.len() < 400 && !message.contains('\n'), "{message}");
            if message.contains("its decoder failed") { Fate::Fenced } else { Fate::Refused }
        }
    }
}
