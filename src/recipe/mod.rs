//! Every setting with its default, saved as TOML.

mod border_finish;

mod sections;

mod scene;

mod derived;

pub mod settings;

mod check;

mod kind;

use serde::{Deserialize, Serialize};

pub use crate::cutter::{Cutter, CutterError};
pub use border_finish::{BorderFinish, BorderFinishError};
pub use check::RecipeError;
pub use kind::SurfaceKind;
pub use scene::{NearMethod, SceneFault, SceneSettings};
pub use sections::{
    Arrangement, DesignSettings, Heights, HighlightSettings, LightSettings, PlateSettings, Seen, VerifySettings,
};

use crate::distribution::SlopeDistributionSettings;
use crate::facets::arrange::anneal::{Annealing, Energy};

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
    /// Lamp and wall nearby, if they are.
    #[serde(skip_serializing_if = "is_far")]
    pub scene: SceneSettings,
    /// The plate.
    pub plate: PlateSettings,
    /// How slopes are found, drawn, ordered and raised.
    pub design: DesignSettings,
    /// How the plate is proved.
    pub verify: VerifySettings,
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

fn is_far(scene: &SceneSettings) -> bool {
    *scene == SceneSettings::default()
}

fn line_of(text: &str, error: &toml::de::Error) -> usize {
    let before = error.span().map_or(0, |span| span.start);
    text.as_bytes().iter().take(before).filter(|b| **b == b'\n').count() + 1
}
