use std::f64::consts::PI;

use super::*;
use crate::lamp::Extent;
use crate::projection::Projection;
use crate::relief::faceted::{Facet, FacetedRelief};
use crate::setup::Setup;
use crate::slope::Slope;
use crate::trace::grid::GridSurface;
use crate::trace::path::frame;

fn flat() -> FacetedRelief {
    FacetedRelief::uniform(2, 2, DVec2::splat(20.0), vec![Facet { height: 0.0, slope: Slope::FLAT }; 4])
}

/// A lamp 40° from the normal.
fn slanting() -> Setup {
    Setup::new(0.7, 1.0, 0.0, Projection::Equidistant, 0.3)
}

fn under<'a>(surface: &'a GridSurface, setup: &'a Setup, material: &str, radius: f64) -> Experiment<'a, GridSurface> {
    Experiment {
        surface,
        setup,
        material: material.parse().unwrap(),
        lamp: setup.lamp().with_extent(Extent::round(radius)).into(),
    }
}

/// Largest |z| that so many normal deviates stay below with a chance of 99.7 % in all (Šidák), and then some for
/// errors that are themselves estimated.
const MOST: f64 = 5.2;

#[test]
fn a_matt_plate_is_as_bright_as_lambert_says() {
    let (surface, setup) = (GridSurface::new(&flat(), &Progress::silent()).unwrap(), slanting());
    let settings = ViewSettings {
        size: [16, 12],
        rays: 4,
        theta: 30.0,
        phi: 200.0,
        field_of_view: 1.0,
        ..ViewSettings::default()
    };
    let view = render(&under(&surface, &setup, "diffuse:0.6", 0.0), &settings, &Progress::silent()).unwrap();
    let expected = 0.6 * setup.light().z / PI;
    assert!(view.radiance.values.iter().all(|v| (v / expected - 1.0).abs() < 1e-12));
    // Past the plate's edge there is nothing, or the surroundings.
    let wide = ViewSettings { field_of_view: 10.0, ambient: 0.25, ..settings };
    let view = render(&under(&surface, &setup, "diffuse:0", 0.0), &wide, &Progress::silent()).unwrap();
    assert_eq!((view.radiance.at(0, 0), view.radiance.at(8, 6)), (0.25, 0.0));
    assert_eq!((view.radiance.at(0, 6), view.radiance.at(15, 6)), (0.25, 0.25), "nor any skirt below it");
}

#[test]
fn a_rough_plate_is_as_bright_as_its_brdf_however_the_lamp_is_found() {
    let (surface, setup) = (GridSurface::new(&flat(), &Progress::silent()).unwrap(), slanting());
    let settings = ViewSettings {
        size: [8, 8],
        theta: 38.0,
        phi: 232.0,
        distance: 60.0,
        field_of_view: 10.0,
        rays: 2500,
        ..ViewSettings::default()
    };
    for (material, radius) in [("aluminium:ggx:0.2", 0.0), ("aluminium:ggx:0.05", 0.1), ("paint:0.7:ggx:0.3", 0.2)] {
        let experiment = under(&surface, &setup, material, radius);
        let view = render(&experiment, &settings, &Progress::silent()).unwrap();
        let camera = settings.camera(&experiment);
        for k in 0..64 {
            let expected = over_pixel(k, settings.size, |uv| {
                over_disc(setup.light(), radius, |l| experiment.material.eval(-camera.direction(uv), l))
            });
            let (got, error) = (view.radiance.values[k], view.errors.values[k]);
            assert!(
                (got - expected).abs() < MOST * error + 1e-3 * expected,
                "{material} {k}: {got} {error} {expected}"
            );
        }
    }
}

#[test]
fn a_mirror_shows_the_lamp_at_its_own_radiance() {
    let (surface, setup) = (GridSurface::new(&flat(), &Progress::silent()).unwrap(), slanting());
    let settings = ViewSettings {
        theta: 40.107,
        phi: 237.296,
        distance: 60.0,
        field_of_view: 10.0,
        size: [9, 9],
        rays: 10_000,
        ..ViewSettings::default()
    };
    for material in ["aluminium", "paint:0.5"] {
        let experiment = under(&surface, &setup, material, 0.02);
        let view = render(&experiment, &settings, &Progress::silent()).unwrap();
        let radiance = 1.0 / (2.0 * PI * (1.0 - f64::cos(0.02)));
        let pigment = experiment.material.eval(settings.toward(), setup.light());
        let expected = experiment.material.facet_share(setup.light().z) * radiance + pigment;
        let middle = view.radiance.at(4, 4);
        assert!(
            (middle - expected).abs() < 4.0 * view.errors.at(4, 4) + 1e-3 * expected,
            "{material} {middle} {expected}"
        );
        assert!(view.radiance.at(0, 0) < 0.01 * middle);
    }
}

#[test]
fn in_a_white_furnace_every_pixel_is_white() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut facet = || Facet {
        height: random.random::<f64>(),
        slope: Slope::new(random.random::<f64>() - 0.5, random.random::<f64>() - 0.5),
    };
    let facets = (0..36).map(|_| facet()).collect();
    let relief = FacetedRelief::uniform(6, 6, DVec2::splat(6.0), facets);
    let setup = slanting();
    let panel = GridSurface::panel(&relief, &Progress::silent()).unwrap();
    for shape in [Shape::Flat, Shape::Sphere { radius: 20.0 }, Shape::Cylinder { radius: 20.0 }] {
        for (material, most) in [("mirror", 40), ("diffuse:1", 40), ("mirror", 2)] {
            let settings = ViewSettings {
                theta: 60.0,
                distance: 100.0,
                field_of_view: 20.0,
                size: [12, 9],
                shape,
                ambient: 1.0,
                rays: 16,
                max_bounces: most,
                ..ViewSettings::default()
            };
            // Mirrors do not show the point of light: only the surroundings shine on them.
            let view = render(&under(&panel, &setup, material, 0.0), &settings, &Progress::silent()).unwrap();
            let lit = material != "mirror";
            for k in 0..12 * 9 {
                let whole = view.radiance.values[k] + view.trapped.values[k];
                if lit {
                    // A white matt relief shows the lamp's light as well.
                    assert!(whole >= 1.0 - 1e-9, "{shape:?} {whole}");
                } else {
                    assert!((whole - 1.0).abs() < 1e-9, "{shape:?} {most} {whole}");
                }
            }
            assert!(most > 2 || view.trapped.max() > 0.01);
        }
    }
}

#[test]
fn a_rough_ball_and_cylinder_are_seen_as_their_brdf_says() {
    let (panel, setup) = (GridSurface::panel(&flat(), &Progress::silent()).unwrap(), slanting());
    for (shape, material, radius) in [
        (Shape::Sphere { radius: 30.0 }, "aluminium:ggx:0.2", 0.0),
        (Shape::Sphere { radius: 30.0 }, "brass:ggx:0.15,0.4", 0.1),
        (Shape::Cylinder { radius: 30.0 }, "gold:beckmann:0.3,0.1", 0.0),
    ] {
        let experiment = under(&panel, &setup, material, radius);
        let settings = ViewSettings {
            shape,
            distance: 200.0,
            field_of_view: 18.0,
            size: [24, 24],
            theta: 20.0,
            rays: 1600,
            ..ViewSettings::default()
        };
        let view = render(&experiment, &settings, &Progress::silent()).unwrap();
        let camera = settings.camera(&experiment);
        let (mut inside, mut total) = (0, 0.0);
        for k in 0..24 * 24 {
            let radiance = |uv: DVec2| {
                let seen = camera.direction(uv);
                let Some(axes) = shape.frame(camera.position, seen) else { return 0.0 };
                let to_local = |v: DVec3| frame(DVec3::Z).transpose() * (axes.transpose() * v);
                over_disc(setup.light(), radius, |l| experiment.material.eval(to_local(-seen), to_local(l)))
            };
            let expected = over_pixel(k, settings.size, radiance);
            let (got, error) = (view.radiance.values[k], view.errors.values[k]);
            assert!(
                (got - expected).abs() <= MOST * error + 4e-3 * expected + 1e-5,
                "{material} {k}: {got} {error} {expected}"
            );
            inside += usize::from(expected > 0.0);
            total += expected;
        }
        assert!(inside > 150, "{inside}");
        assert!((view.radiance.sum() / total - 1.0).abs() < 3e-3, "{} {total}", view.radiance.sum());
    }
}

#[test]
fn extreme_settings_are_refused_or_give_finite_pictures() {
    let slopes = (0..9).map(|k| Slope::new(0.3 * f64::from(k % 3 - 1), 0.2 * f64::from(k / 3 - 1)));
    let facets = slopes.map(|slope| Facet { height: slope.p - slope.q, slope }).collect();
    let relief = FacetedRelief::uniform(3, 3, DVec2::new(9.0, 5.0), facets);
    let setup = Setup::new(f64::to_radians(89.9), 1.0, 0.0, Projection::Equidistant, 0.3);
    let (mut seen, mut refused) = (0, 0);
    for surface in [
        GridSurface::new(&relief, &Progress::silent()).unwrap(),
        GridSurface::panel(&relief, &Progress::silent()).unwrap(),
    ] {
        for (material, lamp) in [("brass:ggx:0.001,2", 0.0), ("mirror", 3.1), ("paint:1", 1e-6)] {
            let experiment = under(&surface, &setup, material, lamp);
            let angles = [(0.0, 0.0), (45.0, -1e9), (89.999, 77.0)];
            for ((theta, phi), distance) in angles.into_iter().flat_map(|a| [1e-3, 7.0, 1e9].map(|d| (a, d))) {
                for (field_of_view, radius) in
                    [1e-6, 20.0, 160.0].into_iter().flat_map(|f| [1e-3, 5.0, 1e8].map(|r| (f, r)))
                {
                    for shape in [Shape::Flat, Shape::Sphere { radius }, Shape::Cylinder { radius }] {
                        let size = [5, 3];
                        let settings = ViewSettings {
                            theta,
                            phi,
                            distance,
                            field_of_view,
                            size,
                            shape,
                            rays: 4,
                            ..ViewSettings::default()
                        };
                        match render(&experiment, &settings, &Progress::silent()) {
                            Ok(view) => {
                                seen += 1;
                                let finite = |raster: &Raster| raster.values.iter().all(|v| v.is_finite() && *v >= 0.0);
                                let all = [&view.radiance, &view.errors, &view.trapped];
                                assert!(all.into_iter().all(finite), "{settings:?}");
                            }
                            Err(_) => refused += 1,
                        }
                    }
                }
            }
        }
    }
    assert!(seen > 300 && refused > 300, "{seen} {refused}");
}

#[test]
fn nonsense_is_refused_and_nothing_depends_on_threads() {
    let (plate, panel, setup) = (
        GridSurface::new(&flat(), &Progress::silent()).unwrap(),
        GridSurface::panel(&flat(), &Progress::silent()).unwrap(),
        slanting(),
    );
    let (rough, smooth) = (under(&plate, &setup, "brass:ggx:0.3", 0.0), under(&plate, &setup, "brass", 0.0));
    let fine = ViewSettings { size: [20, 15], rays: 4, ..ViewSettings::default() };
    assert_eq!(fine.check(&rough), Ok(()));
    let error = fine.check(&smooth).unwrap_err();
    assert!(error.to_string().contains("smooth brass"), "{error}");
    assert_eq!(ViewSettings { ambient: 0.1, ..fine }.check(&smooth), Ok(()));
    let refused = |look: ViewSettings| look.check(&rough).unwrap_err();
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        assert!(matches!(refused(ViewSettings { distance: bad, ..fine }), RenderError::Length { .. }));
        assert!(matches!(refused(ViewSettings { theta: bad, ..fine }), RenderError::Direction { .. }));
        assert!(matches!(refused(ViewSettings { field_of_view: bad, ..fine }), RenderError::FieldOfView(_)));
        assert!(matches!(refused(ViewSettings { ambient: bad, ..fine }), RenderError::Ambient(_)));
    }
    assert!(matches!(refused(ViewSettings { theta: 90.0, ..fine }), RenderError::Direction { .. }));
    assert!(matches!(refused(ViewSettings { phi: f64::NAN, ..fine }), RenderError::Direction { .. }));
    assert!(matches!(refused(ViewSettings { size: [0, 5], ..fine }), RenderError::Size(_)));
    assert!(matches!(refused(ViewSettings { rays: 0, ..fine }), RenderError::Rays(0)));
    let shape = Shape::Cylinder { radius: 10.0 };
    assert_eq!(refused(ViewSettings { shape, ..fine }), RenderError::Ends);
    let experiment = under(&panel, &setup, "brass:ggx:0.3", 0.0);
    let along = ViewSettings { shape, theta: 85.0, phi: 90.0, distance: 100.0, ..fine };
    assert_eq!(along.check(&experiment), Err(RenderError::Inside { distance: 100.0 }));
    let no_ball = Shape::Sphere { radius: f64::NAN };
    assert!(matches!(ViewSettings { shape: no_ball, ..fine }.check(&experiment), Err(RenderError::Length { .. })));

    let taken = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&rough, &fine, &Progress::silent()).unwrap())
    };
    assert_eq!(taken(1), taken(3));
}

/// Mean over pixel `k` of what is seen at image positions.
fn over_pixel(k: usize, size: [usize; 2], f: impl Fn(DVec2) -> f64) -> f64 {
    let n = 12;
    let middle = View::pixel_centre(k % size[0], k / size[0], size[0], size[1]);
    let half = 1.0 / DVec2::new(size[0] as f64, size[1] as f64);
    let mean = |j: usize| f(middle + half * View::pixel_centre(j % n, j / n, n, n));
    (0..n * n).map(mean).sum::<f64>() / (n * n) as f64
}

/// Mean over a disc-shaped lamp, by its own rings of equal solid angle.
fn over_disc(middle: DVec3, radius: f64, f: impl Fn(DVec3) -> f64) -> f64 {
    if radius == 0.0 {
        return f(middle);
    }
    let (axes, n) = (frame(middle), 8);
    let at = |j: usize| {
        let cosine = 1.0 - (f64::from((j % n) as u32) + 0.5) / n as f64 * (1.0 - radius.cos());
        let azimuth = 2.0 * PI * ((j / n) as f64 + 0.5) / n as f64;
        axes * direction(cosine.acos(), azimuth)
    };
    (0..n * n).map(|j| f(at(j))).sum::<f64>() / (n * n) as f64
}
