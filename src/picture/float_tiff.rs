//! TIFF pictures of floats that the general decoder does not know: grey ones, and coloured ones of 16 or 64 bits.
//!
//! Scientific programs write them. The crate `tiff` decodes them, compressed or not, in strips or tiles; what they may
//! hold is checked before memory is set aside.

use std::io::{Cursor, ErrorKind};

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::PictureError;
use super::pixels::{MAX_MEMORY, Pixels, Samples, check_size, one_line};

/// The value of the tag `SampleFormat` that means floats (TIFF 6.0, section 19).
const FLOATS: u16 = 3;

/// The crate's own limit for a list in the directory, bytes: [`super::MAX_SIDE`] strips take a tenth of it.
const MAX_LIST: usize = 1 << 20;

/// `None`: not one of these pictures, or too damaged to tell; the general decoder shall judge it.
pub(crate) fn decode(bytes: &[u8], name: &str) -> Option<Result<Pixels, PictureError>> {
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size) = (MAX_MEMORY as usize, MAX_MEMORY as usize);
    limits.ifd_value_size = MAX_LIST;
    let mut file = Decoder::new(Cursor::new(bytes)).ok()?.with_limits(limits);
    let formats: Vec<u16> = file.find_tag_unsigned_vec(Tag::SampleFormat).ok()??;
    if formats.is_empty() || formats.iter().any(|&format| format != FLOATS) {
        return None;
    }
    let channels = match file.colortype().ok()? {
        ColorType::Gray(16 | 32 | 64) => 1,
        ColorType::RGB(16 | 64) => 3,
        ColorType::RGBA(16 | 64) => 4,
        _ => return None,
    };
    Some(read(&mut file, channels, name))
}

fn read(file: &mut Decoder<Cursor<&[u8]>>, channels: usize, name: &str) -> Result<Pixels, PictureError> {
    let complain = |error| complaint(error, name);
    let (width, height) = file.dimensions().map_err(complain)?;
    check_size(width.into(), height.into(), name)?;
    let layout = file.image_buffer_layout().map_err(complain)?;
    // Numbers of 64 bits come of it, whatever the file holds.
    let count = u64::from(width) * u64::from(height) * channels as u64;
    if 8 * count > MAX_MEMORY || layout.complete_len as u64 > MAX_MEMORY {
        return Err(PictureError::Memory { name: name.into() });
    }
    if layout.planes > 1 {
        let reason = "each of its colours stands in a plane of its own".into();
        return Err(PictureError::Unsupported { name: name.into(), format: "float TIFF", reason });
    }
    let samples = match file.read_image().map_err(complain)? {
        DecodingResult::F16(values) => Samples::F32(values.iter().map(|value| value.to_f32()).collect()),
        DecodingResult::F32(values) => Samples::F32(values),
        DecodingResult::F64(values) => Samples::F64(values),
        _ => return Err(corrupt("its numbers are not the floats that it promises", name)),
    };
    if samples.len() as u64 != count {
        return Err(corrupt("it holds more or fewer numbers than its size asks for", name));
    }
    Ok(Pixels { width: width as usize, height: height as usize, channels, samples, notes: Vec::new() })
}

fn corrupt(reason: &str, name: &str) -> PictureError {
    PictureError::Corrupt { name: name.into(), format: "float TIFF", reason: reason.into() }
}

fn complaint(error: TiffError, name: &str) -> PictureError {
    match error {
        TiffError::LimitsExceeded | TiffError::IntSizeError => PictureError::Memory { name: name.into() },
        TiffError::UnsupportedError(e) => {
            PictureError::Unsupported { name: name.into(), format: "float TIFF", reason: one_line(&e) }
        }
        TiffError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof => corrupt("a strip of it is missing", name),
        e => corrupt(&one_line(&e), name),
    }
}

#[cfg(test)]
mod tests {
    use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, colortype};

    use super::*;

    const SHORT: u16 = 3;
    const LONG: u16 = 4;

    /// The bits of a float of `depth` bits.
    fn bits(value: f64, depth: usize) -> u64 {
        let single = (value as f32).to_bits();
        match depth {
            64 => value.to_bits(),
            32 => single.into(),
            _ if value == 0.0 => 0,
            // Sign, exponent about 15 in place of 127, ten bits of the fraction.
            _ => u64::from(single >> 16 & 0x8000 | ((single >> 23 & 0xff) - 112) << 10 | single >> 13 & 0x3ff),
        }
    }

    /// A grey float TIFF of 3 × 4 pixels, pixel i having the value i - 2, in strips of 3 rows or one tile of 16 × 16.
    fn sample(depth: usize, big_endian: bool, tiled: bool) -> Vec<u8> {
        let number = |value: u64, size: usize| {
            let bytes = value.to_be_bytes()[8 - size..].to_vec();
            if big_endian { bytes } else { bytes.into_iter().rev().collect() }
        };
        let size = depth / 8;
        let mut out = if big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
        let across = if tiled { 16 } else { 3 };
        let pixels = if tiled { 16 * 16 } else { 12 };
        let directory = 8 + pixels * size;
        out.extend(number(directory as u64, 4));
        for i in 0..pixels {
            let (x, y) = (i % across, i / across);
            let value = if x < 3 && y < 4 { (3 * y + x) as f64 - 2.0 } else { 0.0 };
            out.extend(number(bits(value, depth), size));
        }
        let mut entries = vec![(256, SHORT, 1, 3), (257, LONG, 1, 4), (258, SHORT, 1, depth), (262, SHORT, 1, 1)];
        let lists = directory + 2 + 12 * if tiled { 10 } else { 9 } + 4;
        if tiled {
            entries.extend([(277, SHORT, 1, 1), (322, SHORT, 1, 16), (323, SHORT, 1, 16)]);
            entries.extend([(324, LONG, 1, 8), (325, LONG, 1, 256 * size), (339, SHORT, 1, 3)]);
        } else {
            entries.extend([(273, LONG, 2, lists), (277, SHORT, 1, 1), (278, SHORT, 1, 3)]);
            entries.extend([(279, LONG, 2, lists + 8), (339, SHORT, 1, 3)]);
        }
        out.extend(number(entries.len() as u64, 2));
        for (tag, kind, count, value) in entries {
            out.extend(number(tag, 2));
            out.extend(number(kind.into(), 2));
            out.extend(number(count, 4));
            let inline = number(value as u64, if kind == SHORT { 2 } else { 4 });
            out.extend(inline.into_iter().chain([0, 0]).take(4));
        }
        out.extend(number(0, 4));
        if !tiled {
            [8, 8 + 9 * size, 9 * size, 3 * size].iter().for_each(|&value| out.extend(number(value as u64, 4)));
        }
        out
    }

    fn assert_counts(bytes: &[u8], what: &str) {
        let pixels = decode(bytes, "a").unwrap().unwrap();
        assert_eq!((pixels.width, pixels.height, pixels.channels), (3, 4, 1), "{what}");
        for i in 0..12 {
            assert_eq!(pixels.samples.at(i), i as f64 - 2.0, "{what}");
        }
    }

    #[test]
    fn grey_floats_of_every_size_in_both_byte_orders_in_strips_and_tiles_are_read() {
        for depth in [16, 32, 64] {
            for big_endian in [false, true] {
                for tiled in [false, true] {
                    let what = format!("{depth} bits, big-endian {big_endian}, tiled {tiled}");
                    assert_counts(&sample(depth, big_endian, tiled), &what);
                }
            }
        }
    }

    #[test]
    fn compressed_floats_are_read() {
        let values: Vec<f32> = (0..12).map(|i| i as f32 - 2.0).collect();
        for (name, compression) in [
            ("LZW", Compression::Lzw),
            ("deflate", Compression::Deflate(DeflateLevel::Balanced)),
            ("packed bits", Compression::Packbits),
        ] {
            let mut file = Cursor::new(Vec::new());
            let mut encoder = TiffEncoder::new(&mut file).unwrap().with_compression(compression);
            encoder.write_image::<colortype::Gray32Float>(3, 4, &values).unwrap();
            assert_counts(&file.into_inner(), name);
        }
    }

    #[test]
    fn colours_of_64_bits_are_read() {
        let values: Vec<f64> = (0..12).map(f64::from).collect();
        let mut file = Cursor::new(Vec::new());
        TiffEncoder::new(&mut file).unwrap().write_image::<colortype::RGB64Float>(2, 2, &values).unwrap();
        let pixels = decode(&file.into_inner(), "a").unwrap().unwrap();
        assert_eq!((pixels.width, pixels.height, pixels.channels), (2, 2, 3));
        assert!((0..12).all(|i| pixels.samples.at(i) == i as f64));
    }

    #[test]
    fn a_width_that_the_file_cannot_hold_is_refused() {
        let whole = sample(64, false, false);
        let entry = whole.windows(4).rposition(|start| start == [0, 1, SHORT as u8, 0]).unwrap();
        let complaint = |width: u16| {
            let bytes = [&whole[..entry + 8], &width.to_le_bytes(), &whole[entry + 10..]].concat();
            decode(&bytes, "a").unwrap().map(|_| ()).unwrap_err()
        };
        assert!(matches!(complaint(10_001), PictureError::TooLarge { width: 10_001, .. }));
        assert!(matches!(complaint(1), PictureError::TooSmall { width: 1, .. }));
        assert!(matches!(complaint(5_000), PictureError::Corrupt { .. }));
    }

    #[test]
    fn every_truncation_and_every_changed_byte_is_survived() {
        for tiled in [false, true] {
            let whole = sample(32, false, tiled);
            for length in 0..whole.len() - 4 {
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
}
