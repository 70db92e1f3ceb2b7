//! OBJ (Wavefront), parsed by the crate `tobj`: its faces, whatever groups, normals and materials they have.

use std::io::{self, BufRead, BufReader, Read};

use tobj::{LoadOptions, load_obj_buf};

use super::{MergedTriangles, MeshFileError};

/// Reads a whole file.
pub(crate) fn read(file: &mut impl Read) -> Result<MergedTriangles, MeshFileError> {
    let options = LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    // Materials are of no interest, and what a file names is not opened.
    let none = |_: &std::path::Path| Ok(Default::default());
    let (models, _) = load_obj_buf(&mut BufReader::new(Joined::new(file)), &options, none)
        .map_err(|error| MeshFileError::Damaged { format: "OBJ", reason: error.to_string() })?;
    let mut triangles = MergedTriangles::default();
    for model in models {
        let positions = model.mesh.positions;
        let corner = |index: u32| {
            let from = 3 * index as usize;
            positions.get(from..from + 3).map(|xyz| [xyz[0], xyz[1], xyz[2]])
        };
        for [a, b, c] in model.mesh.indices.as_chunks::<3>().0 {
            if let (Some(a), Some(b), Some(c)) = (corner(*a), corner(*b), corner(*c)) {
                triangles.add([a, b, c])?;
            }
        }
    }
    Ok(triangles)
}

/// A text whose lines go on where they end with a backslash.
struct Joined<R> {
    file: BufReader<R>,
    line: Vec<u8>,
    given: usize,
}

impl<R: Read> Joined<R> {
    fn new(file: R) -> Self {
        Self { file: BufReader::new(file), line: Vec::new(), given: 0 }
    }
}

impl<R: Read> Read for Joined<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.given == self.line.len() {
            self.line.clear();
            self.given = 0;
            self.file.read_until(b'\n', &mut self.line)?;
            while let Some(whole) = self.line.trim_ascii_end().strip_suffix(b"\\").map(<[u8]>::len) {
                self.line.truncate(whole);
                self.line.push(b' ');
                if self.file.read_until(b'\n', &mut self.line)? == 0 {
                    break;
                }
            }
        }
        let bytes = (&self.line[self.given..]).read(buffer)?;
        self.given += bytes;
        Ok(bytes)
    }
}
