//! The settings of chance and proof, a part of the table.

use super::Form::{Switch, Text};
use super::table::PLAIN;
use super::{Section, Setting, Unit};

const COUNT: Setting = Setting { form: Text("N"), section: Section::Running, ..PLAIN };
const LENGTH: Setting = Setting { form: Text("MM"), unit: Unit::Millimetres, section: Section::Running, ..PLAIN };

/// What is drawn at random, how much light is sent, and who looks.
pub(super) static RUNNING: &[Setting] = &[
    Setting {
        name: "seed",
        key: "design.seed",
        section: Section::Design,
        // What TOML can write back.
        ranges: &[[0.0, 9.2e18]],
        help: "Seed of everything random",
        at: |recipe| &mut recipe.design.seed,
        ..COUNT
    },
    Setting {
        name: "preview",
        key: "design.preview",
        section: Section::Design,
        form: Switch,
        help: "Look at it quickly: a sheet on few nodes by few steps, no plate to be made",
        more: "Its light is that of the first bounce, known without rays. No cutter is followed over it, and nothing is \
               compared. Its verdict and its report say that it is a preview.",
        at: |recipe| &mut recipe.design.sheet.preview,
        ..PLAIN
    },
    Setting {
        name: "rays",
        key: "verify.rays",
        ranges: &[[1000.0, 1e11]],
        help: "Rays sent over the plate",
        at: |recipe| &mut recipe.verify.rays,
        ..COUNT
    },
    Setting {
        name: "eye-distance",
        key: "verify.eye-distance",
        ranges: &[[100.0, 1e6]],
        unset: "3000",
        help: "From the eye to a wall nearby, mm: how finely its picture is looked at",
        more: "An eye resolves 2.3 minutes of arc: 2 mm from 3 m.",
        at: |recipe| &mut recipe.verify.eye_distance,
        ..LENGTH
    },
];
