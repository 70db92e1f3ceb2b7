//! The plate seen from above, shaded so that facets, steps and the whole shape can be told at a glance.

mod facet_plan;

mod heights;

use glam::{DVec2, DVec3};
use image::RgbImage;

use super::heightmap::pixel_counts;
use super::lettering::Align;
use super::page::{GRID, LINE, PLAN_LINE, Page, TEXT, Unit, pixel};
use super::ticks::{number, round_below};
use crate::progress::{Cancelled, Progress};
use crate::relief::faceted::FacetedRelief;
use facet_plan::FacetPlan;
use heights::CornerHeights;

/// Unit vector toward the lamp of the plan: from the upper left, as maps are shaded, 30° above the plate.
const TOWARD_LAMP: DVec3 = DVec3::new(-0.612_4, 0.612_4, 0.5);
/// Brightness of a face turned away from the lamp, as a share of the full brightness.
const AMBIENT: f64 = 0.08;
/// Slope at which the steepest facets are to be shown.
const SHOWN_SLOPE: f64 = 0.75;
/// Linear colours of the lowest and the highest ground.
const LOW: DVec3 = DVec3::new(0.50, 0.58, 0.70);
const HIGH: DVec3 = DVec3::new(1.0, 0.96, 0.89);
/// Room for the labels of heights at the left, in units of the page.
const LABELS: f64 = 80.0;

/// About how many contour lines a relief has.
const CONTOURS: f64 = 9.0;

/// The picture of a relief from above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReliefPicture<'a> {
    /// The whole relief, rim included.
    pub relief: &'a FacetedRelief,
    /// Whether it is one surface, whose facets are only the squares of its grid.
    pub continuous: bool,
    /// What it is made of, for the caption.
    pub made_of: &'a str,
}

impl ReliefPicture<'_> {
    /// A shaded plan with contour lines, and below it a section in mm through the plate's middle; +y is up.
    ///
    /// The plate's longer side gets `pixels` pixels (taken into 16 to 8192), the page a margin around it. The lamp of the plan
    /// stands low at the upper left. Facets are shaded by their exact planes, and a wall shows as a bright or dark edge as
    /// wide as its height asks for; of a continuous relief each pixel shows the mean of its slopes, about the slope of the
    /// whole plate. All slopes are exaggerated by a round factor that makes the steeper ones stand out; the caption states
    /// it. Higher ground is a little warmer.
    pub fn picture(&self, pixels: usize, progress: &Progress) -> Result<RgbImage, Cancelled> {
        let relief = self.relief;
        let (low, high) = relief.bounds();
        let size = (high - low).truncate();
        let [width, height] = pixel_counts(size, pixels.clamp(16, 8192));
        let heights = CornerHeights::new(relief, self.continuous, [width as usize, height as usize], progress)?;
        let (mut plan, exaggeration) = if self.continuous {
            heights.shaded(low.z, high.z)
        } else {
            let exaggeration = facet_plan::exaggeration(relief);
            let plan = FacetPlan { relief, low, high, exaggeration, pixel: size.x / f64::from(width) };
            (plan.picture(width, height, progress)?, exaggeration)
        };
        progress.check()?;
        // Between walls lines would only be pieces.
        let step = round_below((high.z - low.z) / CONTOURS).filter(|step| self.continuous && *step > 1e-7);
        if let Some(step) = step {
            heights.contours(&mut plan, step);
        }
        progress.check()?;
        let unit = Unit((f64::from(width.max(height)) / 900.0).max(0.6));
        let margin = unit.px(40.0);
        let (wide, tall) = (i64::from(width), i64::from(height));
        // A narrow plate still leaves room for its caption.
        let page_width = (wide + 2 * margin).max(unit.px(640.0)) + unit.px(LABELS);
        let (left, bottom) = (margin + unit.px(LABELS), margin + tall);
        let mut page = Page::new(page_width, bottom + unit.px(330.0));
        page.put(&plan, (left, margin), |colour| colour);
        page.frame([left, margin, wide, tall], unit.hair(), PLAN_LINE);
        scale_bar(&mut page, unit, (left, bottom + unit.px(34.0)), width, size.x);
        let section = Section { heights: &heights, unit, low: low.z, high: high.z };
        section.draw(&mut page, [left, bottom + unit.px(74.0), wide, unit.px(110.0)], margin);
        let room = (page_width - left - margin / 2) as f32;
        let mut words = |line: i64, text: &str| {
            let at = pixel(left, bottom + unit.px(260.0) + line * unit.px(30.0));
            page.write_fitted(text, at, unit.left(22.0, TEXT), room);
        };
        words(0, &caption(relief, self.made_of, exaggeration));
        let lines = step.map(|step| format!("contour lines every {} · ", length_text(step))).unwrap_or_default();
        words(1, &format!("{lines}the section is at the marks"));
        Ok(page.image)
    }
}

/// The plate cut along the middle row of the plan.
struct Section<'a> {
    heights: &'a CornerHeights,
    unit: Unit,
    /// Lowest and highest point of the relief, mm.
    low: f64,
    high: f64,
}

impl Section<'_> {
    /// Draws it into `[left, top, width, height]` with a scale in mm, and marks its place beside the plan, whose upper edge is
    /// at `plan_top`.
    fn draw(&self, page: &mut Page, [left, top, width, height]: [i64; 4], plan_top: i64) {
        let (unit, row) = (self.unit, self.heights.rows / 2);
        let range = self.high - self.low;
        let y = |z: f64| {
            let share = if range > 0.0 { (z - self.low) / range } else { 0.0 };
            top as f64 + (1.0 - share) * height as f64
        };
        let heights = self.heights.section(row);
        for (column, pair) in heights.windows(2).enumerate() {
            let surface = y(0.5 * (pair[0] + pair[1])).round() as i64;
            let x = left + column as i64 * width / self.heights.columns as i64;
            page.fill([x, surface, 1, top + height - surface], GRID);
        }
        let scale = width as f64 / self.heights.columns as f64;
        let points = |(column, z): (usize, &f64)| DVec2::new(left as f64 + column as f64 * scale, y(*z));
        page.stroke(&heights.iter().enumerate().map(points).collect::<Vec<_>>(), 1.6 * unit.0.max(0.7), TEXT);
        page.fill([left, top + height, width, unit.hair()], LINE);
        for (z, label) in [(self.low, "0 mm".to_owned()), (self.high, length_text(range))] {
            let at = y(z).round() as i64;
            page.fill([left - unit.px(8.0), at, unit.px(8.0), unit.hair()], LINE);
            let style = unit.style(19.0, TEXT, Align::Right);
            page.write(&label, pixel(left - unit.px(14.0), at + unit.px(7.0)), style);
        }
        let mark = plan_top + row as i64;
        for x in [left - unit.px(16.0), left + width + unit.px(4.0)] {
            page.fill([x, mark - unit.hair(), unit.px(12.0), 2 * unit.hair()], TEXT);
        }
    }
}

/// Linear colour of ground of a (exaggerated) normal, `rise` of the way from the lowest to the highest.
fn lit(normal: DVec3, rise: f64) -> DVec3 {
    let lit = AMBIENT + (1.0 - AMBIENT) * normal.dot(TOWARD_LAMP).max(0.0);
    LOW.lerp(HIGH, rise) * lit
}

/// A bar of a round length from the pixel (`left`, `y`) on, its length beside it, under a plan `width` pixels and
/// `width_mm` wide.
fn scale_bar(page: &mut Page, unit: Unit, (left, y): (i64, i64), width: u32, width_mm: f64) {
    let Some(bar) = round_below(0.22 * width_mm) else { return };
    let length = (bar / width_mm * f64::from(width)).round() as i64;
    let (thick, tall) = (unit.px(2.0).max(1), unit.px(12.0));
    page.fill([left, y, length, thick], TEXT);
    page.fill([left, y - tall / 2, thick, tall + thick], TEXT);
    page.fill([left + length - thick, y - tall / 2, thick, tall + thick], TEXT);
    let style = unit.left(22.0, TEXT);
    let at = ((left + length + unit.px(12.0)) as f32, y as f32 + 0.35 * style.size);
    page.write(&length_text(bar), at, style);
}

/// What stands under the picture: size, relief height, parts, and how much the slopes are exaggerated.
fn caption(relief: &FacetedRelief, made_of: &str, exaggeration: f64) -> String {
    let (low, high) = relief.bounds();
    let size = high - low;
    let rounded = |v: f64| number((v * 100.0).round() / 100.0);
    let slopes =
        if exaggeration == 1.0 { "slopes true".into() } else { format!("slopes shown ×{}", number(exaggeration)) };
    format!("{} × {} mm · relief {} · {made_of} · {slopes}", rounded(size.x), rounded(size.y), length_text(size.z))
}

/// A length in the unit that suits it: "12 mm", "0.35 mm", "8.2 µm".
fn length_text(mm: f64) -> String {
    let three_digits = |v: f64| {
        let step = 10f64.powf(v.log10().floor() - 2.0);
        number((v / step).round() * step)
    };
    match mm {
        v if v >= 0.1 => format!("{} mm", three_digits(v)),
        v if v > 1e-9 => format!("{} µm", three_digits(v * 1e3)),
        _ => "0 mm".into(),
    }
}

/// The round factor, at least 1, that brings the steepest twentieth of `slopes` to [`SHOWN_SLOPE`].
fn round_exaggeration(mut slopes: Vec<f64>) -> f64 {
    if slopes.is_empty() {
        return 1.0;
    }
    let rank = (slopes.len() - 1) * 19 / 20;
    let steep = *slopes.select_nth_unstable_by(rank, f64::total_cmp).1;
    // Slopes of rounding errors are those of a flat plate.
    let wanted = if steep > 1e-7 { (SHOWN_SLOPE / steep).clamp(1.0, 1000.0) } else { 1.0 };
    let decade = 10f64.powf(wanted.log10().floor());
    [8.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.5, 1.0].map(|m| m * decade).into_iter().find(|k| *k <= wanted).unwrap_or(1.0)
}

#[cfg(test)]
mod tests;
