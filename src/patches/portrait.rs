//! Bowls so large that a viewer sees a picture on the plate.
//!
//! Each patch's lobe is about the slope that mirrors the lamp to the viewer from there, so that the picture holds for a
//! viewer at any distance and moves with nobody's head within the lobe. White is what every patch can reach with the
//! largest bowl, black what the brightest patch keeps without one; tones lie between, in proportion to the picture's light.

use rayon::prelude::*;

use super::dimple::{Dimple, PatchLobe, Walls};
use super::plate::Patches;
use super::viewer::Viewer;
use crate::progress::{Cancelled, Progress};
use crate::raster::Raster;

/// How near the brightness of a patch comes to what is wanted, as a share of white.
const NEAR: f64 = 0.002;

/// Bisections of the size of a bowl; brightness follows it but for the steps of a grid's triangles.
const TRIES: usize = 18;

/// A plate that shows a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Portrait {
    /// Row by row from the top left.
    pub dimples: Vec<Dimple>,
    /// What is to be seen: the picture between black and white, 1/sr for a lamp of irradiance 1 across its beam.
    pub wanted: Raster,
    /// What the written triangles show by their first bounce, 1/sr.
    pub shown: Raster,
    /// Radiance of the darkest and of the brightest tone, 1/sr.
    pub range: [f64; 2],
    /// Least and largest share of a patch that the largest bowl takes.
    pub most_share: [f64; 2],
}

impl Portrait {
    /// Designs the plate for `tones`, light from 0 to 1 for each patch, row 0 on top.
    ///
    /// # Errors
    /// A patch cannot mirror the lamp to the viewer; or the work was cancelled.
    pub fn new(
        patches: &Patches,
        walls: Walls,
        width: f64,
        (tones, viewer): (&Raster, &Viewer),
        progress: &Progress,
    ) -> Result<Self, PortraitError> {
        let cells: Vec<Cell> = (0..patches.len())
            .into_par_iter()
            .map(|k| {
                progress.check()?;
                Cell::new(patches, walls, width, viewer, [k % patches.count[0], k / patches.count[0]])
            })
            .collect::<Result<_, PortraitError>>()?;
        let white = cells.iter().map(|cell| cell.white).fold(f64::INFINITY, f64::min);
        let black = cells.iter().map(|cell| cell.black).fold(0.0, f64::max);
        if white <= black {
            return Err(PortraitError::NoContrast);
        }
        let [width, height] = patches.count;
        let wanted = Raster::from_fn(width, height, |x, y| black + tones.at(x, y).clamp(0.0, 1.0) * (white - black));
        let made: Vec<(Dimple, f64)> = cells
            .par_iter()
            .zip(&wanted.values)
            .map(|(cell, wanted)| {
                progress.check()?;
                Ok(cell.tuned(patches, walls, viewer, *wanted, NEAR * white))
            })
            .collect::<Result<_, Cancelled>>()?;
        let shares = cells.iter().map(|cell| cell.most);
        let most_share = shares.fold([1.0, 0.0], |[low, high]: [f64; 2], share| [low.min(share), high.max(share)]);
        let (dimples, shown) = made.into_iter().unzip();
        Ok(Self { dimples, wanted, shown: Raster { width, height, values: shown }, range: [black, white], most_share })
    }
}

/// What one patch can do.
struct Cell {
    place: glam::DVec2,
    lobe: PatchLobe,
    /// The largest share of its bowl.
    most: f64,
    /// Radiance with that, and without a bowl.
    white: f64,
    black: f64,
}

impl Cell {
    fn new(
        patches: &Patches,
        walls: Walls,
        width: f64,
        viewer: &Viewer,
        [column, row]: [usize; 2],
    ) -> Result<Self, PortraitError> {
        let place = patches.middle(column, row);
        let tilt = viewer.mirroring(place).ok_or(PortraitError::NoMirror { column, row })?;
        let lobe = PatchLobe::round(width, tilt);
        let most = Dimple::most_share(walls, &lobe);
        let seen = |share| viewer.radiance(patches, &patches.heights(&Dimple::new(walls, &lobe, share)), place);
        Ok(Self { place, lobe, most, white: seen(most), black: seen(0.0) })
    }

    /// The dimple that shows `wanted` to within `near`, or as nearly as can be, and what it shows.
    fn tuned(&self, patches: &Patches, walls: Walls, viewer: &Viewer, wanted: f64, near: f64) -> (Dimple, f64) {
        let try_share = |share: f64| {
            let dimple = Dimple::new(walls, &self.lobe, share);
            (dimple, viewer.radiance(patches, &patches.heights(&dimple), self.place))
        };
        let (mut low, mut high) = ((0.0, self.black), (self.most, self.white));
        let mut best = if wanted - self.black <= near { try_share(0.0) } else { try_share(self.most) };
        for k in 0..TRIES {
            if (best.1 - wanted).abs() <= near {
                break;
            }
            // Brightness goes with the share, nearly; where that leads nowhere, halves do.
            let along = if k % 3 < 2 { ((wanted - low.1) / (high.1 - low.1)).clamp(0.02, 0.98) } else { 0.5 };
            let share = low.0 + along * (high.0 - low.0);
            let (dimple, seen) = try_share(share);
            if seen < wanted {
                low = (share, seen)
            } else {
                high = (share, seen)
            }
            if (seen - wanted).abs() < (best.1 - wanted).abs() {
                best = (dimple, seen);
            }
        }
        best
    }
}

/// Why no plate shows a picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PortraitError {
    /// Lamp and viewer are below each other's horizon.
    #[error("the patch in column {column}, row {row} cannot mirror the lamp to the viewer: move one of them")]
    NoMirror {
        /// From the left, from 0.
        column: usize,
        /// From the top, from 0.
        row: usize,
    },
    /// Walls as bright as bowls.
    #[error(
        "patches cannot be made brighter than their walls are: move lamp and viewer so that a flat plate mirrors one to the other, or take a smaller --lobe"
    )]
    NoContrast,
    /// Stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
