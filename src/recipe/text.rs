//! A recipe as a file: TOML with a comment at each line, and errors in a user's words.

use std::path::{Path, PathBuf};

use super::settings::SETTINGS;
use super::{Recipe, RecipeError};
use crate::goal::spec::GoalSpec;

/// What stands at keys that are no setting of their own.
const OTHER_KEYS: [(&str, &str); 16] = [
    ("picture", "looked for beside this file, then in the working folder"),
    ("picture-bytes", "the picture's name, which is not Unicode, as hexadecimal bytes"),
    ("goal", "reflectance in place of a picture; a file is looked for beside this one, then in the working folder"),
    ("goal-part", "specular, without what scatters evenly, or all"),
    (
        "patches.portrait",
        "the picture that a viewer sees on the plate; looked for beside this file, then in the working folder",
    ),
    ("patches.gloss", "map of lobes, white the narrowest; looked for as a portrait"),
    ("patches.normal", "map of normals, red to the right, green up; looked for as a portrait"),
    ("patches.anisotropy", "map of long lobes, red and green their direction, blue how long; looked for as a portrait"),
    ("patches.albedo", "map of the share of light in the lobe; looked for as a portrait"),
    ("light.theta", "degrees, the lamp from the plate's normal"),
    ("light.phi", "degrees, the lamp's azimuth from +x, counter-clockwise"),
    ("design.annealing.energy", "which energies are weighed"),
    ("design.annealing.swaps", "exchanges tried in a run"),
    ("design.annealing.starts", "runs, of which the best is kept"),
    ("design.annealing.valleys", "weight of a valley"),
    ("design.annealing", "how facets are annealed"),
];

impl Recipe {
    /// As TOML, what each number is and its unit beside it.
    pub fn to_toml(&self) -> String {
        // Plain tables of numbers and words: there is nothing that TOML cannot hold.
        let plain = toml::to_string(self).unwrap_or_else(|error| format!("# not representable: {error}\n"));
        let mut table = String::new();
        let mut text = String::new();
        // What ends the string of several lines that the line before is a part of.
        let mut open: Option<&str> = None;
        for line in plain.split_terminator('\n') {
            if let Some(end) = open {
                text += &format!("{line}\n");
                open = open.filter(|_| !line.contains(end));
                continue;
            }
            if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
                table = format!("{name}.");
            }
            let comment = line.split_once(" = ").and_then(|(key, _)| comment(&format!("{table}{key}")));
            open = begun(line);
            text += &match comment {
                Some(comment) if open.is_none() => format!("{line}  # {comment}\n"),
                _ => format!("{line}\n"),
            };
        }
        text
    }

    /// From TOML; what is not said keeps its default, what is not known is an error.
    pub fn from_toml(text: &str) -> Result<Self, RecipeError> {
        toml::from_str(text).map_err(|error| {
            let line = line_of(text, &error);
            let key = text.lines().nth(line - 1).and_then(|line| line.split_once('=')).map(|(key, _)| key.trim());
            RecipeError::Unreadable(in_plain_words(key, error.message()), line)
        })
    }

    /// Names the picture, be its name Unicode or, where a system allows that, not.
    pub fn name_picture(&mut self, path: &Path) {
        self.picture = path.to_str().map(Into::into);
        self.picture_bytes = if self.picture.is_some() { None } else { hexadecimal(path) };
    }

    /// Names a goal in place of a picture.
    pub fn name_goal(&mut self, goal: &GoalSpec) {
        (self.picture, self.picture_bytes) = (None, None);
        self.goal = Some(goal.clone());
    }

    /// The picture that it names.
    pub fn picture_path(&self) -> Option<PathBuf> {
        let named = self.picture.as_ref().filter(|name| !name.is_empty()).map(PathBuf::from);
        named.or_else(|| from_hexadecimal(self.picture_bytes.as_deref()?))
    }
}

/// What ends the string that begins in a line and goes on in the next, if one does.
fn begun(line: &str) -> Option<&'static str> {
    let (_, value) = line.split_once(" = ")?;
    ["\"\"\"", "'''"].into_iter().find(|end| value.strip_prefix(end).is_some_and(|rest| !rest.contains(end)))
}

/// What a key means and its unit, in a line.
fn comment(key: &str) -> Option<String> {
    if let Some(setting) = SETTINGS.iter().find(|setting| setting.key == key) {
        let words = setting.words().map(|words| format!(": {words}")).unwrap_or_default();
        // The help of every setting with a unit names it.
        return Some(format!("{}{words}", setting.help));
    }
    OTHER_KEYS.iter().find(|(other, _)| *other == key).map(|(_, comment)| (*comment).to_owned())
}

/// A message of the TOML reader for whoever wrote the recipe, who knows of no types.
fn in_plain_words(key: Option<&str>, message: &str) -> String {
    let Some((found, expected)) = message.strip_prefix("invalid ").and_then(|rest| {
        let rest = rest.strip_prefix("type: ").or_else(|| rest.strip_prefix("value: "))?;
        rest.split_once(", expected ")
    }) else {
        return message.to_owned();
    };
    let value = found.split_once(' ').map_or(found, |(kind, value)| match kind {
        "string" | "integer" => value,
        "boolean" | "floating" => value.strip_prefix("point ").unwrap_or(value),
        _ => found,
    });
    let value = value.replace('`', "");
    let wanted = match expected {
        "f64" | "f32" => "a number, such as 12.5",
        "usize" | "u64" | "u32" | "u16" => "a whole number, such as 30",
        "a boolean" | "bool" => "true or false",
        "a sequence" => "two numbers in brackets, such as [30, 20]",
        "a string" | "string" | "string or table" => "a word in quotes",
        other if other.starts_with("struct ") => "a table, such as [plate]",
        other => other,
    };
    let key =
        key.map(|key| format!("{key} is {value}, and should be ")).unwrap_or_else(|| format!("{value} should be "));
    format!("{key}{wanted}")
}

fn line_of(text: &str, error: &toml::de::Error) -> usize {
    let before = error.span().map_or(0, |span| span.start);
    text.as_bytes().iter().take(before).filter(|b| **b == b'\n').count() + 1
}

/// The bytes of a name, where names are bytes.
#[cfg(unix)]
fn hexadecimal(path: &Path) -> Option<String> {
    use std::os::unix::ffi::OsStrExt;
    Some(path.as_os_str().as_bytes().iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(not(unix))]
fn hexadecimal(_: &Path) -> Option<String> {
    None
}

#[cfg(unix)]
fn from_hexadecimal(digits: &str) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
    let bytes: Option<Vec<u8>> = digits.as_bytes().chunks(2).map(byte).collect();
    bytes.filter(|bytes| !bytes.is_empty()).map(|bytes| std::ffi::OsString::from_vec(bytes).into())
}

#[cfg(not(unix))]
fn from_hexadecimal(_: &str) -> Option<PathBuf> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_a_recipe_says_what_it_is_and_in_which_unit() {
        let mut recipe = Recipe::weyrich2009();
        recipe.picture = Some("ring.png".into());
        let text = recipe.to_toml();
        for line in text.lines().filter(|line| line.contains(" = ")) {
            assert!(line.contains("  # "), "{line}");
        }
        assert!(text.contains("half-field = 20.0  # Angle from the picture's middle to its rim, degrees\n"), "{text}");
        assert!(text.contains("size = [30.0, 30.0]  # Optical area along x and y, mm\n"), "{text}");
        assert!(text.contains("theta = 0.0  # degrees, "), "{text}");
        assert!(
            text.contains("projection = \"orthographic\"  # How directions are laid out on the picture: "),
            "{text}"
        );
        assert_eq!(Recipe::from_toml(&text), Ok(recipe));
    }

    #[test]
    fn names_of_several_lines_are_kept() {
        for name in
            ["r\ng.png", "\n[light]\ntheta = 30.0", "a\r\nb", "\"\"\"\nlight = '''\n", "\n'''\n", "a\n\\\"\"\"\n"]
        {
            let recipe = Recipe { picture: Some(name.into()), ..Recipe::default() };
            assert_eq!(Recipe::from_toml(&recipe.to_toml()), Ok(recipe), "{name:?}");
        }
    }

    #[test]
    fn errors_of_type_are_told_in_a_users_words() {
        for (text, said) in [
            ("[plate]\nthickness = 'five'\n", "line 2 makes no sense: thickness is \"five\", and should be a number"),
            ("[highlight]\ninvert = 1\n", "invert is 1, and should be true or false"),
            ("[design]\nseed = -1\n", "seed is -1, and should be a whole number"),
            ("[plate]\nfacets = [1.5, 2]\n", "is 1.5, and should be a whole number"),
            ("[plate]\ncells = 'many'\n", "cells is \"many\", and should be a whole number, or two such as [5, 3]"),
            ("[light]\ntheta = true\n", "theta is true, and should be a number, such as 12.5"),
        ] {
            let error = Recipe::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
            let types = ["f64", "usize", "u64", "struct", "sequence", "invalid type", "floating"];
            assert!(!types.iter().any(|word| error.contains(word)), "{error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_picture_keeps_its_name_whatever_its_bytes() {
        use std::os::unix::ffi::OsStrExt;
        let odd = Path::new(std::ffi::OsStr::from_bytes(b"r\xffng.png"));
        for path in [Path::new("d/ring.png"), odd] {
            let mut recipe = Recipe::default();
            recipe.name_picture(path);
            assert_eq!(recipe.picture.is_some(), path != odd);
            assert_eq!(Recipe::from_toml(&recipe.to_toml()).unwrap().picture_path().as_deref(), Some(path));
        }
        for nonsense in ["", "7", "zz", "f"] {
            let recipe = Recipe { picture_bytes: Some(nonsense.into()), ..Recipe::default() };
            assert!(recipe.picture_path().is_none() || nonsense.len() == 1);
        }
        assert_eq!(Recipe::default().picture_path(), None);
    }
}
