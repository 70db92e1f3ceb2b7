//! The exact relief as a closed body: facets, walls, sides and a flat base.
//!
//! Up to four facets meet at a grid node, each with its own height there; every distinct height is one vertex of that
//! node's column, and whatever stands along the column uses all vertices between its ends, so that no vertex ever
//! lies inside another triangle's edge. The surroundings of the plate count as facets at the height of the base.
//!
//! ```text
//!    left high ●───────────● left high        ●╲          ╱● right high
//!              │╲__        │                  │  ╲__C__╱   │
//!    another ─►●   ╲__     │                  │  ╱     ╲   │       C: where two facets that cross share a vertex
//!              │╲_____╲__  │                  ●╱          ╲●
//!    right low ●──────────╲● right low        node n   node m
//! ```

use std::cmp::Ordering;

use glam::DVec2;
use thiserror::Error;

use super::column::{Chain, Column, NE, NW, SE, SW};
use crate::progress::{Cancelled, Progress};
use crate::relief::{faceted::FacetedRelief, mesh::Mesh};

/// Heights at one node nearer to each other than this share of the finest pitch become one: no slivers of wall. Slopes
/// change by no more than this, which turns light by 0.0023°, a two-hundredth of the finest blur in reports.
const SNAP: f64 = 2e-5;
/// Least number of single-precision steps between grid lines: rounded by half a step each, they stay in order and their
/// distance changes by an eighth at worst.
const LEAST_LINE_STEPS: f64 = 8.0;
/// Least number of single-precision steps between heights that are kept apart: levels are more than half of that apart,
/// so that rounding by half a step each cannot make two of them one.
const LEAST_HEIGHT_STEPS: f64 = 4.0;
/// Where single precision forces heights together over more than [`SNAP`], the most it may cost in slope. It turns light
/// by 1.1°: what the widest blur in reports would still hide, and a plate far out of its frame is refused.
const WORST_SNAP: f64 = 0.01;

/// The cells around a node, counter-clockwise from the south-west: how far each lies to the west and south.
const AROUND: [(usize, usize); 4] = [(1, 1), (0, 1), (0, 0), (1, 0)];

/// The solid body under `relief`, whose flat base lies `thickness` mm below the lowest point; z is that of the relief.
///
/// Closed by exact vertices: every edge has two triangles, which run along it in opposite directions, the triangles
/// around a vertex are one ring, and none is degenerate. Walls and sides are exactly vertical. Slopes differ from the
/// relief's by about 1e-5. Time and memory grow with the number of cells.
///
/// # Errors
/// When the relief has no cells, a height or slope is not finite, the thickness is not positive, the plate is too
/// large for its details in single precision, or the body outgrows the 32-bit counts of an STL file.
pub fn solid(relief: &FacetedRelief, thickness: f64, progress: &Progress) -> Result<Mesh, SolidError> {
    let mut body = Body::new(relief, thickness)?;
    let (nx, ny) = (relief.columns(), relief.rows());
    let mut south = body.nodes(0)?;
    let mut south_edges = body.edges_along_x(&south);
    let mut west_base = Vec::new();
    let mut east_base = Vec::new();
    let south_base: Vec<u32> = south.iter().map(|node| node.first).collect();
    for j in 0..ny {
        progress.check()?;
        let north = body.nodes(j + 1)?;
        let north_edges = body.edges_along_x(&north);
        let upright: Vec<_> = south.iter().zip(&north).map(|(n, m)| body.edge(n, m, 1, [NW, SW], [NE, SE])).collect();
        for i in 0..nx {
            let corners = [south[i].at(NE), south[i + 1].at(NW), north[i + 1].at(SW), north[i].at(SE)];
            body.facet(corners, [south_edges[i], upright[i + 1], north_edges[i], upright[i]]);
        }
        east_base.push(north[nx].first);
        west_base.push(north[0].first);
        (south, south_edges) = (north, north_edges);
    }
    // The base is a fan around its middle; its rim runs counter-clockwise seen from above.
    let north_base = south[..nx].iter().rev().map(|node| node.first);
    west_base.pop();
    let rim = south_base.into_iter().chain(east_base).chain(north_base).chain(west_base.into_iter().rev());
    body.base(&rim.collect::<Vec<_>>())?;
    Ok(body.mesh)
}

/// The mesh while it grows, and what every node needs to know.
struct Body<'a> {
    relief: &'a FacetedRelief,
    lines: [Vec<f32>; 2],
    range: (f64, f64),
    base: f64,
    snap: f64,
    mesh: Mesh,
}

/// A vertex where the facets on both sides of an edge cross.
#[derive(Clone, Copy)]
struct Crossing {
    id: u32,
    /// Distance from the middle of the edge, in its lengths.
    off_middle: f64,
}

impl<'a> Body<'a> {
    fn new(relief: &'a FacetedRelief, thickness: f64) -> Result<Self, SolidError> {
        let cells = relief.x.len().saturating_sub(1).checked_mul(relief.y.len().saturating_sub(1));
        if cells.is_none_or(|cells| cells == 0 || cells != relief.facets.len()) {
            return Err(SolidError::Shape);
        }
        if !(thickness > 0.0 && thickness.is_finite()) {
            return Err(SolidError::Thickness(thickness));
        }
        let (x, y) = (grid_lines(&relief.x)?, grid_lines(&relief.y)?);
        let (low, high) = height_range(relief)?;
        let base = f64::from((low - thickness) as f32);
        let reach = high.abs().max(base.abs()) as f32;
        let pitch = [&x, &y].into_iter().flat_map(|line| line.windows(2)).map(|w| f64::from(w[1]) - f64::from(w[0]));
        let pitch = pitch.fold(f64::INFINITY, f64::min);
        let finest = LEAST_HEIGHT_STEPS * f64::from(reach.next_up() - reach);
        let snaps_little = finest <= WORST_SNAP * pitch;
        if !snaps_little {
            // Also when a base infinitely deep makes it not a number.
            return Err(SolidError::Heights { reach: f64::from(reach), pitch });
        }
        let snap = finest.max(SNAP * pitch);
        if low - base < 2.0 * snap {
            return Err(SolidError::Thin { thickness, least: 3.0 * snap });
        }
        Ok(Self { relief, lines: [x, y], range: (low, high), base, snap, mesh: Mesh::default() })
    }

    /// Row `j` of nodes, with their vertices made.
    fn nodes(&mut self, j: usize) -> Result<Vec<Column>, SolidError> {
        // At most 4 column and 2 crossing vertices belong to a node, and fewer than 40 triangles.
        let nodes = self.lines[0].len();
        let full = |held: usize, each: usize| held + each * nodes > u32::MAX as usize;
        if full(self.mesh.vertices.len(), 6) || full(self.mesh.triangles.len(), 40) {
            return Err(SolidError::TooMany);
        }
        Ok((0..nodes).map(|i| self.node(i, j)).collect())
    }

    /// One vertex for each distinct height around node (i, j).
    fn node(&mut self, i: usize, j: usize) -> Column {
        let (x, y) = (self.lines[0][i], self.lines[1][j]);
        // The planes are taken where the written vertex is, so that rounding x and y costs no slope; but not below the
        // lowest point, from which the base keeps its distance.
        let at = DVec2::new(f64::from(x), f64::from(y));
        let mut heights = [self.base; 4];
        for (slot, (west, south)) in AROUND.into_iter().enumerate() {
            let (Some(column), Some(row)) = (i.checked_sub(west), j.checked_sub(south)) else { continue };
            if column < self.relief.columns() && row < self.relief.rows() {
                heights[slot] = self.relief.plane_height(column, row, at).clamp(self.range.0, self.range.1);
            }
        }
        let (column, levels) = Column::new(heights, self.snap, self.mesh.vertices.len() as u32);
        // Adding zero turns -0 into 0, which readers may or may not tell apart.
        self.mesh.vertices.extend(levels.into_iter().map(|z| [x + 0.0, y + 0.0, z as f32 + 0.0]));
        column
    }

    fn edges_along_x(&mut self, nodes: &[Column]) -> Vec<Option<Crossing>> {
        nodes.windows(2).map(|pair| self.edge(&pair[0], &pair[1], 0, [NE, NW], [SE, SW])).collect()
    }

    /// The wall over the edge from node `n` to `m`, which runs along `axis`; `left` and `right` name the facets on
    /// either side as seen from `n` and from `m`.
    fn edge(&mut self, n: &Column, m: &Column, axis: usize, left: [usize; 2], right: [usize; 2]) -> Option<Crossing> {
        let order = |k: usize, column: &Column| column.rank[left[k]].cmp(&column.rank[right[k]]);
        let (at_n, at_m) = (order(0, n), order(1, m));
        let chain_n = n.chain([left[0], right[0]]);
        let chain_m = m.chain([left[1], right[1]]);
        if at_n != Ordering::Equal && at_n == at_m.reverse() {
            let crossing = self.crossing([n.at(left[0]), m.at(left[1])], [n.at(right[0]), m.at(right[1])], axis);
            self.wall(&chain_n, &Chain::one(crossing.id), at_n == Ordering::Greater);
            self.wall(&Chain::one(crossing.id), &chain_m, at_m == Ordering::Greater);
            return Some(crossing);
        }
        self.wall(&chain_n, &chain_m, at_n == Ordering::Greater || at_m == Ordering::Greater);
        None
    }

    /// Zips two chains; nothing where both are single. The wall looks to the right if the left facet is higher.
    fn wall(&mut self, n: &Chain, m: &Chain, left_is_higher: bool) {
        let (n, m) = (n.ids(), m.ids());
        let (mut a, mut b) = (0, 0);
        while a + 1 < n.len() || b + 1 < m.len() {
            let z = |id: u32| self.mesh.vertices[id as usize][2];
            let climb_n = b + 1 == m.len() || (a + 1 < n.len() && z(n[a + 1]) <= z(m[b + 1]));
            let next = if climb_n { n[a + 1] } else { m[b + 1] };
            let triangle = if left_is_higher { [n[a], m[b], next] } else { [m[b], n[a], next] };
            self.mesh.triangles.push(triangle);
            a += usize::from(climb_n);
            b += usize::from(!climb_n);
        }
    }

    /// The vertex at which the left and the right facet's borders, given by their ends, cross.
    fn crossing(&mut self, left: [u32; 2], right: [u32; 2], axis: usize) -> Crossing {
        let vertex = |id: u32| self.mesh.vertices[id as usize];
        let z = |id: u32| f64::from(vertex(id)[2]);
        let (from, to) = (vertex(left[0])[axis], vertex(left[1])[axis]);
        let step = left.map(z)[0] - right.map(z)[0];
        let last_step = left.map(z)[1] - right.map(z)[1];
        let (start, length) = (f64::from(from), f64::from(to) - f64::from(from));
        let wanted = (start + length * step / (step - last_step)) as f32;
        let mut position = vertex(left[0]);
        position[axis] = wanted.clamp(from.next_up(), to.next_down()) + 0.0;
        let t = (f64::from(position[axis]) - start) / length;
        let on = |ends: [u32; 2]| z(ends[0]) + t * (z(ends[1]) - z(ends[0]));
        position[2] = (0.5 * (on(left) + on(right))) as f32 + 0.0;
        let id = self.mesh.vertices.len() as u32;
        self.mesh.vertices.push(position);
        Crossing { id, off_middle: (t - 0.5).abs() }
    }

    /// The facet over a cell, from its `corners` and what its edges carry, both counter-clockwise from the south-west.
    fn facet(&mut self, corners: [u32; 4], edges: [Option<Crossing>; 4]) {
        let hub = (0..4)
            .filter_map(|side| edges[side].map(|crossing| (side, crossing)))
            .min_by(|a, b| a.1.off_middle.total_cmp(&b.1.off_middle));
        let Some((side, hub)) = hub else {
            let [a, b, c, d] = corners;
            self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
            return;
        };
        // From a vertex inside a side all other sides are seen at an angle: no triangle of this fan is degenerate.
        let mut previous = corners[(side + 1) % 4];
        for k in 1..4 {
            let crossing = edges[(side + k) % 4].map(|crossing| crossing.id);
            for next in crossing.into_iter().chain([corners[(side + k + 1) % 4]]) {
                self.mesh.triangles.push([hub.id, previous, next]);
                previous = next;
            }
        }
    }

    /// The flat underside, a fan from the middle to its rim.
    fn base(&mut self, rim: &[u32]) -> Result<(), SolidError> {
        if self.mesh.triangles.len() + rim.len() > u32::MAX as usize {
            return Err(SolidError::TooMany);
        }
        let middle = |line: &[f32]| (0.5 * (f64::from(line[0]) + f64::from(line[line.len() - 1]))) as f32 + 0.0;
        let id = self.mesh.vertices.len() as u32;
        self.mesh.vertices.push([middle(&self.lines[0]), middle(&self.lines[1]), self.base as f32 + 0.0]);
        self.mesh.triangles.extend((0..rim.len()).map(|k| [id, rim[(k + 1) % rim.len()], rim[k]]));
        Ok(())
    }
}

/// Grid lines in single precision, if it keeps them well apart.
fn grid_lines(lines: &[f64]) -> Result<Vec<f32>, SolidError> {
    let rounded: Vec<f32> = lines.iter().map(|&v| v as f32).collect();
    for (pair, exact) in rounded.windows(2).zip(lines.windows(2)) {
        let size = pair[0].abs().max(pair[1].abs());
        let apart = f64::from(pair[1]) - f64::from(pair[0]);
        if !(size < f32::MAX && apart >= LEAST_LINE_STEPS * f64::from(size.next_up() - size)) {
            return Err(SolidError::GridLines(exact[0], exact[1]));
        }
    }
    Ok(rounded)
}

/// Lowest and highest point of the relief, if every height fits single precision.
fn height_range(relief: &FacetedRelief) -> Result<(f64, f64), SolidError> {
    let mut range = (f64::INFINITY, f64::NEG_INFINITY);
    for row in 0..relief.rows() {
        for column in 0..relief.columns() {
            for z in relief.corner_heights(column, row) {
                if !(z as f32).is_finite() {
                    return Err(SolidError::NotFinite { column, row });
                }
                range = (range.0.min(z), range.1.max(z));
            }
        }
    }
    Ok(range)
}

/// Why a relief has no solid body.
#[derive(Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SolidError {
    /// No cells, or the number of facets is not that of the cells.
    #[error("the relief must have at least one cell and exactly one facet for each cell")]
    Shape,
    /// A height or slope is infinite, not a number, or beyond single precision.
    #[error("the facet in column {column}, row {row} has a height or slope that is not a finite number")]
    NotFinite {
        /// Column of the cell, from x = 0.
        column: usize,
        /// Row of the cell, from y = 0.
        row: usize,
    },
    /// The base is not below the relief.
    #[error("the base must lie more than 0 mm below the lowest point, not {0} mm")]
    Thickness(f64),
    /// The base is below the relief by less than can be written.
    #[error(
        "a base {thickness} mm below the lowest point cannot be told from it in an STL file; use at least {least} mm"
    )]
    Thin {
        /// Wanted thickness, mm.
        thickness: f64,
        /// Thickness that is sure to do, mm.
        least: f64,
    },
    /// Two grid lines coincide or nearly coincide in single precision.
    #[error(
        "the grid lines at {0} mm and {1} mm are too close, or in the wrong order, for an STL file's single precision"
    )]
    GridLines(f64, f64),
    /// Heights so large that single precision spoils the slopes.
    #[error(
        "heights of {reach} mm on cells of {pitch} mm exceed an STL file's single precision; bring the relief near z = 0"
    )]
    Heights {
        /// Largest height or depth, mm.
        reach: f64,
        /// Smallest distance of two grid lines, mm.
        pitch: f64,
    },
    /// Vertices or triangles do not fit 32-bit counts.
    #[error("the solid would need more triangles than an STL file can count")]
    TooMany,
    /// The caller wanted nothing more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
