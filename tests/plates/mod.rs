//! Reliefs that tempt a mesher, each from a seed.

pub mod waves;

use facetmill::relief::faceted::{Facet, FacetedRelief};
use facetmill::slope::Slope;
use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Ways to shape a plate.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// One flat face.
    Flat,
    /// The facets of a smooth dome, not quite in order: small steps that change sign along most edges.
    Dome,
    /// A plane of one slope: no steps but those of rounding.
    Ramp,
    /// Heights and slopes at random, walls many cells tall.
    Random,
    /// Flat tops at heights 0 to 2 cells: ties and alternating corners everywhere.
    Integers,
    /// The same with slopes of whole eighths, so that edges meet and cross at equal heights.
    Eighths,
    /// Flat tops, high and low by turns: every inner corner alternates, with equal tops.
    Checkerboard,
    /// A dome with steps of a few millionths of a cell, just below and above what is snapped.
    Nudged,
}

/// Every shape.
pub const ALL: [Shape; 8] = [
    Shape::Flat,
    Shape::Dome,
    Shape::Ramp,
    Shape::Random,
    Shape::Integers,
    Shape::Eighths,
    Shape::Checkerboard,
    Shape::Nudged,
];

/// A plate of `columns` × `rows` cells of about `cell` mm, not square, its first grid lines uneven, its heights near `level` mm.
pub fn plate(shape: Shape, columns: usize, rows: usize, cell: f64, level: f64, seed: u64) -> FacetedRelief {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut facets = Vec::new();
    let (middle, scale) = (DVec2::new(columns as f64, rows as f64) / 2.0, 0.4 / columns.max(rows) as f64);
    for k in 0..columns * rows {
        let (i, j) = (k % columns, k / columns);
        let at = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) - middle;
        let mut noise = |span: f64| span * (random.random::<f64>() - 0.5);
        let (height, p, q) = match shape {
            Shape::Flat => (0.25, 0.0, 0.0),
            Shape::Dome => (-0.5 * scale * at.length_squared(), noise(0.02) - scale * at.x, noise(0.02) - scale * at.y),
            Shape::Ramp => (0.3 * at.x - 0.11 * at.y, 0.3, -0.11),
            Shape::Random => (noise(12.0), noise(1.5), noise(1.5)),
            Shape::Integers => ((noise(2.999) + 0.5).floor(), 0.0, 0.0),
            Shape::Eighths => ((noise(5.0)).round() / 4.0, noise(5.0).round() / 8.0, noise(5.0).round() / 8.0),
            Shape::Checkerboard => (((i + j) % 2) as f64, 0.0, 0.0),
            Shape::Nudged => {
                let height = -0.5 * scale * at.length_squared() + noise(1e-4);
                (height, noise(1e-4) - scale * at.x, noise(1e-4) - scale * at.y)
            }
        };
        facets.push(Facet { height: level + cell * height, slope: Slope::new(p, q) });
    }
    let size = cell * DVec2::new(columns as f64, rows as f64);
    let mut relief = FacetedRelief::uniform(columns, rows, size, facets);
    if matches!(shape, Shape::Random | Shape::Integers) && columns > 2 {
        relief.x[1] += 0.4 * cell;
    }
    relief
}
