//! Reading a `.bsdf` back as a table of the BRDF.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use thiserror::Error;

use super::corners::bilinear;
use super::tensor::{Floats, TensorError, read_tensors};
use super::warp::Warp;
use crate::slope::mirror;
use crate::verify::goniometer::table::{BrdfAxes, BrdfTable, TableError};

/// Cells of half vectors of the table that is made: as `measure --brdf` has them unless told otherwise.
const CELLS: [usize; 2] = [128, 64];

/// The BRDF of a `.bsdf`, its colours as an eye weighs them (Rec. 709) or its wavelengths all alike.
///
/// # Errors
/// Bytes that are no such file, fields that are missing or do not fit together, a grid that is not round.
pub fn read_bsdf(bytes: &[u8]) -> Result<BrdfTable, BsdfReadError> {
    let fields = read_tensors(bytes)?;
    let file = Fields::new(&fields)?;
    let isotropic = file.phi.len() <= 2;
    // A grid of whole turns has its last azimuth twice.
    let azimuths = if isotropic { 1 } else { file.phi.len() - 1 };
    if !isotropic && (file.phi[azimuths] - file.phi[0] - TAU).abs() > 0.01 {
        return Err(BsdfReadError::Part);
    }
    let polar: Vec<f64> = file.theta.iter().copied().filter(|theta| *theta < FRAC_PI_2 - 0.01).collect();
    let axes = match azimuths {
        1 => BrdfAxes::isotropic(polar, CELLS[0], CELLS[1])?,
        _ => BrdfAxes::anisotropic(polar, azimuths, CELLS[0], CELLS[1])?,
    };
    let mut table = BrdfTable::new(axes);
    for slice in 0..table.axes().slices() {
        let share = file.slice(&table, slice);
        table.set_flux(slice, &share, &vec![0.0; share.len()])?;
    }
    Ok(table)
}

/// The fields, checked against each other.
struct Fields<'a> {
    theta: &'a [f64],
    phi: &'a [f64],
    ndf: &'a Floats,
    sigma: &'a Floats,
    vndf: &'a Floats,
    colour: &'a Floats,
    weights: Vec<f64>,
}

impl<'a> Fields<'a> {
    fn new(fields: &'a HashMap<String, Floats>) -> Result<Self, BsdfReadError> {
        let field = |name: &'static str| fields.get(name).ok_or(BsdfReadError::Missing(name));
        let colour = field("rgb").or_else(|_| field("spectra"))?;
        let (theta, phi) = (field("theta_i")?, field("phi_i")?);
        let (ndf, sigma, vndf) = (field("ndf")?, field("sigma")?, field("vndf")?);
        let lights = [phi.values.len(), theta.values.len()];
        let grid = |floats: &Floats, rank: usize| {
            let sides = &floats.shape[floats.shape.len().saturating_sub(2)..];
            floats.shape.len() == rank && sides.iter().all(|side| *side >= 2) && !floats.values.is_empty()
        };
        let sound = grid(ndf, 2)
            && grid(sigma, 2)
            && grid(vndf, 4)
            && grid(colour, 5)
            && vndf.shape[..2] == lights
            && colour.shape[..2] == lights
            && [theta, phi, ndf, sigma, vndf, colour].iter().all(|f| f.values.iter().all(|v| v.is_finite()));
        if !sound {
            return Err(BsdfReadError::Shape);
        }
        let channels = colour.shape[2];
        let weights = match channels {
            3 if fields.contains_key("rgb") => vec![0.2126, 0.7152, 0.0722],
            _ => vec![1.0 / channels.max(1) as f64; channels],
        };
        Ok(Self { theta: &theta.values, phi: &phi.values, ndf, sigma, vndf, colour, weights })
    }

    /// Share of the light of a slice that leaves through each cell, from the BRDF at its middle.
    fn slice(&self, table: &BrdfTable, slice: usize) -> Vec<f64> {
        let axes = table.axes();
        let polar = axes.theta_i().len();
        let light = slice / polar * self.theta.len() + slice % polar;
        let of_light = |floats: &'a Floats| {
            let size: usize = floats.shape[2..].iter().product();
            &floats.values[light * size..][..size]
        };
        let warp = Warp::new(of_light(self.vndf), self.vndf.shape[3]);
        let colours = of_light(self.colour);
        let size = self.colour.shape[3] * self.colour.shape[4];
        let (theta, phi) = axes.incident_angles(slice);
        let (l, columns) = (axes.incident(slice), axes.columns());
        let at = |floats: &Floats, u: f64, v: f64| bilinear(&floats.values, floats.shape[1], u, v);
        let sigma = at(self.sigma, (theta * 2.0 / PI).sqrt(), (phi + PI) / TAU);
        let share = |cell: usize| {
            let u = ((cell % columns) as f64 + 0.5) / columns as f64;
            let v = ((cell / columns) as f64 + 0.5) / axes.rows() as f64;
            let o = mirror(l, axes.half_vector(slice, u, v));
            if o.z <= 1e-3 {
                return 0.0;
            }
            let (s1, s2) = warp.place_of(u, v);
            let channel = |k: usize| bilinear(&colours[k * size..][..size], self.colour.shape[4], s1, s2);
            let colour: f64 = self.weights.iter().enumerate().map(|(k, weight)| weight * channel(k)).sum();
            let value = colour.max(0.0) * at(self.ndf, u, v) / (4.0 * sigma.max(1e-9) * o.z);
            value * f64::from(table.slice_projected(slice)[cell])
        };
        (0..axes.cells()).map(share).collect()
    }
}

/// Why bytes are no `.bsdf` that is read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BsdfReadError {
    /// Not a tensor file.
    #[error(transparent)]
    Tensor(#[from] TensorError),
    /// A field is not there.
    #[error("this is no .bsdf of a material: its field {0} is missing; name one of RGL's or of measure --brdf")]
    Missing(&'static str),
    /// Fields of different sizes.
    #[error("the fields of this .bsdf do not fit together or hold what is no number; copy the file again")]
    Shape,
    /// A material measured over a part of the azimuths.
    #[error(
        "this .bsdf holds a part of the azimuths only, the rest by symmetry, which is not read; use a MERL file or a CSV"
    )]
    Part,
    /// A grid that cannot be.
    #[error(transparent)]
    Table(#[from] TableError),
}
