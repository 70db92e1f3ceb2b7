//! The cutter that a plate is proved for, and a sheet designed for, written as on the command line: `ball:0.5`.

use std::fmt;
use std::str::FromStr;

use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize, Serializer};

/// A ball-nosed cutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutter {
    /// Diameter of the ball, mm.
    pub diameter: f64,
}

impl Cutter {
    /// Radius of the ball, mm.
    pub fn radius(self) -> f64 {
        0.5 * self.diameter
    }
}

impl fmt::Display for Cutter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ball:{}", self.diameter)
    }
}

impl FromStr for Cutter {
    type Err = CutterError;

    fn from_str(text: &str) -> Result<Self, CutterError> {
        let diameter = text.trim().strip_prefix("ball:").and_then(|d| d.parse().ok());
        diameter.map(|diameter| Self { diameter }).ok_or_else(|| CutterError(text.to_owned()))
    }
}

impl Serialize for Cutter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Cutter {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

/// Not a cutter.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("'{0}' is no cutter: write ball: and its diameter in mm, such as ball:0.5")]
pub struct CutterError(String);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cutters_are_written_as_they_are_read() {
        for text in ["ball:0.5", "ball:1", "ball:12.25"] {
            assert_eq!(text.parse::<Cutter>().unwrap().to_string(), text);
        }
        for text in ["", "0.5", "ball", "ball:", "ball:half", "cone:30", "ball 0.5"] {
            assert_eq!(text.parse::<Cutter>(), Err(CutterError(text.into())));
        }
    }
}
