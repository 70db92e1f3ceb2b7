//! The error function and its inverse in f64, which the Gaussian slopes of Beckmann's lobe need for every ray.

use std::f64::consts::FRAC_2_SQRT_PI;
use std::sync::LazyLock;

/// Nodes per unit of the argument, and how many units: beyond 6 the function is ±1 in f64.
const PER_UNIT: f64 = 32.0;
const NODES: usize = 6 * 32 + 1;

/// (erf, its derivative) at the nodes.
static TABLE: LazyLock<[(f64, f64); NODES]> = LazyLock::new(|| {
    std::array::from_fn(|index| {
        let x = index as f64 / PER_UNIT;
        (series(x), FRAC_2_SQRT_PI * (-x * x).exp())
    })
});

/// erf x, within a few of the last bits.
pub(super) fn erf(x: f64) -> f64 {
    let size = x.abs();
    if size >= 6.0 {
        return x.signum();
    }
    let node = (size * PER_UNIT).round();
    let (value, rise) = TABLE[node as usize];
    // Taylor about the node x0: exp(-2 x0 d - d²) = Σ c d^n with (n + 1) c_{n+1} = -2 (x0 c_n + c_{n-1}), integrated.
    let (x0, d) = (node / PER_UNIT, size - node / PER_UNIT);
    let (mut before, mut c, mut power, mut sum) = (0.0, 1.0, d, d);
    for n in 1..10 {
        let n = f64::from(n);
        (before, c) = (c, -2.0 * (x0 * c + before) / n);
        power *= d;
        sum += c * power / (n + 1.0);
    }
    (value + rise * sum).copysign(x)
}

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

/// Abramowitz & Stegun 7.1.6: all terms positive, so nothing cancels.
fn series(x: f64) -> f64 {
    let (mut term, mut sum, mut n) = (x, x, 0.0);
    while term > 1e-18 * sum {
        n += 1.0;
        term *= 2.0 * x * x / (2.0 * n + 1.0);
        sum += term;
    }
    FRAC_2_SQRT_PI * (-x * x).exp() * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_and_the_series_agree() {
        // Abramowitz & Stegun, table 7.1.
        for (x, expected) in [(0.5, 0.5204998778), (1.0, 0.8427007929), (1.5, 0.9661051465), (2.0, 0.9953222650)] {
            assert!((erf(x) - expected).abs() < 1e-10);
            assert_eq!(erf(-x), -erf(x));
        }
        for step in 0..6000 {
            let x = f64::from(step) * 1e-3 + 3e-4;
            assert!((erf(x) - series(x)).abs() < 4e-15, "{x}: {} {}", erf(x), series(x));
        }
        assert_eq!((erf(0.0), erf(7.0), erf(-f64::INFINITY)), (0.0, 1.0, -1.0));
    }

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
