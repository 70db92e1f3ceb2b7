//! Arrangement by optimal transport: slopes matched to places so that the plate is a dome.
//!
//! Of all orders, the one that maximises Σ -s·x is cyclically monotone (Brenier 1991): its slopes are those of a
//! concave function, up to the grid's discreteness. Concave means ridges only, and a mill cuts ridges; and the
//! gradient of a function needs no steps.

use glam::DVec2;
use rayon::prelude::*;

use super::assignment::cheapest_assignment;
use crate::facets::SlopeGrid;
use crate::progress::Progress;
use crate::slope::Slope;

/// The largest grid that is solved in one exact assignment, cells; larger ones go window by window. The assignment takes
/// the cube of this at worst, and 8 MB for its costs; windows of a grid of this size come within a thousandth of the
/// exact gain (see the tests), so that nobody sees the change from one to the other.
const EXACT: usize = 1024;

/// Side of a window, cells. A window's assignment takes the sixth power of it at worst, the whole grid the fourth: twice
/// the side costs up to sixteen times as much for what one more round of windows does as well.
const WINDOW: usize = 8;

/// Rounds from coarse to fine windows. Measured at 100 × 100: steps of 0.0032, 0.0031 and 0.0030 pitches after 2, 3
/// and 4; a million facets are content with one, since their steps are a hundredth of anything a mill can cut.
fn rounds(cells: usize) -> u32 {
    match cells {
        0..=20_000 => 3,
        20_001..=200_000 => 2,
        _ => 1,
    }
}

/// Orders `slopes` on a `columns` × `rows` grid of cells of `pitch` mm.
pub fn dome(slopes: Vec<Slope>, columns: usize, rows: usize, pitch: DVec2, progress: &Progress) -> SlopeGrid {
    let mut grid = sorted(slopes, columns, rows);
    if columns * rows <= EXACT {
        let cells: Vec<usize> = (0..columns * rows).collect();
        grid.slopes = assigned(&grid, &cells, pitch, progress);
    } else {
        window_by_window(&mut grid, pitch, progress);
    }
    // Of the exact order only rounding is left: slopes that differ by less than the sums can tell.
    bubble(&mut grid, progress);
    grid
}

/// A first order: split across one axis of the grid, the steeper falls to the farther half, and again within halves.
fn sorted(mut slopes: Vec<Slope>, columns: usize, rows: usize) -> SlopeGrid {
    let mut grid = SlopeGrid { columns, rows, slopes: vec![Slope::FLAT; slopes.len()] };
    place(&mut slopes, &mut grid, (0, columns), (0, rows));
    grid
}

fn place(slopes: &mut [Slope], grid: &mut SlopeGrid, (x0, x1): (usize, usize), (y0, y1): (usize, usize)) {
    let (width, height) = (x1 - x0, y1 - y0);
    if width * height <= 1 {
        if let [slope] = slopes {
            grid.slopes[y0 * grid.columns + x0] = *slope;
        }
    } else if width >= height {
        let middle = x0 + width / 2;
        let (left, right) = split(slopes, (middle - x0) * height, |s| -s.p);
        place(left, grid, (x0, middle), (y0, y1));
        place(right, grid, (middle, x1), (y0, y1));
    } else {
        let middle = y0 + height / 2;
        let (low, high) = split(slopes, (middle - y0) * width, |s| -s.q);
        place(low, grid, (x0, x1), (y0, middle));
        place(high, grid, (x0, x1), (middle, y1));
    }
}

fn split(slopes: &mut [Slope], at: usize, key: impl Fn(&Slope) -> f64) -> (&mut [Slope], &mut [Slope]) {
    slopes.select_nth_unstable_by(at, |a, b| key(a).total_cmp(&key(b)));
    slopes.split_at_mut(at)
}

/// Solves windows exactly, coarse ones first: every W-th cell far apart carries slopes across the whole plate at once,
/// finer ones put the neighbourhood in order, down to windows of neighbours.
fn window_by_window(grid: &mut SlopeGrid, pitch: DVec2, progress: &Progress) {
    let coarsest = (grid.columns.max(grid.rows) / WINDOW).max(1).ilog2();
    let rounds = rounds(grid.slopes.len());
    for step in 0..rounds * (coarsest + 1) {
        progress.fraction(f64::from(step) / f64::from(rounds * (coarsest + 1)));
        if progress.is_to_finish() {
            return;
        }
        let level = coarsest - step % (coarsest + 1);
        (0..4).for_each(|phase| sweep(grid, 1 << level, phase, pitch, progress));
    }
}

/// One cover of the grid by windows of cells `stride` apart, shifted by half a window as `phase` (0 to 3) says.
fn sweep(grid: &mut SlopeGrid, stride: usize, phase: usize, pitch: DVec2, progress: &Progress) {
    let (across, up) = (combs(grid.columns, stride, phase & 1), combs(grid.rows, stride, phase >> 1));
    let columns = grid.columns;
    let windows: Vec<Vec<usize>> = up
        .iter()
        .flat_map(|ys| {
            across.iter().map(move |xs| ys.iter().flat_map(|y| xs.iter().map(move |x| y * columns + x)).collect())
        })
        .collect();
    let solved: Vec<Vec<Slope>> = windows.par_iter().map(|cells| assigned(grid, cells, pitch, progress)).collect();
    for (cells, slopes) in windows.iter().zip(solved) {
        for (&cell, slope) in cells.iter().zip(slopes) {
            grid.slopes[cell] = slope;
        }
    }
}

/// 0..n dealt into runs of [`WINDOW`] numbers `stride` apart, the first half as long if `shifted`.
fn combs(n: usize, stride: usize, shifted: usize) -> Vec<Vec<usize>> {
    let mut combs = Vec::new();
    for first in 0..stride.min(n) {
        let line: Vec<usize> = (first..n).step_by(stride).collect();
        let (head, rest) = line.split_at((shifted * WINDOW / 2).min(line.len()));
        combs.extend([head].into_iter().chain(rest.chunks(WINDOW)).filter(|c| !c.is_empty()).map(<[usize]>::to_vec));
    }
    combs
}

/// The slopes of `cells` in the order that maximises Σ -s·x over those cells; told to finish, as they are.
fn assigned(grid: &SlopeGrid, cells: &[usize], pitch: DVec2, progress: &Progress) -> Vec<Slope> {
    if progress.is_to_finish() {
        return cells.iter().map(|&cell| grid.slopes[cell]).collect();
    }
    let n = cells.len();
    let at = |cell: usize| DVec2::new((cell % grid.columns) as f64, (cell / grid.columns) as f64) * pitch;
    let origin = cells.get(n / 2).map_or(DVec2::ZERO, |&cell| at(cell));
    let places: Vec<DVec2> = cells.iter().map(|&cell| at(cell) - origin).collect();
    let slopes: Vec<Slope> = cells.iter().map(|&cell| grid.slopes[cell]).collect();
    let cost: Vec<f64> = places.iter().flat_map(|x| slopes.iter().map(move |s| s.to_vec().dot(*x))).collect();
    cheapest_assignment(n, &cost, progress).into_iter().map(|k| slopes[k]).collect()
}

/// Swaps neighbours that form a valley until there is none.
fn bubble(grid: &mut SlopeGrid, progress: &Progress) {
    let (columns, rows) = (grid.columns, grid.rows);
    // Each swap raises Σ -s·x, so this ends; the bound is only against rounding.
    for _ in 0..columns + rows {
        if progress.is_to_finish() {
            break;
        }
        let mut swapped = false;
        for y in 0..rows {
            for x in 0..columns {
                let k = y * columns + x;
                if x + 1 < columns && grid.slopes[k + 1].p > grid.slopes[k].p {
                    grid.slopes.swap(k, k + 1);
                    swapped = true;
                }
                if y + 1 < rows && grid.slopes[k + columns].q > grid.slopes[k].q {
                    grid.slopes.swap(k, k + columns);
                    swapped = true;
                }
            }
        }
        if !swapped {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slopes of a paraboloid dome on a grid, shuffled by a multiplier prime to their number.
    fn shuffled_dome(columns: usize, rows: usize, pitch: DVec2) -> (Vec<Slope>, Vec<Slope>) {
        let n = columns * rows;
        let planted: Vec<Slope> = (0..n)
            .map(|k| Slope::from_vec(-0.1 * DVec2::new((k % columns) as f64, (k / columns) as f64) * pitch))
            .collect();
        let shuffled = (0..n).map(|k| planted[k * 7919 % n]).collect();
        (planted, shuffled)
    }

    fn gain(grid: &SlopeGrid, pitch: DVec2) -> f64 {
        let place = |k: usize| DVec2::new((k % grid.columns) as f64, (k / grid.columns) as f64) * pitch;
        grid.slopes.iter().enumerate().map(|(k, s)| -s.to_vec().dot(place(k))).sum()
    }

    #[test]
    fn a_shuffled_dome_is_put_together_again() {
        for (columns, rows) in [(1, 1), (1, 9), (13, 11), (30, 30), (50, 41)] {
            let pitch = DVec2::new(1.0, 1.5);
            let (planted, shuffled) = shuffled_dome(columns, rows, pitch);
            let grid = dome(shuffled, columns, rows, pitch, &Progress::silent());
            assert_eq!(grid.slopes, planted, "{columns} × {rows}");
        }
    }

    #[test]
    fn windows_come_within_a_thousandth_of_the_exact_order() {
        let (columns, rows, pitch) = (32, 32, DVec2::ONE);
        let slope = |k: usize| {
            let (a, r) = (k as f64 * 2.399_963, (k as f64 + 0.5).sqrt());
            Slope::new(a.cos() * (r + 10.0), a.sin() * (r + 10.0))
        };
        let slopes: Vec<Slope> = (0..columns * rows).map(slope).collect();
        let exact = dome(slopes.clone(), columns, rows, pitch, &Progress::silent());
        let mut windowed = sorted(slopes, columns, rows);
        window_by_window(&mut windowed, pitch, &Progress::silent());
        bubble(&mut windowed, &Progress::silent());
        let (best, found) = (gain(&exact, pitch), gain(&windowed, pitch));
        assert!(found <= best * (1.0 + 1e-12) && found > best * 0.999, "{found} against {best}");
    }
}
