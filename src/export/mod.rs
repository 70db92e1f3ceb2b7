//! What leaves the program: geometry and pictures, made in memory; the caller writes the files.

mod column;

pub mod solid;

pub mod stl;

pub mod picture;

pub mod lettering;

pub mod ticks;

pub mod comparison;

pub mod sights;

pub mod heightmap;

pub mod shading;
