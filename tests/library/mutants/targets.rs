//! What is held true of every file, whatever its bytes: one function for each kind of file that is read.
//!
//! They panic if the library is wrong. The answer says what became of the file, for statistics.

use std::io::Cursor;

use facetmill::export::mesh_files::{MeshFileError, ReadMesh, read_mesh};
use facetmill::export::stl::StlError;
use facetmill::job::memory;
use facetmill::picture::{Picture, PictureError, PictureFit, Reading, from_bytes};
use facetmill::progress::Progress;
use facetmill::recipe::Recipe;
use facetmill::relief::recognise::recognise;
use facetmill::report::design::Mount;
use facetmill::sculpt::checkpoint::{StateError, read_state, write_state};

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
pub const TARGETS: [(&str, Target); 5] =
    [("picture", picture), ("stl", mesh), ("recipe", recipe), ("state", state), ("folder", folder)];

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
            // Whether it is a plate on a grid is found out of any mesh.
            recognise(&mesh, &Progress::silent()).unwrap();
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

/// A recipe: settings that are written as they are read and, once checked, ask for a bounded plate; or a sentence.
pub fn recipe(bytes: &[u8]) -> Fate {
    let Ok(text) = str::from_utf8(bytes) else { return Fate::Refused };
    let recipe = match Recipe::from_toml(text) {
        Ok(recipe) => recipe,
        Err(error) => return refused(&error),
    };
    if let Err(error) = recipe.check() {
        return refused(&error);
    }
    assert_eq!(Recipe::from_toml(&recipe.to_toml()).as_ref(), Ok(&recipe));
    let ([columns, rows], sheet) = (recipe.facets(), recipe.sculpting());
    assert!(columns * rows <= 4_000_000 && sheet.grid <= 4096 && recipe.pitch().is_finite());
    // As many bytes as the largest plates may take, and no more.
    assert!((1 << 20..1 << 40).contains(&memory::need(&recipe, 256, true).bytes));
    Fate::Read
}

/// The state of a design: heights of the grid that its first line tells, written again as they were read; or a sentence.
pub fn state(bytes: &[u8]) -> Fate {
    match read_state(&mut Cursor::new(bytes)) {
        Ok((at, origin)) => {
            assert_eq!(at.heights.len(), at.nodes * at.nodes);
            assert!(at.heights.iter().all(|z| z.is_finite()) && at.misplaced.len() == at.done);
            let mut again = Vec::new();
            write_state(&at, &origin, &mut again).unwrap();
            let (same, beside) = read_state(&mut again.as_slice()).unwrap();
            assert!(same == at && beside == origin);
            recipe(origin.recipe.as_bytes());
            Fate::Read
        }
        Err(StateError::Unreadable(error)) => panic!("reading from memory fails: {error}"),
        Err(error) => refused(&error),
    }
}

/// What is read back of a design's folder: its recipe, and behind a form feed its report.
pub fn folder(bytes: &[u8]) -> Fate {
    let at = bytes.iter().position(|byte| *byte == 0x0c).unwrap_or(bytes.len());
    let (settings, report) = (&bytes[..at], bytes.get(at + 1..).unwrap_or_default());
    let Ok(report) = str::from_utf8(report) else { return Fate::Refused };
    match (recipe(settings), Mount::read(report)) {
        (Fate::Read, Ok(_)) => Fate::Read,
        (_, Err(error)) => refused(&error),
        (fate, _) => fate,
    }
}

/// Refused in words, whatever bytes of the file they repeat.
fn refused(error: &dyn std::fmt::Display) -> Fate {
    assert!(!error.to_string().is_empty());
    Fate::Refused
}
