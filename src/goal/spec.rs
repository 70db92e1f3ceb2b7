//! How a goal is asked for.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::brdf::model::named::{Named, NamedError, names};

/// Which part of a reflectance is the goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GoalPart {
    /// Without what scatters evenly, which no plate of mirrors does.
    #[default]
    Specular,
    /// All of it.
    All,
}

/// A kind of file that holds reflectance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalFile {
    /// Lobes in TOML.
    Lafortune,
    /// MERL's table of an isotropic BRDF.
    Merl,
    /// RGL's table, as Mitsuba's `measured` reads it.
    Bsdf,
    /// The text that `measure --brdf` writes.
    Csv,
    /// A painted density of normals.
    Ndf,
}

impl GoalFile {
    const ALL: [Self; 5] = [Self::Lafortune, Self::Merl, Self::Bsdf, Self::Csv, Self::Ndf];

    const fn name(self) -> &'static str {
        match self {
            Self::Lafortune => "lafortune",
            Self::Merl => "merl",
            Self::Bsdf => "bsdf",
            Self::Csv => "csv",
            Self::Ndf => "ndf",
        }
    }
}

/// A goal in words: a model by name as in `ward:0.1,0.3`, or a kind and its file as in `merl:gold.binary`; behind a painted
/// density of normals the tilt of its rim may stand, as in `ndf:star.png,30`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum GoalSpec {
    /// By name.
    Model(Named),
    /// In a file.
    File {
        /// What it holds.
        kind: GoalFile,
        /// The file.
        path: PathBuf,
        /// Of a painted density of normals, the tilt of its rim, degrees.
        tilt: Option<f64>,
    },
}

impl GoalSpec {
    /// Tilt of the rim of a painted density of normals, degrees, where none is given: light is thrown up to 60° aside.
    pub const TILT: f64 = 30.0;

    /// The file, if it is in one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Model(_) => None,
            Self::File { path, .. } => Some(path),
        }
    }

    /// The same with its file at `path`.
    pub fn with_path(&self, path: PathBuf) -> Self {
        match self {
            Self::Model(_) => self.clone(),
            Self::File { kind, tilt, .. } => Self::File { kind: *kind, path, tilt: *tilt },
        }
    }
}

impl FromStr for GoalSpec {
    type Err = GoalSpecError;

    fn from_str(text: &str) -> Result<Self, GoalSpecError> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        // A model of that name begins with a number.
        let numbers = rest.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) && !rest.contains(".toml");
        let Some(kind) = GoalFile::ALL.into_iter().find(|own| own.name() == kind.trim().to_lowercase()) else {
            return text.parse().map(Self::Model).map_err(|error| match error {
                NamedError::Unknown(word) => GoalSpecError::Unknown(word),
                other => GoalSpecError::Model(other),
            });
        };
        if kind == GoalFile::Lafortune && numbers {
            return Ok(Self::Model(text.parse()?));
        }
        let tilted = rest.rsplit_once(',').and_then(|(path, tilt)| Some((path, tilt.trim().parse::<f64>().ok()?)));
        let (path, tilt) = match tilted.filter(|_| kind == GoalFile::Ndf) {
            Some((path, tilt)) => (path, Some(tilt)),
            None => (rest, None),
        };
        if path.is_empty() {
            return Err(GoalSpecError::NoFile(kind.name()));
        }
        match tilt.filter(|tilt| !(1.0..=90.0).contains(tilt)) {
            Some(tilt) => Err(GoalSpecError::Tilt(tilt)),
            None => Ok(Self::File { kind, path: path.into(), tilt }),
        }
    }
}

impl fmt::Display for GoalSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model(model) => write!(f, "{model}"),
            Self::File { kind, path, tilt } => {
                write!(f, "{}:{}", kind.name(), path.display())?;
                tilt.map_or(Ok(()), |tilt| write!(f, ",{tilt}"))
            }
        }
    }
}

impl TryFrom<String> for GoalSpec {
    type Error = GoalSpecError;

    fn try_from(text: String) -> Result<Self, GoalSpecError> {
        text.parse()
    }
}

impl From<GoalSpec> for String {
    fn from(spec: GoalSpec) -> Self {
        spec.to_string()
    }
}

/// Why a text is no goal.
#[derive(Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum GoalSpecError {
    /// Neither a model nor a kind of file.
    #[error(
        "'{0}' is no goal; known are the models {known}, and the files merl:FILE.binary, bsdf:FILE.bsdf, csv:FILE, lafortune:FILE.toml and \
         ndf:PICTURE",
        known = names()
    )]
    Unknown(String),
    /// A kind of file without one.
    #[error("'{0}' takes a file, as in {0}:FILE")]
    NoFile(&'static str),
    /// A rim where none can be.
    #[error("the rim of a map of normals must be 1 to 90 degrees from the plate's own, not {0}")]
    Tilt(f64),
    /// No such model.
    #[error(transparent)]
    Model(#[from] NamedError),
}
