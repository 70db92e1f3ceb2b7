//! Where the triangles of a periodic relief send light, as written or as a ball cutter leaves them, and how that
//! answers to the heights.
//!
//! Every square of the grid is cut from its lower right to its upper left corner, as in the file that is written:
//!
//! ```text
//!    z01 ─── z11       lower triangle:  p = (z10 - z00)/hx,  q = (z01 - z00)/hy
//!     │ ╲ up  │        upper triangle:  p = (z11 - z01)/hx,  q = (z11 - z10)/hy
//!     │  ╲    │
//!     │ lo╲   │        a square's own edges: bottom, left, diagonal
//!    z00 ─── z10
//! ```
//!
//! All triangles have the same footprint, so each is one point of the slope plane with the same mass.
//!
//! Where two triangles meet in a valley, a ball of radius R leaves a fillet: a strip R·Δs wide, Δs the difference of
//! the slopes, half of it taken from each side, whose light is spread evenly between the two slopes (a parabola in
//! place of the sphere). Bites out of one triangle may add up to more than all of it where the ball touches nothing but
//! corners; then they share it in proportion.

use glam::DVec2;
use rayon::prelude::*;

use super::bins::{Bins, Place};

/// Pieces of the grid with light of their own, summed in order: the same for any number of threads.
const BANDS: usize = 4;

/// A square grid of heights over one cell, `n` × `n` nodes, `step` mm apart; opposite rims are joined.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    /// Nodes a side.
    pub n: usize,
    /// Distance of nodes along x and y, mm.
    pub step: DVec2,
}

/// The light of a lattice's triangles among the bins of a target.
pub struct Light {
    n: usize,
    bins: Bins,
    /// One over the step.
    per_mm: [f32; 2],
    /// What is cut away at edges, if anything.
    edges: Option<Edges>,
    /// Mass of a triangle.
    mass: f32,
}

/// How wide the strips are that the cutter, and whatever rounds all edges, leave along a bottom, left and diagonal edge.
#[derive(Clone, Copy)]
struct Edges {
    /// Bite out of a triangle per fold: see [`FOLD`].
    per_fold: [f32; 3],
    /// Least bite, of ridges too.
    least: [f32; 3],
}

/// Bites that a square's bottom, left and diagonal edge take out of the triangle on either side, shares of a triangle.
type Bites = [f32; 3];

/// The slopes of a square's triangles, (p, q) each.
#[derive(Clone, Copy)]
struct Square {
    low: [f32; 2],
    up: [f32; 2],
}

impl Light {
    /// For triangles cut with a ball of `radius` mm, all of whose edges are rounded over `rounding` mm; or, with neither,
    /// taken as they are.
    pub fn new(lattice: Lattice, bins: Bins, radius: Option<f64>, rounding: f64) -> Self {
        let Lattice { n, step } = lattice;
        // Half the strip's area over the triangle's: a strip w wide along an edge of length ℓ bites w ℓ/(hx hy) out.
        let area = step.x * step.y;
        let bite = |width: [f64; 3]| {
            let bites = [step.x * width[0], step.y * width[1], step.length() * width[2]];
            bites.map(|b| (b / area) as f32)
        };
        // On a diagonal Δs = D ℓ/(hx hy), D the second difference of the heights; the fold is given as D/hx + D/hy.
        let r = radius.unwrap_or(0.0);
        let per_fold = bite([r, r, r * step.length() / (step.x + step.y)]);
        let least = bite([rounding; 3]);
        let edges = (r > 0.0 || rounding > 0.0).then_some(Edges { per_fold, least });
        let per_mm = (1.0 / step).to_array().map(|v| v as f32);
        Self { n, bins, per_mm, edges, mass: 0.5 / (n * n) as f32 }
    }

    /// The light of heights `z`: shares in the bins, sum 1.
    pub fn shine(&self, z: &[f32]) -> Vec<f32> {
        let (n, bins) = (self.n, &self.bins);
        let bites = self.bites(z);
        let lay = |band: usize| {
            let mut light = vec![0.0f32; bins.side * bins.side];
            for j in n * band / BANDS..n * (band + 1) / BANDS {
                for i in 0..n {
                    let square = self.square(z, i, j);
                    let [low, up] = [square.low, square.up].map(|s| bins.place(s[0], s[1]));
                    let Some(bites) = &bites else {
                        bins.lay(&mut light, low, self.mass);
                        bins.lay(&mut light, up, self.mass);
                        continue;
                    };
                    bins.lay(&mut light, low, self.mass * (1.0 - bites.low(i, j)).max(0.0));
                    bins.lay(&mut light, up, self.mass * (1.0 - bites.up(i, j)).max(0.0));
                    for edge in 0..3 {
                        let mass = self.mass * bites.mass(i, j, edge);
                        if mass > 0.0 {
                            let (pieces, points) =
                                bins.walk(self.across(z, i, j, edge), if edge == 2 { up } else { low });
                            points.for_each(|(_, at)| bins.lay(&mut light, at, mass / pieces as f32));
                        }
                    }
                }
            }
            light
        };
        let bands: Vec<Vec<f32>> = (0..BANDS).into_par_iter().map(lay).collect();
        let mut light = vec![0.0f32; bins.side * bins.side];
        light.par_chunks_mut(1 << 13).enumerate().for_each(|(k, piece)| {
            for band in &bands {
                piece.iter_mut().zip(&band[k << 13..]).for_each(|(sum, v)| *sum += v);
            }
        });
        light
    }

    /// Share of the light that a ball touches with more than a point or spreads in fillets: R times all that the relief
    /// turns upward, over its area. 0 without a cutter.
    pub fn fillets(&self, z: &[f32]) -> f64 {
        let Some(edges) = self.edges else { return 0.0 };
        let n = self.n;
        let row = |j: usize| {
            let bite = |i: usize, e: usize| edges.per_fold[e] * self.fold(z, i, j, e);
            (0..n).map(|i| (0..3).map(|e| f64::from(bite(i, e).max(0.0))).sum::<f64>()).sum::<f64>()
        };
        let rows: Vec<f64> = (0..n).into_par_iter().map(row).collect();
        2.0 * f64::from(self.mass) * rows.iter().sum::<f64>()
    }

    /// The gradient with respect to the heights `z` of Σ potential · light.
    ///
    /// Light of fillets costs `price` more, as in [`fillets`](Self::fillets).
    pub fn pull(&self, z: &[f32], potential: &[f32], price: f32) -> Vec<f32> {
        let n = self.n;
        let pulls = match self.bites(z) {
            None => self.pulls(z, potential),
            Some(bites) => self.pulls_as_cut(z, potential, &bites, price),
        };
        let [px, py] = self.per_mm;
        let mut gradient = vec![0.0; n * n];
        gradient.par_chunks_mut(n).enumerate().for_each(|(j, row)| {
            let below = (j + n - 1) % n;
            let (here, down) = (&pulls[j * n..][..n], &pulls[below * n..][..n]);
            for (i, g) in row.iter_mut().enumerate() {
                let left = if i == 0 { n - 1 } else { i - 1 };
                let along_x = here[left].low[0] - here[i].low[0] + down[left].up[0] - down[i].up[0];
                let along_y = down[i].low[1] - here[i].low[1] + down[left].up[1] - here[left].up[1];
                *g = px * along_x + py * along_y;
            }
        });
        gradient
    }

    /// Gradients with respect to the slopes of each square's triangles.
    fn pulls(&self, z: &[f32], potential: &[f32]) -> Vec<Square> {
        let each = |k: usize| {
            let square = self.square(z, k % self.n, k / self.n);
            let [low, up] = [square.low, square.up].map(|s| {
                let (_, [x, y]) = self.bins.read(potential, self.bins.place(s[0], s[1]));
                self.bins.to_slope([self.mass * x, self.mass * y])
            });
            Square { low, up }
        };
        (0..self.n * self.n).into_par_iter().with_min_len(1 << 12).map(each).collect()
    }

    /// The same with fillets in the valleys.
    ///
    /// With b the bites and S their sum at a triangle, the value is Σ max(0, 1 - S) φ(s) over triangles plus
    /// Σ b (1/max(1, S) + 1/max(1, S')) φ̄ over edges, φ̄ the mean of the potential on the way between the slopes. A
    /// bite grows at the price V of either triangle: V = φ(s), or Σ b φ̄ / S² where the triangle is eaten up.
    fn pulls_as_cut(&self, z: &[f32], potential: &[f32], bites: &BiteGrid, fee: f32) -> Vec<Square> {
        let (n, bins) = (self.n, &self.bins);
        let place = |s: [f32; 2]| bins.place(s[0], s[1]);
        let strips: Vec<[Strip; 3]> = (0..n * n)
            .into_par_iter()
            .with_min_len(1 << 10)
            .map(|k| {
                let (i, j) = (k % n, k / n);
                let square = self.square(z, i, j);
                let (low, up) = (place(square.low), place(square.up));
                std::array::from_fn(|edge| {
                    if bites.of[k][edge] <= 0.0 {
                        return Strip::default();
                    }
                    Strip::read(bins, potential, self.across(z, i, j, edge), if edge == 2 { up } else { low })
                })
            })
            .collect();
        let price = |edges: [(usize, usize); 3], value: f32| {
            let sum: f32 = edges.iter().map(|&(k, e)| bites.of[k][e]).sum();
            let spent = || edges.iter().map(|&(k, e)| bites.of[k][e] * strips[k][e].mean).sum::<f32>();
            if sum < 1.0 { value } else { spent() / (sum * sum) }
        };
        // For every square: its own triangles; and, as `low` and `up`, what its bottom and its left edge do to the upper
        // triangles beyond them.
        let parts: Vec<(Square, Square)> = (0..n * n)
            .into_par_iter()
            .with_min_len(1 << 10)
            .map(|k| {
                let (i, j) = (k % n, k / n);
                let square = self.square(z, i, j);
                let (low_value, low_pull) = bins.read(potential, place(square.low));
                let (up_value, up_pull) = bins.read(potential, place(square.up));
                let kept = |sum: f32, [x, y]: [f32; 2]| {
                    let share = self.mass * (1.0 - sum).max(0.0);
                    bins.to_slope([share * x, share * y])
                };
                let mut own = Square { low: kept(bites.low(i, j), low_pull), up: kept(bites.up(i, j), up_pull) };
                let mut other = Square { low: [0.0; 2], up: [0.0; 2] };
                for edge in (0..3).filter(|&e| bites.of[k][e] > 0.0) {
                    let strip = strips[k][edge];
                    let mass = self.mass * bites.mass(i, j, edge);
                    let [near, far] = [strip.near, strip.far].map(|g| bins.to_slope([mass * g[0], mass * g[1]]));
                    let worth = || {
                        let (x, y) = bites.beyond(i, j, edge);
                        let prices = if edge == 2 {
                            price(bites.up_edges(i, j), up_value) + price(bites.low_edges(i, j), low_value)
                        } else {
                            let across = bins.read(potential, self.across(z, i, j, edge)).0;
                            price(bites.low_edges(i, j), low_value) + price(bites.up_edges(x, y), across)
                        };
                        bites.pieces(i, j, edge) * strip.mean - prices
                    };
                    let grow = self.mass * self.growth(z, k, edge, bites.of[k][edge], fee, worth);
                    let fold = FOLD[edge];
                    let (to_near, to_far) = match edge {
                        0 => (&mut own.low, &mut other.low),
                        1 => (&mut own.low, &mut other.up),
                        _ => (&mut own.up, &mut own.low),
                    };
                    for axis in 0..2 {
                        to_near[axis] += near[axis] + fold[axis] * grow;
                        to_far[axis] += far[axis] - fold[axis] * grow;
                    }
                }
                (own, other)
            })
            .collect();
        (0..n * n)
            .into_par_iter()
            .with_min_len(1 << 12)
            .map(|k| {
                let (i, j) = (k % n, k / n);
                let mut square = parts[k].0;
                let (above, right) = (&parts[(j + 1) % n * n + i].1, &parts[j * n + (i + 1) % n].1);
                for axis in 0..2 {
                    square.up[axis] += above.low[axis] + right.up[axis];
                }
                square
            })
            .collect()
    }

    fn square(&self, z: &[f32], i: usize, j: usize) -> Square {
        let n = self.n;
        let (right, top) = (if i + 1 == n { 0 } else { i + 1 }, if j + 1 == n { 0 } else { j + 1 });
        let [z00, z10, z01, z11] = [z[j * n + i], z[j * n + right], z[top * n + i], z[top * n + right]];
        let [px, py] = self.per_mm;
        Square { low: [px * (z10 - z00), py * (z01 - z00)], up: [px * (z11 - z01), py * (z11 - z10)] }
    }

    /// The place of the triangle on the far side of a square's bottom, left or diagonal edge.
    fn across(&self, z: &[f32], i: usize, j: usize, edge: usize) -> Place {
        let n = self.n;
        let slope = match edge {
            0 => self.square(z, i, if j == 0 { n - 1 } else { j - 1 }).up,
            1 => self.square(z, if i == 0 { n - 1 } else { i - 1 }, j).up,
            _ => self.square(z, i, j).low,
        };
        self.bins.place(slope[0], slope[1])
    }

    /// How the value changes with the fold of an edge whose bite is worth `worth`, in masses of a triangle.
    fn growth(&self, z: &[f32], k: usize, edge: usize, bite: f32, fee: f32, worth: impl Fn() -> f32) -> f32 {
        let Some(edges) = self.edges else { return 0.0 };
        let grows = bite > edges.least[edge];
        let turns = grows || (fee > 0.0 && self.fold(z, k % self.n, k / self.n, edge) > 0.0);
        let rate = if grows { worth() } else { 0.0 } + if turns { 2.0 * fee } else { 0.0 };
        edges.per_fold[edge] * rate
    }

    /// How much the relief turns upward across an edge; less than 0 at a ridge.
    fn fold(&self, z: &[f32], i: usize, j: usize, edge: usize) -> f32 {
        let n = self.n;
        let here = self.square(z, i, j);
        let (near, far) = match edge {
            0 => (here.low, self.square(z, i, if j == 0 { n - 1 } else { j - 1 }).up),
            1 => (here.low, self.square(z, if i == 0 { n - 1 } else { i - 1 }, j).up),
            _ => (here.up, here.low),
        };
        FOLD[edge][0] * (near[0] - far[0]) + FOLD[edge][1] * (near[1] - far[1])
    }

    fn bites(&self, z: &[f32]) -> Option<BiteGrid> {
        let edges = self.edges?;
        let n = self.n;
        let of = (0..n * n)
            .into_par_iter()
            .with_min_len(1 << 12)
            .map(|k| {
                let bite = |e: usize| edges.per_fold[e] * self.fold(z, k % n, k / n, e);
                std::array::from_fn(|e| bite(e).max(edges.least[e]))
            })
            .collect();
        Some(BiteGrid { n, of })
    }
}

/// How the fold of a bottom, left and diagonal edge is read off the difference of the slopes (p, q) on its two sides.
const FOLD: [[f32; 2]; 3] = [[0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];

/// The potential on the way between the slopes of two neighbours.
#[derive(Clone, Copy, Default)]
struct Strip {
    mean: f32,
    /// How the mean changes with the near and with the far slope.
    near: [f32; 2],
    far: [f32; 2],
}

impl Strip {
    fn read(bins: &Bins, potential: &[f32], from: Place, to: Place) -> Self {
        let (pieces, points) = bins.walk(from, to);
        let each = 1.0 / pieces as f32;
        let mut strip = Self::default();
        for (t, at) in points {
            let (value, pull) = bins.read(potential, at);
            strip.mean += each * value;
            for (axis, pull) in pull.into_iter().enumerate() {
                strip.near[axis] += each * t * pull;
                strip.far[axis] += each * (1.0 - t) * pull;
            }
        }
        strip
    }
}

/// All bites of a grid.
struct BiteGrid {
    n: usize,
    of: Vec<Bites>,
}

impl BiteGrid {
    /// The edges of a square's lower triangle, as (square, edge).
    fn low_edges(&self, i: usize, j: usize) -> [(usize, usize); 3] {
        let k = j * self.n + i;
        [(k, 0), (k, 1), (k, 2)]
    }

    /// The edges of a square's upper triangle.
    fn up_edges(&self, i: usize, j: usize) -> [(usize, usize); 3] {
        let n = self.n;
        let (right, top) = (if i + 1 == n { 0 } else { i + 1 }, if j + 1 == n { 0 } else { j + 1 });
        [(top * n + i, 0), (j * n + right, 1), (j * n + i, 2)]
    }

    fn sum(&self, edges: [(usize, usize); 3]) -> f32 {
        edges.iter().map(|&(k, e)| self.of[k][e]).sum()
    }

    fn low(&self, i: usize, j: usize) -> f32 {
        self.sum(self.low_edges(i, j))
    }

    fn up(&self, i: usize, j: usize) -> f32 {
        self.sum(self.up_edges(i, j))
    }

    /// The square whose upper triangle lies beyond a bottom or left edge.
    fn beyond(&self, i: usize, j: usize, edge: usize) -> (usize, usize) {
        let n = self.n;
        match edge {
            0 => (i, if j == 0 { n - 1 } else { j - 1 }),
            1 => (if i == 0 { n - 1 } else { i - 1 }, j),
            _ => (i, j),
        }
    }

    /// Of one bite, how much both sides of an edge together really give.
    fn pieces(&self, i: usize, j: usize, edge: usize) -> f32 {
        let (x, y) = self.beyond(i, j, edge);
        let (near, far) = if edge == 2 { (self.up(i, j), self.low(i, j)) } else { (self.low(i, j), self.up(x, y)) };
        1.0 / near.max(1.0) + 1.0 / far.max(1.0)
    }

    /// The fillet of an edge, in triangles.
    fn mass(&self, i: usize, j: usize, edge: usize) -> f32 {
        let bite = self.of[j * self.n + i][edge];
        if bite > 0.0 { bite * self.pieces(i, j, edge) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests;
