//! What a job takes of memory at the most, from its sizes alone.
//!
//! Every figure is bytes at once in one stage, for each of what the stage's arrays have as many entries as. They were
//! measured as peaks of resident memory over sizes that differ at least fourfold, and rounded up.

use glam::DVec2;

use crate::memory::Need;
use crate::recipe::{Recipe, SurfaceKind};
use crate::sculpt::milled_facets::Places;
use crate::sculpt::tool::Tool;
use crate::verify::tally;

/// The program itself, its threads and small things.
const GROUND: f64 = 7e7;

/// A pixel of the picture: its light, and the target that the proof is scored against.
const PICTURE_PIXEL: f64 = 24.0;

/// A pixel of the picture as designs see it: flux, footprint, slopes in pieces.
const WANTED_PIXEL: f64 = 150.0;

/// The same where lamp or metal blur: transforms on a grid with room for the blur.
const SHARPENED_PIXEL: f64 = 300.0;

/// A node of the cell that is optimised: twenty grids of the descent's memory, and who touches whom in the closing.
const SCULPTED_NODE: f64 = 480.0;

/// The square on which a plate for a lamp or a wall nearby is shaped, for each of the plate; not measured, but all of its
/// margin at the largest.
const NEARBY: f64 = 1.5;

/// A place of the tool: heights before and after, their slopes, the light of both.
const TOOL_PLACE: f64 = 60.0;

/// A place of the tool without steps: heights before, between and after.
const FINE_PLACE: f64 = 20.0;

/// A square of a sheet's plate: two triangles, planes for pictures; and where light is sent over it.
const SQUARE: (f64, f64) = (75.0, 60.0);

/// A place of the tool on the cell as milled, as light is sent over it.
const MILLED_PLACE: f64 = 120.0;

/// A facet, with its share of the solid.
const FACET: f64 = 350.0;

/// A place of the tool over a plate of facets.
const FACET_PLACE: f64 = 48.0;

/// What the job of `recipe` takes at the most, for a picture of `side` pixels a side; `proved` if light is sent over it.
pub fn need(recipe: &Recipe, side: usize, proved: bool) -> Need {
    let pixels = (side as f64).powi(2);
    let seen = pixels.min(1024.0 * 1024.0);
    let wanted = seen * if recipe.blur(&recipe.setup()).is_some() { SHARPENED_PIXEL } else { WANTED_PIXEL };
    let ground = GROUND + PICTURE_PIXEL * pixels + wanted + if proved { tally::bytes(256 * 256) } else { 0.0 };
    let stages = match recipe.surface() {
        SurfaceKind::Facets => faceted(recipe, proved),
        SurfaceKind::Sheet => sheet(recipe, proved),
    };
    let made = Some(recipe).filter(|_| proved).and_then(|recipe| recipe.machining().ok().flatten()).map(|machining| {
        let surface = machining.bytes(DVec2::from(recipe.plate.size)) + plate_bytes(recipe);
        Need::new(surface, "the surface as made", "take a wider --stepover or --polish, or a smaller --size")
    });
    let whole = stages.into_iter().chain(made).reduce(Need::or);
    let more = |need: Need| Need { bytes: (ground + need.bytes as f64) as u64, ..need };
    whole.map_or(Need::new(ground, "the picture", "take a smaller one"), more)
}

fn sheet(recipe: &Recipe, proved: bool) -> Vec<Need> {
    let sculpting = recipe.sculpting();
    let nodes = (sculpting.grid as f64).powi(2);
    let squares = nodes * sculpting.cells.iter().map(|n| *n as f64).product::<f64>();
    let smaller = "lower --grid or --max-triangles, or leave them out";
    let mut stages = vec![Need::new(SQUARE.0 * squares, "the plate's solid", smaller)];
    if proved {
        stages.push(Need::new((SQUARE.0 + SQUARE.1) * squares, "the proof of the plate", smaller));
    }
    // Beside a lamp or a wall nearby all cells are shaped at once, on a somewhat larger square.
    let at_once = if recipe.is_near() { NEARBY * squares / nodes } else { 1.0 };
    stages.push(Need::new(SCULPTED_NODE * nodes * at_once, "shaping the sheet", smaller));
    let Some(cutter) = sculpting.settings.cutter else { return stages };
    let finer = "take a larger cutter in --for-cutter, more --cells or a smaller --size";
    let places = at_once * Tool::new(sculpting.cell, cutter).all_places();
    let fine = at_once * Tool::without_steps(sculpting.cell, sculpting.grid, cutter).all_places();
    let kept = SCULPTED_NODE * nodes * at_once;
    stages.push(Need::new(kept + TOOL_PLACE * places, "the cutter's way over a cell", finer));
    stages.push(Need::new(FINE_PLACE * fine, "the cutter's way over a cell", finer));
    if proved {
        let milled = SQUARE.0 * squares + MILLED_PLACE * places;
        stages.push(Need::new(milled, "the proof of the plate as milled", finer));
        let beside = faceted(&recipe.clone().only_for(SurfaceKind::Facets), true);
        stages.extend(beside.into_iter().map(|need| Need { bytes: need.bytes + (SQUARE.0 * squares) as u64, ..need }));
    }
    stages
}

/// The plate itself, as it lies there while it is made.
fn plate_bytes(recipe: &Recipe) -> f64 {
    let product = |sides: [usize; 2]| sides.iter().map(|n| *n as f64).product::<f64>();
    match recipe.surface() {
        SurfaceKind::Facets => FACET * product(recipe.facets()),
        SurfaceKind::Sheet => {
            let spec = recipe.sculpting();
            SQUARE.0 * product(spec.cells) * (spec.grid as f64).powi(2)
        }
    }
}

fn faceted(recipe: &Recipe, proved: bool) -> Vec<Need> {
    let [columns, rows] = recipe.facets();
    let facets = columns as f64 * rows as f64;
    let mut stages = vec![Need::new(FACET * facets, "a plate of so many facets", "take fewer --facets")];
    if let Some(cutter) = recipe.design.sheet.cutter.filter(|_| proved) {
        let places = Places::new(recipe.plate.size, [columns, rows], cutter).all();
        let finer = "take another cutter in --for-cutter, or fewer --facets";
        stages.push(Need::new(FACET * facets + FACET_PLACE * places, "the cutter's way over the facets", finer));
    }
    stages
}
