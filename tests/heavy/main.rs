//! What is too heavy for `cargo test`: designs at the program's own defaults.
//!
//!     cargo test --locked --test heavy

#[allow(dead_code, reason = "shared with the tests of the command line, which need all of it")]
#[path = "../program/mod.rs"]
mod program;

#[path = "../shop/mod.rs"]
mod shop;

mod digits;

use std::fs;
use std::path::Path;

use program::{Outcome, home, run_line};
use serde_json::Value;

fn json(path: impl AsRef<Path>) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn assert_done(outcome: &Outcome) {
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
}

#[test]
fn facets_are_made_where_the_kind_is_open_and_they_are_better() {
    let home = home();
    // Nine cells of 5.3 mm are small for a ball of 5 mm, one dome of 16 mm is not.
    let line = "design ring.png --size 16x16 --for-cutter ball:5 --rays 50000";
    let told = run_line(home.path(), &format!("{line} -o open"));
    assert_done(&told);
    assert!(told.told().contains("30 × 30 facets"), "{}", told.stdout);
    assert!(told.told().contains("Note: Flat facets were made, since 30x30"), "{}", told.stdout);
    let report = json(home.path().join("open/report.json"));
    assert!(report["design"]["surface"].as_str().unwrap().starts_with("facets: they are better"), "{report}");
    let [flat, sheet] =
        ["flat", "continuous"].map(|kind| report["beside_facets"]["tv_incident_1deg"][kind].as_f64().unwrap());
    assert!(flat < sheet, "{flat} {sheet}");
    assert_eq!(flat, report["as_milled"]["tv_incident"]["1"].as_f64().unwrap());
    assert_done(&run_line(home.path(), "design --recipe open/recipe.toml -o again --no-verify"));
    let stl = |name: &str| fs::read(home.path().join(name).join("plate.stl")).unwrap();
    assert!(stl("open") == stl("again"));
    // Who asks for the relief gets it.
    let told = run_line(home.path(), &format!("{line} -o asked --surface continuous --grid 32"));
    assert_done(&told);
    assert!(told.told().contains("Note: Flat facets would do better, since 30x30"), "{}", told.stdout);
}
