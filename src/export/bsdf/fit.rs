//! The colour grid of `.bsdf` files: not the table at the grid's nodes but the grid that comes nearest to the table.
//!
//! Measured tables are noisy. After the warp every part of the unit square holds as much light as any other, so that a
//! mean over the square weighs cells by the rays they counted: the least scatter the counts allow. The nodes are those
//! whose bilinear surface is the least-squares fit among those that are nowhere negative: a BRDF is not, and renderers
//! draw what is as dark streaks. Only directions above the horizon bear on it; nodes below, which readers interpolate
//! with, are what serves those above best. In the end all nodes are scaled by one number, so that the surface holds the
//! light that the points hold, whatever the nodes at zero took or gave.

/// Points each way over the whole square, at least: about as fine as the tables themselves.
const POINTS: usize = 128;

/// A sweep that moves no node by more than this share of the largest is the last. Each sweep takes off at least a third
/// of what is wrong (the condition number of such a grid is 9), so that some thirty sweeps do.
const SETTLED: f64 = 1e-9;
const MOST_SWEEPS: usize = 500;

/// Least-squares fit of a bilinear surface over the unit square.
pub(super) struct GridFit {
    /// Nodes a side.
    side: usize,
    /// Points between two nodes.
    points: usize,
}

impl GridFit {
    /// For `side` × `side` nodes; `None` for fewer than 2 a side.
    pub(super) fn new(side: usize) -> Option<Self> {
        let points = POINTS.div_ceil(side.checked_sub(1).filter(|&gaps| gaps > 0)?).max(2);
        Some(Self { side, points })
    }

    /// Points a side.
    fn across(&self) -> usize {
        self.points * (self.side - 1)
    }

    /// `place(s1, s2)` at the points of the fit, s1 fastest.
    pub(super) fn places<T>(&self, place: impl Fn(f64, f64) -> T) -> Vec<T> {
        let n = self.across();
        let at = |k: usize| (k as f64 + 0.5) / n as f64;
        (0..n * n).map(|k| place(at(k % n), at(k / n))).collect()
    }

    /// The four nodes about point `k` and how much each weighs there.
    fn about(&self, k: usize) -> [(usize, f64); 4] {
        let split = |k: usize| (k / self.points, ((k % self.points) as f64 + 0.5) / self.points as f64);
        let ((x, s), (y, t)) = (split(k % self.across()), split(k / self.across()));
        let first = x + self.side * y;
        [
            (first, (1.0 - s) * (1.0 - t)),
            (first + 1, s * (1.0 - t)),
            (first + self.side, (1.0 - s) * t),
            (first + self.side + 1, s * t),
        ]
    }

    /// The normal equations of the points that `counts` lets count.
    pub(super) fn equations(&self, counts: &[bool]) -> Equations<'_> {
        let side = self.side;
        let mut gram = vec![[0.0; 9]; side * side];
        for (k, _) in counts.iter().enumerate().filter(|(_, counts)| **counts) {
            let about = self.about(k);
            for (a, weight) in about {
                for (b, other) in about {
                    // Neighbours by row, then column, the node itself being the fifth.
                    let (right, up) = (b % side + 1 - a % side, b / side + 1 - a / side);
                    gram[a][right + 3 * up] += weight * other;
                }
            }
        }
        Equations { fit: self, counts: counts.to_vec(), gram }
    }
}

/// G X = S, with the Gram matrix G of the hat functions of the nodes: nine numbers a node.
pub(super) struct Equations<'a> {
    fit: &'a GridFit,
    counts: Vec<bool>,
    gram: Vec<[f64; 9]>,
}

impl Equations<'_> {
    /// The nodes for `values` at the points, none of them negative.
    pub(super) fn nodes(&self, values: &[f64]) -> Vec<f32> {
        let side = self.fit.side;
        let mut sums = vec![0.0; side * side];
        let mut light = 0.0;
        for (k, value) in values.iter().enumerate().filter(|(k, _)| self.counts[*k]) {
            light += value;
            for (node, weight) in self.fit.about(k) {
                sums[node] += weight * value;
            }
        }
        let mut nodes = vec![0.0f64; side * side];
        for _ in 0..MOST_SWEEPS {
            let (mut moved, mut most) = (0.0f64, 0.0f64);
            for node in 0..nodes.len() {
                let before = nodes[node];
                nodes[node] = self.best(node, &nodes, sums[node]);
                moved = moved.max((nodes[node] - before).abs());
                most = most.max(nodes[node]);
            }
            if moved <= SETTLED * most {
                break;
            }
        }
        let held = self.light(&nodes);
        let scale = if held > 0.0 && light > 0.0 { light / held } else { 1.0 };
        nodes.iter().map(|node| (node * scale) as f32).collect()
    }

    /// What is best for one node, the others as they are.
    fn best(&self, node: usize, nodes: &[f64], sum: f64) -> f64 {
        let (side, row) = (self.fit.side, &self.gram[node]);
        if row[4] <= 0.0 {
            return 0.0;
        }
        let (x, y) = (node % side, node / side);
        let mut rest = sum;
        for (k, weight) in row.iter().enumerate() {
            let (i, j) = (x + k % 3, y + k / 3);
            if k != 4 && *weight > 0.0 && (1..=side).contains(&i) && (1..=side).contains(&j) {
                rest -= weight * nodes[i - 1 + side * (j - 1)];
            }
        }
        (rest / row[4]).max(0.0)
    }

    /// The sum of the surface over the points that count.
    pub(super) fn light(&self, nodes: &[f64]) -> f64 {
        let about = |k: usize| self.fit.about(k).iter().map(|(node, weight)| weight * nodes[*node]).sum::<f64>();
        (0..self.counts.len()).filter(|k| self.counts[*k]).map(about).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random numbers in [-0.5, 0.5).
    fn noise(count: usize) -> Vec<f64> {
        let mut state = 1u64;
        let next = |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
        };
        (0..count).map(next).collect()
    }

    #[test]
    fn what_is_bilinear_between_nodes_and_never_negative_comes_back() {
        for side in [2, 3, 17, 40] {
            let wanted: Vec<f64> = (0..side * side).map(|k| f64::from(k as u32 * 7919 % 101)).collect();
            let fit = GridFit::new(side).unwrap();
            let values = fit.places(|s, t| {
                let (x, y) = (s * (side - 1) as f64, t * (side - 1) as f64);
                let near = |a: f64, node: usize| (1.0 - (a - node as f64).abs()).max(0.0);
                wanted.iter().enumerate().map(|(k, w)| near(x, k % side) * near(y, k / side) * w).sum::<f64>()
            });
            let all = vec![true; values.len()];
            for (got, wanted) in fit.equations(&all).nodes(&values).iter().zip(&wanted) {
                assert!((f64::from(*got) - wanted).abs() < 1e-4, "{side}: {got} {wanted}");
            }
        }
    }

    #[test]
    fn noise_shrinks_as_points_are_many() {
        let fit = GridFit::new(17).unwrap();
        let count = fit.places(|_, _| ()).len();
        let values: Vec<f64> = noise(count).iter().map(|v| v + 5.0).collect();
        let nodes = fit.equations(&vec![true; count]).nodes(&values);
        let off = |node: &f32| (f64::from(*node) - 5.0).powi(2);
        let rms = (nodes.iter().map(off).sum::<f64>() / nodes.len() as f64).sqrt();
        // 64 points a node, of 0.289 each: alone their mean would have 0.036; a fit has √3 of that along either axis.
        assert!((0.04..0.13).contains(&rms), "{rms}");
    }

    #[test]
    fn nodes_are_never_negative_and_hold_the_light_of_the_points() {
        for side in [4, 17, 32] {
            let fit = GridFit::new(side).unwrap();
            let values: Vec<f64> = fit.places(|s, t| if (s - 0.5).hypot(t - 0.4) < 0.1 { 30.0 } else { 0.0 });
            let noisy: Vec<f64> = values.iter().zip(noise(values.len())).map(|(v, n)| (v + 8.0 * n).max(0.0)).collect();
            for values in [values, noisy] {
                let counts: Vec<bool> = (0..values.len()).map(|k| k % fit.across() > k / fit.across() / 3).collect();
                let equations = fit.equations(&counts);
                let nodes = equations.nodes(&values);
                assert!(nodes.iter().all(|node| *node >= 0.0));
                let held = equations.light(&nodes.iter().map(|node| f64::from(*node)).collect::<Vec<_>>());
                let wanted: f64 = values.iter().zip(&counts).filter(|(_, counts)| **counts).map(|(v, _)| v).sum();
                assert!((held / wanted - 1.0).abs() < 1e-6, "{side}: {held} {wanted}");
            }
        }
    }

    #[test]
    fn points_that_do_not_count_have_no_say() {
        let fit = GridFit::new(9).unwrap();
        let n = fit.across();
        let counts: Vec<bool> = (0..n * n).map(|k| k % n < n / 2).collect();
        let values: Vec<f64> = counts.iter().map(|counts| if *counts { 2.0 } else { -1e9 }).collect();
        let nodes = fit.equations(&counts).nodes(&values);
        assert!((0..9).all(|row| (0..=4).all(|column| (nodes[column + 9 * row] - 2.0).abs() < 1e-6)));
        assert!((0..9).all(|row| nodes[8 + 9 * row] == 0.0));
    }
}
