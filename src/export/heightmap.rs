//! The relief as a 16-bit grey picture for programs that carve from height maps, with the scale that a PNG cannot hold.

use std::io::{self, Seek, Write};

use glam::DVec2;
use image::{ImageBuffer, Luma};
use serde::{Deserialize, Serialize};
use tiff::encoder::colortype::Gray16;
use tiff::encoder::{Rational, TiffEncoder};
use tiff::tags::{ResolutionUnit, Tag};

use crate::progress::{Cancelled, Progress};
use crate::relief::faceted::FacetedRelief;

/// A picture of heights and what its grey levels mean.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// White is high; the top row is the highest y.
    pub image: ImageBuffer<Luma<u16>, Vec<u16>>,
    /// The scale, to be written beside the picture.
    pub sidecar: HeightScale,
}

/// What a height map's pixels mean, for a JSON file beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeightScale {
    /// Unit of every length here: "mm".
    pub units: String,
    /// Columns of the picture.
    pub width: u32,
    /// Rows of the picture.
    pub height: u32,
    /// Distance between neighbouring pixel centres along x and y, mm.
    pub mm_per_pixel: [f64; 2],
    /// Height of grey level 0, mm.
    pub z_low_mm: f64,
    /// Height of grey level 65535, mm; equal to `z_low_mm` on a flat plate.
    pub z_high_mm: f64,
    /// Height from grey level, in words.
    pub formula: String,
    /// Which way the rows run, in words.
    pub row_order: String,
    /// The lower-left corner of the picture (a pixel's corner, not its centre) on the plate, mm.
    pub lower_left_mm: [f64; 2],
    /// Where the plate's origin lies, in words.
    pub origin: String,
    /// What the shop has to know of the plate's rim, in words, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim: Option<String>,
}

impl HeightScale {
    /// Height of a grey level, mm: the formula of the sidecar.
    pub fn height_mm(&self, value: u16) -> f64 {
        self.z_low_mm + f64::from(value) / 65535.0 * (self.z_high_mm - self.z_low_mm)
    }
}

impl HeightMap {
    /// Writes picture and scale as one TIFF file of 16 bits: the scale as JSON in its description, and its pixels to the
    /// centimetre.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_tiff(&self, out: &mut (impl Write + Seek)) -> io::Result<()> {
        let HeightScale { width, height, mm_per_pixel, .. } = self.sidecar;
        let mut file = TiffEncoder::new(out).map_err(io::Error::other)?;
        let mut image = file.new_image::<Gray16>(width, height).map_err(io::Error::other)?;
        let description = ascii(&serde_json::to_string(&self.sidecar).map_err(io::Error::other)?);
        image.encoder().write_tag(Tag::ImageDescription, description.as_str()).map_err(io::Error::other)?;
        let program = concat!("facetmill ", env!("CARGO_PKG_VERSION"));
        image.encoder().write_tag(Tag::Software, program).map_err(io::Error::other)?;
        let [x, y] = mm_per_pixel.map(pixels_per_centimetre);
        image.resolution_unit(ResolutionUnit::Centimeter);
        image.x_resolution(x);
        image.y_resolution(y);
        image.write_data(&self.image).map_err(io::Error::other)
    }
}

/// Pixels to the centimetre as TIFF holds them, to a millionth.
fn pixels_per_centimetre(mm_per_pixel: f64) -> Rational {
    let exact = 10.0 / mm_per_pixel;
    // As many digits as fit 32 bits; the cast saturates.
    let denominator = [1_000_000_u32, 10_000, 100, 1].into_iter().find(|d| exact * f64::from(*d) < 4e9).unwrap_or(1);
    Rational { n: (exact * f64::from(denominator)).round() as u32, d: denominator }
}

/// JSON in which all that is not ASCII is escaped, as descriptions in TIFF must be.
fn ascii(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    let mut units = [0; 2];
    for c in json.chars() {
        match c.is_ascii() {
            true => text.push(c),
            false => c.encode_utf16(&mut units).iter().for_each(|unit| text += &format!("\\u{unit:04x}")),
        }
    }
    text
}

/// The heights of the whole relief, rim included, at the centres of pixels, taken exactly from the facets' planes.
///
/// The plate's longer side gets `pixels_per_side_max` pixels (1 to 65535), the shorter as many as keep the pixels
/// as square as whole numbers allow. On a grid line the facet with the higher x or y counts.
pub fn height_map(
    relief: &FacetedRelief,
    pixels_per_side_max: usize,
    progress: &Progress,
) -> Result<HeightMap, Cancelled> {
    let (low, high) = relief.bounds();
    let size = (high - low).truncate();
    let [width, height] = pixel_counts(size, pixels_per_side_max);
    let pixel = size / DVec2::new(f64::from(width), f64::from(height));
    let columns: Vec<_> =
        (0..width).map(|c| low.x + (f64::from(c) + 0.5) * pixel.x).map(|x| (x, interval(&relief.x, x))).collect();
    let range = high.z - low.z;
    let steps_per_mm = if range > 0.0 { 65535.0 / range } else { 0.0 };
    let mut image = ImageBuffer::new(width, height);
    for (r, row) in image.rows_mut().enumerate() {
        progress.check()?;
        let y = high.y - (r as f64 + 0.5) * pixel.y;
        let j = interval(&relief.y, y);
        for (grey, &(x, i)) in row.zip(&columns) {
            let z = relief.plane_height(i, j, DVec2::new(x, y));
            // The cast saturates: rounding errors at the ends of the range cannot wrap around.
            *grey = Luma([((z - low.z) * steps_per_mm).round() as u16]);
        }
    }
    let sidecar = HeightScale {
        units: "mm".to_owned(),
        width,
        height,
        mm_per_pixel: pixel.to_array(),
        z_low_mm: low.z,
        z_high_mm: high.z,
        formula: "z = z_low_mm + value / 65535 * (z_high_mm - z_low_mm)".to_owned(),
        row_order: "top row is highest y (image convention)".to_owned(),
        lower_left_mm: [low.x, low.y],
        origin: "lower-left corner of the optical area is x = y = 0; x right, y up".to_owned(),
        rim: None,
    };
    Ok(HeightMap { image, sidecar })
}

/// Columns and rows of a picture of something `size` large whose longer side has `longer` pixels; at least one each.
pub(super) fn pixel_counts(size: DVec2, longer: usize) -> [u32; 2] {
    let longer = longer.clamp(1, 65535) as f64;
    let longest = size.max_element();
    // A size that is not a number falls through the cast as 0.
    size.to_array().map(|side| ((side / longest * longer).round() as u32).clamp(1, longer as u32))
}

/// Which interval of the ascending `lines` holds `at`: the upper one on a line, the nearest outside.
pub(super) fn interval(lines: &[f64], at: f64) -> usize {
    let above = lines.partition_point(|line| *line <= at);
    above.clamp(1, lines.len().max(2) - 1) - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relief::faceted::Facet;
    use crate::slope::Slope;

    fn mapped(relief: &FacetedRelief, pixels: usize) -> HeightMap {
        height_map(relief, pixels, &Progress::silent()).unwrap()
    }

    fn plane(slope: Slope, columns: usize, rows: usize, size: DVec2) -> FacetedRelief {
        let mut relief =
            FacetedRelief::uniform(columns, rows, size, vec![Facet { height: 0.0, slope }; columns * rows]);
        for j in 0..rows {
            for i in 0..columns {
                relief.facets[j * columns + i].height = slope.to_vec().dot(relief.middle(i, j));
            }
        }
        relief
    }

    #[test]
    fn bright_is_high_up_is_up_and_right_is_right() {
        let size = DVec2::new(3.0, 2.0);
        let up = mapped(&plane(Slope::new(0.0, 0.5), 3, 2, size), 30).image;
        assert_eq!(up.dimensions(), (30, 20));
        assert!(up.get_pixel(7, 0).0 > up.get_pixel(7, 1).0);
        assert!(up.get_pixel(7, 0).0[0] > 63_000 && up.get_pixel(7, 19).0[0] < 2_000);
        assert_eq!(up.get_pixel(0, 5), up.get_pixel(29, 5));
        let right = mapped(&plane(Slope::new(0.5, 0.0), 3, 2, size), 30).image;
        assert!(right.get_pixel(29, 4).0[0] > 64_000 && right.get_pixel(0, 4).0[0] < 1_200);
        assert_eq!(right.get_pixel(11, 0), right.get_pixel(11, 19));
    }

    #[test]
    fn heights_come_back_within_half_a_step() {
        // Uneven steps between facets, and a rim.
        let facets = (0..35)
            .map(|k| Facet {
                height: f64::from(k * 17 % 11) * 0.01,
                slope: Slope::new(f64::from(k % 5) * 0.05 - 0.1, f64::from(k % 7) * 0.03 - 0.1),
            })
            .collect();
        let relief = FacetedRelief::uniform(7, 5, DVec2::new(14.0, 9.0), facets).with_rim(1.5);
        let HeightMap { image, sidecar } = mapped(&relief, 171);
        assert_eq!((sidecar.width, sidecar.height), image.dimensions());
        assert_eq!((sidecar.width, sidecar.height), (171, 121));
        let half_step = (sidecar.z_high_mm - sidecar.z_low_mm) / 65535.0 / 2.0;
        for (c, r, grey) in image.enumerate_pixels() {
            let x = sidecar.lower_left_mm[0] + (f64::from(c) + 0.5) * sidecar.mm_per_pixel[0];
            let y = sidecar.lower_left_mm[1] + (f64::from(sidecar.height - r) - 0.5) * sidecar.mm_per_pixel[1];
            let i = relief.x.iter().rposition(|line| *line <= x).unwrap();
            let j = relief.y.iter().rposition(|line| *line <= y).unwrap();
            let z = relief.plane_height(i, j, DVec2::new(x, y));
            assert!((sidecar.height_mm(grey.0[0]) - z).abs() <= half_step * (1.0 + 1e-6), "{c} {r}");
        }
    }

    #[test]
    fn a_tiff_holds_the_same_heights_and_their_scale() {
        let mut map = mapped(&plane(Slope::new(0.1, 0.2), 2, 3, DVec2::new(3.0, 2.0)), 30);
        map.sidecar.rim = Some("falling by 3.5°".into());
        let mut file = std::io::Cursor::new(Vec::new());
        map.write_tiff(&mut file).unwrap();
        file.set_position(0);
        let mut read = tiff::decoder::Decoder::new(file).unwrap();
        let text = read.get_tag_ascii_string(Tag::ImageDescription).unwrap();
        assert!(text.is_ascii());
        assert_eq!(serde_json::from_str::<HeightScale>(&text).unwrap(), map.sidecar);
        let resolution = read.get_tag(Tag::XResolution).unwrap();
        assert_eq!(format!("{resolution:?}"), "Rational(100000000, 1000000)");
        let tiff::decoder::DecodingResult::U16(values) = read.read_image().unwrap() else { panic!() };
        assert_eq!(&values, map.image.as_raw());
    }

    #[test]
    fn a_flat_plate_is_black_and_says_one_height() {
        let facets = vec![Facet { height: 0.7, slope: Slope::FLAT }];
        let map = mapped(&FacetedRelief::uniform(1, 1, DVec2::new(5.0, 5.0), facets), 4);
        assert!(map.image.pixels().all(|p| p.0 == [0]));
        assert_eq!((map.sidecar.z_low_mm, map.sidecar.z_high_mm), (0.7, 0.7));
        assert_eq!(map.sidecar.height_mm(12_345), 0.7);
    }

    #[test]
    fn sizes_keep_the_aspect_and_at_least_a_pixel() {
        assert_eq!(pixel_counts(DVec2::new(30.0, 20.0), 300), [300, 200]);
        assert_eq!(pixel_counts(DVec2::new(1.0, 1000.0), 100), [1, 100]);
        assert_eq!(pixel_counts(DVec2::new(1.0, 1.0), 0), [1, 1]);
        assert_eq!(pixel_counts(DVec2::NAN, 10), [1, 1]);
        let lines = [0.0, 1.0, 3.0];
        assert_eq!([-1.0, 0.0, 0.9, 1.0, 2.9, 3.0, 9.0].map(|at| interval(&lines, at)), [0, 0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn the_sidecar_survives_json() {
        let sidecar = mapped(&plane(Slope::new(0.1, 0.2), 2, 2, DVec2::ONE), 8).sidecar;
        let text = serde_json::to_string_pretty(&sidecar).unwrap();
        assert!(text.contains("\"mm_per_pixel\""));
        assert_eq!(serde_json::from_str::<HeightScale>(&text).unwrap(), sidecar);
    }
}
