use super::*;
use crate::milling::machine::Machine;

/// A plate of 3 × 2 mm, two triangles.
fn plane(slope: DVec2) -> Mesh {
    let at = |x: f64, y: f64| [x, y, 0.3 + slope.dot(DVec2::new(x, y))].map(|v| v as f32);
    let vertices = vec![at(0.0, 0.0), at(3.0, 0.0), at(0.0, 2.0), at(3.0, 2.0)];
    Mesh { vertices, triangles: vec![[0, 1, 3], [0, 3, 2]] }
}

const PLATE: DVec2 = DVec2::new(3.0, 2.0);

fn machining(machine: Machine, cutter: &str, stepover: f64, degrees: f64) -> Machining {
    let passes = Passes { angle: degrees.to_radians(), stepover, zigzag: false };
    Machining { machine, cutter: cutter.parse().unwrap(), passes, polish: None, seed: 4 }
}

fn exact() -> Machine {
    Machine { decimals: 9, ..Machine::ideal() }
}

/// Root mean square of the slopes along x and along y of the inner plate, and the share that is level.
fn spread(of: &Machining, mesh: &Mesh) -> (DVec2, f64) {
    let ways = of.ways(mesh, PLATE, &Progress::silent()).unwrap();
    let surface = of.bare(&ways, 0);
    let row = |k: usize| {
        let slopes = surface.slopes(k, 401);
        let inner = &slopes[slopes.len() / 4..3 * slopes.len() / 4];
        let all = inner.iter().filter(|slope| slope.is_finite());
        all.fold((DVec2::ZERO, 0.0, 0.0), |(sum, level, n), s| {
            (sum + *s * *s, level + f64::from(u8::from(s.length() < 1e-9)), n + 1.0)
        })
    };
    let inner: Vec<_> = (100..300).map(row).collect();
    let n: f64 = inner.iter().map(|row| row.2).sum();
    let squares = inner.iter().map(|row| row.0).sum::<DVec2>() / n;
    (DVec2::new(squares.x.sqrt(), squares.y.sqrt()), inner.iter().map(|row| row.1).sum::<f64>() / n)
}

#[test]
fn cusps_spread_slopes_evenly_across_the_passes() {
    // Slopes from -w/2R to w/2R, each as often: root mean square w/2R√3.
    for (cutter, stepover) in [("ball:0.5", 0.02), ("ball:2", 0.1)] {
        let of = machining(exact(), cutter, stepover, 0.0);
        let (rms, _) = spread(&of, &plane(DVec2::ZERO));
        let expected = stepover / (of.cutter.diameter() * 3f64.sqrt());
        // Along a pass the cutter is everywhere, although only samples an eighth of the stepover apart are reckoned.
        assert!((rms.y / expected - 1.0).abs() < 5e-3 && rms.x < 0.01 * expected, "{cutter}: {rms} {expected}");
    }
    let (rms, _) = spread(&machining(exact(), "ball:0.5", 0.02, 90.0), &plane(DVec2::ZERO));
    assert!((rms.x / (0.02 / (0.5 * 3f64.sqrt())) - 1.0).abs() < 5e-3 && rms.y < 0.003, "{rms}");
}

#[test]
fn teeth_spread_slopes_along_the_passes() {
    let machine = Machine { feed_per_tooth: 0.01, ..exact() };
    let (rms, _) = spread(&machining(machine, "ball:0.5", 0.06, 0.0), &plane(DVec2::ZERO));
    let expected = 0.01 / (0.5 * 3f64.sqrt());
    // Teeth of neighbouring tracks lie anywhere to each other, so that cells end in teeth of a saw.
    assert!((rms.x / expected - 1.0).abs() < 0.05, "{rms} {expected}");
}

#[test]
fn a_worn_tip_leaves_a_level_spot() {
    // A flat of radius e on passes w apart covers min(1, 2e/w) of a level plate.
    let machine = Machine { tip_flat: 0.004, ..exact() };
    let (_, level) = spread(&machining(machine, "ball:0.5", 0.02, 0.0), &plane(DVec2::ZERO));
    assert!((level - 0.4).abs() < 0.012, "{level}");
}

#[test]
fn polish_leaves_a_plane_as_it_is_whatever_the_direction_of_the_passes() {
    let slope = DVec2::new(0.12, -0.08);
    for degrees in [0.0, 90.0, 30.0] {
        let of = Machining { polish: Some(0.04), ..machining(exact(), "ball:0.5", 0.02, degrees) };
        let mesh = plane(slope);
        let ways = of.ways(&mesh, PLATE, &Progress::silent()).unwrap();
        let relief = of.polished(&ways, 0, &Progress::silent()).unwrap().unwrap();
        let [nx, ny] = relief.nodes;
        assert!((relief.step * DVec2::new((nx - 1) as f64, (ny - 1) as f64) - PLATE).length() < 1e-9);
        for j in ny / 4..3 * ny / 4 {
            for i in nx / 4..3 * nx / 4 {
                let at = relief.step * DVec2::new(i as f64, j as f64);
                let off = f64::from(relief.heights[j * nx + i]) - 0.3 - slope.dot(at);
                // The mean of cusps w²/8R high is a third of that, 0.067 µm; from four rows a pass it is 0.075.
                assert!((off - 0.071e-3).abs() < 0.01e-3, "{degrees}: {off}");
            }
        }
    }
}

#[test]
fn tracks_of_random_height_leave_the_slopes_that_the_law_says() {
    // A quarter of the cusps' height, so that no track is cut away by its neighbours.
    const DELTA: f64 = 5e-5;
    // White offsets of δ leave, after polish, slopes of δ √(w/(4 √π σ³)) across the passes, 4√π = 7.09.
    let machine = Machine { track_scatter: DELTA, ..exact() };
    let (stepover, sigma) = (0.02, 0.04);
    let of = Machining { polish: Some(sigma), ..machining(machine, "ball:0.5", stepover, 0.0) };
    let ways = of.ways(&plane(DVec2::ZERO), PLATE, &Progress::silent()).unwrap();
    let (mut squares, mut count) = (0.0, 0.0);
    for draw in 0..40 {
        let relief = of.polished(&ways, draw, &Progress::silent()).unwrap().unwrap();
        let [nx, ny] = relief.nodes;
        for j in ny / 8..7 * ny / 8 {
            let rise = relief.heights[(j + 1) * nx + nx / 2] - relief.heights[j * nx + nx / 2];
            squares += (f64::from(rise) / relief.step.y).powi(2);
            count += 1.0;
        }
    }
    let expected = DELTA * (stepover / (7.09 * sigma.powi(3))).sqrt();
    let found = (squares / count).sqrt();
    assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
}

#[test]
fn the_same_draw_is_the_same_surface_with_any_number_of_threads() {
    let of = Machining { polish: Some(0.05), ..machining(Machine::preset("vmc").unwrap(), "ball:0.5", 0.025, 0.0) };
    let mesh = plane(DVec2::new(0.05, 0.1));
    let with = |threads: usize, draw: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let ways = of.ways(&mesh, PLATE, &Progress::silent()).unwrap();
            of.polished(&ways, draw, &Progress::silent()).unwrap().unwrap()
        })
    };
    assert!(with(1, 0) == with(3, 0) && with(1, 0) != with(1, 1));
}
