//! Bounds of where a cutter's tip can stand over many triangles at once.

use glam::{DVec2, DVec3};

use crate::cutter::Profile;

/// Blocks along the side of a block of blocks: with 2 of them 44 bounds are asked a place, with 4 of them 80.
pub(super) const SIDE: usize = 2;

/// z = height + slope · (x, y).
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// At the origin, mm.
    pub(super) height: f64,
    pub(super) slope: DVec2,
}

impl Plane {
    pub(super) fn through(point: DVec3, slope: DVec2) -> Self {
        Self { height: point.z - slope.dot(point.truncate()), slope }
    }

    pub(super) fn raised(self, by: f64) -> Self {
        Self { height: self.height + by, ..self }
    }

    #[inline]
    pub(super) fn at(&self, place: DVec2) -> f64 {
        self.height + self.slope.dot(place)
    }
}

/// One level of blocks, in rows of constant y.
pub(super) struct Level {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) blocks: Vec<Block>,
}

/// Where the triangles of a block are.
#[derive(Clone, Copy)]
pub(super) struct Block {
    low: DVec2,
    high: DVec2,
    /// Highest point, mm.
    top: f64,
    /// All of it lies below this plane, which is raised by the height at which the cutter's tip stands on it.
    tips: Plane,
    /// By how much it is raised, mm.
    lift: f64,
    /// From the tip to where it touches that plane, mm.
    touch: DVec2,
}

impl Block {
    /// Around points (x, y, z) of which `slope` is about the mean slope.
    pub(super) fn around(points: impl Iterator<Item = DVec3>, slope: DVec2, profile: &Profile) -> Self {
        let lift = profile.lift(slope.length());
        let mut block = Self {
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
            top: f64::NEG_INFINITY,
            tips: Plane { height: f64::NEG_INFINITY, slope },
            lift,
            touch: profile.touch(slope),
        };
        for p in points {
            block.low = block.low.min(p.truncate());
            block.high = block.high.max(p.truncate());
            block.top = block.top.max(p.z);
            block.tips.height = block.tips.height.max(Plane::through(p, slope).height + lift);
        }
        block
    }

    /// From the tip to where it touches the block's plane, mm.
    pub(super) fn touch(&self) -> DVec2 {
        self.touch
    }

    /// Whether a tip at `at` that rests on the block stands no higher than `best`, as far as bounds tell; `bend` is half of
    /// the underside's least curvature, `reach2` the square of its reach.
    #[inline]
    pub(super) fn cannot_carry(&self, at: DVec2, best: f64, profile: &Profile, [bend, reach2]: [f64; 2]) -> bool {
        let over = self.tips.at(at) - best;
        if over <= 0.0 {
            return true;
        }
        let beside = self.beside(at + self.touch);
        if beside * bend > over {
            return true;
        }
        let d = self.beside(at);
        d > reach2 || self.top - profile.underside(d.sqrt().min(profile.reach)) <= best
    }

    /// Square of the distance of a place from the block's box, mm².
    fn beside(&self, place: DVec2) -> f64 {
        (self.low - place).max(place - self.high).max(DVec2::ZERO).length_squared()
    }

    /// Points that the block lies below: its plane over the corners of its box, which is as much as is known of it.
    fn roof(&self) -> [DVec3; 4] {
        let corner = |x: f64, y: f64| DVec2::new(x, y).extend(self.tips.at(DVec2::new(x, y)) - self.lift);
        [
            corner(self.low.x, self.low.y),
            corner(self.high.x, self.low.y),
            corner(self.low.x, self.high.y),
            corner(self.high.x, self.high.y),
        ]
    }

    fn is_empty(&self) -> bool {
        self.top == f64::NEG_INFINITY
    }
}

impl Level {
    /// Blocks of this level's blocks.
    pub(super) fn merged(&self, profile: &Profile) -> Self {
        let [columns, rows] = [self.columns, self.rows].map(|n| n.div_ceil(SIDE));
        let merged = |k: usize| {
            let (i, j) = (k % columns * SIDE, k / columns * SIDE);
            let own = || {
                (j..(j + SIDE).min(self.rows))
                    .flat_map(move |j| {
                        (i..(i + SIDE).min(self.columns)).map(move |i| &self.blocks[j * self.columns + i])
                    })
                    .filter(|block| !block.is_empty())
            };
            let slope = own().map(|block| block.tips.slope).sum::<DVec2>() / own().count().max(1) as f64;
            let mut block = Block::around(own().flat_map(Block::roof), slope, profile);
            block.top = own().map(|block| block.top).fold(f64::NEG_INFINITY, f64::max);
            block
        };
        Self { columns, rows, blocks: (0..columns * rows).map(merged).collect() }
    }
}
