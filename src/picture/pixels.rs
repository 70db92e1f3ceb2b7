//! The numbers of a picture as they stand in its file, and how many there may be.

use image::metadata::Orientation;

use super::statement::Statement;
use super::{MAX_SIDE, PictureError};

/// The most a decoder may allocate, bytes.
pub(crate) const MAX_MEMORY: u64 = 1 << 30;

/// Pixels as the file has them: rows from the top, channels interleaved.
pub(crate) struct Pixels {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// 1 grey, 2 grey and opacity, 3 colour, 4 colour and opacity.
    pub channels: usize,
    /// `width * height * channels` numbers.
    pub samples: Samples,
    /// Whether the colours are multiplied by the opacity already.
    pub premultiplied: bool,
    /// What the file says its numbers mean as light.
    pub statement: Option<Statement>,
    /// What was decided while decoding, as sentences.
    pub notes: Vec<String>,
}

impl Pixels {
    /// Pixels of which the file says nothing more.
    pub(crate) fn plain((width, height): (usize, usize), channels: usize, samples: Samples) -> Self {
        Self { width, height, channels, samples, premultiplied: false, statement: None, notes: Vec::new() }
    }

    /// Turned and flipped as the camera noted.
    pub(crate) fn upright(self, orientation: Orientation) -> Self {
        let (w, h) = (self.width, self.height);
        // Where the pixel stands in the file that is to be seen at (x, y).
        let from: fn(usize, usize, usize, usize) -> (usize, usize) = match orientation {
            Orientation::NoTransforms => return self,
            Orientation::FlipHorizontal => |x, y, w, _| (w - 1 - x, y),
            Orientation::Rotate180 => |x, y, w, h| (w - 1 - x, h - 1 - y),
            Orientation::FlipVertical => |x, y, _, h| (x, h - 1 - y),
            Orientation::Rotate90FlipH => |x, y, _, _| (y, x),
            Orientation::Rotate90 => |x, y, _, h| (y, h - 1 - x),
            Orientation::Rotate270FlipH => |x, y, w, h| (w - 1 - y, h - 1 - x),
            Orientation::Rotate270 => |x, y, w, _| (w - 1 - y, x),
        };
        let turned = matches!(
            orientation,
            Orientation::Rotate90 | Orientation::Rotate270 | Orientation::Rotate90FlipH | Orientation::Rotate270FlipH
        );
        let (width, height) = if turned { (h, w) } else { (w, h) };
        let place = |k: usize| {
            let (x, y) = from(k % width, k / width, w, h);
            (x + w * y) * self.channels
        };
        let samples = self.samples.gathered(self.channels, width * height, place);
        Self { width, height, samples, ..self }
    }
}

/// Numbers of one depth.
pub(crate) enum Samples {
    /// White is 255.
    U8(Vec<u8>),
    /// White is 65535.
    U16(Vec<u16>),
    /// White is 1.
    F32(Vec<f32>),
    /// White is 1.
    F64(Vec<f64>),
}

impl Samples {
    /// How many numbers there are.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::U8(v) => v.len(),
            Self::U16(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::F64(v) => v.len(),
        }
    }

    /// Number `i`, white being 1.
    pub(crate) fn at(&self, i: usize) -> f64 {
        match self {
            Self::U8(v) => f64::from(v[i]) / 255.0,
            Self::U16(v) => f64::from(v[i]) / 65535.0,
            Self::F32(v) => f64::from(v[i]),
            Self::F64(v) => v[i],
        }
    }

    /// Makes white of what the file says is `white`, unless its decoder has done so.
    pub(crate) fn whiten(&mut self, white: u32) {
        let most = match self {
            Self::U8(v) => v.iter().max().map_or(0, |most| u32::from(*most)),
            Self::U16(v) => v.iter().max().map_or(0, |most| u32::from(*most)),
            _ => return,
        };
        if white == 0 || most > white {
            return;
        }
        let scaled = |value: u32, full: u32| (value * full + white / 2) / white;
        match self {
            Self::U8(v) if white < 255 => v.iter_mut().for_each(|v| *v = scaled((*v).into(), 255) as u8),
            Self::U16(v) if white < 65535 => v.iter_mut().for_each(|v| *v = scaled((*v).into(), 65535) as u16),
            _ => {}
        }
    }

    /// `count` groups of `size` numbers, group k from the one that begins at `place(k)`.
    pub(crate) fn gathered(&self, size: usize, count: usize, place: impl Fn(usize) -> usize) -> Self {
        fn pick<T: Copy>(all: &[T], size: usize, count: usize, place: impl Fn(usize) -> usize) -> Vec<T> {
            (0..count).flat_map(|k| all[place(k)..place(k) + size].iter().copied()).collect()
        }
        match self {
            Self::U8(v) => Self::U8(pick(v, size, count, place)),
            Self::U16(v) => Self::U16(pick(v, size, count, place)),
            Self::F32(v) => Self::F32(pick(v, size, count, place)),
            Self::F64(v) => Self::F64(pick(v, size, count, place)),
        }
    }
}

/// Refuses what is too large to hold or too small to draw on.
pub(crate) fn check_size(width: u64, height: u64, name: &str) -> Result<(), PictureError> {
    let name = name.into();
    if width.max(height) > MAX_SIDE as u64 {
        Err(PictureError::TooLarge { name, width, height })
    } else if width.min(height) < 2 {
        Err(PictureError::TooSmall { name, width, height })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use image::{DynamicImage, GrayImage, Luma};

    use super::*;

    #[test]
    fn every_orientation_is_that_of_the_general_decoder() {
        let grey = GrayImage::from_fn(3, 2, |x, y| Luma([(x + 10 * y) as u8]));
        for code in 1..=8 {
            let orientation = Orientation::from_exif(code).unwrap();
            let mut wanted = DynamicImage::from(grey.clone());
            wanted.apply_orientation(orientation);
            let got = Pixels::plain((3, 2), 1, Samples::U8(grey.as_raw().clone())).upright(orientation);
            assert_eq!((got.width as u32, got.height as u32), (wanted.width(), wanted.height()), "{code}");
            let Samples::U8(values) = got.samples else { panic!("depth") };
            assert_eq!(values, wanted.into_luma8().into_raw(), "{code}");
        }
    }
}
