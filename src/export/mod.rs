//! What leaves the program: geometry and pictures, made in memory; the caller writes the files.

mod column;

pub mod solid;

pub mod sheet;

pub mod stl;

pub mod obj;

pub mod ply;

#[cfg(feature = "meshes")]
pub mod three_mf;

pub mod step;

pub mod mesh_files;

pub mod scene_files;

pub mod pixels;

pub mod lettering;

mod stroke;

mod page;

pub mod ticks;

mod axes;

pub mod comparison;

pub mod float_tiff;

pub mod rendered_view;

pub mod patch_page;

pub mod heightmap;

pub mod shading;

pub mod bsdf;

pub mod merl;

pub mod brdf_csv;

pub mod polar_slices;

pub mod hemisphere_maps;

pub mod plan_chart;
