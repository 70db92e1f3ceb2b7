//! Every setting once: its name, its place in a recipe, unit, range, kind of relief, and what it means.
//!
//! The command line's flags with their help, the recipe's range checks, the refusals of what only the other kind of relief
//! has, and the report's remedies are made from [`SETTINGS`]; a form on a page can be.

pub mod value;

mod table;

mod files;
mod machining;
mod patches;
mod running;
mod scene;

#[cfg(test)]
mod tests;

pub use table::{LEAST_GRID, MOST_FACETS};
pub use value::Value;

use super::{Recipe, RecipeError, SurfaceKind};

/// Every setting but the picture itself, in the order of the help.
pub static SETTINGS: &[Setting] = &joined();

const PARTS: [&[Setting]; 6] =
    [table::GENERAL, running::RUNNING, &patches::PATCHES, &scene::SCENE, &machining::MAKING, files::FILES];

const COUNT: usize =
    PARTS[0].len() + PARTS[1].len() + PARTS[2].len() + PARTS[3].len() + PARTS[4].len() + PARTS[5].len();

const fn joined() -> [Setting; COUNT] {
    let mut all = [table::PLAIN; COUNT];
    let (mut k, mut part) = (0, 0);
    while part < PARTS.len() {
        let mut of_part = 0;
        while of_part < PARTS[part].len() {
            all[k] = PARTS[part][of_part];
            (k, of_part) = (k + 1, of_part + 1);
        }
        part += 1;
    }
    all
}

/// One thing that a recipe can be told.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Setting {
    /// Its name, which is its flag's without dashes.
    pub name: &'static str,
    /// What earlier versions called it.
    pub before: Option<&'static str>,
    /// Its place in a recipe's TOML, tables and key with dots between.
    pub key: &'static str,
    /// What it is about.
    pub section: Section,
    /// How it is written.
    pub form: Form,
    /// Unit of its numbers.
    pub unit: Unit,
    /// Least and most of each of its numbers, in order; the last counts for all that follow.
    pub ranges: &'static [[f64; 2]],
    /// The only kind of relief that has it.
    pub only: Option<SurfaceKind>,
    /// What is taken where it is not given, if that is no value of its own.
    pub unset: &'static str,
    /// What it is, in a line.
    pub help: &'static str,
    /// What else to know of it.
    pub more: &'static str,
    /// What may bring a sheet closer to the picture where this setting stands in the way.
    pub remedy: &'static str,
    /// Its place in a recipe.
    pub at: fn(&mut Recipe) -> &mut dyn Value,
}

/// What a setting is about: a heading of the help, or of a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Section {
    /// The picture and the lamp.
    Optics,
    /// A picture that stands on the plate.
    Patches,
    /// Lamp and wall nearby.
    Scene,
    /// The piece of metal.
    Plate,
    /// How the relief comes about.
    Design,
    /// How it is made.
    Machining,
    /// What is written.
    Files,
    /// How it is proved.
    Running,
}

impl Section {
    /// The heading.
    pub fn title(self) -> &'static str {
        match self {
            Self::Optics => "Highlight and light",
            Self::Patches => "A picture on the plate",
            Self::Scene => "Lamp and wall nearby",
            Self::Plate => "Plate",
            Self::Design => "Design",
            Self::Machining => "As a machine makes it",
            Self::Files => "Files",
            Self::Running => "Running",
        }
    }
}

/// How a setting is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// As this placeholder says: one number, or two with what stands between them, or a cutter.
    Text(&'static str),
    /// One of these words.
    Words(&'static str, &'static [Word]),
    /// True or false; alone it is true.
    Switch,
    /// Each word is a flag of its own.
    Switches(&'static [Word]),
    /// A table of a recipe, which has no flag.
    Table,
}

/// A word that a setting takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// The word.
    pub word: &'static str,
    /// What earlier versions wrote for it.
    pub before: Option<&'static str>,
    /// What it means.
    pub help: &'static str,
}

/// Unit of a setting's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unit {
    /// None: counts, words.
    None,
    /// Millimetres.
    Millimetres,
    /// Degrees.
    Degrees,
}

impl Unit {
    /// As it is written in sentences.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Millimetres => "mm",
            Self::Degrees => "degrees",
        }
    }
}

impl Setting {
    /// The words that it takes, in a row, if it takes words.
    pub fn words(&self) -> Option<String> {
        match self.form {
            Form::Words(_, words) | Form::Switches(words) => {
                Some(words.iter().map(|word| word.word).collect::<Vec<_>>().join(", "))
            }
            _ => None,
        }
    }

    /// The setting of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        SETTINGS.iter().find(|setting| setting.name == name)
    }

    /// Takes `text`, written as on the command line.
    pub fn read(&self, recipe: &mut Recipe, text: &str) -> Result<(), String> {
        (self.at)(recipe).read(text)?;
        // 0 of what may be left out, where 0 is allowed, has always been the same as leaving it out.
        if self.ranges.first().is_some_and(|[low, _]| *low == 0.0) && (self.at)(recipe).numbers() == [0.0] {
            (self.at)(recipe).clear();
        }
        Ok(())
    }

    /// What `recipe` says, written as on the command line; `None` if it says nothing.
    pub fn written(&self, recipe: &Recipe) -> Option<String> {
        (self.at)(&mut recipe.clone()).written()
    }

    /// Whether `recipe` says something else of it than every recipe does.
    pub(super) fn is_given(&self, recipe: &Recipe) -> bool {
        self.written(recipe) != self.written(&Recipe::default())
    }

    /// What is taken where it is not given, in words; empty if that goes without saying.
    pub fn default(&self) -> String {
        let usual = if self.form == Form::Switch { None } else { self.written(&Recipe::default()) };
        usual.filter(|_| self.unset.is_empty()).unwrap_or_else(|| self.unset.to_owned())
    }

    /// Refuses numbers out of range.
    pub(super) fn check(&self, recipe: &mut Recipe) -> Result<(), RecipeError> {
        for (k, value) in (self.at)(recipe).numbers().into_iter().enumerate() {
            if let Some([low, high]) = self.ranges.get(k).or(self.ranges.last()) {
                within(self.name, value, *low, *high)?;
            }
        }
        Ok(())
    }
}

impl Recipe {
    /// The first setting that is given and that only `kind` has.
    pub(super) fn given_only_for(&self, kind: SurfaceKind) -> Option<&'static str> {
        let mut recipe = self.clone();
        let mut of_kind = SETTINGS.iter().filter(|setting| setting.only == Some(kind));
        of_kind.find(|setting| (setting.at)(&mut recipe).written().is_some()).map(|setting| setting.name)
    }

    /// What would bring a sheet closer to the picture, of the settings that are given.
    pub(crate) fn remedies(&self) -> impl Iterator<Item = &'static str> {
        let helps = SETTINGS.iter().rev().filter(|setting| !setting.remedy.is_empty());
        helps.filter(|setting| setting.written(self).is_some()).map(|setting| setting.remedy)
    }
}

pub(super) fn within(setting: &'static str, value: f64, low: f64, high: f64) -> Result<(), RecipeError> {
    // A value that is not a number is in no range.
    if (low..=high).contains(&value) { Ok(()) } else { Err(RecipeError::OutOfRange { setting, value, low, high }) }
}
