//! What a measurement takes of memory at the most, from its sizes alone. Figures are measured as those of `job::memory`.

use facetmill::memory::Need;
use facetmill::verify::tally;

use super::brdf;
use crate::args::MeasureArgs;
use crate::console::Failure;

/// A pixel of a view: radiance, error and trapped share, by rows and as pictures.
const VIEWED_PIXEL: f64 = 80.0;

/// A cell of a table of a BRDF: itself, its error, and both once more as they are written.
const TABLE_CELL: f64 = 40.0;

/// A pixel of a picture as it is drawn and written.
const DRAWN_PIXEL: f64 = 16.0;

/// What is drawn of a BRDF.
const BRDF_PICTURES: f64 = 1.5e8;

/// What `args` ask for takes besides its plate, on pictures of `resolution` pixels a side.
pub fn need(args: &MeasureArgs, resolution: usize) -> Result<Need, Failure> {
    let pixels = resolution * resolution;
    let coarser = "lower --resolution";
    Ok(if args.brdf {
        let axes = brdf::axes(args)?;
        let (cells, all) = (axes.cells(), axes.slices() as f64 * axes.cells() as f64);
        let bytes = tally::bytes(cells) + TABLE_CELL * all + BRDF_PICTURES;
        Need::new(bytes, "the table of the BRDF", "lower --half-vectors, --polar or --azimuths")
    } else if args.look {
        Need::new(VIEWED_PIXEL * pixels as f64, "the view of the plate", coarser)
    } else if args.ndf {
        Need::new(DRAWN_PIXEL * pixels as f64, "the picture of slopes", coarser)
    } else {
        Need::new(tally::bytes(pixels) + DRAWN_PIXEL * pixels as f64, "the image of the light", coarser)
    })
}
