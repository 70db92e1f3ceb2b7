//! The corners of a bright piece on dark ground.

use glam::DVec2;

use super::lines::straight;
use crate::raster::Raster;

/// Pixels of a photograph that the piece is looked for in, along a side: blocks of others are taken together.
const COARSE: usize = 160;

/// Least share of a photograph that the piece fills.
const LEAST: f64 = 0.08;

/// Places along a side at which its edge is looked for, and pixels on either side of each that are taken together.
const PLACES: usize = 60;
const STRETCH: i64 = 12;

/// The piece begins where brightness is so far above the ground's, as a share of the piece's bright parts: its dark stripes are
/// brighter than that.
const EDGE: f64 = 0.035;

/// The four corners of the piece as pixels: those of (0, 0), (x, 0), (x, y), (0, y), its low y at the bottom.
pub(super) fn corners(photograph: &Raster) -> Option<[DVec2; 4]> {
    let block = photograph.width.div_ceil(COARSE).max(1);
    let (columns, rows) = (photograph.width / block, photograph.height / block);
    let mean = |k: usize| {
        let (i, j) = (k % columns * block, k / columns * block);
        let all = (0..block * block).map(|k| photograph.at(i + k % block, j + k / block));
        all.sum::<f64>() / (block * block) as f64
    };
    let coarse: Vec<f64> = (0..columns * rows).map(mean).collect();
    let mut sorted = coarse.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let [dark, light] = [0.02, 0.9].map(|share| sorted[(share * (sorted.len() - 1) as f64) as usize]);
    let threshold = dark + 0.2 * (light - dark);
    // The largest piece of ground that is bright.
    let mut of = vec![0_u32; coarse.len()];
    let mut best: (usize, u32) = (0, 0);
    let mut name = 0;
    for start in 0..coarse.len() {
        if of[start] != 0 || coarse[start] < threshold {
            continue;
        }
        name += 1;
        let (mut open, mut count) = (vec![start], 0);
        of[start] = name;
        while let Some(k) = open.pop() {
            count += 1;
            let (i, j) = (k % columns, k / columns);
            let beside = [
                (i > 0).then(|| k - 1),
                (i + 1 < columns).then(|| k + 1),
                (j > 0).then(|| k - columns),
                (j + 1 < rows).then(|| k + columns),
            ];
            for next in beside.into_iter().flatten() {
                if of[next] == 0 && coarse[next] >= threshold {
                    of[next] = name;
                    open.push(next);
                }
            }
        }
        best = best.max((count, name));
    }
    if light <= 2.0 * dark || (best.0 as f64) < LEAST * coarse.len() as f64 || best.0 == coarse.len() {
        return None;
    }
    let places: Vec<DVec2> = (0..coarse.len())
        .filter(|k| of[*k] == best.1)
        .map(|k| DVec2::new((k % columns) as f64, (k / columns) as f64))
        .collect();
    // Rows of a picture go down, y of the piece up.
    let farthest = |way: DVec2| {
        let at = places.iter().copied().max_by(|a, b| a.dot(way).total_cmp(&b.dot(way)))?;
        Some((at + 0.5 + 0.5 * way.signum()) * block as f64 - 0.5)
    };
    let ways = [DVec2::new(-1.0, 1.0), DVec2::new(1.0, 1.0), DVec2::new(1.0, -1.0), DVec2::new(-1.0, -1.0)];
    let found: Vec<DVec2> = ways.into_iter().filter_map(farthest).collect();
    let rough: [DVec2; 4] = found.try_into().ok()?;
    let level = dark + EDGE * (light - dark);
    refined(photograph, rough, (level, 2.0 * block as f64))
}

/// The crossings of the four sides' straight lines, each through the outermost places that are brighter than `level` within
/// `reach` pixels of the rough side.
fn refined(photograph: &Raster, rough: [DVec2; 4], (level, reach): (f64, f64)) -> Option<[DVec2; 4]> {
    let middle = 0.25 * rough.iter().sum::<DVec2>();
    let side = |k: usize| {
        let (from, to) = (rough[k], rough[(k + 1) % 4]);
        let along = (to - from).normalize();
        let out = along.perp() * (from - middle).dot(along.perp()).signum();
        let crossing = |n: usize| {
            let at = from.lerp(to, 0.06 + 0.88 * n as f64 / (PLACES - 1) as f64);
            // Brightness along a short stretch of the side, from outside in.
            let brightness = |away: f64| {
                let all = (-STRETCH..=STRETCH).map(|k| {
                    let pixel = at + out * away + along * k as f64;
                    let within = pixel.cmpge(DVec2::ZERO).all()
                        && pixel.x < photograph.width as f64
                        && pixel.y < photograph.height as f64;
                    if within { photograph.at(pixel.x as usize, pixel.y as usize) } else { 0.0 }
                });
                all.sum::<f64>() / (2 * STRETCH + 1) as f64
            };
            let steps = (2.0 * reach) as i64;
            let (mut away, mut before) = (reach, brightness(reach));
            for _ in 0..steps {
                let next = brightness(away - 1.0);
                if next >= level && before < level {
                    let share = (level - before) / (next - before);
                    return Some(at + out * (away - share));
                }
                (away, before) = (away - 1.0, next);
            }
            None
        };
        let points: Vec<[f64; 2]> =
            (0..PLACES).filter_map(crossing).map(|at| [(at - from).dot(along), (at - from).dot(out)]).collect();
        (points.len() > PLACES / 2).then(|| {
            let [level, rise] = straight(&points);
            (from + out * level, along + out * rise)
        })
    };
    let sides: Vec<(DVec2, DVec2)> = (0..4).filter_map(side).collect();
    let cross = |k: usize| {
        let ((a, u), (b, v)) = (*sides.get((k + 3) % 4)?, *sides.get(k)?);
        let turn = u.perp_dot(v);
        (turn.abs() > 0.1).then(|| a + u * ((b - a).perp_dot(v) / turn))
    };
    let corners: Vec<DVec2> = (0..4).filter_map(cross).collect();
    corners.try_into().ok()
}
