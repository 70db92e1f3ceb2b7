use glam::{DMat2, DVec2};

use super::*;

const NODES: usize = 24;

fn lattice() -> Lattice {
    Lattice { n: NODES, step: DVec2::new(0.05, 0.04) }
}

/// Numbers between -1 and 1, the same every time.
fn noise(seed: usize, n: usize) -> Vec<f32> {
    (0..n).map(|k| (((k + 7919 * seed) as f64 + 1.0).sin() * 43_758.545_3).fract() as f32).collect()
}

/// A wanted ring of light, 6° wide about a dark middle.
fn target(bin: f64) -> SlopeTarget {
    // Wide enough for all slopes: beyond the rim, light has a gradient that is not its derivative.
    let side = (64.0 / bin) as usize;
    let middle = DVec2::splat(0.5 * (side - 1) as f64);
    let at = |k: usize| (DVec2::new((k % side) as f64, (k / side) as f64) - middle) * bin;
    let ring = |k: usize| if (4.0..10.0).contains(&at(k).length()) { 1.0 } else { 0.0 };
    let wanted: Vec<f32> = (0..side * side).map(ring).collect();
    let sum: f32 = wanted.iter().sum();
    let per_slope = DMat2::from_diagonal(DVec2::new(115.0, 100.0) / bin);
    // Askew, as where the light comes from aside.
    let degrees = DMat2::from_cols(DVec2::new(bin, 0.0), DVec2::new(0.2 * bin, 0.98 * bin));
    SlopeTarget { side, bin, wanted: wanted.iter().map(|w| w / sum).collect(), per_slope, degrees, middle }
}

/// Unknowns of a relief of two waves and some noise, slopes up to about 0.1.
fn relief_at(objective: &Objective, seed: usize) -> Vec<f32> {
    let wave = |k: usize, m: f32| (TAU as f32 * m * k as f32 / NODES as f32).sin();
    let rough = noise(seed, NODES * NODES);
    let z: Vec<f32> = (0..NODES * NODES)
        .map(|k| {
            let (x, y) = (k % NODES, k / NODES);
            0.012 * (wave(x, 1.0) + wave(y, 1.0)) + 0.004 * wave(x, 2.0) * wave(y, 3.0) + 0.0004 * rough[k]
        })
        .collect();
    objective.unknowns(&z)
}

/// Along the gradient and along smooth directions, the derivative of the loss is its central difference.
fn assert_gradient(name: &str, scale: LossScale, settings: SheetSettings, look_at_tool: bool) {
    let n = NODES * NODES;
    for seed in 1..3 {
        let mut objective =
            Objective::new(lattice(), Slope::FLAT, target((0.5 * scale.blur).max(0.125)), scale, &settings);
        let y = relief_at(&objective, seed);
        let z = objective.relief(&y);
        objective.set_penalties(&z, 0.5);
        if look_at_tool {
            objective.update_tool_residual(&z, &Progress::silent()).unwrap();
        }
        let mut gradient = vec![0.0; n];
        let loss = objective.loss(&y, &mut gradient, &Progress::silent()).unwrap();
        let length = gradient.iter().map(|g| f64::from(*g).powi(2)).sum::<f64>().sqrt();
        let mut directions = vec![gradient.iter().map(|g| (f64::from(*g) / length) as f32).collect::<Vec<f32>>()];
        for k in 0..2 {
            // Half the gradient, so that the derivative is not small beside its error, and half of something else.
            let other = noise(10 * seed + k, n);
            let size = other.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
            let mix = |(g, v): (&f32, &f32)| (f64::from(*g) / length + f64::from(*v) / size) as f32;
            directions.push(gradient.iter().zip(&other).map(mix).collect());
        }
        for direction in directions {
            let product =
                |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>();
            let slope = product(&gradient, &direction);
            // A step that changes the loss by three parts in ten thousand: rounding is some ten-millionth of it, and few triangles
            // pass from bin to bin, where the bilinear histogram has kinks.
            let step = (3e-4 * loss / slope) as f32;
            let at = |t: f32| {
                let moved: Vec<f32> = y.iter().zip(&direction).map(|(y, d)| y + t * d).collect();
                objective.loss(&moved, &mut vec![0.0; n], &Progress::silent()).unwrap()
            };
            let measured = (at(step) - at(-step)) / f64::from(2.0 * step);
            assert!((measured / slope - 1.0).abs() < 0.01, "{name}, {seed}: {measured} {slope}");
        }
    }
}

const WIDE: LossScale = LossScale { blur: 1.5, alpha: 1.0, weighed: false };
const NARROW: LossScale = LossScale { blur: 0.5, alpha: 0.75, weighed: false };
const FINE: LossScale = LossScale { blur: 0.25, alpha: 0.25, weighed: true };
const BALL: Option<Cutter> = Some(Cutter::Ball { diameter: 0.1 });

#[test]
fn the_gradient_is_the_derivative_without_a_cutter() {
    assert_gradient("wide", WIDE, SheetSettings::default(), false);
    assert_gradient("narrow", NARROW, SheetSettings::default(), false);
    assert_gradient("fine", LossScale { weighed: false, ..FINE }, SheetSettings::default(), false);
}

#[test]
fn the_gradient_is_the_derivative_where_the_dark_weighs_more() {
    assert_gradient("dark", LossScale { weighed: true, ..NARROW }, SheetSettings::default(), false);
}

#[test]
fn the_gradient_is_the_derivative_for_a_cutter() {
    assert_gradient("cutter", NARROW, SheetSettings { cutter: BALL, ..Default::default() }, false);
}

#[test]
fn the_gradient_is_the_derivative_under_polish() {
    assert_gradient("polish", NARROW, SheetSettings { polish: Some(0.04), ..Default::default() }, false);
}

#[test]
fn the_gradient_is_the_derivative_beyond_the_depth_limit() {
    let shallow = SheetSettings { max_depth: Some(0.03), ..Default::default() };
    let objective = Objective::new(lattice(), Slope::FLAT, target(0.25), NARROW, &shallow);
    assert!(objective.excess_depth(&objective.relief(&relief_at(&objective, 1))) > 0.3);
    assert_gradient("depth", NARROW, shallow, false);
}

#[test]
fn the_gradient_is_the_derivative_with_everything_together() {
    let (polish, min_feature, max_depth) = (Some(0.02), Some(0.08), Some(0.04));
    let all = SheetSettings { cutter: BALL, polish, min_feature, max_depth, preview: false };
    assert_gradient("all", LossScale { weighed: true, ..NARROW }, all, false);
    assert_gradient("all, fine", FINE, all, true);
}

#[test]
fn unknowns_and_heights_are_each_others_inverse() {
    let objective = Objective::new(lattice(), Slope::FLAT, target(0.25), NARROW, &SheetSettings::default());
    let y = relief_at(&objective, 1);
    let back = objective.unknowns(&objective.relief(&y));
    let largest = y.iter().fold(0.0f32, |m, v| m.max(v.abs()));
    assert!(y.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-5 * largest));
}

#[test]
fn a_tool_residual_makes_the_models_light_that_of_the_milled_relief() {
    let mut objective = Objective::new(
        lattice(),
        Slope::FLAT,
        target(0.125),
        FINE,
        &SheetSettings { cutter: BALL, ..Default::default() },
    );
    let z = objective.relief(&relief_at(&objective, 1));
    let before = objective.misplaced(&z, 0.5);
    objective.update_tool_residual(&z, &Progress::silent()).unwrap();
    let milled = Tool::new(lattice().cell(), BALL.unwrap())
        .mill(&relief(lattice(), &z, Slope::FLAT), &Progress::silent())
        .unwrap()
        .relief;
    let fine = Lattice::of(&milled);
    let light = LightModel::new(fine, AxisHistogram::new(&objective.target), 0.5, None);
    let mut difference = light.forward(&EdgeSlopes::new(fine, &milled.heights));
    difference.iter_mut().zip(&objective.target.wanted).for_each(|(d, w)| *d -= w);
    let expected = objective.loss.total_variation(difference, 0.5);
    assert!((objective.misplaced(&z, 0.5) - expected).abs() < 1e-6 && (before - expected).abs() > 1e-4);
}
