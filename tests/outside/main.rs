//! What programs of others say of our files. Where one of them is not installed its tests are skipped, visibly; with
//! FACETMILL_REQUIRE_CHECKERS=1 that is a failure.

#[path = "../moves/mod.rs"]
mod moves;
#[path = "../plates/mod.rs"]
mod plates;
#[path = "../shop/mod.rs"]
mod shop;

mod asking;
mod files_read;
mod linuxcnc;
mod looks;
mod machined;
mod mesh_checkers;
mod pygcode;
mod referee;
mod referee_figures;
mod renderer;
mod scenes;
mod step_read;
mod stl_light;
mod ztests;
