//! A mesh that is a relief on a grid, known as one again: whoever wrote it, it can be traced without a tree.
//!
//! A grid line may be drawn wherever no triangle that faces up reaches across it. The rectangles between such lines
//! hold one plane each, or two triangles between four nodes, or the mesh is no grid.

use glam::{DVec2, DVec3};

use super::bisected::bisected;
use super::faceted::{Facet, FacetedRelief};
use super::height_grid::HeightGrid;
use super::mesh::Mesh;
use crate::progress::{Cancelled, Progress};
use crate::slope::Slope;

/// What a mesh was found to be.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Recognised {
    /// A plane over each rectangle.
    Facets(FacetedRelief),
    /// Two triangles over each rectangle, which is cut either way; neighbours meet at the nodes.
    Heights(HeightGrid),
}

/// How far a corner may lie off its facet's plane, as a share of the shorter side of the rectangle. Writers join corners
/// nearly as high as each other: the solid of this program those within 2e-5 of the finest pitch, which
/// can bend a facet by that much, and this is two and a half times as much. Light turns by 0.006°.
const FLATNESS: f64 = 5e-5;

/// A triangle counts as facing up beyond this part of its unit normal along z: what is steeper than 89.94° is a wall.
/// The steepest facet has 0.4 (65°), walls that single precision has tilted less than a tenth of this.
const UPRIGHT: f64 = 1e-3;

/// The relief on a grid that the upper side of `mesh` is, if it is one; steps of rounding height are closed. A thinned sheet is
/// the grid whose squares its triangles cover.
///
/// The optical area is all of it. Time grows as that of sorting the triangles.
pub fn recognise(mesh: &Mesh, progress: &Progress) -> Result<Option<Recognised>, Cancelled> {
    if mesh.vertices.iter().flatten().any(|c| !c.is_finite())
        || mesh.triangles.iter().flatten().any(|&v| v as usize >= mesh.vertices.len())
    {
        return Ok(None);
    }
    let (low, high) = mesh.bounds();
    let (mut volume, mut up) = (0.0, Vec::new());
    for some in progress.stretches(mesh.triangles.len()) {
        for k in some? {
            volume += six_volumes(mesh, k, low);
            up.extend(faces_up(mesh, k).then_some(k));
        }
    }
    // Inside out, the base would pass for the relief.
    if volume < 0.0 {
        return Ok(None);
    }
    let heights = || bisected(mesh, &up, rounding(mesh), progress);
    let whole = |grid: &HeightGrid| grid.area() == (low.truncate(), high.truncate());
    match on_free_lines(mesh, &up, progress)? {
        None => Ok(heights()?.filter(whole).map(Recognised::Heights)),
        found => Ok(found),
    }
}

/// The relief on the grid of all lines that no triangle reaches across.
fn on_free_lines(mesh: &Mesh, up: &[usize], progress: &Progress) -> Result<Option<Recognised>, Cancelled> {
    let (low, high) = mesh.bounds();
    let Some(x) = free_lines(mesh, up, 0, progress)? else { return Ok(None) };
    let Some(y) = free_lines(mesh, up, 1, progress)? else { return Ok(None) };
    let ends = |lines: &[f64], axis: usize| lines[0] == low[axis] && lines[lines.len() - 1] == high[axis];
    let cells = (x.len() - 1).checked_mul(y.len() - 1);
    if cells.is_none_or(|cells| cells > up.len()) || !ends(&x, 0) || !ends(&y, 1) {
        return Ok(None);
    }
    let interval = |lines: &[f64], at: f64| lines.partition_point(|&line| line <= at).clamp(1, lines.len() - 1) - 1;
    let cell_of = |k: usize| {
        let [a, b, c] = mesh.corners(k);
        let middle = (a + b + c) / 3.0;
        interval(&y, middle.y) * (x.len() - 1) + interval(&x, middle.x)
    };
    let mut homes = Vec::with_capacity(up.len());
    for some in progress.stretches(up.len()) {
        homes.extend(up[some?].iter().map(|&k| cell_of(k) as u32));
    }
    let side = UpperSide { mesh, up, homes, x, y };
    if let Some(facets) = side.facets(progress)? {
        return Ok(Some(Recognised::Facets(facets)));
    }
    Ok(side.nodes(progress)?.map(Recognised::Heights))
}

/// The triangles of a mesh that face up, and the grid that they may stand on.
struct UpperSide<'a> {
    mesh: &'a Mesh,
    up: &'a [usize],
    /// The rectangle of each of them.
    homes: Vec<u32>,
    x: Vec<f64>,
    y: Vec<f64>,
}

/// Six times the volume between `origin` and triangle `k`, positive where it is seen from inside.
fn six_volumes(mesh: &Mesh, k: usize, origin: DVec3) -> f64 {
    let [a, b, c] = mesh.corners(k).map(|v| v - origin);
    a.dot(b.cross(c))
}

fn faces_up(mesh: &Mesh, k: usize) -> bool {
    let [a, b, c] = mesh.corners(k);
    let cross = (b - a).cross(c - a);
    cross.z > UPRIGHT * cross.length()
}

/// All coordinates along `axis` that no triangle reaches across.
fn free_lines(mesh: &Mesh, up: &[usize], axis: usize, progress: &Progress) -> Result<Option<Vec<f64>>, Cancelled> {
    let span = |k: usize| {
        let along = mesh.triangles[k].map(|v| mesh.vertices[v as usize][axis]);
        along.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), &c| (a.min(c), b.max(c)))
    };
    let mut ends: Vec<f32> = Vec::new();
    let in_order = |ends: &mut Vec<f32>| {
        ends.sort_unstable_by(f32::total_cmp);
        ends.dedup();
    };
    let mut room = SORTED_AT_ONCE;
    for some in progress.stretches(up.len()) {
        ends.extend(up[some?].iter().flat_map(|&k| <[f32; 2]>::from(span(k))));
        // On a grid most are alike: what is left is short, and so is each sorting.
        if ends.len() > room {
            in_order(&mut ends);
            room = SORTED_AT_ONCE.max(2 * ends.len());
        }
    }
    in_order(&mut ends);
    // Crossings begin after a triangle's lower end and stop at its upper one.
    let mut crossings = vec![0i32; ends.len() + 1];
    let index = |c: f32| ends.partition_point(|&end| end < c);
    for some in progress.stretches(up.len()) {
        for &k in &up[some?] {
            let (from, to) = span(k);
            crossings[index(from) + 1] += 1;
            crossings[index(to)] -= 1;
        }
    }
    let mut open = 0;
    let free = ends.iter().zip(&crossings).filter_map(|(&at, change)| {
        open += change;
        (open == 0).then_some(f64::from(at))
    });
    let lines: Vec<f64> = free.collect();
    Ok((lines.len() >= 2).then_some(lines))
}

/// Ends of triangles that are sorted at once, at least: some milliseconds.
const SORTED_AT_ONCE: usize = 1 << 17;

impl UpperSide<'_> {
    fn columns(&self) -> usize {
        self.x.len() - 1
    }

    fn rectangle(&self, home: usize) -> (DVec2, DVec2) {
        let (i, j) = (home % self.columns(), home / self.columns());
        (DVec2::new(self.x[i], self.y[j]), DVec2::new(self.x[i + 1], self.y[j + 1]))
    }

    /// Calls `visit` with every triangle and its rectangle until it says that it is enough; whether it never did.
    fn all(&self, progress: &Progress, mut visit: impl FnMut(usize, usize) -> bool) -> Result<bool, Cancelled> {
        for some in progress.stretches(self.up.len()) {
            if !some?.all(|k| visit(self.up[k], self.homes[k] as usize)) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// A plane over each rectangle, if that is what it is.
    fn facets(&self, progress: &Progress) -> Result<Option<FacetedRelief>, Cancelled> {
        let mesh = self.mesh;
        // Area and its moments: gradient and height weighted by the triangles' footprints.
        let mut sums = vec![(0.0, DVec2::ZERO); self.columns() * (self.y.len() - 1)];
        self.all(progress, |k, home| {
            let [a, b, c] = mesh.corners(k);
            let cross = 0.5 * (b - a).cross(c - a);
            let sum = &mut sums[home];
            *sum = (sum.0 + cross.z, sum.1 - cross.truncate());
            true
        })?;
        let covered = sums.iter().enumerate().all(|(home, (area, _))| {
            let (low, high) = self.rectangle(home);
            let whole = (high - low).element_product();
            (area - whole).abs() <= 1e-3 * whole
        });
        if !covered {
            return Ok(None);
        }
        let gradient = |home: usize| sums[home].1 / sums[home].0;
        // The height of the plane that leaves as much of the facet above as below: mean over the corners, by footprint.
        let mut heights = vec![0.0; sums.len()];
        let over_middle = |v: DVec3, home: usize| {
            let (low, high) = self.rectangle(home);
            v.z - gradient(home).dot(v.truncate() - 0.5 * (low + high))
        };
        self.all(progress, |k, home| {
            let corners = mesh.corners(k);
            let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).z;
            let mean = corners.iter().map(|&v| over_middle(v, home)).sum::<f64>() / 3.0;
            heights[home] += mean * area / sums[home].0;
            true
        })?;
        let rounding = rounding(mesh);
        let flat = self.all(progress, |k, home| {
            let (low, high) = self.rectangle(home);
            let tolerance = FLATNESS * (high - low).min_element() + rounding;
            mesh.corners(k).iter().all(|&v| (over_middle(v, home) - heights[home]).abs() <= tolerance)
        })?;
        let facet = |home: usize| Facet { height: heights[home], slope: Slope::from_vec(gradient(home)) };
        Ok(flat.then(|| FacetedRelief {
            x: self.x.clone(),
            y: self.y.clone(),
            facets: (0..sums.len()).map(facet).collect(),
            optical: (0..self.columns(), 0..self.y.len() - 1),
        }))
    }

    /// Two triangles over each rectangle, between nodes, if that is what it is.
    fn nodes(&self, progress: &Progress) -> Result<Option<HeightGrid>, Cancelled> {
        let Self { mesh, x, y, .. } = self;
        let columns = self.columns();
        if self.up.len() != 2 * columns * (y.len() - 1) {
            return Ok(None);
        }
        let rounding = rounding(mesh);
        let mut heights = vec![f64::NAN; x.len() * y.len()];
        // Which triangles of each square have been seen: where it falls the lower one is 1 and the upper one 2, where it
        // rises they are 4 and 8.
        let mut seen = vec![0u8; columns * (y.len() - 1)];
        let between_nodes = self.all(progress, |k, home| {
            let (i, j) = (home % columns, home / columns);
            let mut corners = 0u8;
            for v in mesh.corners(k) {
                let side = |at: f64, low: f64, high: f64| {
                    if at == low { Some(0) } else { (at == high).then_some(1) }
                };
                let (Some(a), Some(b)) = (side(v.x, x[i], x[i + 1]), side(v.y, y[j], y[j + 1])) else { return false };
                corners |= 1 << (2 * b + a);
                let height = &mut heights[(j + b) * x.len() + i + a];
                if !height.is_nan() && (*height - v.z).abs() > rounding {
                    return false;
                }
                *height = v.z;
            }
            // Bits: lower left 1, lower right 2, upper left 4, upper right 8.
            let triangle = match corners {
                0b0111 => 1,
                0b1110 => 2,
                0b1011 => 4,
                0b1101 => 8,
                _ => 0,
            };
            seen[home] |= triangle;
            triangle > 0
        })?;
        let rising = seen.iter().map(|&both| match both {
            0b0011 => Some(false),
            0b1100 => Some(true),
            _ => None,
        });
        let rising = if between_nodes { rising.collect::<Option<_>>() } else { None };
        Ok(rising.map(|rising| HeightGrid { x: x.clone(), y: y.clone(), heights, rising }))
    }
}

/// What single precision may have moved a vertex by, mm.
fn rounding(mesh: &Mesh) -> f64 {
    let (low, high) = mesh.bounds();
    4.0 * f64::from(f32::EPSILON) * low.z.abs().max(high.z.abs())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    fn known(mesh: &Mesh) -> Option<Recognised> {
        recognise(mesh, &Progress::silent()).unwrap()
    }

    /// Heights `z` at the crossings; square k, counted along the rows, is cut upward to the right where `rises` says so.
    fn triangles_of_squares(
        x: &[f64],
        y: &[f64],
        z: impl Fn(usize, usize) -> f64,
        rises: impl Fn(usize) -> bool,
    ) -> Mesh {
        let mut mesh = Mesh::default();
        for (j, &v) in y.iter().enumerate() {
            mesh.vertices.extend(x.iter().enumerate().map(|(i, &u)| [u as f32, v as f32, z(i, j) as f32]));
        }
        let at = |i: usize, j: usize| (j * x.len() + i) as u32;
        for j in 0..y.len() - 1 {
            for i in 0..x.len() - 1 {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                let rises = rises(j * (x.len() - 1) + i);
                mesh.triangles.extend(if rises { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
            }
        }
        mesh
    }

    #[test]
    fn a_height_grid_comes_back_node_for_node_and_cut_for_cut() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let (x, y) = ([0.0, 0.5, 1.0, 1.5, 4.0], [-1.0, 0.0, 0.25]);
        let heights: Vec<f64> = (0..15).map(|_| f64::from(random.random::<f32>())).collect();
        // Every way to cut the eight squares.
        for cuts in 0..256 {
            let rises = |k: usize| cuts >> k & 1 == 1;
            let mesh = triangles_of_squares(&x, &y, |i, j| heights[5 * j + i], rises);
            let rising = (0..8).map(rises).collect();
            let expected = HeightGrid { x: x.to_vec(), y: y.to_vec(), heights: heights.clone(), rising };
            assert_eq!(known(&mesh), Some(Recognised::Heights(expected)), "cuts {cuts}");
            let mut torn = mesh.clone();
            torn.triangles.pop();
            assert_eq!(known(&torn), None);
        }
    }

    #[test]
    fn a_square_is_two_triangles_of_one_cut() {
        let (x, y) = ([0.0, 1.0, 2.0], [0.0, 1.0]);
        let [falling, rising] = [false, true].map(|rises| {
            let mesh = triangles_of_squares(&x, &y, |i, j| [[0.0, 0.3, 0.1], [0.5, 0.1, 0.4]][j][i], |_| rises);
            assert!(matches!(known(&mesh), Some(Recognised::Heights(_))));
            mesh
        });
        // The first square's triangles are any two of its four; those of one cut are the whole square.
        let four = [&falling.triangles[..2], &rising.triangles[..2]].concat();
        for (k, l) in (0..16).map(|pair| (pair % 4, pair / 4)) {
            let mut mesh = falling.clone();
            (mesh.triangles[0], mesh.triangles[1]) = (four[k], four[l]);
            assert_eq!(known(&mesh).is_some(), k != l && k / 2 == l / 2, "{k} {l}");
        }
    }

    #[test]
    fn one_plane_cut_into_a_grid_is_facets_of_that_plane() {
        let (x, y) = ([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 4.0]);
        let mesh = triangles_of_squares(&x, &y, |i, j| 1.0 + 0.25 * x[i] - 0.125 * y[j], |_| true);
        let Some(Recognised::Facets(relief)) = known(&mesh) else { panic!("not recognised") };
        assert_eq!((relief.columns(), relief.rows()), (3, 2));
        assert!(relief.facets.iter().all(|f| (f.slope.to_vec() - DVec2::new(0.25, -0.125)).length() < 1e-6));
        assert!((relief.facet(0, 0).height - 1.0).abs() < 1e-6);
    }

    #[test]
    fn what_is_no_grid_is_not_taken_for_one() {
        assert_eq!(known(&Mesh::default()), None);
        let mut tent = triangles_of_squares(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0], |i, j| (i + j) as f64 * 0.1, |_| false);
        // The middle vertex off its place: the lines there are crossed.
        tent.vertices[4] = [1.2, 0.9, 0.7];
        assert_eq!(known(&tent), None);
    }
}
