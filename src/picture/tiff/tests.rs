use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, colortype};

use super::*;

const SHORT: u16 = 3;
const LONG: u16 = 4;

/// The bits of a float of `depth` bits.
fn bits(value: f64, depth: usize) -> u64 {
    let single = (value as f32).to_bits();
    match depth {
        64 => value.to_bits(),
        32 => single.into(),
        _ if value == 0.0 => 0,
        // Sign, exponent about 15 in place of 127, ten bits of the fraction.
        _ => u64::from(single >> 16 & 0x8000 | ((single >> 23 & 0xff) - 112) << 10 | single >> 13 & 0x3ff),
    }
}

/// A grey float TIFF of 3 × 4 pixels, pixel i having the value i - 2, in strips of 3 rows or one tile of 16 × 16.
fn sample(depth: usize, big_endian: bool, tiled: bool) -> Vec<u8> {
    let number = |value: u64, size: usize| {
        let bytes = value.to_be_bytes()[8 - size..].to_vec();
        if big_endian { bytes } else { bytes.into_iter().rev().collect() }
    };
    let size = depth / 8;
    let mut out = if big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
    let across = if tiled { 16 } else { 3 };
    let pixels = if tiled { 16 * 16 } else { 12 };
    let directory = 8 + pixels * size;
    out.extend(number(directory as u64, 4));
    for i in 0..pixels {
        let (x, y) = (i % across, i / across);
        let value = if x < 3 && y < 4 { (3 * y + x) as f64 - 2.0 } else { 0.0 };
        out.extend(number(bits(value, depth), size));
    }
    let mut entries = vec![(256, SHORT, 1, 3), (257, LONG, 1, 4), (258, SHORT, 1, depth), (262, SHORT, 1, 1)];
    let lists = directory + 2 + 12 * if tiled { 10 } else { 9 } + 4;
    if tiled {
        entries.extend([(277, SHORT, 1, 1), (322, SHORT, 1, 16), (323, SHORT, 1, 16)]);
        entries.extend([(324, LONG, 1, 8), (325, LONG, 1, 256 * size), (339, SHORT, 1, 3)]);
    } else {
        entries.extend([(273, LONG, 2, lists), (277, SHORT, 1, 1), (278, SHORT, 1, 3)]);
        entries.extend([(279, LONG, 2, lists + 8), (339, SHORT, 1, 3)]);
    }
    out.extend(number(entries.len() as u64, 2));
    for (tag, kind, count, value) in entries {
        out.extend(number(tag, 2));
        out.extend(number(kind.into(), 2));
        out.extend(number(count, 4));
        let inline = number(value as u64, if kind == SHORT { 2 } else { 4 });
        out.extend(inline.into_iter().chain([0, 0]).take(4));
    }
    out.extend(number(0, 4));
    if !tiled {
        [8, 8 + 9 * size, 9 * size, 3 * size].iter().for_each(|&value| out.extend(number(value as u64, 4)));
    }
    out
}

fn assert_counts(bytes: &[u8], what: &str) {
    let pixels = decode(bytes, "a").unwrap();
    assert_eq!((pixels.width, pixels.height, pixels.channels), (3, 4, 1), "{what}");
    for i in 0..12 {
        assert_eq!(pixels.samples.at(i), i as f64 - 2.0, "{what}");
    }
}

#[test]
fn grey_floats_of_every_size_in_both_byte_orders_in_strips_and_tiles_are_read() {
    for depth in [16, 32, 64] {
        for big_endian in [false, true] {
            for tiled in [false, true] {
                let what = format!("{depth} bits, big-endian {big_endian}, tiled {tiled}");
                assert_counts(&sample(depth, big_endian, tiled), &what);
            }
        }
    }
}

#[test]
fn compressed_floats_are_read() {
    let values: Vec<f32> = (0..12).map(|i| i as f32 - 2.0).collect();
    for (name, compression) in [
        ("LZW", Compression::Lzw),
        ("deflate", Compression::Deflate(DeflateLevel::Balanced)),
        ("packed bits", Compression::Packbits),
    ] {
        let mut file = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut file).unwrap().with_compression(compression);
        encoder.write_image::<colortype::Gray32Float>(3, 4, &values).unwrap();
        assert_counts(&file.into_inner(), name);
    }
}

#[test]
fn colours_of_64_bits_are_read() {
    let values: Vec<f64> = (0..12).map(f64::from).collect();
    let mut file = Cursor::new(Vec::new());
    TiffEncoder::new(&mut file).unwrap().write_image::<colortype::RGB64Float>(2, 2, &values).unwrap();
    let pixels = decode(&file.into_inner(), "a").unwrap();
    assert_eq!((pixels.width, pixels.height, pixels.channels), (2, 2, 3));
    assert!((0..12).all(|i| pixels.samples.at(i) == i as f64));
}

#[test]
fn a_width_that_the_file_cannot_hold_is_refused() {
    let whole = sample(64, false, false);
    let entry = whole.windows(4).rposition(|start| start == [0, 1, SHORT as u8, 0]).unwrap();
    let complaint = |width: u16| {
        let bytes = [&whole[..entry + 8], &width.to_le_bytes(), &whole[entry + 10..]].concat();
        decode(&bytes, "a").map(|_| ()).unwrap_err()
    };
    assert!(matches!(complaint(10_001), PictureError::TooLarge { width: 10_001, .. }));
    assert!(matches!(complaint(1), PictureError::TooSmall { width: 1, .. }));
    assert!(matches!(complaint(5_000), PictureError::Corrupt { .. }));
}

#[test]
fn every_truncation_and_every_changed_byte_is_survived() {
    for tiled in [false, true] {
        let whole = sample(32, false, tiled);
        for length in 0..whole.len() - 4 {
            assert!(decode(&whole[..length], "a").is_err(), "{length}");
        }
        for at in 0..whole.len() {
            for value in [0, 1, 127, 255] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                if let Ok(pixels) = decode(&bytes, "a") {
                    assert!(pixels.width >= 2 && pixels.height >= 2);
                }
            }
        }
    }
}

/// A page: tags with their numbers, and the pixels' bytes. Strip and size tags are added.
struct Drawn {
    size: (u64, u64),
    bits: Vec<u64>,
    photometric: u64,
    more: Vec<(u64, Vec<u64>)>,
    data: Vec<u8>,
}

/// A little-endian file of these pages, with offsets of 64 bits if it is `wide`; offsets of pages within pages may be
/// asked for by tag 330 and the index of a page, which is then left out of the chain.
fn file(pages: &[Drawn], wide: bool) -> Vec<u8> {
    let (offset, count) = if wide { (8, 8) } else { (4, 2) };
    let mut out = if wide { b"II\x2b\0\x08\0\0\0".to_vec() } else { b"II*\0".to_vec() };
    let first = out.len();
    out.extend(vec![0; offset]);
    let put =
        |out: &mut Vec<u8>, at: usize, value: u64| out[at..at + offset].copy_from_slice(&value.to_le_bytes()[..offset]);
    let mut link = Some(first);
    let mut places = Vec::new();
    for page in pages.iter().rev() {
        let data = out.len() as u64;
        out.extend(&page.data);
        let mut entries = vec![
            (256, vec![page.size.0]),
            (257, vec![page.size.1]),
            (258, page.bits.clone()),
            (259, vec![1]),
            (262, vec![page.photometric]),
            (273, vec![data]),
            (277, vec![page.bits.len() as u64]),
            (278, vec![page.size.1]),
            (279, vec![page.data.len() as u64]),
        ];
        for (tag, values) in &page.more {
            entries.retain(|(own, _)| own != tag);
            let values =
                if *tag == 330 { values.iter().map(|k| places[*k as usize]).collect() } else { values.clone() };
            // Strips of planes stand one after the other.
            let values = if *tag == 273 { values.iter().map(|v| v + data).collect() } else { values };
            entries.push((*tag, values));
        }
        entries.sort();
        // Longer lists stand before the directory; offsets take four bytes, all else two.
        let mut rows = Vec::new();
        for (tag, values) in &entries {
            let size = if matches!(tag, 273 | 279 | 330) { 4 } else { 2 };
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()[..size].to_vec()).collect();
            let mut inline = bytes.clone();
            if bytes.len() > offset {
                inline = (out.len() as u64).to_le_bytes()[..offset].to_vec();
                out.extend(bytes);
            }
            inline.resize(offset, 0);
            rows.push((*tag, if size == 4 { LONG } else { SHORT }, values.len() as u64, inline));
        }
        places.push(out.len() as u64);
        out.extend(&(rows.len() as u64).to_le_bytes()[..count]);
        for (tag, kind, number, inline) in rows {
            out.extend(&tag.to_le_bytes()[..2]);
            out.extend(kind.to_le_bytes());
            out.extend(&number.to_le_bytes()[..offset]);
            out.extend(inline);
        }
        out.extend(vec![0; offset]);
    }
    // The chain, from the first page on; pages within pages are the last ones and stand in none.
    let inner: usize =
        pages.iter().flat_map(|page| &page.more).filter(|(tag, _)| *tag == 330).map(|(_, v)| v.len()).sum();
    for (k, place) in places.iter().rev().enumerate().take(pages.len() - inner) {
        if let Some(at) = link {
            put(&mut out, at, *place);
        }
        let rows = u64::from_le_bytes({
            let mut bytes = [0; 8];
            bytes[..count].copy_from_slice(&out[*place as usize..][..count]);
            bytes
        });
        link = (k + 1 < pages.len()).then_some(*place as usize + count + rows as usize * (4 + 2 * offset));
    }
    out
}

fn grey(side: u64, value: u8) -> Drawn {
    Drawn { size: (side, side), bits: vec![8], photometric: 1, more: vec![], data: vec![value; (side * side) as usize] }
}

fn values(pixels: &Pixels) -> Vec<f64> {
    (0..pixels.samples.len()).map(|i| (pixels.samples.at(i) * 255.0).round()).collect()
}

/// One page of 2 × 2 pixels.
fn small(bits: Vec<u64>, photometric: u64, more: Vec<(u64, Vec<u64>)>, data: Vec<u8>) -> Result<Pixels, PictureError> {
    decode(&file(&[Drawn { size: (2, 2), bits, photometric, more, data }], false), "a")
}

#[test]
fn the_picture_is_read_and_not_its_thumbnail_and_other_pages_are_told() {
    for wide in [false, true] {
        let flagged = Drawn { more: vec![(254, vec![1])], ..grey(4, 9) };
        let pixels = decode(&file(&[flagged, grey(16, 200)], wide), "a").unwrap();
        assert_eq!((pixels.width, values(&pixels)[0]), (16, 200.0));
        assert_eq!(pixels.notes, ["The file has 2 pages or copies: the second was read."]);
        let pixels = decode(&file(&[grey(4, 9), grey(16, 200), grey(8, 7)], wide), "a").unwrap();
        assert_eq!((pixels.width, values(&pixels)[0]), (16, 200.0));
        let pixels = decode(&file(&[grey(4, 9), grey(4, 200)], wide), "a").unwrap();
        assert_eq!((values(&pixels)[0], pixels.notes.len()), (9.0, 1));
        assert!(decode(&file(&[grey(4, 9)], wide), "a").unwrap().notes.is_empty());
    }
    // The picture within its thumbnail, as some cameras store what they developed.
    let preview = Drawn { more: vec![(254, vec![1]), (330, vec![0])], ..grey(4, 9) };
    assert_eq!(decode(&file(&[preview, grey(16, 200)], false), "a").unwrap().width, 16);
}

#[test]
fn raw_photographs_are_refused_as_such() {
    for more in [(50_706, vec![1, 4]), (262, vec![32_803]), (262, vec![34_892])] {
        let message = decode(&file(&[Drawn { more: vec![more], ..grey(4, 9) }], false), "a").map(|_| ()).unwrap_err();
        assert!(message.to_string().contains("raw photograph"), "{message}");
    }
    let sensor = Drawn { photometric: 32_803, ..grey(64, 9) };
    let preview = Drawn { more: vec![(330, vec![0])], ..grey(4, 9) };
    assert!(decode(&file(&[preview, sensor], false), "a").is_err());
}

#[test]
fn grey_of_every_depth_is_read_as_light_and_as_ink() {
    assert_eq!(values(&small(vec![8], 1, vec![], vec![0, 1, 254, 255]).unwrap()), [0.0, 1.0, 254.0, 255.0]);
    assert_eq!(values(&small(vec![8], 0, vec![], vec![0, 1, 254, 255]).unwrap()), [255.0, 254.0, 1.0, 0.0]);
    assert_eq!(values(&small(vec![1], 1, vec![], vec![0b0100_0000, 0b1100_0000]).unwrap()), [0.0, 255.0, 255.0, 255.0]);
    assert_eq!(values(&small(vec![1], 0, vec![], vec![0b0100_0000, 0b1100_0000]).unwrap()), [255.0, 0.0, 0.0, 0.0]);
    assert_eq!(values(&small(vec![2], 1, vec![], vec![0b0001_0000, 0b1011_0000]).unwrap()), [0.0, 85.0, 170.0, 255.0]);
    assert_eq!(values(&small(vec![4], 1, vec![], vec![0x0f, 0x31]).unwrap()), [0.0, 255.0, 51.0, 17.0]);
    let wide = [0u32, u32::MAX / 5, u32::MAX / 3, u32::MAX].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(values(&small(vec![32], 1, vec![], wide).unwrap()), [0.0, 51.0, 85.0, 255.0]);
    let signed = small(vec![16], 1, vec![(339, vec![2])], vec![0; 8]).map(|_| ()).unwrap_err();
    assert!(signed.to_string().contains("numbers have signs"), "{signed}");
}

#[test]
fn opacity_is_told_from_what_is_none_and_from_what_is_multiplied() {
    let data = vec![10, 20, 30, 40, 50, 60, 70, 80];
    let read = |kind: u64| small(vec![8, 8], 1, vec![(338, vec![kind])], data.clone()).unwrap();
    let apart = read(2);
    assert_eq!((apart.channels, apart.premultiplied, values(&apart).len()), (2, false, 8));
    let multiplied = read(1);
    assert_eq!((multiplied.channels, multiplied.premultiplied), (2, true));
    let unknown = read(0);
    assert_eq!((unknown.channels, values(&unknown)), (1, vec![10.0, 30.0, 50.0, 70.0]));
    let ink = small(vec![8, 8], 0, vec![(338, vec![2])], data.clone()).unwrap();
    assert_eq!(values(&ink)[..2], [245.0, 20.0]);
    let colours: Vec<u8> = (0..16).collect();
    let coloured = small(vec![8; 4], 2, vec![(338, vec![1])], colours).unwrap();
    assert_eq!((coloured.channels, coloured.premultiplied, values(&coloured)[5]), (4, true, 5.0));
    let forgotten = small(vec![8; 4], 2, vec![], (0..16).collect()).unwrap();
    assert_eq!((forgotten.channels, forgotten.premultiplied), (4, false));
    let bands = small(vec![8; 4], 1, vec![], vec![0; 16]).map(|_| ()).unwrap_err();
    assert!(bands.to_string().contains("4 bands"), "{bands}");
}

#[test]
fn palettes_are_looked_up() {
    // Red 0xff00 and blue 0x8000 of 16 bits, in the order red, green, blue.
    let palette = vec![0, 0xff00, 0, 0, 0, 0, 0, 0x8000, 0, 0, 0, 0].into_iter().collect::<Vec<u64>>();
    for (bits, data) in [(2, vec![0b0001_0000, 0b1100_0000]), (8, vec![0, 1, 3, 0])] {
        let colours = if bits == 2 {
            palette.clone()
        } else {
            [&palette[..4], &[0; 252], &palette[4..8], &[0; 252], &palette[8..], &[0; 252]].concat()
        };
        let pixels = small(vec![bits], 3, vec![(320, colours)], data).unwrap();
        assert_eq!(
            (pixels.channels, values(&pixels)[3..9].to_vec()),
            (3, vec![255.0, 0.0, 0.0, 0.0, 128.0, 0.0]),
            "{bits}"
        );
    }
    let missing = small(vec![8], 3, vec![], vec![0; 4]).map(|_| ()).unwrap_err();
    assert!(missing.to_string().contains("no palette"), "{missing}");
    let short = small(vec![8], 3, vec![(320, vec![0; 6])], vec![0, 1, 2, 0]).map(|_| ()).unwrap_err();
    assert!(short.to_string().contains("does not have"), "{short}");
}

#[test]
fn inks_planes_and_brightness_with_colour_are_made_into_light() {
    let inks = vec![0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 255, 0, 0, 0, 0, 255];
    let pixels = small(vec![8; 4], 5, vec![], inks).unwrap();
    assert_eq!(values(&pixels), [255.0, 255.0, 255.0, 0.0, 255.0, 255.0, 255.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(pixels.notes[0].contains("CMYK"));
    let planes: Vec<u8> = (0..12).collect();
    let more = vec![(284, vec![2]), (273, vec![0, 4, 8]), (279, vec![4, 4, 4])];
    let pixels = small(vec![8; 3], 2, more, planes).unwrap();
    assert_eq!(values(&pixels)[..6], [0.0, 4.0, 8.0, 1.0, 5.0, 9.0]);
    // Y 76, Cb 85, Cr 255 is pure red (ITU-T T.871).
    let more = || vec![(530, vec![1, 1])];
    let pixels = small(vec![8; 3], 6, more(), [76, 85, 255].repeat(4)).unwrap();
    assert_eq!(values(&pixels)[..3], [254.0, 0.0, 0.0]);
    let coarse = small(vec![8; 3], 6, vec![(530, vec![2, 2])], vec![0; 12]).map(|_| ()).unwrap_err();
    assert!(coarse.to_string().contains("YCbCr"), "{coarse}");
    let lab = small(vec![8; 3], 9, vec![], vec![0; 12]).map(|_| ()).unwrap_err();
    assert!(lab.to_string().contains("L*a*b*"), "{lab}");
}

#[test]
fn what_the_camera_noted_is_obeyed() {
    let pixels = small(vec![8], 1, vec![(274, vec![6])], vec![1, 2, 3, 4]).unwrap();
    assert_eq!(values(&pixels), [3.0, 1.0, 4.0, 2.0]);
    assert!(pixels.notes[0].contains("upright"));
}
