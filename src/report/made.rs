//! What is said of a plate as a machine makes it.

use serde::Serialize;

use super::on_wall::WallScores;
use super::scores::Scores;
use crate::cutter::Cutter;
use crate::milling::machine::Machine;
use crate::milling::made::Machining;

/// By what a plate is made, and how.
#[derive(Clone, Debug, Serialize)]
pub struct MachiningFacts {
    /// The machine.
    pub machine: Machine,
    /// The cutter.
    pub cutter: Cutter,
    /// From one finishing pass to the next, mm.
    pub stepover_mm: f64,
    /// Direction of the finishing passes from +x toward +y, degrees.
    pub pass_angle_deg: f64,
    /// Whether every other finishing pass is cut on the way back.
    pub zigzag: bool,
    /// Standard deviation of the polish afterwards, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polish_mm: Option<f64>,
    /// Height of the cusps between passes over a level plate, µm.
    pub cusp_height_um: f64,
}

impl From<&Machining> for MachiningFacts {
    fn from(machining: &Machining) -> Self {
        let Machining { machine, cutter, passes, polish, .. } = machining;
        Self {
            machine: machine.clone(),
            cutter: *cutter,
            stepover_mm: passes.stepover,
            // Without what the way through radians left.
            pass_angle_deg: (1e9 * passes.angle.to_degrees()).round() / 1e9,
            zigzag: passes.zigzag,
            polish_mm: *polish,
            cusp_height_um: 1000.0 * machining.cusp_height(),
        }
    }
}

/// Light over a plate as a machine makes it.
#[derive(Clone, Debug, Serialize)]
pub struct MadeFacts {
    /// Its figures, in the first draw of the machine's errors.
    #[serde(flatten)]
    pub scores: Scores,
    /// In each draw, the share of the light that is misplaced or lost at a blur of 1°.
    pub tv_incident_1deg_by_draw: Vec<f64>,
    /// How it was made.
    #[serde(flatten)]
    pub machining: MachiningFacts,
    /// Share of the light within half a degree of where a level plate throws it, less what the drawing has there.
    pub central_spot: f64,
    /// Time of the finishing passes, hours.
    pub finishing_hours: f64,
    /// Its light on the wall, in a scene that has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_wall: Option<WallScores>,
}
