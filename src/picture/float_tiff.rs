//! Grey float TIFF, the plain kind that scientific programs write; the image decoders know only coloured ones.
//!
//! TIFF 6.0, section 2 (directories of 12-byte entries) and "SampleFormat" in section 19.

use super::PictureError;
use super::decode::{Pixels, Samples, check_size};

const SHORT: u16 = 3;
const LONG: u16 = 4;

/// `None`: not a grey float TIFF, or too damaged to tell; the ordinary decoder shall judge it.
pub fn decode(bytes: &[u8], name: &str) -> Option<Result<Pixels, PictureError>> {
    let file = File { bytes, big_endian: bytes.starts_with(b"MM\0*") };
    if !file.big_endian && !bytes.starts_with(b"II*\0") {
        return None;
    }
    let tags = Tags { file: &file, at: file.number(4, 4)? };
    let (depth, format) = (tags.first(258)?, tags.first(339)?);
    if format != 3 || tags.first(277).unwrap_or(1) != 1 || !(depth == 32 || depth == 64) {
        return None;
    }
    let unsupported = |reason: &str| {
        Some(Err(PictureError::Unsupported { name: name.into(), format: "float TIFF", reason: reason.into() }))
    };
    if tags.first(259).unwrap_or(1) != 1 {
        return unsupported("it is compressed");
    }
    if tags.first(262) == Some(0) {
        return unsupported("its zero is white");
    }
    if tags.first(322).is_some() {
        return unsupported("it is cut into tiles");
    }
    let (width, height) = (tags.first(256)?, tags.first(257)?);
    if let Err(error) = check_size(width as u64, height as u64, name) {
        return Some(Err(error));
    }
    let corrupt = || {
        let reason = "a strip of it is missing".into();
        PictureError::Corrupt { name: name.into(), format: "float TIFF", reason }
    };
    let size = depth / 8;
    let row = width * size;
    let rows = tags.first(278).unwrap_or(height).clamp(1, height);
    let strips = (0..height.div_ceil(rows)).map(|k| {
        let long = row * rows.min(height - k * rows);
        let start = tags.value(273, k)?;
        bytes.get(start..start.checked_add(long)?)
    });
    let Some(strips) = strips.collect::<Option<Vec<_>>>() else {
        return Some(Err(corrupt()));
    };
    let numbers = strips.into_iter().flat_map(|strip| strip.chunks_exact(size));
    let samples = numbers.map(|chunk| file.float(chunk)).collect();
    Some(Ok(Pixels { width, height, channels: 1, samples: Samples::F64(samples), notes: Vec::new() }))
}

struct File<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl File<'_> {
    /// The unsigned number of `size` (at most 4) bytes at `at`.
    fn number(&self, at: usize, size: usize) -> Option<usize> {
        let chunk = self.bytes.get(at..at.checked_add(size)?)?;
        Some(self.bits(chunk) as usize)
    }

    fn bits(&self, chunk: &[u8]) -> u64 {
        let join = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        if self.big_endian { chunk.iter().fold(0, join) } else { chunk.iter().rev().fold(0, join) }
    }

    fn float(&self, chunk: &[u8]) -> f64 {
        let bits = self.bits(chunk);
        if chunk.len() == 8 { f64::from_bits(bits) } else { f64::from(f32::from_bits(bits as u32)) }
    }
}

/// The first directory, that of the first picture.
struct Tags<'a> {
    file: &'a File<'a>,
    at: usize,
}

impl Tags<'_> {
    fn first(&self, tag: usize) -> Option<usize> {
        self.value(tag, 0)
    }

    /// Value `k` of an entry of whole numbers. An entry holds tag, type, count, and the values or where they are.
    fn value(&self, tag: usize, k: usize) -> Option<usize> {
        let file = self.file;
        let entries = file.number(self.at, 2)?;
        let entry = (0..entries).map(|i| self.at + 2 + 12 * i).find(|at| file.number(*at, 2) == Some(tag))?;
        let size = match file.number(entry + 2, 2)? as u16 {
            SHORT => 2,
            LONG => 4,
            _ => return None,
        };
        let count = file.number(entry + 4, 4)?;
        let values = if count.checked_mul(size)? <= 4 { entry + 8 } else { file.number(entry + 8, 4)? };
        (k < count).then(|| file.number(values + k * size, size))?
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grey float TIFF of 3 × 4 pixels in strips of 3 rows, pixel i having the value i - 2.
    pub fn sample(depth: usize, big_endian: bool) -> Vec<u8> {
        let number = |value: u64, size: usize| {
            let bytes = value.to_be_bytes()[8 - size..].to_vec();
            if big_endian { bytes } else { bytes.into_iter().rev().collect() }
        };
        let size = depth / 8;
        let mut out = if big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
        let directory = 8 + 12 * size;
        out.extend(number(directory as u64, 4));
        for i in 0..12 {
            let value = f64::from(i) - 2.0;
            out.extend(if depth == 64 {
                number(value.to_bits(), 8)
            } else {
                number((value as f32).to_bits().into(), 4)
            });
        }
        let offsets = directory + 2 + 12 * 7 + 4;
        let entries = [
            (256, SHORT, 1, 3),
            (257, LONG, 1, 4),
            (258, SHORT, 1, depth),
            (273, LONG, 2, offsets),
            (277, SHORT, 1, 1),
            (278, SHORT, 1, 3),
            (339, SHORT, 1, 3),
        ];
        out.extend(number(entries.len() as u64, 2));
        for (tag, kind, count, value) in entries {
            out.extend(number(tag, 2));
            out.extend(number(kind.into(), 2));
            out.extend(number(count, 4));
            let inline = number(value as u64, if kind == SHORT { 2 } else { 4 });
            out.extend(inline.into_iter().chain([0, 0]).take(4));
        }
        out.extend(number(0, 4));
        out.extend(number(8, 4));
        out.extend(number(8 + 9 * size as u64, 4));
        out
    }

    #[test]
    fn grey_floats_of_both_sizes_and_both_byte_orders_are_read() {
        for depth in [32, 64] {
            for big_endian in [false, true] {
                let pixels = decode(&sample(depth, big_endian), "a").unwrap().unwrap();
                assert_eq!((pixels.width, pixels.height, pixels.channels), (3, 4, 1));
                for i in 0..12 {
                    assert_eq!(pixels.samples.at(i), i as f64 - 2.0);
                }
            }
        }
    }

    #[test]
    fn every_truncation_and_every_changed_byte_is_survived() {
        let whole = sample(32, false);
        for length in 0..whole.len() {
            assert!(!matches!(decode(&whole[..length], "a"), Some(Ok(_))), "{length}");
        }
        for at in 0..whole.len() {
            for value in [0, 1, 127, 255] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                if let Some(Ok(pixels)) = decode(&bytes, "a") {
                    assert!(pixels.width >= 2 && pixels.height >= 2);
                }
            }
        }
    }
}
