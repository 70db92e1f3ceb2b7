//! TIFF pictures, which can be nearly anything: strips or tiles, whole numbers of 1 to 64 bits or floats, grey, with a
//! palette, as light or as ink, with opacity, planes beside each other, several pages.
//!
//! The crate `tiff` undoes packing and compression; what the numbers mean is told apart here. What is left out is refused
//! by its name.

use std::io::{Cursor, ErrorKind, Read, Seek, SeekFrom};

use image::metadata::Orientation;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{CompressionMethod, Tag};
use tiff::{ColorType, TiffError};

use super::pixels::{MAX_MEMORY, Pixels, Samples, check_size};
use super::tiff_pages::{Layout, Page, picture};
use super::{PictureError, one_line, statement};

/// The crate's own limit for a list in the directory, bytes: [`super::MAX_SIDE`] strips take a tenth of it.
const MAX_LIST: usize = 1 << 20;

/// The tag that says in which colours a profile stands; the crate names it too, but not for both kinds of file.
const PALETTE: Tag = Tag::ColorMap;

/// Decodes the picture of a TIFF file.
pub(crate) fn decode(bytes: &[u8], name: &str) -> Result<Pixels, PictureError> {
    let corrupt = |reason: &str| PictureError::Corrupt { name: name.into(), format: "TIFF", reason: reason.into() };
    let layout = Layout::new(bytes).ok_or_else(|| corrupt("its header is none"))?;
    let pages = layout.pages();
    if pages.iter().any(|page| page.camera) {
        return Err(PictureError::Format {
            name: name.into(),
            found: "a camera's raw photograph",
            remedy: "develop it and export it as 16-bit PNG or TIFF",
        });
    }
    let index = picture(&pages);
    let page = pages.get(index).ok_or_else(|| corrupt("its first page is missing"))?;
    let file = OnePage::new(&layout, bytes, page);
    let mut notes = Vec::new();
    if pages.len() > 1 {
        notes.push(format!("The file has {} pages or copies: the {} was read.", pages.len(), ordinal(index + 1)));
    }
    let complain = |error| complaint(error, name);
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size) = (MAX_MEMORY as usize, MAX_MEMORY as usize);
    limits.ifd_value_size = MAX_LIST;
    let decoder = Decoder::new(file).map_err(complain)?.with_limits(limits);
    let mut reading = Raw { decoder, name, photometric: page.photometric.unwrap_or(1) };
    let mut pixels = reading.pixels()?;
    let tag = |number: u16| Tag::from_u16_exhaustive(number);
    let orientation = reading.decoder.find_tag_unsigned::<u8>(tag(274)).ok().flatten();
    let orientation = orientation.and_then(Orientation::from_exif).unwrap_or(Orientation::NoTransforms);
    if orientation != Orientation::NoTransforms {
        notes.push("The picture was turned upright as its camera noted.".into());
    }
    if let Ok(Some(profile)) = reading.decoder.find_tag(tag(34_675))
        && let Ok(profile) = profile.into_u8_vec()
        && reading.photometric != 5
    {
        let colours = if pixels.channels < 3 { 1 } else { 3 };
        pixels.statement = statement::of_profile(&profile, colours, &mut notes);
    }
    notes.append(&mut pixels.notes);
    Ok(Pixels { notes, ..pixels.upright(orientation) })
}

/// A page's numbers, and what they are.
struct Raw<'a> {
    decoder: Decoder<OnePage<'a>>,
    name: &'a str,
    /// Tag 262.
    photometric: u64,
}

/// What the samples of a pixel are.
struct Kind {
    /// Numbers in the file for a pixel.
    samples: usize,
    /// Bits of each.
    bits: u8,
    /// Which of them is the opacity.
    opacity: Option<usize>,
    /// Whether the colours are multiplied by it.
    premultiplied: bool,
}

impl Raw<'_> {
    fn unsupported(&self, reason: &str) -> PictureError {
        PictureError::Unsupported { name: self.name.into(), format: "TIFF", reason: reason.into() }
    }

    fn corrupt(&self, reason: &str) -> PictureError {
        PictureError::Corrupt { name: self.name.into(), format: "TIFF", reason: reason.into() }
    }

    fn pixels(&mut self) -> Result<Pixels, PictureError> {
        let name = self.name;
        let complain = |error| complaint(error, name);
        let (width, height) = self.decoder.dimensions().map_err(complain)?;
        check_size(width.into(), height.into(), name)?;
        let kind = self.kind()?;
        let count = width as u64 * height as u64 * kind.samples as u64;
        let layout = self.decoder.image_buffer_layout().map_err(complain)?;
        // Numbers of up to 64 bits come of it, whatever the file holds.
        let size = if kind.bits <= 8 { 1 } else { u64::from(kind.bits.div_ceil(8)) };
        if size * count > MAX_MEMORY || layout.complete_len as u64 > MAX_MEMORY {
            return Err(PictureError::Memory { name: name.into() });
        }
        let mut numbers = DecodingResult::U8(Vec::new());
        self.decoder.read_image_to_buffer(&mut numbers).map_err(complain)?;
        let size = (width as usize, height as usize);
        let samples = self.samples(numbers, size, &kind, layout.planes)?;
        if samples.len() as u64 != count {
            return Err(self.corrupt("it holds more or fewer numbers than its size asks for"));
        }
        self.meaning(samples, size, &kind)
    }

    /// What the page says of its samples; refuses what has no reading here.
    fn kind(&mut self) -> Result<Kind, PictureError> {
        let complain = |error, name| complaint(error, name);
        let (samples, bits, colours) = match self.decoder.colortype().map_err(|e| complain(e, self.name))? {
            ColorType::Gray(bits) => (1, bits, 1),
            ColorType::GrayA(bits) => (2, bits, 1),
            ColorType::Multiband { bit_depth, num_samples } => (usize::from(num_samples), bit_depth, 1),
            ColorType::RGB(bits) | ColorType::YCbCr(bits) => (3, bits, 3),
            ColorType::RGBA(bits) => (4, bits, 3),
            ColorType::CMYK(bits) => (4, bits, 4),
            ColorType::CMYKA(bits) => (5, bits, 4),
            ColorType::Lab(_) => return Err(self.unsupported("its colours are CIE L*a*b*")),
            _ => return Err(self.unsupported("its colours are of a rare kind")),
        };
        let extra: Vec<u16> = self.decoder.find_tag_unsigned_vec(Tag::ExtraSamples).ok().flatten().unwrap_or_default();
        if samples > colours + 1 && extra.len() + colours < samples {
            return Err(self.unsupported(&format!("{samples} bands, and nothing says which is the picture")));
        }
        if self.photometric == 6 {
            self.check_brightness_and_colour()?;
        }
        // 1: multiplied; 2: apart; anything else is no opacity. A fourth number beside colours that nothing is said of is
        // the opacity of programs that forget to say so (OpenCV).
        let forgotten = extra.is_empty() && self.photometric == 2 && samples == 4;
        let first = extra.first().copied().unwrap_or(if forgotten { 2 } else { 0 });
        let opacity = (samples > colours && matches!(first, 1 | 2)).then_some(colours);
        Ok(Kind { samples, bits, opacity, premultiplied: first == 1 })
    }

    /// Y, Cb and Cr are read as JPEG compression leaves them, or one of each for every pixel.
    fn check_brightness_and_colour(&mut self) -> Result<(), PictureError> {
        let numbers =
            |decoder: &mut Decoder<OnePage<'_>>, tag| decoder.find_tag_unsigned_vec::<u16>(tag).ok().flatten();
        let compression = numbers(&mut self.decoder, Tag::Compression).and_then(|list| list.first().copied());
        let jpeg = compression.map(CompressionMethod::from_u16_exhaustive) == Some(CompressionMethod::ModernJPEG);
        let step = numbers(&mut self.decoder, Tag::ChromaSubsampling).unwrap_or(vec![2, 2]);
        if jpeg || step.iter().all(|step| *step == 1) {
            return Ok(());
        }
        Err(self.unsupported("its colours are coarser than its brightness (YCbCr)"))
    }

    /// The numbers as samples, interleaved and each by itself.
    fn samples(
        &self,
        numbers: DecodingResult,
        (width, height): (usize, usize),
        kind: &Kind,
        planes: usize,
    ) -> Result<Samples, PictureError> {
        let scaled = |values: Vec<f64>| Samples::F64(values);
        let samples = match (numbers, kind.bits) {
            (DecodingResult::U8(packed), 1 | 2 | 4) => {
                let across = if planes > 1 { width } else { width * kind.samples };
                Samples::U8(unpacked(&packed, across, kind.bits, self.photometric == 3))
            }
            (DecodingResult::U8(values), 8) => Samples::U8(values),
            (DecodingResult::U16(values), 16) => Samples::U16(values),
            (DecodingResult::U32(values), 32) => {
                scaled(values.iter().map(|v| f64::from(*v) / f64::from(u32::MAX)).collect())
            }
            (DecodingResult::F16(values), _) => Samples::F32(values.iter().map(|value| value.to_f32()).collect()),
            (DecodingResult::F32(values), _) => Samples::F32(values),
            (DecodingResult::F64(values), _) => Samples::F64(values),
            (DecodingResult::I8(_) | DecodingResult::I16(_) | DecodingResult::I32(_) | DecodingResult::I64(_), _) => {
                return Err(self.unsupported("its numbers have signs"));
            }
            (_, bits) => return Err(self.unsupported(&format!("numbers of {bits} bits"))),
        };
        if planes < 2 || kind.samples < 2 {
            return Ok(samples);
        }
        let count = width * height;
        if samples.len() != count * kind.samples {
            return Err(self.corrupt("a plane of it is missing"));
        }
        Ok(samples.gathered(1, count * kind.samples, |k| k % kind.samples * count + k / kind.samples))
    }

    /// Light and opacity by what the numbers stand for.
    fn meaning(&mut self, samples: Samples, size: (usize, usize), kind: &Kind) -> Result<Pixels, PictureError> {
        let count = size.0 * size.1;
        let only = |samples: &Samples, which: &[usize]| {
            samples.gathered(1, count * which.len(), |k| k / which.len() * kind.samples + which[k % which.len()])
        };
        let with_opacity = |colours: &[usize]| [colours, kind.opacity.as_slice()].concat();
        let mut pixels = match self.photometric {
            0 | 1 => {
                let which = with_opacity(&[0]);
                let mut samples = only(&samples, &which);
                if self.photometric == 0 {
                    // The crate was told otherwise: it cannot turn ink into light where there is opacity too.
                    samples.turn_over(which.len());
                }
                Pixels::plain(size, which.len(), samples)
            }
            2 => {
                let which = with_opacity(&[0, 1, 2]);
                Pixels::plain(size, which.len(), only(&samples, &which))
            }
            3 => self.looked_up(&samples, size, kind)?,
            5 => {
                let which = with_opacity(&[0, 1, 2]);
                let mut pixels = Pixels::plain(size, which.len(), samples.inks(kind, count, &which));
                let note = "Its inks (CMYK) were turned into light by plain subtraction, without a colour profile.";
                pixels.notes.push(note.into());
                pixels
            }
            6 => Pixels::plain(size, 3, samples.rgb_of_brightness_and_colour(count)),
            _ => return Err(self.unsupported("its colours are of a rare kind")),
        };
        pixels.premultiplied = kind.opacity.is_some() && kind.premultiplied;
        Ok(pixels)
    }

    /// Colours from the palette, which has 16 bits; a palette of 8 bits that stands in them is an old mistake.
    fn looked_up(&mut self, samples: &Samples, size: (usize, usize), kind: &Kind) -> Result<Pixels, PictureError> {
        let palette: Option<Vec<u16>> = self.decoder.find_tag_unsigned_vec(PALETTE).ok().flatten();
        let palette = palette.ok_or_else(|| self.corrupt("it has no palette"))?;
        let colours = palette.len() / 3;
        let bits = kind.bits;
        let number = |i: usize| match samples {
            Samples::U8(values) => Some(usize::from(values[i])),
            _ => None,
        };
        let shift = if palette.iter().all(|value| *value < 256) { 0 } else { 8 };
        let mut out = Vec::with_capacity(3 * size.0 * size.1);
        for k in 0..size.0 * size.1 {
            let Some(index) = number(k * kind.samples) else {
                return Err(self.unsupported(&format!("a palette for numbers of {bits} bits")));
            };
            if index >= colours {
                return Err(self.corrupt("a pixel has a colour that its palette does not have"));
            }
            out.extend([0, 1, 2].map(|part| (palette[index + part * colours] >> shift) as u8));
        }
        Ok(Pixels::plain(size, 3, Samples::U8(out)))
    }
}

impl Samples {
    /// Ink becomes light, opacity (the last of two) stays.
    fn turn_over(&mut self, channels: usize) {
        match self {
            Self::U8(values) => values.iter_mut().step_by(channels).for_each(|v| *v = u8::MAX - *v),
            Self::U16(values) => values.iter_mut().step_by(channels).for_each(|v| *v = u16::MAX - *v),
            Self::F32(values) => values.iter_mut().step_by(channels).for_each(|v| *v = 1.0 - *v),
            Self::F64(values) => values.iter_mut().step_by(channels).for_each(|v| *v = 1.0 - *v),
        }
    }

    /// Red, green, blue (and opacity) of cyan, magenta, yellow and black, 16 bits: each ink takes its share of light.
    fn inks(&self, kind: &Kind, count: usize, which: &[usize]) -> Self {
        let number = |i: usize| self.at(i).clamp(0.0, 1.0);
        let light = |pixel: usize, part: usize| match kind.opacity {
            Some(opacity) if part == opacity => number(pixel * kind.samples + opacity),
            _ => (1.0 - number(pixel * kind.samples + part)) * (1.0 - number(pixel * kind.samples + 3)),
        };
        let all = (0..count).flat_map(|pixel| which.iter().map(move |&part| light(pixel, part)));
        if kind.bits <= 8 {
            Self::U8(all.map(|v| (255.0 * v).round() as u8).collect())
        } else {
            Self::U16(all.map(|v| (65535.0 * v).round() as u16).collect())
        }
    }

    /// Red, green and blue of Y, Cb and Cr as JPEG files have them (ITU-T T.871), 8 bits.
    fn rgb_of_brightness_and_colour(&self, count: usize) -> Self {
        let number = |i: usize| 255.0 * self.at(i);
        let colour = |k: usize| {
            let (y, b, r) = (number(3 * k), number(3 * k + 1) - 128.0, number(3 * k + 2) - 128.0);
            [y + 1.402 * r, y - 0.344_136 * b - 0.714_136 * r, y + 1.772 * b]
        };
        Self::U8((0..count).flat_map(colour).map(|v| v.round().clamp(0.0, 255.0) as u8).collect())
    }
}

/// Numbers of less than 8 bits, each by itself: as they stand, or white being 255. Rows begin at whole bytes.
fn unpacked(packed: &[u8], across: usize, bits: u8, as_numbers: bool) -> Vec<u8> {
    let most = (1u8 << bits) - 1;
    let row_bytes = (across * usize::from(bits)).div_ceil(8);
    let per_byte = usize::from(8 / bits);
    let rows = packed.chunks_exact(row_bytes.max(1));
    let number = |row: &[u8], x: usize| row[x / per_byte] >> (8 - bits - bits * (x % per_byte) as u8) & most;
    let scale = if as_numbers { 1 } else { 255 / most };
    rows.flat_map(|row| (0..across).map(move |x| scale * number(row, x))).collect()
}

/// A file as if one of its pages were the first, and with a reading of its numbers that the crate knows.
struct OnePage<'a> {
    file: Cursor<&'a [u8]>,
    /// What stands elsewhere than in the file: where, and what.
    patches: [(u64, Vec<u8>); 2],
}

impl<'a> OnePage<'a> {
    fn new(layout: &Layout, bytes: &'a [u8], page: &Page) -> Self {
        let (at, first) = layout.first(page.offset);
        // Palettes, and ink in place of light, are undone here: to the crate they are plain numbers.
        let plain = matches!(page.photometric, Some(0 | 3));
        let (photometric_at, size) = page.photometric_at;
        let photometric = if plain { layout.encoded(1, size) } else { Vec::new() };
        Self { file: Cursor::new(bytes), patches: [(at as u64, first), (photometric_at, photometric)] }
    }
}

impl Read for OnePage<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let from = self.file.position();
        let read = self.file.read(buffer)?;
        for (at, bytes) in &self.patches {
            for (k, byte) in bytes.iter().enumerate() {
                let place = (at + k as u64).checked_sub(from).and_then(|place| usize::try_from(place).ok());
                if let Some(old) = place.filter(|place| *place < read).and_then(|place| buffer.get_mut(place)) {
                    *old = *byte;
                }
            }
        }
        Ok(read)
    }
}

impl Seek for OnePage<'_> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.file.seek(to)
    }
}

/// "first", "second", "third", then numbers.
fn ordinal(number: usize) -> String {
    match number {
        1 => "first".into(),
        2 => "second".into(),
        3 => "third".into(),
        _ => format!("{number}th"),
    }
}

fn complaint(error: TiffError, name: &str) -> PictureError {
    let corrupt = |reason: String| PictureError::Corrupt { name: name.into(), format: "TIFF", reason };
    match error {
        TiffError::LimitsExceeded | TiffError::IntSizeError => PictureError::Memory { name: name.into() },
        TiffError::UnsupportedError(e) => {
            PictureError::Unsupported { name: name.into(), format: "TIFF", reason: one_line(&e) }
        }
        TiffError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof => corrupt("a strip of it is missing".into()),
        e => corrupt(one_line(&e)),
    }
}

#[cfg(test)]
mod tests;
