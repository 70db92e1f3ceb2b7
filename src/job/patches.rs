//! The whole job of a plate of patches: design, what its cutter leaves, and a camera at the viewer's place for the proof.

use glam::{DVec2, DVec3};

use super::clock::Clock;
use crate::export::sheet::{SheetError, sheet_solid};
use crate::lamp::Lamp;
use crate::memory::{MemoryLimit, Need};
use crate::patches::dimple::{Dimple, Walls};
use crate::patches::maps::{Maps, MapsError};
use crate::patches::milled::milled;
use crate::patches::plate::Patches;
use crate::patches::portrait::{Portrait, PortraitError};
use crate::patches::viewer::Viewer;
use crate::picture::PictureFit;
use crate::progress::{Cancelled, Progress, Stage};
use crate::raster::Raster;
use crate::recipe::{Recipe, RecipeError};
use crate::relief::mesh::Mesh;
use crate::relief::open::OpenRelief;
use crate::trace::Surface;
use crate::trace::grid::GridSurface;
use crate::trace::traced_plate::{Task, TracedPlate, TracedPlateError};
use crate::verify::experiment::Experiment;
use crate::verify::patch_view::{PatchScores, PatchView, field_of_view, resolution};
use crate::verify::render::{RenderError, RenderedView, ViewSettings, render};

/// Paths for each of the rays that are asked for: the plate takes a third of the camera's picture.
const PATHS_A_RAY: f64 = 3.0;

/// Paths a pixel: with fewer than four no error can be told.
const PATHS: [f64; 2] = [4.0, 4096.0];

/// By how much the sides of a picture and of its plate may differ in proportion.
const ASPECT: f64 = 0.01;

/// Bytes for each node of the plate: heights, solid and tracer, and the same of four times as many places of a cutter.
const BYTES_A_NODE: f64 = 600.0;

/// What the patches are to show.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// A picture: light from 0 to 1 for each patch.
    Portrait(Raster),
    /// Lobes by maps.
    Maps(Box<Maps>),
}

/// A plate of patches and what is known of it.
#[derive(Clone, Debug)]
pub struct PatchProduct {
    /// Its recipe.
    pub recipe: Recipe,
    /// How it is divided.
    pub patches: Patches,
    /// What is around the bowls.
    pub walls: Walls,
    /// Row by row from the top left.
    pub dimples: Vec<Dimple>,
    /// What the viewer shall see, 1/sr for a lamp of irradiance 1 across its beam, row 0 on top.
    pub wanted: Raster,
    /// Radiance of the darkest and the brightest tone that all patches reach, of a portrait.
    pub range: Option<[f64; 2]>,
    /// Least and largest share of a patch that the largest bowl takes.
    pub most_share: [f64; 2],
    /// The relief.
    pub relief: OpenRelief,
    /// The closed solid.
    pub mesh: Mesh,
    /// A camera's view of it, if it was to be proved.
    pub proof: Option<PatchProof>,
    /// CPU seconds by stage, in order.
    pub seconds: Vec<(&'static str, f64)>,
}

/// What a camera at the viewer's place sees.
#[derive(Clone, Debug)]
pub struct PatchProof {
    /// Where it stands.
    pub settings: ViewSettings,
    /// Of the plate as written.
    pub written: SeenPatches,
    /// Of the plate as its cutter leaves it, if it has one, and the most that the cutter leaves, mm.
    pub cut: Option<(SeenPatches, f64)>,
}

/// A camera's picture of a plate, averaged over patches and scored.
#[derive(Clone, Debug)]
pub struct SeenPatches {
    /// The picture.
    pub view: RenderedView,
    /// Patch by patch.
    pub seen: PatchView,
    /// Beside what is wanted.
    pub scores: PatchScores,
}

impl PatchProof {
    /// The view that counts: of the plate as cut, if it has a cutter.
    pub fn decisive(&self) -> &SeenPatches {
        self.cut.as_ref().map_or(&self.written, |(cut, _)| cut)
    }
}

/// Designs the plate of `recipe` for what is `asked`, and proves it if it is to be `proved`.
///
/// # Errors
/// The recipe or the memory forbids it, no such patches can be made, or the work was cancelled.
pub fn design_patches(
    recipe: &Recipe,
    asked: &Asked,
    proved: bool,
    limit: MemoryLimit,
    progress: &Progress,
) -> Result<PatchProduct, PatchError> {
    recipe.check()?;
    let recipe = recipe.clone().with_patch_metal();
    let (patches, walls) = (recipe.patches(), recipe.patch_walls());
    limit.admit(need(&patches))?;
    let mut clock = Clock::start();
    progress.stage(Stage::Sculpting);
    let viewer = viewer(&recipe);
    let (dimples, wanted, range, most_share) = match asked {
        Asked::Portrait(tones) => {
            let made = Portrait::new(&patches, walls, recipe.patch_lobes()[0], (tones, &viewer), progress)?;
            (made.dimples, made.wanted, Some(made.range), made.most_share)
        }
        Asked::Maps(maps) => {
            let made =
                maps.plate(&patches, walls, recipe.patch_lobes(), (&viewer, recipe.normal_spread()), progress)?;
            (made.dimples, made.wanted, None, made.most_share)
        }
    };
    let relief = patches.relief(&dimples, progress)?;
    recipe.reaches(relief.depth())?;
    clock.lap(Stage::Sculpting);
    progress.stage(Stage::Solid);
    let mesh = sheet_solid(&relief, recipe.plate.thickness, recipe.plate.border, progress)?;
    clock.lap(Stage::Solid);
    let mut product = PatchProduct {
        recipe,
        patches,
        walls,
        dimples,
        wanted,
        range,
        most_share,
        relief,
        mesh,
        proof: None,
        seconds: Vec::new(),
    };
    if proved {
        // The triangles themselves, as they stand in the file.
        let plate = TracedPlate::new(&product.mesh, product.recipe.plate.border, progress)?;
        let standing = Standing { plate: &plate, level: mean_height(&product.relief), relief: Some(&product.relief) };
        product.proof = Some(prove(&product, standing, &mut clock, progress)?);
    }
    product.seconds = clock.into_laps();
    Ok(product)
}

/// The memory that a plate of so many patches takes.
pub fn need(patches: &Patches) -> Need {
    let bytes = BYTES_A_NODE * (patches.len() * patches.nodes * patches.nodes) as f64;
    Need::new(bytes, "designing and proving the patches", "take fewer --patches or a smaller --grid")
}

/// Paths for each pixel of a camera's picture of `side` pixels a side.
pub(super) fn paths(recipe: &Recipe, side: usize) -> f64 {
    (PATHS_A_RAY * recipe.verify.rays as f64 / (side * side) as f64).clamp(PATHS[0], PATHS[1])
}

fn viewer(recipe: &Recipe) -> Viewer {
    let middle = 0.5 * DVec2::from(recipe.plate.size);
    let eye = middle.extend(0.0) + recipe.viewer_distance() * recipe.viewer().direction();
    let setup = recipe.setup();
    Viewer::new(recipe.metal(), recipe.normal_spread(), setup.light(), setup.light_radius(), eye)
}

/// A camera at the viewer's place.
struct Camera<'a> {
    recipe: &'a Recipe,
    settings: ViewSettings,
    progress: &'a Progress<'a>,
}

impl Task for Camera<'_> {
    type Output = Result<(RenderedView, DVec3), RenderError>;

    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let setup = self.recipe.setup();
        let lamp: Lamp = setup.lamp().into();
        let experiment = Experiment { surface, setup: &setup, material: self.recipe.metal(), lamp };
        Ok((render(&experiment, &self.settings, self.progress)?, surface.middle()))
    }
}

/// A plate of patches as it stands, the lower left corner of its optical area at x = y = 0.
pub(super) struct Standing<'a> {
    /// Its triangles.
    pub plate: &'a TracedPlate,
    /// Their mean height, mm, at which patches are told apart.
    pub level: f64,
    /// The heights of the patches' own nodes above their rims, for a cutter; `None` if it has no such nodes.
    pub relief: Option<&'a OpenRelief>,
}

/// Mean height of a relief, mm.
pub(super) fn mean_height(relief: &OpenRelief) -> f64 {
    relief.heights.iter().map(|z| f64::from(*z)).sum::<f64>() / relief.heights.len() as f64
}

/// What the viewer of the product's recipe sees of the plate that stands there, beside what is wanted.
pub(super) fn prove(
    product: &PatchProduct,
    standing: Standing,
    clock: &mut Clock,
    progress: &Progress,
) -> Result<PatchProof, PatchError> {
    let PatchProduct { recipe, patches, .. } = product;
    let [theta, phi] = recipe.viewer().0;
    let (distance, border) = (recipe.viewer_distance(), recipe.plate.border);
    let side = resolution(patches);
    let settings = ViewSettings {
        theta,
        phi,
        distance,
        field_of_view: field_of_view((patches.size + 2.0 * border).length(), distance),
        size: [side; 2],
        rays: paths(recipe, side) as u32,
        seed: recipe.design.seed,
        ..ViewSettings::default()
    };
    let camera = || Camera { recipe, settings, progress };
    let judged = |(view, middle): (RenderedView, DVec3), level: f64| {
        let seen = PatchView::new(&view, &settings, patches, middle, level);
        let scores = seen.scores(&product.wanted);
        SeenPatches { view, seen, scores }
    };
    progress.stage(Stage::View);
    let written = judged(standing.plate.run(camera())?, standing.level);
    clock.lap(Stage::View);
    let (Some(cutter), Some(relief)) = (recipe.design.sheet.cutter, standing.relief) else {
        return Ok(PatchProof { settings, written, cut: None });
    };
    progress.stage(Stage::Milling);
    let left = milled(patches, relief, cutter, progress)?;
    let surface = GridSurface::continuous(&left.relief.height_grid(progress)?, progress)?;
    let cut = judged(camera().on(&surface)?, mean_height(&left.relief));
    clock.lap(Stage::Milling);
    Ok(PatchProof { settings, written, cut: Some((cut, left.most_left)) })
}

/// Tones from 0 to 1 of a portrait, from the light of a picture on a square, which had so many columns and rows before it was
/// fitted to that.
///
/// # Errors
/// A picture whose proportions are not the plate's.
pub fn tones(recipe: &Recipe, light: &Raster, (columns, rows): (usize, usize)) -> Result<Raster, PatchError> {
    let [width, height] = recipe.plate.size;
    let [across, up] = recipe.patches().count;
    let square = (width / height - 1.0).abs() <= ASPECT;
    let part = if square {
        light.clone()
    } else {
        let same = (columns as f64 / rows as f64 / (width / height) - 1.0).abs() <= ASPECT;
        let plain = recipe.highlight.rotate == 0.0 && recipe.highlight.fit == PictureFit::Pad;
        if !(same && plain) {
            return Err(PatchError::Aspect { picture: "the picture".into(), columns, rows, width, height });
        }
        // Where a picture was laid on a square, the right or the lower bar is the wider one.
        let (left, top) = (light.width.saturating_sub(columns) / 2, light.height.saturating_sub(rows) / 2);
        let (w, h) = (columns.min(light.width), rows.min(light.height));
        Raster::from_fn(w, h, |x, y| light.at(left + x, top + y))
    };
    let small = part.resampled(across, up);
    let white = small.max();
    Ok(if white > 0.0 { small.scaled(1.0 / white) } else { small })
}

/// A map with one value for each patch.
///
/// # Errors
/// A map, by its name `picture`, whose proportions are not the plate's.
pub fn on_patches(recipe: &Recipe, map: &Raster, picture: &str) -> Result<Raster, PatchError> {
    let [width, height] = recipe.plate.size;
    let (columns, rows) = (map.width, map.height);
    if (columns as f64 / rows as f64 / (width / height) - 1.0).abs() > ASPECT {
        return Err(PatchError::Aspect { picture: picture.into(), columns, rows, width, height });
    }
    let [across, up] = recipe.patches().count;
    // Means of the map's pixels, not sums.
    Ok(map.resampled(across, up).scaled((across * up) as f64 / (columns * rows) as f64))
}

/// Why there is no plate of patches.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PatchError {
    /// The recipe makes no sense.
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    /// A picture or map of other proportions.
    #[error(
        "{picture} has {columns} × {rows} pixels, and the plate is {width} × {height} mm: choose --size in the same proportion, or crop it"
    )]
    Aspect {
        /// Its name.
        picture: String,
        /// Its columns.
        columns: usize,
        /// Its rows.
        rows: usize,
        /// Of the plate, mm.
        width: f64,
        /// Of the plate, mm.
        height: f64,
    },
    /// A plate in a file that is not of the recipe's size.
    #[error(
        "the plate is {:.3} × {:.3} mm without its rim, and that of its recipe {} × {} mm: check --unit and --margin", found[0], found[1], wanted[0], wanted[1]
    )]
    Size {
        /// Of the plate in the file, mm.
        found: [f64; 2],
        /// Of the recipe's, mm.
        wanted: [f64; 2],
    },
    /// No such picture can be shown.
    #[error(transparent)]
    Portrait(PortraitError),
    /// No such maps can be made.
    #[error(transparent)]
    Maps(MapsError),
    /// The solid cannot be closed.
    #[error(transparent)]
    Solid(#[from] SheetError),
    /// The plate cannot be traced.
    #[error(transparent)]
    Traced(#[from] TracedPlateError),
    /// The plate cannot be looked at.
    #[error(transparent)]
    View(RenderError),
    /// It would take too much memory.
    #[error(transparent)]
    Memory(#[from] crate::memory::TooMuchMemory),
    /// Stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<PortraitError> for PatchError {
    fn from(error: PortraitError) -> Self {
        match error {
            PortraitError::Cancelled(cancelled) => cancelled.into(),
            error => Self::Portrait(error),
        }
    }
}

impl From<MapsError> for PatchError {
    fn from(error: MapsError) -> Self {
        match error {
            MapsError::Cancelled(cancelled) => cancelled.into(),
            error => Self::Maps(error),
        }
    }
}

impl From<RenderError> for PatchError {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Cancelled(cancelled) => cancelled.into(),
            error => Self::View(error),
        }
    }
}
