//! The settings of a lamp and a wall nearby, a part of the table.

use super::Form::{Table, Text, Words};
use super::table::PLAIN;
use super::{Section, Setting, Unit, Word};

/// Lengths that a scene may have, mm.
const LENGTHS: &[[f64; 2]] = &[[1e-3, 1e9]];

const LENGTH: Setting =
    Setting { form: Text("MM"), unit: Unit::Millimetres, section: Section::Scene, ranges: LENGTHS, ..PLAIN };

const fn word(word: &'static str, help: &'static str) -> Word {
    Word { word, before: None, help }
}

/// Lamp, wall and picture at distances in mm.
pub(super) const SCENE: [Setting; 10] = [
    Setting {
        name: "lamp-distance",
        key: "scene.lamp-distance",
        unset: "endlessly far",
        help: "From the plate's middle to the lamp, mm; --light says in which direction",
        more: "Lamps and walls nearer than some 400 plate sides need a design that knows them: 12 m for a plate of 30 mm. \
               With a lamp or a wall the picture is what its light draws on the wall, as in a room: screen, flux and \
               on-wall are implied.",
        at: |recipe| &mut recipe.scene.lamp_distance,
        ..LENGTH
    },
    Setting {
        name: "lamp-at",
        key: "scene.lamp-at",
        form: Text("X,Y,Z"),
        ranges: &[[-1e9, 1e9]],
        help: "The lamp, mm along the plate's x, y and z from its middle; in place of --light and --lamp-distance",
        at: |recipe| &mut recipe.scene.lamp_at,
        ..LENGTH
    },
    Setting {
        name: "lamp-radius",
        key: "scene.lamp-radius",
        unset: "0, a point",
        help: "Radius of the lamp nearby, mm; the design sharpens against it",
        at: |recipe| &mut recipe.scene.lamp_radius,
        ..LENGTH
    },
    Setting {
        name: "wall",
        key: "scene.wall",
        unset: "endlessly far",
        help: "From the plate's middle to the wall along the direction in which a flat plate mirrors the light, mm",
        more: "The wall stands across that direction unless --wall-tilt turns it; any other pose by --scene.",
        at: |recipe| &mut recipe.scene.wall,
        ..LENGTH
    },
    Setting {
        name: "wall-tilt",
        key: "scene.wall-tilt",
        form: Text("DEG"),
        unit: Unit::Degrees,
        ranges: &[[-85.0, 85.0]],
        unset: "0",
        help: "Turn of the wall about its horizontal axis, its upper edge away from the plate, degrees",
        at: |recipe| &mut recipe.scene.wall_tilt,
        ..LENGTH
    },
    Setting {
        name: "picture-width",
        key: "scene.picture-width",
        unset: "as --half-field says",
        help: "Width of the drawing on the wall, mm, before it is padded to a square",
        at: |recipe| &mut recipe.scene.picture_width,
        ..LENGTH
    },
    Setting {
        name: "focus",
        key: "scene.focus",
        help: "A bowl of this focal length under a far design, mm: for a sun and a wall that far away",
        more: "1/f = 1/lamp + 1/wall: the same plate serves a lamp 1 m and a wall 1 m away, and the sun and a wall at \
               0.5 m, for f = 500.",
        at: |recipe| &mut recipe.scene.focus,
        ..LENGTH
    },
    Setting {
        name: "near",
        key: "scene.near",
        form: Words(
            "HOW",
            &[
                word("base", "A far design on a bowl that sends the lamp to the picture"),
                word("warp", "Its cells warped too"),
                word("exact", "A descent over the whole plate, each triangle's light where it lands"),
            ],
        ),
        unit: Unit::None,
        ranges: &[],
        unset: "exact; base where it misses by less than 0.05 degrees",
        help: "How the design follows lamp and wall",
        at: |recipe| &mut recipe.scene.near,
        ..LENGTH
    },
    Setting {
        name: "scene",
        key: "scene.room",
        form: Table,
        unit: Unit::None,
        ranges: &[],
        help: "Plate, lamp, wall and picture in the room's own coordinates",
        at: |recipe| &mut recipe.scene.room,
        ..LENGTH
    },
    Setting {
        name: "drawing",
        key: "scene.drawing",
        form: Table,
        unit: Unit::None,
        ranges: &[],
        help: "Columns and rows of the drawing, noted when it was read",
        at: |recipe| &mut recipe.scene.drawing,
        ..LENGTH
    },
];
