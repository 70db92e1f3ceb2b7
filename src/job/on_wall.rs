//! The proof of a plate in its room: light thrown on the wall of its scene, as designed and as its cutter leaves it.

use super::cut_sheet::cut_plate;
use super::design::{Design, DesignError};
use super::findings::{MilledProof, Proof, RimProof, WallDiffraction, WallLight, WallProof};
use super::scene_facts::{in_words, mirror_miss, sag, stopped_by_lamp};
use crate::brdf::material::Material;
use crate::export::sheet::sheet_solid;
use crate::highlight::{Quantity, scored_target};
use crate::progress::{Cancelled, Progress, Stage};
use crate::raster::Raster;
use crate::recipe::{BorderFinish, Cutter, Recipe};
use crate::relief::faceted::FacetedRelief;
use crate::relief::mesh::Mesh;
use crate::relief::open::{NodeGrid, OpenRelief};
use crate::relief::recognise::Recognised;
use crate::relief::repeats::{unrepeated, within_rim};
use crate::report::on_wall::{CellsOnWall, DiffractionOnWall, OnWallFacts, UnderSun};
use crate::scene::Scene;
use crate::sculpt::detail::WAVELENGTH;
use crate::sculpt::milled_facets::milled_facets;
use crate::sculpt::room::objective::polished;
use crate::sculpt::room::plate_grid::PlateGrid;
use crate::trace::Surface;
use crate::trace::grid::GridSurface;
use crate::trace::traced_plate::{Task, TracedPlate};
use crate::verify::elsewhere::{Elsewhere, ThrownElsewhere, change};
use crate::verify::measure::Mirrored;
use crate::verify::rim::{OverRim, RimLight};
use crate::verify::tally::Measurement;
use crate::verify::thrown::{ACROSS, Throwing, within_picture};
use crate::verify::verdict::Verdict;
use crate::verify::wall_verdict::{WallVerdict, eye_blur, likeness_once_spread};

impl WallProof {
    /// What a report says of it.
    pub fn facts(&self, recipe: &Recipe) -> OnWallFacts {
        let Self { scene, elsewhere, .. } = self;
        let elsewhere = elsewhere.as_ref();
        let [lamp, wall] = in_words(scene);
        let cells = |windows: &[f64]| CellsOnWall {
            mean: windows.iter().sum::<f64>() / windows.len() as f64,
            largest: windows.iter().copied().fold(0.0, f64::max),
        };
        OnWallFacts {
            lamp,
            wall,
            lamp_distance_mm: Some(scene.lamp_distance()).filter(|distance| distance.is_finite()),
            wall_distance_mm: scene.wall_distance(),
            picture_mm: scene.wall().map_or(f64::NAN, |wall| 2.0 * wall.half),
            focus_mm: scene.focal_length(),
            sag_mm: sag(scene, recipe.plate.size.into()),
            mirror_miss_mm: mirror_miss(scene),
            eye_distance_mm: self.eye_distance,
            eye_blur_mm: eye_blur(self.eye_distance),
            in_focus_mm: elsewhere.map(|elsewhere| elsewhere.focus),
            in_focus_tv: elsewhere.map(|elsewhere| elsewhere.in_focus),
            under_sun: elsewhere.map(|elsewhere| UnderSun { wall_mm: elsewhere.sun.0, tv: elsewhere.sun.1 }),
            cells_tv: elsewhere.filter(|e| e.windows.len() > 1).map(|elsewhere| cells(&elsewhere.windows)),
            diffraction: self.diffraction.map(|found| DiffractionOnWall {
                smallest_patch_mm: found.patch,
                its_spread_mm: found.spread,
                ssim_eye_if_all_spread: found.ssim,
            }),
            stopped_by_lamp: self.stopped_by_lamp,
            designed: (&self.designed.verdict).into(),
            as_milled: self.milled.as_ref().map(|milled| (&milled.verdict).into()),
        }
    }
}

/// A proof in a room, to which plates are handed one by one.
pub struct RoomProof<'a> {
    /// Every setting.
    pub recipe: &'a Recipe,
    /// The drawing's light.
    pub light: &'a Raster,
    /// Lamp and wall.
    pub scene: &'a Scene,
    /// The scene from the plate's middle.
    pub mirrored: Mirrored<'a>,
}

impl<'a> RoomProof<'a> {
    /// Light sent to the wall.
    pub fn throwing(&self) -> Throwing<'a> {
        let Mirrored { metal, measuring, progress, .. } = self.mirrored;
        let scene = self.scene;
        Throwing { scene, metal, measuring, within: None, progress }
    }

    /// The drawing on `side` pixels.
    pub fn target(&self, side: usize) -> Raster {
        scored_target(self.light, Quantity::Flux, self.mirrored.setup, side)
    }

    /// What is said of light on the wall: within the picture as of any highlight, and on the wall, if there is one.
    pub fn judged(
        &self,
        thrown: Option<Measurement>,
        rim: Option<&RimLight>,
    ) -> Result<(Measurement, Verdict, Option<WallLight>), DesignError> {
        let Mirrored { setup, measuring, progress, .. } = self.mirrored;
        progress.check()?;
        let thrown = thrown.ok_or(DesignError::NoLight)?;
        progress.stage(Stage::Scoring);
        let thrown = match rim {
            Some(rim) => rim.over(thrown),
            None => thrown,
        };
        let measurement = within_picture(&thrown);
        let verdict = Verdict::new(&measurement, &self.target(measuring.resolution), setup.view(), progress)?;
        let on_wall = WallVerdict::new(&thrown, &self.target(ACROSS), self.scene, self.recipe.eye_distance());
        progress.check()?;
        let on_wall = on_wall.map(|verdict| WallLight { thrown, verdict });
        Ok((measurement, verdict, on_wall))
    }

    /// The whole proof from what was judged of the plate as designed.
    pub fn wall_proof(&self, designed: Option<WallLight>, elsewhere: Option<ThrownElsewhere>) -> Option<WallProof> {
        let target = self.target(ACROSS);
        let stopped_by_lamp = stopped_by_lamp(self.scene, self.recipe.plate.size.into(), &target);
        let (scene, eye_distance) = (self.scene.clone(), self.recipe.eye_distance());
        designed.map(|designed| WallProof {
            scene,
            eye_distance,
            target,
            designed,
            milled: None,
            elsewhere,
            diffraction: None,
            stopped_by_lamp,
        })
    }

    /// What a plate throws elsewhere; a share of it may be dark.
    pub fn elsewhere(&self) -> ElsewhereOf<'_> {
        ElsewhereOf {
            scene: self.scene,
            target: self.target(ACROSS),
            cells: self.recipe.cells(),
            progress: self.mirrored.progress,
        }
    }
}

/// [`Elsewhere`] with a drawing of its own.
pub struct ElsewhereOf<'a> {
    scene: &'a Scene,
    target: Raster,
    cells: [usize; 2],
    progress: &'a Progress<'a>,
}

impl Task for ElsewhereOf<'_> {
    type Output = Option<ThrownElsewhere>;

    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let Self { scene, ref target, cells, progress } = self;
        Elsewhere { scene, target, cells, progress }.on(surface)
    }
}

/// Light thrown on the wall, what the plate throws elsewhere, and light of its rim.
struct InRoom<'a> {
    throwing: Throwing<'a>,
    elsewhere: ElsewhereOf<'a>,
}

impl Task for InRoom<'_> {
    type Output = (Option<Measurement>, Option<ThrownElsewhere>);

    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        (self.throwing.on(surface), self.elsewhere.on(surface))
    }
}

/// Sends the light of `scene` over the design's exact relief, and over it as its cutter and polish leave it, to its wall.
pub(super) fn prove_in_room(
    recipe: &Recipe,
    scene: &Scene,
    light: &Raster,
    design: &Design,
    progress: &Progress,
) -> Result<Proof, DesignError> {
    progress.stage(Stage::Tracing);
    let setup = &design.distribution.setup;
    let measuring = recipe.measuring();
    let metal: Material = recipe.metal();
    let room = RoomProof {
        recipe,
        light,
        scene,
        mirrored: Mirrored { setup, metal: &metal, measuring: &measuring, progress },
    };
    let sheet = design.near.as_ref().and_then(|near| near.sheet.as_ref());
    let task = InRoom { throwing: room.throwing(), elsewhere: room.elsewhere() };
    let border = recipe.plate.border;
    let (thrown, elsewhere) = match sheet {
        None => task.on(&GridSurface::new(&design.relief, progress)?),
        // Without its rim: that is lit by itself.
        Some(sheet) if border > 0.0 => {
            let bare = sheet_solid(&sheet.relief, recipe.plate.thickness, 0.0, progress)?;
            TracedPlate::new(&bare, 0.0, progress)?.run(task)
        }
        Some(_) => TracedPlate::new(&design.mesh, 0.0, progress)?.run(task),
    };
    let rim = match &thrown {
        Some(thrown) if border > 0.0 => {
            let over = OverRim { mirrored: room.mirrored, width: border, scene: Some(scene) };
            let light = match sheet {
                None => over.on(&GridSurface::new(&design.relief, progress)?)?,
                Some(_) => TracedPlate::new(&design.mesh, border, progress)?.run(over)?,
            };
            Some(rim_proof(light, thrown, recipe.border_finish()))
        }
        _ => None,
    };
    let over_all = rim.as_ref().filter(|rim| rim.counts).map(|rim| &rim.light);
    let (measurement, verdict, designed) = room.judged(thrown, over_all)?;
    let mut wall = room.wall_proof(designed, elsewhere);
    if let (Some(wall), Some(sheet)) = (&mut wall, sheet) {
        wall.diffraction = diffraction(&sheet.relief, wall, progress)?;
        progress.check()?;
    }
    let mut milled = None;
    if let Some((thrown, left)) = over_milled(&room, design, sheet.map(|sheet| &sheet.relief))? {
        let (measurement, verdict, on_wall) = room.judged(thrown, over_all)?;
        milled = Some(MilledProof { left, measurement, verdict });
        if let Some(wall) = &mut wall {
            wall.milled = on_wall;
        }
    }
    let target = room.target(measuring.resolution);
    Ok(Proof { target, measurement, verdict, sheet: None, milled, made: None, rim, wall })
}

/// Light of a rim beside that of the plate on its wall; what falls into the picture is looked at.
pub fn rim_proof(light: RimLight, thrown: &Measurement, finish: BorderFinish) -> RimProof {
    let dull = RimProof::dull(light.within_picture(), &within_picture(thrown));
    RimProof { light, counts: finish != BorderFinish::Matt, ..dull }
}

/// Light over the plate as its cutter and polish leave it, and the most that the cutter leaves, mm; `None` without them.
fn over_milled(
    room: &RoomProof,
    design: &Design,
    sheet: Option<&OpenRelief>,
) -> Result<Option<ThrownMilled>, DesignError> {
    let (cutter, polish) = (room.recipe.design.sheet.cutter, room.recipe.design.sheet.polish);
    if cutter.is_none() && polish.is_none() {
        return Ok(None);
    }
    room.mirrored.progress.stage(Stage::Milling);
    match sheet {
        Some(relief) => room.over_milled_sheet(relief).map(Some),
        None => cutter.map(|cutter| room.over_milled_facets(&design.relief, cutter)).transpose(),
    }
}

/// Light thrown on the wall by a milled plate, and the most that its cutter leaves, mm.
pub type ThrownMilled = (Option<Measurement>, f64);

impl RoomProof<'_> {
    /// Light over the plate of the recipe that stands in `mesh`, as its cutter and polish leave it; `None` without them, or
    /// if the mesh is no such plate. The optical area is the xy bounding box less `margin` mm on each side.
    ///
    /// # Errors
    /// The milled plate cannot be traced, or the job is abandoned.
    pub fn over_milled_mesh(&self, mesh: &Mesh, margin: f64) -> Result<Option<ThrownMilled>, DesignError> {
        let (cutter, polish) = (self.recipe.design.sheet.cutter, self.recipe.design.sheet.polish);
        if cutter.is_none() && polish.is_none() {
            return Ok(None);
        }
        let progress = self.mirrored.progress;
        progress.stage(Stage::Milling);
        match within_rim(mesh, margin, progress)? {
            Some((Recognised::Heights(grid), (low, high))) => {
                unrepeated(&grid, low, high).map(|relief| self.over_milled_sheet(&relief)).transpose()
            }
            Some((Recognised::Facets(relief), _)) => {
                cutter.map(|cutter| self.over_milled_facets(&relief, cutter)).transpose()
            }
            None => Ok(None),
        }
    }

    fn over_milled_facets(&self, relief: &FacetedRelief, cutter: Cutter) -> Result<ThrownMilled, DesignError> {
        let progress = self.mirrored.progress;
        let cut = milled_facets(relief, cutter, progress)?;
        Ok((self.throwing().on(&GridSurface::continuous(&cut.surface, progress)?), cut.most_left))
    }

    fn over_milled_sheet(&self, relief: &OpenRelief) -> Result<ThrownMilled, DesignError> {
        let progress = self.mirrored.progress;
        let (cut, left) = cut_plate(self.recipe, relief, progress)?;
        let surface = cut.height_grid(progress)?;
        progress.check()?;
        Ok((self.throwing().on(&GridSurface::continuous(&surface, progress)?), left))
    }
}

/// The change of the light at a blur of 0.5° that shows a patch to be needed: as for far sheets at 1°.
const SEEN: f64 = 0.002;

/// Halvings of the range of patches, on a logarithmic scale: from a node to a twentieth of the plate in steps of 8 %.
const HALVINGS: usize = 6;

/// Width of a Gaussian at half its height, standard deviations.
const WIDTH: f64 = 2.354_820_045_030_949;

/// Looks for the widest Gaussian by which heights can be smoothed without visible change of the light on the wall, and for
/// what diffraction by patches so wide leaves of the picture.
fn diffraction(
    relief: &OpenRelief,
    wall: &WallProof,
    progress: &Progress,
) -> Result<Option<WallDiffraction>, Cancelled> {
    let WallProof { scene, eye_distance, target, designed, .. } = wall;
    let grid = PlateGrid::of(relief, None);
    let written = grid.embedded(relief);
    let surface = |heights: &[f32]| GridSurface::continuous(&grid.plate(heights).height_grid(progress)?, progress);
    let Some(change) = change(scene, &surface(&written)?, progress) else { return Ok(None) };
    let (mut unseen, mut seen) = (0.25 * relief.step.min_element(), 0.05 * relief.size().min_element());
    for _ in 0..HALVINGS {
        let middle = (unseen * seen).sqrt();
        let changed = change(&surface(&polished(&grid, written.clone(), middle))?);
        let Some(changed) = changed else { return Ok(None) };
        *(if changed > SEEN { &mut seen } else { &mut unseen }) = middle;
    }
    let patch = WIDTH * unseen;
    let spread = scene.wall_distance() * WAVELENGTH / patch;
    let ssim = likeness_once_spread(&designed.thrown, target, scene, *eye_distance, spread / WIDTH);
    Ok(ssim.map(|ssim| WallDiffraction { patch, spread, ssim }))
}
