//! How a plate is made: machine and passes, kept so that a recipe is enough by itself.

use std::fmt;

use glam::DVec2;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use super::settings::{SETTINGS, Section};
use super::{Recipe, RecipeError, SurfaceKind};
use crate::cutter::Cutter;
use crate::milling::machine::{Machine, PRESETS};
use crate::milling::made::Machining;
use crate::milling::passes::Passes;

/// Passes so many standard deviations of the polish apart leave nothing of their cusps.
const CUSPS_GONE: f64 = 2.0;

/// Of a cutter that is not polished after, the passes for each diameter: cusps then cost about as much as a good machine.
const PASSES_A_DIAMETER: f64 = 50.0;

/// How the plate is made; nothing of it is given where no machine is named.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct MachiningSettings {
    /// From one pass to the next, mm; without it what the polish takes away, else a fiftieth of the cutter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stepover: Option<f64>,
    /// Direction of the passes, degrees from +x toward +y; without it along x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pass_angle: Option<f64>,
    /// Which way passes are cut; without it one way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pass_order: Option<PassOrder>,
    /// Plates that are proved, each with other random errors of the machine; without it one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub draws: Option<u64>,
    /// Whether the surface as made is written too.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub as_made_stl: bool,
    /// The machine: a preset by its name, any other by its values.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "written", deserialize_with = "read")]
    pub machine: Option<Machine>,
}

/// Which way passes are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PassOrder {
    /// All from the same side.
    OneWay,
    /// Every other one on the way back.
    Zigzag,
}

impl MachiningSettings {
    /// How a plate is made with `cutter`, polished by `polish` mm, the machine's errors drawn from `seed`; `None` without a
    /// machine.
    ///
    /// # Errors
    /// Values out of range, settings without a machine, or a machine without a cutter.
    pub fn machining(
        &self,
        cutter: Option<Cutter>,
        polish: Option<f64>,
        seed: u64,
    ) -> Result<Option<Machining>, RecipeError> {
        let mut alone = Recipe { machining: self.clone(), ..Recipe::default() };
        let own = || SETTINGS.iter().filter(|setting| setting.section == Section::Machining);
        own().try_for_each(|setting| setting.check(&mut alone))?;
        let Some(machine) = &self.machine else {
            let given = own().find(|setting| setting.is_given(&alone));
            return given.map_or(Ok(None), |setting| Err(RecipeError::NoMachine { setting: setting.name }));
        };
        machine.check().map_err(|error| RecipeError::Machine(error.to_string()))?;
        let cutter = cutter.ok_or(RecipeError::NoCutter)?;
        let polish = polish.filter(|polish| *polish != 0.0);
        let usual = match polish {
            Some(sigma) => (CUSPS_GONE * sigma).min(0.5 * cutter.reach()),
            None => cutter.tip_diameter() / PASSES_A_DIAMETER,
        };
        let passes = Passes {
            angle: self.pass_angle.unwrap_or(0.0).to_radians(),
            stepover: self.stepover.unwrap_or(usual),
            zigzag: self.pass_order == Some(PassOrder::Zigzag),
        };
        Ok(Some(Machining { machine: machine.clone(), cutter, passes, polish, seed }))
    }
}

impl Recipe {
    /// Plates that are proved as made: as asked, or one.
    pub fn draws(&self) -> u64 {
        self.machining.draws.unwrap_or(1)
    }

    /// How its plate is made, if a machine is named.
    ///
    /// # Errors
    /// It cannot be made so.
    pub fn machining(&self) -> Result<Option<Machining>, RecipeError> {
        let sheet = &self.design.sheet;
        let machining = self.machining.machining(sheet.cutter, sheet.polish, self.design.seed)?;
        if let Some(machining) = &machining {
            if self.machining.as_made_stl && machining.polish.is_none() && self.surface() == SurfaceKind::Sheet {
                return Err(RecipeError::NoPolish);
            }
            if self.is_near() {
                return Err(RecipeError::MachineNearby);
            }
            machining.check(DVec2::from(self.plate.size))?;
        }
        Ok(machining)
    }
}

fn written<S: Serializer>(machine: &Option<Machine>, serializer: S) -> Result<S::Ok, S::Error> {
    match machine {
        Some(machine) if Machine::preset(&machine.name).as_ref() == Some(machine) => {
            serializer.serialize_str(&machine.name)
        }
        machine => machine.serialize(serializer),
    }
}

fn read<'de, D: Deserializer<'de>>(toml: D) -> Result<Option<Machine>, D::Error> {
    struct NameOrValues;
    impl<'de> Visitor<'de> for NameOrValues {
        type Value = Machine;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            write!(f, "a machine's name, or a table of its values")
        }

        fn visit_str<E: Error>(self, name: &str) -> Result<Machine, E> {
            let unknown = || E::custom(format!("machine '{name}' is none of {}", PRESETS.join(", ")));
            Machine::preset(name).ok_or_else(unknown)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Machine, A::Error> {
            Machine::deserialize(MapAccessDeserializer::new(map))
        }
    }
    toml.deserialize_any(NameOrValues).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_is_kept_by_its_name_or_by_all_of_its_values() {
        let mut recipe = Recipe::default();
        recipe.design.sheet.cutter = Some(Cutter::ball(0.5));
        recipe.machining.machine = Machine::preset("vmc");
        let text = recipe.to_toml();
        assert!(text.contains("machine = \"vmc\"") && !text.contains("backlash-z"), "{text}");
        assert_eq!(Recipe::from_toml(&text).as_ref(), Ok(&recipe));
        recipe.machining.machine = Machine::preset("vmc").map(|vmc| Machine { backlash_z: 0.001, ..vmc });
        let text = recipe.to_toml();
        assert!(text.contains("backlash-z = 0.001"), "{text}");
        assert_eq!(Recipe::from_toml(&text).as_ref(), Ok(&recipe));
        assert_eq!(recipe.machining().unwrap().unwrap().machine.backlash_z, 0.001);
        let unknown = Recipe::from_toml("[machining]\nmachine = 'lathe'\n").unwrap_err().to_string();
        assert!(unknown.contains("lathe") && unknown.contains("desktop-good"), "{unknown}");
    }

    #[test]
    fn what_is_not_said_of_passes_follows_from_cutter_and_polish() {
        let mut recipe = Recipe::default();
        assert_eq!(recipe.machining(), Ok(None));
        recipe.machining.stepover = Some(0.02);
        assert_eq!(recipe.machining(), Err(RecipeError::NoMachine { setting: "stepover" }));
        recipe.machining.machine = Machine::preset("vmc");
        assert_eq!(recipe.check(), Err(RecipeError::NoCutter));
        recipe.design.sheet.cutter = Some(Cutter::ball(0.5));
        let stepover = |recipe: &Recipe| recipe.machining().unwrap().unwrap().passes.stepover;
        assert_eq!(stepover(&recipe), 0.02);
        recipe.machining.stepover = None;
        assert_eq!(stepover(&recipe), 0.01);
        recipe.design.sheet.polish = Some(0.04);
        assert_eq!(stepover(&recipe), 0.08);
        (recipe.design.sheet.polish, recipe.machining.as_made_stl) = (None, true);
        assert_eq!(recipe.machining(), Err(RecipeError::NoPolish));
        (recipe.machining.as_made_stl, recipe.machining.stepover) = (false, Some(0.3));
        let wide = recipe.check().unwrap_err();
        assert!(wide.is_impossible() && wide.to_string().contains("0.25"), "{wide}");
        (recipe.machining.stepover, recipe.scene.wall) = (None, Some(500.0));
        assert_eq!(recipe.machining(), Err(RecipeError::MachineNearby));
    }
}
