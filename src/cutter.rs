//! The cutter that mills a plate: its profile, from which everything else that is known of it follows.
//!
//! A cutter turns about its axis, so that its shape is one curve, the height of its underside above its tip over the
//! distance from the axis:
//!
//! ```text
//!     height │ \         /        ball of radius R:  R - √(R² - r²)  for r ≤ R
//!            │  \       /
//!            │   `-._.-'
//!            └──────┴──────► r
//! ```
//!
//! Proofs of what is milled ask for this curve alone. The design of a sheet has a model of valleys that follow a
//! paraboloid, z = r²/2R: [`suits_sheets`](Cutter::suits_sheets) refuses a cutter that has no such tip.
//!
//! A cutter is written as on the command line, `ball:0.5`. Another shape is one more variant here.

use std::fmt;
use std::str::FromStr;

use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize, Serializer};

/// A cutter, by its shape.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Cutter {
    /// A ball-nosed cutter.
    Ball {
        /// Diameter of the ball, mm.
        diameter: f64,
    },
}

impl Cutter {
    /// A ball-nosed cutter of `diameter` mm.
    pub fn ball(diameter: f64) -> Self {
        Self::Ball { diameter }
    }

    /// Largest diameter that cuts, mm.
    pub fn diameter(self) -> f64 {
        match self {
            Self::Ball { diameter } => diameter,
        }
    }

    /// Distance from the axis beyond which it touches nothing, mm.
    pub fn reach(self) -> f64 {
        0.5 * self.diameter()
    }

    /// Height of the underside above the tip at `r` mm from the axis, mm; infinite beyond the reach.
    pub fn underside(self, r: f64) -> f64 {
        // What rounding puts a hair beyond the reach belongs to its rim.
        if r.abs() > self.reach() * (1.0 + 1e-12) {
            return f64::INFINITY;
        }
        match self {
            Self::Ball { diameter } => {
                let radius = 0.5 * diameter;
                radius - (radius * radius - r * r).max(0.0).sqrt()
            }
        }
    }

    /// Distance from the axis, mm, of the point that touches a plane of the given slope: on the side to which it climbs.
    pub fn contact(self, slope: f64) -> f64 {
        match self {
            Self::Ball { diameter } => 0.5 * diameter * slope / slope.hypot(1.0),
        }
    }

    /// Radius of the paraboloid that the tip follows, mm: no valley that it leaves is rounder than this.
    pub fn valley_radius(self) -> f64 {
        match self {
            Self::Ball { diameter } => 0.5 * diameter,
        }
    }

    /// Refuses, by name, a cutter of whose valleys the design of a sheet has no model.
    pub fn suits_sheets(self) -> Result<(), UnmodelledCutter> {
        // A tip without a radius, or with one that ends before its flank begins, would be taken for a ball.
        match self {
            Self::Ball { .. } => Ok(()),
        }
    }
}

impl fmt::Display for Cutter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ball { diameter } => write!(f, "ball:{diameter}"),
        }
    }
}

impl FromStr for Cutter {
    type Err = CutterError;

    fn from_str(text: &str) -> Result<Self, CutterError> {
        let diameter = text.trim().strip_prefix("ball:").and_then(|d| d.parse().ok());
        diameter.map(Self::ball).ok_or_else(|| CutterError(text.to_owned()))
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

/// A cutter that sheets cannot be designed for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("no sheet can be designed for the cutter {0} yet: name a ball, such as ball:0.5, or take facets")]
pub struct UnmodelledCutter(pub Cutter);

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

    #[test]
    fn a_balls_underside_is_its_sphere_and_near_the_tip_its_paraboloid() {
        let ball = Cutter::ball(0.5);
        // 0.25² = 0.15² + 0.2².
        assert!((ball.underside(0.15) - 0.05).abs() < 1e-15 && ball.underside(-0.15) == ball.underside(0.15));
        assert_eq!((ball.underside(0.0), ball.underside(ball.reach())), (0.0, 0.25));
        assert_eq!(ball.underside(0.26), f64::INFINITY);
        let paraboloid = 0.01 * 0.01 / (2.0 * ball.valley_radius());
        assert!((ball.underside(0.01) / paraboloid - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_slope_is_touched_where_the_underside_has_it() {
        let ball = Cutter::ball(0.5);
        for slope in [-1.2, -0.3, 0.0, 0.1, 0.75] {
            let (r, d) = (ball.contact(slope), 1e-6);
            let there = (ball.underside(r + d) - ball.underside(r - d)) / (2.0 * d);
            assert!((there - slope).abs() < 1e-6, "{slope}: {there}");
        }
    }
}
