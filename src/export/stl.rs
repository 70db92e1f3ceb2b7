//! STL files: written as binary, read as binary or text, whoever wrote them.
//!
//! The crate `stl_io` encodes and parses them. What it lacks is done here, around it: it writes an empty header, where
//! the units belong; it believes the count of triangles, takes any file that begins with "solid" for text, and of text
//! it wants lower case, takes lines of any length, a named solid and only one. A binary file takes 8 % more time than
//! by a loop of our own, a text file, which it splits into strings, 75 % more.

mod feed;

pub(super) mod merge;

#[cfg(test)]
mod tests;

use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};

use stl_io::{Triangle, Vector, create_stl_reader};
use thiserror::Error;

use self::feed::{Lines, Records};
use self::merge::MergedTriangles;
use crate::fence::fenced;
use crate::relief::mesh::Mesh;

const HEADER: &str = concat!("facetmill ", env!("CARGO_PKG_VERSION"), ", binary STL, unit mm, right-handed, z up");
/// Bytes of a binary file that anybody may fill.
const HEADER_BYTES: usize = 80;
/// Bytes before the first triangle of a binary file: the header and the count of triangles.
const PREAMBLE: usize = HEADER_BYTES + 4;
/// Bytes of a triangle in a binary file.
const RECORD: usize = 50;

/// What is looked at to tell what a file is: comments may stand before a text's first word.
const ENOUGH: usize = 4096;
/// A file that has lost more than this many of its triangles for each that is left is none that was cut.
const MOST_LOST: u64 = 1000;

/// Size in bytes of a binary STL file of that many triangles.
pub(crate) fn stl_bytes(triangles: usize) -> u64 {
    PREAMBLE as u64 + RECORD as u64 * triangles as u64
}

/// Writes a binary STL file in mm; normals are those of the written vertices.
///
/// # Errors
/// When writing fails; `InvalidInput` when a triangle names a vertex that does not exist or there are more than 2³²
/// triangles.
pub fn write_stl(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    if u32::try_from(mesh.triangles.len()).is_err() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "more triangles than STL can count"));
    }
    whole(mesh)?;
    let triangles = (0..mesh.triangles.len()).map(|k| {
        let [a, b, c] = mesh.corners(k);
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array();
        Triangle { normal: Vector(normal), vertices: mesh.triangles[k].map(|v| Vector(mesh.vertices[v as usize])) }
    });
    let mut header = [0; HEADER_BYTES];
    header[..HEADER.len()].copy_from_slice(HEADER.as_bytes());
    // The encoder's own pieces of 8 KiB are collected: fewer calls.
    let mut out = BufWriter::with_capacity(1 << 16, out);
    out.write_all(&header)?;
    stl_io::write_stl(&mut AfterHeader { out: &mut out, left: HEADER_BYTES }, triangles)
}

/// Refuses a mesh of which a triangle names a vertex that it does not have.
pub(super) fn whole(mesh: &Mesh) -> io::Result<()> {
    let is_whole = mesh.triangles.as_flattened().iter().all(|&v| (v as usize) < mesh.vertices.len());
    let stray = || io::Error::new(io::ErrorKind::InvalidInput, "a triangle names a vertex that does not exist");
    if is_whole { Ok(()) } else { Err(stray()) }
}

/// Passes on what is written but for the first bytes, an empty header.
struct AfterHeader<'a, W> {
    out: &'a mut W,
    /// Bytes of the header that are still to come.
    left: usize,
}

impl<W: Write> Write for AfterHeader<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.left == 0 {
            return self.out.write(bytes);
        }
        let dropped = self.left.min(bytes.len());
        self.left -= dropped;
        Ok(dropped)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Whether a file of `length` bytes that begins with `head` is a binary STL by its length.
pub(super) fn is_binary_stl(head: &[u8], length: u64) -> bool {
    promised(head).is_some_and(|count| count > 0 && length == stl_bytes(count as usize))
}

/// The count of triangles of a binary file that begins so.
fn promised(head: &[u8]) -> Option<u32> {
    head.get(HEADER_BYTES..PREAMBLE)?.first_chunk().map(|&bytes| u32::from_le_bytes(bytes))
}

/// Reads a binary or text STL file; vertices at exactly the same position become one, in the order of the file.
///
/// Memory is bounded by a small multiple of the file's true length, whatever the file claims.
///
/// # Errors
/// When reading fails, or the file is no STL, is truncated, has no triangles or has coordinates that are not finite.
pub fn read_stl(file: &mut (impl Read + Seek)) -> Result<Mesh, StlError> {
    read_stl_noted(file).map(|(mesh, _)| mesh)
}

/// As [`read_stl`], with notes on what was passed over: bytes behind the last triangle, comments, a mark of the text's
/// encoding.
///
/// # Errors
/// As those of [`read_stl`].
pub fn read_stl_noted(file: &mut (impl Read + Seek)) -> Result<(Mesh, Vec<String>), StlError> {
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(0))?;
    let mut head = Vec::with_capacity(ENOUGH);
    file.by_ref().take(ENOUGH as u64).read_to_end(&mut head)?;
    let mut triangles = MergedTriangles::default();
    let mut notes = Vec::new();
    // The length decides: many binary files begin with "solid" too.
    match promised(&head) {
        Some(count) if length == stl_bytes(count as usize) => binary(file, count, &mut triangles)?,
        _ if feed::is_text(&head) => {
            let mut lines = Lines::new(BufReader::new(file));
            let read = lines.rewind().map_err(StlError::from).and_then(|()| gather(&mut lines, &mut triangles));
            read.map_err(|error| lines.located(error, triangles.len()))?;
            notes = lines.notes();
        }
        Some(count) if count > 0 && length > stl_bytes(count as usize) && 2 * stl_bytes(count as usize) >= length => {
            if carries_more(file, count, length)? {
                return Err(StlError::Attributes);
            }
            binary(file, count, &mut triangles)?;
            if is_followed_by_a_triangle(file, &triangles)? {
                return Err(StlError::Length { promised: count, room: room(length) });
            }
            let behind = length - stl_bytes(count as usize);
            notes.push(format!("{behind} bytes behind the file's last triangle were left out."));
        }
        // Of a file that is cut some triangles are left, and one whose count is damaged has whole ones: a count beyond
        // that is none, and the file no STL.
        Some(count) if u64::from(count) <= MOST_LOST * room(length) || is_whole(length) => {
            return Err(StlError::Length { promised: count, room: room(length) });
        }
        _ => return Err(StlError::NotStl),
    }
    if triangles.len() == 0 { Err(StlError::Empty) } else { Ok((triangles.into_mesh(), notes)) }
}

/// Whole triangles that a binary file of that length has room for.
fn room(length: u64) -> u64 {
    length.saturating_sub(PREAMBLE as u64) / RECORD as u64
}

/// Whether a file of that length has nothing but whole triangles behind its header.
fn is_whole(length: u64) -> bool {
    length.saturating_sub(PREAMBLE as u64).is_multiple_of(RECORD as u64)
}

/// Reads `count` triangles behind the header of a binary file.
fn binary(file: &mut (impl Read + Seek), count: u32, triangles: &mut MergedTriangles) -> Result<(), StlError> {
    triangles.reserve(count as usize);
    file.seek(SeekFrom::Start(PREAMBLE as u64))?;
    gather(&mut Records::new(file, count), triangles)
}

/// Whether each triangle says how many bytes of something else follow it, and they add up to the file.
fn carries_more(file: &mut (impl Read + Seek), count: u32, length: u64) -> io::Result<bool> {
    let mut at = PREAMBLE as u64;
    for _ in 0..count {
        let mut more = [0; 2];
        if at + RECORD as u64 > length {
            return Ok(false);
        }
        file.seek(SeekFrom::Start(at + RECORD as u64 - 2))?;
        file.read_exact(&mut more)?;
        at += RECORD as u64 + u64::from(u16::from_le_bytes(more));
    }
    Ok(at == length)
}

/// Whether what comes next in a binary file is one more triangle near the others: then its count is wrong.
fn is_followed_by_a_triangle(file: &mut (impl Read + Seek), triangles: &MergedTriangles) -> io::Result<bool> {
    file.seek(SeekFrom::Start(stl_bytes(triangles.len())))?;
    let mut record = Vec::new();
    file.by_ref().take(RECORD as u64).read_to_end(&mut record)?;
    let numbers: Vec<f32> = record.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let Some(corners) = numbers.get(3..12).filter(|_| record.len() == RECORD) else { return Ok(false) };
    let (low, high) = triangles.bounds();
    let near = |(k, c): (usize, &f32)| {
        let size = high[k % 3] - low[k % 3];
        (low[k % 3] - size..=high[k % 3] + size).contains(c)
    };
    // Zeros pad files; a triangle has three corners.
    let apart = corners[..3] != corners[3..6] && corners[3..6] != corners[6..9];
    Ok(apart && corners.iter().enumerate().all(near))
}

/// Adds every triangle of `file` to `triangles`.
fn gather(file: &mut (impl Read + Seek), triangles: &mut MergedTriangles) -> Result<(), StlError> {
    let all = || {
        for triangle in create_stl_reader(file)? {
            // The normal is passed over: the vertices know it better.
            triangles.add(triangle?.vertices.map(|vertex| vertex.0))?;
        }
        Ok(())
    };
    fenced(all).unwrap_or(Err(StlError::Parser))
}

/// Why a file is not read as STL.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StlError {
    /// The file could not be read.
    #[error("the STL file cannot be read: {0}")]
    Io(#[from] io::Error),
    /// Neither kind of STL file.
    #[error("the file is neither a binary nor a text STL nor another mesh that is known; name the plate's mesh")]
    NotStl,
    /// A binary file whose length does not fit its count of triangles.
    #[error(
        "the STL file's length does not fit the {promised} triangles it promises (it has room for {room}): \
         it is truncated, damaged or no STL at all"
    )]
    Length {
        /// Triangles by the file's own count.
        promised: u32,
        /// Whole triangles that fit its length.
        room: u64,
    },
    /// Bytes of something else behind each triangle.
    #[error(
        "the STL file carries other data behind each triangle, which is not read; export it without colours and marks"
    )]
    Attributes,
    /// A line of a text file that does not belong there.
    #[error("line {0} of the text STL is not what the format asks for there")]
    Line(u64),
    /// The parser panicked.
    #[error("the STL file is damaged so that its parser fails on it; export it again")]
    Parser,
    /// A text file that ends within a solid.
    #[error("the text STL ends before its endsolid; it is truncated")]
    Unfinished,
    /// A coordinate that is infinite or not a number; triangles count from 1.
    #[error("triangle {0} of the file has a coordinate that is not a finite number")]
    NotFinite(usize),
    /// Not a single triangle.
    #[error("the STL file has no triangles")]
    Empty,
    /// More vertices than 32 bits can number.
    #[error("the file has more than 4 billion vertices")]
    TooMany,
}
