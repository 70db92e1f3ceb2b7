//! How many light paths a second: the same job that a bare loop over Embree does, by both of our tracers.
//!
//! ```text
//! facetmill design picture.png -o plate
//! cargo run --release --example trace_paths -- plate 4000000
//! ```
//!
//! DIR is a folder that `design` wrote. `grid` walks the exact relief, designed again from its recipe.toml; `mesh` goes
//! through the triangles of its plate.stl; `measure` is what `design` itself does with paths, its tallies included.
//! The job: mirror paths from straight above, starts on a jittered grid in row order, up to 8 bounces, those that leave
//! upward counted in a 512² image. One thread; the median of five runs, in CPU time.

use std::error::Error;
use std::fs::{File, read_to_string};
use std::path::Path;

use cpu_time::ThreadTime;
use facetmill::export::stl::read_stl;
use facetmill::picture;
use facetmill::progress::Progress;
use facetmill::recipe::Recipe;
use facetmill::recipe::run::design;
use facetmill::slope::mirror;
use facetmill::trace::Surface;
use facetmill::trace::grid::GridSurface;
use facetmill::trace::mesh::MeshSurface;
use facetmill::verify::measure::{Measuring, measure};
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Pixels a side of the image that collects the light.
const PIXELS: usize = 512;

/// Mirror bounces followed.
const BOUNCES: usize = 8;

/// Timed runs of each job.
const RUNS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [directory, paths] = arguments.as_slice() else { return Err("usage: trace_paths DIR PATHS".into()) };
    let (directory, paths): (&Path, f64) = (directory.as_ref(), paths.parse()?);
    let side = paths.sqrt() as usize;

    let mesh = read_stl(&mut File::open(directory.join("plate.stl"))?)?;
    let recipe = Recipe::from_toml(&read_to_string(directory.join("recipe.toml"))?)?;
    let light = picture::read(recipe.picture.as_deref().unwrap_or_default().as_ref(), &recipe.reading())?.light;
    let made = design(&recipe, &light, &Progress::silent())?;
    if made.mesh.triangles.len() != mesh.triangles.len() {
        return Err("plate.stl is not what recipe.toml makes".into());
    }

    let (grid, start) = (GridSurface::new(&made.relief), ThreadTime::now());
    let mesh = MeshSurface::new(&mesh, 0.0)?;
    println!("{} triangles, tree planted in {:.3} s", made.mesh.triangles.len(), start.elapsed().as_secs_f64());
    report("grid", side * side, || trace(&grid, side));
    report("mesh", side * side, || trace(&mesh, side));
    let measuring = Measuring { rays: (side * side) as u64, ..Measuring::default() };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build()?;
    report("grid, measure", side * side, || {
        let measured = one.install(|| measure(&grid, &recipe.setup(), &measuring, &Progress::silent()));
        measured.map_or(0.0, |measured| measured.whole.up())
    });
    Ok(())
}

/// Runs `job`, which returns the share of light that left upward, and prints what it took.
fn report(name: &str, paths: usize, job: impl Fn() -> f64) {
    let mut escaped = 0.0;
    let mut rates: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = ThreadTime::now();
            escaped = job();
            paths as f64 / 1e6 / start.elapsed().as_secs_f64()
        })
        .collect();
    rates.sort_by(f64::total_cmp);
    println!("{name:14} {:6.2} M paths/CPU-s   escaped {escaped:.4}", rates[RUNS / 2]);
}

/// Sends `side`² paths over the surface; the share that leaves upward.
fn trace<S: Surface>(surface: &S, side: usize) -> f64 {
    let (low, high) = surface.optical_area();
    let top = surface.height_range().1 + 1.0;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(777);
    let mut image = vec![0.0f32; PIXELS * PIXELS];
    for row in 0..side {
        for column in 0..side {
            let cell = DVec2::new(column as f64, row as f64);
            let at = (cell + DVec2::new(random.random(), random.random())) / side as f64;
            let origin = (low + (high - low) * at).extend(top);
            let Some(d) = leaves(surface, origin) else { continue };
            let pixel = |c: f64| ((c / (1.0 + d.z) * 0.5 + 0.5) * (PIXELS - 1) as f64) as usize;
            image[pixel(d.y) * PIXELS + pixel(d.x)] += 1.0;
        }
    }
    image.iter().map(|&light| f64::from(light)).sum::<f64>() / (side * side) as f64
}

/// Where light from straight above goes in the end, if that is up.
fn leaves<S: Surface>(surface: &S, origin: DVec3) -> Option<DVec3> {
    let mut direction = -DVec3::Z;
    let mut hit = surface.first(origin, direction)?;
    for _ in 0..BOUNCES {
        direction = mirror(-direction, hit.normal);
        match surface.next(&hit, direction) {
            Some(next) => hit = next,
            None => return (direction.z > 0.0).then_some(direction),
        }
    }
    None
}
