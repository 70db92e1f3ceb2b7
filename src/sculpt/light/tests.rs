use glam::DMat2;

use super::*;
use crate::sculpt::target::SlopeTarget;

/// Bins over slopes from -1 to 1, turned a little.
fn bins(side: usize) -> Bins {
    let middle = DVec2::splat(0.5 * (side - 1) as f64);
    let per_slope = DMat2::from_angle(0.3) * (0.45 * side as f64);
    Bins::new(&SlopeTarget { side, bin: 1.0, wanted: vec![0.0; side * side], per_slope, middle })
}

fn uneven(n: usize, height: f32) -> Vec<f32> {
    (0..n * n).map(|k| height * ((k * 7919 % 1009) as f32 / 1009.0 - 0.5)).collect()
}

fn potential(side: usize) -> Vec<f32> {
    (0..side * side).map(|k| ((k % side) as f32 * 0.21).sin() + ((k / side) as f32 * 0.17).cos()).collect()
}

#[test]
fn all_light_lands_with_and_without_a_cutter() {
    let lattice = Lattice { n: 16, step: DVec2::new(0.05, 0.04) };
    for radius in [None, Some(0.002), Some(0.01), Some(0.5)] {
        let light = Light::new(lattice, bins(64), radius, 0.0).shine(&uneven(16, 0.02));
        let sum: f64 = light.iter().map(|v| f64::from(*v)).sum();
        assert!((sum - 1.0).abs() < 1e-5, "{radius:?}: {sum}");
    }
}

#[test]
fn a_groove_sends_light_two_ways_and_its_fillet_in_between() {
    // z falls to the middle and rises again: slopes -0.4 and 0.4, one valley and one ridge a cell.
    let (n, h, r) = (16, 0.05, 0.03);
    let lattice = Lattice { n, step: DVec2::splat(h) };
    let z: Vec<f32> = (0..n * n).map(|k| 0.4 * h as f32 * ((k % n) as f32 - 8.0).abs()).collect();
    let bins = bins(128);
    let light = Light::new(lattice, bins, Some(r), 0.0).shine(&z);
    let share_near = |p: f64| {
        let at = bins.place(p as f32, 0.0);
        let near = |k: usize| ((k % 128) as f32 - at.x).hypot((k / 128) as f32 - at.y) < 1.9;
        light.iter().enumerate().filter(|(k, _)| near(*k)).map(|(_, v)| f64::from(*v)).sum::<f64>()
    };
    // R Δs = 0.024 of the cell's 0.8 mm.
    let fillet = r * 0.8 / (n as f64 * h);
    let flank = 0.5 * (1.0 - fillet);
    assert!(share_near(0.4) > flank && share_near(0.4) < flank + 0.1 * fillet);
    assert!(share_near(-0.4) > flank && share_near(-0.4) < flank + 0.1 * fillet);
    // A disc 3.8 bins across on a way of 46 bins.
    let per_bin = fillet / (0.8 * 0.45 * 128.0);
    for p in [-0.25, 0.0, 0.3] {
        assert!((share_near(p) / per_bin - 3.8).abs() < 1.0, "{p}: {}", share_near(p) / per_bin);
    }
    let plain = Light::new(lattice, bins, None, 0.0).shine(&z);
    assert!(plain.iter().filter(|v| **v > 0.0).count() <= 8);
}

#[test]
fn the_pull_is_the_derivative() {
    let side = 64;
    // The last is all eaten up by fillets, whose pieces change in number as they grow: little, but at once.
    let cases = [(None, 0.05, 0.0, 0.999), (Some(0.01), 0.05, 0.01, 0.995), (Some(0.2), 0.04, 0.0, 0.97)];
    for (radius, across, rounding, alike) in cases {
        let step = [across, 0.05];
        let lattice = Lattice { n: 12, step: step.into() };
        let light = Light::new(lattice, bins(side), radius, rounding);
        // Bilinear reading has kinks at the bins: steps must be small beside them, sums exact beside the steps.
        let phi = potential(side);
        let value =
            |z: &[f32]| light.shine(z).iter().zip(&phi).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>();
        let z = uneven(12, 0.03);
        let pull = light.pull(&z, &phi, 0.0);
        let (mut product, mut ours, mut measured) = (0.0, 0.0, 0.0);
        for k in 0..144 {
            let d = 1e-4;
            let (mut up, mut down) = (z.clone(), z.clone());
            up[k] += d;
            down[k] -= d;
            let slope = (value(&up) - value(&down)) / f64::from(up[k] - down[k]);
            product += slope * f64::from(pull[k]);
            ours += f64::from(pull[k]).powi(2);
            measured += slope * slope;
        }
        let cosine = product / (ours * measured).sqrt();
        assert!(cosine > alike && (ours / measured - 1.0).abs() < 0.1, "{radius:?}: {cosine} {}", ours / measured);
    }
}
