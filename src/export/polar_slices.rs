//! Polar diagrams of a BRDF: its slices through the plane of incidence, as textbooks draw lobes.

use std::f64::consts::PI;

use glam::DVec2;
use image::{Rgb, RgbImage};

use super::lettering::{self, Align};
use super::page::{CURVES, GRID, LINE, NOTE, Page, TEXT, Unit};
use super::ticks::{number, round_below};
use crate::slope::direction;
use crate::verify::goniometer::table::BrdfTable;

/// Slices of a diagram: more cannot be told apart in it.
const MOST: usize = 7;
/// Of dashes, over the curve that they are compared with.
const DASHED: Rgb<u8> = Rgb([20, 20, 20]);
/// The diagram is drawn at one size only: its unit is the pixel.
const UNIT: Unit = Unit(1.0);
/// Radius of the diagram, and its centre on the page, pixels.
const RADIUS: f64 = 400.0;
const CENTRE: DVec2 = DVec2::new(500.0, 560.0);
/// Steps of a curve over 180°: a lobe of 0.2° is still drawn as one.
pub const STEPS: usize = 3600;
/// Decades that a logarithmic scale spans.
const DECADES: f64 = 4.0;

/// How far from the centre a value stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RadialScale {
    /// In proportion to the BRDF.
    Linear,
    /// In proportion to its logarithm, over four decades: the centre is 10⁻⁴ of the rim and less.
    #[default]
    Logarithmic,
}

/// A slice to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarCurve {
    /// Polar angle of the light, radians.
    pub theta: f64,
    /// Values over the viewer's angle from -90° to 90° in [`STEPS`] steps, 1/sr.
    pub values: Vec<f64>,
    /// Dashed and thinner: what another curve is to be compared with.
    pub dashed: bool,
}

/// Draws slices for light from the polar angles `theta_i` (radians, seven at most are drawn) and the azimuth `phi`.
///
/// Light comes from the right half of the plane of incidence; viewers on the other side of the normal, where mirrors
/// send it, are on the left. The small mark at the rim, in the curve's colour, is the light.
pub fn polar_slices(table: &BrdfTable, theta_i: &[f64], phi: f64, scale: RadialScale, heading: &str) -> RgbImage {
    let angle = |k: usize| (k as f64 / STEPS as f64 - 0.5) * PI;
    let curve = |&theta: &f64| {
        let values = (0..=STEPS).map(|k| table.at(direction(theta, phi), direction(angle(k), phi))).collect();
        PolarCurve { theta, values, dashed: false }
    };
    let curves: Vec<PolarCurve> = theta_i.iter().take(MOST).map(curve).collect();
    drawn(&curves, phi, scale, heading)
}

/// Draws slices for light from the azimuth `phi` on a logarithmic scale, those of one polar angle in one colour.
pub fn polar_diagram(curves: &[PolarCurve], phi: f64, heading: &str) -> RgbImage {
    drawn(curves, phi, RadialScale::Logarithmic, heading)
}

fn drawn(curves: &[PolarCurve], phi: f64, scale: RadialScale, heading: &str) -> RgbImage {
    let mut page = Page::new(1000, 720);
    let angle = |k: usize| (k as f64 / STEPS as f64 - 0.5) * PI;
    let mut shown: Vec<f64> = Vec::new();
    for curve in curves.iter().filter(|curve| !curve.dashed) {
        if !shown.contains(&curve.theta) && shown.len() < MOST {
            shown.push(curve.theta);
        }
    }
    let greatest = curves.iter().flat_map(|curve| &curve.values).copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let rim = rim(greatest, scale);
    let place = |value: f64, angle: f64| {
        let share = match scale {
            RadialScale::Linear => value / rim,
            RadialScale::Logarithmic if value > 0.0 => 1.0 + (value / rim).log10() / DECADES,
            RadialScale::Logarithmic => 0.0,
        };
        CENTRE + RADIUS * share.clamp(0.0, 1.0) * DVec2::new(angle.sin(), -angle.cos())
    };
    grid(&mut page, rim, scale);
    for curve in curves {
        let Some(colour) = shown.iter().position(|theta| *theta == curve.theta).map(|k| CURVES[k]) else { continue };
        let points: Vec<DVec2> = curve.values.iter().enumerate().map(|(k, value)| place(*value, angle(k))).collect();
        if curve.dashed {
            // A degree each, every other one.
            points.chunks(STEPS / 90).for_each(|dash| page.stroke(&dash[..dash.len().div_ceil(2)], 1.6, DASHED));
        } else {
            page.stroke(&points, 2.4, colour);
        }
        let toward = DVec2::new(curve.theta.sin(), -curve.theta.cos());
        page.stroke(&[CENTRE + (RADIUS - 8.0) * toward, CENTRE + (RADIUS + 8.0) * toward], 5.0, colour);
    }
    page.write_fitted(heading, (40.0, 46.0), UNIT.left(26.0, TEXT), 920.0);
    legend(&mut page, &shown);
    let scale = match scale {
        RadialScale::Linear => "linear".to_owned(),
        RadialScale::Logarithmic => format!("logarithmic, {DECADES} decades"),
    };
    let around = number((10.0 * phi.to_degrees()).round() / 10.0);
    let note =
        format!("BRDF in 1/sr over the viewer's angle in the plane of incidence, azimuth {around}° · scale {scale}");
    page.write_fitted(&note, (40.0, 676.0), UNIT.left(18.0, NOTE), 920.0);
    page.write_fitted("The light comes from the bold mark of each colour", (40.0, 702.0), UNIT.left(18.0, NOTE), 920.0);
    page.image
}

/// The colours and their angles.
fn legend(page: &mut Page, shown: &[f64]) {
    let mut x = 40.0;
    for (theta, colour) in shown.iter().zip(CURVES) {
        let label = format!("θi {}°", number((10.0 * theta.to_degrees()).round() / 10.0));
        page.stroke(&[DVec2::new(x, 79.0), DVec2::new(x + 26.0, 79.0)], 4.0, colour);
        page.write(&label, (x as f32 + 34.0, 85.0), UNIT.style(18.0, TEXT, Align::Left));
        x += 60.0 + f64::from(lettering::width(&label, 18.0));
    }
}

/// The value at the rim: the smallest of 1, 2, 4, 5 × 10^k not below the greatest value, or its power of ten.
fn rim(greatest: f64, scale: RadialScale) -> f64 {
    let Some(below) = round_below(greatest) else { return 1.0 };
    match scale {
        RadialScale::Linear => {
            [1.0, 2.0, 2.5].map(|m| m * below).into_iter().find(|v| *v >= greatest).unwrap_or(greatest)
        }
        RadialScale::Logarithmic => 10f64.powf(greatest.log10().ceil()),
    }
}

fn grid(page: &mut Page, rim: f64, scale: RadialScale) {
    let arc = |radius: f64| -> Vec<DVec2> {
        (0..=180).map(|k| CENTRE + radius * DVec2::from_angle(-PI * f64::from(k) / 180.0)).collect()
    };
    for k in 1..=4 {
        page.stroke(&arc(RADIUS * f64::from(k) / 4.0), 1.0, if k == 4 { LINE } else { GRID });
    }
    for degrees in (-90i32..=90).step_by(15) {
        let angle = f64::from(degrees).to_radians();
        let toward = DVec2::new(angle.sin(), -angle.cos());
        page.stroke(&[CENTRE, CENTRE + (RADIUS + 6.0) * toward], 1.0, if degrees.abs() == 90 { LINE } else { GRID });
        if degrees % 30 == 0 {
            let at = CENTRE + (RADIUS + 24.0) * toward;
            let align = [Align::Right, Align::Centre, Align::Left][(degrees.signum() + 1) as usize];
            let at = (at.x as f32 - 8.0 * degrees.signum() as f32, at.y as f32 + 6.0);
            page.write(&format!("{}°", number(f64::from(degrees))), at, UNIT.style(18.0, TEXT, align));
        }
    }
    for k in 0..=4 {
        let share = f64::from(k) / 4.0;
        let value = match scale {
            RadialScale::Linear => share * rim,
            RadialScale::Logarithmic => rim * 10f64.powf(DECADES * (share - 1.0)),
        };
        let at = CENTRE + DVec2::new(RADIUS * share, 0.0);
        page.stroke(&[at, at + DVec2::new(0.0, 6.0)], 1.0, LINE);
        page.write(&short_number(value), (at.x as f32, at.y as f32 + 26.0), UNIT.style(17.0, TEXT, Align::Centre));
    }
    page.write(
        "1/sr",
        (CENTRE.x as f32 + 0.5 * RADIUS as f32, CENTRE.y as f32 + 52.0),
        UNIT.style(17.0, NOTE, Align::Centre),
    );
}

/// A value of a scale in as few signs as it takes.
pub(super) fn short_number(value: f64) -> String {
    if value == 0.0 || (0.001..100_000.0).contains(&value) {
        number((value * 1000.0).round() / 1000.0)
    } else {
        format!("{value:.0e}").replace('-', "−")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::goniometer::table::BrdfAxes;

    fn table(f: impl Fn(glam::DVec3, glam::DVec3) -> f64 + Sync) -> BrdfTable {
        BrdfTable::from_fn(BrdfAxes::isotropic(vec![0.0, 0.7, 1.4], 64, 32).unwrap(), f)
    }

    /// Pixels of a colour along the ray from the centre at an angle: distances in pixels.
    fn found(page: &RgbImage, angle: f64, colour: Rgb<u8>) -> Vec<f64> {
        let toward = DVec2::new(angle.sin(), -angle.cos());
        let steps = (40..790).map(|k| 0.5 * f64::from(k));
        let pixel = |r: f64| {
            let at = CENTRE + r * toward;
            *page.get_pixel(at.x as u32, at.y as u32)
        };
        steps.filter(|r| pixel(*r) == colour).collect()
    }

    #[test]
    fn a_lobe_stands_where_its_value_says() {
        // 0.3 everywhere: on a linear scale up to 0.4 at three quarters, on a logarithmic one up to 1 at 1 + log(0.3)/4.
        let flat = table(|_, _| 0.3);
        for (scale, share) in [(RadialScale::Linear, 0.75), (RadialScale::Logarithmic, 1.0 + 0.3f64.log10() / 4.0)] {
            let page = polar_slices(&flat, &[0.0], 0.0, scale, "");
            for angle in [-1.2, -0.5, 0.45, 1.1] {
                let at = found(&page, angle, CURVES[0]);
                assert!(
                    !at.is_empty() && at.iter().all(|r| (r - share * RADIUS).abs() < 3.0),
                    "{scale:?} {angle} {at:?}"
                );
            }
        }
        // Light from the right is thrown to the left.
        let lobe = table(|wi, wo| 0.7 * f64::from(u8::from((wi + wo).normalize().z > 0.98)));
        let page = polar_slices(&lobe, &[0.7], 0.0, RadialScale::Linear, "");
        assert!(!found(&page, -0.72, CURVES[0]).is_empty() && found(&page, 0.3, CURVES[0]).is_empty());
    }

    #[test]
    fn scales_are_round_and_nothing_panics() {
        let rims = [0.4, 1.0, 0.26, 7.0, 0.0, f64::NAN].map(|v| rim(v, RadialScale::Linear));
        assert!(rims.iter().zip([0.4, 1.0, 0.4, 10.0, 1.0, 1.0]).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{rims:?}");
        assert_eq!([0.25, 0.0, 1000.0, 2e-5].map(short_number), ["0.25", "0", "1000", "2e−5"]);
        for scale in [RadialScale::Linear, RadialScale::Logarithmic] {
            let black = polar_slices(&table(|_, _| 0.0), &[0.1; 9], 0.3, scale, &"long heading ".repeat(50));
            assert_eq!(black.dimensions(), (1000, 720));
            polar_slices(&table(|_, _| 0.0), &[], f64::NAN, scale, "");
        }
    }
}
