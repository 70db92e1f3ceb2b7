//! The library as its callers see it: known answers, laws of light, closed solids, hostile input.

#[path = "../moves/mod.rs"]
mod moves;
#[path = "../plates/mod.rs"]
mod plates;
#[path = "../shop/mod.rs"]
mod shop;

mod closed_forms;
mod closed_solids;
mod conservation;
mod coupon;
mod fence;
mod field_reports;
mod gcode_programs;
mod hostile_pictures;
mod hostile_rays;
mod jobs;
mod mutants;
mod recognition;
mod sharpening;
mod sheets;
mod swept_programs;
