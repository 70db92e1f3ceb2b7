//! `facetmill verify` as a shop uses it: a folder, a limit, plates that lie otherwise than they should.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

use facetmill::export::stl::{read_stl, write_stl};
use facetmill::relief::mesh::Mesh;
use facetmill::relief::placement::{Axis, faces_turned, scaled, upright};
use serde_json::Value;

use crate::program::{facetmill, finish, home, listing, run_line};
use crate::reports::assert_published;
use crate::{assert_done, assert_refused, json};

const PLATE: &str = "design ring.png -o ring --facets 16x16 --rays 100000 --half-field 15";

fn tv(report: &Value, part: &str) -> f64 {
    report[part]["tv_incident"]["1"].as_f64().unwrap()
}

/// What verifying a mesh in `home` says, and its report.
fn verified(home: &Path, mesh: &Mesh, flags: &str) -> (String, Value) {
    let mut file = BufWriter::new(File::create(home.join("turned.stl")).unwrap());
    write_stl(mesh, &mut file).unwrap();
    file.flush().unwrap();
    let line = format!("verify turned.stl --against ring.png --half-field 15 --rays 60000 {flags}");
    let done = run_line(home, &line);
    assert_done(&done);
    let report = run_line(home, &format!("{line} --json"));
    (done.stdout, serde_json::from_str(&report.stdout).unwrap())
}

#[test]
fn a_designs_folder_is_verified_by_itself_and_a_limit_decides_the_exit_code() {
    let home = home();
    assert_done(&run_line(home.path(), PLATE));
    let before = listing(home.path());
    let done = run_line(home.path(), "verify ring --rays 100000");
    assert_done(&done);
    assert_eq!(listing(home.path()), before, "without -o nothing is written");
    let kept = run_line(home.path(), "verify ring --rays 100000 --at-most 0.5 --json");
    assert_done(&kept);
    let report: Value = serde_json::from_str(&kept.stdout).unwrap();
    let designed = json(home.path().join("ring/report.json"));
    assert!((tv(&report, "measured") - tv(&designed, "designed")).abs() < 0.01, "{report}");
    assert_eq!((&report["at_most"]["kept"], &report["at_most"]["as_milled"]), (&true.into(), &false.into()));
    assert_eq!(report["highlight"]["half-field"], 15.0);
    let beyond = run_line(home.path(), "verify ring --rays 100000 --at-most 0.001@0.5 -o proof --verbose");
    assert_eq!(beyond.code, Some(1), "{beyond:?}");
    assert!(beyond.stderr.contains("--at-most") && beyond.stdout.contains("not kept"), "{beyond:?}");
    assert!(home.path().join("proof/comparison.png").exists(), "the proof of what is worse is there");
    let told = run_line(home.path(), "verify ring --rays 100000 --at-most 0.1% --json");
    assert_eq!(told.code, Some(1));
    assert_eq!(serde_json::from_str::<Value>(&told.stdout).unwrap()["at_most"]["kept"], false);
    // The drawing is the recipe's; where it is gone, that is told.
    fs::rename(home.path().join("ring.png"), home.path().join("elsewhere.png")).unwrap();
    assert_refused(&run_line(home.path(), "verify ring"), 3, &["ring.png", "--against"]);
    assert_done(&run_line(home.path(), "verify ring --against elsewhere.png --rays 20000"));
    assert_refused(&run_line(home.path(), "verify ring/plate.stl"), 2, &["--against"]);
    for wrong in ["0", "2", "0.1@0", "much"] {
        assert_refused(&run_line(home.path(), &format!("verify ring --at-most {wrong}")), 2, &["--at-most"]);
    }
}

#[test]
fn a_folder_with_a_cutter_is_milled_again_with_the_designs_own_figures() {
    let home = home();
    for (name, flags) in [
        ("facets", "--facets 12x12 --for-cutter ball:1 --border 2"),
        ("sheet", "--surface continuous --grid 64 --cells 2 --size 20x20 --for-cutter ball:1 --border 1"),
    ] {
        assert_done(&run_line(home.path(), &format!("design ring.png -o {name} --rays 100000 {flags}")));
        let done = run_line(home.path(), &format!("verify {name} --rays 100000 --at-most 0.9 --json"));
        assert_done(&done);
        let report: Value = serde_json::from_str(&done.stdout).unwrap();
        let designed = json(home.path().join(name).join("report.json"));
        let (again, first) = (tv(&report, "as_milled"), tv(&designed, "as_milled"));
        assert!((again - first).abs() < 0.01, "{name}: {again} {first}");
        let left = |report: &Value| report["as_milled"]["left_by_cutter_um"].as_f64().unwrap();
        assert!((left(&report) - left(&designed)).abs() < 0.1 + 0.02 * left(&designed), "{name}");
        assert_eq!(report["at_most"]["as_milled"], true, "{name}");
    }
}

#[test]
fn a_plate_is_proved_as_a_machine_makes_it() {
    let home = home();
    let plate = "--surface continuous --grid 64 --cells 1 --size 6x6 --for-cutter ball:1 --polish 0.02 \
                 --machine ultraprecision --stepover 0.01 --as-made-stl";
    let told = run_line(home.path(), &format!("design ring.png -o ring --rays 100000 {plate}"));
    assert_done(&told);
    assert!(told.stdout.starts_with("As ultraprecision makes it with ball:1, polished 20 µm, "), "{}", told.stdout);
    assert!(home.path().join("ring/comparison_made.png").exists() && home.path().join("ring/as-made.stl").exists());
    let made = |flags: &str| {
        let done = run_line(home.path(), &format!("verify ring --rays 100000 --json {flags}"));
        assert_done(&done);
        serde_json::from_str::<Value>(&done.stdout).unwrap()
    };
    // Passes as close as this, and a machine as good, come near what is milled without steps; coarser ones do not.
    let fine = made("-o fine");
    assert_eq!(
        fine["as_made"],
        json(home.path().join("ring/report.json"))["as_made"],
        "the recipe says how it is made"
    );
    assert_eq!(made("--machine none").get("as_made"), None);
    let coarse = made("--machine desktop --stepover 0.05 --polish 0");
    let [milled, near, far] = [tv(&fine, "as_milled"), tv(&fine, "as_made"), tv(&coarse, "as_made")];
    assert!((near - milled).abs() < 0.004 && far > near + 0.05, "{milled} {near} {far}");
    assert_eq!(
        (&coarse["as_made"]["cutter"], &coarse["as_made"]["machine"]["name"]),
        (&"ball:1".into(), &"desktop".into())
    );
    // Cusps between passes w apart by a ball of radius R: w²/8R, 0.625 µm.
    assert!((coarse["as_made"]["cusp_height_um"].as_f64().unwrap() - 0.625).abs() < 0.002);
    assert!(home.path().join("fine/comparison_made.png").exists());
    // The file of the surface as made throws the light that was told.
    let again = run_line(home.path(), "verify fine/as-made.stl --against ring.png --rays 100000 --json");
    assert_done(&again);
    let again = tv(&serde_json::from_str(&again.stdout).unwrap(), "measured");
    assert!((again - near).abs() < 0.002, "{again} {near}");
    // The same draw is the same plate; another is not.
    let rough = "--machine vmc --stepover 0.04 --polish 0.03";
    let draws = |report: &Value| report["as_made"]["tv_incident_1deg_by_draw"].as_array().unwrap().clone();
    let (three, one) = (draws(&made(&format!("{rough} --draws 3"))), draws(&made(rough)));
    assert!(three[0] == one[0] && three[1] != one[0] && three.len() == 3, "{three:?} {one:?}");
    let limit = run_line(home.path(), &format!("verify ring --rays 100000 --machine desktop --at-most {near}"));
    assert_eq!(limit.code, Some(1));
    assert!(limit.stderr.contains("as made"), "{limit:?}");
}

#[test]
fn what_cannot_be_made_is_told_before_it_is_tried() {
    let home = home();
    assert_done(&run_line(home.path(), PLATE));
    fs::write(home.path().join("mine.toml"), "name = 'mine'\nstep = -1\n").unwrap();
    for (flags, code, words) in [
        ("--machine lathe", 2, ["lathe", "desktop"]),
        ("--machine vmc", 2, ["--cutter", "ball:0.5"]),
        ("--machine vmc --cutter drill:3", 2, ["drill:3", "bull:"]),
        ("--cutter ball:1", 2, ["--cutter", "--machine"]),
        ("--stepover 0.1", 2, ["--stepover", "--machine"]),
        ("--machine vmc --cutter ball:1 --polish 0.02 --as-made-stl", 2, ["--as-made-stl", "-o"]),
        ("--machine mine.toml --cutter ball:1", 3, ["mine.toml", "missing field"]),
        ("--machine vmc --cutter ball:1 --stepover 0.6", 4, ["--stepover", "0.5"]),
        ("--machine vmc --cutter ball:1 --stepover nan", 2, ["stepover", "0.0005"]),
        ("--machine vmc --cutter ball:90", 4, ["ball:90", "smaller"]),
        ("--machine vmc --cutter ball:1 --polish 3", 4, ["--polish", "twentieth"]),
        ("--machine ultraprecision --cutter ball:1 --stepover 0.0005 --memory 200M", 4, ["as made", "--stepover"]),
    ] {
        assert_refused(&run_line(home.path(), &format!("verify ring {flags}")), code, &words);
    }
}

#[test]
fn a_plate_that_lies_otherwise_is_told_with_the_flag_that_mends_it() {
    let home = home();
    assert_done(&run_line(home.path(), PLATE));
    let mesh = read_stl(&mut File::open(home.path().join("ring/plate.stl")).unwrap()).unwrap();
    let (said, report) = verified(home.path(), &mesh, "");
    let right = tv(&report, "measured");
    assert!(right < 0.2 && !said.contains("--flip") && !said.contains("--up"), "{said}");
    let over = upright(mesh.clone(), Axis::MinusZ);
    for (turned, word, flags) in [
        (over.clone(), "--flip", "--flip"),
        (over, "--flip", "--up=-z"),
        (upright(mesh.clone(), Axis::MinusY), "--up y", "--up y"),
        (upright(mesh.clone(), Axis::X), "--up -x", "--up -x"),
        (scaled(mesh.clone(), 0.1 / 25.4), "--unit in", "--unit in"),
    ] {
        let line = "verify turned.stl --against ring.png --half-field 15 --rays 60000";
        let mut file = BufWriter::new(File::create(home.path().join("turned.stl")).unwrap());
        write_stl(&turned, &mut file).unwrap();
        file.flush().unwrap();
        let lost = run_line(home.path(), line);
        assert!(lost.code == Some(4) || lost.told().contains(word), "{word}: {lost:?}");
        let (said, report) = verified(home.path(), &turned, flags);
        let mended = tv(&report, "measured");
        // Turned about an axis the ring is a ring still.
        assert!((mended - right).abs() < 0.02, "{flags}: {mended} {right} {said}");
    }
    let (said, report) = verified(home.path(), &faces_turned(mesh), "");
    assert!(said.contains("inside out") && (tv(&report, "measured") - right).abs() < 0.02, "{said}");
}

#[test]
fn a_drawing_that_is_turned_is_told_and_nothing_passes_without_a_word() {
    let home = home();
    let corner = image::GrayImage::from_fn(48, 48, |x, y| image::Luma([if x < 20 && y > 30 { 255 } else { 0 }]));
    corner.save(home.path().join("corner.png")).unwrap();
    image::imageops::rotate90(&corner).save(home.path().join("turned.png")).unwrap();
    assert_done(&run_line(home.path(), "design corner.png -o corner --facets 12x12 --rays 60000"));
    let said = run_line(home.path(), "verify corner --against turned.png --rays 60000").told();
    assert!(said.contains("if the drawing is turned by 90°"), "{said}");
    let said = run_line(home.path(), "verify corner --against ring.png --rays 60000").told();
    assert!(said.contains("may not belong together"), "{said}");
}

#[test]
fn a_picture_comes_through_a_pipe() {
    let home = home();
    let bytes = fs::read(home.path().join("ring.png")).unwrap();
    let mut child = facetmill()
        .current_dir(home.path())
        .args(["design", "-", "-o", "piped", "--facets", "6x6", "--no-verify"])
        .stdin(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    assert_done(&finish(child));
    assert_done(&run_line(home.path(), "design ring.png -o named --facets 6x6 --no-verify"));
    let plate = |folder: &str| fs::read(home.path().join(folder).join("plate.stl")).unwrap();
    assert!(plate("piped") == plate("named"));
}

#[test]
fn a_goals_folder_is_proved_again_from_every_side_as_designed_and_as_cut() {
    let home = home();
    fs::create_dir(home.path().join("made")).unwrap();
    fs::write(home.path().join("lobe.toml"), "[[lobe]]\nc = [-0.9, -0.9, 1.0]\nn = 20\n").unwrap();
    let plate = "--facets 10x10 --size 10x10 --rays 4000 --for-cutter ball:0.5 --verbose";
    let told = run_line(home.path(), &format!("design --goal lafortune:lobe.toml -o made/plate {plate}"));
    assert_done(&told);
    assert!(told.told().contains("as milled") && told.told().contains("as cut: "), "{told:?}");
    let designed = json(home.path().join("made/plate/report.json"));
    let done = run_line(home.path(), "verify made/plate --rays 4000 --at-most 0.001 -o proof");
    assert!(done.code == Some(1) && done.stderr.contains("as milled"), "{done:?}");
    assert!(done.told().contains("goal Cut by ball:0.5, the plate misplaces"), "{done:?}");
    let report = json(home.path().join("proof/report.json"));
    assert_published(&report, "VerifyReport");
    assert!((tv(&report, "measured") - tv(&designed, "designed")).abs() < 0.01, "{report}");
    assert_eq!((&report["at_most"]["as_milled"], &report["at_most"]["kept"]), (&true.into(), &false.into()));
    assert_eq!(report["highlight"]["half-field"], designed["recipe"]["highlight"]["half-field"]);
    let tvs = |slices: &Value| -> Vec<f64> {
        slices.as_array().unwrap().iter().map(|slice| slice["tv_1deg"]["value"].as_f64().unwrap()).collect()
    };
    let near =
        |a: &[f64], b: &[f64], most: f64| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < most);
    let [first, cut] = [&designed["goal"], &designed["goal"]["as_milled"]].map(|facts| tvs(&facts["slices"]));
    let [again, cut_again] = [&report["goal"], &report["goal"]["as_milled"]].map(|facts| tvs(&facts["slices"]));
    assert!(first.len() >= 5 && near(&first, &again, 0.01) && near(&cut, &cut_again, 0.01), "{report}");
    // A ball of half a facet's width rounds the foot of every wall: what it leaves is not what was designed.
    assert!(!near(&first, &cut, 0.02), "{first:?} {cut:?}");
    assert!(home.path().join("proof/goal.png").exists());
    // As a file that nobody knows of, against the goal that is named: the same slices, and the field that the goal needs.
    let file = "verify made/plate/plate.stl --rays 4000";
    assert_done(&run_line(home.path(), &format!("{file} --goal lafortune:lobe.toml --at-most 0.9 -o foreign")));
    let foreign = json(home.path().join("foreign/report.json"));
    assert_eq!(foreign["highlight"]["half-field"], report["highlight"]["half-field"]);
    assert!((tv(&foreign, "measured") - tv(&report, "measured")).abs() < 1e-9, "{foreign}");
    assert!(near(&tvs(&foreign["goal"]["slices"]), &again, 1e-9), "{foreign}");
    assert!(home.path().join("foreign/goal.png").exists());
    // Another goal is missed, and that decides the exit code.
    assert_eq!(run_line(home.path(), &format!("{file} --goal ggx:0.1 --at-most 0.2")).code, Some(1));
    assert_refused(&run_line(home.path(), &format!("{file} --goal ggx:0.1 --against ring.png")), 2, &["--against"]);
    assert_refused(&run_line(home.path(), &format!("{file} --against ring.png --goal-part all")), 2, &["--goal-part"]);
    assert_refused(&run_line(home.path(), &format!("{file} --goal merl:none.binary")), 3, &["none.binary"]);
    assert_refused(&run_line(home.path(), "verify made/plate --wall 500"), 2, &["goal", "--against"]);
    fs::rename(home.path().join("lobe.toml"), home.path().join("gone.toml")).unwrap();
    assert_refused(&run_line(home.path(), "verify made/plate"), 3, &["the goal's file lobe.toml"]);
}
