//! PLY (Polygon File Format), text or binary of either byte order, parsed by the crate `ply-rs-bw`.

use std::io::{BufReader, Read};

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, Property, PropertyAccess, PropertyAccessResult};

use super::{MergedTriangles, MeshFileError, add_polygon};

/// A place.
struct Vertex([f32; 3]);

/// Indices of vertices.
struct Face(Vec<usize>);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([f32::NAN; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.0[axis] = match property {
            Property::Char(v) => f32::from(v),
            Property::UChar(v) => f32::from(v),
            Property::Short(v) => f32::from(v),
            Property::UShort(v) => f32::from(v),
            Property::Int(v) => v as f32,
            Property::UInt(v) => v as f32,
            Property::Float(v) => v,
            Property::Double(v) => v as f32,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_index" | "vertex_indices") {
            return PropertyAccessResult::Ignored;
        }
        // A negative index is no vertex's.
        let index = |v: i64| usize::try_from(v).unwrap_or(usize::MAX);
        self.0 = match property {
            Property::ListChar(list) => list.into_iter().map(|v| index(v.into())).collect(),
            Property::ListUChar(list) => list.into_iter().map(|v| index(v.into())).collect(),
            Property::ListShort(list) => list.into_iter().map(|v| index(v.into())).collect(),
            Property::ListUShort(list) => list.into_iter().map(|v| index(v.into())).collect(),
            Property::ListInt(list) => list.into_iter().map(|v| index(v.into())).collect(),
            Property::ListUInt(list) => list.into_iter().map(|v| index(v.into())).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// Reads a whole file of `length` bytes.
pub(crate) fn read(file: &mut impl Read, length: u64) -> Result<MergedTriangles, MeshFileError> {
    let damaged = |reason: String| MeshFileError::Damaged { format: "PLY", reason };
    let words = |error: ply_rs_bw::parser::ParseError| {
        // The crate's words have several lines and quote the file.
        let text = error.to_string();
        damaged(text.lines().next().unwrap_or_default().chars().filter(|c| !c.is_control()).take(120).collect())
    };
    let mut file = Reader::new(BufReader::new(file));
    let header = Parser::<Vertex>::new().read_header(&mut file).map_err(words)?;
    let mut vertices: Vec<[f32; 3]> = Vec::new();
    let mut triangles = MergedTriangles::default();
    for (name, element) in &header.elements {
        // Each takes a byte at least, so that memory is bounded by the file.
        if element.count as u64 > length || (element.properties.is_empty() && element.count > 0) {
            return Err(damaged(format!("it promises {} of {name}, more than it has room for", element.count)));
        }
        match name.as_str() {
            "vertex" => {
                let read = Parser::<Vertex>::new().read_payload_for_element(&mut file, element, &header);
                vertices = read.map_err(words)?.into_iter().map(|vertex| vertex.0).collect();
            }
            "face" => {
                let read = Parser::<Face>::new().read_payload_for_element(&mut file, element, &header);
                for face in read.map_err(words)? {
                    add_polygon(&mut triangles, &vertices, &face.0, "PLY")?;
                }
            }
            "tristrips" => return Err(damaged("its faces are strips, which are not read".into())),
            _ => {
                Parser::<DefaultElement>::new().read_payload_for_element(&mut file, element, &header).map_err(words)?;
            }
        }
    }
    Ok(triangles)
}
