//! Solids judged by programs of others: manifold3d and trimesh (Python packages), admesh (a command).
//!
//! A judge that is not installed is skipped, visibly; with FACETMILL_REQUIRE_CHECKERS=1 it is a failure.
//! FACETMILL_PYTHON names the Python to use, `python3` if unset.

mod plates;

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::process::Command;

use facetmill::export::solid::solid;
use facetmill::export::stl::write_stl;
use plates::{ALL, Shape, plate};
use tempfile::TempDir;

/// Plates of every kind in a directory that lives as long as the first of the pair.
fn written_plates() -> (TempDir, Vec<PathBuf>) {
    let mut plates = vec![
        ("one_cell".to_string(), plate(Shape::Random, 1, 1, 1.0, 0.0, 1)),
        ("one_row".to_string(), plate(Shape::Random, 40, 1, 0.5, 0.0, 2)),
        ("small_and_high".to_string(), plate(Shape::Random, 25, 25, 0.05, 3.0, 3).with_rim(0.5)),
        ("dome_with_rim".to_string(), plate(Shape::Dome, 24, 16, 1.016, 0.0, 4).with_rim(3.0)),
    ];
    plates.extend(ALL.map(|shape| (format!("{shape:?}"), plate(shape, 37, 50, 1.0, 0.0, 5))));
    let directory = tempfile::tempdir().unwrap();
    let paths = plates.iter().map(|(name, relief)| {
        let path = directory.path().join(format!("{name}.stl"));
        let mesh = solid(relief, 2.0).unwrap();
        write_stl(&mesh, &mut File::create(&path).unwrap()).unwrap();
        path
    });
    let paths = paths.collect();
    (directory, paths)
}

/// Says on the terminal itself, past the test harness, that a judge was not asked.
#[allow(clippy::explicit_write, reason = "the harness hides what a passing test says with eprintln")]
fn skip(judge: &str, why: &str) {
    let required = std::env::var("FACETMILL_REQUIRE_CHECKERS").is_ok_and(|value| value == "1");
    assert!(!required, "{judge} is required but missing: {why}");
    writeln!(std::io::stderr(), "SKIPPED: no opinion of {judge} ({why})").unwrap();
}

#[test]
fn manifold3d_and_trimesh_find_every_solid_sound() {
    let python = std::env::var("FACETMILL_PYTHON").unwrap_or_else(|_| "python3".into());
    let (_directory, paths) = written_plates();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/check_mesh.py");
    let run = match Command::new(&python).arg(script).args(&paths).output() {
        Ok(run) => run,
        Err(why) => return skip("manifold3d and trimesh", &format!("{python}: {why}")),
    };
    let report = String::from_utf8_lossy(&run.stdout);
    if run.status.code() == Some(3) {
        return skip("manifold3d and trimesh", report.trim());
    }
    assert!(run.status.success(), "{report}{}", String::from_utf8_lossy(&run.stderr));
    assert_eq!(report.lines().filter(|line| line.starts_with("sound: ")).count(), paths.len(), "{report}");
}

/// The counts behind every ": " in admesh's summary, by the words before it.
fn count(report: &str, label: &str) -> Option<u64> {
    let rest = report.split_once(label)?.1;
    rest.split_once(':')?.1.split_whitespace().next()?.parse().ok()
}

#[test]
fn admesh_has_nothing_to_repair() {
    // admesh always exits with 0: only its counts tell.
    let (_directory, paths) = written_plates();
    for path in paths {
        let run = match Command::new("admesh").arg(&path).output() {
            Ok(run) => run,
            Err(why) => return skip("admesh", &why.to_string()),
        };
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
