//! What leaves the program: geometry and pictures, made in memory; the caller writes the files.

mod column;

pub mod solid;

pub mod sheet;

pub mod stl;

pub mod picture;

pub mod lettering;

pub mod ticks;

pub mod comparison;

pub mod heightmap;

pub mod shading;
