//! How many triangles the file of a sheet may have.

use super::{Recipe, SurfaceKind};

/// Triangles from which on CAM programs become slow: an STL of 25 MB.
const LIGHT: usize = 500_000;

/// The share of a sheet's own triangles in which its light still counts. A word for a ball of 0.5 mm, 0.0059 of its light
/// misplaced at 1° in all triangles, has 0.0080 in a fifteenth and 0.0157 in a twentieth; a sheet that is designed on so
/// coarse a grid 0.0096 and 0.0116.
const LEAST_SHARE: f64 = 1.0 / 16.0;

/// What decides how many triangles are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileSize {
    /// All that the grid has.
    Whole,
    /// Fewer: so many at the most.
    AtMost(usize),
    /// Fewer: so many, or as many more as its light needs.
    AsLightAllows(usize),
}

impl Recipe {
    /// How many triangles the file of a sheet may have.
    ///
    /// A grid that was asked for is written as it is, and so are previews, and goals: their light, wide and smooth, needs two
    /// thirds of all triangles or more (of three goals two could do with 96 MB in place of 145, one with no less). A budget thins sheets for a
    /// cutter; one that no cutter rounds is grainier thinned than designed on a grid that fits: 0.0048 of a portrait's light
    /// misplaced at 1° in place of 0.0013 in 200,000 triangles.
    pub fn file_size(&self) -> FileSize {
        let plate = &self.plate;
        let whole = self.design.sheet.preview || plate.grid.is_some() || self.goal.is_some();
        if self.surface() != SurfaceKind::Sheet || whole {
            return FileSize::Whole;
        }
        match plate.max_triangles {
            Some(most) if self.design.sheet.cutter.is_some() => {
                let grid = self.usual_grid(most);
                let (surface, whole) = (self.surface_triangles(grid), self.triangles(grid));
                // Triangles of eight squares' side are there in any case.
                let enough = grid.is_multiple_of(8) && most as f64 - (whole - surface) >= LEAST_SHARE * surface;
                if enough { FileSize::AtMost(most) } else { FileSize::Whole }
            }
            None if !plate.fine => FileSize::AsLightAllows(LIGHT),
            _ => FileSize::Whole,
        }
    }
}
