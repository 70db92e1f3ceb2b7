//! Steepnesses from which a ray that leaves the surface meets nothing more, block by block of a grid.
//!
//! Over the block of a start and its eight neighbours a surface without steps climbs no steeper than its steepest triangle:
//! a ray that climbs more stays above it. Farther off a ray has gone some way at least, and is above what is there if it
//! climbs more than from the lowest point of its block to the highest there over that way. What is far is looked at in
//! ever larger blocks, of each size those that no larger one has dealt with (the lists of the fast multipole method,
//! Greengard and Rokhlin 1987), so that the work grows as the number of blocks.

/// What is known of one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Lowest height of the surface, mm; infinite if nothing stands here.
    pub low: f32,
    /// Highest height of anything, mm; minus infinity if nothing stands here.
    pub high: f32,
    /// Steepest triangle, dz over horizontal way; infinite where the surface has steps or an end.
    pub steepest: f32,
}

impl Block {
    pub(super) const EMPTY: Self = Self { low: f32::INFINITY, high: f32::NEG_INFINITY, steepest: 0.0 };

    pub(super) fn join(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.steepest = self.steepest.max(other.steepest);
    }
}

/// The same with numbers rounded: what a ray must climb to be above a plane for certain.
const SAFETY: f32 = 1.001;

/// For each block the least dz over horizontal way with which rays from the surface there meet nothing more; infinite if
/// that is not known. Blocks stand in rows of `columns` and are `size` mm along x and y.
pub(super) fn horizon(blocks: Vec<Block>, columns: usize, size: [f64; 2]) -> Vec<f32> {
    let rows = blocks.len() / columns;
    let nearest = |k: usize| {
        let (i, j) = (k % columns, k / columns);
        let mut steepest = 0.0f32;
        for b in j.saturating_sub(1)..(j + 2).min(rows) {
            for a in i.saturating_sub(1)..(i + 2).min(columns) {
                steepest = steepest.max(blocks[b * columns + a].steepest);
            }
        }
        steepest
    };
    let near: Vec<f32> = (0..blocks.len()).map(nearest).collect();
    let far = beyond(&blocks, columns, size);
    near.iter().zip(&far).map(|(near, far)| SAFETY * near.max(*far)).collect()
}

/// What is to be climbed because of all blocks but the nearest nine.
fn beyond(blocks: &[Block], columns: usize, size: [f64; 2]) -> Vec<f32> {
    let rows = blocks.len() / columns;
    if columns <= 2 && rows <= 2 {
        return vec![0.0; blocks.len()];
    }
    let (wide, deep) = (columns.div_ceil(2), rows.div_ceil(2));
    let mut parents = vec![Block::EMPTY; wide * deep];
    for (k, block) in blocks.iter().enumerate() {
        parents[k / columns / 2 * wide + k % columns / 2].join(block);
    }
    let above = beyond(&parents, wide, size.map(|side| 2.0 * side));
    let ways = inverse_gaps(size);
    let mut climbs = Vec::with_capacity(blocks.len());
    for (k, block) in blocks.iter().enumerate() {
        let (i, j) = (k % columns, k / columns);
        let mut climb = above[j / 2 * wide + i / 2];
        // Children of the parent's neighbours that are no neighbours.
        let (west, south) = ((i / 2 * 2).saturating_sub(2), (j / 2 * 2).saturating_sub(2));
        let (east, north) = ((i / 2 * 2 + 4).min(columns), (j / 2 * 2 + 4).min(rows));
        for b in south..north {
            let ways = &ways[b.abs_diff(j)];
            for a in west..east {
                climb = climb.max((blocks[b * columns + a].high - block.low) * ways[a.abs_diff(i)]);
            }
        }
        climbs.push(climb);
    }
    climbs
}

/// One over the least horizontal way between blocks so many rows and columns apart, 1/mm; 0 between neighbours.
fn inverse_gaps(size: [f64; 2]) -> [[f32; 4]; 4] {
    let gap = |apart: usize, side: f64| apart.saturating_sub(1) as f64 * side;
    let inverse = |rows: usize, columns: usize| {
        let way = gap(columns, size[0]).hypot(gap(rows, size[1]));
        if way > 0.0 { (1.0 / way) as f32 } else { 0.0 }
    };
    [0, 1, 2, 3].map(|rows| [0, 1, 2, 3].map(|columns| inverse(rows, columns)))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn every_block_stands_below_the_horizon() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        for (columns, rows) in [(1, 1), (2, 9), (13, 7), (16, 33)] {
            let size = [0.5, 0.25];
            let blocks: Vec<Block> = (0..columns * rows)
                .map(|_| {
                    let low = random.random::<f32>();
                    Block { low, high: low + 4.0 * random.random::<f32>().powi(4), steepest: random.random() }
                })
                .collect();
            let found = horizon(blocks.clone(), columns, size);
            for k in 0..blocks.len() {
                let mut exact = 0.0f64;
                for (other, block) in blocks.iter().enumerate() {
                    let apart = [(k % columns).abs_diff(other % columns), (k / columns).abs_diff(other / columns)];
                    let gap = |axis: usize| apart[axis].saturating_sub(1) as f64 * size[axis];
                    let way = gap(0).hypot(gap(1));
                    let climb = if apart.iter().all(|&apart| apart <= 1) {
                        f64::from(block.steepest)
                    } else {
                        f64::from(block.high - blocks[k].low) / way
                    };
                    exact = exact.max(climb);
                }
                assert!(f64::from(found[k]) >= exact && found[k].is_finite(), "{k}: {exact}");
            }
        }
    }

    #[test]
    fn empty_blocks_hide_nothing_and_steps_no_number_tells() {
        let mut blocks = vec![Block::EMPTY; 50];
        blocks[0] = Block { low: 0.0, high: 1.0, steepest: 0.5 };
        let found = horizon(blocks.clone(), 10, [1.0; 2]);
        assert_eq!(found[0], SAFETY * 0.5);
        blocks[11].steepest = f32::INFINITY;
        assert_eq!(horizon(blocks, 10, [1.0; 2])[0], f32::INFINITY);
    }
}
