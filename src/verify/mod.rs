//! Proof: how near the light a relief really sends is to the light that was wanted.

pub mod blur;

pub mod wasserstein;

pub mod score;

pub mod lamp;

pub mod tally;

pub mod launch;

mod near;

mod exact;

pub mod measure;

pub mod goniometer;

pub mod microgeometry;

pub mod wall;

pub mod camera;

mod gather;

pub mod look;

pub mod verdict;

pub mod windows;
