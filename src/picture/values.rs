//! A picture as plain numbers, for maps whose colours are no light.

use std::path::Path;

use super::{MAX_FILE, PictureError, decode};
use crate::raster::Raster;

/// Red, green and blue of the picture at `path` as its pixels have them, white being 1, row 0 on top; grey counts as all
/// three, and opacity does not count.
///
/// # Errors
/// It is no file, cannot be read, is no picture, is damaged or larger than [`MAX_FILE`].
pub fn values(path: &Path) -> Result<[Raster; 3], PictureError> {
    let name = path.display().to_string();
    let unreadable = |source: std::io::Error| match source.kind() {
        std::io::ErrorKind::NotFound => PictureError::Missing { name: path.display().to_string() },
        _ => PictureError::Unreadable { name: path.display().to_string(), source },
    };
    let about = path.metadata().map_err(unreadable)?;
    if !about.is_file() {
        let found = if about.is_dir() { "a directory" } else { "a device or a pipe" };
        return Err(PictureError::NotAFile { name, found });
    }
    if about.len() > MAX_FILE {
        return Err(PictureError::Heavy { name, megabytes: about.len() >> 20 });
    }
    let pixels = decode::decode(&std::fs::read(path).map_err(unreadable)?, &name)?;
    let (width, height) = (pixels.width, pixels.height);
    Ok([0, 1, 2].map(|channel| {
        let channel = if pixels.channels < 3 { 0 } else { channel };
        let at = |k: usize| pixels.samples.at(k * pixels.channels + channel);
        // What is no number says nothing.
        let number = |value: f64| if value.is_finite() { value } else { 0.0 };
        Raster { width, height, values: (0..width * height).map(|k| number(at(k))).collect() }
    }))
}
