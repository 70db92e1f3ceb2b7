//! Maps of a BRDF: for each light one disc, the hemisphere of viewers seen from above the plate.

use glam::{DVec2, DVec3};
use image::{Rgb, RgbImage};
use rayon::prelude::*;

use super::lettering::Align;
use super::page::{GRID_ON_GREY, LAMP_DOT, NOTE, PAGE, Page, TEXT, Unit};
use super::pixels::{common_white, tone_mapped};
use super::polar_slices::short_number;
use super::ticks::number;
use crate::raster::Raster;
use crate::slope::direction;
use crate::verify::goniometer::table::BrdfTable;

/// Maps are drawn at one size only: their unit is the pixel.
const UNIT: Unit = Unit(1.0);
/// Side of a disc, pixels.
const SIDE: usize = 256;
/// From one disc to the next in its row, and the upper left corner of the first, pixels.
const PITCH: usize = SIDE + 56;
const LEFT: usize = 40;
const TOP: usize = 96;
/// Discs to a row.
const ACROSS: usize = 4;

/// Draws a disc for each of `lights` (θi, φi in radians; 24 at most), orthographic: x right, y up, the horizon as rim.
///
/// Brightness is the BRDF, in the sRGB curve, white the same for all discs: the value that 99.5 % of what is lit in
/// them together stays below. It is stated below. The dot is the light.
pub fn hemisphere_maps(table: &BrdfTable, lights: &[(f64, f64)], heading: &str) -> RgbImage {
    let lights = &lights[..lights.len().min(24)];
    let discs: Vec<Raster> = lights.par_iter().map(|&(theta, phi)| disc(table, direction(theta, phi))).collect();
    let all = discs.iter().flat_map(|d| d.values.iter().copied().filter(|v| v.is_finite())).collect::<Vec<f64>>();
    let white = common_white(&Raster { width: all.len(), height: 1, values: all });
    let (across, down) = (lights.len().clamp(1, ACROSS), lights.len().div_ceil(ACROSS).max(1));
    let (width, height) = (2 * LEFT + across * PITCH - 56, TOP + down * (SIDE + 70) + 60);
    let mut page = Page::new(width as i64, height as i64);
    for (k, (disc, &(theta, phi))) in discs.iter().zip(lights).enumerate() {
        let (x, y) = (LEFT + k % ACROSS * PITCH, TOP + k / ACROSS * (SIDE + 70));
        let grey = tone_mapped(disc, white);
        for (column, row, pixel) in grey.enumerate_pixels() {
            if !disc.at(column as usize, row as usize).is_nan() {
                page.image.put_pixel(x as u32 + column, y as u32 + row, Rgb([pixel.0[0]; 3]));
            }
        }
        rings(&mut page, DVec2::new(x as f64, y as f64) + 0.5 * SIDE as f64, theta, phi);
        let rounded = |angle: f64| number((10.0 * angle.to_degrees()).round() / 10.0);
        let label = format!("light at {}°, azimuth {}°", rounded(theta), rounded(phi));
        page.write(&label, ((x + SIDE / 2) as f32, (y + SIDE + 34) as f32), UNIT.style(18.0, TEXT, Align::Centre));
    }
    let room = (width - 2 * LEFT) as f32;
    page.write_fitted(heading, (LEFT as f32, 46.0), UNIT.left(26.0, TEXT), room);
    let foot = (height - 50) as f32;
    let exposure =
        format!("White is {} 1/sr in every disc, sRGB curve · orange: the light", short_number(rounded_to_3(white)));
    page.write_fitted(&exposure, (LEFT as f32, foot), UNIT.left(18.0, NOTE), room);
    let reading = "Viewers seen from above, x right, y up; circles at 30°, 60° and the horizon (orthographic)";
    page.write_fitted(reading, (LEFT as f32, foot + 26.0), UNIT.left(18.0, NOTE), room);
    page.image
}

/// The BRDF over the disc of viewers; NaN outside the disc.
fn disc(table: &BrdfTable, light: DVec3) -> Raster {
    // Four samples a pixel: narrow lobes must not slip between the pixels.
    let value = |x: f64, y: f64| {
        let (x, y) = (2.0 * x / SIDE as f64 - 1.0, 1.0 - 2.0 * y / SIDE as f64);
        let rest = 1.0 - x * x - y * y;
        (rest > 0.0).then(|| table.at(light, DVec3::new(x, y, rest.sqrt())))
    };
    Raster::from_fn(SIDE, SIDE, |column, row| {
        let samples = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)];
        let seen: Vec<f64> = samples.iter().filter_map(|(dx, dy)| value(column as f64 + dx, row as f64 + dy)).collect();
        if seen.is_empty() { f64::NAN } else { seen.iter().sum::<f64>() / seen.len() as f64 }
    })
}

fn rings(page: &mut Page, centre: DVec2, theta: f64, phi: f64) {
    let half = 0.5 * SIDE as f64;
    let ring = |radius: f64| -> Vec<DVec2> {
        (0..=180).map(|k| centre + radius * DVec2::from_angle(f64::from(2 * k).to_radians())).collect()
    };
    for (degrees, wide) in [(30.0f64, 0.7), (60.0, 0.7), (90.0, 1.4)] {
        page.stroke(&ring(half * degrees.to_radians().sin()), wide, GRID_ON_GREY);
    }
    for k in 0..12 {
        let toward = DVec2::from_angle(f64::from(30 * k).to_radians());
        page.stroke(&[centre + half * toward, centre + (half + 5.0) * toward], 1.0, GRID_ON_GREY);
    }
    for (degrees, at) in [(0, (half + 8.0, 5.0)), (90, (0.0, -half - 8.0))] {
        let at = centre + DVec2::new(at.0, at.1);
        let align = if degrees == 0 { Align::Left } else { Align::Centre };
        page.write(&format!("{degrees}°"), (at.x as f32, at.y as f32), UNIT.style(14.0, NOTE, align));
    }
    let lamp = direction(theta, phi);
    let lamp = centre + half * DVec2::new(lamp.x, -lamp.y);
    page.stroke(&[lamp, lamp], 9.0, PAGE);
    page.stroke(&[lamp, lamp], 6.0, LAMP_DOT);
}

fn rounded_to_3(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 0.0;
    }
    let unit = 10f64.powf(value.log10().floor() - 2.0);
    (value / unit).round() * unit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::goniometer::table::BrdfAxes;

    #[test]
    fn a_lobe_lies_across_from_its_light_seen_from_above() {
        let axes = BrdfAxes::anisotropic(vec![0.0, 0.4, 0.8], 8, 64, 64).unwrap();
        let table = BrdfTable::from_fn(axes, |wi, wo| (-(1.0 - (wi + wo).normalize().z) / 0.003).exp());
        let light = direction(0.6, 0.9);
        let map = disc(&table, light);
        let brightest = (0..SIDE * SIDE).max_by(|a, b| {
            let value = |k: usize| if map.values[k].is_nan() { -1.0 } else { map.values[k] };
            value(*a).total_cmp(&value(*b))
        });
        let brightest = brightest.unwrap();
        let (x, y) = ((brightest % SIDE) as f64, (brightest / SIDE) as f64);
        assert!((x - 128.0 * (1.0 - light.x)).abs() < 5.0 && (y - 128.0 * (1.0 + light.y)).abs() < 5.0, "{x} {y}");
        assert!(map.at(0, 0).is_nan() && !map.at(128, 2).is_nan());
        let page = hemisphere_maps(&table, &[(0.6, 0.9); 5], "five");
        let lamp = (LEFT as f64 + 128.0 * (1.0 + light.x), TOP as f64 + 128.0 * (1.0 - light.y));
        assert_eq!(page.get_pixel(lamp.0 as u32, lamp.1 as u32), &LAMP_DOT);
        assert_eq!(page.height() as usize, TOP + 2 * (SIDE + 70) + 60);
    }

    #[test]
    fn nothing_panics_on_odd_requests() {
        let axes = BrdfAxes::isotropic(vec![0.0, 0.4], 8, 8).unwrap();
        let black = BrdfTable::from_fn(axes.clone(), |_, _| 0.0);
        hemisphere_maps(&black, &[], &"long heading ".repeat(50));
        hemisphere_maps(&BrdfTable::new(axes), &[(0.2, 0.0), (f64::NAN, 9.0)], "");
    }
}
