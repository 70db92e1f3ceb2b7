//! What a program does to stock and machine: bounds, rapids too low, cuts too deep, moves that go nobody knows where.
//!
//! Surfaces are handed over as functions of the place, so that anything that has a height can be asked.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::program::{Move, Program};

/// The least and largest coordinates, mm; those of axes that are never named are 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least.
    pub low: DVec3,
    /// Largest.
    pub high: DVec3,
}

/// Lengths and bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// Of all moves whose beginning is known.
    pub all: Option<Bounds>,
    /// Of cuts.
    pub cuts: Option<Bounds>,
    /// Rapids and cuts.
    pub moves: [usize; 2],
    /// Their lengths, mm.
    pub lengths: [f64; 2],
    /// Least and largest feed, mm/min.
    pub feeds: Option<(f64, f64)>,
}

/// How far and where `program` moves.
pub fn extent(program: &Program) -> Extent {
    let mut extent = Extent::default();
    let join = |bounds: &mut Option<Bounds>, (low, high): (DVec3, DVec3)| {
        let before = bounds.unwrap_or(Bounds { low, high });
        *bounds = Some(Bounds { low: before.low.min(low), high: before.high.max(high) });
    };
    for one in program.moves() {
        let cuts = usize::from(one.cuts());
        extent.moves[cuts] += 1;
        if one.cuts() {
            let feed = one.motion.feed;
            let (least, most) = extent.feeds.unwrap_or((feed, feed));
            extent.feeds = Some((least.min(feed), most.max(feed)));
        }
        // The first moves come from wherever the tool stands: their end counts alone, once all of it is known.
        if one.motion.known != [true; 3] {
            continue;
        }
        let ends = (one.motion.to, one.motion.to);
        let (reached, length) = match program.arc(&one.motion) {
            Some(arc) => (arc.bounds(), arc.length()),
            None if one.is_known() => {
                ((one.from.min(one.motion.to), one.from.max(one.motion.to)), one.from.distance(one.motion.to))
            }
            None => (ends, 0.0),
        };
        extent.lengths[cuts] += length;
        join(&mut extent.all, reached);
        if one.cuts() {
            join(&mut extent.cuts, reached);
        }
    }
    extent
}

/// Places where something is amiss.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Amiss {
    /// Moves of which some place is.
    pub moves: usize,
    /// The first of them.
    pub first_line: u32,
    /// By how much at the worst place, mm.
    pub worst: f64,
    /// Line of the worst place.
    pub line: u32,
    /// The worst place, mm.
    pub place: DVec3,
}

impl Amiss {
    /// Takes the worst place of a move, if any is amiss.
    pub(crate) fn take(&mut self, line: u32, worst: Option<(f64, DVec3)>) {
        let Some((by, place)) = worst else { return };
        self.moves += 1;
        if self.moves == 1 {
            self.first_line = line;
        }
        if by > self.worst || self.moves == 1 {
            (self.worst, self.line, self.place) = (by, line, place);
        }
    }

    /// Whether nothing is amiss.
    pub fn is_none(&self) -> bool {
        self.moves == 0
    }
}

/// Most places that are looked at along one move: a rapid over 10 m at 0.1 mm.
const MOST_PLACES: f64 = 100_000.0;

/// Chords in place of arcs, mm.
const CHORD: f64 = 1e-4;

/// The worst place of a move, looked at every `step` mm and at its end (its beginning is the end of another): by how much `below` says it is too low.
fn worst(
    program: &Program,
    one: &Move,
    step: f64,
    below: &(impl Fn(DVec3) -> Option<f64> + Sync),
) -> Option<(f64, DVec3)> {
    let mut worst: Option<(f64, DVec3)> = None;
    let mut from = one.from;
    for to in program.pieces(&one.motion, CHORD) {
        let n = (from.truncate().distance(to.truncate()) / step).ceil().clamp(1.0, MOST_PLACES) as usize;
        for k in 1..=n {
            let place = from.lerp(to, k as f64 / n as f64);
            if let Some(by) = below(place)
                && worst.is_none_or(|(most, _)| by > most)
            {
                worst = Some((by, place));
            }
        }
        from = to;
    }
    worst
}

/// The worst places of all of `moves` together, each looked at as `worst` says.
fn all_worst(program: &Program, moves: &[Move], step: f64, below: &(impl Fn(DVec3) -> Option<f64> + Sync)) -> Amiss {
    let found: Vec<_> = moves.par_iter().map(|one| worst(program, one, step, below)).collect();
    let mut amiss = Amiss::default();
    moves.iter().zip(found).for_each(|(one, found)| amiss.take(one.motion.line, found));
    amiss
}

/// Rapids that go sideways or down below the height that `safe` gives for a place, looked at every `step` mm. Straight up
/// they leave the way that they came.
pub fn low_rapids(program: &Program, safe: impl Fn(DVec2) -> f64 + Sync, step: f64) -> Amiss {
    let is_up = |one: &Move| one.from.truncate() == one.motion.to.truncate() && one.motion.to.z >= one.from.z;
    let rapids: Vec<Move> = program.moves().filter(|one| !one.cuts() && one.is_known() && !is_up(one)).collect();
    all_worst(program, &rapids, step, &|place: DVec3| Some(safe(place.truncate()) - place.z).filter(|by| *by > 0.0))
}

/// Moves sideways while the height, or cuts while any axis, is unknown: they come from wherever the tool stands.
pub fn blind_moves(program: &Program) -> Amiss {
    let mut amiss = Amiss::default();
    for one in program.moves() {
        let sideways = one.motion.to.truncate() != one.from.truncate() || one.motion.known[..2] != one.from_known[..2];
        let blind = if one.cuts() { !one.is_known() } else { sideways && !one.from_known[2] };
        amiss.take(one.motion.line, blind.then_some((0.0, one.motion.to)));
    }
    amiss
}

/// Cuts that pass more than `tolerance` mm below the lowest place of the tool's tip that `lowest` allows, looked at every
/// `step` mm; `None` where nothing is to be kept.
pub fn gouges(program: &Program, lowest: impl Fn(DVec2) -> Option<f64> + Sync, tolerance: f64, step: f64) -> Amiss {
    let cuts: Vec<Move> = program.moves().filter(|one| one.cuts() && one.is_known()).collect();
    let below = |place: DVec3| lowest(place.truncate()).map(|least| least - place.z).filter(|by| *by > tolerance);
    all_worst(program, &cuts, step, &below)
}

/// Moves that leave the box from `low` to `high`, mm.
pub fn strays(program: &Program, low: DVec3, high: DVec3) -> Amiss {
    let mut amiss = Amiss::default();
    for one in program.moves().filter(Move::is_known) {
        let (least, most) = match program.arc(&one.motion) {
            Some(arc) => arc.bounds(),
            None => (one.from.min(one.motion.to), one.from.max(one.motion.to)),
        };
        let by = (low - least).max(most - high).max_element();
        amiss.take(one.motion.line, (by > 0.0).then_some((by, one.motion.to)));
    }
    amiss
}

#[cfg(test)]
mod tests {
    use super::super::read::read;
    use super::*;

    fn program(text: &str) -> Program {
        let read = read(text.as_bytes(), None).unwrap();
        assert_eq!(read.fault_count, 0, "{:?}", read.faults);
        read.program
    }

    #[test]
    fn bounds_and_lengths_are_those_of_the_path() {
        let extent = extent(&program("G21G90G0Z5\nX10Y0\nG1Z-1F100\nG3X-10I-10F200\nG0Z5\nM2"));
        let all = extent.all.unwrap();
        assert!((all.low - DVec3::new(-10.0, 0.0, -1.0)).length() < 1e-12, "{all:?}");
        assert!((all.high - DVec3::new(10.0, 10.0, 5.0)).length() < 1e-12, "the top of the half circle");
        assert_eq!(extent.cuts.unwrap().high.z, 5.0, "the plunge begins at 5");
        assert_eq!((extent.moves, extent.feeds), ([3, 2], Some((100.0, 200.0))));
        let half = 10.0 * std::f64::consts::PI;
        assert!((extent.lengths[1] - 6.0 - half).abs() < 1e-9 && (extent.lengths[0] - 6.0).abs() < 1e-9);
    }

    #[test]
    fn a_rapid_in_the_way_is_named_with_its_line() {
        let hill = |place: DVec2| if place.x > 4.9 && place.x < 5.1 { 1.0 } else { 0.0 };
        let good = program("G21G90G0Z2\nX0Y0\nX10\nG1Z-1F100\nG0Z2\nM2");
        assert!(low_rapids(&good, hill, 0.05).is_none());
        let bad = program("G21G90G0Z2\nX0Y0\nZ0.5\nX10\nM2");
        let amiss = low_rapids(&bad, hill, 0.05);
        assert_eq!((amiss.moves, amiss.line, amiss.worst), (1, 4, 0.5));
        assert!((amiss.place.x - 5.0).abs() < 0.11);
        let sunk = low_rapids(&program("G21G90G0Z2\nX0Y0\nZ-0.25\nM2"), hill, 0.05);
        assert_eq!((sunk.first_line, sunk.worst), (3, 0.25));
    }

    #[test]
    fn moves_from_nowhere_are_told() {
        assert!(blind_moves(&program("G21G90G0Z5\nX0Y0\nG1Z0F100")).is_none());
        assert_eq!(blind_moves(&program("G21G90G0X0Y0\nZ5")).first_line, 1, "sideways at any height");
        assert_eq!(blind_moves(&program("G21G90G0Z5\nG1X3F100")).first_line, 2);
    }

    #[test]
    fn a_gouge_and_a_stray_are_measured() {
        let ball = program("G21G90G0Z5\nX0Y0\nG1Z0F100\nX10\nZ-0.002\nX0\nG0Z5");
        let flat = |_: DVec2| Some(0.0);
        let amiss = gouges(&ball, flat, 0.001, 0.05);
        assert_eq!((amiss.moves, amiss.first_line), (2, 5));
        assert!((amiss.worst - 0.002).abs() < 1e-12);
        assert!(gouges(&ball, flat, 0.003, 0.05).is_none());
        assert!(gouges(&ball, |_| None, 0.0, 0.05).is_none());
        let out = strays(&ball, DVec3::new(0.0, 0.0, -0.001), DVec3::new(9.5, 1.0, 6.0));
        assert_eq!((out.moves, out.line, out.worst), (4, 4, 0.5));
    }
}
