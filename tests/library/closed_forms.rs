//! Surfaces whose light is known in closed form, measured the way every design is: within three standard errors of the
//! measurement's own, and with errors small enough that a wrong answer would show.
//!
//! Each surface is traced as a grid with the first bounce in closed form, as a grid with plain rays only (a lamp of next
//! to no size forces them), and as the triangles of its closed solid.

use std::f64::consts::{PI, TAU};

use facetmill::brdf::material::{Material, Substance};
use facetmill::brdf::metals::Metal;
use facetmill::brdf::microfacet::{Lobe, MicrofacetDistribution};
use facetmill::export::solid::solid;
use facetmill::lamp::Extent;
use facetmill::progress::Progress;
use facetmill::projection::{Projection, View};
use facetmill::relief::faceted::{Facet, FacetedRelief};
use facetmill::relief::height_grid::HeightGrid;
use facetmill::setup::Setup;
use facetmill::slope::Slope;
use facetmill::trace::Surface;
use facetmill::trace::grid::GridSurface;
use facetmill::trace::mesh::MeshSurface;
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::measure::measure;
use facetmill::verify::tally::{Measurement, Tally};
use glam::{DVec2, DVec3};

/// Plain rays over grids; rays over meshes, whose search is slower; and rays that correct what is known in closed form.
const RAYS: u64 = 10_000_000;
const MESH_RAYS: u64 = 1_000_000;
const CORRECTING_RAYS: u64 = 2_000_000;

/// A lamp of next to no size.
const NEARLY_POINT: Extent = Extent::Disc { radius: 1e-8 };

/// Light from THETA, PHI and the image around its mirror direction; degrees.
#[derive(Clone)]
struct Scene {
    theta: f64,
    phi: f64,
    half_field: f64,
    resolution: usize,
    material: Material,
}

impl Scene {
    fn overhead(half_field: f64, resolution: usize) -> Self {
        Self { theta: 0.0, phi: 0.0, half_field, resolution, material: Material::MIRROR }
    }

    fn setup(&self) -> Setup {
        let [theta, phi, half_field] = [self.theta, self.phi, self.half_field].map(f64::to_radians);
        Setup::new(theta, phi, 0.0, Projection::Equidistant, half_field)
    }

    fn lit<S: Surface>(&self, surface: &S, lamp: Extent, rays: u64) -> Measurement {
        let setup = self.setup();
        let experiment = Experiment {
            surface,
            setup: &setup,
            material: self.material.clone(),
            lamp: setup.lamp().with_extent(lamp).into(),
        };
        let measuring = Measuring { rays, resolution: self.resolution, seed: 20, ..Measuring::default() };
        let measurement = measure(&experiment, &measuring, &Progress::silent()).unwrap();
        assert!((measurement.whole.balance() - 1.0).abs() < 1e-9, "light is lost or made");
        measurement
    }

    /// Plain rays, which a lamp of any size takes.
    fn plain<S: Surface>(&self, surface: &S) -> Measurement {
        self.lit(surface, NEARLY_POINT, RAYS)
    }

    /// The three ways to trace a relief, by name.
    fn all_ways(&self, relief: &FacetedRelief) -> [(&'static str, Measurement); 3] {
        self.all_ways_with(relief, 1)
    }

    /// The same with so many times fewer rays.
    fn all_ways_with(&self, relief: &FacetedRelief, fewer: u64) -> [(&'static str, Measurement); 3] {
        let grid = GridSurface::new(relief, &Progress::silent()).unwrap();
        let mesh = MeshSurface::new(&solid(relief, 1.0, &Progress::silent()).unwrap(), 0.0).unwrap();
        [
            ("exact", self.lit(&grid, Extent::Point, CORRECTING_RAYS / fewer)),
            ("plain", self.lit(&grid, NEARLY_POINT, RAYS / fewer)),
            ("mesh", self.lit(&mesh, Extent::Point, MESH_RAYS / fewer)),
        ]
    }
}

/// Demands that a figure is `want` within three standard errors, and that one of them is no more than `telling`.
fn agrees(what: &str, m: &Measurement, figure: impl Fn(&Tally) -> f64 + Sync, want: f64, telling: f64) {
    agrees_within(what, m, figure, want, telling, 0.0);
}

/// The same where the surface is `off` from the one that the closed form is about.
fn agrees_within(
    what: &str,
    m: &Measurement,
    figure: impl Fn(&Tally) -> f64 + Sync,
    want: f64,
    telling: f64,
    off: f64,
) {
    let value = figure(&m.whole);
    let [error] = m.standard_errors(|tally| [figure(tally)]);
    let apart = value - want;
    println!("{what}: {value:.6}, known {want:.6}, error {error:.1e}, z {:.2}", apart / error.max(1e-12));
    assert!(error <= telling, "{what}: a standard error of {error} tells nothing");
    assert!(apart.abs() <= 3.0 * error + off + 1e-9, "{what}: {value}, not {want}, with a standard error of {error}");
}

/// Share of incident light in the pixel at an image position.
fn in_pixel(tally: &Tally, uv: DVec2) -> f64 {
    let n = tally.image.width;
    let (column, row) = View::pixel_at(uv, n, n).unwrap();
    tally.image.values[row * n + column] / tally.incident
}

/// Columns of facets that climb along x by turns, from (length along x, height at the middle, slope).
fn columns(list: &[(f64, f64, f64)], depth: f64) -> FacetedRelief {
    let mut x = vec![0.0];
    x.extend(list.iter().scan(0.0, |at, column| {
        *at += column.0;
        Some(*at)
    }));
    let facet = |&(_, height, p): &(f64, f64, f64)| Facet { height, slope: Slope::new(p, 0.0) };
    let facets = list.iter().map(facet).collect();
    FacetedRelief { x, y: vec![0.0, depth], facets, optical: (0..list.len(), 0..1) }
}

#[test]
fn a_flat_mirror_makes_one_spot_at_the_mirror_direction() {
    let flat = columns(&[(10.0, 0.0, 0.0)], 7.0);
    for (theta, phi) in [(0.0, 0.0), (30.0, 110.0), (75.0, -40.0)] {
        let scene = Scene { theta, phi, ..Scene::overhead(20.0, 101) };
        for (way, m) in scene.all_ways_with(&flat, 100) {
            // The lamp of next to no size is far smaller than the pixel around the middle: nothing is random.
            agrees(&format!("{way}: spot at {theta}"), &m, |t| in_pixel(t, DVec2::ZERO), 1.0, 1e-12);
        }
    }
}

#[test]
fn a_plane_tilted_by_t_throws_light_2t_aside() {
    for (tilt, azimuth) in [(5.0, 30.0), (14.0, 250.0f64)] {
        let (t, a) = (f64::to_radians(tilt), azimuth.to_radians());
        let slope = -t.tan() * DVec2::from_angle(a);
        let facet = |k: usize| {
            let middle = DVec2::new((k % 4) as f64 + 0.5, (k / 4) as f64 + 0.5);
            Facet { height: slope.dot(middle), slope: Slope::from_vec(slope) }
        };
        let plane = FacetedRelief::uniform(4, 3, DVec2::new(4.0, 3.0), (0..12).map(facet).collect());
        for (way, m) in Scene::overhead(40.0, 401).all_ways_with(&plane, 100) {
            // Equidistant: the angle from straight up, 2 t, is 40° at the rim of the image.
            let uv = 2.0 * tilt / 40.0 * DVec2::from_angle(a);
            agrees(&format!("{way}: spot of a plane tilted by {tilt}"), &m, |t| in_pixel(t, uv), 1.0, 1e-12);
        }
    }
}

/// Nodes over a square of side 2 `half` around 0, and the same surface as tangent planes.
fn dome(half: f64, n: usize, z: impl Fn(DVec2) -> f64) -> HeightGrid {
    let lines: Vec<f64> = (0..=n).map(|k| half * (2.0 * k as f64 / n as f64 - 1.0)).collect();
    let heights = lines.iter().flat_map(|&y| lines.iter().map(move |&x| DVec2::new(x, y))).map(z).collect();
    HeightGrid::new(lines.clone(), lines, heights, &Progress::silent()).unwrap()
}

fn facets_of_dome(half: f64, n: usize, z: impl Fn(DVec2) -> f64) -> FacetedRelief {
    let pitch = 2.0 * half / n as f64;
    let facet = |k: usize| {
        let at = DVec2::new((k % n) as f64 + 0.5, (k / n) as f64 + 0.5) * pitch - half;
        let along = |step: DVec2| (z(at + step) - z(at - step)) / (2.0 * step.length());
        let slope = Slope::new(along(0.5 * pitch * DVec2::X), along(0.5 * pitch * DVec2::Y));
        Facet { height: z(at), slope }
    };
    FacetedRelief::uniform(n, n, DVec2::splat(2.0 * half), (0..n * n).map(facet).collect())
}

/// Overhead light off a convex dome of curvature 1/R = 1 on the square |x|, |y| <= 1/2: middle, sides and corners of an
/// image of 3 × 3 pixels, 45° to the rim, all of it inside what the dome lights.
fn dome_agrees(name: &str, z: impl Fn(DVec2) -> f64 + Copy, intensity: impl Fn(f64) -> f64) {
    let scene = Scene::overhead(45.0, 3);
    let setup = scene.setup();
    // ∫ I dω over each pixel by the midpoint rule, over the beam of cross section 1.
    let fine = 300;
    let mut want = [0.0; 9];
    for k in 0..fine * fine {
        let uv = View::pixel_centre(k % fine, k / fine, fine, fine);
        let angle = setup.view().inverse(uv).unwrap().z.acos();
        let (column, row) = (k % fine / (fine / 3), k / fine / (fine / 3));
        want[3 * row + column] += intensity(angle) * setup.view().solid_angle_density(uv) * 4.0 / (fine * fine) as f64;
    }
    let surface = GridSurface::continuous(&dome(0.5, 1000, z), &Progress::silent()).unwrap();
    let mesh = MeshSurface::new(&solid(&facets_of_dome(0.5, 400, z), 1.0, &Progress::silent()).unwrap(), 0.0).unwrap();
    let ways = [
        ("exact", 1000.0, scene.lit(&surface, Extent::Point, 100_000)),
        ("plain", 1000.0, scene.plain(&surface)),
        ("mesh", 400.0, scene.lit(&mesh, Extent::Point, MESH_RAYS)),
    ];
    for (way, pieces, m) in ways {
        for (part, pixels) in [("middle", &[4][..]), ("sides", &[1, 3, 5, 7]), ("corners", &[0, 2, 6, 8])] {
            let known: f64 = pixels.iter().map(|&k| want[k]).sum();
            let share = |t: &Tally| pixels.iter().map(|&k| t.image.values[k]).sum::<f64>() / t.incident;
            // A surface of n flat pieces a side lights in n steps. A pixel is 0.26 n of them wide, at the least, and its
            // rim may cut half a step off or add it at either end, in both directions.
            let off = 8.0 / pieces * known;
            agrees_within(&format!("{way}: {part} of the {name}"), &m, share, known, 1e-2 * known, off);
        }
    }
}

#[test]
fn a_paraboloid_spreads_light_as_the_fourth_power_of_the_secant() {
    dome_agrees("paraboloid", |at| -0.5 * at.length_squared(), |angle| 0.25 * (0.5 * angle).cos().powi(-4));
}

#[test]
fn a_spherical_cap_spreads_light_evenly() {
    dome_agrees("spherical cap", |at| (1.0 - at.length_squared()).sqrt(), |_| 0.25);
}

/// Ten grooves of half-slope `beta`, degrees, ridges at both ends.
fn grooves(beta: f64) -> FacetedRelief {
    let p = beta.to_radians().tan();
    columns(&[(0.5, 0.0, -p), (0.5, 0.0, p)].repeat(10), 4.0)
}

/// Overhead light meets a side at distance d from the valley and leaves 2β from the vertical, toward the other side. It
/// climbs cot 2β a mm, that side tan β, so it arrives x = d (tan β + cot 2β) / (tan β - cot 2β) from the valley, if that is
/// still groove: a share (tan β - cot 2β) / (tan β + cot 2β) = 1 - 2 cos 2β of it for 30° < β <= 45°. The second mirror,
/// tilted -β, turns the way 2β - 180° back to light into 2 (-β) - (2β - 180°) = 180° - 4β, which climbs past everything.
fn twice_reflected(beta: f64) -> f64 {
    1.0 - 2.0 * (2.0 * beta.to_radians()).cos()
}

#[test]
fn v_grooves_send_the_known_share_back_after_two_bounces_at_the_known_angle() {
    for beta in [35.0, 40.0, 45.0] {
        let share = twice_reflected(beta);
        for (way, m) in Scene::overhead(85.0, 171).all_ways(&grooves(beta)) {
            agrees(&format!("{way}: two bounces at {beta}"), &m, Tally::multi_bounce, share, 5e-4);
            agrees(&format!("{way}: one bounce at {beta}"), &m, |t| t.up_single / t.incident, 1.0 - share, 5e-4);
            let both_sides = |t: &Tally, angle: f64| {
                let spot = |side: f64| in_pixel(t, DVec2::new(side * angle / 85.0, 0.0));
                if angle == 0.0 { spot(1.0) } else { spot(1.0) + spot(-1.0) }
            };
            let twice = 180.0 - 4.0 * beta;
            agrees(&format!("{way}: at {twice} degrees"), &m, |t| both_sides(t, twice), share, 5e-4);
            if share < 0.999 {
                agrees(
                    &format!("{way}: at {} degrees", 2.0 * beta),
                    &m,
                    |t| both_sides(t, 2.0 * beta),
                    1.0 - share,
                    5e-4,
                );
            }
        }
    }
}

/// Fresnel's equations in complex numbers, as (real, imaginary): an independent spelling of them.
fn fresnel(cosine: f64, (eta, k): (f64, f64)) -> f64 {
    let times = |a: (f64, f64), b: (f64, f64)| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let squared = |a: (f64, f64)| a.0 * a.0 + a.1 * a.1;
    let index = (eta, k);
    let index2 = times(index, index);
    // n cos θt = √(n² - sin²), the root with positive parts.
    let radicand = (index2.0 - (1.0 - cosine * cosine), index2.1);
    let modulus = squared(radicand).sqrt();
    let refracted = ((0.5 * (modulus + radicand.0)).sqrt(), (0.5 * (modulus - radicand.0)).sqrt());
    let across = squared((cosine - refracted.0, refracted.1)) / squared((cosine + refracted.0, refracted.1));
    let (near, far) = ((index2.0 * cosine, index2.1 * cosine), refracted);
    let along = squared((near.0 - far.0, near.1 - far.1)) / squared((near.0 + far.0, near.1 + far.1));
    0.5 * (across + along)
}

#[test]
fn aluminium_grooves_lose_at_each_bounce_what_fresnel_takes() {
    let index = Metal::Aluminium.at(Substance::WAVELENGTH);
    for beta in [35.0, 40.0, 45.0] {
        let scene = Scene { material: "aluminium".parse().unwrap(), ..Scene::overhead(85.0, 11) };
        // Light meets the first side at β, and the second at 180° - 3β.
        let [first, second] = [beta, 180.0 - 3.0 * beta].map(|angle: f64| fresnel(angle.to_radians().cos(), index));
        let share = twice_reflected(beta);
        for (way, m) in scene.all_ways_with(&grooves(beta), 5) {
            let twice = |t: &Tally| t.up_multi / t.incident;
            agrees(&format!("{way}: aluminium twice at {beta}"), &m, twice, share * first * second, 5e-4);
            let once = |t: &Tally| t.up_single / t.incident;
            agrees(&format!("{way}: aluminium once at {beta}"), &m, once, (1.0 - share) * first, 5e-4);
        }
    }
}

/// Blocks 1 mm wide and high, gaps of 2 mm; light along x. Each gap's walls take h tan θ of the beam and throw it on the
/// floor; as much of the lit floor throws its light on the other wall: 2 h tan θ a gap bounces twice.
#[test]
fn a_comb_of_walls_shadows_what_its_height_times_the_tangent_says() {
    let (block, gap) = ((1.0, 1.0, 0.0), (2.0, 0.0, 0.0));
    for (theta, phi) in [(10.0, 0.0), (30.0, 180.0), (44.0, 0.0)] {
        let scene = Scene { theta, phi, ..Scene::overhead(90.0, 3) };
        let tangent = f64::to_radians(theta).tan();
        let check = |way: &str, m: &Measurement, gaps: f64, width: f64| {
            let shadowed = |t: &Tally| t.first_hit_wall / t.incident;
            agrees(&format!("{way}: wall first at {theta}"), m, shadowed, gaps * tangent / width, 5e-4);
            agrees(
                &format!("{way}: comb, twice at {theta}"),
                m,
                Tally::multi_bounce,
                2.0 * gaps * tangent / width,
                5e-4,
            );
            agrees(&format!("{way}: comb, up at {theta}"), m, Tally::up, 1.0, 5e-4);
        };
        let panel = GridSurface::panel(&columns(&[block, gap], 4.0), &Progress::silent()).unwrap();
        check("endless, exact", &scene.lit(&panel, Extent::Point, CORRECTING_RAYS), 1.0, 3.0);
        check("endless, plain", &scene.plain(&panel), 1.0, 3.0);
        let comb = columns(&[&[block, gap].repeat(5)[..], &[block]].concat(), 4.0);
        for (way, m) in scene.all_ways(&comb) {
            check(way, &m, 5.0, 16.0);
        }
    }
}

/// Facet area per steradian of normals tilted by `tilt`, and Smith's G₁ toward `angle`: Walter et al., EGSR 2007, eq. 25,
/// 33 and 26, 34, with the error function as an integral.
fn walter(law: MicrofacetDistribution, alpha: f64) -> (impl Fn(f64) -> f64, impl Fn(f64) -> f64) {
    let d = move |tilt: f64| {
        let (t2, c4) = (tilt.tan().powi(2), tilt.cos().powi(4));
        match law {
            MicrofacetDistribution::Ggx => alpha * alpha / (PI * c4 * (alpha * alpha + t2).powi(2)),
            MicrofacetDistribution::Beckmann => (-t2 / (alpha * alpha)).exp() / (PI * alpha * alpha * c4),
            other => panic!("no closed form of {other:?} here"),
        }
    };
    let g1 = move |angle: f64| {
        let slope = alpha * angle.tan();
        if slope < 1e-9 {
            return 1.0;
        }
        match law {
            MicrofacetDistribution::Ggx => 2.0 / (1.0 + (1.0 + slope * slope).sqrt()),
            MicrofacetDistribution::Beckmann => {
                let a: f64 = 1.0 / slope;
                let end = a.min(6.0);
                let erf = 2.0 / PI.sqrt() * midpoints(0.0, end, 200, |t| (-t * t).exp());
                2.0 / (1.0 + erf + (-a * a).exp() / (a * PI.sqrt()))
            }
            other => panic!("no closed form of {other:?} here"),
        }
    };
    (d, g1)
}

fn midpoints(from: f64, to: f64, n: usize, f: impl Fn(f64) -> f64) -> f64 {
    let step = (to - from) / n as f64;
    (0..n).map(|k| step * f(from + (k as f64 + 0.5) * step)).sum()
}

/// Visible normals are drawn with density D G₁(l) (l·m) / cos θi and weighed G₁(o); mirroring spreads dω_m over
/// dω_o = 4 (l·m) dω_m. So the light per steradian is D G₁(l) G₁(o) / (4 cos θi): the bias toward normals that face the
/// light is gone, and the masking G₁(o) is what is left between half vectors seen and normals there.
#[test]
fn half_vectors_of_rough_plates_lie_within_a_tilt_as_their_laws_say() {
    let flat = columns(&[(10.0, 0.0, 0.0)], 10.0);
    let mesh = MeshSurface::new(&solid(&flat, 1.0, &Progress::silent()).unwrap(), 0.0).unwrap();
    let grid = GridSurface::new(&flat, &Progress::silent()).unwrap();
    let alpha = 0.2;
    for (law, theta) in [MicrofacetDistribution::Ggx, MicrofacetDistribution::Beckmann]
        .into_iter()
        .flat_map(|law| [(law, 0.0), (law, 45.0)])
    {
        let material = Material::new(Substance::Mirror, Some(Lobe::new(law, alpha, alpha).unwrap())).unwrap();
        let scene = Scene { theta, phi: 200.0, material, ..Scene::overhead(80.0, 128) };
        let ways =
            [("grid", scene.lit(&grid, Extent::Point, RAYS / 2)), ("mesh", scene.lit(&mesh, Extent::Point, MESH_RAYS))];
        let (setup, (d, g1)) = (scene.setup(), walter(law, alpha));
        let half_tilt = |o: DVec3| (o + setup.light()).normalize().z.min(1.0).acos();
        let n = 128;
        let centre_tilt: Vec<f64> = (0..n * n)
            .map(|k| setup.view().inverse(View::pixel_centre(k % n, k / n, n, n)))
            .map(|o| o.filter(|o| o.z > 0.0).map_or(f64::INFINITY, half_tilt))
            .collect();
        for factor in [0.5, 1.0, 2.0] {
            let tilt = f64::atan(factor * alpha);
            let inside: Vec<usize> = (0..n * n).filter(|&k| centre_tilt[k] < tilt).collect();
            let (mut known, mut unmasked) = (0.0, 0.0);
            let fine = 4 * n;
            for (&k, sub) in inside.iter().flat_map(|k| (0..16).map(move |sub| (k, sub))) {
                let uv = View::pixel_centre(4 * (k % n) + sub % 4, 4 * (k / n) + sub / 4, fine, fine);
                let Some(o) = setup.view().inverse(uv).filter(|o| o.z > 0.0) else { continue };
                let area = 4.0 / (fine * fine) as f64 * setup.view().solid_angle_density(uv);
                let light = d(half_tilt(o)) / (4.0 * setup.light().z) * area;
                known += light * g1(theta.to_radians()) * g1(o.z.acos());
                unmasked += light;
            }
            if theta == 0.0 {
                // Without masking, D cos θ dω within the tilt, but for the staircase of pixels around it.
                let plain = match law {
                    MicrofacetDistribution::Ggx => factor * factor / (1.0 + factor * factor),
                    MicrofacetDistribution::Beckmann => 1.0 - (-factor * factor).exp(),
                    other => panic!("no closed form of {other:?} here"),
                };
                assert!((unmasked - plain).abs() < 0.01, "{unmasked} {plain}");
            }
            for (way, m) in &ways {
                let share = |t: &Tally| inside.iter().map(|&k| t.image.values[k]).sum::<f64>() / t.incident;
                let what = format!("{way}: {} within {factor} alpha at {theta}", law.name());
                agrees(&what, m, share, known, 1e-3);
            }
        }
    }
}

#[test]
fn a_very_rough_mirror_returns_seven_tenths_of_light_from_above() {
    let (d, g1) = walter(MicrofacetDistribution::Ggx, 0.5);
    // Half vectors tilted beyond 45° send light into the plate.
    let albedo = midpoints(0.0, PI / 4.0, 10_000, |t| TAU * t.sin() * t.cos() * d(t) * g1(2.0 * t));
    assert!((albedo - 0.69).abs() < 0.005, "{albedo}");
    let scene = Scene { material: "mirror:ggx:0.5".parse().unwrap(), ..Scene::overhead(90.0, 3) };
    let flat = columns(&[(10.0, 0.0, 0.0)], 10.0);
    for (way, m) in scene.all_ways(&flat) {
        agrees(&format!("{way}: albedo"), &m, Tally::up, albedo, 1e-3);
        // All of it inside the image, whose rim is the horizon on two sides and past it elsewhere.
        assert_eq!(m.whole.outside_image, 0.0);
    }
}
