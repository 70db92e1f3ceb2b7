//! What is written is read, and what is damaged is refused.

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
fn what_is_written_is_read_back_and_the_parser_alone_agrees() {
    let mesh = tetrahedron();
    let bytes = written(&mesh);
    assert_eq!(read(&bytes).unwrap(), mesh);
    let other = stl_io::read_stl(&mut Cursor::new(&bytes)).unwrap();
    other.validate().unwrap();
    assert_eq!(other.vertices.iter().map(|v| v.0).collect::<Vec<_>>(), mesh.vertices);
    assert_eq!(other.faces.iter().map(|f| f.vertices.map(|v| v as u32)).collect::<Vec<_>>(), mesh.triangles);
}

#[test]
fn a_file_holds_the_unit_the_count_and_normals_with_corners() {
    let mesh = tetrahedron();
    let bytes = written(&mesh);
    assert_eq!(bytes.len() as u64, stl_bytes(4));
    assert!(bytes.starts_with(b"facetmill 0.") && bytes[..80].windows(7).any(|w| w == b"unit mm"));
    assert_eq!(bytes[80..84], [4, 0, 0, 0]);
    let normals = [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0]];
    for (k, record) in bytes[84..].chunks(50).enumerate() {
        let numbers: Vec<f32> = record[..48].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        assert!(normals.get(k).is_none_or(|normal| *normal == numbers[..3]));
        assert_eq!(numbers[3..], mesh.triangles[k].map(|v| mesh.vertices[v as usize]).concat());
        assert_eq!(record[48..], [0, 0]);
    }
    let empty = written(&Mesh::default());
    assert_eq!((&empty[..80], &empty[80..]), (&bytes[..80], &[0; 4][..]));
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
    assert!(matches!(read(TEXT.replace(" endloop\n endfacet\n\n endsolid", " endsolid\n")), Err(StlError::Line(7))));
    // A word alone may be rubbish behind the first solid; a facet is not.
    assert!(matches!(read(TEXT.replace("solid two\n", "two\n")), Err(StlError::Line(12))));
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
                assert!(mesh.open_edges() <= 3 * mesh.triangles.len());
            }
        }
    }
}

#[test]
fn a_mesh_that_cannot_be_written_is_an_error() {
    let mesh = Mesh { vertices: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 3]] };
    assert_eq!(write_stl(&mesh, &mut Vec::new()).unwrap_err().kind(), io::ErrorKind::InvalidInput);
}

/// A file such as those of /proc: it has content and says that it is empty.
struct Special(Cursor<Vec<u8>>);

impl Read for Special {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer)
    }
}

impl Seek for Special {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        if let SeekFrom::End(_) = to { Ok(0) } else { self.0.seek(to) }
    }
}

#[test]
fn a_special_file_that_says_it_is_empty_is_refused_by_what_it_says() {
    let mut file = Special(Cursor::new(written(&tetrahedron())));
    assert!(matches!(read_stl(&mut file), Err(StlError::Length { promised: 4, room: 0 })));
}
