//! A plate of patches from a file, looked at once more and set beside what its recipe asks for.

use glam::{DVec2, DVec3};

use super::clock::Clock;
use super::patches::{Asked, PatchError, PatchProduct, Standing, design_patches, prove};
use crate::memory::MemoryLimit;
use crate::patches::plate::Patches;
use crate::progress::{Cancelled, Progress};
use crate::recipe::Recipe;
use crate::relief::mesh::Mesh;
use crate::relief::open::OpenRelief;
use crate::relief::recognise::Recognised;
use crate::relief::repeats::{unrepeated, within_rim};
use crate::trace::traced_plate::TracedPlate;

/// By how much the sides of a plate may differ from those of its recipe: patches would be told apart by a tenth of their
/// width too far at the rim of a hundred of them.
const SAME_SIZE: f64 = 1e-3;

/// A plate that is there, and how it is looked at.
#[derive(Clone, Copy, Debug)]
pub struct FoundPlate<'a> {
    /// Its triangles.
    pub mesh: &'a Mesh,
    /// Width of the rim that is no optical area, mm.
    pub margin: f64,
    /// Lamp, metal, rays and cutter.
    pub recipe: &'a Recipe,
}

/// The plate that was `found` beside what the recipe by which it was `designed` wants for what is `asked`: its patches are
/// planned again, and the viewer for whom they were looks at the triangles of the file.
///
/// # Errors
/// The plate is not of its recipe's size, or all of [`design_patches`].
pub fn check_patches(
    designed: &Recipe,
    asked: &Asked,
    found: FoundPlate,
    limit: MemoryLimit,
    progress: &Progress,
) -> Result<PatchProduct, PatchError> {
    let FoundPlate { mesh, margin, recipe } = found;
    let (low, high) = mesh.bounds();
    let size = (high - low).truncate() - 2.0 * margin;
    let wanted = designed.plate.size;
    let off = (size / DVec2::from(wanted) - 1.0).abs().max_element();
    if off.is_nan() || off > SAME_SIZE {
        return Err(PatchError::Size { found: size.to_array(), wanted });
    }
    let mut product = design_patches(designed, asked, false, limit, progress)?;
    let mut clock = Clock::start();
    product.mesh = mesh.at_optical_corner(margin);
    let mut looked = recipe.clone().with_patch_metal();
    // Who looks is who the plate was made for, wherever the lamp is.
    looked.patches.viewer = Some(designed.viewer());
    looked.plate.border = margin;
    product.recipe = looked;
    let plate = TracedPlate::new(&product.mesh, margin, progress)?;
    let relief = heights(&product.mesh, margin, &product.patches, progress)?;
    let standing = Standing { plate: &plate, level: level(&product.mesh, margin), relief: relief.as_ref() };
    product.proof = Some(prove(&product, standing, &mut clock, progress)?);
    product.seconds.extend(clock.into_laps());
    Ok(product)
}

/// Heights of the plate in `mesh` above the rims of its patches, if it stands on the nodes of `patches`.
fn heights(mesh: &Mesh, margin: f64, patches: &Patches, progress: &Progress) -> Result<Option<OpenRelief>, Cancelled> {
    let Some((Recognised::Heights(grid), (low, high))) = within_rim(mesh, margin, progress)? else { return Ok(None) };
    let Some(mut relief) = unrepeated(&grid, low, high) else { return Ok(None) };
    if relief.nodes != patches.count.map(|count| count * patches.nodes + 1) {
        return Ok(None);
    }
    // The second node of the lowest row stands on a patch's rim, the first in its corner.
    let rim = f64::from(relief.heights[1]);
    relief.heights.iter_mut().for_each(|z| *z = (f64::from(*z) - rim) as f32);
    Ok(Some(relief))
}

/// Mean height of what of `mesh` looks up within the rim, by its area seen from above, mm.
fn level(mesh: &Mesh, margin: f64) -> f64 {
    let (low, high) = mesh.bounds();
    let (low, high) = (low.truncate() + margin, high.truncate() - margin);
    let mut sums = [0.0; 2];
    for k in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(k);
        let (area, middle): (f64, DVec3) = (0.5 * (b - a).cross(c - a).z, (a + b + c) / 3.0);
        let inside = middle.truncate().cmpge(low).all() && middle.truncate().cmple(high).all();
        if area > 0.0 && inside {
            sums = [sums[0] + area, sums[1] + area * middle.z];
        }
    }
    if sums[0] > 0.0 { sums[1] / sums[0] } else { 0.0 }
}
