//! Plates that are one continuous sheet.

use std::fs;

use serde_json::Value;

use super::program::{Outcome, home, run_line};
use super::{ALL_FILES, SHEET, assert_done, assert_refused, assert_same_plate, json, names};

#[test]
fn a_continuous_plate_is_the_same_with_any_threads_and_tells_what_a_cutter_leaves() {
    let home = home();
    let small = "--surface continuous --grid 64 --cells 2 --size 20x20 --rays 20000 --for-cutter ball:0.5";
    for threads in [1, 2] {
        let line = format!("design ring.png -o plate{threads} --threads {threads} {small}");
        assert_done(&run_line(home.path(), &line));
    }
    let [one, two] = ["plate1", "plate2"].map(|name| home.path().join(name));
    assert_eq!(names(&one), [&ALL_FILES[..1], &["comparison_milled.png"], &ALL_FILES[1..]].concat());
    assert_same_plate(&one, &two, &[]);
    let report = json(one.join("report.json"));
    // Two triangles a square, and a base.
    assert!(report["stl"]["triangles"].as_u64().unwrap() > 2 * 128 * 128, "{}", report["stl"]);
    assert!(report["design"]["valleys"].is_null());
    assert_eq!(report["design"]["continuous"]["grid"], 64);
    let [designed, milled] = ["designed", "as_milled"].map(|key| report[key]["tv_incident"]["1"].as_f64().unwrap());
    assert!(designed < 0.05 && milled < 0.1, "{designed} {milled}");
    assert_eq!(report["designed"]["multi_bounce"], 0.0);

    let dry = run_line(home.path(), &format!("design ring.png --dry-run --json {small}"));
    let facts: Value = serde_json::from_str(&dry.stdout).unwrap();
    let about = facts["stl_triangles_about"].as_f64().unwrap();
    assert!((about / report["stl"]["triangles"].as_f64().unwrap() - 1.0).abs() < 0.1, "{facts}");

    for (flags, code, parts) in [
        ("--grid 63", 4, ["--grid 64", "63"]),
        ("--for-cutter drill:3", 2, ["drill:3", "ball:0.5"]),
        ("--for-cutter ball:90", 4, ["90", "cell"]),
        ("--max-triangles 100", 2, ["--max-triangles", "100"]),
    ] {
        let line = format!("design ring.png -o none --surface continuous {flags}");
        assert_refused(&run_line(home.path(), &line), code, &parts);
        assert!(!home.path().join("none").exists());
    }
}

#[test]
fn depth_and_levelling_are_obeyed_or_refused() {
    let home = home();
    let free = run_line(home.path(), &format!("design ring.png -o free {SHEET} --json"));
    let depth = |outcome: &Outcome| {
        let report: Value = serde_json::from_str(&outcome.stdout).unwrap();
        report["design"]["continuous"]["depth_mm"].as_f64().unwrap()
    };
    let allowed = 0.6 * depth(&free);
    let shallow = run_line(home.path(), &format!("design ring.png -o shallow {SHEET} --json --max-depth {allowed}"));
    assert_done(&shallow);
    assert!(depth(&shallow) <= 1.02 * allowed, "{} {allowed}", depth(&shallow));
    // A wide ball cannot follow so shallow a relief, and raises it.
    let line = "design ring.png -o deep --grid 64 --cells 2 --size 20x20 --for-cutter ball:5 --max-depth 0.01";
    assert_refused(&run_line(home.path(), line), 4, &["mm deep where 0.01 mm", "--max-depth", "--cells"]);
    assert!(!home.path().join("deep").exists());
    let line = format!("design ring.png -o none {SHEET} --polish 2.5");
    assert_refused(&run_line(home.path(), &line), 4, &["--polish", "quarter"]);
    for flag in ["--polish -1", "--max-depth 0", "--max-depth -3"] {
        let line = format!("design ring.png -o none {SHEET} {flag}");
        assert_refused(&run_line(home.path(), &line), 2, &[flag.split(' ').next().unwrap()]);
    }
    assert!(!home.path().join("none").exists());
    assert_done(&run_line(home.path(), &format!("design ring.png -o polished {SHEET} --polish 0.1")));
    let stl = |name: &str| fs::read(home.path().join(name).join("plate.stl")).unwrap();
    assert!(stl("free") != stl("polished"));
}

#[test]
fn a_preview_says_what_it_is_and_is_not_milled() {
    let home = home();
    let told = run_line(home.path(), "design ring.png -o look --preview");
    assert_done(&told);
    assert!(told.stdout.starts_with("In this preview, "), "{}", told.stdout);
    assert!(told.told().contains("no plate to be made: leave out --preview"), "{}", told.stdout);
    let report = json(home.path().join("look/report.json"));
    assert_eq!(report["design"]["continuous"]["preview"], true);
    assert!(report["designed"]["tv_incident"]["1"].as_f64().unwrap() < 0.01, "{report}");
    let refused = run_line(home.path(), "mill look --machine vmc --cutter ball:1 -o shop");
    assert_eq!(refused.code, Some(4), "{refused:?}");
    assert!(refused.stderr.contains("look is a preview") && !home.path().join("shop").exists(), "{}", refused.stderr);
    let refused = run_line(home.path(), "design ring.png -o near --preview --wall 1000");
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.stderr.contains("preview"), "{}", refused.stderr);
}
