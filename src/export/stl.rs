//! STL files: written as binary, read as binary or text, whoever wrote them.
//!
//! The crate `stl_io` serves only as the tests' independent reader: its writer leaves the header empty, so the units
//! could not be stated, and its readers believe the triangle count, take any file that begins with "solid" for text,
//! stop at the first `endsolid`, refuse a solid without a name and split lines of any length.

use std::hash::{BuildHasher, RandomState};
use std::io::{self, BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write};

use thiserror::Error;

use crate::relief::mesh::Mesh;

const HEADER: &str = concat!("facetmill ", env!("CARGO_PKG_VERSION"), ", binary STL, unit mm, right-handed, z up");
const PREAMBLE: usize = 84;
const RECORD: usize = 50;
/// Longest line of a text STL, bytes.
const LINE: u64 = 4096;

/// Size in bytes of a binary STL file of that many triangles.
pub fn stl_bytes(triangles: usize) -> u64 {
    PREAMBLE as u64 + RECORD as u64 * triangles as u64
}

/// Writes a binary STL file in mm; normals are those of the written vertices.
///
/// # Errors
/// When writing fails; `InvalidInput` when a triangle names a vertex that does not exist or there are more than 2³²
/// triangles.
pub fn write_stl(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    let invalid = |why| io::Error::new(io::ErrorKind::InvalidInput, why);
    let count = u32::try_from(mesh.triangles.len()).map_err(|_| invalid("more triangles than STL can count"))?;
    if mesh.triangles.as_flattened().iter().any(|&v| v as usize >= mesh.vertices.len()) {
        return Err(invalid("a triangle names a vertex that does not exist"));
    }
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let mut preamble = [0; PREAMBLE];
    preamble[..HEADER.len()].copy_from_slice(HEADER.as_bytes());
    preamble[80..].copy_from_slice(&count.to_le_bytes());
    out.write_all(&preamble)?;
    for (k, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(k);
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array();
        let corners = triangle.map(|v| mesh.vertices[v as usize]);
        let mut record = [0; RECORD];
        for (bytes, value) in record.chunks_exact_mut(4).zip([normal].iter().chain(&corners).flatten()) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
        out.write_all(&record)?;
    }
    out.flush()
}

/// Reads a binary or text STL file; vertices at exactly the same position become one, in the order of the file.
///
/// Memory is bounded by a small multiple of the file's true length, whatever the file claims.
///
/// # Errors
/// When reading fails, or the file is no STL, is truncated, has no triangles or has coordinates that are not finite.
pub fn read_stl(file: &mut (impl Read + Seek)) -> Result<Mesh, StlError> {
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(0))?;
    let mut preamble = Vec::with_capacity(PREAMBLE);
    file.by_ref().take(PREAMBLE as u64).read_to_end(&mut preamble)?;
    let count = preamble.last_chunk().filter(|_| preamble.len() == PREAMBLE).map(|&bytes| u32::from_le_bytes(bytes));
    // The length decides: many binary files begin with "solid" too.
    let mesh = match count {
        Some(count) if length == stl_bytes(count as usize) => read_binary(file, count as usize)?,
        _ if is_text(&preamble) => {
            file.seek(SeekFrom::Start(0))?;
            read_text(&mut BufReader::new(file))?
        }
        Some(promised) => return Err(StlError::Length { promised, room: (length - PREAMBLE as u64) / RECORD as u64 }),
        None => return Err(StlError::NotStl),
    };
    if mesh.triangles.is_empty() { Err(StlError::Empty) } else { Ok(mesh) }
}

/// Whether a file that begins so may be a text STL.
fn is_text(start: &[u8]) -> bool {
    let word = start.trim_ascii_start();
    let printable = |&byte: &u8| byte >= b' ' || byte.is_ascii_whitespace();
    word.len() >= 5 && word[..5].eq_ignore_ascii_case(b"solid") && start.iter().all(printable)
}

/// `count` records, for which the file has been found long enough.
fn read_binary(file: &mut impl Read, count: usize) -> Result<Mesh, StlError> {
    let mut collector = Collector::default();
    collector.triangles.reserve_exact(count);
    let mut buffer = vec![0; RECORD * count.min(1 << 12)];
    let mut left = count;
    while left > 0 {
        let batch = &mut buffer[..RECORD * left.min(1 << 12)];
        file.read_exact(batch)?;
        for record in batch.chunks_exact(RECORD) {
            // The first three numbers are the normal, which the vertices know better.
            let mut numbers = record[12..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            let mut corners = [[0.0; 3]; 3];
            corners.as_flattened_mut().fill_with(|| numbers.next().unwrap_or(f32::NAN));
            collector.add(corners)?;
        }
        left -= batch.len() / RECORD;
    }
    Ok(Mesh { vertices: collector.vertices, triangles: collector.triangles })
}

/// Text, one statement a line; several solids become one mesh.
fn read_text(file: &mut impl BufRead) -> Result<Mesh, StlError> {
    let mut collector = Collector::default();
    let (mut line, mut number) = (Vec::new(), 0);
    let mut facet: Option<Vec<[f32; 3]>> = None;
    let mut finished = false;
    loop {
        line.clear();
        number += 1;
        if file.by_ref().take(LINE).read_until(b'\n', &mut line)? == 0 {
            break;
        }
        let wrong = StlError::Line(number);
        if line.len() as u64 == LINE && !line.ends_with(b"\n") {
            return Err(wrong);
        }
        let text = String::from_utf8_lossy(&line);
        let mut words = text.split_whitespace();
        let Some(statement) = words.next().map(str::to_ascii_lowercase) else { continue };
        match (statement.as_str(), &mut facet) {
            ("solid" | "endsolid", None) => finished = statement == "endsolid",
            ("facet", None) if !finished => facet = Some(Vec::new()),
            ("outer" | "endloop", Some(_)) => {}
            ("vertex", Some(corners)) if corners.len() < 3 => {
                let numbers: Option<Vec<f32>> = words.map(|word| word.parse().ok()).collect();
                corners.push(numbers.and_then(|numbers| numbers.try_into().ok()).ok_or(wrong)?);
            }
            ("endfacet", Some(corners)) => {
                let &[a, b, c] = corners.as_slice() else { return Err(wrong) };
                collector.add([a, b, c])?;
                facet = None;
            }
            _ => return Err(wrong),
        }
    }
    if !finished {
        return Err(StlError::Unfinished);
    }
    Ok(Mesh { vertices: collector.vertices, triangles: collector.triangles })
}

/// Triangles whose vertices are merged by position.
struct Collector {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Open addressing: ids of vertices, or [`FREE`]. Less memory than a map that keeps the positions once more.
    table: Vec<u32>,
    seed: u64,
}

const FREE: u32 = u32::MAX;

impl Default for Collector {
    fn default() -> Self {
        // A seed no file can know keeps a hostile one from filling a single chain; the mesh does not depend on it.
        let seed = RandomState::new().hash_one(0);
        Self { vertices: Vec::new(), triangles: Vec::new(), table: vec![FREE; 64], seed }
    }
}

impl Collector {
    fn add(&mut self, corners: [[f32; 3]; 3]) -> Result<(), StlError> {
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

/// Number of directed edges without a partner that runs the opposite way; 0 for a closed mesh.
///
/// An edge of four triangles, two each way, counts as closed; a triangle turned over leaves all its edges open.
pub fn open_edges(mesh: &Mesh) -> usize {
    let (rising, falling) = (edges(mesh, true), edges(mesh, false));
    (0..mesh.vertices.len()).map(|v| unpaired(rising.of(v), falling.of(v))).sum()
}

/// The edges of a mesh that run one way, by their lower vertex.
struct Edges {
    starts: Vec<usize>,
    others: Vec<u32>,
}

impl Edges {
    /// The upper vertices, ascending, of the edges whose lower one is `v`.
    fn of(&self, v: usize) -> &[u32] {
        &self.others[self.starts[v]..self.starts[v + 1]]
    }
}

/// The edges from lower to higher vertex (`rising`) or the others; linear but for the sorting of each short list.
fn edges(mesh: &Mesh, rising: bool) -> Edges {
    let one_way = || {
        let all = mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        all.filter_map(move |(a, b)| (a != b && (a < b) == rising).then_some((a.min(b) as usize, a.max(b))))
    };
    // Each list's end is found by filling it, and is the next one's start.
    let mut starts = vec![0; mesh.vertices.len() + 2];
    one_way().for_each(|(v, _)| starts[v + 2] += 1);
    for v in 1..starts.len() {
        starts[v] += starts[v - 1];
    }
    let mut others = vec![0; starts[starts.len() - 1]];
    for (v, other) in one_way() {
        others[starts[v + 1]] = other;
        starts[v + 1] += 1;
    }
    for v in 0..mesh.vertices.len() {
        others[starts[v]..starts[v + 1]].sort_unstable();
    }
    Edges { starts, others }
}

/// How many entries of two ascending lists have no equal in the other.
fn unpaired(mut a: &[u32], mut b: &[u32]) -> usize {
    let mut count = 0;
    while let ([x, rest_a @ ..], [y, rest_b @ ..]) = (a, b) {
        count += usize::from(x != y);
        (a, b) = (if x <= y { rest_a } else { a }, if y <= x { rest_b } else { b });
    }
    count + a.len() + b.len()
}

/// Why a file is not read as STL.
#[derive(Debug, Error)]
pub enum StlError {
    /// The file could not be read.
    #[error("the STL file cannot be read: {0}")]
    Io(#[from] io::Error),
    /// Neither kind of STL file.
    #[error("the file is neither a binary nor a text STL; name the plate's STL file")]
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
    /// A line of a text file that does not belong there.
    #[error("line {0} of the text STL is not what the format asks for there")]
    Line(u64),
    /// A text file that ends within a solid.
    #[error("the text STL ends before its endsolid; it is truncated")]
    Unfinished,
    /// A coordinate that is infinite or not a number; triangles count from 1.
    #[error("triangle {0} of the STL file has a coordinate that is not a finite number")]
    NotFinite(usize),
    /// Not a single triangle.
    #[error("the STL file has no triangles")]
    Empty,
    /// More vertices than 32 bits can number.
    #[error("the STL file has more than 4 billion vertices")]
    TooMany,
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    fn tetrahedron() -> Mesh {
        Mesh {
            vertices: vec![[0.0, 0.0, 0.0], [0.0, 2.5, 0.0], [1.5, 0.0, 0.0], [0.0, 0.0, 3.25]],
            triangles: vec![[0, 1, 2], [0, 2, 3], [2, 1, 3], [1, 0, 3]],
        }
    }

    fn written(mesh: &Mesh) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_stl(mesh, &mut bytes).unwrap();
        bytes
    }

    fn read(bytes: impl AsRef<[u8]>) -> Result<Mesh, StlError> {
        read_stl(&mut Cursor::new(bytes))
    }

    const TEXT: &str = "solid\n FACET normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1e0 -0 0\r\n vertex 0 1 -0.0
        endloop\n endfacet\n\n endsolid\n solid two\n facet normal 0 0 -1\n outer loop\n vertex 0 0 0\n vertex 0 1 0
        vertex 1 0 0\n endloop\n endfacet\n endsolid two";

    #[test]
    fn what_is_written_is_read_back_and_an_independent_reader_agrees() {
        let mesh = tetrahedron();
        let bytes = written(&mesh);
        assert_eq!(bytes.len() as u64, stl_bytes(4));
        assert!(bytes.starts_with(b"facetmill 0.") && bytes[..80].windows(7).any(|w| w == b"unit mm"));
        assert_eq!(read(&bytes).unwrap(), mesh);
        let other = stl_io::read_stl(&mut Cursor::new(&bytes)).unwrap();
        assert_eq!(other.vertices.iter().map(|v| v.0).collect::<Vec<_>>(), mesh.vertices);
        assert_eq!(other.faces.iter().map(|f| f.vertices.map(|v| v as u32)).collect::<Vec<_>>(), mesh.triangles);
        assert_eq!([0, 1].map(|k| other.faces[k].normal.0), [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0]]);
    }

    #[test]
    fn text_of_several_unnamed_solids_is_read_and_minus_zero_is_zero() {
        let mesh = read(TEXT).unwrap();
        assert_eq!((mesh.vertices.len(), mesh.triangles), (3, vec![[0, 1, 2], [0, 2, 1]]));
    }

    #[test]
    fn a_binary_that_begins_with_solid_is_read_by_its_length() {
        let mut bytes = written(&tetrahedron());
        bytes[..80].copy_from_slice(format!("{:80}", "solid by another program").as_bytes());
        assert_eq!(read(&bytes).unwrap(), tetrahedron());
        bytes.truncate(140);
        assert!(matches!(read(&bytes), Err(StlError::Length { promised: 4, room: 1 })));
    }

    #[test]
    fn damaged_files_are_refused_in_one_sentence() {
        let whole = written(&tetrahedron());
        let with = |at: usize, value: [u8; 4]| [&whole[..at], &value, &whole[at + 4..]].concat();
        assert!(matches!(read(with(80, [255; 4])), Err(StlError::Length { promised: u32::MAX, room: 4 })));
        assert!(matches!(read(with(80, [0; 4])), Err(StlError::Length { promised: 0, room: 4 })));
        assert!(matches!(read(&with(80, [0; 4])[..84]), Err(StlError::Empty)));
        assert!(matches!(read(with(84 + 50 + 12, f32::NAN.to_le_bytes())), Err(StlError::NotFinite(2))));
        assert!(matches!(read(with(84 + 44, f32::INFINITY.to_le_bytes())), Err(StlError::NotFinite(1))));
        assert!(matches!(read(&whole[..83]), Err(StlError::NotStl)));
        assert!(matches!(read(b""), Err(StlError::NotStl)));
        assert!(matches!(read("solid\nendsolid"), Err(StlError::Empty)));
        assert!(matches!(read(TEXT.replace("1e0", "1e99")), Err(StlError::NotFinite(1))));
        assert!(matches!(read(TEXT.replace("1e0", "1,0")), Err(StlError::Line(5))));
        assert!(matches!(read(TEXT.replace("1e0", "")), Err(StlError::Line(5))));
        assert!(matches!(read(TEXT.replace("two", &"two".repeat(2000))), Err(StlError::Line(11))));
        for cut in 8..TEXT.len() - 12 {
            assert!(read(&TEXT[..cut]).is_err() || TEXT[..cut].trim_end().ends_with("endsolid"), "{cut}");
        }
    }

    #[test]
    fn random_damage_never_panics() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
        for file in [written(&tetrahedron()), TEXT.as_bytes().to_vec()] {
            for _ in 0..20_000 {
                let mut bytes = file.clone();
                for _ in 0..1 + random.next_u32() % 3 {
                    let at = random.next_u32() as usize % bytes.len();
                    bytes[at] = random.next_u32() as u8;
                }
                bytes.truncate(1 + random.next_u32() as usize % (2 * file.len()));
                if let Ok(mesh) = read(&bytes) {
                    assert!(open_edges(&mesh) <= 3 * mesh.triangles.len());
                }
            }
        }
    }

    #[test]
    fn open_edges_are_those_of_holes_and_turned_triangles() {
        let whole = tetrahedron();
        assert_eq!(open_edges(&whole), 0);
        let holed = Mesh { triangles: whole.triangles[1..].to_vec(), ..whole.clone() };
        assert_eq!(open_edges(&holed), 3);
        let mut turned = whole.clone();
        turned.triangles[2].swap(0, 1);
        assert_eq!(open_edges(&turned), 6);
        let mut doubled = whole.clone();
        doubled.triangles.extend(whole.triangles.iter());
        assert_eq!(open_edges(&doubled), 0);
        assert_eq!(open_edges(&Mesh::default()), 0);
    }

    #[test]
    fn a_mesh_that_cannot_be_written_is_an_error() {
        let mesh = Mesh { vertices: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 3]] };
        assert_eq!(write_stl(&mesh, &mut Vec::new()).unwrap_err().kind(), io::ErrorKind::InvalidInput);
    }
}
