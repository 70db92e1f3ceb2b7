//! The plate seen from above, shaded so that facets, steps and the whole shape can be told at a glance.

use glam::{DVec2, DVec3};
use image::{Rgb, RgbImage};
use rayon::prelude::*;

use super::heightmap::{interval, pixel_counts};
use super::page::{PLAN_LINE, Page, TEXT, Unit, pixel};
use super::pixels::{byte, srgb_encoded};
use super::ticks::{number, round_below};
use crate::relief::faceted::FacetedRelief;

/// Samples along each side of a pixel.
const SAMPLES: usize = 3;
/// Unit vector toward the lamp of the plan: from the upper left, as maps are shaded.
const TOWARD_LAMP: DVec3 = DVec3::new(-0.54, 0.54, 0.645_6);
/// Brightness of a face turned away from the lamp, as a share of the full brightness.
const AMBIENT: f64 = 0.08;
/// Slope at which the steepest facets are to be shown.
const SHOWN_SLOPE: f64 = 0.75;
/// A wall is drawn as if it leaned: this many times its (exaggerated) height wide, on its low side.
const WALL_LEAN: f64 = 0.5;
/// Linear colours of the lowest and the highest ground.
const LOW: DVec3 = DVec3::new(0.50, 0.58, 0.70);
const HIGH: DVec3 = DVec3::new(1.0, 0.96, 0.89);
/// How much of the light a hairline between facets takes at most, where facets are many pixels wide.
const HAIRLINE: f64 = 0.16;

/// A shaded plan of the whole relief, rim included, with a scale bar and a caption that names what it is `made_of`; +y is
/// up.
///
/// The plate's longer side gets `pixels` pixels (taken into 16 to 8192), the page a margin around it. Facets are
/// shaded by their exact planes under a lamp at the upper left, higher ground is a little warmer, and a wall shows
/// as a bright or dark edge as wide as its height asks for. All slopes are exaggerated by a round factor that makes
/// the steeper facets stand out; the caption states it.
pub(crate) fn relief_picture(relief: &FacetedRelief, made_of: &str, pixels: usize) -> RgbImage {
    let (low, high) = relief.bounds();
    let size = (high - low).truncate();
    let [width, height] = pixel_counts(size, pixels.clamp(16, 8192));
    let exaggeration = exaggeration(relief);
    let plan = ShadedPlan { relief, low, high, exaggeration, pixel: size.x / f64::from(width) };
    let unit = Unit((f64::from(width.max(height)) / 900.0).max(0.6));
    let margin = unit.px(40.0);
    let (wide, tall) = (i64::from(width), i64::from(height));
    // A narrow plate still leaves room for its caption.
    let page_width = (wide + 2 * margin).max(unit.px(560.0));
    let bottom = margin + tall;
    let mut page = Page::new(page_width, bottom + unit.px(100.0));
    page.put(&plan.picture(width, height), (margin, margin), |colour| colour);
    page.frame([margin, margin, wide, tall], unit.hair(), PLAN_LINE);
    scale_bar(&mut page, unit, (margin, bottom + unit.px(34.0)), width, size.x);
    let room = (page_width - margin - margin / 2) as f32;
    let text = caption(relief, made_of, exaggeration);
    page.write_fitted(&text, pixel(margin, bottom + unit.px(78.0)), unit.left(22.0, TEXT), room);
    page.image
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

/// The round factor, at least 1, that brings the steepest twentieth of the slopes to [`SHOWN_SLOPE`].
fn exaggeration(relief: &FacetedRelief) -> f64 {
    let (columns, rows) = &relief.optical;
    let mut slopes: Vec<f64> = rows
        .clone()
        .flat_map(|j| columns.clone().map(move |i| (i, j)))
        .map(|(i, j)| relief.facet(i, j).slope.to_vec().length())
        .collect();
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

/// What the colour of a point of the plate is computed from.
struct ShadedPlan<'a> {
    relief: &'a FacetedRelief,
    low: DVec3,
    high: DVec3,
    exaggeration: f64,
    /// Side of a pixel, mm.
    pixel: f64,
}

impl ShadedPlan<'_> {
    /// All of the plan, `width` × `height` pixels.
    fn picture(&self, width: u32, height: u32) -> RgbImage {
        let rows: Vec<Vec<Rgb<u8>>> = (0..height)
            .into_par_iter()
            .map(|row| (0..width).map(|column| self.pixel(column, row, width, height)).collect())
            .collect();
        RgbImage::from_fn(width, height, |x, y| rows[y as usize][x as usize])
    }

    fn pixel(&self, column: u32, row: u32, width: u32, height: u32) -> Rgb<u8> {
        let pixels = DVec2::new(f64::from(width), f64::from(height));
        let mut sum = DVec3::ZERO;
        for a in 0..SAMPLES {
            for b in 0..SAMPLES {
                let inside = (DVec2::new(a as f64, b as f64) + 0.5) / SAMPLES as f64;
                let share = (DVec2::new(f64::from(column), f64::from(row)) + inside) / pixels;
                let size = (self.high - self.low).truncate();
                sum += self.colour(DVec2::new(self.low.x + share.x * size.x, self.high.y - share.y * size.y));
            }
        }
        Rgb((sum / (SAMPLES * SAMPLES) as f64).to_array().map(|v| byte(srgb_encoded(v))))
    }

    /// Linear colour of the plate at a point, mm.
    fn colour(&self, at: DVec2) -> DVec3 {
        let relief = self.relief;
        let (i, j) = (interval(&relief.x, at.x), interval(&relief.y, at.y));
        let slope = relief.facet(i, j).slope.to_vec() * self.exaggeration;
        let z = relief.plane_height(i, j, at);
        let normal = self.wall(i, j, at).unwrap_or((-slope).extend(1.0)).normalize();
        let range = self.high.z - self.low.z;
        let rise = if range > 0.0 { ((z - self.low.z) / range).clamp(0.0, 1.0) } else { 1.0 };
        let lit = AMBIENT + (1.0 - AMBIENT) * normal.dot(TOWARD_LAMP).max(0.0);
        LOW.lerp(HIGH, rise) * lit * (1.0 - self.hairline(i, j, at))
    }

    /// Share of light that the line between facets takes at this point of cell (i, j): neighbours that meet
    /// without a step and with nearly the same slope could not be told apart by their shade alone. The rim has none.
    fn hairline(&self, i: usize, j: usize, at: DVec2) -> f64 {
        let (columns, rows) = &self.relief.optical;
        if !columns.contains(&i) || !rows.contains(&j) {
            return 0.0;
        }
        let (x, y) = (&self.relief.x[i..i + 2], &self.relief.y[j..j + 2]);
        let edge = (at.x - x[0]).min(x[1] - at.x).min(at.y - y[0]).min(y[1] - at.y);
        let cell_pixels = (x[1] - x[0]).min(y[1] - y[0]) / self.pixel;
        if edge < 0.5 * self.pixel { HAIRLINE * ((cell_pixels - 5.0) / 15.0).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The normal of the wall that is drawn over this point of cell (i, j), if a neighbour stands that much higher.
    fn wall(&self, i: usize, j: usize, at: DVec2) -> Option<DVec3> {
        let relief = self.relief;
        let (x0, x1, y0, y1) = (relief.x[i], relief.x[i + 1], relief.y[j], relief.y[j + 1]);
        // Foot of the wall nearest the point, distance to it, the way it faces, and the neighbour behind it.
        let sides = [
            (DVec2::new(x0, at.y), at.x - x0, DVec2::X, (i > 0).then(|| (i - 1, j))),
            (DVec2::new(x1, at.y), x1 - at.x, -DVec2::X, (i + 1 < relief.columns()).then(|| (i + 1, j))),
            (DVec2::new(at.x, y0), at.y - y0, DVec2::Y, (j > 0).then(|| (i, j - 1))),
            (DVec2::new(at.x, y1), y1 - at.y, -DVec2::Y, (j + 1 < relief.rows()).then(|| (i, j + 1))),
        ];
        let widest = 0.25 * (x1 - x0).min(y1 - y0);
        // Steps of rounding errors are none.
        let mut best = (1e-6 * widest, None);
        for (foot, distance, facing, neighbour) in sides {
            let Some((ni, nj)) = neighbour else { continue };
            let step = relief.plane_height(ni, nj, foot) - relief.plane_height(i, j, foot);
            let left_over = (WALL_LEAN * self.exaggeration * step).min(widest) - distance;
            if left_over > best.0 {
                best = (left_over, Some(facing.extend(WALL_LEAN)));
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::page::PAGE;
    use crate::relief::faceted::Facet;
    use crate::slope::Slope;

    fn one(slope: Slope, size: DVec2) -> FacetedRelief {
        FacetedRelief::uniform(1, 1, size, vec![Facet { height: 0.0, slope }])
    }

    fn brightness(p: &Rgb<u8>) -> u32 {
        p.0.iter().map(|v| u32::from(*v)).sum()
    }

    fn plan(relief: &FacetedRelief) -> ShadedPlan<'_> {
        let (low, high) = relief.bounds();
        ShadedPlan { relief, low, high, exaggeration: exaggeration(relief), pixel: 0.01 }
    }

    #[test]
    fn slopes_facing_the_upper_left_are_bright() {
        // A plane that climbs to the right faces left; one that climbs down the page faces up.
        let light = |p, q| {
            let relief = one(Slope::new(p, q), DVec2::ONE);
            plan(&relief).colour(DVec2::new(0.5, 0.5)).y
        };
        assert!(light(0.1, -0.1) > 1.5 * light(-0.1, -0.1));
        assert!(light(-0.1, -0.1) > 1.2 * light(-0.1, 0.1));
        assert!((light(0.1, 0.0) - light(0.0, -0.1)).abs() < 1e-12);
    }

    #[test]
    fn a_step_shows_on_its_low_side_only_and_y_is_up() {
        // The upper row of cells (higher y) stands 0.05 mm higher: its wall faces down the page, away from the lamp.
        let facet = |height| Facet { height, slope: Slope::FLAT };
        let relief = FacetedRelief::uniform(1, 2, DVec2::new(1.0, 2.0), vec![facet(0.0), facet(0.05)]);
        let plan = plan(&relief);
        assert_eq!(plan.exaggeration, 1.0);
        assert_eq!(plan.wall(0, 0, DVec2::new(0.5, 0.98)), Some(DVec3::new(0.0, -1.0, WALL_LEAN)));
        assert_eq!(plan.wall(0, 0, DVec2::new(0.5, 0.97)), None);
        assert_eq!(plan.wall(0, 1, DVec2::new(0.5, 1.01)), None);
        let page = relief_picture(&relief, "2 facets", 400);
        let column = page.width() / 2;
        let (top, low) = (page.get_pixel(column, 60), page.get_pixel(column, 400));
        assert!(brightness(top) > brightness(low), "higher ground is lighter and lies at the top");
    }

    #[test]
    fn the_exaggeration_is_round_and_never_hides_slopes() {
        let of = |p| exaggeration(&one(Slope::new(p, 0.0), DVec2::ONE));
        assert_eq!([0.0, 1e-12, 2.0, 0.75, 0.18, 0.075, 0.01, 1e-6].map(of), [1., 1., 1., 1., 4., 10., 60., 1000.]);
    }

    #[test]
    fn captions_state_size_height_and_factor() {
        let relief = one(Slope::new(0.01, 0.0), DVec2::new(30.48, 20.0)).with_rim(1.0);
        assert_eq!(
            caption(&relief, "1 × 1 facets", 60.0),
            "32.48 × 22 mm · relief 0.305 mm · 1 × 1 facets · slopes shown ×60"
        );
        let flat = one(Slope::FLAT, DVec2::new(5.0, 5.0));
        assert_eq!(caption(&flat, "1 × 1 facets", 1.0), "5 × 5 mm · relief 0 mm · 1 × 1 facets · slopes true");
        assert_eq!(
            [2.0, 0.5, 0.05, 0.0123456, 123.4].map(length_text),
            ["2 mm", "0.5 mm", "50 µm", "12.3 µm", "123 mm"]
        );
    }

    #[test]
    fn any_shape_of_plate_is_drawn_with_its_aspect_and_the_same_each_time() {
        for (size, pixels) in [(DVec2::new(30.0, 10.0), 300), (DVec2::new(0.1, 40.0), 200), (DVec2::ONE, 0)] {
            let relief = one(Slope::new(0.05, 0.1), size);
            let page = relief_picture(&relief, "one facet", pixels);
            assert!(page.width() >= 336 && page.height() > 80);
            assert_eq!(page, relief_picture(&relief, "one facet", pixels));
            // The paper stays white all around: nothing is cut off at its edge.
            let (w, h) = page.dimensions();
            assert!(page.enumerate_pixels().all(|(x, y, p)| *p == PAGE || (x > 0 && y > 0 && x < w - 1 && y < h - 1)));
        }
        let page = relief_picture(&one(Slope::new(0.05, 0.1), DVec2::new(30.0, 10.0)), "one facet", 600);
        let row = (0..page.width()).filter(|&x| brightness(page.get_pixel(x, 100)) < 765).count();
        let column = (0..220).filter(|&y| brightness(page.get_pixel(300, y)) < 765).count();
        assert_eq!((row, column), (602, 194), "600 × 200 with its frame, of which the page's first 220 rows hold 194");
    }
}
