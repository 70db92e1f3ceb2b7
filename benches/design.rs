//! The slow stages from a picture to a solid: `cargo bench --bench design`.

#[allow(dead_code, reason = "each bench uses its part")]
mod subject;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use facetmill::export::solid::solid;
use facetmill::facets::SlopeGrid;
use facetmill::facets::arrange::anneal::{Annealing, anneal};
use facetmill::facets::arrange::assignment::cheapest_assignment;
use facetmill::facets::arrange::transport;
use facetmill::facets::heights::LeastSquares;
use facetmill::facets::sample::equal_mass::equal_mass_centres;
use facetmill::facets::sample::refine::refined;
use facetmill::job::preview::preview;
use facetmill::job::speed::relative_speed;
use facetmill::picture::read;
use facetmill::progress::Progress;
use facetmill::recipe::Recipe;
use glam::DVec2;

fn sampling(c: &mut Criterion) {
    let distribution = subject::distribution();
    let mut group = c.benchmark_group("sampling");
    for n in [900, 10_000] {
        group.bench_function(BenchmarkId::new("cells", n), |b| {
            b.iter(|| equal_mass_centres(&distribution.footprint, black_box(n), &Progress::silent()));
        });
        let centres = equal_mass_centres(&distribution.footprint, n, &Progress::silent());
        group.bench_function(BenchmarkId::new("refine", n), |b| {
            b.iter_batched(
                || centres.clone(),
                |centres| refined(&distribution, centres, &Progress::silent()),
                BatchSize::LargeInput,
            );
        });
    }
}

fn arrangement(c: &mut Criterion) {
    let mut group = c.benchmark_group("arrangement");
    let slopes = subject::slopes(900);
    let place = |k: usize| DVec2::new((k % 30) as f64, (k / 30) as f64);
    let cost: Vec<f64> = (0..900 * 900).map(|k| slopes[k % 900].to_vec().dot(place(k / 900))).collect();
    group.bench_function("assignment/900", |b| {
        b.iter(|| cheapest_assignment(900, black_box(&cost), &Progress::silent()))
    });
    for side in [30, 100] {
        let slopes = subject::slopes(side * side);
        group.bench_function(BenchmarkId::new("transport", side * side), |b| {
            b.iter_batched(
                || slopes.clone(),
                |slopes| transport::dome(slopes, side, side, DVec2::ONE, &Progress::silent()),
                BatchSize::LargeInput,
            );
        });
    }
    let settings = Annealing { swaps: 200_000, ..Annealing::default() };
    group.throughput(Throughput::Elements(settings.swaps));
    let grid = SlopeGrid { columns: 30, rows: 30, slopes };
    group.bench_function("annealing/900", |b| {
        b.iter_batched(
            || grid.clone(),
            |mut grid| anneal(&mut grid, &settings, 1, &Progress::silent()),
            BatchSize::LargeInput,
        );
    });
}

fn raising(c: &mut Criterion) {
    let mut group = c.benchmark_group("raising");
    let grid = subject::dome(1000);
    for periodic in [false, true] {
        let heights = LeastSquares::new(1000, 1000, DVec2::ONE, periodic);
        let name = if periodic { "heights/cyclic" } else { "heights/free" };
        group.bench_function(BenchmarkId::new(name, 1_000_000), |b| b.iter(|| heights.heights(black_box(&grid))));
    }
    let relief = subject::relief(300);
    group.bench_function("solid/90000", |b| b.iter(|| solid(black_box(&relief), 5.0, &Progress::silent())));
}

/// A preview of a portrait, and one of the same under a lamp moved by a degree that goes on from it.
fn previewing(c: &mut Criterion) {
    let mut recipe = Recipe::default();
    let light = read("examples/highlights/portrait.png".as_ref(), &recipe.reading()).map(|picture| picture.light);
    let Ok(light) = light else { return };
    let mut group = c.benchmark_group("preview");
    let silent = Progress::silent();
    let Ok(cold) = preview(&recipe, &light, None, &silent) else { return };
    group.bench_function("cold", |b| b.iter(|| preview(black_box(&recipe), &light, None, &silent)));
    recipe.light.theta += 1.0;
    group.bench_function("warm", |b| b.iter(|| preview(black_box(&recipe), &light, Some(&cold), &silent)));
}

/// What is measured of the machine before a dry run tells times: at most 50 ms, and the answer, ten times.
fn machine(c: &mut Criterion) {
    let speeds: Vec<String> = (0..10).map(|_| format!("{:.2}", relative_speed())).collect();
    println!("speed of this machine beside the one of the estimates: {}", speeds.join(", "));
    c.bench_function("speed of the machine", |b| b.iter(relative_speed));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1));
    targets = sampling, arrangement, raising, previewing, machine
}
criterion_main!(benches);
