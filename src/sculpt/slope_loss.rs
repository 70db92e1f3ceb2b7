//! The distance between a relief's light and the wanted light, both histograms over slopes, at one scale.
//!
//! With the difference d of both, per bin, and the weight w of the dark,
//!
//! ```text
//!     E = ½ Σ w d · (W ∗ w d),      Ŵ(k) = exp(-k²σ²) / (k² + k0²)^α,      k0 = 2π / 40°
//! ```
//!
//! where k is the angular frequency over the slope plane, radians a degree. exp(-k²σ²) is the square of the gain of a
//! Gaussian blur of standard deviation σ. At α = 1 E is nearly a transport distance: light far from where it is wanted has
//! a gradient toward it. At α = 0 it is a sum of squares.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2};

use crate::fourier::{even_smooth_size, frequency};

use super::periodic_filter::PeriodicFilter;
use super::target::SlopeTarget;

/// Differences wider than this, degrees, count as if they were as wide: 2π/k0. It is about the width of a usual picture, and
/// keeps the gain of the mean, which is 0 anyway, finite.
const WIDEST: f64 = 40.0;

/// Degrees without light beyond the target's own bins. The convolution is periodic, and this is how far light at one rim
/// is from the opposite one: two standard deviations of the widest blur, 3°. More would only cost time.
const PADDING: f64 = 6.0;

/// The weight of a difference is (1 + DARK)/(t + DARK) at a wanted brightness t, as a share of the peak: 1 at the peak and
/// 4.3 on black.
///
/// The eye sees haze on black, and so does SSIM: 0.973 became 0.978 for the astronaut with a ball of 1 mm (docs/relief.md).
/// A smaller value takes light from the bright parts' own detail.
const DARK: f64 = 0.3;

/// Blur, degrees, through which the wanted brightness is looked at for [`DARK`].
const DARK_BLUR: f64 = 0.5;

/// How a stage of the design compares light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LossScale {
    /// σ, degrees.
    pub blur: f64,
    /// α, from 0 (a sum of squares) to 1 (nearly a transport distance).
    pub alpha: f64,
    /// Whether differences in the dark weigh more.
    pub weighed: bool,
}

impl LossScale {
    /// Whether its blur is narrow enough for the light of the tool's grid to count. It falls on lines, 4.6° apart for a ball,
    /// which a wider blur makes too faint to be worth the milling that finds them.
    pub(crate) const fn is_fine(self) -> bool {
        self.blur < 0.4
    }
}

/// The loss at one scale, over the bins of one target.
pub(crate) struct SlopeLoss {
    side: usize,
    /// Degrees from a bin to the next along either axis.
    degrees: DMat2,
    filter: PeriodicFilter,
    /// Ŵ.
    gains: Vec<f32>,
    dark_weight: Option<Vec<f32>>,
}

impl SlopeLoss {
    /// Between light in the bins of `target` and the light wanted there.
    pub fn new(target: &SlopeTarget, scale: LossScale) -> Self {
        let padding = (PADDING / target.bin).ceil() as usize;
        let filter = PeriodicFilter::new(even_smooth_size(target.side + padding));
        let gains = gains(&filter, target.degrees, scale);
        let mut loss = Self { side: target.side, degrees: target.degrees, filter, gains, dark_weight: None };
        if scale.weighed {
            loss.dark_weight = Some(loss.dark_weight(&target.wanted));
        }
        loss
    }

    /// E of a difference of light, and its gradient with respect to the light: the potential.
    pub fn compare(&self, mut difference: Vec<f32>) -> (f64, Vec<f32>) {
        let weigh = |values: &mut [f32]| {
            if let Some(weight) = &self.dark_weight {
                values.iter_mut().zip(weight).for_each(|(v, w)| *v *= w);
            }
        };
        weigh(&mut difference);
        let mut potential = difference.clone();
        self.filter.filter(&mut potential, self.side, &self.gains);
        let products = potential.iter().zip(&difference).map(|(p, d)| f64::from(*p) * f64::from(*d));
        let loss = 0.5 * products.sum::<f64>();
        weigh(&mut potential);
        (loss, potential)
    }

    /// Total variation of a difference of light after a Gaussian blur of `blur` degrees: half the sum of its absolute
    /// values.
    pub(crate) fn total_variation(&self, mut difference: Vec<f32>, blur: f64) -> f64 {
        self.blur(&mut difference, blur);
        0.5 * difference.iter().map(|d| f64::from(d.abs())).sum::<f64>()
    }

    fn blur(&self, light: &mut [f32], blur: f64) {
        // The gain of a sum of squares is the square of a blur's.
        let squared = LossScale { blur: blur / 2f64.sqrt(), alpha: 0.0, weighed: false };
        self.filter.filter(light, self.side, &gains(&self.filter, self.degrees, squared));
    }

    /// See [`DARK`].
    fn dark_weight(&self, wanted: &[f32]) -> Vec<f32> {
        let mut seen = wanted.to_vec();
        self.blur(&mut seen, DARK_BLUR);
        let peak = f64::from(seen.iter().fold(f32::MIN_POSITIVE, |m, v| m.max(*v)));
        seen.iter().map(|v| ((1.0 + DARK) / (f64::from(v.max(0.0)) / peak + DARK)) as f32).collect()
    }
}

/// Ŵ over the waves of `filter`, whose grid has bins `degrees` apart along either axis.
fn gains(filter: &PeriodicFilter, degrees: DMat2, scale: LossScale) -> Vec<f32> {
    let side = filter.side();
    // From waves over bins to waves over degrees.
    let per_degree = degrees.inverse().transpose();
    filter.gains(|i, j| {
        let k2 = (per_degree * DVec2::new(frequency(i, side), frequency(j, side))).length_squared();
        (-k2 * scale.blur * scale.blur).exp() / (k2 + (TAU / WIDEST).powi(2)).powf(scale.alpha)
    })
}
