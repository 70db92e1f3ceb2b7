//! STEP (ISO 10303-21, AP214): a plate of facets as a solid of planar faces, for CAD programs and shops that refuse meshes.
//!
//! Each facet is one face on its exact plane, each wall between facets one vertical face, the sides and the base too: a
//! closed shell of shared edges. Nothing is cut into triangles. Heights that meet at a node within 2 nm become one
//! vertex, so that a vertex lies on each of its planes within one and a half times that.

mod brep;

mod part21;

#[cfg(test)]
mod tests;

use std::io::{self, Write};

use thiserror::Error;

use self::brep::Brep;
use crate::progress::{Cancelled, Progress};
use crate::relief::faceted::FacetedRelief;

/// The most facets that are written: 10,000 with walls between all of them are 35 MB of text and 30,000 faces, and CAD
/// programs become slow from some ten thousand faces on.
pub const MOST_FACETS: usize = 10_000;

/// Heights at one node nearer to each other than this become one, mm: less than any machine's step, twice the accuracy
/// that the file states, and more than the 1e-7 mm at which CAD programs take places as the same.
const SNAP: f64 = 2e-6;

/// What the file states as its accuracy, mm: vertices are further apart, so that no reader takes two for one.
const ACCURACY: f64 = 1e-6;

/// Writes the solid under `relief`, whose flat base lies `thickness` mm below the lowest point; `about` says what it is.
///
/// # Errors
/// When writing fails, it is abandoned, or the relief has too many facets or is none.
pub fn write_step(
    relief: &FacetedRelief,
    thickness: f64,
    about: &str,
    out: &mut dyn Write,
    progress: &Progress,
) -> Result<(), StepError> {
    let facets = relief.optical.0.len() * relief.optical.1.len();
    if facets > MOST_FACETS {
        return Err(StepError::TooMany { facets });
    }
    let solid = Brep::under(relief, thickness, progress)?;
    Ok(part21::write(&solid, about, out, progress)?)
}

/// Why a plate is not written as STEP.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StepError {
    /// More than CAD programs take.
    #[error("{facets} facets are more than the {MOST_FACETS} that are written as STEP: take 3MF, or fewer facets")]
    TooMany {
        /// Facets of the optical area.
        facets: usize,
    },
    /// A height or slope that is none, or no facets.
    #[error("the relief has no facets, or a height or slope that is not a finite number")]
    NoRelief,
    /// The file could not be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The caller wanted nothing more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
