//! The kernels of a sheet's design, on 256 × 256 nodes: `cargo bench --bench sculpt`.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use facetmill::cutter::Cutter;
use facetmill::progress::Progress;
use facetmill::sculpt::axis_histogram::AxisHistogram;
use facetmill::sculpt::closing::Closing;
use facetmill::sculpt::concave_edges::ConcaveEdges;
use facetmill::sculpt::edge_slopes::{EdgeSlopes, Lattice};
use facetmill::sculpt::light_model::LightModel;
use facetmill::sculpt::objective::relief;
use facetmill::sculpt::periodic_filter::PeriodicFilter;
use facetmill::sculpt::target::SlopeTarget;
use facetmill::sculpt::tool::Tool;
use facetmill::slope::Slope;
use glam::{DMat2, DVec2};

const NODES: usize = 256;
const SIDE: usize = 384;

/// A dome with ripples, slopes up to about 0.2, valleys at its edges.
fn heights(lattice: Lattice) -> Vec<f32> {
    let cell = lattice.cell();
    (0..NODES * NODES)
        .map(|k| {
            let at = lattice.step * DVec2::new((k % NODES) as f64, (k / NODES) as f64);
            let wave = |m: f64| (std::f64::consts::TAU * m * at / cell).map(f64::cos);
            (0.2 * wave(1.0).element_sum() + 0.003 * wave(7.0).element_product()) as f32
        })
        .collect()
}

fn kernels(criterion: &mut Criterion) {
    let lattice = Lattice { n: NODES, step: DVec2::splat(10.0 / NODES as f64) };
    let cutter = Cutter::ball(0.5);
    let z = heights(lattice);
    let per_slope = DMat2::from_diagonal(DVec2::splat(-115.0 / 0.125));
    let target = SlopeTarget {
        side: SIDE,
        bin: 0.125,
        wanted: vec![0.0; SIDE * SIDE],
        per_slope,
        degrees: DMat2::from_diagonal(DVec2::splat(-0.125)),
        middle: DVec2::splat(0.5 * SIDE as f64),
    };
    let bins = AxisHistogram::new(&target);
    let potential: Vec<f32> = (0..SIDE * SIDE).map(|k| ((k % SIDE) as f32 * 0.1).sin()).collect();
    let edges = EdgeSlopes::new(lattice, &z);
    let plain = LightModel::new(lattice, bins, 0.0, None);
    let cut = LightModel::new(lattice, bins, 0.125, Some(ConcaveEdges::new(lattice, cutter, 0.1)));
    criterion.bench_function("edges", |b| b.iter(|| EdgeSlopes::new(lattice, black_box(&z))));
    for (name, light) in [("triangles", &plain), ("triangles and fillets", &cut)] {
        criterion.bench_function(&format!("splat {name}"), |b| b.iter(|| light.forward(black_box(&edges))));
        criterion.bench_function(&format!("gradient of {name}"), |b| {
            b.iter(|| light.adjoint(black_box(&edges), &potential, 1.0))
        });
    }
    let closing = Closing::new(lattice, cutter);
    criterion.bench_function("hulls", |b| b.iter(|| closing.close(&mut z.clone())));
    let contacts = closing.close(&mut z.clone());
    criterion.bench_function("adjoint of hulls", |b| b.iter(|| contacts.adjoint(&mut z.clone())));
    for side in [NODES, 432] {
        let waves = PeriodicFilter::new(side);
        let gains = waves.gains(|i, j| 1.0 / (1.0 + (i * i + j * j) as f64));
        let grid = vec![0.5f32; side * side];
        criterion
            .bench_function(&format!("filter {side}"), |b| b.iter(|| waves.filter(&mut grid.clone(), side, &gains)));
    }
    let tool = Tool::new(lattice.cell(), cutter);
    let written = relief(lattice, &z, Slope::FLAT);
    criterion.bench_function("milling on 1000 x 1000 places", |b| {
        b.iter(|| tool.mill(black_box(&written), &Progress::silent()))
    });
}

criterion_group!(benches, kernels);
criterion_main!(benches);
