//! Pictures that are damaged, mislabelled, enormous or no pictures at all.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, GrayAlphaImage, GrayImage, ImageFormat, Luma};

use super::Trials;
use crate::mutate::crc32;
use crate::program::ring;

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    image.write_to(&mut out, format).unwrap();
    out.into_inner()
}

fn grey(width: u32, height: u32, value: u8) -> DynamicImage {
    GrayImage::from_pixel(width, height, Luma([value])).into()
}

/// A PNG whose header claims this size and kind; its other parts are a whole ring's.
fn claiming(width: u32, height: u32, depth: u8, colour: u8) -> Vec<u8> {
    let mut bytes = encoded(&ring().into(), ImageFormat::Png);
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    (bytes[24], bytes[25]) = (depth, colour);
    let sum = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&sum.to_be_bytes());
    bytes
}

/// A float TIFF of `side` x `side` pixels of one value, little-endian, one strip.
fn float_tiff(side: u32, value: f32) -> Vec<u8> {
    let data: Vec<u8> = std::iter::repeat_n(value.to_le_bytes(), (side * side) as usize).flatten().collect();
    let (long, short) = (4u16, 3u16);
    let entries = [
        (256u16, long, side),
        (257, long, side),
        (258, short, 32),
        (259, short, 1),
        (262, short, 1),
        (273, long, 8),
        (277, short, 1),
        (278, long, side),
        (279, long, data.len() as u32),
        (339, short, 3),
    ];
    let mut out = b"II*\0".to_vec();
    out.extend((8 + data.len() as u32).to_le_bytes());
    out.extend(&data);
    out.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, value) in entries {
        out.extend(tag.to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(1u32.to_le_bytes());
        out.extend(value.to_le_bytes());
    }
    out.extend([0; 4]);
    out
}

fn patched(mut bytes: Vec<u8>, at: usize, with: &[u8]) -> Vec<u8> {
    bytes[at..at + with.len()].copy_from_slice(with);
    bytes
}

/// Name and bytes; every one is refused with exit code 3.
fn pictures() -> Vec<(String, Vec<u8>)> {
    let whole = |format| encoded(&ring().into(), format);
    let (png, jpeg, tiff, webp) = (
        whole(ImageFormat::Png),
        encoded(&DynamicImage::from(ring()).to_rgb8().into(), ImageFormat::Jpeg),
        whole(ImageFormat::Tiff),
        encoded(&DynamicImage::from(ring()).to_rgb8().into(), ImageFormat::WebP),
    );
    let mut all: Vec<(String, Vec<u8>)> = Vec::new();
    for (name, bytes) in [("png", &png), ("jpg", &jpeg), ("tif", &tiff), ("webp", &webp)] {
        // Of a PNG the last chunk may be missing.
        let end = if name == "png" { 30 } else { 14 };
        for (k, length) in [4, 12, 30, bytes.len() / 3, bytes.len() * 2 / 3, bytes.len() - end].into_iter().enumerate()
        {
            all.push((format!("cut{k}.{name}"), bytes[..length].to_vec()));
        }
    }
    let length = png.len();
    for (name, bytes) in [
        ("empty.png", vec![]),
        ("zeros.png", vec![0; 4096]),
        ("text.png", b"Dear mill, please cut me a ring.\n".to_vec()),
        ("page.jpg", b"<!DOCTYPE html><html><body>404</body></html>".to_vec()),
        ("drawing.png", b"<svg xmlns='http://www.w3.org/2000/svg'/>".to_vec()),
        ("paper.png", b"%PDF-1.7\n".to_vec()),
        ("gif.png", b"GIF89a\x02\0\x02\0\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\x02\0\x02\0\0\x02\x02D".to_vec()),
        ("bitmap.png", [b"BM".to_vec(), vec![0; 100]].concat()),
        ("archive.png", b"PK\x03\x04\x14\0\0\0".to_vec()),
        ("program.png", b"\x7fELF\x02\x01\x01\0".to_vec()),
        ("heic.jpg", b"\0\0\0\x18ftypheic\0\0\0\0mif1heic".to_vec()),
        ("signature.png", png[..8].to_vec()),
        ("jpeg markers.jpg", b"\xff\xd8\xff\xd9".to_vec()),
        ("tiff header.tif", b"II*\0\x08\0\0\0".to_vec()),
        ("riff.webp", b"RIFF\x04\0\0\0WEBP".to_vec()),
        ("bomb.png", claiming(50_000, 50_000, 16, 6)),
        ("largest.png", claiming(0x7fff_ffff, 0x7fff_ffff, 8, 0)),
        ("beyond.png", claiming(u32::MAX, u32::MAX, 16, 6)),
        ("heavy.png", claiming(10_000, 10_000, 16, 6)),
        ("no size.png", claiming(0, 0, 8, 0)),
        ("no height.png", claiming(48, 0, 8, 0)),
        ("too tall.png", claiming(48, 4800, 8, 0)),
        ("other kind.png", claiming(48, 48, 16, 6)),
        ("no kind.png", claiming(48, 48, 8, 5)),
        ("no depth.png", claiming(48, 48, 77, 0)),
        ("palette.png", include_bytes!("../../corpus/picture/plte4.png").to_vec()),
        ("a fifth.jpg", include_bytes!("../../corpus/picture/cut.jpg").to_vec()),
        ("checksum.png", patched(png.clone(), 30, &[1, 2, 3])),
        ("garbled.png", patched(png.clone(), length / 2, &[0xa5; 24])),
        ("one pixel.png", encoded(&grey(1, 1, 255), ImageFormat::Png)),
        ("one line.png", encoded(&grey(9, 1, 255), ImageFormat::Png)),
        ("black.png", encoded(&grey(16, 16, 0), ImageFormat::Png)),
        ("clear.png", encoded(&GrayAlphaImage::new(16, 16).into(), ImageFormat::Png)),
        ("nan.tif", float_tiff(16, f32::NAN)),
        ("infinite.tif", float_tiff(16, f32::INFINITY)),
        ("negative.tif", float_tiff(16, -1.0)),
        ("zero.tif", float_tiff(16, 0.0)),
        ("one float.tif", float_tiff(1, 1.0)),
        ("far entries.tif", patched(tiff.clone(), 4, &[0xff, 0xff, 0xff, 0x7f])),
        ("loop.tif", patched(tiff, 4, &[0, 0, 0, 0])),
        ("large.webp", patched(webp, 21, &[0xff, 0xff, 0xff, 0x0f])),
    ] {
        all.push((name.to_owned(), bytes));
    }
    all
}

#[test]
fn what_is_no_drawing_is_refused_by_name() {
    let mut trials = Trials::new();
    for (name, bytes) in pictures() {
        fs::write(trials.home().join(&name), bytes).unwrap();
        trials.refused(&["design", &name, "-o", "out/deep"], 3, &[&name]);
        fs::remove_file(trials.home().join(&name)).unwrap();
    }
    let white = encoded(&grey(16, 16, 255), ImageFormat::Png);
    fs::write(trials.home().join("white.png"), white).unwrap();
    trials.refused(&["design", "white.png", "-o", "out", "--invert"], 3, &["white.png"]);
    // Light in two corners only: all of it is turned out of the field.
    let corners = |x: u32, y: u32| Luma([if x == y && x.is_multiple_of(47) { 255 } else { 0 }]);
    GrayImage::from_fn(48, 48, corners).save(trials.home().join("corners.png")).unwrap();
    let turned = ["design", "corners.png", "-o", "out", "--rotate", "45"];
    trials.refused(&turned, 4, &["corners.png", "rotating"]);
    trials.judge();
}

#[test]
fn what_is_no_file_is_refused_by_name() {
    let mut trials = Trials::new();
    fs::create_dir(trials.home().join("folder.png")).unwrap();
    let long = "n".repeat(5000);
    for name in ["missing.png", "folder.png", "ring.png/inner.png", "folder.png/../../..", &long] {
        trials.refused(&["design", name, "-o", "out"], 3, &[&name[..name.len().min(40)]]);
    }
    for device in ["/dev/null", "/dev/zero", "/dev/stdin"] {
        if Path::new(device).exists() {
            trials.refused(&["design", device, "-o", "out"], 3, &[device]);
        }
    }
    // Sparse: takes no room on the disk.
    let huge = fs::File::create(trials.home().join("huge.png")).unwrap();
    std::io::Write::write_all(&mut &huge, b"\x89PNG\r\n\x1a\n").unwrap();
    huge.set_len(3 << 30).unwrap();
    trials.refused(&["design", "huge.png", "-o", "out"], 3, &["huge.png", "MiB"]);
    let piped = std::process::Command::new("mkfifo").arg(trials.home().join("pipe.png")).status();
    if piped.is_ok_and(|made| made.success()) {
        trials.refused(&["design", "pipe.png", "-o", "out"], 3, &["pipe.png"]);
        trials.refused(&["design", "--recipe", "pipe.png", "-o", "out"], 3, &["pipe.png"]);
        trials.refused(&["verify", "pipe.png", "--against", "ring.png", "-o", "out"], 3, &["pipe.png"]);
    }
    trials.judge();
}
