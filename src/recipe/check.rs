//! Which recipes can be made at all.

use super::files::MOST_STEP_FACETS;
use super::settings::{MOST_FACETS, SETTINGS, within};
use super::{BorderFinish, Format, Recipe, RecipeError, SurfaceKind};
use crate::cutter::Cutter;
use crate::sculpt::milled_facets::{Places, least_diameter};
use crate::sculpt::tool::Tool;

impl Recipe {
    /// Refuses settings that make no sense, naming the first one.
    pub fn check(&self) -> Result<(), RecipeError> {
        let mut recipe = self.clone();
        SETTINGS.iter().try_for_each(|setting| setting.check(&mut recipe))?;
        within("light-radius", self.light.radius, 0.0, 89.0 - self.light.theta)?;
        let annealing = self.annealing();
        within("annealing.swaps", annealing.swaps as f64, 0.0, 1e12)?;
        within("annealing.valleys", annealing.valleys, 0.0, 1e6)?;
        within("annealing.starts", f64::from(annealing.starts), 1.0, 1000.0)?;
        self.check_patches()?;
        if self.patches.are_wanted() {
            return Ok(());
        }
        let field = self.highlight.half_field;
        if self.reading().aspect.is_some_and(|aspect| !(0.1..=10.0).contains(&aspect)) {
            return Err(RecipeError::LongField { field });
        }
        self.check_scene()?;
        self.check_kind()?;
        self.machining()?;
        self.check_files()?;
        if self.plate.border == 0.0 && self.border_finish() != BorderFinish::Matt {
            return Err(RecipeError::NoBorder);
        }
        self.check_preview()?;
        match self.surface() {
            SurfaceKind::Facets => self.check_facets(),
            SurfaceKind::Sheet => self.check_sheet(),
        }
    }

    fn check_files(&self) -> Result<(), RecipeError> {
        if !cfg!(feature = "meshes") && self.writes(Format::ThreeMf) {
            return Err(RecipeError::FormatLeftOut { format: Format::ThreeMf });
        }
        if !self.writes(Format::Step) {
            return Ok(());
        }
        let [columns, rows] = self.facets();
        match self.surface() {
            SurfaceKind::Sheet => Err(RecipeError::StepOfSheet),
            SurfaceKind::Facets if columns.saturating_mul(rows) > MOST_STEP_FACETS => {
                Err(RecipeError::StepTooLarge { columns, rows })
            }
            SurfaceKind::Facets => Ok(()),
        }
    }

    fn check_preview(&self) -> Result<(), RecipeError> {
        let without = [
            ("facets", self.surface() == SurfaceKind::Facets),
            ("lamp and wall nearby", self.is_near()),
            ("machine", self.machining()?.is_some()),
        ];
        match without.into_iter().find(|(_, given)| self.design.sheet.preview && *given) {
            Some((with, _)) => Err(RecipeError::NoPreview { with }),
            None => Ok(()),
        }
    }

    fn check_facets(&self) -> Result<(), RecipeError> {
        let [columns, rows] = self.facets();
        if columns * rows > MOST_FACETS {
            return Err(RecipeError::TooManyFacets { columns, rows });
        }
        let [across, up] = self.cells();
        if !columns.is_multiple_of(across) || !rows.is_multiple_of(up) {
            let nearest = |n: usize, cells: usize| (n as f64 / cells as f64).round().max(1.0) as usize * cells;
            return Err(RecipeError::Indivisible {
                columns,
                rows,
                cells: [across, up],
                near_columns: nearest(columns, across),
                near_rows: nearest(rows, up),
            });
        }
        let pitch = self.pitch();
        if pitch.max_element() > 20.0 * pitch.min_element() {
            return Err(RecipeError::Slivers { across: pitch.x, up: pitch.y });
        }
        let Some(cutter) = self.design.sheet.cutter else { return Ok(()) };
        not_too_fine(cutter, least_diameter(self.plate.size[0] * self.plate.size[1]))?;
        if Places::new(self.plate.size, [columns, rows], cutter).are_too_many() {
            let diameter = cutter.diameter();
            return Err(RecipeError::CutterTooWide { diameter, pitch: pitch.min_element() });
        }
        Ok(())
    }

    fn check_sheet(&self) -> Result<(), RecipeError> {
        let sculpting = self.sculpting();
        let (cell, grid) = (sculpting.cell, sculpting.grid);
        if !grid.is_multiple_of(2) {
            return Err(RecipeError::OddGrid { grid });
        }
        if cell.max_element() > 4.0 * cell.min_element() {
            return Err(RecipeError::LongCells { across: cell.x, up: cell.y });
        }
        if !self.fits_the_file(grid) {
            let most = (1..grid / 2).rev().map(|half| 2 * half).find(|grid| self.fits_the_file(*grid));
            return Err(RecipeError::TooManyTriangles { triangles: self.triangles(grid), most: most.unwrap_or(0) });
        }
        self.design.sheet.cutter.map_or(Ok(()), Cutter::suits_sheets)?;
        if let Some(cutter) = self.design.sheet.cutter.filter(|c| c.tip_diameter() > cell.min_element()) {
            return Err(RecipeError::CutterBeyondCell { diameter: cutter.tip_diameter(), cell: cell.min_element() });
        }
        if let Some(cutter) = self.design.sheet.cutter {
            not_too_fine(cutter, Tool::least_diameter(cell, grid))?;
        }
        let cell = cell.min_element();
        match self.design.sheet.polish.filter(|polish| *polish >= 0.25 * cell) {
            Some(polish) => Err(RecipeError::PolishBeyondCell { polish, cell }),
            None => Ok(()),
        }
    }
}

/// Refuses a cutter smaller than `least` mm.
fn not_too_fine(cutter: Cutter, least: f64) -> Result<(), RecipeError> {
    // Rounded up, so that what the message names will do.
    let least = (1e3 * least).ceil() / 1e3;
    let diameter = cutter.tip_diameter();
    if diameter < least { Err(RecipeError::CutterTooFine { diameter, least }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::arrange::anneal::Annealing;
    use crate::recipe::Cells;

    #[test]
    fn a_recipe_survives_toml_and_typos_do_not() {
        for recipe in [Recipe::default(), Recipe::weyrich2009()] {
            assert_eq!(recipe.check(), Ok(()));
            assert_eq!(Recipe::from_toml(&recipe.to_toml()), Ok(recipe));
        }
        assert_eq!(Recipe::from_toml(""), Ok(Recipe::default()));
        let typo = Recipe::from_toml("[light]\ntheta = 30\nthata = 3\n").unwrap_err();
        assert!(matches!(&typo, RecipeError::Unreadable(what, 3) if what.contains("thata")), "{typo:?}");
        let third = Recipe::from_toml("[plate]\nsize = [30, 30, 30]\n").unwrap_err();
        assert!(matches!(&third, RecipeError::Unreadable(what, 2) if what.contains("two")), "{third:?}");
    }

    #[test]
    fn nonsense_is_named() {
        let refused = |change: fn(&mut Recipe)| {
            let mut recipe = Recipe::default();
            change(&mut recipe);
            recipe.check().unwrap_err()
        };
        let named = |error| match error {
            RecipeError::OutOfRange { setting, .. } => setting,
            other => panic!("{other}"),
        };
        assert_eq!(named(refused(|r| r.highlight.half_field = 0.0.into())), "half-field");
        assert_eq!(named(refused(|r| r.highlight.half_field = f64::NAN.into())), "half-field");
        assert_eq!(named(refused(|r| r.light.theta = 90.0)), "light");
        assert_eq!(named(refused(|r| r.plate.size[1] = f64::INFINITY)), "size");
        assert_eq!(named(refused(|r| r.plate.facets = Some([0, 30]))), "facets");
        assert_eq!(named(refused(|r| r.plate.cells = Some(0.into()))), "cells");
        assert!(refused(|r| r.plate.border_finish = Some(BorderFinish::Polished)).to_string().contains("--border"));
        let steep =
            |r: &mut Recipe| (r.plate.border, r.plate.border_finish) = (3.0, Some(BorderFinish::Sloped(Some(70.0))));
        assert_eq!(named(refused(steep)), "border-finish");
        assert_eq!(named(refused(|r| r.design.seed = u64::MAX)), "seed");
        let near = |r: &mut Recipe| (r.design.sheet.preview, r.scene.focus) = (true, Some(1000.0));
        assert!(refused(near).to_string().contains("nearby, or preview"));
        let flat = |r: &mut Recipe| (r.design.sheet.preview, r.plate.surface) = (true, Some(SurfaceKind::Facets));
        assert_eq!(refused(flat), RecipeError::NoPreview { with: "facets" });
        assert_eq!(
            named(refused(|r| r.design.annealing = Some(Annealing { valleys: f64::NAN, ..Annealing::default() }))),
            "annealing.valleys"
        );
        assert_eq!(
            named(refused(|r| r.design.annealing = Some(Annealing { starts: 0, ..Annealing::default() }))),
            "annealing.starts"
        );
        let flat = |change: fn(&mut Recipe)| {
            let mut recipe = Recipe::default();
            recipe.plate.surface = Some(SurfaceKind::Facets);
            assert_eq!(recipe.check(), Ok(()));
            change(&mut recipe);
            recipe.check().unwrap_err()
        };
        let error = flat(|r| r.plate.cells = Some(4.into()));
        assert!(error.is_impossible() && error.to_string().contains("--facets 32x32"), "{error}");
        assert!(flat(|r| r.plate.facets = Some([3000, 3000])).is_impossible());
        assert!(flat(|r| r.plate.facets = Some([2, 300])).is_impossible());
        let error = flat(|r| r.design.sheet.cutter = Some(Cutter::ball(0.07)));
        assert!(error.to_string().contains("0.075 mm or more"), "{error}");
        let wide = flat(|r| {
            (r.plate.facets, r.plate.size) = (Some([2000, 2000]), [1.0, 1.0]);
            r.design.sheet.cutter = Some(Cutter::ball(100.0));
        });
        assert!(wide.is_impossible() && matches!(wide, RecipeError::CutterTooWide { .. }), "{wide}");
        assert_eq!(named(refused(|r| r.plate.grid = Some(2))), "grid");
        assert_eq!(named(refused(|r| r.design.sheet.min_feature = Some(-1.0))), "min-feature");
        assert_eq!(named(refused(|r| r.design.sheet.polish = Some(f64::NAN))), "polish");
        assert_eq!(named(refused(|r| r.design.sheet.max_depth = Some(0.0))), "max-depth");
        assert_eq!(named(refused(|r| r.design.sheet.cutter = Some(Cutter::ball(f64::NAN)))), "for-cutter");
        let continuous = |change: fn(&mut Recipe)| {
            let mut recipe = Recipe::default();
            recipe.plate.surface = Some(SurfaceKind::Sheet);
            assert_eq!(recipe.check(), Ok(()));
            change(&mut recipe);
            recipe.check().unwrap_err()
        };
        assert_eq!(continuous(|r| r.plate.grid = Some(255)), RecipeError::OddGrid { grid: 255 });
        let error = continuous(|r| r.plate.grid = Some(1024));
        assert!(error.is_impossible() && error.to_string().contains("--grid to 408"), "{error}");
        let error = continuous(|r| (r.plate.size, r.plate.cells) = ([30.0, 2.0], Some(3.into())));
        assert!(matches!(error, RecipeError::LongCells { .. }));
        let many = continuous(|r| r.plate.cells = Some(1000.into())).to_string();
        assert!(many.contains("fewer --cells"), "{many}");
        let error = flat(|r| r.plate.cells = Some(Cells([5, 4])));
        assert!(error.to_string().contains("5x4 cells: take --facets 30x32"), "{error}");
        assert!(continuous(|r| r.design.sheet.cutter = Some(Cutter::ball(20.0))).is_impossible());
        assert!(continuous(|r| r.design.sheet.polish = Some(2.5)).is_impossible());
    }

    #[test]
    fn the_smallest_ball_that_is_named_will_do() {
        let with = |ball, change: fn(&mut Recipe)| {
            let mut recipe = Recipe::default();
            recipe.plate.surface = Some(SurfaceKind::Sheet);
            recipe.design.sheet.cutter = Some(Cutter::ball(ball));
            change(&mut recipe);
            recipe.check()
        };
        for (ball, change) in [
            (0.001, (|_| {}) as fn(&mut Recipe)),
            (0.01, |r| r.plate.size = [100.0, 100.0]),
            (0.1, |r| (r.plate.size, r.plate.grid, r.plate.cells) = ([100.0, 100.0], Some(16), Some(1.into()))),
        ] {
            let refused = with(ball, change).unwrap_err();
            let RecipeError::CutterTooFine { least, .. } = refused else { panic!("{refused}") };
            assert!(refused.is_impossible() && with(least, change).is_ok(), "{refused}");
            assert!(with(0.99 * least - 0.001, change).is_err());
        }
    }

    #[test]
    fn a_budget_of_triangles_chooses_the_grid_and_is_kept() {
        for (most, grid) in [(75_000, 60), (76_032, 64), (50_000, 48), (10_000, 20), (3_000_000, 400)] {
            let mut recipe = Recipe::default();
            recipe.plate.max_triangles = Some(most);
            assert_eq!((recipe.check(), recipe.sculpting().grid), (Ok(()), grid), "{most}");
            assert!(recipe.triangles(grid) <= most as f64);
        }
        let mut recipe = Recipe::default();
        recipe.plate.max_triangles = Some(4000);
        let error = recipe.check().unwrap_err().to_string();
        assert!(error.contains("5184 triangles") && error.contains("fewer --cells"), "{error}");
        (recipe.plate.max_triangles, recipe.plate.grid) = (Some(75_000), Some(64));
        let error = recipe.check().unwrap_err().to_string();
        assert!(error.contains("76032 triangles") && error.contains("--grid to 62"), "{error}");
    }
}
