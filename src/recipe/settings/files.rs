//! The settings of files, a part of the table.

use super::Form::{Switch, Text};
use super::table::PLAIN;
use super::{Section, Setting};

/// What is written beside the files of every design.
pub(super) static FILES: &[Setting] = &[FORMATS, SCENE_FILES];

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
