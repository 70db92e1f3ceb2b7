//! Mutants of small files of every kind that is read: an answer for each, never a panic, soon.
//!
//! The short form, some seconds, is part of the tests. The long form, here 20 minutes for each kind of file:
//!
//! ```text
//! FACETMILL_MUTANT_SECONDS=1200 cargo test --locked --test library mutants:: -- --nocapture --test-threads 1
//! ```
//!
//! Mutant k is the same in every run. What fails is kept in `target/tmp`, under the name that the message tells.

pub mod mutate;
mod targets;

use std::fs;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use facetmill::export::sheet::thinned_solid;
use facetmill::export::stl::write_stl;
use facetmill::progress::Progress;
use facetmill::relief::mesh::Mesh;
use facetmill::relief::periodic::PeriodicRelief;
use facetmill::sculpt::bisection::{Bisection, HALF_LOST};
use facetmill::sculpt::checkpoint::{Checkpoint, Origin, write_state};
use facetmill::sculpt::start::Start;
use facetmill::slope::Slope;
use glam::DVec2;
use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use self::targets::{Fate, TARGETS};

/// The most that one file may take, CPU time: a picture of 100 million pixels takes some seconds.
const LONGEST: Duration = Duration::from_secs(20);

/// Mutants of the short form.
const FEW: u64 = 1500;

/// What a run of one target came to.
#[derive(Default)]
struct Count {
    read: u64,
    refused: u64,
    fenced: u64,
    /// CPU time of the slowest.
    slowest: Duration,
}

/// Mutants of the corpus of `name`: a few, or as many as the environment gives time for.
fn run(name: &str) -> Count {
    let target = TARGETS.iter().find(|target| target.0 == name).unwrap().1;
    let corpus = corpus(name);
    let seconds = std::env::var("FACETMILL_MUTANT_SECONDS").ok().map(|text| text.parse().unwrap());
    let (start, cpu) = (Instant::now(), ThreadTime::now());
    let mut count = Count::default();
    for k in 0.. {
        let over = |seconds: u64| cpu.elapsed().as_secs() >= seconds;
        if seconds.map_or(k >= FEW, over) {
            break;
        }
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(k);
        let bytes = match corpus.get(k as usize) {
            Some(whole) => whole.clone(),
            None => mutate::mutant(&corpus, &mut rng),
        };
        let before = ThreadTime::now();
        let fate = catch_unwind(AssertUnwindSafe(|| target(&bytes)));
        let took = before.elapsed();
        count.slowest = count.slowest.max(took);
        match fate {
            Ok(Fate::Read) => count.read += 1,
            Ok(Fate::Refused) => count.refused += 1,
            Ok(Fate::Fenced) => {
                count.fenced += 1;
                keep(name, k, &bytes);
            }
            Err(_) => panic!("mutant {k} of {name} panics: see {}", keep(name, k, &bytes)),
        }
        assert!(took < LONGEST, "mutant {k} of {name} takes {took:?}: see {}", keep(name, k, &bytes));
    }
    let Count { read, refused, fenced, slowest } = count;
    let all = read + refused + fenced;
    println!(
        "{name}: {all} files, {read} read, {refused} refused, {fenced} held by the fence, slowest {} ms, {} s of CPU, \
         {} s, peak memory of the process {} MiB",
        slowest.as_millis(),
        cpu.elapsed().as_secs(),
        start.elapsed().as_secs(),
        peak_memory().map_or("?".into(), |peak| peak.to_string()),
    );
    count
}

/// The largest resident memory so far, MiB, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? >> 10)
}

/// Writes a mutant aside; where.
fn keep(name: &str, k: u64, bytes: &[u8]) -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("mutant-{k}.{name}"));
    fs::write(&path, bytes).unwrap();
    path.display().to_string()
}

/// Files that are read or were once misread: those of the repository and those drawn here.
fn corpus(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name);
    let mut paths: Vec<_> = fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let mut all: Vec<Vec<u8>> = paths.iter().map(|path| fs::read(path).unwrap()).collect();
    match name {
        "picture" => all.extend(pictures()),
        "stl" => {
            let vertices = vec![[0.0, 0.0, 0.0], [0.0, 2.5, 0.0], [1.5, 0.0, 0.0], [0.0, 0.0, 3.25]];
            let mesh = Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3], [2, 1, 3], [1, 0, 3]] };
            let mut bytes = Vec::new();
            write_stl(&mesh, &mut bytes).unwrap();
            all.push(bytes);
            all.push(thinned_sheet());
            all.extend(meshes());
        }
        "state" => all.extend(states()),
        _ => {}
    }
    assert!(!all.is_empty(), "{name}");
    all
}

/// The file of a sheet in fewer triangles than its grid has.
fn thinned_sheet() -> Vec<u8> {
    let heights = (0..16 * 16).map(|k| 0.05 * ((k % 16) as f32 - 7.3).abs() + 0.002 * (k / 16) as f32).collect();
    let relief =
        PeriodicRelief { nodes: 16, heights, cell: DVec2::new(1.0, 1.5), cells: [1, 2], tilt: Slope::new(0.0, 0.1) };
    let mut cover = Bisection::new(&relief, HALF_LOST).unwrap();
    cover.refine(100, &Progress::silent()).unwrap();
    let mesh = thinned_solid(&cover.thinned(), 1.0, 0.0, &Progress::silent()).unwrap();
    let mut bytes = Vec::new();
    write_stl(&mesh, &mut bytes).unwrap();
    bytes
}

/// States of two small designs.
fn states() -> Vec<Vec<u8>> {
    let of = |nodes: usize, start: Start, recipe: &str| {
        let heights = (0..nodes * nodes).map(|k| 0.01 * (k % 17) as f32 - 0.07).collect();
        let at = Checkpoint { done: 2, start, nodes, heights, misplaced: vec![0.3, 0.1 + 0.2] };
        let origin = Origin { recipe: recipe.into(), picture: "48x48 0123456789abcdef".into() };
        let mut bytes = Vec::new();
        write_state(&at, &origin, &mut bytes).unwrap();
        bytes
    };
    vec![of(4, Start::Cone, "[design]\nseed = 3\n"), of(16, Start::Hills(2), "[plate]\ngrid = 16\ncells = 1\n")]
}

/// A small drawing in every format and depth.
fn pictures() -> Vec<Vec<u8>> {
    let drawing = RgbImage::from_fn(24, 16, |x, y| Rgb([(x * 10) as u8, (y * 15) as u8, ((x ^ y) * 8) as u8]));
    let drawing = DynamicImage::from(drawing);
    let grey = DynamicImage::from(drawing.to_luma8());
    let mut all = Vec::new();
    let formats = [
        ImageFormat::Png,
        ImageFormat::Jpeg,
        ImageFormat::Tiff,
        ImageFormat::WebP,
        ImageFormat::Bmp,
        ImageFormat::Gif,
        ImageFormat::Pnm,
        ImageFormat::Hdr,
    ];
    for format in formats {
        let mut kinds = vec![grey.clone(), drawing.clone()];
        match format {
            ImageFormat::Png => {
                kinds.push(drawing.to_luma_alpha8().into());
                kinds.push(drawing.to_rgba16().into());
            }
            ImageFormat::Tiff => {
                kinds.push(drawing.to_luma16().into());
                kinds.push(drawing.to_rgb32f().into());
            }
            ImageFormat::WebP => kinds[0] = drawing.to_rgba8().into(),
            ImageFormat::Gif => kinds = vec![drawing.to_rgba8().into()],
            ImageFormat::Hdr => kinds = vec![drawing.to_rgb32f().into()],
            _ => {}
        }
        for kind in kinds {
            let mut file = Cursor::new(Vec::new());
            kind.write_to(&mut file, format).unwrap();
            all.push(file.into_inner());
        }
    }
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 20 10'><g opacity='.5'><path d='M1 1h9v8z'/></g>\
               <linearGradient id='a'><stop stop-color='red'/></linearGradient><circle r='3' fill='url(#a)'/></svg>";
    all.push(svg.as_bytes().to_vec());
    all
}

/// A tetrahedron in every format of text.
fn meshes() -> Vec<Vec<u8>> {
    let (corners, faces) = (["0 0 0", "2 0 0", "0 2 0", "0 0 2"], ["0 2 1", "0 1 3", "1 2 3", "0 3 2"]);
    let lines = |before: &str, lines: &[&str]| lines.iter().map(|line| format!("{before}{line}\n")).collect::<String>();
    let off = format!("OFF\n4 4 6\n{}{}", lines("", &corners), lines("3 ", &faces));
    let obj = format!("{}f 1 3 2\nf 1 2 4\nf 2//1 3//1 4//1\nf -4 -1 -2\n", lines("v ", &corners));
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 4\nproperty list uchar int vertex_indices\nend_header\n";
    let ply = format!("{header}{}{}", lines("", &corners), lines("3 ", &faces));
    [off, obj, ply].map(String::into_bytes).to_vec()
}

/// Enough are read and enough refused that both ways are tried.
fn judge(name: &str) {
    let Count { read, refused, .. } = run(name);
    let all = read + refused;
    assert!(read >= all / 100 && refused >= all / 20, "{name}: {read} read and {refused} refused");
}

#[test]
fn mutated_pictures_are_read_or_refused_in_time() {
    judge("picture");
}

#[test]
fn mutated_meshes_are_read_or_refused_in_time() {
    judge("stl");
}

#[test]
fn mutated_recipes_are_read_or_refused_in_time() {
    judge("recipe");
}

#[test]
fn mutated_states_are_read_or_refused_in_time() {
    judge("state");
}

#[test]
fn mutated_folders_are_read_or_refused_in_time() {
    judge("folder");
}
