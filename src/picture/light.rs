//! Numbers to linear light.

use rayon::prelude::*;

use super::pixels::{Pixels, Samples};
use super::{Encoding, PictureError, Reading};
use crate::raster::Raster;

/// Luminance of linear red, green and blue: ITU-R BT.709-6, item 3.2.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Light up to this is black ink: the second sRGB step above black.
const BLACK_INK: f64 = 2.0 / 255.0 / 12.92;

/// The light of each pixel and the notes so far. Consumes the pixels, so that a large picture is in memory only once.
pub fn light(pixels: Pixels, name: &str, reading: &Reading) -> Result<(Raster, Vec<String>), PictureError> {
    let (width, height) = (pixels.width, pixels.height);
    let linear = match reading.encoding {
        Encoding::Auto => !matches!(pixels.samples, Samples::U8(_)),
        Encoding::Srgb => false,
        Encoding::Linear => true,
    };
    let transfer = Transfer { linear, invert: reading.invert };
    let mut raster = Raster::zeros(width, height);
    let odd = raster.values.par_chunks_mut(width).enumerate().map(|(row, line)| {
        let mut odd = Odd::default();
        for (column, value) in line.iter_mut().enumerate() {
            *value = transfer.light(&pixels, row * width + column, &mut odd);
        }
        odd
    });
    let odd = odd.reduce(Odd::default, Odd::and);
    if odd.not_finite == width * height {
        return Err(PictureError::NoNumbers { name: name.into() });
    }
    let mut found = "black";
    let mut notes = pixels.notes.clone();
    if raster.max() <= BLACK_INK && !reading.invert && pixels.has_opacity() {
        let opacity = Raster::from_fn(width, height, |x, y| pixels.opacity(y * width + x));
        let most = opacity.max();
        if opacity.values.iter().any(|o| *o < most) {
            notes.push("The picture is black on transparent: its opacity was taken as light.".into());
            raster = opacity;
        } else if most == 0.0 {
            found = "transparent";
        }
    }
    if raster.max() <= 0.0 {
        let remedy = match (found, reading.invert) {
            ("transparent", _) => "draw or export it with something on it",
            (_, true) => "it is all white before inverting: leave out --invert, or check what was exported",
            (_, false) => "if it is meant to be all bright, use --invert, else check what was exported",
        };
        return Err(PictureError::Black { name: name.into(), found, remedy });
    }
    notes.extend(odd.notes());
    if reading.encoding == Encoding::Auto && matches!(pixels.samples, Samples::U16(_)) {
        notes.push("Its 16-bit values were taken as linear light: if it was painted by eye, use --srgb.".into());
    }
    if !reading.invert && looks_like_paper(&raster) {
        notes.push(
            "Its edge is as bright as its brightest part: if it is dark ink on white paper, use --invert.".into(),
        );
    }
    Ok((raster, notes))
}

/// sRGB-encoded value to linear light (IEC 61966-2-1).
fn srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

struct Transfer {
    linear: bool,
    invert: bool,
}

impl Transfer {
    fn light(&self, pixels: &Pixels, index: usize, odd: &mut Odd) -> f64 {
        let colours = pixels.colours();
        let opacity = pixels.opacity(index);
        let mut values = [0.0; 3];
        for (k, value) in values[..colours].iter_mut().enumerate() {
            *value = pixels.samples.at(index * pixels.channels + k);
        }
        let values = &mut values[..colours];
        if !opacity.is_finite() || values.iter().any(|v| !v.is_finite()) {
            odd.not_finite += 1;
            return 0.0;
        }
        odd.negative += usize::from(values.iter().any(|v| *v < 0.0));
        for value in values.iter_mut() {
            *value = value.max(0.0);
            if self.invert {
                // On white paper: opacity·value + (1 - opacity)·1, and 1 minus that.
                *value = (opacity * (1.0 - *value)).max(0.0);
            }
            if !self.linear {
                *value = srgb(*value);
            }
        }
        let light = match values {
            [grey] => *grey,
            colour => colour.iter().zip(LUMINANCE).map(|(value, weight)| value * weight).sum(),
        };
        if self.invert { light } else { light * opacity }
    }
}

impl Pixels {
    fn colours(&self) -> usize {
        if self.channels < 3 { 1 } else { 3 }
    }

    fn has_opacity(&self) -> bool {
        self.channels.is_multiple_of(2)
    }

    /// Opacity of a pixel, 0 to 1; NaN where it is no finite number.
    fn opacity(&self, index: usize) -> f64 {
        if !self.has_opacity() {
            return 1.0;
        }
        let opacity = self.samples.at((index + 1) * self.channels - 1);
        if opacity.is_finite() { opacity.clamp(0.0, 1.0) } else { f64::NAN }
    }
}

/// How many pixels are not numbers that light can have.
#[derive(Clone, Copy, Default)]
struct Odd {
    not_finite: usize,
    negative: usize,
}

impl Odd {
    fn and(self, other: Self) -> Self {
        Self { not_finite: self.not_finite + other.not_finite, negative: self.negative + other.negative }
    }

    fn notes(self) -> impl Iterator<Item = String> {
        let note = |count: usize, what: &str| {
            let pixels = if count == 1 { "pixel" } else { "pixels" };
            (count > 0).then(|| format!("{count} {pixels} with {what} values were taken as dark."))
        };
        note(self.not_finite, "infinite or undefined").into_iter().chain(note(self.negative, "negative"))
    }
}

/// Nearly all of the rim is bright, and something is dark.
fn looks_like_paper(light: &Raster) -> bool {
    let half = 0.5 * light.max();
    let (w, h) = (light.width, light.height);
    let rim = || (0..w).flat_map(|x| [(x, 0), (x, h - 1)]).chain((0..h).flat_map(|y| [(0, y), (w - 1, y)]));
    let bright = rim().filter(|(x, y)| light.at(*x, *y) > half).count();
    bright * 10 > rim().count() * 9 && light.values.iter().any(|v| *v < half)
}

#[cfg(test)]
mod tests {
    use super::super::from_raster;
    use super::*;

    fn pixels(channels: usize, samples: Samples) -> Pixels {
        let count = samples.len();
        Pixels { width: count / channels / 2, height: 2, channels, samples, notes: Vec::new() }
    }

    fn values(channels: usize, samples: Samples, reading: &Reading) -> Vec<f64> {
        light(pixels(channels, samples), "a", reading).unwrap().0.values
    }

    fn near(a: &[f64], b: &[f64]) {
        assert!(a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
    }

    const AUTO: Reading = Reading {
        encoding: Encoding::Auto,
        invert: false,
        rotate: 0.0,
        fit: super::super::PictureFit::Pad,
        mirrored: false,
    };
    const LINEAR: Reading = Reading { encoding: Encoding::Linear, ..AUTO };
    const SRGB: Reading = Reading { encoding: Encoding::Srgb, ..AUTO };
    const INVERT: Reading = Reading { invert: true, ..AUTO };

    #[test]
    fn depth_decides_the_encoding_unless_told() {
        // 188 is the sRGB code for half of the light, to the nearest step; 10 lies on the straight part.
        let bytes = || Samples::U8(vec![0, 10, 188, 255]);
        let half = ((188.0f64 / 255.0 + 0.055) / 1.055).powf(2.4);
        assert!((half - 0.5).abs() < 0.005);
        near(&values(1, bytes(), &AUTO), &[0.0, 10.0 / 255.0 / 12.92, half, 1.0]);
        near(&values(1, bytes(), &LINEAR), &[0.0, 10.0 / 255.0, 188.0 / 255.0, 1.0]);
        let words = || Samples::U16(vec![0, 2570, 48316, 65535]);
        near(&values(1, words(), &AUTO), &values(1, bytes(), &LINEAR));
        near(&values(1, words(), &SRGB), &values(1, bytes(), &AUTO));
        let floats = || Samples::F32(vec![0.0, 0.25, 0.5, 4.0]);
        near(&values(1, floats(), &AUTO), &[0.0, 0.25, 0.5, 4.0]);
        near(&values(1, floats(), &SRGB)[3..], &[(4.055f64 / 1.055).powf(2.4)]);
    }

    #[test]
    fn colour_becomes_luminance_after_decoding() {
        let pure = Samples::U8(vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 188, 188, 188]);
        near(&values(3, pure, &AUTO), &[0.2126, 0.7152, 0.0722, srgb(188.0 / 255.0)]);
        let olive = Samples::U8([188, 188, 0].repeat(4));
        near(&values(3, olive, &AUTO)[..1], &[(0.2126 + 0.7152) * srgb(188.0 / 255.0)]);
    }

    #[test]
    fn opacity_multiplies_and_is_never_srgb() {
        let white = Samples::U8(vec![255, 0, 255, 51, 255, 102, 188, 255]);
        near(&values(2, white, &AUTO), &[0.0, 0.2, 0.4, srgb(188.0 / 255.0)]);
        let red = Samples::U16([65535, 0, 0, 13107].repeat(4));
        near(&values(4, red, &AUTO), &[0.2126 * 0.2; 4]);
    }

    #[test]
    fn black_on_transparent_is_taken_by_its_opacity() {
        let ink = || Samples::U8(vec![0, 0, 0, 0, 1, 1, 1, 51, 0, 0, 0, 102, 0, 0, 0, 255]);
        let (raster, notes) = light(pixels(4, ink()), "a", &AUTO).unwrap();
        near(&raster.values, &[0.0, 0.2, 0.4, 1.0]);
        assert!(notes[0].contains("opacity was taken as light"));
        // A dark grey drawing is faint, not black: it stays what it is.
        let grey = Samples::U8(vec![60, 0, 60, 255, 60, 0, 60, 255]);
        near(&values(2, grey, &AUTO), &[0.0, srgb(60.0 / 255.0), 0.0, srgb(60.0 / 255.0)]);
    }

    #[test]
    fn inverting_is_what_an_editor_does() {
        let grey = Samples::U8(vec![188, 0, 255, 67]);
        near(&values(1, grey, &INVERT), &[srgb(67.0 / 255.0), 1.0, 0.0, srgb(188.0 / 255.0)]);
        near(&values(1, Samples::U16(vec![0, 13107, 65535, 0]), &INVERT), &[1.0, 0.8, 0.0, 1.0]);
        // Each channel by itself: yellow paper with blue ink.
        let colour = Samples::U8(vec![255, 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255]);
        near(&values(3, colour, &INVERT), &[0.0722, 0.2126 + 0.7152, 1.0, 0.0]);
    }

    #[test]
    fn inverting_a_transparent_drawing_is_inverting_it_on_white_paper() {
        let mut clear = Vec::new();
        let mut paper = Vec::new();
        for opacity in [0u8, 51, 102, 255] {
            clear.extend([0, opacity]);
            paper.push(255 - opacity);
        }
        near(&values(2, Samples::U8(clear), &INVERT), &values(1, Samples::U8(paper), &INVERT));
    }

    #[test]
    fn what_is_no_light_is_dark_and_counted() {
        let floats = vec![f32::NAN, f32::INFINITY, -1.0, 2.0, f32::NEG_INFINITY, 0.5];
        let (raster, notes) = light(pixels(1, Samples::F32(floats.clone())), "a", &AUTO).unwrap();
        near(&raster.values, &[0.0, 0.0, 0.0, 2.0, 0.0, 0.5]);
        assert!(notes[0].starts_with("3 pixels with infinite"), "{notes:?}");
        assert!(notes[1].starts_with("1 pixel with negative"), "{notes:?}");
        // Brighter than white, and no number at all, stay dark when inverted.
        near(&values(1, Samples::F32(floats), &INVERT), &[0.0, 0.0, 1.0, 0.0, 0.0, 0.5]);
    }

    #[test]
    fn a_picture_without_light_says_what_to_do() {
        let message =
            |channels, samples, reading| light(pixels(channels, samples), "a", reading).unwrap_err().to_string();
        assert!(message(1, Samples::U8(vec![0; 4]), &AUTO).contains("black everywhere"));
        assert!(message(1, Samples::U8(vec![0; 4]), &AUTO).contains("--invert"));
        assert!(message(1, Samples::U8(vec![255; 4]), &INVERT).contains("leave out --invert"));
        assert!(message(2, Samples::U8(vec![0, 128, 0, 128, 0, 128, 0, 128]), &AUTO).contains("black everywhere"));
        assert!(
            message(2, Samples::U8(vec![255, 0, 255, 0, 255, 0, 255, 0]), &AUTO).contains("transparent everywhere")
        );
        assert!(message(1, Samples::F32(vec![f32::NAN; 4]), &AUTO).contains("no pixel"));
    }

    #[test]
    fn ink_on_paper_is_recognised() {
        let drawn = |paper: f64, ink: f64| {
            let page =
                Raster::from_fn(9, 9, |x, y| if (3..6).contains(&x) && (3..6).contains(&y) { ink } else { paper });
            from_raster(page, &AUTO).unwrap().notes
        };
        assert!(drawn(0.9, 0.1)[0].contains("--invert"));
        assert!(drawn(0.1, 0.9).is_empty());
        assert!(drawn(0.9, 0.9).is_empty());
    }
}
