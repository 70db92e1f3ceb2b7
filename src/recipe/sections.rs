//! The parts of a recipe, each a table of its TOML.

use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize};

use super::{BorderFinish, Cells, HalfField, SurfaceKind};
use crate::distribution::SlopeDistributionSettings;
use crate::facets::arrange::anneal::Annealing;
use crate::facets::sample::Sampling;
use crate::highlight::Quantity;
use crate::picture::{Encoding, PictureFit};
use crate::projection::Projection;
use crate::sculpt::settings::SheetSettings;

/// What the picture means.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct HighlightSettings {
    /// Angle from the picture's middle to its rim, degrees.
    pub half_field: HalfField,
    /// How directions are laid out on the picture.
    pub projection: Projection,
    /// What a pixel's value says.
    pub quantity: Quantity,
    /// From which side the picture is looked at.
    pub seen: Seen,
    /// How pixel values stand for light.
    pub encoding: Encoding,
    /// Dark is light.
    pub invert: bool,
    /// Turn of the drawing, degrees counter-clockwise.
    pub rotate: f64,
    /// How a picture that is not square fills the field.
    pub fit: PictureFit,
}

impl Default for HighlightSettings {
    fn default() -> Self {
        Self {
            half_field: 20.0.into(),
            projection: Projection::default(),
            quantity: Quantity::default(),
            seen: Seen::default(),
            encoding: Encoding::default(),
            invert: false,
            rotate: 0.0,
            fit: PictureFit::default(),
        }
    }
}

/// From which side the highlight image is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Seen {
    /// A map of viewers seen from above the plate.
    #[default]
    FromAbove,
    /// Thrown on a ceiling or wall and looked at from the plate's side: mirrored.
    OnWall,
}

/// One distant lamp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct LightSettings {
    /// Angle from the plate's normal, degrees.
    pub theta: f64,
    /// Azimuth from +x, counter-clockwise seen from above, degrees.
    pub phi: f64,
    /// Angular radius, degrees: 0 is ideal, the sun has 0.2665.
    pub radius: f64,
}

/// The piece of metal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct PlateSettings {
    /// Optical area along x and y, mm.
    #[serde(deserialize_with = "pair")]
    pub size: [f64; 2],
    /// Facets along x and y, on the whole plate; without it 30 each way.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_pair")]
    pub facets: Option<[usize; 2]>,
    /// The whole highlight is repeated in this many cells along x and y; without it, as suits the kind of relief.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<Cells>,
    /// Solid metal under the lowest point, mm.
    pub thickness: f64,
    /// Rim around the optical area, mm.
    pub border: f64,
    /// How that rim is finished; without it, left dull.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub border_finish: Option<BorderFinish>,
    /// Scatter of the polished base metal, degrees: standard deviation, along each axis, of what it adds to the
    /// direction of light mirrored at normal incidence. 0 is a perfect mirror.
    pub lobe: f64,
    /// Kind of relief; without it, flat if a setting asks for facets, else continuous.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceKind>,
    /// Nodes along each side of a cell of a sheet; without it, as suits picture, cutter and file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<usize>,
    /// Triangles of a sheet's file at the most; without it as many as its light needs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_triangles: Option<usize>,
    /// A sheet's file has all triangles of its grid, however large it is.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub fine: bool,
}

impl Default for PlateSettings {
    fn default() -> Self {
        Self {
            size: [30.0, 30.0],
            facets: None,
            cells: None,
            thickness: 5.0,
            border: 0.0,
            border_finish: None,
            lobe: 0.0,
            surface: None,
            grid: None,
            max_triangles: None,
            fine: false,
        }
    }
}

/// How the relief comes about.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct DesignSettings {
    /// How facets are drawn from the distribution; without it in centroidal cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample: Option<Sampling>,
    /// Which facet goes where; without it by transport.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arrange: Option<Arrangement>,
    /// How heights follow from slopes; without it, as suits the arrangement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heights: Option<Heights>,
    /// What a sheet can be told.
    #[serde(flatten)]
    pub sheet: SheetSettings,
    /// How deep the cutter can go, mm, if that is known: no relief is to be deeper.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flutes: Option<f64>,
    /// Diameter of the flat that wear leaves on the cutter's tip, mm, if that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worn_tip: Option<f64>,
    /// Seed of everything random.
    pub seed: u64,
    /// The slope distribution.
    pub distribution: SlopeDistributionSettings,
    /// The annealing of facets, where it is not the usual one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub annealing: Option<Annealing>,
}

impl Default for DesignSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            sample: None,
            arrange: None,
            heights: None,
            sheet: SheetSettings::default(),
            flutes: None,
            worn_tip: None,
            distribution: SlopeDistributionSettings::default(),
            annealing: None,
        }
    }
}

/// Ways to order facets on the plate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Arrangement {
    /// Optimal transport: a dome without valleys.
    #[default]
    Transport,
    /// The 2009 paper's simulated annealing on a cyclic grid.
    Anneal,
    /// No order, for comparison.
    Random,
}

/// Ways to raise facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Heights {
    /// Smallest steps in the mean square, edges free.
    Free,
    /// Smallest steps on a plate that continues into itself.
    Cyclic,
    /// The Poisson equation as printed in the 2009 paper, cyclic.
    Weyrich2009,
}

impl Heights {
    /// Whether opposite rims are neighbours.
    pub fn is_cyclic(self) -> bool {
        self != Self::Free
    }
}

/// How the plate is proved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct VerifySettings {
    /// Rays sent.
    pub rays: u64,
    /// From the eye to the wall, mm; without it 3 m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eye_distance: Option<f64>,
}

impl Default for VerifySettings {
    fn default() -> Self {
        Self { rays: 2_000_000, eye_distance: None }
    }
}

/// Exactly two values: TOML's own reading of an array ignores what is too many.
fn pair<'de, T: Deserialize<'de>, D: Deserializer<'de>>(toml: D) -> Result<[T; 2], D::Error> {
    let values = Vec::<T>::deserialize(toml)?;
    values.try_into().map_err(|v: Vec<T>| D::Error::invalid_length(v.len(), &"two numbers, along x and y"))
}

fn some_pair<'de, T: Deserialize<'de>, D: Deserializer<'de>>(toml: D) -> Result<Option<[T; 2]>, D::Error> {
    pair(toml).map(Some)
}
