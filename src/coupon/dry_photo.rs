//! Photographs of a piece that was made: the part of each groove that mirrors the lamp, seen by a camera that stands askew.

use glam::DVec2;
use rayon::prelude::*;

use super::dry_run::Piece;
use super::layout::{Coupon, Place};
use super::lines::wide;
use super::stripes::{SOFT, per_mm};
use crate::export::pixels::{byte, srgb_encoded};
use crate::milling::polish::taps;
use crate::milling::random::{normal, stream};
use crate::picture::srgb;
use crate::raster::Raster;

/// How far beside the middle of a field the piece is followed as it was made, mm; elsewhere it is as it is meant.
const ASIDE: f64 = 0.3;

/// Places of the surface along and across, mm: across so fine that edges of stripes lie where they should to a tenth of what
/// scatter moves them, and keeping no step with passes.
const ALONG: f64 = 0.02;
const ACROSS: f64 = 0.00087;

/// Samples of a pixel along and across.
const SAMPLES: [usize; 2] = [2, 6];

/// Brightness of what does not mirror the lamp, and of the ground.
const DARK: f64 = 0.08;
const GROUND: f64 = 0.01;

/// How far a lamp is off being even over the piece.
const UNEVEN: f64 = 0.2;

/// A camera and where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Of a pixel, mm on the piece.
    pub pixel: f64,
    /// Standard deviation of the lens's blur, pixels.
    pub blur: f64,
    /// Noise of a bright pixel, as a share of it.
    pub noise: f64,
    /// By how much the far side of the piece looks smaller, and by what angle it is turned, radians.
    pub askew: [f64; 2],
    /// Slope that mirrors the lamp's edge in the middle of the passes far apart.
    pub edge: f64,
    /// Of the noise.
    pub seed: u64,
}

/// Slopes across the passes around a field.
struct Strip {
    from: f64,
    columns: usize,
    slopes: Vec<f32>,
}

/// What `camera` takes of `piece`: 8-bit numbers of an sRGB picture, row by row, with width and height.
pub fn taken(coupon: &Coupon, piece: &Piece, camera: &Camera) -> (Vec<u8>, [usize; 2]) {
    let size = coupon.size();
    let strips: Vec<Strip> = coupon
        .lines()
        .iter()
        .filter(|line| !matches!(line.1, Place::Up | Place::Down))
        .map(|(x, place)| strip(piece, *x, *place, size.y))
        .collect();
    let rim = 3.0;
    let pixels = (size + 2.0 * rim) / camera.pixel;
    let [width, height] = [pixels.x as usize, pixels.y as usize];
    let tracks = wide(coupon);
    let middle = 0.5 * (tracks[0].y + tracks[tracks.len() - 1].y);
    let all: Vec<f64> = coupon.tracks().iter().map(|track| track.y).collect();
    let radius = coupon.cutter.valley_radius();
    let slope = |at: DVec2| {
        let strip = strips.iter().find(|strip| at.x >= strip.from && at.x < strip.from + ALONG * strip.columns as f64);
        if let Some(strip) = strip {
            let [i, j] = [((at.x - strip.from) / ALONG) as usize, (at.y / ACROSS) as usize];
            let known = strip.slopes.get(j * strip.columns + i.min(strip.columns - 1));
            return known.map_or(0.0, |slope| f64::from(*slope));
        }
        let after = all.partition_point(|track| *track < at.y);
        let near = [after.saturating_sub(1), after.min(all.len() - 1)].map(|k| at.y - all[k]);
        (if near[0].abs() < near[1].abs() { near[0] } else { near[1] }) / radius
    };
    let light = |at: DVec2| {
        if at.cmplt(DVec2::ZERO).any() || at.cmpgt(size).any() {
            return GROUND;
        }
        let edge = camera.edge + per_mm() * (at.y - middle);
        let bright = ((slope(at) - edge) / SOFT + 0.5).clamp(0.0, 1.0);
        let share = at / size - 0.5;
        (DARK + (1.0 - DARK) * bright) * (1.0 + UNEVEN * (share.x - 1.4 * share.y + share.x * share.y))
    };
    // From a pixel to the piece: turned, and nearer at the bottom.
    let [shrunk, turn] = camera.askew;
    let place = |pixel: DVec2| {
        let from = DVec2::from_angle(turn).rotate((pixel - 0.5 * pixels) * DVec2::new(1.0, -1.0) * camera.pixel);
        from / (1.0 - shrunk * from.y / size.y) + 0.5 * size
    };
    let all_samples = SAMPLES[0] * SAMPLES[1];
    let row = |k: usize| -> Vec<f64> {
        let sample = |i: usize, s: usize| {
            let [along, across] = SAMPLES;
            let [a, b] = [(s % along, along), (s / along, across)].map(|(n, of)| (n as f64 + 0.5) / of as f64);
            light(place(DVec2::new(i as f64 + a, k as f64 + b)))
        };
        (0..width).map(|i| (0..all_samples).map(|s| sample(i, s)).sum::<f64>() / all_samples as f64).collect()
    };
    let rows: Vec<Vec<f64>> = (0..height).into_par_iter().map(row).collect();
    (developed(&rows, camera), [width, height])
}

/// Blurred by the lens, with noise, as numbers of a picture.
fn developed(rows: &[Vec<f64>], camera: &Camera) -> Vec<u8> {
    let taps = taps(camera.blur.max(0.3));
    let blurred = |line: &dyn Fn(usize) -> f64, count: usize, k: usize| {
        let at = |k: isize| line(k.clamp(0, count as isize - 1) as usize);
        let k = k as isize;
        taps.iter().enumerate().fold(0.0, |sum, (j, tap)| {
            let j = j as isize;
            sum + if j == 0 { tap * at(k) } else { tap * (at(k - j) + at(k + j)) }
        })
    };
    let width = rows[0].len();
    let across: Vec<Vec<f64>> =
        rows.par_iter().map(|row| (0..width).map(|i| blurred(&|k| row[k], width, i)).collect()).collect();
    let numbers = |j: usize| -> Vec<u8> {
        let mut random = stream(camera.seed, j as u64);
        (0..width)
            .map(|i| {
                let light = 0.75 * blurred(&|k| across[k][i], across.len(), j);
                let seen = light + camera.noise * light.max(0.0).sqrt() * normal(&mut random);
                byte(srgb_encoded(seen))
            })
            .collect()
    };
    (0..rows.len()).into_par_iter().flat_map_iter(numbers).collect()
}

/// The numbers of a picture as linear light.
pub fn linear(numbers: &[u8], [width, height]: [usize; 2]) -> Raster {
    Raster::from_fn(width, height, |column, row| srgb(f64::from(numbers[row * width + column]) / 255.0))
}

fn strip(piece: &Piece, x: f64, place: Place, size: f64) -> Strip {
    let (from, columns) = (x - ASIDE, (2.0 * ASIDE / ALONG).round() as usize);
    let rows = (size / ACROSS) as usize;
    // What is polished is the same all along its field.
    let own = if place == Place::Polished { 1 } else { columns };
    let lines: Vec<Vec<f64>> = (0..own)
        .into_par_iter()
        .map(|i| piece.heights(from + ALONG * (i as f64 + 0.5), [0.0, ACROSS], rows + 1))
        .collect();
    let slope = |k: usize| {
        let line = &lines[(k % columns).min(own - 1)];
        ((line[k / columns + 1] - line[k / columns]) / ACROSS) as f32
    };
    Strip { from, columns, slopes: (0..rows * columns).map(slope).collect() }
}
