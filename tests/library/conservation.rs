//! Laws that hold for every relief: light is neither made nor lost, light runs backward as forward, a lamp is the sum of
//! its points, and what is known in closed form is what plain rays find.

use std::f64::consts::TAU;

use crate::plates::{Shape, plate};
use facetmill::brdf::material::Material;
use facetmill::lamp::Extent;
use facetmill::progress::Progress;
use facetmill::projection::{Projection, View};
use facetmill::relief::faceted::FacetedRelief;
use facetmill::setup::Setup;
use facetmill::slope::{angle_between, direction};
use facetmill::trace::Surface;
use facetmill::trace::grid::GridSurface;
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::measure::measure;
use facetmill::verify::tally::{Measurement, Tally};
use glam::DVec3;

/// Half field of the image, degrees: everything above the plate.
const HALF_FIELD: f64 = 90.0;

struct Scene {
    theta: f64,
    phi: f64,
    lamp: Extent,
    material: Material,
    rays: u64,
    resolution: usize,
    max_bounces: u32,
}

impl Scene {
    /// A mirror under a point lamp; degrees.
    fn mirror(theta: f64, phi: f64, rays: u64) -> Self {
        let (lamp, material) = (Extent::Point, Material::MIRROR);
        Self { theta, phi, lamp, material, rays, resolution: 16, max_bounces: 8 }
    }

    fn setup(&self) -> Setup {
        let [theta, phi, half_field] = [self.theta, self.phi, HALF_FIELD].map(f64::to_radians);
        Setup::new(theta, phi, 0.0, Projection::Equidistant, half_field)
    }

    fn lit<S: Surface>(&self, surface: &S) -> Measurement {
        let setup = self.setup();
        let (lamp, material) = (self.lamp.clone(), self.material.clone());
        let experiment = Experiment { surface, setup: &setup, material, lamp: setup.lamp().with_extent(lamp).into() };
        let (rays, resolution, max_bounces) = (self.rays, self.resolution, self.max_bounces);
        let measuring = Measuring { rays, resolution, max_bounces, seed: 5, error: None };
        measure(&experiment, &measuring, &Progress::silent()).unwrap()
    }
}

/// Facets of random heights and slopes, walls higher than cells are wide, a little tamed.
fn rugged(seed: u64) -> FacetedRelief {
    let mut relief = plate(Shape::Random, 12, 9, 1.0, 0.0, seed);
    relief.facets.iter_mut().for_each(|facet| facet.height *= 0.15);
    relief
}

#[test]
fn a_white_furnace_loses_and_makes_no_light() {
    for (seed, theta) in [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0].into_iter().enumerate() {
        let relief = rugged(seed as u64);
        let size = relief.optical_area().1;
        for lamp in [Extent::Point, Extent::Disc { radius: 1e-8 }] {
            let scene = Scene { lamp, max_bounces: 100, ..Scene::mirror(theta, 50.0 * seed as f64, 400_000) };
            let m = scene.lit(&GridSurface::panel(&relief, &Progress::silent()).unwrap());
            let whole = &m.whole;
            // Endless: what comes in is the beam over one period, no more and no less, whatever shades what.
            let ends = |t: &Tally| (t.up_single + t.up_multi + t.trapped) / size.element_product();
            let incident = |t: &Tally| t.incident / size.element_product();
            // Each part left out takes a share of the beam with it: as ratios to what a whole measurement has.
            let scale = m.parts() as f64 / (m.parts() - 1) as f64;
            let [error, incident_error] = m.standard_errors(|t| [scale * ends(t), scale * incident(t)]);
            println!("endless at {theta}: incident {:.6} ± {incident_error:.1e}", incident(whole));
            assert!(incident_error < 5e-3 && error < 5e-3, "{incident_error} {error}");
            assert!((incident(whole) - 1.0).abs() <= 3.0 * incident_error + 1e-9, "{} at {theta}", incident(whole));
            assert!((ends(whole) - 1.0).abs() <= 3.0 * error + 1e-9, "{} at {theta}", ends(whole));
            let lost = whole.escaped_down + whole.absorbed + whole.taken;
            assert_eq!(whole.backface, 0.0);
            // Facets so steep that their light goes down first are known in closed form and corrected by samples: what the
            // two differ by is a few samples. Plain rays lose none.
            let samples = if scene.lamp.is_point() { 20.0 } else { 1e-9 };
            assert!(lost.abs() <= samples / scene.rays as f64 * whole.incident, "{lost} at {theta}");
            // The remainder is small: what is left in deep wells after a hundred bounces.
            assert!(whole.trapped < 0.01 * whole.incident, "{} at {theta}", whole.trapped / whole.incident);

            let m = scene.lit(&GridSurface::new(&relief, &Progress::silent()).unwrap());
            let whole = &m.whole;
            // A plate with an end loses some over its rim; nothing else, and nothing unaccounted.
            let away = whole.up_single + whole.up_multi + whole.escaped_down + whole.absorbed + whole.trapped;
            assert!((away / whole.incident - 1.0).abs() < 1e-9, "{} at {theta}", away / whole.incident);
            assert!(whole.backface == 0.0 && whole.taken.abs() < 1e-9, "{whole:?}");
        }
    }
}

/// How much of each pixel lies in the cone of `radius` around `axis`.
fn cone(setup: &Setup, n: usize, axis: DVec3, radius: f64) -> Vec<f64> {
    let fine = 4 * n;
    let mut shares = vec![0.0; n * n];
    for (row, column) in (0..fine).flat_map(|row| (0..fine).map(move |column| (row, column))) {
        let o = setup.view().inverse(View::pixel_centre(column, row, fine, fine));
        if o.is_some_and(|o| angle_between(o, axis) < radius) {
            shares[row / 4 * n + column / 4] += 1.0 / 16.0;
        }
    }
    shares
}

/// For a lamp over the cone A the light that leaves within the cone B is ∫∫ f cos θB cos θA over ∫ cos θA, and the last is
/// π sin² r cos θA of its axis: the flux from A to B times cos θA is that from B to A times cos θB.
#[test]
fn light_runs_backward_as_it_runs_forward() {
    let radius = f64::to_radians(8.0);
    for (material, seed) in [("mirror", 1), ("aluminium:ggx:0.3", 2), ("paint:0.7:beckmann:0.2", 3)] {
        let panel = GridSurface::panel(&rugged(seed), &Progress::silent()).unwrap();
        for (a, b) in [((20.0, 10.0), (55.0, 140.0)), ((65.0, 200.0), (35.0, 60.0f64))] {
            let axis = |(theta, phi): (f64, f64)| direction(theta.to_radians(), phi.to_radians());
            let flux = |from: (f64, f64), to: (f64, f64)| {
                let lamp = Extent::Disc { radius };
                let scene = Scene { lamp, resolution: 256, max_bounces: 50, ..Scene::mirror(from.0, from.1, 600_000) };
                let scene = Scene { material: material.parse().unwrap(), ..scene };
                let m = scene.lit(&panel);
                let cone = cone(&scene.setup(), 256, axis(to), radius);
                let figure = |t: &Tally| {
                    let inside: f64 = cone.iter().zip(&t.image.values).map(|(share, light)| share * light).sum();
                    [inside / t.incident * axis(from).z]
                };
                (figure(&m.whole)[0], m.standard_errors(figure)[0])
            };
            let ((there, error), (back, other)) = (flux(a, b), flux(b, a));
            let combined = error.hypot(other);
            println!("{material}: {there:.6} there, {back:.6} back, z {:.2}", (there - back) / combined);
            assert!(combined < 0.03 * there, "an error of {combined} in {there} tells nothing");
            assert!((there - back).abs() <= 3.0 * combined, "{material}: {there} there, {back} back, error {combined}");
        }
    }
}

#[test]
fn a_disc_of_light_is_the_mean_of_its_points() {
    let radius = f64::to_radians(6.0);
    let panel = GridSurface::panel(&rugged(7), &Progress::silent()).unwrap();
    let middle = direction(f64::to_radians(50.0), 1.0);
    let disc = Scene { lamp: Extent::Disc { radius }, ..Scene::mirror(50.0, 1f64.to_degrees(), 4_000_000) }.lit(&panel);
    // Even over the cap: a spiral of the golden angle.
    let points = 400;
    let (e1, e2) = facetmill::projection::carried_axes(middle);
    let mut sums = [0.0; 4];
    for k in 0..points {
        let cosine = 1.0 - (k as f64 + 0.5) / points as f64 * (1.0 - radius.cos());
        let (sin, cos) = (TAU * 0.618_033_988_749_895 * k as f64).sin_cos();
        let l = cosine * middle + (1.0 - cosine * cosine).sqrt() * (cos * e1 + sin * e2);
        let theta_phi = (l.z.acos().to_degrees(), l.y.atan2(l.x).to_degrees());
        let t = Scene::mirror(theta_phi.0, theta_phi.1, 40_000).lit(&panel).whole;
        // A tally is in horizontal area: times the cosine it is light.
        let all = [t.incident, t.up_single, t.up_multi, t.first_hit_wall];
        sums = std::array::from_fn(|f| sums[f] + l.z * all[f]);
    }
    let figures = |t: &Tally| [t.up_single, t.up_multi, t.first_hit_wall].map(|light| light / t.incident);
    let errors = disc.standard_errors(figures);
    for ((got, error), sum) in figures(&disc.whole).into_iter().zip(errors).zip(&sums[1..]) {
        // Sixteen million rays at four hundred points: their own error is no larger than the disc's.
        let (mean, combined) = (sum / sums[0], 1.5 * error + 2e-5);
        println!("disc {got:.6}, points {mean:.6}, z {:.2}", (got - mean) / combined);
        assert!(error < 1e-3, "{error}");
        assert!((got - mean).abs() <= 3.0 * combined, "{got} of the disc, {mean} of its points, error {combined}");
    }
}

/// The estimator that starts on facets against rays from above.
#[test]
fn light_known_in_closed_form_is_what_plain_rays_find() {
    for (seed, material) in [(11, "mirror"), (12, "aluminium")] {
        let relief = rugged(seed);
        let rimmed = relief.with_rim(2.0);
        for (endless, theta) in [0.0, 30.0, 60.0, 80.0].into_iter().flat_map(|theta| [(false, theta), (true, theta)]) {
            let surface = if endless {
                GridSurface::panel(&relief, &Progress::silent()).unwrap()
            } else {
                GridSurface::new(&rimmed, &Progress::silent()).unwrap()
            };
            let scene = |lamp: Extent, rays: u64| Scene {
                lamp,
                material: material.parse().unwrap(),
                ..Scene::mirror(theta, 77.0 * seed as f64, rays)
            };
            let exact = scene(Extent::Point, 1_000_000).lit(&surface);
            let plain = scene(Extent::Disc { radius: 1e-8 }, 1_000_000).lit(&surface);
            let figures = |t: &Tally| {
                let per = |light: f64| light / t.incident;
                [per(t.up_single), per(t.up_multi), per(t.first_hit_wall), t.blocked(), per(t.taken), per(t.trapped)]
            };
            let (a, b) = (figures(&exact.whole), figures(&plain.whole));
            let (da, db) = (exact.standard_errors(figures), plain.standard_errors(figures));
            let mut worst = 0.0f64;
            for k in 0..a.len() {
                let combined = da[k].hypot(db[k]);
                let z = (a[k] - b[k]).abs() / (combined + 1e-7);
                assert!(combined < 6e-3, "figure {k} of {material} at {theta}: an error of {combined} tells nothing");
                assert!(z <= 3.0, "figure {k} of {material} at {theta}: {} and {}, error {combined}", a[k], b[k]);
                // Errors of mirrors are on the safe side: whatever they say, the two are near.
                assert!((a[k] - b[k]).abs() < 2e-3, "figure {k} of {material} at {theta}: {} and {}", a[k], b[k]);
                worst = worst.max(z);
            }
            // Pixels that hold light: χ² over their number, and no single one far off.
            let (ea, eb) = (exact.pixel_errors(), plain.pixel_errors());
            let (ia, ib) = (exact.whole.share_image(), plain.whole.share_image());
            let zs: Vec<f64> = (0..ia.values.len())
                .filter(|&k| ia.values[k] + ib.values[k] > 4e-4)
                .map(|k| (ia.values[k] - ib.values[k]) / (ea.values[k].hypot(eb.values[k]) + 1e-7))
                .collect();
            let chi2 = zs.iter().map(|z| z * z).sum::<f64>() / zs.len() as f64;
            let farthest = zs.iter().fold(0.0f64, |most, z| most.max(z.abs()));
            println!("{material} at {theta}, {endless}: z {worst:.2}, χ² {chi2:.2} over {}, {farthest:.1}", zs.len());
            // Sixteen strata a side stand for more than chance: errors are on the safe side, χ² below 1.
            let most = 1.15 + 4.0 * (2.0 / zs.len() as f64).sqrt();
            assert!(zs.len() > 20 && chi2 < most && farthest < 5.5, "{material} at {theta}: {chi2}, {farthest}");
        }
    }
}
