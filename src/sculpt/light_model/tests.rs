use glam::{DMat2, DVec2};

use super::*;
use crate::cutter::Cutter;
use crate::sculpt::axis_histogram::Along;
use crate::sculpt::target::SlopeTarget;

/// Bins over slopes from -1 to 1, more of them to a slope along one axis, and backward along the other.
fn bins(side: usize) -> AxisHistogram {
    let middle = DVec2::splat(0.5 * (side - 1) as f64);
    let per_slope = DMat2::from_diagonal(DVec2::new(0.45, -0.4) * side as f64);
    let wanted = vec![0.0; side * side];
    AxisHistogram::new(&SlopeTarget { side, bin: 1.0, wanted, per_slope, degrees: DMat2::IDENTITY, middle })
}

/// A coordinate in bins.
fn coordinate(along: Along) -> f64 {
    along.bin as f64 + f64::from(along.part)
}

fn uneven(n: usize, height: f32) -> Vec<f32> {
    // No two edges as steep as each other, where light and concave edges have kinks.
    (0..n * n).map(|k| height * (((k as f64 + 1.0).sin() * 43_758.545_3).fract() * 0.5) as f32).collect()
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
            let (x, y) = (coordinate(bins(64).x(p)), coordinate(bins(64).y(q)));
            let near = |k: usize| ((k % 64) as f64 - x).abs().max(((k / 64) as f64 - y).abs()) < 1.0;
            let share: f32 = light.iter().enumerate().filter(|(k, _)| near(*k)).map(|(_, v)| v).sum();
            // The valley opposite the ridge runs along diagonals too, and is cut across: half of its squares.
            assert!(share > 0.43, "{falls}: {share}");
        }
    }
}

/// The four bins around a place, their weights, and how the weights change as the place moves by `(dx, dy)`.
fn bilinear(side: usize, (x, y): (f64, f64), (dx, dy): (f64, f64)) -> [(usize, f64, f64); 4] {
    let (i, j) = (x as usize, y as usize);
    let (a, b) = (x.fract(), y.fract());
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, up)| {
        let (u, du) = if right == 1 { (a, dx) } else { (1.0 - a, -dx) };
        let (v, dv) = if up == 1 { (b, dy) } else { (1.0 - b, -dy) };
        ((j + up) * side + i + right, u * v, du * v + u * dv)
    })
}

/// A slope and its change along a direction.
#[derive(Clone, Copy)]
struct Moving {
    at: f64,
    change: f64,
}

/// The change of the light of heights `z` along `direction`, written down anew in double precision: triangle by triangle,
/// edge by edge.
fn tangent(lattice: Lattice, z: &[f32], direction: &[f64], model: Model) -> Vec<f64> {
    let (n, side, bins) = (lattice.n, 64, bins(64));
    let index = |i: usize, j: usize| j % n * n + i % n;
    let slope = |from: usize, to: usize, step: f64| Moving {
        // The slopes are those that the model sees, rounded as it rounds them.
        at: f64::from((1.0 / step) as f32 * (z[to] - z[from])),
        change: (direction[to] - direction[from]) / step,
    };
    let p = |i: usize, j: usize| slope(index(i, j), index(i + 1, j), lattice.step.x);
    let q = |i: usize, j: usize| slope(index(i, j), index(i, j + 1), lattice.step.y);
    let per_slope = bins.per_slope().map(f64::from);
    let mut light = vec![0.0; side * side];
    let mut strips = vec![0.0; side * side];
    let mut splat = |p: Moving, q: Moving, mass: f64, mass_change: f64| {
        let at = (coordinate(bins.x(p.at as f32)), coordinate(bins.y(q.at as f32)));
        let change = (per_slope[0] * p.change, per_slope[1] * q.change);
        for (bin, weight, grows) in bilinear(side, at, change) {
            light[bin] += mass * grows + mass_change * weight;
        }
    };
    let each = 0.5 / (n * n) as f64;
    for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
        let (bottom, top, left, right) = (p(i, j), p(i, j + 1), q(i, j), q(i + 1, j));
        let (with_bottom, with_top) = if top.at > bottom.at { (right, left) } else { (left, right) };
        for (share, low, up) in [(1.0 - model.lower, with_bottom, with_top), (model.lower, with_top, with_bottom)] {
            splat(bottom, low, share * each, 0.0);
            splat(top, up, share * each, 0.0);
        }
        let Some(radius) = model.radius else { continue };
        let least = |a: Moving, b: Moving| if b.at < a.at { b } else { a };
        let most = |a: Moving, b: Moving| if b.at > a.at { b } else { a };
        let across_x = (least(bottom, top), most(p(i + 1, j), p(i + 1, j + 1)), right);
        let across_y = (least(left, right), most(q(i, j + 1), q(i + 1, j + 1)), top);
        for (axis, (from, to, along)) in [across_x, across_y].into_iter().enumerate() {
            let jump = to.at - from.at;
            if jump * per_slope[axis].abs() <= 1.0 {
                continue;
            }
            let share = radius / lattice.step[axis] / (n * n) as f64;
            let (mass, mass_change) = (share * jump, share * (to.change - from.change));
            for end in [from, to] {
                let (p, q) = if axis == 0 { (end, along) } else { (along, end) };
                splat(p, q, -0.5 * mass, -0.5 * mass_change);
            }
            // Bin by bin, the integral of its hat from end to end, and how that changes as the ends move.
            let place = |s: Moving, axis: usize| {
                let at = if axis == 0 { bins.x(s.at as f32) } else { bins.y(s.at as f32) };
                (coordinate(at), per_slope[axis] * s.change)
            };
            let ((a, da), (b, db), (y, dy)) = (place(from, axis), place(to, axis), place(along, 1 - axis));
            let density = share / per_slope[axis];
            for (on, aside) in (0..side * side).map(|k| (k % side, k / side)) {
                let (u, v, w) = (a - on as f64, b - on as f64, y - aside as f64);
                let hat = |x: f64| (1.0 - x.abs()).max(0.0);
                let integral = |x: f64| {
                    let x = x.clamp(-1.0, 1.0);
                    if x < 0.0 { 0.5 * (1.0 + x) * (1.0 + x) } else { 1.0 - 0.5 * (1.0 - x) * (1.0 - x) }
                };
                let slope = if w.abs() < 1.0 { -w.signum() } else { 0.0 };
                let length = hat(v) * db - hat(u) * da;
                let change = density * (length * hat(w) + (integral(v) - integral(u)) * slope * dy);
                strips[if axis == 0 { aside * side + on } else { on * side + aside }] += change;
            }
        }
    }
    light.iter_mut().zip(&strips).for_each(|(light, strip)| *light += strip);
    light
}

#[derive(Clone, Copy, Debug)]
struct Model {
    lower: f64,
    radius: Option<f64>,
}

#[test]
fn the_adjoint_is_the_transpose_of_the_tangent_to_rounding() {
    let plain = Model { lower: 0.0, radius: None };
    for model in [
        plain,
        Model { lower: 0.3, ..plain },
        Model { radius: Some(0.01), ..plain },
        Model { lower: 0.1, radius: Some(0.4) },
    ] {
        let lattice = Lattice { n: 12, step: DVec2::new(0.05, 0.04) };
        let concave = model.radius.map(|radius| ConcaveEdges::new(lattice, Cutter::ball(2.0 * radius), 0.3));
        let light = LightModel::new(lattice, bins(64), model.lower, concave);
        let z = uneven(12, 0.03);
        // No smooth function of the bins, so that each counts.
        let phi: Vec<f32> = (0..64 * 64).map(|k| ((k as f64 * 12.9898).sin() * 43_758.545_3).fract() as f32).collect();
        let (gradient, _) = light.adjoint(&EdgeSlopes::new(lattice, &z), &phi, 0.0);
        for seed in 1..4 {
            let direction: Vec<f64> = (0..144).map(|k| f64::from(seed * 100 + k).sin()).collect();
            let change = tangent(lattice, &z, &direction, model);
            let forward: f64 = change.iter().zip(&phi).map(|(a, b)| a * f64::from(*b)).sum();
            let back: f64 = gradient.iter().zip(&direction).map(|(a, b)| f64::from(*a) * b).sum();
            let size: f64 = gradient.iter().zip(&direction).map(|(a, b)| (f64::from(*a) * b).abs()).sum();
            assert!((forward - back).abs() < 2e-5 * size, "{model:?}: {forward} {back} of {size}");
        }
    }
}

#[test]
fn the_penaltys_gradient_is_its_derivative() {
    let lattice = Lattice { n: 12, step: DVec2::new(0.05, 0.04) };
    let concave = ConcaveEdges::new(lattice, Cutter::ball(0.02), 0.3);
    let light = LightModel::new(lattice, bins(64), 0.0, Some(concave));
    let z = uneven(12, 0.03);
    let penalty = |z: &[f32]| light.penalty(&EdgeSlopes::new(lattice, z));
    let (gradient, along) = light.adjoint(&EdgeSlopes::new(lattice, &z), &vec![0.0; 64 * 64], 0.4);
    assert!((along / penalty(&z) - 1.0).abs() < 1e-6);
    for seed in 1..4 {
        let direction: Vec<f32> = (0..144).map(|k| (seed * 100 + k) as f32).map(f32::sin).collect();
        let moved = |d: f32| -> Vec<f32> { z.iter().zip(&direction).map(|(z, v)| z + d * v).collect() };
        let d = 2e-5;
        let measured = 0.4 * (penalty(&moved(d)) - penalty(&moved(-d))) / f64::from(2.0 * d);
        let ours: f64 = gradient.iter().zip(&direction).map(|(g, v)| f64::from(*g) * f64::from(*v)).sum();
        let size: f64 = gradient.iter().zip(&direction).map(|(g, v)| (f64::from(*g) * f64::from(*v)).abs()).sum();
        assert!((measured - ours).abs() < 1e-3 * size, "{measured} {ours} of {size}");
    }
}
