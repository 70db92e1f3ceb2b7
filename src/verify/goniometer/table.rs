//! A tabulated BRDF on the grids of [`BrdfAxes`].
//!
//! A cell holds ∫ f_r cosθo dωo / ∫ cosθo dωo over the outgoing directions of its half vectors, the mean that a flux
//! counter can know, with dωo = 4 (l·m) dωm. Where a cell straddles the horizon only the part above it counts; a cell
//! whose every half vector sends light into the plate holds nothing (NaN).

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

pub use super::axes::{BrdfAxes, TableError};
use crate::slope::{mirror, polar_angle};

/// A BRDF measured or computed on a grid; 12 bytes a cell. One wavelength: colour takes three tables on the same axes.
#[derive(Clone, Debug, PartialEq)]
pub struct BrdfTable {
    axes: BrdfAxes,
    mean: Vec<f32>,
    error: Vec<f32>,
    /// [`BrdfAxes::projected`] of every cell.
    projected: Vec<f32>,
}

impl BrdfTable {
    /// A table that holds nothing yet (NaN everywhere), to be filled with [`BrdfTable::set_flux`].
    pub fn new(axes: BrdfAxes) -> Self {
        let cells = axes.slices() * axes.cells();
        let projected = axes.all_projected();
        Self { axes, mean: vec![f32::NAN; cells], error: vec![0.0; cells], projected }
    }

    /// The table of an analytic BRDF `f(wi, wo)` in 1/sr, both unit vectors away from the plate; errors are 0.
    pub fn from_fn(axes: BrdfAxes, f: impl Fn(DVec3, DVec3) -> f64 + Sync) -> Self {
        let mut table = Self::new(axes);
        let (axes, cells) = (&table.axes, table.axes.cells());
        table.mean.par_iter_mut().enumerate().for_each(|(i, mean)| {
            let (slice, cell) = (i / cells, i % cells);
            let l = axes.incident(slice);
            let (mut flux, mut whole) = (0.0, 0.0);
            axes.quadrature(slice, cell, |o, weight| {
                flux += weight * f(l, o);
                whole += weight;
            });
            *mean = if whole > 0.0 { (flux / whole) as f32 } else { f32::NAN };
        });
        table
    }

    /// Fills one slice from counted light: for each cell the share of the light arriving on the plate that leaves
    /// through it, and the standard error of that share. Fails on wrong lengths and on what is not finite.
    ///
    /// What [`BrdfAxes::cell`] files under a cell that the quadrature finds wholly below the horizon (a sliver less
    /// than 1/500 of it reaches above) is light the table cannot hold; its share is returned.
    pub fn set_flux(&mut self, slice: usize, share: &[f64], error: &[f64]) -> Result<f64, TableError> {
        let cells = self.axes.cells();
        if slice >= self.axes.slices() || share.len() != cells || error.len() != cells {
            return Err(TableError::Shape);
        }
        if share.iter().chain(error).any(|v| !v.is_finite()) {
            return Err(TableError::NotFinite);
        }
        let mut lost = 0.0;
        for cell in 0..cells {
            let at = slice * cells + cell;
            let whole = f64::from(self.projected[at]);
            if whole > 0.0 {
                self.mean[at] = (share[cell] / whole) as f32;
                self.error[at] = (error[cell] / whole) as f32;
            } else {
                (self.mean[at], self.error[at]) = (f32::NAN, 0.0);
                lost += share[cell];
            }
        }
        Ok(lost)
    }

    /// The grids.
    pub fn axes(&self) -> &BrdfAxes {
        &self.axes
    }

    /// [`BrdfAxes::projected`] of every cell of a slice.
    pub(crate) fn slice_projected(&self, slice: usize) -> &[f32] {
        &self.projected[slice * self.axes.cells()..][..self.axes.cells()]
    }

    /// Mean BRDF of every cell of a slice, 1/sr; NaN where no light can leave.
    pub fn slice(&self, slice: usize) -> &[f32] {
        &self.mean[slice * self.axes.cells()..][..self.axes.cells()]
    }

    /// Standard error of every cell of a slice, 1/sr.
    pub(crate) fn slice_error(&self, slice: usize) -> &[f32] {
        &self.error[slice * self.axes.cells()..][..self.axes.cells()]
    }

    /// Bilinear between cell centres of one slice, v around the circle; cells that hold nothing are left out.
    pub(crate) fn within_slice(&self, slice: usize, u: f64, v: f64) -> Option<f64> {
        let (columns, rows) = (self.axes.columns, self.axes.rows);
        let x = (u * columns as f64 - 0.5).clamp(0.0, (columns - 1) as f64);
        let y = v * rows as f64 - 0.5;
        let (left, below) = ((x as usize).min(columns - 2), y.floor());
        let (s, t) = (x - left as f64, y - below);
        let row = |k: f64| k.rem_euclid(rows as f64) as usize % rows;
        let values = self.slice(slice);
        let (mut sum, mut whole) = (0.0, 0.0);
        for (row, wt) in [(row(below), 1.0 - t), (row(below + 1.0), t)] {
            for (column, ws) in [(left, 1.0 - s), (left + 1, s)] {
                let value = f64::from(values[column + columns * row]);
                if !value.is_nan() {
                    sum += ws * wt * value;
                    whole += ws * wt;
                }
            }
        }
        (whole > 0.0).then(|| sum / whole)
    }

    /// The BRDF in 1/sr for light from `wi` seen from `wo`, unit vectors; 0 where either is not above the plate.
    ///
    /// Linear between incident directions in f_r cosθi, which stays finite where f_r does not; beyond the last polar
    /// angle the last slice holds.
    pub fn at(&self, wi: DVec3, wo: DVec3) -> f64 {
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return 0.0;
        }
        let (u, v) = self.axes.coordinates(wi, wo);
        let nodes = &self.axes.theta_i;
        let theta = polar_angle(wi).min(nodes[nodes.len() - 1]);
        let low = nodes.partition_point(|n| *n <= theta).clamp(1, nodes.len() - 1) - 1;
        let t = (theta - nodes[low]) / (nodes[low + 1] - nodes[low]);
        let azimuths = self.axes.phi_i.len();
        let around = if azimuths == 1 { 0.0 } else { (wi.y.atan2(wi.x) + PI) / TAU * azimuths as f64 };
        let (before, s) = (around.floor() as usize % azimuths, around - around.floor());
        let (mut sum, mut whole) = (0.0, 0.0);
        for (azimuth, ws) in [(before, 1.0 - s), ((before + 1) % azimuths, s)] {
            for (polar, wt) in [(low, 1.0 - t), (low + 1, t)] {
                let weight = ws * wt;
                if weight <= 0.0 {
                    continue;
                }
                if let Some(value) = self.within_slice(azimuth * nodes.len() + polar, u, v) {
                    sum += weight * value * nodes[polar].cos();
                    whole += weight;
                }
            }
        }
        if whole > 0.0 { sum / whole / theta.cos() } else { 0.0 }
    }

    /// Share of the light from a slice's direction that leaves, and its standard error.
    pub fn albedo(&self, slice: usize) -> (f64, f64) {
        let (mean, error) = (self.slice(slice), self.slice_error(slice));
        let parts: Vec<(f64, f64)> = (0..self.axes.cells())
            .into_par_iter()
            .filter(|&cell| !mean[cell].is_nan())
            .map(|cell| {
                let whole = f64::from(self.slice_projected(slice)[cell]);
                (f64::from(mean[cell]) * whole, (f64::from(error[cell]) * whole).powi(2))
            })
            .collect();
        let (flux, variance) = parts.iter().fold((0.0, 0.0), |a, p| (a.0 + p.0, a.1 + p.1));
        (flux, variance.sqrt())
    }

    /// How far f(wi, wo) and f(wo, wi) are apart: the mean of |difference| over the mean of f, each cell weighted with
    /// its flux. The other way round is interpolated, so that noise and the coarseness of the grid show here too.
    ///
    /// Light that leaves beyond the last polar angle of incidence has no counterpart and is left out.
    pub fn reciprocity_error(&self) -> f64 {
        let last = self.axes.theta_i[self.axes.theta_i.len() - 1].cos();
        let per_slice: Vec<(f64, f64)> = (0..self.axes.slices())
            .into_par_iter()
            .map(|slice| {
                let (l, cells) = (self.axes.incident(slice), self.slice(slice));
                let (mut apart, mut whole) = (0.0, 0.0);
                for (cell, &value) in cells.iter().enumerate() {
                    let (column, row) = (cell % self.axes.columns, cell / self.axes.columns);
                    let (u, v) = (column as f64 + 0.5, row as f64 + 0.5);
                    let m = self.axes.half_vector(slice, u / self.axes.columns as f64, v / self.axes.rows as f64);
                    let o = mirror(l, m);
                    if value.is_nan() || o.z < last {
                        continue;
                    }
                    let weight = l.z * f64::from(self.slice_projected(slice)[cell]);
                    apart += weight * (f64::from(value) - self.at(o, l)).abs();
                    whole += weight * f64::from(value);
                }
                (apart, whole)
            })
            .collect();
        let (apart, whole) = per_slice.iter().fold((0.0, 0.0), |a, p| (a.0 + p.0, a.1 + p.1));
        if whole > 0.0 { apart / whole } else { 0.0 }
    }

    /// How much of [`Self::reciprocity_error`] the rays' own scatter makes: what would be left of it if the plate kept
    /// reciprocity and cells were endlessly fine.
    ///
    /// Of a normal error σ, |error| is √(2/π) σ on average; the other way round, interpolated between about three cells, adds
    /// a third of the variance.
    pub fn reciprocity_noise(&self) -> f64 {
        let per_slice = (0..self.axes.slices()).map(|slice| {
            let l = self.axes.incident(slice);
            let cells = self.slice(slice).iter().zip(self.slice_error(slice)).zip(self.slice_projected(slice));
            let held = cells.filter(|((value, _), _)| !value.is_nan());
            held.fold((0.0, 0.0), |(noise, whole), ((value, error), projected)| {
                let weight = l.z * f64::from(*projected);
                (noise + weight * f64::from(*error), whole + weight * f64::from(*value))
            })
        });
        let (noise, whole) = per_slice.fold((0.0, 0.0), |a: (f64, f64), p| (a.0 + p.0, a.1 + p.1));
        let of_both = (2.0 / PI).sqrt() * (4.0f64 / 3.0).sqrt();
        if whole > 0.0 { of_both * noise / whole } else { 0.0 }
    }

    /// The three laws every BRDF obeys, as numbers.
    pub fn laws(&self) -> Laws {
        let least = self.mean.iter().filter(|v| !v.is_nan()).fold(f64::INFINITY, |a, v| a.min(f64::from(*v)));
        let greatest_albedo = (0..self.axes.slices())
            .map(|slice| self.albedo(slice))
            .fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        let (reciprocity_error, reciprocity_noise) = (self.reciprocity_error(), self.reciprocity_noise());
        Laws { least, greatest_albedo, reciprocity_error, reciprocity_noise }
    }
}

/// What a table says of the laws of nature; see [`BrdfTable::laws`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laws {
    /// Smallest value, 1/sr; not below 0. Infinite if the table holds nothing.
    pub least: f64,
    /// Largest albedo and its standard error; not above 1 by more than the error.
    pub greatest_albedo: (f64, f64),
    /// [`BrdfTable::reciprocity_error`].
    pub reciprocity_error: f64,
    /// [`BrdfTable::reciprocity_noise`].
    pub reciprocity_noise: f64,
}

#[cfg(test)]
#[path = "table_tests.rs"]
mod tests;
