//! Arrangement by simulated annealing on a cyclic grid: the method of Weyrich et al. 2009, and one that sees the walls.
//!
//! Facets change places two at a time. An exchange that lowers the energy stays; one that raises it by ΔE stays with
//! probability exp(-ΔE/T), and the temperature T falls. Slopes are dimensionless, lengths in pitches, cells taken as
//! square; on w × h facets, x + 1 and y + 1 meant cyclically, the paper's energies are
//!
//! ```text
//! C = ¼ Σ (q(x+1) - q(x))² + ¼ Σ (p(y+1) - p(y))²          the twist of each edge, which no heights remove
//! I = Σ_rows (Σ_x p)² + Σ_columns (Σ_y q)²                 the climb left over when a row or a column closes
//! V = how often p(x+1) > p(x) or q(y+1) > q(y)             valleys
//! ```
//!
//! Measured on 900 slopes of a spiral of half field 45°, mean slope taken out, cyclic heights by least squares: what
//! is left of A_v and of V in random order (0.17 and 900), means of 4 to 8 seeds:
//!
//! ```text
//! exchanges             0.3 M        1 M          3 M          8 M          30 M         100 M
//! Walls              0.26  0.56   0.21  0.48   0.18  0.41   0.16  0.38   0.14  0.34   0.14  0.31
//! Walls, no valleys  0.21  0.99   0.17  1.00   0.14  0.99   0.13  1.03   0.11  1.00   0.10  0.96
//! Weyrich2009        0.53  0.68   0.52  0.60   0.53  0.51   0.55  0.43   0.44  0.34   0.54  0.33
//! ```
//!
//! One seed of `Walls` is within 0.02 (A_v) and 0.04 (V) of another. A_v of `Weyrich2009` strays by up to 0.2, and
//! more exchanges do not lower it, only V. A mean slope left in costs a wall at every edge of a cyclic plate, whatever
//! the order: with it (0.07 here) `Walls` leaves 0.48 of A_v, where 0.46 is the least possible. 100 × 100 facets need
//! ten times the exchanges for the same result; with the default they come to 0.22 and 0.49.

use std::f64::consts::PI;

use glam::DVec2;
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::facets::SlopeGrid;
use crate::facets::arrange::annealing_grid::{AnnealingGrid, Weights};
use crate::facets::arrange::below;
use crate::facets::heights::least_squares;
use crate::facets::steps::steps;
use crate::progress::Progress;

/// What annealing makes small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Energy {
    /// E = C + W + 0.3 s² V, with W = Σ (step at the middle of the edge)² over all edges, for the heights of
    /// [`least_squares`], and s² the mean squared distance of the slopes from their mean, so that faint and bold
    /// highlights are treated alike.
    ///
    /// C looks from one cell to the next and I at whole rows; slopes that drift slowly over the plate cost little of
    /// either and yet may be the gradient of no surface. W notices at every scale. Heights are held between two
    /// solutions of Poisson's equation, which bounds E from above: an exchange stays local, and solving lowers E.
    #[default]
    Walls,
    /// As printed E = C + V (wh)² + I (w+h)⁴ with V = w_V × number of valleys, w_V = 1/2000; the weights are said to
    /// make C and I approximate the squared area of the vertical walls.
    ///
    /// With the sums above for C and I the printed factors do no such thing: at 30 × 30 one valley costs twenty times
    /// all of C, the closing of rows freezes the rest, and 97% of the walls stay. So this follows the stated meaning.
    /// For normal deviates (Σ|x|)² is about 2/π n Σx², hence the squared area of walls ¼|Δ| from twists alone is about
    /// wh/π C, and that of walls from rows and columns that do not close about (w+h) 2/π I. Beside these stands
    /// w_V (wh)² as printed, times the valleys per facet. All of it times π/wh:
    ///
    /// ```text
    /// E = C + 2 (w+h)/(wh) I + π/2000 V
    /// ```
    ///
    /// That gives the paper's proportions. For its spiral, A_v goes from 0.1782 to 0.0985 (by 0.553) and V from 901 to
    /// 418 (by 0.464); here, at 8 million exchanges, by 0.55 and 0.43. (The A_v of 0.2190 that the paper gives for the
    /// random order agrees with facets all at height zero, here 0.20 to 0.22, and 0.1782 with its heights, here 0.18.)
    Weyrich2009,
}

/// Settings of [`anneal`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Annealing {
    /// What to make small.
    pub energy: Energy,
    /// Exchanges tried in a run, 40 to 80 ns each.
    pub swaps: u64,
    /// Factor on the energy's own weight of a valley, 0 or more; 0 is the paper's variant without valley term.
    pub valleys: f64,
    /// Independent runs, of which the one with the least wall area is kept.
    pub starts: u32,
}

impl Default for Annealing {
    fn default() -> Self {
        Self { energy: Energy::Walls, swaps: 8_000_000, valleys: 1.0, starts: 1 }
    }
}

/// What became of the energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Annealed {
    /// Energy of the order given.
    pub before: f64,
    /// Energy of the order left.
    pub after: f64,
    /// Exchanges tried: fewer than asked for if the work was cancelled.
    pub tried: u64,
    /// Exchanges that stayed.
    pub accepted: u64,
}

/// Share of exchanges that shall stay, at the first and at the last temperature. A hotter start undoes exchanges that it
/// pays for, a colder one keeps the first order it falls into; at one in a thousand an exchange a facet hardly changes
/// the plate. The table above was measured with these.
const ACCEPTANCE: [f64; 2] = [0.3, 0.001];

/// Rearranges `grid` as [`anneal`] does, several times if the settings say so, each time from the order given.
///
/// The 2009 energy does not see the slow drifts of slope that build walls in the end, so its runs differ; the one kept
/// has the least wall area under heights by least squares.
pub(crate) fn anneal_best(grid: &mut SlopeGrid, settings: &Annealing, seed: u64, progress: &Progress<'_>) {
    let start = grid.clone();
    let walls = |grid: &SlopeGrid| {
        let heights = least_squares(grid, DVec2::ONE, true);
        steps(grid, &heights, DVec2::ONE, true).wall_area_ratio
    };
    anneal(grid, settings, seed, progress);
    for run in 1..settings.starts {
        let mut other = start.clone();
        anneal(&mut other, settings, seed.wrapping_add(u64::from(run) << 32), progress);
        if walls(&other) < walls(grid) {
            *grid = other;
        }
    }
}

/// Rearranges `grid`, from the order given, so that its walls become low and its valleys few.
///
/// A temperature lasts for one exchange a facet; then it is moved so that the share of exchanges that stay follows a
/// geometric descent over the whole budget. That needs no scale of energy or size of plate, and no tuning by hand.
/// Only fractions are reported to `progress`. If it is cancelled, the order reached so far is left: the same slopes,
/// less well arranged. Grids of one cell or none are left as they are.
pub fn anneal(grid: &mut SlopeGrid, settings: &Annealing, seed: u64, progress: &Progress<'_>) -> Annealed {
    let mut plate = AnnealingGrid::new(grid, weights(grid, settings));
    let before = plate.energy();
    let mut done = Annealed { before, after: before, tried: 0, accepted: 0 };
    let cells = grid.cells() as u64;
    if cells < 2 {
        return done;
    }
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut temperature = typical_change(&mut plate, &mut random);
    let mut since_settled = 0;
    while done.tried < settings.swaps && !progress.is_to_finish() {
        let share = done.tried as f64 / settings.swaps as f64;
        progress.fraction(share);
        let tried = cells.min(settings.swaps - done.tried);
        let accepted = sweep(&mut plate, tried, temperature, &mut random);
        done.tried += tried;
        done.accepted += accepted;
        since_settled += accepted;
        // Heights are solved anew when an eighth of the facets has moved: until then they only bound the energy.
        if since_settled * 8 >= cells {
            plate.settle();
            since_settled = 0;
        }
        let wanted = ACCEPTANCE[0] * (ACCEPTANCE[1] / ACCEPTANCE[0]).powf(share);
        let got = (accepted as f64 + 0.1) / tried as f64;
        // The tenth root: near the end a sweep sees about one exchange that stays, and its share is mostly noise.
        temperature *= (wanted / got).powf(0.1).clamp(0.8, 1.25);
    }
    plate.settle();
    done.after = plate.energy();
    grid.slopes = plate.slopes();
    done
}

fn weights(grid: &SlopeGrid, settings: &Annealing) -> Weights {
    let (w, h) = (grid.columns as f64, grid.rows as f64);
    let mean = grid.mean().to_vec();
    let spread = grid.slopes.iter().map(|s| s.to_vec().distance_squared(mean)).sum::<f64>() / (w * h).max(1.0);
    match settings.energy {
        Energy::Walls => Weights { twist: 1.0, step: 1.0, closure: 0.0, valley: 0.3 * spread * settings.valleys },
        Energy::Weyrich2009 => {
            Weights { twist: 1.0, step: 0.0, closure: 2.0 * (w + h) / (w * h), valley: PI / 2000.0 * settings.valleys }
        }
    }
}

/// Mean size of ΔE over random exchanges: hot enough to keep most of them.
fn typical_change(plate: &mut AnnealingGrid, random: &mut Xoshiro256PlusPlus) -> f64 {
    const SAMPLES: usize = 1000;
    let n = plate.places();
    let sizes = (0..SAMPLES).map(|_| plate.change(below(random.next_u64(), n), below(random.next_u64(), n)).abs());
    sizes.sum::<f64>() / SAMPLES as f64
}

/// Tries `swaps` exchanges at one temperature; how many stayed.
fn sweep(plate: &mut AnnealingGrid, swaps: u64, temperature: f64, random: &mut Xoshiro256PlusPlus) -> u64 {
    let n = plate.places();
    let mut accepted = 0;
    for _ in 0..swaps {
        // Two cells from the halves of one number, each uneven by less than n in 2^32.
        let bits = random.next_u64();
        let (a, b) = (below(bits, n), below(bits << 32, n));
        let change = plate.change(a, b) / temperature;
        if change <= 0.0 || (change < 40.0 && random.random::<f64>() < (-change).exp()) {
            plate.exchange(a, b);
            accepted += 1;
        }
    }
    accepted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::arrange::random_order;
    use crate::facets::steps::Steps;
    use crate::progress::{CancelToken, Event};
    use crate::slope::Slope;

    const ENERGIES: [Energy; 2] = [Energy::Walls, Energy::Weyrich2009];

    /// A disc of slopes (a sunflower), shuffled: no two alike, and nothing in the order to start from.
    fn disc(columns: usize, rows: usize, seed: u64) -> SlopeGrid {
        let n = (columns * rows) as f64;
        let mut grid = SlopeGrid::from_fn(columns, rows, |i, j| {
            let k = (j * columns + i) as f64;
            let (r, a) = (0.3 * ((k + 0.5) / n).sqrt(), k * PI * (3.0 - 5f64.sqrt()));
            Slope::new(r * a.cos(), r * a.sin())
        });
        random_order(&mut grid, seed);
        grid
    }

    fn sorted(grid: &SlopeGrid) -> Vec<(u64, u64)> {
        let mut bits: Vec<_> = grid.slopes.iter().map(|s| (s.p.to_bits(), s.q.to_bits())).collect();
        bits.sort_unstable();
        bits
    }

    fn measured(grid: &SlopeGrid) -> Steps {
        steps(grid, &least_squares(grid, DVec2::ONE, true), DVec2::ONE, true)
    }

    #[test]
    fn the_default_halves_walls_and_valleys_with_room_to_spare() {
        let mut grid = disc(30, 30, 1);
        let before = measured(&grid);
        anneal(&mut grid, &Annealing { swaps: 3_000_000, ..Default::default() }, 5, &Progress::silent());
        let after = measured(&grid);
        assert!(after.wall_area_ratio < 0.3 * before.wall_area_ratio, "{before:?} {after:?}");
        assert!(after.rms < 0.3 * before.rms, "{before:?} {after:?}");
        assert!((after.valleys as f64) < 0.45 * before.valleys as f64, "{before:?} {after:?}");
    }

    #[test]
    fn the_paper_s_valley_term_trades_valleys_for_walls_as_in_the_paper() {
        let mut with = disc(30, 30, 2);
        let before = measured(&with);
        let mut without = with.clone();
        let settings = Annealing { energy: Energy::Weyrich2009, swaps: 2_000_000, valleys: 1.0, starts: 1 };
        anneal(&mut with, &settings, 3, &Progress::silent());
        anneal(&mut without, &Annealing { valleys: 0.0, ..settings }, 3, &Progress::silent());
        let (with, without) = (measured(&with), measured(&without));
        assert!((with.valleys as f64) < 0.6 * before.valleys as f64, "{before:?} {with:?}");
        assert!((without.valleys as f64) > 0.85 * before.valleys as f64, "{before:?} {without:?}");
        assert!(without.wall_area_ratio < 0.8 * before.wall_area_ratio, "{before:?} {without:?}");
    }

    #[test]
    fn the_slopes_stay_the_same_set_and_the_energy_falls_on_grids_of_any_shape() {
        for energy in ENERGIES {
            for (columns, rows) in [(12, 7), (1, 40), (40, 1), (2, 9), (3, 2), (2, 1)] {
                let mut grid = disc(columns, rows, 4);
                let set = sorted(&grid);
                let settings = Annealing { energy, swaps: 50_000, valleys: 1.0, starts: 1 };
                let done = anneal(&mut grid, &settings, 9, &Progress::silent());
                assert_eq!(sorted(&grid), set, "{columns} x {rows}");
                assert_eq!(done.tried, 50_000);
                let slack = 1e-12 * done.before.abs();
                assert!(done.after <= done.before + slack, "{energy:?} {columns} x {rows}: {done:?}");
                if columns * rows > 6 {
                    assert!(done.after < 0.9 * done.before, "{energy:?} {columns} x {rows}: {done:?}");
                }
            }
        }
    }

    #[test]
    fn more_exchanges_reach_a_lower_energy() {
        for energy in ENERGIES {
            let after = [20_000, 200_000, 2_000_000].map(|swaps| {
                let settings = Annealing { energy, swaps, valleys: 1.0, starts: 1 };
                anneal(&mut disc(20, 20, 6), &settings, 1, &Progress::silent()).after
            });
            assert!(after[0] > after[1] && after[1] > after[2], "{energy:?}: {after:?}");
        }
    }

    #[test]
    fn of_several_starts_the_lowest_walls_are_kept() {
        let settings = Annealing { energy: Energy::Weyrich2009, swaps: 100_000, valleys: 1.0, starts: 4 };
        let order = disc(12, 12, 8);
        let run = |starts| {
            let mut grid = order.clone();
            anneal_best(&mut grid, &Annealing { starts, ..settings }, 7, &Progress::silent());
            measured(&grid).wall_area_ratio
        };
        let areas = [1, 2, 3, 4].map(run);
        assert!(areas.is_sorted_by(|a, b| a >= b) && areas[3] < areas[0], "{areas:?}");
    }

    #[test]
    fn the_seed_decides_everything() {
        let run = |seed| {
            let mut grid = disc(10, 8, 3);
            anneal(&mut grid, &Annealing { swaps: 20_000, ..Default::default() }, seed, &Progress::silent());
            grid
        };
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }

    #[test]
    fn cancelled_or_trivial_work_leaves_the_order_alone() {
        let cancel = CancelToken::default();
        cancel.finish();
        let mut grid = disc(6, 6, 3);
        let order = grid.clone();
        let done = anneal(&mut grid, &Annealing::default(), 1, &Progress::new(&|_: Event<'_>| {}, &cancel));
        assert_eq!((&grid, done.tried, done.after == done.before), (&order, 0, true));
        for slopes in [vec![], vec![Slope::new(0.1, 0.2)]] {
            let order = SlopeGrid { columns: slopes.len(), rows: slopes.len(), slopes };
            let mut grid = order.clone();
            assert_eq!(anneal(&mut grid, &Annealing::default(), 1, &Progress::silent()).tried, 0);
            assert_eq!(grid, order);
        }
    }

    #[test]
    fn equal_slopes_are_a_plane_with_nothing_to_gain() {
        let mut grid = SlopeGrid::from_fn(5, 4, |_, _| Slope::new(0.1, 0.2));
        let order = grid.clone();
        let done = anneal(&mut grid, &Annealing { swaps: 1000, ..Default::default() }, 1, &Progress::silent());
        assert_eq!(grid, order);
        assert!(done.after.is_finite() && (done.after - done.before).abs() < 1e-12);
    }
}
