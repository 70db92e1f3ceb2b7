use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::named::{Kind, Named};
use super::normals::{Normals, Profile, ProfileNormals};
use super::painted::{PaintedError, PaintedNormals};
use super::*;
use crate::brdf::microfacet::{Lobe, MicrofacetDistribution};
use crate::projection::View;
use crate::raster::Raster;
use crate::slope::direction;

/// One of every model, some turned and some summed.
const ALL: [&str; 16] = [
    "lambert:0.5",
    "oren-nayar:0.9,30",
    "oren-nayar-qualitative:0.9,30",
    "phong:20",
    "blinn-phong:40",
    "gaussian:0.3",
    "beckmann:0.1,0.3,25",
    "cook-torrance:0.3",
    "ggx:0.2,0.05,30",
    "shifted-gamma:0.195704,0.706913",
    "ward:0.1,0.3",
    "ward-bounded:0.1,0.3",
    "ashikhmin-shirley:20,80,0.3,0.5",
    "lafortune:-0.9,-0.9,1,12/-0.4,-0.3,0.5,3",
    "lambert:0.2+ggx:0.3:schlick=0.04+ward:0.2:0.3",
    "beckmann:0.2:index=1.5",
];

fn named(text: &str) -> Named {
    text.parse().unwrap()
}

#[test]
fn values_are_those_of_the_papers_at_twenty_pairs_of_directions() {
    let figures = include_str!("../../../tests/models/figures.txt");
    let (mut model, mut met) = (None, Vec::new());
    for line in figures.lines().filter(|line| !line.starts_with('#')) {
        let Some(numbers) = line.split(' ').map(|n| n.parse::<f64>().ok()).collect::<Option<Vec<_>>>() else {
            met.push(line.split(':').next().unwrap().to_owned());
            model = Some(named(line));
            continue;
        };
        let at = |k: usize| direction(numbers[k].to_radians(), numbers[k + 1].to_radians());
        let (model, wanted) = (model.as_ref().unwrap(), numbers[4]);
        let got = model.value(at(0), at(2));
        // Mitsuba's is in single precision; shadowing by integration is a table here.
        let within = match model.terms()[0].kind.name {
            "ggx" => 2e-5,
            "blinn-phong" | "shifted-gamma" | "gaussian" => 3e-4,
            _ => 1e-8,
        };
        assert!((got - wanted).abs() <= within * wanted.abs() + 1e-12, "{model} {line}: {got}");
    }
    assert_eq!(met, Kind::ALL.iter().map(|kind| kind.name).collect::<Vec<_>>(), "each model once");
    assert_eq!(figures.lines().count(), 1 + 21 * Kind::ALL.len());
}

#[test]
fn light_and_viewer_may_be_exchanged_in_every_model_and_nothing_is_negative() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    for text in ALL {
        let model = named(text);
        for _ in 0..200 {
            let mut draw = || direction(random.random::<f64>() * 1.57, random.random::<f64>() * TAU);
            let (wi, wo) = (draw(), draw());
            let (there, back) = (model.value(wi, wo), model.value(wo, wi));
            assert!(there >= 0.0 && there.is_finite() && model.density(wi, wo) >= 0.0, "{text}");
            assert!((there - back).abs() <= 1e-12 * there.max(1.0), "{text}: {there} {back}");
        }
        assert_eq!((model.value(DVec3::Z, -DVec3::Z), model.value(-DVec3::Z, DVec3::Z)), (0.0, 0.0));
    }
}

#[test]
fn nothing_reflects_more_than_it_gets_and_what_would_is_refused() {
    for text in ALL.into_iter().chain(["ward:0.1", "ward:0.5", "ward-bounded:0.5", "oren-nayar:1,30", "phong:2"]) {
        let model = named(text);
        let (albedo, theta) = greatest_albedo(&model, 2);
        assert!(albedo < 1.005, "{text}: {albedo} at {theta}");
        assert_eq!(model.keep_energy(), Ok(()), "{text}");
    }
    // Lafortune's coefficients are free: these send 7 times the light back.
    let bright = named("lafortune:-1.1,-1.1,1.1,20");
    assert!(bright.keep_energy().unwrap_err().to_string().contains("times the light that comes in"));
}

#[test]
fn white_surfaces_have_the_albedos_that_are_known() {
    assert!((named("lambert:0.5").albedo(direction(0.7, 1.0)) - 0.5).abs() < 2e-3);
    // Straight on, nothing is cut off: n + 2 of Phong's is exactly what returns everything.
    assert!((named("phong:20").albedo(DVec3::Z) - 1.0).abs() < 2e-3);
    // What second bounces would bring back is lost.
    let ggx = named("ggx:0.5").albedo(DVec3::Z);
    assert!((ggx - 0.689).abs() < 0.003, "{ggx}");
    let half = named("ggx:0.2:0.5").albedo(DVec3::Z) / named("ggx:0.2").albedo(DVec3::Z);
    assert!((half - 0.5).abs() < 1e-12);
}

/// χ² of `count` samples against the density, cells pooled to an expected count of 8 or more; the chance that a sound sampler
/// does worse.
fn chance(model: &Named, wi: DVec3, count: usize, seed: u64) -> f64 {
    // Cells over (o.x, o.y) above, and one for all that goes below, where light is lost.
    const SIDE: usize = 24;
    let cell = |w: DVec3| {
        let at = |x: f64| (((x + 1.0) * 0.5 * SIDE as f64) as usize).min(SIDE - 1);
        if w.z > 0.0 { at(w.x) + SIDE * at(w.y) } else { SIDE * SIDE }
    };
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut seen = vec![0.0; SIDE * SIDE + 1];
    for _ in 0..count {
        seen[cell(model.sample(wi, random.random()))] += 1.0;
    }
    let mut wanted = vec![0.0; SIDE * SIDE + 1];
    let (polar, around) = (250, 500);
    for i in 0..polar {
        let z = (i as f64 + 0.5) / polar as f64;
        for j in 0..around {
            let w = direction(z.acos(), (j as f64 + 0.5) / around as f64 * TAU);
            wanted[cell(w)] += model.density(wi, w) * TAU / (polar * around) as f64 * count as f64;
        }
    }
    wanted[SIDE * SIDE] = (count as f64 - wanted.iter().sum::<f64>()).max(0.0);
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|a, b| wanted[*a].total_cmp(&wanted[*b]));
    let (mut chi2, mut cells, mut pool) = (0.0, 0usize, [0.0; 2]);
    for k in order {
        pool = [pool[0] + seen[k], pool[1] + wanted[k]];
        if pool[1] >= 8.0 {
            chi2 += (pool[0] - pool[1]).powi(2) / pool[1];
            cells += 1;
            pool = [0.0; 2];
        }
    }
    // Wilson and Hilferty: (χ²/k)^(1/3) is nearly normal.
    let k = (cells.max(2) - 1) as f64;
    let normal = ((chi2 / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt();
    0.5 * libm::erfc(normal / std::f64::consts::SQRT_2)
}

#[test]
fn samples_follow_their_density() {
    // Šidák: all of them together are wrong by chance once in a thousand times.
    let level = 1.0 - 0.999f64.powf(1.0 / (2 * ALL.len()) as f64);
    for (k, text) in ALL.iter().enumerate() {
        for (j, wi) in [direction(0.4, 1.0), direction(1.2, -2.0)].into_iter().enumerate() {
            let chance = chance(&named(text), wi, 10_000, (2 * k + j) as u64);
            assert!(chance > level, "{text} {j}: {chance}");
        }
    }
}

#[test]
fn a_table_of_normals_has_the_shadowing_of_its_law() {
    let side = 512;
    let table = |d: &dyn Fn(DVec3) -> f64| {
        let painted = Raster::from_fn(side, side, |x, y| {
            let uv = View::pixel_centre(x, y, side, side);
            let z2 = 1.0 - uv.length_squared();
            if z2 > 0.0 { d(uv.extend(z2.sqrt())) } else { 0.0 }
        });
        PaintedNormals::new(&painted, 0.5 * PI).unwrap()
    };
    for law in MicrofacetDistribution::ALL {
        let lobe = Lobe::new(law, 0.15, 0.4).unwrap();
        let painted = table(&|m| lobe.d(m));
        for (theta, phi) in [(0.0, 0.0), (0.5, 0.3), (1.0, 2.0), (1.3, -1.0), (1.45, 0.8)] {
            let v = direction(theta, phi);
            let (got, wanted) = (painted.smith(v), Normals::smith(&lobe, v));
            assert!((got / wanted - 1.0).abs() < 0.005, "{law:?} {theta} {phi}: {got} {wanted}");
        }
    }
    // A star of five rays has no closed form: its table is held to an integral over four times as many normals.
    let star = |m: DVec3| {
        let ray = 0.5 + 0.5 * (5.0 * m.y.atan2(m.x)).cos();
        ray * (-(m.truncate().length_squared()) / 0.09).exp()
    };
    let painted = table(&star);
    let seen = |v: DVec3| {
        let n = 1100;
        let mut sums = (0.0, 0.0);
        for k in 0..n * n {
            let uv = View::pixel_centre(k % n, k / n, n, n);
            let z2 = 1.0 - uv.length_squared();
            if z2 > 1e-9 {
                let m = uv.extend(z2.sqrt());
                sums = (sums.0 + star(m), sums.1 + star(m) * m.dot(v).max(0.0) / m.z);
            }
        }
        sums.1 / sums.0
    };
    for v in [direction(1.0, 0.2), direction(1.4, 0.6)] {
        let wanted = (v.z / seen(v)).min(1.0);
        assert!((painted.smith(v) / wanted - 1.0).abs() < 0.005, "{} {wanted}", painted.smith(v));
    }
    // Laws of the tilt alone.
    let lobe = Lobe::new(MicrofacetDistribution::Beckmann, 0.3, 0.3).unwrap();
    let gamma = ProfileNormals::new(Profile::ShiftedGamma { alpha: 0.09, power: 0.0 });
    // exp(-tan²/α) is Beckmann's law of the width √α.
    for theta in [0.0, 0.3, 1.0, 1.5] {
        let v = direction(theta, 0.4);
        assert!((gamma.density(v) / lobe.d(v) - 1.0).abs() < 1e-5 || lobe.d(v) < 1e-30, "{theta}");
        assert!((gamma.smith(v) / lobe.g1(v) - 1.0).abs() < 1e-3);
    }
}

#[test]
fn a_painted_density_is_sampled_as_it_is_painted_and_nonsense_is_refused() {
    let star = Raster::from_fn(32, 32, |x, y| f64::from(u8::from(x > 20 && y < 9)));
    let normals = PaintedNormals::new(&star, 0.5).unwrap();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    for _ in 0..1000 {
        let m = normals.sample(DVec3::Z, random.random());
        assert!((m.length() - 1.0).abs() < 1e-12 && m.x > 0.0 && m.y > 0.0 && normals.density(m) > 0.0);
    }
    let mut bad = star.clone();
    bad.values[3] = -1.0;
    assert_eq!(PaintedNormals::new(&bad, 0.5).unwrap_err(), PaintedError::Value(-1.0));
    assert_eq!(PaintedNormals::new(&Raster::zeros(8, 8), 0.5).unwrap_err(), PaintedError::Empty);
    assert!(matches!(PaintedNormals::new(&star, 2.0).unwrap_err(), PaintedError::Rim(_)));
}
