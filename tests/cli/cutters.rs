//! Cutters by name: what is sold, the user's own, how deep they go, and worn ones.

use std::fs;

use serde_json::Value;

use super::mill::{PASSES, PLATE};
use super::program::{home, run_line};
use super::{SHEET, assert_done, assert_refused, json};

/// A user's own cutters.
const OWN: &str = "\
\"ball-1\" = { shape = \"ball:1\", flutes = 0.02 }
\"stub\" = { shape = \"ball:1\", flutes = 0.02, neck = 3.5, worn-tip = 0.2 }
";

#[test]
fn a_cutter_by_name_is_its_shape_and_the_recipe_keeps_what_is_known_of_it() {
    let home = home();
    for (name, cutter) in [("named", "ball-1"), ("spelled", "ball:1"), ("flagged", "ball-1 --flutes 2")] {
        assert_done(&run_line(home.path(), &format!("design ring.png -o {name} {SHEET} --for-cutter {cutter}")));
    }
    let read = |file: &str| fs::read(home.path().join(file)).unwrap();
    assert!(read("named/plate.stl") == read("spelled/plate.stl"));
    let recipe = |folder: &str| String::from_utf8(read(&format!("{folder}/recipe.toml"))).unwrap();
    let said = ["cutter = \"ball:1\"", "flutes = 2.5", "worn-tip = 0.1"];
    assert!(said.iter().all(|key| recipe("named").contains(key)), "{}", recipe("named"));
    assert!(!recipe("spelled").contains("flutes") && recipe("flagged").contains("flutes = 2.0"));
    // Another cutter is not as long as the one before.
    let line = "design --recipe named/recipe.toml -o again --for-cutter ball:2 --no-verify";
    assert_done(&run_line(home.path(), line));
    assert!(!recipe("again").contains("flutes") && !recipe("again").contains("worn-tip"));
}

#[test]
fn reliefs_deeper_than_the_cutter_goes_are_refused_by_design_and_mill() {
    let home = home();
    fs::write(home.path().join("own.toml"), OWN).unwrap();
    let own = "--cutters own.toml";
    let short = run_line(home.path(), &format!("design ring.png -o none {SHEET} {own} --for-cutter ball-1"));
    assert_refused(
        &short,
        4,
        &["mm deep about its mean plane, and the cutter reaches 0.02 mm", "facetmill cutters", "--cells"],
    );
    let flat = run_line(home.path(), "design ring.png -o none --facets 8x6 --for-cutter ball:1 --flutes 0.02");
    assert_refused(&flat, 4, &["the cutter reaches 0.02 mm"]);
    assert!(!home.path().join("none").exists());
    // A neck goes where the teeth alone do not.
    assert_done(&run_line(home.path(), &format!("design ring.png -o necked {SHEET} {own} --for-cutter stub")));
    assert_done(&run_line(home.path(), PLATE));
    let short = run_line(home.path(), &format!("mill plate {PASSES} {own} --cutter ball-1 --no-verify -o shop"));
    assert_refused(&short, 4, &["the cutter reaches 0.02 mm"]);
    assert_done(&run_line(home.path(), &format!("mill plate {PASSES} --cutter ball-1 --no-verify -o shop")));
}

#[test]
fn a_worn_cutter_leaves_its_flat_in_the_surface_as_made() {
    let home = home();
    let named = PLATE.replace("12x8", "6x4").replace("ball:1", "ball-1").replace(" --no-verify", "");
    let making = "--machine vmc --stepover 0.1 --polish 0.05";
    assert_done(&run_line(home.path(), &format!("{named} {making}")));
    let made = |flags: &str, folder: &str| {
        assert_done(&run_line(home.path(), &format!("verify plate {flags} -o {folder}")));
        json(home.path().join(folder).join("report.json"))["as_made"].clone()
    };
    let [new, worn] = [made("", "new"), made("--worn", "worn")];
    let [before, after] = [&new, &worn].map(|made| made["tv_incident"]["1"].as_f64().unwrap());
    assert!(after > before, "{before} {after}");
    // Its radius, in mm.
    assert_eq!(worn["machine"]["tip-flat"], 0.05);
    let shape = run_line(home.path(), "verify plate --worn --for-cutter ball:1");
    assert_refused(&shape, 2, &["--worn", "ball-0.5", "tip-flat"]);
    let alone = run_line(home.path(), "design ring.png -o none --for-cutter ball-1 --worn");
    assert_refused(&alone, 2, &["worn", "--machine"]);
}

#[test]
fn the_list_has_every_cutter_and_wrong_names_and_files_are_told() {
    let home = home();
    fs::write(home.path().join("own.toml"), OWN).unwrap();
    fs::write(home.path().join("wrong.toml"), "\"a\" = { shape = \"ball:1\", teeth = 2 }\n").unwrap();
    let list = run_line(home.path(), "cutters");
    assert_eq!(list.code, Some(0), "{list:?}");
    assert!(list.stdout.contains("vbit-30-0.1") && list.stdout.contains("cone:30,0.1,3.175"), "{}", list.stdout);
    let own = run_line(home.path(), "cutters --cutters own.toml --json");
    let known: Value = serde_json::from_str(&own.stdout).unwrap();
    assert_eq!((&known["stub"]["neck"], &known["ball-1"]["flutes"]), (&3.5.into(), &0.02.into()));
    assert_eq!(known["ball-0.5"]["shape"], "ball:0.5");
    for (line, code, words) in [
        ("design ring.png -o none --for-cutter bal-0.5", 2, ["--for-cutter: 'bal-0.5'", "did you mean ball-0.5?"]),
        ("coupon --machine vmc --for-cutter stub -o none", 2, ["--for-cutter: 'stub'", "facetmill cutters"]),
        ("coupon --machine vmc --for-cutter drill:1 -o none", 2, ["--for-cutter: 'drill:1'", "ball:0.5"]),
        ("design ring.png -o none --cutters own.toml", 2, ["--cutters", "--for-cutter"]),
        ("design ring.png -o none --cutters wrong.toml --for-cutter a", 3, ["wrong.toml", "teeth"]),
        ("cutters --cutters gone.toml", 3, ["gone.toml", "no such file"]),
        ("coupon --machine vmc --cutters own.toml --for-cutter ball-1 -o none", 4, ["test piece", "reaches 0.02 mm"]),
    ] {
        assert_refused(&run_line(home.path(), line), code, &words);
    }
    assert!(!home.path().join("none").exists());
}
