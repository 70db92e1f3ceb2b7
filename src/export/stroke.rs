//! Antialiased lines on pictures.

use glam::DVec2;
use image::{Rgb, RgbImage};

/// Draws a line through `points` (pixels, x right, y down), `wide` pixels across, with round ends and joints.
///
/// What lies outside the image is left off; points that are not finite break the line.
pub(super) fn stroke(image: &mut RgbImage, points: &[DVec2], wide: f64, colour: Rgb<u8>) {
    // The whole line covers a pixel once, however many of its pieces come near.
    let mut cover = std::collections::BTreeMap::<(u32, u32), f64>::new();
    let reach = 0.5 * wide + 1.0;
    let limit = DVec2::new(f64::from(image.width()), f64::from(image.height()));
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        if !(a.is_finite() && b.is_finite()) {
            continue;
        }
        let low = (a.min(b) - reach).floor().clamp(DVec2::ZERO, limit);
        let high = (a.max(b) + reach).ceil().clamp(DVec2::ZERO, limit);
        let length = (b - a).length_squared();
        for y in low.y as u32..high.y as u32 {
            for x in low.x as u32..high.x as u32 {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let t = if length > 0.0 { ((at - a).dot(b - a) / length).clamp(0.0, 1.0) } else { 0.0 };
                let share = (0.5 + 0.5 * wide - at.distance(a.lerp(b, t))).clamp(0.0, 1.0);
                if share > 0.0 {
                    let known = cover.entry((x, y)).or_default();
                    *known = known.max(share);
                }
            }
        }
    }
    for ((x, y), share) in cover {
        let pixel = image.get_pixel_mut(x, y);
        for (under, over) in pixel.0.iter_mut().zip(colour.0) {
            *under = (f64::from(*under) + (f64::from(over) - f64::from(*under)) * share).round() as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_inks_its_own_area_and_stays_inside() {
        let mut image = RgbImage::from_pixel(60, 40, Rgb([255; 3]));
        stroke(&mut image, &[DVec2::new(10.0, 10.3), DVec2::new(40.0, 30.7)], 3.0, Rgb([0; 3]));
        let ink: f64 = image.pixels().map(|p| 1.0 - f64::from(p.0[0]) / 255.0).sum();
        let length = DVec2::new(30.0, 20.4).length();
        assert!((ink - 3.0 * length - std::f64::consts::PI * 2.25).abs() < 1.5, "{ink}");
        let nan = DVec2::new(f64::NAN, 1.0);
        stroke(&mut image, &[DVec2::new(-50.0, -9.0), DVec2::new(300.0, 1e7), nan, nan], 2.0, Rgb([0; 3]));
    }
}
