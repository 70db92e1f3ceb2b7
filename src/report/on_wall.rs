//! What is said of a plate in its room: lamp, wall, and the light on it in millimetres.

use serde::Serialize;

use super::Named;
use crate::verify::verdict::Figure;
use crate::verify::wall_verdict::WallVerdict;

/// A plate in its room.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OnWallFacts {
    /// The lamp in words.
    pub lamp: String,
    /// The wall in words.
    pub wall: String,
    /// From the plate's middle to the lamp, mm; nothing if it is endlessly far.
    pub lamp_distance_mm: Option<f64>,
    /// From the plate's middle to that of the picture, mm.
    pub wall_distance_mm: f64,
    /// Side of the picture's square on the wall, mm.
    pub picture_mm: f64,
    /// Focal length of the bowl that lamp and wall ask for, mm: 1/f = 1/lamp + 1/wall.
    pub focus_mm: f64,
    /// How deep that bowl is, mm.
    pub sag_mm: f64,
    /// From the picture's middle to where the flat plate would throw the light, mm.
    pub mirror_miss_mm: Option<f64>,
    /// From the eye to the wall, mm.
    pub eye_distance_mm: f64,
    /// Blur of that eye on the wall, a standard deviation, mm.
    pub eye_blur_mm: f64,
    /// Nearest and farthest wall in focus, the lamp where it is, mm; nothing where it stays in focus.
    pub in_focus_mm: Option<[Option<f64>; 2]>,
    /// Misplaced light at a blur of 0.5° up to which it counts as in focus.
    pub in_focus_tv: Option<f64>,
    /// The same plate under the sun.
    pub under_sun: Option<UnderSun>,
    /// Misplaced light of single cells at a blur of 0.5°.
    pub cells_tv: Option<CellsOnWall>,
    /// What diffraction leaves of the picture, of a sheet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diffraction: Option<DiffractionOnWall>,
    /// Share of the picture's light that the lamp's housing, 30 mm across or as large as the lamp, stops.
    pub stopped_by_lamp: f64,
    /// The light as designed.
    pub designed: WallScores,
    /// The light as the cutter leaves the plate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_milled: Option<WallScores>,
}

/// The same plate under the sun, on the wall that is sharp there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UnderSun {
    /// Distance of that wall, mm.
    pub wall_mm: f64,
    /// Misplaced light at a blur of 0.5°.
    pub tv: f64,
}

/// What diffraction by the smallest patches on which the light depends leaves of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DiffractionOnWall {
    /// Width of such a patch, mm.
    pub smallest_patch_mm: f64,
    /// By how much it spreads light on the wall, mm at half brightness.
    pub its_spread_mm: f64,
    /// Likeness to the drawing at the eye's blur if all light were spread so: the truth lies between this and `ssim`.
    pub ssim_eye_if_all_spread: f64,
}

/// Misplaced light of single cells.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CellsOnWall {
    /// On average.
    pub mean: f64,
    /// Of the worst.
    pub largest: f64,
}

/// The figures of light on a wall, under `eye`, `0.5deg` and `1deg`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WallScores {
    /// Misplaced or lost light.
    pub tv_incident: Named,
    /// Structural similarity.
    pub ssim: Named,
    /// Share of the light within the picture's square.
    pub in_picture: f64,
    /// Share of the light that meets the wall far beside the picture or not at all.
    pub lost: f64,
    /// What an eye sees of the difference and a blur of 0.5° does not, over the drawing's mean where it is lit.
    pub grain: f64,
    /// One standard error of each.
    pub error: Named,
}

impl From<&WallVerdict> for WallScores {
    fn from(verdict: &WallVerdict) -> Self {
        let rows = [("eye", verdict.eye), ("0.5deg", verdict.at[0]), ("1deg", verdict.at[1])];
        let tv = rows.map(|(name, at)| (name.to_owned(), at.tv));
        let ssim = rows.map(|(name, at)| (name.to_owned(), at.ssim));
        let values = |figures: &[(String, Figure)]| figures.iter().map(|(name, f)| (name, f.value)).collect();
        let named = |what: &str, figures: &[(String, Figure)]| {
            figures.iter().map(|(name, f)| (format!("{what}_{name}"), f.error)).collect::<Vec<_>>()
        };
        let rest = [("in_picture", verdict.in_picture), ("lost", verdict.lost), ("grain", verdict.grain)];
        let rest = rest.map(|(name, figure)| (name.to_owned(), figure.error));
        Self {
            tv_incident: values(&tv),
            ssim: values(&ssim),
            in_picture: verdict.in_picture.value,
            lost: verdict.lost.value,
            grain: verdict.grain.value,
            error: named("tv", &tv).into_iter().chain(named("ssim", &ssim)).chain(rest).collect(),
        }
    }
}
