//! Which files are written beside those of every design.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::Recipe;

pub use crate::export::step::MOST_FACETS as MOST_STEP_FACETS;

/// Files beside those of every design.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct FileSettings {
    /// The plate in other formats too; without it in none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub also: Option<Formats>,
    /// Whether a scene for other renderers is written.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub scene_files: bool,
}

/// A format in which the plate can be written beside its STL file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ, text.
    #[serde(rename = "obj")]
    Obj,
    /// PLY, binary.
    #[serde(rename = "ply")]
    Ply,
    /// 3D Manufacturing Format.
    #[serde(rename = "3mf")]
    ThreeMf,
    /// STEP AP214, planar faces: facets only.
    #[serde(rename = "step")]
    Step,
    /// A 16-bit height map.
    #[serde(rename = "tiff")]
    Tiff,
}

impl Format {
    /// All of them, in the order in which they are written.
    pub const ALL: [Self; 5] = [Self::Obj, Self::Ply, Self::ThreeMf, Self::Step, Self::Tiff];

    /// How it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::ThreeMf => "3mf",
            Self::Step => "step",
            Self::Tiff => "tiff",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Format {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Self, FormatError> {
        let found = Self::ALL.into_iter().find(|format| format.name() == text.trim());
        found.ok_or_else(|| FormatError(text.trim().to_owned()))
    }
}

impl Recipe {
    /// Whether the plate is written in this format too.
    pub fn writes(&self, format: Format) -> bool {
        self.files.also.as_ref().is_some_and(|also| also.has(format))
    }
}

/// Formats, each once; on the command line with commas between.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Formats(Vec<Format>);

impl Formats {
    /// Whether it is among them.
    pub fn has(&self, format: Format) -> bool {
        self.0.contains(&format)
    }
}

impl From<Vec<Format>> for Formats {
    fn from(mut formats: Vec<Format>) -> Self {
        formats.sort_unstable();
        formats.dedup();
        Self(formats)
    }
}

impl fmt::Display for Formats {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0.iter().map(|format| format.name()).collect::<Vec<_>>().join(","))
    }
}

impl FromStr for Formats {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Self, FormatError> {
        text.split(',').map(Format::from_str).collect::<Result<Vec<_>, _>>().map(Self::from)
    }
}

/// A word that is no format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no format that a plate is written in: write {all}, or several with commas between", all = all())]
pub struct FormatError(String);

fn all() -> String {
    let [first @ .., last] = Format::ALL.map(Format::name);
    format!("{} or {last}", first.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_written_as_they_are_read_each_once_and_in_order() {
        assert_eq!("3mf, obj,obj".parse::<Formats>().unwrap().to_string(), "obj,3mf");
        for text in ["", "obj,,ply", "stl", "OBJ"] {
            let error = text.parse::<Formats>().unwrap_err().to_string();
            assert!(error.contains("obj, ply, 3mf") && error.contains(" or tiff"), "{error}");
        }
        let recipe = Recipe::from_toml("[files]\nalso = [\"tiff\", \"obj\"]\n").unwrap();
        let also = recipe.files.also.clone().unwrap();
        assert!(also.has(Format::Tiff) && also.has(Format::Obj) && !also.has(Format::Ply));
        assert_eq!(Recipe::from_toml(&recipe.to_toml()), Ok(recipe));
        assert!(!Recipe::default().to_toml().contains("files"));
    }
}
