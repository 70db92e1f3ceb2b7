//! File bytes to numbers, as they stand in the file.

use std::io::Cursor;

use image::codecs::gif::GifDecoder;
use image::metadata::Orientation;
use image::{AnimationDecoder, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::headers::{self, JpegEnd};
use super::pixels::{MAX_MEMORY, Pixels, Samples, check_size};
use super::sniff::{self, Format};
use super::statement::{self, Statement};
use super::{PictureError, one_line, tiff};
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

/// Decodes a file of a format that is read. A decoder that panics is one that finds the file damaged.
pub(crate) fn decode(bytes: &[u8], name: &str) -> Result<Pixels, PictureError> {
    let format = sniff::format(bytes, name)?;
    let work = || match format {
        Format::General(format) => general(format, bytes, name),
        Format::Tiff => tiff::decode(bytes, name),
        #[cfg(feature = "exr")]
        Format::Exr => super::exr::decode(bytes, name),
        #[cfg(feature = "svg")]
        Format::Svg => super::svg::decode(bytes, name),
    };
    fenced(work).unwrap_or_else(|panicked| Err(corrupt(format.title(), name, &panicked)))
}

/// Decodes what the general decoder knows, mended where only its end is missing.
fn general(format: ImageFormat, bytes: &[u8], name: &str) -> Result<Pixels, PictureError> {
    let ended = match format {
        ImageFormat::Png => headers::ended_png(bytes),
        ImageFormat::Jpeg if headers::jpeg_end(bytes) == JpegEnd::Missing => Some([bytes, &[0xff, 0xd9]].concat()),
        _ => None,
    };
    let Some(ended) = ended else { return decode_as(format, bytes, name) };
    let mut pixels = decode_as(format, &ended, name)?;
    pixels.notes.push("The end of the file is missing, but no part of its picture.".into());
    Ok(pixels)
}

fn decode_as(format: ImageFormat, bytes: &[u8], name: &str) -> Result<Pixels, PictureError> {
    check_headers(format, bytes, name)?;
    let mut decoder = decoder(format, bytes, name)?;
    // A damaged remark on the camera or the colours is no reason to refuse the picture.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let profile = decoder.icc_profile().ok().flatten();
    let image = DynamicImage::from_decoder(decoder).map_err(|e| complaint(e, format, name))?;
    if format == ImageFormat::Jpeg && reads_beyond_its_end(&image, bytes, name) {
        return Err(corrupt("JPEG", name, &"a part of its picture is missing"));
    }
    let unknown = || PictureError::Unsupported {
        name: name.into(),
        format: Format::General(format).title(),
        reason: "unknown depth".into(),
    };
    let mut pixels = pixels(image).ok_or_else(unknown)?;
    if format == ImageFormat::Pnm
        && let Some(white) = headers::netpbm_white(bytes)
    {
        pixels.samples.whiten(white);
    }
    if moves(format, bytes) {
        pixels.notes.push("The picture moves: its first frame was taken.".into());
    }
    let png = format == ImageFormat::Png;
    pixels.statement = statement(bytes, png, profile.as_deref(), pixels.channels, &mut pixels.notes);
    if orientation != Orientation::NoTransforms {
        pixels.notes.push("The picture was turned upright as its camera noted.".into());
    }
    Ok(pixels.upright(orientation))
}

/// What a file says of its numbers: a PNG's code points, a profile, a PNG's other chunks, in the order of belief that
/// the PNG specification (13.12, third edition) gives.
fn statement(
    bytes: &[u8],
    png: bool,
    profile: Option<&[u8]>,
    channels: usize,
    notes: &mut Vec<String>,
) -> Option<Statement> {
    let chunk = |wanted: &[u8; 4]| {
        let before = headers::png_chunks(bytes).take_while(|(kind, _)| *kind != b"IDAT");
        let found = before.filter(|_| png).find(|(kind, _)| *kind == wanted);
        found.map(|(_, content)| content)
    };
    let points = chunk(b"cICP").and_then(|content| statement::of_code_points(content.try_into().ok()?));
    let colours = if channels < 3 { 1 } else { 3 };
    let profiled = || statement::of_profile(profile?, colours, notes);
    let srgb = || chunk(b"sRGB").map(|_| Statement { by: "its sRGB chunk".into(), means: statement::Means::Srgb });
    let gamma = || statement::of_gamma(u32::from_be_bytes(chunk(b"gAMA")?.try_into().ok()?));
    points.or_else(profiled).or_else(srgb).or_else(gamma)
}

/// Whether there is more than one frame.
fn moves(format: ImageFormat, bytes: &[u8]) -> bool {
    match format {
        ImageFormat::Gif => {
            let decoder = GifDecoder::new(Cursor::new(bytes));
            decoder.is_ok_and(|decoder| matches!(decoder.into_frames().nth(1), Some(Ok(_))))
        }
        ImageFormat::Png | ImageFormat::WebP => headers::moves(bytes),
        _ => false,
    }
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
        return Err(corrupt("PNG", name, &format!("{length} bytes are no palette")));
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

fn pixels(image: DynamicImage) -> Option<Pixels> {
    let size = (image.width() as usize, image.height() as usize);
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
    Some(Pixels::plain(size, channels, samples))
}

fn complaint(error: ImageError, format: ImageFormat, name: &str) -> PictureError {
    let (name, format) = (name.into(), Format::General(format).title());
    match error {
        ImageError::Limits(_) => PictureError::Memory { name },
        ImageError::Unsupported(e) => PictureError::Unsupported { name, format, reason: one_line(&e) },
        e => PictureError::Corrupt { name, format, reason: one_line(&e) },
    }
}

fn corrupt(format: &'static str, name: &str, reason: &dyn std::fmt::Display) -> PictureError {
    PictureError::Corrupt { name: name.into(), format, reason: one_line(reason) }
}
