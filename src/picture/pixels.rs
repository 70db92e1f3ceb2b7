//! The numbers of a picture as they stand in its file, and how many there may be.

use super::{MAX_SIDE, PictureError};

/// The most a decoder may allocate, bytes.
pub(crate) const MAX_MEMORY: u64 = 1 << 30;

/// Pixels as the file has them: rows from the top, channels interleaved.
pub struct Pixels {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// 1 grey, 2 grey and opacity, 3 colour, 4 colour and opacity.
    pub channels: usize,
    /// `width * height * channels` numbers.
    pub samples: Samples,
    /// What was decided while decoding, as sentences.
    pub notes: Vec<String>,
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
    pub fn len(&self) -> usize {
        match self {
            Self::U8(v) => v.len(),
            Self::U16(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::F64(v) => v.len(),
        }
    }

    /// Number `i`, white being 1.
    pub fn at(&self, i: usize) -> f64 {
        match self {
            Self::U8(v) => f64::from(v[i]) / 255.0,
            Self::U16(v) => f64::from(v[i]) / 65535.0,
            Self::F32(v) => f64::from(v[i]),
            Self::F64(v) => v[i],
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

/// A decoder's words fit for a message of one line; a damaged file can put anything into them.
pub fn one_line(words: &dyn std::fmt::Display) -> String {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    words.to_string().chars().map(plain).take(160).collect()
}
