//! The settings of making, a part of the table.

use super::Form::{Switch, Switches, Table, Text};
use super::table::PLAIN;
use super::{Section, Setting, Unit, Word};
use crate::cutter::library::WIDEST_WEAR;
use crate::milling::made::LEAST_STEPOVER;

const MACHINING: Setting = Setting { section: Section::Machining, ..PLAIN };
const OF_CUTTER: Setting = Setting { section: Section::Design, form: Text("MM"), unit: Unit::Millimetres, ..PLAIN };

/// Cutter, machine and passes.
pub(super) const MAKING: [Setting; 9] = [
    Setting {
        name: "flutes",
        key: "design.flutes",
        ranges: &[[0.01, 1000.0]],
        unset: "as sold, if the cutter is named",
        help: "How deep the cutter can go, mm: its teeth's length, or its neck's; deeper reliefs are refused",
        at: |recipe| &mut recipe.design.flutes,
        ..OF_CUTTER
    },
    Setting {
        name: "worn-tip",
        key: "design.worn-tip",
        ranges: &[[0.0, WIDEST_WEAR]],
        unset: "of the cutter that is named",
        help: "Diameter of the flat that wear leaves on the cutter's tip, mm; it counts with --worn",
        at: |recipe| &mut recipe.design.worn_tip,
        ..OF_CUTTER
    },
    Setting {
        name: "worn",
        key: "machining.worn",
        form: Switch,
        help: "Make it with a worn cutter: the flat that wear leaves on its tip is in the surface as made",
        at: |recipe| &mut recipe.machining.worn,
        ..MACHINING
    },
    Setting {
        name: "machine",
        key: "machining.machine",
        form: Table,
        help: "The machine that makes the plate: a name, or a table of its values",
        at: |recipe| &mut recipe.machining.machine,
        ..MACHINING
    },
    Setting {
        name: "stepover",
        key: "machining.stepover",
        form: Text("MM"),
        unit: Unit::Millimetres,
        ranges: &[[LEAST_STEPOVER, 50.0]],
        unset: "what the polish takes away, else a fiftieth of the cutter",
        help: "From one pass to the next, mm",
        more: "Twice the polish leaves nothing of the cusps between passes; without polish passes w apart with a ball of \
               radius R spread slopes by w/2R either way, and light by twice that.",
        at: |recipe| &mut recipe.machining.stepover,
        ..MACHINING
    },
    Setting {
        name: "pass-angle",
        key: "machining.pass-angle",
        form: Text("DEG|best"),
        unit: Unit::Degrees,
        ranges: &[[-360.0, 360.0]],
        unset: "0",
        help: "Direction of the passes, degrees from +x toward +y, or best",
        more: "best: of twelve directions the one in which cusps between passes misplace least of the drawing's light, which \
               they spread across the passes; along x where none is better by 3 %. The recipe keeps the degrees.",
        at: |recipe| &mut recipe.machining.pass_angle,
        ..MACHINING
    },
    Setting {
        name: "pass-order",
        key: "machining.pass-order",
        form: Switches(&[
            Word { word: "one-way", before: None, help: "Cut all passes from the same side  [default]" },
            Word {
                word: "zigzag",
                before: None,
                help: "Cut every other pass on the way back: a quarter faster, and as rough as the machine's play",
            },
        ]),
        unset: "one-way",
        help: "Which way passes are cut",
        at: |recipe| &mut recipe.machining.pass_order,
        ..MACHINING
    },
    Setting {
        name: "draws",
        key: "machining.draws",
        form: Text("N"),
        ranges: &[[1.0, 100.0]],
        unset: "1",
        help: "Plates that are proved, each with other random errors of the machine; the first is shown",
        at: |recipe| &mut recipe.machining.draws,
        ..MACHINING
    },
    Setting {
        name: "as-made-stl",
        key: "machining.as-made-stl",
        form: Switch,
        help: "Write the surface as made and polished to as-made.stl too, closed, its nodes half the polish apart",
        at: |recipe| &mut recipe.machining.as_made_stl,
        ..MACHINING
    },
];
