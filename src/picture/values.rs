//! A picture as plain numbers, for maps whose colours are no light.

use std::io::Read;
use std::path::Path;

use super::opened::{opened, unreadable};
use super::{PictureError, decode};
use crate::raster::Raster;

/// Red, green and blue of the picture at `path` as its pixels have them, white being 1, row 0 on top; grey counts as all
/// three, and opacity does not count.
///
/// # Errors
/// It is no file, cannot be read, is no picture, is damaged or larger than [`MAX_FILE`](super::MAX_FILE).
pub fn values(path: &Path) -> Result<[Raster; 3], PictureError> {
    let mut bytes = Vec::new();
    opened(path)?.read_to_end(&mut bytes).map_err(|source| unreadable(path, source))?;
    let pixels = decode::decode(&bytes, &path.display().to_string())?;
    let (width, height) = (pixels.width, pixels.height);
    Ok([0, 1, 2].map(|channel| {
        let channel = if pixels.channels < 3 { 0 } else { channel };
        let at = |k: usize| pixels.samples.at(k * pixels.channels + channel);
        // What is no number says nothing.
        let number = |value: f64| if value.is_finite() { value } else { 0.0 };
        Raster { width, height, values: (0..width * height).map(|k| number(at(k))).collect() }
    }))
}
