//! Each patch its own lobe, by maps of numbers from 0 to 1, one for each patch, row 0 on top.
//!
//! Normals and anisotropy are coded as in glTF 2.0 and its extension KHR_materials_anisotropy: red and green from -1 to 1 are
//! the normal's x and y, or the direction in which a lobe is long, and blue is how long, from round at 0.

use glam::DVec2;
use rayon::prelude::*;

use super::dimple::{Dimple, PatchLobe, Walls};
use super::plate::Patches;
use super::viewer::Viewer;
use crate::golden::GOLDEN_ANGLE;
use crate::progress::{Cancelled, Progress};
use crate::raster::Raster;
use crate::slope::Slope;

/// Normals that stand for the metal's scatter where an ideal lobe is looked at: a lobe's rim is right to a twentieth.
const SCATTERED: usize = 64;

/// What is known of each patch; what is not given is 1 for gloss and albedo, level and round.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// How narrow the lobe is: 1 the narrowest, 0 the widest.
    pub gloss: Option<Raster>,
    /// Red, green and blue of the normal.
    pub normal: Option<[Raster; 3]>,
    /// Red, green and blue of the anisotropy.
    pub anisotropy: Option<[Raster; 3]>,
    /// Share of the light that can be in the lobe that is.
    pub albedo: Option<Raster>,
}

/// A plate by maps.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapped {
    /// Row by row from the top left.
    pub dimples: Vec<Dimple>,
    /// What the viewer would see of ideal lobes with the shares that the bowls have, 1/sr for a lamp of irradiance 1 across
    /// its beam.
    pub wanted: Raster,
    /// What the written triangles show by their first bounce, 1/sr.
    pub shown: Raster,
    /// Least and largest share of a patch that the largest bowl takes.
    pub most_share: [f64; 2],
}

impl Maps {
    /// The lobe of patch `k`, between half widths of `narrow` and `wide` as slopes.
    fn lobe(&self, k: usize, [narrow, wide]: [f64; 2]) -> PatchLobe {
        let gloss = self.gloss.as_ref().map_or(1.0, |gloss| gloss.values[k].clamp(0.0, 1.0));
        let width = wide * (narrow / wide).powf(gloss);
        let signed = |map: &[Raster; 3]| {
            let [x, y] = [0, 1].map(|channel| 2.0 * map[channel].values[k] - 1.0);
            // What 8 bits cannot say is meant to be 0: 127 and 128 are nearest to it.
            DVec2::new(x, y).map(|v| if v.abs() < 0.006 { 0.0 } else { v })
        };
        let tilt = self.normal.as_ref().map_or(Slope::FLAT, |map| {
            let across = signed(map).clamp_length_max(0.999);
            Slope::from_vec(-across / (1.0 - across.length_squared()).sqrt())
        });
        let (turn, longer) = self.anisotropy.as_ref().map_or((0.0, 0.0), |map| {
            let along = signed(map);
            (along.y.atan2(along.x), map[2].values[k].clamp(0.0, 1.0))
        });
        PatchLobe { widths: DVec2::new(width + longer * (wide - width).max(0.0), width), turn, tilt }
    }

    /// The plate of these maps.
    ///
    /// # Errors
    /// A normal that the walls cannot hold; or the work was cancelled.
    pub fn plate(
        &self,
        patches: &Patches,
        walls: Walls,
        widths: [f64; 2],
        (viewer, spread): (&Viewer, f64),
        progress: &Progress,
    ) -> Result<Mapped, MapsError> {
        let [width, height] = patches.count;
        let made: Vec<(Dimple, [f64; 3])> = (0..patches.len())
            .into_par_iter()
            .map(|k| {
                progress.check()?;
                let (column, row) = (k % width, k / width);
                let lobe = self.lobe(k, widths);
                let most = Dimple::most_share(walls, &lobe);
                if most < LEAST_SHARE {
                    let tilt = lobe.tilt.tilt().to_degrees();
                    return Err(MapsError::Steep { column, row, tilt, walls: walls.steep.atan().to_degrees() });
                }
                let albedo = self.albedo.as_ref().map_or(1.0, |map| map.values[k].clamp(0.0, 1.0));
                let dimple = Dimple::new(walls, &lobe, albedo * most);
                let place = patches.middle(column, row);
                let shown = viewer.radiance(patches, &patches.heights(&dimple), place);
                let wanted = ideal(&lobe, albedo * most, viewer, spread, place);
                Ok((dimple, [wanted, shown, most]))
            })
            .collect::<Result<_, MapsError>>()?;
        let raster = |of: usize| Raster { width, height, values: made.iter().map(|(_, values)| values[of]).collect() };
        let shares = made.iter().map(|(_, [.., share])| *share);
        let most_share = shares.fold([1.0, 0.0], |[low, high]: [f64; 2], share| [low.min(share), high.max(share)]);
        let (wanted, shown) = (raster(0), raster(1));
        Ok(Mapped { dimples: made.into_iter().map(|(dimple, _)| dimple).collect(), wanted, shown, most_share })
    }
}

/// The least share of a patch that its lobe must be able to take.
const LEAST_SHARE: f64 = 0.02;

/// Radiance of a share of a patch with an even lobe, blurred by metal whose normals are spread by `spread`.
fn ideal(lobe: &PatchLobe, share: f64, viewer: &Viewer, spread: f64, place: DVec2) -> f64 {
    let Some(mirroring) = viewer.mirroring(place) else { return 0.0 };
    let scattered = |k: usize| {
        let distance = spread * (-2.0 * (1.0 - (k as f64 + 0.5) / SCATTERED as f64).ln()).sqrt();
        Slope::from_vec(mirroring.to_vec() + DVec2::from_angle(GOLDEN_ANGLE * k as f64) * distance)
    };
    let within = (0..SCATTERED).filter(|k| lobe.holds(scattered(*k))).count() as f64 / SCATTERED as f64;
    let (cosine, o) = (mirroring.normal().z, viewer.toward(place));
    within * share / lobe.area() / (4.0 * o.z * cosine.powi(4))
}

/// Why maps cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapsError {
    /// A lobe beyond the walls.
    #[error(
        "the lobe of the patch in column {column}, row {row} is tilted by {tilt:.1}°, more than walls of {walls:.1}° can hold: flatten the map of normals, or take a smaller --patch-lobe and --widest-lobe"
    )]
    Steep {
        /// From the left, from 0.
        column: usize,
        /// From the top, from 0.
        row: usize,
        /// Degrees.
        tilt: f64,
        /// Degrees.
        walls: f64,
    },
    /// Stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::recipe::Recipe;
    use crate::slope::direction;

    #[test]
    fn maps_say_how_wide_how_tilted_how_long_and_how_much() {
        let map = |values: [f64; 4]| Raster { width: 2, height: 2, values: values.to_vec() };
        let level = || map([0.5; 4]);
        let maps = Maps {
            gloss: Some(map([1.0, 0.0, 1.0, 1.0])),
            normal: Some([map([0.5, 0.5, 0.53, 0.5]), level(), map([1.0; 4])]),
            anisotropy: Some([level(), map([1.0; 4]), map([0.0, 0.0, 0.0, 1.0])]),
            albedo: Some(map([1.0, 1.0, 0.5, 1.0])),
        };
        let widths = [0.04, 0.12];
        let lobes = [0, 1, 2, 3].map(|k| maps.lobe(k, widths));
        let near = |a: DVec2, b: DVec2| (a - b).length() < 1e-9;
        assert!(near(lobes[0].widths, DVec2::splat(0.04)) && near(lobes[1].widths, DVec2::splat(0.12)));
        // A normal to the right is a slope that falls to the right.
        assert!((lobes[2].tilt.p + 0.06 / (1.0f64 - 0.0036).sqrt()).abs() < 1e-9 && lobes[2].tilt.q == 0.0);
        assert!(
            near(lobes[3].widths, DVec2::new(0.12, 0.04)) && (lobes[3].turn - std::f64::consts::FRAC_PI_2).abs() < 1e-9
        );

        let mut recipe = Recipe::default();
        (recipe.plate.lobe, recipe.light.theta) = (1.5, 30.0);
        let patches = Patches { count: [2, 2], size: DVec2::splat(2.0), nodes: 20 };
        let walls = Walls { half: DVec2::splat(0.5), steep: 0.35, spare: None };
        let eye = DVec3::new(1.0, 1.0, 0.0) + 1e5 * direction(f64::to_radians(30.0), std::f64::consts::PI);
        let spread = f64::to_radians(0.75);
        let viewer = Viewer::new(recipe.metal(), spread, recipe.setup().light(), 0.0, eye);
        let plate = maps.plate(&patches, walls, widths, (&viewer, spread), &Progress::silent()).unwrap();
        // Seen in the middle of their lobes: bright, a ninth of that, none (tilted away), a third.
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| (plate.wanted.values[k], plate.shown.values[k]));
        for (wanted, shown) in [a, b, d] {
            assert!((shown / wanted - 1.0).abs() < 0.1, "{wanted} {shown}");
        }
        assert!(c.1 < 0.2 * a.1 && b.0 < 0.2 * a.0 && d.0 < 0.5 * a.0, "{plate:?}");
        let steep = Maps { normal: Some([map([0.9; 4]), level(), level()]), ..Maps::default() };
        let refused = steep.plate(&patches, walls, widths, (&viewer, spread), &Progress::silent());
        assert!(matches!(refused, Err(MapsError::Steep { column: 0, row: 0, .. })), "{refused:?}");
    }
}
