//! RGL `.bsdf`: a BRDF table as Mitsuba's `measured`, pbrt's `measured` and powitacq read it.
//!
//! The file is a tensor file: `tensor_file\0`, version 1.0, a count of fields; for each field its name, rank, type,
//! offset and shape; then the data, little-endian. What the fields mean (Dupuy and Jakob 2018, section 4), with
//! u = sqrt(2θ/π) and v = (φ + π)/2π of a half vector m:
//!
//! | field | shape | content |
//! |---|---|---|
//! | `theta_i`, `phi_i` | n | incidence, radians; one azimuth means isotropic, v then counts from φi |
//! | `ndf` | v, u | D(m) |
//! | `sigma` | v, u of ωi | σ(ωi) = ∫ D max(0, ωi·m) dm |
//! | `vndf` | φi, θi, v, u | D max(0, ωi·m)/σ as density over the unit square |
//! | `rgb` or `spectra` | φi, θi, channel, s2, s1 | f_r cosθo · 4σ(ωi)/D(m) |
//! | `luminance` | φi, θi, s2, s1 | brightness of the former: what is sampled first |
//! | `jacobian` | 1 | 1: the reader multiplies by D/4σ |
//!
//! All grids hold values at nodes, from one edge of the unit square to the other, and readers interpolate between
//! them. (s1, s2) is (u, v) after the warp that makes `vndf` uniform: there a lobe takes up the whole square, so that
//! a coarse grid is enough for colour while `ndf` and `vndf` carry its shape. Its nodes are fitted to the table by least
//! squares under the condition that none is negative: all of the light that a measured table counted bears on them, the
//! coarser the grid the less they scatter, and the light of each incidence stays what it is ([`BsdfFacts`]).
//!
//! D is not measured by itself here but drawn from the table: 4 f_r cosθi cosθo = D F G, averaged over incidence with
//! the weight cosθi cos²θo, which fades where half vectors send light below the horizon. A small diffuse share is
//! mixed into it ([`BsdfSettings::floor`]), so that no region is without density where light arrives by other ways
//! (several bounces). What the estimate misses stands in the colour fields: it decides resolution, not correctness.
//!
//! Size in bytes: 4 · azimuths · polar angles · ((columns + 1)(rows + 1) + (1 + channels) · samples²). Isotropic, 16
//! polar angles, 256 × 32 cells, 64² samples, grey as three channels: 1.6 MB. Anisotropic, 16 + 1 azimuths × 12,
//! 256 × 128 cells, 64² samples: 40 MB. Four cells to a lobe of half width w radians take 4/sqrt(2w/π) columns if it
//! stands on the plate's normal (1°: 38); tilted by t, 4π sqrt(2t/π)/w columns and 8π sin t/w rows (1° tilted by 10°:
//! 240 and 250). Half the columns in rows do well for smooth lobes: with 32 rows GGX of α = 0.2 came out within 1.6 %
//! on a sphere, with 64 within 0.7 %.

mod corners;

mod fit;

mod tensor;

mod warp;

mod read;

pub use self::read::{BsdfReadError, read_bsdf};
pub use self::tensor::TensorError;

#[cfg(test)]
mod tests;

use std::io::{self, Write};

use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use self::corners::{bilinear, corner_values};
use self::fit::GridFit;
use self::tensor::{Tensor, write_tensors};
use self::warp::Warp;
use crate::slope::mirror;
use crate::verify::goniometer::table::{BrdfAxes, BrdfTable};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Nodes of σ along the polar angle.
const SIGMA_NODES: usize = 129;

/// How a table is laid out as `.bsdf`.
#[derive(Clone, Debug, PartialEq)]
pub struct BsdfSettings {
    /// Nodes each way of the colour grid over the warped square, 2 or more. More are better for tables without noise;
    /// for measured ones see [`BsdfSettings::measured`].
    pub samples: usize,
    /// Share of a diffuse distribution mixed into the distribution of normals, in (0, 1).
    pub floor: f64,
    /// Free text in the file.
    pub description: String,
}

impl Default for BsdfSettings {
    fn default() -> Self {
        Self { samples: 64, floor: 0.02, description: "facetmill".into() }
    }
}

impl BsdfSettings {
    /// For tables that hold noise: the colour grid half as fine. On a sphere that wears a measured plate 32 nodes came out
    /// nearer than 16 (too coarse toward the horizon) and 64 (noise): 2.5 %, 3.7 % and 3.0 % from direct tracing.
    pub fn measured() -> Self {
        Self { samples: 32, ..Self::default() }
    }
}

/// The colours of a `.bsdf` file; all tables on the same axes.
#[derive(Clone, Copy, Debug)]
pub enum BsdfColour<'a> {
    /// One table for all of red, green and blue: for readers in RGB.
    Grey(&'a BrdfTable),
    /// Linear Rec. 709 red, green and blue: for readers in RGB.
    Rgb([&'a BrdfTable; 3]),
    /// Wavelengths in nanometres, ascending, each with its table: for readers that render spectra.
    Spectral(&'a [(f64, &'a BrdfTable)]),
}

/// What the colours of a `.bsdf` file came to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BsdfFacts {
    /// The least of its colour values: never below 0.
    pub least_value: f64,
    /// Light above the horizon in its colours, as a share of that in the table, over all incidences and colours.
    pub light: f64,
}

/// Writes the `.bsdf` file. Memory: about what the file takes.
pub fn write_bsdf(colour: BsdfColour, settings: &BsdfSettings, out: &mut impl Write) -> Result<BsdfFacts, BsdfError> {
    let (tables, weights): (Vec<&BrdfTable>, Vec<f64>) = match colour {
        BsdfColour::Grey(table) => (vec![table], vec![1.0]),
        BsdfColour::Rgb(tables) => (tables.to_vec(), vec![0.2126, 0.7152, 0.0722]),
        BsdfColour::Spectral(list) => list.iter().map(|(_, t)| (*t, 1.0 / list.len() as f64)).unzip(),
    };
    let Some(first) = tables.first() else { return Err(BsdfError::NoTable) };
    if tables.iter().any(|t| t.axes() != first.axes()) {
        return Err(BsdfError::Axes);
    }
    let fit = GridFit::new(settings.samples).filter(|_| settings.floor > 0.0 && settings.floor < 1.0);
    let fit = fit.ok_or(BsdfError::Settings)?;
    if let BsdfColour::Spectral(list) = colour
        && !list.windows(2).all(|w| w[0].0 < w[1].0)
    {
        return Err(BsdfError::Wavelengths);
    }
    let axes = first.axes();
    let normals = Normals::new(&tables, &weights, settings.floor);
    let sigma = normals.sigma();
    let slices: Vec<Slice> =
        (0..axes.slices()).into_par_iter().map(|slice| normals.slice(&tables, &weights, &sigma, slice, &fit)).collect();

    // The circle of azimuths is closed by its first slices once more.
    let order: Vec<usize> = if axes.is_isotropic() {
        (0..axes.slices()).collect()
    } else {
        (0..axes.slices()).chain(0..axes.theta_i().len()).collect()
    };
    let channels: Vec<usize> = match colour {
        BsdfColour::Grey(_) => vec![0; 3],
        _ => (0..tables.len()).collect(),
    };
    let mut phi_i = axes.phi_i().to_vec();
    if !axes.is_isotropic() {
        phi_i.push(PI);
    }
    let angles = [phi_i.len(), axes.theta_i().len()];
    let (nodes, n) = ([axes.rows() + 1, axes.columns() + 1], settings.samples);
    let gathered = |part: &dyn Fn(&Slice) -> Vec<f32>| order.iter().flat_map(|&k| part(&slices[k])).collect();
    let floats = |values: &[f64]| values.iter().map(|v| *v as f32).collect::<Vec<f32>>();
    let mut fields = vec![
        Tensor::bytes("description", settings.description.as_bytes()),
        Tensor::bytes("jacobian", &[1]),
        Tensor::floats("theta_i", &[angles[1]], floats(axes.theta_i())),
        Tensor::floats("phi_i", &[angles[0]], floats(&phi_i)),
        Tensor::floats("ndf", &nodes, floats(&normals.density)),
        Tensor::floats("sigma", &[sigma.rows, SIGMA_NODES], floats(&sigma.values)),
        Tensor::floats("vndf", &[angles[0], angles[1], nodes[0], nodes[1]], gathered(&|s| s.vndf.clone())),
        Tensor::floats("luminance", &[angles[0], angles[1], n, n], gathered(&|s| s.luminance.clone())),
    ];
    let coloured = gathered(&|s| channels.iter().flat_map(|&c| s.colour[c].iter().copied()).collect());
    let shape = [angles[0], angles[1], channels.len(), n, n];
    if let BsdfColour::Spectral(list) = colour {
        let wavelengths: Vec<f64> = list.iter().map(|(nm, _)| *nm).collect();
        fields.push(Tensor::floats("wavelengths", &[list.len()], floats(&wavelengths)));
        fields.push(Tensor::floats("spectra", &shape, coloured));
    } else {
        fields.push(Tensor::floats("rgb", &shape, coloured));
    }
    write_tensors(&fields, out)?;
    Ok(facts(&slices))
}

/// What all slices together came to.
fn facts(slices: &[Slice]) -> BsdfFacts {
    let values = slices.iter().flat_map(|slice| slice.colour.iter().flatten());
    let sum = |part: fn(&Slice) -> f64| slices.iter().map(part).sum::<f64>();
    let (held, wanted) = (sum(|slice| slice.light[0]), sum(|slice| slice.light[1]));
    BsdfFacts {
        least_value: values.fold(f64::INFINITY, |least, value| least.min(f64::from(*value))),
        light: if wanted > 0.0 { held / wanted } else { 1.0 },
    }
}

/// The distribution of normals at the corners of the table's cells.
struct Normals<'a> {
    axes: &'a BrdfAxes,
    density: Vec<f64>,
}

/// Projected area of the normals, on nodes of (u, v) of the incident direction.
struct Sigma {
    rows: usize,
    values: Vec<f64>,
}

/// What the file holds for one incident direction.
struct Slice {
    vndf: Vec<f32>,
    luminance: Vec<f32>,
    colour: Vec<Vec<f32>>,
    /// Sum over the points of the fit above the horizon: of the grid, and of the table.
    light: [f64; 2],
}

impl<'a> Normals<'a> {
    fn new(tables: &[&'a BrdfTable], weights: &[f64], floor: f64) -> Self {
        let axes = tables[0].axes();
        let (columns, rows) = (axes.columns() + 1, axes.rows() + 1);
        // (Σ weight · D F G, Σ weight) per corner, summed in the order of slices.
        let mut sums = vec![(0.0, 0.0); columns * rows];
        for slice in 0..axes.slices() {
            let l = axes.incident(slice);
            let corners = corner_values(tables, weights, slice);
            sums.par_iter_mut().enumerate().for_each(|(node, sum)| {
                let (u, v) = (node % columns, node / columns);
                let m = axes.half_vector(slice, u as f64 / axes.columns() as f64, v as f64 / axes.rows() as f64);
                let o = mirror(l, m);
                if o.z > 0.0 && l.dot(m) > 0.0 {
                    // The sine is the share of polar angles in the sphere of incident directions.
                    let weight = l.z * o.z * o.z * l.x.hypot(l.y).max(0.05);
                    sum.0 += weight * 4.0 * l.z * o.z * corners[node].max(0.0);
                    sum.1 += weight;
                }
            });
        }
        // One point of the sphere, the pole, has one density; and D of an isotropic plate knows no azimuth.
        for column in 0..if axes.is_isotropic() { columns } else { 1 } {
            let whole = (0..rows - 1).map(|row| sums[column + columns * row]);
            let whole = whole.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
            (0..rows).for_each(|row| sums[column + columns * row] = whole);
        }
        let density = sums.iter().map(|(a, b)| if *b > 0.0 { a / b } else { 0.0 }).collect();
        let mut normals = Self { axes, density };
        // Normals of a closed relief project onto its own area: ∫ D cosθ dm = 1.
        let area = normals.integral(|m| m.z);
        let share = if area > 0.0 { (1.0 - floor) / area } else { 0.0 };
        let base = (1.0 - share * area) * FRAC_1_PI;
        normals.density.iter_mut().for_each(|d| *d = *d * share + base);
        normals
    }

    /// ∫ D(m) g(m) dm, each cell at its centre.
    fn integral(&self, g: impl Fn(glam::DVec3) -> f64) -> f64 {
        let (columns, rows) = (self.axes.columns(), self.axes.rows());
        let mut sum = 0.0;
        for row in 0..rows {
            for column in 0..columns {
                let (u, v) = ((column as f64 + 0.5) / columns as f64, (row as f64 + 0.5) / rows as f64);
                let m = self.axes.half_vector(0, u, v);
                let corner = column + (columns + 1) * row;
                let d = [0, 1, columns + 1, columns + 2].map(|k| self.density[corner + k]).iter().sum::<f64>() / 4.0;
                sum += d * g(m) * jacobian(u) / (columns * rows) as f64;
            }
        }
        sum
    }

    fn sigma(&self) -> Sigma {
        let rows = if self.axes.is_isotropic() { 2 } else { 65 };
        let across = |row: usize| if self.axes.is_isotropic() { 0 } else { row };
        let mut values: Vec<f64> = (0..rows * SIGMA_NODES)
            .into_par_iter()
            .map(|node| {
                let (column, row) = (node % SIGMA_NODES, node / SIGMA_NODES);
                if across(row) != row {
                    return 0.0;
                }
                let u = column as f64 / (SIGMA_NODES - 1) as f64;
                let l = crate::slope::direction(PI / 2.0 * u * u, TAU * row as f64 / (rows - 1) as f64 - PI);
                self.integral(|m| l.dot(m).max(0.0))
            })
            .collect();
        if self.axes.is_isotropic() {
            values.copy_within(..SIGMA_NODES, SIGMA_NODES);
        }
        Sigma { rows, values }
    }

    fn slice(&self, tables: &[&BrdfTable], weights: &[f64], sigma: &Sigma, slice: usize, fit: &GridFit) -> Slice {
        let axes = self.axes;
        let (columns, rows) = (axes.columns() + 1, axes.rows() + 1);
        let (theta, phi) = axes.incident_angles(slice);
        let (l, sigma) = (axes.incident(slice), sigma.at(theta, phi));
        let place = |node: usize| {
            let (u, v) = (node % columns, node / columns);
            (u as f64 / axes.columns() as f64, v as f64 / axes.rows() as f64)
        };
        let vndf: Vec<f64> = (0..columns * rows)
            .map(|node| {
                let (u, v) = place(node);
                self.density[node] * l.dot(axes.half_vector(slice, u, v)).max(0.0) / sigma * jacobian(u)
            })
            .collect();
        let warp = Warp::new(&vndf, columns);
        let places = fit.places(|s1, s2| warp.sample(s1, s2));
        let above: Vec<bool> = places.iter().map(|&(u, v)| mirror(l, axes.half_vector(slice, u, v)).z > 0.0).collect();
        let equations = fit.equations(&above);
        let mut light = [0.0; 2];
        let mut colour = Vec::with_capacity(tables.len());
        for table in tables {
            let mut shape = corner_values(&[*table], &[1.0], slice);
            let out = |node: usize| {
                let (u, v) = place(node);
                mirror(l, axes.half_vector(slice, u, v))
            };
            for (node, value) in shape.iter_mut().enumerate() {
                *value = value.max(0.0) * out(node).z * 4.0 * sigma / self.density[node];
            }
            // Light falls to zero at the horizon. Between the table's corners it does if it goes on below as the
            // negative of what is above.
            let mirrored = shape.clone();
            for (node, value) in shape.iter_mut().enumerate() {
                let mut o = out(node);
                if o.z < 0.0 {
                    o.z = -o.z;
                    let (u, v) = axes.coordinates(l, o);
                    *value = -bilinear(&mirrored, columns, u, v).max(0.0);
                }
            }
            let values: Vec<f64> = places.iter().map(|&(u, v)| bilinear(&shape, columns, u, v).max(0.0)).collect();
            let nodes = equations.nodes(&values);
            light[0] += equations.light(&nodes.iter().map(|node| f64::from(*node)).collect::<Vec<_>>());
            light[1] += values.iter().zip(&above).filter(|(_, above)| **above).map(|(value, _)| value).sum::<f64>();
            colour.push(nodes);
        }
        let mut luminance: Vec<f32> = (0..colour[0].len())
            .map(|k| colour.iter().zip(weights).map(|(c, w)| f64::from(c[k]) * w).sum::<f64>().max(0.0) as f32)
            .collect();
        // A slice that sends nothing back must still be a distribution.
        if luminance.iter().all(|v| *v <= 0.0) {
            luminance.fill(1.0);
        }
        Slice { vndf: vndf.iter().map(|v| *v as f32).collect(), luminance, colour, light }
    }
}

impl Sigma {
    /// As a reader interpolates it.
    fn at(&self, theta: f64, phi: f64) -> f64 {
        bilinear(&self.values, SIGMA_NODES, (theta * 2.0 / PI).sqrt(), (phi + PI) / TAU)
    }
}

/// dm/(du dv): solid angle per area of the unit square.
fn jacobian(u: f64) -> f64 {
    2.0 * PI * PI * u * (PI / 2.0 * u * u).sin()
}

/// Why a `.bsdf` cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BsdfError {
    /// No wavelength at all.
    #[error("a .bsdf file needs at least one BRDF table")]
    NoTable,
    /// Colours measured on different grids.
    #[error("the BRDF tables of the colours are not on the same grid")]
    Axes,
    /// Wavelengths out of order.
    #[error("the wavelengths of a .bsdf file must ascend")]
    Wavelengths,
    /// Settings out of range.
    #[error("a .bsdf file needs 2 samples a side or more and a floor between 0 and 1")]
    Settings,
    /// The writer failed.
    #[error("the .bsdf file cannot be written: {0}")]
    Write(#[from] io::Error),
}
