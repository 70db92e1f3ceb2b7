//! What a plate made for one scene throws elsewhere: on a wall nearer or farther, under the sun, from one cell alone.
//!
//! Each planar piece of the relief sends what it gets to one place, whatever stands in the way: shadows and further
//! bounces are left to [`thrown`](super::thrown).

use glam::{DVec2, DVec3};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::score::distance;
use super::tally::PARTS;
use super::thrown::{ACROSS, MARGIN, plate_origin};
use super::wall_verdict::{WALL_BLURS, WallScores, blurred, widened};
use crate::lamp::{DistantLamp, Lamp};
use crate::progress::Progress;
use crate::projection::View;
use crate::raster::Raster;
use crate::scene::{Scene, Screen};
use crate::slope::mirror;
use crate::trace::Surface;
use crate::trace::traced_plate::Task;

/// Pixels across the picture: a blur of 0.5° is three of them in a field of 20°.
const SIDE: usize = 256;

/// Misplaced light at a blur of 0.5° that is still in focus; where the best is worse, 1.5 times that.
const IN_FOCUS: f64 = 0.01;
const OF_BEST: f64 = 1.5;

/// How near and how far, beside the wall of the scene, a wall is looked for that is out of focus.
const NEAREST: f64 = 0.05;
const FARTHEST: f64 = 20.0;

/// Halvings of the stretch in which focus is lost, each a trial: it is then known to a sixteenth of its first half.
const HALVINGS: u32 = 5;

/// Angular radius of the sun, degrees.
const SUN: f64 = 0.2665;

/// Asks what a plate throws elsewhere.
#[derive(Clone, Copy)]
pub struct Elsewhere<'a> {
    /// What it was made for.
    pub scene: &'a Scene,
    /// The drawing, sum 1.
    pub target: &'a Raster,
    /// Cells along x and y, whose windows are looked at.
    pub cells: [usize; 2],
    /// Who listens.
    pub progress: &'a Progress<'a>,
}

/// What it throws there. Misplaced light is at a blur of 0.5°.
#[derive(Clone, Debug, PartialEq)]
pub struct ThrownElsewhere {
    /// Nearest and farthest wall in focus, the lamp where it is, mm; `None` where none was found that is not.
    pub focus: [Option<f64>; 2],
    /// Misplaced light up to which it is in focus.
    pub in_focus: f64,
    /// Distance of the wall that is sharp under the sun, mm, and misplaced light there.
    pub sun: (f64, f64),
    /// Misplaced light of each cell alone, rows from y = 0.
    pub windows: Vec<f64>,
}

impl Task for Elsewhere<'_> {
    type Output = Option<ThrownElsewhere>;

    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let wall = *self.scene.wall()?;
        if surface.facets() == 0 {
            return None;
        }
        let wanted = widened(&self.target.resampled(SIDE, SIDE));
        let over = Over { surface, origin: plate_origin(surface), wanted: &wanted, progress: self.progress };
        let moved = |t: f64| self.scene.with_wall(wall.moved(t));
        let at = |t: f64| over.misplaced(&moved(t), None);
        let best = at(1.0)?;
        let in_focus = IN_FOCUS.max(OF_BEST * best);
        let distance = self.scene.wall_distance();
        let nearest = out_of_focus(&at, in_focus, -1.0)?.map(|t| t * distance);
        let farthest = out_of_focus(&at, in_focus, 1.0)?.map(|t| t * distance);

        let focal = self.scene.focal_length();
        let middle = self.scene.light(DVec3::ZERO).direction;
        let sun = Lamp::from(DistantLamp::round(middle, SUN.to_radians()));
        let sunny = Scene::new(sun, Screen::Wall(wall.moved(focal / distance)));
        let sun = (focal, over.misplaced(&sunny, None)?);

        let (low, high) = surface.optical_area();
        let [columns, rows] = self.cells;
        let cell = (high - low) / DVec2::new(columns as f64, rows as f64);
        let windows = (0..columns * rows).map(|k| {
            let corner = low + cell * DVec2::new((k % columns) as f64, (k / columns) as f64);
            over.misplaced(self.scene, Some((corner, corner + cell)))
        });
        let windows = windows.collect::<Option<_>>()?;
        Some(ThrownElsewhere { focus: [nearest, farthest], in_focus, sun, windows })
    }
}

/// The wall, as a multiple of the scene's distance, nearer (`way` -1) or farther (1) at which more than `limit` is
/// misplaced; inner `None` if there is none within reach, outer if nothing could be sent.
fn out_of_focus(at: &impl Fn(f64) -> Option<f64>, limit: f64, way: f64) -> Option<Option<f64>> {
    let mut sharp = (1.0f64, at(1.0)?);
    for k in 1.. {
        // Strides that double: 10 %, 21 %, 46 %, …
        let stretch = 1.1f64.powi(1 << (k.min(8) - 1));
        let t = if way < 0.0 { 1.0 / stretch } else { stretch };
        if !(NEAREST..=FARTHEST).contains(&t) {
            break;
        }
        let tv = at(t)?;
        if tv <= limit {
            sharp = (t, tv);
            continue;
        }
        let mut blurred = (t, tv);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (sharp.0 + blurred.0);
            let tv = at(middle)?;
            *(if tv <= limit { &mut sharp } else { &mut blurred }) = (middle, tv);
        }
        let share = (limit - sharp.1) / (blurred.1 - sharp.1);
        return Some(Some(sharp.0 + share * (blurred.0 - sharp.0)));
    }
    Some(None)
}

/// A surface, lit again and again.
struct Over<'a, S> {
    surface: &'a S,
    origin: DVec3,
    wanted: &'a Raster,
    progress: &'a Progress<'a>,
}

impl<S: Surface> Over<'_, S> {
    /// Misplaced light at a blur of 0.5° in a scene, of what lies `within` two corners; `None` if nothing is lit, or
    /// abandoned.
    fn misplaced(&self, scene: &Scene, within: Option<(DVec2, DVec2)>) -> Option<f64> {
        let image = self.image(SIDE, scene, within)?;
        Some(0.5 * (apart(scene, &image, self.wanted)? + 1.0 - image.sum()))
    }

    /// The light itself on `across` pixels across the picture, as shares of what is lit.
    fn image(&self, across: usize, scene: &Scene, within: Option<(DVec2, DVec2)>) -> Option<Raster> {
        let (facets, side) = (self.surface.facets(), (MARGIN * across as f64) as usize);
        let part = |part: usize| {
            let mut image = Raster::zeros(side, side);
            let mut incident = 0.0;
            let mut random = Xoshiro256PlusPlus::seed_from_u64(part as u64);
            for k in part * facets / PARTS..(part + 1) * facets / PARTS {
                if k % 4096 == 0 && self.progress.is_abandoned() {
                    break;
                }
                let Some((place, footprint)) = self.surface.facet(k).filter(|(_, footprint)| *footprint > 0.0) else {
                    continue;
                };
                let point = self.surface.point_on(k, [1.0 / 3.0; 2]);
                let at = point.truncate();
                if within.is_some_and(|(low, high)| !(at.cmpge(low) & at.cmplt(high)).all()) {
                    continue;
                }
                let (here, normal) = (point - self.origin, self.surface.normal(place));
                let light = scene.light(here);
                let l = light.sample(&mut random);
                let weight = footprint * light.irradiance * (l.dot(normal) / normal.z).max(0.0);
                incident += weight;
                let uv = scene.image_of(here, mirror(l, normal));
                if let Some((x, y)) = uv.and_then(|uv| View::pixel_at(uv / MARGIN, side, side)) {
                    image.values[y * side + x] += weight;
                }
            }
            (image, incident)
        };
        let parts: Vec<(Raster, f64)> = (0..PARTS).into_par_iter().map(part).collect();
        let incident: f64 = parts.iter().map(|(_, incident)| incident).sum();
        let mut image = Raster::zeros(side, side);
        for (part, _) in &parts {
            image.values.iter_mut().zip(&part.values).for_each(|(sum, v)| *sum += v);
        }
        let lit = incident > 0.0 && !self.progress.is_abandoned();
        lit.then(|| image.scaled(1.0 / incident))
    }
}

/// Sum of the differences of two images of a scene at a blur of 0.5°.
fn apart(scene: &Scene, a: &Raster, b: &Raster) -> Option<f64> {
    let blur = scene.wall_distance() * WALL_BLURS[0].to_radians().tan();
    let sigma = blur / (2.0 * scene.wall()?.half) * SIDE as f64;
    Some(distance(&blurred(a, sigma), &blurred(b, sigma)))
}

/// The figures of a surface's light on the wall of `scene`, piece by piece, against a drawing on [`ACROSS`] pixels that is looked
/// at from so many mm away; `None` if nothing is lit, or abandoned.
pub fn scored_directly<S: Surface>(
    surface: &S,
    scene: &Scene,
    (target, eye_distance): (&Raster, f64),
    progress: &Progress,
) -> Option<WallScores> {
    let over = Over { surface, origin: plate_origin(surface), wanted: target, progress };
    WallScores::new(&over.image(ACROSS, scene, None)?, target, scene, eye_distance)
}

/// By how much light on the wall of `scene` changes from one surface to others of the same size, as total variation at a
/// blur of 0.5°; `None` if one of them is not lit, or abandoned.
pub fn change<'a, S: Surface>(
    scene: &'a Scene,
    from: &S,
    progress: &'a Progress<'a>,
) -> Option<impl Fn(&S) -> Option<f64> + use<'a, S>> {
    let thrown = move |surface: &S| {
        let nothing = Raster::zeros(1, 1);
        Over { surface, origin: plate_origin(surface), wanted: &nothing, progress }.image(SIDE, scene, None)
    };
    let before = thrown(from)?;
    Some(move |surface: &S| Some(0.5 * apart(scene, &before, &thrown(surface)?)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_focus_are_found_on_either_side_or_not_at_all() {
        let blur = |t: f64| Some(0.002 + 0.05 * (1.0 / t - 1.0).abs());
        let (near, far) = (1.0 / 1.16, 1.0 / 0.84);
        assert!((out_of_focus(&blur, 0.01, -1.0).unwrap().unwrap() / near - 1.0).abs() < 1e-3);
        assert!((out_of_focus(&blur, 0.01, 1.0).unwrap().unwrap() / far - 1.0).abs() < 1e-3);
        // A wall as far as one likes is sharp.
        let endless = |t: f64| Some(0.01 * (1.0 / t - 1.0).abs());
        assert_eq!(out_of_focus(&endless, 0.01, 1.0), Some(None));
        assert_eq!(out_of_focus(&|_| None, 0.01, 1.0), None);
    }
}
