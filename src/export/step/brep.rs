//! The solid under a plate of facets as faces with shared edges.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::{SNAP, StepError};
use crate::export::column::{Chain, Column, NE, NW, SE, SW};
use crate::progress::Progress;
use crate::relief::faceted::FacetedRelief;

/// The cells around a node, counter-clockwise from the south-west: how far each lies to the west and south.
const AROUND: [(usize, usize); 4] = [(1, 1), (0, 1), (0, 0), (1, 0)];

/// A closed shell of planar faces.
#[derive(Debug, Default)]
pub(super) struct Brep {
    pub vertices: Vec<DVec3>,
    /// Vertices of each edge: every one belongs to two faces.
    pub edges: Vec<[u32; 2]>,
    pub faces: Vec<Face>,
    /// Which edge runs between two vertices, the lower first.
    named: HashMap<[u32; 2], u32>,
}

/// A planar polygon.
#[derive(Debug)]
pub(super) struct Face {
    /// Unit normal, out of the solid.
    pub normal: DVec3,
    /// A unit vector in its plane.
    pub along: DVec3,
    /// A point of its plane.
    pub point: DVec3,
    /// Its edges, counter-clockwise seen from outside, and whether each runs from its first vertex to its second.
    pub border: Vec<(u32, bool)>,
}

/// An edge of the grid from node to node, and the facets to its left and right, as the slots that they have at either end.
struct Sides<'a> {
    ends: [&'a Column; 2],
    left: [usize; 2],
    right: [usize; 2],
    /// The axis it runs along.
    axis: usize,
}

impl Brep {
    /// The solid whose flat base lies `thickness` mm below the lowest point of `relief`.
    pub fn under(relief: &FacetedRelief, thickness: f64, progress: &Progress) -> Result<Self, StepError> {
        let (low, high) = relief.height_range();
        let base = low - thickness;
        if relief.facets.is_empty() || !(base.is_finite() && high.is_finite() && base < low) {
            return Err(StepError::NoRelief);
        }
        let (nx, ny) = (relief.columns(), relief.rows());
        let mut solid = Self::default();
        let mut rim = [const { Vec::new() }; 4];
        let mut south = solid.nodes(relief, 0, base);
        let mut south_edges = solid.along_x(&south);
        rim[0].extend(south.iter().map(|node| node.first));
        for j in 0..ny {
            progress.check()?;
            let north = solid.nodes(relief, j + 1, base);
            let north_edges = solid.along_x(&north);
            let upright: Vec<_> = south
                .iter()
                .zip(&north)
                .map(|(n, m)| solid.wall_over(&Sides { ends: [n, m], left: [NW, SW], right: [NE, SE], axis: 1 }))
                .collect();
            for i in 0..nx {
                let corners = [south[i].at(NE), south[i + 1].at(NW), north[i + 1].at(SW), north[i].at(SE)];
                let crossings = [south_edges[i], upright[i + 1], north_edges[i], upright[i]];
                solid.facet(relief, [i, j], corners, crossings);
            }
            rim[1].push(north[nx].first);
            rim[3].push(north[0].first);
            (south, south_edges) = (north, north_edges);
        }
        // The rim of the base runs counter-clockwise seen from above; the base is seen from below.
        let [first, east, mut north, mut west] = rim;
        west.pop();
        north.extend(south[..nx].iter().rev().map(|node| node.first));
        let all: Vec<u32> = first.into_iter().chain(east).chain(north).chain(west.into_iter().rev()).rev().collect();
        let point = solid.vertices[all[0] as usize];
        solid.face(&all, point, -DVec3::Z, DVec3::X);
        Ok(solid)
    }

    /// Row `j` of nodes, with their vertices made.
    fn nodes(&mut self, relief: &FacetedRelief, j: usize, base: f64) -> Vec<Column> {
        let column = |solid: &mut Self, i: usize| {
            let at = DVec2::new(relief.x[i], relief.y[j]);
            let mut heights = [base; 4];
            for (slot, (west, south)) in AROUND.into_iter().enumerate() {
                let (Some(column), Some(row)) = (i.checked_sub(west), j.checked_sub(south)) else { continue };
                if column < relief.columns() && row < relief.rows() {
                    heights[slot] = relief.plane_height(column, row, at);
                }
            }
            let (column, levels) = Column::new(heights, SNAP, solid.vertices.len() as u32);
            solid.vertices.extend(levels.into_iter().map(|z| at.extend(z)));
            column
        };
        (0..relief.x.len()).map(|i| column(self, i)).collect()
    }

    fn along_x(&mut self, nodes: &[Column]) -> Vec<Option<u32>> {
        let over = |pair: &[Column]| {
            self.wall_over(&Sides { ends: [&pair[0], &pair[1]], left: [NE, NW], right: [SE, SW], axis: 0 })
        };
        nodes.windows(2).map(over).collect()
    }

    /// The wall over an edge of the grid, and the vertex at which the facets on its sides cross, if they do.
    fn wall_over(&mut self, sides: &Sides) -> Option<u32> {
        let Sides { ends: [n, m], left, right, .. } = *sides;
        let higher = |column: &Column, k: usize| column.rank[left[k]].cmp(&column.rank[right[k]]);
        let (at_n, at_m) = (higher(n, 0), higher(m, 1));
        let [chain_n, chain_m] = [n.chain([left[0], right[0]]), m.chain([left[1], right[1]])];
        if at_n.is_ne() && at_n == at_m.reverse() {
            let crossing = self.crossing([n.at(left[0]), m.at(left[1])], [n.at(right[0]), m.at(right[1])]);
            self.wall(&chain_n, &Chain::one(crossing), at_n.is_gt(), sides.axis);
            self.wall(&Chain::one(crossing), &chain_m, at_m.is_gt(), sides.axis);
            return Some(crossing);
        }
        self.wall(&chain_n, &chain_m, at_n.is_gt() || at_m.is_gt(), sides.axis);
        None
    }

    /// The vertex at which two borders cross, each given by its ends over the same nodes.
    fn crossing(&mut self, left: [u32; 2], right: [u32; 2]) -> u32 {
        let vertex = |id: u32| self.vertices[id as usize];
        let steps = [0, 1].map(|k| vertex(left[k]).z - vertex(right[k]).z);
        let at = vertex(left[0]).lerp(vertex(left[1]), steps[0] / (steps[0] - steps[1]));
        self.vertices.push(at);
        self.vertices.len() as u32 - 1
    }

    /// The face between two chains of vertices; none where both are single. It looks to the right of the way from the first
    /// to the second if what is on the left is higher.
    fn wall(&mut self, n: &Chain, m: &Chain, left_is_higher: bool, axis: usize) {
        let (n, m) = (n.ids(), m.ids());
        if n.len() + m.len() < 3 {
            return;
        }
        let mut border: Vec<u32> = n[..1].iter().chain(m).chain(n[1..].iter().rev()).copied().collect();
        if !left_is_higher {
            border.reverse();
        }
        let (along, right) = if axis == 0 { (DVec3::X, -DVec3::Y) } else { (DVec3::Y, DVec3::X) };
        let point = self.vertices[n[0] as usize];
        self.face(&border, point, if left_is_higher { right } else { -right }, along);
    }

    /// The facet of a cell, from its corners and what its edges carry, both counter-clockwise from the south-west.
    fn facet(&mut self, relief: &FacetedRelief, [i, j]: [usize; 2], corners: [u32; 4], crossings: [Option<u32>; 4]) {
        let facet = relief.facet(i, j);
        let border: Vec<u32> = (0..4).flat_map(|k| [Some(corners[k]), crossings[k]]).flatten().collect();
        let point = relief.middle(i, j).extend(facet.height);
        let along = DVec3::new(1.0, 0.0, facet.slope.p).normalize();
        self.face(&border, point, facet.slope.normal(), along);
    }

    fn face(&mut self, border: &[u32], point: DVec3, normal: DVec3, along: DVec3) {
        let border = (0..border.len()).map(|k| self.edge(border[k], border[(k + 1) % border.len()])).collect();
        self.faces.push(Face { normal, along, point, border });
    }

    /// The edge from one vertex to another, and whether that is the way it runs.
    fn edge(&mut self, from: u32, to: u32) -> (u32, bool) {
        let edges = &mut self.edges;
        let name = *self.named.entry([from.min(to), from.max(to)]).or_insert_with(|| {
            edges.push([from, to]);
            edges.len() as u32 - 1
        });
        (name, self.edges[name as usize] == [from, to])
    }
}
