//! Centroidal cells of equal mass: the paper's stippling done right for equal facets.
//!
//! Plain weighted Voronoi stippling lets the cells' masses drift apart, and facets all have the same area. Here the
//! density becomes many atoms of one mass, every cell owns the same number of them throughout, and neighbouring
//! cells redivide their atoms by the line across their centres until nothing moves. Where no pair can gain, the
//! cells are those of a power diagram with equal masses and sites at the centroids, the optimum of semi-discrete
//! transport (Balzer, Schlömer, Deussen, "Capacity-constrained point distributions", SIGGRAPH 2009;
//! Aurenhammer, Hoffmann, Aronov 1998).

use glam::{DVec2, Vec2};

use super::kd;
use crate::progress::Progress;
use crate::raster::Raster;

/// Centres of `n` centroidal cells of equal mass under `density` (sum 1), on the image plane [-1, 1]².
pub fn equal_mass_centres(density: &Raster, n: usize, progress: &Progress) -> Vec<DVec2> {
    let size = atoms_per_cell(n);
    let mut atoms = equal_mass_atoms(density, n * size);
    kd::group(&mut atoms, size, &|atom| atom.as_dvec2());
    let mut centres: Vec<Vec2> = atoms.chunks(size).map(centroid).collect();
    let mut scratch = Vec::with_capacity(2 * size);
    for sweep in 0..SWEEPS {
        progress.fraction(sweep as f64 / SWEEPS as f64);
        let mut moved = 0.0f64;
        for (a, b) in neighbours(&centres) {
            let axis = centres[b] - centres[a];
            scratch.clear();
            scratch.extend(atoms[a * size..][..size].iter().chain(&atoms[b * size..][..size]));
            scratch.select_nth_unstable_by(size, |x: &Vec2, y: &Vec2| x.dot(axis).total_cmp(&y.dot(axis)));
            atoms[a * size..][..size].copy_from_slice(&scratch[..size]);
            atoms[b * size..][..size].copy_from_slice(&scratch[size..]);
            let (old_a, old_b) = (centres[a], centres[b]);
            centres[a] = centroid(&scratch[..size]);
            centres[b] = centroid(&scratch[size..]);
            moved += f64::from(old_a.distance_squared(centres[a]) + old_b.distance_squared(centres[b]));
        }
        if moved < STILL * cell_area(&atoms, &centres, size) {
            break;
        }
    }
    centres.iter().map(|c| c.as_dvec2()).collect()
}

/// Sweeps over all neighbouring pairs, at most.
const SWEEPS: usize = 24;

/// Sum of squared moves in a sweep, as a share of the sum of squared distances in the cells, that ends the sweeps.
const STILL: f64 = 1e-3;

/// More atoms draw the cells' borders finer; at a million facets memory and time matter more.
fn atoms_per_cell(n: usize) -> usize {
    match n {
        0..=2_000 => 64,
        2_001..=20_000 => 32,
        _ => 16,
    }
}

fn centroid(atoms: &[Vec2]) -> Vec2 {
    atoms.iter().sum::<Vec2>() / atoms.len() as f32
}

fn cell_area(atoms: &[Vec2], centres: &[Vec2], size: usize) -> f64 {
    let squared = |(cell, c): (&[Vec2], &Vec2)| cell.iter().map(|a| a.distance_squared(*c)).sum::<f32>() / size as f32;
    atoms.chunks(size).zip(centres).map(|pair| f64::from(squared(pair))).sum()
}

/// `count` atoms of equal mass. Pixels are visited along a Hilbert curve and the running mass is cut at equal steps,
/// so every compact patch gets its share within about one atom; inside a pixel the atoms follow the R2 sequence.
fn equal_mass_atoms(density: &Raster, count: usize) -> Vec<Vec2> {
    let (width, height) = (density.width as u32, density.height as u32);
    let side = width.max(height).max(2).next_power_of_two();
    let total = density.sum();
    let mut atoms = Vec::with_capacity(count);
    let mut running = 0.0;
    for h in 0..u64::from(side) * u64::from(side) {
        let (column, row): (u32, u32) = fast_hilbert::h2xy(h, side.trailing_zeros() as u8);
        if column >= width || row >= height {
            continue;
        }
        running += density.at(column as usize, row as usize);
        let reached = ((running / total * count as f64 + 0.5) as usize).min(count);
        while atoms.len() < reached {
            let k = atoms.len() as f64;
            let (right, down) = ((0.5 + k * R2.0).fract(), (0.5 + k * R2.1).fract());
            atoms.push(Vec2::new(
                ((f64::from(column) + right) / f64::from(width) * 2.0 - 1.0) as f32,
                (1.0 - (f64::from(row) + down) / f64::from(height) * 2.0) as f32,
            ));
        }
    }
    // Rounding in the running sum may leave the last atom out.
    while let (true, Some(&last)) = (atoms.len() < count, atoms.last()) {
        atoms.push(last);
    }
    atoms
}

/// 1/g and 1/g² of the plastic number g: the R2 low-discrepancy sequence (Roberts 2018).
const R2: (f64, f64) = (0.754_877_666_246_692_8, 0.569_840_290_998_053_3);

/// Pairs of cells that are near: each with its eight nearest. A grid of bins holds about two centres a bin where the
/// centres are dense.
fn neighbours(centres: &[Vec2]) -> Vec<(usize, usize)> {
    let mut pairs = Vec::with_capacity(8 * centres.len());
    let tree = Bins::new(centres);
    let mut near = Vec::new();
    for a in 0..centres.len() {
        tree.nearest(centres, a, NEAREST, &mut near);
        pairs.extend(near.iter().map(|&(_, b)| (a.min(b), a.max(b))));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

const NEAREST: usize = 8;

/// Centres sorted into square bins.
struct Bins {
    side: usize,
    low: Vec2,
    per_length: f32,
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Bins {
    fn new(centres: &[Vec2]) -> Self {
        let low = centres.iter().fold(Vec2::INFINITY, |m, c| m.min(*c));
        let high = centres.iter().fold(Vec2::NEG_INFINITY, |m, c| m.max(*c));
        let side = ((centres.len() as f32 / 2.0).sqrt().ceil() as usize).max(1);
        let per_length = side as f32 / (high - low).max_element().max(1e-6);
        let mut bins =
            Self { side, low, per_length, starts: vec![0; side * side + 1], members: vec![0; centres.len()] };
        let bin: Vec<usize> = centres.iter().map(|c| bins.index(bins.cell(*c))).collect();
        bin.iter().for_each(|&b| bins.starts[b + 1] += 1);
        for b in 0..side * side {
            bins.starts[b + 1] += bins.starts[b];
        }
        let mut next = bins.starts.clone();
        for (k, &b) in bin.iter().enumerate() {
            bins.members[next[b] as usize] = k as u32;
            next[b] += 1;
        }
        bins
    }

    fn cell(&self, at: Vec2) -> (usize, usize) {
        let cell = ((at - self.low) * self.per_length).max(Vec2::ZERO);
        ((cell.x as usize).min(self.side - 1), (cell.y as usize).min(self.side - 1))
    }

    fn index(&self, (x, y): (usize, usize)) -> usize {
        y * self.side + x
    }

    /// The `count` centres nearest to centre `a`, with their squared distances, searched ring by ring.
    fn nearest(&self, centres: &[Vec2], a: usize, count: usize, near: &mut Vec<(f32, usize)>) {
        near.clear();
        let (x, y) = self.cell(centres[a]);
        for ring in 0..self.side {
            let (x0, x1) = (x.saturating_sub(ring), (x + ring).min(self.side - 1));
            let (y0, y1) = (y.saturating_sub(ring), (y + ring).min(self.side - 1));
            for by in y0..=y1 {
                let whole_row = by + ring == y || by == y + ring;
                let step = if whole_row || ring == 0 { 1 } else { (2 * ring).max(1) };
                let first = if whole_row {
                    x0
                } else if x >= ring {
                    x - ring
                } else {
                    x + ring
                };
                for bx in (first..=x1).step_by(step) {
                    let bin = self.index((bx, by));
                    for &b in &self.members[self.starts[bin] as usize..self.starts[bin + 1] as usize] {
                        if b as usize != a {
                            near.push((centres[a].distance_squared(centres[b as usize]), b as usize));
                        }
                    }
                }
            }
            if near.len() >= count {
                near.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
                near.truncate(count);
                // All centres not yet seen are at least this far away.
                let seen = ring as f32 / self.per_length;
                if near[count - 1].0 <= seen * seen {
                    return;
                }
            }
        }
        near.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        near.truncate(count);
    }
}
