//! The width of the smallest patches of a relief that its light depends on, and the blur that diffraction gives them.
//!
//! Heights are smoothed by ever wider Gaussians until their light changes visibly: detail narrower than such a Gaussian
//! is not needed, detail as wide as it is. A mirror ℓ wide spreads light of wavelength λ by about λ/ℓ.
//!
//! The smallest patch is found from a change of one part in 500 of the light, and says nothing of the rest. Sharp edges
//! count as such patches: rounding one by σ takes a strip about 2σ wide from the mirrors beside it. [`diffracted`] is the
//! share of all light whose patches spread it by more than a given blur.

use crate::relief::periodic::PeriodicRelief;

use super::periodic_filter::smoothed;

/// Change of the light, as total variation after a blur of 1°, that counts as visible: about twice the error that a
/// good sheet has there (0.0008, docs/relief.md).
pub(crate) const SEEN: f64 = 0.002;

/// Wavelength of light to which the eye is most sensitive, mm.
pub const WAVELENGTH: f64 = 0.55e-3;

/// Width of a Gaussian at half its height, standard deviations: 2 √(2 ln 2).
const WIDTH: f64 = 2.354_820_045_030_949;

/// Narrowest Gaussian tried, in distances of nodes: at half its height as wide as the circle inscribed in a triangle of
/// the grid, and no mirror of a relief is smaller than that.
const NARROWEST: f64 = 0.25;

/// Widest Gaussian tried, sides of the cell.
const WIDEST: f64 = 0.25;

/// Halvings of the range of σ on a logarithmic scale, after which it is known to 2 %.
const HALVINGS: usize = 8;

/// The smallest patch on which light depends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Standard deviation of the widest Gaussian by which heights can be smoothed without visible change, mm.
    pub sigma: f64,
}

impl Detail {
    /// Size of the patch, mm: the width of the Gaussian at half its height.
    pub fn patch(self) -> f64 {
        WIDTH * self.sigma
    }

    /// By how much diffraction spreads the light of one such patch, degrees.
    pub fn blur(self) -> f64 {
        (WAVELENGTH / self.patch()).to_degrees()
    }
}

/// The smallest patch on which the light of `relief` depends.
///
/// `changed` returns, for smoothed heights of its cell, the total variation between their light and that of the heights as
/// they are; [`SEEN`] is the limit. It is called about ten times. `None` if the light stays the same however wide the
/// Gaussian, as that of a plane does. Where a Gaussian as wide as one triangle already changes it, that one is returned.
pub(crate) fn smallest_detail<E>(
    relief: &PeriodicRelief,
    changed: impl Fn(&[f32]) -> Result<f64, E>,
) -> Result<Option<Detail>, E> {
    let step = relief.step().min_element();
    let is_seen = |sigma: f64| Ok(changed(&smoothed(relief, sigma))? > SEEN);
    let (mut unseen, mut seen) = (NARROWEST * step, WIDEST * relief.cell.min_element());
    if is_seen(unseen)? {
        return Ok(Some(Detail { sigma: unseen }));
    }
    if !is_seen(seen)? {
        return Ok(None);
    }
    for _ in 0..HALVINGS {
        let middle = (unseen * seen).sqrt();
        if is_seen(middle)? {
            seen = middle;
        } else {
            unseen = middle;
        }
    }
    Ok(Some(Detail { sigma: unseen }))
}

/// Share of the light of `relief` that diffraction spreads by more than `blur` degrees: what changes, as `changed` says,
/// when all that is smaller than λ/blur is smoothed away.
pub fn diffracted<E>(relief: &PeriodicRelief, blur: f64, changed: impl Fn(&[f32]) -> Result<f64, E>) -> Result<f64, E> {
    let patch = WAVELENGTH / blur.to_radians();
    changed(&smoothed(relief, patch / WIDTH))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::convert::Infallible;
    use std::f64::consts::TAU;

    use glam::DVec2;

    use super::*;
    use crate::relief::periodic::drawn;
    use crate::slope::Slope;

    const CELL: DVec2 = DVec2::new(10.0, 5.0);

    fn relief(nodes: usize, height: impl Fn(f64, f64) -> f64) -> PeriodicRelief {
        let heights = drawn(nodes, height);
        PeriodicRelief { nodes, heights, cell: CELL, cells: [1, 1], tilt: Slope::new(0.1, 0.0) }
    }

    /// How much lower the highest point has become, as a share.
    fn flattening(relief: &PeriodicRelief) -> impl Fn(&[f32]) -> Result<f64, Infallible> {
        let top = |z: &[f32]| f64::from(z.iter().copied().fold(f32::MIN, f32::max));
        let before = top(&relief.heights);
        move |z| Ok(1.0 - top(z) / before)
    }

    #[test]
    fn one_wave_is_as_small_as_its_length_says() {
        // Smoothed by σ, a wave of length Λ keeps exp(-2π²σ²/Λ²) of its height.
        for (nodes, waves_x, waves_y) in [(64, 2.0, 0.0), (62, 1.0, 0.0), (96, 0.0, 3.0), (64, 2.0, 1.0)] {
            let wave = relief(nodes, |x, y| 0.1 * (TAU * (waves_x * x + waves_y * y)).cos());
            let length = 1.0 / (DVec2::new(waves_x, waves_y) / CELL).length();
            let calls = Cell::new(0);
            let flattened = flattening(&wave);
            let Ok(detail) = smallest_detail(&wave, |z| {
                calls.set(calls.get() + 1);
                flattened(z)
            });
            let expected = length * (-(1.0 - SEEN).ln() / 2.0).sqrt() / std::f64::consts::PI;
            let sigma = detail.unwrap().sigma;
            assert!(sigma <= 1.001 * expected && sigma > 0.97 * expected, "{sigma} {expected}");
            assert_eq!(calls.get(), HALVINGS + 2);
        }
    }

    #[test]
    fn a_patch_of_a_tenth_of_a_millimetre_blurs_by_a_third_of_a_degree() {
        let detail = Detail { sigma: 0.1 / WIDTH };
        assert!((detail.patch() - 0.1).abs() < 1e-12);
        assert!((detail.blur() - 0.315).abs() < 1e-3);
    }

    #[test]
    fn a_plane_has_no_detail_and_single_nodes_have_the_least_there_is() {
        let flat = relief(32, |_, _| 0.3);
        assert_eq!(smallest_detail(&flat, flattening(&flat)), Ok(None));
        let spike = relief(32, |x, y| f64::from(u8::from(x == 0.5 && y == 0.5)));
        let least = smallest_detail(&spike, flattening(&spike)).unwrap().unwrap();
        assert_eq!(least.sigma, NARROWEST * 5.0 / 32.0);
    }

    #[test]
    fn waves_too_short_for_the_blur_are_diffracted() {
        // At 0.01° a patch is 3.15 mm wide.
        let wave = |waves: f64| relief(64, |x, _| 0.1 * (TAU * waves * x).cos());
        let share = |waves: f64, blur: f64| diffracted(&wave(waves), blur, flattening(&wave(waves))).unwrap();
        assert!(share(8.0, 0.01) > 0.99 && share(8.0, 1.0) < 0.003);
        let expected = 1.0 - (-0.5 * (TAU / 10.0 * 3.151 / WIDTH).powi(2)).exp();
        assert!((share(1.0, 0.01) - expected).abs() < 1e-3);
    }

    #[test]
    fn smoothing_keeps_the_mean_and_what_is_smooth() {
        let rough = relief(40, |x, y| ((x * 91.0 + y * 57.0).sin() * 43.0).fract());
        let mean = |z: &[f32]| z.iter().map(|v| f64::from(*v)).sum::<f64>() / z.len() as f64;
        let wide = smoothed(&rough, 5.0);
        assert!((mean(&wide) - mean(&rough.heights)).abs() < 1e-6);
        assert!(wide.iter().all(|v| (f64::from(*v) - mean(&wide)).abs() < 0.05));
        assert_eq!(smoothed(&rough, 0.0).len(), 1600);
        assert!(smoothed(&rough, 0.0).iter().zip(&rough.heights).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}
