//! Reliefs in millimetres: planes or triangles over a grid, and the triangles that are written.

pub mod depth;

pub mod rim;

pub mod faceted;

pub mod height_grid;

pub mod periodic;

pub mod open;

pub mod thinned;

pub mod mesh;

mod bisected;

pub mod recognise;

pub mod placement;

pub mod repeats;
