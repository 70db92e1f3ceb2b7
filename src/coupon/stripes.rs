//! What a lamp with a straight edge shows of grooves: the part of each that is steeper than what mirrors the edge is bright.

use nalgebra::DMatrix;
use rand::RngExt;

use super::groove::Teeth;
use crate::cutter::Profile;
use crate::milling::random::{normal, stream};

/// Distance of camera and lamp's edge from the piece that the setup sheet asks for, mm.
pub const DISTANCE: f64 = 300.0;

/// From the lens's opening: slopes over which bright turns to dark, half of them on either side.
pub const SOFT: f64 = 0.004;

/// Slopes up to which a groove's share is known, and their number.
const STEEPEST: f64 = 0.16;
pub const SLOPES: usize = 160;

/// Places along a pass at which grooves are simulated, and places from the middle outward.
const DRAWS: usize = 400;
const PLACES: usize = 60;

/// How fast the slope that mirrors the lamp's edge changes across the piece, 1/mm: lamp and camera are near.
pub fn per_mm() -> f64 {
    0.5 * (1.0 / DISTANCE + 1.0 / DISTANCE)
}

/// For each slope, from 0 to [`STEEPEST`], the mean length on one side of a groove's middle, mm, over which the surface is no
/// steeper; `half` is how far it is looked at.
pub fn gentle(profile: &Profile, teeth: Teeth, half: f64) -> Vec<f64> {
    let worn = profile.underside(teeth.flat);
    let reach = profile.radius_at(worn + 8.0 * teeth.scatter) + teeth.feed;
    let ahead = if teeth.feed > 0.0 { (reach / teeth.feed).ceil().min(100.0) as i64 } else { 0 };
    let mut counts = vec![0.0; SLOPES];
    for draw in 0..DRAWS {
        let mut random = stream(0x57e9, draw as u64);
        let phase: f64 = random.random::<f64>() - 0.5;
        let own: Vec<(f64, f64)> = (0..=2 * ahead)
            .map(|k| if k % 2 == 0 { k / 2 } else { -(k + 1) / 2 })
            .map(|tooth| ((tooth as f64 + phase) * teeth.feed, teeth.scatter * normal(&mut random)))
            .collect();
        for k in 0..PLACES {
            let u = half * (k as f64 + 0.5) / PLACES as f64;
            let height = |(along, own): &(f64, f64)| own + (profile.underside(along.hypot(u)) - worn).max(0.0);
            let lowest = own.iter().min_by(|a, b| height(a).total_cmp(&height(b)));
            let r = lowest.map_or(u, |tooth| tooth.0.hypot(u));
            let slope = if r <= teeth.flat { 0.0 } else { profile.rise(r) * u / r };
            let first = (slope / STEEPEST * (SLOPES - 1) as f64).ceil() as usize;
            counts.iter_mut().skip(first).for_each(|count| *count += 1.0);
        }
    }
    counts.iter().map(|count| count * half / (PLACES * DRAWS) as f64).collect()
}

/// A table over slopes from 0 to [`STEEPEST`], of an odd function, around `slope` as the lens's opening sees it.
pub fn odd(table: &[f64], slope: f64) -> f64 {
    let at = |slope: f64| {
        let k = (slope.abs() / STEEPEST * (SLOPES - 1) as f64).min((SLOPES - 1) as f64);
        let before = (k as usize).min(SLOPES - 2);
        let value = table[before] + (k - before as f64) * (table[before + 1] - table[before]);
        value * slope.signum()
    };
    const PARTS: usize = 8;
    let part = |k: usize| at(slope + SOFT * ((k as f64 + 0.5) / PARTS as f64 - 0.5));
    (0..PARTS).map(part).sum::<f64>() / PARTS as f64
}

/// Share of grooves `apart` mm, polished by `sigma` mm, that is steeper than each of `slopes`; passes scatter by `scatter` mm.
pub fn steeper(profile: &Profile, apart: f64, (sigma, scatter): (f64, f64), slopes: &[f64]) -> Vec<f64> {
    // One groove as a sum of waves, each faded by the polish.
    const WAVES: usize = 12;
    const SAMPLES: usize = 64;
    let turn = |wave: usize, k: usize| std::f64::consts::TAU * (wave * k) as f64 / SAMPLES as f64;
    let height = |k: usize| {
        let u = apart * (k as f64 / SAMPLES as f64);
        profile.underside(u.min(apart - u))
    };
    let parts = DMatrix::from_fn(WAVES, 1, |wave, _| {
        let wave = wave + 1;
        let sum: f64 = (0..SAMPLES).map(|k| height(k) * turn(wave, k).cos()).sum();
        let steep = std::f64::consts::TAU * wave as f64 / apart;
        2.0 * sum / SAMPLES as f64 * steep * (-0.5 * (steep * sigma).powi(2)).exp()
    });
    let own: Vec<f64> =
        (0..SAMPLES).map(|k| -(0..WAVES).map(|wave| parts[wave] * turn(wave + 1, k).sin()).sum::<f64>()).collect();
    // White heights of passes, smoothed, and the lamp's soft edge.
    let spread = scatter * (apart / (4.0 * std::f64::consts::PI.sqrt() * sigma.powi(3))).sqrt();
    let spread = spread.hypot(SOFT / 12f64.sqrt());
    let share = |slope: &f64| {
        own.iter().map(|own| 0.5 * libm::erfc((slope - own) / (spread * std::f64::consts::SQRT_2))).sum::<f64>()
            / SAMPLES as f64
    };
    slopes.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::Cutter;

    #[test]
    fn a_flat_tip_makes_a_level_strip_of_its_width_and_a_polish_takes_slopes_away() {
        let profile = Cutter::ball(0.5).profile();
        let teeth = Teeth { feed: 1e-4, scatter: 0.0, flat: 0.01 };
        let table = gentle(&profile, teeth, 0.05);
        assert!((table[0] - 0.01).abs() < 1e-3, "{}", table[0]);
        // Slope 0.1 lies 25 µm from the middle.
        assert!((odd(&table, 0.1) - 0.0249).abs() < 1e-3 && (odd(&table, -0.1) + 0.0249).abs() < 1e-3);
        let share = |sigma: f64| steeper(&profile, 0.14, (sigma, 0.0), &[0.05])[0];
        assert!(share(0.005) > 0.25 && share(0.03) < share(0.02) && share(0.06) < 0.01);
        // Slopes of a bare groove are spread evenly up to 0.28: 0.41 of them are steeper than 0.05.
        assert!((share(1e-3) - 0.41).abs() < 0.02, "{}", share(1e-3));
    }
}
