//! The surface that a program leaves: at each place the lowest underside of a cutter whose tip goes along straight moves.
//!
//! With all heights turned over that is the question of [`tip`](super::tip): how low a cutter can stand over edges. So the
//! answer is exact for any moves in any direction, with nothing rounded to a grid.

use glam::{DMat2, DVec2, DVec3};

use super::polish::Nodes;
use super::tip::tree::{Piece, Tree, Underside};
use crate::cutter::Profile;
use crate::progress::{Cancelled, Progress};
use crate::relief::open::OpenRelief;

/// Longest piece of a move, as a multiple of the mean distance of its neighbours: blocks of pieces are then about square.
const LONGEST: f64 = 8.0;

/// And bounds of that, mm.
const SHORTEST_PIECE: f64 = 0.01;

/// Most pieces, beside those that moves are by themselves.
const MOST_PIECES: f64 = 4e6;

/// Samples before polish from one node to the next, along x and along y. Of passes just two samples apart their mean is a
/// sixth of a cusp too high, the same everywhere; others are met at many places of their cusps.
const FINER: usize = 2;

/// A cutter's way, with the line of the program that it is from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Where the tip begins, mm.
    pub from: DVec3,
    /// Where it ends, mm.
    pub to: DVec3,
    /// Line, from 1.
    pub line: u32,
}

/// The surface that strokes leave.
pub struct Swept(Tree<Edge>);

/// A place of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Its height, mm.
    pub height: f64,
    /// Its gradient.
    pub slope: DVec2,
    /// Line of the stroke that left it.
    pub line: u32,
}

/// Part of a stroke, turned over.
struct Edge {
    ends: [DVec3; 2],
    line: u32,
}

impl Edge {
    /// Height of the turned tip at `at`, mm, and from there to where it touches.
    fn touched(&self, cutter: &Underside, at: DVec2) -> (f64, DVec2) {
        let [a, b] = self.ends;
        if (b - a).truncate().length_squared() > 1e-18 {
            return cutter.on_edge(a, b, at);
        }
        // Straight down: its deepest point.
        let touch = a.truncate() - at;
        (a.z.max(b.z) - cutter.profile.underside(touch.length()), touch)
    }
}

impl Piece for Edge {
    fn centre(&self) -> DVec2 {
        0.5 * (self.ends[0] + self.ends[1]).truncate()
    }

    fn points(&self) -> impl Iterator<Item = DVec3> + Clone {
        self.ends.into_iter()
    }

    /// Of the plane that fits their ends best; along a single line nothing across it.
    fn slope_of(pieces: &[Self]) -> DVec2 {
        let points = || pieces.iter().flat_map(|piece| piece.ends);
        let middle = points().sum::<DVec3>() / (2 * pieces.len()).max(1) as f64;
        let (mut square, mut product) = (DMat2::ZERO, DVec2::ZERO);
        for point in points() {
            let from = point - middle;
            let aside = from.truncate();
            square += DMat2::from_cols(aside * aside.x, aside * aside.y);
            product += aside * from.z;
        }
        let ridge = 1e-9 * (square.x_axis.x + square.y_axis.y) + f64::MIN_POSITIVE;
        let slope = (square + DMat2::from_diagonal(DVec2::splat(ridge))).inverse() * product;
        if slope.is_finite() { slope } else { DVec2::ZERO }
    }

    fn carries(&self, cutter: &Underside, at: DVec2, best: f64) -> f64 {
        let highest = self.ends[0].z.max(self.ends[1].z);
        if highest > best { self.touched(cutter, at).0 } else { best }
    }
}

impl Swept {
    /// Strokes of a cutter of `profile`.
    pub fn new(strokes: &[Stroke], profile: Profile) -> Self {
        let length: f64 = strokes.iter().map(|stroke| (stroke.to - stroke.from).truncate().length()).sum();
        let ends = || strokes.iter().flat_map(|stroke| [stroke.from.truncate(), stroke.to.truncate()]);
        let (low, high) = ends().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), end| (l.min(end), h.max(end)));
        let size = (high - low).max(DVec2::ZERO);
        let apart = size.x * size.y / length.max(f64::MIN_POSITIVE);
        let longest = (LONGEST * apart).max(SHORTEST_PIECE).max(length / MOST_PIECES);
        let mut edges = Vec::with_capacity(strokes.len());
        for Stroke { from, to, line } in strokes {
            let [from, to] = [from, to].map(|end| DVec3::new(end.x, end.y, -end.z));
            let pieces = ((to - from).truncate().length() / longest).ceil().max(1.0);
            let at = |k: f64| if k == pieces { to } else { from.lerp(to, k / pieces) };
            edges.extend((0..pieces as usize).map(|k| Edge { ends: [at(k as f64), at((k + 1) as f64)], line: *line }));
        }
        Self(Tree::new(edges, profile))
    }

    /// Memory that `strokes` of some length over an area take, bytes, about.
    pub fn bytes(strokes: usize) -> f64 {
        // An edge, its place in the order, and its share of blocks; as many again that long ones are cut into.
        250.0 * (strokes as f64 + MOST_PIECES.min(strokes as f64))
    }

    /// Height of the surface at `at`, mm; none where no stroke has passed.
    pub fn height(&self, at: DVec2) -> Option<f64> {
        self.0.rest(at).map(|rest| -rest.height)
    }

    /// The surface at `at`, if a stroke has passed there.
    pub fn spot(&self, at: DVec2) -> Option<Spot> {
        let rest = self.0.rest(at)?;
        let edge = &self.0.pieces[rest.piece as usize];
        let (height, touch) = edge.touched(&self.0.cutter, at);
        let r = touch.length();
        let rise = self.0.cutter.profile.rise(r);
        let slope = if r > 0.0 && rise.is_finite() { touch * (-rise / r) } else { DVec2::ZERO };
        Some(Spot { height: -height, slope, line: edge.line })
    }

    /// The surface over a plate of `size` mm whose lower left corner is x = y = 0, polished by a Gaussian of `sigma` mm; where
    /// nothing has passed it is `uncut` mm high.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn polished(&self, size: DVec2, sigma: f64, uncut: f64, progress: &Progress) -> Result<OpenRelief, Cancelled> {
        let nodes = Nodes::new(size, sigma);
        let fine = nodes.apart / FINER as f64;
        let row = |k: usize, row: &mut [f32]| {
            for (i, z) in row.iter_mut().enumerate() {
                let place = fine * DVec2::new(i as f64, k as f64);
                *z = self.height(place).map_or(uncut, |height| height.min(uncut)) as f32;
            }
        };
        let heights = nodes.polished([FINER; 2], row, progress)?;
        Ok(OpenRelief { nodes: nodes.count, step: nodes.apart, heights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::Cutter;

    fn strokes(ends: &[[f64; 3]]) -> Vec<Stroke> {
        let ends: Vec<DVec3> = ends.iter().map(|end| DVec3::from_array(*end)).collect();
        ends.windows(2).enumerate().map(|(k, e)| Stroke { from: e[0], to: e[1], line: k as u32 + 1 }).collect()
    }

    #[test]
    fn a_ball_leaves_a_groove_a_slanted_one_a_slanted_groove_and_a_plunge_its_own_shape() {
        let ball = Cutter::ball(2.0).profile();
        let groove = Swept::new(&strokes(&[[0.0, 0.0, -0.1], [5.0, 0.0, -0.1]]), ball);
        for aside in [0.0, 0.3, -0.6] {
            let spot = groove.spot(DVec2::new(2.0, aside)).unwrap();
            assert!((spot.height - (-0.1 + 1.0 - (1.0 - aside * aside).sqrt())).abs() < 1e-12, "{spot:?}");
            assert!((spot.slope - DVec2::new(0.0, aside / (1.0 - aside * aside).sqrt())).length() < 1e-9, "{spot:?}");
        }
        assert_eq!(groove.height(DVec2::new(2.0, 1.1)), None);
        // Along a slope s a ball's underside is R (√(1 + s²) - 1) below its tip's line.
        let slanted = Swept::new(&strokes(&[[0.0, 0.0, 0.0], [8.0, 0.0, 1.6]]), ball);
        let spot = slanted.spot(DVec2::new(4.0, 0.0)).unwrap();
        assert!((spot.height - (0.8 - (1.04_f64.sqrt() - 1.0))).abs() < 1e-9 && (spot.slope.x - 0.2).abs() < 1e-9);
        let hole = Swept::new(&strokes(&[[1.0, 1.0, 2.0], [1.0, 1.0, -0.5]]), Cutter::Flat { diameter: 1.0 }.profile());
        assert_eq!((hole.height(DVec2::new(1.3, 1.3)), hole.height(DVec2::new(1.4, 1.4))), (Some(-0.5), None));
    }

    #[test]
    fn the_lowest_of_many_strokes_in_all_directions_is_found_with_its_line() {
        let mut state = 9_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let ends: Vec<[f64; 3]> = (0..400).map(|_| [4.0 * random(), 4.0 * random(), 0.3 * random()]).collect();
        let all = strokes(&ends);
        for cutter in ["ball:0.5", "flat:0.3", "bull:0.6,0.1", "cone:60,0.05,0.6"] {
            let profile = cutter.parse::<Cutter>().unwrap().profile();
            let swept = Swept::new(&all, profile);
            let single: Vec<Swept> = all.iter().map(|one| Swept::new(std::slice::from_ref(one), profile)).collect();
            for _ in 0..40 {
                let at = DVec2::new(4.0 * random(), 4.0 * random());
                let each = single.iter().filter_map(|one| one.spot(at));
                let lowest = each.min_by(|a, b| a.height.total_cmp(&b.height));
                let found = swept.spot(at);
                assert_eq!(found.is_some(), lowest.is_some());
                if let (Some(found), Some(lowest)) = (found, lowest) {
                    assert!((found.height - lowest.height).abs() < 1e-9, "{cutter}: {found:?} {lowest:?}");
                }
            }
        }
    }

    #[test]
    fn polish_leaves_the_mean_of_even_cusps() {
        let rows: Vec<[f64; 3]> = (-10..60)
            .flat_map(|k| {
                let y = 0.06 * f64::from(k);
                let ends = [[-1.0, y, 0.2], [4.0, y, 0.2]];
                if k % 2 == 0 { ends } else { [ends[1], ends[0]] }
            })
            .collect();
        let swept = Swept::new(&strokes(&rows), Cutter::ball(1.0).profile());
        let relief = swept.polished(DVec2::new(2.0, 2.0), 0.1, 1.0, &Progress::silent()).unwrap();
        let [nx, ny] = relief.nodes;
        // A cusp of w²/8R has a mean of a third of it: 0.06²/(24 · 0.5).
        let mean = f64::from(relief.heights[ny / 2 * nx + nx / 2]) - 0.2;
        assert!((mean - 0.0036 / 12.0).abs() < 0.2e-4, "{mean}");
    }
}
