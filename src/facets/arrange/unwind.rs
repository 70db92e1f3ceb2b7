//! Takes the swirl out of an arrangement: slopes flow over the plate until they are the gradient of a surface.
//!
//! Of all arrangements of the same slopes, one is the gradient of a concave surface (Brenier 1991). What an arrangement s
//! lacks is r = s - ∇h, with h the heights nearest to it in the least squares: a field without sources that does not cross
//! the rim. Slopes may be carried along such a field without crowding anywhere. On a dome whose slope falls by κ a
//! millimetre, slopes carried by -r/κ change by -r: that is the flow of Angenent, Haker and Tannenbaum (SIAM J. Math. Anal.
//! 35, 2003), which ends when r does. Windows of neighbours cannot do this: within one, r is nearly constant, and no other
//! order of its slopes is better.
//!
//! The flow is followed on a coarse grid, where r is smooth. Then each slope of the fine one is where the flow carried it,
//! and the cells are dealt out anew by place; neighbours put out of order by that change places.

use glam::DVec2;
use rayon::prelude::*;

use super::exchange::exchange;
use super::split::laid_out;
use crate::facets::SlopeGrid;
use crate::facets::heights::LeastSquares;
use crate::progress::Progress;
use crate::raster::bilinear_weights;
use crate::slope::Slope;

/// Cells along a side of the coarse grid. Measured on a portrait at 300 × 300: 64, 128 and 256 end with the same walls
/// within a tenth.
const SIDE: usize = 128;

/// Times that the flow is followed and cells are dealt out anew. Measured at 100 × 100 and 300 × 300 on photographs and
/// letters: walls no longer fall after the fourth to the sixth.
const ROUNDS: usize = 8;

/// Steps of the flow in a round. More let it run away at ridges, where slopes jump; from 10 on it does.
const STEPS: usize = 6;

/// Share of r that a step takes away. Measured on a ring at 100 × 100: 0.5 leaves steps of 0.0013 pitches, 0.3 of 0.0010.
const RATE: f64 = 0.3;

/// Coarse cells by which slopes move in a step at the most.
const FARTHEST: f64 = 1.0;

/// Offsets between cells that change places, times powers of two up to [`WIDEST`].
const OFFSETS: [[isize; 2]; 8] = [[1, 0], [0, 1], [1, 1], [1, -1], [2, 1], [1, 2], [2, -1], [1, -2]];

/// Largest factor of [`OFFSETS`]: dealing out moves slopes by a few cells.
const WIDEST: isize = 8;

/// Rearranges `grid`, of cells of `pitch` mm, so that its slopes come near to a gradient; `share` hears how much is done.
/// Told to finish, it leaves the order reached so far. Grids with fewer than four cells along a side stay as they are.
pub(super) fn unwind(grid: &mut SlopeGrid, pitch: DVec2, share: impl Fn(f64), progress: &Progress) {
    if grid.columns.min(grid.rows) < 4 {
        return;
    }
    for round in 0..ROUNDS {
        share(round as f64 / ROUNDS as f64);
        if progress.is_to_finish() {
            return;
        }
        let places = Flow::new(grid, pitch).carried();
        let moved: Vec<(DVec2, Slope)> = places.into_iter().zip(grid.slopes.iter().copied()).collect();
        let dealt = laid_out(moved, grid.columns, grid.rows, &|moved| moved.0);
        grid.slopes = dealt.into_iter().map(|(_, slope)| slope).collect();
        put_in_order(grid, pitch, progress);
    }
}

/// Lets cells change places with others nearby wherever that makes the plate more of a dome.
fn put_in_order(grid: &mut SlopeGrid, pitch: DVec2, progress: &Progress) {
    for _ in 0..2 {
        let mut factor = WIDEST;
        while factor > 0 && !progress.is_to_finish() {
            OFFSETS.iter().for_each(|[x, y]| {
                exchange(grid, [x * factor, y * factor], pitch);
            });
            factor /= 2;
        }
    }
}

/// The flow of one round on the coarse grid. Lengths are in coarse cells, the middle of the first is the origin.
struct Flow {
    /// Columns and rows.
    size: [usize; 2],
    /// Size of a coarse cell, mm.
    pitch: DVec2,
    /// Mean slopes of the coarse cells as the round begins.
    slopes: Vec<DVec2>,
    /// Where the slope that is now in a coarse cell came from.
    origins: Vec<DVec2>,
    /// Where each slope of the fine grid is now.
    places: Vec<DVec2>,
    heights: LeastSquares,
}

impl Flow {
    fn new(grid: &SlopeGrid, pitch: DVec2) -> Self {
        let size = [grid.columns.min(SIDE), grid.rows.min(SIDE)];
        let cells = size[0] * size[1];
        let (mut slopes, mut count) = (vec![DVec2::ZERO; cells], vec![0.0; cells]);
        for (k, slope) in grid.slopes.iter().enumerate() {
            let (column, row) = (k % grid.columns, k / grid.columns);
            let coarse = row * size[1] / grid.rows * size[0] + column * size[0] / grid.columns;
            slopes[coarse] += slope.to_vec();
            count[coarse] += 1.0;
        }
        slopes.iter_mut().zip(count).for_each(|(sum, count)| *sum /= count);
        let fine = DVec2::new(size[0] as f64 / grid.columns as f64, size[1] as f64 / grid.rows as f64);
        let place = |k: usize| (cell(k, grid.columns) + 0.5) * fine - 0.5;
        let coarse_pitch = pitch / fine;
        Self {
            size,
            pitch: coarse_pitch,
            slopes,
            origins: (0..cells).map(|k| cell(k, size[0])).collect(),
            places: (0..grid.cells()).map(place).collect(),
            heights: LeastSquares::new(size[0], size[1], coarse_pitch, false),
        }
    }

    /// Where each slope of the fine grid is carried by all steps of a round.
    fn carried(mut self) -> Vec<DVec2> {
        for _ in 0..STEPS {
            let velocity = self.velocity();
            let upstream = |k: usize| self.between(&self.origins, cell(k, self.size[0]) - velocity[k]);
            self.origins = (0..velocity.len()).map(upstream).collect();
            let mut places = std::mem::take(&mut self.places);
            places.par_iter_mut().with_min_len(4096).for_each(|place| *place += self.between(&velocity, *place));
            self.places = places;
        }
        self.places
    }

    /// By how many coarse cells slopes move in the next step: along -r/κ, smoothed.
    fn velocity(&self) -> Vec<DVec2> {
        let [columns, rows] = self.size;
        let slopes: Vec<DVec2> = self.origins.iter().map(|origin| self.between(&self.slopes, *origin)).collect();
        let grid = SlopeGrid { columns, rows, slopes: slopes.iter().copied().map(Slope::from_vec).collect() };
        let gradient = self.gradient(&self.heights.heights(&grid));
        let mut lack: Vec<DVec2> = slopes.iter().zip(gradient).map(|(slope, gradient)| *slope - gradient).collect();
        // Differences are one-sided at the rim, which nothing crosses.
        for (k, lack) in lack.iter_mut().enumerate() {
            let (column, row) = (k % columns, k / columns);
            lack.x *= f64::from(u8::from(column > 0 && column + 1 < columns));
            lack.y *= f64::from(u8::from(row > 0 && row + 1 < rows));
        }
        let lack = self.smoothed(&self.smoothed(&lack));
        let low = slopes.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = slopes.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        // How much slopes fall from one coarse cell to the next, in the mean of both directions.
        let fall = 0.5 * ((high - low) / DVec2::new(columns as f64, rows as f64)).element_sum();
        if fall <= 0.0 {
            return vec![DVec2::ZERO; lack.len()];
        }
        // Cells need not be square, and the flow has no sources in millimetres.
        let shape = (self.pitch.x * self.pitch.y).sqrt() / self.pitch;
        lack.into_iter().map(|lack| (-RATE / fall * lack * shape).clamp_length_max(FARTHEST)).collect()
    }

    /// Gradient of heights (mm) at the middles of the coarse cells.
    fn gradient(&self, heights: &[f64]) -> Vec<DVec2> {
        let [columns, rows] = self.size;
        let around = |k: usize, n: usize| [k.saturating_sub(1), (k + 1).min(n - 1)];
        let at = |column: usize, row: usize| heights[row * columns + column];
        let gradient = |k: usize| {
            let (column, row) = (k % columns, k / columns);
            let ([left, right], [below, above]) = (around(column, columns), around(row, rows));
            let rise = DVec2::new(at(right, row) - at(left, row), at(column, above) - at(column, below));
            rise / (DVec2::new((right - left) as f64, (above - below) as f64) * self.pitch)
        };
        (0..heights.len()).map(gradient).collect()
    }

    /// The mean over a cell and its neighbours with weights 1, 2, 1 along both sides.
    fn smoothed(&self, field: &[DVec2]) -> Vec<DVec2> {
        let [columns, rows] = self.size;
        let along = |field: &[DVec2], step: usize, n: usize| -> Vec<DVec2> {
            let mean = |k: usize| {
                let i = k / step % n;
                let before = if i == 0 { k } else { k - step };
                let after = if i + 1 == n { k } else { k + step };
                0.25 * (field[before] + field[after]) + 0.5 * field[k]
            };
            (0..field.len()).map(mean).collect()
        };
        along(&along(field, 1, columns), columns, rows)
    }

    /// A field between the middles of the coarse cells; beyond the outermost as there.
    fn between(&self, field: &[DVec2], place: DVec2) -> DVec2 {
        let [columns, rows] = self.size;
        let place = place.clamp(DVec2::ZERO, DVec2::new((columns - 1) as f64, (rows - 1) as f64));
        let (column, row) = ((place.x as usize).min(columns - 2), (place.y as usize).min(rows - 2));
        let corner = row * columns + column;
        let weights = bilinear_weights(place.x - column as f64, place.y - row as f64);
        let corners = [corner, corner + 1, corner + columns, corner + columns + 1];
        weights.iter().zip(corners).map(|(weight, corner)| *weight * field[corner]).sum()
    }
}

/// Column and row of number `k` in rows of `columns`.
fn cell(k: usize, columns: usize) -> DVec2 {
    DVec2::new((k % columns) as f64, (k / columns) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::heights::least_squares;
    use crate::facets::steps::steps;

    /// A dome whose slopes are turned by 0.2 about the normal, as no surface has them.
    fn turned(columns: usize, rows: usize, pitch: DVec2) -> SlopeGrid {
        let middle = DVec2::new(columns as f64, rows as f64) * 0.5;
        SlopeGrid::from_fn(columns, rows, |i, j| {
            let x = (DVec2::new(i as f64, j as f64) + 0.5 - middle) * pitch;
            Slope::from_vec(-0.01 * (x + 0.2 * x.perp()))
        })
    }

    #[test]
    fn a_turned_dome_is_turned_back_and_keeps_its_slopes() {
        for (columns, rows, pitch) in [(60, 60, DVec2::ONE), (200, 150, DVec2::new(0.5, 0.8))] {
            let mut grid = turned(columns, rows, pitch);
            let walls =
                |grid: &SlopeGrid| steps(grid, &least_squares(grid, pitch, false), pitch, false).wall_area_ratio;
            let sorted = |grid: &SlopeGrid| {
                let mut slopes: Vec<[u64; 2]> = grid.slopes.iter().map(|s| [s.p.to_bits(), s.q.to_bits()]).collect();
                slopes.sort_unstable();
                slopes
            };
            let (before, set) = (walls(&grid), sorted(&grid));
            unwind(&mut grid, pitch, |_| {}, &Progress::silent());
            let after = walls(&grid);
            assert!(after < 0.2 * before, "{columns} × {rows}: {before} to {after}");
            assert_eq!(sorted(&grid), set);
        }
    }

    #[test]
    fn grids_of_one_row_or_of_one_slope_stay_as_they_are() {
        for grid in [turned(500, 1, DVec2::ONE), SlopeGrid::from_fn(40, 40, |_, _| Slope::new(0.1, 0.2))] {
            let mut same = grid.clone();
            unwind(&mut same, DVec2::ONE, |_| {}, &Progress::silent());
            assert_eq!(same, grid);
        }
    }
}
