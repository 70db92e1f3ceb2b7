//! The picture that is wanted on a plate of patches, what a viewer sees, and their difference, patch by patch.

use image::{GrayImage, Luma, Rgb, RgbImage};

use super::page::{LINE, NOTE, Page, TEXT, Unit, pixel};
use super::pixels::{diverging, tone_mapped};
use crate::raster::Raster;

/// The difference at which colours are full, as a share of white.
const FULL: f64 = 0.2;

/// What stands on the page.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatchPage<'a> {
    /// Radiance of each patch as wanted.
    pub wanted: &'a Raster,
    /// As seen, in the same unit.
    pub seen: &'a Raster,
    /// Over all.
    pub heading: &'a str,
    /// Under the panels.
    pub notes: &'a [String],
}

impl PatchPage<'_> {
    /// Draws the page; each patch is a whole number of pixels.
    pub fn picture(&self) -> RgbImage {
        let (columns, rows) = (self.wanted.width.max(1), self.wanted.height.max(1));
        let times = 384usize.div_ceil(columns.max(rows)).max(1) as u32;
        let (width, height) = (i64::from(columns as u32 * times), i64::from(rows as u32 * times));
        let unit = Unit((width.max(height) as f64 / 512.0).max(0.75));
        let px = |length| unit.px(length);
        let (margin, top) = (px(28.0), px(96.0));
        let below = top + height + px(38.0);
        let mut page = Page::new(4 * margin + 3 * width, below + (self.notes.len() as i64 + 1) * px(26.0));
        let white = self.wanted.max();
        let grey = [self.wanted, self.seen].map(|raster| tone_mapped(raster, white));
        let enlarged = |picture: &GrayImage| {
            GrayImage::from_fn(width as u32, height as u32, |x, y| *picture.get_pixel(x / times, y / times))
        };
        for (k, (title, picture)) in ["wanted", "seen"].into_iter().zip(&grey).enumerate() {
            let left = margin + k as i64 * (width + margin);
            page.put(&enlarged(picture), (left, top), |Luma([value])| Rgb([value; 3]));
            page.frame([left, top, width, height], unit.hair(), LINE);
            page.write(title, pixel(left, top - px(12.0)), unit.left(20.0, TEXT));
        }
        let left = margin + 2 * (width + margin);
        let difference = RgbImage::from_fn(width as u32, height as u32, |x, y| {
            let (x, y) = ((x / times) as usize, (y / times) as usize);
            diverging((self.seen.at(x, y) - self.wanted.at(x, y)) / (FULL * white))
        });
        page.put(&difference, (left, top), |colour| colour);
        page.frame([left, top, width, height], unit.hair(), LINE);
        let title = "seen - wanted, full colours at 20 % of white";
        page.write_fitted(title, pixel(left, top - px(12.0)), unit.left(20.0, TEXT), width as f32);
        let room = (3 * width + 2 * margin) as f32;
        page.write_fitted(self.heading, pixel(margin, px(44.0)), unit.left(26.0, TEXT), room);
        for (k, note) in self.notes.iter().enumerate() {
            page.write_fitted(note, pixel(margin, below + k as i64 * px(26.0)), unit.left(17.0, NOTE), room);
        }
        page.image
    }
}

/// A picture of one grey for each patch, enlarged to whole pixels; `white` and above are white.
pub(crate) fn patch_picture(radiance: &Raster, white: f64) -> GrayImage {
    let times = 384usize.div_ceil(radiance.width.max(radiance.height).max(1)).max(1) as u32;
    let grey = tone_mapped(radiance, white);
    GrayImage::from_fn(grey.width() * times, grey.height() * times, |x, y| *grey.get_pixel(x / times, y / times))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_panels_show_wanted_seen_and_where_they_differ() {
        let wanted = Raster::from_fn(4, 2, |x, _| x as f64);
        let seen = Raster::from_fn(4, 2, |x, y| if (x, y) == (1, 0) { 2.0 } else { x as f64 });
        let notes = ["a note".to_owned()];
        let page = PatchPage { wanted: &wanted, seen: &seen, heading: "A plate", notes: &notes }.picture();
        // Patches of 96 pixels; margins of 28 and 96 in units of 384/512.
        let (margin, top) = (21, 72);
        let at = |panel: u32, column: u32, row: u32| {
            *page.get_pixel(margin + panel * (384 + margin) + 96 * column + 48, top + 96 * row + 48)
        };
        assert_eq!((at(0, 3, 0), at(0, 0, 1)), (Rgb([255; 3]), Rgb([0; 3])));
        assert_eq!((at(1, 1, 0), at(1, 1, 1)), (at(0, 2, 0), at(0, 1, 0)));
        let Rgb([red, _, blue]) = at(2, 1, 0);
        assert!(red > blue && at(2, 1, 1) == Rgb([255; 3]), "{red} {blue}");
        assert_eq!(patch_picture(&wanted, 3.0).dimensions(), (384, 192));
    }
}
