//! File bytes to numbers, as they stand in the file.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::headers::{self, JpegEnd};
use super::pixels::{MAX_MEMORY, Pixels, Samples, check_size, one_line};
use super::{PictureError, float_tiff, sniff};
use crate::fence::fenced;

/// Data of a scan that no picture has: as many bits of either kind, in no order, and no byte that looks like a mark.
const FILLER: [u8; 64] = {
    let mut filler = [0; 64];
    let mut k = 0;
    while k < filler.len() {
        filler[k] = (151 * (k + 1) % 251) as u8;
        k += 1;
    }
    filler
};

/// Decodes a file of one of the four formats. A decoder that panics is one that finds the file damaged.
pub(crate) fn decode(bytes: &[u8], name: &str) -> Result<Pixels, PictureError> {
    let format = sniff::format(bytes, name)?;
    fenced(|| decode_as(format, bytes, name)).unwrap_or_else(|panicked| Err(corrupt(format, name, &panicked)))
}

fn decode_as(format: ImageFormat, bytes: &[u8], name: &str) -> Result<Pixels, PictureError> {
    if format == ImageFormat::Tiff
        && let Some(result) = float_tiff::decode(bytes, name)
    {
        return result;
    }
    check_headers(format, bytes, name)?;
    let mut decoder = decoder(format, bytes, name)?;
    // A damaged remark on the camera is no reason to refuse the picture.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let complain = |e| complaint(e, format, name);
    let mut image = DynamicImage::from_decoder(decoder).map_err(complain)?;
    if format == ImageFormat::Jpeg && reads_beyond_its_end(&image, bytes, name) {
        return Err(corrupt(format, name, &"a part of its picture is missing"));
    }
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

/// Refuses what the decoders would misread, or on which they would fail.
fn check_headers(format: ImageFormat, bytes: &[u8], name: &str) -> Result<(), PictureError> {
    let size = match format {
        ImageFormat::Png => headers::png_size(bytes),
        ImageFormat::WebP => headers::webp_size(bytes),
        _ => None,
    };
    if let Some((width, height)) = size {
        check_size(width, height, name)?;
    }
    if format == ImageFormat::Png
        && let Some(length) = headers::wrong_png_palette(bytes)
    {
        return Err(corrupt(format, name, &format!("{length} bytes are no palette")));
    }
    // The decoder would fill what is missing with grey and say nothing.
    if format == ImageFormat::Jpeg && headers::jpeg_end(bytes) == JpegEnd::Missing {
        return Err(corrupt(format, name, &"the end is missing"));
    }
    Ok(())
}

/// The decoder of a file whose pixels are neither too many nor too few.
fn decoder<'a>(format: ImageFormat, bytes: &'a [u8], name: &str) -> Result<impl ImageDecoder + 'a, PictureError> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_MEMORY);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|e| complaint(e, format, name))?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), name)?;
    if decoder.total_bytes() > MAX_MEMORY {
        return Err(PictureError::Memory { name: name.into() });
    }
    Ok(decoder)
}

/// Whether pixels of a JPEG hang on what stands behind its last scan: the scan is too short, and the decoder, which
/// does not tell, makes them up. It is asked again with other bytes there; a whole scan leaves those unread.
fn reads_beyond_its_end(image: &DynamicImage, bytes: &[u8], name: &str) -> bool {
    let JpegEnd::At(end) = headers::jpeg_end(bytes) else { return false };
    let longer = [&bytes[..end], &FILLER, &bytes[end..]].concat();
    let other = decoder(ImageFormat::Jpeg, &longer, name).ok();
    // An error there says nothing of the file at hand.
    let other = other.and_then(|decoder| DynamicImage::from_decoder(decoder).ok());
    other.is_some_and(|other| other.as_bytes() != image.as_bytes())
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

fn complaint(error: ImageError, format: ImageFormat, name: &str) -> PictureError {
    let (name, format) = (name.into(), sniff::title(format));
    match error {
        ImageError::Limits(_) => PictureError::Memory { name },
        ImageError::Unsupported(e) => PictureError::Unsupported { name, format, reason: one_line(&e) },
        e => PictureError::Corrupt { name, format, reason: one_line(&e) },
    }
}

fn corrupt(format: ImageFormat, name: &str, reason: &dyn std::fmt::Display) -> PictureError {
    PictureError::Corrupt { name: name.into(), format: sniff::title(format), reason: one_line(reason) }
}
