use toml::{Table, Value};

use super::*;
use crate::facets::arrange::anneal::Annealing;
use crate::recipe::Cutter;

/// Every key of a recipe's TOML that is no table, with its tables before it.
fn keys(prefix: &str, table: &Table, found: &mut Vec<(String, Value)>) {
    for (key, value) in table {
        let key = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            Value::Table(inner) => keys(&key, inner, found),
            _ => found.push((key, value.clone())),
        }
    }
}

fn keys_of(recipe: &Recipe) -> Vec<(String, Value)> {
    let mut found = Vec::new();
    keys("", &recipe.to_toml().parse().unwrap(), &mut found);
    found
}

/// Something within the ranges of a setting that is not its default.
fn other(setting: &Setting) -> String {
    let high = setting.ranges.last().map_or(1.0, |[_, high]| *high);
    match setting.form {
        Form::Words(_, words) | Form::Switches(words) => {
            words.iter().map(|word| word.word).find(|word| *word != setting.default()).unwrap().to_owned()
        }
        Form::Switch => "true".into(),
        Form::Text("FINISH") => format!("sloped:{high}"),
        Form::Text("FORMATS") => "obj,tiff".into(),
        Form::Text("CUTTER") => format!("ball:{high}"),
        Form::Text("WxH") | Form::Text("NxM") => format!("{high}x{high}"),
        Form::Text("THETA,PHI") => "1,2".into(),
        Form::Text("X,Y,Z") => "1,2,300".into(),
        Form::Text(_) => high.to_string(),
        Form::Table => unreachable!(),
    }
}

fn with_flags() -> impl Iterator<Item = &'static Setting> {
    SETTINGS.iter().filter(|setting| setting.form != Form::Table)
}

#[test]
fn a_setting_changes_its_own_place_of_the_recipe_and_no_other() {
    let usual = Recipe::default();
    for setting in with_flags() {
        let mut recipe = usual.clone();
        setting.read(&mut recipe, &other(setting)).unwrap();
        let (before, after) = (keys_of(&usual), keys_of(&recipe));
        let changed: Vec<&str> =
            after.iter().filter(|place| !before.contains(place)).map(|(key, _)| key.as_str()).collect();
        // The lamp's direction is two numbers.
        let expected = if setting.key == "light" { vec!["light.phi", "light.theta"] } else { vec![setting.key] };
        assert_eq!(changed, expected, "{}", setting.name);
        assert_eq!(setting.written(&recipe), Some(other(setting)), "{}", setting.name);
        assert_eq!(Recipe::from_toml(&recipe.to_toml()), Ok(recipe), "{}", setting.name);
    }
}

#[test]
fn every_place_of_a_recipe_has_its_setting() {
    let mut recipe = Recipe::default();
    with_flags().for_each(|setting| setting.read(&mut recipe, &other(setting)).unwrap());
    recipe.design.annealing = Some(Annealing::default());
    for (key, _) in keys_of(&recipe) {
        let has_it = |setting: &Setting| key == setting.key || key.starts_with(&format!("{}.", setting.key));
        assert!(SETTINGS.iter().any(has_it), "{key}");
    }
    let mut names: Vec<&str> = SETTINGS.iter().map(|setting| setting.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), SETTINGS.len());
}

#[test]
fn ranges_end_where_they_say() {
    let refused = |setting: &Setting, text: &str| {
        let mut recipe = Recipe::default();
        setting.read(&mut recipe, text).unwrap();
        match recipe.check() {
            Err(RecipeError::OutOfRange { setting, .. }) => Some(setting),
            _ => None,
        }
    };
    let single = with_flags().filter(|setting| matches!(setting.form, Form::Text("MM" | "DEG" | "N" | "K")));
    for setting in single {
        let [low, high] = setting.ranges[0];
        assert_eq!(refused(setting, &low.to_string()), None, "{}", setting.name);
        assert_eq!(refused(setting, &high.to_string()), None, "{}", setting.name);
        assert_eq!(refused(setting, &(1.01 * high).ceil().to_string()), Some(setting.name));
        if low > 0.0 {
            assert_eq!(refused(setting, "0"), Some(setting.name));
        }
    }
}

#[test]
fn help_says_the_unit_and_words_are_those_of_the_recipe() {
    for setting in SETTINGS {
        assert!(!setting.help.is_empty() && !setting.help.ends_with('.'), "{}", setting.name);
        assert!(setting.help.contains(setting.unit.name()), "{}: {}", setting.name, setting.unit.name());
        assert_eq!(
            setting.unit == Unit::None,
            !matches!(setting.form, Form::Text(form) if !["N", "NxM", "K", "FORMATS"].contains(&form)),
            "{}",
            setting.name
        );
        if let Form::Words(_, words) | Form::Switches(words) = setting.form {
            for word in words {
                let mut recipe = Recipe::default();
                for spelling in word.before.into_iter().chain([word.word]) {
                    setting.read(&mut recipe, spelling).unwrap();
                    assert_eq!(setting.written(&recipe).as_deref(), Some(word.word));
                }
            }
        }
    }
}

#[test]
fn what_only_one_kind_of_relief_has_can_be_left_out() {
    for setting in SETTINGS.iter().filter(|setting| setting.only.is_some()) {
        assert_eq!(setting.written(&Recipe::default()), None, "{}", setting.name);
    }
}

#[test]
fn nothing_given_is_written_as_it_always_was_and_0_is_read_as_nothing_and_one_side_as_both() {
    let old = "[design]\ncutter = 'ball:0.5'\nlevelling = 0\nmin-feature = 0.0\nmax-depth = 2\nseed = 7\n";
    let recipe = Recipe::from_toml(old).unwrap();
    let sheet = recipe.design.sheet;
    assert_eq!((sheet.polish, sheet.min_feature, sheet.max_depth), (None, None, Some(2.0)));
    assert_eq!((sheet.cutter, recipe.design.seed), (Some(Cutter::ball(0.5)), 7));
    let new: String =
        recipe.to_toml().lines().map(|line| line.split("  # ").next().unwrap().to_owned() + "\n").collect();
    assert!(new.contains("polish = 0.0\nmin-feature = 0.0\nmax-depth = 2.0\nseed = 7\n"), "{new}");
    let read = |name: &str, text: &str| {
        let mut recipe = Recipe::default();
        Setting::named(name).unwrap().read(&mut recipe, text).unwrap();
        recipe
    };
    assert_eq!(read("polish", "0"), Recipe::default());
    assert_eq!(read("polish", "0.02").design.sheet.polish, Some(0.02));
    assert_eq!(read("border", "0").plate.border, 0.0);
    assert_eq!(read("size", "30").plate.size, [30.0; 2]);
    assert_eq!(read("size", "30x20").plate.size, [30.0, 20.0]);
    assert_eq!(read("max-depth", "0").design.sheet.max_depth, Some(0.0));
}

#[test]
fn what_a_table_of_the_recipe_does_not_know_is_refused() {
    for (text, line) in [("[design]\nseed = 2\npolsh = 0.1\n", "polsh"), ("[plate]\nthikness = 2\n", "thikness")] {
        let error = Recipe::from_toml(text).unwrap_err().to_string();
        assert!(error.contains(line), "{error}");
    }
}
