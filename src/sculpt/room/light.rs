//! The light of a plate's triangles on the wall, and the gradient of a function of it.
//!
//! Each triangle sends its light from its own place with its own mass: with the lamp nearby both direction and irradiance
//! change over the plate. Where a triangle stands moves with its heights by so little that the gradient leaves it out.

use rayon::prelude::*;

use crate::sculpt::edge_slopes::{EdgeSlopes, SquareEdges, added_bands};

use super::fillets::Fillets;
use super::landing::{Landed, Landing};
use super::plate_grid::PlateGrid;

/// The light of a plate's triangles among the bins of the picture.
#[derive(Clone, Copy, Debug)]
pub struct PlateLight {
    grid: PlateGrid,
    landing: Landing,
    /// Share of the plate of each triangle along the higher diagonals, and along the lower ones.
    share: [f32; 2],
    fillets: Option<Fillets>,
}

impl PlateLight {
    /// For the triangles of `grid`. A share `lower` of the light goes as if squares were cut along their lower diagonals,
    /// as in [`LightModel`](crate::sculpt::light_model::LightModel).
    pub fn new(grid: PlateGrid, landing: Landing, lower: f64, fillets: Option<Fillets>) -> Self {
        let share = 0.5 / (grid.squares[0] * grid.squares[1]) as f64;
        Self { grid, landing, share: [share * (1.0 - lower), share * lower].map(|v| v as f32), fillets }
    }

    /// Where square i of row `j` begins, mm from the plate's middle, its height that of `z` there.
    #[inline(always)]
    fn corner<'a>(&self, j: usize, z: &'a [f32]) -> impl Fn(usize) -> [f32; 3] + 'a {
        let (step, half, n) = (self.grid.lattice.step.as_vec2(), self.grid.half().as_vec2(), self.grid.lattice.n);
        move |i| [i as f32 * step.x - half.x, j as f32 * step.y - half.y, z[j * n + i]]
    }

    /// Share of the plate, and light of the lower and the upper triangle, of both cuts of a square.
    #[inline(always)]
    fn triangles(&self, square: SquareEdges, corner: [f32; 3]) -> [(f32, [Landed; 2]); 2] {
        let step = self.grid.lattice.step.as_vec2();
        let SquareEdges { bottom, top, left, right } = square;
        let land = |a: f32, b: f32, p: f32, q: f32| {
            let (x, y) = (a * step.x, b * step.y);
            self.landing.land([corner[0] + x, corner[1] + y, corner[2] + x * bottom + y * left], p, q)
        };
        const ONE: f32 = 1.0 / 3.0;
        const TWO: f32 = 2.0 / 3.0;
        let rising = || [land(TWO, ONE, bottom, right), land(ONE, TWO, top, left)];
        let falling = || [land(ONE, ONE, bottom, left), land(TWO, TWO, top, right)];
        let only_higher = self.share[1] == 0.0;
        match square.rises() {
            true => {
                let higher = rising();
                [(self.share[0], higher), (self.share[1], if only_higher { higher } else { falling() })]
            }
            false => {
                let higher = falling();
                [(self.share[0], higher), (self.share[1], if only_higher { higher } else { rising() })]
            }
        }
    }

    /// The light of heights `z` whose slopes are `edges`, as shares of what the flat plate takes if it were lit as in its
    /// middle.
    pub fn forward(&self, z: &[f32], edges: &EdgeSlopes) -> Vec<f32> {
        let bins = &self.landing.bins;
        let splat = |band: usize| {
            let mut light = vec![0.0f32; bins.side * bins.side];
            for j in self.grid.band(band) {
                let (row, corner) = (edges.row(j), self.corner(j, z));
                for i in 0..self.grid.squares[0] {
                    for (share, landed) in self.triangles(row.square(i), corner(i)) {
                        if share > 0.0 {
                            landed.into_iter().for_each(|l| bins.splat(&mut light, l.at, share * l.mass.max(0.0)));
                        }
                    }
                }
                if let Some(fillets) = &self.fillets {
                    fillets.forward((&row, j), &self.landing, corner, &mut light);
                }
            }
            light
        };
        added_bands(bins.side * bins.side, splat)
    }

    /// The gradient with respect to the heights, per mm, of Σ `potential` · light + `weight` · penalty of the concave
    /// edges; and that penalty.
    pub fn adjoint(&self, z: &[f32], edges: &EdgeSlopes, potential: &[f32], weight: f32) -> (Vec<f32>, f64) {
        let bins = &self.landing.bins;
        let slopes = |share: f32, l: Landed| {
            let (value, [x, y]) = bins.sample(potential, l.at);
            [0, 1].map(|k| share * (l.mass * (x * l.moves[k][0] + y * l.moves[k][1]) + l.grows[k] * value))
        };
        edges.adjoint(self.grid.lattice, |j, row, sums| {
            if j >= self.grid.squares[1] {
                return 0.0;
            }
            let corner = self.corner(j, z);
            for i in 0..self.grid.squares[0] {
                let square = row.square(i);
                let mut gradients = [[[0.0; 2]; 2]; 2];
                for (gradients, (share, landed)) in gradients.iter_mut().zip(self.triangles(square, corner(i))) {
                    if share > 0.0 {
                        *gradients = landed.map(|l| slopes(share, l));
                    }
                }
                let [higher, lower] = gradients;
                sums.p[0][i] += higher[0][0] + lower[0][0];
                sums.p[1][i] += higher[1][0] + lower[1][0];
                let (first, second) = (higher[0][1] + lower[1][1], higher[1][1] + lower[0][1]);
                let (left, right) = if square.rises() { (second, first) } else { (first, second) };
                sums.q[0][i] += left;
                sums.q[0][i + 1] += right;
            }
            let with_weight = (potential, weight);
            self.fillets.map_or(0.0, |fillets| fillets.adjoint((&row, j), &self.landing, corner, with_weight, sums))
        })
    }

    /// The penalty of a plate's concave edges.
    pub fn penalty(&self, edges: &EdgeSlopes) -> f64 {
        let Some(fillets) = &self.fillets else { return 0.0 };
        let rows = (0..self.grid.squares[1]).into_par_iter().map(|j| fillets.penalty(&edges.row(j), j));
        rows.collect::<Vec<f64>>().iter().sum()
    }
}
