use super::super::statement::{of_gamma, srgb};
use super::super::{PLAIN, from_raster};
use super::*;

fn pixels(channels: usize, samples: Samples) -> Pixels {
    let count = samples.len();
    Pixels::plain((count / channels / 2, 2), channels, samples)
}

fn values(channels: usize, samples: Samples, reading: &Reading) -> Vec<f64> {
    light(pixels(channels, samples), "a", reading).unwrap().0.values
}

fn near(a: &[f64], b: &[f64]) {
    assert!(a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
}

const AUTO: Reading = PLAIN;
const LINEAR: Reading = Reading { encoding: Encoding::Linear, ..AUTO };
const SRGB: Reading = Reading { encoding: Encoding::Srgb, ..AUTO };
const INVERT: Reading = Reading { invert: true, ..AUTO };

#[test]
fn depth_decides_the_encoding_unless_told() {
    // 188 is the sRGB code for half of the light, to the nearest step; 10 lies on the straight part.
    let bytes = || Samples::U8(vec![0, 10, 188, 255]);
    let half = ((188.0f64 / 255.0 + 0.055) / 1.055).powf(2.4);
    assert!((half - 0.5).abs() < 0.005);
    near(&values(1, bytes(), &AUTO), &[0.0, 10.0 / 255.0 / 12.92, half, 1.0]);
    near(&values(1, bytes(), &LINEAR), &[0.0, 10.0 / 255.0, 188.0 / 255.0, 1.0]);
    let words = || Samples::U16(vec![0, 2570, 48316, 65535]);
    near(&values(1, words(), &AUTO), &values(1, bytes(), &LINEAR));
    near(&values(1, words(), &SRGB), &values(1, bytes(), &AUTO));
    let floats = || Samples::F32(vec![0.0, 0.25, 0.5, 4.0]);
    near(&values(1, floats(), &AUTO), &[0.0, 0.25, 0.5, 4.0]);
    near(&values(1, floats(), &SRGB)[3..], &[(4.055f64 / 1.055).powf(2.4)]);
}

#[test]
fn colour_becomes_luminance_after_decoding() {
    let pure = Samples::U8(vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 188, 188, 188]);
    near(&values(3, pure, &AUTO), &[0.2126, 0.7152, 0.0722, srgb(188.0 / 255.0)]);
    let olive = Samples::U8([188, 188, 0].repeat(4));
    near(&values(3, olive, &AUTO)[..1], &[(0.2126 + 0.7152) * srgb(188.0 / 255.0)]);
}

#[test]
fn opacity_multiplies_and_is_never_srgb() {
    let white = Samples::U8(vec![255, 0, 255, 51, 255, 102, 188, 255]);
    near(&values(2, white, &AUTO), &[0.0, 0.2, 0.4, srgb(188.0 / 255.0)]);
    let red = Samples::U16([65535, 0, 0, 13107].repeat(4));
    near(&values(4, red, &AUTO), &[0.2126 * 0.2; 4]);
}

#[test]
fn black_on_transparent_is_taken_by_its_opacity() {
    let ink = || Samples::U8(vec![0, 0, 0, 0, 1, 1, 1, 51, 0, 0, 0, 102, 0, 0, 0, 255]);
    let (raster, notes) = light(pixels(4, ink()), "a", &AUTO).unwrap();
    near(&raster.values, &[0.0, 0.2, 0.4, 1.0]);
    assert!(notes[0].contains("opacity was taken as light"));
    // A dark grey drawing is faint, not black: it stays what it is.
    let grey = Samples::U8(vec![60, 0, 60, 255, 60, 0, 60, 255]);
    near(&values(2, grey, &AUTO), &[0.0, srgb(60.0 / 255.0), 0.0, srgb(60.0 / 255.0)]);
}

#[test]
fn inverting_is_what_an_editor_does() {
    let grey = Samples::U8(vec![188, 0, 255, 67]);
    near(&values(1, grey, &INVERT), &[srgb(67.0 / 255.0), 1.0, 0.0, srgb(188.0 / 255.0)]);
    near(&values(1, Samples::U16(vec![0, 13107, 65535, 0]), &INVERT), &[1.0, 0.8, 0.0, 1.0]);
    // Each channel by itself: yellow paper with blue ink.
    let colour = Samples::U8(vec![255, 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255]);
    near(&values(3, colour, &INVERT), &[0.0722, 0.2126 + 0.7152, 1.0, 0.0]);
}

#[test]
fn inverting_a_transparent_drawing_is_inverting_it_on_white_paper() {
    let mut clear = Vec::new();
    let mut paper = Vec::new();
    for opacity in [0u8, 51, 102, 255] {
        clear.extend([0, opacity]);
        paper.push(255 - opacity);
    }
    near(&values(2, Samples::U8(clear), &INVERT), &values(1, Samples::U8(paper), &INVERT));
}

#[test]
fn what_is_no_light_is_dark_and_counted() {
    let floats = vec![f32::NAN, f32::INFINITY, -1.0, 2.0, f32::NEG_INFINITY, 0.5];
    let (raster, notes) = light(pixels(1, Samples::F32(floats.clone())), "a", &AUTO).unwrap();
    near(&raster.values, &[0.0, 0.0, 0.0, 2.0, 0.0, 0.5]);
    assert!(notes[0].starts_with("3 pixels with infinite"), "{notes:?}");
    assert!(notes[1].starts_with("1 pixel with negative"), "{notes:?}");
    // Brighter than white, and no number at all, stay dark when inverted.
    near(&values(1, Samples::F32(floats), &INVERT), &[0.0, 0.0, 1.0, 0.0, 0.0, 0.5]);
}

#[test]
fn a_picture_without_light_says_what_to_do() {
    let message = |channels, samples, reading| light(pixels(channels, samples), "a", reading).unwrap_err().to_string();
    assert!(message(1, Samples::U8(vec![0; 4]), &AUTO).contains("black everywhere"));
    assert!(message(1, Samples::U8(vec![0; 4]), &AUTO).contains("--invert"));
    assert!(message(1, Samples::U8(vec![255; 4]), &INVERT).contains("leave out --invert"));
    assert!(message(2, Samples::U8(vec![0, 128, 0, 128, 0, 128, 0, 128]), &AUTO).contains("black everywhere"));
    assert!(message(2, Samples::U8(vec![255, 0, 255, 0, 255, 0, 255, 0]), &AUTO).contains("transparent everywhere"));
    assert!(message(1, Samples::F32(vec![f32::NAN; 4]), &AUTO).contains("no pixel"));
}

#[test]
fn ink_on_paper_is_recognised() {
    let drawn = |paper: f64, ink: f64| {
        let page = Raster::from_fn(9, 9, |x, y| if (3..6).contains(&x) && (3..6).contains(&y) { ink } else { paper });
        from_raster(page, &AUTO).unwrap().notes
    };
    assert!(drawn(0.9, 0.1)[0].contains("--invert"));
    assert!(drawn(0.1, 0.9).is_empty());
    assert!(!drawn(0.9, 0.9)[0].contains("--invert"));
}

/// 40 × 40 pixels of `other`, the middle 20 × 20 of `middle`.
fn logo(middle: [u8; 4], other: [u8; 4], rest: [u8; 4]) -> Pixels {
    let pixel = |k: usize| match (k % 40, k / 40) {
        (5..25, 5..25) => middle,
        (25..35, 5..25) => other,
        _ => rest,
    };
    Pixels::plain((40, 40), 4, Samples::U8((0..1600).flat_map(pixel).collect()))
}

const BLACK: [u8; 4] = [0, 0, 0, 255];
const CLEAR: [u8; 4] = [0; 4];

#[test]
fn a_mostly_black_drawing_on_transparency_shines_where_it_is_black_and_says_so() {
    let (raster, notes) = light(logo(BLACK, [200, 30, 30, 255], CLEAR), "a", &AUTO).unwrap();
    assert_eq!(raster.at(10, 10), 1.0);
    // Red laid on white and inverted is a light greenish blue.
    let red = 0.2126 * srgb(55.0 / 255.0) + (0.7152 + 0.0722) * srgb(225.0 / 255.0);
    assert!((raster.at(30, 10) - red).abs() < 1e-9);
    assert_eq!(raster.at(2, 2), 0.0);
    assert!(notes[0].starts_with("67 % of what is drawn is dark") && notes.len() == 1, "{notes:?}");
    // With the flag it is just the same, without the note.
    let told = light(logo(BLACK, [200, 30, 30, 255], CLEAR), "a", &INVERT).unwrap();
    assert_eq!(told.0, raster);
    assert!(told.1.is_empty());
}

#[test]
fn white_that_is_lost_beside_black_is_told() {
    let (raster, notes) = light(logo(BLACK, [255; 4], CLEAR), "a", &AUTO).unwrap();
    assert_eq!((raster.at(10, 10), raster.at(30, 10)), (1.0, 0.0));
    assert!(notes[1].starts_with("33 % of what is drawn is white"), "{notes:?}");
}

#[test]
fn black_that_is_lost_beside_colours_is_told() {
    let (raster, notes) = light(logo([200, 30, 30, 255], BLACK, CLEAR), "a", &AUTO).unwrap();
    assert!(raster.at(10, 10) > 0.1 && raster.at(30, 10) == 0.0);
    assert!(notes[0].starts_with("33 % of what is drawn is black on transparency"), "{notes:?}");
}

#[test]
fn one_stray_pixel_does_not_take_all_the_light() {
    let mut stray = logo([35, 31, 32, 255], [35, 31, 32, 255], CLEAR);
    let Samples::U8(values) = &mut stray.samples else { unreachable!() };
    values[4 * (7 + 40 * 30)..][..4].copy_from_slice(&[255; 4]);
    let (raster, notes) = light(stray, "a", &AUTO).unwrap();
    assert_eq!((raster.at(10, 10), raster.at(30, 10), raster.at(7, 30), raster.at(2, 2)), (1.0, 1.0, 1.0, 0.0));
    assert!(notes[0].contains("opacity was taken as light") && notes[1].contains("strays"), "{notes:?}");
}

#[test]
fn a_statement_is_believed_over_the_depth_and_a_flag_over_a_statement() {
    let stated = |samples, statement| Pixels { statement, ..pixels(1, samples) };
    let srgb_chunk = || Some(Statement { by: "its sRGB chunk".into(), means: Means::Srgb });
    let words = || Samples::U16(vec![0, 2570, 48316, 65535]);
    let told = |samples, statement, reading| light(stated(samples, statement), "a", reading).unwrap();
    let (raster, notes) = told(words(), srgb_chunk(), &AUTO);
    near(&raster.values, &values(1, words(), &SRGB));
    assert!(notes[0].contains("as its sRGB chunk states") && notes[0].contains("--linear"), "{notes:?}");
    let (raster, notes) = told(words(), srgb_chunk(), &LINEAR);
    near(&raster.values, &values(1, words(), &LINEAR));
    assert!(notes.is_empty());
    let bytes = || Samples::U8(vec![0, 10, 188, 255]);
    let (raster, notes) = told(bytes(), of_gamma(100_000), &AUTO);
    near(&raster.values, &values(1, bytes(), &LINEAR));
    assert!(notes[0].contains("gAMA chunk of 1 states") && notes[0].contains("--srgb"), "{notes:?}");
    // What everybody expects of 8 bits is worth no word.
    assert!(told(bytes(), srgb_chunk(), &AUTO).1.is_empty());
}

#[test]
fn light_that_is_multiplied_by_its_opacity_is_not_multiplied_again() {
    let half = ((128.0f64 / 255.0 + 0.055) / 1.055).powf(2.4);
    let plain = pixels(2, Samples::U8([128, 51].repeat(4)));
    near(&light(plain, "a", &AUTO).unwrap().0.values, &[0.2 * half; 4]);
    let multiplied = |value: u8| Pixels { premultiplied: true, ..pixels(2, Samples::U8([value, 51].repeat(4))) };
    // 26 of 51 is 128.0 of 255 to the nearest step of the file.
    let encoded = 26.0 / 51.0;
    near(&light(multiplied(26), "a", &AUTO).unwrap().0.values, &[0.2 * srgb(encoded); 4]);
    // Floats: light as it stands, and light that shines where nothing covers.
    let floats =
        Pixels { premultiplied: true, ..pixels(2, Samples::F32(vec![0.5, 0.5, 3.0, 1.0, 0.25, 0.0, 0.0, 0.0])) };
    near(&light(floats, "a", &AUTO).unwrap().0.values, &[0.5, 3.0, 0.25, 0.0]);
}

#[test]
fn light_that_is_no_drawing_is_told() {
    let plain = |values: Vec<f64>| plainness(&Raster { width: 3, height: 2, values });
    assert!(plain(vec![0.7; 6]).unwrap().contains("equally bright"));
    assert!(plain(vec![0.0, 0.0, 3.0, 0.0, 0.0, 0.0]).unwrap().contains("one pixel"));
    assert!(plain(vec![0.0, 0.0, 3.0, 0.1, 0.0, 0.0]).is_none());
    assert!(plain(vec![0.7, 0.7, 0.7, 0.7, 0.7, 0.69]).is_none());
}
