//! What a design would be, from its sizes alone.

use super::made::BARE_ROWS;
use super::memory::need;
use super::near::likely_method;
use crate::export::stl::stl_bytes;
use crate::facets::sample::Sampling;
use crate::recipe::file_size::FileSize;
use crate::recipe::{Arrangement, NearMethod, Recipe, SurfaceKind};
use crate::report::estimate::{EstimateReport, Parts};
use crate::sculpt::milled_facets::places;
use crate::sculpt::plan::{SheetSpec, Step, plan};
use crate::sculpt::room::exact::evaluations;
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

/// CPU seconds for the pictures and the rest of the files: of facets, of a sheet, and for each triangle of a sheet. Without a
/// proof 900 facets took 0.8 s, sheets of 0.3 and 2.9 million triangles 0.3 and 0.5 s.
const FILES: (f64, f64, f64) = (0.75, 0.3, 7e-8);

/// CPU seconds for scoring and its pictures, a ray over facets, and one on metal with a lobe. 900 facets took 1.3 s with
/// 2 million rays.
const PROOF: (f64, f64, f64) = (1.15, 1.1e-7, 7e-7);

/// The same over a sheet, and what each of its triangles takes. 0.3 and 2.9 million triangles took 1.2 and 3.2 s.
const SHEET_PROOF: (f64, f64, f64, f64) = (0.2, 3.7e-7, 7e-7, 8e-7);

/// CPU seconds of a place of the tool over a sheet, to mill it and to send light over it. A ball of 1 mm took 1.5 s more.
const MILLED_PLACE: f64 = 5e-7;

/// CPU seconds of scoring the facets that a sheet is compared with, beside their rays.
const BESIDE: f64 = 0.4;

/// CPU seconds of proving facets, or a plate in a room, as milled, and a place of the tool. For a ball of 1 mm 900 facets took
/// 6.2 s more, those beside a sheet 4.7 s.
const MILLED: (f64, f64) = (2.2, 1.4e-6);

/// CPU seconds of a descent over a whole plate in its room: any, and for each evaluation of a node without a cutter and for
/// one. Plates of 192² and 384² nodes took 3.3 and 9.9 s.
const ROOM: (f64, f64, f64) = (0.5, 3.5e-7, 7.4e-7);

/// CPU seconds a place of the tool over such a plate, without steps. 30 mm with 192² and 384² nodes for a ball of 0.5 mm, 22.6
/// million places, took 22 to 27 and 41 s in all; for a ball of 1 mm with 144² nodes, 11.3 million, 10.6 s.
const ROOM_PLACE: f64 = 7e-7;

/// CPU seconds of the proof in a room: any, a ray, a triangle, which is thrown onto a dozen walls. Plates of 74,000 and 295,000
/// triangles took 2.2 and 3.1 s with 2 million rays.
const ROOM_PROOF: (f64, f64, f64) = (1.0, 4.5e-7, 4e-6);

/// CPU seconds of any sheet, and for each evaluation of a node that its plan counts: without a cutter, and for one. Cells of 64²,
/// 128² and 400² nodes took 0.7, 2.3 and 5.4 s; for a ball of 0.5 in 10 mm 2.4, 3.7 and 13 to 15 s.
const SCULPTING: (f64, f64, f64) = (0.35, 1.6e-7, 2.8e-7);

/// CPU seconds a place of the tool over a cell: on its grid, where its light is taken again and again; without steps, where
/// valleys are filled, once over all places and again beside each node that is raised, a few hundred times over one node's
/// share of the places. A cell of 30 mm for a ball of 0.5 mm, 2000² and 4224² places, takes 7.6 s on 128² nodes, for one of
/// 0.3 mm, 2000² and 5504², 5.7 s on 64², for one of 1 mm, 1500² and 3008², 6.7 s on 16².
const TOOL_PLACE: (f64, f64, f64) = (1e-6, 2e-8, 1.1e-4);

/// CPU seconds of a plate as made: a place at which the cutter is lowered, a sample of its surface, a node that is polished,
/// closed and traced. On 30 mm, ball 0.5, polished 40 µm, passes 0.04 and 0.08 mm apart took 12.7 and 9.9 s;
/// ball 1, passes 0.05 and 0.1 mm apart 6.5 and 4.1 s.
const MADE: (f64, f64, f64) = (1.2e-6, 5e-8, 2e-6);

/// CPU seconds of a slope of a plate as made that is not polished. On 30 mm, ball 1, passes 0.05 mm apart took 40 s.
const BARE: f64 = 1.6e-6;

/// CPU seconds of proving the plate as the recipe's machine makes it, in each draw of its errors.
fn made_seconds(recipe: &Recipe) -> f64 {
    let Ok(Some(machining)) = recipe.machining() else { return 0.0 };
    let work = machining.work(recipe.plate.size.into());
    let (place, sample, node) = MADE;
    let draw = match machining.polish {
        None => BARE * BARE_ROWS as f64 * work.along,
        Some(_) => sample * work.samples + node * work.nodes + PROOF.0 + ray_seconds(recipe, PROOF.1),
    };
    place * work.places + recipe.draws() as f64 * draw
}

/// What a design of `recipe` will be for a picture of `side` pixels a side; `proved` if light is to be sent over it.
///
/// Times are those of a thread of the machine on which they were measured, and
/// [`on_machine`](EstimateReport::on_machine) makes them those of another; "about" is within a half. Of a sheet, triangles and
/// bytes are exact but for its base, unless it is thinned as far as its light allows: without a cutter that shows only when
/// it is done.
pub fn estimate(recipe: &Recipe, side: usize, proved: bool) -> EstimateReport {
    let facts = match recipe.surface() {
        SurfaceKind::Facets => faceted_facts(recipe, proved),
        SurfaceKind::Sheet => continuous_facts(recipe, proved),
    };
    let verify = facts.verify_cpu_seconds_about + if proved { made_seconds(recipe) } else { 0.0 };
    let memory = need(recipe, side, proved).bytes;
    EstimateReport { memory_bytes_about: memory, verify_cpu_seconds_about: verify, ..facts }.on_machine(1.0, 1)
}

fn faceted_facts(recipe: &Recipe, proved: bool) -> EstimateReport {
    let [columns, rows] = recipe.facets();
    let facets = columns * rows;
    let (pitch, rim) = (recipe.pitch(), 2.0 * recipe.plate.border);
    // Measured on drawings and photographs: 8.4 to 11 triangles a facet with its walls. The rest is sides and base.
    let triangles = 19 * facets / 2 + 8 * (columns + rows);
    let proof = match recipe.is_near() {
        true => room_proof_seconds(recipe, triangles),
        false => PROOF.0 + ray_seconds(recipe, PROOF.1),
    };
    EstimateReport {
        dry_run: true,
        plate_mm: recipe.plate.size.map(|side| side + rim),
        pitch_mm: pitch.to_array(),
        parts: Parts::Facets { facets },
        stl_triangles_about: triangles,
        stl_bytes_about: stl_bytes(triangles),
        design_cpu_seconds_about: design_seconds(recipe),
        verify_cpu_seconds_about: if proved { proof + milled_seconds(recipe) } else { 0.0 },
        comparison_cpu_seconds_about: 0.0,
        files_cpu_seconds_about: FILES.0 + 2e-6 * facets as f64,
        wall_seconds_about: 0.0,
        threads: 1,
        machine_speed: 1.0,
        memory_bytes_about: 0,
        least_stray_share: None,
    }
}

/// The share of a sheet's triangles that it needs without a cutter: a third to a half on the pictures of the examples. On a
/// wall nearby an eye sees finer, and a portrait of 2.9 million triangles needs 1.5 million, cut or not.
const UNCUT_SHARE: f64 = 0.4;
const ON_WALL_SHARE: f64 = 0.53;

/// CPU seconds a triangle of trying how many are enough on a wall: some trials of their light, and the cutter led over three of
/// them. 2.9 million took 17 s for a ball of 0.5 mm.
const TRIED_ON_WALL: (f64, f64) = (3e-6, 6e-6);

fn continuous_facts(recipe: &Recipe, proved: bool) -> EstimateReport {
    let sculpting = recipe.sculpting();
    let ([columns, rows], rim) = (sculpting.cells.map(|cells| cells * sculpting.grid), 2.0 * recipe.plate.border);
    let triangles = 2 * columns * rows + 8 * (columns + rows);
    let written = triangles.min(match recipe.file_size() {
        FileSize::Whole => triangles,
        FileSize::AtMost(most) => most,
        FileSize::AsLightAllows(first) if recipe.is_near() => first.max((ON_WALL_SHARE * triangles as f64) as usize),
        // Sheets for a cutter have kept to it on every picture measured.
        FileSize::AsLightAllows(first) if sculpting.settings.cutter.is_some() => first,
        FileSize::AsLightAllows(first) => first.max((UNCUT_SHARE * triangles as f64) as usize),
    });
    let step = sculpting.cell / sculpting.grid as f64;
    let (bare, cut) = TRIED_ON_WALL;
    let tried = if sculpting.settings.cutter.is_some() { cut } else { bare };
    EstimateReport {
        dry_run: true,
        plate_mm: recipe.plate.size.map(|side| side + rim),
        pitch_mm: step.to_array(),
        parts: Parts::Sheet { grid: sculpting.grid, cells: sculpting.cells },
        stl_triangles_about: written,
        stl_bytes_about: stl_bytes(written),
        design_cpu_seconds_about: sculpting_seconds(&sculpting)
            + room_seconds(recipe, &sculpting)
            + if recipe.is_near() && written < triangles { tried * triangles as f64 } else { 0.0 },
        verify_cpu_seconds_about: if proved { sheet_proof_seconds(recipe, triangles) } else { 0.0 },
        comparison_cpu_seconds_about: if proved { comparison_seconds(recipe) } else { 0.0 },
        files_cpu_seconds_about: FILES.1 + FILES.2 * triangles as f64,
        wall_seconds_about: 0.0,
        threads: 1,
        machine_speed: 1.0,
        memory_bytes_about: 0,
        least_stray_share: None,
    }
}

/// Leading the cutter over a cell.
fn tool_seconds(sculpting: &SheetSpec) -> f64 {
    let SheetSpec { cell, grid, settings, .. } = *sculpting;
    settings.cutter.map_or(0.0, |cutter| {
        let (stepping, fine) = (Tool::new(cell, cutter), Tool::without_steps(cell, grid, cutter));
        let filled = TOOL_PLACE.1 + TOOL_PLACE.2 / (grid * grid) as f64;
        TOOL_PLACE.0 * stepping.all_places() + filled * fine.all_places()
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

/// The descent over the whole plate in its room, if there is one and it is likely to need that.
fn room_seconds(recipe: &Recipe, spec: &SheetSpec) -> f64 {
    if likely_method(recipe) != Some(NearMethod::Exact) {
        return 0.0;
    }
    let (squares, cutter) = (spec.cells.map(|cells| cells * spec.grid), spec.settings.cutter);
    let (evaluations, grid) = evaluations(squares, spec.cell / spec.grid as f64, cutter);
    match cutter {
        None => ROOM.0 + ROOM.1 * evaluations,
        Some(cutter) => {
            let finer = Tool::without_steps(grid.lattice.cell(), grid.lattice.n, cutter);
            ROOM.0 + ROOM.2 * evaluations + ROOM_PLACE * finer.all_places()
        }
    }
}

/// Rays of a proof, each of which takes `smooth` CPU seconds on metal without a lobe.
fn ray_seconds(recipe: &Recipe, smooth: f64) -> f64 {
    let ray = if recipe.metal().is_smooth() { smooth } else { PROOF.2 };
    ray * recipe.verify.rays as f64
}

/// The proof of a sheet of so many triangles, as designed and as milled.
fn sheet_proof_seconds(recipe: &Recipe, triangles: usize) -> f64 {
    if recipe.is_near() {
        return room_proof_seconds(recipe, triangles) + milled_seconds(recipe);
    }
    let (scoring, ray, lobe, triangle) = SHEET_PROOF;
    let ray = if recipe.metal().is_smooth() { ray } else { lobe };
    let light = scoring + ray * recipe.verify.rays as f64;
    let [width, height] = recipe.plate.size;
    let milled = |cutter| light + MILLED_PLACE * places(width * height, cutter);
    light + triangle * triangles as f64 + recipe.design.sheet.cutter.map_or(0.0, milled)
}

/// The facets that a sheet is compared with, should it misplace so much light that it is.
fn comparison_seconds(recipe: &Recipe) -> f64 {
    if recipe.is_near() || recipe.design.sheet.polish.is_some() {
        return 0.0;
    }
    let facets = recipe.clone().only_for(SurfaceKind::Facets);
    design_seconds(&facets) + BESIDE + ray_seconds(recipe, PROOF.1) + milled_seconds(recipe)
}

fn room_proof_seconds(recipe: &Recipe, triangles: usize) -> f64 {
    ROOM_PROOF.0 + ray_seconds(recipe, ROOM_PROOF.1) + ROOM_PROOF.2 * triangles as f64
}

/// The proof of the plate as milled; 0 without a cutter.
fn milled_seconds(recipe: &Recipe) -> f64 {
    let [width, height] = recipe.plate.size;
    recipe.design.sheet.cutter.map_or(0.0, |cutter| MILLED.0 + MILLED.1 * places(width * height, cutter))
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
mod tests;
