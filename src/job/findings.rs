//! What a proof finds: light, and what is said of it.

use crate::milling::made::Machining;
use crate::raster::Raster;
use crate::relief::open::OpenRelief;
use crate::scene::Scene;
use crate::sculpt::detail::Detail;
use crate::verify::elsewhere::ThrownElsewhere;
use crate::verify::rim::RimLight;
use crate::verify::tally::Measurement;
use crate::verify::verdict::{Figure, Verdict};
use crate::verify::wall_verdict::WallVerdict;
use crate::verify::windows::Likeness;

/// Light sent over a design, and what is said of it.
#[derive(Clone, Debug)]
pub struct Proof {
    /// What was wanted, 256² pixels, sum 1.
    pub target: Raster,
    /// What the light did.
    pub measurement: Measurement,
    /// The figures.
    pub verdict: Verdict,
    /// What is said of a sheet besides.
    pub sheet: Option<SheetProof>,
    /// The same of the plate as its cutter leaves it, if one is named.
    pub milled: Option<MilledProof>,
    /// The same as a machine makes it, if one is named.
    pub made: Option<MadeProof>,
    /// Light of the rim, if there is one.
    pub rim: Option<RimProof>,
    /// Light on the wall, in a scene that has one.
    pub wall: Option<WallProof>,
}

/// Light of the rim around the optical area, as shares of the light on that area.
#[derive(Clone, Debug)]
pub struct RimProof {
    /// It, as if the rim were polished; the cutter's fillet at the relief's foot is left out.
    pub light: RimLight,
    /// Light that falls on the rim.
    pub lit: f64,
    /// What of it would fall into the picture.
    pub into_picture: Figure,
    /// Whether the rim is polished, so that this counts in all figures and pictures.
    pub counts: bool,
}

impl RimProof {
    /// `measurement` of the optical area with the light of `rim` over its image, where there is one and it counts.
    pub fn over(rim: Option<&Self>, measurement: Measurement) -> Measurement {
        match rim {
            Some(rim) if rim.counts => rim.light.over(measurement),
            _ => measurement,
        }
    }
}

/// How a sheet looks in parts, and to diffraction; after its cutter, if it was designed for one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetProof {
    /// Its windows against the picture.
    pub windows: Likeness,
    /// The smallest patch on which its light depends.
    pub detail: Option<Detail>,
    /// Share of the light from mirrors so small that diffraction spreads it by more than a degree.
    pub diffracted: f64,
}

/// Light sent over a design as its cutter leaves it.
#[derive(Clone, Debug)]
pub struct MilledProof {
    /// The most that the cutter stays above the written surface, mm.
    pub left: f64,
    /// What the light did.
    pub measurement: Measurement,
    /// The figures.
    pub verdict: Verdict,
}

/// Light sent over a plate as a machine makes it.
#[derive(Clone, Debug)]
pub struct MadeProof {
    /// How it is made.
    pub machining: Machining,
    /// Its surface in the first draw of the machine's errors, if it is polished.
    pub surface: Option<OpenRelief>,
    /// What the light did there.
    pub measurement: Measurement,
    /// The figures of that.
    pub verdict: Verdict,
    /// Light on the wall and its figures there, in a scene that has one.
    pub on_wall: Option<WallLight>,
    /// In each draw, the share of the light that is misplaced or lost at a blur of 1°.
    pub draws: Vec<f64>,
    /// Share of the light within half a degree of where a level plate throws it, less what the drawing has there.
    pub central_spot: f64,
    /// Time of the finishing passes, hours.
    pub hours: f64,
}

impl RimProof {
    /// A rim that counts as dark, around the optical area of `measurement`.
    pub fn dull(light: RimLight, measurement: &Measurement) -> Self {
        Self { lit: light.lit(measurement), into_picture: light.in_image(measurement), counts: false, light }
    }
}

/// Light on a wall, and its figures there.
#[derive(Clone, Debug)]
pub struct WallLight {
    /// The light.
    pub thrown: Measurement,
    /// Its figures.
    pub verdict: WallVerdict,
}

/// What is said of a plate in its room.
#[derive(Clone, Debug)]
pub struct WallProof {
    /// Lamp and wall.
    pub scene: Scene,
    /// From the eye to the wall, mm.
    pub eye_distance: f64,
    /// The drawing, [`ACROSS`](crate::verify::thrown::ACROSS) pixels a side, sum 1.
    pub target: Raster,
    /// The plate as it is designed, or as it stands in a file.
    pub designed: WallLight,
    /// The plate as its cutter leaves it, if one is named.
    pub milled: Option<WallLight>,
    /// What it throws elsewhere, of a relief that stands on a grid.
    pub elsewhere: Option<ThrownElsewhere>,
    /// What diffraction leaves of it, of a sheet.
    pub diffraction: Option<WallDiffraction>,
    /// Share of the picture's light that the lamp, 30 mm across or larger, stops on its way to the wall.
    pub stopped_by_lamp: f64,
}

/// What diffraction by the smallest patches on which a sheet's light depends leaves of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallDiffraction {
    /// Width of such a patch, mm.
    pub patch: f64,
    /// By how much it spreads light, mm on the wall at half brightness.
    pub spread: f64,
    /// Likeness to the drawing at the eye's blur, were all light spread so.
    pub ssim: f64,
}
