//! facetmill turns a drawn highlight into a relief that can be milled and that really reflects it.
//!
//! The modules below stand in reading order, and each imports only from those above it.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod progress;

pub mod slope;

pub mod projection;

pub mod setup;

pub mod raster;

pub mod highlight;

pub mod distribution;

pub mod relief;
