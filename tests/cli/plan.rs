//! Plans: which way of making a plate brings its drawing out best.

use serde_json::Value;

use super::program::{home, run_line};
use super::reports::assert_published;
use super::{assert_done, assert_refused, names};

#[test]
fn a_plan_is_proved_and_its_recipe_makes_the_plate() {
    let home = home();
    let plate = "--size 6x6 --cells 1 --for-cutter ball:0.5 --max-triangles 6000 --rays 20000";
    let line = format!("plan ring.png --machine vmc --hours 0.05 -o plan --json {plate}");
    let told = run_line(home.path(), &line);
    assert_done(&told);
    let report: Value = serde_json::from_str(&told.stdout).unwrap();
    assert_published(&report, "PlanReport");
    assert_eq!(names(&home.path().join("plan")), ["plan.png", "recipe-1.toml", "report.json"]);
    let best = &report["best"][0];
    let [expected, proved, hours] = [&best["expected_tv_1deg"], &best["as_made"]["tv_incident"]["1"], &best["hours"]]
        .map(|figure| figure.as_f64().unwrap());
    // Of so coarse a grid the design itself misplaces more than the model's cell does.
    assert!(expected > 0.001 && proved < 3.0 * expected + 0.02 && hours <= 0.0501, "{best}");
    let again = run_line(home.path(), "design --recipe plan/recipe-1.toml -o plate --json");
    assert_done(&again);
    let made: Value = serde_json::from_str(&again.stdout).unwrap();
    assert_eq!(made["as_made"]["tv_incident"], best["as_made"]["tv_incident"]);
}

#[test]
fn what_cannot_be_planned_is_told() {
    let home = home();
    for (flags, code, words) in [
        ("ring.png --machine vmc", 2, ["--hours", "required"]),
        ("ring.png --hours 1", 2, ["--machine", "vmc"]),
        ("ring.png --machine vmc --hours -1", 2, ["--hours", "0.001"]),
        ("ring.png --machine vmc --hours 1 --wanted 0.1", 2, ["--wanted", "--hours"]),
        ("ring.png --machine vmc --wanted 0", 2, ["--wanted", "0.0001"]),
        ("ring.png --machine vmc --hours 1 --facets 9x9", 2, ["--facets", "there is no"]),
        ("none.png --machine vmc --hours 1", 3, ["none.png", "no such file"]),
        ("ring.png --machine vmc --hours 1 --size 6x6 --cells 1 --max-depth 0.01", 4, ["--max-depth", "0.01 mm"]),
    ] {
        assert_refused(&run_line(home.path(), &format!("plan {flags} -o plan")), code, &words);
    }
    assert!(!home.path().join("plan").exists());
}
