use super::*;
use crate::slope::{direction, flat_mirror};

/// Whole numbers that look random, 0 to 999.
fn noise(i: usize) -> usize {
    let mixed = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) as usize % 1000
}

fn masses(n: usize, seed: usize) -> Vec<f64> {
    (0..n).map(|i| 1.0 + noise(i + seed) as f64).collect()
}

fn solved(supply: &[f64], demand: &[f64], cost: Vec<f64>) -> f64 {
    let (supply, demand) = (counted(supply), counted(demand));
    let mut tree = Tree::new(&supply, &demand, cost, &Progress::silent()).unwrap();
    tree.optimise(&Progress::silent()).unwrap();
    prove_optimal(&tree, &supply, &demand);
    tree.total_cost() / WHOLE as f64
}

/// Feasible flow, feasible prices, and flow only where the price is met: together they prove optimality.
fn prove_optimal(tree: &Tree, supply: &[i64], demand: &[i64]) {
    let (sources, sinks) = (supply.len(), demand.len());
    let mut balance: Vec<i64> = supply.iter().chain(demand).chain(&[0]).copied().collect();
    for node in 0..sources + sinks {
        let (parent, flow) = (tree.parent[node] as usize, tree.flow[node]);
        assert!(flow > 0 || (flow == 0 && node < sources), "an idle arc must point to the root");
        balance[node] -= flow;
        balance[parent] -= flow;
        let slack = tree.arc_cost(node) - tree.price[node] - tree.price[parent];
        assert!(slack.abs() <= tree.tolerance);
    }
    assert!(balance.iter().all(|&left| left == 0));
    for (k, cost) in tree.cost.iter().enumerate() {
        let reduced = cost - tree.price[k / sinks] - tree.price[sources + k % sinks];
        assert!(reduced >= -tree.tolerance, "{k} {reduced}");
    }
}

#[test]
fn prices_prove_every_solution_optimal() {
    for (sources, sinks) in [(1, 1), (1, 7), (9, 1), (40, 40), (31, 83), (150, 60)] {
        let cost = masses(sources * sinks, 0);
        solved(&masses(sources, 7), &masses(sinks, 9000), cost.clone());
        // Equal masses and few different costs: nearly every pivot is degenerate.
        let coarse: Vec<f64> = cost.iter().map(|c| (c / 250.0).floor()).collect();
        solved(&vec![1.0; sources], &vec![1.0; sinks], coarse);
    }
}

#[test]
fn on_a_line_the_cost_is_the_area_between_the_cumulated_masses() {
    let n = 120usize;
    let (a, b) = (masses(n, 0), masses(n, 500));
    let cost = (0..n * n).map(|k| (k / n).abs_diff(k % n) as f64).collect();
    let found = solved(&a, &b, cost);
    let (sum_a, sum_b) = (a.iter().sum::<f64>(), b.iter().sum::<f64>());
    let (mut surplus, mut area) = (0.0f64, 0.0);
    for (a, b) in a.iter().zip(&b) {
        surplus += a / sum_a - b / sum_b;
        area += surplus.abs();
    }
    assert!((found / area - 1.0).abs() < 1e-10);
}

fn blob(n: usize, x0: usize, y0: usize) -> Raster {
    Raster::from_fn(n, n, |x, y| (30.0 - (x.abs_diff(x0).pow(2) + y.abs_diff(y0).pow(2)) as f64).max(0.0))
}

#[test]
fn a_shifted_highlight_reads_its_shift() {
    let view = View::new(Projection::Equidistant, f64::to_radians(2.0), DVec3::Z);
    // 40 pixels over 4 degrees; shifts that overlap the old place and shifts that do not.
    for (dx, dy) in [(1, 0), (0, 3), (3, 4), (12, 5)] {
        let found = exact_w1(&blob(40, 12, 14), &blob(40, 12 + dx, 14 + dy), &view, 40, &Progress::silent()).unwrap();
        assert!((found / (0.1 * f64::hypot(dx as f64, dy as f64)) - 1.0).abs() < 1e-3, "{dx} {dy} {found}");
    }
}

#[test]
fn it_is_a_metric() {
    let view = View::new(Projection::Screen, 0.5, flat_mirror(direction(0.4, 2.0)));
    let image = |seed| Raster::from_fn(14, 14, |x, y| noise(x + 14 * y + seed) as f64);
    let [a, b, c] = [0, 1000, 5000].map(image);
    let brighter = a.clone().scaled(3.0);
    let d = |a, b| exact_w1(a, b, &view, 14, &Progress::silent()).unwrap();
    assert!(d(&a, &brighter) < 1e-9);
    assert!(d(&a, &b) > 0.1);
    assert!((d(&a, &b) - d(&b, &a)).abs() < 1e-9);
    assert!(d(&a, &c) <= d(&a, &b) + d(&b, &c));
}

#[test]
fn agrees_with_the_independent_referee() {
    use Projection::{Equidistant, Orthographic, Screen};
    let measured = Raster::from_fn(32, 32, |x, y| ((7 * x + 13 * y + x * y) % 11) as f64);
    let wanted = blob(32, 18, 14);
    // Half field and light in degrees; W1 at 20 × 20 pixels. The last one has light painted beyond the horizon.
    let cases = [
        (Equidistant, 20.0, (0.0, 0.0), 11.887978417863138),
        (Orthographic, 15.0, (30.0, 137.0), 9.701420456904092),
        (Screen, 25.0, (50.0, 250.0), 14.856715910012595),
        (Orthographic, 90.0, (0.0, 0.0), 45.56263358556311),
    ];
    for (projection, field, (theta, phi), expected) in cases {
        let centre = flat_mirror(direction(f64::to_radians(theta), f64::to_radians(phi)));
        let view = View::new(projection, f64::to_radians(field), centre);
        let found = exact_w1(&measured, &wanted, &view, 20, &Progress::silent()).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-9, "{projection:?} {found} {expected}");
    }
}

#[test]
fn what_cannot_be_compared_has_no_distance() {
    let view = View::new(Projection::Equidistant, 3.0, DVec3::Z);
    let good = blob(20, 10, 10);
    let mut broken = good.clone();
    broken.values[3] = f64::NAN;
    for bad in [&Raster::zeros(20, 20), &Raster::zeros(0, 0), &broken, &good.clone().scaled(f64::INFINITY)] {
        assert_eq!(exact_w1(bad, &good, &view, 20, &Progress::silent()), Err(MeasureError::NoLight));
        assert_eq!(exact_w1(&good, bad, &view, 20, &Progress::silent()), Err(MeasureError::NoLight));
    }
    assert_eq!(exact_w1(&good, &good, &view, 0, &Progress::silent()), Err(MeasureError::NoLight));
    // Beyond 180 degrees from the centre there are no directions, hence no light to be moved.
    let corner = Raster::from_fn(20, 20, |x, y| f64::from(x + y == 0));
    assert_eq!(exact_w1(&corner, &good, &view, 20, &Progress::silent()), Err(MeasureError::NoLight));
}
