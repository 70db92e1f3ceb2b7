//! The program as a whole, from the command line to the files.

#[path = "../program/mod.rs"]
mod program;

#[path = "../library/mutants/mutate.rs"]
mod mutate;

mod bounds;
mod breaking;
mod continuous;
mod cutters;
mod files;
mod hostile;
mod kinds;
mod measure;
mod mill;
mod milled;
mod names;
mod on_wall;
mod plan;
mod portraits;
mod publishing;
mod reports;
mod stopping;
mod telling;
mod verify;

use std::fs;
use std::path::Path;
use std::process::Command;

use program::{Outcome, listing};
use serde_json::Value;

/// A plate that takes a moment.
const SMALL: &str = "--facets 8x6 --rays 20000";

/// A sheet that takes a moment.
const SHEET: &str = "--surface continuous --grid 64 --cells 2 --size 20x20 --no-verify";

const ALL_FILES: [&str; 9] = [
    "comparison.png",
    "heightmap.json",
    "heightmap.png",
    "plate.stl",
    "recipe.toml",
    "relief.png",
    "report.json",
    "simulated.png",
    "target.png",
];

fn names(folder: &Path) -> Vec<String> {
    listing(folder).iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect()
}

fn json(path: impl AsRef<Path>) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn assert_done(outcome: &Outcome) {
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
}

fn assert_refused(outcome: &Outcome, code: i32, parts: &[&str]) {
    assert_eq!(outcome.code, Some(code), "{outcome:?}");
    assert!(outcome.stderr.starts_with("facetmill: ") && outcome.stderr.lines().count() == 1, "{outcome:?}");
    assert!(parts.iter().all(|part| outcome.stderr.contains(part)), "{parts:?} in {outcome:?}");
}

/// Files of two designs that must be the same bytes; the report differs in its seconds.
fn assert_same_plate(a: &Path, b: &Path, but: &[&str]) {
    for name in ALL_FILES.iter().filter(|name| **name != "report.json" && !but.contains(name)) {
        assert!(fs::read(a.join(name)).unwrap() == fs::read(b.join(name)).unwrap(), "{name} differs");
    }
    let facts = |folder: &Path| {
        let mut report = json(folder.join("report.json"));
        report["design"].as_object_mut().unwrap().remove("seconds");
        report
    };
    if but.is_empty() {
        assert_eq!(facts(a), facts(b));
    }
}

/// Whether calls of the program can be made to fail or to kill it here; says so if not.
fn strace_may_trace() -> bool {
    let strace = Command::new("strace").args(["-f", "-e", "trace=none", "true"]).output();
    let may = strace.is_ok_and(|done| done.status.success());
    if !may {
        eprintln!("skipped: no strace here, or it may not trace");
    }
    may
}
