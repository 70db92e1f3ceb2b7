//! Sampled facets are moved until their light, seen through a blur a little finer than their spacing, agrees with the
//! highlight.
//!
//! Points repel each other and are drawn to the drawing's light (electrostatic halftoning, Schmaltz et al. 2010):
//! the loss is Σ_k W(k) |light(k) - highlight(k)|² over spatial frequencies, W(k) = exp(-k²σ²) / (k² + k0²).
//! Below the facets' own spacing no arrangement of points can agree, so σ follows the spacing. Against the cells'
//! own centres this takes a quarter to a third off the total variation of photographs at a blur of that size.

use glam::DVec2;
use rustfft::num_complex::Complex64;

use crate::descent::{Descent, minimise};
use crate::distribution::SlopeDistribution;
use crate::fourier::{WaveTransform, even_smooth_size, frequency};
use crate::progress::Progress;

/// Standard deviation of the comparison's blur, in units of the facets' mean spacing. A finer one would ask the points
/// for detail that no arrangement of them has, a coarser one leaves gaps and heaps that the eye can see.
const BLUR: f64 = 0.6;

/// Grid pixels a blur. The blur's gain at the shortest wave of the grid is exp(-(1.6 π)²), nothing: finer grids give the
/// same loss and cost more.
const PIXELS_PER_BLUR: f64 = 1.6;

/// Length of wave, in units of the image side, beyond which the loss no longer grows with it: k0 of the loss. At twice
/// the side, light that lies at the wrong end of the picture weighs most and the mean, which no move changes, has a
/// finite weight.
const LONGEST_WAVE: f64 = 2.0;

/// `points` moved so that their blurred light agrees with the distribution's.
pub fn refined(distribution: &SlopeDistribution, points: Vec<DVec2>, progress: &Progress) -> Vec<DVec2> {
    let field = Field::new(distribution, points.len());
    let mut x: Vec<f64> = points.iter().flat_map(|p| [p.x, p.y]).collect();
    let settings = Descent { steps: 120, memory: 10, tolerance: 2e-4, first_move: 0.1 * field.spacing };
    // Told to finish, the points stay where they have come to.
    let _ = minimise(&mut x, &settings, |x, gradient| Ok(field.loss(x, gradient)), |_| !progress.is_to_finish());
    x.chunks(2).map(|p| DVec2::new(p[0], p[1])).collect()
}

/// The image plane with a margin, on a grid.
struct Field<'a> {
    distribution: &'a SlopeDistribution,
    spacing: f64,
    side: usize,
    pixel: f64,
    low: f64,
    target: Vec<f64>,
    waves: WaveTransform,
    gain: Vec<f64>,
}

impl<'a> Field<'a> {
    fn new(distribution: &'a SlopeDistribution, n: usize) -> Self {
        let flux = &distribution.flux;
        // The area that the light would fill if it were even: 1 / ∫ρ².
        let even = 4.0 / flux.values.len() as f64 / flux.values.iter().map(|f| f * f).sum::<f64>();
        let spacing = (even / n as f64).sqrt();
        let blur = (BLUR * spacing).max(PIXELS_PER_BLUR * 2.0 / FINEST as f64);
        let inner = ((2.0 * PIXELS_PER_BLUR / blur).ceil() as usize).clamp(32, FINEST);
        let pixel = 2.0 / inner as f64;
        let margin = (3.0 * blur / pixel).ceil() as usize;
        let side = even_smooth_size(inner + 2 * margin);
        let mut target = vec![0.0; side * side];
        let shrunk = flux.resampled(inner, inner);
        for row in 0..inner {
            // The grid has y upward, as the image plane.
            let to = (margin + inner - 1 - row) * side + margin;
            target[to..to + inner].copy_from_slice(&shrunk.values[row * inner..][..inner]);
        }
        let gain = (0..side * side)
            .map(|k| {
                let k2 = (frequency(k % side, side).powi(2) + frequency(k / side, side).powi(2)) / (pixel * pixel);
                let floor = std::f64::consts::TAU / (2.0 * LONGEST_WAVE);
                (-k2 * blur * blur).exp() / (k2 + floor * floor)
            })
            .collect();
        let low = -1.0 - margin as f64 * pixel;
        Self { distribution, spacing, side, pixel, low, target, waves: WaveTransform::new(side, side), gain }
    }

    /// The loss of points `x` (u, v in turn) and its gradient.
    fn loss(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let setup = &self.distribution.setup;
        let light = setup.light();
        let flux_of = |p: &[f64]| setup.slope_at(DVec2::new(p[0], p[1])).map_or(1.0, |s| s.intercept(light).max(0.0));
        let flux: Vec<f64> = x.chunks(2).map(flux_of).collect();
        let total: f64 = flux.iter().sum();
        let mut difference: Vec<f64> = self.target.iter().map(|t| -t).collect();
        for (p, f) in x.chunks(2).zip(&flux) {
            let (k, a, b) = self.corner(p);
            let share = f / total;
            difference[k] += share * (1.0 - a) * (1.0 - b);
            difference[k + 1] += share * a * (1.0 - b);
            difference[k + self.side] += share * (1.0 - a) * b;
            difference[k + self.side + 1] += share * a * b;
        }
        let mut potential = difference.clone();
        self.waves.filter(&mut potential, |i, j| Complex64::new(self.gain[j * self.side + i], 0.0));
        for ((p, f), g) in x.chunks(2).zip(&flux).zip(gradient.chunks_mut(2)) {
            let (k, a, b) = self.corner(p);
            let [p00, p10, p01, p11] = [0, 1, self.side, self.side + 1].map(|d| potential[k + d]);
            let share = f / total / self.pixel;
            g[0] = share * ((p10 - p00) * (1.0 - b) + (p11 - p01) * b);
            g[1] = share * ((p01 - p00) * (1.0 - a) + (p11 - p10) * a);
        }
        0.5 * potential.iter().zip(&difference).map(|(p, d)| p * d).sum::<f64>()
    }

    /// Index of the grid point below and left of a point, and the point's place between it and its neighbours.
    fn corner(&self, p: &[f64]) -> (usize, f64, f64) {
        let last = self.side as f64 - 2.0;
        let place = |c: f64| ((c - self.low) / self.pixel - 0.5).clamp(0.0, last);
        let (x, y) = (place(p[0]), place(p[1]));
        let (i, j) = ((x as usize).min(self.side - 2), (y as usize).min(self.side - 2));
        (j * self.side + i, x - i as f64, y - j as f64)
    }
}

/// Grid points across the image at the most: a larger grid costs more than all the facets that it could tell apart.
const FINEST: usize = 192;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::SlopeDistributionSettings;
    use crate::facets::sample::{Sampling, sample};
    use crate::highlight::{Highlight, Quantity};
    use crate::projection::{Projection, View};
    use crate::raster::Raster;
    use crate::setup::Setup;

    fn distribution(theta: f64, light: &Raster) -> SlopeDistribution {
        let setup = Setup::new(theta, 0.4, 0.0, Projection::Equidistant, 0.35);
        let highlight = Highlight::new(light, Quantity::Flux, &setup).unwrap();
        SlopeDistribution::new(&highlight, &setup, &SlopeDistributionSettings::default(), |_| 1.0).unwrap()
    }

    fn wedge() -> Raster {
        Raster::from_fn(48, 48, |x, y| if x + y < 60 && x > 8 { 1.0 + y as f64 / 16.0 } else { 0.0 })
    }

    fn flat(points: &[DVec2]) -> Vec<f64> {
        points.iter().flat_map(|p| p.to_array()).collect()
    }

    fn loss(field: &Field<'_>, points: &[DVec2]) -> f64 {
        field.loss(&flat(points), &mut vec![0.0; 2 * points.len()])
    }

    #[test]
    fn refinement_only_lowers_the_blurred_loss() {
        for theta in [0.0, 1.0] {
            let wanted = distribution(theta, &wedge());
            for (n, sampling) in [(1, Sampling::Random), (5, Sampling::Sobol), (120, Sampling::Random)] {
                // Drawn points are moved by nothing else; random ones have far to go.
                let start = sample(&wanted, n, sampling, 9, &Progress::silent());
                let field = Field::new(&wanted, n);
                let (before, after) = (loss(&field, &start), {
                    let moved = refined(&wanted, start.clone(), &Progress::silent());
                    assert_eq!(moved.len(), n);
                    loss(&field, &moved)
                });
                assert!(after <= before, "{n}: {before} {after}");
                assert!(n < 100 || after < 0.05 * before, "{n}: {before} {after}");
            }
        }
    }

    #[test]
    fn a_perfect_lattice_of_an_even_highlight_hardly_moves() {
        let wanted = distribution(0.0, &Raster::from_fn(60, 60, |_, _| 1.0));
        let lattice: Vec<DVec2> = (0..144).map(|k| View::pixel_centre(k % 12, k / 12, 12, 12)).collect();
        let moved = refined(&wanted, lattice.clone(), &Progress::silent());
        let farthest = lattice.iter().zip(&moved).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(farthest < 0.1 / 6.0, "{farthest}");
    }

    #[test]
    fn the_gradient_is_that_of_the_loss() {
        // Exact where every facet sends the same light, at normal incidence; elsewhere the change of a facet's own
        // flux as it moves is left out, which must not turn the descent around.
        for (theta, alike) in [(0.0, 0.9999), (1.0, 0.98)] {
            let wanted = distribution(theta, &wedge());
            let points = sample(&wanted, 40, Sampling::Random, 2, &Progress::silent());
            let field = Field::new(&wanted, points.len());
            let mut x = flat(&points);
            let mut gradient = vec![0.0; x.len()];
            field.loss(&x, &mut gradient);
            let mut scratch = vec![0.0; x.len()];
            let step = 1e-6;
            let measured: Vec<f64> = (0..x.len())
                .map(|k| {
                    let at = x[k];
                    let [up, down] = [step, -step].map(|d| {
                        x[k] = at + d;
                        field.loss(&x, &mut scratch)
                    });
                    x[k] = at;
                    (up - down) / (2.0 * step)
                })
                .collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let cosine = dot(&gradient, &measured) / (dot(&gradient, &gradient) * dot(&measured, &measured)).sqrt();
            assert!(cosine > alike, "{theta}: {cosine}");
        }
    }
}
