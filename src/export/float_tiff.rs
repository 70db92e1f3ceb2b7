//! Rasters with all their digits: grey TIFF of 32-bit floats, which ImageJ, Python and facetmill itself read.

use std::io::{self, Seek, Write};

use tiff::encoder::{TiffEncoder, colortype::Gray32Float};

use crate::raster::Raster;

/// Writes `raster` row by row, the uppermost first.
pub fn write_float_tiff(raster: &Raster, out: &mut (impl Write + Seek)) -> io::Result<()> {
    let values: Vec<f32> = raster.values.iter().map(|&v| v as f32).collect();
    let mut encoder = TiffEncoder::new(out).map_err(io::Error::other)?;
    encoder.write_image::<Gray32Float>(raster.width as u32, raster.height as u32, &values).map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::picture::{Reading, read};

    #[test]
    fn what_is_written_is_read() {
        let raster = Raster::from_fn(32, 32, |x, y| (x + 32 * y) as f64 * 1e-3);
        let mut file = Cursor::new(Vec::new());
        write_float_tiff(&raster, &mut file).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.tiff");
        std::fs::write(&path, file.into_inner()).unwrap();
        let picture = read(&path, &Reading::default()).unwrap();
        let scale = picture.light.at(31, 31) / raster.at(31, 31);
        for (a, b) in picture.light.values.iter().zip(&raster.values) {
            assert!((a - b * scale).abs() < 1e-6 * scale * raster.max());
        }
    }
}
