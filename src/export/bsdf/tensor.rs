//! Tensor files: named arrays, as Mitsuba reads them.

use std::io::{self, Write};

/// One named array of a tensor file.
pub(super) struct Tensor {
    name: &'static str,
    shape: Vec<u64>,
    /// 1: bytes, 10: 32-bit floats, as Mitsuba numbers its types.
    kind: u8,
    data: Vec<u8>,
}

impl Tensor {
    /// An array of bytes.
    pub(super) fn bytes(name: &'static str, data: &[u8]) -> Self {
        Self { name, shape: vec![data.len() as u64], kind: 1, data: data.to_vec() }
    }

    /// An array of 32-bit floats of that `shape`, the last index running fastest.
    pub(super) fn floats(name: &'static str, shape: &[usize], values: Vec<f32>) -> Self {
        let shape = shape.iter().map(|n| *n as u64).collect();
        Self { name, shape, kind: 10, data: values.iter().flat_map(|v| v.to_le_bytes()).collect() }
    }
}

/// Writes the file of these arrays: the directory, then the data, each on a multiple of 8 bytes.
pub(super) fn write_tensors(fields: &[Tensor], out: &mut impl Write) -> io::Result<()> {
    let header: usize = fields.iter().map(|f| 2 + f.name.len() + 2 + 1 + 8 + 8 * f.shape.len()).sum();
    let aligned = |at: usize| at.next_multiple_of(8);
    let mut at = 12 + 2 + 4 + header;
    out.write_all(b"tensor_file\0\x01\x00")?;
    out.write_all(&(fields.len() as u32).to_le_bytes())?;
    let begin = at;
    for field in fields {
        at = aligned(at);
        out.write_all(&(field.name.len() as u16).to_le_bytes())?;
        out.write_all(field.name.as_bytes())?;
        out.write_all(&(field.shape.len() as u16).to_le_bytes())?;
        out.write_all(&[field.kind])?;
        out.write_all(&(at as u64).to_le_bytes())?;
        for side in &field.shape {
            out.write_all(&side.to_le_bytes())?;
        }
        at += field.data.len();
    }
    let mut at = begin;
    for field in fields {
        out.write_all(&[0; 8][..aligned(at) - at])?;
        out.write_all(&field.data)?;
        at = aligned(at) + field.data.len();
    }
    Ok(())
}
