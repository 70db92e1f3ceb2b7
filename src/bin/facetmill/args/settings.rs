//! Flags of settings, made from the library's table of them.

use std::marker::PhantomData;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};
use facetmill::recipe::settings::{Form, SETTINGS, Section, Setting};
use facetmill::recipe::{Recipe, SceneFault};

/// The setting whose text may be a name of a library.
const CUTTER: &str = "for-cutter";

/// A command that takes some of the settings.
pub trait Takes {
    /// Whether it takes this one.
    fn takes(setting: &Setting) -> bool;

    /// The flag as this command shows it.
    fn shown(_: &Setting, flag: Arg) -> Arg {
        flag
    }
}

/// `facetmill design` takes them all.
#[derive(Clone, Copy, Debug)]
pub struct ByDesign;

impl Takes for ByDesign {
    fn takes(_: &Setting) -> bool {
        true
    }
}

/// `facetmill verify` takes what the picture and the lamp are, and how light is sent.
#[derive(Clone, Copy, Debug)]
pub struct ByVerify;

impl Takes for ByVerify {
    fn takes(setting: &Setting) -> bool {
        let of_scene = setting.section == Section::Scene && !["near", "focus"].contains(&setting.name);
        let whole = [Section::Optics, Section::Machining].contains(&setting.section);
        whole || of_scene || ["rays", "seed", "eye-distance"].contains(&setting.name)
    }

    fn shown(setting: &Setting, flag: Arg) -> Arg {
        if setting.name == "seed" { seed_of_rays(flag, setting) } else { flag }
    }
}

/// `facetmill plan` takes what the picture and the lamp are, the plate's measures, and what of its making is fixed.
#[derive(Clone, Copy, Debug)]
pub struct ByPlan;

impl Takes for ByPlan {
    fn takes(setting: &Setting) -> bool {
        let more = [
            "size",
            "cells",
            "thickness",
            "border",
            "border-finish",
            "for-cutter",
            "flutes",
            "polish",
            "max-triangles",
            "max-depth",
        ];
        let making = ["pass-angle", "pass-order", "draws", "rays", "seed"];
        setting.section == Section::Optics || more.contains(&setting.name) || making.contains(&setting.name)
    }

    fn shown(setting: &Setting, flag: Arg) -> Arg {
        let searched = ["size", "cells", "for-cutter", "polish", "pass-angle"].contains(&setting.name);
        if searched { flag.help(format!("{}  [default: searched for]", setting.help)) } else { flag }
    }
}

/// `facetmill mill` takes how passes go, and whether the cutter is worn.
#[derive(Clone, Copy, Debug)]
pub struct ByMill;

impl Takes for ByMill {
    fn takes(setting: &Setting) -> bool {
        ["stepover", "pass-angle", "pass-order", "worn"].contains(&setting.name)
    }

    fn shown(_: &Setting, flag: Arg) -> Arg {
        flag.help_heading("Finishing")
    }
}

/// The seed where nothing is random but the rays.
pub fn seed_of_rays(flag: Arg, setting: &Setting) -> Arg {
    flag.help(format!("Seed of the rays  [default: {}]", setting.default())).help_heading(Section::Running.title())
}

/// The settings that were given to command `C`.
#[derive(Clone, Debug)]
pub struct SettingFlags<C> {
    given: Vec<(&'static Setting, String)>,
    command: PhantomData<C>,
}

impl<C> SettingFlags<C> {
    /// Lays them over `recipe`, a cutter if it is given by its shape.
    pub fn apply(&self, recipe: &mut Recipe) {
        for (setting, text) in &self.given {
            // It was read once already, but for names of cutters, which whoever has the library lays over it.
            let _ = setting.read(recipe, text);
        }
    }

    /// Nothing but them.
    pub fn alone(&self) -> Recipe {
        let mut recipe = Recipe::default();
        self.apply(&mut recipe);
        recipe
    }

    /// `recipe` with what its scene implies, unless a flag contradicts that: then what is wrong with it.
    pub fn implied(&self, recipe: Recipe) -> Result<Recipe, String> {
        let flags = self.alone();
        let given = |name: &str| self.has(name);
        if given("lamp-at") && given("light") {
            return Err("--light has no meaning beside --lamp-at: leave out one of the two".into());
        }
        let implied = recipe.clone().with_implied();
        let contradicts = |name: &str| match name {
            "projection" => flags.highlight.projection != implied.highlight.projection,
            "quantity" => flags.highlight.quantity != implied.highlight.quantity,
            _ => flags.highlight.seen != implied.highlight.seen,
        };
        let all = ["projection", "quantity", "seen"];
        match all.into_iter().find(|name| recipe.is_near() && given(name) && contradicts(name)) {
            Some(name) => Err(format!("--{}", SceneFault::Implied(name))),
            None => Ok(implied),
        }
    }

    /// The cutter that was given, by its shape or by a name.
    pub fn cutter(&self) -> Option<&str> {
        self.given.iter().find(|(setting, _)| setting.name == CUTTER).map(|(_, text)| text.as_str())
    }

    /// Whether the setting of this name was given.
    pub fn has(&self, name: &str) -> bool {
        self.given.iter().any(|(setting, _)| setting.name == name)
    }
}

impl<C: Takes> FromArgMatches for SettingFlags<C> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let text = |setting: &'static Setting| match setting.form {
            Form::Table => None,
            Form::Switches(words) => {
                words.iter().find(|word| matches.get_flag(word.word)).map(|word| word.word.to_owned())
            }
            _ => matches.get_one::<String>(setting.name).cloned(),
        };
        let taken = SETTINGS.iter().filter(|setting| C::takes(setting));
        let given = taken.filter_map(|setting| Some((setting, text(setting)?))).collect();
        Ok(Self { given, command: PhantomData })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        Self::from_arg_matches(matches).map(|given| *self = given)
    }
}

impl<C: Takes> Args for SettingFlags<C> {
    fn augment_args(command: Command) -> Command {
        let taken = SETTINGS.iter().filter(|setting| C::takes(setting));
        command.args(taken.flat_map(|setting| flags(setting).into_iter().map(|flag| C::shown(setting, flag))))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The flags of a setting: one, but for a setting of several switches.
fn flags(setting: &'static Setting) -> Vec<Arg> {
    let new = |name: &'static str| Arg::new(name).long(name).help_heading(setting.section.title());
    let flag = match setting.form {
        Form::Table => return Vec::new(),
        Form::Switches(words) => {
            let others = |name| words.iter().map(|word| word.word).filter(move |word| *word != name);
            let switch = |name| new(name).action(ArgAction::SetTrue).conflicts_with_all(others(name));
            return words.iter().map(|word| switch(word.word).help(word.help)).collect();
        }
        // A name is looked up once it is known whose library is meant.
        Form::Text(placeholder) if setting.name == CUTTER => new(CUTTER).value_name(placeholder),
        Form::Text(placeholder) => new(setting.name)
            .value_name(placeholder)
            .value_parser(move |text: &str| read(setting, text))
            // Of two numbers the first may be negative; a single one is told from a flag by itself.
            .allow_hyphen_values(placeholder.contains(['x', ','])),
        Form::Words(placeholder, words) => {
            let words = words.iter().map(|word| PossibleValue::new(word.word).help(word.help).aliases(word.before));
            new(setting.name).value_name(placeholder).value_parser(PossibleValuesParser::new(words))
        }
        Form::Switch => new(setting.name)
            .value_name("BOOL")
            .num_args(0..=1)
            .require_equals(true)
            .default_missing_value("true")
            .value_parser(move |text: &str| read(setting, text)),
    };
    let flag = match setting.before {
        Some(before) => flag.alias(before),
        None => flag,
    };
    vec![explained(flag, setting, "")]
}

/// The flag with its help; `before` stands before what is taken where it is not given.
pub fn explained(flag: Arg, setting: &Setting, before: &str) -> Arg {
    let Setting { help, more, .. } = setting;
    let line = match setting.default() {
        usual if usual.is_empty() => (*help).to_owned(),
        usual => format!("{help}  [default: {before}{usual}]"),
    };
    let flag = flag.help(line.clone());
    if more.is_empty() { flag } else { flag.long_help(format!("{line}\n\n{more}")) }
}

/// The text, if it can be read.
fn read(setting: &Setting, text: &str) -> Result<String, String> {
    setting.read(&mut Recipe::default(), text).map(|()| text.to_owned())
}
