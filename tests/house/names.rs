//! Words that the sources no longer use as names: each has a standard term in its place.

use crate::none;
use crate::source::{identifiers, sources};

/// Old names as whole identifiers, anywhere in `src`, and the term in their place.
const OLD: [(&str, &str); 35] = [
    ("Bins", "slope histogram"),
    ("Rims", "edge slopes"),
    ("Folds", "concave edges"),
    ("toll", "penalty, weight"),
    ("Toll", "penalty, weight"),
    ("shine", "forward"),
    ("Gaze", "scale of the loss"),
    ("gaze", "scale of the loss"),
    ("Making", "manufacturing model"),
    ("Made", "as milled"),
    ("watch_tool", "tool residual"),
    ("tooled", "tool residual"),
    ("Mote", "weighted slope"),
    ("mote", "weighted slope"),
    ("motes", "weighted slopes"),
    ("Glint", "light of a triangle"),
    ("glint", "light of a triangle"),
    ("Waypoint", "checkpoint"),
    ("waypoint", "checkpoint"),
    ("design_by_way", "design with checkpoints"),
    ("Waves", "periodic filter"),
    ("Sculpture", "sheet"),
    ("sculpture", "sheet"),
    ("Sight", "rendered view"),
    ("Sights", "rendered views"),
    ("sight", "rendered view"),
    ("sights", "rendered views"),
    ("Look", "rendered view"),
    ("Looking", "settings of a view"),
    ("Gatherer", "path tracer"),
    ("Throw", "settings of a wall"),
    ("Thrown", "image on a wall"),
    ("levelling", "polish"),
    ("Levelling", "polish"),
    ("ashore", "snap"),
];

/// Words that mean something else elsewhere.
const OLD_IN_SCULPT: [(&str, &str); 9] = [
    ("lay", "splat"),
    ("rims", "edge slopes"),
    ("folds", "concave edges"),
    ("charge", "penalty, weight"),
    ("price", "penalty, weight"),
    ("pull", "gradient"),
    ("answer", "adjoint"),
    ("passed", "on_step"),
    ("making", "manufacturing model"),
];

#[test]
fn no_identifier_is_an_old_name() {
    let mut offences = Vec::new();
    for file in sources() {
        for (at, name) in identifiers(&file.code) {
            let sculpt: &[_] = if file.path.starts_with("src/sculpt/") { &OLD_IN_SCULPT } else { &[] };
            if let Some((_, new)) = OLD.iter().chain(sculpt).find(|(old, _)| *old == name) {
                offences.push(format!("{}:{}: {name}, now {new}", file.path, file.line(at)));
            }
        }
    }
    none(offences);
}

/// A catch-all says nothing of what it holds.
#[test]
fn no_module_is_named_after_nothing() {
    for file in sources() {
        let stem = file.path.rsplit('/').next().unwrap();
        assert!(!["utils.rs", "util.rs", "common.rs", "types.rs", "helpers.rs", "misc.rs"].contains(&stem), "{stem}");
    }
}
