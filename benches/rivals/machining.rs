//! A cutter over triangles, timed in CPU seconds of one thread: how low it can stand, and the surface that its passes leave.
//!
//! ```text
//! machining tips PLATE.stl CUTTER N OUT           tip heights at N places in rows, written to OUT as x, y, z (f64, little-endian)
//! machining made PLATE.stl CUTTER MACHINE STEPOVER [POLISH]
//!                                                 the whole plate as that machine makes it, and its peak memory (Linux)
//! ```
//!
//! Each prints one JSON object. `tips.py` beside it sets the first against OpenCAMLib's drop cutter at the same places.

use std::error::Error;
use std::fs::{File, read_to_string, write};
use std::path::Path;

use cpu_time::ThreadTime;
use facetmill::cutter::Cutter;
use facetmill::export::stl::read_stl;
use facetmill::milling::machine::Machine;
use facetmill::milling::made::Machining;
use facetmill::milling::passes::Passes;
use facetmill::milling::tip::TipHeights;
use facetmill::progress::Progress;
use facetmill::relief::mesh::Mesh;
use glam::DVec2;
use serde_json::{Value, json};

/// Places in a row, which the next row keeps no step with.
const ROW: usize = 1000;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let outcome = match words.as_slice() {
        ["tips", plate, cutter, count, out] => tips(&mesh(plate)?, cutter.parse()?, count.parse()?, out.as_ref()),
        ["made", plate, cutter, machine, stepover, polish @ ..] if polish.len() <= 1 => {
            let passes = Passes { angle: 0.0, stepover: stepover.parse()?, zigzag: false };
            let machine = Machine::preset(machine).ok_or("no such machine")?;
            let polish = polish.first().map(|polish| polish.parse()).transpose()?;
            made(&mesh(plate)?, &Machining { machine, cutter: cutter.parse()?, passes, polish, seed: 1 })
        }
        _ => Err(
            "usage: machining tips PLATE.stl CUTTER N OUT | machining made PLATE.stl CUTTER MACHINE STEPOVER [POLISH]"
                .into(),
        ),
    }?;
    println!("{outcome}");
    Ok(())
}

fn mesh(file: &str) -> Result<Mesh, Box<dyn Error>> {
    Ok(read_stl(&mut File::open(file)?)?)
}

/// What `job` makes, and the CPU seconds that it takes.
fn timed<T>(job: impl FnOnce() -> T) -> (T, f64) {
    let start = ThreadTime::now();
    let made = job();
    (made, start.elapsed().as_secs_f64())
}

fn tips(mesh: &Mesh, cutter: Cutter, count: usize, out: &Path) -> Result<Value, Box<dyn Error>> {
    let (low, high) = mesh.bounds();
    let size = (high - low).truncate();
    let rows = count.div_ceil(ROW).max(1);
    let place = |k: usize| {
        let (i, j) = (k % ROW, k / ROW);
        let along = (i as f64 + (0.618_033_988_75 * j as f64).fract()) / ROW as f64;
        low.truncate() + size * DVec2::new(along, (j as f64 + 0.5) / rows as f64)
    };
    let (tips, building) = timed(|| TipHeights::new(mesh, cutter.profile()));
    let places: Vec<DVec2> = (0..count).map(place).collect();
    let (heights, seconds) = timed(|| places.iter().map(|at| tips.at(*at)).collect::<Vec<f64>>());
    let numbers = places.iter().zip(&heights).flat_map(|(at, z)| [at.x, at.y, *z]);
    write(out, numbers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>())?;
    let triangles = mesh.triangles.len();
    Ok(
        json!({ "triangles": triangles, "building_s": building, "places": count, "places_per_s": count as f64 / seconds }),
    )
}

fn made(mesh: &Mesh, machining: &Machining) -> Result<Value, Box<dyn Error>> {
    let (low, high) = mesh.bounds();
    let plate = (high - low).truncate();
    machining.check(plate)?;
    let before = peak_megabytes();
    let (tips, building) = timed(|| machining.tips(mesh));
    let (ways, lowering) = timed(|| machining.ways_over(&tips, plate, &Progress::silent()));
    let ways = ways?;
    let work = machining.work(plate);
    let (samples, cutting) = match machining.polish {
        Some(_) => {
            let (surface, seconds) = timed(|| machining.polished(&ways, 0, &Progress::silent()));
            surface?.ok_or("not polished")?;
            (work.samples, seconds)
        }
        None => {
            // As many rows as there would be samples across the passes of a polished one.
            let surface = machining.bare(&ways, 0);
            let rows = (4.0 * plate.y / machining.passes.stepover).ceil() as usize;
            timed(|| (0..rows).map(|k| surface.slopes(k, rows).len()).sum::<usize>() as f64)
        }
    };
    Ok(json!({
        "places": work.places, "building_s": building, "lowering_s": lowering, "samples": samples, "cutting_s": cutting,
        "peak_mb_before": before, "peak_mb": peak_megabytes(),
    }))
}

/// The most memory that the process has held so far, MB.
fn peak_megabytes() -> Option<f64> {
    let status = read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()? / 1000.0)
}
