//! The report of a verification.

use serde::Serialize;

use super::design::MilledFacts;
use super::goal::GoalFacts;
use super::made::MadeFacts;
use super::on_wall::OnWallFacts;
use super::scores::Scores;
use super::{MeshFacts, PictureFacts};
use crate::brdf::material::Material;
use crate::recipe::{HighlightSettings, LightSettings};

/// Light over any mesh, scored against a picture or the slice of a goal.
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
    /// The goal, if a folder's recipe has one in place of a picture, and the plate beside it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<GoalFacts>,
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
