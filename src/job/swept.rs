//! The light of what a program leaves.

use glam::DVec2;

use super::design::DesignError;
use super::findings::RimProof;
use super::made::{Seen, bare, traced};
use crate::golden::golden;
use crate::milling::swept::Swept;
use crate::progress::Stage;
use crate::relief::open::OpenRelief;
use crate::verify::measure::Mirrored;
use crate::verify::tally::Measurement;
use crate::verify::verdict::Verdict;

/// Slopes along a row of a surface that is not polished: three million in all, more than a default proof has rays.
const SLOPES_A_ROW: usize = 3000;

/// A surface that a program left, and its light.
#[derive(Clone, Debug)]
pub struct SweptProof {
    /// The surface, if it is polished.
    pub surface: Option<OpenRelief>,
    /// What the light did.
    pub measurement: Measurement,
    /// The figures of that.
    pub verdict: Verdict,
}

/// Proves what `swept` leaves of stock whose upper face is `uncut` mm high, over a plate of `plate` mm whose lower left corner
/// is x = y = 0, polished by `polish` mm if at all.
///
/// # Errors
/// The surface cannot be closed or traced, no light reaches the image, or the caller asked to stop.
pub fn prove_swept(
    swept: &Swept,
    (plate, uncut): (DVec2, f64),
    polish: Option<f64>,
    Seen { target, blur, rim }: Seen,
    mirrored: Mirrored,
) -> Result<SweptProof, DesignError> {
    let progress = mirrored.progress;
    progress.stage(Stage::Milling);
    let surface = polish.map(|sigma| swept.polished(plate, sigma, uncut, progress)).transpose()?;
    let measurement = match &surface {
        Some(surface) => traced(surface, mirrored)?,
        None => bare(|k, rows| slopes(swept, plate, k, rows), blur, mirrored)?,
    };
    progress.stage(Stage::Scoring);
    let measurement = RimProof::over(rim, measurement);
    let verdict = Verdict::new(&measurement, target, mirrored.setup.view(), progress)?;
    Ok(SweptProof { surface, measurement, verdict })
}

/// Slopes along row `k` of `rows`; where nothing has passed the stock is level.
fn slopes(swept: &Swept, plate: DVec2, k: usize, rows: usize) -> Vec<DVec2> {
    // Rows and their shifts keep no step with passes.
    let y = plate.y * (k as f64 + golden(7 * k + 3)) / rows as f64;
    let x = |i: usize| plate.x * (i as f64 + golden(k + 5 * i)) / SLOPES_A_ROW as f64;
    let slope = |i: usize| swept.spot(DVec2::new(x(i), y)).map_or(DVec2::ZERO, |spot| spot.slope);
    (0..SLOPES_A_ROW).map(slope).collect()
}
