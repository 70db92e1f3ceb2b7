//! Light to the field: rotated, fitted, mirrored, and the field in the middle of a square.

use rayon::prelude::*;

use super::{PictureFit, Reading};
use crate::raster::Raster;

/// Less light than this may leave the field without a note.
const NEGLIGIBLE: f64 = 1e-3;

/// Columns of a field that a small picture is laid out in without losing any of its own.
const ENOUGH: usize = 2048;

/// The light as it will be used: square, row 0 on top.
pub(crate) fn place(light: Raster, reading: &Reading, notes: &mut Vec<String>) -> Raster {
    let (width, height) = (light.width, light.height);
    let turn = Turn::by(reading.rotate);
    let aspect = reading.aspect.unwrap_or(1.0);
    // As the drawing lies before it is turned.
    let field = Field { aspect: if turn.swaps_sides() { 1.0 / aspect } else { aspect }, fit: reading.fit };
    if field.around(width, height) != (width, height) {
        let what = if aspect == 1.0 { "a square" } else { "the field's proportions" };
        notes.push(match reading.fit {
            PictureFit::Pad => format!("The picture is {width} x {height}: it was padded with black to {what}."),
            PictureFit::Crop => format!("The picture is {width} x {height}: it was cropped to {what}."),
            PictureFit::Stretch => format!("The picture is {width} x {height}: it was stretched to {what}."),
        });
    }
    let light = field.bounded(light);
    // Stretched first: turning by an odd angle and stretching after would shear the drawing.
    let light = if reading.fit == PictureFit::Stretch { field.stretched(light) } else { light };
    let total = light.sum();
    let field = Field { aspect, ..field };
    let (light, kept) = match turn {
        Turn::Quarters(quarters) => {
            let light = quarter_turned(light, quarters);
            let (across, up) = field.around(light.width, light.height);
            let light = about_middle(light, across, up);
            let kept = light.sum();
            (light, kept)
        }
        Turn::Angle(angle) => turned(&light, angle, field),
    };
    let lost = 1.0 - kept / total;
    if lost > NEGLIGIBLE {
        notes.push(format!("{:.1} % of its light fell outside the field and was cut off.", 100.0 * lost));
    }
    let side = light.width.max(light.height);
    let mut light = about_middle(light, side, side);
    if reading.mirrored {
        light.values.chunks_exact_mut(light.width).for_each(<[f64]>::reverse);
    }
    light
}

/// The field and how a picture fills it.
#[derive(Clone, Copy)]
struct Field {
    /// Height over width.
    aspect: f64,
    fit: PictureFit,
}

impl Field {
    /// Columns and rows of the field, in pixels of a picture of `width` x `height`.
    fn around(self, width: usize, height: usize) -> (usize, usize) {
        let pixels = |length: f64| (length.round() as usize).max(1);
        let (w, h) = (width as f64, height as f64);
        // Whether the field is as wide as the picture, or else as high.
        let as_wide = (h <= self.aspect * w) != (self.fit == PictureFit::Crop);
        if as_wide { (width, pixels(self.aspect * w)) } else { (pixels(h / self.aspect), height) }
    }

    /// A picture of fewer pixels, where the field about it would have many more than the picture's own sides.
    fn bounded(self, light: Raster) -> Raster {
        let (across, up) = self.around(light.width, light.height);
        let most = light.width.max(light.height).max(ENOUGH) as f64;
        let shrunk = most / across.max(up) as f64;
        if shrunk >= 1.0 {
            return light;
        }
        let [width, height] = [light.width, light.height].map(|n| ((n as f64 * shrunk).round() as usize).max(1));
        resampled(light, width, height)
    }

    fn stretched(self, light: Raster) -> Raster {
        let (width, height) = self.around(light.width, light.height);
        resampled(light, width, height)
    }
}

#[derive(Clone, Copy)]
enum Turn {
    /// Quarter turns counter-clockwise, 0 to 3.
    Quarters(usize),
    /// Radians counter-clockwise.
    Angle(f64),
}

impl Turn {
    fn by(degrees: f64) -> Self {
        let degrees = degrees.rem_euclid(360.0);
        let quarters = (degrees / 90.0).round();
        if (degrees - 90.0 * quarters).abs() < 1e-9 {
            Self::Quarters(quarters as usize % 4)
        } else {
            Self::Angle(degrees.to_radians())
        }
    }

    /// Whether width becomes height.
    fn swaps_sides(self) -> bool {
        matches!(self, Self::Quarters(1 | 3))
    }
}

/// By areas; scaled so that a plain area keeps its brightness.
fn resampled(light: Raster, width: usize, height: usize) -> Raster {
    if (light.width, light.height) == (width, height) {
        return light;
    }
    let grown = (width * height) as f64 / (light.width * light.height) as f64;
    light.resampled(width, height).scaled(grown)
}

fn quarter_turned(light: Raster, quarters: usize) -> Raster {
    let (w, h) = (light.width, light.height);
    match quarters {
        0 => light,
        // The upper right corner comes to the upper left.
        1 => Raster::from_fn(h, w, |x, y| light.at(w - 1 - y, x)),
        2 => Raster::from_fn(w, h, |x, y| light.at(w - 1 - x, h - 1 - y)),
        _ => Raster::from_fn(h, w, |x, y| light.at(y, h - 1 - x)),
    }
}

/// `width` x `height` pixels about the middle, black where the picture does not reach. Where bars or cuts cannot be equal,
/// the right or the lower one is a pixel wider.
fn about_middle(light: Raster, width: usize, height: usize) -> Raster {
    let (w, h) = (light.width, light.height);
    if (w, h) == (width, height) {
        return light;
    }
    // Where column `x` of `to` columns lies among the picture's `from`.
    let at = |x: usize, from: usize, to: usize| match to.checked_sub(from) {
        Some(bars) => x.checked_sub(bars / 2).filter(|x| *x < from),
        None => Some(x + (from - to) / 2),
    };
    Raster::from_fn(width, height, |x, y| match (at(x, w, width), at(y, h, height)) {
        (Some(x), Some(y)) => light.at(x, y),
        _ => 0.0,
    })
}

/// Turned about its middle by `angle` and cut to the field; also the light that stays inside.
fn turned(light: &Raster, angle: f64, field: Field) -> (Raster, f64) {
    let (across, up) = field.around(light.width, light.height);
    let (sine, cosine) = angle.sin_cos();
    let (w, h) = (light.width as f64, light.height as f64);
    let [half_across, half_up] = [across, up].map(|n| n as f64 / 2.0);
    let mut out = Raster::zeros(across, up);
    out.values.par_chunks_mut(across).enumerate().for_each(|(row, line)| {
        // Coordinates from the middle, y up.
        let y = half_up - (row as f64 + 0.5);
        for (column, value) in line.iter_mut().enumerate() {
            let x = column as f64 + 0.5 - half_across;
            // Light now at (x, y) came from there turned back.
            let (from_x, from_y) = (x * cosine + y * sine, y * cosine - x * sine);
            *value = bilinear(light, from_x + w / 2.0 - 0.5, h / 2.0 - from_y - 0.5);
        }
    });
    let mut kept = 0.0;
    for row in 0..light.height {
        let y = h / 2.0 - (row as f64 + 0.5);
        for column in 0..light.width {
            let x = column as f64 + 0.5 - w / 2.0;
            let (to_x, to_y) = (x * cosine - y * sine, x * sine + y * cosine);
            if to_x.abs() <= half_across && to_y.abs() <= half_up {
                kept += light.at(column, row);
            }
        }
    }
    (out, kept)
}

/// Between the four nearest pixel centres, pixel (0, 0) having its centre at (0, 0); black outside.
fn bilinear(light: &Raster, x: f64, y: f64) -> f64 {
    let (left, top) = (x.floor(), y.floor());
    let (right, low) = (x - left, y - top);
    let pixel = |column: f64, row: f64| {
        let inside = column >= 0.0 && row >= 0.0 && column < light.width as f64 && row < light.height as f64;
        if inside { light.at(column as usize, row as usize) } else { 0.0 }
    };
    let upper = pixel(left, top) * (1.0 - right) + pixel(left + 1.0, top) * right;
    let lower = pixel(left, top + 1.0) * (1.0 - right) + pixel(left + 1.0, top + 1.0) * right;
    upper * (1.0 - low) + lower * low
}

#[cfg(test)]
mod tests {
    use super::super::{PLAIN, Picture, from_raster};
    use super::*;

    fn read(light: &Raster, reading: Reading) -> Picture {
        from_raster(light.clone(), &reading).unwrap()
    }

    fn numbered(width: usize, height: usize) -> Raster {
        Raster::from_fn(width, height, |x, y| (1 + x + y * width) as f64)
    }

    /// A soft spot at (x, y) from the middle, y up, in pixels.
    fn spot(n: usize, at: (f64, f64)) -> Raster {
        let half = n as f64 / 2.0;
        Raster::from_fn(n, n, |c, r| {
            let (x, y) = (c as f64 + 0.5 - half - at.0, half - r as f64 - 0.5 - at.1);
            (-(x * x + y * y) / 18.0).exp()
        })
    }

    /// Centre of light from the middle, y up.
    fn centre(light: &Raster) -> (f64, f64) {
        let half = light.width as f64 / 2.0;
        let (mut x, mut y) = (0.0, 0.0);
        for row in 0..light.height {
            for column in 0..light.width {
                x += light.at(column, row) * (column as f64 + 0.5 - half);
                y += light.at(column, row) * (half - row as f64 - 0.5);
            }
        }
        (x / light.sum(), y / light.sum())
    }

    #[test]
    fn a_plain_square_keeps_every_bit() {
        let light = Raster::from_fn(7, 7, |x, y| 1.0 / (1 + x + 7 * y) as f64);
        for fit in [PictureFit::Pad, PictureFit::Crop, PictureFit::Stretch] {
            for rotate in [0.0, 360.0, -720.0] {
                let picture = read(&light, Reading { fit, rotate, ..PLAIN });
                assert_eq!(picture.light, light);
                assert_eq!(picture.original_size, (7, 7));
            }
        }
    }

    #[test]
    fn quarter_turns_are_exact_and_counter_clockwise() {
        let light = Raster { width: 2, height: 2, values: vec![1.0, 2.0, 3.0, 4.0] };
        for (rotate, expected) in [
            (90.0, [2.0, 4.0, 1.0, 3.0]),
            (180.0, [4.0, 3.0, 2.0, 1.0]),
            (270.0, [3.0, 1.0, 4.0, 2.0]),
            (-90.0, [3.0, 1.0, 4.0, 2.0]),
            (450.0, [2.0, 4.0, 1.0, 3.0]),
        ] {
            assert_eq!(read(&light, Reading { rotate, ..PLAIN }).light.values, expected, "{rotate}");
        }
        let wide = numbered(3, 2);
        let turned = quarter_turned(wide.clone(), 1);
        assert_eq!((turned.width, turned.height), (2, 3));
        assert_eq!(turned.values, [3.0, 6.0, 2.0, 5.0, 1.0, 4.0]);
        assert_eq!(quarter_turned(turned, 3), wide);
    }

    #[test]
    fn a_planted_spot_turns_counter_clockwise_and_keeps_its_light() {
        let light = spot(64, (15.0, 0.0));
        for degrees in [10.0f64, 45.0, 133.0, -60.0] {
            let picture = read(&light, Reading { rotate: degrees, ..PLAIN });
            let (x, y) = centre(&picture.light);
            let (ex, ey) = (15.0 * degrees.to_radians().cos(), 15.0 * degrees.to_radians().sin());
            assert!((x - ex).hypot(y - ey) < 0.05, "{degrees}: {x} {y}");
            assert!((picture.light.sum() / light.sum() - 1.0).abs() < 1e-3, "{degrees}");
            assert!(picture.notes.is_empty());
        }
    }

    #[test]
    fn turning_back_to_the_start_keeps_the_light() {
        let start = spot(48, (9.0, 4.0));
        for steps in [5, 7, 8, 12] {
            let rotate = 360.0 / f64::from(steps);
            let mut light = start.clone();
            for _ in 0..steps {
                light = read(&light, Reading { rotate, ..PLAIN }).light;
            }
            // Bilinear sampling of this spot gains or loses about 1e-4 a turn, most at 45°.
            assert!((light.sum() / start.sum() - 1.0).abs() < 3e-3, "{steps}");
            let ((x, y), (ex, ey)) = (centre(&light), centre(&start));
            assert!((x - ex).hypot(y - ey) < 0.05, "{steps}");
        }
    }

    #[test]
    fn corners_that_leave_the_field_are_noted() {
        let full = Raster::from_fn(100, 100, |_, _| 1.0);
        let picture = read(&full, Reading { rotate: 45.0, ..PLAIN });
        // A square and itself turned by 45° share 2(√2 - 1) of their area.
        let kept = 2.0 * (2f64.sqrt() - 1.0);
        assert!((picture.light.sum() / 1e4 - kept).abs() < 0.01);
        let note = picture.notes.last().unwrap();
        let told: f64 = note.split(' ').next().unwrap().parse().unwrap();
        assert!((told - 100.0 * (1.0 - kept)).abs() < 0.5, "{note}");
        assert!(note.contains("outside the field"));
    }

    #[test]
    fn padding_adds_black_and_nothing_else() {
        let picture = read(&numbered(3, 2), PLAIN);
        assert_eq!(picture.light.values, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.0, 0.0, 0.0]);
        assert_eq!(picture.original_size, (3, 2));
        assert!(picture.notes[0].contains("3 x 2"));
        let tall = read(&numbered(2, 4), PLAIN).light;
        assert_eq!(tall.values[..8], [0.0, 1.0, 2.0, 0.0, 0.0, 3.0, 4.0, 0.0]);
        let upright = read(&numbered(2, 4), Reading { rotate: 90.0, ..PLAIN }).light;
        assert_eq!(upright.values[4..12], [2.0, 4.0, 6.0, 8.0, 1.0, 3.0, 5.0, 7.0]);
    }

    #[test]
    fn cropping_keeps_the_middle_and_notes_the_rest() {
        let crop = Reading { fit: PictureFit::Crop, ..PLAIN };
        let picture = read(&numbered(4, 2), crop);
        assert_eq!(picture.light.values, [2.0, 3.0, 6.0, 7.0]);
        assert!(picture.notes.iter().any(|n| n.starts_with("50.0 %")), "{:?}", picture.notes);
        // Turned, the field is filled from what a crop alone would have cut: no black corners.
        let wide = Raster::from_fn(300, 100, |_, _| 1.0);
        let turned = read(&wide, Reading { rotate: 20.0, ..crop }).light;
        assert_eq!(turned.width, 100);
        assert!(turned.at(99, 50) > 0.999 && turned.at(0, 50) > 0.999);
        let rim = Raster::from_fn(4, 2, |x, _| if x == 0 { 1.0 } else { 0.0 });
        assert!(from_raster(rim, &crop).unwrap_err().to_string().contains("cut off"));
    }

    #[test]
    fn stretching_keeps_brightness_and_proportions_of_light() {
        let stretch = Reading { fit: PictureFit::Stretch, ..PLAIN };
        let flat = read(&Raster::from_fn(6, 4, |_, _| 0.7), stretch).light;
        assert!(flat.width == 6 && flat.height == 6 && flat.values.iter().all(|v| (v - 0.7).abs() < 1e-12));
        let doubled = read(&numbered(4, 2), stretch).light;
        assert_eq!(doubled.values[..8], [1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn a_field_of_other_proportions_is_filled_and_the_rest_of_its_square_is_black() {
        let wide = Reading { aspect: Some(0.5), ..PLAIN };
        // A picture of the field's own proportions loses and gains nothing.
        let picture = read(&numbered(4, 2), wide);
        assert_eq!(picture.light.values[4..12], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        assert!(picture.light.sum() == 36.0 && picture.notes.is_empty());
        // A square is padded to the right and left, cropped above and below, or stretched.
        let plain = Raster::from_fn(40, 40, |_, _| 1.0);
        for (fit, [across, up]) in
            [(PictureFit::Pad, [40, 40]), (PictureFit::Crop, [40, 20]), (PictureFit::Stretch, [80, 40])]
        {
            for rotate in [0.0, 90.0] {
                let light = read(&plain, Reading { fit, rotate, ..wide }).light;
                let [width, height] = [light.width, light.height];
                assert_eq!((width, height), if fit == PictureFit::Crop { (40, 40) } else { (80, 80) });
                let lit = |x: usize, y: usize| light.at(x, y) > 0.999;
                let columns = (0..width).filter(|x| lit(*x, height / 2)).count();
                let rows = (0..height).filter(|y| lit(width / 2, *y)).count();
                assert_eq!([columns, rows], [across, up], "{fit:?} {rotate}");
                assert_eq!(light.sum().round() as usize, across * up);
            }
        }
        // Turned by an odd angle, a drawing that is small stays whole.
        let spot = spot(64, (9.0, 0.0));
        let turned = read(&spot, Reading { rotate: 30.0, ..wide }).light;
        let (x, y) = centre(&turned);
        assert!((x - 9.0 * 0.75f64.sqrt()).abs() < 0.05 && (y - 4.5).abs() < 0.05, "{x} {y}");
        // A field far longer than the picture takes no more pixels than a picture of usual size would.
        let long = read(&Raster::from_fn(1000, 1000, |_, _| 1.0), Reading { aspect: Some(0.1), ..PLAIN }).light;
        assert_eq!((long.width, long.height), (2050, 2050));
    }

    #[test]
    fn mirroring_flips_left_and_right_after_turning() {
        let light = numbered(3, 3);
        let mirrored = read(&light, Reading { mirrored: true, ..PLAIN }).light;
        assert_eq!(mirrored.values, [3.0, 2.0, 1.0, 6.0, 5.0, 4.0, 9.0, 8.0, 7.0]);
        for rotate in [90.0, 30.0] {
            let both = read(&light, Reading { mirrored: true, rotate, ..PLAIN }).light;
            let turned = read(&light, Reading { rotate, ..PLAIN }).light;
            assert_eq!(both, read(&turned, Reading { mirrored: true, ..PLAIN }).light);
        }
    }
}
