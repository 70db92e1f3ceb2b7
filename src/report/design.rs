//! The report of a design.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::goal::GoalFacts;
use super::made::MadeFacts;
use super::on_wall::OnWallFacts;
use super::scores::Scores;
use super::thinned::ThinnedFacts;
pub use super::windows::{DiffractionFacts, MisplacedFacts, WindowFacts};
use super::{Named, PictureFacts};
use crate::brdf::material::Material;
use crate::cutter::Cutter;
use crate::recipe::{BorderFinish, Recipe};
use crate::sculpt::start::Start;

/// Everything that is known of a design.
#[derive(Clone, Debug, Serialize)]
pub struct DesignReport {
    /// The program and its version.
    pub program: &'static str,
    /// The drawing.
    pub picture: PictureFacts,
    /// Every setting.
    pub recipe: Recipe,
    /// What of the drawing can be lit, and how brightly.
    pub highlight: HighlightFacts,
    /// What lamp and metal blur.
    pub blur: BlurFacts,
    /// The plate.
    pub design: PlateFacts,
    /// How far lamp and wall must be for its figures to hold, if it was made for endlessly far ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds_beyond: Option<HoldsBeyond>,
    /// Light on the wall, if lamp or wall are near and light was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_wall: Option<OnWallFacts>,
    /// Its rim, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rim: Option<RimFacts>,
    /// Its file.
    pub stl: StlFacts,
    /// Light over the plate as designed, if any was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub designed: Option<Scores>,
    /// Windows of a sheet, if light was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub windows_tv_1deg: Option<WindowFacts>,
    /// Of a sheet, if light was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diffraction: Option<DiffractionFacts>,
    /// Light over the plate as its cutter leaves it, if there is one and light was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_milled: Option<MilledFacts>,
    /// The same of the plate as a machine makes it, if one is named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_made: Option<MadeFacts>,
    /// The sheet beside facets, if they were compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beside_facets: Option<BesideFacets>,
    /// The goal, if it was asked for in place of a picture, and the plate beside it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<GoalFacts>,
    /// How the light came out, in a sentence, if any was sent: that of the plate as it is made or cut, if it has a machine or
    /// a cutter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<String>,
    /// What a person should know; empty if nothing is off.
    pub advice: Vec<String>,
}

impl DesignReport {
    /// What the relief is made of, in words.
    pub fn made_of(&self) -> String {
        made_of(&self.recipe, self.design.continuous.as_ref().map(|sheet| sheet.cells))
    }
}

/// What a relief is made of, in words; `cells` are those of a sheet.
pub fn made_of(recipe: &Recipe, cells: Option<[usize; 2]>) -> String {
    match cells {
        None => {
            let [across, up] = recipe.facets();
            format!("{across} × {up} facets")
        }
        Some([across, up]) => {
            let cutter = recipe.design.sheet.cutter.map(|c| format!(" for {c}")).unwrap_or_default();
            format!("{across} × {up} cells of a sheet{cutter}")
        }
    }
}

/// What of a drawing can be lit, and how brightly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HighlightFacts {
    /// Share of the drawing's light below the plate.
    pub below_plate: f64,
    /// Share of the highlight that needs steeper slopes than allowed.
    pub beyond_cap: f64,
    /// How many times as bright as white paper the brightest spot looks.
    pub brightest_vs_white_paper: f64,
}

/// What lamp and metal blur.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BlurFacts {
    /// Angular radius of the lamp, degrees.
    pub light_radius_deg: f64,
    /// Scatter of the metal, degrees.
    pub lobe_deg: f64,
    /// The metal as a material.
    pub metal: Material,
    /// What sharpening the light against both is worth, if they blur.
    pub sharpening: Option<SharpeningFacts>,
}

/// What sharpening is worth: misplaced light at a blur, under the blur's degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SharpeningFacts {
    /// If the drawing itself is sent.
    pub tv_without: Named,
    /// If the sharpened light is.
    pub tv_with: Named,
    /// Steps of the sharpening.
    pub steps: usize,
}

/// The plate.
#[derive(Clone, Debug, Serialize)]
pub struct PlateFacts {
    /// Its kind, and why it is of that kind.
    pub surface: String,
    /// Sides of a facet, or distance of a sheet's nodes, mm.
    pub pitch_mm: [f64; 2],
    /// From its lowest to its highest point, mm.
    pub relief_height_mm: f64,
    /// Mean slope along x and y.
    pub mean_slope: [f64; 2],
    /// Tilt of that slope, degrees.
    pub mean_slope_deg: f64,
    /// Height that it costs from corner to corner, mm.
    pub mean_slope_costs_mm: f64,
    /// Root mean square of the slopes about their mean.
    pub slope_spread: f64,
    /// How the plate is to be mounted.
    #[serde(flatten)]
    pub mount: Mount,
    /// Height of the walls between facets, root mean square, mm. A sheet has none, and no edges to count as valleys.
    pub step_rms_mm: f64,
    /// The same in sides of a facet.
    pub step_rms_pitch: f64,
    /// Area of the walls over that of the plate.
    pub wall_area_ratio: f64,
    /// Concave edges of facets, pairs across the plate's rim included.
    pub valleys: Option<usize>,
    /// Those inside the plate.
    pub inner_valleys: Option<usize>,
    /// CPU seconds by stage, and in total.
    pub seconds: Named,
    /// Of a sheet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub continuous: Option<SheetFacts>,
    /// Of lamp and wall nearby.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near: Option<NearFacts>,
}

/// How a design follows a lamp and a wall nearby.
#[derive(Clone, Debug, Serialize)]
pub struct NearFacts {
    /// How, and why so.
    pub method: String,
    /// From the plate's middle to the lamp; null if it is endlessly far.
    pub lamp_distance_mm: Option<f64>,
    /// From the plate's middle to that of the picture; null if it is endlessly far.
    pub wall_distance_mm: Option<f64>,
    /// Focal length of the bowl.
    pub focus_mm: f64,
    /// Its height about its mean plane.
    pub sag_mm: f64,
    /// From the picture's middle to where the flat plate would throw the lamp; null without a wall. It costs tilt.
    pub mirror_miss_mm: Option<f64>,
    /// By how much the light of the far design misses, root mean square: as it is, on the bowl, and warped on it.
    pub miss_deg: [f64; 3],
    /// Misplaced light of the model at a blur of 0.5°, before the descent over the whole plate and after each stage.
    pub misplaced_by_stage: Vec<f64>,
}

/// How a plate is to be mounted: the direction of its normal, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mount {
    /// From the drawing's normal; 0 if it is mounted flat.
    #[serde(rename = "mount_theta_deg")]
    pub theta: f64,
    /// Azimuth.
    #[serde(rename = "mount_phi_deg")]
    pub phi: f64,
}

impl Mount {
    /// What a design's `report.json` says; `None` if it is none of a design, or of a version that said nothing.
    pub fn read(report: &str) -> Result<Option<Self>, serde_json::Error> {
        // A map, since a derived struct would take a list for its fields in order.
        #[derive(Deserialize)]
        struct Report {
            design: Option<serde_json::Map<String, Value>>,
        }
        let Some(plate) = serde_json::from_str::<Report>(report)?.design else { return Ok(None) };
        let angle = |key: &str| plate.get(key).cloned().map(serde_json::from_value::<Option<f64>>).transpose();
        let (theta, phi) = (angle("mount_theta_deg")?.flatten(), angle("mount_phi_deg")?.flatten());
        let angles = theta.map(|theta| (theta, phi));
        // One angle without the other is no mounting: NaN, which no range holds.
        Ok(angles.map(|(theta, phi)| Self { theta, phi: phi.unwrap_or(f64::NAN) }))
    }
}

/// A sheet.
#[derive(Clone, Debug, Serialize)]
pub struct SheetFacts {
    /// Nodes along a side of a cell.
    pub grid: usize,
    /// If it is a preview, no plate to be made.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub preview: bool,
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// Sides of a cell, mm.
    pub cell_mm: [f64; 2],
    /// What it is shaped for.
    pub cutter: Option<Cutter>,
    /// The relief that the design began from.
    pub start: Start,
    /// Misplaced light as the design sees it, after each step.
    pub misplaced_by_stage: Vec<f64>,
    /// Share of the plate that fillets fill.
    pub fillet_share: f64,
    /// Light that no relief keeps from straying, with that cutter.
    pub least_stray: Option<StrayFacts>,
    /// The most that a cell rises about its mean plane, mm.
    pub depth_mm: f64,
    /// If the design was told to finish early.
    pub stopped_early: Option<StoppedEarly>,
}

/// Light that no relief keeps from straying.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StrayFacts {
    /// Share of the light, at least.
    pub share: f64,
    /// The gap of the drawing that it falls into, degrees of slope from the mean.
    pub gap_deg: [f64; 2],
    /// Cells along x and y to one period of the lines that show it.
    pub along_cells: [i32; 2],
}

/// How far a design had come that was told to finish early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct StoppedEarly {
    /// Steps that were done.
    pub steps_done: usize,
    /// All steps.
    pub steps: usize,
}

/// How far lamp and wall must be from a plate that knows nothing of them, mm: its own size then blurs by 0.005 rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HoldsBeyond {
    /// Each of them, from the plate.
    pub lamp_and_wall_mm: f64,
    /// The wall, under the sun.
    pub wall_under_sun_mm: f64,
}

/// The rim around the optical area. Shares are of the light that falls on that area, and absent if no light was sent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RimFacts {
    /// Width, mm.
    pub width_mm: f64,
    /// How it is finished.
    pub finish: BorderFinish,
    /// By how much it falls outward, degrees.
    pub slope_deg: f64,
    /// What the shop has to know, in words.
    pub for_the_shop: String,
    /// Light that falls on it.
    pub light_on_it: Option<f64>,
    /// What it throws into the picture, counted in every figure; nothing if it is left dull.
    pub into_picture: Option<f64>,
    /// What it would throw there if it were polished.
    pub into_picture_if_polished: Option<f64>,
    /// Standard error of that.
    pub error: Option<f64>,
}

/// The plate's file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StlFacts {
    /// Unit of its lengths.
    pub units: &'static str,
    /// Triangles.
    pub triangles: usize,
    /// Size, bytes.
    pub bytes: u64,
    /// Height of the base, mm.
    pub z_base_mm: f64,
    /// Lowest point of the relief, mm.
    pub z_low_mm: f64,
    /// Highest point of the relief, mm.
    pub z_high_mm: f64,
    /// If it has fewer triangles than the sheet's grid, what the whole sheet would be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thinned: Option<ThinnedFacts>,
    /// If the file is heavy and light was sent, what the same relief would be in a smaller one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lighter: Option<LighterFacts>,
}

/// The same relief on a coarser grid, as written; misplaced light by first bounces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LighterFacts {
    /// Nodes along a side of a cell.
    pub grid: usize,
    /// Triangles of its file.
    pub triangles: usize,
    /// Size of the file, bytes.
    pub bytes: u64,
    /// Misplaced light of it at a blur of 1°.
    pub tv_incident_1deg: f64,
    /// The same, counted in the same way, of the file that there is.
    pub tv_incident_1deg_of_this: f64,
}

/// Light over the plate as its cutter leaves it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MilledFacts {
    /// Its figures.
    #[serde(flatten)]
    pub scores: Scores,
    /// The most that the cutter stays above the written surface, µm.
    pub left_by_cutter_um: f64,
}

/// A sheet beside facets of the same recipe.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BesideFacets {
    /// Facets along x and y.
    pub facets: [usize; 2],
    /// Whether both were judged as their cutter leaves them.
    pub as_milled: bool,
    /// Misplaced light of either.
    pub tv_incident_1deg: OfEither,
    /// Structural similarity of either.
    pub ssim_1deg: OfEither,
}

/// A figure of facets and of the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OfEither {
    /// Of the facets.
    pub flat: f64,
    /// Of the sheet.
    pub continuous: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mounting_is_read_as_it_is_written() {
        let mount = Mount { theta: 2.5, phi: 108.25 };
        let text = super::super::text(&serde_json::json!({ "program": "x", "design": mount }));
        assert_eq!(Mount::read(&text).unwrap(), Some(mount));
        for (silent, what) in
            [("{}", "of a measurement"), (r#"{"design": {}}"#, "old"), (r#"{"design": null}"#, "empty")]
        {
            assert_eq!(Mount::read(silent).unwrap(), None, "{what}");
        }
        assert!(Mount::read(r#"{"design": {"mount_theta_deg": 3}}"#).unwrap().unwrap().phi.is_nan());
        for broken in
            ["", "[1]", r#"{"design": [1, 2]}"#, r#"{"design": {"mount_theta_deg": "x", "mount_phi_deg": 1}}"#]
        {
            assert!(Mount::read(broken).is_err(), "{broken}");
        }
    }
}
