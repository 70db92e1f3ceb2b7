//! Pictures that are damaged, mislabelled, enormous or no pictures at all get an answer, never a panic.

use std::io::Cursor;
use std::path::Path;

use facetmill::picture::{Encoding, MAX_SIDE, Picture, PictureError, Reading, from_bytes, from_raster, read};
use facetmill::raster::Raster;
use image::{DynamicImage, ImageFormat};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::mutants::mutate::crc32;

const FORMATS: [ImageFormat; 6] =
    [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff, ImageFormat::WebP, ImageFormat::Bmp, ImageFormat::Pnm];

fn plain() -> Reading {
    Reading::default()
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    image.write_to(&mut out, format).unwrap();
    out.into_inner()
}

/// A colourful 24 × 16 picture with something in every row.
fn drawing() -> DynamicImage {
    let at = |x: u32, y: u32| image::Rgb([(x * 10) as u8, (y * 15) as u8, ((x ^ y) * 8) as u8]);
    DynamicImage::ImageRgb8(image::RgbImage::from_fn(24, 16, at))
}

/// Whatever comes out is usable or is one sentence that begins with the name.
fn judge(result: Result<Picture, PictureError>) -> bool {
    match result {
        Ok(picture) => {
            let light = &picture.light;
            assert_eq!(light.width, light.height);
            assert_eq!(light.values.len(), light.width * light.height);
            assert!(light.values.iter().all(|v| v.is_finite() && *v >= 0.0) && light.max() > 0.0);
            true
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with("odd: ") && message.contains("; ") && !message.contains('\n'), "{message}");
            assert!(message.len() < 400, "{message}");
            false
        }
    }
}

#[test]
fn the_format_is_told_by_content_and_all_formats_agree() {
    let folder = tempfile::tempdir().unwrap();
    let mut pictures = Vec::new();
    for format in FORMATS {
        // Every file has the wrong ending.
        let path = folder.path().join("drawing.gif");
        std::fs::write(&path, encoded(&drawing(), format)).unwrap();
        pictures.push(read(&path, &plain()).unwrap());
    }
    for (k, picture) in pictures.iter().enumerate() {
        assert_eq!((picture.original_size, picture.light.width), ((24, 16), 24));
        let off = |(a, b): (&f64, &f64)| (a - b).abs();
        let most = picture.light.values.iter().zip(&pictures[0].light.values).map(off).fold(0.0, f64::max);
        // JPEG loses some, most of all colour.
        assert!(most < if k == 1 { 0.4 } else { 1e-15 }, "{k}: {most}");
    }
}

#[test]
fn every_kind_of_pixel_gives_its_light() {
    let grey = DynamicImage::ImageLuma8(image::GrayImage::from_fn(4, 4, |x, y| image::Luma([(x * 60 + y) as u8])));
    let want = from_bytes(&encoded(&grey, ImageFormat::Png), "odd", &plain()).unwrap().light;
    let same = |bytes: &[u8], reading: Reading| {
        let got = from_bytes(bytes, "odd", &reading).unwrap().light;
        assert!(got.values.iter().zip(&want.values).all(|(a, b)| (a - b).abs() < 1e-6));
    };
    let srgb = Reading { encoding: Encoding::Srgb, ..plain() };
    for format in [ImageFormat::Png, ImageFormat::Tiff] {
        same(&encoded(&DynamicImage::ImageRgba8(grey.to_rgba8()), format), plain());
        same(&encoded(&DynamicImage::ImageLuma16(grey.to_luma16()), format), srgb);
        same(&encoded(&DynamicImage::ImageRgb16(grey.to_rgb16()), format), srgb);
    }
    same(&encoded(&DynamicImage::ImageLumaA16(grey.to_luma_alpha16()), ImageFormat::Png), srgb);
    same(&encoded(&DynamicImage::ImageRgb32F(grey.to_rgb32f()), ImageFormat::Tiff), srgb);
    let linear = from_bytes(&encoded(&DynamicImage::ImageLuma16(grey.to_luma16()), ImageFormat::Png), "odd", &plain());
    let linear = linear.unwrap();
    assert!((linear.light.at(3, 0) - 180.0 / 255.0).abs() < 1e-12);
    assert!(linear.notes[0].contains("16-bit"));
}

#[test]
fn a_palette_is_looked_up() {
    // Two bits a pixel, four colours: black, white, red, and white at opacity 0.2.
    let palette = [0, 0, 0, 255, 255, 255, 255, 0, 0, 255, 255, 255];
    let rows = [0u8, 0b00_01_10_11, 0, 0b11_10_01_00];
    let chunks: [(&[u8; 4], &[u8]); 5] = [
        (b"IHDR", &[0, 0, 0, 4, 0, 0, 0, 2, 2, 3, 0, 0, 0]),
        (b"PLTE", &palette),
        (b"tRNS", &[255, 255, 255, 51]),
        (b"IDAT", &stored(&rows)),
        (b"IEND", &[]),
    ];
    let light = from_bytes(&png(&chunks), "odd", &plain()).unwrap().light;
    let want = [0.0, 1.0, 0.2126, 0.2, 0.2, 0.2126, 1.0, 0.0];
    assert!(light.values[4..12].iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-12), "{:?}", light.values);
}

#[test]
fn a_palette_that_is_no_list_of_colours_is_refused() {
    let of = |length: usize| {
        let palette = vec![200; length];
        let header = [0, 0, 0, 2, 0, 0, 0, 2, 8, 3, 0, 0, 0];
        png(&[(b"IHDR", &header), (b"PLTE", &palette), (b"IDAT", &stored(&[0; 6])), (b"IEND", &[])])
    };
    for length in [0, 1, 2, 4, 5, 7, 8, 769, 771, 3000] {
        let error = from_bytes(&of(length), "odd", &plain()).unwrap_err();
        assert!(error.to_string().contains("are no palette"), "{length}: {error}");
        judge(Err(error));
    }
    for length in [3, 6, 768] {
        assert!(judge(from_bytes(&of(length), "odd", &plain())), "{length}");
    }
}

#[test]
fn a_jpeg_whose_scan_is_too_short_is_refused_though_it_ends_well() {
    for drawing in [drawing(), DynamicImage::ImageLuma8(drawing().to_luma8())] {
        let whole = encoded(&drawing, ImageFormat::Jpeg);
        let scan = whole.windows(2).position(|pair| pair == [0xff, 0xda]).unwrap() + 14;
        let cut = |length: usize| [&whole[..length], &[0xff, 0xd9]].concat();
        for length in (scan..whole.len() - 8).filter(|length| whole[length - 1] != 0xff) {
            let error = from_bytes(&cut(length), "odd", &plain()).unwrap_err();
            assert!(error.to_string().contains("a part of its picture is missing"), "{length}: {error}");
        }
        // What follows the end marker, or pads the scan, is nobody's business.
        let want = from_bytes(&whole, "odd", &plain()).unwrap();
        let padded = [&whole[..whole.len() - 2], &[0; 5], &[0xff, 0xd9, 1, 2, 3]].concat();
        assert_eq!(from_bytes(&padded, "odd", &plain()).unwrap(), want);
    }
}

#[test]
fn whole_jpegs_of_every_size_are_read() {
    for (width, height) in (2..20).flat_map(|width| [(width, 2), (width, 9), (width, 17)]) {
        let part = drawing().resize_exact(width, height, image::imageops::FilterType::Triangle);
        for picture in [part.to_luma8().into(), part] {
            for quality in [5, 60, 100] {
                let mut bytes = Vec::new();
                let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, quality);
                picture.write_with_encoder(encoder).unwrap();
                assert!(judge(from_bytes(&bytes, "odd", &plain())), "{width} x {height}");
            }
        }
    }
}

#[test]
fn a_webp_too_large_is_refused_with_its_size() {
    let lossless = |width: u32, height: u32| {
        let size = (width - 1) | (height - 1) << 14;
        let mut bytes = b"RIFF\x1a\0\0\0WEBPVP8L\x0d\0\0\0\x2f".to_vec();
        bytes.extend(size.to_le_bytes());
        bytes.extend([0; 12]);
        bytes
    };
    let extended = |width: u32, height: u32| {
        let mut bytes = b"RIFF\x16\0\0\0WEBPVP8X\x0a\0\0\0\0\0\0\0".to_vec();
        bytes.extend(&(width - 1).to_le_bytes()[..3]);
        bytes.extend(&(height - 1).to_le_bytes()[..3]);
        bytes
    };
    for (bytes, width, height) in [
        (lossless(16384, 16384), 16384, 16384),
        (lossless(16384, 5), 16384, 5),
        (lossless(20, 10001), 20, 10001),
        (extended(16384, 16384), 16384, 16384),
        (extended(1 << 24, 200), 1 << 24, 200),
    ] {
        let error = from_bytes(&bytes, "odd", &plain()).unwrap_err();
        assert!(error.to_string().contains(&format!("is {width} x {height} pixels")), "{error}");
    }
}

#[test]
fn a_camera_held_sideways_is_obeyed() {
    // An Exif segment that holds one entry: tag 274, value 6, "turn by 90° clockwise to see it".
    let jpeg = encoded(&drawing(), ImageFormat::Jpeg);
    let exif = b"\xff\xe1\0\x22Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    let turned: Vec<u8> = jpeg[..2].iter().chain(exif).chain(&jpeg[2..]).copied().collect();
    let picture = from_bytes(&turned, "odd", &plain()).unwrap();
    assert_eq!(picture.original_size, (16, 24));
    assert!(picture.notes[0].contains("upright"));
    let rotated = Reading { rotate: -90.0, ..plain() };
    assert_eq!(picture.light, from_bytes(&jpeg, "odd", &rotated).unwrap().light);
}

#[test]
fn a_cut_file_is_refused_or_whole() {
    for format in FORMATS {
        let whole = encoded(&drawing(), format);
        let want = from_bytes(&whole, "odd", &plain()).unwrap();
        let step = (whole.len() / 120).max(1);
        for length in (0..whole.len()).step_by(step).chain(whole.len().saturating_sub(20)..whole.len()) {
            let result = from_bytes(&whole[..length], "odd", &plain());
            // What may be missing without harm is what follows the pixels.
            if let Ok(picture) = &result {
                assert_eq!(picture.light, want.light, "{format:?} cut to {length} of {}", whole.len());
            }
            judge(result);
        }
        assert!(from_bytes(&whole[..whole.len() / 2], "odd", &plain()).is_err(), "{format:?}");
    }
}

#[test]
fn flipped_bits_never_panic() {
    for (k, format) in FORMATS.into_iter().enumerate() {
        let whole = encoded(&drawing(), format);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(k as u64);
        let mut refused = 0;
        for _ in 0..300 {
            let mut bytes = whole.clone();
            for _ in 0..rng.random_range(1..6) {
                // Headers lie near the start: half of the flips go there.
                let reach = if rng.random_bool(0.5) { bytes.len().min(64) } else { bytes.len() };
                let at = rng.random_range(0..reach);
                bytes[at] ^= 1 << rng.random_range(0..8);
            }
            refused += usize::from(!judge(from_bytes(&bytes, "odd", &plain())));
        }
        assert!(refused > 30, "{format:?}: only {refused} refused");
    }
}

#[test]
fn an_enormous_picture_is_refused_by_its_header() {
    for (width, height) in [(50_000u32, 50_000u32), (u32::MAX / 2, 2), (2, MAX_SIDE as u32 + 1)] {
        let header: Vec<u8> =
            width.to_be_bytes().into_iter().chain(height.to_be_bytes()).chain([16, 6, 0, 0, 0]).collect();
        let bomb = png(&[(b"IHDR", &header), (b"IDAT", &stored(&[0; 64])), (b"IEND", &[])]);
        let error = from_bytes(&bomb, "odd", &plain()).unwrap_err();
        assert!(matches!(error, PictureError::TooLarge { .. }), "{error}");
        let message = error.to_string();
        assert!(message.contains(&format!("{width} x {height}")) && message.contains("10000"), "{message}");
    }
    // Within the limit of pixels, but 16 bits of four channels are too much.
    let header = [0, 0, 0x27, 0x10, 0, 0, 0x27, 0x10, 16, 6, 0, 0, 0];
    let heavy = png(&[(b"IHDR", &header), (b"IDAT", &stored(&[0; 64])), (b"IEND", &[])]);
    assert!(!judge(from_bytes(&heavy, "odd", &plain())));
}

#[test]
fn a_picture_of_no_size_or_one_pixel_holds_no_drawing() {
    for (width, height) in [(1, 1), (1, 9), (9, 1)] {
        let grey = DynamicImage::ImageLuma8(image::GrayImage::from_pixel(width, height, image::Luma([200])));
        for format in FORMATS {
            let error = from_bytes(&encoded(&grey, format), "odd", &plain()).unwrap_err();
            assert!(matches!(error, PictureError::TooSmall { .. }), "{error}");
        }
    }
    let nothing = png(&[(b"IHDR", &[0, 0, 0, 0, 0, 0, 0, 0, 8, 0, 0, 0, 0]), (b"IEND", &[])]);
    assert!(!judge(from_bytes(&nothing, "odd", &plain())));
    assert!(from_raster(Raster::zeros(0, 0), &plain()).is_err());
    assert!(from_raster(Raster { width: 3, height: 3, values: vec![1.0] }, &plain()).is_err());
}

#[test]
fn what_is_no_picture_is_called_by_its_name() {
    for (bytes, word) in [
        (&b"GIF89a\x02\0\x02\0\x80\0\0"[..], "GIF data are damaged"),
        (b"<svg xmlns='http://www.w3.org/2000/svg'/>", if cfg!(feature = "svg") { "transparent" } else { "SVG" }),
        (b"%PDF-1.4", "PDF"),
        (b"Dear mill,", "text"),
        (b"", "empty"),
        (b"\x89PNG\r\n\x1a\n", "PNG data are damaged"),
        (b"\xff\xd8\xff\xd9", "JPEG"),
        (b"II*\0\x08\0\0\0", "TIFF data are damaged"),
        (b"RIFF\x04\0\0\0WEBP", "WebP data are damaged"),
    ] {
        let result = from_bytes(bytes, "odd", &plain());
        assert!(result.as_ref().unwrap_err().to_string().contains(word), "{result:?}");
        judge(result);
    }
}

#[test]
fn paths_that_lead_nowhere_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.png");
    let message = read(&missing, &plain()).unwrap_err().to_string();
    assert!(message.contains("missing.png") && message.contains("no such file"), "{message}");
    assert!(matches!(read(folder.path(), &plain()).unwrap_err(), PictureError::NotAFile { found: "a directory", .. }));
    let empty = folder.path().join("empty.png");
    std::fs::write(&empty, b"").unwrap();
    assert!(matches!(read(&empty, &plain()).unwrap_err(), PictureError::Empty { .. }));
    let beyond = empty.join("drawing.png");
    assert!(matches!(read(&beyond, &plain()).unwrap_err(), PictureError::Unreadable { .. }));
    if Path::new("/dev/zero").exists() {
        assert!(matches!(read(Path::new("/dev/zero"), &plain()).unwrap_err(), PictureError::NotAFile { .. }));
    }
}

#[test]
fn a_huge_file_is_refused_without_reading_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.png");
    let file = std::fs::File::create(&path).unwrap();
    std::io::Write::write_all(&mut &file, b"\x89PNG\r\n\x1a\n").unwrap();
    // Sparse: takes no room on the disk.
    file.set_len(3 << 30).unwrap();
    assert!(matches!(read(&path, &plain()).unwrap_err(), PictureError::Heavy { megabytes: 3072, .. }));
}

#[test]
fn rotating_by_no_number_is_refused() {
    for rotate in [f64::NAN, f64::INFINITY] {
        let light = Raster::from_fn(4, 4, |x, _| x as f64);
        let error = from_raster(light, &Reading { rotate, ..plain() }).unwrap_err();
        assert!(matches!(error, PictureError::Rotation { .. }), "{error}");
    }
}

#[test]
fn settings_survive_a_recipe_file() {
    let reading: Reading = toml::from_str("encoding = 'linear'\ninvert = true\nfit = 'crop'").unwrap();
    assert_eq!(toml::from_str::<Reading>(&toml::to_string(&reading).unwrap()).unwrap(), reading);
    assert_eq!(toml::from_str::<Reading>("").unwrap(), plain());
    assert!(toml::from_str::<Reading>("rotation = 3").is_err());
}

/// A PNG of these chunks, with right checksums.
pub fn png(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    for (kind, data) in chunks {
        out.extend((data.len() as u32).to_be_bytes());
        let body: Vec<u8> = kind.iter().chain(*data).copied().collect();
        out.extend(&body);
        out.extend(crc32(&body).to_be_bytes());
    }
    out
}

/// zlib (RFC 1950) around one stored block (RFC 1951, 3.2.4).
pub fn stored(data: &[u8]) -> Vec<u8> {
    let length = data.len() as u16;
    let mut out = vec![0x78, 0x01, 0x01];
    out.extend(length.to_le_bytes());
    out.extend((!length).to_le_bytes());
    out.extend(data);
    let (mut a, mut b) = (1u32, 0u32);
    for byte in data {
        a = (a + u32::from(*byte)) % 65521;
        b = (b + a) % 65521;
    }
    out.extend((b << 16 | a).to_be_bytes());
    out
}
