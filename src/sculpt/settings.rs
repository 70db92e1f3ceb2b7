//! What a sheet can be told. The struct is part of the recipe as it stands, and goes whole to the objective.

use serde::{Deserialize, Serialize};

use crate::cutter::Cutter;

/// What a sheet can be told; `None` is what was not given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
pub struct SheetSettings {
    /// The cutter that the plate is proved for, and a sheet shaped for; without it, the valleys of one are as
    /// sharp as its triangles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutter: Option<Cutter>,
    /// Polish or paint after the cutter, which smooths the heights of a sheet by a Gaussian of this standard
    /// deviation, mm.
    #[serde(alias = "levelling", with = "zero_is_none")]
    pub polish: Option<f64>,
    /// Details of a sheet narrower than this are left out, mm.
    #[serde(with = "zero_is_none")]
    pub min_feature: Option<f64>,
    /// The most from the lowest to the highest point of a cell of a sheet about its mean plane, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_depth: Option<f64>,
    /// Whether it is a preview: on few nodes, by few steps, and never a plate to be made.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub preview: bool,
}

/// Recipes have always written 0 where nothing was given.
mod zero_is_none {
    use serde::{Deserialize, Deserializer, Serializer};

    pub(crate) fn serialize<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(value.unwrap_or(0.0))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
        Ok(Some(f64::deserialize(deserializer)?).filter(|value| *value != 0.0))
    }
}
