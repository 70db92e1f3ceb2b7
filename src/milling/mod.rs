//! Milling as machines do it: where a cutter's tip stands over the triangles that are written, how a machine follows that,
//! and the surface that is left.

pub mod machine;

pub(crate) mod random;

pub mod polish;

pub mod tip;

mod track;

pub mod passes;

mod sweep;

pub mod made;

pub mod swept;

pub mod roughing;
