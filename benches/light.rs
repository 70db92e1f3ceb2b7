//! The slow stages of the proof: `cargo bench --bench light`. Rates of paths and segments are for one thread.

#[allow(dead_code, reason = "each bench uses its part")]
mod subject;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use facetmill::export::solid::solid;
use facetmill::highlight::{Quantity, scored_target};
use facetmill::progress::Progress;
use facetmill::trace::Surface;
use facetmill::trace::grid::GridSurface;
use facetmill::trace::mesh::MeshSurface;
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::measure::measure;
use facetmill::verify::score::blurred_scores;
use facetmill::verify::tally::Measurement;
use facetmill::verify::wasserstein::exact_w1;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Paths of one measurement.
const PATHS: u64 = 250_000;

fn light_over(surface: &impl Surface, threads: &ThreadPool) -> Measurement {
    let measuring = Measuring { rays: PATHS, ..Measuring::default() };
    let setup = subject::setup();
    threads.install(|| measure(&Experiment::new(surface, &setup), &measuring, &Progress::silent())).unwrap()
}

fn tracing(c: &mut Criterion) {
    let one = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut group = c.benchmark_group("tracing");
    for side in [30, 300] {
        let relief = subject::relief(side);
        let mesh = solid(&relief, 5.0, &Progress::silent()).unwrap();
        group.throughput(Throughput::Elements(PATHS));
        let grid = GridSurface::new(&relief, &Progress::silent()).unwrap();
        group.bench_function(BenchmarkId::new("grid", side * side), |b| b.iter(|| light_over(&grid, &one)));
        let planted = MeshSurface::new(&mesh, 0.0).unwrap();
        group.bench_function(BenchmarkId::new("mesh", side * side), |b| b.iter(|| light_over(&planted, &one)));
        group.throughput(Throughput::Elements(mesh.triangles.len() as u64));
        group.bench_function(BenchmarkId::new("planting", side * side), |b| {
            b.iter(|| MeshSurface::new(black_box(&mesh), 0.0));
        });
    }
}

fn scoring(c: &mut Criterion) {
    let one = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let setup = subject::setup();
    let target = scored_target(&subject::light(), Quantity::Radiance, &setup, 256);
    // The even light of a dome against a portrait: most of it has to move.
    let seen =
        light_over(&GridSurface::new(&subject::relief(30), &Progress::silent()).unwrap(), &one).whole.share_image();
    let mut group = c.benchmark_group("scoring");
    group.bench_function("blur_and_ssim/256", |b| {
        b.iter(|| blurred_scores(black_box(&seen), 1.0, &target, setup.view(), 1f64.to_radians()));
    });
    for resolution in [32, 64] {
        group.bench_function(BenchmarkId::new("w1", resolution), |b| {
            b.iter(|| exact_w1(black_box(&seen), &target, setup.view(), resolution, &Progress::silent()));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1));
    targets = tracing, scoring
}
criterion_main!(benches);
