//! The white page that pictures with captions are drawn on: its colours, its unit of length, and what is drawn on it.

use glam::DVec2;
use image::{GenericImageView, Rgb, RgbImage};

use super::lettering::{self, Align, Style};
use super::stroke;

/// The page itself.
pub(super) const PAGE: Rgb<u8> = Rgb([255; 3]);
/// Headings, labels and captions.
pub(super) const TEXT: Rgb<u8> = Rgb([51; 3]);
/// Remarks on how a picture is to be read.
pub(super) const NOTE: Rgb<u8> = Rgb([105; 3]);
/// Frames, ticks and axes.
pub(super) const LINE: Rgb<u8> = Rgb([120; 3]);
/// The frame of a shaded plan, a little darker than the plan's own greys at its rim.
pub(super) const PLAN_LINE: Rgb<u8> = Rgb([110; 3]);
/// Grid lines of a diagram on the white page.
pub(super) const GRID: Rgb<u8> = Rgb([222; 3]);
/// Grid lines over a grey picture: bluish, so that they differ from its greys.
pub(super) const GRID_ON_GREY: Rgb<u8> = Rgb([96, 112, 140]);
/// Curves of a diagram, in their order; told apart in grey too.
pub(super) const CURVES: [Rgb<u8>; 9] = [
    Rgb([22, 64, 138]),
    Rgb([201, 76, 32]),
    Rgb([40, 140, 90]),
    Rgb([128, 62, 150]),
    Rgb([212, 150, 20]),
    Rgb([60, 160, 200]),
    Rgb([90, 90, 90]),
    Rgb([150, 40, 60]),
    Rgb([0, 0, 0]),
];
/// The dot that marks the lamp.
pub(super) const LAMP_DOT: Rgb<u8> = Rgb([242, 170, 40]);

/// Pixels to one unit of a layout, so that a page looks alike at every size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit(pub f64);

impl Unit {
    /// A length of the layout in whole pixels.
    pub fn px(self, length: f64) -> i64 {
        (length * self.0).round() as i64
    }

    /// The thinnest line, pixels.
    pub fn hair(self) -> i64 {
        self.px(1.0).max(1)
    }

    /// A size of text, pixels.
    pub fn size(self, size: f64) -> f32 {
        (size * self.0) as f32
    }

    /// A style of text; `size` in units of the layout.
    pub fn style(self, size: f64, colour: Rgb<u8>, align: Align) -> Style {
        Style { size: self.size(size), colour, align }
    }

    /// A style of text that begins at its place.
    pub fn left(self, size: f64, colour: Rgb<u8>) -> Style {
        self.style(size, colour, Align::Left)
    }
}

/// A whole pixel as a place for text.
pub(super) fn pixel(x: i64, y: i64) -> (f32, f32) {
    (x as f32, y as f32)
}

/// A page while it is drawn; places are pixels from its upper left corner, x right, y down. What lies outside is left off.
pub(super) struct Page {
    /// The page as a picture.
    pub image: RgbImage,
}

impl Page {
    /// An empty page.
    pub fn new(width: i64, height: i64) -> Self {
        Self { image: RgbImage::from_pixel(width as u32, height as u32, PAGE) }
    }

    /// Puts `picture` on the page, its upper left pixel at `corner`, each pixel in the `colour` of what it holds.
    pub fn put<I: GenericImageView>(&mut self, picture: &I, corner: (i64, i64), colour: impl Fn(I::Pixel) -> Rgb<u8>) {
        for (x, y, pixel) in picture.pixels() {
            self.image.put_pixel(corner.0 as u32 + x, corner.1 as u32 + y, colour(pixel));
        }
    }

    /// Fills the rectangle `[x, y, width, height]`.
    pub(crate) fn fill(&mut self, [x, y, width, height]: [i64; 4], colour: Rgb<u8>) {
        let clip = |from: i64, length: i64, limit: u32| {
            from.clamp(0, i64::from(limit)) as u32..(from + length).clamp(0, i64::from(limit)) as u32
        };
        let columns = clip(x, width, self.image.width());
        for row in clip(y, height, self.image.height()) {
            for column in columns.clone() {
                self.image.put_pixel(column, row, colour);
            }
        }
    }

    /// Draws a frame `thick` pixels wide just outside the rectangle `[x, y, width, height]`.
    pub fn frame(&mut self, [x, y, width, height]: [i64; 4], thick: i64, colour: Rgb<u8>) {
        self.fill([x - thick, y - thick, width + 2 * thick, thick], colour);
        self.fill([x - thick, y + height, width + 2 * thick, thick], colour);
        self.fill([x - thick, y, thick, height], colour);
        self.fill([x + width, y, thick, height], colour);
    }

    /// Draws a line through `points`, `wide` pixels across; see [`stroke::stroke`].
    pub(crate) fn stroke(&mut self, points: &[DVec2], wide: f64, colour: Rgb<u8>) {
        stroke::stroke(&mut self.image, points, wide, colour);
    }

    /// Writes one line of text; `at` is the x that the style's alignment names, and the y of the baseline.
    pub fn write(&mut self, text: &str, at: (f32, f32), style: Style) {
        lettering::draw(&mut self.image, text, at, style);
    }

    /// The same within `room` pixels: what is too long is set smaller, then cut off.
    pub(crate) fn write_fitted(&mut self, text: &str, at: (f32, f32), style: Style, room: f32) {
        let (text, size) = lettering::fitted(text, style.size, room);
        self.write(&text, at, Style { size, ..style });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filling_and_framing_stay_inside_and_cover_their_area() {
        let mut page = Page::new(4, 4);
        page.fill([-2, 3, 4, 100], Rgb([9; 3]));
        assert_eq!(page.image.pixels().filter(|p| p.0 == [9; 3]).count(), 2);
        page.fill([7, 7, 3, -3], Rgb([1; 3]));
        page.frame([1, 1, 2, 2], 1, Rgb([5; 3]));
        assert_eq!(page.image.pixels().filter(|p| p.0 == [5; 3]).count(), 12);
    }

    #[test]
    fn a_layout_is_scaled_by_its_unit() {
        assert_eq!([Unit(1.5).px(3.0), Unit(1.5).hair(), Unit(0.2).hair()], [5, 2, 1]);
        assert_eq!(Unit(2.0).left(9.0, TEXT).size, 18.0);
    }
}
