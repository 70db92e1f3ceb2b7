use super::*;
use crate::projection::Projection;
use glam::DVec3;

fn view() -> View {
    View::new(Projection::Orthographic, f64::to_radians(20.0), DVec3::Z)
}

/// A row without words.
fn row(target: &Raster, simulated: &Raster) -> Comparison {
    let (target, simulated) = (target.clone(), simulated.clone());
    Comparison { target, simulated, titles: Default::default(), numbers: Default::default() }
}

fn picture(rows: &[Comparison], view: &View) -> RgbImage {
    ComparisonPage { rows, view, on_wall: None, heading: "", footer: "" }.picture()
}

#[test]
fn the_panels_show_the_pixels_with_row_zero_on_top_and_agreement_as_white() {
    // One bright pixel at the upper left of the target; the simulation has it at the upper right.
    let target = Raster::from_fn(4, 4, |x, y| if (x, y) == (0, 0) { 1.0 } else { 0.0 });
    let simulated = Raster::from_fn(4, 4, |x, y| if (x, y) == (3, 0) { 1.0 } else { 0.0 });
    // A second row has them the other way round.
    let page = picture(&[row(&target, &simulated), row(&simulated, &target)], &view());
    let layout = Layout::new(384, 2, false, 0);
    assert_eq!(page.dimensions(), (layout.width as u32, layout.height as u32));
    let at = |line: i64, panel: usize, column: i64, row: i64| {
        let top = layout.top + line * layout.pitch;
        page.get_pixel((layout.lefts[panel] + column * 96 + 48) as u32, (top + row * 96 + 48) as u32).0
    };
    for (line, [first, second]) in [(0, [0, 3]), (1, [3, 0])] {
        assert_eq!((at(line, 0, first, 0), at(line, 0, second, 0), at(line, 0, 0, 3)), ([255; 3], [0; 3], [0; 3]));
        assert_eq!((at(line, 1, first, 0), at(line, 1, second, 0)), ([0; 3], [255; 3]));
        let differences = (at(line, 2, first, 0), at(line, 2, second, 0), at(line, 2, 1, 2));
        assert_eq!(differences, (diverging(-1.0).0, diverging(1.0).0, [255; 3]));
    }
    // The scales, through the projection: 10° stands at sin 10° / sin 20°, to the right and up.
    let offset = (192.0 * f64::to_radians(10.0).sin() / f64::to_radians(20.0).sin()).round() as i64;
    let (x, y) = (layout.lefts[0] + 192 + offset, layout.top + layout.side + 3);
    assert_eq!(page.get_pixel(x as u32, y as u32), &LINE);
    assert_eq!(page.get_pixel(x as u32 - 2, y as u32), &PAGE);
    let (x, y) = (layout.lefts[0] - 4, layout.top + 192 - offset);
    assert_eq!(page.get_pixel(x as u32, y as u32), &LINE);
    assert_eq!(page.get_pixel(x as u32, y as u32 - 2), &PAGE);
}

#[test]
fn enlarging_keeps_brightness_and_the_mean() {
    let ramp = Raster::from_fn(128, 100, |x, y| (x + 2 * y) as f64);
    for (raster, side) in [(ramp.clone(), 384), (ramp.resampled(8, 6).scaled(0.1), 384), (ramp, 64)] {
        let shown = enlarged(&raster, side);
        let mean = |r: &Raster| r.sum() / r.values.len() as f64;
        assert!((mean(&shown) / mean(&raster) - 1.0).abs() < 1e-9, "{side}");
        assert!(shown.max() <= raster.max() + 1e-9);
    }
    assert_eq!(
        [0, 1, 3, 100, 256, 384, 500, 1024, 2048].map(panel_side),
        [384, 384, 384, 400, 512, 384, 500, 512, 682]
    );
}

#[test]
fn the_colour_scale_is_round_and_holds_nearly_everything() {
    let of = |v: f64| difference_limit(&Raster::from_fn(40, 40, |x, _| if x == 7 { v } else { 0.0 }));
    assert_eq!([0.0, 0.01, -0.08, 0.3, -0.6, 7.0].map(of), [0.05, 0.05, 0.1, 0.5, 1.0, 1.0]);
    let mut single = Raster::zeros(40, 40);
    single.values[5] = 0.9;
    assert_eq!(difference_limit(&single), 0.05);
}

#[test]
fn words_stay_on_the_page_and_nothing_panics() {
    let long = "A very long caption about a very small plate, ".repeat(30);
    let mut nan = Raster::zeros(5, 5);
    nan.values[3] = f64::NAN;
    let one = Raster::from_fn(1, 1, |_, _| 1.0);
    let wide = View::new(Projection::Screen, f64::to_radians(80.0), DVec3::new(0.6, 0.0, 0.8));
    for (target, simulated) in [(&one, &one), (&Raster::zeros(0, 0), &one), (&Raster::zeros(3, 2), &one), (&nan, &nan)]
    {
        let silent = row(target, simulated);
        let each = || [long.clone(), long.clone(), long.clone()];
        let wordy = Comparison { titles: each(), numbers: each(), ..silent.clone() };
        let footer = format!("{long}\n").repeat(12);
        for view in [&view(), &wide, &View::new(Projection::Equidistant, 0.0, DVec3::Z)] {
            let rows = [wordy.clone(), wordy.clone()];
            let told = ComparisonPage { rows: &rows, view, on_wall: None, heading: &long, footer: &footer };
            let on_wall = ComparisonPage { on_wall: Some(364.0), ..told };
            assert_ne!(on_wall.picture(), told.picture());
            for page in
                [picture(std::slice::from_ref(&silent), view), told.picture(), on_wall.picture(), picture(&[], view)]
            {
                let (w, h) = page.dimensions();
                let edge = |x, y| x == 0 || y == 0 || x == w - 1 || y == h - 1;
                assert!(page.enumerate_pixels().all(|(x, y, p)| *p == PAGE || !edge(x, y)));
            }
        }
    }
}

#[test]
fn the_same_comparison_gives_the_same_picture_and_shows_its_words() {
    let target = Raster::from_fn(30, 30, |x, y| (x * y) as f64);
    let silent = [row(&target, &target)];
    let plain = picture(&silent, &view());
    assert_eq!(plain, picture(&silent, &view()));
    let told = [Comparison { numbers: [String::new(), String::new(), "TV 0".into()], ..silent[0].clone() }];
    assert_ne!(plain, picture(&told, &view()));
}
