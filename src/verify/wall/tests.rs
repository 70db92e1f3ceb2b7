use super::*;
use crate::lamp::Extent;
use crate::projection::Projection;
use crate::relief::faceted::{Facet, FacetedRelief};
use crate::setup::Setup;
use crate::slope::{Slope, direction, mirror};
use crate::trace::grid::GridSurface;
use crate::verify::measure::measure;

fn one_facet(slope: Slope, size: DVec2) -> GridSurface {
    GridSurface::new(&FacetedRelief::uniform(1, 1, size, vec![Facet { height: 0.0, slope }]), &Progress::silent())
        .unwrap()
}

fn slanting(projection: Projection) -> Setup {
    Setup::new(f64::to_radians(35.0), f64::to_radians(250.0), 0.0, projection, f64::to_radians(15.0))
}

/// Middle and root mean square along u and v, mm.
fn moments(image: &WallImage) -> (DVec2, DVec2) {
    let half_width = image.half_width;
    let image = &image.measurement.whole.image;
    let n = image.width;
    let place = |k: usize| View::pixel_centre(k % n, k / n, n, n) * half_width;
    let mean = |f: &dyn Fn(DVec2) -> DVec2| {
        let sum: DVec2 = image.values.iter().enumerate().map(|(k, v)| *v * f(place(k))).sum();
        sum / image.sum()
    };
    let middle = mean(&|at| at);
    let square = mean(&|at| (at - middle) * (at - middle));
    (middle, square.map(f64::sqrt))
}

#[test]
fn a_flat_mirror_throws_itself_as_its_mirror_image_would_shine() {
    // A point of light 400 mm away is seen 400 mm behind the plate: its light passes the plate as through a window.
    let (surface, setup) = (one_facet(Slope::FLAT, DVec2::new(20.0, 12.0)), slanting(Projection::Screen));
    let experiment = Experiment::new(&surface, &setup).under_ball(400.0, 0.0);
    let settings = WallSettings { wall_distance: 500.0, wall_tilt: 25.0, half_width: 40.0, ..WallSettings::default() };
    let measuring = Measuring { rays: 1_000_000, resolution: 64, ..Measuring::default() };
    let image = wall_image(&experiment, &settings, &measuring, &Progress::silent()).unwrap();

    let wall = Wall::new(&settings, &experiment);
    let Lamp::Ball { middle: lamp, .. } = experiment.lamp else { panic!("a ball") };
    let source = lamp.with_z(-lamp.z);
    let irradiance = image.irradiance();
    let (mut low, mut high, mut inside) = (DVec2::INFINITY, DVec2::NEG_INFINITY, 0);
    for k in 0..64 * 64 {
        let at = View::pixel_centre(k % 64, k / 64, 64, 64) * 40.0;
        if irradiance.values[k] > 0.0 {
            (low, high) = (low.min(at - 0.625), high.max(at + 0.625));
        }
        let seen_through = |at: DVec2| {
            let point = wall.centre + at.x * wall.u + at.y * wall.v;
            let window = source + (point - source) * (-source.z / (point.z - source.z));
            let (a, b) = surface.optical_area();
            (window.truncate().cmpge(a) & window.truncate().cmple(b)).all()
        };
        let whole = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        if !whole.iter().all(|&(x, y)| seen_through(at + 0.625 * DVec2::new(x, y))) {
            continue;
        }
        inside += 1;
        let way = wall.centre + at.x * wall.u + at.y * wall.v - source;
        let across = 400.0f64.powi(2) / way.length_squared();
        let expected = across * way.normalize().dot(wall.normal) / setup.light().z;
        let (got, error) = (irradiance.values[k], image.errors().values[k]);
        assert!((got - expected).abs() < 5.0 * error + 1e-4, "{at}: {got} {error} {expected}");
        assert!(error < 0.1 * expected);
    }
    assert!(inside > 200, "{inside}");
    // The spot's size, to a pixel.
    assert!((high - low - image.blur.plate).abs().max_element() < 2.0 * 1.25, "{} {}", high - low, image.blur.plate);
    let [landed, beyond, missed] = image.shares();
    assert!((landed.0 - 1.0).abs() < 1e-9 && beyond.0 == 0.0 && missed.0 == 0.0);
}

#[test]
fn blur_is_the_plates_size_and_the_lamps_angle() {
    let (surface, setup) = (one_facet(Slope::FLAT, DVec2::new(20.0, 12.0)), slanting(Projection::Screen));
    let overhead = Setup::new(0.0, 0.0, 0.004, Projection::Screen, 0.2);
    let far = WallSettings { wall_distance: 500.0, ..WallSettings::default() };
    let blur = far.blur(&Experiment::new(&surface, &overhead));
    assert!((blur.plate - DVec2::new(20.0, 12.0)).length() < 1e-9);
    assert!((blur.lamp - 2.0 * 500.0 * f64::tan(0.004)).length() < 1e-9);
    let blur = far.blur(&Experiment::new(&surface, &overhead).under_ball(250.0, 10.0));
    assert!((blur.plate - 3.0 * DVec2::new(20.0, 12.0)).length() < 1e-9);
    assert!((blur.lamp_angle - 2.0 * f64::asin(0.04)).abs() < 1e-12);
    assert!((blur.lamp.x - 1000.0 * f64::asin(0.04).tan()).abs() < 1e-9);
    assert!((blur.plate_angle.x - 2.0 * f64::atan(0.06)).abs() < 1e-12);
    // A pinhole plate shows the lamp as a disc, root mean square a quarter of its diameter, wider up a leaning wall.
    let speck = one_facet(Slope::FLAT, DVec2::splat(0.01));
    let experiment = Experiment::new(&speck, &setup).under_ball(250.0, 10.0);
    let measuring = Measuring { rays: 200_000, resolution: 200, ..Measuring::default() };
    for tilt in [0.0, 40.0] {
        let settings = WallSettings { wall_tilt: tilt, half_width: 40.0, ..far };
        let image = wall_image(&experiment, &settings, &measuring, &Progress::silent()).unwrap();
        let (_, spread) = moments(&image);
        assert!((4.0 * spread / image.blur.lamp - 1.0).abs().max_element() < 0.015, "{spread} {}", image.blur.lamp);
        assert!((image.blur.lamp.y / image.blur.lamp.x * tilt.to_radians().cos() - 1.0).abs() < 0.005);
    }
    // Both at once: the variances of disc and plate add.
    let image = wall_image(
        &Experiment::new(&surface, &overhead).under_ball(250.0, 10.0),
        &WallSettings { half_width: 80.0, ..far },
        &measuring,
        &Progress::silent(),
    );
    let image = image.unwrap();
    let (middle, spread) = moments(&image);
    let expected =
        (image.blur.lamp * image.blur.lamp / 16.0 + image.blur.plate * image.blur.plate / 12.0).map(f64::sqrt);
    assert!((spread / expected - 1.0).abs().max_element() < 0.01, "{spread} {expected}");
    assert!(middle.length() < 0.2, "{middle}");
}

#[test]
fn a_tilted_facet_throws_where_its_mirror_sends() {
    let slope = Slope::new(0.05, -0.08);
    let (surface, setup) = (one_facet(slope, DVec2::splat(0.2)), slanting(Projection::Screen));
    let experiment = Experiment::new(&surface, &setup).under_ball(600.0, 0.0);
    let settings = WallSettings { wall_distance: 700.0, wall_tilt: -30.0, half_width: 300.0, elsewhere: None };
    let measuring = Measuring { rays: 20_000, resolution: 300, ..Measuring::default() };
    let image = wall_image(&experiment, &settings, &measuring, &Progress::silent()).unwrap();
    let wall = Wall::new(&settings, &experiment);
    let expected = wall.meets(wall.middle, mirror(setup.light(), slope.normal())).unwrap();
    let (middle, spread) = moments(&image);
    assert!((middle - expected).length() < 2.0, "{middle} {expected}");
    assert!(spread.max_element() < 2.0 && expected.length() > 50.0);
    // As large as it is seen from the lamp's image behind it: a parallelogram, even but for a little perspective.
    let side = 12.0;
    let large = one_facet(slope, DVec2::splat(side));
    let image =
        wall_image(&Experiment::new(&large, &setup).under_ball(600.0, 0.0), &settings, &measuring, &Progress::silent())
            .unwrap();
    let Lamp::Ball { middle: lamp, .. } = experiment.lamp else { panic!("a ball") };
    let (m, lamp) = (slope.normal(), lamp + 0.5 * (side - 0.2) * DVec2::ONE.extend(0.0));
    let foot = (DVec2::splat(0.5 * side)).extend(0.0);
    let source = lamp - 2.0 * (lamp - foot).dot(m) * m;
    let screen = Wall::new(&settings, &Experiment::new(&large, &setup));
    let through = |x: f64, y: f64| {
        let corner = foot + DVec3::new(x, y, slope.p * x + slope.q * y);
        screen.meets(corner, corner - source).unwrap()
    };
    let half = 0.5 * side;
    let (a, b) = (through(half, 0.0) - through(-half, 0.0), through(0.0, half) - through(0.0, -half));
    let (_, spread) = moments(&image);
    let expected = ((a * a + b * b) / 12.0).map(f64::sqrt);
    assert!((spread / expected - 1.0).abs().max_element() < 0.02, "{spread} {expected}");
    // And about as the closed form for a flat plate says, which knows nothing of the facet's tilt.
    assert!((a.abs() + b.abs() - image.blur.plate).abs().max_element() < 0.15 * image.blur.plate.max_element());

    // A facet that climbs toward +x throws toward -x, on the wall as on the highlight image.
    let straight = Setup::new(0.0, 0.0, 0.0, Projection::Screen, 0.2);
    let image = wall_image(
        &Experiment::new(&surface, &straight).under_ball(600.0, 0.0),
        &settings,
        &measuring,
        &Progress::silent(),
    )
    .unwrap();
    let (middle, _) = moments(&image);
    assert!(middle.x < -20.0 && middle.y > 20.0, "{middle}");
}

#[test]
fn a_far_wall_shows_the_highlight_image_in_any_mounting() {
    let slopes = (0..64).map(|k| Slope::new(0.02 * f64::from(k % 8 - 3), 0.015 * f64::from(k / 8 - 4)));
    let facets = slopes.map(|slope| Facet { height: 0.1 * slope.p, slope }).collect();
    let surface =
        GridSurface::new(&FacetedRelief::uniform(8, 8, DVec2::splat(8.0), facets), &Progress::silent()).unwrap();
    let flat = slanting(Projection::Screen);
    for setup in [flat.clone(), flat.mounted(direction(0.1, 2.0))] {
        let material = "aluminium:ggx:0.05".parse().unwrap();
        let experiment = Experiment {
            material,
            lamp: setup.lamp().with_extent(Extent::round(0.01)).into(),
            ..Experiment::new(&surface, &setup)
        };
        let measuring = Measuring { rays: 100_000, resolution: 32, ..Measuring::default() };
        let highlight = measure(&experiment, &measuring, &Progress::silent()).unwrap();
        let wall_distance = 1e8;
        let half_width = wall_distance * setup.view().half_field().tan();
        let settings = WallSettings { wall_distance, half_width, ..WallSettings::default() };
        let image = wall_image(&experiment, &settings, &measuring, &Progress::silent()).unwrap();
        let (far, near) = (&highlight.whole.image, &image.measurement.whole.image);
        let apart: f64 = far.values.iter().zip(&near.values).map(|(a, b)| (a - b).abs()).sum();
        assert!(apart < 1e-4 * far.sum() && far.sum() > 0.5 * highlight.whole.incident, "{apart}");
        assert!(far.values.iter().filter(|v| **v > 0.0).count() > 300);
    }
}

#[test]
fn extreme_settings_are_refused_or_give_finite_light() {
    let slopes = (0..9).map(|k| Slope::new(0.3 * f64::from(k % 3 - 1), 0.2 * f64::from(k / 3 - 1)));
    let facets = slopes.map(|slope| Facet { height: slope.p - slope.q, slope }).collect();
    let relief = FacetedRelief::uniform(3, 3, DVec2::new(9.0, 5.0), facets);
    let measuring = Measuring { rays: 600, resolution: 5, ..Measuring::default() };
    let (mut collected, mut refused) = (0, 0);
    for surface in [
        GridSurface::new(&relief, &Progress::silent()).unwrap(),
        GridSurface::panel(&relief, &Progress::silent()).unwrap(),
    ] {
        for theta in [0.0, 60.0, 89.9f64] {
            let setup = Setup::new(theta.to_radians(), 1.0, 0.0, Projection::Screen, 0.3);
            let material = "brass:ggx:0.3".parse().unwrap();
            let experiment = Experiment {
                material,
                lamp: setup.lamp().with_extent(Extent::round(0.1)).into(),
                ..Experiment::new(&surface, &setup)
            };
            let lengths = [1e-3, 7.0, 1e9];
            for (lamp_distance, wall_distance) in
                [1e-3, 7.0, 1e9, f64::INFINITY].into_iter().flat_map(|d| lengths.map(|w| (d, w)))
            {
                for (lamp_radius, half_width) in [0.0, 1e-3, 5.0, 1e9].into_iter().flat_map(|r| lengths.map(|h| (r, h)))
                {
                    for wall_tilt in [-85.0, 0.0, 60.0] {
                        let experiment = if lamp_distance.is_finite() {
                            experiment.clone().under_ball(lamp_distance, lamp_radius)
                        } else {
                            experiment.clone()
                        };
                        let settings = WallSettings { wall_distance, wall_tilt, half_width, elsewhere: None };
                        match wall_image(&experiment, &settings, &measuring, &Progress::silent()) {
                            Ok(light) => {
                                collected += 1;
                                assert!(light.irradiance().values.iter().all(|v| v.is_finite()), "{settings:?}");
                                assert!((light.measurement.whole.balance() - 1.0).abs() < 1e-9, "{settings:?}");
                                assert!(light.blur.plate.min_element() >= 0.0, "{settings:?} {:?}", light.blur);
                                assert!(light.blur.lamp.min_element() >= 0.0, "{settings:?} {:?}", light.blur);
                            }
                            Err(_) => refused += 1,
                        }
                    }
                }
            }
        }
    }
    assert!(collected > 500 && refused > 500, "{collected} {refused}");
}

#[test]
fn nonsense_is_refused_and_nothing_depends_on_threads() {
    let (surface, setup) = (one_facet(Slope::FLAT, DVec2::splat(10.0)), slanting(Projection::Screen));
    let experiment = Experiment::new(&surface, &setup).under_ball(300.0, 5.0);
    let measuring = Measuring { rays: 10_000, resolution: 16, ..Measuring::default() };
    let check = |settings: WallSettings| settings.check(&experiment, &measuring);
    let under = |distance, radius| {
        WallSettings::default().check(&Experiment::new(&surface, &setup).under_ball(distance, radius), &measuring)
    };
    let fine = WallSettings::default();
    assert_eq!(check(fine), Ok(()));
    for bad in [0.0, -1.0] {
        assert!(matches!(under(bad, 5.0), Err(WallError::LampInPlate { .. })));
    }
    for bad in [f64::NAN, f64::INFINITY, 2e9] {
        assert!(matches!(under(bad, 5.0), Err(WallError::Length { .. })));
    }
    for bad in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        assert!(matches!(check(WallSettings { wall_distance: bad, ..fine }), Err(WallError::Length { .. })));
        assert!(matches!(check(WallSettings { half_width: bad, ..fine }), Err(WallError::Length { .. })));
    }
    assert!(matches!(under(300.0, f64::NAN), Err(WallError::Length { .. })));
    assert!(matches!(check(WallSettings { wall_tilt: f64::NAN, ..fine }), Err(WallError::Tilt(_))));
    assert!(matches!(check(WallSettings { wall_tilt: 90.0, ..fine }), Err(WallError::Tilt(_))));
    assert!(matches!(under(300.0, 290.0), Err(WallError::LampInPlate { .. })));
    assert!(matches!(check(WallSettings { wall_distance: 5.0, ..fine }), Ok(())));
    assert!(matches!(
        check(WallSettings { wall_distance: 1.0, wall_tilt: 70.0, ..fine }),
        Err(WallError::WallInPlate { .. })
    ));
    let none = Measuring { resolution: 0, ..measuring };
    assert_eq!(fine.check(&experiment, &none), Err(WallError::Measuring));

    let image = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| wall_image(&experiment, &fine, &measuring, &Progress::silent()).unwrap())
    };
    assert_eq!(image(1), image(3));
    // As many rounds as the error asks for.
    let wanted = Measuring { error: Some(0.01), ..measuring };
    let close = WallSettings { half_width: 30.0, ..fine };
    let taken = |measuring| wall_image(&experiment, &close, measuring, &Progress::silent()).unwrap().measurement;
    let (sure, surer) = (taken(&measuring), taken(&wanted));
    assert!(sure.image_noise() > 0.01 && surer.image_noise() <= 0.01 && surer.whole.rays > sure.whole.rays);
}
