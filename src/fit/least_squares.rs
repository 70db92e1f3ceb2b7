//! Non-linear least squares: Levenberg-Marquardt (Marquardt, SIAM J. Appl. Math. 11, 1963) with differences for derivatives.

use nalgebra::{DMatrix, DVector};

/// Steps at the most.
const STEPS: usize = 60;
/// Relative gain below which it ends.
const ENOUGH: f64 = 1e-9;
/// Step of the differences; parameters are logarithms or of the size of 1.
const DIFFERENCE: f64 = 1e-5;

/// Where a descent ended.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    pub at: Vec<f64>,
    /// Sum of the squared residuals.
    pub sum: f64,
    /// Standard errors from the Jacobian: √ of the diagonal of s² (JᵀJ)⁻¹; infinite where the data do not say.
    pub errors: Vec<f64>,
}

/// Descends from `start`. `residuals` is `None` where there is no such model; so is what comes back if there is none at the
/// start.
pub(super) fn minimum(start: &[f64], residuals: impl Fn(&[f64]) -> Option<DVector<f64>>) -> Option<Minimum> {
    let mut at = start.to_vec();
    let mut here = residuals(&at)?;
    let (mut sum, mut damping) = (here.norm_squared(), 1e-3);
    for _ in 0..STEPS {
        let jacobian = jacobian(&at, &here, &residuals)?;
        let (normal, gradient) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&here));
        let mut gained = None;
        while damping < 1e12 {
            let mut damped = normal.clone();
            for k in 0..at.len() {
                damped[(k, k)] += damping * normal[(k, k)].max(1e-12);
            }
            let tried = damped.cholesky().map(|factor| factor.solve(&gradient)).and_then(|step| {
                let next: Vec<f64> = at.iter().zip(step.iter()).map(|(a, s)| a - s.clamp(-1.0, 1.0)).collect();
                let there = residuals(&next)?;
                let sum = there.norm_squared();
                sum.is_finite().then_some((next, there, sum))
            });
            match tried {
                Some((next, there, less)) if less < sum => {
                    gained = Some(sum - less);
                    (at, here, sum) = (next, there, less);
                    damping = (0.3 * damping).max(1e-12);
                    break;
                }
                _ => damping *= 4.0,
            }
        }
        if gained.is_none_or(|gained| gained <= ENOUGH * sum) {
            break;
        }
    }
    let errors = standard_errors(&at, &here, sum, &residuals)?;
    Some(Minimum { at, sum, errors })
}

fn standard_errors(
    at: &[f64],
    here: &DVector<f64>,
    sum: f64,
    residuals: &impl Fn(&[f64]) -> Option<DVector<f64>>,
) -> Option<Vec<f64>> {
    let jacobian = jacobian(at, here, residuals)?;
    let variance = sum / (here.len().saturating_sub(at.len())).max(1) as f64;
    let inverse = jacobian.tr_mul(&jacobian).cholesky().map(|factor| factor.inverse());
    let error =
        |k: usize| inverse.as_ref().map_or(f64::INFINITY, |inverse| (variance * inverse[(k, k)]).max(0.0).sqrt());
    Some((0..at.len()).map(error).collect())
}

/// Derivatives of the residuals by the parameters: central differences, one-sided at the rim of what is possible.
fn jacobian(
    at: &[f64],
    here: &DVector<f64>,
    residuals: &impl Fn(&[f64]) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let mut jacobian = DMatrix::zeros(here.len(), at.len());
    for k in 0..at.len() {
        let moved = |by: f64| {
            let mut at = at.to_vec();
            at[k] += by;
            residuals(&at)
        };
        let column = match (moved(DIFFERENCE), moved(-DIFFERENCE)) {
            (Some(up), Some(down)) => (up - down) / (2.0 * DIFFERENCE),
            (Some(up), None) => (up - here) / DIFFERENCE,
            (None, Some(down)) => (here - down) / DIFFERENCE,
            (None, None) => return None,
        };
        jacobian.set_column(k, &column);
    }
    Some(jacobian)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_three_points_has_the_slope_and_the_error_of_textbooks() {
        // y = a + b x at 0, 1, 2 through 0, 1, 3: b = 1.5, s² = 1/6, its error √(s²/2).
        let data = [0.0, 1.0, 3.0];
        let residuals = |p: &[f64]| Some(DVector::from_fn(3, |k, _| p[0] + p[1] * k as f64 - data[k]));
        let found = minimum(&[5.0, 5.0], residuals).unwrap();
        assert!((found.at[1] - 1.5).abs() < 1e-6 && (found.sum - 1.0 / 6.0).abs() < 1e-9, "{found:?}");
        assert!((found.errors[1] - (1.0f64 / 12.0).sqrt()).abs() < 1e-6);
    }

    #[test]
    fn a_valley_of_rosenbrock_is_followed_to_its_end() {
        let found = minimum(&[-1.2, 1.0], |p| Some(DVector::from_vec(vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]])));
        assert!(found.unwrap().at.iter().all(|x| (x - 1.0).abs() < 1e-4));
    }
}
