//! From words and files to reflectance.

use std::fs::File;
use std::io::{self, BufReader, Read as _};
use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use thiserror::Error;

use super::spec::{GoalFile, GoalSpec};
use super::{Reflectance, of_model};
use crate::brdf::model::lafortune::{LafortuneLobe, lafortune};
use crate::brdf::model::microfacets::{Microfacets, Shadowing};
use crate::brdf::model::painted::{PaintedError, PaintedNormals};
use crate::export::brdf_csv::{BrdfCsvError, read_brdf_csv};
use crate::export::bsdf::{BsdfReadError, read_bsdf};
use crate::export::merl::{Merl, MerlError};
use crate::picture::{self, PictureError, Reading};
use crate::slope::direction;

/// What a spec stands for.
pub(super) struct Read {
    pub all: Reflectance,
    /// Without what scatters evenly; `None` if nothing is left.
    pub specular: Option<Reflectance>,
    pub notes: Vec<String>,
    pub is_isotropic: bool,
    /// Of measured data, what was taken as scattering evenly, 1/sr.
    pub even: f64,
}

/// Largest file that is read, bytes: a CSV of 16 × 16 incident directions and 128 × 64 cells has 100 MB.
const LARGEST: u64 = 1 << 30;

/// Reads it.
pub(super) fn read(spec: &GoalSpec) -> Result<Read, GoalError> {
    let (kind, path, tilt) = match spec {
        GoalSpec::Model(model) => {
            return Ok(Read {
                all: of_model(model.clone()),
                specular: model.without_base().map(of_model),
                notes: Vec::new(),
                is_isotropic: model.is_isotropic(),
                even: 0.0,
            });
        }
        GoalSpec::File { kind, path, tilt } => (*kind, path.as_path(), tilt.unwrap_or(GoalSpec::TILT)),
    };
    let name = path.display().to_string();
    match kind {
        GoalFile::Ndf => {
            let picture = picture::read(path, &Reading::default())?;
            let normals = PaintedNormals::new(&picture.light, tilt.to_radians());
            let normals = normals.map_err(|source| GoalError::Normals { name, source })?;
            let all = of_model(Microfacets { normals, shadowing: Shadowing::Smith });
            Ok(Read { specular: Some(all.clone()), all, notes: picture.notes, is_isotropic: false, even: 0.0 })
        }
        GoalFile::Lafortune => {
            let lobes = lobes(path)?;
            let isotropic = lobes.iter().all(|lobe| lobe.direction.x == lobe.direction.y);
            let model = lafortune(lobes).ok_or_else(|| GoalError::Lobes { name, what: "no [[lobe]]".into() })?;
            let all = of_model(model);
            Ok(Read { specular: Some(all.clone()), all, notes: Vec::new(), is_isotropic: isotropic, even: 0.0 })
        }
        GoalFile::Merl => {
            let merl =
                Merl::read(&mut BufReader::new(open(path)?)).map_err(|source| GoalError::Merl { name, source })?;
            let invalid = merl.invalid_share();
            let notes = vec![format!(
                "{:.1} % of the file's cells are invalid, as for directions that were not measured; they count as dark.",
                100.0 * invalid
            )];
            // Rec. 709: what an eye makes of red, green and blue.
            let all: Reflectance = Arc::new(move |wi, wo| {
                let channel = |k| merl.at(k, wi, wo);
                let value = 0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2);
                if value.is_finite() { value } else { 0.0 }
            });
            Ok(measured(all, notes, true))
        }
        GoalFile::Bsdf => {
            let mut bytes = Vec::new();
            let read = open(path)?.take(LARGEST).read_to_end(&mut bytes);
            read.map_err(|source| GoalError::Unreadable { name: name.clone(), source })?;
            let table = read_bsdf(&bytes).map_err(|source| GoalError::Bsdf { name, source })?;
            let isotropic = table.axes().is_isotropic();
            Ok(measured(Arc::new(move |wi, wo| table.at(wi, wo)), Vec::new(), isotropic))
        }
        GoalFile::Csv => {
            let table = read_brdf_csv(&text(path, LARGEST)?).map_err(|source| GoalError::Csv { name, source })?;
            let isotropic = table.axes().is_isotropic();
            Ok(measured(Arc::new(move |wi, wo| table.at(wi, wo)), Vec::new(), isotropic))
        }
    }
}

/// Measured data with its even part told apart: the least value that viewers within 60° of the normal see under a lamp at 60°,
/// whose half vectors lie farther from the normal than lobes reach.
fn measured(all: Reflectance, notes: Vec<String>, is_isotropic: bool) -> Read {
    let light = direction(f64::to_radians(60.0), 0.0);
    let mut values: Vec<f64> = (0..24 * 36)
        .map(|k| all(light, direction(f64::to_radians(2.5 * (k % 24) as f64), f64::to_radians(10.0 * (k / 24) as f64))))
        .filter(|value| value.is_finite() && *value > 0.0)
        .collect();
    values.sort_by(f64::total_cmp);
    // One cell in fifty may be noise.
    let even = values.get(values.len() / 50).copied().unwrap_or(0.0);
    let whole = all.clone();
    let specular: Reflectance = Arc::new(move |wi, wo| (whole(wi, wo) - even).max(0.0));
    let left = values.iter().any(|value| *value > even);
    Read { all, specular: left.then_some(specular), notes, is_isotropic, even }
}

/// The lobes of a TOML file: `[[lobe]]` tables with `c = [Cx, Cy, Cz]` and `n`.
fn lobes(path: &Path) -> Result<Vec<LafortuneLobe>, GoalError> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Lobes {
        lobe: Vec<Lobe>,
    }
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Lobe {
        c: [f64; 3],
        n: f64,
    }
    let name = path.display().to_string();
    let wrong = |what: String| GoalError::Lobes { name: name.clone(), what };
    let read: Lobes = toml::from_str(&text(path, 1 << 20)?).map_err(|error| wrong(error.message().to_owned()))?;
    let lobe = |lobe: Lobe| {
        let sound = lobe.c.iter().all(|c| (-10.0..=10.0).contains(c)) && (0.0..=1e5).contains(&lobe.n);
        let lobe = LafortuneLobe { direction: lobe.c.into(), exponent: lobe.n };
        sound.then_some(lobe).ok_or_else(|| wrong("c must be -10 to 10 and n 0 to 100000".into()))
    };
    read.lobe.into_iter().map(lobe).collect()
}

fn open(path: &Path) -> Result<File, GoalError> {
    let name = || path.display().to_string();
    let unreadable = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => GoalError::Missing(name()),
        _ => GoalError::Unreadable { name: name(), source },
    };
    let about = path.metadata().map_err(unreadable)?;
    if !about.is_file() {
        return Err(GoalError::NotAFile(name()));
    }
    File::open(path).map_err(unreadable)
}

fn text(path: &Path, most: u64) -> Result<String, GoalError> {
    let mut text = String::new();
    let read = open(path)?.take(most).read_to_string(&mut text);
    read.map_err(|source| GoalError::Unreadable { name: path.display().to_string(), source })?;
    Ok(text)
}

/// Why there is no such goal.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GoalError {
    /// Nothing has this name.
    #[error("{0}: there is no such file; check the path")]
    Missing(String),
    /// A folder or a device.
    #[error("{0}: this is no file; name a file")]
    NotAFile(String),
    /// The system refuses, or the bytes are no text.
    #[error("{name}: the file cannot be read ({source}); check what it is and its permissions")]
    Unreadable {
        /// The file.
        name: String,
        /// What the system says.
        source: io::Error,
    },
    /// No MERL file.
    #[error("{name}: {source}")]
    Merl {
        /// The file.
        name: String,
        /// Why.
        source: MerlError,
    },
    /// No `.bsdf`.
    #[error("{name}: {source}")]
    Bsdf {
        /// The file.
        name: String,
        /// Why.
        source: BsdfReadError,
    },
    /// No CSV of the program's.
    #[error("{name}: {source}")]
    Csv {
        /// The file.
        name: String,
        /// Why.
        source: BrdfCsvError,
    },
    /// A picture that is no density of normals.
    #[error("{name}: {source}")]
    Normals {
        /// The file.
        name: String,
        /// Why.
        source: PaintedError,
    },
    /// Lobes that are none.
    #[error("{name}: these are no lobes ({what}); write [[lobe]] with c = [-0.9, -0.9, 1.0] and n = 20 for each")]
    Lobes {
        /// The file.
        name: String,
        /// What is wrong.
        what: String,
    },
    /// No picture.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// Mirrors make nothing of it.
    #[error("{0} only scatters evenly, and a plate of mirrors cannot: name a lobe, or take --goal-part all")]
    OnlyBase(String),
    /// Dark where the lamp would show it.
    #[error("the goal sends no light of this lamp above the plate: change --light or the goal")]
    Dark,
}
