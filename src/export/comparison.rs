//! Target, simulation and their difference side by side, sharp and blurred, with scales, for reports and talks.

use glam::DVec2;
use image::{Rgb, RgbImage};

use super::axes::{self, Place};
use super::lettering::Align;
use super::page::{LINE, NOTE, PAGE, Page, TEXT, Unit, pixel};
use super::pixels::{common_white, diverging, tone_mapped};
use super::ticks::{self, number, round_below};
use crate::projection::View;
use crate::raster::Raster;

/// Ends of the difference scale, shares of white: the smallest that holds nearly all of the difference is taken.
const LIMITS: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];

/// What is to be compared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ComparisonPage<'a> {
    /// What stands below each other: the same highlight sharp and blurred, for instance. At least one is shown.
    pub rows: &'a [Comparison],
    /// The view all images cover, u and v from -1 to 1.
    pub view: &'a View,
    /// From the middle of the images to their rim, mm, if they are seen on a wall: scales are then in mm, 0 in the middle.
    pub on_wall: Option<f64>,
    /// Over all; empty to do without.
    pub heading: &'a str,
    /// Facts of the plate, at the bottom; may have several lines.
    pub footer: &'a str,
}

/// One row of a [`ComparisonPage`]: a target, a simulation, and their difference. Words may be empty; what is too long is
/// set smaller, then cut off.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Comparison {
    /// The wanted highlight, flux per pixel.
    pub target: Raster,
    /// What the plate gives, flux per pixel in the same unit; resampled to the target's size if it has another.
    pub simulated: Raster,
    /// Over each panel.
    pub titles: [String; 3],
    /// Under each panel, such as "TV(1°) 0.009".
    pub numbers: [String; 3],
}

impl ComparisonPage<'_> {
    /// Draws the comparison; panels are 384 to 768 pixels wide, a whole multiple or part of the first target's own pixels.
    ///
    /// Target and simulation of a row share one white, see [`common_white`]. The difference is simulated minus target in
    /// percent of that white: red where the simulation is brighter, blue where it is darker, white where they agree.
    pub fn picture(&self) -> RgbImage {
        let size = self.rows.first().map_or(0, |row| row.target.width.max(row.target.height));
        let footer: Vec<&str> = self.footer.lines().collect();
        let layout = Layout::new(panel_side(size), self.rows.len(), !self.heading.is_empty(), footer.len());
        let mut page = Page::new(layout.width, layout.height);
        for (k, row) in self.rows.iter().enumerate() {
            layout.row(k).draw(&mut page, row, self.view, self.on_wall);
        }
        let axes = self.on_wall.map_or("degrees from the mirror direction", |_| "mm on the wall");
        let note = format!("Axes: {axes} · difference: simulated − target, in % of white");
        layout.page_words(&mut page, self.heading, &footer, &note);
        page.image
    }
}

/// Side of a panel for an image of `n` pixels: the smallest whole multiple from 384 up, or a whole part up to 768.
pub(super) fn panel_side(n: usize) -> usize {
    match n {
        0 => 384,
        1..=768 => n * 384usize.div_ceil(n),
        n => n / n.div_ceil(768),
    }
}

/// `raster` with `side` × `side` pixels of the same brightness (values are not shared out among the new pixels).
pub(super) fn enlarged(raster: &Raster, side: usize) -> Raster {
    let (width, height) = (raster.width, raster.height);
    // A few pixels are shown as what they are; many are shown smooth.
    if width.max(height) > side || width.min(height) < 96 {
        let pixels = (width * height) as f64;
        return raster.resampled(side, side).scaled((side * side) as f64 / pixels.max(1.0));
    }
    let place = |k: usize, n: usize| {
        let at = ((k as f64 + 0.5) / side as f64 * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
        let low = at as usize;
        (low, (low + 1).min(n - 1), at - low as f64)
    };
    let columns: Vec<_> = (0..side).map(|x| place(x, width)).collect();
    Raster::from_fn(side, side, |x, y| {
        let ((x0, x1, s), (y0, y1, t)) = (columns[x], place(y, height));
        let row = |y| raster.at(x0, y) * (1.0 - s) + raster.at(x1, y) * s;
        row(y0) * (1.0 - t) + row(y1) * t
    })
}

/// The end of the colour scale: the first of [`LIMITS`] that only one pixel in 200 exceeds.
fn difference_limit(difference: &Raster) -> f64 {
    let exceeding = |limit: f64| difference.values.iter().filter(|v| v.abs() > limit).count();
    LIMITS.into_iter().find(|l| exceeding(*l) * 200 <= difference.values.len()).unwrap_or(LIMITS[LIMITS.len() - 1])
}

/// Where things stand on the page, pixels.
struct Layout {
    /// Side of a panel.
    side: i64,
    /// One pixel of a page whose panels are 512 wide.
    unit: Unit,
    width: i64,
    height: i64,
    /// Left edges of the panels.
    lefts: [i64; 3],
    /// Upper edge of the first row's panels.
    top: i64,
    /// From one row's panels to the next one's.
    pitch: i64,
    /// Rows.
    rows: i64,
}

impl Layout {
    fn new(side: usize, rows: usize, heading: bool, footer_lines: usize) -> Self {
        let (side, unit, rows) = (side as i64, Unit(side as f64 / 512.0), rows.max(1) as i64);
        let px = |length| unit.px(length);
        let top = px(if heading { 130.0 } else { 78.0 });
        let across = side + px(64.0);
        let (left, pitch) = (px(88.0), side + px(140.0));
        // A page can hold a footer of a few lines; what a file name or a list would add is left off.
        let height = top + (rows - 1) * pitch + side + px(142.0) + footer_lines.min(8) as i64 * px(30.0);
        let width = left + 3 * side + 2 * px(64.0) + px(126.0);
        Self { side, unit, width, height, lefts: [left, left + across, left + 2 * across], top, pitch, rows }
    }

    /// Where row `k` stands.
    fn row(&self, k: usize) -> RowLayout<'_> {
        RowLayout { page: self, top: self.top + k as i64 * self.pitch }
    }

    fn px(&self, length: f64) -> i64 {
        self.unit.px(length)
    }

    fn page_words(&self, page: &mut Page, heading: &str, footer: &[&str], note: &str) {
        let left = self.lefts[0];
        let room = (self.width - 2 * left) as f32;
        page.write_fitted(heading, pixel(left, self.px(58.0)), self.unit.left(34.0, TEXT), room);
        let mut y = self.top + (self.rows - 1) * self.pitch + self.side + self.px(112.0);
        for line in footer.iter().take(8) {
            page.write_fitted(line, pixel(left, y), self.unit.left(21.0, TEXT), room);
            y += self.px(30.0);
        }
        page.write_fitted(note, pixel(left, y), self.unit.left(18.0, NOTE), room);
    }
}

/// Where one row stands on the page.
struct RowLayout<'a> {
    page: &'a Layout,
    /// Upper edge of its panels.
    top: i64,
}

impl RowLayout<'_> {
    /// Draws the three panels with their scales and words.
    fn draw(&self, page: &mut Page, row: &Comparison, view: &View, on_wall: Option<f64>) {
        let target = &row.target;
        let simulated = row.simulated.resampled(target.width, target.height);
        let white = [common_white(target), common_white(&simulated), 1.0].into_iter().find(|w| *w > 0.0).unwrap_or(1.0);
        let side = self.page.side as usize;
        let (target, simulated) = (enlarged(target, side), enlarged(&simulated, side));
        let difference = Raster::from_fn(side, side, |x, y| (simulated.at(x, y) - target.at(x, y)) / white);
        let limit = difference_limit(&difference);
        for (k, raster) in [&target, &simulated].into_iter().enumerate() {
            let grey = tone_mapped(raster, white);
            self.paint(page, k, |x, y| Rgb([grey.get_pixel(x, y).0[0]; 3]));
        }
        self.paint(page, 2, |x, y| diverging(difference.at(x as usize, y as usize) / limit));
        for k in 0..3 {
            match on_wall {
                None => self.scales(page, k, view),
                Some(half) => self.millimetres(page, k, half),
            }
            self.panel_words(page, k, &row.titles[k], &row.numbers[k]);
        }
        if on_wall.is_none() {
            self.scale_bar(page, view);
        }
        self.colour_bar(page, limit);
    }

    fn px(&self, length: f64) -> i64 {
        self.page.px(length)
    }

    /// Pixel offset within a panel of a position in [-1, 1] that grows with the pixels.
    fn along(&self, position: f64) -> i64 {
        (((position + 1.0) * 0.5 * self.page.side as f64).round() as i64).min(self.page.side - 1)
    }

    fn paint(&self, page: &mut Page, panel: usize, colour: impl Fn(u32, u32) -> Rgb<u8>) {
        let (left, top, side) = (self.page.lefts[panel] as u32, self.top as u32, self.page.side as u32);
        for y in 0..side {
            for x in 0..side {
                page.image.put_pixel(left + x, top + y, colour(x, y));
            }
        }
        page.frame([self.page.lefts[panel], self.top, self.page.side, self.page.side], self.page.unit.hair(), LINE);
    }

    /// Ticks at the left and lower edges; the labels of the left edge stand beside the first panel only.
    fn scales(&self, page: &mut Page, panel: usize, view: &View) {
        let Layout { side, lefts, unit, .. } = *self.page;
        let place = Place { left: lefts[panel], top: self.top, width: side, height: side };
        axes::degrees(page, unit, place, view, panel == 0);
    }

    fn millimetres(&self, page: &mut Page, panel: usize, half: f64) {
        let Layout { side, lefts, unit, .. } = *self.page;
        let place = Place { left: lefts[panel], top: self.top, width: side, height: side };
        axes::linear(page, unit, place, (half, false), |at| if panel == 0 { number(at) } else { String::new() });
    }

    fn panel_words(&self, page: &mut Page, panel: usize, title: &str, numbers: &str) {
        let left = self.page.lefts[panel];
        page.write_fitted(
            title,
            pixel(left, self.top - self.px(16.0)),
            self.page.unit.left(28.0, TEXT),
            self.page.side as f32,
        );
        let below = self.top + self.page.side + self.px(68.0);
        page.write_fitted(
            numbers,
            pixel(left, below),
            self.page.unit.left(24.0, TEXT),
            (self.page.side + self.px(30.0)) as f32,
        );
    }

    /// A bar of a round angle across the centre's direction, drawn in the target's lower right corner.
    fn scale_bar(&self, page: &mut Page, view: &View) {
        let Some(degrees) = round_below(0.5 * view.half_field().to_degrees()) else { return };
        let half = 0.5 * degrees.to_radians();
        let ends = [-half, half].map(|a| ticks::position(view, DVec2::X, a));
        let [Some(from), Some(to)] = ends else { return };
        let length = ((to - from) * 0.5 * self.page.side as f64).round() as i64;
        let (right, y) =
            (self.page.lefts[0] + self.page.side - self.px(18.0), self.top + self.page.side - self.px(20.0));
        let (thick, dark) = (self.px(3.0).max(2), self.page.unit.hair());
        let label = format!("{}°", number(degrees));
        let middle = right - length / 2;
        // A dark rim keeps bar and label legible on a bright highlight.
        page.fill([right - length - dark, y - dark, length + 2 * dark, thick + 2 * dark], TEXT);
        page.fill([right - length, y, length, thick], PAGE);
        for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
            let at = pixel(middle + dx * dark, y - self.px(8.0) + dy * dark);
            page.write(&label, at, self.page.unit.style(20.0, TEXT, Align::Centre));
        }
        page.write(&label, pixel(middle, y - self.px(8.0)), self.page.unit.style(20.0, PAGE, Align::Centre));
    }

    fn colour_bar(&self, page: &mut Page, limit: f64) {
        let (left, wide, hair) =
            (self.page.lefts[2] + self.page.side + self.px(20.0), self.px(18.0), self.page.unit.hair());
        for y in 0..self.page.side {
            let t = 1.0 - (y as f64 + 0.5) / self.page.side as f64 * 2.0;
            page.fill([left, self.top + y, wide, 1], diverging(t));
        }
        page.frame([left, self.top, wide, self.page.side], hair, LINE);
        for share in [-1.0, -0.5, 0.0, 0.5, 1.0] {
            let y = self.top + self.along(-share);
            let sign = if share > 0.0 { "+" } else { "" };
            page.fill([left + wide + hair, y - hair / 2, self.px(6.0), hair], LINE);
            let label = format!("{sign}{}%", number(100.0 * share * limit));
            let at = pixel(left + wide + self.px(12.0), y + self.px(7.0));
            page.write(&label, at, self.page.unit.style(19.0, TEXT, Align::Left));
        }
    }
}

#[cfg(test)]
mod tests;
