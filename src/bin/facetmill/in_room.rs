//! A plate that is there, proved in its room: the scene that flags and recipe make, and the light on its wall.

use facetmill::job::findings::{MilledProof, Proof};
use facetmill::job::on_wall::{RoomProof, rim_proof};
use facetmill::raster::Raster;
use facetmill::recipe::{BorderFinish, Recipe, SceneSettings};
use facetmill::scene::Scene;
use facetmill::verify::measure::Mirrored;
use facetmill::verify::rim::OverRim;

use crate::args::VerifyArgs;
use crate::console::Failure;
use crate::inputs;
use crate::plates::Opened;

/// The recipe in the scene that the flags say, if lamp and plate can stand so.
///
/// `designed_for` is the scene of the plate's own recipe: a wall that is elsewhere has a picture as much wider.
pub fn in_its_scene(args: &VerifyArgs, mut recipe: Recipe, designed_for: &SceneSettings) -> Result<Recipe, Failure> {
    if let Some(file) = &args.scene {
        recipe.scene.room = Some(inputs::room(file)?);
    }
    let mut recipe = args.settings.implied(recipe).map_err(Failure::Usage)?;
    // Light that spreads on its way grows with the wall's distance.
    if let (Some(width), Some(from), Some(to)) = (designed_for.picture_width, designed_for.wall, recipe.scene.wall)
        && !args.settings.has("picture-width")
    {
        recipe.scene.picture_width = Some(width * to / from);
    }
    recipe.check().map_err(Failure::of_flags)?;
    if recipe.is_near() && args.mount.is_some() {
        return Err(Failure::Usage(
            "--mount has no meaning beside a lamp or a wall nearby: their pose is the plate's".into(),
        ));
    }
    Ok(recipe)
}

/// The proof of a plate in its room.
pub fn in_room(
    recipe: &mut Recipe,
    scene: &Scene,
    opened: &Opened,
    (light, margin): (&Raster, f64),
    mirrored: Mirrored,
) -> Result<Proof, Failure> {
    recipe.plate.size = (opened.size.truncate() - 2.0 * margin).to_array();
    let room = RoomProof { recipe, light, scene, mirrored };
    let plate = opened.bare.as_ref().unwrap_or(&opened.plate);
    let (thrown, elsewhere) = (plate.run(room.throwing()), plate.run(room.elsewhere()));
    let rim = match &thrown {
        Some(thrown) if margin > 0.0 => {
            let light = opened.plate.run(OverRim { mirrored, width: margin, scene: Some(scene) })?;
            Some(rim_proof(light, thrown, BorderFinish::Matt))
        }
        _ => None,
    };
    let (measurement, verdict, designed) = room.judged(thrown, None)?;
    let (target, mut wall) = (room.target(measurement.whole.image.width), room.wall_proof(designed, elsewhere));
    let mut milled = None;
    if let Some((thrown, left)) = room.over_milled_mesh(&opened.mesh, margin)? {
        let (measurement, verdict, on_wall) = room.judged(thrown, None)?;
        milled = Some(MilledProof { left, measurement, verdict });
        if let Some(wall) = &mut wall {
            wall.milled = on_wall;
        }
    }
    Ok(Proof { target, measurement, verdict, sheet: None, milled, made: None, rim, wall })
}
