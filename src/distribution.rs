//! The distribution of slopes that the plate must have for its light to be the highlight.
//!
//! A facet whose footprint on the plate is dA intercepts dA (l·m)/(m·z) of the beam and reflects F(l·m) of it, so a
//! pixel's flux asks for footprint ∝ flux / (F (l·m)/(m·z)). Pixel masses are pushed through the map as they are;
//! no Jacobian enters. The distribution is kept over the image plane, where distances are what the eye sees, and
//! every image position names its slope through [`Setup::slope_at`].

use serde::{Deserialize, Serialize};

use crate::highlight::Highlight;
use crate::projection::View;
use crate::raster::Raster;
use crate::setup::Setup;
use crate::slope::Slope;

/// How the distribution is read off a highlight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct SlopeDistributionSettings {
    /// Steepest facet, degrees: light that asks for steeper ones is dropped and reported (the paper's 65°).
    pub slope_cap: f64,
    /// Mount the plate tilted so that its mean slope is zero (the paper rotates its distribution so).
    pub level: bool,
}

impl Default for SlopeDistributionSettings {
    fn default() -> Self {
        Self { slope_cap: 65.0, level: false }
    }
}

/// Share of the plate's area that each image position asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct SlopeDistribution {
    /// Footprint per pixel of the highlight image, sum 1.
    pub footprint: Raster,
    /// Flux per pixel that those footprints send, sum 1: the highlight less what the slope cap takes.
    pub flux: Raster,
    /// Light, image and mounting under which this holds.
    pub setup: Setup,
    /// Share of the highlight's flux that asks for slopes beyond the cap.
    pub beyond_cap: f64,
    /// Area-weighted mean slope of the plate.
    pub mean: Slope,
    /// Area-weighted root mean square of the slope about its mean.
    pub spread: f64,
}

impl SlopeDistribution {
    /// Finds the distribution for a `highlight` read for `setup`; `reflectance` is the base metal's F as a function of the cosine of incidence.
    pub fn new(
        highlight: &Highlight,
        setup: &Setup,
        settings: &SlopeDistributionSettings,
        reflectance: impl Fn(f64) -> f64,
    ) -> Result<Self, DistributionError> {
        let mut found = Self::mounted(highlight, setup.clone(), settings, &reflectance)?;
        if settings.level {
            // Mounting the plate along its mean normal changes the footprints a little, hence the mean: a fixed point,
            // reached to rounding in a handful of rounds because the change is of second order in the slopes.
            for _ in 0..LEVEL_ROUNDS {
                if found.mean.to_vec().length() < 1e-10 {
                    break;
                }
                let (e1, e2) = crate::projection::carried_axes(found.setup.plate_normal());
                let mean = found.mean.normal();
                let normal = (mean.x * e1 + mean.y * e2 + mean.z * found.setup.plate_normal()).normalize();
                let mounted = setup.mounted(normal);
                found = Self::mounted(&highlight.remounted(setup, &mounted), mounted, settings, &reflectance)?;
            }
        }
        Ok(found)
    }

    fn mounted(
        highlight: &Highlight,
        setup: Setup,
        settings: &SlopeDistributionSettings,
        reflectance: &impl Fn(f64) -> f64,
    ) -> Result<Self, DistributionError> {
        let Raster { width, height, .. } = highlight.flux;
        let light = setup.light();
        let cap = settings.slope_cap.to_radians().tan();
        let mut footprint = Raster::zeros(width, height);
        let mut flux = highlight.flux.clone();
        let (mut area, mut first, mut second, mut cut) = (0.0, glam::DVec2::ZERO, 0.0, 0.0);
        for (k, value) in flux.values.iter_mut().enumerate().filter(|(_, value)| **value > 0.0) {
            let uv = View::pixel_centre(k % width, k / width, width, height);
            let slope = setup.slope_at(uv).filter(|s| s.to_vec().length() <= cap && s.intercept(light) > 0.0);
            let Some(slope) = slope else {
                cut += std::mem::take(value);
                continue;
            };
            let share = *value / (reflectance(light.dot(slope.normal())) * slope.intercept(light));
            footprint.values[k] = share;
            area += share;
            first += share * slope.to_vec();
            second += share * slope.to_vec().length_squared();
        }
        if !(area > 0.0 && area.is_finite()) {
            return Err(DistributionError::AllBeyondCap { cap: settings.slope_cap });
        }
        let kept = flux.sum();
        let mean = first / area;
        Ok(Self {
            footprint: footprint.normalised(),
            flux: flux.normalised(),
            setup,
            beyond_cap: cut / (cut + kept),
            mean: Slope::from_vec(mean),
            spread: (second / area - mean.length_squared()).max(0.0).sqrt(),
        })
    }
}

const LEVEL_ROUNDS: usize = 20;

/// Why no distribution could be found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DistributionError {
    /// Nothing is left under the slope cap.
    #[error(
        "all of the highlight needs facets steeper than the slope cap of {cap}°: raise --slope-cap or lower --half-field"
    )]
    AllBeyondCap {
        /// The cap, degrees.
        cap: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::highlight::Quantity;
    use crate::projection::Projection;

    fn distribution(theta: f64, light: &Raster, settings: &SlopeDistributionSettings) -> SlopeDistribution {
        let setup = Setup::new(theta, 0.3, 0.0, Projection::Equidistant, 0.25);
        let highlight = Highlight::new(light, Quantity::Intensity, &setup).unwrap();
        SlopeDistribution::new(&highlight, &setup, settings, |_| 1.0).unwrap()
    }

    #[test]
    fn footprints_intercept_exactly_the_flux_that_was_asked_for() {
        let light = Raster::from_fn(32, 32, |x, y| 1.0 + (x * y % 7) as f64);
        let found = distribution(1.0, &light, &SlopeDistributionSettings::default());
        let l = found.setup.light();
        let sent: Vec<f64> = (0..32 * 32)
            .map(|k| {
                let slope = found.setup.slope_at(View::pixel_centre(k % 32, k / 32, 32, 32)).unwrap();
                found.footprint.values[k] * slope.intercept(l)
            })
            .collect();
        let total: f64 = sent.iter().sum();
        for (s, f) in sent.iter().zip(&found.flux.values) {
            assert!((s / total - f).abs() < 1e-14);
        }
        assert!((found.footprint.sum() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn levelling_takes_the_mean_slope_out_at_any_incidence() {
        let light = Raster::from_fn(32, 32, |x, y| f64::from(u8::from(x > 20 && y < 12)));
        for theta in [0.0, 0.8] {
            let plain = distribution(theta, &light, &SlopeDistributionSettings::default());
            assert!(plain.mean.to_vec().length() > 0.05);
            let level = distribution(theta, &light, &SlopeDistributionSettings { level: true, ..Default::default() });
            assert!(level.mean.to_vec().length() < 1e-9, "{:?}", level.mean);
            assert!(level.spread < 1.1 * plain.spread);
        }
    }

    #[test]
    fn a_levelled_plate_is_as_bright_as_painted_from_where_it_looks() {
        // Radiance is foreshortened by the plate as it hangs, not as it was first thought of: 4 % from end to end here.
        let light = Raster::from_fn(32, 32, |x, y| f64::from(u8::from(x > 16 && y < 16)));
        let setup = Setup::new(0.3, 0.3, 0.0, Projection::Equidistant, 0.5);
        let highlight = Highlight::new(&light, Quantity::Radiance, &setup).unwrap();
        let settings = SlopeDistributionSettings { level: true, ..Default::default() };
        let found = SlopeDistribution::new(&highlight, &setup, &settings, |_| 1.0).unwrap();
        let asked = Highlight::new(&light, Quantity::Radiance, &found.setup).unwrap().flux;
        for ((found, asked), flat) in found.flux.values.iter().zip(&asked.values).zip(&highlight.flux.values) {
            assert!((found - asked).abs() < 1e-12);
            assert!(*flat == 0.0 || (found / flat - 1.0).abs() < 0.1);
        }
        assert!(found.flux.values.iter().zip(&highlight.flux.values).any(|(a, b)| (a / b - 1.0).abs() > 0.01));
    }

    #[test]
    fn the_cap_drops_and_counts_steep_light() {
        let light = Raster::from_fn(64, 64, |_, _| 1.0);
        let cap = SlopeDistributionSettings { slope_cap: f64::to_degrees(0.0625), level: false };
        let found = distribution(0.0, &light, &cap);
        // Deflection is twice the tilt: the cap keeps the disc of half the half field, π/16 of the square; intensity
        // weighs pixels by sin(a)/a, which is 1 within 1 % here.
        assert!((1.0 - found.beyond_cap - std::f64::consts::PI / 16.0).abs() < 0.01, "{}", found.beyond_cap);
        let highlight =
            Highlight { flux: Raster::from_fn(2, 2, |_, _| 0.25), below_plate: 0.0, quantity: Quantity::Flux };
        let none = SlopeDistributionSettings { slope_cap: 0.1, level: false };
        assert!(SlopeDistribution::new(&highlight, &found.setup, &none, |_| 1.0).is_err());
    }
}
