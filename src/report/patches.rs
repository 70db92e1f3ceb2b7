//! The report of a plate of patches.

use serde::Serialize;

use super::{MeshFacts, Named, PictureFacts};
use crate::recipe::Recipe;
use crate::verify::patch_view::PatchScores;

/// Everything that is known of a plate of patches.
#[derive(Clone, Debug, Serialize)]
pub struct PatchesReport {
    /// The program and its version.
    pub program: &'static str,
    /// The picture, of a portrait.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<PictureFacts>,
    /// Every setting.
    pub recipe: Recipe,
    /// The patches.
    pub patches: PatchFacts,
    /// Who looks.
    pub viewer: ViewerFacts,
    /// What a portrait can show.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reachable: Option<ReachableFacts>,
    /// The plate's file.
    pub stl: PatchStlFacts,
    /// What a camera at the viewer's place sees of the plate as written, if it was looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub designed: Option<PatchScoreFacts>,
    /// The same of the plate as its cutter leaves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_milled: Option<PatchScoreFacts>,
    /// How it looks, in a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<String>,
    /// What a person should know; empty if nothing is off.
    pub advice: Vec<String>,
    /// CPU seconds by stage.
    pub cpu_seconds: Named,
}

/// A plate of patches in a file, looked at once more.
#[derive(Clone, Debug, Serialize)]
pub struct PatchesVerifyReport {
    /// The program and its version.
    pub program: &'static str,
    /// The mesh.
    pub plate: MeshFacts,
    /// The picture, of a portrait.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<PictureFacts>,
    /// Every setting under which it was looked at.
    pub recipe: Recipe,
    /// Who looks.
    pub viewer: ViewerFacts,
    /// What a portrait can show.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reachable: Option<ReachableFacts>,
    /// What a camera at the viewer's place sees of the plate as it stands in the file.
    pub measured: Option<PatchScoreFacts>,
    /// The same of the plate as its cutter leaves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_milled: Option<PatchScoreFacts>,
    /// What was allowed, and what came of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<AllowedInPatches>,
    /// How it looks, in a sentence.
    pub verdict: Option<String>,
    /// What a person should know; empty if nothing is off.
    pub advice: Vec<String>,
}

/// How much light may be in other patches than it should, and how much is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AllowedInPatches {
    /// The most that may, as a share of the light of all patches.
    pub share: f64,
    /// What is in another patch.
    pub tv: f64,
    /// Whether that is of the plate as milled.
    pub as_milled: bool,
    /// Whether it is no more than may be.
    pub kept: bool,
}

/// The patches of a plate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PatchFacts {
    /// Along x and y.
    pub count: [usize; 2],
    /// Size of one, mm.
    pub size_mm: [f64; 2],
    /// Nodes along a side of one.
    pub nodes: usize,
    /// Tilt of the walls, degrees.
    pub walls_deg: f64,
    /// Half widths of the narrowest and the widest lobe, degrees of tilt.
    pub lobe_deg: [f64; 2],
    /// Scatter of the metal, degrees.
    pub metal_lobe_deg: f64,
    /// Least and largest share of a patch that the largest bowl takes.
    pub most_share: [f64; 2],
    /// Mean share of the plate that bowls take.
    pub bowls_share: f64,
    /// Mean share of the plate that sends light to the stated place out of sight, if one was stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spare_share: Option<f64>,
    /// Radius of the sharpest bowl, mm.
    pub sharpest_bowl_mm: f64,
    /// From the lowest to the highest point, mm.
    pub relief_height_mm: f64,
    /// By how much diffraction spreads the light of a bowl over a whole patch, and of the smallest bowl, degrees.
    pub diffraction_deg: [f64; 2],
}

/// Who looks at a portrait.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ViewerFacts {
    /// From the plate's normal, degrees.
    pub theta: f64,
    /// Azimuth, degrees.
    pub phi: f64,
    /// From the plate's middle, mm.
    pub distance_mm: f64,
}

/// What a portrait can show.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReachableFacts {
    /// Radiance of white, 1/sr for a lamp of irradiance 1 across its beam.
    pub white: f64,
    /// Radiance of black by first bounces.
    pub black: f64,
    /// White over black; of a plate with a cutter over what the cutter's own round leaves in a pit, if that is brighter.
    pub contrast: f64,
}

/// The file of a plate of patches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PatchStlFacts {
    /// Unit of its lengths.
    pub units: &'static str,
    /// Triangles.
    pub triangles: usize,
    /// Size, bytes.
    pub bytes: u64,
}

/// How near a plate looks to what is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PatchScoreFacts {
    /// The scores themselves, each a key of its own.
    #[serde(flatten)]
    pub scores: PatchScores,
    /// The most that the cutter leaves above the written surface, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_mm: Option<f64>,
    /// Paths for each pixel of the camera's picture.
    pub paths_a_pixel: u32,
    /// Pixels a side of that picture.
    pub resolution: usize,
}
