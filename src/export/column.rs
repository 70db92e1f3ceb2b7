//! The vertices that stand over one grid node.

/// The corners of a cell, and the cells around a node, counter-clockwise from the south-west.
pub(super) const SW: usize = 0;
pub(super) const SE: usize = 1;
pub(super) const NE: usize = 2;
pub(super) const NW: usize = 3;

/// A column of vertices over a node, bottom to top, with ids `first..`.
pub(super) struct Column {
    pub first: u32,
    /// The place in the column of each facet around the node.
    pub rank: [u32; 4],
    /// See [`Column::chain`].
    skip: Option<u32>,
}

/// Ids of vertices one above the other, low to high; at least one.
pub(super) struct Chain {
    ids: [u32; 4],
    len: usize,
}

impl Column {
    /// The column for four facets of `heights`, and its levels. Heights within `snap` become one level; levels are
    /// more than half of `snap` apart.
    pub fn new(heights: [f64; 4], snap: f64, first: u32) -> (Self, Vec<f64>) {
        let mut order = [SW, SE, NE, NW];
        order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
        let mut levels = Vec::with_capacity(4);
        let mut rank = [0; 4];
        let mut lowest = f64::NEG_INFINITY;
        for slot in order {
            let z = heights[slot];
            if z - lowest > snap {
                lowest = z;
                levels.push(z);
            }
            let top = levels.len() - 1;
            // Midway between the lowest and, so far, the highest of those that become one.
            levels[top] = 0.5 * (lowest + z);
            rank[slot] = top as u32;
        }
        let mut skip = None;
        for (one, other, aside) in [(SW, NE, [SE, NW]), (SE, NW, [SW, NE])] {
            if rank[one].min(rank[other]) > rank[aside[0]].max(rank[aside[1]]) {
                if rank[one] == rank[other] {
                    rank[other] += 1;
                    levels.push(levels[levels.len() - 1] + snap);
                }
                skip = Some(rank[one].min(rank[other]));
            }
        }
        (Self { first, rank, skip }, levels)
    }

    /// The vertex of the facet in `slot`.
    pub fn at(&self, slot: usize) -> u32 {
        self.first + self.rank[slot]
    }

    /// The vertices between the heights of the facets in two slots.
    ///
    /// Where two facets that touch only at this node both rise above the other two, their four walls would share one
    /// edge. The walls of the higher one pass by the vertex `skip` of the lower one instead: then the edge below
    /// `skip` belongs to the lower one's walls and the long one to the higher one's.
    pub fn chain(&self, slots: [usize; 2]) -> Chain {
        let (a, b) = (self.rank[slots[0]], self.rank[slots[1]]);
        let (low, high) = (a.min(b), a.max(b));
        let mut chain = Chain { ids: [0; 4], len: 0 };
        for rank in (low..=high).filter(|&rank| rank == high || Some(rank) != self.skip) {
            chain.ids[chain.len] = self.first + rank;
            chain.len += 1;
        }
        chain
    }
}

impl Chain {
    /// A chain of a single vertex.
    pub fn one(id: u32) -> Self {
        Self { ids: [id; 4], len: 1 }
    }

    pub(crate) fn ids(&self) -> &[u32] {
        &self.ids[..self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How often the walls around the node use each of their vertical edges.
    fn uses(heights: [f64; 4]) -> Vec<(u32, u32, usize)> {
        let (column, _) = Column::new(heights, 1e-3, 10);
        let mut edges: Vec<(u32, u32)> = Vec::new();
        for slot in 0..4 {
            let chain = column.chain([slot, (slot + 1) % 4]);
            edges.extend(chain.ids().windows(2).map(|pair| (pair[0], pair[1])));
        }
        edges.sort_unstable();
        edges.chunk_by(|a, b| a == b).map(|same| (same[0].0, same[0].1, same.len())).collect()
    }

    #[test]
    fn heights_within_the_snap_are_one_and_levels_stay_apart() {
        let (column, levels) = Column::new([1.0, 1.0006, 1.0012, -2.0], 1e-3, 5);
        assert_eq!(column.rank, [1, 1, 2, 0]);
        assert_eq!(levels, [-2.0, 1.0003, 1.0012]);
        assert_eq!(column.at(NE), 7);
        assert_eq!(column.chain([NE, NW]).ids(), [5, 6, 7]);
        assert_eq!(column.chain([SE, SW]).ids(), [6]);
    }

    #[test]
    fn no_vertical_edge_has_more_than_two_walls() {
        // All orders of up to four heights, ties and alternating corners among them.
        for k in 0..256 {
            let heights = [0, 2, 4, 6].map(|shift| f64::from((k >> shift) & 3));
            assert!(uses(heights).iter().all(|edge| edge.2 == 2), "{heights:?}");
        }
    }

    #[test]
    fn at_an_alternating_corner_the_higher_walls_pass_by_the_lower_top() {
        assert_eq!(uses([2.0, 0.0, 3.0, 1.0]), [(10, 11, 2), (11, 12, 2), (11, 13, 2)]);
        let (column, levels) = Column::new([0.0, 3.0, 0.0, 3.0], 1e-3, 0);
        assert_eq!(levels, [0.0, 3.0, 3.001]);
        assert_eq!(column.chain([SE, SW]).ids(), [0, 1]);
        assert_eq!(column.chain([NW, NE]).ids(), [0, 2]);
    }
}
