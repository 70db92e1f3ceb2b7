//! The light of written plates as a few lines of Python see it, which share no code with the program and need no package:
//! they read the STL, mirror the light at every triangle, blur, and compare with the drawing.

use std::fs;
use std::path::Path;
use std::process::Command;

use image::{GrayImage, Luma};
use serde_json::Value;

use crate::asking;

/// Pixels along a side of the drawing.
const SIDE: u32 = 120;

/// A ring of light around a disc of half its brightness, off the middle, smooth enough for its pixels.
fn drawing() -> GrayImage {
    GrayImage::from_fn(SIDE, SIDE, |x, y| {
        let centre = f64::from(SIDE - 1);
        let at = [2.0 * f64::from(x) - centre, 2.0 * f64::from(y) - centre].map(|v| v / f64::from(SIDE));
        let radius = (at[0] - 0.1).hypot(at[1] + 0.05);
        Luma([match radius {
            ..0.25 => 188,
            0.45..0.7 => 255,
            _ => 0,
        }])
    })
}

/// The report of a design of `drawing.png` in `home`.
fn designed(home: &Path, flags: &str) -> Value {
    let run = Command::new(env!("CARGO_BIN_EXE_facetmill"))
        .current_dir(home)
        .args("design drawing.png -o plate --force --json --half-field 15 --rays 50000".split(' '))
        .args(flags.split(' '))
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    serde_json::from_slice(&run.stdout).unwrap()
}

#[test]
fn a_few_lines_of_python_see_the_reported_light_in_the_written_stl() {
    let home = tempfile::tempdir().unwrap();
    let drawing = drawing();
    drawing.save(home.path().join("drawing.png")).unwrap();
    let pgm = home.path().join("drawing.pgm");
    fs::write(&pgm, [format!("P5 {SIDE} {SIDE} 255\n").as_bytes(), drawing.as_raw()].concat()).unwrap();
    // The last: a plate of a few facets, whose light is far from the drawing. A plate of some cells of a sheet, light from
    // straight above and from aside, and facets.
    for (flags, theta, phi, least, most) in [
        ("--grid 96 --cells 2", 0.0, 0.0, 0.0, 0.02),
        ("--grid 96 --cells 2 --light 25,130", 25.0, 130.0, 0.0, 0.02),
        ("--facets 24x24", 0.0, 0.0, 0.0, 0.03),
        ("--facets 4x4", 0.0, 0.0, 0.1, 1.0),
    ] {
        let report = designed(home.path(), flags);
        let plate = home.path().join("plate/plate.stl");
        let [theta, phi] = [theta, phi].map(|degrees: f64| degrees.to_string());
        let arguments = [plate.as_os_str(), pgm.as_os_str(), theta.as_ref(), phi.as_ref(), "15".as_ref(), "1".as_ref()];
        let said = match asking::ask("stl_light.py", &arguments) {
            Ok(said) => said,
            Err(why) => return asking::skip("Python", &why),
        };
        let theirs: Value = serde_json::from_str(&said).unwrap();
        let tv = theirs["tv_incident"].as_f64().unwrap();
        let ours = report["designed"]["tv_incident"]["1"].as_f64().unwrap();
        println!("{flags}: {tv} by Python, {ours} reported");
        assert!((tv - ours).abs() <= 0.003 + 0.02 * ours, "{flags}: {tv} by Python, {ours} reported");
        assert!((least..most).contains(&tv), "{flags}: {tv}");
        assert!(theirs["efficiency_in_image"].as_f64().unwrap() > 0.98, "{flags}: {theirs}");
    }
}
