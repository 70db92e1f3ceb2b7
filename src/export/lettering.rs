//! Text on pictures: one light sans-serif face, antialiased, placed by its baseline.

use std::sync::LazyLock;

use ab_glyph_rasterizer::{Point, Rasterizer, point};
use image::{Rgb, RgbImage};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};

/// The face that comes with the program, so that pictures are the same on every machine. It has no table of kerning.
static FACE: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::new(epaint_default_fonts::UBUNTU_LIGHT).expect("the embedded font is a valid font"));

/// Which part of the text stands at the anchor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// The text begins there.
    Left,
    /// The text's middle.
    Centre,
    /// The text ends there.
    Right,
}

/// How text looks and lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Side of the em square, pixels; capitals are about 0.7 of it high.
    pub size: f32,
    /// Colour of the ink.
    pub colour: Rgb<u8>,
    /// Which part of the text stands at the anchor.
    pub align: Align,
}

/// Width of one line of text whose em is `size` pixels, pixels. Control characters, newlines too, take no room.
pub fn width(text: &str, size: f32) -> f32 {
    laid_out(text, size).last().map_or(0.0, |placed| placed.end)
}

/// Draws one line of text; `anchor` is the x named by the style's alignment and the y of the baseline, pixels.
///
/// What would fall outside the image is left off. Characters the face lacks show as its empty box.
pub fn draw(image: &mut RgbImage, text: &str, anchor: (f32, f32), style: Style) {
    let shift = match style.align {
        Align::Left => 0.0,
        Align::Centre => 0.5,
        Align::Right => 1.0,
    };
    let left = anchor.0 - shift * width(text, style.size);
    let (columns, rows) = (i64::from(image.width()), i64::from(image.height()));
    for placed in laid_out(text, style.size) {
        // Far outside there is nothing to draw, and the float of a position loses its fraction.
        if left + placed.end < -style.size || left + placed.start > columns as f32 + style.size {
            continue;
        }
        let origin = point(left + placed.start, anchor.1);
        let Some(outline) = Outline::of(placed.glyph, style.size, origin) else { continue };
        let (corner, raster) = outline.rasterised();
        raster.for_each_pixel_2d(|x, y, coverage| {
            let (x, y) = (corner.x as i64 + i64::from(x), corner.y as i64 + i64::from(y));
            if (0..columns).contains(&x) && (0..rows).contains(&y) {
                // A light face on white looks washed out at its true coverage: the edges get more ink.
                ink(image, x as u32, y as u32, style.colour, coverage.clamp(0.0, 1.0).powf(0.7));
            }
        });
    }
}

/// Text and size that fit into `room` pixels: shrunk to three quarters at most, then cut off with an ellipsis.
pub fn fitted(text: &str, size: f32, room: f32) -> (String, f32) {
    let wide = width(text, size);
    if wide <= room {
        return (text.to_owned(), size);
    }
    let size = size * (room / wide).max(0.75);
    // A hair of tolerance: shrinking exactly to the room must not count as too wide.
    if width(text, size) <= room * 1.001 {
        return (text.to_owned(), size);
    }
    let kept_room = room - width("…", size);
    let kept = laid_out(text, size).take_while(|placed| placed.end <= kept_room).last();
    let kept = kept.map_or("", |placed| &text[..placed.byte_end]).trim_end();
    (if kept.is_empty() { String::new() } else { format!("{kept}…") }, size)
}

/// One glyph on its line, which begins at 0.
struct Placed {
    glyph: GlyphId,
    start: f32,
    end: f32,
    byte_end: usize,
}

fn laid_out(text: &str, size: f32) -> impl Iterator<Item = Placed> {
    let signs = FACE.charmap();
    // In font units, so that nothing is rounded to a pixel grid.
    let metrics = FACE.glyph_metrics(Size::unscaled(), LocationRef::default());
    let scale = pixels_per_unit(size);
    let mut at = 0.0;
    text.char_indices().filter(|(_, c)| !c.is_control()).map(move |(byte, c)| {
        let glyph = signs.map(c).unwrap_or(GlyphId::NOTDEF);
        let start = at;
        at = start + scale * metrics.advance_width(glyph).unwrap_or(0.0);
        Placed { glyph, start, end: at, byte_end: byte + c.len_utf8() }
    })
}

/// Pixels per font unit where the em is `size` pixels.
fn pixels_per_unit(size: f32) -> f32 {
    let units_per_em = FACE.metrics(Size::unscaled(), LocationRef::default()).units_per_em;
    size / f32::from(units_per_em.max(1))
}

/// The closed curves of one glyph, pixels, y downwards. The font library moves it as a pen.
struct Outline {
    /// Where the glyph's own (0, 0) lies: the left end of its baseline.
    origin: Point,
    /// Pixels per font unit.
    scale: f32,
    curves: Vec<Curve>,
    /// Where the contour under way began, and where its pen stands.
    first: Point,
    last: Point,
}

/// A line, or a Bézier curve of the second or third degree, from its first point to its last.
enum Curve {
    Line([Point; 2]),
    Quad([Point; 3]),
    Cubic([Point; 4]),
}

impl Curve {
    fn points(&self) -> &[Point] {
        match self {
            Self::Line(points) => points,
            Self::Quad(points) => points,
            Self::Cubic(points) => points,
        }
    }
}

impl Outline {
    /// Of a glyph that begins at `origin`; nothing where it has no ink.
    fn of(glyph: GlyphId, size: f32, origin: Point) -> Option<Self> {
        let scale = pixels_per_unit(size);
        let mut outline = Self { origin, scale, curves: Vec::new(), first: origin, last: origin };
        let settings = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
        FACE.outline_glyphs().get(glyph)?.draw(settings, &mut outline).ok()?;
        (!outline.curves.is_empty()).then_some(outline)
    }

    /// Share of each pixel that the outline covers, and the pixel in which that raster begins.
    fn rasterised(&self) -> (Point, Rasterizer) {
        let points = || self.curves.iter().flat_map(Curve::points);
        let low = points().fold(point(f32::INFINITY, f32::INFINITY), |m, p| point(m.x.min(p.x), m.y.min(p.y)));
        let high = points().fold(point(f32::NEG_INFINITY, f32::NEG_INFINITY), |m, p| point(m.x.max(p.x), m.y.max(p.y)));
        let corner = point(low.x.floor(), low.y.floor());
        // Places that are not numbers leave a raster without pixels.
        let mut raster = Rasterizer::new((high.x.ceil() - corner.x) as usize, (high.y.ceil() - corner.y) as usize);
        for curve in &self.curves {
            match *curve {
                Curve::Line([a, b]) => raster.draw_line(a - corner, b - corner),
                Curve::Quad([a, b, c]) => raster.draw_quad(a - corner, b - corner, c - corner),
                Curve::Cubic([a, b, c, d]) => raster.draw_cubic(a - corner, b - corner, c - corner, d - corner),
            }
        }
        (corner, raster)
    }

    fn at(&self, x: f32, y: f32) -> Point {
        self.origin + point(self.scale * x, -self.scale * y)
    }
}

impl OutlinePen for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.first = self.at(x, y);
        self.last = self.first;
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let end = self.at(x, y);
        self.curves.push(Curve::Line([self.last, end]));
        self.last = end;
    }

    fn quad_to(&mut self, cx0: f32, cy0: f32, x: f32, y: f32) {
        let end = self.at(x, y);
        self.curves.push(Curve::Quad([self.last, self.at(cx0, cy0), end]));
        self.last = end;
    }

    fn curve_to(&mut self, cx0: f32, cy0: f32, cx1: f32, cy1: f32, x: f32, y: f32) {
        let end = self.at(x, y);
        self.curves.push(Curve::Cubic([self.last, self.at(cx0, cy0), self.at(cx1, cy1), end]));
        self.last = end;
    }

    fn close(&mut self) {
        self.curves.push(Curve::Line([self.last, self.first]));
        self.last = self.first;
    }
}

fn ink(image: &mut RgbImage, x: u32, y: u32, colour: Rgb<u8>, cover: f32) {
    let pixel = image.get_pixel_mut(x, y);
    for (under, over) in pixel.0.iter_mut().zip(colour.0) {
        *under = (f32::from(*under) + (f32::from(over) - f32::from(*under)) * cover).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INK: Rgb<u8> = Rgb([0; 3]);

    fn white(width: u32, height: u32) -> RgbImage {
        RgbImage::from_pixel(width, height, Rgb([255; 3]))
    }

    /// Columns that hold ink: first and last.
    fn extent(image: &RgbImage) -> Option<(u32, u32)> {
        let mut inked = image.enumerate_pixels().filter(|(_, _, p)| p.0 != [255; 3]).map(|(x, _, _)| x);
        let first = inked.next()?;
        Some(inked.fold((first, first), |(low, high), x| (low.min(x), high.max(x))))
    }

    #[test]
    fn text_lies_where_its_alignment_says_and_is_as_wide_as_measured() {
        let text = "Simulated −20° × 0.009";
        let wide = width(text, 24.0);
        assert!(wide > 150.0 && wide < 300.0, "{wide}");
        assert!((width(text, 48.0) - 2.0 * wide).abs() < 0.01 * wide);
        for (align, from) in [(Align::Left, 300.0), (Align::Centre, 300.0 - wide / 2.0), (Align::Right, 300.0 - wide)] {
            let mut image = white(600, 40);
            draw(&mut image, text, (300.0, 28.0), Style { size: 24.0, colour: INK, align });
            let (low, high) = extent(&image).unwrap();
            assert!((low as f32 - from).abs() < 4.0, "{align:?} {low} {from}");
            assert!((high as f32 - from - wide).abs() < 4.0, "{align:?} {high}");
        }
    }

    #[test]
    fn ink_is_dark_inside_soft_at_the_edges_and_above_the_baseline() {
        let mut image = white(60, 60);
        draw(&mut image, "H", (10.0, 45.0), Style { size: 50.0, colour: INK, align: Align::Left });
        assert!(image.pixels().any(|p| p.0 == [0; 3]));
        assert!(image.pixels().any(|p| p.0[0] > 20 && p.0[0] < 235));
        assert!(image.enumerate_pixels().all(|(_, y, p)| y <= 45 || p.0 == [255; 3]));
    }

    #[test]
    fn every_sign_the_pictures_use_is_in_the_face() {
        for sign in "°−×·±%…≤µσαωθΩé–,".chars() {
            assert!(FACE.charmap().map(sign).is_some(), "{sign}");
        }
    }

    #[test]
    fn fitting_shrinks_first_and_cuts_after() {
        let text = "a plate of 30 × 30 facets under a lamp at 30°";
        let wide = width(text, 20.0);
        assert_eq!(fitted(text, 20.0, wide + 1.0), (text.to_owned(), 20.0));
        let (whole, size) = fitted(text, 20.0, 0.9 * wide);
        assert_eq!(whole, text);
        assert!((size - 18.0).abs() < 0.1);
        let (cut, size) = fitted(text, 20.0, 0.4 * wide);
        assert!(cut.ends_with('…') && text.starts_with(cut.trim_end_matches('…')));
        assert!(width(&cut, size) <= 0.4 * wide);
        assert_eq!(fitted(text, 20.0, 3.0).0, "");
        assert_eq!(fitted("", 20.0, 3.0).0, "");
        assert!(width(&fitted(&"é".repeat(100_000), 20.0, 300.0).0, 15.0) <= 300.0);
    }

    #[test]
    fn nothing_panics_outside_or_with_odd_text() {
        let mut image = white(20, 20);
        for text in ["", "\n\t", "字🦀", "long text that leaves the image on both of its sides"] {
            for anchor in [(10.0, 10.0), (-500.0, -500.0), (500.0, 1e9), (f32::NAN, 5.0)] {
                draw(&mut image, text, anchor, Style { size: 18.0, colour: INK, align: Align::Centre });
            }
        }
        assert_eq!(width("", 18.0), 0.0);
        assert_eq!(width("a\nb", 18.0), width("ab", 18.0));
    }
}
