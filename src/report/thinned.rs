//! What is said of a sheet in fewer triangles than its grid has.

use serde::Serialize;

/// The thinned sheet beside the whole one; misplaced light by first bounces, as made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThinnedFacts {
    /// Triangles of the whole one's file.
    pub whole_triangles: usize,
    /// Size of that file, bytes.
    pub whole_bytes: u64,
    /// Misplaced light of the whole one at a blur of 1°.
    pub tv_incident_1deg_of_whole: f64,
    /// The same, counted in the same way, of the file that there is.
    pub tv_incident_1deg_of_this: f64,
    /// Whether misplaced light at 1° is within 0.0015 of the whole one's, at 0.5° within 0.002, likeness there within 0.005; on
    /// a wall likeness at the eye's blur within 0.01.
    pub within_limits: bool,
}
