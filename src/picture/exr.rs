//! OpenEXR pictures: red, green and blue, or brightness alone, with opacity that the colours are multiplied by.

use std::io::Cursor;

use exr::error::Error;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, read};

use super::pixels::{MAX_MEMORY, Pixels, Samples, check_size};
use super::{PictureError, one_line};

/// Decodes the first layer that has colours or brightness.
pub(crate) fn decode(bytes: &[u8], name: &str) -> Result<Pixels, PictureError> {
    let complain = |error| complaint(error, name);
    let about = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(complain)?;
    let named = |layer: usize, channel: &str| {
        let channels = &about.headers[layer].channels.list;
        channels.iter().find(|one| one.name.eq(channel))
    };
    let coloured = |layer: &usize| ["R", "G", "B"].iter().all(|channel| named(*layer, channel).is_some());
    let layers = 0..about.headers.len();
    let colour = layers.clone().find(coloured);
    let grey = layers.clone().find(|layer| named(*layer, "Y").is_some());
    let Some(layer) = colour.or(grey) else {
        let reason = "no layer has channels R, G and B, or Y".into();
        return Err(PictureError::Unsupported { name: name.into(), format: "OpenEXR", reason });
    };
    let header = &about.headers[layer];
    if header.deep || header.channels.list.iter().any(|channel| channel.sampling.0 != 1 || channel.sampling.1 != 1) {
        let reason =
            if header.deep { "it has depth in each pixel" } else { "its colours are coarser than its brightness" };
        return Err(PictureError::Unsupported { name: name.into(), format: "OpenEXR", reason: reason.into() });
    }
    let (width, height) = (header.layer_size.0, header.layer_size.1);
    check_size(width as u64, height as u64, name)?;
    let channels = if colour.is_some() { 4 } else { 2 };
    // The crate decodes all channels of a block that some are wanted of, and holds few blocks at a time.
    if (4 * width * height * channels) as u64 > MAX_MEMORY {
        return Err(PictureError::Memory { name: name.into() });
    }
    let samples = if colour.is_some() { colours(bytes) } else { greys(bytes) }.map_err(complain)?;
    if samples.len() != width * height * channels {
        let reason = "it holds more or fewer numbers than its size asks for".into();
        return Err(PictureError::Corrupt { name: name.into(), format: "OpenEXR", reason });
    }
    let pixels = Pixels::plain((width, height), channels, Samples::F32(samples));
    Ok(Pixels { premultiplied: true, ..pixels })
}

/// Red, green, blue and opacity, 1 where there is none, of the first layer that has colours.
fn colours(bytes: &[u8]) -> Result<Vec<f32>, Error> {
    let channels = read().no_deep_data().largest_resolution_level().specific_channels();
    let channels = channels.required("R").required("G").required("B").optional("A", 1f32);
    let layer = channels
        .collect_pixels(
            |size: Vec2<usize>, _| (size.0, vec![0f32; 4 * size.0 * size.1]),
            |(width, values), at, (r, g, b, a): (f32, f32, f32, f32)| put(values, at.0 + *width * at.1, [r, g, b, a]),
        )
        .first_valid_layer();
    let image = layer.all_attributes().non_parallel().from_buffered(Cursor::new(bytes))?;
    Ok(image.layer_data.channel_data.pixels.1)
}

/// Brightness and opacity, 1 where there is none, of the first layer that has brightness.
fn greys(bytes: &[u8]) -> Result<Vec<f32>, Error> {
    let channels = read().no_deep_data().largest_resolution_level().specific_channels();
    let channels = channels.required("Y").optional("A", 1f32);
    let layer = channels
        .collect_pixels(
            |size: Vec2<usize>, _| (size.0, vec![0f32; 2 * size.0 * size.1]),
            |(width, values), at, (y, a): (f32, f32)| put(values, at.0 + *width * at.1, [y, a]),
        )
        .first_valid_layer();
    let image = layer.all_attributes().non_parallel().from_buffered(Cursor::new(bytes))?;
    Ok(image.layer_data.channel_data.pixels.1)
}

/// Writes pixel `at`, if there is one.
fn put<const N: usize>(values: &mut [f32], at: usize, pixel: [f32; N]) {
    if let Some(place) = values.chunks_exact_mut(N).nth(at) {
        place.copy_from_slice(&pixel);
    }
}

fn complaint(error: Error, name: &str) -> PictureError {
    let (name, format) = (name.into(), "OpenEXR");
    match error {
        Error::NotSupported(reason) => PictureError::Unsupported { name, format, reason: one_line(&reason) },
        error => PictureError::Corrupt { name, format, reason: one_line(&error) },
    }
}

#[cfg(test)]
mod tests {
    use exr::prelude::*;

    use super::*;

    fn values(pixels: &Pixels) -> Vec<f64> {
        (0..pixels.samples.len()).map(|i| pixels.samples.at(i)).collect()
    }

    #[test]
    fn colours_and_opacity_are_read_as_light_that_is_multiplied_already() {
        let colours = SpecificChannels::rgba(|at: Vec2<usize>| (at.0 as f32, at.1 as f32, 8.0f32, 0.5f32));
        let mut file = Cursor::new(Vec::new());
        Image::from_channels((3, 2), colours).write().to_buffered(&mut file).unwrap();
        let bytes = file.into_inner();
        let pixels = decode(&bytes, "a").unwrap();
        assert_eq!((pixels.width, pixels.height, pixels.channels, pixels.premultiplied), (3, 2, 4, true));
        assert_eq!(values(&pixels)[16..20], [1.0, 1.0, 8.0, 0.5]);
        for length in 0..bytes.len() {
            assert!(decode(&bytes[..length], "a").is_err(), "{length}");
        }
    }

    #[test]
    fn brightness_alone_is_read_and_an_opacity_that_is_missing_is_full() {
        let grey =
            SpecificChannels::build().with_channel("Y").with_pixel_fn(|at: Vec2<usize>| (f16::from_f32(at.0 as f32),));
        let mut file = Cursor::new(Vec::new());
        Image::from_channels((2, 2), grey).write().to_buffered(&mut file).unwrap();
        let pixels = decode(&file.into_inner(), "a").unwrap();
        assert_eq!(values(&pixels), [0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0]);
    }
}
