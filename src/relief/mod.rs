//! Reliefs in millimetres: planes over a grid, and the triangles that are written.

pub mod faceted;

pub mod periodic;

pub mod mesh;
