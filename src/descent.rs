//! Limited-memory BFGS: the descent behind every smooth optimisation in the crate.
//!
//! Nocedal and Wright, "Numerical Optimization", 2nd edition, algorithms 7.4 and 7.5, with a backtracking line search.

use std::collections::VecDeque;

use rayon::prelude::*;

use crate::progress::Cancelled;

/// A number that a descent can move: `f64`, or `f32` where millions of them would fill the memory.
pub trait Number: Copy + Default + Send + Sync + Into<f64> {
    /// The nearest number of this kind.
    fn nearest(value: f64) -> Self;
}

impl Number for f64 {
    fn nearest(value: f64) -> Self {
        value
    }
}

impl Number for f32 {
    fn nearest(value: f64) -> Self {
        value as f32
    }
}

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

/// What a descent remembers of its way: moves, the changes of the gradient that they made, and the inverse of both's product.
#[derive(Clone, Debug)]
pub struct Past<T>(VecDeque<(Vec<T>, Vec<T>, f64)>);

impl<T> Default for Past<T> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

/// Lowers `objective` from `x`; returns the final value.
///
/// `objective` writes the gradient at its first argument into its second and returns the value there. `goes_on` is asked
/// before each step, whose number it is given.
/// A step that does not lower the value is never taken: the result is at least as good as the start, also where
/// `objective` is cancelled on the way.
pub fn minimise<T: Number>(
    x: &mut [T],
    settings: &Descent,
    objective: impl FnMut(&[T], &mut [T]) -> Result<f64, Cancelled>,
    goes_on: impl FnMut(usize) -> bool,
) -> Result<f64, Cancelled> {
    minimise_on(x, &mut Past::default(), settings, objective, goes_on)
}

/// The same, going on from what an earlier descent of a similar objective remembers; what it remembers itself is added.
///
/// Where only a part of the objective was changed that is nearly linear, its curvature is still the one that was met, and
/// the first steps need not find it anew.
pub fn minimise_on<T: Number>(
    x: &mut [T],
    Past(past): &mut Past<T>,
    settings: &Descent,
    mut objective: impl FnMut(&[T], &mut [T]) -> Result<f64, Cancelled>,
    mut goes_on: impl FnMut(usize) -> bool,
) -> Result<f64, Cancelled> {
    let n = x.len();
    let mut gradient = vec![T::default(); n];
    let mut value = objective(x, &mut gradient)?;
    let (mut trial, mut trial_gradient) = (vec![T::default(); n], vec![T::default(); n]);
    for step in 0..settings.steps {
        if !goes_on(step) {
            break;
        }
        let mut direction = newton_direction(&gradient, past);
        if past.is_empty() {
            let largest = direction.iter().fold(0.0f64, |m, &d| m.max(d.into().abs()));
            if !(largest > 0.0 && largest.is_finite()) {
                break;
            }
            scale(&mut direction, settings.first_move / largest);
        }
        let descent = dot(&gradient, &direction);
        // Downhill but for rounding, or a gradient that is not a number.
        if descent.is_nan() || descent >= 0.0 {
            break;
        }
        let mut length = 1.0;
        let lowered = loop {
            trial.copy_from_slice(x);
            add(&mut trial, &direction, length);
            let reached = objective(&trial, &mut trial_gradient)?;
            if reached.is_finite() && reached <= value + SUFFICIENT * length * descent {
                break Some(reached);
            }
            length *= 0.5;
            if length < SHORTEST {
                break None;
            }
        };
        let Some(reached) = lowered else { break };
        let mut moved = direction;
        scale(&mut moved, length);
        let mut change = trial_gradient.clone();
        add(&mut change, &gradient, -1.0);
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
    Ok(value)
}

/// Armijo's constant.
const SUFFICIENT: f64 = 1e-4;

/// Step lengths below this are given up.
const SHORTEST: f64 = 1e-6;

/// Minus the inverse Hessian, as far as the past tells it, times the gradient: the two-loop recursion.
fn newton_direction<T: Number>(gradient: &[T], past: &VecDeque<(Vec<T>, Vec<T>, f64)>) -> Vec<T> {
    let mut d: Vec<T> = gradient.iter().map(|&g| T::nearest(-g.into())).collect();
    let mut weights = Vec::with_capacity(past.len());
    for (moved, change, inverse) in past.iter().rev() {
        let weight = inverse * dot(moved, &d);
        add(&mut d, change, -weight);
        weights.push(weight);
    }
    if let Some((moved, change, _)) = past.back() {
        scale(&mut d, dot(moved, change) / dot(change, change));
    }
    for ((moved, change, inverse), weight) in past.iter().zip(weights.iter().rev()) {
        let correction = weight - inverse * dot(change, &d);
        add(&mut d, moved, correction);
    }
    d
}

/// Numbers that one thread takes at a time. Sums are those of the pieces in order: the same for any number of threads.
const PIECE: usize = 1 << 15;

fn dot<T: Number>(a: &[T], b: &[T]) -> f64 {
    // Eight sums side by side: one alone waits for itself.
    let sum = |(a, b): (&[T], &[T])| {
        let mut sums = [0.0f64; 8];
        let (eights, rest) = (a.chunks_exact(8).zip(b.chunks_exact(8)), a.len() / 8 * 8);
        for (a, b) in eights {
            for k in 0..8 {
                sums[k] += a[k].into() * b[k].into();
            }
        }
        let tail: f64 = a[rest..].iter().zip(&b[rest..]).map(|(&x, &y)| x.into() * y.into()).sum();
        sums.iter().sum::<f64>() + tail
    };
    if a.len() <= PIECE {
        return sum((a, b));
    }
    let sums: Vec<f64> = a.par_chunks(PIECE).zip(b.par_chunks(PIECE)).map(sum).collect();
    sums.iter().sum()
}

fn add<T: Number>(to: &mut [T], from: &[T], factor: f64) {
    to.par_chunks_mut(PIECE).zip(from.par_chunks(PIECE)).for_each(|(to, from)| {
        for (t, &f) in to.iter_mut().zip(from) {
            *t = T::nearest((*t).into() + factor * f.into());
        }
    });
}

fn scale<T: Number>(values: &mut [T], factor: f64) {
    values.par_chunks_mut(PIECE).for_each(|piece| {
        for v in piece {
            *v = T::nearest((*v).into() * factor);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_floor_of_rosenbrocks_valley() {
        let settings = Descent { steps: 200, memory: 8, tolerance: 0.0, first_move: 0.1 };
        let mut x = [-1.2, 1.0];
        let value = minimise(
            &mut x,
            &settings,
            |x, g| {
                let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
                g[0] = -2.0 * a - 400.0 * x[0] * b;
                g[1] = 200.0 * b;
                Ok(a * a + 100.0 * b * b)
            },
            |_| true,
        )
        .unwrap();
        assert!(value < 1e-12 && (x[0] - 1.0).abs() < 1e-5, "{value} {x:?}");
    }

    #[test]
    fn single_precision_and_many_numbers_descend_alike() {
        // A valley of 100 000 numbers, each its own bowl between 1 and 100 times as steep as the flattest.
        let n = 100_000;
        let steepness = |k: usize| 1.0 + 99.0 * (k % 7) as f64 / 6.0;
        let settings = Descent { steps: 60, memory: 8, tolerance: 0.0, first_move: 0.1 };
        let mut x = vec![1.0f32; n];
        let value = minimise(
            &mut x,
            &settings,
            |x, g| {
                let each = x.iter().zip(g).enumerate().map(|(k, (&x, g))| {
                    *g = (steepness(k) * f64::from(x)) as f32;
                    0.5 * steepness(k) * f64::from(x).powi(2)
                });
                Ok(each.sum())
            },
            |_| true,
        )
        .unwrap();
        assert!(value < 1e-6 * n as f64, "{value}");
    }

    #[test]
    fn odd_objectives_end_where_they_began() {
        let settings = Descent { steps: 5, memory: 0, tolerance: 0.0, first_move: 1.0 };
        assert_eq!(minimise::<f64>(&mut [], &settings, |_, _| Ok(7.0), |_| true), Ok(7.0));
        for slope in [0.0, f64::NAN, f64::INFINITY] {
            let mut x = [1.0, 2.0];
            minimise(
                &mut x,
                &settings,
                |x, g| {
                    g.fill(slope);
                    Ok(x[0])
                },
                |_| true,
            )
            .unwrap();
            assert_eq!(x, [1.0, 2.0]);
        }
        // Nothing remembered is steepest descent with one pair: still downhill.
        let mut x = [3.0, -1.0];
        let bowl = |x: &[f64], g: &mut [f64]| {
            (g[0], g[1]) = (2.0 * x[0], 20.0 * x[1]);
            Ok(x[0] * x[0] + 10.0 * x[1] * x[1])
        };
        assert!(minimise(&mut x, &Descent { steps: 30, ..settings }, bowl, |_| true).unwrap() < 1e-6);
    }

    #[test]
    fn ends_when_told_to() {
        let settings = Descent { steps: 50, memory: 4, tolerance: 0.0, first_move: 0.5 };
        let mut x = [8.0f64];
        let mut asked = 0;
        let bowl = |x: &[f64], g: &mut [f64]| {
            g[0] = 4.0 * x[0].powi(3);
            Ok(x[0].powi(4))
        };
        minimise(&mut x, &settings, bowl, |step| {
            asked += 1;
            step < 2
        })
        .unwrap();
        assert!(asked == 3 && x[0] < 8.0 && x[0] > 1.0, "{asked} {x:?}");
    }

    #[test]
    fn a_cancelled_objective_leaves_the_best_so_far() {
        let settings = Descent { steps: 50, memory: 4, tolerance: 0.0, first_move: 0.5 };
        let mut x = [8.0f64];
        let (mut calls, mut least) = (0, f64::INFINITY);
        let bowl = |x: &[f64], g: &mut [f64]| {
            calls += 1;
            if calls > 4 {
                return Err(Cancelled);
            }
            g[0] = 4.0 * x[0].powi(3);
            least = least.min(x[0]);
            Ok(x[0].powi(4))
        };
        assert_eq!(minimise(&mut x, &settings, bowl, |_| true), Err(Cancelled));
        assert!(x[0] == least && least < 8.0, "{x:?} {least}");
    }

    #[test]
    fn never_ends_above_its_start() {
        let settings = Descent { steps: 50, memory: 4, tolerance: 0.0, first_move: 10.0 };
        let mut x = [0.3f64];
        let value = minimise(
            &mut x,
            &settings,
            |x, g| {
                g[0] = x[0].signum();
                Ok(if x[0] == 0.3 { 0.0 } else { f64::NAN })
            },
            |_| true,
        )
        .unwrap();
        assert_eq!((value, x[0]), (0.0, 0.3));
    }
}
