//! The virtual gonioreflectometer: the whole BRDF of a plate, measured as a machine would
//! (Westin, Arvo, Torrance, "Predicting reflectance functions from complex surfaces", SIGGRAPH 1992).

pub mod axes;

pub mod table;

pub mod sweep;
