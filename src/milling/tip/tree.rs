//! Pieces that carry a cutter, sorted so that most are never looked at.
//!
//! Blocks of pieces, and blocks of blocks, each lie below a plane and within a box, over both of which the tip stands no
//! lower than over the pieces themselves.

use glam::{DVec2, DVec3};

use super::blocks::{Block, Level, SIDE};
use crate::cutter::Profile;

/// Pieces in a block. Of 2, 4, 8, 16 and 32 triangles, 2 and 4 were fastest over the default sheet, 16 took 2.3 times as long.
const IN_BLOCK: f64 = 4.0;

/// A cutter from below.
#[derive(Clone, Copy)]
pub(in crate::milling) struct Underside {
    pub(in crate::milling) profile: Profile,
    /// Half of its least curvature, 1/mm.
    pub(in crate::milling) bend: f64,
    /// Square of the reach, mm².
    pub(in crate::milling) reach2: f64,
}

/// What a cutter can rest on.
pub(in crate::milling) trait Piece {
    /// About its middle, mm.
    fn centre(&self) -> DVec2;
    /// Its corners, mm.
    fn points(&self) -> impl Iterator<Item = DVec3> + Clone;
    /// About the slope of several that lie together.
    fn slope_of(pieces: &[Self]) -> DVec2
    where
        Self: Sized;
    /// Height of the tip at `at` when the cutter rests on it, if that is above `best`; else anything that is not.
    fn carries(&self, cutter: &Underside, at: DVec2, best: f64) -> f64;
}

/// The tip's height, and the piece that carries it.
#[derive(Clone, Copy)]
pub(in crate::milling) struct Rest {
    pub(in crate::milling) height: f64,
    pub(in crate::milling) piece: u32,
}

/// Pieces, sorted.
pub(in crate::milling) struct Tree<P> {
    pub(in crate::milling) cutter: Underside,
    low: DVec2,
    /// Blocks per mm.
    per_mm: f64,
    /// From the blocks of pieces up to one that holds all.
    levels: Vec<Level>,
    /// Where each block's pieces begin.
    starts: Vec<u32>,
    pub(in crate::milling) pieces: Vec<P>,
}

impl Underside {
    fn new(profile: Profile) -> Self {
        let reach2 = profile.reach * profile.reach * (1.0 + 1e-12);
        Self { profile, bend: 0.5 * profile.least_curvature(), reach2 }
    }

    /// Height of the tip when the cutter rests on the edge from `a` to `b`, mm, and where it touches it, from `at`.
    pub(in crate::milling) fn on_edge(&self, a: DVec3, b: DVec3, at: DVec2) -> (f64, DVec2) {
        const NOWHERE: (f64, DVec2) = (f64::NEG_INFINITY, DVec2::ZERO);
        let way = (b - a).truncate();
        let length = way.length();
        let along = way / length;
        let from = a.truncate() - at;
        // Places along the edge are counted from the point nearest to the axis.
        let (near, start) = (along.perp_dot(from), along.dot(from));
        let rest = self.reach2 - near * near;
        if rest < 0.0 {
            return NOWHERE;
        }
        let chord = rest.sqrt();
        let (low, high) = (start.max(-chord), (start + length).min(chord));
        if low > high {
            return NOWHERE;
        }
        let rise = (b.z - a.z) / length;
        let t = self.profile.rest(near.abs(), rise, [low, high]);
        let height =
            a.z + rise * (t - start) - self.profile.underside((t * t + near * near).sqrt().min(self.profile.reach));
        (height, from + along * (t - start))
    }
}

impl<P: Piece> Tree<P> {
    pub(in crate::milling) fn new(pieces: Vec<P>, profile: Profile) -> Self {
        let (low, high) = pieces.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), piece| {
            (low.min(piece.centre()), high.max(piece.centre()))
        });
        let size = (high - low).max(DVec2::ZERO);
        let count = pieces.len().max(1) as f64;
        let wanted = (IN_BLOCK * size.x * size.y / count).sqrt();
        // No more blocks than pieces, even if these stand in a row.
        let side = wanted.max(size.max_element() / count).max(1e-9);
        let per_mm = side.recip();
        let [columns, rows] = [size.x, size.y].map(|s| if s > 0.0 { (s * per_mm) as usize + 1 } else { 1 });
        let (levels, starts) = (Vec::new(), Vec::new());
        let mut this = Self { cutter: Underside::new(profile), low, per_mm, levels, starts, pieces: Vec::new() };
        if !pieces.is_empty() {
            this.sort(pieces, columns, rows);
        }
        this
    }

    fn sort(&mut self, pieces: Vec<P>, columns: usize, rows: usize) {
        let block_of = |piece: &P| {
            let place = (piece.centre() - self.low) * self.per_mm;
            ((place.y as usize).min(rows - 1) * columns + (place.x as usize).min(columns - 1)) as u32
        };
        let mut keyed: Vec<(u32, P)> = pieces.into_iter().map(|piece| (block_of(&piece), piece)).collect();
        keyed.sort_by_key(|(block, _)| *block);
        self.starts =
            (0..=(columns * rows) as u32).map(|block| keyed.partition_point(|(b, _)| *b < block) as u32).collect();
        self.pieces = keyed.into_iter().map(|(_, piece)| piece).collect();
        let profile = &self.cutter.profile;
        let blocks = (0..columns * rows).map(|b| {
            let own = &self.pieces[self.starts[b] as usize..self.starts[b + 1] as usize];
            Block::around(own.iter().flat_map(P::points), P::slope_of(own), profile)
        });
        self.levels.push(Level { columns, rows, blocks: blocks.collect() });
        while let Some(level) = self.levels.last().filter(|level| level.blocks.len() > 1) {
            let next = level.merged(profile);
            self.levels.push(next);
        }
    }

    /// The tip's height at `at`, mm; none where it meets nothing.
    pub(in crate::milling) fn rest(&self, at: DVec2) -> Option<Rest> {
        let Level { columns, rows, blocks } = self.levels.first()?;
        let mut best = Rest { height: f64::NEG_INFINITY, piece: u32::MAX };
        // A first guess, so that bounds have something to be below: the block that is touched if it is as steep as the
        // one under the tip.
        let under = |place: DVec2| {
            let place = ((place - self.low) * self.per_mm).max(DVec2::ZERO);
            (place.y as usize).min(rows - 1) * columns + (place.x as usize).min(columns - 1)
        };
        let first = under(at + blocks[under(at)].touch());
        self.rest_on_block(first, at, &mut best);
        self.descend(self.levels.len() - 1, [0, 0], at, first, &mut best);
        (best.piece != u32::MAX).then_some(best)
    }

    fn descend(&self, level: usize, [i, j]: [usize; 2], at: DVec2, done: usize, best: &mut Rest) {
        let Level { columns, rows, blocks } = &self.levels[level];
        let Underside { profile, bend, reach2 } = &self.cutter;
        for row in j..(j + SIDE).min(*rows) {
            for column in i..(i + SIDE).min(*columns) {
                let k = row * columns + column;
                if blocks[k].cannot_carry(at, best.height, profile, [*bend, *reach2]) {
                    continue;
                }
                if level > 0 {
                    self.descend(level - 1, [SIDE * column, SIDE * row], at, done, best);
                } else if k != done {
                    self.rest_on_block(k, at, best);
                }
            }
        }
    }

    fn rest_on_block(&self, block: usize, at: DVec2, best: &mut Rest) {
        for k in self.starts[block]..self.starts[block + 1] {
            let height = self.pieces[k as usize].carries(&self.cutter, at, best.height);
            if height > best.height {
                *best = Rest { height, piece: k };
            }
        }
    }
}
