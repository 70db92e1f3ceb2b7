//! The report of a dry run.

use serde::Serialize;

/// What a design would be; "about" is within a half: times from two thirds to one and a half.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EstimateReport {
    /// True: nothing was designed or written.
    pub dry_run: bool,
    /// The plate with its rim, mm.
    pub plate_mm: [f64; 2],
    /// Sides of a facet, or distance of nodes, mm.
    pub pitch_mm: [f64; 2],
    /// What it is made of.
    #[serde(flatten)]
    pub parts: Parts,
    /// Triangles of the file; of a sheet, exact but for its base.
    pub stl_triangles_about: usize,
    /// Size of the file, bytes.
    pub stl_bytes_about: u64,
    /// CPU seconds of the design, on this machine.
    pub design_cpu_seconds_about: f64,
    /// CPU seconds of the proof; 0 if none is asked for.
    pub verify_cpu_seconds_about: f64,
    /// CPU seconds on top of the proof, should a sheet misplace so much light that it is compared with facets; 0 of facets.
    pub comparison_cpu_seconds_about: f64,
    /// CPU seconds of the files.
    pub files_cpu_seconds_about: f64,
    /// Seconds from beginning to end, if nothing else runs beside it.
    pub wall_seconds_about: f64,
    /// Threads that share the work.
    pub threads: usize,
    /// How many times as fast a thread is as one of the machine on which times were measured, as it was a moment ago.
    pub machine_speed: f64,
    /// Bytes of memory at once, at the most.
    pub memory_bytes_about: u64,
    /// Light that no relief keeps from straying, with its cutter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_stray_share: Option<f64>,
}

impl EstimateReport {
    /// The same on `threads` of a machine that is `speed` times as fast as the one on which times were measured.
    pub fn on_machine(self, speed: f64, threads: usize) -> Self {
        let times = self.machine_speed / speed;
        let report = Self {
            design_cpu_seconds_about: times * self.design_cpu_seconds_about,
            verify_cpu_seconds_about: times * self.verify_cpu_seconds_about,
            comparison_cpu_seconds_about: times * self.comparison_cpu_seconds_about,
            files_cpu_seconds_about: times * self.files_cpu_seconds_about,
            machine_speed: speed,
            threads,
            ..self
        };
        Self { wall_seconds_about: report.wall_seconds(), ..report }
    }

    /// CPU seconds of all of it but the comparison.
    pub fn cpu_seconds(&self) -> f64 {
        self.design_cpu_seconds_about + self.verify_cpu_seconds_about + self.files_cpu_seconds_about
    }

    /// Design and proof are shared out among threads; files are written by one.
    fn wall_seconds(&self) -> f64 {
        (self.design_cpu_seconds_about + self.verify_cpu_seconds_about) / self.threads as f64
            + self.files_cpu_seconds_about
    }
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
    /// Patches of a plate that is seen as a picture.
    Patches {
        /// How many along x and y.
        patches: [usize; 2],
        /// Distances of nodes along a side of a patch.
        grid: usize,
    },
}
