//! A camera's picture of a plate of patches, averaged over each of them, beside the picture that is wanted.

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::camera::Camera;
use super::render::{RenderedView, ViewSettings};
use super::score::structural_similarity;
use crate::patches::plate::Patches;
use crate::projection::View;
use crate::raster::Raster;
use crate::slope::direction;

/// Pixels of the camera's picture for each patch along the longer side of the plate: with a rim around it about 10 lie
/// across a patch, so that pixels on its edges, which show two patches, are a fifth of all.
const PIXELS_A_PATCH: usize = 17;

/// The smallest picture, pixels a side.
const LEAST_PIXELS: usize = 256;

/// Least patches along both sides for a likeness: its windows are 11 wide.
const LEAST_FOR_SSIM: usize = 11;

/// What a camera sees, patch by patch.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchView {
    /// Mean radiance of each patch, 1/sr for a lamp of irradiance 1 across its beam, row 0 on top.
    pub seen: Raster,
    /// Its standard error.
    pub errors: Raster,
}

/// How near a plate looks to what is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PatchScores {
    /// Structural similarity of the pictures of one pixel a patch, both in the same unit; `None` of plates with fewer than
    /// 11 patches along a side.
    pub ssim: Option<f64>,
    /// Share of light that is in another patch, both pictures with the same light in all.
    pub tv: f64,
    /// Light of all patches over that of the wanted picture.
    pub light: f64,
    /// Root of the mean square of the patches' standard errors, as a share of the wanted picture's peak.
    pub noise: f64,
    /// Radiance that 99 % and 1 % of the patches stay below, 1/sr.
    pub bright: f64,
    /// See `bright`.
    pub dark: f64,
}

/// Pixels a side of the picture that is averaged over patches.
pub fn resolution(patches: &Patches) -> usize {
    let longer = patches.count[0].max(patches.count[1]);
    (PIXELS_A_PATCH * longer).clamp(LEAST_PIXELS, ViewSettings::MOST_PIXELS)
}

/// Angle across a picture that holds a plate with a diagonal of `diagonal` mm from `distance` mm, and a rim, degrees.
pub fn field_of_view(diagonal: f64, distance: f64) -> f64 {
    (2.4 * (0.5 * diagonal / distance).atan()).to_degrees().clamp(1e-6, 160.0)
}

impl PatchView {
    /// Averages a picture over the patches that its pixels look at. `middle` is the place that the camera looks at, mm,
    /// and `level` the height at which patches are told apart, mm.
    ///
    /// The light of the pixels whose middles look at a patch is divided by the area of the patch in the picture: to divide it
    /// by their number would count a dark rim's pixels here and not there, and leave stripes of 10 % on a portrait.
    pub fn new(view: &RenderedView, settings: &ViewSettings, patches: &Patches, middle: DVec3, level: f64) -> Self {
        let [columns, rows] = patches.count;
        let toward = direction(settings.theta.to_radians(), settings.phi.to_radians());
        let fov = settings.field_of_view.to_radians();
        let camera = Camera::new(middle, toward, settings.distance, fov, settings.size);
        let mut sums = vec![[0.0f64; 2]; columns * rows];
        let [width, height] = settings.size;
        for k in 0..width * height {
            let uv = View::pixel_centre(k % width, k / width, width, height);
            let way = camera.direction(uv);
            if way.z >= 0.0 {
                continue;
            }
            let at = camera.position + (level - camera.position.z) / way.z * way;
            if let Some([column, row]) = patches.patch_at(at.truncate()) {
                let sum = &mut sums[row * columns + column];
                sum[0] += view.radiance.values[k];
                sum[1] += view.errors.values[k].powi(2);
            }
        }
        let half = 0.5 * DVec2::new(width as f64, height as f64);
        let pixels = |k: usize| {
            let (patch, middle) = (patches.patch(), patches.middle(k % columns, k / columns));
            let corner = |x: f64, y: f64| camera.uv((middle + 0.5 * patch * DVec2::new(x, y)).extend(level));
            let [a, b, c, d] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| corner(x, y));
            // Half the product of the diagonals, as vectors.
            let area = |a: DVec2, b: DVec2, c: DVec2, d: DVec2| 0.5 * ((c - a) * half).perp_dot((d - b) * half);
            Some(area(a?, b?, c?, d?)).filter(|area| *area > 0.0)
        };
        let raster = |of: fn(&[f64; 2]) -> f64| Raster {
            width: columns,
            height: rows,
            values: (0..sums.len()).map(|k| pixels(k).map_or(0.0, |pixels| of(&sums[k]) / pixels)).collect(),
        };
        Self { seen: raster(|sum| sum[0]), errors: raster(|sum| sum[1].sqrt()) }
    }

    /// How near it is to `wanted`, in the same unit.
    pub fn scores(&self, wanted: &Raster) -> PatchScores {
        let large_enough = wanted.width.min(wanted.height) >= LEAST_FOR_SSIM;
        let ssim = large_enough.then(|| structural_similarity(&self.seen, wanted));
        let (seen, all) = (self.seen.sum(), wanted.sum());
        let apart = self.seen.values.iter().zip(&wanted.values).map(|(a, b)| (a / seen - b / all).abs());
        let tv = if seen > 0.0 && all > 0.0 { 0.5 * apart.sum::<f64>() } else { 1.0 };
        let squares = self.errors.values.iter().map(|error| error * error).sum::<f64>();
        let noise = (squares / self.errors.values.len().max(1) as f64).sqrt() / wanted.max();
        let mut sorted = self.seen.values.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let rank = |share: f64| sorted[(share * (sorted.len() - 1) as f64).round() as usize];
        PatchScores { ssim, tv, light: seen / all, noise, bright: rank(0.99), dark: rank(0.01) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lamp::Lamp;
    use crate::patches::dimple::Walls;
    use crate::patches::milled::milled;
    use crate::patches::portrait::Portrait;
    use crate::patches::viewer::Viewer;
    use crate::progress::Progress;
    use crate::recipe::Recipe;
    use crate::relief::open::{NodeGrid, OpenRelief};
    use crate::trace::Surface;
    use crate::trace::grid::GridSurface;
    use crate::verify::experiment::Experiment;
    use crate::verify::render::render;

    fn seen(recipe: &Recipe, relief: &OpenRelief, patches: &Patches) -> PatchView {
        let grid = relief.height_grid(&Progress::silent());
        let surface = GridSurface::continuous(&grid.unwrap(), &Progress::silent()).unwrap();
        let setup = recipe.setup();
        let lamp: Lamp = setup.lamp().into();
        let experiment = Experiment { surface: &surface, setup: &setup, material: recipe.metal(), lamp };
        let settings = ViewSettings {
            theta: 40.0,
            phi: 180.0,
            distance: 300.0,
            field_of_view: field_of_view(patches.size.length(), 300.0),
            size: [resolution(patches); 2],
            rays: 16,
            ..ViewSettings::default()
        };
        let view = render(&experiment, &settings, &Progress::silent()).unwrap();
        PatchView::new(&view, &settings, patches, surface.middle(), -0.04)
    }

    #[test]
    fn a_planted_picture_is_seen_on_the_metal_and_after_the_cutter() {
        let mut recipe = Recipe::default();
        (recipe.plate.lobe, recipe.light.theta) = (1.5, 40.0);
        let patches = Patches { count: [14, 12], size: DVec2::new(14.0, 12.0), nodes: 20 };
        // Neither turned nor mirrored is it like itself.
        let tones = Raster::from_fn(14, 12, |x, y| match (x, y) {
            (2..5, 1..10) | (2..11, 7..10) => 1.0,
            (8..12, 2..4) => 0.4,
            _ => 0.05,
        });
        let eye = DVec3::new(7.0, 6.0, 0.0) + 300.0 * direction(f64::to_radians(40.0), std::f64::consts::PI);
        let spread = f64::to_radians(0.75);
        let viewer = Viewer::new(recipe.metal(), spread, recipe.setup().light(), 0.0, eye);
        let walls = Walls { half: DVec2::splat(0.5), steep: 0.3, spare: None };
        let width = f64::to_radians(3.0).tan();
        let portrait = Portrait::new(&patches, walls, width, (&tones, &viewer), &Progress::silent()).unwrap();
        let [black, white] = portrait.range;
        assert!(white > 500.0 * black, "{black} {white}");
        let relief = patches.relief(&portrait.dimples, &Progress::silent()).unwrap();
        let scores = seen(&recipe, &relief, &patches).scores(&portrait.wanted);
        assert!(scores.ssim.unwrap() > 0.95 && scores.tv < 0.05, "{scores:?}");
        assert!((scores.light - 1.0).abs() < 0.03 && scores.noise < 0.05, "{scores:?}");
        let cut = milled(&patches, &relief, "ball:0.5".parse().unwrap(), &Progress::silent()).unwrap();
        assert!((0.001..0.02).contains(&cut.most_left), "{}", cut.most_left);
        assert_eq!(cut.relief.size(), patches.size);
        let scores = seen(&recipe, &cut.relief, &patches).scores(&portrait.wanted);
        assert!(scores.ssim.unwrap() > 0.9 && (0.9..1.02).contains(&scores.light), "{scores:?}");
    }
}
