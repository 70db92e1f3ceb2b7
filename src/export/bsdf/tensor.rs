//! Tensor files: named arrays, as Mitsuba reads them.

use std::collections::HashMap;
use std::io::{self, Write};

use thiserror::Error;

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

/// An array of numbers that was read.
#[derive(Clone, Debug)]
pub(super) struct Floats {
    /// The last index runs fastest.
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
}

/// Reads every array of 32-bit floats; others are passed over.
pub(super) fn read_tensors(bytes: &[u8]) -> Result<HashMap<String, Floats>, TensorError> {
    let mut at = 0;
    let mut take = |count: usize| {
        let end = at + count;
        let found = bytes.get(at..end).ok_or(TensorError::Short)?;
        at = end;
        Ok::<&[u8], TensorError>(found)
    };
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0u64, |sum, byte| sum << 8 | u64::from(*byte));
    if take(12)? != b"tensor_file\0" {
        return Err(TensorError::Other);
    }
    take(2)?;
    let count = number(take(4)?);
    let mut found = HashMap::new();
    for _ in 0..count {
        let length = number(take(2)?) as usize;
        let name = String::from_utf8_lossy(take(length)?).into_owned();
        let rank = number(take(2)?) as usize;
        let kind = take(1)?[0];
        let offset = number(take(8)?) as usize;
        let mut shape = Vec::new();
        for _ in 0..rank {
            shape.push(number(take(8)?) as usize);
        }
        if kind != 10 {
            continue;
        }
        let size = shape.iter().try_fold(4usize, |size, side| size.checked_mul(*side)).ok_or(TensorError::Short)?;
        let end = offset.checked_add(size).ok_or(TensorError::Short)?;
        let data = bytes.get(offset..end).ok_or(TensorError::Short)?;
        let value = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        found.insert(name, Floats { shape, values: data.chunks_exact(4).map(value).collect() });
    }
    Ok(found)
}

/// Why bytes are no tensor file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TensorError {
    /// Another kind of file.
    #[error("this is no .bsdf: it does not begin as one; name one of RGL's or of measure --brdf")]
    Other,
    /// It ends before its data do.
    #[error("the .bsdf is cut short; copy or download it again")]
    Short,
}
