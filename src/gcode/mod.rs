//! G-code: programs of any origin read and judged, and our own written.
//!
//! ```
//! use facetmill::gcode::read::read;
//! use facetmill::gcode::check::extent;
//!
//! let read = read(b"G21 G90 G0 Z5\nX0 Y0 S10000 M3\nG1 Z-0.1 F200\nG2 X10 I5\nG0 Z5\nM2\n", None).unwrap();
//! assert!(read.faults.is_empty() && read.notes.is_empty());
//! assert!((extent(&read.program).cuts.unwrap().high.y - 5.0).abs() < 1e-12);
//! ```

// In reading order: each imports only from those above it.

pub mod dialect;

pub mod arc;

mod words;

mod block;

pub mod findings;

pub mod program;

mod seal;

pub mod read;

pub mod reduce;

pub mod timing;

pub mod check;

pub mod write;

pub use block::{BlockFault, PathControl};
pub use words::WordFault;
