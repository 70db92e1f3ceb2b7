//! Five jobs that other programs can do too, timed in CPU seconds of one thread. `run.py` beside it runs both sides.
//!
//! ```text
//! speed paths DIR N           mirror paths over the plate that `facetmill design` left in DIR, by either tracer
//! speed free PLATE.stl N      mirror paths over any mesh, in the cells of a grid if it is a height field, and in a tree
//! speed noise DIR             a highlight image of that plate down to a noise of 0.002
//! speed w1 A.png B.png        the exact transport distance between two highlights, 64 × 64 pixels
//! speed assignment DIR COST   DIR's facets to their places, exactly; leaves the cost matrix in COST (f64, little-endian)
//! ```
//!
//! Each prints one JSON object: seconds by job, and what came out, so that both sides can be seen to have solved the same.

use std::error::Error;
use std::fs::{File, read_to_string, write};
use std::path::Path;

use cpu_time::ThreadTime;
use facetmill::brdf::material::Material;
use facetmill::export::stl::read_stl;
use facetmill::facets::arrange::assignment::cheapest_assignment;
use facetmill::facets::arrange::{random_order, transport};
use facetmill::job::design::{Design, design};
use facetmill::picture;
use facetmill::progress::Progress;
use facetmill::projection::Projection;
use facetmill::recipe::Recipe;
use facetmill::setup::Setup;
use facetmill::trace::Surface;
use facetmill::trace::mesh::MeshSurface;
use facetmill::trace::path::{Fate, PathFollower};
use facetmill::trace::traced_plate::TracedPlate;
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::measure::measure;
use facetmill::verify::wasserstein::exact_w1;
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    // Work that would be shared out stays on this thread, whose time is taken.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let outcome = match words.as_slice() {
        ["paths", directory, paths] => paths_over(directory.as_ref(), paths.parse::<f64>()?.sqrt() as usize),
        ["free", file, paths] => free_paths_over(file.as_ref(), paths.parse::<f64>()?.sqrt() as usize),
        ["noise", directory] => noise_of(directory.as_ref()),
        ["w1", a, b] => distance(a.as_ref(), b.as_ref()),
        ["assignment", directory, cost] => assignment(directory.as_ref(), cost.as_ref()),
        _ => {
            Err("usage: speed paths DIR N | speed free PLATE.stl N | speed noise DIR | speed w1 A.png B.png | speed assignment DIR COST".into())
        }
    }?;
    println!("{outcome}");
    Ok(())
}

/// What `job` makes, and the CPU seconds that it takes.
fn timed<T>(job: impl FnOnce() -> T) -> (T, f64) {
    let start = ThreadTime::now();
    let made = job();
    (made, start.elapsed().as_secs_f64())
}

/// The design of a folder, made again from its recipe: files do not hold the exact relief.
fn redesigned(directory: &Path) -> Result<(Recipe, Design), Box<dyn Error>> {
    let recipe = Recipe::from_toml(&read_to_string(directory.join("recipe.toml"))?)?;
    let light = picture::read(recipe.picture.as_deref().unwrap_or_default().as_ref(), &recipe.reading())?.light;
    let made = design(&recipe, &light, &Progress::silent())?;
    Ok((recipe, made))
}

/// The job of a bare loop over Embree, on the very same STL: paths from straight above, starts on a jittered grid in row
/// order, mirror bounces, what leaves upward collected in an image. `grid` traces the relief that was found in the file,
/// `mesh` its triangles; `measure` is the highlight image with plain rays and all tallies, of a lamp of next to no size.
fn paths_over(directory: &Path, side: usize) -> Result<Value, Box<dyn Error>> {
    let mesh = read_stl(&mut File::open(directory.join("plate.stl"))?)?;
    let (plate, finding) = timed(|| TracedPlate::new(&mesh, 0.0, &Progress::silent()));
    let TracedPlate::Facets(grid) = plate? else { return Err("plate.stl holds no facets on a grid".into()) };
    let (escaped, by_grid) = timed(|| trace(&grid, side));
    let setup = Setup::new(0.0, 0.0, 1e-9, Projection::Orthographic, 0.35);
    let measuring = Measuring { rays: (side * side) as u64, ..Measuring::default() };
    let (_, measured) = timed(|| measure(&Experiment::new(&grid, &setup), &measuring, &Progress::silent()));
    let (surface, planting) = timed(|| MeshSurface::in_tree(&mesh, 0.0));
    let surface = surface?;
    let (also, by_mesh) = timed(|| trace(&surface, side));
    Ok(json!({
        "triangles": mesh.triangles.len(), "paths": side * side, "escaped": escaped, "escaped_mesh": also,
        "bytes_a_facet": grid.bytes() as f64 / grid.facets() as f64,
        "seconds": { "grid": by_grid, "finding": finding, "mesh": by_mesh, "measure": measured, "planting": planting },
    }))
}

/// The same paths over the triangles of any mesh, as they are traced where they are on no grid of nodes, and in a tree alone.
fn free_paths_over(file: &Path, side: usize) -> Result<Value, Box<dyn Error>> {
    let mesh = read_stl(&mut File::open(file)?)?;
    let (surface, building) = timed(|| MeshSurface::new(&mesh, 0.0));
    let (tree, planting) = timed(|| MeshSurface::in_tree(&mesh, 0.0));
    let (surface, tree) = (surface?, tree?);
    let (escaped, tracing) = timed(|| trace(&surface, side));
    let (also, in_tree) = timed(|| trace(&tree, side));
    Ok(json!({
        "triangles": mesh.triangles.len(), "paths": side * side, "in_cells": surface.is_field(),
        "escaped": escaped, "escaped_tree": also,
        "seconds": { "building": building, "paths": tracing, "planting": planting, "tree": in_tree },
    }))
}

/// The time in which a highlight image of 256² pixels comes down to a noise of 0.002 in total variation, by the program's
/// own measurement, rays doubled until it does.
fn noise_of(directory: &Path) -> Result<Value, Box<dyn Error>> {
    let mesh = read_stl(&mut File::open(directory.join("plate.stl"))?)?;
    let (plate, finding) = timed(|| TracedPlate::new(&mesh, 0.0, &Progress::silent()));
    let TracedPlate::Facets(grid) = plate? else { return Err("plate.stl holds no facets on a grid".into()) };
    let setup = Setup::new(0.0, 0.0, 0.0, Projection::Orthographic, f64::to_radians(20.0));
    let measuring = Measuring { rays: 1000, error: Some(0.002), ..Measuring::default() };
    let (measured, seconds) = timed(|| measure(&Experiment::new(&grid, &setup), &measuring, &Progress::silent()));
    let measured = measured?;
    Ok(json!({
        "rays": measured.whole.rays, "noise": measured.image_noise(), "image": measured.whole.share_image().values,
        "seconds": { "finding": finding, "measure": seconds },
    }))
}

/// Pixels a side of the image that collects the light.
const PIXELS: usize = 512;

/// Mirror bounces followed.
const BOUNCES: u32 = 8;

/// Sends `side`² paths over the surface; the share that leaves upward.
fn trace<S: Surface>(surface: &S, side: usize) -> f64 {
    let (low, high) = surface.optical_area();
    let top = surface.height_range().1 + 1.0;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(777);
    // A mirror looks at no random number.
    let mut idle = Xoshiro256PlusPlus::seed_from_u64(0);
    let mut follower = PathFollower::new(surface, &Material::MIRROR, BOUNCES);
    let mut image = vec![0.0f32; PIXELS * PIXELS];
    for row in 0..side {
        for column in 0..side {
            let cell = DVec2::new(column as f64, row as f64);
            let at = (cell + DVec2::new(random.random(), random.random())) / side as f64;
            let origin = (low + (high - low) * at).extend(top);
            let Some(hit) = surface.first(origin, -DVec3::Z) else { continue };
            let end = follower.follow(hit, -DVec3::Z, &mut idle);
            if end.fate == Fate::Up {
                let d = end.direction;
                let pixel = |c: f64| ((c / (1.0 + d.z) * 0.5 + 0.5) * (PIXELS - 1) as f64) as usize;
                image[pixel(d.y) * PIXELS + pixel(d.x)] += 1.0;
            }
        }
    }
    image.iter().map(|&light| f64::from(light)).sum::<f64>() / (side * side) as f64
}

/// Pictures as flux over the default field; resampling and costs are part of the time.
fn distance(a: &Path, b: &Path) -> Result<Value, Box<dyn Error>> {
    let recipe = Recipe::default();
    let (a, b) = (picture::read(a, &recipe.reading())?.light, picture::read(b, &recipe.reading())?.light);
    let (w1, seconds) = timed(|| exact_w1(&a, &b, recipe.setup().view(), 64, &Progress::silent()));
    Ok(json!({ "w1_deg": w1?, "seconds": seconds }))
}

/// The assignment behind the transport arrangement, from slopes in no order.
fn assignment(directory: &Path, cost_file: &Path) -> Result<Value, Box<dyn Error>> {
    let mut grid = redesigned(directory)?.1.facets.ok_or("the plate has no facets")?.grid;
    random_order(&mut grid, 1);
    let (n, columns) = (grid.slopes.len(), grid.columns);
    let place = |k: usize| DVec2::new((k % columns) as f64, (k / columns) as f64);
    let cost: Vec<f64> = (0..n * n).map(|k| grid.slopes[k % n].to_vec().dot(place(k / n))).collect();
    write(cost_file, cost.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>())?;
    let (order, seconds) = timed(|| cheapest_assignment(n, &cost, &Progress::silent()));
    let total: f64 = order.iter().enumerate().map(|(i, &j)| cost[i * n + j]).sum();
    let dome = || transport::dome(grid.slopes.clone(), columns, grid.rows, DVec2::ONE, &Progress::silent());
    let (_, arranging) = timed(dome);
    Ok(json!({ "n": n, "total": total, "seconds": seconds, "seconds_arranging": arranging }))
}
