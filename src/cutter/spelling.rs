//! How a cutter is written: its shape, a colon and its sizes with commas between them.

use std::fmt;
use std::str::FromStr;

use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize, Serializer};

use super::Cutter;

/// Largest diameter of an engraving bit or a tapered ball if it is not told, mm: the usual shank of 1/8 inch.
const SHANK: f64 = 3.175;

impl fmt::Display for Cutter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ball { diameter } => write!(f, "ball:{diameter}"),
            Self::BullNose { diameter, corner } => write!(f, "bull:{diameter},{corner}"),
            Self::Flat { diameter } => write!(f, "flat:{diameter}"),
            Self::Cone { angle, tip, diameter } => write!(f, "cone:{angle},{tip},{diameter}"),
            Self::TaperedBall { tip, angle, diameter } => write!(f, "tapered:{tip},{angle},{diameter}"),
        }
    }
}

impl FromStr for Cutter {
    type Err = CutterError;

    fn from_str(text: &str) -> Result<Self, CutterError> {
        let wrong = || CutterError(text.to_owned());
        let (shape, sizes) = text.trim().split_once(':').ok_or_else(wrong)?;
        let sizes: Vec<f64> =
            sizes.split(',').map(|v| v.trim().parse()).collect::<Result<_, _>>().map_err(|_| wrong())?;
        let cutter = match (shape, sizes.as_slice()) {
            ("ball", &[diameter]) => Self::Ball { diameter },
            ("bull", &[diameter, corner]) => Self::BullNose { diameter, corner },
            ("flat", &[diameter]) => Self::Flat { diameter },
            ("cone", &[angle, tip]) => Self::Cone { angle, tip, diameter: SHANK },
            ("cone", &[angle, tip, diameter]) => Self::Cone { angle, tip, diameter },
            ("tapered", &[tip, angle]) => Self::TaperedBall { tip, angle, diameter: SHANK.max(tip) },
            ("tapered", &[tip, angle, diameter]) => Self::TaperedBall { tip, angle, diameter },
            _ => return Err(wrong()),
        };
        if cutter.can_be() { Ok(cutter) } else { Err(wrong()) }
    }
}

impl Cutter {
    /// Whether its sizes fit each other; that of a ball is for ranges to say.
    fn can_be(self) -> bool {
        match self {
            Self::Ball { .. } | Self::Flat { .. } => true,
            Self::BullNose { diameter, corner } => corner > 0.0 && corner <= 0.5 * diameter,
            Self::Cone { angle, tip, diameter } => angle > 0.0 && angle < 180.0 && tip >= 0.0 && tip < diameter,
            Self::TaperedBall { tip, angle, diameter } => angle > 0.0 && angle < 180.0 && tip > 0.0 && tip <= diameter,
        }
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
#[error(
    "'{0}' is no cutter: write ball: and its diameter in mm, such as ball:0.5; other shapes are bull:DIAMETER,CORNER, \
     flat:DIAMETER, cone:ANGLE,TIP and tapered:TIP,ANGLE, in mm and degrees"
)]
pub struct CutterError(String);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cutters_are_written_as_they_are_read() {
        for text in ["ball:0.5", "ball:1", "ball:12.25", "bull:3,0.5", "flat:2", "cone:38,0.1,6", "tapered:0.5,10,3"] {
            assert_eq!(text.parse::<Cutter>().unwrap().to_string(), text);
        }
        assert_eq!("cone:38,0.1".parse::<Cutter>().unwrap().to_string(), "cone:38,0.1,3.175");
        let wrong = [
            "",
            "0.5",
            "ball",
            "ball:",
            "ball:half",
            "cone:30",
            "ball 0.5",
            "ball:1,2",
            "bull:1,0.6",
            "cone:180,0.1",
            "cone:38,4",
            "tapered:0.5,0",
            "drill:3",
        ];
        for text in wrong {
            assert_eq!(text.parse::<Cutter>(), Err(CutterError(text.into())));
        }
    }
}
