use image::Rgb;

use super::*;
use crate::export::page::PAGE;
use crate::relief::faceted::Facet;
use crate::slope::Slope;

fn one(slope: Slope, size: DVec2) -> FacetedRelief {
    FacetedRelief::uniform(1, 1, size, vec![Facet { height: 0.0, slope }])
}

fn brightness(p: &Rgb<u8>) -> u32 {
    p.0.iter().map(|v| u32::from(*v)).sum()
}

fn picture(relief: &FacetedRelief, pixels: usize) -> RgbImage {
    let [facets, sheet] = [false, true].map(|continuous| {
        ReliefPicture { relief, continuous, made_of: "one facet" }.picture(pixels, &Progress::silent()).unwrap()
    });
    assert_eq!(facets.dimensions(), sheet.dimensions());
    facets
}

#[test]
fn higher_ground_is_lighter_and_y_is_up() {
    let facet = |height| Facet { height, slope: Slope::FLAT };
    let relief = FacetedRelief::uniform(1, 2, DVec2::new(1.0, 2.0), vec![facet(0.0), facet(0.05)]);
    let page = picture(&relief, 400);
    let column = page.width() / 4;
    let (top, low) = (page.get_pixel(column, 60), page.get_pixel(column, 400));
    assert!(brightness(top) > brightness(low), "higher ground is lighter and lies at the top");
}

#[test]
fn captions_state_size_height_and_factor() {
    let relief = one(Slope::new(0.01, 0.0), DVec2::new(30.48, 20.0)).with_rim(1.0);
    assert_eq!(
        caption(&relief, "1 × 1 facets", 60.0),
        "32.48 × 22 mm · relief 0.305 mm · 1 × 1 facets · slopes shown ×60"
    );
    let flat = one(Slope::FLAT, DVec2::new(5.0, 5.0));
    assert_eq!(caption(&flat, "1 × 1 facets", 1.0), "5 × 5 mm · relief 0 mm · 1 × 1 facets · slopes true");
    assert_eq!([2.0, 0.5, 0.05, 0.0123456, 123.4].map(length_text), ["2 mm", "0.5 mm", "50 µm", "12.3 µm", "123 mm"]);
}

#[test]
fn any_shape_of_plate_is_drawn_with_its_aspect_and_the_same_each_time() {
    for (size, pixels) in [(DVec2::new(30.0, 10.0), 300), (DVec2::new(0.1, 40.0), 200), (DVec2::ONE, 0)] {
        let relief = one(Slope::new(0.05, 0.1), size);
        let page = picture(&relief, pixels);
        assert!(page.width() >= 336 && page.height() > 80);
        assert_eq!(page, picture(&relief, pixels));
        // The paper stays white all around: nothing is cut off at its edge.
        let (w, h) = page.dimensions();
        assert!(page.enumerate_pixels().all(|(x, y, p)| *p == PAGE || (x > 0 && y > 0 && x < w - 1 && y < h - 1)));
    }
    let page = picture(&one(Slope::new(0.05, 0.1), DVec2::new(30.0, 10.0)), 600);
    let grey = |x, y| brightness(page.get_pixel(x, y)) < 765;
    let row = (0..page.width()).filter(|&x| grey(x, 100)).count();
    let column = (0..228).filter(|&y| grey(400, y)).count();
    assert_eq!((row, column), (602, 202), "600 × 200 with its frame");
}

#[test]
fn the_section_is_a_profile_in_millimetres() {
    // A ramp along x: its section rises from the lower left to the upper right of its strip.
    let page = picture(&one(Slope::new(0.1, 0.0), DVec2::new(10.0, 10.0)), 900);
    let (left, bottom) = (120, 940);
    let highest = |x: u32| (bottom + 74 - 4..bottom + 74 + 110).find(|y| page.get_pixel(x, *y) != &PAGE).unwrap();
    let (start, middle, end) = (highest(left + 30), highest(left + 450), highest(left + 870));
    assert!(start > middle + 40 && middle > end + 40, "{start} {middle} {end}");
    assert!((2 * middle).abs_diff(start + end) < 4, "a straight line");
}
