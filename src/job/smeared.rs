//! What slopes that are spread make of a drawing: its light through a wider blur, against its light as it is looked at; and the
//! direction of passes that spreads it least.

use std::f64::consts::{PI, TAU};

use glam::{DMat2, DVec2};

use super::design::{DesignError, slopes};
use crate::fourier::WaveTransform;
use crate::highlight::scored_target;
use crate::progress::{Cancelled, Progress};
use crate::raster::Raster;
use crate::recipe::{PassAngle, Recipe};
use crate::relief::periodic::PeriodicRelief;
use crate::setup::Setup;
use crate::slope::Slope;
use crate::verify::verdict::MAIN_BLUR;
use crate::verify::windows::FirstBounce;

/// Pixels a side of the drawing, and of the grid that has room for what is spread beyond its rim. The main blur is three
/// pixels wide at the usual half field; with twice as many pixels misplaced light changes by less than a fiftieth.
const SIDE: usize = 128;
const GRID: usize = 192;

/// Directions of passes that are tried over half a turn.
const DIRECTIONS: usize = 12;

/// Root mean square of the slopes across passes for which the best direction is looked for: cusps between passes about a
/// twentieth of the cutter's radius apart.
const CUSPS: f64 = 0.0145;

/// Slopes about those that were meant: root mean square along the passes and across them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Along.
    pub along: f64,
    /// Across.
    pub across: f64,
}

/// The direction of `recipe`'s passes for the drawing's `light`: found, if the best is asked for.
///
/// # Errors
/// The light has no slopes.
pub fn pass_angle(recipe: &Recipe, light: &Raster) -> Result<Option<PassAngle>, DesignError> {
    if recipe.machining.pass_angle != Some(PassAngle::Best) {
        return Ok(recipe.machining.pass_angle);
    }
    let mean = slopes(recipe, light, &Progress::silent())?.mean;
    let drawing = Drawing::new(recipe, light, mean).ok_or(DesignError::NoLight)?;
    Ok(Some(PassAngle::Degrees(drawing.best_angle().to_degrees().round())))
}

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
    /// The drawing's `light`, as plates of `recipe` are scored against it; the middle of its slopes is `mean`.
    pub fn new(recipe: &Recipe, light: &Raster, mean: Slope) -> Option<Self> {
        let setup = recipe.setup();
        let target = scored_target(light, recipe.highlight.quantity, &setup, SIDE);
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

    /// The direction in which cusps misplace least, radians.
    pub fn best_angle(&self) -> f64 {
        let angle = |k: usize| PI * k as f64 / DIRECTIONS as f64;
        let spread = Spread { along: 0.0, across: CUSPS };
        let figures = (0..DIRECTIONS).map(|k| (k, self.misplaced(spread, angle(k), None)));
        // Of directions as good as each other, along x: the table's own axis is the best that a machine has.
        let least = |best: (usize, f64), next: (usize, f64)| if next.1 < 0.97 * best.1 { next } else { best };
        figures.reduce(least).map_or(0.0, |(k, _)| angle(k))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::machine::Machine;

    /// Five soft bars across the picture's middle, which lie along `along`, radians from +x toward +y.
    fn bars(along: f64) -> Raster {
        let (along, n) = (DVec2::from_angle(along), 96);
        Raster::from_fn(n, n, |x, y| {
            let at = DVec2::new(x as f64 - 47.5, 47.5 - y as f64) / 48.0;
            let (on, aside) = (along.dot(at), along.perp_dot(at));
            let ends = (-(on / 0.35).powi(4)).exp() * (-(aside / 0.5).powi(4)).exp();
            ends * (aside * 30.0).cos().max(0.0)
        })
    }

    #[test]
    fn passes_lie_across_the_bars_of_a_drawing_so_that_cusps_spread_light_along_them() {
        let mut recipe = Recipe::default();
        recipe.machining.machine = Machine::preset("vmc");
        for (degrees, across) in [(0.0f64, 90.0), (90.0, 0.0), (45.0, 135.0), (120.0, 30.0)] {
            let light = bars(degrees.to_radians());
            recipe.machining.pass_angle = Some(PassAngle::Best);
            assert_eq!(pass_angle(&recipe, &light).unwrap(), Some(PassAngle::Degrees(across)), "{degrees}");
            recipe.machining.pass_angle = Some(PassAngle::Degrees(7.0));
            assert_eq!(pass_angle(&recipe, &light).unwrap(), Some(PassAngle::Degrees(7.0)));
        }
    }
}
