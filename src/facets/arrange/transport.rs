//! Arrangement by optimal transport: slopes matched to places so that the plate is a dome.
//!
//! Of all orders, the one that maximises Σ -s·x is cyclically monotone (Brenier 1991): its slopes are those of a
//! concave function, up to the grid's discreteness. Concave means ridges only, and a mill cuts ridges; and the
//! gradient of a function needs no steps.

use glam::DVec2;
use rayon::prelude::*;

use super::assignment::cheapest_assignment;
use super::exchange::exchange;
use super::split::laid_out;
use super::unwind::unwind;
use crate::facets::SlopeGrid;
use crate::facets::heights::least_squares;
use crate::progress::Progress;
use crate::slope::Slope;

/// The largest grid that is solved in one exact assignment, cells; larger ones go window by window. The assignment takes
/// the cube of this at worst, and 8 MB for its costs; windows of a grid of this size come within a thousandth of the
/// exact gain (see the tests), so that nobody sees the change from one to the other.
const EXACT: usize = 1024;

/// Side of a window, cells. A window's assignment takes the sixth power of it at worst, the whole grid the fourth: twice
/// the side costs up to sixteen times as much for what one more round of windows does as well.
const WINDOW: usize = 8;

/// Distances between the cells of a window, in turn. Measured at 100 × 100: the first lowers walls by a fiftieth at the
/// most, wider ones by nothing.
const STRIDES: [usize; 2] = [2, 1];

/// Share of the time that [`unwind`] takes, for the progress told.
const UNWINDING: f64 = 0.4;

/// Orders `slopes` on a `columns` × `rows` grid of cells of `pitch` mm.
pub fn dome(slopes: Vec<Slope>, columns: usize, rows: usize, pitch: DVec2, progress: &Progress) -> SlopeGrid {
    let slopes = laid_out(slopes, columns, rows, &|slope| -slope.to_vec());
    let mut grid = SlopeGrid { columns, rows, slopes };
    if columns * rows <= EXACT {
        let cells: Vec<usize> = (0..columns * rows).collect();
        grid.slopes = assigned(&grid, &least_squares(&grid, pitch, false), &cells, pitch, progress);
    } else {
        unwind(&mut grid, pitch, |share| progress.fraction(UNWINDING * share), progress);
        window_by_window(&mut grid, pitch, progress);
    }
    // Of the exact order only rounding is left: slopes that differ by less than the sums can tell.
    bubble(&mut grid, pitch, progress);
    grid
}

/// Solves windows exactly that cover the grid four times at each of the [`STRIDES`].
fn window_by_window(grid: &mut SlopeGrid, pitch: DVec2, progress: &Progress) {
    let sweeps = STRIDES.iter().flat_map(|stride| (0..4).map(move |phase| (*stride, phase)));
    for (done, (stride, phase)) in sweeps.enumerate() {
        let share = done as f64 / (4 * STRIDES.len()) as f64;
        progress.fraction(UNWINDING + (1.0 - UNWINDING) * share);
        if progress.is_to_finish() {
            return;
        }
        sweep(grid, stride, phase, pitch, progress);
    }
}

/// One cover of the grid by windows of cells `stride` apart, shifted by half a window as `phase` (0 to 3) says.
fn sweep(grid: &mut SlopeGrid, stride: usize, phase: usize, pitch: DVec2, progress: &Progress) {
    let (across, up) = (combs(grid.columns, stride, phase & 1), combs(grid.rows, stride, phase >> 1));
    let columns = grid.columns;
    let heights = least_squares(grid, pitch, false);
    let windows: Vec<[&[usize]; 2]> =
        up.iter().flat_map(|ys| across.iter().map(move |xs| [xs.as_slice(), ys.as_slice()])).collect();
    let solved = windows.par_iter().map(|[xs, ys]| {
        let cells: Vec<usize> = ys.iter().flat_map(|y| xs.iter().map(move |x| y * columns + x)).collect();
        let slopes = assigned(grid, &heights, &cells, pitch, progress);
        cells.into_iter().zip(slopes).collect::<Vec<_>>()
    });
    for (cell, slope) in solved.collect::<Vec<_>>().into_iter().flatten() {
        grid.slopes[cell] = slope;
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
///
/// What a cell adds to the cost of every slope in it changes no order, and `heights` h near to a surface of these slopes
/// make s·x - h(x) least about where the slope is already: the assignment then has little to do. Measured, that takes a
/// sixth of the time for a whole grid and a quarter for windows of neighbours.
fn assigned(grid: &SlopeGrid, heights: &[f64], cells: &[usize], pitch: DVec2, progress: &Progress) -> Vec<Slope> {
    if progress.is_to_finish() {
        return cells.iter().map(|&cell| grid.slopes[cell]).collect();
    }
    let n = cells.len();
    let at = |cell: usize| DVec2::new((cell % grid.columns) as f64, (cell / grid.columns) as f64) * pitch;
    let origin = cells.get(n / 2).map_or(DVec2::ZERO, |&cell| at(cell));
    let slopes: Vec<Slope> = cells.iter().map(|&cell| grid.slopes[cell]).collect();
    let costs = |cell: usize| {
        let (place, height) = (at(cell) - origin, heights[cell]);
        slopes.iter().map(move |slope| slope.to_vec().dot(place) - height)
    };
    let cost: Vec<f64> = cells.iter().flat_map(|&cell| costs(cell)).collect();
    cheapest_assignment(n, &cost, progress).into_iter().map(|k| slopes[k]).collect()
}

/// Swaps neighbours that form a valley until there is none.
fn bubble(grid: &mut SlopeGrid, pitch: DVec2, progress: &Progress) {
    // Each swap raises Σ -s·x, so this ends; the bound is only against rounding.
    for _ in 0..grid.columns + grid.rows {
        let beside = exchange(grid, [1, 0], pitch);
        if progress.is_to_finish() || !(exchange(grid, [0, 1], pitch) | beside) {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::steps::steps;

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
    fn without_an_assignment_of_all_the_gain_is_within_a_thousandth_and_walls_within_a_tenth() {
        let (columns, rows, pitch) = (32, 32, DVec2::ONE);
        let slope = |k: usize| {
            let (a, r) = (k as f64 * 2.399_963, (k as f64 + 0.5).sqrt());
            Slope::new(a.cos() * (r + 10.0), a.sin() * (r + 10.0))
        };
        let slopes: Vec<Slope> = (0..columns * rows).map(slope).collect();
        let silent = Progress::silent();
        let exact = dome(slopes.clone(), columns, rows, pitch, &silent);
        let slopes = laid_out(slopes, columns, rows, &|slope| -slope.to_vec());
        let mut near = SlopeGrid { columns, rows, slopes };
        unwind(&mut near, pitch, |_| {}, &silent);
        window_by_window(&mut near, pitch, &silent);
        bubble(&mut near, pitch, &silent);
        let walls = |grid: &SlopeGrid| steps(grid, &least_squares(grid, pitch, false), pitch, false).wall_area_ratio;
        assert!(walls(&near) < 1.1 * walls(&exact), "{} against {}", walls(&near), walls(&exact));
        let (best, found) = (gain(&exact, pitch), gain(&near, pitch));
        assert!(found <= best * (1.0 + 1e-12) && found > best * 0.999, "{found} against {best}");
    }
}
