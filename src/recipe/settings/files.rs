//! The settings of files, a part of the table.

use super::Form::{Switch, Text};
use super::table::PLAIN;
use super::{Section, Setting};

/// What is written beside the files of every design.
pub(super) static FILES: &[Setting] = &[FINE, FORMATS, SCENE_FILES];

const FINE: Setting = Setting {
    name: "fine",
    key: "plate.fine",
    form: Switch,
    section: Section::Files,
    help: "Write all triangles of a sheet's grid, in place of fewer where it is smooth: 145 MB in place of 25 to 70",
    more: "Without it a sheet has 500,000 triangles, or as many more as it takes to keep misplaced light within 0.0015 of the \
           whole sheet's at a blur of 1° and within 0.002 at 0.5°, and the likeness at 0.5° within 0.005. With --grid, a \
           lamp or wall nearby or a goal in place of a picture all are written in any case.",
    at: |recipe| &mut recipe.plate.fine,
    ..PLAIN
};

const FORMATS: Setting = Setting {
    name: "also",
    key: "files.also",
    form: Text("FORMATS"),
    section: Section::Files,
    help: "Write the plate in these formats too, with commas between: obj, ply, 3mf, step, tiff",
    more: "plate.obj, plate.ply (binary) and plate.3mf hold the triangles of plate.stl, to the last digit; plate.step each \
           facet and wall as a planar face, of at most 10,000 facets; heightmap.tiff the \
           16-bit heights of heightmap.png with their scale in mm inside.",
    at: |recipe| &mut recipe.files.also,
    ..PLAIN
};

const SCENE_FILES: Setting = Setting {
    name: "scene-files",
    key: "files.scene-files",
    form: Switch,
    section: Section::Files,
    help: "Write plate, lamp and wall or screen for other renderers: scene.xml for Mitsuba 3, scene.glb",
    more: "scene.xml and the scene_*.ply beside it, rendered as they are, show the proof's image: light per pixel over the even \
           share. Lengths are mm; scene.glb is glTF 2.0, in metres.",
    at: |recipe| &mut recipe.files.scene_files,
    ..PLAIN
};
