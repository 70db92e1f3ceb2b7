//! What becomes of the rim around the optical area: `matt`, `polished`, `sloped` or `sloped:12`.

use std::fmt;
use std::str::FromStr;

use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize, Serializer};

/// How the rim is finished. Flat and polished it is a mirror like the optical area, and throws its light into the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum BorderFinish {
    /// Flat and left dull: blasted, sanded or painted. It counts as dark.
    #[default]
    Matt,
    /// Flat and polished with the rest: its light counts.
    Polished,
    /// Polished, its sides falling outward by this many degrees; without them by the least that passes the picture.
    Sloped(Option<f64>),
}

impl fmt::Display for BorderFinish {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Matt => f.write_str("matt"),
            Self::Polished => f.write_str("polished"),
            Self::Sloped(None) => f.write_str("sloped"),
            Self::Sloped(Some(degrees)) => write!(f, "sloped:{degrees}"),
        }
    }
}

impl FromStr for BorderFinish {
    type Err = BorderFinishError;

    fn from_str(text: &str) -> Result<Self, BorderFinishError> {
        let unknown = || BorderFinishError(text.to_owned());
        match text.trim() {
            "matt" => Ok(Self::Matt),
            "polished" => Ok(Self::Polished),
            "sloped" => Ok(Self::Sloped(None)),
            other => {
                let degrees = other.strip_prefix("sloped:").and_then(|degrees| degrees.parse().ok());
                degrees.map(|degrees| Self::Sloped(Some(degrees))).ok_or_else(unknown)
            }
        }
    }
}

impl Serialize for BorderFinish {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for BorderFinish {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

/// Not a finish.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("'{0}' is no finish of a border: write matt, polished, sloped, or sloped: and its degrees, such as sloped:12")]
pub struct BorderFinishError(String);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finishes_are_written_as_they_are_read() {
        for text in ["matt", "polished", "sloped", "sloped:12.5"] {
            assert_eq!(text.parse::<BorderFinish>().unwrap().to_string(), text);
        }
        for text in ["", "dull", "sloped:", "sloped:steep", "matt:3"] {
            assert_eq!(text.parse::<BorderFinish>(), Err(BorderFinishError(text.into())));
        }
    }
}
