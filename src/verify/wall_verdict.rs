//! The figures of light on the wall of a scene: blurs in millimetres, lost light counted.

use super::blur::{Edge, gaussian};
use super::score::{SUPPORT, distance, structural_similarity};
use super::tally::Measurement;
use super::tally::Tally;
use super::thrown::{ACROSS, MARGIN, WHOLE, cropped};
use super::verdict::Figure;
use crate::raster::Raster;
use crate::scene::Scene;

/// Angles at which light on a wall is compared beside the eye's own blur, degrees as seen from the plate.
pub const WALL_BLURS: [f64; 2] = [0.5, 1.0];

/// What an eye resolves, minutes of arc: 2 mm from 3 m.
const EYE: f64 = 2.3;

/// Blur of an eye `distance` mm away from what it looks at, mm: a standard deviation.
pub fn eye_blur(distance: f64) -> f64 {
    distance * (EYE / 60.0).to_radians().tan()
}

/// Scores at one blur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtWallBlur {
    /// Standard deviation on the wall, mm.
    pub mm: f64,
    /// Light in the wrong place or lost, as a share of all that falls on the plate.
    pub tv: Figure,
    /// Likeness to the drawing.
    pub ssim: Figure,
}

/// What is said of light on a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallVerdict {
    /// At the eye's blur.
    pub eye: AtWallBlur,
    /// At [`WALL_BLURS`].
    pub at: [AtWallBlur; 2],
    /// Share of the light that lands in the picture's square.
    pub in_picture: Figure,
    /// Share of the light that meets the wall far beside the picture, or not at all.
    pub lost: Figure,
    /// Grain: what an eye sees of the difference and a blur of 0.5° does not, root mean square over the lit part of the
    /// picture, as a share of the drawing's mean there.
    pub grain: Figure,
}

/// Blurs of a score on the wall of `scene`, mm: the eye's first.
pub fn wall_blurs(scene: &Scene, eye_distance: f64) -> [f64; 3] {
    let at = |degrees: f64| scene.wall_distance() * degrees.to_radians().tan();
    [eye_blur(eye_distance), at(WALL_BLURS[0]), at(WALL_BLURS[1])]
}

impl WallVerdict {
    /// Scores light on the wall of `scene` against `target`, the drawing on [`ACROSS`] pixels a side with sum 1.
    ///
    /// `None` if the picture got no light.
    pub fn new(thrown: &Measurement, target: &Raster, scene: &Scene, eye_distance: f64) -> Option<Self> {
        let blurs = wall_blurs(scene, eye_distance);
        let pixel = 2.0 * scene.wall()?.half / ACROSS as f64;
        let wanted = widened(target);
        let wanted = blurs.map(|mm| blurred(&wanted, mm / pixel));
        let of = |tally: &Tally| figures(tally, &wanted, blurs.map(|mm| mm / pixel));
        let (whole, halves) = rayon::join(|| of(&thrown.whole), || thrown.halves().map(|half| of(&half)));
        // Half the difference of two halves is the standard error of the whole, on average.
        let figure = |k: usize| Figure { value: whole[k], error: 0.5 * (halves[0][k] - halves[1][k]).abs() };
        let at = |b: usize| AtWallBlur { mm: blurs[b], tv: figure(2 * b), ssim: figure(2 * b + 1) };
        let lit = whole[6] > 0.0;
        lit.then(|| Self { eye: at(0), at: [at(1), at(2)], in_picture: figure(6), lost: figure(7), grain: figure(8) })
    }
}

/// What counts when two surfaces are compared by their light on a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallScores {
    /// Misplaced light at [`WALL_BLURS`].
    pub tv: [f64; 2],
    /// Likeness to the drawing at the eye's blur.
    pub ssim_eye: f64,
}

impl WallScores {
    /// Scores `image`, shares of the light on the plate on [`WHOLE`] pixels, against `target` on [`ACROSS`] as
    /// [`WallVerdict::new`] does; `None` in a scene without a wall.
    pub fn new(image: &Raster, target: &Raster, scene: &Scene, eye_distance: f64) -> Option<Self> {
        let pixel = 2.0 * scene.wall()?.half / ACROSS as f64;
        let (wanted, own) = (widened(target), image.sum());
        let [eye, fine, main] = wall_blurs(scene, eye_distance).map(|mm| {
            let sigma = mm / pixel;
            scores(&blurred(image, sigma), &blurred(&wanted, sigma), own)
        });
        Some(Self { tv: [fine[0], main[0]], ssim_eye: eye[1] })
    }
}

/// Likeness to the drawing at the eye's blur of light that something else spreads first, by a Gaussian of `spread` mm.
pub fn likeness_once_spread(
    thrown: &Measurement,
    target: &Raster,
    scene: &Scene,
    eye_distance: f64,
    spread: f64,
) -> Option<f64> {
    let (eye, pixel) = (eye_blur(eye_distance), 2.0 * scene.wall()?.half / ACROSS as f64);
    let seen = cropped(&blurred(&thrown.whole.lit_image(), eye.hypot(spread) / pixel));
    let light = seen.sum();
    let wanted = cropped(&blurred(&widened(target), eye / pixel)).normalised();
    (light > 0.0).then(|| structural_similarity(&seen.scaled(1.0 / light), &wanted))
}

/// The drawing in the middle of an image with a dark margin around it.
pub fn widened(target: &Raster) -> Raster {
    let rim = (target.width as f64 * (MARGIN - 1.0) / 2.0).round() as usize;
    Raster::from_fn(target.width + 2 * rim, target.height + 2 * rim, |x, y| {
        let within = (rim..target.width + rim).contains(&x) && (rim..target.height + rim).contains(&y);
        if within { target.at(x - rim, y - rim) } else { 0.0 }
    })
}

/// `image` through a Gaussian of `sigma` pixels.
pub(super) fn blurred(image: &Raster, sigma: f64) -> Raster {
    gaussian(image, (sigma, sigma), 5.0, Edge::Dark)
}

/// Misplaced light and likeness of an image whose blurred light is `seen`, as is `wanted`; `own` is the share of the light on
/// the plate that lands in the image.
fn scores(seen: &Raster, wanted: &Raster, own: f64) -> [f64; 2] {
    let misplaced = 0.5 * (distance(seen, wanted) + (1.0 - own).max(0.0));
    let (inner, drawn) = (cropped(seen), cropped(wanted));
    let light = inner.sum();
    let likeness =
        if light > 0.0 { structural_similarity(&inner.scaled(1.0 / light), &drawn.normalised()) } else { 0.0 };
    [misplaced, likeness]
}

/// Total variation and likeness at each blur; shares in the picture and lost; grain.
fn figures(tally: &Tally, wanted: &[Raster; 3], sigmas: [f64; 3]) -> [f64; 9] {
    let image = tally.lit_image().scaled(tally.up());
    let own = tally.image.sum() / tally.incident;
    let mut values = [0.0; 9];
    let seen: [Raster; 3] = std::array::from_fn(|b| blurred(&image, sigmas[b]));
    for (b, (seen, wanted)) in seen.iter().zip(wanted).enumerate() {
        [values[2 * b], values[2 * b + 1]] = scores(seen, wanted, own);
    }
    values[6] = cropped(&tally.image).sum() / tally.incident;
    values[7] = 1.0 - own;
    values[8] = grain(&seen, wanted);
    values
}

fn grain(seen: &[Raster; 3], wanted: &[Raster; 3]) -> f64 {
    let least = SUPPORT * wanted[0].max();
    let (mut squares, mut light, mut count) = (0.0, 0.0, 0.0);
    for k in (0..WHOLE * WHOLE).filter(|&k| wanted[0].values[k] > least) {
        let difference = |b: usize| seen[b].values[k] - wanted[b].values[k];
        squares += (difference(0) - difference(1)).powi(2);
        light += wanted[0].values[k];
        count += 1.0;
    }
    if light > 0.0 { (squares / count).sqrt() / (light / count) } else { 0.0 }
}
