use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::slope::{Slope, direction, mirror};

fn lobe(distribution: MicrofacetDistribution, ax: f64, ay: f64) -> Lobe {
    Lobe::new(distribution, ax, ay).unwrap()
}

fn lobes() -> Vec<Lobe> {
    let alphas = [(0.05, 0.05), (0.3, 0.3), (0.1, 0.4), (1.0, 1.0), (2.0, 0.5)];
    MicrofacetDistribution::ALL.into_iter().flat_map(|law| alphas.map(|(x, y)| lobe(law, x, y))).collect()
}

/// ∫ f(m) d(m) over the normals, by midpoints in the tilt's stretched share and azimuth: independent of the sampler
/// except for the closed form of the shares, which has its own test.
fn over_normals(lobe: &Lobe, f: impl Fn(DVec3) -> f64) -> f64 {
    let (rings, turns) = (400, 200);
    let (ax, ay) = lobe.alpha();
    let mut sum = 0.0;
    for ring in 0..rings {
        // Unit-roughness slope radius r = t/(1-t); p = ax r cos, q = ay r sin; d m.z dω = D(m) (m.z)^4 dp dq.
        let t = (f64::from(ring) + 0.5) / f64::from(rings);
        let r = t / (1.0 - t);
        for turn in 0..turns {
            let (sin, cos) = ((f64::from(turn) + 0.5) / f64::from(turns) * 2.0 * PI).sin_cos();
            let m = Slope::new(ax * r * cos, ay * r * sin).normal();
            let area = ax * ay * r / (1.0 - t).powi(2) / f64::from(rings) * 2.0 * PI / f64::from(turns);
            sum += f(m) * lobe.d(m) * m.z.powi(3) * area;
        }
    }
    sum
}

#[test]
fn normals_cover_the_plate_once_and_the_seen_area_is_the_integral() {
    for lobe in lobes() {
        let once = over_normals(&lobe, |m| m.z);
        assert!((once - 1.0).abs() < 1e-4, "{lobe}: {once}");
        for (theta, phi) in [(0.0, 0.0), (30.0, 10.0), (60.0, 100.0), (85.0, 45.0), (89.9, 200.0f64)] {
            let v = direction(f64::to_radians(theta), f64::to_radians(phi));
            let expected = over_normals(&lobe, |m| v.dot(m).max(0.0));
            let got = lobe.seen_area(v);
            assert!((got - expected).abs() < 2e-3 * expected.max(0.01), "{lobe} {theta}: {got} {expected}");
        }
    }
}

#[test]
fn shares_of_normals_within_a_tilt_are_the_closed_forms() {
    // Straight down the seen normals are d(m) m.z: GGX tan²t/(α² + tan²t), Beckmann 1 - exp(-tan²t/α²).
    let count = 40_000u32;
    for law in MicrofacetDistribution::ALL {
        for alpha in [1e-3, 0.1, 0.5, 2.0] {
            let lobe = lobe(law, alpha, alpha);
            let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
            let tilts: Vec<f64> = (0..count)
                .map(|_| lobe.sample(DVec3::Z, [random.random(), random.random()]))
                .map(|m| m.x.hypot(m.y) / m.z / alpha)
                .collect();
            for tan in [0.25, 0.5, 1.0, 1.5, 3.0f64] {
                let share = match law {
                    MicrofacetDistribution::Ggx => tan * tan / (1.0 + tan * tan),
                    MicrofacetDistribution::Beckmann => 1.0 - (-tan * tan).exp(),
                };
                let got = tilts.iter().filter(|&&tilt| tilt <= tan).count() as f64 / f64::from(count);
                let error = (share * (1.0 - share) / f64::from(count)).sqrt();
                assert!((got - share).abs() < 4.5 * error + 1e-9, "{lobe} {tan}: {got} {share}");
            }
        }
    }
}

#[test]
fn alpha_of_beckmann_is_root_two_times_the_rms_slope() {
    let (sx, sy) = (0.08, 0.2);
    let lobe = Lobe::beckmann_of_rms(sx, sy).unwrap();
    assert!((lobe.alpha().0 - 0.08 * 2.0f64.sqrt()).abs() < 1e-15);
    let square = |of: fn(Slope) -> f64| over_normals(&lobe, |m| m.z * of(Slope::from_normal(m).unwrap()).powi(2));
    assert!((square(|s| s.p).sqrt() - sx).abs() < 1e-4 * sx);
    assert!((square(|s| s.q).sqrt() - sy).abs() < 1e-4 * sy);
}

#[test]
fn single_scattering_of_ggx_at_normal_incidence_is_0_69() {
    // Albedo of F = 1 by quadrature over outgoing directions of D G / 4 (G is G1(wo) for either form, since G1(z) = 1).
    let lobe = lobe(MicrofacetDistribution::Ggx, 0.5, 0.5);
    let steps = 20_000;
    let mut albedo = 0.0;
    for step in 0..steps {
        let theta = (f64::from(step) + 0.5) / f64::from(steps) * PI / 2.0;
        let tan_m = (0.5 * theta).tan();
        let cos_m = (0.5 * theta).cos();
        let d = 0.25 / (PI * cos_m.powi(4) * (0.25 + tan_m * tan_m).powi(2));
        let g = 2.0 / (1.0 + (1.0 + 0.25 * theta.tan().powi(2)).sqrt());
        albedo += d * g / 4.0 * theta.sin() * 2.0 * PI * (PI / 2.0) / f64::from(steps);
    }
    assert!((albedo - 0.687_849).abs() < 2e-6, "{albedo}");
    assert_eq!(format!("{albedo:.2}"), "0.69");

    let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
    let count = 200_000;
    let weights: Vec<f64> = (0..count)
        .map(|_| lobe.g1(mirror(DVec3::Z, lobe.sample(DVec3::Z, [random.random(), random.random()]))))
        .collect();
    let mean = weights.iter().sum::<f64>() / f64::from(count);
    let error = (weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>()).sqrt() / f64::from(count);
    assert!((mean - albedo).abs() < 3.0 * error, "{mean} {albedo} {error}");
}

#[test]
fn reflection_at_sampled_normals_has_the_stated_density() {
    for lobe in lobes() {
        let wi = direction(1.0, 0.4);
        let m = lobe.sample(wi, [0.3, 0.6]);
        let wo = mirror(wi, m);
        // dω_o = 4 (wi·m) dω_m.
        let expected = lobe.pdf(wi, m) / (4.0 * wi.dot(m));
        assert!((lobe.reflected_pdf(wi, wo) / expected - 1.0).abs() < 1e-9, "{lobe}");
    }
}

#[test]
fn smoothest_and_grazing_stay_finite() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(4);
    let edge = [0.0, 1e-17, 0.5, 1.0 - f64::EPSILON / 2.0];
    for law in MicrofacetDistribution::ALL {
        for alpha in [1e-3, 0.1, 2.0] {
            let lobe = lobe(law, alpha, alpha);
            for z in [1e-300, 1e-12, 1e-6, 1e-3, 0.1, 1.0f64] {
                let wi = DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
                let corners: Vec<[f64; 2]> = edge.iter().flat_map(|&a| edge.map(|b| [a, b])).collect();
                let drawn: Vec<[f64; 2]> = (0..200).map(|_| random.random()).collect();
                for (index, &u) in drawn.iter().chain(&corners).enumerate() {
                    let m = lobe.sample(wi, u);
                    assert!((m.length() - 1.0).abs() < 1e-12 && m.z > 0.0, "{lobe} {z} {u:?}: {m}");
                    // At the last numbers before 1 the half vector of GGX is the difference of near vectors.
                    let slack = if index < drawn.len() { 1e-9 } else { 1e-3 };
                    assert!(wi.dot(m) > -slack, "{lobe} {z} {u:?}: {}", wi.dot(m));
                    let wo = mirror(wi, m);
                    assert!((0.0..=1.0).contains(&lobe.g1(wo)));
                    for value in [lobe.reflected(wi, wo), lobe.pdf(wi, m)] {
                        assert!(value >= 0.0 && value.is_finite(), "{lobe} {z} {u:?}: {value}");
                    }
                }
            }
        }
    }
}

#[test]
fn roughness_out_of_range_is_refused() {
    for alpha in [0.0, 9e-4, 2.1, -0.1, f64::NAN, f64::INFINITY] {
        assert!(Lobe::new(MicrofacetDistribution::Ggx, 0.1, alpha).is_err());
        assert!(Lobe::new(MicrofacetDistribution::Ggx, alpha, 0.1).is_err());
    }
}
