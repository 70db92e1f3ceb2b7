//! What slopes that are spread make of a drawing: its light through a wider blur, against its light as it is looked at.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2};

use super::grain::Spread;
use crate::fourier::WaveTransform;
use crate::highlight::scored_target;
use crate::picture::Picture;
use crate::progress::{Cancelled, Progress};
use crate::raster::Raster;
use crate::recipe::Recipe;
use crate::relief::periodic::PeriodicRelief;
use crate::setup::Setup;
use crate::slope::Slope;
use crate::verify::verdict::MAIN_BLUR;
use crate::verify::windows::FirstBounce;

/// Pixels a side of the drawing, and of the grid that has room for what is spread beyond its rim. The main blur is three
/// pixels wide at the usual half field; with twice as many pixels misplaced light changes by less than a fiftieth.
const SIDE: usize = 128;
const GRID: usize = 192;

/// A drawing, ready to be smeared.
pub struct Drawing {
    setup: Setup,
    transform: WaveTransform,
    /// On the grid, sum 1.
    light: Vec<f64>,
    /// Pixels of the image for a unit of slope, where the plate is least steep about its mean.
    pixels: DMat2,
    /// Standard deviation of the blur through which it is looked at, pixels.
    blur: f64,
    /// Through that blur.
    seen: Vec<f64>,
}

/// By how much light differs from the drawing, as it is looked at, on the grid.
pub struct Besides(Vec<f64>);

impl Besides {
    /// What is left of it without `other`.
    pub fn less(&self, other: &Self) -> Self {
        Self(self.0.iter().zip(&other.0).map(|(a, b)| a - b).collect())
    }
}

impl Drawing {
    /// The drawing of `picture`, as plates of `recipe` are scored against it; the middle of its slopes is `mean`.
    pub fn new(recipe: &Recipe, picture: &Picture, mean: Slope) -> Option<Self> {
        let setup = recipe.setup();
        let target = scored_target(&picture.light, recipe.highlight.quantity, &setup, SIDE);
        let step = 1e-4;
        let image = |by: DVec2| setup.image_of_slope(Slope::from_vec(mean.to_vec() + by));
        let derivative = |axis: DVec2| Some((image(step * axis)? - image(-step * axis)?) / (2.0 * step));
        let rows_go_down = DMat2::from_diagonal(DVec2::new(1.0, -1.0));
        let pixels =
            0.5 * SIDE as f64 * (rows_go_down * DMat2::from_cols(derivative(DVec2::X)?, derivative(DVec2::Y)?));
        let blur = setup.view().blur_pixels(MAIN_BLUR.to_radians(), SIDE);
        let (transform, light) = (WaveTransform::new(GRID, GRID), on_grid(&target));
        let mut drawing = Self { setup, transform, light, pixels, blur, seen: Vec::new() };
        drawing.seen = drawing.through(drawing.light.clone(), DMat2::ZERO);
        Some(drawing)
    }

    /// Share of the light that is misplaced or lost, as it is looked at, where slopes are spread by `spread` about those
    /// meant, on passes at `angle` radians; `besides` is what else the light differs by, pixel for pixel.
    pub fn misplaced(&self, spread: Spread, angle: f64, besides: Option<&Besides>) -> f64 {
        let along = DVec2::from_angle(angle);
        let axes = self.pixels * DMat2::from_cols(spread.along * along, spread.across * along.perp());
        let made = self.through(self.light.clone(), axes * axes.transpose());
        let inside = |k: &usize| k % GRID < SIDE && k / GRID < SIDE;
        let by = |k: usize| made[k] - self.seen[k] + besides.map_or(0.0, |besides| besides.0[k]);
        let (apart, lost) =
            (0..GRID * GRID).filter(inside).map(by).fold((0.0, 0.0), |(apart, lost), by| (apart + by.abs(), lost + by));
        0.5 * (apart + f64::abs(lost))
    }

    /// What the light of `relief`'s first bounces differs by from the drawing, as it is looked at.
    ///
    /// # Errors
    /// The work was abandoned.
    pub fn besides(&self, relief: &PeriodicRelief, progress: &Progress) -> Result<Besides, Cancelled> {
        let first = FirstBounce::new(relief, &self.setup, (SIDE, SIDE), progress)?;
        let sent = first.window([0, 0], relief.nodes).unwrap_or_else(|| Raster::zeros(SIDE, SIDE));
        let seen = self.through(on_grid(&sent), DMat2::ZERO);
        Ok(Besides(seen.iter().zip(&self.seen).map(|(a, b)| a - b).collect()))
    }

    /// The light through the blur and a Gaussian of covariance `wider`, pixels².
    fn through(&self, mut light: Vec<f64>, wider: DMat2) -> Vec<f64> {
        let covariance = wider + DMat2::from_diagonal(DVec2::splat(self.blur * self.blur));
        let frequency = |k: usize| (if k > GRID / 2 { k as f64 - GRID as f64 } else { k as f64 }) * TAU / GRID as f64;
        self.transform.filter(&mut light, |i, j| {
            let k = DVec2::new(frequency(i), frequency(j));
            (-0.5 * k.dot(covariance * k)).exp().into()
        });
        light
    }
}

/// An image with room around it.
fn on_grid(image: &Raster) -> Vec<f64> {
    let mut light = vec![0.0; GRID * GRID];
    for (row, values) in image.values.chunks(SIDE).enumerate() {
        light[row * GRID..row * GRID + SIDE].copy_from_slice(values);
    }
    light
}
