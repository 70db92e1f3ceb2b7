//! How a machine follows a relief: play that lags where it turns, and a drive that rounds.

use glam::DVec2;

use crate::milling::machine::Machine;
use crate::relief::periodic::PeriodicRelief;
use crate::sculpt::tool::polished;
use crate::slope::Slope;

/// So much longer than wide is a cell over which a polish acts along one side alone.
const LONG: f64 = 1e9;

/// `cell`, which is right as it is polished, as `machine` follows it on passes along x, or along y; a polish of `sigma` mm smooths
/// what play alters.
pub fn followed(cell: &PeriodicRelief, machine: &Machine, upright: bool, sigma: f64) -> PeriodicRelief {
    let n = cell.nodes;
    let step = cell.step();
    let (rise, step) = if upright { (cell.tilt.q, step.y) } else { (cell.tilt.p, step.x) };
    let place = |line: usize, k: usize| if upright { k * n + line } else { line * n + k };
    let mut lag = vec![0.0f32; n * n];
    for line in 0..n {
        // Once around to be as far behind as the pass before this cell leaves it.
        let mut at = f64::NAN;
        for k in 0..2 * n {
            let z = f64::from(cell.heights[place(line, k % n)]) + rise * step * k as f64;
            let play = 0.5 * machine.backlash_z;
            at = if at.is_nan() { z } else { at.clamp(z - play, z + play) };
            if k >= n {
                lag[place(line, k - n)] = (at - z) as f32;
            }
        }
    }
    let lag = polished(PeriodicRelief { heights: lag, tilt: Slope::FLAT, ..cell.clone() }, positive(sigma));
    let along = if upright { DVec2::new(LONG, 1.0) } else { DVec2::new(1.0, LONG) };
    let rounded = polished(PeriodicRelief { cell: cell.cell * along, ..cell.clone() }, positive(machine.smoothing));
    let heights = rounded.heights.iter().zip(&lag.heights).map(|(z, lag)| z + lag).collect();
    PeriodicRelief { heights, ..cell.clone() }
}

fn positive(mm: f64) -> Option<f64> {
    Some(mm).filter(|mm| *mm > 0.0)
}

/// A cell of the same shape `times` as large.
pub fn scaled(cell: &PeriodicRelief, times: f64) -> PeriodicRelief {
    let heights = cell.heights.iter().map(|z| (f64::from(*z) * times) as f32).collect();
    PeriodicRelief { heights, cell: cell.cell * times, ..cell.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn play_flattens_what_turns_and_nothing_else() {
        let n = 64;
        let wave = |k: usize| (0.1 * (std::f64::consts::TAU * (k % n) as f64 / n as f64).cos()) as f32;
        let cell = PeriodicRelief {
            nodes: n,
            heights: (0..n * n).map(wave).collect(),
            cell: DVec2::splat(10.0),
            cells: [1, 1],
            tilt: Slope::FLAT,
        };
        let still = Machine::ideal();
        assert_eq!(followed(&cell, &still, false, 0.0).heights, cell.heights);
        let loose = Machine { backlash_z: 0.01, ..still };
        let by = |upright: bool| {
            let made = followed(&cell, &loose, upright, 0.0);
            made.heights.iter().zip(&cell.heights).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        assert!((by(false) - 0.005).abs() < 1e-6 && by(true) < 1e-6, "{} {}", by(false), by(true));
        let large = scaled(&cell, 3.0);
        assert!((large.heights[0] - 0.3).abs() < 1e-6 && large.cell == DVec2::splat(30.0));
    }
}
