//! The settings of chance and proof, a part of the table.

use super::Form::Text;
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
