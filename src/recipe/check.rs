//! Which recipes can be made at all.

use super::settings::{LEAST_GRID, MOST_FACETS, SETTINGS, within};
use super::{BorderFinish, Recipe, SceneFault, SurfaceKind};
use crate::cutter::{Cutter, UnmodelledCutter};
use crate::milling::made::MachiningError;
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
        self.check_scene()?;
        self.check_kind()?;
        self.machining()?;
        if self.plate.border == 0.0 && self.border_finish() != BorderFinish::Matt {
            return Err(RecipeError::NoBorder);
        }
        match self.surface() {
            SurfaceKind::Facets => self.check_facets(),
            SurfaceKind::Sheet => self.check_sheet(),
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

/// Why a recipe cannot be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecipeError {
    /// Not TOML, or not of this program: what, and on which line.
    #[error("line {1} makes no sense: {0}")]
    Unreadable(String, usize),
    /// A number outside what is possible.
    #[error("{setting} is {value}: it must be from {low} to {high}")]
    OutOfRange {
        /// Name of the setting, as in the flag.
        setting: &'static str,
        /// What was asked.
        value: f64,
        /// Least possible.
        low: f64,
        /// Most possible.
        high: f64,
    },
    /// Lamp and wall nearby that make no scene.
    #[error(transparent)]
    Scene(#[from] SceneFault),
    /// A setting of one kind of relief beside one of the other.
    #[error("{setting} is for {}: leave out one of the two", other_kind(*kind, decisive))]
    OtherKind {
        /// Name of the setting without meaning, as in the flag.
        setting: &'static str,
        /// Name of the setting that decided for the other kind.
        decisive: &'static str,
        /// The kind of the relief.
        kind: SurfaceKind,
    },
    /// A setting of making without a machine.
    #[error("{setting} is for a plate that a machine makes: name one with --machine, or leave it out")]
    NoMachine {
        /// Name of the setting, as in the flag.
        setting: &'static str,
    },
    /// A machine that is none.
    #[error("machine: {0}")]
    Machine(String),
    /// A machine without a cutter.
    #[error("machine: say what it cuts with, such as --for-cutter ball:0.5 (--cutter of a plate that is there)")]
    NoCutter,
    /// A surface that is too fine for a file.
    #[error("as-made-stl is for a plate that is polished: give --polish too, or leave it out")]
    NoPolish,
    /// A proof that there is not.
    #[error(
        "machine: the proof as made is for lamps and walls far away: leave it out, or the flags of lamp and wall nearby"
    )]
    MachineNearby,
    /// What the machine cannot make.
    #[error(transparent)]
    Machining(#[from] MachiningError),
    /// A finish of a rim that is not there.
    #[error("border-finish is for a plate with a rim: give --border too, or leave it out")]
    NoBorder,
    /// Facets do not divide into cells.
    #[error(
        "{columns}x{rows} facets do not divide into {}x{} cells: take --facets {near_columns}x{near_rows}, or other --cells",
        cells[0],
        cells[1]
    )]
    Indivisible {
        /// Facets along x.
        columns: usize,
        /// Facets along y.
        rows: usize,
        /// Cells along x and y.
        cells: [usize; 2],
        /// The nearest number along x that divides.
        near_columns: usize,
        /// The nearest number along y that divides.
        near_rows: usize,
    },
    /// More than fits.
    #[error("{columns}x{rows} facets are more than the 4 million that one plate can have: take fewer --facets")]
    TooManyFacets {
        /// Facets along x.
        columns: usize,
        /// Facets along y.
        rows: usize,
    },
    /// Facets twenty times as long as wide.
    #[error("facets would be {across:.3} mm by {up:.3} mm: choose --facets in proportion to --size")]
    Slivers {
        /// Facet size along x, mm.
        across: f64,
        /// Facet size along y, mm.
        up: f64,
    },
    /// The transforms want pairs of nodes.
    #[error("a grid of {grid} nodes is odd: take --grid {}", grid + 1)]
    OddGrid {
        /// Nodes a side.
        grid: usize,
    },
    /// Cells four times as long as wide.
    #[error(
        "cells would be {across:.3} mm by {up:.3} mm: leave out --cells, choose a --size whose sides differ by less than four times, or take flat facets (--facets)"
    )]
    LongCells {
        /// Cell size along x, mm.
        across: f64,
        /// Cell size along y, mm.
        up: f64,
    },
    /// Over the budget.
    #[error("the grid needs {triangles:.0} triangles, over the budget: {}, or raise --max-triangles", fewer(*most))]
    TooManyTriangles {
        /// Triangles on the plate.
        triangles: f64,
        /// The largest grid within the budget.
        most: usize,
    },
    /// A cutter that sheets cannot be designed for.
    #[error(transparent)]
    UnmodelledCutter(#[from] UnmodelledCutter),
    /// A ball wider than what it shall cut.
    #[error("a cutter of {diameter} mm cannot cut cells of {cell:.3} mm: take a smaller cutter or fewer --cells")]
    CutterBeyondCell {
        /// Its diameter, mm.
        diameter: f64,
        /// Shorter side of a cell, mm.
        cell: f64,
    },
    /// A cutter too small to follow over a plate.
    #[error(
        "a cutter of {diameter} mm is too small to be followed over the whole plate: name one of {least} mm or more in --for-cutter, take a smaller --size, or leave the cutter out"
    )]
    CutterTooFine {
        /// Its diameter, mm.
        diameter: f64,
        /// The smallest that can be, mm.
        least: f64,
    },
    /// A cutter that takes thousands of facets to pass over.
    #[error(
        "a cutter of {diameter} mm is too wide to be followed over facets of {pitch:.4} mm: take a smaller cutter in --for-cutter or fewer --facets"
    )]
    CutterTooWide {
        /// Its diameter, mm.
        diameter: f64,
        /// Shorter side of a facet, mm.
        pitch: f64,
    },
    /// Polish that leaves nothing.
    #[error(
        "a polish of {polish} mm leaves nothing of cells of {cell:.3} mm: it must be less than a quarter of them, take a smaller --polish or fewer --cells"
    )]
    PolishBeyondCell {
        /// Standard deviation, mm.
        polish: f64,
        /// Shorter side of a cell, mm.
        cell: f64,
    },
}

fn fewer(most: usize) -> String {
    if most < LEAST_GRID { "take fewer --cells".into() } else { format!("lower --grid to {most}") }
}

fn other_kind(kind: SurfaceKind, decisive: &str) -> String {
    match kind {
        SurfaceKind::Facets => format!("a sheet, and --{decisive} makes this plate one of flat facets"),
        SurfaceKind::Sheet => format!("flat facets, and --{decisive} makes this plate a sheet"),
    }
}

impl RecipeError {
    /// Whether the settings are sound one by one but no plate can have them together.
    pub fn is_impossible(&self) -> bool {
        match self {
            Self::Unreadable(..) | Self::OutOfRange { .. } | Self::OtherKind { .. } | Self::NoBorder => false,
            Self::NoMachine { .. } | Self::Machine(_) | Self::NoCutter | Self::NoPolish | Self::MachineNearby => false,
            Self::Scene(fault) => fault.is_impossible(),
            _ => true,
        }
    }
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
        assert_eq!(named(refused(|r| r.highlight.half_field = 0.0)), "half-field");
        assert_eq!(named(refused(|r| r.highlight.half_field = f64::NAN)), "half-field");
        assert_eq!(named(refused(|r| r.light.theta = 90.0)), "light");
        assert_eq!(named(refused(|r| r.plate.size[1] = f64::INFINITY)), "size");
        assert_eq!(named(refused(|r| r.plate.facets = Some([0, 30]))), "facets");
        assert_eq!(named(refused(|r| r.plate.cells = Some(0.into()))), "cells");
        assert!(refused(|r| r.plate.border_finish = Some(BorderFinish::Polished)).to_string().contains("--border"));
        let steep =
            |r: &mut Recipe| (r.plate.border, r.plate.border_finish) = (3.0, Some(BorderFinish::Sloped(Some(70.0))));
        assert_eq!(named(refused(steep)), "border-finish");
        assert_eq!(named(refused(|r| r.design.seed = u64::MAX)), "seed");
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
