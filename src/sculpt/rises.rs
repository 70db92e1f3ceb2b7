//! Between which bounds heights rise from place to place, kept for blocks of places: where heights change, only the blocks
//! there are looked at again.

use rayon::prelude::*;

use crate::relief::periodic::PeriodicRelief;

use super::places::{Places, Rectangle};
use super::resample::sampled_at;

/// Places along a side of a block.
const BLOCK: usize = 32;

/// The lowest and the highest rise to the next place along x and y, mm; 0 is among them.
pub(super) type Extremes = [[f32; 2]; 2];

/// Rises of heights on a square grid of places whose rows and columns continue into themselves.
pub(super) struct Rises {
    /// Places a side.
    places: usize,
    /// Blocks a side.
    blocks: usize,
    /// Rises of so much, mm, are no part of the relief.
    cliff: f32,
    of: Vec<Extremes>,
}

impl Rises {
    /// Of heights `z` at `places` × `places` places; those of `cliff` mm or more are not counted.
    pub fn of(z: &[f32], places: usize, cliff: f32) -> Self {
        let blocks = places.div_ceil(BLOCK);
        let mut rises = Self { places, blocks, cliff, of: Vec::new() };
        rises.of = (0..blocks * blocks).into_par_iter().with_min_len(16).map(|k| rises.block(z, k)).collect();
        rises
    }

    /// Columns and rows of block `k`.
    fn range(&self, k: usize) -> [std::ops::Range<usize>; 2] {
        [k % self.blocks, k / self.blocks].map(|b| b * BLOCK..((b + 1) * BLOCK).min(self.places))
    }

    fn block(&self, z: &[f32], k: usize) -> Extremes {
        let (n, [columns, rows]) = (self.places, self.range(k));
        let mut extremes: Extremes = [[0.0; 2]; 2];
        let mut count = |axis: usize, rise: f32| {
            let rise = if rise.abs() < self.cliff { rise } else { 0.0 };
            extremes[axis] = [extremes[axis][0].min(rise), extremes[axis][1].max(rise)];
        };
        for j in rows {
            let (row, above) = (&z[j * n..][..n], &z[(j + 1) % n * n..][..n]);
            for i in columns.clone() {
                let next = if i + 1 == n { 0 } else { i + 1 };
                count(0, row[next] - row[i]);
                count(1, above[i] - row[i]);
            }
        }
        extremes
    }

    /// The bounds of all rises.
    pub fn extremes(&self) -> Extremes {
        self.of.iter().fold([[0.0; 2]; 2], |all, block| {
            [0, 1].map(|axis| [all[axis][0].min(block[axis][0]), all[axis][1].max(block[axis][1])])
        })
    }

    /// Looks again at what rises in and into `rectangles`, where the heights of `relief` have changed.
    pub fn update(&mut self, relief: &PeriodicRelief, rectangles: &[Rectangle]) {
        let mut changed = vec![false; self.blocks * self.blocks];
        for rectangle in rectangles {
            let [columns, rows] = [0, 1].map(|k| {
                // The place before a changed one rises into it.
                let range = rectangle[k].start - 1..rectangle[k].end;
                let block = |place: isize| place.rem_euclid(self.places as isize) as usize / BLOCK;
                let mut blocks: Vec<usize> = range.map(block).collect();
                blocks.dedup();
                blocks
            });
            for row in rows {
                columns.iter().for_each(|column| changed[row * self.blocks + column] = true);
            }
        }
        let changed: Vec<usize> = (0..changed.len()).filter(|k| changed[*k]).collect();
        let known: Vec<Rectangle> =
            changed.iter().map(|k| self.range(*k).map(|range| range.start as isize..range.end as isize)).collect();
        let places = Places::around(&known, [1, 1], [self.places; 2]);
        let z = sampled_at(relief, self.places, &places);
        let again: Vec<Extremes> = changed.par_iter().map(|k| self.block(&z, *k)).collect();
        changed.into_iter().zip(again).for_each(|(k, extremes)| self.of[k] = extremes);
    }
}
