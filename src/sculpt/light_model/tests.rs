use glam::{DMat2, DVec2};

use super::*;
use crate::cutter::Cutter;
use crate::sculpt::target::SlopeTarget;

/// Bins over slopes from -1 to 1, turned a little.
fn bins(side: usize) -> SlopeHistogram {
    let middle = DVec2::splat(0.5 * (side - 1) as f64);
    let per_slope = DMat2::from_angle(0.3) * (0.45 * side as f64);
    SlopeHistogram::new(&SlopeTarget { side, bin: 1.0, wanted: vec![0.0; side * side], per_slope, middle })
}

fn uneven(n: usize, height: f32) -> Vec<f32> {
    // No two edges as steep as each other, where light and concave edges have kinks.
    (0..n * n).map(|k| height * (((k as f64 + 1.0).sin() * 43_758.545_3).fract() * 0.5) as f32).collect()
}

fn potential(side: usize) -> Vec<f32> {
    (0..side * side).map(|k| ((k % side) as f32 * 0.21).sin() + ((k / side) as f32 * 0.17).cos()).collect()
}

#[test]
fn all_light_lands_with_and_without_a_cutter() {
    let lattice = Lattice { n: 16, step: DVec2::new(0.05, 0.04) };
    for (crossed, radius) in [(0.0, None), (0.25, None), (0.0, Some(0.01)), (0.5, Some(0.5))] {
        let concave = radius.map(|radius| ConcaveEdges::new(lattice, Cutter::ball(2.0 * radius), 0.1));
        let light =
            LightModel::new(lattice, bins(64), crossed, concave).forward(&EdgeSlopes::new(lattice, &uneven(16, 0.02)));
        let sum: f64 = light.iter().map(|v| f64::from(*v)).sum();
        assert!((sum - 1.0).abs() < 1e-5, "{radius:?}: {sum}");
    }
}

#[test]
fn ridges_either_way_up_have_no_light_but_that_of_their_flanks() {
    // Two flanks that meet along a diagonal of the squares, rising or falling to the right.
    let n = 8;
    let lattice = Lattice { n, step: DVec2::ONE };
    for falls in [false, true] {
        let z: Vec<f32> = (0..n * n)
            .map(|k| {
                let (x, y) = (k % n, if falls { n - 1 - k / n } else { k / n });
                -0.3 * ((x + n - y) % n).min((y + n - x) % n) as f32
            })
            .collect();
        let light = LightModel::new(lattice, bins(64), 0.0, None).forward(&EdgeSlopes::new(lattice, &z));
        let flank = if falls { [(0.3, 0.3), (-0.3, -0.3)] } else { [(0.3, -0.3), (-0.3, 0.3)] };
        for (p, q) in flank {
            let at = bins(64).place(p, q);
            let near = |k: usize| ((k % 64) as f32 - at.x).abs().max(((k / 64) as f32 - at.y).abs()) < 1.0;
            let share: f32 = light.iter().enumerate().filter(|(k, _)| near(*k)).map(|(_, v)| v).sum();
            // The valley opposite the ridge runs along diagonals too, and is cut across: half of its squares.
            assert!(share > 0.43, "{falls}: {share}");
        }
    }
}

#[test]
fn the_pull_is_the_derivative() {
    let side = 64;
    // Fillets are laid in pieces, whose number jumps as they grow: small balls only.
    for (radius, across, crossed, weight) in
        [(None, 0.05, 0.0, 0.0), (None, 0.04, 0.3, 0.0), (Some(0.01), 0.05, 0.1, 0.0), (Some(0.01), 0.04, 0.0, 0.4)]
    {
        let lattice = Lattice { n: 12, step: [across, 0.05].into() };
        let concave = radius.map(|radius| ConcaveEdges::new(lattice, Cutter::ball(2.0 * radius), 0.3));
        let light = LightModel::new(lattice, bins(side), crossed, concave);
        // Bilinear reading has kinks at the bins, concave edges where two edges are as steep: steps must be small beside them, sums
        // exact beside the steps.
        let phi = potential(side);
        let value = |z: &[f32]| {
            let edges = EdgeSlopes::new(lattice, z);
            let products =
                light.forward(&edges).iter().zip(&phi).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>();
            products + weight * light.penalty(&edges)
        };
        let z = uneven(12, 0.03);
        let edges = EdgeSlopes::new(lattice, &z);
        let (gradient, penalty) = light.adjoint(&edges, &phi, weight as f32);
        assert!((penalty - light.penalty(&edges)).abs() <= 1e-6 * penalty);
        let (mut product, mut ours, mut measured) = (0.0, 0.0, 0.0);
        for k in 0..144 {
            let d = 1e-5;
            let (mut up, mut down) = (z.clone(), z.clone());
            up[k] += d;
            down[k] -= d;
            let slope = (value(&up) - value(&down)) / f64::from(up[k] - down[k]);
            product += slope * f64::from(gradient[k]);
            ours += f64::from(gradient[k]).powi(2);
            measured += slope * slope;
        }
        let cosine = product / (ours * measured).sqrt();
        assert!(cosine > 0.98 && (ours / measured - 1.0).abs() < 0.05, "{radius:?}: {cosine} {}", ours / measured);
    }
}
