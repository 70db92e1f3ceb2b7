//! The sheet as a closed body: its own triangles, a flat rim if wanted, sides and a flat base.

use glam::DVec2;
use thiserror::Error;

use crate::progress::{Cancelled, Progress};
use crate::relief::mesh::Mesh;
use crate::relief::open::NodeGrid;
use crate::relief::rim::Rim;
use crate::relief::thinned::{Thinned, Tiled};

/// Least number of single-precision steps between nodes: rounded by half a step each, they stay in order and their
/// distance changes by an eighth at worst.
const LEAST_STEPS: f64 = 8.0;

/// Largest step of single precision in heights, as a share of the nodes' distance: the most that rounding may cost in
/// slope. It turns light by 0.011°, a fortieth of the finest blur in reports.
const WORST_SLOPE: f64 = 1e-4;

/// The solid body under `relief`, with a rim that starts level with its lowest point (a width in mm is a flat one),
/// whose flat base lies `thickness` mm below the lowest point of both.
///
/// Vertices are shared, every edge has two triangles, and nothing inside the plate is vertical; with a rim, a wall
/// stands around the relief, without one the sides do.
///
/// # Errors
/// When the plate is too large for its details in single precision, the thickness is not positive, a height is not
/// finite, or the body outgrows the 32-bit counts of an STL file.
pub fn sheet_solid(
    relief: &impl NodeGrid,
    thickness: f64,
    rim: impl Into<Rim>,
    progress: &Progress,
) -> Result<Mesh, SheetError> {
    let rim = rim.into();
    let [nx, ny] = relief.plate_nodes();
    let whole = Whole::of(relief, thickness, rim)?;
    let mut mesh = Mesh::default();
    mesh.triangles.reserve_exact(whole.triangles as usize);
    for j in 0..ny {
        progress.check()?;
        mesh.vertices.extend((0..nx).map(|i| vertex(relief, i, j)));
    }
    for j in 0..ny - 1 {
        progress.check()?;
        for i in 0..nx - 1 {
            let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| ((j + y) * nx + i + x) as u32);
            mesh.triangles.extend(if relief.rises(i, j) { [[a, b, d], [a, d, c]] } else { [[a, b, c], [b, d, c]] });
        }
    }
    let sides = [nx, ny, nx, ny];
    let around = border(&sides.map(|n| (0..n).collect()), |i, j| (j * nx + i) as u32);
    whole.closed(mesh, around, sides.map(|n| n - 1))
}

/// The solid body under a thinned sheet, as [`sheet_solid`] closes one that is not.
///
/// # Errors
/// As of [`sheet_solid`].
pub fn thinned_solid(
    thinned: &Thinned<impl Tiled>,
    thickness: f64,
    rim: impl Into<Rim>,
    progress: &Progress,
) -> Result<Mesh, SheetError> {
    let rim = rim.into();
    let relief = &thinned.relief;
    let ([nx, ny], tiles, squares) = (relief.plate_nodes(), relief.tiles(), relief.squares());
    let whole = Whole::of(relief, thickness, rim)?;
    let mut mesh = Mesh::default();
    // Numbers of the nodes that are corners.
    let mut numbers = vec![u32::MAX; nx * ny];
    for [column, row] in (0..tiles[0] * tiles[1]).map(|k| [k % tiles[0], k / tiles[0]]) {
        progress.check()?;
        mesh.triangles.extend(thinned.triangles.iter().map(|corners| {
            corners.map(|[i, j]| {
                let (i, j) = (column * squares[0] + i as usize, row * squares[1] + j as usize);
                let number = &mut numbers[j * nx + i];
                if *number == u32::MAX {
                    *number = mesh.vertices.len() as u32;
                    mesh.vertices.push(vertex(relief, i, j));
                }
                *number
            })
        }));
    }
    let sides = thinned.along_rim();
    let around = border(&sides, |i, j| numbers[j * nx + i]);
    whole.closed(mesh, around, sides.map(|side| side.len() - 1))
}

/// Node (i, j) as it is written: adding zero turns -0 into 0, which readers may or may not tell apart.
fn vertex(relief: &impl NodeGrid, i: usize, j: usize) -> [f32; 3] {
    relief.node(i, j).to_array().map(|v| v as f32 + 0.0)
}

/// What a body must hold beside its upper side, and what it may not exceed.
struct Whole {
    rim: Rim,
    low: f64,
    base: f64,
    size: DVec2,
    /// With two for each square.
    triangles: u64,
}

impl Whole {
    fn of(relief: &impl NodeGrid, thickness: f64, rim: Rim) -> Result<Self, SheetError> {
        let [nx, ny] = relief.plate_nodes();
        let (low, high) = relief.height_range();
        let base = low - rim.depth() - thickness;
        if !((0..nx * ny).all(|k| relief.node(k % nx, k / nx).z.is_finite()) && low.is_finite() && high.is_finite()) {
            return Err(SheetError::NotFinite);
        }
        if !(thickness > 1e-6 * relief.size().max_element() && (low as f32) > (base as f32)) {
            return Err(SheetError::Thickness(thickness));
        }
        let step = relief.step().min_element();
        let size = relief.size();
        let ulp = |v: f64| f64::from((v as f32).next_up() - v as f32);
        let reach = high.abs().max(base.abs());
        if ulp(size.max_element() + rim.width) * LEAST_STEPS > step || ulp(reach) > WORST_SLOPE * step {
            return Err(SheetError::Fine { step });
        }
        let triangles = 2 * (nx - 1) as u64 * (ny - 1) as u64 + 16 * (nx + ny) as u64;
        if triangles > u64::from(u32::MAX) {
            return Err(SheetError::TooMany);
        }
        Ok(Self { rim, low, base, size, triangles })
    }

    /// `mesh` with rim, sides and base, whose loop `around` starts at the lower left corner and has `sides` edges along each of
    /// its sides in turn.
    fn closed(self, mut mesh: Mesh, mut around: Vec<u32>, sides: [usize; 4]) -> Result<Mesh, SheetError> {
        let Self { rim, low, base, size, .. } = self;
        if rim.width > 0.0 {
            around = lowered(&mut mesh, &around, low as f32 + 0.0);
            around = match rim.fall > 0.0 {
                false => widened(&mut mesh, &around, rim.width, size),
                true => sloped(&mut mesh, &around, rim, sides),
            };
        }
        let below = lowered(&mut mesh, &around, base as f32 + 0.0);
        let middle = (0.5 * size).extend(base).to_array().map(|v| v as f32 + 0.0);
        fan(&mut mesh, &below, middle);
        Ok(mesh)
    }
}

/// The nodes around the plate, counter-clockwise seen from above, of those that stand at `sides` along its lower, right, upper
/// and left side, each ascending with both ends; node (i, j) has number `number(i, j)`.
fn border(sides: &[Vec<usize>; 4], number: impl Fn(usize, usize) -> u32) -> Vec<u32> {
    let [south, east, north, west] = sides;
    let (Some((&right, to_right)), Some((&top, to_top))) = (south.split_last(), east.split_last()) else {
        return Vec::new();
    };
    let (to_left, to_bottom) = (north.iter().skip(1).rev(), west.iter().skip(1).rev());
    let south = to_right.iter().map(|&i| number(i, 0));
    let east = to_top.iter().map(|&j| number(right, j));
    south.chain(east).chain(to_left.map(|&i| number(i, top))).chain(to_bottom.map(|&j| number(0, j))).collect()
}

/// A vertical wall below a counter-clockwise loop, down to height `z`; the loop at its foot. Nodes that stand there
/// already are their own foot.
fn lowered(mesh: &mut Mesh, above: &[u32], z: f32) -> Vec<u32> {
    let below: Vec<u32> = above
        .iter()
        .map(|&v| {
            let [x, y, height] = mesh.vertices[v as usize];
            if height <= z {
                return v;
            }
            mesh.vertices.push([x, y, z]);
            mesh.vertices.len() as u32 - 1
        })
        .collect();
    band(mesh, above, &below);
    below
}

/// A flat band `width` mm wide around a counter-clockwise loop of a plate of `size`; the loop at its outer side.
fn widened(mesh: &mut Mesh, inner: &[u32], width: f64, size: DVec2) -> Vec<u32> {
    // Nodes keep their neighbours: each moves straight outward, those of the corners along both axes.
    let stretch = (size + 2.0 * width) / size;
    let outer = inner
        .iter()
        .map(|&v| {
            let [x, y, z] = mesh.vertices[v as usize];
            let at = 0.5 * size + stretch * (DVec2::new(f64::from(x), f64::from(y)) - 0.5 * size);
            mesh.vertices.push([at.x as f32 + 0.0, at.y as f32 + 0.0, z]);
            mesh.vertices.len() as u32 - 1
        })
        .collect::<Vec<_>>();
    band(mesh, inner, &outer);
    outer
}

/// A falling band around a counter-clockwise loop that starts at the lower left corner and has `sides` edges along each side in
/// turn; the loop at its outer side. Nodes move straight outward; a corner becomes three, so that each side is one plane and each
/// corner another.
fn sloped(mesh: &mut Mesh, inner: &[u32], rim: Rim, sides: [usize; 4]) -> Vec<u32> {
    let corners = [0, sides[0], sides[0] + sides[1], sides[0] + sides[1] + sides[2]];
    // Outward from the side that ends in a corner, and from the one that begins there.
    let outward = [DVec2::NEG_Y, DVec2::X, DVec2::Y, DVec2::NEG_X];
    let (mut from, mut to) = (Vec::new(), Vec::new());
    for (k, &v) in inner.iter().enumerate() {
        let side = corners.partition_point(|&corner| corner <= k) - 1;
        let (before, after) = (outward[(side + 3) % 4], outward[side]);
        let ways = if corners[side] == k { vec![before, before + after, after] } else { vec![after] };
        for way in ways {
            let [x, y, z] = mesh.vertices[v as usize].map(f64::from);
            let at = DVec2::new(x, y) + rim.width * way;
            let fallen = z - rim.width * rim.fall * (way.x.abs() + way.y.abs());
            mesh.vertices.push([at.x as f32 + 0.0, at.y as f32 + 0.0, fallen as f32 + 0.0]);
            from.push(v);
            to.push(mesh.vertices.len() as u32 - 1);
        }
    }
    band(mesh, &from, &to);
    to
}

/// Two triangles between each pair of neighbours of two loops; what has no area is left out.
fn band(mesh: &mut Mesh, from: &[u32], to: &[u32]) {
    for k in 0..from.len() {
        let next = (k + 1) % from.len();
        let (a, b, c, d) = (from[k], from[next], to[k], to[next]);
        for [p, q, r] in [[a, c, b], [b, c, d]] {
            if p != q && q != r && r != p {
                mesh.triangles.push([p, q, r]);
            }
        }
    }
}

/// The flat underside: a fan from `middle` to a loop that is counter-clockwise seen from above.
fn fan(mesh: &mut Mesh, rim: &[u32], middle: [f32; 3]) {
    mesh.vertices.push(middle);
    let hub = mesh.vertices.len() as u32 - 1;
    mesh.triangles.extend((0..rim.len()).map(|k| [hub, rim[(k + 1) % rim.len()], rim[k]]));
}

/// Why a sheet has no solid body.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SheetError {
    /// A height is infinite or not a number.
    #[error("the relief has a height that is not a finite number")]
    NotFinite,
    /// The base is not below the relief, as far as an STL file can tell.
    #[error("a base {0} mm below the lowest point cannot be told from it in an STL file: raise --thickness")]
    Thickness(f64),
    /// The plate is too large for nodes so near to each other.
    #[error(
        "nodes {step:.5} mm apart are too close for an STL file's single precision: lower --grid or the plate's size"
    )]
    Fine {
        /// Distance of nodes, mm.
        step: f64,
    },
    /// Triangles do not fit 32-bit counts.
    #[error("the solid would need more triangles than an STL file can count: lower --grid or --cells")]
    TooMany,
    /// The caller wanted nothing more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::relief::periodic::PeriodicRelief;
    use crate::relief::recognise::{Recognised, recognise};
    use crate::slope::Slope;

    fn relief(cells: [usize; 2], tilt: Slope) -> PeriodicRelief {
        let heights = (0..25).map(|k| (k * k % 11) as f32 * 0.01).collect();
        PeriodicRelief { nodes: 5, heights, cell: DVec2::new(2.0, 1.5), cells, tilt }
    }

    fn closed(relief: &PeriodicRelief, thickness: f64, rim: impl Into<Rim>) -> Result<Mesh, SheetError> {
        sheet_solid(relief, thickness, rim, &Progress::silent())
    }

    /// Volume by the divergence theorem; panics unless every directed edge has its opposite exactly once.
    fn closed_volume(mesh: &Mesh) -> f64 {
        let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
        let mut volume = 0.0;
        for (k, t) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(k);
            volume += a.dot(b.cross(c)) / 6.0;
            for e in 0..3 {
                *edges.entry((t[e], t[(e + 1) % 3])).or_default() += 1;
            }
        }
        for (&(a, b), &count) in &edges {
            assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
        }
        volume
    }

    #[test]
    fn bodies_are_closed_and_as_large_as_their_prisms() {
        for (cells, tilt, width, fall) in [
            ([1, 1], Slope::FLAT, 0.0, 0.0),
            ([2, 3], Slope::new(0.05, -0.1), 0.0, 0.0),
            ([2, 1], Slope::new(0.0, 0.1), 0.7, 0.0),
            ([2, 1], Slope::new(0.0, 0.1), 0.7, 0.3),
        ] {
            let (relief, rim) = (relief(cells, tilt), Rim { width, fall });
            let mesh = closed(&relief, 2.0, rim).unwrap();
            let low = relief.height_range().0 - rim.depth();
            let [nx, ny] = relief.plate_nodes();
            let prisms = (0..(nx - 1) * (ny - 1)).map(|k| {
                let (i, j) = (k % (nx - 1), k / (nx - 1));
                let z = |a: usize, b: usize| relief.node(i + a, j + b).z - low + 2.0;
                // The ends of the cut belong to both triangles, and the cut is the higher diagonal.
                let (rising, falling) = (z(0, 0) + z(1, 1), z(1, 0) + z(0, 1));
                (rising + falling + rising.max(falling)) / 6.0 * relief.step().element_product()
            });
            let size = relief.size();
            // Sides are half as much higher than the base's thickness as they fall, corners as they fall once.
            let (sides, corners) = (2.0 * width * (size.x + size.y), 4.0 * width * width);
            let above = rim.depth() + 2.0 - 0.5 * fall * width;
            let expected = prisms.sum::<f64>() + sides * above + corners * (above - 0.5 * fall * width);
            assert!((closed_volume(&mesh) / expected - 1.0).abs() < 1e-5, "{cells:?}");
            let (from, to) = mesh.bounds();
            assert!((to - from).truncate().distance(size + 2.0 * width) < 1e-5);
        }
    }

    #[test]
    fn every_square_is_written_with_its_own_cut() {
        let relief = relief([2, 3], Slope::new(0.05, -0.1));
        let Some(Recognised::Heights(grid)) =
            recognise(&closed(&relief, 2.0, 0.0).unwrap(), &Progress::silent()).unwrap()
        else {
            panic!("not known again")
        };
        let rising: Vec<bool> = (0..150).map(|k| relief.rises(k % 10, k / 10)).collect();
        assert!(rising.contains(&true) && rising.contains(&false));
        assert_eq!(grid.rising, rising);
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        let plain = relief([1, 1], Slope::FLAT);
        assert_eq!(closed(&plain, 0.0, 0.0), Err(SheetError::Thickness(0.0)));
        assert_eq!(closed(&plain, 1e-12, 0.0), Err(SheetError::Thickness(1e-12)));
        assert!(matches!(closed(&plain, 1e5, 0.0), Err(SheetError::Fine { .. })));
        let tiny = PeriodicRelief { cell: DVec2::splat(1e-5), cells: [10_000, 1], ..plain.clone() };
        assert!(matches!(closed(&tiny, 1.0, 0.0), Err(SheetError::Fine { .. })));
        let mut broken = plain;
        broken.heights[3] = f32::NAN;
        assert_eq!(closed(&broken, 1.0, 0.0), Err(SheetError::NotFinite));
    }
}
