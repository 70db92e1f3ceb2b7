//! Limited-memory BFGS: the descent behind every smooth optimisation in the crate.
//!
//! Nocedal and Wright, "Numerical Optimization", 2nd edition, algorithms 7.4 and 7.5, with a backtracking line search.

use std::collections::VecDeque;

/// When to stop, and how much to remember.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Descent {
    /// Steps at the most.
    pub steps: usize,
    /// Pairs of moves and gradient changes remembered, one at the least.
    pub memory: usize,
    /// Ends when a step lowers the value by less than this share of it.
    pub tolerance: f64,
    /// Length of the first move's largest component.
    pub first_move: f64,
}

/// Lowers `objective` from `x`; returns the final value.
///
/// `objective` writes the gradient at its first argument into its second and returns the value there.
/// A step that does not lower the value is never taken: the result is at least as good as the start.
pub fn minimise(x: &mut [f64], settings: &Descent, mut objective: impl FnMut(&[f64], &mut [f64]) -> f64) -> f64 {
    let n = x.len();
    let mut gradient = vec![0.0; n];
    let mut value = objective(x, &mut gradient);
    let mut past: VecDeque<(Vec<f64>, Vec<f64>, f64)> = VecDeque::new();
    let (mut trial, mut trial_gradient) = (vec![0.0; n], vec![0.0; n]);
    for _ in 0..settings.steps {
        let mut direction = newton_direction(&gradient, &past);
        if past.is_empty() {
            let largest = direction.iter().fold(0.0f64, |m, d| m.max(d.abs()));
            if !(largest > 0.0 && largest.is_finite()) {
                break;
            }
            direction.iter_mut().for_each(|d| *d *= settings.first_move / largest);
        }
        let descent = dot(&gradient, &direction);
        // Downhill but for rounding, or a gradient that is not a number.
        if descent.is_nan() || descent >= 0.0 {
            break;
        }
        let mut length = 1.0;
        let lowered = loop {
            for k in 0..n {
                trial[k] = x[k] + length * direction[k];
            }
            let reached = objective(&trial, &mut trial_gradient);
            if reached.is_finite() && reached <= value + SUFFICIENT * length * descent {
                break Some(reached);
            }
            length *= 0.5;
            if length < SHORTEST {
                break None;
            }
        };
        let Some(reached) = lowered else { break };
        let moved: Vec<f64> = direction.iter().map(|d| length * d).collect();
        let change: Vec<f64> = trial_gradient.iter().zip(&gradient).map(|(new, old)| new - old).collect();
        let curvature = dot(&moved, &change);
        if curvature > 1e-12 * dot(&change, &change).sqrt() * dot(&moved, &moved).sqrt() {
            if past.len() >= settings.memory.max(1) {
                past.pop_front();
            }
            past.push_back((moved, change, 1.0 / curvature));
        }
        x.copy_from_slice(&trial);
        std::mem::swap(&mut gradient, &mut trial_gradient);
        let gain = value - reached;
        value = reached;
        if gain <= settings.tolerance * value.abs() {
            break;
        }
    }
    value
}

/// Armijo's constant.
const SUFFICIENT: f64 = 1e-4;

/// Step lengths below this are given up.
const SHORTEST: f64 = 1e-6;

/// Minus the inverse Hessian, as far as the past tells it, times the gradient: the two-loop recursion.
fn newton_direction(gradient: &[f64], past: &VecDeque<(Vec<f64>, Vec<f64>, f64)>) -> Vec<f64> {
    let mut d: Vec<f64> = gradient.iter().map(|g| -g).collect();
    let mut weights = Vec::with_capacity(past.len());
    for (moved, change, inverse) in past.iter().rev() {
        let weight = inverse * dot(moved, &d);
        add(&mut d, change, -weight);
        weights.push(weight);
    }
    if let Some((moved, change, _)) = past.back() {
        let scale = dot(moved, change) / dot(change, change);
        d.iter_mut().for_each(|v| *v *= scale);
    }
    for ((moved, change, inverse), weight) in past.iter().zip(weights.iter().rev()) {
        let correction = weight - inverse * dot(change, &d);
        add(&mut d, moved, correction);
    }
    d
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn add(to: &mut [f64], from: &[f64], factor: f64) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += factor * f;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_floor_of_rosenbrocks_valley() {
        let settings = Descent { steps: 200, memory: 8, tolerance: 0.0, first_move: 0.1 };
        let mut x = [-1.2, 1.0];
        let value = minimise(&mut x, &settings, |x, g| {
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            g[0] = -2.0 * a - 400.0 * x[0] * b;
            g[1] = 200.0 * b;
            a * a + 100.0 * b * b
        });
        assert!(value < 1e-12 && (x[0] - 1.0).abs() < 1e-5, "{value} {x:?}");
    }

    #[test]
    fn odd_objectives_end_where_they_began() {
        let settings = Descent { steps: 5, memory: 0, tolerance: 0.0, first_move: 1.0 };
        assert_eq!(minimise(&mut [], &settings, |_, _| 7.0), 7.0);
        for slope in [0.0, f64::NAN, f64::INFINITY] {
            let mut x = [1.0, 2.0];
            minimise(&mut x, &settings, |x, g| {
                g.fill(slope);
                x[0]
            });
            assert_eq!(x, [1.0, 2.0]);
        }
        // Nothing remembered is steepest descent with one pair: still downhill.
        let mut x = [3.0, -1.0];
        let bowl = |x: &[f64], g: &mut [f64]| {
            (g[0], g[1]) = (2.0 * x[0], 20.0 * x[1]);
            x[0] * x[0] + 10.0 * x[1] * x[1]
        };
        assert!(minimise(&mut x, &Descent { steps: 30, ..settings }, bowl) < 1e-6);
    }

    #[test]
    fn never_ends_above_its_start() {
        let settings = Descent { steps: 50, memory: 4, tolerance: 0.0, first_move: 10.0 };
        let mut x = [0.3];
        let value = minimise(&mut x, &settings, |x, g| {
            g[0] = x[0].signum();
            if x[0] == 0.3 { 0.0 } else { f64::NAN }
        });
        assert_eq!((value, x[0]), (0.0, 0.3));
    }
}
