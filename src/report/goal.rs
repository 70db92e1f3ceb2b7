//! What is said of a goal and of the plate beside it.

use serde::Serialize;

use crate::goal::spec::GoalPart;
use crate::verify::verdict::Figure;

/// A goal and its proof.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GoalFacts {
    /// As it was asked for.
    pub spec: String,
    /// Which part of it was wanted.
    pub part: GoalPart,
    /// Share of the design's light that it reflects, its even part included.
    pub albedo: f64,
    /// Share of that which is left out: what scatters evenly.
    pub left_out: f64,
    /// Goal and plate under lamps at several angles.
    pub slices: Vec<GoalSlice>,
    /// The proof in a sentence, if light was sent.
    pub verdict: Option<String>,
    /// The same of the plate as its cutter and polish leave it, if it has them and light was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_milled: Option<MilledGoalFacts>,
}

/// A goal and the plate beside it as its cutter and polish leave it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MilledGoalFacts {
    /// Goal and plate under the same lamps as the plate as designed.
    pub slices: Vec<GoalSlice>,
    /// The proof in a sentence, beside that of the plate as designed.
    pub verdict: String,
}

/// Goal and plate under one lamp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GoalSlice {
    /// The lamp from the plate's normal, degrees.
    pub theta: f64,
    /// Its azimuth, degrees.
    pub phi: f64,
    /// Share of light that lies elsewhere on the plate than in the goal, cosine-weighted, at a blur of 1°.
    pub tv_1deg: Figure,
    /// The same between the goal and mirrors that make its slice at the design's lamp: what no plate of mirrors can follow.
    pub mirrors_cannot: f64,
    /// The same between those mirrors and the plate: the rest, shadows and second bounces among it.
    pub rest: Figure,
    /// Share of light that the wanted part of the goal reflects.
    pub albedo_goal: f64,
    /// Share of light that leaves the plate upward, its mirror share taken as 1.
    pub albedo_plate: f64,
}
