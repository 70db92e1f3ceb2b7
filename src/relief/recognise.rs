//! A mesh that is a relief on a grid, known as one again: whoever wrote it, it can be traced without a tree.
//!
//! A grid line may be drawn wherever no triangle that faces up reaches across it. The rectangles between such lines
//! hold one plane each, or two triangles between four nodes, or the mesh is no grid.

use glam::{DVec2, DVec3};

use super::faceted::{Facet, FacetedRelief};
use super::height_grid::HeightGrid;
use super::mesh::Mesh;
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

/// The relief on a grid that the upper side of `mesh` is, if it is one; steps of rounding height are closed.
///
/// The optical area is all of it. Time grows as that of sorting the triangles.
pub fn recognise(mesh: &Mesh) -> Option<Recognised> {
    if mesh.vertices.iter().flatten().any(|c| !c.is_finite())
        || mesh.triangles.iter().flatten().any(|&v| v as usize >= mesh.vertices.len())
    {
        return None;
    }
    let (low, high) = mesh.bounds();
    // Inside out, the base would pass for the relief.
    if (0..mesh.triangles.len()).map(|k| six_volumes(mesh, k, low)).sum::<f64>() < 0.0 {
        return None;
    }
    let up: Vec<usize> = (0..mesh.triangles.len()).filter(|&k| faces_up(mesh, k)).collect();
    let x = free_lines(mesh, &up, 0)?;
    let y = free_lines(mesh, &up, 1)?;
    let ends = |lines: &[f64], axis: usize| lines[0] == low[axis] && lines[lines.len() - 1] == high[axis];
    let cells = (x.len() - 1).checked_mul(y.len() - 1)?;
    if cells > up.len() || !ends(&x, 0) || !ends(&y, 1) {
        return None;
    }
    let interval = |lines: &[f64], at: f64| lines.partition_point(|&line| line <= at).clamp(1, lines.len() - 1) - 1;
    let cell_of = |k: usize| {
        let [a, b, c] = mesh.corners(k);
        let middle = (a + b + c) / 3.0;
        interval(&y, middle.y) * (x.len() - 1) + interval(&x, middle.x)
    };
    let homes: Vec<u32> = up.iter().map(|&k| cell_of(k) as u32).collect();
    facets(mesh, &up, &homes, &x, &y)
        .map(Recognised::Facets)
        .or_else(|| nodes(mesh, &up, &homes, &x, &y).map(Recognised::Heights))
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
fn free_lines(mesh: &Mesh, up: &[usize], axis: usize) -> Option<Vec<f64>> {
    let span = |k: usize| {
        let along = mesh.triangles[k].map(|v| mesh.vertices[v as usize][axis]);
        along.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), &c| (a.min(c), b.max(c)))
    };
    let mut ends: Vec<f32> = up.iter().flat_map(|&k| <[f32; 2]>::from(span(k))).collect();
    ends.sort_unstable_by(f32::total_cmp);
    ends.dedup();
    // Crossings begin after a triangle's lower end and stop at its upper one.
    let mut crossings = vec![0i32; ends.len() + 1];
    let index = |c: f32| ends.partition_point(|&end| end < c);
    for &k in up {
        let (from, to) = span(k);
        crossings[index(from) + 1] += 1;
        crossings[index(to)] -= 1;
    }
    let mut open = 0;
    let free = ends.iter().zip(&crossings).filter_map(|(&at, change)| {
        open += change;
        (open == 0).then_some(f64::from(at))
    });
    let lines: Vec<f64> = free.collect();
    (lines.len() >= 2).then_some(lines)
}

fn facets(mesh: &Mesh, up: &[usize], homes: &[u32], x: &[f64], y: &[f64]) -> Option<FacetedRelief> {
    let columns = x.len() - 1;
    // Area and its moments: gradient and height weighted by the triangles' footprints.
    let mut sums = vec![(0.0, DVec2::ZERO); columns * (y.len() - 1)];
    for (&k, &home) in up.iter().zip(homes) {
        let [a, b, c] = mesh.corners(k);
        let cross = 0.5 * (b - a).cross(c - a);
        let sum = &mut sums[home as usize];
        *sum = (sum.0 + cross.z, sum.1 - cross.truncate());
    }
    let rectangle = |home: usize| {
        let (i, j) = (home % columns, home / columns);
        (DVec2::new(x[i], y[j]), DVec2::new(x[i + 1], y[j + 1]))
    };
    let covered = sums.iter().enumerate().all(|(home, (area, _))| {
        let (low, high) = rectangle(home);
        let whole = (high - low).element_product();
        (area - whole).abs() <= 1e-3 * whole
    });
    if !covered {
        return None;
    }
    let gradient = |home: usize| sums[home].1 / sums[home].0;
    // The height of the plane that leaves as much of the facet above as below: mean over the corners, by footprint.
    let mut heights = vec![0.0; sums.len()];
    let over_middle = |v: DVec3, home: usize| {
        let (low, high) = rectangle(home);
        v.z - gradient(home).dot(v.truncate() - 0.5 * (low + high))
    };
    for (&k, &home) in up.iter().zip(homes) {
        let corners = mesh.corners(k);
        let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).z;
        let mean = corners.iter().map(|&v| over_middle(v, home as usize)).sum::<f64>() / 3.0;
        heights[home as usize] += mean * area / sums[home as usize].0;
    }
    let rounding = rounding(mesh);
    let flat = up.iter().zip(homes).all(|(&k, &home)| {
        let home = home as usize;
        let (low, high) = rectangle(home);
        let tolerance = FLATNESS * (high - low).min_element() + rounding;
        mesh.corners(k).iter().all(|&v| (over_middle(v, home) - heights[home]).abs() <= tolerance)
    });
    let facet = |home: usize| Facet { height: heights[home], slope: Slope::from_vec(gradient(home)) };
    flat.then(|| FacetedRelief {
        x: x.to_vec(),
        y: y.to_vec(),
        facets: (0..sums.len()).map(facet).collect(),
        optical: (0..columns, 0..y.len() - 1),
    })
}

fn nodes(mesh: &Mesh, up: &[usize], homes: &[u32], x: &[f64], y: &[f64]) -> Option<HeightGrid> {
    let columns = x.len() - 1;
    if up.len() != 2 * columns * (y.len() - 1) {
        return None;
    }
    let rounding = rounding(mesh);
    let mut heights = vec![f64::NAN; x.len() * y.len()];
    // Which triangles of each square have been seen: where it falls the lower one is 1 and the upper one 2, where it
    // rises they are 4 and 8.
    let mut seen = vec![0u8; columns * (y.len() - 1)];
    for (&k, &home) in up.iter().zip(homes) {
        let (i, j) = (home as usize % columns, home as usize / columns);
        let mut corners = 0u8;
        for v in mesh.corners(k) {
            let side = |at: f64, low: f64, high: f64| {
                if at == low { Some(0) } else { (at == high).then_some(1) }
            };
            let (a, b) = (side(v.x, x[i], x[i + 1])?, side(v.y, y[j], y[j + 1])?);
            corners |= 1 << (2 * b + a);
            let height = &mut heights[(j + b) * x.len() + i + a];
            if !height.is_nan() && (*height - v.z).abs() > rounding {
                return None;
            }
            *height = v.z;
        }
        // Bits: lower left 1, lower right 2, upper left 4, upper right 8.
        seen[home as usize] |= match corners {
            0b0111 => 1,
            0b1110 => 2,
            0b1011 => 4,
            0b1101 => 8,
            _ => return None,
        };
    }
    let rising = seen.iter().map(|&both| match both {
        0b0011 => Some(false),
        0b1100 => Some(true),
        _ => None,
    });
    let rising = rising.collect::<Option<_>>()?;
    Some(HeightGrid { x: x.to_vec(), y: y.to_vec(), heights, rising })
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
            assert_eq!(recognise(&mesh), Some(Recognised::Heights(expected)), "cuts {cuts}");
            let mut torn = mesh.clone();
            torn.triangles.pop();
            assert_eq!(recognise(&torn), None);
        }
    }

    #[test]
    fn a_square_is_two_triangles_of_one_cut() {
        let (x, y) = ([0.0, 1.0, 2.0], [0.0, 1.0]);
        let [falling, rising] = [false, true].map(|rises| {
            let mesh = triangles_of_squares(&x, &y, |i, j| [[0.0, 0.3, 0.1], [0.5, 0.1, 0.4]][j][i], |_| rises);
            assert!(matches!(recognise(&mesh), Some(Recognised::Heights(_))));
            mesh
        });
        // The first square's triangles are any two of its four; those of one cut are the whole square.
        let four = [&falling.triangles[..2], &rising.triangles[..2]].concat();
        for (k, l) in (0..16).map(|pair| (pair % 4, pair / 4)) {
            let mut mesh = falling.clone();
            (mesh.triangles[0], mesh.triangles[1]) = (four[k], four[l]);
            assert_eq!(recognise(&mesh).is_some(), k != l && k / 2 == l / 2, "{k} {l}");
        }
    }

    #[test]
    fn one_plane_cut_into_a_grid_is_facets_of_that_plane() {
        let (x, y) = ([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 4.0]);
        let mesh = triangles_of_squares(&x, &y, |i, j| 1.0 + 0.25 * x[i] - 0.125 * y[j], |_| true);
        let Some(Recognised::Facets(relief)) = recognise(&mesh) else { panic!("not recognised") };
        assert_eq!((relief.columns(), relief.rows()), (3, 2));
        assert!(relief.facets.iter().all(|f| (f.slope.to_vec() - DVec2::new(0.25, -0.125)).length() < 1e-6));
        assert!((relief.facet(0, 0).height - 1.0).abs() < 1e-6);
    }

    #[test]
    fn what_is_no_grid_is_not_taken_for_one() {
        assert_eq!(recognise(&Mesh::default()), None);
        let mut tent = triangles_of_squares(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0], |i, j| (i + j) as f64 * 0.1, |_| false);
        // The middle vertex off its place: the lines there are crossed.
        tent.vertices[4] = [1.2, 0.9, 0.7];
        assert_eq!(recognise(&tent), None);
    }
}
