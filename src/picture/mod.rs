//! Reading the drawing of a highlight: a picture file becomes linear light on a square.
//!
//! The steps, in order:
//!
//! 1. **Recognise** the format by its content, never by its name: PNG, JPEG, TIFF, WebP, GIF, BMP, PBM to PAM, Radiance
//!    HDR, and with the features `exr` and `svg` OpenEXR and SVG; the first frame of what moves, the picture among the
//!    pages of a TIFF. A camera's note on how the picture was held is obeyed, as viewers do. A file of which only the end
//!    is missing, and no part of its picture, is read with a note.
//! 2. **Invert**, if asked, in the encoded values, as an image editor does: a grey of 188 becomes 67, and ink on
//!    paper becomes light on darkness. A transparent picture is first laid on white paper, also in the encoded
//!    values, so that a drawing gives the same light whether it was exported with its background or without.
//! 3. **Decode** to linear light. The order of belief: what [`Encoding`] says; what the file states, by code points
//!    (cICP), by a colour profile of curves with a matrix or a grey one, by a PNG's sRGB and then its gAMA chunk; else 8-bit
//!    values are sRGB (IEC 61966-2-1), 16-bit and float values linear. A note says what was believed. Colour becomes
//!    Rec. 709 luminance after decoding. Opacity multiplies the light, once: it is a share of area and never sRGB.
//!    Black drawn on nothing would give no light. Where nearly all that is drawn is dark, the opacity itself is taken as the
//!    light; where most is, the drawing is laid on white and inverted; notes say so, and how much gives no light.
//! 4. **Rotate** counter-clockwise about the picture's centre: exactly for quarter turns, bilinearly otherwise. The
//!    scale never changes, so corners can leave the field; a note says how much light left with them.
//! 5. **Fit** to the square field, see [`PictureFit`].
//! 6. **Mirror**, if asked. Last, so that rotating means the same to someone who looks at a wall.
//!
//! A square picture that is neither rotated nor inverted is never resampled: what is designed, traced and scored is
//! the very pixel values that were drawn.

mod statement;

mod pixels;

mod sniff;

mod headers;

mod tiff_pages;

mod tiff;

#[cfg(feature = "exr")]
mod exr;

#[cfg(feature = "svg")]
mod svg;

mod decode;

mod pipe;

mod opened;

mod ink;

mod light;

mod fit;

mod values;

use std::io::{self, Read};
use std::path::Path;

use image::ImageReader;
use serde::{Deserialize, Serialize};

pub(crate) use self::statement::srgb;
pub use self::values::values;

use self::opened::{opened, unreadable};
use self::pixels::{Pixels, Samples, check_size};
use crate::fence::fenced;
use crate::memory::Need;
use crate::raster::Raster;

/// The longest side of a picture that is read, pixels; the square it is fitted to is no larger.
pub const MAX_SIDE: usize = 10_000;

/// The heaviest file that is read, bytes.
pub const MAX_FILE: u64 = 512 << 20;

/// How the numbers of a picture stand for light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Encoding {
    /// As the file states; else 8-bit values are sRGB, 16-bit and float values linear.
    #[default]
    Auto,
    /// All values are sRGB.
    Srgb,
    /// All values are proportional to light.
    Linear,
}

/// How a picture fills a field of other proportions: of a square one, unless the reading says otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum PictureFit {
    /// The longer side fills the field, the rest is black. Pixel values stay as they are; where the bars cannot be
    /// equal, the right or the lower one is a pixel wider.
    #[default]
    Pad,
    /// The shorter side fills the field, the rest is cut. Pixel values stay as they are; where the cuts cannot be
    /// equal, the right or the lower one is a pixel wider.
    Crop,
    /// Resampled by areas to the field's proportions; the brightness of a plain area does not change.
    Stretch,
}

/// How to read a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", default, deny_unknown_fields)]
pub struct Reading {
    /// How its numbers stand for light.
    pub encoding: Encoding,
    /// Dark becomes bright: for dark ink on white paper.
    pub invert: bool,
    /// Turns the drawing counter-clockwise as its viewer sees it, degrees.
    pub rotate: f64,
    /// How it fills the field.
    pub fit: PictureFit,
    /// Height of the field over its width; without it, 1. What is left of the square about it is black.
    pub aspect: Option<f64>,
    /// Flips u after everything else: for a highlight drawn as it shall appear on a wall (`--seen on-wall`).
    pub mirrored: bool,
}

/// Nothing asked for, for tests that ask for one thing.
#[cfg(test)]
const PLAIN: Reading = Reading {
    encoding: Encoding::Auto,
    invert: false,
    rotate: 0.0,
    fit: PictureFit::Pad,
    aspect: None,
    mirrored: false,
};

/// A highlight's drawing, ready for use.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Linear light on the square field: finite, never negative, somewhere positive; row 0 on top (v = +1).
    pub light: Raster,
    /// What was decided on the user's behalf, as sentences for the report.
    pub notes: Vec<String>,
    /// Columns and rows of the picture before it was rotated and fitted, held upright.
    pub original_size: (usize, usize),
}

/// Reads the picture at `path`; `-` is standard input, and a pipe is read to its end.
///
/// # Errors
/// The file cannot be read, is no picture, is damaged or larger than [`MAX_FILE`] or [`MAX_SIDE`], or holds no light.
pub fn read(path: &Path, reading: &Reading) -> Result<Picture, PictureError> {
    if path == Path::new("-") {
        return read_from(&mut io::stdin().lock(), "standard input", reading);
    }
    let name = path.display().to_string();
    let unreadable = |source| unreadable(path, source);
    if pipe::is_pipe(&path.metadata().map_err(unreadable)?) {
        return read_from(&mut pipe::open(path).map_err(unreadable)?, &name, reading);
    }
    read_from(&mut opened(path)?, &name, reading)
}

/// Reads a picture from what may be endless.
fn read_from(file: &mut impl Read, name: &str, reading: &Reading) -> Result<Picture, PictureError> {
    let unreadable = |source: io::Error| PictureError::Unreadable { name: name.into(), source };
    let mut bytes = Vec::new();
    file.by_ref().take(sniff::ENOUGH).read_to_end(&mut bytes).map_err(unreadable)?;
    sniff::format(&bytes, name)?;
    file.by_ref().take(MAX_FILE + 1 - bytes.len() as u64).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_FILE {
        return Err(PictureError::Heavy { name: name.into(), megabytes: MAX_FILE >> 20 });
    }
    from_bytes(&bytes, name, reading)
}

/// What it takes of memory to read the picture at `path`, if its header tells a size that pictures may have.
pub fn need(path: &Path) -> Option<Need> {
    // Not even to look at: a pipe nobody writes to would wait for ever.
    if !path.is_file() {
        return None;
    }
    let size = || ImageReader::open(path).ok()?.with_guessed_format().ok()?.into_dimensions().ok();
    let (width, height) = fenced(size).ok()??;
    let longer = width.max(height) as usize;
    let pixels = f64::from(width) * f64::from(height);
    // As decoded, as light, and on the square that it is laid on, where it may be turned.
    let bytes = DECODED_PIXEL * pixels + SQUARE_PIXEL * (longer as f64).powi(2);
    (longer <= MAX_SIDE).then(|| Need::new(GROUND + bytes, "reading the picture", "make the picture smaller"))
}

/// Bytes a pixel of a file that is read, at the most: two pictures of the decoder's, or one and its light.
const DECODED_PIXEL: f64 = 24.0;

/// Bytes a pixel of the square that light is laid on: itself, and as it was before it was turned.
const SQUARE_PIXEL: f64 = 16.0;

/// Bytes of the program itself.
const GROUND: f64 = 2e7;

/// Reads a picture from the bytes of a file; `name` stands in the messages.
///
/// # Errors
/// The bytes are no picture, are damaged or larger than [`MAX_SIDE`] allows, or hold no light.
pub fn from_bytes(bytes: &[u8], name: &str, reading: &Reading) -> Result<Picture, PictureError> {
    prepare(decode::decode(bytes, name)?, name, reading)
}

/// Takes `values`, row 0 on top, as a grey float picture: linear unless `reading` says sRGB, 1 being white.
///
/// # Errors
/// The raster is too small or larger than [`MAX_SIDE`], or holds no light.
pub fn from_raster(values: Raster, reading: &Reading) -> Result<Picture, PictureError> {
    let name = "the picture in memory";
    let Raster { width, height, values } = values;
    check_size(width as u64, height as u64, name)?;
    if values.len() != width * height {
        let reason = format!("{} values for {width} x {height} pixels", values.len());
        return Err(PictureError::Corrupt { name: name.into(), format: "raster", reason });
    }
    let samples = Samples::F64(values);
    prepare(Pixels::plain((width, height), 1, samples), name, reading)
}

fn prepare(pixels: Pixels, name: &str, reading: &Reading) -> Result<Picture, PictureError> {
    if !reading.rotate.is_finite() {
        return Err(PictureError::Rotation { name: name.into(), degrees: reading.rotate });
    }
    let original_size = (pixels.width, pixels.height);
    let (light, mut notes) = light::light(pixels, name, reading)?;
    notes.extend(light::plainness(&light));
    let light = fit::place(light, reading, &mut notes);
    if light.max() <= 0.0 {
        return Err(PictureError::CutAway { name: name.into() });
    }
    Ok(Picture { light, notes, original_size })
}

/// A decoder's words fit for a message of one line; a damaged file can put anything into them.
fn one_line(words: &dyn std::fmt::Display) -> String {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    words.to_string().chars().map(plain).take(160).collect()
}

/// Why a picture cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// Nothing has this name.
    #[error("{name}: there is no such file; check the path")]
    Missing {
        /// The picture.
        name: String,
    },
    /// A directory or a device.
    #[error("{name}: this is {found}, not a file; name a picture file")]
    NotAFile {
        /// The picture.
        name: String,
        /// What it is instead.
        found: &'static str,
    },
    /// The system refuses to read the file.
    #[error("{name}: the file cannot be read ({source}); check its permissions and its disk")]
    Unreadable {
        /// The picture.
        name: String,
        /// What the system says.
        source: io::Error,
    },
    /// No bytes.
    #[error("{name}: the file is empty; save or export the picture again")]
    Empty {
        /// The picture.
        name: String,
    },
    /// More bytes than are read.
    #[error("{name}: the file has {megabytes} MiB or more and {} are read; scale the picture down", MAX_FILE >> 20)]
    Heavy {
        /// The picture.
        name: String,
        /// Its size in MiB, or how much of a pipe was read.
        megabytes: u64,
    },
    /// Something other than the formats that are read.
    #[error("{name}: this is {found}, and only {} pictures are read; {remedy}", sniff::READ)]
    Format {
        /// The picture.
        name: String,
        /// What it looks like.
        found: &'static str,
        /// What would do.
        remedy: &'static str,
    },
    /// A rare kind of one of the formats.
    #[error("{name}: this kind of {format} is not read ({reason}); save it as an ordinary 8-bit or 16-bit PNG")]
    Unsupported {
        /// The picture.
        name: String,
        /// Its format.
        format: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// The content contradicts its format.
    #[error("{name}: the {format} data are damaged or cut short ({reason}); export or download the picture again")]
    Corrupt {
        /// The picture.
        name: String,
        /// Its format.
        format: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// More pixels than are read.
    #[error(
        "{name}: the picture is {width} x {height} pixels and at most {MAX_SIDE} a side are read; scale it down, \
         1000 a side show every detail a plate can"
    )]
    TooLarge {
        /// The picture.
        name: String,
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// Within the limit of pixels, but too much to decode.
    #[error(
        "{name}: decoding the picture takes more than {} MiB; scale it down or save it with 8 bits",
        pixels::MAX_MEMORY >> 20
    )]
    Memory {
        /// The picture.
        name: String,
    },
    /// A single pixel or a single line of them.
    #[error("{name}: the picture is {width} x {height} pixels, which holds no drawing; use at least 2 x 2")]
    TooSmall {
        /// The picture.
        name: String,
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// Nothing but NaN and infinities.
    #[error("{name}: no pixel of the picture is a finite number; check the program that wrote it")]
    NoNumbers {
        /// The picture.
        name: String,
    },
    /// No light at all.
    #[error("{name}: the picture is {found} everywhere and a highlight needs light somewhere; {remedy}")]
    Black {
        /// The picture.
        name: String,
        /// What it is everywhere.
        found: &'static str,
        /// What would do.
        remedy: &'static str,
    },
    /// All the light left the field.
    #[error("{name}: all light of the picture was cut off by rotating or cropping it; use the fit `pad`")]
    CutAway {
        /// The picture.
        name: String,
    },
    /// NaN or infinite degrees.
    #[error("{name}: the picture cannot be rotated by {degrees} degrees; give a finite number")]
    Rotation {
        /// The picture.
        name: String,
        /// What was asked.
        degrees: f64,
    },
}
