//! The report of a dry run.

use serde::Serialize;

/// What a design would be; "about" is within a third.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EstimateReport {
    /// True: nothing was designed or written.
    pub dry_run: bool,
    /// The plate with its rim, mm.
    pub plate_mm: [f64; 2],
    /// Sides of a facet, or distance of a sheet's nodes, mm.
    pub pitch_mm: [f64; 2],
    /// What it is made of.
    #[serde(flatten)]
    pub parts: Parts,
    /// Triangles of the file; of a sheet, exact but for its base.
    pub stl_triangles_about: usize,
    /// Size of the file, bytes.
    pub stl_bytes_about: u64,
    /// CPU seconds of the design.
    pub design_cpu_seconds_about: f64,
    /// CPU seconds of the proof; 0 if none is asked for.
    pub verify_cpu_seconds_about: f64,
    /// CPU seconds of the files.
    pub files_cpu_seconds_about: f64,
    /// Bytes of memory at once, at the most.
    pub memory_bytes_about: u64,
    /// Light that no relief keeps from straying, with its cutter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_stray_share: Option<f64>,
}

/// What a plate is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum Parts {
    /// Flat facets.
    Facets {
        /// How many.
        facets: usize,
    },
    /// Cells of a sheet.
    Sheet {
        /// Nodes along a side of a cell.
        grid: usize,
        /// Cells along x and y.
        cells: [usize; 2],
    },
}
