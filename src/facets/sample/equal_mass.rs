//! Centroidal cells of equal mass, whose centres stand for facets of equal area.
//!
//! Plain weighted Voronoi stippling lets the cells' masses drift apart, and facets all have the same area. Here the
//! density becomes many atoms of one mass, every cell owns the same number of them throughout, and neighbouring
//! cells redivide their atoms by the line across their centres until nothing moves. Where no pair can gain, the
//! cells are those of a power diagram with equal masses and sites at the centroids, the optimum of semi-discrete
//! transport (Balzer, Schlömer, Deussen, "Capacity-constrained point distributions", SIGGRAPH 2009;
//! Aurenhammer, Hoffmann, Aronov 1998).

use glam::{DVec2, Vec2};

use super::kd;
use super::nearest::{MOST, neighbours};
use crate::progress::Progress;
use crate::raster::Raster;

/// Centres of `n` centroidal cells of equal mass under `density` (sum 1), on the image plane [-1, 1]².
pub fn equal_mass_centres(density: &Raster, n: usize, progress: &Progress) -> Vec<DVec2> {
    let size = atoms_per_cell(n);
    let mut atoms = equal_mass_atoms(density, n * size);
    if kd::group(&mut atoms, size, &|atom| atom.as_dvec2(), &progress.until_finish()).is_err() {
        // There are no cells yet: atoms as heavy as they would be stand for them.
        return equal_mass_atoms(density, n).iter().map(|atom| atom.as_dvec2()).collect();
    }
    let mut centres: Vec<Vec2> = atoms.chunks(size).map(centroid).collect();
    let mut scratch = Vec::with_capacity(2 * size);
    for sweep in 0..SWEEPS {
        progress.fraction(sweep as f64 / SWEEPS as f64);
        if progress.is_to_finish() {
            break;
        }
        let mut moved = 0.0f64;
        let Ok(pairs) = neighbours(&centres, MOST, &progress.until_finish()) else { break };
        for (k, (a, b)) in pairs.into_iter().enumerate() {
            if k.is_multiple_of(PAIRS_A_QUESTION) && progress.is_to_finish() {
                break;
            }
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
        let spreads = atoms.chunks(size).zip(&centres).map(|(cell, c)| f64::from(spread(cell, *c)));
        if moved < STILL * spreads.sum::<f64>() {
            break;
        }
    }
    snap_to_own_atoms(&atoms, &mut centres, size);
    centres.iter().map(|c| c.as_dvec2()).collect()
}

/// Moves each centre that is farther from all of its cell's atoms than the median cell is wide to the nearest of them.
///
/// Where bright regions hold no whole number of facets' mass, a cell reaches across the dark between two of them, and
/// its centroid would lie in the dark.
fn snap_to_own_atoms(atoms: &[Vec2], centres: &mut [Vec2], size: usize) {
    let mut spreads: Vec<f32> = atoms.chunks(size).zip(&*centres).map(|(cell, c)| spread(cell, *c)).collect();
    let middle = spreads.len() / 2;
    let (_, &mut usual, _) = spreads.select_nth_unstable_by(middle, f32::total_cmp);
    for (centre, cell) in centres.iter_mut().zip(atoms.chunks(size)) {
        let away = |atom: &&Vec2| atom.distance_squared(*centre);
        match cell.iter().min_by(|a, b| away(a).total_cmp(&away(b))) {
            Some(nearest) if away(&nearest) > usual => *centre = *nearest,
            _ => {}
        }
    }
}

/// Pairs exchanged between two questions whether to go on.
const PAIRS_A_QUESTION: usize = 1024;

/// Sweeps over all neighbouring pairs, at most. Pictures come to rest by [`STILL`] in fewer; the bound is for densities
/// whose cells drift for long along a line.
const SWEEPS: usize = 24;

/// Sum of squared moves in a sweep, as a share of the sum of the cells' spreads, that ends the sweeps:
/// centres then move by a thirtieth of their cell's radius, and the refinement that follows moves them farther.
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

/// Mean squared distance of a cell's atoms from its centre.
fn spread(cell: &[Vec2], centre: Vec2) -> f32 {
    cell.iter().map(|a| a.distance_squared(centre)).sum::<f32>() / cell.len() as f32
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::arrange::assignment::cheapest_assignment;
    use crate::projection::View;

    fn centres(density: &Raster, n: usize) -> Vec<DVec2> {
        equal_mass_centres(density, n, &Progress::silent())
    }

    /// Squared transport distance from equal masses at `points` to the even square [-1, 1]², divided by the least
    /// that any points reach: 5/(18√3) area/N (Fejes Tóth's hexagons). 1024 pixels of one mass are assigned exactly;
    /// within a pixel of side h the light spreads by h²/6.
    fn w2_above_bound(points: &[DVec2]) -> f64 {
        const SIDE: usize = 32;
        let each = SIDE * SIDE / points.len();
        let pixel = |k: usize| View::pixel_centre(k % SIDE, k / SIDE, SIDE, SIDE);
        let n = SIDE * SIDE;
        let cost: Vec<f64> = (0..n * n).map(|k| pixel(k / n).distance_squared(points[k % n / each])).collect();
        let total: f64 = cheapest_assignment(n, &cost, &Progress::silent())
            .iter()
            .enumerate()
            .map(|(row, &to)| cost[row * n + to])
            .sum();
        let h = 2.0 / SIDE as f64;
        let bound = 5.0 / (18.0 * 3f64.sqrt()) * 4.0 / points.len() as f64;
        ((total / n as f64 + h * h / 6.0) / bound).sqrt()
    }

    #[test]
    fn cells_are_nearly_as_compact_as_hexagons() {
        let even = Raster::from_fn(16, 16, |_, _| 1.0 / 256.0);
        let ratio = w2_above_bound(&centres(&even, 64));
        assert!((1.0..1.10).contains(&ratio), "{ratio}");
        // The measure itself: a square lattice has second moment 1/6, hexagons 5/(18√3).
        let lattice: Vec<DVec2> = (0..64).map(|k| View::pixel_centre(k % 8, k / 8, 8, 8)).collect();
        let square = (18.0 * 3f64.sqrt() / 30.0).sqrt();
        assert!((w2_above_bound(&lattice) - square).abs() < 1e-9, "{}", w2_above_bound(&lattice));
    }

    #[test]
    fn atoms_share_the_mass_of_any_density_evenly() {
        let density = Raster::from_fn(24, 17, |x, y| if x < 6 { 0.0 } else { (x * y) as f64 });
        let density = density.normalised();
        for count in [1, 100, 20_000] {
            let atoms = equal_mass_atoms(&density, count);
            assert_eq!(atoms.len(), count);
            // No pixel is off by more than one atom, nor any quarter of the picture by more than a few.
            let mut counts = vec![0.0; 24 * 17];
            for atom in &atoms {
                let (x, y) = View::pixel_at(atom.as_dvec2(), 24, 17).unwrap();
                counts[y * 24 + x] += 1.0;
            }
            for (got, wanted) in counts.iter().zip(&density.values) {
                assert!((got - wanted * count as f64).abs() <= 1.0 + 1e-3 * count as f64 * wanted, "{got} {wanted}");
            }
        }
    }

    #[test]
    fn a_planted_density_is_divided_into_equal_masses() {
        // Density ∝ 1 + u over the square: the mass left of u is (1+u)²/4, so ranks of u tell if masses are equal.
        let density = Raster::from_fn(64, 64, |x, _| x as f64 + 0.5).normalised();
        let points = centres(&density, 256);
        let mut ranks: Vec<f64> = points.iter().map(|p| (1.0 + p.x).powi(2) / 4.0).collect();
        ranks.sort_by(f64::total_cmp);
        let worst = ranks.iter().enumerate().map(|(k, r)| (r - (k as f64 + 0.5) / 256.0).abs()).fold(0.0, f64::max);
        // A column of the sixteen or so holds a sixteenth, and ranks within it are a matter of shape.
        assert!(worst < 0.04, "{worst}");
        let mean = points.iter().sum::<DVec2>() / 256.0;
        assert!(mean.distance(DVec2::new(1.0 / 3.0, 0.0)) < 2e-3, "{mean}");
    }
}
