//! The report of a verification.

use serde::Serialize;

use super::design::MilledFacts;
use super::on_wall::OnWallFacts;
use super::scores::Scores;
use super::{MeshFacts, PictureFacts};
use crate::brdf::material::Material;
use crate::cutter::Cutter;
use crate::milling::machine::Machine;
use crate::recipe::{HighlightSettings, LightSettings};

/// Light over any mesh, scored against a picture.
#[derive(Clone, Debug, Serialize)]
pub struct VerifyReport {
    /// The program and its version.
    pub program: &'static str,
    /// The mesh.
    pub plate: MeshFacts,
    /// The drawing.
    pub picture: PictureFacts,
    /// How the drawing is laid out.
    pub highlight: HighlightSettings,
    /// The lamp.
    pub light: LightSettings,
    /// Scatter of the metal, degrees.
    pub lobe_deg: f64,
    /// The metal as a material.
    pub metal: Material,
    /// Rim that is no optical area, mm.
    pub margin_mm: f64,
    /// What that rim would throw into the picture if it were polished, as a share of the light on the optical area; in no
    /// other figure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin_into_picture_if_polished: Option<f64>,
    /// Light on the wall, if lamp or wall are near.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_wall: Option<OnWallFacts>,
    /// The figures.
    pub measured: Scores,
    /// The same of the plate as its recipe's cutter leaves it, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_milled: Option<MilledFacts>,
    /// The same of the plate as a machine makes it, if one is named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_made: Option<MadeFacts>,
    /// What was allowed, and what came of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<Allowed>,
    /// How the light came out, in a sentence.
    pub verdict: String,
    /// What a person should know; empty if nothing is off.
    pub advice: Vec<String>,
}

/// Light over a plate as a machine makes it.
#[derive(Clone, Debug, Serialize)]
pub struct MadeFacts {
    /// Its figures, in the first draw of the machine's errors.
    #[serde(flatten)]
    pub scores: Scores,
    /// In each draw, the share of the light that is misplaced or lost at a blur of 1°.
    pub tv_incident_1deg_by_draw: Vec<f64>,
    /// The machine.
    pub machine: Machine,
    /// The cutter.
    pub cutter: Cutter,
    /// From one pass to the next, mm.
    pub stepover_mm: f64,
    /// Direction of the passes from +x toward +y, degrees.
    pub pass_angle_deg: f64,
    /// Whether every other pass is cut on the way back.
    pub zigzag: bool,
    /// Standard deviation of the polish afterwards, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polish_mm: Option<f64>,
    /// Height of the cusps between passes over a level plate, µm.
    pub cusp_height_um: f64,
    /// Share of the light within half a degree of where a level plate throws it, less what the drawing has there.
    pub central_spot: f64,
    /// Time of the finishing passes, hours.
    pub finishing_hours: f64,
}

/// How much light may go astray, and how much does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Allowed {
    /// The most that may, as a share of the incident light.
    pub share: f64,
    /// The blur through which it is seen, degrees.
    pub blur_deg: f64,
    /// What is misplaced or lost.
    pub tv_incident: f64,
    /// Whether that is of the plate as milled.
    pub as_milled: bool,
    /// Whether that is of the plate as a machine makes it.
    pub as_made: bool,
    /// Whether it is no more than may be.
    pub kept: bool,
}
