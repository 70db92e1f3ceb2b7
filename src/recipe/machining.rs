//! How a plate is made: machine and passes, kept so that a recipe is enough by itself.

use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use super::pass_angle::PassAngle;
use crate::milling::machine::{Machine, PRESETS};

/// How the plate is made; nothing of it is given where no machine is named.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct MachiningSettings {
    /// From one pass to the next, mm; without it what the polish takes away, else a fiftieth of the cutter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stepover: Option<f64>,
    /// Direction of the passes, degrees from +x toward +y, or the best that is found; without it along x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pass_angle: Option<PassAngle>,
    /// Which way passes are cut; without it one way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pass_order: Option<PassOrder>,
    /// Plates that are proved, each with other random errors of the machine; without it one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub draws: Option<u64>,
    /// Whether the surface as made is written too.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub as_made_stl: bool,
    /// Whether its cutter is worn.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub worn: bool,
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
    use crate::cutter::Cutter;
    use crate::recipe::Recipe;

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
}
