//! The direction of finishing passes, as a recipe and a flag have it.

use std::fmt;
use std::str::FromStr;

use serde::de::{Deserializer, Error, Visitor};
use serde::{Deserialize, Serialize, Serializer};

/// Direction of the finishing passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PassAngle {
    /// Degrees from +x toward +y.
    Degrees(f64),
    /// The one in which cusps misplace least light of the drawing, which is still to be found; until then along x.
    Best,
}

/// How the best one is spelled.
const BEST: &str = "best";

impl PassAngle {
    /// Degrees from +x toward +y.
    pub fn degrees(self) -> f64 {
        match self {
            Self::Degrees(degrees) => degrees,
            Self::Best => 0.0,
        }
    }
}

impl fmt::Display for PassAngle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Degrees(degrees) => degrees.fmt(f),
            Self::Best => f.write_str(BEST),
        }
    }
}

impl FromStr for PassAngle {
    type Err = PassAngleError;

    fn from_str(text: &str) -> Result<Self, PassAngleError> {
        let degrees = || text.trim().parse().ok().filter(|degrees: &f64| degrees.is_finite()).map(Self::Degrees);
        if text.trim() == BEST { Ok(Self::Best) } else { degrees().ok_or_else(|| PassAngleError(text.to_owned())) }
    }
}

impl Serialize for PassAngle {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Degrees(degrees) => serializer.serialize_f64(*degrees),
            Self::Best => serializer.serialize_str(BEST),
        }
    }
}

impl<'de> Deserialize<'de> for PassAngle {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrWord;
        impl Visitor<'_> for NumberOrWord {
            type Value = PassAngle;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "degrees, or \"{BEST}\"")
            }

            fn visit_f64<E: Error>(self, degrees: f64) -> Result<PassAngle, E> {
                Ok(PassAngle::Degrees(degrees))
            }

            fn visit_i64<E: Error>(self, degrees: i64) -> Result<PassAngle, E> {
                Ok(PassAngle::Degrees(degrees as f64))
            }

            fn visit_u64<E: Error>(self, degrees: u64) -> Result<PassAngle, E> {
                Ok(PassAngle::Degrees(degrees as f64))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<PassAngle, E> {
                text.parse().map_err(E::custom)
            }
        }
        deserializer.deserialize_any(NumberOrWord)
    }
}

/// No direction.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("'{0}' is no direction of passes: write degrees from +x toward +y, such as 45, or best")]
pub struct PassAngleError(String);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::Recipe;

    #[test]
    fn directions_are_written_as_they_are_read() {
        for (text, angle) in
            [("45", PassAngle::Degrees(45.0)), ("-7.5", PassAngle::Degrees(-7.5)), ("best", PassAngle::Best)]
        {
            assert_eq!(text.parse(), Ok(angle));
            assert_eq!(angle.to_string(), text);
        }
        for wrong in ["", "better", "NaN", "inf", "4 5"] {
            assert!(wrong.parse::<PassAngle>().is_err(), "{wrong}");
        }
        for (toml, angle) in
            [("30", PassAngle::Degrees(30.0)), ("2.5", PassAngle::Degrees(2.5)), ("\"best\"", PassAngle::Best)]
        {
            let recipe = Recipe::from_toml(&format!("[machining]\nmachine = \"vmc\"\npass-angle = {toml}\n")).unwrap();
            assert_eq!(recipe.machining.pass_angle, Some(angle));
            let again = Recipe::from_toml(&recipe.to_toml()).unwrap();
            assert_eq!(again.machining.pass_angle, Some(angle));
        }
        let error = Recipe::from_toml("[machining]\nmachine = \"vmc\"\npass-angle = \"north\"\n").unwrap_err();
        assert!(error.to_string().contains("north"), "{error}");
    }
}
