//! File bytes to numbers, as they stand in the file.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::{MAX_SIDE, PictureError, float_tiff, sniff};

/// The most a decoder may allocate, bytes.
pub const MAX_MEMORY: u64 = 1 << 30;

/// Pixels as the file has them: rows from the top, channels interleaved.
pub struct Pixels {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// 1 grey, 2 grey and opacity, 3 colour, 4 colour and opacity.
    pub channels: usize,
    /// `width * height * channels` numbers.
    pub samples: Samples,
    /// What was decided while decoding, as sentences.
    pub notes: Vec<String>,
}

/// Numbers of one depth.
pub enum Samples {
    /// White is 255.
    U8(Vec<u8>),
    /// White is 65535.
    U16(Vec<u16>),
    /// White is 1.
    F32(Vec<f32>),
    /// White is 1.
    F64(Vec<f64>),
}

impl Samples {
    /// Number `i`, white being 1.
    pub fn at(&self, i: usize) -> f64 {
        match self {
            Self::U8(v) => f64::from(v[i]) / 255.0,
            Self::U16(v) => f64::from(v[i]) / 65535.0,
            Self::F32(v) => f64::from(v[i]),
            Self::F64(v) => v[i],
        }
    }
}

/// Decodes a file of one of the four formats.
pub fn decode(bytes: &[u8], name: &str) -> Result<Pixels, PictureError> {
    let format = sniff::format(bytes, name)?;
    if format == ImageFormat::Tiff
        && let Some(result) = float_tiff::decode(bytes, name)
    {
        return result;
    }
    if let Some((width, height)) = png_header(bytes, format) {
        check_size(width, height, name)?;
    }
    if format == ImageFormat::Jpeg && !jpeg_ends(bytes) {
        let reason = "the end is missing".into();
        return Err(PictureError::Corrupt { name: name.into(), format: "JPEG", reason });
    }
    let complain = |e| complaint(e, format, name);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_MEMORY);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(complain)?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), name)?;
    if decoder.total_bytes() > MAX_MEMORY {
        return Err(PictureError::Memory { name: name.into() });
    }
    // A damaged remark on the camera is no reason to refuse the picture.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut image = DynamicImage::from_decoder(decoder).map_err(complain)?;
    let mut notes = Vec::new();
    if orientation != Orientation::NoTransforms {
        image.apply_orientation(orientation);
        notes.push("The picture was turned upright as its camera noted.".into());
    }
    pixels(image, notes).ok_or_else(|| PictureError::Unsupported {
        name: name.into(),
        format: sniff::title(format),
        reason: "unknown depth".into(),
    })
}

/// Refuses what is too large to hold or too small to draw on.
pub fn check_size(width: u64, height: u64, name: &str) -> Result<(), PictureError> {
    let name = name.into();
    if width.max(height) > MAX_SIDE as u64 {
        Err(PictureError::TooLarge { name, width, height })
    } else if width.min(height) < 2 {
        Err(PictureError::TooSmall { name, width, height })
    } else {
        Ok(())
    }
}

fn pixels(image: DynamicImage, notes: Vec<String>) -> Option<Pixels> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let channels = usize::from(image.color().channel_count());
    let samples = match image {
        DynamicImage::ImageLuma8(b) => Samples::U8(b.into_raw()),
        DynamicImage::ImageLumaA8(b) => Samples::U8(b.into_raw()),
        DynamicImage::ImageRgb8(b) => Samples::U8(b.into_raw()),
        DynamicImage::ImageRgba8(b) => Samples::U8(b.into_raw()),
        DynamicImage::ImageLuma16(b) => Samples::U16(b.into_raw()),
        DynamicImage::ImageLumaA16(b) => Samples::U16(b.into_raw()),
        DynamicImage::ImageRgb16(b) => Samples::U16(b.into_raw()),
        DynamicImage::ImageRgba16(b) => Samples::U16(b.into_raw()),
        DynamicImage::ImageRgb32F(b) => Samples::F32(b.into_raw()),
        DynamicImage::ImageRgba32F(b) => Samples::F32(b.into_raw()),
        _ => return None,
    };
    Some(Pixels { width, height, channels, samples, notes })
}

/// Size by a PNG's header, before its decoder sets memory aside for a row.
fn png_header(bytes: &[u8], format: ImageFormat) -> Option<(u64, u64)> {
    let number = |at: usize| Some(u32::from_be_bytes(bytes.get(at..at + 4)?.try_into().ok()?).into());
    (format == ImageFormat::Png && bytes.get(12..16)? == b"IHDR").then_some((number(16)?, number(20)?))
}

/// Whether the end marker follows the first scan. The decoder would fill what is missing with grey and say nothing.
/// Only the scan counts: a thumbnail before it has an end of its own.
fn jpeg_ends(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(&[mark, kind, high, low]) = bytes.get(at..at + 4) {
        match (mark, kind) {
            (0xff, 0xda) => return bytes[at..].windows(2).any(|pair| pair == [0xff, 0xd9]),
            (0xff, 0xff) => at += 1,
            (0xff, 0x01 | 0xd0..=0xd8) => at += 2,
            (0xff, _) => at += 2 + usize::from(u16::from_be_bytes([high, low])),
            // Stray bytes between segments: the decoder skips them, and so do we.
            _ => at += 1,
        }
    }
    // No scan at all: the decoder knows better what to say.
    true
}

fn complaint(error: ImageError, format: ImageFormat, name: &str) -> PictureError {
    let (name, format) = (name.into(), sniff::title(format));
    match error {
        ImageError::Limits(_) => PictureError::Memory { name },
        ImageError::Unsupported(e) => PictureError::Unsupported { name, format, reason: one_line(&e) },
        ImageError::IoError(e) => PictureError::Corrupt { name, format, reason: one_line(&e) },
        e => PictureError::Corrupt { name, format, reason: one_line(&e) },
    }
}

/// A decoder's words fit for a message of one line; a damaged file can put anything into them.
fn one_line(words: &dyn std::fmt::Display) -> String {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    words.to_string().chars().map(plain).take(160).collect()
}
