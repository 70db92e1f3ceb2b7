//! A test piece that tells what a machine does to a surface: fields that are cut and half of them polished, and what is
//! read from them afterwards.
//!
//! All passes go along x. Along each of them lie level places that the tip comes to from above and from below, ramps, and a
//! half that is to be polished; across them lie bands of passes: far apart one way, far apart to and fro, closer by steps,
//! and two domes. A line across the passes meets the groove of every one of them. Heights of the grooves' bottoms tell
//! scatter, from above and below play, the grooves' shape the cutter's tip, and what is left of them in the polished half
//! the polish.

// In reading order: each imports only from those above it.

pub mod layout;

pub mod scan;

mod least_squares;

pub mod groove;

pub mod lines;

mod told;

pub use told::Told;

mod polished;

pub mod findings;

mod corners;

mod fields;

mod stripes;

pub mod photograph;

pub mod dry_run;

pub mod dry_photo;
