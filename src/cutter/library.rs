//! Cutters by name: as they are sold, and as a user's own file has them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Cutter;

/// The built-in cutters.
const SOLD: &str = include_str!("library.toml");

/// Shortest and longest teeth and necks, mm.
const LENGTHS: [f64; 2] = [0.01, 1000.0];

/// Smallest and largest diameter of a cutter, mm.
const DIAMETERS: [f64; 2] = [1e-3, 100.0];

/// Widest flat that wear leaves, mm.
pub const WIDEST_WEAR: f64 = 2.0;

/// A cutter with what is known of it besides its shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", expecting = "{ shape = \"ball:0.5\" } or the like")]
pub struct SoldCutter {
    /// Its shape when it is new.
    pub shape: Cutter,
    /// Length of its teeth, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flutes: Option<f64>,
    /// How far its teeth and a neck thinner than they are reach together, mm, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub neck: Option<f64>,
    /// Diameter of the flat that wear leaves on its tip, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worn_tip: Option<f64>,
}

impl From<Cutter> for SoldCutter {
    fn from(shape: Cutter) -> Self {
        Self { shape, flutes: None, neck: None, worn_tip: None }
    }
}

impl SoldCutter {
    /// How deep it can go, mm, if that is known: as far as its neck, else its teeth, reach.
    pub fn deepest(&self) -> Option<f64> {
        self.neck.or(self.flutes)
    }

    /// What is wrong with it, if anything is.
    fn fault(&self) -> Option<String> {
        let diameter = self.shape.diameter();
        let flat = 2.0 * self.shape.profile().flat;
        let within = [
            ("the diameter", Some(diameter), DIAMETERS),
            ("flutes", self.flutes, LENGTHS),
            // No neck is shorter than the teeth at its end.
            ("neck", self.neck, [self.flutes.unwrap_or(LENGTHS[0]), LENGTHS[1]]),
            // A flat no wider than the new tip's changes nothing.
            ("worn-tip", self.worn_tip, [flat, WIDEST_WEAR.min(diameter)]),
        ];
        within.into_iter().find_map(|(key, value, [least, most])| {
            let value = value.filter(|value| !(least..=most).contains(value))?;
            Some(format!("{key} is {value}, where {least} to {most} mm would do"))
        })
    }
}

/// Cutters by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Library {
    cutters: BTreeMap<String, SoldCutter>,
}

impl Library {
    /// The cutters that are commonly sold.
    pub fn built_in() -> Self {
        // A test reads the same text.
        Self::from_toml(SOLD).unwrap_or_default()
    }

    /// The cutters that a TOML file describes: `name = { shape = "ball:0.5", flutes = 1.0 }`, a line each.
    ///
    /// # Errors
    /// It is no TOML, a name stands there twice or cannot be one, a key is unknown, or a size is none that a cutter has.
    pub fn from_toml(text: &str) -> Result<Self, LibraryError> {
        let line = |error: &toml::de::Error| {
            let before = text.get(..error.span().map_or(0, |span| span.start)).unwrap_or_default();
            1 + before.matches('\n').count()
        };
        let library: Self = toml::from_str(text)
            .map_err(|error| LibraryError::Toml { line: line(&error), what: error.message().to_owned() })?;
        for (name, cutter) in &library.cutters {
            // What has a colon is read as a shape.
            if name.trim().is_empty() || name.contains(|c: char| c == ':' || c.is_control()) {
                return Err(LibraryError::Name(name.clone()));
            }
            if let Some(fault) = cutter.fault() {
                return Err(LibraryError::Cutter { name: name.clone(), fault });
            }
        }
        Ok(library)
    }

    /// These cutters, and `others` over them.
    pub fn with(mut self, others: Self) -> Self {
        self.cutters.extend(others.cutters);
        self
    }

    /// The cutter of this name.
    pub fn get(&self, name: &str) -> Option<&SoldCutter> {
        self.cutters.get(name)
    }

    /// All of them with their names, in the order of these.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &SoldCutter)> {
        self.cutters.iter().map(|(name, cutter)| (name.as_str(), cutter))
    }
}

/// Not a library of cutters.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LibraryError {
    /// The text itself.
    #[error("line {line} makes no sense: {what}")]
    Toml {
        /// Which line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// What cannot be typed for a cutter.
    #[error("'{0}' cannot be a cutter's name: take letters, digits and dashes, without a colon")]
    Name(String),
    /// A size that no cutter has.
    #[error("cutter '{name}': {fault}")]
    Cutter {
        /// Its name.
        name: String,
        /// What is wrong with it.
        fault: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_cutters_are_of_every_shape_and_named_by_their_sizes() {
        let library = Library::from_toml(SOLD).unwrap();
        assert!(library.iter().count() >= 40);
        let mut shapes = Vec::new();
        for (name, cutter) in library.iter() {
            let spelled = cutter.shape.to_string();
            let (shape, sizes) = spelled.split_once(':').unwrap();
            let word = name.split('-').next().unwrap();
            assert_eq!(word, if shape == "cone" { "vbit" } else { shape }, "{name}");
            let said = name.strip_suffix("-neck").unwrap_or(name).split('-').skip(1).collect::<Vec<_>>().join(",");
            assert!(sizes.starts_with(&said), "{name}: {sizes}");
            assert_eq!(name.ends_with("-neck"), cutter.neck.is_some(), "{name}");
            let flutes = cutter.flutes.unwrap();
            assert!(flutes >= 0.5 * cutter.shape.tip_diameter(), "{name}");
            // Teeth along a flank are no longer than the flank.
            let rises = cutter.shape.underside(cutter.shape.reach());
            if ["cone", "tapered"].contains(&shape) {
                assert!((flutes - rises).abs() < 0.2, "{name}: {rises}");
            }
            let wears = ["ball", "cone", "tapered"].contains(&shape);
            assert_eq!(cutter.worn_tip.is_some(), wears, "{name}");
            assert!(cutter.worn_tip.is_none_or(|tip| tip > 2.0 * cutter.shape.profile().flat), "{name}");
            shapes.push(shape.to_owned());
        }
        shapes.sort_unstable();
        shapes.dedup();
        assert_eq!(shapes, ["ball", "bull", "cone", "flat", "tapered"]);
        let new = Library::built_in();
        assert_eq!(new.get("ball-0.5").map(|cutter| cutter.shape), Some(Cutter::ball(0.5)));
        assert_eq!(new.get("ball-0.5-neck").and_then(SoldCutter::deepest), Some(4.0));
    }

    #[test]
    fn the_users_own_cutters_count_before_those_that_are_sold() {
        let own = "mine = { shape = 'ball:0.7' }\n'ball-0.5' = { shape = 'ball:0.5', flutes = 2 }\n";
        let library = Library::built_in().with(Library::from_toml(own).unwrap());
        assert_eq!(library.get("mine").copied(), Some(Cutter::ball(0.7).into()));
        assert_eq!(library.get("ball-0.5").and_then(SoldCutter::deepest), Some(2.0));
        assert!(library.get("ball-1").is_some() && library.get("ball-9").is_none());
    }

    #[test]
    fn what_is_no_library_is_told_by_name_and_key() {
        for (text, parts) in [
            ("\na = 3", ["line 2", "ball:0.5"]),
            ("a = { shape = 'ball:1', teeth = 2 }", ["teeth", "flutes"]),
            ("a = { shape = 'drill:1' }", ["drill:1", "ball:0.5"]),
            ("a = { flutes = 1 }", ["shape", "missing"]),
            ("a = { shape = 'ball:1' }\na = { shape = 'ball:2' }", ["duplicate", "a"]),
            ("'a:b' = { shape = 'ball:1' }", ["a:b", "colon"]),
            ("a = { shape = 'ball:1', flutes = -1 }", ["'a': flutes is -1", "0.01 to 1000 mm"]),
            ("a = { shape = 'ball:1', flutes = 3, neck = 2 }", ["'a': neck is 2", "3 to 1000 mm"]),
            ("a = { shape = 'ball:1', worn-tip = 1.5 }", ["'a': worn-tip is 1.5", "0 to 1 mm"]),
            ("a = { shape = 'cone:30,0.1', worn-tip = 0.05 }", ["'a': worn-tip is 0.05", "0.1 to 2 mm"]),
            ("a = { shape = 'ball:nan' }", ["'a': the diameter is NaN", "0.001 to 100 mm"]),
            ("a = { shape = 'ball:1', flutes = inf }", ["flutes is inf", "1000"]),
        ] {
            let error = Library::from_toml(text).unwrap_err().to_string();
            assert!(parts.iter().all(|part| error.contains(part)), "{text}: {error}");
        }
    }
}
