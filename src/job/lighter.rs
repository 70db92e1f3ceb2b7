//! What a smaller file of a sheet that is written whole would cost in light: its triangles on a coarser grid, not a second
//! design.

use super::design::Design;
use crate::export::stl::stl_bytes;
use crate::raster::Raster;
use crate::recipe::Recipe;
use crate::relief::periodic::PeriodicRelief;
use crate::sculpt::plan::suitable_grid;
use crate::sculpt::resample::sampled;
use crate::verify::windows::misplaced_by_a_cell;

/// Triangles from which on programs for CAM become slow: an STL of 50 MB.
pub const HEAVY: usize = 1_000_000;

/// Triangles of the smaller file, as a share of those there are: half as many nodes a side, and a little more for the base.
const SHARE: f64 = 0.26;

/// A smaller file of the same relief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lighter {
    /// Nodes along a side of a cell.
    pub grid: usize,
    /// Triangles.
    pub triangles: usize,
    /// Size of the STL, bytes.
    pub bytes: u64,
    /// Misplaced light at the main blur by first bounces, as written: of the smaller file, and of the one there is.
    pub misplaced: [f64; 2],
}

/// What `design` would be in about a quarter of its triangles, if its file is heavy, and neither thinned nor to be whole;
/// `target` is what was wanted.
pub fn lighter(recipe: &Recipe, design: &Design, target: &Raster) -> Option<Lighter> {
    let asked = recipe.plate.fine || design.thinning.is_some();
    let heavy = design.mesh.triangles.len() >= HEAVY && !asked;
    let sheet = design.sheet.as_ref().filter(|_| heavy)?;
    let cell = PeriodicRelief { cells: [1, 1], ..sheet.relief.clone() };
    let most = SHARE * design.mesh.triangles.len() as f64;
    let grid = suitable_grid(cell.cell, None, |grid| recipe.triangles(grid) <= most);
    let coarse = PeriodicRelief { nodes: grid, heights: sampled(&cell, grid), ..cell.clone() };
    let setup = &design.distribution.setup;
    let blur = recipe.blur(setup);
    let of = |relief: &PeriodicRelief| misplaced_by_a_cell(relief, setup, blur.as_ref(), target);
    let triangles = recipe.triangles(grid) as usize;
    Some(Lighter { grid, triangles, bytes: stl_bytes(triangles), misplaced: [of(&coarse)?, of(&cell)?] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::highlight::scored_target;
    use crate::job::clock::on_own_threads;
    use crate::job::design::design;
    use crate::progress::Progress;

    #[test]
    fn a_heavy_file_is_told_what_a_quarter_of_it_costs_without_a_second_design() {
        let ring = Raster::from_fn(64, 64, |x, y| {
            let radius = (x as f64 - 31.5).hypot(y as f64 - 31.5) / 32.0;
            f64::from(u8::from((0.4..0.6).contains(&radius)))
        });
        let mut recipe = Recipe::default();
        (recipe.plate.grid, recipe.plate.cells) = (Some(48), Some(2.into()));
        let mut plate = design(&recipe, &ring, &Progress::silent()).unwrap();
        let target = scored_target(&ring, recipe.highlight.quantity, &plate.distribution.setup, 256);
        assert_eq!(lighter(&recipe, &plate, &target), None, "a small file needs no smaller one");
        // The same relief in a file of more than a million triangles. Its own 48 nodes are not among the 160 of a smaller one,
        // so that this loses light, though not much.
        let sheet = plate.sheet.as_mut().unwrap();
        sheet.relief = PeriodicRelief { nodes: 384, heights: sampled(&sheet.relief, 384), ..sheet.relief.clone() };
        plate.mesh = crate::export::sheet::sheet_solid(&sheet.relief, 5.0, 0.0, &Progress::silent()).unwrap();
        recipe.plate.grid = Some(384);
        let (made, spent) = on_own_threads(None, || lighter(&recipe, &plate, &target)).unwrap();
        let made = made.unwrap();
        assert!((made.grid, made.triangles) == (160, 208_640) && made.bytes == stl_bytes(208_640), "{made:?}");
        let [coarse, whole] = made.misplaced;
        assert!(whole < 0.005 && (whole..0.05).contains(&coarse), "{made:?}");
        // A second design on as many nodes takes longer than this by far; how long it takes varies with the machine.
        assert!(spent.cpu.as_secs_f64() < 3.0, "{spent:?}");
    }
}
