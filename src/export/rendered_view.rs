//! Pages for what a camera sees of the plate, for the reflection on a wall, for a highlight and for slopes, with exposure and
//! scale.

use image::{GrayImage, Luma, Rgb, RgbImage};

use super::axes::{self, Place};
use super::comparison::{enlarged, panel_side};
use super::lettering::Style;
use super::page::{LINE, NOTE, Page, TEXT, Unit, pixel};
use super::pixels::{common_white, tone_mapped};
use super::ticks::number;
use crate::projection::View;
use crate::raster::Raster;
use crate::verify::render::{RenderedView, Shape, ViewSettings};
use crate::verify::wall::{WallImage, WallSettings};

/// How such a page is made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exposure {
    /// What is shown white, in the picture's own unit; by itself what 99.5 % of its lit pixels stay below.
    pub white: Option<f64>,
    /// Turned left for right: a wall as it looks from where the plate is.
    pub mirrored: bool,
    /// A line over the picture, if not empty.
    pub heading: String,
}

impl Exposure {
    fn white(&self, raster: &Raster) -> f64 {
        let given = self.white.filter(|white| *white > 0.0 && white.is_finite());
        given.unwrap_or_else(|| [common_white(raster), 1.0].into_iter().find(|w| *w > 0.0).unwrap_or(1.0))
    }

    fn turned(&self, raster: &Raster) -> Raster {
        if !self.mirrored {
            return raster.clone();
        }
        Raster::from_fn(raster.width, raster.height, |x, y| raster.at(raster.width - 1 - x, y))
    }
}

/// The camera's picture with its exposure; few pixels are shown as whole blocks.
pub fn view_page(view: &RenderedView, settings: &ViewSettings, exposure: &Exposure) -> RgbImage {
    let raster = exposure.turned(&view.radiance);
    let white = exposure.white(&raster);
    let times = 384usize.div_ceil(raster.width.max(raster.height).max(1)).max(1) as u32;
    let grey = tone_mapped(&raster, white);
    let grey =
        GrayImage::from_fn(grey.width() * times, grey.height() * times, |x, y| *grey.get_pixel(x / times, y / times));
    let what = match settings.shape {
        Shape::Flat => "plate".to_owned(),
        Shape::Sphere { radius } => format!("ball of radius {} mm", number(radius)),
        Shape::Cylinder { radius } => format!("cylinder of radius {} mm", number(radius)),
    };
    let [theta, phi, away, across] =
        [settings.theta, settings.phi, settings.distance, settings.field_of_view].map(number);
    let notes = [
        format!(
            "{what} from {away} mm at {theta}°, {phi}° · {across}° across · surroundings {}/sr",
            digits(settings.ambient)
        ),
        format!("white is {}/sr under a lamp of irradiance 1 · sRGB, no other curve", digits(white)),
    ];
    Framed::new(&grey, &exposure.heading, &notes, false).page.image
}

/// The wall's picture with a scale in mm along its edges, its exposure, and what the distances blur.
pub fn wall_page(wall: &WallImage, settings: &WallSettings, exposure: &Exposure) -> RgbImage {
    let raster = exposure.turned(&wall.irradiance());
    let white = exposure.white(&raster);
    let grey = tone_mapped(&enlarged(&raster, panel_side(raster.width)), white);
    let lamp = if wall.lamp_distance.is_finite() {
        format!("lamp of radius {} mm at {} mm", number(wall.lamp_radius), number(wall.lamp_distance))
    } else {
        "distant lamp".to_owned()
    };
    let away = number(settings.wall_distance);
    let tilt =
        if settings.wall_tilt == 0.0 { String::new() } else { format!(" tilted by {}°", number(settings.wall_tilt)) };
    let blur = &wall.blur;
    let [pu, pv, lu, lv] = [blur.plate.x, blur.plate.y, blur.lamp.x, blur.lamp.y].map(digits);
    let [a, b] = [blur.plate_angle.max_element(), blur.lamp_angle].map(|angle| digits(angle.to_degrees()));
    let [(landed, error), ..] = wall.shares();
    let side = if exposure.mirrored { "seen from the plate" } else { "as the highlight image" };
    let notes = [
        format!("wall at {away} mm{tilt}, {side} · {lamp} · scale in mm"),
        format!("blurred by the plate over {pu} × {pv} mm ({a}°) · by the lamp over {lu} × {lv} mm ({b}°)"),
        format!(
            "white is {} × the irradiance on the plate · {:.2} ± {:.2} % of its light lands here",
            digits(white),
            100.0 * landed,
            100.0 * error
        ),
    ];
    let mut framed = Framed::new(&grey, &exposure.heading, &notes, true);
    framed.scales(wall.half_width, exposure.mirrored);
    framed.page.image
}

/// A highlight, shares of light per pixel laid out by `view`, with a scale in degrees and its exposure.
pub fn highlight_page(image: &Raster, view: &View, exposure: &Exposure) -> RgbImage {
    let raster = exposure.turned(image);
    let white = exposure.white(&raster);
    let grey = tone_mapped(&enlarged(&raster, panel_side(raster.width)), white);
    let pixels = (raster.width * raster.height).max(1) as f64;
    let notes = [
        "degrees from the mirror direction, seen from above the plate: x right, y up".to_owned(),
        format!(
            "white is {} × the light of a pixel if all were lit alike · sRGB, no other curve",
            digits(white * pixels)
        ),
    ];
    let mut framed = Framed::new(&grey, &exposure.heading, &notes, true);
    let (unit, place) = (framed.unit, framed.place());
    axes::degrees(&mut framed.page, unit, place, view, true);
    framed.page.image
}

/// The density of slopes, from -`rim` to `rim` along x and y, with a scale of slopes and its exposure.
pub fn slopes_page(density: &Raster, rim: f64, exposure: &Exposure) -> RgbImage {
    let white = exposure.white(density);
    let grey = tone_mapped(&enlarged(density, panel_side(density.width)), white);
    let notes = [
        format!("slope of the surface along x (right) and y (up) · the rim is {}°", digits(rim.atan().to_degrees())),
        format!("white is a density of {} per unit of slope squared · sRGB, no other curve", digits(white)),
    ];
    let mut framed = Framed::new(&grey, &exposure.heading, &notes, true);
    framed.scales(rim, false);
    framed.page.image
}

/// Three digits, however large or small.
fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() {
        return if size == 0.0 { "0".into() } else { "∞".into() };
    }
    let decade = size.log10().floor();
    match decade as i32 {
        -3..=5 => {
            let step = 10f64.powf(decade - 2.0);
            let rounded = (value / step).round() * step;
            if decade >= -1.0 {
                return number(rounded);
            }
            format!("{rounded:.*}", (2.0 - decade) as usize).trim_end_matches('0').to_owned()
        }
        _ => format!("{value:.2e}"),
    }
}

/// A grey picture on its page: heading above, notes below, room for scales where there are any.
struct Framed {
    page: Page,
    /// The picture's upper left pixel on the page, and its size.
    left: i64,
    top: i64,
    width: i64,
    height: i64,
    unit: Unit,
}

impl Framed {
    fn new(grey: &GrayImage, heading: &str, notes: &[String], scaled: bool) -> Self {
        let (width, height) = (i64::from(grey.width()), i64::from(grey.height()));
        let unit = Unit((width.max(height) as f64 / 512.0).max(0.75));
        let px = |length| unit.px(length);
        let top = px(if heading.is_empty() { 28.0 } else { 62.0 });
        let left = px(if scaled { 92.0 } else { 28.0 });
        let below = top + height + px(if scaled { 76.0 } else { 38.0 });
        let total = (left + width + px(34.0)).max(px(620.0));
        let mut page = Page::new(total, below + notes.len() as i64 * px(26.0));
        page.put(grey, (left, top), |Luma([value])| Rgb([value; 3]));
        page.frame([left, top, width, height], unit.hair(), LINE);
        let mut framed = Self { page, left, top, width, height, unit };
        framed.write(heading, top - px(18.0), unit.left(26.0, TEXT));
        for (k, note) in notes.iter().enumerate() {
            framed.write(note, below + k as i64 * px(26.0), unit.left(17.0, NOTE));
        }
        framed
    }

    fn px(&self, length: f64) -> i64 {
        self.unit.px(length)
    }

    /// A line of text with its baseline at `y`, from margin to margin at the most.
    fn write(&mut self, text: &str, y: i64, style: Style) {
        let left = self.px(28.0);
        let room = i64::from(self.page.image.width()) - 2 * left + self.px(14.0);
        self.page.write_fitted(text, pixel(left, y), style, room as f32);
    }

    /// Where the picture stands.
    fn place(&self) -> Place {
        Place { left: self.left, top: self.top, width: self.width, height: self.height }
    }

    /// Ticks along the lower and the left edge, 0 in the middle; `mirrored` counts u from right to left.
    fn scales(&mut self, half_width: f64, mirrored: bool) {
        let (unit, place) = (self.unit, self.place());
        let label = |at: f64| if at.abs() < 1e6 { number(at) } else { digits(at) };
        axes::linear(&mut self.page, unit, place, (half_width, mirrored), label);
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::export::page::PAGE;
    use crate::verify::tally::{Measurement, Tally};
    use crate::verify::wall::WallBlur;

    fn thrown(n: usize, half_width: f64) -> WallImage {
        let mut part = Tally::empty((n, n));
        part.incident = 1.0;
        part.up_single = 1.0;
        part.image.values[0] = 1.0;
        let measurement = Measurement::of_parts(vec![part; 16]).unwrap();
        let blur =
            WallBlur { plate: DVec2::splat(30.0), lamp: DVec2::ZERO, plate_angle: DVec2::splat(0.03), lamp_angle: 0.0 };
        WallImage { measurement, blur, half_width, lamp_distance: f64::INFINITY, lamp_radius: 0.0 }
    }

    #[test]
    fn nothing_is_cut_off_at_any_size_and_mirroring_turns_left_to_right() {
        let throw = WallSettings::default();
        for half_width in [1e-3, 0.3, 25.0, 500.0, 1e9] {
            for (n, heading) in [
                (1, ""),
                (16, "A heading that is much too long for a page of this width ".repeat(4).as_str()),
                (300, "Wall"),
            ] {
                let exposure = Exposure { heading: heading.to_owned(), ..Exposure::default() };
                let page = wall_page(&thrown(n, half_width), &throw, &exposure);
                let (w, h) = page.dimensions();
                let edge = |x, y| x == 0 || y == 0 || x == w - 1 || y == h - 1;
                assert!(page.enumerate_pixels().all(|(x, y, p)| *p == PAGE || !edge(x, y)), "{half_width} {n}");
            }
        }
        let shown = |mirrored| wall_page(&thrown(16, 500.0), &throw, &Exposure { mirrored, ..Exposure::default() });
        let (plain, turned) = (shown(false), shown(true));
        // 384 pixels from (69, 21) on at this size: the lit pixel is the upper left one of 16².
        let (left, top) = (69, 21);
        assert_eq!(plain.get_pixel(left + 5, top + 5), &Rgb([255; 3]));
        assert_eq!(plain.get_pixel(left + 379, top + 5), &Rgb([0; 3]));
        assert_eq!(turned.get_pixel(left + 379, top + 5), &Rgb([255; 3]));
        assert_eq!(turned.get_pixel(left + 5, top + 5), &Rgb([0; 3]));
    }

    #[test]
    fn the_stated_white_is_what_is_shown_white() {
        let raster = Raster::from_fn(20, 10, |x, _| x as f64);
        let view = RenderedView { errors: raster.clone(), trapped: raster.clone(), radiance: raster };
        let look = ViewSettings { size: [20, 10], ..ViewSettings::default() };
        let exposure = Exposure { white: Some(10.0), ..Exposure::default() };
        let page = view_page(&view, &look, &exposure);
        // Twenty pixels of 20 become 400; the margin is 28 · 400/512.
        let at = |column: u32| page.get_pixel(22 + 20 * column + 10, 22 + 100).0[0];
        assert!(at(10) == 255 && at(19) == 255 && at(9) < 255 && at(9) > 230 && at(0) == 0);
        for white in [Some(0.0), Some(f64::NAN), None] {
            let page = view_page(&view, &look, &Exposure { white, ..Exposure::default() });
            assert_eq!(page.get_pixel(22 + 20 * 19 + 10, 122).0[0], 255);
        }
        let black =
            RenderedView { radiance: Raster::zeros(1, 1), errors: Raster::zeros(1, 1), trapped: Raster::zeros(1, 1) };
        assert!(view_page(&black, &look, &Exposure::default()).width() > 384);
    }

    #[test]
    fn digits_are_three() {
        let cases = [0.0, 0.05, 0.004_567, 0.0123, 0.5, 12.345, 1234.5, 1e9, 2e-7, f64::INFINITY];
        assert_eq!(
            cases.map(digits),
            ["0", "0.05", "0.00457", "0.0123", "0.5", "12.3", "1230", "1.00e9", "2.00e-7", "∞"]
        );
    }
}
