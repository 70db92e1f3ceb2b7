//! The drawing of a design's folder, as its light is scored against it.

use std::path::Path;

use facetmill::glam::DVec3;
use facetmill::highlight::scored_target;
use facetmill::job::findings::Proof;
use facetmill::memory::MemoryLimit;
use facetmill::raster::Raster;
use facetmill::recipe::Recipe;
use facetmill::setup::Setup;
use facetmill::verify::tally::Measurement;
use facetmill::verify::verdict::Verdict;

use crate::console::Failure;
use crate::inputs;

/// What is wanted, and where.
pub struct Drawn {
    pub target: Raster,
    pub setup: Setup,
}

impl Drawn {
    /// The proof that light as `measurement` and `verdict` have it is.
    pub fn proof(&self, measurement: &Measurement, verdict: &Verdict) -> Proof {
        Proof {
            target: self.target.clone(),
            measurement: measurement.clone(),
            verdict: verdict.clone(),
            sheet: None,
            milled: None,
            made: None,
            rim: None,
            wall: None,
        }
    }
}

/// The drawing that the recipe in `folder` names, for a plate that is mounted with the normal `mount`; or why its light is
/// not told.
pub fn of(
    folder: &Path,
    recipe: &mut Recipe,
    mount: Option<DVec3>,
    limit: MemoryLimit,
) -> Result<Result<Drawn, String>, Failure> {
    let untold = |why: &str| Ok(Err(format!("Its light is not told: {why}.")));
    if !folder.is_dir() || recipe.picture_path().is_none() {
        return untold("a mesh by itself names no drawing; name a design's folder");
    }
    if recipe.is_near() {
        return untold("as made that is for lamps and walls far away");
    }
    let path = match inputs::picture_of(recipe, &folder.join("recipe.toml")) {
        Ok(path) => path,
        Err(why) => return untold(&why.to_string()),
    };
    let picture = inputs::picture(&path, &recipe.reading(), limit)?;
    recipe.note_drawing(picture.original_size);
    let setup = match mount {
        Some(normal) => recipe.setup().mounted(normal),
        None => recipe.setup(),
    };
    let resolution = recipe.measuring().resolution;
    let target = scored_target(&picture.light, recipe.highlight.quantity, &setup, resolution);
    Ok(Ok(Drawn { target, setup }))
}
