//! Every setting with its default, saved as TOML, and the main job from a recipe to a plate.

mod check;

mod kind;

use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize};

pub use check::RecipeError;
pub use kind::SurfaceKind;

use crate::brdf::material::{Material, Substance};
use crate::brdf::microfacet::Lobe;
pub use crate::cutter::{Cutter, CutterError};
use crate::distribution::SlopeDistributionSettings;
use crate::facets::arrange::anneal::{Annealing, Energy};
use crate::facets::sample::Sampling;
use crate::highlight::Quantity;
use crate::picture::{Encoding, PictureFit, Reading};
use crate::projection::Projection;
use crate::sculpt::plan::SheetSettings;
use crate::sculpt::plan::suitable_grid;
use crate::setup::Setup;
use crate::sharpen::BlurKernel;

/// All that a design depends on. The same recipe gives the same bytes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Recipe {
    /// The picture of the highlight, as named by the user; relative to the working folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
    /// How the picture is read, and what it means.
    pub highlight: HighlightSettings,
    /// The lamp.
    pub light: LightSettings,
    /// The plate.
    pub plate: PlateSettings,
    /// How slopes are found, drawn, ordered and raised.
    pub design: DesignSettings,
    /// How the plate is proved.
    pub verify: VerifySettings,
}

/// What the picture means.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct HighlightSettings {
    /// Angle from the picture's middle to its rim, degrees.
    pub half_field: f64,
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
            half_field: 20.0,
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
    /// The whole highlight is repeated in this many cells along each side; without it, as suits the kind of relief.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<usize>,
    /// Solid metal under the lowest point, mm.
    pub thickness: f64,
    /// Flat rim around the optical area, mm.
    pub border: f64,
    /// Scatter of the polished base metal, degrees: standard deviation, along each axis, of what it adds to the
    /// direction of light mirrored at normal incidence. 0 is a perfect mirror.
    pub lobe: f64,
    /// Kind of relief; without it, flat if a setting asks for facets, else continuous.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceKind>,
    /// Nodes along each side of a cell of a sheet; without it, as suits picture, cutter and file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<usize>,
    /// Triangles of a sheet at the most, on the whole plate; without it 3 million.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_triangles: Option<usize>,
}

impl Default for PlateSettings {
    fn default() -> Self {
        Self {
            size: [30.0, 30.0],
            facets: None,
            cells: None,
            thickness: 5.0,
            border: 0.0,
            lobe: 0.0,
            surface: None,
            grid: None,
            max_triangles: None,
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
    /// The cutter that the plate is proved for, and a sheet shaped for; without it, the valleys of one are as
    /// sharp as its triangles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutter: Option<Cutter>,
    /// Polish or paint after the cutter, which smooths the heights of a sheet by a Gaussian of this standard
    /// deviation, mm.
    #[serde(alias = "levelling")]
    pub polish: f64,
    /// Details of a sheet narrower than this are left out, mm.
    pub min_feature: f64,
    /// The most that a cell of a sheet may rise about its mean plane, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_depth: Option<f64>,
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
            cutter: None,
            polish: 0.0,
            min_feature: 0.0,
            max_depth: None,
            distribution: SlopeDistributionSettings::default(),
            annealing: None,
        }
    }
}

/// Ways to order facets on the plate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct VerifySettings {
    /// Rays sent.
    pub rays: u64,
}

impl Default for VerifySettings {
    fn default() -> Self {
        Self { rays: 2_000_000 }
    }
}

impl Recipe {
    /// Every choice as in the 2009 paper.
    pub fn weyrich2009() -> Self {
        let mut recipe = Self::default();
        recipe.design.arrange = Some(Arrangement::Anneal);
        // A valley a little dearer than in our reading of the printed weights, and the best of three runs: measured on
        // two spirals and six seeds, A_v falls to 0.39 to 0.62 of random order and V to 0.39 to 0.47 (paper: 0.55, 0.46).
        let annealing = Annealing { energy: Energy::Weyrich2009, swaps: 7_000_000, starts: 3, valleys: 1.15 };
        recipe.design.annealing = Some(annealing);
        recipe.design.heights = Some(Heights::Weyrich2009);
        recipe.design.distribution = SlopeDistributionSettings { slope_cap: 65.0, level: true };
        recipe
    }

    /// Facets along x and y: as asked, or 30 each way.
    pub fn facets(&self) -> [usize; 2] {
        self.plate.facets.unwrap_or([30, 30])
    }

    /// How facets are drawn.
    pub fn sampling(&self) -> Sampling {
        self.design.sample.unwrap_or_default()
    }

    /// Which facet goes where.
    pub fn arrangement(&self) -> Arrangement {
        self.design.arrange.unwrap_or_default()
    }

    /// How facets are annealed, where they are.
    pub fn annealing(&self) -> Annealing {
        self.design.annealing.unwrap_or_default()
    }

    /// Triangles of a sheet at the most.
    pub fn most_triangles(&self) -> usize {
        self.plate.max_triangles.unwrap_or(3_000_000)
    }

    /// How heights are found: as asked, or cyclic where the arrangement is cyclic.
    pub fn heights(&self) -> Heights {
        self.design.heights.unwrap_or(match self.arrangement() {
            Arrangement::Anneal => Heights::Cyclic,
            Arrangement::Transport | Arrangement::Random => Heights::Free,
        })
    }

    /// Cells along x and y: as asked; else one dome of facets, and about nine cells of a sheet, as square as
    /// the plate lets them be.
    pub fn cells(&self) -> [usize; 2] {
        let usual = || match self.surface() {
            SurfaceKind::Facets => [1, 1],
            SurfaceKind::Sheet => {
                let [x, y] = self.plate.size;
                let side = (x * y / 9.0).sqrt().min(x).min(y);
                [x, y].map(|length| (length / side).round() as usize)
            }
        };
        self.plate.cells.map_or_else(usual, |cells| [cells; 2])
    }

    /// What a sheet of this recipe shall be.
    pub fn sculpting(&self) -> SheetSettings {
        let PlateSettings { size, grid, .. } = self.plate;
        let cells = self.cells();
        let cell = glam::DVec2::from(size) / glam::DVec2::from(cells.map(|n| n as f64));
        let cutter = self.design.cutter;
        let grid = grid.unwrap_or_else(|| suitable_grid(cell, cells, cutter, self.most_triangles()));
        let DesignSettings { polish, min_feature, max_depth, seed, .. } = self.design;
        SheetSettings { cell, cells, grid, cutter, polish, min_feature, max_depth, seed }
    }

    /// How the picture file is to be read.
    pub fn reading(&self) -> Reading {
        let HighlightSettings { encoding, invert, rotate, fit, seen, .. } = self.highlight;
        Reading { encoding, invert, rotate, fit, mirrored: seen == Seen::OnWall }
    }

    /// Light, image and a plate lying flat.
    pub fn setup(&self) -> Setup {
        let LightSettings { theta, phi, radius } = self.light;
        let HighlightSettings { projection, half_field, .. } = self.highlight;
        let [theta, phi, radius, half_field] = [theta, phi, radius, half_field].map(f64::to_radians);
        Setup::new(theta, phi, radius, projection, half_field)
    }

    /// What the lamp of `setup` and the plate's metal blur, if they do.
    pub fn blur(&self, setup: &Setup) -> Option<BlurKernel> {
        BlurKernel::new(setup, self.plate.lobe.to_radians())
    }

    /// What the plate is made of: a mirror that takes no light, with Gaussian microscopic slopes if it has a lobe.
    ///
    /// A tilt by t throws light 2t aside, so that their standard deviation is half the lobe's, and Beckmann's α is √2
    /// times that. Below [`Lobe::ALPHA`](crate::brdf::microfacet::Lobe::ALPHA), about 0.08°, it is smooth.
    pub fn metal(&self) -> Material {
        let slope = 0.5 * self.plate.lobe.to_radians();
        let lobe = Lobe::beckmann_of_rms(slope, slope).ok();
        Material::new(Substance::Mirror, lobe).unwrap_or_default()
    }

    /// Size of a facet, mm.
    pub fn pitch(&self) -> glam::DVec2 {
        let (size, facets) = (self.plate.size, self.facets());
        glam::DVec2::new(size[0] / facets[0] as f64, size[1] / facets[1] as f64)
    }

    /// As TOML.
    pub fn to_toml(&self) -> String {
        // Plain tables of numbers, words and one path: a path that is not UTF-8 is the one thing that cannot be said.
        toml::to_string_pretty(self).unwrap_or_else(|error| format!("# not representable: {error}\n"))
    }

    /// From TOML; what is not said keeps its default, what is not known is an error.
    pub fn from_toml(text: &str) -> Result<Self, RecipeError> {
        toml::from_str(text).map_err(|error| RecipeError::Unreadable(error.message().to_owned(), line_of(text, &error)))
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

fn line_of(text: &str, error: &toml::de::Error) -> usize {
    let before = error.span().map_or(0, |span| span.start);
    text.as_bytes().iter().take(before).filter(|b| **b == b'\n').count() + 1
}
