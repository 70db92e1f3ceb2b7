//! Target, simulation and their difference side by side, with scales, for reports and talks.

use glam::DVec2;
use image::{Rgb, RgbImage};

use super::lettering::{self, Align};
use super::page::{LINE, NOTE, PAGE, Page, TEXT, Unit, pixel};
use super::pixels::{common_white, diverging, tone_mapped};
use super::ticks::{self, number, round_below};
use crate::projection::View;
use crate::raster::Raster;

/// Ends of the difference scale, shares of white: the smallest that holds nearly all of the difference is taken.
const LIMITS: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];

/// What is to be compared, and what is to be said about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ComparisonPage<'a> {
    /// The wanted highlight, flux per pixel.
    pub target: &'a Raster,
    /// What the plate gives, flux per pixel in the same unit; resampled to the target's size if it has another.
    pub simulated: &'a Raster,
    /// The view both images cover, u and v from -1 to 1.
    pub view: &'a View,
    /// The blur both rasters have had, radians; only stated, not applied. 0: nothing is stated.
    pub blur: f64,
    /// The words.
    pub captions: &'a Captions,
}

/// The words of a [`ComparisonPage`]; any may be empty. What is too long is set smaller, then cut off.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Captions {
    /// Over all; leave empty to do without.
    pub heading: String,
    /// Over each panel.
    pub titles: [String; 3],
    /// Under each panel, such as "TV(1°) 0.009".
    pub numbers: [String; 3],
    /// Facts of the plate, at the bottom; may have several lines.
    pub footer: String,
}

impl Default for Captions {
    fn default() -> Self {
        Self {
            heading: String::new(),
            titles: ["Target", "Simulated", "Difference"].map(str::to_owned),
            numbers: Default::default(),
            footer: String::new(),
        }
    }
}

impl ComparisonPage<'_> {
    /// Draws the comparison; panels are 384 to 768 pixels wide, a whole multiple or part of the target's own pixels.
    ///
    /// Target and simulation share one white, see [`common_white`]. The difference is simulated minus target in
    /// percent of that white: red where the simulation is brighter, blue where it is darker, white where they agree.
    pub fn picture(&self) -> RgbImage {
        let (target, simulated) = (self.target, self.simulated.resampled(self.target.width, self.target.height));
        let white = [common_white(target), common_white(&simulated), 1.0].into_iter().find(|w| *w > 0.0).unwrap_or(1.0);
        let side = panel_side(target.width.max(target.height));
        let (target, simulated) = (enlarged(target, side), enlarged(&simulated, side));
        let difference = Raster::from_fn(side, side, |x, y| (simulated.at(x, y) - target.at(x, y)) / white);
        let limit = difference_limit(&difference);

        let footer: Vec<&str> = self.captions.footer.lines().collect();
        let layout = Layout::new(side, !self.captions.heading.is_empty(), footer.len());
        let mut page = Page::new(layout.width, layout.height);
        for (k, raster) in [&target, &simulated].into_iter().enumerate() {
            let grey = tone_mapped(raster, white);
            layout.paint(&mut page, k, |x, y| Rgb([grey.get_pixel(x, y).0[0]; 3]));
        }
        layout.paint(&mut page, 2, |x, y| diverging(difference.at(x as usize, y as usize) / limit));
        for k in 0..3 {
            layout.scales(&mut page, k, self.view);
            layout.panel_words(&mut page, k, &self.captions.titles[k], &self.captions.numbers[k]);
        }
        layout.scale_bar(&mut page, self.view);
        layout.colour_bar(&mut page, limit);
        layout.page_words(&mut page, &self.captions.heading, &footer, &self.note());
        page.image
    }

    /// How to read the panels.
    fn note(&self) -> String {
        let blur = number(self.blur.to_degrees());
        let blur = if self.blur > 0.0 { format!(" · both seen through a blur of {blur}°") } else { String::new() };
        format!("Axes: degrees from the mirror direction · difference: simulated − target, in % of white{blur}")
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
    /// Upper edge of the panels.
    top: i64,
}

impl Layout {
    fn new(side: usize, heading: bool, footer_lines: usize) -> Self {
        let (side, unit) = (side as i64, Unit(side as f64 / 512.0));
        let px = |length| unit.px(length);
        let top = px(if heading { 130.0 } else { 78.0 });
        let pitch = side + px(64.0);
        let left = px(88.0);
        // A page can hold a footer of a few lines; what a file name or a list would add is left off.
        let height = top + side + px(142.0) + footer_lines.min(8) as i64 * px(30.0);
        let width = left + 3 * side + 2 * px(64.0) + px(126.0);
        Self { side, unit, width, height, lefts: [left, left + pitch, left + 2 * pitch], top }
    }

    fn px(&self, length: f64) -> i64 {
        self.unit.px(length)
    }

    /// Pixel offset within a panel of a position in [-1, 1] that grows with the pixels.
    fn along(&self, position: f64) -> i64 {
        (((position + 1.0) * 0.5 * self.side as f64).round() as i64).min(self.side - 1)
    }

    fn paint(&self, page: &mut Page, panel: usize, colour: impl Fn(u32, u32) -> Rgb<u8>) {
        let (left, top, side) = (self.lefts[panel] as u32, self.top as u32, self.side as u32);
        for y in 0..side {
            for x in 0..side {
                page.image.put_pixel(left + x, top + y, colour(x, y));
            }
        }
        page.frame([self.lefts[panel], self.top, self.side, self.side], self.unit.hair(), LINE);
    }

    /// Ticks at the left and lower edges; the labels of the left edge stand beside the first panel only.
    fn scales(&self, page: &mut Page, panel: usize, view: &View) {
        let (left, bottom, hair) = (self.lefts[panel], self.top + self.side, self.unit.hair());
        for (along, is_x) in [(DVec2::X, true), (DVec2::Y, false)] {
            let mut marks = ticks::ticks(view, along);
            // From the centre outward, labelled ones first: where a scale crowds, the middle stays legible.
            marks.sort_by(|a, b| b.labelled.cmp(&a.labelled).then(a.angle.abs().total_cmp(&b.angle.abs())));
            let (mut drawn, mut taken) = (Vec::new(), Vec::<(i64, i64)>::new());
            for tick in marks {
                let at = self.along(if is_x { tick.position } else { -tick.position });
                if !tick.labelled && drawn.iter().any(|d: &i64| (d - at).abs() < self.px(6.0)) {
                    continue;
                }
                drawn.push(at);
                let reach = self.px(if tick.labelled { 9.0 } else { 5.0 });
                if is_x {
                    page.fill([left + at - hair / 2, bottom + hair, hair, reach], LINE);
                } else {
                    page.fill([left - hair - reach, self.top + at - hair / 2, reach, hair], LINE);
                }
                let label = format!("{}°", number(tick.angle));
                let wide = if is_x { lettering::width(&label, self.unit.size(19.0)) as i64 } else { self.px(18.0) };
                let (from, to) = (at - wide / 2 - self.px(4.0), at + wide / 2 + self.px(4.0));
                let unlabelled = !tick.labelled || !is_x && panel > 0;
                if unlabelled || taken.iter().any(|&(a, b)| from < b && a < to) {
                    continue;
                }
                taken.push((from, to));
                if is_x {
                    page.write(
                        &label,
                        pixel(left + at, bottom + self.px(30.0)),
                        self.unit.style(19.0, TEXT, Align::Centre),
                    );
                } else {
                    let place = pixel(left - self.px(16.0), self.top + at + self.px(7.0));
                    page.write(&label, place, self.unit.style(19.0, TEXT, Align::Right));
                }
            }
        }
    }

    fn panel_words(&self, page: &mut Page, panel: usize, title: &str, numbers: &str) {
        let left = self.lefts[panel];
        page.write_fitted(title, pixel(left, self.top - self.px(16.0)), self.unit.left(28.0, TEXT), self.side as f32);
        let below = self.top + self.side + self.px(68.0);
        page.write_fitted(numbers, pixel(left, below), self.unit.left(24.0, TEXT), (self.side + self.px(30.0)) as f32);
    }

    /// A bar of a round angle across the centre's direction, drawn in the target's lower right corner.
    fn scale_bar(&self, page: &mut Page, view: &View) {
        let Some(degrees) = round_below(0.5 * view.half_field().to_degrees()) else { return };
        let half = 0.5 * degrees.to_radians();
        let ends = [-half, half].map(|a| ticks::position(view, DVec2::X, a));
        let [Some(from), Some(to)] = ends else { return };
        let length = ((to - from) * 0.5 * self.side as f64).round() as i64;
        let (right, y) = (self.lefts[0] + self.side - self.px(18.0), self.top + self.side - self.px(20.0));
        let (thick, dark) = (self.px(3.0).max(2), self.unit.hair());
        let label = format!("{}°", number(degrees));
        let middle = right - length / 2;
        // A dark rim keeps bar and label legible on a bright highlight.
        page.fill([right - length - dark, y - dark, length + 2 * dark, thick + 2 * dark], TEXT);
        page.fill([right - length, y, length, thick], PAGE);
        for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
            let at = pixel(middle + dx * dark, y - self.px(8.0) + dy * dark);
            page.write(&label, at, self.unit.style(20.0, TEXT, Align::Centre));
        }
        page.write(&label, pixel(middle, y - self.px(8.0)), self.unit.style(20.0, PAGE, Align::Centre));
    }

    fn colour_bar(&self, page: &mut Page, limit: f64) {
        let (left, wide, hair) = (self.lefts[2] + self.side + self.px(20.0), self.px(18.0), self.unit.hair());
        for y in 0..self.side {
            let t = 1.0 - (y as f64 + 0.5) / self.side as f64 * 2.0;
            page.fill([left, self.top + y, wide, 1], diverging(t));
        }
        page.frame([left, self.top, wide, self.side], hair, LINE);
        for share in [-1.0, -0.5, 0.0, 0.5, 1.0] {
            let y = self.top + self.along(-share);
            let sign = if share > 0.0 { "+" } else { "" };
            page.fill([left + wide + hair, y - hair / 2, self.px(6.0), hair], LINE);
            let label = format!("{sign}{}%", number(100.0 * share * limit));
            let at = pixel(left + wide + self.px(12.0), y + self.px(7.0));
            page.write(&label, at, self.unit.style(19.0, TEXT, Align::Left));
        }
    }

    fn page_words(&self, page: &mut Page, heading: &str, footer: &[&str], note: &str) {
        let left = self.lefts[0];
        let room = (self.width - 2 * left) as f32;
        page.write_fitted(heading, pixel(left, self.px(58.0)), self.unit.left(34.0, TEXT), room);
        let mut y = self.top + self.side + self.px(112.0);
        for line in footer.iter().take(8) {
            page.write_fitted(line, pixel(left, y), self.unit.left(21.0, TEXT), room);
            y += self.px(30.0);
        }
        page.write_fitted(note, pixel(left, y), self.unit.left(18.0, NOTE), room);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::Projection;
    use glam::DVec3;

    fn view() -> View {
        View::new(Projection::Orthographic, f64::to_radians(20.0), DVec3::Z)
    }

    fn picture(target: &Raster, simulated: &Raster, view: &View, captions: &Captions) -> RgbImage {
        ComparisonPage { target, simulated, view, blur: 0.01, captions }.picture()
    }

    #[test]
    fn the_panels_show_the_pixels_with_row_zero_on_top_and_agreement_as_white() {
        // One bright pixel at the upper left of the target; the simulation has it at the upper right.
        let target = Raster::from_fn(4, 4, |x, y| if (x, y) == (0, 0) { 1.0 } else { 0.0 });
        let simulated = Raster::from_fn(4, 4, |x, y| if (x, y) == (3, 0) { 1.0 } else { 0.0 });
        let page = picture(&target, &simulated, &view(), &Captions::default());
        let layout = Layout::new(384, false, 0);
        assert_eq!(page.dimensions(), (layout.width as u32, layout.height as u32));
        let at = |panel: usize, column: i64, row: i64| {
            let (x, y) = (layout.lefts[panel] + column * 96 + 48, layout.top + row * 96 + 48);
            page.get_pixel(x as u32, y as u32).0
        };
        assert_eq!((at(0, 0, 0), at(0, 3, 0), at(0, 0, 3)), ([255; 3], [0; 3], [0; 3]));
        assert_eq!((at(1, 0, 0), at(1, 3, 0)), ([0; 3], [255; 3]));
        assert_eq!((at(2, 0, 0), at(2, 3, 0), at(2, 1, 2)), (diverging(-1.0).0, diverging(1.0).0, [255; 3]));
        // The scales, through the projection: 10° stands at sin 10° / sin 20°, to the right and up.
        let offset = (192.0 * f64::to_radians(10.0).sin() / f64::to_radians(20.0).sin()).round() as i64;
        let (x, y) = (layout.lefts[0] + 192 + offset, layout.top + layout.side + 3);
        assert_eq!(page.get_pixel(x as u32, y as u32), &LINE);
        assert_eq!(page.get_pixel(x as u32 - 2, y as u32), &PAGE);
        let (x, y) = (layout.lefts[0] - 4, layout.top + 192 - offset);
        assert_eq!(page.get_pixel(x as u32, y as u32), &LINE);
        assert_eq!(page.get_pixel(x as u32, y as u32 - 2), &PAGE);
    }

    #[test]
    fn enlarging_keeps_brightness_and_the_mean() {
        let ramp = Raster::from_fn(128, 100, |x, y| (x + 2 * y) as f64);
        for (raster, side) in [(ramp.clone(), 384), (ramp.resampled(8, 6).scaled(0.1), 384), (ramp, 64)] {
            let shown = enlarged(&raster, side);
            let mean = |r: &Raster| r.sum() / r.values.len() as f64;
            assert!((mean(&shown) / mean(&raster) - 1.0).abs() < 1e-9, "{side}");
            assert!(shown.max() <= raster.max() + 1e-9);
        }
        assert_eq!(
            [0, 1, 3, 100, 256, 384, 500, 1024, 2048].map(panel_side),
            [384, 384, 384, 400, 512, 384, 500, 512, 682]
        );
    }

    #[test]
    fn the_colour_scale_is_round_and_holds_nearly_everything() {
        let of = |v: f64| difference_limit(&Raster::from_fn(40, 40, |x, _| if x == 7 { v } else { 0.0 }));
        assert_eq!([0.0, 0.01, -0.08, 0.3, -0.6, 7.0].map(of), [0.05, 0.05, 0.1, 0.5, 1.0, 1.0]);
        let mut single = Raster::zeros(40, 40);
        single.values[5] = 0.9;
        assert_eq!(difference_limit(&single), 0.05);
    }

    #[test]
    fn words_stay_on_the_page_and_nothing_panics() {
        let long = "A very long caption about a very small plate, ".repeat(30);
        let wordy = Captions {
            heading: long.clone(),
            titles: [long.clone(), long.clone(), long.clone()],
            numbers: [long.clone(), long.clone(), long.clone()],
            footer: format!("{long}\n").repeat(12),
        };
        let empty = Captions { titles: Default::default(), ..Captions::default() };
        let mut nan = Raster::zeros(5, 5);
        nan.values[3] = f64::NAN;
        let one = Raster::from_fn(1, 1, |_, _| 1.0);
        let wide = View::new(Projection::Screen, f64::to_radians(80.0), DVec3::new(0.6, 0.0, 0.8));
        for (target, simulated) in
            [(&one, &one), (&Raster::zeros(0, 0), &one), (&Raster::zeros(3, 2), &one), (&nan, &nan)]
        {
            for captions in [&wordy, &empty] {
                for view in [&view(), &wide, &View::new(Projection::Equidistant, 0.0, DVec3::Z)] {
                    let page = picture(target, simulated, view, captions);
                    let (w, h) = page.dimensions();
                    let edge = |x, y| x == 0 || y == 0 || x == w - 1 || y == h - 1;
                    assert!(page.enumerate_pixels().all(|(x, y, p)| *p == PAGE || !edge(x, y)));
                }
            }
        }
    }

    #[test]
    fn the_same_comparison_gives_the_same_picture_and_shows_its_words() {
        let target = Raster::from_fn(30, 30, |x, y| (x * y) as f64);
        let plain = picture(&target, &target, &view(), &Captions::default());
        assert_eq!(plain, picture(&target, &target, &view(), &Captions::default()));
        let told = Captions { numbers: [String::new(), String::new(), "TV 0".into()], ..Captions::default() };
        assert_ne!(plain, picture(&target, &target, &view(), &told));
    }
}
