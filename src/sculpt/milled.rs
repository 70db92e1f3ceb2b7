//! The relief as a ball cutter would really leave it, found another way than the design does: every triangle sampled on
//! a much finer grid and closed exactly, to say what the design is worth.
//!
//! With a parabola in place of the ball (a little blunter on slopes), the tool's path is the upper envelope of parabolas
//! on all points and the surface left is the lower envelope of parabolas under the path. Both part into rows and
//! columns, and along a line take linear time (Felzenszwalb and Huttenlocher 2012). The tool stands only over points of
//! the grid, as on a machine that counts steps.

use glam::DVec2;
use rayon::prelude::*;

use crate::relief::periodic::PeriodicRelief;

/// Samples a side of a cell at the most.
const MOST: usize = 2000;

/// A relief after the cutter.
#[derive(Clone, Debug, PartialEq)]
pub struct Milled {
    /// One cell of the machined surface on its finer grid.
    pub relief: PeriodicRelief,
    /// The most that the cutter stays above the written surface, mm: 0 if it can follow it everywhere.
    pub left: f64,
}

/// One cell of `relief` as a ball of `radius` mm leaves it, on a grid of about `spacing` mm.
pub fn milled(relief: &PeriodicRelief, radius: f64, spacing: f64) -> Milled {
    let n = ((relief.cell.max_element() / spacing).ceil() as usize).clamp(16, MOST);
    let step = relief.cell / n as f64;
    let written: Vec<f64> = (0..n * n)
        .into_par_iter()
        .with_min_len(1 << 12)
        .map(|k| height(relief, DVec2::new((k % n) as f64, (k / n) as f64) / n as f64))
        .collect();
    let mut z = written.clone();
    // Slower fall per squared step of the parabola along x and y.
    let fall = step * step / (2.0 * radius);
    for sign in [1.0, -1.0] {
        along_rows(&mut z, n, fall.x, sign);
        z = transposed(&z, n);
        along_rows(&mut z, n, fall.y, sign);
        z = transposed(&z, n);
    }
    let left = z.iter().zip(&written).fold(0.0, |most: f64, (a, b)| most.max(a - b));
    let heights = z.iter().map(|v| *v as f32).collect();
    let relief = PeriodicRelief { nodes: n, heights, cell: relief.cell, cells: [1, 1], tilt: relief.tilt };
    Milled { relief, left }
}

/// Height of a cell's triangles about the mean plane, at a place in cells, 0 to 1.
fn height(relief: &PeriodicRelief, at: DVec2) -> f64 {
    let n = relief.nodes;
    let at = at * n as f64;
    let (i, j) = ((at.x as usize).min(n - 1), (at.y as usize).min(n - 1));
    let (a, b) = (at.x - i as f64, at.y - j as f64);
    // Where the cut rises, left and right are exchanged: in the mirror it falls.
    let rises = relief.rises(i, j);
    let a = if rises { 1.0 - a } else { a };
    let z = |x: usize, y: usize| {
        let x = if rises { 1 - x } else { x };
        f64::from(relief.heights[(j + y) % n * n + (i + x) % n])
    };
    if a + b <= 1.0 {
        z(0, 0) + a * (z(1, 0) - z(0, 0)) + b * (z(0, 1) - z(0, 0))
    } else {
        z(1, 1) + (1.0 - a) * (z(0, 1) - z(1, 1)) + (1.0 - b) * (z(1, 0) - z(1, 1))
    }
}

/// Replaces every row by the envelope of parabolas on it: upper and falling for sign 1, lower and rising for -1.
fn along_rows(z: &mut [f64], n: usize, fall: f64, sign: f64) {
    z.par_chunks_mut(n).for_each_init(
        || (Vec::with_capacity(3 * n), Vec::with_capacity(3 * n)),
        |(tops, from), row| {
            tops.clear();
            from.clear();
            let value = |k: usize| sign * row[k % n];
            // Three periods; the envelope is read off over the middle one.
            for k in 0..3 * n {
                let mut start = f64::NEG_INFINITY;
                while let Some(&top) = tops.last() {
                    // Where the parabola on k rises above that on top.
                    let (a, b) = (top as f64, k as f64);
                    start = 0.5 * (a + b) + (value(top) - value(k)) / (2.0 * fall * (b - a));
                    if from.last().is_some_and(|&f| start <= f) {
                        tops.pop();
                        from.pop();
                        start = f64::NEG_INFINITY;
                    } else {
                        break;
                    }
                }
                tops.push(k);
                from.push(start);
            }
            let mut present = 0;
            let envelope: Vec<f64> = (n..2 * n)
                .map(|k| {
                    while present + 1 < tops.len() && from[present + 1] <= k as f64 {
                        present += 1;
                    }
                    let way = k as f64 - tops[present] as f64;
                    sign * (value(tops[present]) - fall * way * way)
                })
                .collect();
            row.copy_from_slice(&envelope);
        },
    );
}

fn transposed(z: &[f64], n: usize) -> Vec<f64> {
    (0..n * n).map(|k| z[k % n * n + k / n]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slope::Slope;

    fn relief(nodes: usize, height: impl Fn(f64, f64) -> f64) -> PeriodicRelief {
        let heights = (0..nodes * nodes)
            .map(|k| height((k % nodes) as f64 / nodes as f64, (k / nodes) as f64 / nodes as f64) as f32)
            .collect();
        PeriodicRelief { nodes, heights, cell: DVec2::new(2.0, 1.0), cells: [3, 3], tilt: Slope::new(0.1, 0.0) }
    }

    #[test]
    fn ridges_stay_and_a_groove_gets_its_fillet() {
        // Slopes ±0.2 along x: the ball stays R s²/2 above the bottom of the valley.
        let roof = relief(40, |x, _| 0.4 * (x - 0.5).abs());
        let cut = milled(&roof, 0.25, 0.005);
        assert!((cut.left - 0.25 * 0.04 / 2.0).abs() < 1e-4, "{}", cut.left);
        let n = cut.relief.nodes;
        assert_eq!(n, 400);
        assert!((f64::from(cut.relief.heights[0]) - 0.2).abs() < 1e-6);
        assert_eq!((cut.relief.tilt, cut.relief.cells), (roof.tilt, [1, 1]));
    }

    #[test]
    fn samples_stand_on_the_triangles_that_are_written() {
        let rough = relief(12, |x, y| ((x * 91.0 + y * 57.0).sin() * 43.0).fract() * 0.02);
        for (i, j) in (0..144).map(|k| (k % 12, k / 12)) {
            let node = |[a, b]: [usize; 2]| f64::from(rough.heights[(j + b) % 12 * 12 + (i + a) % 12]);
            let triangles = if rough.rises(i, j) {
                [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]]
            } else {
                [[[0, 0], [1, 0], [0, 1]], [[1, 0], [1, 1], [0, 1]]]
            };
            for corners in triangles {
                let middle =
                    corners.iter().map(|&[a, b]| DVec2::new((i + a) as f64, (j + b) as f64)).sum::<DVec2>() / 3.0;
                let mean = corners.map(node).iter().sum::<f64>() / 3.0;
                assert!((height(&rough, middle / 12.0) - mean).abs() < 1e-12, "({i}, {j}) {corners:?}");
            }
        }
    }

    #[test]
    fn the_envelopes_are_those_of_all_parabolas() {
        let rough = relief(12, |x, y| ((x * 91.0 + y * 57.0).sin() * 43.0).fract() * 0.02);
        let cut = milled(&rough, 0.3, 2.0 / 24.0);
        let n = cut.relief.nodes;
        let step = rough.cell / n as f64;
        let z: Vec<f64> =
            (0..n * n).map(|k| height(&rough, DVec2::new((k % n) as f64, (k / n) as f64) / n as f64)).collect();
        let apart = |a: usize, b: usize| {
            let along = |a: usize, b: usize, h: f64| {
                let d = (a + n - b) % n;
                (d.min(n - d) as f64 * h).powi(2) / 0.6
            };
            along(a % n, b % n, step.x) + along(a / n, b / n, step.y)
        };
        let all = || 0..n * n;
        let path: Vec<f64> = all().map(|k| all().map(|j| z[j] - apart(k, j)).fold(f64::MIN, f64::max)).collect();
        for j in all().step_by(5) {
            let expected = all().map(|k| path[k] + apart(k, j)).fold(f64::MAX, f64::min);
            assert!((f64::from(cut.relief.heights[j]) - expected).abs() < 1e-6, "{j}");
        }
    }
}
