//! A picture that stands on the metal: the settings of a plate of patches, and which plates can be divided so.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::settings::SETTINGS;
use super::{BorderFinish, Recipe, RecipeError};
use crate::patches::dimple::Walls;
use crate::patches::plate::Patches;
use crate::slope::{Slope, direction};

/// What a plate of patches shall show, and to whom. Nothing of it is given for other plates.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct PatchSettings {
    /// The picture that a viewer shall see on the plate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub portrait: Option<String>,
    /// Map of how narrow lobes are: white the narrowest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gloss: Option<String>,
    /// Map of the normals in the middle of lobes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<String>,
    /// Map of how much longer than wide lobes are, and in which direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anisotropy: Option<String>,
    /// Map of the share of light that stays in the lobe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub albedo: Option<String>,
    /// Patches along x and y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<[usize; 2]>,
    /// The viewer, degrees from the plate's normal and azimuth; without it where a flat plate mirrors the lamp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viewer: Option<Angles>,
    /// From the plate's middle to the viewer's eye, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viewer_distance: Option<f64>,
    /// Where light goes that the viewer shall not see; without it to four sides.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spare: Option<Angles>,
    /// Half width of the lobes, degrees of tilt; with a map of gloss that of the narrowest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lobe: Option<f64>,
    /// That of the widest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub widest_lobe: Option<f64>,
}

/// A direction: degrees from the plate's normal, and azimuth from +x.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Angles(pub [f64; 2]);

/// Half width of a lobe unless another is asked for, degrees: at 0.5 m both eyes see it, which are 3.7° of view to either side
/// of the middle, and the head may move as much again.
const LOBE: f64 = 3.0;

/// That of the widest lobe, degrees.
const WIDEST_LOBE: f64 = 8.0;

/// Scatter of the metal of a plate of patches unless one is given, degrees. A bowl is made of flat triangles, and it is what
/// makes a lobe of them: with 1° the likeness of a portrait seen by 700 rays a patch is 0.952, with 1.5° 0.972, with 2° 0.969.
const METAL: f64 = 1.5;

/// Steepest walls, as a slope.
const STEEPEST: f64 = 0.5;

/// Nodes along a side of a patch where the file has room for them: more change nothing that is seen.
const MOST_NODES: usize = 40;

/// The smallest patch, mm: bowls of a hundredth of it would be as small as a wavelength.
const LEAST_PATCH: f64 = 0.2;

/// Smallest features across a patch at the least.
const FEATURES: f64 = 20.0;

/// Settings that a plate of patches has besides its own.
const SHARED: [&str; 18] = [
    "light",
    "light-radius",
    "encoding",
    "invert",
    "rotate",
    "fit",
    "size",
    "thickness",
    "border",
    "lobe",
    "grid",
    "max-triangles",
    "for-cutter",
    "flutes",
    "worn-tip",
    "min-feature",
    "seed",
    "rays",
];

impl PatchSettings {
    /// Whether a plate of patches is asked for.
    pub fn are_wanted(&self) -> bool {
        self.portrait.is_some() || self.has_maps()
    }

    /// Whether it is asked for by maps.
    pub fn has_maps(&self) -> bool {
        [&self.gloss, &self.normal, &self.anisotropy, &self.albedo].iter().any(|map| map.is_some())
    }
}

impl Angles {
    /// As a unit vector from the plate.
    pub fn direction(self) -> glam::DVec3 {
        let [theta, phi] = self.0.map(f64::to_radians);
        direction(theta, phi)
    }
}

impl Recipe {
    /// The viewer of a plate of patches: as asked, else where a flat plate mirrors the lamp.
    pub fn viewer(&self) -> Angles {
        self.patches.viewer.unwrap_or(Angles([self.light.theta, (self.light.phi + 180.0).rem_euclid(360.0)]))
    }

    /// From the plate's middle to the viewer's eye, mm: as asked, or half a metre.
    pub fn viewer_distance(&self) -> f64 {
        self.patches.viewer_distance.unwrap_or(500.0)
    }

    /// Half widths of the narrowest and the widest lobe of patches, as slopes.
    pub fn patch_lobes(&self) -> [f64; 2] {
        let narrow = self.patches.lobe.unwrap_or(LOBE);
        let wide = self.patches.widest_lobe.unwrap_or(WIDEST_LOBE.max(narrow));
        [narrow, wide].map(|degrees| degrees.to_radians().tan())
    }

    /// Whether the metal's scatter is to be chosen for a plate of patches.
    pub fn needs_patch_metal(&self) -> bool {
        self.patches.are_wanted() && self.plate.lobe == 0.0
    }

    /// The same recipe, with metal of a scatter that makes a lobe of the triangles of a bowl, if it was given none.
    pub fn with_patch_metal(mut self) -> Self {
        if self.needs_patch_metal() {
            self.plate.lobe = METAL;
        }
        self
    }

    /// How the plate is divided into patches.
    pub fn patches(&self) -> Patches {
        let size = DVec2::from(self.plate.size);
        let count = self.patches.count.unwrap_or_else(|| {
            // As square as they can be, 60 along the longer side or of 1 mm.
            let patch = (size.max_element() / 60.0).max(1.0);
            [size.x, size.y].map(|side| ((side / patch).round() as usize).max(1))
        });
        let budget = self.plate.max_triangles.map_or(3e6, |most| 0.98 * most as f64);
        let fitting = (budget / (2.0 * (count[0] * count[1]) as f64)).sqrt() as usize;
        let nodes = self.plate.grid.unwrap_or((fitting / 2 * 2).min(MOST_NODES));
        Patches { count, size, nodes }
    }

    /// What is around the bowls. Light that has met a wall shall meet no second one, on its way to the viewer or from the lamp:
    /// a wall of tilt a turns light by 2a, and the wall across the patch is as steep.
    pub fn patch_walls(&self) -> Walls {
        let lowest = self.light.theta.max(self.viewer().0[0]);
        let steep = ((90.0 - lowest) / 3.0).to_radians().tan().min(STEEPEST);
        let spare = self.spare_slope();
        // The walls must be steeper than what they stand around.
        let steep = spare.map_or(steep, |spare| steep.max(2.0 * spare.to_vec().abs().max_element()));
        Walls { half: 0.5 * self.patches().patch(), steep, spare }
    }

    /// The slope that mirrors the lamp to where spare light goes.
    fn spare_slope(&self) -> Option<Slope> {
        Slope::reflecting(self.setup().light(), self.patches.spare?.direction())
    }

    /// Refuses settings of patches that cannot be made, or that stand beside those of other plates.
    pub(super) fn check_patches(&self) -> Result<(), RecipeError> {
        let given = |setting: &&super::settings::Setting| setting.is_given(self);
        let own = |name: &str| SETTINGS.iter().any(|s| s.name == name && s.key.starts_with("patches."));
        if !self.patches.are_wanted() {
            let alone = SETTINGS.iter().filter(|setting| own(setting.name)).find(given);
            return alone.map_or(Ok(()), |setting| Err(RecipeError::NoPatches { setting: setting.name }));
        }
        if self.patches.portrait.is_some() && self.patches.has_maps() {
            return Err(RecipeError::PortraitAndMaps);
        }
        let foreign = |setting: &&super::settings::Setting| {
            given(setting) && !own(setting.name) && !SHARED.contains(&setting.name)
        };
        if let Some(setting) = SETTINGS.iter().find(foreign) {
            return Err(RecipeError::NotOfPatches { setting: setting.name });
        }
        if self.is_near() {
            return Err(RecipeError::NotOfPatches { setting: "scene" });
        }
        if self.goal.is_some() || self.border_finish() != BorderFinish::Matt {
            return Err(RecipeError::NotOfPatches {
                setting: if self.goal.is_some() { "goal" } else { "border-finish" },
            });
        }
        self.check_division()
    }

    fn check_division(&self) -> Result<(), RecipeError> {
        let patches = self.patches();
        let side = patches.patch().min_element();
        let least = self.design.sheet.min_feature.map_or(LEAST_PATCH, |feature| LEAST_PATCH.max(FEATURES * feature));
        if side < least {
            let fewer = patches.size / least;
            return Err(RecipeError::SmallPatches {
                side,
                least,
                most: [fewer.x, fewer.y].map(|n| n.max(1.0) as usize),
            });
        }
        if patches.patch().max_element() > 2.0 * side {
            let DVec2 { x, y } = patches.patch();
            return Err(RecipeError::LongPatches { across: x, up: y });
        }
        if patches.nodes < 12 || !patches.nodes.is_multiple_of(2) {
            return Err(RecipeError::PatchNodes { nodes: patches.nodes });
        }
        let triangles = 2.0 * (patches.len() * patches.nodes * patches.nodes) as f64;
        if triangles > self.plate.max_triangles.map_or(2e8, |most| most as f64) {
            return Err(RecipeError::PatchNodes { nodes: patches.nodes });
        }
        let walls = self.patch_walls();
        let flatter = walls.spare.is_none_or(|spare| spare.to_vec().length() > 2.0 * self.patch_lobes()[0]);
        let spare = self.patches.spare.is_none() || walls.spare.is_some();
        if walls.steep > 1.0 || !flatter || !spare {
            return Err(RecipeError::Spare);
        }
        self.design.sheet.cutter.map_or(Ok(()), |cutter| Ok(cutter.suits_sheets()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn portrait(text: &str) -> Recipe {
        Recipe::from_toml(&format!("{text}\n[patches]\nportrait = 'a.png'\n")).unwrap()
    }

    #[test]
    fn a_plate_is_divided_as_its_size_and_file_allow() {
        let recipe = portrait("[plate]\nsize = [60, 60]\n[light]\ntheta = 40");
        let patches = recipe.patches();
        assert_eq!((recipe.check(), patches.count, patches.nodes), (Ok(()), [60, 60], 20));
        assert!((recipe.patch_walls().steep.atan().to_degrees() - 50.0 / 3.0).abs() < 1e-9);
        assert_eq!((recipe.viewer(), recipe.viewer_distance()), (Angles([40.0, 180.0]), 500.0));
        assert_eq!(Recipe::from_toml(&recipe.to_toml()).unwrap(), recipe);
        assert_eq!(recipe.with_patch_metal().plate.lobe, 1.5);
        assert_eq!(portrait("[plate]\nsize = [30, 20]").patches().count, [30, 20]);
    }

    #[test]
    fn what_patches_cannot_be_is_refused_with_what_would_do() {
        let refused = |text: &str| portrait(text).check().unwrap_err().to_string();
        assert!(refused("[plate]\ncells = 3").starts_with("cells is not for a plate of patches"));
        assert!(refused("[highlight]\nhalf-field = 12").starts_with("half-field "));
        let small = |count: &str| {
            let mut recipe = portrait("[design]\nmin-feature = 0.05");
            recipe.patches.count = Some(count.parse().map(|n| [n; 2]).unwrap());
            recipe.check()
        };
        assert_eq!(small("30"), Ok(()));
        let said = small("40").unwrap_err();
        assert!(said.is_impossible() && said.to_string().contains("--patches 30x30"), "{said}");
        let mut alone = Recipe::default();
        alone.patches.count = Some([10, 10]);
        assert_eq!(alone.check(), Err(RecipeError::NoPatches { setting: "patches" }));
        let mut both = portrait("");
        both.patches.gloss = Some("b.png".into());
        assert_eq!(both.check(), Err(RecipeError::PortraitAndMaps));
        let mut odd = portrait("");
        odd.plate.grid = Some(21);
        assert_eq!(odd.check(), Err(RecipeError::PatchNodes { nodes: 21 }));
        let mut spare = portrait("");
        spare.patches.spare = Some(Angles([2.0, 0.0]));
        assert_eq!(spare.check(), Err(RecipeError::Spare));
        spare.patches.spare = Some(Angles([35.0, 0.0]));
        assert_eq!(spare.check(), Ok(()));
    }
}
