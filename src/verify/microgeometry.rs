//! What a relief is as microgeometry: the distribution of its normals, and how much of it is seen from a direction.
//!
//! The two halves of every microfacet model, here of the real surface: D(m), the area of facets per steradian of
//! normals and per area of plate, is known exactly; G₁, the share of what faces a direction that is seen from there,
//! is found with rays. For an endless relief the area seen is that of the plate itself, so that the mean G₁ is
//! cosθ over the projected area of all that faces the direction (Heitz, "Understanding the Masking-Shadowing Function",
//! JCGT 2014, eq. 14): a known answer.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use super::first_bounce::{Beams, scattered};
use crate::progress::{Cancelled, Progress};
use crate::slope::{direction, flat_mirror, polar_angle};
use crate::trace::{Hit, Surface};

/// The distribution of a relief's normals on a grid of directions.
///
/// Column k of `columns` holds polar angles with sqrt(2θ/π) from k/columns on, row j of `rows` azimuths from
/// -π + 2π j/rows on: the grid of [`BrdfAxes`](super::goniometer::table::BrdfAxes).
#[derive(Clone, Debug, PartialEq)]
pub struct NormalDistribution {
    /// Cells along the polar angle.
    pub columns: usize,
    /// Cells along the azimuth.
    pub rows: usize,
    /// Mean D over each cell, 1/sr: ∫ D (m·z) dm = 1 over all normals that face up.
    pub density: Vec<f64>,
    /// Root mean square of the slope along x and y.
    pub rms_slope: [f64; 2],
    /// Share of the surface's area beyond that of the plate.
    pub excess_area: f64,
}

impl NormalDistribution {
    /// Counts every facet. `None` if the surface cannot list its facets.
    pub fn of<S: Surface>(surface: &S, columns: usize, rows: usize) -> Option<Self> {
        let mut density = vec![0.0; columns * rows];
        let (mut plate, mut area, mut squares) = (0.0, 0.0, [0.0; 2]);
        for (place, footprint) in (0..surface.facets()).filter_map(|k| surface.facet(k)) {
            let m = surface.normal(place);
            plate += footprint;
            area += footprint / m.z;
            squares[0] += footprint * (m.x / m.z).powi(2);
            squares[1] += footprint * (m.y / m.z).powi(2);
            let u = (polar_angle(m) / FRAC_PI_2).sqrt();
            let v = (m.y.atan2(m.x) + PI) / TAU;
            let cell = |at: f64, n: usize| ((at * n as f64) as usize).min(n - 1);
            density[cell(v, rows) * columns + cell(u, columns)] += footprint / m.z;
        }
        for (index, d) in density.iter_mut().enumerate() {
            let edge = |k: usize| FRAC_PI_2 * (k as f64 / columns as f64).powi(2);
            let column = index % columns;
            let solid_angle = (edge(column).cos() - edge(column + 1).cos()) * TAU / rows as f64;
            *d /= plate * solid_angle;
        }
        let rms_slope = squares.map(|square| (square / plate).sqrt());
        (plate > 0.0).then(|| Self { columns, rows, density, rms_slope, excess_area: area / plate - 1.0 })
    }
}

/// How much of a relief is seen from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Masking {
    /// Polar angle of the direction, radians.
    pub theta: f64,
    /// Its azimuth, radians.
    pub phi: f64,
    /// Share of the projected area facing the direction that is seen from there.
    pub seen: f64,
    /// Standard error of that share.
    pub error: f64,
    /// What it would be on an endless relief without walls, in closed form.
    pub endless: f64,
    /// Share of what faces both the direction and its mirror direction, (θ, φ + 180°), that is seen from both: the
    /// masking and shadowing of light that comes from the one and leaves toward the other.
    pub both: f64,
}

/// Directions whose masking is told: polar angles in steps of 5° up to 85°, four azimuths.
pub fn masking<S: Surface>(surface: &S, rays: u64, seed: u64, progress: &Progress) -> Result<Vec<Masking>, Cancelled> {
    let directions = (0..4 * 18).map(|k| (f64::to_radians(5.0 * f64::from(k % 18)), FRAC_PI_2 * f64::from(k / 18)));
    directions
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(theta, phi)| seen(surface, theta, phi, rays, seed, progress))
        .collect()
}

fn seen<S: Surface>(
    surface: &S,
    theta: f64,
    phi: f64,
    rays: u64,
    seed: u64,
    progress: &Progress,
) -> Result<Masking, Cancelled> {
    let toward: DVec3 = direction(theta, phi);
    let beams = Beams::new(surface, toward, progress)?;
    let step = beams.whole() / rays.max(1) as f64;
    let back = flat_mirror(toward);
    let (mut samples, mut clear, mut facing, mut clear_both) = (0u64, 0u64, 0u64, 0u64);
    for k in 0..surface.facets() {
        if k % FACETS_A_QUESTION == 0 {
            progress.check()?;
        }
        let Some((place, _)) = surface.facet(k) else { continue };
        for (shift, m) in beams.samples(k, step, seed) {
            samples += 1;
            let hit = Hit { point: surface.point_on(k, scattered(shift, m)), place };
            let seen = surface.next(&hit, toward).is_none();
            clear += u64::from(seen);
            if back.dot(surface.normal(place)) > 0.0 {
                facing += 1;
                clear_both += u64::from(seen && surface.next(&hit, back).is_none());
            }
        }
    }
    let seen = clear as f64 / samples.max(1) as f64;
    let plate: f64 = (0..surface.facets()).filter_map(|k| surface.facet(k)).map(|(_, footprint)| footprint).sum();
    let both = clear_both as f64 / facing.max(1) as f64;
    Ok(Masking {
        both,
        theta,
        phi,
        seen,
        error: (seen * (1.0 - seen) / samples.max(1) as f64).sqrt(),
        endless: plate / beams.whole(),
    })
}

/// Facets, each with its rays, between two questions whether to go on.
const FACETS_A_QUESTION: usize = 1 << 12;

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::relief::faceted::{Facet, FacetedRelief};
    use crate::slope::Slope;
    use crate::trace::grid::GridSurface;

    #[test]
    fn normals_are_counted_with_their_area() {
        let facets = [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.4), (0.0, 0.0)];
        let facets = facets.map(|(p, q)| Facet { height: 0.0, slope: Slope::new(p, q) }).to_vec();
        let surface =
            GridSurface::new(&FacetedRelief::uniform(4, 1, DVec2::new(4.0, 1.0), facets), &Progress::silent()).unwrap();
        let ndf = NormalDistribution::of(&surface, 64, 32).unwrap();
        // ∫ D (m·z) dm = 1, with the cosine at each cell's middle.
        let whole: f64 = (0..64 * 32)
            .map(|k| {
                let edge = |k: usize| FRAC_PI_2 * (k as f64 / 64.0).powi(2);
                let (a, b) = (edge(k % 64), edge(k % 64 + 1));
                ndf.density[k] * (a.cos() - b.cos()) * TAU / 32.0 * (0.5 * (a + b)).cos()
            })
            .sum();
        assert!((whole - 1.0).abs() < 0.01, "{whole}");
        assert!((ndf.rms_slope[0] - (0.09f64 / 2.0).sqrt()).abs() < 1e-12);
        assert!((ndf.rms_slope[1] - 0.2).abs() < 1e-12);
        let excess = (2.0 * 1.09f64.sqrt() + 1.16f64.sqrt() + 1.0) / 4.0 - 1.0;
        assert!((ndf.excess_area - excess).abs() < 1e-12);
    }

    #[test]
    fn an_endless_continuous_relief_shows_as_much_as_its_plate() {
        // Roofs: no walls, so that all that faces a direction is facets.
        let facets = (0..6)
            .map(|k| Facet { height: 0.0, slope: Slope::new(if k % 2 == 0 { 0.7 } else { -0.7 }, 0.0) })
            .collect();
        let panel =
            GridSurface::panel(&FacetedRelief::uniform(6, 1, DVec2::new(6.0, 1.0), facets), &Progress::silent())
                .unwrap();
        let rows = masking(&panel, 20_000, 1, &Progress::silent()).unwrap();
        for row in &rows {
            let z = (row.seen - row.endless) / row.error.max(1e-4);
            assert!(z.abs() < 4.0, "{row:?}");
        }
        assert!(rows.iter().any(|row| row.endless < 0.5), "nothing was hidden");
    }

    #[test]
    fn walls_hide_facets_from_low_directions_only() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        let facets = (0..64).map(|_| Facet { height: random.random::<f64>(), slope: Slope::FLAT }).collect();
        let surface =
            GridSurface::new(&FacetedRelief::uniform(8, 8, DVec2::splat(8.0), facets), &Progress::silent()).unwrap();
        let rows = masking(&surface, 10_000, 1, &Progress::silent()).unwrap();
        assert_eq!((rows[0].seen, rows[0].both), (1.0, 1.0));
        assert!(
            rows.iter().all(|row| row.both <= row.seen + 4.0 * row.error),
            "more is seen from two sides than from one"
        );
        assert!((0.3..0.7).contains(&rows[17].seen), "{:?}", rows[17]);
        assert!(rows.windows(2).take(17).all(|w| w[1].seen <= w[0].seen + 0.01));
    }
}
