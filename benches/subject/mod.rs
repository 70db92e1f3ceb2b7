//! What all benches work on: the portrait of the examples under plain settings.

use facetmill::distribution::{SlopeDistribution, SlopeDistributionSettings};
use facetmill::facets::SlopeGrid;
use facetmill::facets::heights::least_squares;
use facetmill::facets::sample::{Sampling, sample};
use facetmill::highlight::{Highlight, Quantity};
use facetmill::picture::{Reading, read};
use facetmill::progress::Progress;
use facetmill::projection::Projection;
use facetmill::raster::Raster;
use facetmill::relief::faceted::{Facet, FacetedRelief};
use facetmill::setup::Setup;
use facetmill::slope::Slope;
use glam::DVec2;

/// Light from straight above, 20° of half field.
pub fn setup() -> Setup {
    Setup::new(0.0, 0.0, 0.0, Projection::Orthographic, 20f64.to_radians())
}

/// The portrait's linear light.
pub fn light() -> Raster {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/highlights/portrait.png");
    read(path.as_ref(), &Reading::default()).unwrap().light
}

/// The slopes that show the portrait.
pub fn distribution() -> SlopeDistribution {
    let setup = setup();
    let highlight = Highlight::new(&light(), Quantity::Radiance, &setup).unwrap();
    SlopeDistribution::new(&highlight, &setup, &SlopeDistributionSettings::default(), |_| 1.0).unwrap()
}

/// `n` slopes of the portrait, quickly drawn, in no order.
pub fn slopes(n: usize) -> Vec<Slope> {
    let distribution = distribution();
    let points = sample(&distribution, n, Sampling::Sobol, 1, &Progress::silent());
    points.iter().map(|uv| distribution.setup.slope_at(*uv).unwrap()).collect()
}

/// A square grid that is nearly a dome: slopes fall across the plate, each a little off.
pub fn dome(side: usize) -> SlopeGrid {
    let slope = |k: usize| 0.17 * (1.0 - 2.0 * k as f64 / side as f64);
    let off = |i: usize, j: usize, k: usize| ((i * 7919 + j * 104_729 + k * 1_299_709) % 1009) as f64 / 1009.0 - 0.5;
    SlopeGrid::from_fn(side, side, |i, j| {
        let noise = 0.34 / side as f64;
        Slope::new(slope(i) + noise * off(i, j, 0), slope(j) + noise * off(i, j, 1))
    })
}

/// [`dome`] as a relief of 30 mm.
pub fn relief(side: usize) -> FacetedRelief {
    let grid = dome(side);
    let heights = least_squares(&grid, DVec2::splat(30.0 / side as f64), false);
    let facets = heights.iter().zip(&grid.slopes).map(|(&height, &slope)| Facet { height, slope }).collect();
    FacetedRelief::uniform(side, side, DVec2::splat(30.0), facets)
}
