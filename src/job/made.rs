//! The proof of a plate as a machine makes it: light over the surface that its passes leave, once it is polished if it is.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::design::{Design, DesignError};
use super::findings::{MadeProof, Proof, RimProof, WallLight};
use super::on_wall::RoomProof;
use crate::brdf::material::Material;
use crate::export::sheet::sheet_solid;
use crate::milling::made::Machining;
use crate::milling::passes::Ways;
use crate::milling::polish::in_words;
use crate::progress::{Progress, Stage};
use crate::projection::View;
use crate::raster::Raster;
use crate::recipe::{Recipe, RecipeError};
use crate::relief::mesh::Mesh;
use crate::relief::open::OpenRelief;
use crate::report::made::MadeFacts;
use crate::setup::Setup;
use crate::sharpen::{BlurKernel, seen};
use crate::slope::{Slope, angle_between, mirror};
use crate::trace::path::{End, Fate};
use crate::trace::traced_plate::TracedPlate;
use crate::verify::experiment::{HighlightImage, Measuring, Sensor};
use crate::verify::measure::Mirrored;
use crate::verify::tally::{MeasureError, Measurement, PARTS, Tally};
use crate::verify::verdict::Verdict;

/// Rows of slopes over a plate that is not polished, for each part of its light. Of the portrait on 30 mm, cut by a ball of
/// 0.5 mm with passes 0.02 mm apart, half as many change TV(1°) by 0.0005.
const ROWS_A_PART: usize = 64;

/// Rows of slopes in all by which a plate that is not polished is judged.
pub(super) const BARE_ROWS: usize = ROWS_A_PART * PARTS;

/// Solid metal under the lowest point of a plate that is only lit, mm.
const THICKNESS: f64 = 1.0;

/// Angle from straight back within which a false spot is looked for, degrees.
const SPOT: f64 = 0.5;

/// Proves `design` for the drawing's `light` as the machine of its recipe makes it, if that names one; `proof` has its target
/// and the light of its rim.
///
/// # Errors
/// As [`prove_as_made`].
pub fn made_by_machine(
    recipe: &Recipe,
    light: &Raster,
    (design, proof): (&Design, &Proof),
    progress: &Progress,
) -> Result<Option<MadeProof>, DesignError> {
    let Some(machining) = recipe.machining()? else { return Ok(None) };
    let lighting = Lighting::new(recipe, &design.distribution.setup);
    let plate = (&design.mesh, DVec2::from(recipe.plate.size), recipe.plate.border);
    let mirrored = lighting.mirrored(progress);
    let made = match &proof.wall {
        Some(wall) => {
            let room = RoomProof { recipe, light, scene: &wall.scene, mirrored };
            prove_as_made_in_room(&machining, plate, &room, proof.rim.as_ref(), recipe.draws())?
        }
        None => {
            let seen = lighting.seen(&proof.target, proof.rim.as_ref());
            prove_as_made(&machining, plate, seen, recipe.draws(), mirrored)?
        }
    };
    Ok(Some(made))
}

/// How the plates of a recipe are lit, and through what they are seen.
pub struct Lighting<'a> {
    setup: &'a Setup,
    metal: Material,
    measuring: Measuring,
    blur: Option<BlurKernel>,
}

impl<'a> Lighting<'a> {
    /// As `recipe` says, light and image as `setup` has them.
    pub fn new(recipe: &Recipe, setup: &'a Setup) -> Self {
        Self { setup, metal: recipe.metal(), measuring: recipe.measuring(), blur: recipe.blur(setup) }
    }

    /// Light to be sent over a surface of it.
    pub fn mirrored<'b>(&'b self, progress: &'b Progress<'b>) -> Mirrored<'b> {
        Mirrored { setup: self.setup, metal: &self.metal, measuring: &self.measuring, progress }
    }

    /// Beside `target`, and with the light of `rim`.
    pub fn seen<'b>(&'b self, target: &'b Raster, rim: Option<&'b RimProof>) -> Seen<'b> {
        Seen { target, blur: self.blur.as_ref(), rim }
    }
}

/// What a plate as made is looked at beside, and what is seen with it.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// The drawing.
    pub target: &'a Raster,
    /// What lamp and metal blur, if they do.
    pub blur: Option<&'a BlurKernel>,
    /// Light of the rim, which no machine alters.
    pub rim: Option<&'a RimProof>,
}

/// Proves `mesh`, whose optical area of `plate` mm begins `margin` mm inside its box, as `machining` leaves it in each of
/// `draws` draws of the machine's errors.
///
/// # Errors
/// The made plate cannot be closed or traced, no light reaches the image, or the caller asked to stop.
pub fn prove_as_made(
    machining: &Machining,
    (mesh, plate, margin): (&Mesh, DVec2, f64),
    seen: Seen,
    draws: u64,
    mirrored: Mirrored,
) -> Result<MadeProof, DesignError> {
    let progress = mirrored.progress;
    progress.stage(Stage::Milling);
    let ways = machining.ways(&mesh.at_optical_corner(margin), plate, progress)?;
    prove_along(machining, &ways, seen, draws, mirrored)
}

/// The same of a plate in its room, the light of whose polished surface lands on the wall; light of the rim counts as `rim`
/// says.
///
/// # Errors
/// As [`prove_as_made`], and of a surface that is not polished.
pub fn prove_as_made_in_room(
    machining: &Machining,
    (mesh, plate, margin): (&Mesh, DVec2, f64),
    room: &RoomProof,
    rim: Option<&RimProof>,
    draws: u64,
) -> Result<MadeProof, DesignError> {
    let progress = room.mirrored.progress;
    progress.stage(Stage::Milling);
    let ways = machining.ways(&mesh.at_optical_corner(margin), plate, progress)?;
    let over_all = rim.filter(|rim| rim.counts).map(|rim| &rim.light);
    let judging = |surface: Option<&OpenRelief>, _| {
        let plate = plate_of(surface.ok_or(RecipeError::BareNearby)?, progress)?;
        room.judged(plate.run(room.throwing()), over_all)
    };
    let proof = over_draws(machining, &ways, draws, &judging, progress)?;
    let target = room.target(room.mirrored.measuring.resolution);
    let central_spot = central_spot(&proof.measurement, &target, room.mirrored);
    Ok(MadeProof { central_spot, ..proof })
}

/// [`prove_as_made`] where the passes over the plate are known.
///
/// # Errors
/// As [`prove_as_made`].
pub fn prove_along(
    machining: &Machining,
    ways: &Ways,
    Seen { target, blur, rim }: Seen,
    draws: u64,
    mirrored: Mirrored,
) -> Result<MadeProof, DesignError> {
    let progress = mirrored.progress;
    let judging = |surface: Option<&OpenRelief>, draw: u64| {
        let measurement = match surface {
            Some(surface) => traced(surface, mirrored)?,
            None => {
                let surface = machining.bare(ways, draw);
                bare(|k, rows| surface.slopes(k, rows), blur, mirrored)?
            }
        };
        progress.check()?;
        progress.stage(Stage::Scoring);
        let measurement = RimProof::over(rim, measurement);
        let verdict = Verdict::new(&measurement, target, mirrored.setup.view(), progress)?;
        Ok((measurement, verdict, None))
    };
    let proof = over_draws(machining, ways, draws, &judging, progress)?;
    let central_spot = central_spot(&proof.measurement, target, mirrored);
    Ok(MadeProof { central_spot, ..proof })
}

/// What is found of a surface, or of one that is not polished in the draw of that number: light, its figures, and those on a
/// wall.
type Judging<'a> =
    dyn Fn(Option<&OpenRelief>, u64) -> Result<(Measurement, Verdict, Option<WallLight>), DesignError> + 'a;

/// The proof of what the passes leave, looked at in each draw; its central spot is still to be found.
fn over_draws(
    machining: &Machining,
    ways: &Ways,
    draws: u64,
    judging: &Judging,
    progress: &Progress,
) -> Result<MadeProof, DesignError> {
    let mut found = Vec::new();
    let mut first = None;
    for draw in 0..draws.max(1) {
        if draw > 0 {
            progress.stage(Stage::Milling);
        }
        let surface = machining.polished(ways, draw, progress)?;
        found.push(judging(surface.as_ref(), draw)?);
        first = first.or(surface);
    }
    let draws = found.iter().map(|(_, verdict, _)| verdict.main().tv_incident.value).collect();
    let (measurement, verdict, on_wall) = found.into_iter().next().ok_or(DesignError::NoLight)?;
    let hours = ways.hours(&machining.machine, machining.passes.zigzag);
    let machining = machining.clone();
    Ok(MadeProof { machining, surface: first, measurement, verdict, on_wall, draws, central_spot: 0.0, hours })
}

impl MadeProof {
    /// By what and with what, such as `vmc makes it with ball:0.5, polished 40 µm`.
    pub fn how(&self) -> String {
        let Machining { machine, cutter, polish, .. } = &self.machining;
        format!("{} makes it with {cutter}, {}", machine.name, in_words(*polish))
    }

    /// What a report says of it.
    pub fn facts(&self) -> MadeFacts {
        MadeFacts {
            scores: (&self.verdict).into(),
            tv_incident_1deg_by_draw: self.draws.clone(),
            machining: (&self.machining).into(),
            central_spot: self.central_spot,
            finishing_hours: self.hours,
            on_wall: self.on_wall.as_ref().map(|light| (&light.verdict).into()),
        }
    }
}

/// A polished surface, ready for light.
fn plate_of(surface: &OpenRelief, progress: &Progress) -> Result<TracedPlate, DesignError> {
    let solid = sheet_solid(surface, THICKNESS, 0.0, progress)?;
    Ok(TracedPlate::new(&solid, 0.0, progress)?)
}

/// Light over a polished surface.
pub(super) fn traced(surface: &OpenRelief, mirrored: Mirrored) -> Result<Measurement, DesignError> {
    Ok(plate_of(surface, mirrored.progress)?.run(mirrored)?)
}

/// Light of a plate that is not polished, whose slopes `slopes` tells of row k of n spread evenly over it: first bounces of
/// every slope, nothing in their way, seen through `blur`.
pub(super) fn bare(
    slopes: impl Fn(usize, usize) -> Vec<DVec2> + Sync,
    blur: Option<&BlurKernel>,
    mirrored: Mirrored,
) -> Result<Measurement, MeasureError> {
    let Mirrored { setup, metal, measuring, progress } = mirrored;
    let sensor = HighlightImage { setup, resolution: measuring.resolution };
    let light = setup.light();
    let count = |tally: &mut Tally, slope: &DVec2| {
        let slope = Slope::from_vec(*slope);
        let (normal, flux) = (slope.normal(), slope.intercept(light).max(0.0) / light.z);
        let direction = mirror(light, normal);
        let fate = if direction.z > 0.0 { Fate::Up } else { Fate::Down };
        let weight = metal.facet_share(light.dot(normal));
        tally.incident += flux;
        tally.rays += 1;
        tally.count(&End { fate, weight, bounces: 1, point: DVec3::ZERO, direction }, flux, sensor.pixel(direction));
    };
    // Rows of a part lie between those of all others.
    let part = |part: usize| {
        let mut tally = Tally::empty(sensor.size());
        for k in (part..BARE_ROWS).step_by(PARTS).take_while(|_| !progress.is_abandoned()) {
            let slopes = slopes(k, BARE_ROWS);
            slopes.iter().filter(|slope| slope.is_finite()).for_each(|slope| count(&mut tally, slope));
        }
        if let Some(blur) = blur {
            tally.image = seen(&tally.image, blur);
        }
        tally
    };
    let parts: Vec<Tally> = (0..PARTS).into_par_iter().map(part).collect();
    progress.check()?;
    Measurement::of_parts(parts)
}

/// Share of the light within half a degree of where a level plate throws it, less what the drawing has there.
fn central_spot(measurement: &Measurement, target: &Raster, mirrored: Mirrored) -> f64 {
    let setup = mirrored.setup;
    let level = mirror(setup.light(), DVec3::Z);
    let n = target.width;
    let near = |k: &usize| {
        let uv = View::pixel_centre(k % n, k / n, n, n);
        setup.viewer_at(uv).is_some_and(|o| angle_between(o, level) < SPOT.to_radians())
    };
    let image = measurement.whole.share_image();
    (0..n * n).filter(near).map(|k| image.values[k] - target.values[k]).sum()
}
