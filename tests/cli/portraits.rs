//! A picture that stands on the metal.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::program::{home, run_line};
use super::reports::assert_published;
use super::{assert_done, assert_refused, json};

const SMALL: &str = "--size 12x12 --light 40,0 --grid 16 --rays 400000";

#[test]
fn a_portrait_is_seen_on_the_plate_and_its_folder_says_how_to_look_at_it() {
    let home = home();
    let folder = |name: &str| home.path().join(name);
    let line = format!("design --portrait ring.png -o plate {SMALL} --for-cutter ball:0.5");
    let dry = run_line(home.path(), &format!("{line} --dry-run --json"));
    assert_done(&dry);
    assert!(!folder("plate").exists(), "a dry run writes nothing");
    let told = run_line(home.path(), &line);
    assert_done(&told);
    assert!(told.told().contains("12 × 12 patches") && told.told().contains("likeness"), "{}", told.stdout);
    let report = json(folder("plate/report.json"));
    assert_published(&report, "PatchesReport");
    let dry: Value = serde_json::from_str(&dry.stdout).unwrap();
    assert_published(&dry, "EstimateReport");
    assert_eq!((&dry["patches"], &dry["grid"]), (&report["patches"]["count"], &report["patches"]["nodes"]));
    assert_eq!(
        (&dry["stl_triangles_about"], &dry["stl_bytes_about"]),
        (&report["stl"]["triangles"], &report["stl"]["bytes"])
    );
    let large = "design --portrait ring.png --size 12x12 --light 40,0 --grid 32 --dry-run --memory 60M";
    let refused = run_line(home.path(), large);
    assert!(refused.told().contains("This would be refused"), "{refused:?}");
    for scores in [&report["designed"], &report["as_milled"]] {
        assert!(scores["ssim"].as_f64().unwrap() > 0.9 && scores["tv"].as_f64().unwrap() < 0.1, "{scores}");
    }
    assert!(report["reachable"]["contrast"].as_f64().unwrap() > 100.0, "{report}");
    assert_eq!((&report["patches"]["nodes"], &report["recipe"]["plate"]["lobe"]), (&16.into(), &1.5.into()));
    for file in ["plate.stl", "target.png", "simulated.png", "comparison.png", "comparison_milled.png", "relief.png"] {
        assert!(fs::metadata(folder("plate").join(file)).unwrap().len() > 500, "{file}");
    }
    // Its recipe makes the same plate, and what it is not for is said.
    assert_done(&run_line(home.path(), "design --recipe plate/recipe.toml -o again --no-verify"));
    let stl = |name: &str| fs::read(folder(name).join("plate.stl")).unwrap();
    assert!(stl("plate") == stl("again"));
    its_file_is_looked_at_again(home.path(), &report);
    let look =
        "measure plate -o look --look --camera 40,180 --resolution 64 --rays 16 --material mirror:beckmann:0.0185";
    assert_done(&run_line(home.path(), look));

    for (line, code, said) in [
        ("design --portrait ring.png -o no --half-field 12", 2, "--half-field is not for a plate of patches"),
        ("design ring.png -o no --patches 10x10", 2, "--patches is for a plate of patches"),
        ("design --portrait ring.png -o no --patches 200x200", 4, "take at most --patches 150x150"),
        ("design --portrait ring.png -o no --size 30x20 --patches 30x20", 3, "choose --size in the same proportion"),
        ("design --portrait ring.png -o no --spare 2,0", 4, "choose --spare"),
        ("design --portrait missing.png -o no", 3, "missing.png"),
    ] {
        assert_refused(&run_line(home.path(), line), code, &[said]);
        assert!(!folder("no").exists(), "{line}");
    }
}

/// What `verify` says of the folder `plate` in `home`, whose design told `report`.
fn its_file_is_looked_at_again(home: &Path, report: &Value) {
    let told = run_line(home, "verify plate --rays 400000 --at-most 0.001 -o proof");
    assert!(told.code == Some(1) && told.stderr.contains("in other patches"), "{told:?}");
    let again = json(home.join("proof/report.json"));
    assert_published(&again, "PatchesVerifyReport");
    for (ours, theirs) in [("measured", "designed"), ("as_milled", "as_milled")] {
        for figure in ["ssim", "tv", "light"] {
            let [a, b] = [&again[ours], &report[theirs]].map(|scores| scores[figure].as_f64().unwrap());
            assert!((a - b).abs() < 0.003, "{ours} {figure}: {a} {b}");
        }
    }
    assert_eq!((&again["reachable"], &again["viewer"]), (&report["reachable"], &report["viewer"]));
    assert_eq!((&again["at_most"]["kept"], &again["at_most"]["as_milled"]), (&false.into(), &true.into()));
    for file in ["target.png", "simulated.png", "comparison.png", "comparison_milled.png", "report.json"] {
        assert!(fs::metadata(home.join("proof").join(file)).unwrap().len() > 500, "{file}");
    }
    // From another lamp the viewer sees another picture, and of a picture that is not its own the plate shows little.
    let elsewhere = run_line(home, "verify plate --rays 20000 --light 40,30 --at-most 0.99 --json");
    assert_done(&elsewhere);
    let elsewhere: Value = serde_json::from_str(&elsewhere.stdout).unwrap();
    assert!(elsewhere["measured"]["light"].as_f64().unwrap() < 0.5, "{elsewhere}");
    assert_eq!((&elsewhere["viewer"], &elsewhere["at_most"]["kept"]), (&report["viewer"], &true.into()));
    for (line, code, said) in [
        ("verify plate --machine vmc", 2, "--machine is not for a plate of patches"),
        ("verify plate --half-field 12", 2, "half-field is not for a plate of patches"),
        ("verify plate --at-most 0.1@2", 2, "blur behind --at-most"),
        ("verify plate --margin 1", 3, "10.000 × 10.000 mm"),
        ("verify plate --against missing.png", 3, "missing.png"),
    ] {
        assert_refused(&run_line(home, line), code, &[said]);
    }
}

#[test]
fn maps_give_each_patch_its_lobe() {
    let home = home();
    let line = format!("design --gloss ring.png --albedo ring.png -o maps {SMALL} --spare 70,180");
    assert_done(&run_line(home.path(), &line));
    let report = json(home.path().join("maps/report.json"));
    assert_published(&report, "PatchesReport");
    assert!(report["designed"]["ssim"].as_f64().unwrap() > 0.8, "{report}");
    let spare = report["patches"]["spare_share"].as_f64().unwrap();
    assert!((0.1..0.9).contains(&spare), "{spare}");
    let refused = run_line(home.path(), "design --portrait ring.png --gloss ring.png -o no");
    assert_refused(&refused, 2, &["--gloss"]);
}
