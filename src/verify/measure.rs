//! Light over a surface, collected as a highlight image: rays, mirror bounces, and where they end.
//!
//! The accounting is that of the independent referee. Rays come in on a jittered grid above the plate; a ray is
//! incident if the first thing that it meets is relief or an inner wall inside the optical area. Every share is a
//! share of incident flux.

use glam::{DVec2, DVec3};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use crate::progress::Progress;
use crate::projection::{View, carried_axes};
use crate::raster::Raster;
use crate::setup::Setup;
use crate::slope::mirror;
use crate::trace::{Hit, Kind, Surface};

/// How finely light is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measuring {
    /// Rays sent, about.
    pub rays: u64,
    /// Pixels a side of the image.
    pub resolution: usize,
    /// Mirror bounces followed; light that wants more is counted as trapped.
    pub max_bounces: u32,
    /// Seed of the rays' jitter.
    pub seed: u64,
}

impl Default for Measuring {
    fn default() -> Self {
        Self { rays: 2_000_000, resolution: 256, max_bounces: 8, seed: 1 }
    }
}

/// Where light went, in rays weighted by the cosine of the light's own extent.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    /// Light that came in.
    pub incident: f64,
    /// Rays that came in.
    pub rays: u64,
    /// Left upward after one bounce.
    pub up_single: f64,
    /// Left upward after more than one.
    pub up_multi: f64,
    /// Of what left upward, beyond the image.
    pub outside_image: f64,
    /// Left downward past the plate's edge.
    pub escaped_down: f64,
    /// Met the plate's outer sides after a bounce.
    pub absorbed: f64,
    /// Still bouncing after the last bounce followed.
    pub trapped: f64,
    /// Met a face from behind: the mesh leaks or is turned inside out.
    pub backface: f64,
    /// Of what came in, met a wall first.
    pub first_hit_wall: f64,
    /// What left upward, by pixel of the image.
    pub image: Raster,
}

impl Tally {
    fn empty(resolution: usize) -> Self {
        Self {
            incident: 0.0,
            rays: 0,
            up_single: 0.0,
            up_multi: 0.0,
            outside_image: 0.0,
            escaped_down: 0.0,
            absorbed: 0.0,
            trapped: 0.0,
            backface: 0.0,
            first_hit_wall: 0.0,
            image: Raster::zeros(resolution, resolution),
        }
    }

    fn add(&mut self, other: &Self, factor: f64) {
        self.incident += factor * other.incident;
        self.rays = self.rays.wrapping_add_signed(factor as i64 * other.rays as i64);
        self.up_single += factor * other.up_single;
        self.up_multi += factor * other.up_multi;
        self.outside_image += factor * other.outside_image;
        self.escaped_down += factor * other.escaped_down;
        self.absorbed += factor * other.absorbed;
        self.trapped += factor * other.trapped;
        self.backface += factor * other.backface;
        self.first_hit_wall += factor * other.first_hit_wall;
        for (sum, v) in self.image.values.iter_mut().zip(&other.image.values) {
            *sum += factor * v;
        }
    }

    /// Share of incident light that leaves upward.
    pub fn up(&self) -> f64 {
        (self.up_single + self.up_multi) / self.incident
    }

    /// Share of upward light that bounced more than once.
    pub fn multi_bounce(&self) -> f64 {
        self.up_multi / (self.up_single + self.up_multi).max(f64::MIN_POSITIVE)
    }

    /// Share of incident light that does not leave upward.
    pub fn blocked(&self) -> f64 {
        1.0 - self.up()
    }

    /// All ends of light as a share of what came in: 1 unless the accounting leaks.
    pub fn balance(&self) -> f64 {
        let ends = self.escaped_down + self.absorbed + self.trapped + self.backface;
        self.up() + ends / self.incident
    }

    /// The image as shares of upward light: with light outside it, the pixels sum to less than 1.
    pub fn share_image(&self) -> Raster {
        let up = (self.up_single + self.up_multi).max(f64::MIN_POSITIVE);
        self.image.clone().scaled(1.0 / up)
    }
}

/// A measurement in parts, so that every figure drawn from it has an error.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// All light.
    pub whole: Tally,
    parts: Vec<Tally>,
}

/// Parts of a measurement. Part k takes rows k, k + PARTS, … of the grid of rays.
const PARTS: usize = 16;

impl Measurement {
    /// The whole without part `k`, for k below [`parts`](Self::parts).
    pub fn without(&self, k: usize) -> Tally {
        let mut rest = self.whole.clone();
        rest.add(&self.parts[k], -1.0);
        rest
    }

    /// The light of the even and of the odd parts.
    pub fn halves(&self) -> [Tally; 2] {
        [0, 1].map(|first| {
            let mut half = Tally::empty(self.whole.image.width);
            self.parts.iter().skip(first).step_by(2).for_each(|part| half.add(part, 1.0));
            half
        })
    }

    /// Parts that can be left out.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Standard error of each figure of `figures`, by leaving out one part after the other (Quenouille, Tukey).
    /// The parts interleave as strata of the whole do, so the estimate errs on the safe side.
    pub fn standard_errors<const N: usize>(&self, figures: impl Fn(&Tally) -> [f64; N] + Sync) -> [f64; N] {
        let n = self.parts();
        let each: Vec<[f64; N]> = (0..n).into_par_iter().map(|k| figures(&self.without(k))).collect();
        std::array::from_fn(|f| {
            let mean = each.iter().map(|e| e[f]).sum::<f64>() / n as f64;
            let squares: f64 = each.iter().map(|e| (e[f] - mean).powi(2)).sum();
            (squares * (n - 1) as f64 / n as f64).sqrt()
        })
    }
}

/// Sends light over `surface` and collects it; the same for any number of threads.
///
/// `None` if no ray met the optical area, or the work was cancelled.
pub fn measure<S: Surface>(
    surface: &S,
    setup: &Setup,
    measuring: &Measuring,
    progress: &Progress,
) -> Option<Measurement> {
    let grid = RayGrid::new(surface, setup, measuring.rays);
    let parts: Vec<Tally> = (0..PARTS)
        .into_par_iter()
        .map(|part| {
            let mut tally = Tally::empty(measuring.resolution);
            for row in (part..grid.rows).step_by(PARTS) {
                if progress.is_cancelled() {
                    break;
                }
                // One stream a row: neither threads nor the number of parts touch the bytes.
                let stream = measuring.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ row as u64;
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(stream);
                for column in 0..grid.columns {
                    let (origin, direction, weight) = grid.ray(column, row, &mut rng);
                    follow(surface, setup, measuring.max_bounces, origin, direction, weight, &mut tally);
                }
                if part == 0 {
                    progress.fraction(row as f64 / grid.rows as f64);
                }
            }
            tally
        })
        .collect();
    let mut whole = Tally::empty(measuring.resolution);
    parts.iter().for_each(|part| whole.add(part, 1.0));
    (whole.incident > 0.0 && !progress.is_cancelled()).then_some(Measurement { whole, parts })
}

/// Start points on a horizontal rectangle through which every ray that can meet the optical area passes.
struct RayGrid {
    low: DVec2,
    size: DVec2,
    z: f64,
    columns: usize,
    rows: usize,
    light: DVec3,
    axes: (DVec3, DVec3),
    radius: f64,
}

impl RayGrid {
    fn new<S: Surface>(surface: &S, setup: &Setup, rays: u64) -> Self {
        let (low, high) = surface.optical_area();
        let (bottom, top) = surface.height_range();
        let lift = 1e-6 * (high - low).length().max(top - bottom);
        let depth = top - bottom + 2.0 * lift;
        let (light, radius) = (setup.light(), setup.light_radius());
        let steepest = (light.z.acos() + radius).min(f64::to_radians(89.9));
        let (low, high) = if radius > 0.0 {
            let reach = DVec2::splat(steepest.tan() * depth);
            (low - reach, high + reach)
        } else {
            let shift = light.truncate() / light.z * depth;
            (low.min(low + shift), high.max(high + shift))
        };
        let size = high - low;
        // Square strata, but on the narrowest of plates at least one row a part.
        let rows = ((rays as f64 * size.y / size.x).sqrt().round() as usize).max(PARTS);
        let columns = ((rays as f64 / rows as f64).round() as usize).max(1);
        Self { low, size, z: top + lift, columns, rows, light, axes: carried_axes(light), radius }
    }

    /// A ray from its own jittered place: origin, direction, weight.
    fn ray(&self, column: usize, row: usize, rng: &mut Xoshiro256PlusPlus) -> (DVec3, DVec3, f64) {
        let mut unit = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let at = DVec2::new((column as f64 + unit()) / self.columns as f64, (row as f64 + unit()) / self.rows as f64);
        let origin = (self.low + self.size * at).extend(self.z);
        if self.radius == 0.0 {
            return (origin, -self.light, 1.0);
        }
        // Uniform over the cap of the disc's solid angle.
        let cosine = 1.0 - unit() * (1.0 - self.radius.cos());
        let (sine, azimuth) = ((1.0 - cosine * cosine).max(0.0).sqrt(), std::f64::consts::TAU * unit());
        let (e1, e2) = self.axes;
        let l = cosine * self.light + sine * (azimuth.cos() * e1 + azimuth.sin() * e2);
        let weight = l.z.max(0.0) / self.light.z;
        (origin, -l.with_z(l.z.max(1e-6)).normalize(), weight)
    }
}

fn follow<S: Surface>(
    surface: &S,
    setup: &Setup,
    max_bounces: u32,
    origin: DVec3,
    mut direction: DVec3,
    weight: f64,
    tally: &mut Tally,
) {
    let (low, high) = surface.optical_area();
    let inside = |hit: &Hit<S::Place>| {
        let at = hit.point.truncate();
        surface.kind(hit.place) != Kind::Outer && (at.cmpge(low) & at.cmple(high)).all()
    };
    let Some(mut hit) = surface.first(origin, direction).filter(inside) else { return };
    tally.incident += weight;
    tally.rays += 1;
    if surface.kind(hit.place) == Kind::Wall {
        tally.first_hit_wall += weight;
    }
    for bounce in 1..=max_bounces + 1 {
        if direction.dot(surface.normal(hit.place)) >= 0.0 {
            tally.backface += weight;
            return;
        }
        if surface.kind(hit.place) == Kind::Outer {
            tally.absorbed += weight;
            return;
        }
        if bounce > max_bounces {
            break;
        }
        direction = mirror(-direction, surface.normal(hit.place));
        match surface.next(&hit, direction) {
            Some(next) => hit = next,
            None if direction.z > 0.0 => {
                let up = if bounce == 1 { &mut tally.up_single } else { &mut tally.up_multi };
                *up += weight;
                let Raster { width, height, .. } = tally.image;
                match setup.image_of(direction).and_then(|uv| View::pixel_at(uv, width, height)) {
                    Some((column, row)) => tally.image.values[row * width + column] += weight,
                    None => tally.outside_image += weight,
                }
                return;
            }
            None => {
                tally.escaped_down += weight;
                return;
            }
        }
    }
    tally.trapped += weight;
}
