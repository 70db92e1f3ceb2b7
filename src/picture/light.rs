//! Numbers to linear light.

use rayon::prelude::*;

use super::ink::{self, Dark};
use super::pixels::{Pixels, Samples};
use super::statement::{Means, Statement};
use super::{Encoding, PictureError, Reading};
use crate::raster::Raster;

/// Light up to this is black ink: the second sRGB step above black.
const BLACK_INK: f64 = 2.0 / 255.0 / 12.92;

/// Differences within this share of the brightest pixel are none: half a step of 8 bits at its darkest.
const EVEN: f64 = 1e-4;

/// The light of each pixel and the notes so far. Consumes the pixels, so that a large picture is in memory only once.
pub(crate) fn light(mut pixels: Pixels, name: &str, reading: &Reading) -> Result<(Raster, Vec<String>), PictureError> {
    let count = pixels.width * pixels.height;
    let mut notes = std::mem::take(&mut pixels.notes);
    let statement = pixels.statement.take();
    let believed = believed(&pixels, statement.as_ref(), reading);
    let transfer = Transfer { means: means(&pixels, statement, reading), invert: reading.invert };
    let (mut raster, mut odd) = transfer.all(&pixels);
    if odd.not_finite == count {
        return Err(PictureError::NoNumbers { name: name.into() });
    }
    let mut drawn_dark = false;
    let mut found = "black";
    if !reading.invert && pixels.has_opacity() {
        let most = (0..count).map(|k| pixels.opacity(k)).fold(0.0, f64::max);
        let varies = (0..count).any(|k| pixels.opacity(k) < most);
        let dark = if varies { ink::dark(&pixels, &transfer.means) } else { Dark::Negligible };
        match dark {
            _ if raster.max() <= BLACK_INK && varies => drawn_dark = true,
            _ if most == 0.0 => found = "transparent",
            Dark::All(_) => drawn_dark = true,
            Dark::Ink(share) => {
                let inverted = Transfer { invert: true, ..transfer };
                (raster, odd) = inverted.all(&pixels);
                notes.extend(laid_on_white(&pixels, &raster, share));
            }
            Dark::Lost(share) => notes.push(format!(
                "{} of what is drawn is black on transparency and gives no light: use --invert if it shall shine.",
                percent(share)
            )),
            Dark::Negligible => {}
        }
        if drawn_dark {
            let strays = if let Dark::All(strays) = dark { strays } else { 0.0 };
            notes.push("The picture is black on transparent: its opacity was taken as light.".into());
            if strays > 0.0 {
                notes.push(format!("{} of what is drawn is brighter, and was taken for strays.", percent(strays)));
            }
            raster = Raster::from_fn(pixels.width, pixels.height, |x, y| pixels.opacity(y * pixels.width + x));
        }
    }
    if raster.max() <= 0.0 {
        return Err(black(found, name, reading));
    }
    notes.extend(odd.notes());
    notes.extend(believed.filter(|_| !drawn_dark));
    if !reading.invert && looks_like_paper(&raster) {
        notes.push(
            "Its edge is as bright as its brightest part: if it is dark ink on white paper, use --invert.".into(),
        );
    }
    Ok((raster, notes))
}

/// How its numbers become light: as asked, else as the file states, else by their depth.
fn means(pixels: &Pixels, statement: Option<Statement>, reading: &Reading) -> Means {
    match (reading.encoding, statement, &pixels.samples) {
        (Encoding::Srgb, ..) => Means::Srgb,
        (Encoding::Linear, ..) => Means::Linear,
        (Encoding::Auto, Some(statement), _) => statement.means,
        (Encoding::Auto, None, Samples::U8(_)) => Means::Srgb,
        (Encoding::Auto, None, _) => Means::Linear,
    }
}

/// A note on what was believed, where that is not what anybody would expect of such numbers.
fn believed(pixels: &Pixels, statement: Option<&Statement>, reading: &Reading) -> Option<String> {
    if reading.encoding != Encoding::Auto {
        return None;
    }
    let bytes = matches!(pixels.samples, Samples::U8(_));
    match statement {
        None if matches!(pixels.samples, Samples::U16(_)) => {
            Some("Its 16-bit values were taken as linear light: if it was painted by eye, use --srgb.".into())
        }
        None => None,
        Some(Statement { means: Means::Srgb, .. }) if bytes => None,
        Some(Statement { means: Means::Srgb, by }) => {
            Some(format!("Its values were taken as sRGB, as {by} states: if they are linear, use --linear."))
        }
        Some(Statement { means: Means::Linear, by }) => Some(format!(
            "Its values were taken as linear light, as {by} states: if it was painted by eye, use --srgb."
        )),
        Some(Statement { means: Means::Curves(..), by }) => Some(format!("Its values were read as {by} states.")),
    }
}

/// What is to be said of a drawing of which `share` is dark, laid on white and inverted.
fn laid_on_white(pixels: &Pixels, light: &Raster, share: f64) -> Vec<String> {
    let note = format!(
        "{} of what is drawn is dark on transparency: it was laid on white and inverted, as --invert does; \
         if its black means darkness, lay it on black first.",
        percent(share)
    );
    let opacity = |k: usize| pixels.opacity(k).max(0.0);
    let drawn: f64 = (0..light.values.len()).map(opacity).sum();
    let least = BLACK_INK * light.max();
    let dark = |k: &usize| light.values[*k] <= least;
    let lost = (0..light.values.len()).filter(dark).map(opacity).sum::<f64>() / drawn;
    let white = || format!("{} of what is drawn is white and gives no light so.", percent(lost));
    [note].into_iter().chain((lost >= 0.001).then(white)).collect()
}

/// The error of a picture without light.
fn black(found: &'static str, name: &str, reading: &Reading) -> PictureError {
    let remedy = match (found, reading.invert) {
        ("transparent", _) => "draw or export it with something on it",
        (_, true) => "it is all white before inverting: leave out --invert, or check what was exported",
        (_, false) => "if it is meant to be all bright, use --invert, else check what was exported",
    };
    PictureError::Black { name: name.into(), found, remedy }
}

/// A share in words that fit it.
fn percent(share: f64) -> String {
    if share < 0.1 { format!("{:.1} %", 100.0 * share) } else { format!("{:.0} %", 100.0 * share) }
}

struct Transfer {
    means: Means,
    invert: bool,
}

impl Transfer {
    /// The light of all pixels, and how many of them are odd.
    fn all(&self, pixels: &Pixels) -> (Raster, Odd) {
        let width = pixels.width;
        let mut raster = Raster::zeros(width, pixels.height);
        let odd = raster.values.par_chunks_mut(width).enumerate().map(|(row, line)| {
            let mut odd = Odd::default();
            for (column, value) in line.iter_mut().enumerate() {
                *value = self.light(pixels, row * width + column, &mut odd);
            }
            odd
        });
        let odd = odd.reduce(Odd::default, Odd::and);
        (raster, odd)
    }

    fn light(&self, pixels: &Pixels, index: usize, odd: &mut Odd) -> f64 {
        let opacity = pixels.opacity(index);
        let Some((mut values, colours)) = pixels.colours_at(index, opacity) else {
            odd.not_finite += 1;
            return 0.0;
        };
        let values = &mut values[..colours];
        odd.negative += usize::from(values.iter().any(|v| *v < 0.0));
        // Light that shines beside what it covers: linear, and multiplied already.
        if opacity == 0.0 && pixels.premultiplied && !self.invert && matches!(self.means, Means::Linear) {
            let plain = Pixels::colours_of(pixels, index).map(|v| v.max(0.0));
            return self.means.light(&plain[..colours]);
        }
        for value in values.iter_mut() {
            *value = value.max(0.0);
            if self.invert {
                // On white paper: opacity·value + (1 - opacity)·1, and 1 minus that.
                *value = (opacity * (1.0 - *value)).max(0.0);
            }
        }
        let light = self.means.light(values);
        let light = if self.invert { light } else { light * opacity };
        if light.is_finite() { light } else { 0.0 }
    }
}

impl Pixels {
    fn has_opacity(&self) -> bool {
        self.channels.is_multiple_of(2)
    }

    /// The colours of a pixel as they stand in the file.
    fn colours_of(&self, index: usize) -> [f64; 3] {
        let colours = if self.channels < 3 { 1 } else { 3 };
        let mut values = [0.0; 3];
        for (k, value) in values[..colours].iter_mut().enumerate() {
            *value = self.samples.at(index * self.channels + k);
        }
        values
    }

    /// The encoded colours of a pixel as if it were opaque, and how many they are; `None` where they are no numbers.
    pub(crate) fn colours_at(&self, index: usize, opacity: f64) -> Option<([f64; 3], usize)> {
        let mut values = self.colours_of(index);
        if !opacity.is_finite() || values.iter().any(|v| !v.is_finite()) {
            return None;
        }
        if self.premultiplied && self.has_opacity() {
            values.iter_mut().for_each(|v| *v = if opacity > 0.0 { *v / opacity } else { 0.0 });
            // Rounded numbers can come out brighter than white.
            if matches!(self.samples, Samples::U8(_) | Samples::U16(_)) {
                values.iter_mut().for_each(|v| *v = v.min(1.0));
            }
        }
        Some((values, if self.channels < 3 { 1 } else { 3 }))
    }

    /// Opacity of a pixel, 0 to 1; NaN where it is no finite number.
    pub(crate) fn opacity(&self, index: usize) -> f64 {
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

/// A note on light that is no drawing: the same in each pixel, or all in one.
pub(crate) fn plainness(light: &Raster) -> Option<String> {
    let most = light.max();
    if light.values.iter().all(|v| (most - v) <= EVEN * most) {
        return Some("Every pixel is equally bright: the highlight will be an even patch of light.".into());
    }
    let bright = light.values.iter().filter(|v| **v > EVEN * most).count();
    (bright == 1).then(|| "All its light is in one pixel: the highlight will be a single spot.".into())
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
mod tests;
