//! Whole designs judged by the independent referee: another language, another renderer, no code in common.
//!
//! The referee is a folder outside this repository (FACETMILL_REFEREE, or `../shared/referee`); FACETMILL_PYTHON names
//! the Python that its setup.sh prints. Where it is missing the tests are skipped, visibly; with
//! FACETMILL_REQUIRE_CHECKERS=1 that is a failure.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::referee;

/// Rays on either side.
const RAYS: u64 = 2_000_000;

/// The referee's figures of one STL against a picture, or why it has none.
fn figures(folder: &Path, plate: &Path, picture: &str, settings: &Value) -> Result<Value, String> {
    let arguments =
        [folder.as_os_str(), plate.as_os_str(), picture.as_ref(), settings.to_string().as_ref()].map(OsStr::to_owned);
    let said = referee::ask("referee_figures.py", &arguments)?;
    Ok(serde_json::from_str(said.lines().last().unwrap_or_default()).unwrap())
}

/// Designs a plate of an example with `flags`, has it judged with `settings`, and demands that both say the same.
/// The referee's figures come back, if there are any.
fn agreed(picture: &str, flags: &[&str], settings: Value) -> Option<Value> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder_of_referee = referee::folder()?;
    let picture = format!("{}/examples/highlights/{picture}.png", root.display());
    let folder = tempfile::tempdir().unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_facetmill"))
        .args(["design", &picture, "--force", "--json", "--rays", &RAYS.to_string(), "-o"])
        .arg(folder.path())
        .args(flags)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    let theirs = match figures(&folder_of_referee, &folder.path().join("plate.stl"), &picture, &settings) {
        Ok(theirs) => theirs,
        Err(why) => {
            referee::skip(&why);
            return None;
        }
    };
    let ours = &report["designed"];
    let pairs = [
        ("TV(1°)", &ours["tv"]["1"], &theirs["tv"], 0.004),
        ("efficiency", &ours["efficiency"], &theirs["efficiency"], 0.006),
        ("multi-bounce share", &ours["multi_bounce"], &theirs["multi_of_up"], 0.003),
        ("blocked share", &ours["blocked"], &theirs["blocked_total"], 0.003),
        ("SSIM(1°)", &ours["ssim"]["1"], &theirs["ssim"], 0.01),
        ("W1, degrees", &ours["w1_deg"], &theirs["w1_deg"], 0.02),
    ];
    for (name, ours, theirs, apart) in pairs {
        let (ours, theirs) = (ours.as_f64().unwrap(), theirs.as_f64().unwrap());
        assert!((ours - theirs).abs() <= apart, "{name} of {picture} {flags:?}: {ours} here, {theirs} at the referee");
    }
    assert!(theirs["backface"].as_f64().unwrap() <= 1e-4, "{theirs}");
    Some(theirs)
}

/// The plain case: light from straight above, 20° of half field, brightness as drawn.
fn plainly_agreed(picture: &str, flags: &str, most: f64) {
    let settings = json!({"projection": "orthographic", "half_field": 20, "rays": RAYS, "mode": "radiance"});
    let Some(theirs) = agreed(picture, &flags.split(' ').collect::<Vec<_>>(), settings) else { return };
    let lost_counts = theirs["tv_incident"].as_f64().unwrap();
    assert!(lost_counts <= most, "TV(1°) of {picture}, lost light counted, is {lost_counts}");
    assert!(theirs["multi_of_up"].as_f64().unwrap() <= 0.001, "{theirs}");
}

#[test]
fn a_ring_shows_as_drawn() {
    plainly_agreed("ring", "--facets 30x30", 0.012);
}

#[test]
fn a_portrait_shows_as_drawn() {
    plainly_agreed("portrait", "--facets 30x30", 0.016);
    plainly_agreed("portrait", "--grid 160", 0.004);
}

#[test]
fn a_letter_of_tall_walls_in_slanting_sunlight_is_seen_alike() {
    let flags = "--arrange random --light 30,70 --light-radius 0.2665 --projection equidistant --half-field 15";
    let flags: Vec<&str> = flags.split(' ').collect();
    let settings = json!({
        "theta": 30, "phi": 70, "radius": 0.2665,
        "projection": "equidistant", "half_field": 15, "rays": RAYS, "mode": "radiance",
    });
    agreed("letter", &flags, settings);
}
