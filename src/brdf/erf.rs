//! The inverse of the error function in f64, which drawing Gaussian slopes of Beckmann's lobe needs for every ray.

use std::f64::consts::FRAC_2_SQRT_PI;

use libm::erf;

/// The x whose erf is `y` in (-1, 1), kept within ±6.
pub(super) fn inverse_erf(y: f64) -> f64 {
    // Start: S. Winitzki, "A handy approximation for the error function and its inverse" (2008), off by 0.002.
    let log = ((1.0 - y) * (1.0 + y)).max(1e-300).ln();
    let half = 2.0 / (std::f64::consts::PI * 0.147) + 0.5 * log;
    let mut x = ((half * half - log / 0.147).sqrt() - half).max(0.0).sqrt().copysign(y).clamp(-6.0, 6.0);
    for _ in 0..2 {
        // Halley: f''/f' = -2x.
        let step = (erf(x) - y) / (FRAC_2_SQRT_PI * (-x * x).exp());
        x = (x - step / (1.0 + x * step)).clamp(-6.0, 6.0);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_inverts() {
        for step in -999..=999 {
            let y = f64::from(step) / 1000.0;
            assert!((erf(inverse_erf(y)) - y).abs() < 1e-14, "{y}");
        }
        for y in [1.0 - 1e-9, 1.0 - 1e-15, 1.0, -1.0] {
            let x = inverse_erf(y);
            assert!(x.is_finite() && (erf(x) - y).abs() < 1e-14, "{y} {x}");
        }
    }
}
