//! Solids judged by programs of others: manifold3d and trimesh (Python packages), admesh (a command).
//!
//! A judge that is not installed is skipped, visibly; with FACETMILL_REQUIRE_CHECKERS=1 it is a failure.
//! FACETMILL_PYTHON names the Python to use, `python3` if unset.

use std::fs::File;
use std::path::PathBuf;
use std::process::Command;
use std::sync::LazyLock;

use facetmill::export::solid::solid;
use facetmill::export::stl::write_stl;
use facetmill::job::design::design;
use facetmill::picture::read;
use facetmill::progress::Progress;
use facetmill::recipe::Recipe;
use facetmill::relief::mesh::Mesh;

use crate::asking::skip;
use crate::plates::{ALL, Shape, plate};

/// Recipes whose plates are judged: picture, what differs from the default.
const DESIGNS: [(&str, &str, &str); 17] = [
    ("dome", "portrait", "plate = { facets = [30, 30] }"),
    ("wide", "word", "plate = { size = [45, 20], facets = [60, 24] }"),
    ("narrow", "star", "plate = { size = [7, 30], facets = [6, 71] }"),
    ("cells_3", "ring", "plate = { facets = [30, 30], cells = 3 }"),
    ("cells_10", "letter", "plate = { cells = 10, border = 2 }\ndesign = { sample = 'sobol' }"),
    ("cells_of_no_order", "portrait", "plate = { cells = 2 }\ndesign = { arrange = 'random' }"),
    ("no_order", "letter", "highlight = { half-field = 40 }\ndesign = { arrange = 'random' }"),
    ("no_order_steep", "ring", "highlight = { half-field = 80 }\ndesign = { arrange = 'random', sample = 'random' }"),
    ("annealed", "spiral", "[design]\narrange = 'anneal'\nannealing = { swaps = 100_000 }"),
    ("as_in_2009", "spiral", "[design]\narrange = 'anneal'\nheights = 'weyrich2009'\nannealing = { swaps = 100_000 }"),
    ("slanting", "portrait", "light = { theta = 50, phi = 200 }\nplate = { facets = [50, 50] }"),
    (
        "level",
        "letter",
        "light = { theta = 30, phi = 10 }\ndesign = { arrange = 'transport', distribution = { level = true } }",
    ),
    ("tiny", "ring", "plate = { size = [0.5, 0.5], facets = [30, 30], thickness = 0.01 }"),
    ("sheet", "portrait", "plate = { surface = 'continuous', grid = 64 }"),
    ("sheet_with_rim", "star", "plate = { surface = 'continuous', grid = 64, size = [30, 9], border = 3 }"),
    (
        "sheet_to_cut",
        "letter",
        "plate = { surface = 'continuous', grid = 64, cells = 2 }\ndesign = { cutter = 'ball:0.5' }",
    ),
    ("huge", "star", "plate = { size = [2000, 1500], facets = [40, 30], border = 100 }"),
];

fn designed(picture: &str, recipe: &str) -> Mesh {
    let recipe = Recipe::from_toml(recipe).unwrap();
    let path = format!("{}/examples/highlights/{picture}.png", env!("CARGO_MANIFEST_DIR"));
    let light = read(path.as_ref(), &recipe.reading()).unwrap().light;
    design(&recipe, &light, &Progress::silent()).unwrap().mesh
}

/// More than thirty plates of every kind, from 1 × 1 to 200 × 200 facets, in the folder where Cargo lets tests leave files.
static WRITTEN: LazyLock<Vec<PathBuf>> = LazyLock::new(|| {
    let closed = |relief| solid(&relief, 2.0, &Progress::silent()).unwrap();
    let mut meshes = vec![
        ("one_cell".to_string(), closed(plate(Shape::Random, 1, 1, 1.0, 0.0, 1))),
        ("one_row".to_string(), closed(plate(Shape::Random, 40, 1, 0.5, 0.0, 2))),
        ("one_column".to_string(), closed(plate(Shape::Eighths, 1, 33, 2.0, 0.0, 6))),
        ("four_cells".to_string(), closed(plate(Shape::Checkerboard, 2, 2, 10.0, 0.0, 7).with_rim(1.0))),
        ("small_and_high".to_string(), closed(plate(Shape::Random, 25, 25, 0.05, 3.0, 3).with_rim(0.5))),
        ("dome_with_rim".to_string(), closed(plate(Shape::Dome, 24, 16, 1.016, 0.0, 4).with_rim(3.0))),
        ("tall_walls_200".to_string(), closed(plate(Shape::Random, 200, 200, 0.15, 0.0, 8))),
        ("eighths_200".to_string(), closed(plate(Shape::Eighths, 200, 200, 0.15, 0.0, 9))),
    ];
    meshes.extend(ALL.map(|shape| (format!("{shape:?}"), closed(plate(shape, 37, 50, 1.0, 0.0, 5)))));
    meshes.extend(DESIGNS.map(|(name, picture, recipe)| (name.into(), designed(picture, recipe))));
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let write = |(name, mesh): (String, Mesh)| {
        let path = folder.join(format!("{name}.stl"));
        write_stl(&mesh, &mut File::create(&path).unwrap()).unwrap();
        path
    };
    meshes.into_iter().map(write).collect()
});

#[test]
fn manifold3d_and_trimesh_find_every_solid_sound() {
    let python = std::env::var("FACETMILL_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/outside/check_mesh.py");
    // Without files it only says whether it could judge.
    match Command::new(&python).arg(script).output() {
        Err(why) => return skip("manifold3d and trimesh", &format!("{python}: {why}")),
        Ok(run) if run.status.code() == Some(3) => {
            return skip("manifold3d and trimesh", String::from_utf8_lossy(&run.stdout).trim());
        }
        Ok(_) => {}
    }
    let run = Command::new(&python).arg(script).args(&*WRITTEN).output().unwrap();
    let report = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success(), "{report}{}", String::from_utf8_lossy(&run.stderr));
    assert_eq!(report.lines().filter(|line| line.starts_with("sound: ")).count(), WRITTEN.len(), "{report}");
}

/// The counts behind every ": " in admesh's summary, by the words before it.
fn count(report: &str, label: &str) -> Option<u64> {
    let rest = report.split_once(label)?.1;
    rest.split_once(':')?.1.split_whitespace().next()?.parse().ok()
}

#[test]
fn admesh_has_nothing_to_repair() {
    if let Err(why) = Command::new("admesh").arg("--version").output() {
        return skip("admesh", &why.to_string());
    }
    // admesh always exits with 0: only its counts tell.
    for path in &*WRITTEN {
        let run = Command::new("admesh").arg(path).output().unwrap();
        let report = String::from_utf8_lossy(&run.stdout);
        for label in [
            "Total disconnected facets",
            "Degenerate facets",
            "Edges fixed",
            "Facets removed",
            "Facets added",
            "Facets reversed",
            "Backwards edges",
        ] {
            assert_eq!(count(&report, label), Some(0), "{label} of {}:\n{report}", path.display());
        }
        assert_eq!(count(&report, "Number of parts"), Some(1), "{}:\n{report}", path.display());
    }
}
