//! Continuous reliefs whose light is the picture: one periodic sheet of triangles, optimised as it is written.

pub mod rims;

pub mod waves;

pub mod start;

pub mod target;

pub mod bound;

pub mod detail;

pub mod bins;

pub mod closing;

pub mod resample;

pub mod milled;

pub mod milled_plate;

pub mod matching;

pub mod folds;

pub mod light;

pub mod objective;

pub mod plan;

pub mod waypoint;

pub mod design;
