//! The picture of a plan: light that is misplaced over hours, a line a cutter.

use glam::DVec2;
use image::RgbImage;

use super::lettering::Align;
use super::page::{CURVES, GRID, LINE, NOTE, PAGE, Page, TEXT, Unit};
use super::ticks::number;

/// The chart is drawn at one size only: its unit is the pixel.
const UNIT: Unit = Unit(1.0);

/// The diagram on the page: left, top, width, height, pixels.
const AREA: [f64; 4] = [110.0, 90.0, 820.0, 480.0];

/// What a chart shows; hours and shares of misplaced light, both above 0.
#[derive(Clone, Copy, Debug)]
pub struct PlanChart<'a> {
    /// For each cutter its name and its points, in the order of hours.
    pub lines: &'a [(String, Vec<[f64; 2]>)],
    /// Plates that were designed and proved.
    pub proved: &'a [[f64; 2]],
    /// Above.
    pub heading: &'a str,
    /// Below.
    pub note: &'a str,
}

impl PlanChart<'_> {
    /// Draws it.
    pub fn picture(&self) -> RgbImage {
        let mut page = Page::new(1000, 700);
        let sound = |point: &&[f64; 2]| point.iter().all(|v| v.is_finite() && *v > 0.0);
        let all: Vec<[f64; 2]> =
            self.lines.iter().flat_map(|(_, points)| points).chain(self.proved).filter(sound).copied().collect();
        let [hours, shares] = [0, 1].map(|axis| Decades::around(all.iter().map(|point| point[axis])));
        let [left, top, width, height] = AREA;
        let place = |[h, share]: [f64; 2]| {
            DVec2::new(left + width * hours.share(h), top + height * (1.0 - shares.share(share)))
        };
        for value in hours.marks() {
            let x = place([value, shares.low]).x;
            page.stroke(&[DVec2::new(x, top), DVec2::new(x, top + height)], 1.0, GRID);
            let at = (x as f32, (top + height) as f32 + 24.0);
            page.write(&number(value), at, UNIT.style(17.0, TEXT, Align::Centre));
        }
        for value in shares.marks() {
            let y = place([hours.low, value]).y;
            page.stroke(&[DVec2::new(left, y), DVec2::new(left + width, y)], 1.0, GRID);
            let label = format!("{} %", number(100.0 * value));
            page.write(&label, (left as f32 - 10.0, y as f32 + 6.0), UNIT.style(17.0, TEXT, Align::Right));
        }
        page.frame(AREA.map(|v| v as i64), 1, LINE);
        for ((_, points), colour) in self.lines.iter().zip(CURVES.iter().cycle()) {
            let points: Vec<DVec2> = points.iter().filter(sound).map(|point| place(*point)).collect();
            page.stroke(&points, 2.4, *colour);
        }
        for point in self.proved.iter().filter(sound) {
            let at = place(*point);
            let ring: Vec<DVec2> =
                (0..=24).map(|k| at + 7.0 * DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 24.0)).collect();
            page.stroke(&ring, 2.4, TEXT);
            page.fill([at.x as i64 - 2, at.y as i64 - 2, 4, 4], PAGE);
        }
        self.captions(&mut page);
        page.image
    }

    fn captions(&self, page: &mut Page) {
        let [left, top, width, height] = AREA;
        page.write_fitted(self.heading, (40.0, 40.0), UNIT.left(24.0, TEXT), 920.0);
        let mut x = left;
        for ((name, _), colour) in self.lines.iter().zip(CURVES.iter().cycle()) {
            page.stroke(&[DVec2::new(x, 69.0), DVec2::new(x + 22.0, 69.0)], 4.0, *colour);
            page.write(name, (x as f32 + 28.0, 75.0), UNIT.style(16.0, TEXT, Align::Left));
            x += 46.0 + f64::from(super::lettering::width(name, 16.0));
        }
        let middle = ((left + 0.5 * width) as f32, (top + height) as f32 + 52.0);
        page.write("hours of finishing", middle, UNIT.style(17.0, NOTE, Align::Centre));
        page.write_fitted(
            "Light misplaced at a blur of 1°, as made, in the mean over polish narrower, as meant and wider; rings: designed and proved",
            (40.0, 655.0),
            UNIT.left(17.0, NOTE),
            920.0,
        );
        page.write_fitted(self.note, (40.0, 682.0), UNIT.left(17.0, NOTE), 920.0);
    }
}

/// A logarithmic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Decades {
    low: f64,
    high: f64,
}

impl Decades {
    /// Around `values`, with a little room.
    fn around(values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = values.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], v| [low.min(v), high.max(v)]);
        if !(low > 0.0 && low <= high && high.is_finite()) {
            return Self { low: 0.1, high: 10.0 };
        }
        Self { low: low / 1.15, high: high * 1.15 }
    }

    fn share(self, value: f64) -> f64 {
        ((value / self.low).ln() / (self.high / self.low).ln()).clamp(0.0, 1.0)
    }

    /// 1, 2 and 5 × 10^k.
    fn marks(self) -> Vec<f64> {
        let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let all = decades.flat_map(|k| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(k)));
        all.filter(|v| (self.low..=self.high).contains(v)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stand_where_their_hours_and_figures_say() {
        let lines = [("ball:1".to_owned(), vec![[1.0, 0.1], [10.0, 0.01]])];
        let chart = PlanChart { lines: &lines, proved: &[], heading: "", note: "" };
        let page = chart.picture();
        // The axes reach 1.15 times beyond; halfway along both logarithms the line is in the middle.
        let [x, y] = [AREA[0] + 0.5 * AREA[2], AREA[1] + 0.5 * AREA[3]].map(|v| v as u32);
        assert!((y - 2..=y + 2).any(|y| *page.get_pixel(x, y) == CURVES[0]), "{:?}", page.get_pixel(x, y));
        let marks = Decades { low: 0.4, high: 25.0 }.marks();
        assert!(
            marks.iter().zip([0.5, 1.0, 2.0, 5.0, 10.0, 20.0]).all(|(a, b)| (a / b - 1.0).abs() < 1e-9),
            "{marks:?}"
        );
        let empty = PlanChart { lines: &[], proved: &[[f64::NAN, 0.0]], heading: &"long ".repeat(90), note: "" };
        assert_eq!(empty.picture().dimensions(), (1000, 700));
    }
}
