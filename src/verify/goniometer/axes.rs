//! The grids of a tabulated BRDF: half vectors under every incident direction of a grid.
//!
//! Lobes of a relief follow its normals, so the table is laid out over half vectors, in the coordinates of Dupuy and
//! Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering" (SIGGRAPH Asia 2018), which
//! are those of Mitsuba's `measured` too: u = sqrt(2θm/π), v = (φm + π)/2π. A table with one azimuth of incidence is
//! isotropic: φm counts from φi there.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use crate::slope::{direction, mirror};

/// Nodes and weights of three-point Gauss-Legendre quadrature on [0, 1].
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 0.277_777_777_777_777_8),
    (0.5, 0.444_444_444_444_444_4),
    (0.887_298_334_620_741_7, 0.277_777_777_777_777_8),
];
/// Samples a side in a cell that the horizon crosses: its area is known to about the inverse square.
const ACROSS_HORIZON: usize = 24;

/// The grids of a [`BrdfTable`](super::table::BrdfTable).
#[derive(Clone, Debug, PartialEq)]
pub struct BrdfAxes {
    pub(super) theta_i: Vec<f64>,
    pub(super) phi_i: Vec<f64>,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl BrdfAxes {
    /// For a plate that looks the same however it is turned about its normal: light from azimuth 0 only, polar angles
    /// `theta_i` (radians, ascending, from 0 up, below π/2), `columns` × `rows` cells over (u, v).
    pub fn isotropic(theta_i: Vec<f64>, columns: usize, rows: usize) -> Result<Self, TableError> {
        Self::checked(theta_i, vec![0.0], columns, rows)
    }

    /// For any plate: as [`BrdfAxes::isotropic`], with light from `azimuths` ≥ 4 azimuths, evenly from -π.
    pub fn anisotropic(theta_i: Vec<f64>, azimuths: usize, columns: usize, rows: usize) -> Result<Self, TableError> {
        if azimuths < 4 {
            return Err(TableError::Azimuths(azimuths));
        }
        let phi_i = (0..azimuths).map(|k| k as f64 / azimuths as f64 * TAU - PI).collect();
        Self::checked(theta_i, phi_i, columns, rows)
    }

    fn checked(theta_i: Vec<f64>, phi_i: Vec<f64>, columns: usize, rows: usize) -> Result<Self, TableError> {
        let rising = theta_i.windows(2).all(|w| w[0] < w[1]);
        if theta_i.len() < 2 || theta_i[0] != 0.0 || !rising || theta_i[theta_i.len() - 1] >= FRAC_PI_2 {
            return Err(TableError::Polar);
        }
        // The file formats count in 32 bits, and four cells are the least that can be interpolated.
        let cells = columns.saturating_mul(rows).saturating_mul(theta_i.len() * phi_i.len());
        if columns < 4 || rows < 4 || cells > u32::MAX as usize {
            return Err(TableError::Cells { columns, rows });
        }
        Ok(Self { theta_i, phi_i, columns, rows })
    }

    /// `count` polar angles from 0 to `last` radians, closer together toward grazing light, where BRDFs change most.
    pub fn polar_nodes(count: usize, last: f64) -> Vec<f64> {
        (0..count).map(|k| last * (1.0 - (1.0 - k as f64 / (count.max(2) - 1) as f64).powf(1.5))).collect()
    }

    /// Polar angles of incidence, radians.
    pub fn theta_i(&self) -> &[f64] {
        &self.theta_i
    }

    /// Azimuths of incidence, radians, from -π; a single 0 if the table is isotropic.
    pub fn phi_i(&self) -> &[f64] {
        &self.phi_i
    }

    /// Cells along u, the polar angle of half vectors.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Cells along v, the azimuth of half vectors.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Whether φm counts from φi.
    pub fn is_isotropic(&self) -> bool {
        self.phi_i.len() == 1
    }

    /// Incident directions: slice k has polar angle k mod `theta_i().len()` and azimuth k div it.
    pub fn slices(&self) -> usize {
        self.theta_i.len() * self.phi_i.len()
    }

    /// Cells of one slice, numbered column + `columns` · row.
    pub fn cells(&self) -> usize {
        self.columns * self.rows
    }

    /// (θi, φi) of a slice, radians.
    pub fn incident_angles(&self, slice: usize) -> (f64, f64) {
        (self.theta_i[slice % self.theta_i.len()], self.phi_i[slice / self.theta_i.len()])
    }

    /// The direction toward the light of a slice.
    pub fn incident(&self, slice: usize) -> DVec3 {
        let (theta, phi) = self.incident_angles(slice);
        direction(theta, phi)
    }

    /// The half vector at (u, v) under the light of a slice.
    pub(crate) fn half_vector(&self, slice: usize, u: f64, v: f64) -> DVec3 {
        let turn = if self.is_isotropic() { self.incident_angles(slice).1 } else { 0.0 };
        direction(FRAC_PI_2 * u * u, TAU * v - PI + turn)
    }

    /// Where the half vector of light toward `wi` and viewer toward `wo` (both above the plate) lies, u and v in [0, 1].
    pub fn coordinates(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        let m = (wi + wo).normalize_or(DVec3::Z);
        // Twice the arc sine of half the chord keeps small angles exact.
        let theta = 2.0 * (0.5 * (m - DVec3::Z).length()).min(1.0).asin();
        let turn = if self.is_isotropic() { wi.y.atan2(wi.x) } else { 0.0 };
        let v = ((m.y.atan2(m.x) - turn + PI) / TAU).rem_euclid(1.0);
        ((theta / FRAC_PI_2).sqrt().min(1.0), v)
    }

    /// The cell that light of a slice falls into when it leaves toward `wo`; `None` if that is not above the plate.
    pub fn cell(&self, slice: usize, wo: DVec3) -> Option<usize> {
        self.cell_under(self.incident(slice), wo)
    }

    /// As [`cell`](Self::cell), for light toward `wi`.
    pub(crate) fn cell_under(&self, wi: DVec3, wo: DVec3) -> Option<usize> {
        // A viewer that is no direction is not above the plate either.
        if wo.z.is_nan() || wo.z <= 0.0 {
            return None;
        }
        let (u, v) = self.coordinates(wi, wo);
        let column = ((u * self.columns as f64) as usize).min(self.columns - 1);
        let row = ((v * self.rows as f64) as usize).min(self.rows - 1);
        Some(column + self.columns * row)
    }

    /// Visits points of a cell, each with its share of ∫ cosθo dωo above the horizon (positive), in a fixed order.
    pub(super) fn quadrature(&self, slice: usize, cell: usize, mut visit: impl FnMut(DVec3, f64)) {
        let (column, row) = (cell % self.columns, cell / self.columns);
        let l = self.incident(slice);
        let edge = |k: usize| FRAC_PI_2 * (k as f64 / self.columns as f64).powi(2);
        let (near, far) = (edge(column), edge(column + 1));
        // Over equal steps of 1 - cosθ solid angles are equal; 2 sin² keeps small ones exact.
        let lift = |theta: f64| 2.0 * (0.5 * theta).sin().powi(2);
        let (low, high) = (lift(near), lift(far));
        let solid_angle = (high - low) * TAU / self.rows as f64;
        let at = |s: f64, t: f64| {
            let lift = low + s * (high - low);
            let theta = 2.0 * (0.5 * lift).sqrt().min(1.0).asin();
            let m = self.half_vector(slice, (theta / FRAC_PI_2).sqrt(), (row as f64 + t) / self.rows as f64);
            let o = mirror(l, m);
            (o, 4.0 * l.dot(m) * o.z)
        };
        let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.5)].map(|(s, t)| at(s, t));
        if corners.iter().all(|(o, weight)| o.z > 0.0 && *weight > 0.0) {
            for (s, ws) in GAUSS {
                for (t, wt) in GAUSS {
                    let (o, weight) = at(s, t);
                    visit(o, weight * ws * wt * solid_angle);
                }
            }
            return;
        }
        // From well below it no part of a cell reaches above the horizon: o.z changes by less than 2 |dm|.
        let reach = 2.0 * (far - near + TAU / self.rows as f64);
        if corners.iter().all(|(o, _)| o.z < -reach) {
            return;
        }
        let n = ACROSS_HORIZON;
        for i in 0..n * n {
            let (o, weight) = at(((i % n) as f64 + 0.5) / n as f64, ((i / n) as f64 + 0.5) / n as f64);
            if o.z > 0.0 && weight > 0.0 {
                visit(o, weight * solid_angle / (n * n) as f64);
            }
        }
    }

    /// ∫ cosθo dωo over the part of a cell above the horizon: its flux under a BRDF of 1/sr. Zero if there is none.
    pub(crate) fn projected(&self, slice: usize, cell: usize) -> f64 {
        let mut sum = 0.0;
        self.quadrature(slice, cell, |_, weight| sum += weight);
        sum
    }

    /// [`projected`](Self::projected) of all cells of all slices.
    pub(super) fn all_projected(&self) -> Vec<f32> {
        let (cells, polar) = (self.cells(), self.theta_i.len());
        let turns = self.phi_i.len();
        // Light turned by whole rows: the same numbers, so many rows on.
        let turned = self.rows.is_multiple_of(turns);
        let known = if turned { polar } else { self.slices() };
        let mut all: Vec<f32> = (0..known * cells)
            .into_par_iter()
            .map(|index| self.projected(index / cells, index % cells) as f32)
            .collect();
        for slice in known..self.slices() {
            let shift = (slice / polar) * (self.rows / turns) * self.columns;
            let first = slice % polar * cells;
            all.extend_from_within(first + cells - shift..first + cells);
            all.extend_from_within(first..first + cells - shift);
        }
        all
    }
}

/// Why a table cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// The polar axis is not one.
    #[error("the polar angles of incidence must rise from 0 to less than 90 degrees, two of them at least")]
    Polar,
    /// Too few azimuths to be interpolated.
    #[error("a BRDF that turns with the plate needs 4 azimuths of incidence or more, not {0}")]
    Azimuths(usize),
    /// A grid too small or too large.
    #[error("a BRDF table needs 4 to some thousand cells each way, not {columns} x {rows}")]
    Cells {
        /// Cells along u.
        columns: usize,
        /// Cells along v.
        rows: usize,
    },
    /// Numbers that do not belong to the table.
    #[error("the counted light does not have one share and one error for each cell of the table")]
    Shape,
    /// NaN or infinity among the counts.
    #[error("a share of the counted light is not a finite number")]
    NotFinite,
}
