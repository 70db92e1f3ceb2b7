//! Continuous reliefs whose light is the picture: one periodic sheet of triangles, optimised as it is written.

pub mod bins;

pub mod bound;

pub mod closing;

pub mod design;

pub mod detail;

pub mod light;

pub mod milled;

pub mod matching;

pub mod objective;

pub mod start;

pub mod target;

pub mod waves;
