//! What a ball cutter leaves of a periodic relief, and how that answers to the relief: closing and its adjoint.
//!
//! A relief z can be cut by a ball of radius R where |x|²/2R - z is convex (a parabola in place of the sphere, which is
//! a little stricter on slopes). What the cutter leaves of any other is the smallest relief above it with that
//! property: along a line, the concave edges hull of z - |x|²/2R. Hulls along eight directions of the grid, one after the
//! other, come near the full one. In a hull, each node that the cutter does not touch is a mean of two nodes that it
//! does touch plus a constant, so the adjoint of a pass is a scatter with the same weights.

use glam::DVec2;
use rayon::prelude::*;

use crate::cutter::Cutter;

use super::edge_slopes::Lattice;

/// Directions of the hull passes, grid steps. One of each pair is ±1 along an axis, so that lines of `n` nodes cover
/// the grid once.
const DIRECTIONS: [(usize, isize); 8] = [(1, 0), (0, 1), (1, 1), (1, -1), (1, 2), (1, -2), (2, 1), (2, -1)];

/// Closing of `n` × `n` periodic grids by one ball.
pub struct Closing {
    n: usize,
    /// Fall of the ball's surface over one step of each direction, mm.
    sag: [f32; 8],
}

/// A node over which the ball bridges: it hangs between two that the ball touches.
#[derive(Clone, Copy, Debug)]
struct Hang {
    at: u32,
    left: u32,
    right: u32,
    /// Weight of the right contact.
    share: f32,
}

/// The record of one closing, from which its adjoint is computed.
#[derive(Default)]
pub struct Contacts {
    passes: Vec<Vec<Hang>>,
}

impl Contacts {
    /// Nodes bridged in all passes together.
    pub fn bridged(&self) -> usize {
        self.passes.iter().map(Vec::len).sum()
    }

    /// Carries a gradient with respect to the closed relief back to the relief before, in place.
    pub fn adjoint(&self, gradient: &mut [f32]) {
        for hang in self.passes.iter().rev().flatten() {
            let g = std::mem::take(&mut gradient[hang.at as usize]);
            gradient[hang.left as usize] += (1.0 - hang.share) * g;
            gradient[hang.right as usize] += hang.share * g;
        }
    }
}

impl Closing {
    /// For heights on `lattice` and the paraboloid of `cutter`'s tip.
    pub fn new(Lattice { n, step }: Lattice, cutter: Cutter) -> Self {
        let twice_radius = 2.0 * cutter.valley_radius();
        let sag =
            DIRECTIONS.map(|(x, y)| ((step * DVec2::new(x as f64, y as f64)).length_squared() / twice_radius) as f32);
        Self { n, sag }
    }

    /// Closes `z` (rows of constant y) in place, one pass a direction; returns what the adjoint needs.
    pub fn close(&self, z: &mut [f32]) -> Contacts {
        Contacts { passes: (0..DIRECTIONS.len()).map(|k| self.pass(z, k)).collect() }
    }

    /// Closes `z` over and over until nothing is raised any more, or `most` times.
    pub fn settle(&self, z: &mut [f32], most: usize) {
        for _ in 0..most {
            let before = z.to_vec();
            self.close(z);
            // Single precision leaves the last digit of bridged nodes trembling.
            if z.iter().zip(&before).all(|(a, b)| (a - b).abs() <= 4.0 * f32::EPSILON * a.abs().max(self.sag[0])) {
                break;
            }
        }
    }

    /// Hulls along all lines of direction `k`.
    fn pass(&self, z: &mut [f32], k: usize) -> Vec<Hang> {
        let n = self.n;
        let (dx, dy) = DIRECTIONS[k];
        let lines = Lines { n, dx, dy: dy.rem_euclid(n as isize) as usize };
        let held: &[f32] = z;
        let bridged: Vec<Vec<(Hang, f32)>> = (0..n)
            .into_par_iter()
            .with_min_len(8)
            .map_init(|| Hull::new(n), |hull, line| hull.bridge(held, lines, line, self.sag[k]))
            .collect();
        let mut hangs = Vec::with_capacity(bridged.iter().map(Vec::len).sum());
        for (hang, height) in bridged.into_iter().flatten() {
            z[hang.at as usize] = height;
            hangs.push(hang);
        }
        hangs
    }
}

/// The lines of one direction.
#[derive(Clone, Copy)]
struct Lines {
    n: usize,
    dx: usize,
    dy: usize,
}

impl Lines {
    /// Calls `visit` with the grid index of each of the `n` nodes of a line, in order.
    fn walk(self, line: usize, mut visit: impl FnMut(usize, usize)) {
        let n = self.n;
        // Lines start on the side across which the direction steps by ±1.
        let (mut x, mut y) = if self.dx == 1 { (0, line) } else { (line, 0) };
        for step in 0..n {
            visit(step, y * n + x);
            x += self.dx;
            y += self.dy;
            x -= if x >= n { n } else { 0 };
            y -= if y >= n { n } else { 0 };
        }
    }
}

/// Room for the hull of one line, kept from line to line.
struct Hull {
    height: Vec<f32>,
    at: Vec<u32>,
    next: Vec<u32>,
    previous: Vec<u32>,
    open: Vec<u32>,
}

impl Hull {
    fn new(n: usize) -> Self {
        Self { height: vec![0.0; n], at: vec![0; n], next: vec![0; n], previous: vec![0; n], open: Vec::new() }
    }

    /// The nodes of a line that lie below its hull, with their heights on it.
    fn bridge(&mut self, z: &[f32], lines: Lines, line: usize, sag: f32) -> Vec<(Hang, f32)> {
        let n = lines.n;
        let Self { height, at, next, previous, open } = self;
        lines.walk(line, |step, node| {
            height[step] = z[node];
            at[step] = node as u32;
        });
        open.clear();
        let sunk = |a: f32, c: f32, b: f32| 0.5 * (a + b) - sag > c;
        open.extend((1..n - 1).filter(|&c| sunk(height[c - 1], height[c], height[c + 1])).map(|c| c as u32));
        for c in [0, n - 1] {
            if sunk(height[(c + n - 1) % n], height[c], height[(c + 1) % n]) {
                open.push(c as u32);
            }
        }
        if open.is_empty() {
            return Vec::new();
        }
        for c in 0..n as u32 {
            next[c as usize] = c + 1;
            previous[c as usize] = c.wrapping_sub(1);
        }
        next[n - 1] = 0;
        previous[0] = n as u32 - 1;
        // Whatever lies below the bridge between its present neighbours is not on the hull; taking it away may sink the
        // neighbours in turn. The highest node of the line never sinks, so the line never empties.
        while let Some(c) = open.pop() {
            let (a, b) = (previous[c as usize], next[c as usize]);
            if a == REMOVED || a == c {
                continue;
            }
            let (to_left, to_right) = (distance(a, c, n), distance(c, b, n));
            let share = to_left / (to_left + to_right);
            let bridge = span(height[a as usize], height[b as usize], share) - to_left * to_right * sag;
            if height[c as usize] < bridge {
                (next[a as usize], previous[b as usize]) = (b, a);
                previous[c as usize] = REMOVED;
                open.extend([a, b]);
            }
        }
        let mut bridged = Vec::new();
        for a in (0..n).filter(|&a| previous[a] != REMOVED) {
            let b = next[a] as usize;
            let whole = distance(a as u32, b as u32, n);
            for step in 1..whole as usize {
                let (to_left, share) = (step as f32, step as f32 / whole);
                let level = span(height[a], height[b], share) - to_left * (whole - to_left) * sag;
                let hang = Hang { at: at[(a + step) % n], left: at[a], right: at[b], share };
                bridged.push((hang, level));
            }
        }
        bridged
    }
}

/// Mark of a node taken off the hull.
const REMOVED: u32 = u32::MAX;

/// Steps from `a` forward to `b` on a closed line; once around if they are the same.
fn distance(a: u32, b: u32, n: usize) -> f32 {
    let steps = (b as usize + n - a as usize) % n;
    if steps == 0 { n as f32 } else { steps as f32 }
}

fn span(a: f32, b: f32, share: f32) -> f32 {
    a + share * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heights in cells of side 1, uneven but repeatable, and no three in a line but by chance.
    fn rough(n: usize) -> Vec<f32> {
        (0..n * n).map(|k| (((k as f64 + 1.0).sin() * 43_758.545_3).fract() * 0.01) as f32).collect()
    }

    fn closing(n: usize, radius: f64) -> Closing {
        Closing::new(Lattice { n, step: DVec2::splat(1.0 / n as f64) }, Cutter::ball(2.0 * radius))
    }

    #[test]
    fn closing_only_raises_and_leaves_what_is_closed() {
        let closing = closing(24, 0.3);
        let before = rough(24);
        let mut once = before.clone();
        assert!(closing.close(&mut once).bridged() > 0);
        assert!(once.iter().zip(&before).all(|(a, b)| a >= b));
        let mut settled = once.clone();
        closing.settle(&mut settled, 100);
        let mut again = settled.clone();
        closing.close(&mut again);
        assert!(again.iter().zip(&settled).all(|(a, b)| (a - b).abs() < 1e-7));
    }

    #[test]
    fn a_line_is_closed_by_its_concave_hull() {
        // Against every chord between two nodes of three periods, the definition of the hull.
        let (n, radius) = (12, 0.2);
        let closing = closing(n, radius);
        let mut z: Vec<f32> = rough(n)[..n].repeat(n);
        let line: Vec<f64> = z[..n].iter().map(|&v| f64::from(v)).collect();
        closing.pass(&mut z, 0);
        let lowered = |k: usize| line[k % n] - (k as f64 / n as f64).powi(2) / (2.0 * radius);
        for (c, &closed) in z[..n].iter().enumerate() {
            let middle = c + n;
            let mut hull = lowered(middle);
            for a in 0..middle {
                for b in middle + 1..3 * n {
                    let t = (middle - a) as f64 / (b - a) as f64;
                    hull = hull.max((1.0 - t) * lowered(a) + t * lowered(b));
                }
            }
            let hull = hull + (middle as f64 / n as f64).powi(2) / (2.0 * radius);
            assert!((f64::from(closed) - hull).abs() < 1e-6, "{c}: {closed} {hull}");
        }
    }

    #[test]
    fn eight_directions_come_near_the_full_hull() {
        // The full hull by its definition: a parabolic ball stands wherever it can, on a grid much finer than the
        // nodes, and reaches down to what it leaves of them.
        let (n, finer, radius) = (12, 6, 0.25);
        let z: Vec<f32> = (0..n * n)
            .map(|k| {
                let turn = |k: usize| k as f32 / n as f32 * std::f32::consts::TAU;
                let (x, y) = (turn(k % n), turn(k / n));
                0.1 * (x.sin() * (y + 0.5).cos() + (x + 2.0 * y).sin())
            })
            .collect();
        let m = n * finer;
        let apart = |a: usize, b: usize| {
            let d = (a + m - b) % m;
            (d.min(m - d) as f64 / m as f64).powi(2) / (2.0 * radius)
        };
        let ball = |c: usize, k: usize| apart(c % m, k % n * finer) + apart(c / m, k / n * finer);
        let mut full = vec![f64::MAX; n * n];
        for c in 0..m * m {
            let path = (0..n * n).map(|k| f64::from(z[k]) - ball(c, k)).fold(f64::MIN, f64::max);
            full.iter_mut().enumerate().for_each(|(k, v)| *v = v.min(path + ball(c, k)));
        }
        let mut ours = z.clone();
        closing(n, radius).settle(&mut ours, 50);
        let raised: f64 = full.iter().zip(&z).map(|(a, b)| a - f64::from(*b)).sum();
        let differing: f64 = full.iter().zip(&ours).map(|(a, b)| (a - f64::from(*b)).abs()).sum();
        assert!(raised > 0.02 && differing < 0.15 * raised, "{differing} of {raised}");
    }

    #[test]
    fn the_adjoint_is_the_derivative() {
        let n = 16;
        let closing = closing(n, 0.3);
        let z = rough(n);
        let weight: Vec<f32> = (0..n * n).map(|k| ((k * 31 % 17) as f32) - 8.0).collect();
        let value = |z: &[f32]| {
            let mut closed = z.to_vec();
            closing.close(&mut closed);
            closed.iter().zip(&weight).map(|(a, b)| f64::from(a * b)).sum::<f64>()
        };
        let mut gradient = weight.clone();
        closing.close(&mut z.clone()).adjoint(&mut gradient);
        // Where a step passes a kink the difference is between two derivatives: rare, and not to be held against us.
        let near = |k: usize| {
            let d = 3e-6;
            let (mut up, mut down) = (z.clone(), z.clone());
            up[k] += d;
            down[k] -= d;
            let measured = (value(&up) - value(&down)) / f64::from(up[k] - down[k]);
            (measured - f64::from(gradient[k])).abs() < 0.1
        };
        let agreeing = (0..n * n).filter(|&k| near(k)).count();
        assert!(agreeing > n * n * 95 / 100, "{agreeing}");
    }
}
