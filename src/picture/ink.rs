//! Dark drawings on transparency: black gives no light, though it is what was drawn.
//!
//! Whether a dark part is ink or shadow is told by how much of what is drawn is dark, and whether it is of few tones: a
//! logo's black is one or two, a photograph's shadows are many.

use super::pixels::Pixels;
use super::statement::{Means, srgb};

/// sRGB steps up to which a colour is dark: a fifth of white, which holds rich black, anthracite and navy.
const DARK: usize = 51;

/// Less of the picture than this is transparent in pictures whose corners alone are cut: their black is background.
const CLEAR: f64 = 0.05;

/// Tones that a drawing's dark parts mostly have, and the share of them that these make up at least.
const TONES: usize = 4;
const MOSTLY: f64 = 0.8;

/// What is brighter beside so much ink is taken for strays: marks of a scan, a forgotten pixel.
const ALL_BUT_STRAYS: f64 = 0.99;

/// What the dark parts of a picture with opacity are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Dark {
    /// Nothing that is worth a word.
    Negligible,
    /// This share of what is drawn is dark and few tones: it gives no light.
    Lost(f64),
    /// Most of what is drawn: to be laid on white and inverted.
    Ink(f64),
    /// All that is drawn, but for strays: the opacity is the drawing.
    All(f64),
}

/// Judges pixels with opacity by what each gives if it were opaque.
pub(crate) fn dark(pixels: &Pixels, means: &Means) -> Dark {
    let count = pixels.width * pixels.height;
    let mut tones = [0.0; 256];
    for k in 0..count {
        let opacity = pixels.opacity(k);
        if opacity > 0.0 {
            let light = pixels.colours_at(k, opacity).map_or(0.0, |(colours, n)| means.light(&colours[..n]));
            tones[tone(light)] += opacity;
        }
    }
    let drawn: f64 = tones.iter().sum();
    let dark: f64 = tones[..=DARK].iter().sum();
    let mut largest = tones[..=DARK].to_vec();
    largest.sort_by(|a, b| b.total_cmp(a));
    let few = largest[..TONES].iter().sum::<f64>() >= MOSTLY * dark;
    let share = dark / drawn;
    if drawn == 0.0 || !few || 1.0 - drawn / (count as f64) < CLEAR || share < 0.01 {
        Dark::Negligible
    } else if share >= ALL_BUT_STRAYS {
        Dark::All(1.0 - share)
    } else if share > 0.5 {
        Dark::Ink(share)
    } else {
        Dark::Lost(share)
    }
}

/// The sRGB step of a light, 0 to 255.
fn tone(light: f64) -> usize {
    let (mut low, mut high) = (0, 255);
    while low < high {
        let middle = (low + high) / 2;
        // Half a step up belongs to the next tone.
        if srgb((middle as f64 + 0.5) / 255.0) < light { low = middle + 1 } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::super::pixels::Samples;
    use super::*;

    /// 100 × 100 pixels: the first of the list as many as it says, and so on, the rest clear.
    fn drawn(parts: &[([u8; 4], usize)]) -> Dark {
        let mut values: Vec<u8> = parts.iter().flat_map(|(pixel, count)| pixel.repeat(*count)).collect();
        values.resize(4 * 100 * 100, 0);
        dark(&Pixels::plain((100, 100), 4, Samples::U8(values)), &Means::Srgb)
    }

    const BLACK: [u8; 4] = [0, 0, 0, 255];
    const RED: [u8; 4] = [200, 30, 30, 255];
    const WHITE: [u8; 4] = [255; 4];

    #[test]
    fn how_much_of_what_is_drawn_is_dark_decides() {
        assert_eq!(drawn(&[(BLACK, 3000)]), Dark::All(0.0));
        assert!(matches!(drawn(&[([35, 31, 32, 255], 3000), (WHITE, 1)]), Dark::All(_)));
        assert!(matches!(drawn(&[(BLACK, 3000), (WHITE, 20)]), Dark::All(_)));
        assert!(matches!(drawn(&[(BLACK, 3000), (RED, 1500)]), Dark::Ink(share) if (share - 2.0 / 3.0).abs() < 1e-12));
        assert!(matches!(drawn(&[(BLACK, 1000), (RED, 3000)]), Dark::Lost(share) if (share - 0.25).abs() < 1e-12));
        assert_eq!(drawn(&[(RED, 3000), (BLACK, 10)]), Dark::Negligible);
        assert_eq!(drawn(&[]), Dark::Negligible);
    }

    #[test]
    fn black_with_hardly_anything_clear_is_background() {
        assert_eq!(drawn(&[(BLACK, 9000), (WHITE, 900)]), Dark::Negligible);
    }

    #[test]
    fn shadows_of_many_tones_are_a_photograph() {
        let shadows: Vec<([u8; 4], usize)> = (0..50u8).map(|tone| ([tone, tone, tone, 255], 100)).collect();
        assert_eq!(drawn(&shadows), Dark::Negligible);
    }

    #[test]
    fn tones_are_the_steps_of_srgb() {
        for step in 0..256usize {
            assert_eq!(tone(srgb(step as f64 / 255.0)), step);
        }
    }
}
