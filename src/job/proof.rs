//! The proof of a plate: light sent over its exact relief, and over what its cutter leaves.

use super::cut_sheet::CutSheet;
use super::design::{Design, DesignError};
use super::findings::{MilledProof, Proof, RimProof, SheetProof};
use super::on_wall::prove_in_room;
use crate::export::sheet::sheet_solid;
use crate::highlight::scored_target;
use crate::progress::{Cancelled, Progress, Stage};
use crate::raster::Raster;
use crate::recipe::{BorderFinish, Cutter, Recipe};
use crate::relief::faceted::FacetedRelief;
use crate::relief::mesh::Mesh;
use crate::relief::periodic::PeriodicRelief;
use crate::relief::recognise::Recognised;
use crate::relief::repeats::{repeated, within_rim};
use crate::sculpt::detail::{diffracted, smallest_detail};
use crate::sculpt::milled_facets::milled_facets;
use crate::setup::Setup;
use crate::trace::Surface;
use crate::trace::grid::GridSurface;
use crate::trace::traced_plate::{Task, TracedPlate};
use crate::verify::measure::Mirrored;
use crate::verify::rim::{OverRim, RimLight};
use crate::verify::tally::{MeasureError, Measurement};
use crate::verify::verdict::Verdict;
use crate::verify::windows::{Wanted, change, likeness};

/// Lines along a side of the milled plate that light from any side is sent over, at the most: 4 million nodes of 50 bytes.
const MOST_LINES: usize = 2000;

/// Sends light over the design's exact relief, and over it as its cutter and polish leave it, and scores what comes back
/// against the picture.
pub fn prove(recipe: &Recipe, light: &Raster, design: &Design, progress: &Progress) -> Result<Proof, DesignError> {
    if let Some(scene) = recipe.scene().ok().flatten() {
        return prove_in_room(recipe, &scene, light, design, progress);
    }
    progress.stage(Stage::Tracing);
    let setup = &design.distribution.setup;
    let measuring = recipe.measuring();
    let target = scored_target(light, recipe.highlight.quantity, setup, measuring.resolution);
    let metal = recipe.metal();
    let mirrored = Mirrored { setup, metal: &metal, measuring: &measuring, progress };
    let task = PlateAndRim { mirrored, width: recipe.plate.border };
    let (measurement, rim) = match &design.sheet {
        None => task.on(&GridSurface::new(&design.relief, progress)?)?,
        // The triangles themselves, as they stand in the file.
        Some(_) => TracedPlate::new(&design.mesh, recipe.plate.border, progress)?.run(task)?,
    };
    let rim = rim.map(|light| RimProof {
        counts: recipe.border_finish() != BorderFinish::Matt,
        ..RimProof::dull(light, &measurement)
    });
    let judged = |measurement: Measurement| {
        progress.stage(Stage::Scoring);
        let measurement = RimProof::over(rim.as_ref(), measurement);
        let verdict = Verdict::new(&measurement, &target, setup.view(), progress)?;
        Ok::<_, DesignError>((measurement, verdict))
    };
    let (measurement, verdict) = judged(measurement)?;
    let made = design.sheet.as_ref().map(|sheet| CutSheet::of(recipe, &sheet.relief, progress)).transpose()?;
    let sheet = match &made {
        Some(made) => made.looked_at(recipe, &target, setup, progress)?,
        None => None,
    };
    let milled = match send_over_milled(recipe, design, made.as_ref(), mirrored)? {
        None => None,
        Some((measurement, left)) => {
            let (measurement, verdict) = judged(measurement)?;
            Some(MilledProof { left, measurement, verdict })
        }
    };
    Ok(Proof { target, measurement, verdict, sheet, milled, made: None, rim, wall: None })
}

/// Light over the optical area, and over the rim around it if it has a width.
struct PlateAndRim<'a> {
    mirrored: Mirrored<'a>,
    width: f64,
}

impl Task for PlateAndRim<'_> {
    type Output = Result<(Measurement, Option<RimLight>), MeasureError>;

    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let Self { mirrored, width } = self;
        let measurement = mirrored.on(surface)?;
        let rim = if width > 0.0 { Some(OverRim { mirrored, width, scene: None }.on(surface)?) } else { None };
        Ok((measurement, rim))
    }
}

impl CutSheet {
    fn looked_at(
        &self,
        recipe: &Recipe,
        target: &Raster,
        setup: &Setup,
        progress: &Progress,
    ) -> Result<Option<SheetProof>, Cancelled> {
        // Windows lie anywhere on a plate of many cells.
        let plate = PeriodicRelief { cells: [2, 2], ..self.relief.clone() };
        let changed = change(&self.relief, setup, progress)?;
        let detail = smallest_detail(&self.relief, &changed)?;
        let diffracted = diffracted(&self.relief, 1.0, &changed)?;
        let blur = recipe.blur(setup);
        let wanted = Wanted { target, blur: blur.as_ref(), seed: recipe.design.seed };
        let windows = likeness(&plate, setup, wanted, progress)?;
        Ok(windows.map(|windows| SheetProof { windows, detail, diffracted }))
    }
}

/// Light sent over the plate as its cutter and polish leave it, and the most that the cutter leaves, mm; `None` without them.
fn send_over_milled(
    recipe: &Recipe,
    design: &Design,
    made: Option<&CutSheet>,
    mirrored: Mirrored,
) -> Result<Option<(Measurement, f64)>, DesignError> {
    let cutter = recipe.design.sheet.cutter;
    if cutter.is_none() && recipe.design.sheet.polish.is_none() {
        return Ok(None);
    }
    mirrored.progress.stage(Stage::Milling);
    match made {
        Some(made) => {
            let solid = sheet_solid(&made.relief, recipe.plate.thickness, 0.0, mirrored.progress)?;
            let surface = TracedPlate::new(&solid, 0.0, mirrored.progress)?;
            Ok(Some((surface.run(mirrored)?, made.left)))
        }
        None => Ok(cutter.map(|cutter| send_over_milled_facets(&design.relief, cutter, mirrored)).transpose()?),
    }
}

/// Light sent over the plate of `recipe` that stands in `mesh`, as its cutter and polish leave it, and the most that the
/// cutter leaves, mm; `None` without them, or if the mesh is no such plate. The optical area is the xy bounding box less
/// `margin` mm on each side.
///
/// # Errors
/// The milled plate cannot be closed or traced.
pub fn send_over_milled_mesh(
    recipe: &Recipe,
    mesh: &Mesh,
    margin: f64,
    mirrored: Mirrored,
) -> Result<Option<(Measurement, f64)>, DesignError> {
    let cutter = recipe.design.sheet.cutter;
    if cutter.is_none() && recipe.design.sheet.polish.is_none() {
        return Ok(None);
    }
    let progress = mirrored.progress;
    progress.stage(Stage::Milling);
    match within_rim(mesh, margin, progress)? {
        Some((Recognised::Heights(grid), (low, high))) => {
            let Some(relief) = repeated(&grid, low, high, recipe.cells()) else { return Ok(None) };
            let made = CutSheet::of(recipe, &relief, progress)?;
            let solid = sheet_solid(&made.relief, recipe.plate.thickness, 0.0, progress)?;
            let surface = TracedPlate::new(&solid, 0.0, progress)?;
            Ok(Some((surface.run(mirrored)?, made.left)))
        }
        Some((Recognised::Facets(relief), _)) => {
            Ok(cutter.map(|cutter| send_over_milled_facets(&relief, cutter, mirrored)).transpose()?)
        }
        None => Ok(None),
    }
}

/// The plate of `recipe` that stands in `mesh`, as its cutter and polish leave it, for light from any side; `None` without
/// them, or if the mesh is no such plate. The optical area is the xy bounding box less `margin` mm on each side.
///
/// Of a sheet as many cells side by side as 2000 lines of nodes hold: with light far aside, what a hill shades lies beyond
/// its cell.
///
/// # Errors
/// The work is cancelled.
pub fn milled_plate(
    recipe: &Recipe,
    mesh: &Mesh,
    margin: f64,
    progress: &Progress,
) -> Result<Option<TracedPlate>, DesignError> {
    let cutter = recipe.design.sheet.cutter;
    if cutter.is_none() && recipe.design.sheet.polish.is_none() {
        return Ok(None);
    }
    progress.stage(Stage::Milling);
    let grid = match (within_rim(mesh, margin, progress)?, cutter) {
        (Some((Recognised::Heights(grid), (low, high))), _) => {
            let Some(relief) = repeated(&grid, low, high, recipe.cells()) else { return Ok(None) };
            let made = CutSheet::of(recipe, &relief, progress)?.relief;
            let cells = relief.cells.map(|cells| cells.min(MOST_LINES / made.nodes).max(1));
            PeriodicRelief { cells, ..made }.height_grid(progress)?
        }
        (Some((Recognised::Facets(relief), _)), Some(cutter)) => milled_facets(&relief, cutter, progress)?.surface,
        _ => return Ok(None),
    };
    Ok(Some(TracedPlate::Heights(GridSurface::continuous(&grid, progress)?)))
}

/// Light sent over facets as their cutter leaves them, and the most that it leaves, mm.
pub(super) fn send_over_milled_facets(
    relief: &FacetedRelief,
    cutter: Cutter,
    mirrored: Mirrored,
) -> Result<(Measurement, f64), MeasureError> {
    let milled = milled_facets(relief, cutter, mirrored.progress)?;
    Ok((mirrored.on(&GridSurface::continuous(&milled.surface, mirrored.progress)?)?, milled.most_left))
}
