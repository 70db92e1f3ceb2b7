//! From numbers to pixels: tone mapping, the colours of differences, and PNG bytes.

use std::io::Cursor;

use image::{EncodableLayout, GrayImage, ImageBuffer, ImageFormat, Luma, PixelWithColorType, Rgb};
use thiserror::Error;

use crate::raster::Raster;

/// Share of the lit pixels that stay unclipped under [`common_white`].
const UNCLIPPED: f64 = 0.995;
/// Share of all light that the lit pixels hold together, brightest first: a blur's endless tails are not part of the drawing.
const LIT: f64 = 0.99;

/// The sRGB transfer curve (IEC 61966-2-1): linear light in [0, 1] to code value in [0, 1]; clipped, NaN gives 0.
pub(crate) fn srgb_encoded(linear: f64) -> f64 {
    let v = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// A code value in [0, 1] as a byte, rounded to the nearest.
pub(crate) fn byte(code: f64) -> u8 {
    (code * 255.0).round() as u8
}

/// An 8-bit sRGB picture of a raster of linear light, same width, height and row order; `white` and above are white.
///
/// A `white` that is not a positive number gives a black picture.
pub fn tone_mapped(raster: &Raster, white: f64) -> GrayImage {
    let gain = if white > 0.0 { 1.0 / white } else { 0.0 };
    GrayImage::from_fn(raster.width as u32, raster.height as u32, |x, y| {
        Luma([byte(srgb_encoded(raster.at(x as usize, y as usize) * gain))])
    })
}

/// The white level under which `target` and whatever is compared with it should both be shown, in `target`'s units.
///
/// It is the value that 99.5 % of the lit pixels stay below (or reach), so that a few hot pixels do not darken the
/// rest; the lit pixels are the brightest ones that together hold 99 % of the light. Zero if nothing is lit.
pub fn common_white(target: &Raster) -> f64 {
    let mut lit: Vec<f64> = target.values.iter().copied().filter(|v| *v > 0.0 && v.is_finite()).collect();
    lit.sort_unstable_by(|a, b| b.total_cmp(a));
    let mut left = LIT * lit.iter().sum::<f64>();
    let count = lit.iter().position(|v| {
        left -= v;
        left <= 0.0
    });
    let count = count.map_or(lit.len(), |last| last + 1);
    // All but this many stay below it or reach it.
    let clipped = count - (UNCLIPPED * count as f64).ceil() as usize;
    lit.get(clipped).copied().unwrap_or(0.0)
}

/// The colour of a signed difference: white at 0, deepening to blue at -1 and red at +1; clipped, NaN gives white.
///
/// Both arms fall linearly in Oklab lightness and alike, so that equal departures look equally strong
/// (Ottosson, "A perceptual color space for image processing", 2020).
pub(crate) fn diverging(t: f64) -> Rgb<u8> {
    let strength = if t.is_nan() { 0.0 } else { t.abs().min(1.0) };
    let hue = f64::to_radians(if t < 0.0 { 256.0 } else { 26.0 });
    let lightness = 1.0 - 0.58 * strength;
    // Rises steeply and saturates, as far as the gamut of sRGB has room at that lightness.
    let chroma = 0.165 * (1.0 - (1.0 - strength).powi(2)) - 0.02 * strength.powi(4);
    from_oklab(lightness, chroma * hue.cos(), chroma * hue.sin())
}

/// Oklab to 8-bit sRGB, clipped; the matrices are those of Ottosson (2020).
fn from_oklab(l: f64, a: f64, b: f64) -> Rgb<u8> {
    let long = (l + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let medium = (l - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let short = (l - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    let red = 4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short;
    let green = -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short;
    let blue = -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short;
    Rgb([red, green, blue].map(|v| byte(srgb_encoded(v))))
}

/// The bytes of a PNG file of an 8-bit grey, 8-bit RGB or 16-bit grey image.
///
/// The same image gives the same bytes. Fails on an image without pixels, which PNG cannot hold.
pub fn encode_png<P>(image: &ImageBuffer<P, Vec<P::Subpixel>>) -> Result<Vec<u8>, PngError>
where
    P: PixelWithColorType,
    [P::Subpixel]: EncodableLayout,
{
    if image.width() == 0 || image.height() == 0 {
        return Err(PngError::Empty);
    }
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// Why a picture could not be made into a file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PngError {
    /// No columns or no rows.
    #[error("the picture has no pixels")]
    Empty,
    /// The encoder refused.
    #[error("the picture cannot be written as PNG: {0}")]
    Encoding(#[from] image::ImageError),
}

#[cfg(test)]
mod tests {
    use image::RgbImage;

    use super::*;

    #[test]
    fn tone_mapping_follows_the_srgb_curve_and_clips() {
        // 0.215861 linear is code 128; the straight part: 0.002 linear is code 0.02584.
        let raster = Raster { width: 3, height: 2, values: vec![0.0, 0.215_861, 1.0, 3.0, 0.002, -1.0] };
        let image = tone_mapped(&raster.clone().scaled(0.25), 0.25);
        assert_eq!(image.as_raw(), &[0, 128, 255, 255, 7, 0]);
        assert_eq!(image.dimensions(), (3, 2));
        for white in [0.0, -1.0, f64::NAN] {
            assert!(tone_mapped(&raster, white).iter().all(|&v| v == 0));
        }
        assert_eq!(tone_mapped(&Raster { width: 1, height: 1, values: vec![f64::NAN] }, 1.0).as_raw(), &[0]);
    }

    #[test]
    fn white_is_a_percentile_of_the_lit_pixels_alone() {
        // Values 1 to 1000 over faint tails. The 901 from 100 on hold 99 % of the light; all but four of them are at most
        // 996.
        let raster = Raster::from_fn(200, 100, |x, y| {
            let k = y * 200 + x;
            if k < 1000 { 1.0 + k as f64 } else { 1e-9 }
        });
        assert_eq!(common_white(&raster), 996.0);
        assert_eq!(common_white(&raster.scaled(0.5)), 498.0);
        assert_eq!(common_white(&Raster::zeros(4, 4)), 0.0);
        assert_eq!(common_white(&Raster::zeros(0, 0)), 0.0);
        assert_eq!(common_white(&Raster { width: 1, height: 1, values: vec![0.3] }), 0.3);
    }

    #[test]
    fn one_hot_pixel_does_not_darken_a_picture() {
        // A tenth of all light in one pixel of 10,000, where the others are alike.
        let mut raster = Raster::from_fn(100, 100, |_, _| 1.0);
        raster.values[77] = 1100.0;
        assert_eq!(common_white(&raster), 1.0);
        // A dot on black is shown as bright as it is.
        let dot = Raster::from_fn(100, 100, |x, y| f64::from(u8::from(x < 3 && y < 3)) + 1e-7);
        assert!((common_white(&dot) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_difference_colours_deepen_evenly_to_blue_and_red() {
        assert_eq!(diverging(0.0), Rgb([255; 3]));
        assert_eq!(diverging(f64::NAN), Rgb([255; 3]));
        assert_eq!(diverging(5.0), diverging(1.0));
        let luma = |Rgb([r, g, b]): Rgb<u8>| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
        for k in 0..20 {
            for sign in [-1.0, 1.0] {
                let (near, far) = (diverging(sign * k as f64 / 20.0), diverging(sign * (k + 1) as f64 / 20.0));
                assert!(luma(far) < luma(near), "{k} {sign}");
            }
        }
        let (Rgb([red, _, blue]), Rgb([other_red, _, other_blue])) = (diverging(0.8), diverging(-0.8));
        assert!(red > blue + 60 && other_blue > other_red + 60);
    }

    #[test]
    fn png_bytes_hold_every_pixel_of_the_three_kinds() {
        let grey = GrayImage::from_fn(5, 3, |x, y| Luma([(x * 50 + y) as u8]));
        let rgb = RgbImage::from_fn(4, 2, |x, y| Rgb([x as u8, y as u8, 200]));
        let deep = ImageBuffer::<Luma<u16>, Vec<u16>>::from_fn(3, 4, |x, y| Luma([(x * 20_000 + y) as u16]));
        assert_eq!(image::load_from_memory(&encode_png(&grey).unwrap()).unwrap(), grey.clone().into());
        assert_eq!(image::load_from_memory(&encode_png(&rgb).unwrap()).unwrap(), rgb.into());
        assert_eq!(image::load_from_memory(&encode_png(&deep).unwrap()).unwrap(), deep.into());
        assert_eq!(encode_png(&grey).unwrap(), encode_png(&grey).unwrap());
        assert!(matches!(encode_png(&GrayImage::new(0, 3)), Err(PngError::Empty)));
    }
}
