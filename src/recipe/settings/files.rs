//! The settings of files, a part of the table.

use super::Form::Text;
use super::table::PLAIN;
use super::{Section, Setting};

/// What is written beside the files of every design.
pub(super) static FILES: &[Setting] = &[Setting {
    name: "also",
    key: "files.also",
    form: Text("FORMATS"),
    section: Section::Files,
    help: "Write the plate in these formats too, with commas between: obj, ply, 3mf, tiff",
    more: "plate.obj, plate.ply (binary) and plate.3mf hold the triangles of plate.stl, to the last digit; heightmap.tiff the \
           16-bit heights of heightmap.png with their scale in mm inside.",
    at: |recipe| &mut recipe.files.also,
    ..PLAIN
}];
