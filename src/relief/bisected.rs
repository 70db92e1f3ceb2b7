//! A mesh whose triangles cover whole squares of a grid and halves of squares: a thinned sheet, found in a file.

use super::height_grid::HeightGrid;
use super::mesh::Mesh;
use super::thinned::{all_nodes, twice_area};
use crate::progress::{Cancelled, Progress};

/// Squares of the grid for each triangle, at the most: 64 times as many as the largest triangles of a thinned sheet cover.
const MOST_SQUARES: usize = 1 << 13;

/// Most squares of all: 200 MB.
const MOST: usize = 1 << 24;

/// Most grid lines along a side: what would be more is no sheet, and its lines alone would take memory.
const MOST_LINES: f64 = 65_536.0;

/// How far a grid line may lie off its even place, as a share of their distance.
const EVEN: f64 = 1e-2;

/// A square that one triangle covers, among the bits of its halves.
const COVERED: u8 = 0b1111;

/// The grid of heights that the triangles `up` of `mesh` are, each over whole squares and halves of squares; `None` if they
/// are not, or not over the whole rectangle. `rounding`: how far heights of one node may differ, mm.
pub(super) fn bisected(
    mesh: &Mesh,
    up: &[usize],
    rounding: f64,
    progress: &Progress,
) -> Result<Option<HeightGrid>, Cancelled> {
    let [Some(x), Some(y)] = [lines(mesh, up, 0), lines(mesh, up, 1)] else { return Ok(None) };
    let (columns, rows) = (x.len() - 1, y.len() - 1);
    let squares = columns.saturating_mul(rows);
    if squares > MOST || squares / MOST_SQUARES > up.len() {
        return Ok(None);
    }
    let mut heights = vec![f64::NAN; x.len() * y.len()];
    let mut seen = vec![0u8; squares];
    let place = |lines: &[f64], at: f64| lines.binary_search_by(|line| line.total_cmp(&at)).ok().map(|at| at as i64);
    for some in progress.stretches(up.len()) {
        for &k in &up[some?] {
            let corners = mesh.corners(k).map(|v| place(&x, v.x).zip(place(&y, v.y)).map(|(i, j)| ([i, j], v.z)));
            let [Some(a), Some(b), Some(c)] = corners else { return Ok(None) };
            let Some(triangle) = Triangle::new([a, b, c]) else { return Ok(None) };
            let even = triangle.nodes(|i, j, z| {
                let height = &mut heights[j * x.len() + i];
                let same = height.is_nan() || (*height - z).abs() <= rounding;
                // A corner's own height is exact.
                *height = if height.is_nan() || triangle.has_corner(i, j) { z } else { *height };
                same
            });
            let apart = triangle.squares(|i, j, halves| {
                let square = &mut seen[j * columns + i];
                let free = *square & halves == 0;
                *square |= halves;
                free
            });
            if !(even && apart) {
                return Ok(None);
            }
        }
    }
    let rising = seen.iter().map(|&halves| match halves {
        FALLING | COVERED => Some(false),
        RISING => Some(true),
        _ => None,
    });
    let Some(rising) = rising.collect::<Option<Vec<bool>>>() else { return Ok(None) };
    Ok(Some(HeightGrid { x, y, heights, rising }))
}

/// Evenly spaced lines across `axis` on which all corners lie: where corners stand as they do, elsewhere between them.
fn lines(mesh: &Mesh, up: &[usize], axis: usize) -> Option<Vec<f64>> {
    let mut at: Vec<f32> =
        up.iter().flat_map(|&k| mesh.triangles[k]).map(|v| mesh.vertices[v as usize][axis]).collect();
    at.sort_unstable_by(f32::total_cmp);
    at.dedup();
    let (first, last) = (f64::from(*at.first()?), f64::from(*at.last()?));
    let nearest = at.windows(2).map(|pair| f64::from(pair[1]) - f64::from(pair[0])).fold(f64::INFINITY, f64::min);
    let count = ((last - first) / nearest).round();
    if !(2.0..=MOST_LINES).contains(&count) {
        return None;
    }
    let step = (last - first) / count;
    let mut lines: Vec<f64> = (0..=count as usize).map(|k| first + k as f64 * step).collect();
    for at in at.into_iter().map(f64::from) {
        let k = ((at - first) / step).round();
        if (at - first - k * step).abs() > EVEN * step {
            return None;
        }
        lines[k as usize] = at;
    }
    Some(lines)
}

/// A triangle on the grid: its corners counter-clockwise with their heights, columns and rows counted in nodes.
struct Triangle {
    corners: [[i64; 2]; 3],
    heights: [f64; 3],
    twice_area: i64,
}

/// Halves of a square that is cut where it falls, and of one that is cut where it rises.
const FALLING: u8 = 0b0011;
const RISING: u8 = 0b1100;

/// The middles of the halves of a square, in thirds of it: lower and upper half of one that falls, of one that rises.
const MIDDLES: [[i64; 2]; 4] = [[1, 1], [2, 2], [2, 1], [1, 2]];

impl Triangle {
    /// `None` if it has no area or a side runs neither along an axis nor halfway between them.
    fn new(corners: [([i64; 2], f64); 3]) -> Option<Self> {
        let (heights, corners) = (corners.map(|corner| corner.1), corners.map(|corner| corner.0));
        let [a, b, c] = corners;
        let steep = |from: [i64; 2], to: [i64; 2]| {
            let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
            dx != 0 && dy != 0 && dx.abs() != dy.abs()
        };
        let twice = twice_area(a, b, c);
        let fits = twice > 0 && ![(a, b), (b, c), (c, a)].into_iter().any(|(from, to)| steep(from, to));
        fits.then_some(Self { corners, heights, twice_area: twice })
    }

    fn has_corner(&self, i: usize, j: usize) -> bool {
        self.corners.contains(&[i as i64, j as i64])
    }

    fn range(&self, axis: usize) -> (i64, i64) {
        let [a, b, c] = self.corners.map(|corner| corner[axis]);
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// Visits its nodes, sides included, with their heights until one says no; whether none did.
    fn nodes(&self, mut visit: impl FnMut(usize, usize, f64) -> bool) -> bool {
        let whole = self.twice_area as f64;
        all_nodes(self.corners, |[i, j], shares| {
            let z = shares.iter().zip(self.heights).map(|(share, z)| *share as f64 / whole * z).sum();
            visit(i as usize, j as usize, z)
        })
    }

    /// Visits the squares that it reaches into, with the halves of them that it covers, until one says no; whether none did.
    fn squares(&self, mut visit: impl FnMut(usize, usize, u8) -> bool) -> bool {
        let [a, b, c] = self.corners.map(|corner| corner.map(|at| 3 * at));
        let ((west, east), (south, north)) = (self.range(0), self.range(1));
        (south..north).all(|j| {
            (west..east).all(|i| {
                let within = |[x, y]: [i64; 2]| {
                    let at = [3 * i + x, 3 * j + y];
                    twice_area(a, b, at) > 0 && twice_area(b, c, at) > 0 && twice_area(c, a, at) > 0
                };
                let halves = (0..4).filter(|&k| within(MIDDLES[k])).map(|k| 1u8 << k).sum();
                halves == 0 || visit(i as usize, j as usize, halves)
            })
        })
    }
}
