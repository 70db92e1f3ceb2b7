//! facetmill turns a drawn highlight into a relief that can be milled and that really reflects it.
//!
//! The modules below stand in reading order, and each imports only from those above it.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod progress;

pub mod fourier;

pub mod descent;

pub mod slope;

pub mod projection;

pub mod setup;

pub mod raster;

pub mod picture;

pub mod highlight;

pub mod distribution;

pub mod facets;

pub mod relief;

pub mod trace;

pub mod verify;

pub mod export;

pub mod recipe;
