//! Closing: the heights, mm, that a cutter leaves of a periodic relief, and the adjoint of its linearisation.
//!
//! A cutter whose tip is a paraboloid of radius R can touch every point of a relief z exactly where |x|²/2R - z is
//! convex. (A ball lies inside its paraboloid, so that what the paraboloid can touch the ball can too.) What the cutter leaves of any other relief is the smallest one above it with that property: along a
//! line, the concave hull of z - |x|²/2R. Hulls along eight directions of the grid, one after the other, come near the
//! hull over the plane.
//!
//! In a hull, each node that the cutter does not touch lies on the paraboloid through two nodes that it does touch: its
//! height is a weighted mean of theirs minus a constant. While the touched nodes stay the same, a pass is therefore
//! affine in the heights, and its adjoint adds each untouched node's gradient to those two nodes with the same weights.

use glam::DVec2;
use rayon::prelude::*;

use crate::cutter::Cutter;

use super::edge_slopes::Lattice;

/// Directions of the hull passes, grid steps. One of each pair is ±1 along an axis, so that lines of `n` nodes cover
/// the grid once.
const DIRECTIONS: [(usize, isize); 8] = [(1, 0), (0, 1), (1, 1), (1, -1), (1, 2), (1, -2), (2, 1), (2, -1)];

/// Closing of `n` × `n` periodic grids by one cutter.
pub struct Closing {
    n: usize,
    /// Height of the paraboloid above its tip at one step of each direction, mm.
    sag: [f32; 8],
}

/// A node that the cutter does not touch, and the two touched ones on its line that carry the paraboloid over it.
#[derive(Clone, Copy, Debug)]
struct Untouched {
    at: u32,
    left: u32,
    right: u32,
    /// Weight of the right node; the left one has the rest.
    share: f32,
}

/// Which nodes the cutter touched in each pass of one closing: all that the adjoint needs.
#[derive(Default)]
pub struct Contacts {
    passes: Vec<Vec<Untouched>>,
}

impl Contacts {
    /// Nodes that were raised, counted in every pass.
    pub fn raised(&self) -> usize {
        self.passes.iter().map(Vec::len).sum()
    }

    /// Turns a gradient with respect to the closed heights into one with respect to the heights before, in place.
    pub fn adjoint(&self, gradient: &mut [f32]) {
        for node in self.passes.iter().rev().flatten() {
            let g = std::mem::take(&mut gradient[node.at as usize]);
            gradient[node.left as usize] += (1.0 - node.share) * g;
            gradient[node.right as usize] += node.share * g;
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

    /// Closes `z` again and again until nothing is raised any more, or `most` times.
    pub fn settle(&self, z: &mut [f32], most: usize) {
        for _ in 0..most {
            let before = z.to_vec();
            self.close(z);
            // The last digit of a raised node is rounded anew each time.
            if z.iter().zip(&before).all(|(a, b)| (a - b).abs() <= 4.0 * f32::EPSILON * a.abs().max(self.sag[0])) {
                break;
            }
        }
    }

    /// Replaces `z` by its hulls along all lines of direction `k`.
    fn pass(&self, z: &mut [f32], k: usize) -> Vec<Untouched> {
        let n = self.n;
        let (dx, dy) = DIRECTIONS[k];
        let lines = Lines { n, dx, dy: dy.rem_euclid(n as isize) as usize };
        let before: &[f32] = z;
        let raised: Vec<Vec<(Untouched, f32)>> = (0..n)
            .into_par_iter()
            .with_min_len(8)
            .map_init(|| Hull::new(n), |hull, line| hull.raised(before, lines, line, self.sag[k]))
            .collect();
        let mut nodes = Vec::with_capacity(raised.iter().map(Vec::len).sum());
        for (node, height) in raised.into_iter().flatten() {
            z[node.at as usize] = height;
            nodes.push(node);
        }
        nodes
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
    /// Calls `visit(k, index)` with the grid index of each node k of a line, in order.
    fn each(self, line: usize, mut visit: impl FnMut(usize, usize)) {
        let n = self.n;
        // Lines start on the side of the grid across which the direction takes single steps.
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

/// Memory for the hull of one line, used again for the next.
struct Hull {
    height: Vec<f32>,
    /// Grid index of each node of the line.
    at: Vec<u32>,
    /// The nodes not yet known to lie below the hull, as a closed list in both directions.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// Nodes that are still to be compared with their neighbours in that list.
    open: Vec<u32>,
}

impl Hull {
    fn new(n: usize) -> Self {
        Self { height: vec![0.0; n], at: vec![0; n], next: vec![0; n], previous: vec![0; n], open: Vec::new() }
    }

    /// The nodes of a line that lie below its hull, with the heights of the hull there.
    fn raised(&mut self, z: &[f32], lines: Lines, line: usize, sag: f32) -> Vec<(Untouched, f32)> {
        let n = lines.n;
        let Self { height, at, next, previous, open } = self;
        lines.each(line, |step, node| {
            height[step] = z[node];
            at[step] = node as u32;
        });
        open.clear();
        let is_below = |a: f32, c: f32, b: f32| 0.5 * (a + b) - sag > c;
        open.extend((1..n - 1).filter(|&c| is_below(height[c - 1], height[c], height[c + 1])).map(|c| c as u32));
        for c in [0, n - 1] {
            if is_below(height[(c + n - 1) % n], height[c], height[(c + 1) % n]) {
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
        // A node below the paraboloid through its present neighbours is not on the hull; once it is taken off the list,
        // the neighbours have new neighbours and are compared again. The highest node of the line is never taken off.
        while let Some(c) = open.pop() {
            let (a, b) = (previous[c as usize], next[c as usize]);
            if a == REMOVED || a == c {
                continue;
            }
            let (to_left, to_right) = (distance(a, c, n), distance(c, b, n));
            let share = to_left / (to_left + to_right);
            let carried = mean(height[a as usize], height[b as usize], share) - to_left * to_right * sag;
            if height[c as usize] < carried {
                (next[a as usize], previous[b as usize]) = (b, a);
                previous[c as usize] = REMOVED;
                open.extend([a, b]);
            }
        }
        let mut raised = Vec::new();
        for a in (0..n).filter(|&a| previous[a] != REMOVED) {
            let b = next[a] as usize;
            let whole = distance(a as u32, b as u32, n);
            for step in 1..whole as usize {
                let (to_left, share) = (step as f32, step as f32 / whole);
                let carried = mean(height[a], height[b], share) - to_left * (whole - to_left) * sag;
                let node = Untouched { at: at[(a + step) % n], left: at[a], right: at[b], share };
                raised.push((node, carried));
            }
        }
        raised
    }
}

/// In place of its predecessor, says that a node was taken off the list.
const REMOVED: u32 = u32::MAX;

/// Steps from `a` forward to `b` on a closed line; once around if they are the same.
fn distance(a: u32, b: u32, n: usize) -> f32 {
    let steps = (b as usize + n - a as usize) % n;
    if steps == 0 { n as f32 } else { steps as f32 }
}

/// The mean of `a` and `b` in which `b` has the weight `share`.
fn mean(a: f32, b: f32, share: f32) -> f32 {
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
        assert!(closing.close(&mut once).raised() > 0);
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

    /// The closing's derivative along `direction` while the touched nodes stay the same.
    fn tangent(contacts: &Contacts, direction: &[f64]) -> Vec<f64> {
        let mut d = direction.to_vec();
        for node in contacts.passes.iter().flatten() {
            let share = f64::from(node.share);
            d[node.at as usize] = (1.0 - share) * d[node.left as usize] + share * d[node.right as usize];
        }
        d
    }

    #[test]
    fn heights_move_as_the_touched_nodes_carry_them() {
        let n = 16;
        let closing = closing(n, 3.0);
        for k in 0..DIRECTIONS.len() {
            let z = rough(n);
            let (mut before, mut after) = (z.clone(), z.clone());
            after.iter_mut().enumerate().for_each(|(k, z)| *z += 1e-7 * (k as f32 * 1.7).sin());
            // What single precision made of the step.
            let direction: Vec<f64> = after.iter().zip(&z).map(|(a, b)| f64::from(a - b)).collect();
            let (nodes, moved) = (closing.pass(&mut before, k), closing.pass(&mut after, k));
            let touched = |nodes: &[Untouched]| nodes.iter().map(|v| (v.at, v.left, v.right)).collect::<Vec<_>>();
            assert!(nodes.len() > n && touched(&nodes) == touched(&moved), "{k}");
            let expected = tangent(&Contacts { passes: vec![nodes] }, &direction);
            let error = |k: usize| (f64::from(after[k] - before[k]) - expected[k]).abs();
            assert!((0..n * n).all(|k| error(k) < 4e-9), "{k}");
        }
    }

    #[test]
    fn the_adjoint_is_the_transpose_of_the_derivative_to_rounding() {
        for (n, radius) in [(16, 0.3), (24, 0.05), (33, 2.0)] {
            let contacts = closing(n, radius).close(&mut rough(n));
            let (x, y): (Vec<f64>, Vec<f32>) =
                (0..n * n).map(|k| ((k as f64 * 1.7).sin(), (k as f64 * 0.3).cos() as f32)).unzip();
            let forward: f64 = tangent(&contacts, &x).iter().zip(&y).map(|(a, b)| a * f64::from(*b)).sum();
            let mut back = y;
            contacts.adjoint(&mut back);
            let products: Vec<f64> = back.iter().zip(&x).map(|(a, b)| f64::from(*a) * b).collect();
            let size: f64 = products.iter().map(|v| v.abs()).sum();
            assert!((forward - products.iter().sum::<f64>()).abs() < 1e-6 * size, "{n}, {radius}");
        }
    }
}
