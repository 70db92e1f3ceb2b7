//! Straight fits: coefficients of a few functions that come nearest to many values.

use nalgebra::{SMatrix, SVector};

/// A fit of `N` functions.
pub(super) struct LinearFit<const N: usize> {
    /// Their coefficients.
    pub(super) of: SVector<f64, N>,
    /// The inverse of the sum of their products: times the variance of single values it is the coefficients' covariance.
    pub(super) inverse: SMatrix<f64, N, N>,
}

/// The fit to `points`, each the values of all functions at a place and what was found there, with `ridge` added to the
/// squares; none if they do not tell the functions apart.
pub(super) fn linear_fit<const N: usize>(
    points: impl Iterator<Item = (SVector<f64, N>, f64)>,
    ridge: f64,
) -> Option<LinearFit<N>> {
    let (mut square, mut product) = (SMatrix::<f64, N, N>::identity() * ridge, SVector::<f64, N>::zeros());
    for (basis, value) in points {
        square += basis * basis.transpose();
        product += basis * value;
    }
    // Inverted by elimination, whatever N is.
    let inverse = square.try_inverse()?;
    Some(LinearFit { of: inverse * product, inverse })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planted_coefficients_are_found_and_functions_that_are_one_are_not_told_apart() {
        let basis = |k: u32| SVector::from([1.0, f64::from(k), f64::from(k * k)]);
        let points = || (0..9).map(|k| (basis(k), basis(k).dot(&SVector::from([2.0, -0.5, 0.25]))));
        let fit = linear_fit(points(), 0.0).unwrap();
        assert!((fit.of - SVector::from([2.0, -0.5, 0.25])).norm() < 1e-10, "{}", fit.of);
        // The variance of the mean of nine values.
        let mean = linear_fit((0..9).map(|k| (SVector::from([1.0]), f64::from(k))), 0.0).unwrap();
        assert!((mean.of[0] - 4.0).abs() < 1e-12 && (mean.inverse[0] - 1.0 / 9.0).abs() < 1e-12);
        assert!(linear_fit((0..9).map(|_| (SVector::from([1.0, 1.0]), 3.0)), 0.0).is_none());
    }
}
