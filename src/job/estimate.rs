//! What a design would be, from its sizes alone.

use super::memory::need;
use crate::export::stl::stl_bytes;
use crate::facets::sample::Sampling;
use crate::recipe::{Arrangement, Cutter, Recipe, SurfaceKind};
use crate::report::estimate::{EstimateReport, Parts};
use crate::sculpt::milled_facets::places;
use crate::sculpt::plan::{SheetSpec, Step, plan};
use crate::sculpt::tool::Tool;

/// (facets, CPU seconds) measured on one core of a 2020s server; pictures differ by a third.
type Measured = &'static [(f64, f64)];

const VORONOI: Measured =
    &[(25.0, 0.01), (100.0, 0.02), (400.0, 0.04), (900.0, 0.2), (2400.0, 0.43), (1e4, 0.4), (4e4, 1.1), (1.6e5, 4.1)];

/// Up to 1024 facets in one exact assignment, beyond that a flow and windows.
const TRANSPORT: Measured = &[
    (100.0, 0.001),
    (400.0, 0.007),
    (900.0, 0.07),
    (1024.0, 0.09),
    (1025.0, 0.013),
    (2400.0, 0.03),
    (1e4, 0.15),
    (4e4, 0.56),
    (1.6e5, 2.1),
    (1e6, 15.3),
];

/// CPU seconds an exchange of facets tried in annealing.
const EXCHANGE: f64 = 3.8e-8;

/// CPU seconds for the pictures and the rest of the files.
const FILES: f64 = 0.63;

/// CPU seconds for scoring, a ray, and one on metal with a lobe.
const PROOF: (f64, f64, f64) = (0.5, 1.1e-7, 7e-7);

/// CPU seconds a place of the tool on a plate of facets, to mill it and to send light over it.
const MILLED_PLACE: f64 = 4.5e-7;

/// CPU seconds of any sheet, and for each evaluation of a node that its plan counts: without a cutter, and for one. Cells of 64²,
/// 128² and 400² nodes took 0.9, 2.5 and 6.5 s; for a ball of 0.5 in 10 mm 3.6, 4.8 and 16 s.
const SCULPTING: (f64, f64, f64) = (0.35, 1.7e-7, 3e-7);

/// CPU seconds a place of the tool over a cell: on its grid, where its light is taken again and again, and without steps,
/// where valleys are filled. A cell of 30 mm and 16² nodes for a ball of 1 mm, 1500² and 3008² places, takes 8.5 s.
const TOOL_PLACE: (f64, f64) = (1.3e-6, 6e-7);

/// CPU seconds of a plate as made: a place at which the cutter is lowered, a sample of its surface, a node that is polished,
/// closed and traced. On 30 mm, ball 0.5, polished 40 µm, passes 0.04 and 0.08 mm apart took 12.7 and 9.9 s.
const MADE: (f64, f64, f64) = (1.2e-6, 5e-8, 3e-6);

/// CPU seconds of proving the plate as the recipe's machine makes it, in each draw of its errors.
fn made_seconds(recipe: &Recipe) -> f64 {
    let Ok(Some(machining)) = recipe.machining() else { return 0.0 };
    let work = machining.work(recipe.plate.size.into());
    let (place, sample, node) = MADE;
    let draw = sample * work.samples + node * work.nodes + proof_seconds(recipe);
    place * work.places + recipe.draws() as f64 * draw
}

/// What a design of `recipe` will be for a picture of `side` pixels a side; `proved` if light is to be sent over it.
///
/// "About" is within a third; of a sheet, triangles and bytes are exact but for its base.
pub fn estimate(recipe: &Recipe, side: usize, proved: bool) -> EstimateReport {
    let facts = match recipe.surface() {
        SurfaceKind::Facets => faceted_facts(recipe, proved),
        SurfaceKind::Sheet => continuous_facts(recipe, proved),
    };
    let verify = facts.verify_cpu_seconds_about + if proved { made_seconds(recipe) } else { 0.0 };
    EstimateReport { memory_bytes_about: need(recipe, side, proved).bytes, verify_cpu_seconds_about: verify, ..facts }
}

fn faceted_facts(recipe: &Recipe, proved: bool) -> EstimateReport {
    let [columns, rows] = recipe.facets();
    let facets = columns * rows;
    let (pitch, rim) = (recipe.pitch(), 2.0 * recipe.plate.border);
    // Measured on drawings and photographs: 8.4 to 11 triangles a facet with its walls. The rest is sides and base.
    let triangles = 19 * facets / 2 + 8 * (columns + rows);
    let proof = proof_seconds(recipe);
    let [width, height] = recipe.plate.size;
    let milled =
        recipe.design.sheet.cutter.map_or(0.0, |cutter| MILLED_PLACE * places(width * height, cutter) + PROOF.0);
    EstimateReport {
        dry_run: true,
        plate_mm: recipe.plate.size.map(|side| side + rim),
        pitch_mm: pitch.to_array(),
        parts: Parts::Facets { facets },
        stl_triangles_about: triangles,
        stl_bytes_about: stl_bytes(triangles),
        design_cpu_seconds_about: design_seconds(recipe),
        verify_cpu_seconds_about: if proved { proof + milled } else { 0.0 },
        files_cpu_seconds_about: FILES + 2e-6 * facets as f64,
        memory_bytes_about: 0,
        least_stray_share: None,
    }
}

fn continuous_facts(recipe: &Recipe, proved: bool) -> EstimateReport {
    let sculpting = recipe.sculpting();
    let ([columns, rows], rim) = (sculpting.cells.map(|cells| cells * sculpting.grid), 2.0 * recipe.plate.border);
    let triangles = 2 * columns * rows + 8 * (columns + rows);
    let step = sculpting.cell / sculpting.grid as f64;
    let proof = proof_seconds(recipe);
    let [width, height] = recipe.plate.size;
    // The facets that it is compared with, and as milled all of it once more.
    let flat = design_seconds(&recipe.clone().only_for(SurfaceKind::Facets));
    let milled = |c: Cutter| 2.0 * proof + MILLED_PLACE * places(width * height, c);
    let beside = flat + recipe.design.sheet.cutter.map_or(0.0, milled);
    EstimateReport {
        dry_run: true,
        plate_mm: recipe.plate.size.map(|side| side + rim),
        pitch_mm: step.to_array(),
        parts: Parts::Sheet { grid: sculpting.grid, cells: sculpting.cells },
        stl_triangles_about: triangles,
        stl_bytes_about: stl_bytes(triangles),
        design_cpu_seconds_about: sculpting_seconds(&sculpting),
        verify_cpu_seconds_about: if proved { proof + beside } else { 0.0 },
        files_cpu_seconds_about: FILES + 2e-7 * triangles as f64,
        memory_bytes_about: 0,
        least_stray_share: None,
    }
}

/// Leading the cutter over a cell.
fn tool_seconds(sculpting: &SheetSpec) -> f64 {
    let SheetSpec { cell, grid, settings, .. } = *sculpting;
    settings.cutter.map_or(0.0, |cutter| {
        let (stepping, fine) = (Tool::new(cell, cutter), Tool::without_steps(cell, grid, cutter));
        TOOL_PLACE.0 * stepping.all_places() + TOOL_PLACE.1 * fine.all_places()
    })
}

/// What the steps of a sheet's plan cost.
fn sculpting_seconds(spec: &SheetSpec) -> f64 {
    let evaluations: f64 = plan(spec).iter().map(Step::cost).sum();
    let (fixed, bare, cut) = SCULPTING;
    match spec.settings.cutter {
        None => fixed + bare * evaluations,
        Some(_) => fixed + cut * evaluations + tool_seconds(spec),
    }
}

fn proof_seconds(recipe: &Recipe) -> f64 {
    let ray = if recipe.metal().is_smooth() { PROOF.1 } else { PROOF.2 };
    PROOF.0 + ray * recipe.verify.rays as f64
}

fn design_seconds(recipe: &Recipe) -> f64 {
    let [columns, rows] = recipe.facets();
    let facets = (columns * rows) as f64;
    let cells = recipe.cells().iter().product::<usize>() as f64;
    let sampling = match recipe.sampling() {
        Sampling::Voronoi => interpolated(VORONOI, facets),
        Sampling::Random | Sampling::Sobol => 2e-7 * facets,
    };
    let annealing = recipe.annealing();
    let arrangement = match recipe.arrangement() {
        Arrangement::Transport => cells * interpolated(TRANSPORT, facets / cells),
        Arrangement::Anneal => cells * EXCHANGE * (annealing.swaps as f64) * f64::from(annealing.starts),
        Arrangement::Random => 0.0,
    };
    0.01 + sampling + arrangement
}

/// A power law between the measured sizes, in proportion to size beyond them.
fn interpolated(measured: Measured, size: f64) -> f64 {
    let (first, last) = (measured[0], measured[measured.len() - 1]);
    if size <= first.0 || size >= last.0 {
        let nearest = if size <= first.0 { first } else { last };
        return nearest.1 * size / nearest.0;
    }
    let next = measured.partition_point(|(at, _)| *at <= size);
    let ((x0, y0), (x1, y1)) = (measured[next - 1], measured[next]);
    y0 * (y1 / y0).powf((size / x0).ln() / (x1 / x0).ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_of_few_nodes_takes_as_long_as_its_tool_has_places() {
        let mut recipe = Recipe::default();
        (recipe.plate.grid, recipe.plate.cells) = (Some(16), Some(1.into()));
        let seconds = |ball: f64| {
            let mut recipe = recipe.clone();
            recipe.design.sheet.cutter = Some(Cutter::ball(ball));
            estimate(&recipe, 256, false).design_cpu_seconds_about
        };
        // 8.5 s were measured.
        assert!((6.0..12.0).contains(&seconds(1.0)), "{}", seconds(1.0));
        assert!(seconds(0.25) > 2.0 * seconds(1.0));
    }

    #[test]
    fn between_measurements_is_a_power_law_and_beyond_them_proportion() {
        let square: Measured = &[(1.0, 1.0), (10.0, 100.0), (20.0, 400.0)];
        for (size, seconds) in [(1.0, 1.0), (3.0, 9.0), (10.0, 100.0), (15.0, 225.0), (40.0, 800.0), (0.5, 0.5)] {
            assert!((interpolated(square, size) / seconds - 1.0).abs() < 1e-12, "{size}");
        }
    }

    #[test]
    fn a_sheet_takes_about_as_long_as_its_plan_and_its_tool_say() {
        // CPU seconds of designs of the example pictures, one thread of a release build, beside other work.
        for (grid, side, ball, measured) in [
            (64, 10.0, None, 0.93),
            (64, 10.0, Some(0.5), 3.59),
            (128, 10.0, None, 2.49),
            (128, 10.0, Some(0.5), 4.8),
            (128, 30.0, Some(1.0), 11.8),
            (400, 10.0, None, 6.5),
            (400, 10.0, Some(0.5), 16.0),
        ] {
            let mut recipe = Recipe::default();
            (recipe.plate.size, recipe.plate.cells, recipe.plate.grid) = ([side; 2], Some(1.into()), Some(grid));
            recipe.design.sheet.cutter = ball.map(Cutter::ball);
            let told = estimate(&recipe, 256, false).design_cpu_seconds_about;
            assert!((measured / 1.5..measured * 1.5).contains(&told), "{grid} {side} {ball:?}: {told} {measured}");
        }
    }
}
