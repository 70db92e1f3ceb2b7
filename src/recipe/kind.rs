//! Which kind of relief a recipe is for, and which settings only one kind has.

use serde::{Deserialize, Serialize};

use super::settings::SETTINGS;
use super::{Recipe, RecipeError};

/// Kinds of relief.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum SurfaceKind {
    /// Planar facets, as in the 2009 paper.
    #[serde(rename = "facets", alias = "flat")]
    Facets,
    /// One sheet without steps, periodic in its cells.
    #[serde(rename = "sheet", alias = "continuous")]
    Sheet,
}

impl Recipe {
    /// The kind of relief: as asked; else facets where a setting asks for them, and one sheet where none does.
    pub fn surface(&self) -> SurfaceKind {
        self.plate.surface.unwrap_or(match self.given_only_for(SurfaceKind::Facets) {
            Some(_) => SurfaceKind::Facets,
            None => SurfaceKind::Sheet,
        })
    }

    /// Whether nothing was asked for that only one kind of relief can give: neither the kind, nor cells, nor a setting of
    /// either.
    pub(crate) fn leaves_the_kind_open(&self) -> bool {
        let asked = [self.given_only_for(SurfaceKind::Facets), self.given_only_for(SurfaceKind::Sheet)];
        self.plate.surface.is_none() && self.plate.cells.is_none() && asked == [None, None]
    }

    /// Why the relief is of its kind, in a sentence for the report.
    pub(crate) fn why_this_surface(&self) -> String {
        match (self.plate.surface, self.given_only_for(SurfaceKind::Facets)) {
            (Some(SurfaceKind::Facets), _) => "facets: as --surface asks".into(),
            (Some(SurfaceKind::Sheet), _) => "sheet: as --surface asks".into(),
            (None, Some(setting)) => format!("facets: --{setting} asks for facets"),
            // Measured on photographs, logos and a word; README.md has the figures.
            (None, None) => "sheet: nothing asked for facets; 900 of them misplace 1.1 to 14 times as much light at \
                             a blur of 1°, 2.8 to 38 times as much once a ball of 0.5 mm has cut them"
                .into(),
        }
    }

    /// The same recipe for `kind`: settings that only the other kind has are gone.
    pub fn only_for(mut self, kind: SurfaceKind) -> Self {
        let others = SETTINGS.iter().filter(|setting| setting.only.is_some_and(|only| only != kind));
        others.for_each(|setting| (setting.at)(&mut self).clear());
        self.plate.surface = Some(kind);
        self
    }

    /// Refuses settings that the kind of relief does not have: they would be without effect.
    pub(super) fn check_kind(&self) -> Result<(), RecipeError> {
        let kind = self.surface();
        let foreign = match kind {
            SurfaceKind::Facets => self.given_only_for(SurfaceKind::Sheet),
            SurfaceKind::Sheet => self.given_only_for(SurfaceKind::Facets),
        };
        let decisive =
            || self.plate.surface.map_or_else(|| self.given_only_for(SurfaceKind::Facets), |_| Some("surface"));
        match (foreign, decisive()) {
            (Some(setting), Some(decisive)) => Err(RecipeError::OtherKind { setting, decisive, kind }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_toml(text: &str) -> Recipe {
        Recipe::from_toml(text).unwrap()
    }

    #[test]
    fn facets_are_made_where_something_asks_for_them() {
        use SurfaceKind::{Facets, Sheet};
        for (text, kind, why) in [
            ("", Sheet, "nothing asked"),
            ("[plate]\ncells = 2\n[design]\ncutter = 'ball:1'\n", Sheet, "nothing asked"),
            ("[plate]\nsurface = 'flat'\n", Facets, "--surface"),
            ("[plate]\nsurface = 'continuous'\n", Sheet, "--surface"),
            ("[plate]\nfacets = [30, 30]\n", Facets, "--facets"),
            ("[design]\nsample = 'sobol'\n", Facets, "--sample"),
            ("[design]\narrange = 'transport'\n", Facets, "--arrange"),
            ("[design]\nheights = 'free'\n", Facets, "--heights"),
            ("[design.annealing]\nswaps = 5\n", Facets, "--annealing"),
        ] {
            let recipe = from_toml(text);
            assert_eq!((recipe.surface(), recipe.check()), (kind, Ok(())), "{text}");
            assert_eq!(recipe.leaves_the_kind_open(), text.is_empty(), "{text}");
            assert!(recipe.why_this_surface().contains(why), "{text}: {}", recipe.why_this_surface());
            assert_eq!(from_toml(&recipe.to_toml()), recipe, "{text}");
        }
        assert_eq!(Recipe::weyrich2009().surface(), Facets);
    }

    #[test]
    fn settings_of_the_other_kind_are_refused_unless_the_kind_is_changed_on_purpose() {
        let sheets = ["[plate]\ngrid = 64", "[plate]\nmax-triangles = 3000000", "[design]\npolish = 0.1"]
            .into_iter()
            .chain(["[design]\nmin-feature = 0.1", "[design]\nmax-depth = 1"]);
        for text in sheets {
            let setting = text.split(['\n', ' ']).nth(1).unwrap();
            for facets in ["surface = 'flat'", "facets = [20, 20]"] {
                let recipe = match text.strip_prefix("[plate]") {
                    Some(rest) => from_toml(&format!("[plate]\n{facets}{rest}")),
                    None => from_toml(&format!("[plate]\n{facets}\n{text}")),
                };
                let error = recipe.check().unwrap_err();
                let decisive = facets.split(' ').next().unwrap();
                assert!(!error.is_impossible());
                let said = error.to_string();
                assert!(
                    said.starts_with(&format!("{setting} is ")) && said.contains(&format!("--{decisive}")),
                    "{said}"
                );
                assert_eq!(recipe.clone().only_for(SurfaceKind::Facets).check(), Ok(()));
                let sheet = recipe.only_for(SurfaceKind::Sheet);
                assert_eq!((sheet.check(), sheet.plate.facets), (Ok(()), None), "{text}");
            }
        }
        for text in ["facets = [30, 30]", "[design]\nsample = 'voronoi'", "[design.annealing]\nstarts = 2"] {
            let recipe = from_toml(&format!("[plate]\nsurface = 'continuous'\n{text}"));
            assert!(matches!(recipe.check(), Err(RecipeError::OtherKind { decisive: "surface", .. })), "{text}");
            assert_eq!(recipe.only_for(SurfaceKind::Facets).check(), Ok(()));
        }
    }
    #[test]
    fn words_of_earlier_versions_are_still_read() {
        let old = from_toml("[plate]\nsurface = 'continuous'\n[design]\nlevelling = 0.03\n");
        assert_eq!((old.surface(), old.design.sheet.polish), (SurfaceKind::Sheet, Some(0.03)));
        assert_eq!(from_toml("[plate]\nsurface = 'flat'\n").surface(), SurfaceKind::Facets);
    }
}
