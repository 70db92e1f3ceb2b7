//! The surface that a program leaves beside the one that is wanted, where a cutter can reach that.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::gcode::check::Amiss;
use crate::gcode::program::{Move, Program};
use crate::golden::golden;
use crate::milling::swept::{Spot, Stroke, Swept};
use crate::milling::tip::TipHeights;
use crate::progress::{Cancelled, Progress};

/// Chords in place of arcs, mm: a hundredth of what counts.
const CHORD: f64 = 1e-5;

/// Places of the cutter along a side of the optical area at which the surface is looked at.
const PLACES: usize = 400;

/// A pass no higher than this above the lowest place of its cutter is one that leaves the surface, mm: allowances of roughing
/// are larger, errors of finishing smaller.
const FINISHES: f64 = 0.02;

/// Cusps that are evenly spread are three times as high as their mean; a third more is no mistake of the program.
const EVEN_CUSPS: f64 = 4.0;

/// Cuts, as strokes whose arcs are chords, in a frame whose zero is at `origin` mm as the program counts.
pub fn strokes(program: &Program, origin: DVec3) -> Vec<Stroke> {
    let mut strokes = Vec::with_capacity(program.motions.len());
    for one in program.moves().filter(|one| one.cuts() && one.is_known()) {
        let mut from = one.from;
        for to in program.pieces(&one.motion, CHORD) {
            strokes.push(Stroke { from: from - origin, to: to - origin, line: one.motion.line });
            from = to;
        }
    }
    strokes
}

/// What is left standing above the wanted surface, at places that the cutter can touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Left {
    /// Mean, mm: of a finished surface that of its cusps.
    pub mean: f64,
    /// The least but for a hundredth of the places, mm: next to nothing where passes touch the surface.
    pub least: f64,
    /// Most, mm; and there, as the program counts, mm, with the line that passed lowest.
    pub most: f64,
    /// That place.
    pub place: DVec3,
    /// That line.
    pub line: u32,
    /// Share of the places over which nothing has passed.
    pub untouched: f64,
    /// The deepest below the wanted surface, mm.
    pub deepest: f64,
}

/// A plate that a program is to leave.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// How low the cutter can stand over it.
    pub tips: &'a TipHeights,
    /// The zero of its frame, as the program counts, mm.
    pub origin: DVec3,
    /// Lower left and upper right corner of its optical area in its frame, mm.
    pub optical: [DVec2; 2],
}

/// What stands at the point of the plate that a cutter touches from `at` (in the plate's frame), and there.
struct Standing {
    by: f64,
    place: DVec3,
    line: u32,
}

impl Wanted<'_> {
    /// At the point that a cutter touches whose tip is at `at` in the plate's frame; none beside the optical area.
    fn standing(&self, swept: &Swept, at: DVec2) -> Option<Result<Standing, DVec3>> {
        let contact = self.tips.contact(at)?;
        let [low, high] = self.optical;
        let within = contact.truncate().cmpge(low).all() && contact.truncate().cmple(high).all();
        let place = contact + self.origin;
        let standing = |spot: Spot| Standing { by: spot.height - contact.z, place, line: spot.line };
        within.then(|| swept.spot(contact.truncate()).map(standing).ok_or(place))
    }

    /// What `swept` leaves standing over all of the optical area.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn left(&self, swept: &Swept, progress: &Progress) -> Result<Left, Cancelled> {
        let [low, high] = self.optical;
        let rows: Vec<_> = (0..PLACES)
            .into_par_iter()
            .map(|j| {
                if progress.is_abandoned() {
                    return Vec::new();
                }
                let at = |i: usize| {
                    // Rows and columns keep no step with passes.
                    let share = DVec2::new(i as f64 + golden(7 * j + 3), j as f64 + golden(i + 11 * j));
                    low + (high - low) * share / PLACES as f64
                };
                (0..PLACES).filter_map(|i| self.standing(swept, at(i))).collect()
            })
            .collect();
        progress.check()?;
        let mut left = Left::default();
        let mut heights = Vec::new();
        let (mut touched, mut missed) = (0.0, 0.0);
        for standing in rows.into_iter().flatten() {
            let Ok(Standing { by, place, line }) = standing else {
                missed += 1.0;
                continue;
            };
            touched += 1.0;
            heights.push(by);
            left.mean += by;
            left.deepest = left.deepest.max(-by);
            if by > left.most {
                (left.most, left.place, left.line) = (by, place, line);
            }
        }
        left.mean /= f64::max(touched, 1.0);
        heights.sort_unstable_by(f64::total_cmp);
        left.least = heights.get(heights.len() / 100).copied().unwrap_or_default();
        left.untouched = missed / f64::max(touched + missed, 1.0);
        Ok(left)
    }

    /// Cuts at whose own places the surface is left standing by more than `tolerance` mm, and places elsewhere that stand
    /// higher than even cusps do.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn missed(
        &self,
        program: &Program,
        (swept, left): (&Swept, &Left),
        tolerance: f64,
        progress: &Progress,
    ) -> Result<Amiss, Cancelled> {
        let most = tolerance + EVEN_CUSPS * (left.mean - left.least).max(0.0);
        let cuts: Vec<Move> = program.moves().filter(|one| one.cuts() && one.is_known()).collect();
        let found: Vec<Option<(f64, DVec3)>> = cuts
            .par_iter()
            .map(|one| {
                // Straight down nothing is wiped.
                if progress.is_abandoned() || one.from.truncate() == one.motion.to.truncate() {
                    return None;
                }
                let places = [one.from, 0.5 * (one.from + one.motion.to), one.motion.to];
                let above = |place: DVec3| {
                    let at = place - self.origin;
                    at.z - self.tips.at(at.truncate())
                };
                // A pass that is to leave the surface touches it somewhere; one well above it only takes stock away.
                let finishes = places.iter().any(|place| above(*place) < FINISHES);
                let most = if finishes { tolerance } else { most };
                let standing = places.iter().filter_map(|place| {
                    if above(*place) <= tolerance {
                        return None;
                    }
                    let standing = self.standing(swept, (*place - self.origin).truncate())?.ok()?;
                    Some(standing).filter(|standing| standing.by > most)
                });
                standing.map(|standing| (standing.by, standing.place)).max_by(|a, b| a.0.total_cmp(&b.0))
            })
            .collect();
        progress.check()?;
        let mut amiss = Amiss::default();
        cuts.iter().zip(found).for_each(|(one, found)| amiss.take(one.motion.line, found));
        // Only where no cut is to blame itself: what passed lowest there may be its neighbour.
        if amiss.is_none() && left.most > most {
            amiss.take(left.line, Some((left.most, left.place)));
        }
        Ok(amiss)
    }
}
