//! Which kind of relief is made, and what is said of the other.

use std::fs;

use super::program::{home, run_line};
use super::{assert_done, assert_refused, assert_same_plate, json};

#[test]
fn a_sheet_is_made_unless_something_asks_for_facets() {
    let home = home();
    let folder = |name: &str| home.path().join(name);
    let told = run_line(home.path(), "design ring.png -o sheet --grid 32 --rays 20000");
    assert_done(&told);
    assert!(told.told().contains("3 × 3 cells of a sheet"), "{}", told.stdout);
    assert!(told.told().contains("Note: No cutter was named"), "{}", told.stdout);
    let report = json(folder("sheet/report.json"));
    assert!(report["design"]["surface"].as_str().unwrap().starts_with("sheet: nothing asked"), "{report}");
    assert_eq!(report["design"]["continuous"]["cells"], serde_json::json!([3, 3]));
    // A recipe of ours is taken again, and may be turned to the other kind and back.
    assert_done(&run_line(home.path(), "design --recipe sheet/recipe.toml -o again"));
    assert_same_plate(&folder("sheet"), &folder("again"), &[]);
    let flat = run_line(home.path(), "design --recipe sheet/recipe.toml -o flat --surface flat --facets 8x6");
    assert_done(&flat);
    assert!(flat.told().contains("8 × 6 facets") && flat.told().contains("as sharp as facets"), "{}", flat.stdout);
    assert_eq!(json(folder("flat/report.json"))["design"]["surface"], "facets: as --surface asks");
    assert_done(&run_line(home.path(), "design --recipe flat/recipe.toml -o flat2 --no-verify"));
    let line = "design --recipe flat/recipe.toml -o back --surface continuous --grid 32";
    assert_done(&run_line(home.path(), line));
    let stl = |name: &str| fs::read(folder(name).join("plate.stl")).unwrap();
    assert!(stl("back") == stl("sheet") && stl("flat") == stl("flat2"));

    assert_done(&run_line(home.path(), "design ring.png -o random --arrange random --no-verify"));
    assert_eq!(json(folder("random/report.json"))["design"]["surface"], "facets: --arrange asks for facets");
    let mixed = run_line(home.path(), "design --recipe sheet/recipe.toml -o none --facets 8x6");
    assert_refused(&mixed, 2, &["--grid is for a sheet", "--facets"]);
    let mixed = run_line(home.path(), "design --recipe flat/recipe.toml -o none --max-depth 1");
    assert_refused(&mixed, 2, &["--max-depth is for a sheet", "--surface"]);
}

#[test]
fn long_plates_have_cells_that_are_nearly_square() {
    let home = home();
    for (size, cells) in [("30x9", "5 × 2"), ("2x30", "1 × 15"), ("100x20", "7 × 1")] {
        let told = run_line(home.path(), &format!("design ring.png --dry-run --size {size}"));
        assert_done(&told);
        assert!(told.told().contains(cells), "{size}: {}", told.stdout);
    }
    assert_done(&run_line(home.path(), "design ring.png -o long --size 30x9 --grid 32 --rays 20000"));
    let report = json(home.path().join("long/report.json"));
    assert!(report["designed"]["tv_incident"]["1"].as_f64().unwrap() < 0.05, "{report}");
}

#[test]
fn a_relief_that_is_worse_than_facets_is_not_praised() {
    let home = home();
    let told = run_line(home.path(), "design ring.png -o blunt --grid 32 --min-feature 5 --rays 50000");
    assert_done(&told);
    assert!(told.told().contains("Note: Flat facets would do better, since 30x30"), "{}", told.stdout);
    assert!(told.told().contains("lower --min-feature, raise --grid, or take --surface flat"), "{}", told.stdout);
    let report = json(home.path().join("blunt/report.json"));
    let [flat, sheet] =
        ["flat", "continuous"].map(|kind| report["beside_facets"]["tv_incident_1deg"][kind].as_f64().unwrap());
    assert!(flat < 0.02 && sheet > 5.0 * flat, "{flat} {sheet}");
    assert_eq!(sheet, report["designed"]["tv_incident"]["1"].as_f64().unwrap());

    // The figure is that of the facets themselves, and as milled where a cutter is named.
    assert_done(&run_line(home.path(), "design ring.png -o facets --surface flat --for-cutter ball:4 --rays 50000"));
    let facets = json(home.path().join("facets/report.json"));
    assert_eq!(facets["designed"]["tv_incident"]["1"].as_f64().unwrap(), flat);
    let line = "design ring.png -o cut --grid 64 --for-cutter ball:4 --rays 50000 --verbose";
    let told = run_line(home.path(), line);
    assert_done(&told);
    assert!(!told.told().contains("would do better") && told.told().contains("milled alike"), "{}", told.stdout);
    let beside = &json(home.path().join("cut/report.json"))["beside_facets"];
    assert_eq!(beside["tv_incident_1deg"]["flat"], facets["as_milled"]["tv_incident"]["1"]);
    assert_eq!(beside["as_milled"], true);

    // A sheet that is right to what an eye sees is not compared.
    let told = run_line(home.path(), "design ring.png -o fine --grid 64 --rays 50000");
    assert_done(&told);
    let fine = json(home.path().join("fine/report.json"));
    assert!(fine["designed"]["tv_incident"]["1"].as_f64().unwrap() < 0.005, "{}", fine["designed"]);
    assert!(fine.get("beside_facets").is_none() && !told.stages.iter().any(|stage| stage.contains("flat facets")));
}
