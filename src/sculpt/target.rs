//! The wanted slopes as a histogram on a plane whose unit is a degree of the highlight image.
//!
//! Where a slope's light falls in the image is nearly a linear function of the slope. The plane takes it as linear, with
//! the derivative at the mean slope. Its axes are p and q, each in degrees that are seen near the middle of the picture as it
//! changes; where the light comes from aside and askew, p and q may move it in directions that are not perpendicular, and
//! distances are reckoned with both ([`SlopeTarget::degrees`]). So a slope is placed by two multiplications. Pixels of the
//! drawing are carried over by the exact map, in pieces smaller than a bin.

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use crate::distribution::SlopeDistribution;
use crate::projection::View;
use crate::raster::{Raster, bilinear_weights};
use crate::slope::Slope;

/// Degrees without wanted light around the picture, so that light falling there is followed. Beyond, it counts as on the rim
/// and keeps the gradient that it would have there: no derivative, but still a pull toward the picture. A wider margin takes
/// more bins, that is time.
const MARGIN: f64 = 4.0;

/// Bins a side at the most; wide pictures get wider bins. Pictures up to 72° wide still have
/// the finest bins, of 0.125°.
const MOST_BINS: usize = 640;

/// A share of the plate that shall have one slope.
#[derive(Clone, Copy, Debug)]
struct WeightedSlope {
    /// Its p and q relative to the mean slope, as degrees of the image.
    at: DVec2,
    mass: f64,
}

/// What slopes a relief shall have, ready to be binned as finely as a stage of the design needs.
pub struct SlopePlane {
    slopes: Vec<WeightedSlope>,
    /// Degrees per unit of slope.
    degrees: DMat2,
    /// Degrees per unit of p, and of q.
    scale: DVec2,
    /// Lower left corner of the histogram, degrees.
    low: DVec2,
    /// Side of the histogram, degrees.
    extent: f64,
}

/// The wanted share of the plate's area in each of `side` × `side` bins, and where slopes fall among them.
pub struct SlopeTarget {
    /// Bins a side.
    pub side: usize,
    /// Width of a bin, degrees.
    pub bin: f64,
    /// Shares, rows along the first axis, sum 1, splatted as the relief's light is.
    pub wanted: Vec<f32>,
    /// Bins per unit of slope.
    pub per_slope: DMat2,
    /// Degrees of the image from a bin to the next along either axis.
    pub degrees: DMat2,
    /// Bin coordinates of the mean slope; bin k has its middle at k.
    pub middle: DVec2,
}

impl SlopePlane {
    /// Carries the footprints of `distribution` over in pieces no wider than `finest` degrees.
    ///
    /// `None` if the mean slope has no image or its neighbourhood no extent.
    pub fn new(distribution: &SlopeDistribution, finest: f64) -> Option<Self> {
        let setup = &distribution.setup;
        let per_degree = setup.view().blur_pixels(1f64.to_radians(), 2);
        let mean = distribution.mean.to_vec();
        let image = |s: DVec2| setup.image_of_slope(Slope::from_vec(s));
        let derivative = |step: DVec2| Some((image(mean + step)? - image(mean - step)?) / (2e-5 * per_degree));
        let degrees = DMat2::from_cols(derivative(DVec2::X * 1e-5)?, derivative(DVec2::Y * 1e-5)?);
        let determinant = degrees.determinant().abs();
        if !(determinant > 1e-6 && determinant.is_finite()) {
            return None;
        }
        let scale = DVec2::new(degrees.x_axis.length(), degrees.y_axis.length());
        let Raster { width, height, ref values } = distribution.footprint;
        let pixel = 2.0 / (width.min(height) as f64 * per_degree);
        let pieces = ((pixel / finest).ceil() as usize).clamp(1, 64);
        let share = 1.0 / (pieces * pieces) as f64;
        let slopes: Vec<WeightedSlope> = (0..width * height)
            .into_par_iter()
            .filter(|k| values[*k] > 0.0)
            .flat_map_iter(|k| {
                let (column, row) = (k % width * pieces, k / width * pieces);
                (0..pieces * pieces).filter_map(move |piece| {
                    let (x, y) = (column + piece % pieces, row + piece / pieces);
                    let slope = setup.slope_at(View::pixel_centre(x, y, width * pieces, height * pieces))?;
                    Some(WeightedSlope { at: scale * (slope.to_vec() - mean), mass: share * values[k] })
                })
            })
            .collect();
        let range = slopes.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |r, m| (r.0.min(m.at), r.1.max(m.at)));
        let extent = (range.1 - range.0).max_element() + 2.0 * MARGIN;
        let low = 0.5 * (range.0 + range.1) - 0.5 * extent;
        (extent.is_finite() && low.is_finite()).then_some(Self { slopes, degrees, scale, low, extent })
    }

    /// The target in bins `bin` degrees wide, or wider if they would be too many.
    pub fn target(&self, bin: f64) -> SlopeTarget {
        let bin = bin.max(self.extent / (MOST_BINS - 2) as f64);
        let side = (self.extent / bin).ceil() as usize + 2;
        let mut wanted = vec![0.0f64; side * side];
        for slope in &self.slopes {
            let at = (slope.at - self.low) / bin;
            let (i, j) = (at.x as usize, at.y as usize);
            let (a, b) = (at.x - i as f64, at.y - j as f64);
            let place = &mut wanted[j * side + i..];
            for (k, weight) in [0, 1, side, side + 1].into_iter().zip(bilinear_weights(a, b)) {
                place[k] += slope.mass * weight;
            }
        }
        let total: f64 = wanted.iter().sum();
        SlopeTarget {
            side,
            bin,
            wanted: wanted.iter().map(|w| (w / total) as f32).collect(),
            per_slope: DMat2::from_diagonal(self.scale / bin),
            degrees: self.degrees * DMat2::from_diagonal(bin / self.scale),
            middle: -self.low / bin,
        }
    }

    /// Degrees of the image per unit of slope, at the mean slope.
    pub fn degrees(&self) -> DMat2 {
        self.degrees
    }

    /// `n` slopes relative to the mean, of equal shares each, that have the target's distribution; in no particular order.
    pub fn samples(&self, n: usize) -> Vec<DVec2> {
        let total: f64 = self.slopes.iter().map(|m| m.mass).sum();
        let (mut mass, mut next) = (0.0, 0);
        let mut samples = Vec::with_capacity(n);
        for slope in &self.slopes {
            mass += slope.mass / total;
            while next < n && (next as f64 + 0.5) / (n as f64) <= mass {
                samples.push(slope.at / self.scale);
                next += 1;
            }
        }
        let last = samples.last().copied().unwrap_or(DVec2::ZERO);
        samples.resize(n, last);
        samples
    }

    /// Root of the mean square of the slopes about their mean, along x and y.
    pub fn spread(&self) -> DVec2 {
        let (sum, mass) = self.slopes.iter().fold((DVec2::ZERO, 0.0), |(sum, mass), slope| {
            let s = slope.at / self.scale;
            (sum + slope.mass * s * s, mass + slope.mass)
        });
        let mean = sum / mass;
        DVec2::new(mean.x.sqrt(), mean.y.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::SlopeDistributionSettings;
    use crate::highlight::{Highlight, Quantity};
    use crate::projection::Projection;
    use crate::setup::Setup;

    fn plane(theta: f64) -> (SlopeDistribution, SlopePlane) {
        let setup = Setup::new(theta, 0.4, 0.0, Projection::Equidistant, f64::to_radians(20.0));
        let light = Raster::from_fn(40, 40, |x, y| if x > 8 && y < 30 { 1.0 + x as f64 } else { 0.0 });
        let highlight = Highlight::new(&light, Quantity::Flux, &setup).unwrap();
        let wanted =
            SlopeDistribution::new(&highlight, &setup, &SlopeDistributionSettings::default(), |_| 1.0).unwrap();
        let plane = SlopePlane::new(&wanted, 0.25).unwrap();
        (wanted, plane)
    }

    #[test]
    fn at_normal_incidence_a_tilt_of_one_degree_is_two_degrees_away() {
        let (_, plane) = plane(0.0);
        let step = plane.degrees() * DVec2::new(f64::to_radians(1.0), 0.0);
        // Toward -x, as a climb toward +x throws light; the mean slope is not quite zero, nor the map quite linear.
        assert!((step.x + 2.0).abs() < 0.1 && step.y.abs() < 0.1, "{step}");
    }

    #[test]
    fn bins_hold_the_drawing_and_its_mean_lies_at_the_mean_slope() {
        for theta in [0.0, 0.9] {
            let (wanted, plane) = plane(theta);
            for bin in [0.125, 0.5] {
                let target = plane.target(bin);
                assert_eq!(target.wanted.len(), target.side * target.side);
                let (mut sum, mut mean) = (0.0, DVec2::ZERO);
                for (k, w) in target.wanted.iter().enumerate() {
                    sum += f64::from(*w);
                    mean += f64::from(*w) * DVec2::new((k % target.side) as f64, (k / target.side) as f64);
                }
                assert!((sum - 1.0).abs() < 1e-5);
                // Pieces of a pixel have other means than pixels, by little.
                assert!((mean - target.middle).length() * target.bin < 0.02, "{mean} {}", target.middle);
            }
            let spread = plane.spread();
            assert!((spread.length() / wanted.spread - 1.0).abs() < 0.01);
            let samples = plane.samples(5000);
            let mean: DVec2 = samples.iter().sum::<DVec2>() / 5000.0;
            assert!(samples.len() == 5000 && mean.length() < 0.01 * wanted.spread);
        }
    }
}
