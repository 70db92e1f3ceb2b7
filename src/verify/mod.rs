//! Proof: how near the light a relief really sends is to the light that was wanted.

pub mod blur;

pub mod score;

pub mod tally;

pub mod wasserstein;

pub mod experiment;

mod ray_grid;

mod follow;

mod first_bounce;

pub mod measure;

pub mod goniometer;

pub mod microgeometry;

pub mod thrown;

pub mod wall;

pub mod camera;

mod path_tracer;

pub mod render;

pub mod patch_view;

pub mod verdict;

pub mod rim;

pub mod wall_verdict;

pub mod elsewhere;

pub mod windows;
