//! The energy of an arrangement, and what an exchange of two facets adds to it, at a cost that no plate size raises.

use glam::DVec2;

use crate::facets::SlopeGrid;
use crate::facets::heights::LeastSquares;
use crate::slope::Slope;

/// The factors of the parts of the energy.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// On C: a quarter of the squared change, along each edge, of the step across it.
    pub twist: f64,
    /// On W: the squared step at the middle of each edge.
    pub step: f64,
    /// On I: the squared climb of each row and column.
    pub closure: f64,
    /// On V: each valley.
    pub valley: f64,
}

/// A place on the plate: the slope it holds at the time, and what is its own whatever slope it holds.
#[derive(Clone, Copy)]
struct Place {
    slope: Slope,
    /// Height of the neighbour on the right, and of the one above, over that of this one, pitches.
    climb: [f64; 2],
}

/// A cyclic plate whose facets are being exchanged.
pub(super) struct AnnealingGrid {
    weights: Weights,
    columns: usize,
    rows: usize,
    places: Vec<Place>,
    row_sums: Vec<f64>,
    column_sums: Vec<f64>,
    poisson: Option<LeastSquares>,
}

impl AnnealingGrid {
    pub fn new(grid: &SlopeGrid, weights: Weights) -> Self {
        let (columns, rows) = (grid.columns, grid.rows);
        let mut plate = Self {
            weights,
            columns,
            rows,
            places: grid.slopes.iter().map(|&slope| Place { slope, climb: [0.0; 2] }).collect(),
            row_sums: vec![0.0; rows],
            column_sums: vec![0.0; columns],
            poisson: (weights.step != 0.0).then(|| LeastSquares::new(columns, rows, DVec2::ONE, true)),
        };
        plate.settle();
        plate
    }

    /// Number of places, and of facets.
    pub fn places(&self) -> usize {
        self.places.len()
    }

    pub fn slopes(&self) -> Vec<Slope> {
        self.places.iter().map(|place| place.slope).collect()
    }

    fn grid(&self) -> SlopeGrid {
        SlopeGrid { columns: self.columns, rows: self.rows, slopes: self.slopes() }
    }

    /// Solves for the heights anew, if they matter, and rids the sums of what rounding has added to them.
    pub fn settle(&mut self) {
        self.row_sums.fill(0.0);
        self.column_sums.fill(0.0);
        for (k, place) in self.places.iter().enumerate() {
            self.row_sums[k / self.columns] += place.slope.p;
            self.column_sums[k % self.columns] += place.slope.q;
        }
        if let Some(poisson) = &self.poisson {
            let grid = self.grid();
            let heights = poisson.heights(&grid);
            for (a, b) in grid.x_pairs(true) {
                self.places[a].climb[0] = heights[b] - heights[a];
            }
            for (a, b) in grid.y_pairs(true) {
                self.places[a].climb[1] = heights[b] - heights[a];
            }
        }
    }

    /// The energy for the heights held, summed over the whole plate.
    pub fn energy(&self) -> f64 {
        let grid = self.grid();
        let place = |k: usize| &self.places[k];
        let x: f64 = grid.x_pairs(true).map(|(a, b)| self.edge_x(place(a), place(a).slope, place(b).slope)).sum();
        let y: f64 = grid.y_pairs(true).map(|(a, b)| self.edge_y(place(a), place(a).slope, place(b).slope)).sum();
        let closure: f64 = self.row_sums.iter().chain(&self.column_sums).map(|sum| sum * sum).sum();
        x + y + self.weights.closure * closure
    }

    /// What exchanging the slopes of places `a` and `b` would add to the energy.
    #[inline]
    pub fn change(&mut self, a: usize, b: usize) -> f64 {
        let (in_a, in_b) = (self.places[a].slope, self.places[b].slope);
        let (near_a, near_b) = (self.neighbours(a), self.neighbours(b));
        let edges = if near_a.contains(&b) || near_a.contains(&a) {
            // They share an edge, or a row of one cell is its own neighbour: one after the other, then back.
            let first = -self.around(a, near_a, in_a);
            self.places[a].slope = in_b;
            let second = self.around(a, near_a, in_b) - self.around(b, near_b, in_b);
            self.places[b].slope = in_a;
            let third = self.around(b, near_b, in_a);
            self.places[b].slope = in_b;
            self.places[a].slope = in_a;
            first + second + third
        } else {
            let at_a = self.around(a, near_a, in_b) - self.around(a, near_a, in_a);
            at_a + self.around(b, near_b, in_a) - self.around(b, near_b, in_b)
        };
        if self.weights.closure == 0.0 { edges } else { edges + self.weights.closure * self.closure_change(a, b) }
    }

    /// What the exchange would add to I: (R + d)² - R² + (S - d)² - S² for two rows, and likewise for two columns.
    #[inline]
    fn closure_change(&self, a: usize, b: usize) -> f64 {
        let d = self.places[b].slope.to_vec() - self.places[a].slope.to_vec();
        let ([i, j], [k, l]) = (self.column_and_row(a), self.column_and_row(b));
        let rows = if j == l { 0.0 } else { 2.0 * d.x * (self.row_sums[j] - self.row_sums[l] + d.x) };
        let columns = if i == k { 0.0 } else { 2.0 * d.y * (self.column_sums[i] - self.column_sums[k] + d.y) };
        rows + columns
    }

    /// Exchanges the slopes of places `a` and `b`.
    #[inline]
    pub fn exchange(&mut self, a: usize, b: usize) {
        let (in_a, in_b) = (self.places[a].slope, self.places[b].slope);
        let ([i, j], [k, l]) = (self.column_and_row(a), self.column_and_row(b));
        self.row_sums[j] += in_b.p - in_a.p;
        self.row_sums[l] += in_a.p - in_b.p;
        self.column_sums[i] += in_b.q - in_a.q;
        self.column_sums[k] += in_a.q - in_b.q;
        self.places[a].slope = in_b;
        self.places[b].slope = in_a;
    }

    /// Column and row of place k. Divided in 32 bits, which is faster and enough for any plate in memory.
    #[inline(always)]
    fn column_and_row(&self, k: usize) -> [usize; 2] {
        let (k, w) = (k as u32, self.columns as u32);
        [(k % w) as usize, (k / w) as usize]
    }

    /// The places to the left, to the right, below and above.
    #[inline(always)]
    fn neighbours(&self, k: usize) -> [usize; 4] {
        let (w, n) = (self.columns, self.places.len());
        let [i, _] = self.column_and_row(k);
        [
            if i == 0 { k + w - 1 } else { k - 1 },
            if i + 1 == w { k + 1 - w } else { k + 1 },
            if k < w { k + n - w } else { k - w },
            if k + w >= n { k + w - n } else { k + w },
        ]
    }

    /// Energy of the four edges of place k if it held `slope`.
    #[inline(always)]
    fn around(&self, k: usize, [left, right, below, above]: [usize; 4], slope: Slope) -> f64 {
        let place = |k: usize| &self.places[k];
        self.edge_x(place(left), place(left).slope, slope)
            + self.edge_x(place(k), slope, place(right).slope)
            + self.edge_y(place(below), place(below).slope, slope)
            + self.edge_y(place(k), slope, place(above).slope)
    }

    /// Energy of the edge to the right of `place`, with slope `a` in it and `b` beyond the edge.
    #[inline(always)]
    fn edge_x(&self, place: &Place, a: Slope, b: Slope) -> f64 {
        self.edge(place.climb[0] - 0.5 * (a.p + b.p), b.q - a.q, b.p > a.p)
    }

    /// Energy of the edge above `place`, with slope `a` in it and `b` beyond the edge.
    #[inline(always)]
    fn edge_y(&self, place: &Place, a: Slope, b: Slope) -> f64 {
        self.edge(place.climb[1] - 0.5 * (a.q + b.q), b.p - a.p, b.q > a.q)
    }

    #[inline(always)]
    fn edge(&self, step: f64, twist: f64, valley: bool) -> f64 {
        let valley = if valley { self.weights.valley } else { 0.0 };
        self.weights.step * step * step + self.weights.twist * 0.25 * twist * twist + valley
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::arrange::below;
    use crate::facets::steps::steps;
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const ALL: Weights = Weights { twist: 1.0, step: 0.7, closure: 0.13, valley: 0.01 };

    fn scattered(columns: usize, rows: usize) -> SlopeGrid {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
        let mut number = || below(random.next_u64(), 2001) as f64 / 1000.0 - 1.0;
        SlopeGrid::from_fn(columns, rows, |_, _| Slope::new(number(), number()))
    }

    #[test]
    fn the_sum_of_all_changes_is_the_change_of_the_sum() {
        for (columns, rows) in [(9, 7), (5, 5), (2, 6), (6, 2), (2, 2), (1, 12), (12, 1)] {
            let mut plate = AnnealingGrid::new(&scattered(columns, rows), ALL);
            let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
            let (mut followed, n) = (plate.energy(), plate.places());
            for _ in 0..5000 {
                let (a, b) = (below(random.next_u64(), n), below(random.next_u64(), n));
                followed += plate.change(a, b);
                plate.exchange(a, b);
            }
            let summed = plate.energy();
            assert!((followed - summed).abs() < 1e-10 * summed, "{columns} x {rows}: {followed} {summed}");
        }
    }

    #[test]
    fn asking_for_a_change_changes_nothing_and_new_heights_only_lower_the_energy() {
        let mut plate = AnnealingGrid::new(&scattered(6, 5), Weights { closure: 0.0, ..ALL });
        let slopes = plate.slopes();
        for (a, b) in [(0, 1), (0, 5), (0, 24), (3, 3), (7, 20)] {
            plate.change(a, b);
        }
        assert_eq!(plate.slopes(), slopes);
        plate.exchange(7, 20);
        plate.exchange(0, 1);
        let held = plate.energy();
        plate.settle();
        assert!(plate.energy() < held);
    }

    #[test]
    fn each_part_of_the_energy_is_what_its_name_says() {
        let grid = scattered(8, 6);
        let none = Weights { twist: 0.0, step: 0.0, closure: 0.0, valley: 0.0 };
        let energy = |weights| AnnealingGrid::new(&grid, weights).energy();
        let heights = LeastSquares::new(8, 6, DVec2::ONE, true).heights(&grid);
        let steps = steps(&grid, &heights, DVec2::ONE, true);
        assert_eq!(energy(Weights { valley: 1.0, ..none }), steps.valleys as f64);
        // The mean square of a step m + t s over an edge is m² + s²/12, and C holds s²/4.
        let squares = energy(Weights { step: 1.0, twist: 1.0 / 3.0, ..none });
        assert!((squares - steps.rms.powi(2) * 96.0).abs() < 1e-9);
        let row = |j: usize| (0..8).map(|i| grid.at(i, j).p).sum::<f64>().powi(2);
        let column = |i: usize| (0..6).map(|j| grid.at(i, j).q).sum::<f64>().powi(2);
        let closure = (0..6).map(row).sum::<f64>() + (0..8).map(column).sum::<f64>();
        assert!((energy(Weights { closure: 1.0, ..none }) - closure).abs() < 1e-9);
    }
}
