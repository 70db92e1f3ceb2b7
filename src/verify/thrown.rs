//! Light of a plate on the wall of a scene: every piece of the relief sends what the lamp gives it, from its own place.
//!
//! Rays start on the relief, some on each of its planar pieces, and are followed to the lamp, to see what shadows them, and
//! onward to the wall through all further bounces. So the light of a million small mirrors is known without the noise of
//! rays that find them by chance; what is random is only where on a piece and on a lamp with an extent a ray stands for
//! the rest. Light that first meets a vertical wall of a relief of facets has no piece to start from: rays of the lamp
//! find it, as they find all light of rough metals and of meshes that stand on no grid.
//!
//! The image is wider than the picture, so that what falls beside it is seen too: see [`MARGIN`].

use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::experiment::{Experiment, Measuring};
use super::first_bounce::scattered;
use super::follow::{Collection, follow_all};
use super::tally::{Measurement, PARTS, Tally};
use crate::brdf::material::Material;
use crate::progress::Progress;
use crate::projection::View;
use crate::raster::Raster;
use crate::scene::Scene;
use crate::setup::Setup;
use crate::trace::path::{End, Fate, PathFollower};
use crate::trace::traced_plate::Task;
use crate::trace::{Hit, PieceKind, Surface};

/// Pixels across the picture.
pub const ACROSS: usize = 512;

/// How many times as wide as the picture the image is.
pub const MARGIN: f64 = 1.5;

/// Pixels across the image.
pub const WHOLE: usize = 768;

/// Rays to a piece of the relief at the least: two, whose difference says how sure the figures are.
const LEAST_RAYS: u64 = 2;

/// Rays over the relief under a lamp with an extent at the least; a disc is then known to a few hundred places a pixel.
const RAYS_OF_EXTENT: u64 = 8_000_000;

/// Sends the light of a scene over a surface and collects it on its wall.
#[derive(Clone, Copy)]
pub struct Throwing<'a> {
    /// Lamp and wall.
    pub scene: &'a Scene,
    /// What the plate is made of.
    pub metal: &'a Material,
    /// How finely; [`WHOLE`] pixels a side whatever it says.
    pub measuring: &'a Measuring,
    /// Only what lies between these corners of the plate is lit, mm.
    pub within: Option<(DVec2, DVec2)>,
    /// Who listens.
    pub progress: &'a Progress<'a>,
}

/// The light on the wall, in two halves of as many rays each: [`WHOLE`] pixels a side around the picture.
impl Task for Throwing<'_> {
    type Output = Option<Measurement>;

    fn on<S: Surface>(self, surface: &S) -> Option<Measurement> {
        let frame = Frame::of(surface, self.scene);
        let listed = self.metal.is_smooth() && surface.facets() > 0;
        let halves = match listed {
            true => self.light_by_pieces(surface, &frame)?,
            false => self.light_of_lamp(surface, &frame, |_| true)?,
        };
        Measurement::of_parts(halves).ok().filter(|_| !self.progress.is_abandoned())
    }
}

/// Where a surface lies in the frame of a scene.
struct Frame<'a> {
    scene: &'a Scene,
    /// The scene's origin in the surface's frame.
    origin: DVec3,
    /// What the lamp gives a horizontal mm² at the plate's middle.
    reference: f64,
}

impl<'a> Frame<'a> {
    fn of<S: Surface>(surface: &S, scene: &'a Scene) -> Self {
        let origin = plate_origin(surface);
        let light = scene.light(DVec3::ZERO);
        Self { scene, origin, reference: light.irradiance * light.direction.z }
    }

    /// The pixel of light that leaves a point of the surface, and whether it meets the wall at all.
    fn pixel(&self, point: DVec3, direction: DVec3) -> (Option<usize>, bool) {
        let Some(uv) = self.scene.image_of(point - self.origin, direction) else { return (None, false) };
        let pixel = View::pixel_at(uv / MARGIN, WHOLE, WHOLE).map(|(x, y)| y * WHOLE + x);
        (pixel, true)
    }

    /// Says which pixel the end of a path lights, and takes back that it left upward if it meets no wall.
    fn land(&self, end: &mut End) -> Option<usize> {
        if !matches!(end.fate, Fate::Up | Fate::Down) {
            return None;
        }
        let (pixel, met) = self.pixel(end.point, end.direction);
        end.fate = if met { Fate::Up } else { Fate::Down };
        pixel
    }
}

/// The middle of the optical area at its mean height, mm: the origin of a scene. Of what cannot list its pieces halfway
/// between lowest and highest.
pub fn plate_origin<S: Surface>(surface: &S) -> DVec3 {
    let mut sum = (0.0, 0.0);
    for k in 0..surface.facets() {
        if let Some((_, footprint)) = surface.facet(k).filter(|(_, footprint)| *footprint > 0.0) {
            sum = (sum.0 + footprint, sum.1 + footprint * surface.point_on(k, [1.0 / 3.0; 2]).z);
        }
    }
    let middle = surface.middle();
    if sum.0 > 0.0 { middle.with_z(sum.1 / sum.0) } else { middle }
}

/// The light within the picture alone, on half as many pixels: a highlight image as any other.
pub fn within_picture(thrown: &Measurement) -> Measurement {
    let inner = |image: &Raster| cropped(image).resampled(ACROSS / 2, ACROSS / 2);
    thrown.mapped(|tally| {
        let image = inner(&tally.image);
        let beside = tally.image.sum() - image.sum();
        let rim = tally.rim.as_ref().map(inner);
        Tally { outside_image: tally.outside_image + beside, image, rim, ..tally.clone() }
    })
}

/// The picture's own square of an image with a margin.
pub fn cropped(image: &Raster) -> Raster {
    let side = (image.width as f64 / MARGIN).round() as usize;
    let rim = (image.width - side) / 2;
    Raster::from_fn(side, side, |x, y| image.at(x + rim, y + rim))
}

impl Throwing<'_> {
    fn lights(&self, point: DVec3) -> bool {
        let at = point.truncate();
        self.within.is_none_or(|(low, high)| (at.cmpge(low) & at.cmplt(high)).all())
    }

    /// Rays from every piece of the relief, and rays of the lamp that first meet a vertical wall.
    fn light_by_pieces<S: Surface>(&self, surface: &S, frame: &Frame) -> Option<Vec<Tally>> {
        let facets = surface.facets();
        let wanted = if frame.scene.lamp().is_point() { 0 } else { RAYS_OF_EXTENT };
        let least = wanted.max(self.measuring.rays).div_ceil(facets as u64).max(LEAST_RAYS).next_multiple_of(2);
        // A spot of light is as large as its mirror, times this: wider than a pixel it is several.
        let spread = 1.0 + frame.scene.wall_distance() / frame.scene.lamp_distance();
        let spread = spread / (2.0 * frame.scene.wall().map_or(f64::INFINITY, |wall| wall.half) / ACROSS as f64);
        let part = |part: usize| {
            let mut follower = PathFollower::new(surface, self.metal, self.measuring.max_bounces);
            let mut halves = [Tally::empty((WHOLE, WHOLE)), Tally::empty((WHOLE, WHOLE))];
            for k in part * facets / PARTS..(part + 1) * facets / PARTS {
                if k % 4096 == 0 {
                    if self.progress.is_abandoned() {
                        break;
                    }
                    self.progress.fraction((k - part * facets / PARTS) as f64 / facets as f64 * PARTS as f64);
                }
                let Some((place, footprint)) = surface.facet(k).filter(|(_, footprint)| *footprint > 0.0) else {
                    continue;
                };
                let rays = least.max((4.0 * footprint * spread * spread).min(4096.0) as u64).next_multiple_of(2);
                let seed = self.measuring.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ k as u64;
                let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
                let shift = random.random();
                let normal = surface.normal(place);
                for m in 0..rays {
                    let point = surface.point_on(k, scattered(shift, m));
                    if !self.lights(point) {
                        continue;
                    }
                    let light = frame.scene.light(point - frame.origin);
                    let l = light.sample(&mut random);
                    let intercept = l.dot(normal) / normal.z;
                    if intercept <= 0.0 {
                        continue;
                    }
                    let hit = Hit { point, place };
                    if surface.next(&hit, l).is_some() {
                        continue;
                    }
                    let weight = footprint / rays as f64 * intercept * light.irradiance / frame.reference;
                    let half = &mut halves[m as usize % 2];
                    half.incident += weight;
                    half.rays += 1;
                    let mut end = follower.follow(hit, -l, &mut random);
                    let pixel = frame.land(&mut end);
                    half.count(&end, weight, pixel);
                }
            }
            halves
        };
        let parts: Vec<[Tally; 2]> = (0..PARTS).into_par_iter().map(part).collect();
        let mut halves = vec![Tally::empty((WHOLE, WHOLE)), Tally::empty((WHOLE, WHOLE))];
        for part in &parts {
            halves.iter_mut().zip(part).for_each(|(half, part)| half.add(part, 1.0));
        }
        let walls = self.light_of_lamp(surface, frame, |kind| kind == PieceKind::Wall)?;
        halves.iter_mut().zip(&walls).for_each(|(half, part)| half.add(part, 1.0));
        Some(halves)
    }

    /// Rays of the lamp, those that first meet what is `wanted`.
    fn light_of_lamp<S: Surface>(
        &self,
        surface: &S,
        frame: &Frame,
        wanted: impl Fn(PieceKind) -> bool + Sync,
    ) -> Option<Vec<Tally>> {
        let setup = Setup::from_middle(frame.scene)?;
        let material = self.metal.clone();
        let experiment =
            Experiment { material, ..Experiment::new(surface, &setup) }.in_scene(frame.scene, frame.origin);
        let landing = || |end: &mut End| frame.land(end);
        let collection = Collection { size: (WHOLE, WHOLE), wanted, landing };
        let parts = follow_all(&experiment, self.measuring, &collection, self.progress).ok()?;
        // In the unit of the pieces: what the lamp gives a horizontal mm² at the scene's origin.
        let middle = experiment.lamp.at(surface.middle());
        let unit = middle.direction.z * middle.irradiance / frame.reference;
        let mut halves = vec![Tally::empty((WHOLE, WHOLE)), Tally::empty((WHOLE, WHOLE))];
        parts.iter().enumerate().for_each(|(k, part)| halves[k % 2].add(part, unit));
        Some(halves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lamp::Lamp;
    use crate::relief::faceted::{Facet, FacetedRelief};
    use crate::relief::height_grid::HeightGrid;
    use crate::slope::Slope;
    use crate::trace::grid::GridSurface;

    const LAMP: DVec3 = DVec3::new(0.0, 300.0, 400.0);

    fn thrown<S: Surface>(surface: &S, scene: &Scene, within: Option<(DVec2, DVec2)>) -> Measurement {
        let measuring = Measuring { rays: 50_000, ..Measuring::default() };
        let progress = Progress::silent();
        let throwing = Throwing { scene, metal: &Material::MIRROR, measuring: &measuring, within, progress: &progress };
        throwing.on(surface).unwrap()
    }

    /// Mean and half extent of the light along u and v, mm from the picture's middle.
    fn spot(thrown: &Measurement, half: f64) -> (DVec2, DVec2) {
        let image = &thrown.whole.image;
        let lit = (0..WHOLE * WHOLE).filter(|&k| image.values[k] > 0.0);
        let mut sums = (DVec2::ZERO, 0.0, DVec2::INFINITY, DVec2::NEG_INFINITY);
        for k in lit {
            let at = View::pixel_centre(k % WHOLE, k / WHOLE, WHOLE, WHOLE) * MARGIN * half;
            sums = (sums.0 + image.values[k] * at, sums.1 + image.values[k], sums.2.min(at), sums.3.max(at));
        }
        (sums.0 / sums.1, 0.5 * (sums.3 - sums.2))
    }

    #[test]
    fn a_flat_mirror_throws_its_own_image_twice_as_large_and_a_bowl_a_point() {
        let size = DVec2::new(20.0, 10.0);
        for radius in [0.0, 2.0] {
            let scene = Scene::across_mirror(Lamp::Ball { middle: LAMP, radius }, 500.0, 0.0, 40.0);
            let flat = FacetedRelief::uniform(1, 1, size, vec![Facet { height: 7.0, slope: Slope::FLAT }]);
            let light = thrown(&GridSurface::new(&flat, &Progress::silent()).unwrap(), &scene, None);
            let (middle, half) = spot(&light, 40.0);
            assert!(middle.length() < 0.2, "{middle}");
            // Lamp and wall are as far: twice the plate, foreshortened along y by the slant, and the lamp's own size.
            let expected = size * DVec2::new(1.0, 0.8) + radius;
            assert!((half - expected).abs().max_element() < 0.5, "{half} {expected}");
            assert!((light.whole.image.sum() / light.whole.incident - 1.0).abs() < 1e-9);
            let side = thrown(
                &GridSurface::new(&flat, &Progress::silent()).unwrap(),
                &scene,
                Some((DVec2::ZERO, DVec2::new(10.0, 10.0))),
            );
            assert!((side.whole.incident / light.whole.incident - 0.5).abs() < 0.02);
        }
        // The ellipsoid with foci at lamp and picture, here its osculating paraboloid; 1/f = 1/500 + 1/500.
        let scene = Scene::across_mirror(Lamp::Ball { middle: 500.0 * DVec3::Z, radius: 0.0 }, 500.0, 0.0, 20.0);
        let lines: Vec<f64> = (0..=100).map(|k| 0.2 * f64::from(k)).collect();
        let heights = (0..101 * 101).map(|k| {
            let at = DVec2::new(lines[k % 101], lines[k / 101]) - 10.0;
            at.length_squared() / 1000.0
        });
        let bowl = HeightGrid::new(lines.clone(), lines.clone(), heights.collect(), &Progress::silent()).unwrap();
        let light = thrown(&GridSurface::continuous(&bowl, &Progress::silent()).unwrap(), &scene, None);
        let (middle, half) = spot(&light, 20.0);
        // Each triangle is a flat mirror of 0.2 mm.
        assert!(middle.length() < 0.05 && half.max_element() < 0.5, "{middle} {half}");
    }

    #[test]
    fn rays_from_the_pieces_find_what_rays_of_the_lamp_find() {
        // Steps between facets, which shadow and bounce; one mirror, the other a little rough: traced the other way.
        let facets = (0..16).map(|k| Facet {
            height: f64::from(k * 7 % 5),
            slope: Slope::new(f64::from(k % 4) * 0.02 - 0.03, f64::from(k / 4) * 0.02 - 0.03),
        });
        let relief = FacetedRelief::uniform(4, 4, DVec2::new(20.0, 20.0), facets.collect());
        let surface = GridSurface::new(&relief, &Progress::silent()).unwrap();
        let scene = Scene::across_mirror(Lamp::Ball { middle: LAMP, radius: 3.0 }, 600.0, 0.2, 60.0);
        let measuring = Measuring { rays: 400_000, ..Measuring::default() };
        let progress = Progress::silent();
        let throwing = Throwing {
            scene: &scene,
            metal: &Material::MIRROR,
            measuring: &measuring,
            within: None,
            progress: &progress,
        };
        let pieces = throwing.on(&surface).unwrap().whole;
        let frame = Frame::of(&surface, &scene);
        let lamp = Measurement::of_parts(throwing.light_of_lamp(&surface, &frame, |_| true).unwrap()).unwrap().whole;
        assert!((pieces.incident / lamp.incident - 1.0).abs() < 0.003, "{} {}", pieces.incident, lamp.incident);
        assert!((pieces.multi_bounce() - lamp.multi_bounce()).abs() < 0.003 && pieces.multi_bounce() > 0.01);
        let coarse = |tally: &Tally| tally.image.clone().scaled(1.0 / tally.incident).resampled(24, 24);
        let (a, b) = (coarse(&pieces), coarse(&lamp));
        let apart: f64 = a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs()).sum();
        assert!(apart < 0.02, "{apart}");
    }
}
