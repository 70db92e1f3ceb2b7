//! File bytes to numbers, as they stand in the file.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::pixels::{MAX_MEMORY, Pixels, Samples, check_size, one_line};
use super::{PictureError, float_tiff, sniff};

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
