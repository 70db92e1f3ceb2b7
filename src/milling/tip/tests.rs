use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::cutter::Cutter;

const SHAPES: [&str; 5] = ["ball:0.5", "bull:0.6,0.15", "flat:0.4", "cone:60,0.05,0.6", "tapered:0.3,40,0.5"];

fn profile(text: &str) -> Profile {
    text.parse::<Cutter>().unwrap().profile()
}

fn mesh(triangles: &[[[f32; 3]; 3]]) -> Mesh {
    let vertices = triangles.iter().flatten().copied().collect();
    Mesh { vertices, triangles: (0..triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect() }
}

/// A sheet of n × n squares over 2 × 2 mm with heights of a function.
fn sheet(n: usize, height: impl Fn(f32, f32) -> f32) -> Mesh {
    let side = n + 1;
    let at = |k: usize| 2.0 * k as f32 / n as f32;
    let vertices = (0..side * side).map(|k| [at(k % side), at(k / side), height(at(k % side), at(k / side))]).collect();
    let squares = (0..n * n).flat_map(|k| {
        let [a, b, c, d] = [0, 1, side, side + 1].map(|next| (k / n * side + k % n + next) as u32);
        [[a, b, d], [a, d, c]]
    });
    Mesh { vertices, triangles: squares.collect() }
}

#[test]
fn a_plane_is_rested_on_where_the_underside_is_as_steep() {
    let [p, q] = [0.3, -0.2f32];
    let tilted = sheet(8, |x, y| 0.5 + p * x + q * y);
    for text in SHAPES {
        let profile = profile(text);
        let tips = TipHeights::new(&tilted, profile);
        let (at, steep) = (DVec2::new(1.03, 0.97), f64::from(p).hypot(f64::from(q)));
        let expected = 0.5 + f64::from(p) * at.x + f64::from(q) * at.y + profile.lift(steep);
        assert!((tips.at(at) - expected).abs() < 1e-6, "{text}: {} {expected}", tips.at(at));
    }
}

#[test]
fn a_roof_is_rested_on_at_its_ridge_and_a_spike_at_its_point() {
    // Two planes that meet in a ridge along y at x = 1; a ball beside it rests on the ridge as on a point below it.
    let roof = sheet(2, |x, _| 1.0 - (x - 1.0).abs());
    let tips = TipHeights::new(&roof, profile("ball:0.5"));
    let rest = |aside: f64| 1.0 - (0.25 - (0.0625 - aside * aside).sqrt());
    // The ball is as steep as the roof 0.177 mm beside its axis.
    for aside in [0.0, 0.1, -0.17] {
        assert!((tips.at(DVec2::new(1.0 + aside, 1.0)) - rest(aside)).abs() < 1e-7, "{aside}");
    }
    let lift = 0.25 * (2f64.sqrt() - 1.0);
    assert!((tips.at(DVec2::new(1.4, 1.0)) - (0.6 + lift)).abs() < 1e-7);
    let spike = mesh(&[[[1.0, 1.0, 0.7], [0.999, 0.999, 0.0], [1.0005, 0.999, 0.0]]]);
    let tips = TipHeights::new(&spike, profile("ball:0.5"));
    assert_eq!(tips.at(DVec2::new(1.3, 1.0)), f64::NEG_INFINITY);
    assert!((tips.at(DVec2::new(1.0, 1.2)) - (0.7 - 0.1)).abs() < 1e-7);
}

/// The highest of many points of the triangles over which the underside would stand; a little low, never too high.
fn sampled(triangles: &Mesh, profile: &Profile, at: DVec2, steps: usize) -> f64 {
    let mut best = f64::NEG_INFINITY;
    for k in 0..triangles.triangles.len() {
        let [a, b, c] = triangles.corners(k);
        for i in 0..=steps {
            for j in 0..=steps - i {
                let [u, v] = [i, j].map(|n| n as f64 / steps as f64);
                let p = a + u * (b - a) + v * (c - a);
                best = best.max(p.z - profile.underside(p.truncate().distance(at)));
            }
        }
    }
    best
}

#[test]
fn no_triangle_is_cut_into_and_one_is_touched() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut unit = || random.random::<f32>();
    // Free triangles that overlap and lie steeply, as no sheet's do.
    let free: Vec<[[f32; 3]; 3]> = (0..60)
        .map(|_| {
            let [x, y, z] = [unit(), unit(), 0.4 * unit()].map(|v| 1.6 * v);
            let mut corner = || [x + 0.4 * unit(), y + 0.4 * unit(), z + 0.3 * unit()];
            let [a, b, c] = [corner(), corner(), corner()];
            let up = (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]);
            if up { [a, b, c] } else { [a, c, b] }
        })
        .collect();
    let waves = sheet(24, |x, y| 0.1 * ((7.0 * x).sin() + (5.0 * y + x).cos()));
    for triangles in [mesh(&free), waves] {
        for text in SHAPES {
            let profile = profile(text);
            let tips = TipHeights::new(&triangles, profile);
            for _ in 0..12 {
                let at = DVec2::new(f64::from(2.0 * unit()), f64::from(2.0 * unit()));
                let (height, floor) = (tips.at(at), sampled(&triangles, &profile, at, 40));
                // Points 0.01 mm apart miss the highest by no more than a slope of 2 over half of that.
                let near = floor == height || (-1e-9..0.012).contains(&(height - floor));
                assert!(near, "{text} at {at}: {height} {floor}");
            }
        }
    }
}

#[test]
fn heights_are_the_same_whatever_is_around() {
    // Bounds leave out far triangles; a search through each triangle by itself leaves out none.
    let waves = sheet(16, |x, y| 0.05 * (9.0 * x).sin() * (8.0 * y).cos());
    for text in SHAPES {
        let profile = profile(text);
        let tips = TipHeights::new(&waves, profile);
        let each: Vec<TipHeights> = (0..waves.triangles.len())
            .map(|k| {
                TipHeights::new(
                    &Mesh { triangles: vec![waves.triangles[k]], vertices: waves.vertices.clone() },
                    profile,
                )
            })
            .collect();
        for k in 0..30 {
            let at = DVec2::new(0.07 * f64::from(k), 1.9 - 0.061 * f64::from(k));
            let highest = each.iter().map(|tips| tips.at(at)).fold(f64::NEG_INFINITY, f64::max);
            assert!((tips.at(at) - highest).abs() < 1e-12, "{text} at {at}");
        }
    }
}

#[test]
fn without_triangles_nothing_carries_a_cutter() {
    let tips = TipHeights::new(&Mesh::default(), profile("ball:1"));
    assert_eq!(tips.at(DVec2::ZERO), f64::NEG_INFINITY);
    let flat = sheet(2, |_, _| 0.25);
    let tips = TipHeights::new(&flat, profile("flat:0.4"));
    assert_eq!((tips.at(DVec2::splat(1.0)), tips.at(DVec2::splat(-0.5))), (0.25, f64::NEG_INFINITY));
}
