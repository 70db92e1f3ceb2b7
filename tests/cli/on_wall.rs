//! A lamp and a wall nearby, from the flags to the figures in millimetres.

use std::fs;

use super::program::{home, run_line};
use super::reports::assert_published;
use super::{assert_done, assert_refused, json};

/// A sheet of four cells for a lamp and a wall at arm's length.
const NEAR: &str = "--size 12x12 --grid 48 --cells 2 --light 30,90 --lamp-distance 300 --wall 400 --picture-width 200";

#[test]
fn a_plate_for_a_room_is_proved_on_its_wall_as_designed_as_milled_and_from_its_file() {
    let home = home();
    let line = format!(
        "design ring.png -o plate {NEAR} --near warp --for-cutter ball:0.5 --polish 0.01 --border 2 --rays 100000 --verbose"
    );
    let done = run_line(home.path(), &line);
    assert_done(&done);
    let report = json(home.path().join("plate/report.json"));
    let wall = &report["on_wall"];
    let figure = |of: &str, key: &str| wall[of]["tv_incident"][key].as_f64().unwrap();
    assert!(figure("designed", "0.5deg") < 0.04 && figure("as_milled", "0.5deg") < 0.04, "{wall}");
    assert!((wall["focus_mm"].as_f64().unwrap() - 1200.0 / 7.0).abs() < 1e-6, "{wall}");
    assert!((wall["eye_blur_mm"].as_f64().unwrap() - 2.007).abs() < 0.001, "{wall}");
    let [near, far] = [0, 1].map(|k| wall["in_focus_mm"][k].as_f64().unwrap());
    assert!((200.0..395.0).contains(&near) && (405.0..900.0).contains(&far), "{wall}");
    // 1/f is all that counts: under the sun a wall at f is as sharp, but for the sun's own size.
    assert!((wall["under_sun"]["wall_mm"].as_f64().unwrap() - 1200.0 / 7.0).abs() < 1e-6);
    assert!(wall["under_sun"]["tv"].as_f64().unwrap() < 0.05 && wall["cells_tv"]["largest"].as_f64().unwrap() < 0.1);
    assert!(done.stdout.contains("on the wall") && done.stdout.contains("in focus"), "{}", done.stdout);
    // A dull rim lights nothing, and its share is told.
    assert!(report["rim"]["into_picture"] == 0.0 && report["rim"]["into_picture_if_polished"].as_f64().unwrap() > 0.3);

    let scene = "--light 30,90 --lamp-distance 300 --wall 400 --picture-width 200 --margin 2 --rays 100000";
    assert_done(&run_line(home.path(), &format!("verify plate/plate.stl --against ring.png -o proof {scene}")));
    let again = json(home.path().join("proof/report.json"));
    for key in ["eye", "0.5deg", "1deg"] {
        let told = again["on_wall"]["designed"]["tv_incident"][key].as_f64().unwrap();
        assert!((told - figure("designed", key)).abs() < 0.002, "{key}: {told}");
    }
    // A machine with next to no faults leaves what an ideal cutter does; and the plate must be polished.
    let made = "verify plate --rays 100000 --machine ultraprecision --stepover 0.02 -o made --verbose";
    let done = run_line(home.path(), made);
    assert_done(&done);
    let proof = json(home.path().join("made/report.json"));
    assert_published(&proof, "VerifyReport");
    let made = |key: &str| proof["as_made"]["on_wall"]["tv_incident"][key].as_f64().unwrap();
    for key in ["0.5deg", "1deg"] {
        assert!((made(key) - figure("as_milled", key)).abs() < 0.003, "{key}: {} {wall}", made(key));
    }
    assert!(done.stdout.contains("as made") && home.path().join("made/comparison_made.png").exists(), "{done:?}");
    assert_refused(&run_line(home.path(), "verify plate --machine vmc --polish 0"), 2, &["--machine", "--polish"]);
    // The design's own room, unless another wall is named; repeated it is no plate.
    assert_done(&run_line(home.path(), "measure plate -o seen --rays 100000"));
    let seen = &json(home.path().join("seen/report.json"))["measured"];
    assert!((seen["wall_distance_mm"].as_f64().unwrap() - 400.0).abs() < 1e-6, "{seen}");
    assert!(seen["in_picture"].as_f64().unwrap() > 0.97, "{seen}");
    let refused = run_line(home.path(), "measure plate -o endless --extent endless");
    assert_refused(&refused, 4, &["its cells differ", "--extent finite"]);
}

#[test]
fn a_far_plate_tells_from_where_on_its_figures_hold_and_a_lamp_in_the_beam_is_told() {
    let home = home();
    let done = run_line(home.path(), "design ring.png -o far --facets 8x6 --rays 20000 --verbose");
    assert_done(&done);
    let holds = &json(home.path().join("far/report.json"))["holds_beyond"];
    assert_eq!(
        (holds["lamp_and_wall_mm"].as_f64(), holds["wall_under_sun_mm"].as_f64()),
        (Some(12000.0), Some(6000.0))
    );
    assert!(done.stdout.contains("12 m"), "{}", done.stdout);
    let line = "design ring.png -o lit --facets 8x6 --rays 20000 --lamp-distance 300 --wall 900 --lamp-radius 60";
    let done = run_line(home.path(), line);
    assert_done(&done);
    let report = json(home.path().join("lit/report.json"));
    assert!(report["advice"].to_string().contains("The lamp stands between plate and picture"), "{report}");
    assert!(report["on_wall"]["stopped_by_lamp"].as_f64().unwrap() > 0.05 && report["holds_beyond"].is_null());
    assert!(fs::exists(home.path().join("lit/comparison.png")).unwrap());
}
