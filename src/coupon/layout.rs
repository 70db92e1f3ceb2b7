//! Where what is on the test piece.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::cutter::Cutter;
use crate::milling::machine::Machine;
use crate::milling::made::Machining;
use crate::milling::passes::{Passes, Ways};
use crate::milling::tip::TipHeights;
use crate::progress::{Cancelled, Progress};
use crate::relief::open::OpenRelief;

/// Version of the places below: a test piece is read by the program that knows them.
const VERSION: u32 = 1;

/// Length along the passes, mm.
pub const LENGTH: f64 = 30.0;

/// A hill and a valley: a ramp, a level part, a ramp, lengths in mm, and how high or deep they are, mm. Ramps are as steep as
/// reliefs usually are, and higher than any play.
const RAMP: f64 = 1.0;
const TOP: f64 = 0.6;
const HEIGHT: f64 = 0.15;

/// Where hills and valleys begin, mm from the left, and which way they go.
const BUMPS: [(f64, f64); 5] = [(0.8, 1.0), (4.6, -1.0), (8.4, 1.0), (12.2, -1.0), (16.0, 1.0)];

/// Left of this the surface stays as it is cut, right of it it is polished, mm: within a hill where nothing is read.
pub const POLISHED_FROM: f64 = 17.3;

/// A level place within a line may lie so far from the middle of its field, mm.
pub const ASIDE: f64 = 0.3;

/// Domes: where their middles are along x, how wide they are, and how high, mm.
const DOMES: [f64; 2] = [8.0, 24.0];
const DOME_WIDTH: f64 = 3.6;
const DOME_HEIGHT: f64 = 0.12;

/// Distance of the nodes that the piece is written with, mm: every ramp begins and ends on one.
const NODE: f64 = 0.1;

/// Seconds that finishing is meant to take: what a person waits for.
const SECONDS: f64 = 1200.0;

/// Seconds that a pass takes beside its length: up, down, and stops.
const BETWEEN: f64 = 1.2;

/// Least and most passes in all: fewer tell too little of scatter, more take more stock.
const PASSES: [f64; 2] = [120.0, 200.0];

/// Cusps of the passes far apart are so many times as high as heights scatter: each groove keeps its bottom even where a
/// machine is four times as bad as it is thought to be.
const ABOVE_SCATTER: f64 = 8.0;

/// No closer than this, mm, or half of the cutter's radius: what instruments and cameras tell apart well.
const APART: f64 = 0.12;

/// No farther than this share of the radius: beyond it ribs are left standing.
const WIDEST: f64 = 0.9;

/// What a band of passes is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Far apart, all from the same side.
    OneWay,
    /// As far apart, every other one on the way back.
    ToAndFro,
    /// Closer, one way.
    Closer,
    /// Over two domes.
    Domes,
}

/// Passes next to each other, equally far apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Band {
    /// What it is for.
    pub kind: Kind,
    /// Number of passes.
    pub passes: usize,
    /// From one to the next, mm.
    pub stepover: f64,
}

impl Band {
    /// Its width across the passes, mm.
    pub fn width(&self) -> f64 {
        self.passes as f64 * self.stepover
    }
}

/// One pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    /// Its place across the piece, mm.
    pub y: f64,
    /// Whether it is cut from right to left.
    pub backward: bool,
    /// Its band.
    pub band: usize,
}

/// What a line across the passes goes over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Level, come to from above by passes from left to right: after a hill.
    AfterHill,
    /// Level, come to from below: after a valley.
    AfterValley,
    /// A ramp up from left to right.
    Up,
    /// A ramp down.
    Down,
    /// Level, in the half that is polished.
    Polished,
}

/// A test piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Coupon {
    /// Version of its places.
    version: u32,
    /// Its cutter.
    pub cutter: Cutter,
    /// Its passes, from the lowest y on.
    pub bands: Vec<Band>,
    /// The machine, as it is thought to be.
    pub machine: Machine,
}

impl Coupon {
    /// For a machine and a cutter with a round tip; `feed` is what finishing goes at, mm/min.
    ///
    /// # Errors
    /// The cutter has no round tip, or the machine scatters too much for it.
    pub fn new(machine: &Machine, cutter: Cutter, feed: f64) -> Result<Self, CouponError> {
        let radius = cutter.valley_radius();
        if cutter.suits_sheets().is_err() || !(0.05..=5.0).contains(&radius) {
            return Err(CouponError::Cutter(cutter));
        }
        let needed = (8.0 * ABOVE_SCATTER * radius * machine.scatter()).sqrt();
        if needed > 2.0 * WIDEST * radius {
            return Err(CouponError::Scatter { scatter: 1000.0 * machine.scatter(), cutter });
        }
        // Whole micrometres: programs of three decimals say them.
        let whole = |length: f64| (1000.0 * length).round() / 1000.0;
        let wide = whole(needed.max(APART.min(0.5 * radius)).min(WIDEST * radius));
        let pass = 60.0 * LENGTH / feed + 60.0 * LENGTH / machine.rapid + BETWEEN;
        let all = (SECONDS / pass).clamp(PASSES[0], PASSES[1]);
        let band = |kind, share: f64, stepover: f64| Band { kind, passes: (share * all).round() as usize, stepover };
        let domes = whole((0.5 * wide).max(DOME_WIDTH / (0.12 * all)));
        let mut bands = vec![
            band(Kind::OneWay, 0.4, wide),
            band(Kind::ToAndFro, 0.28, wide),
            band(Kind::Closer, 0.1, whole(0.5 * wide)),
            band(Kind::Closer, 0.1, whole(0.25 * wide)),
        ];
        bands.push(Band { kind: Kind::Domes, passes: (1.1 * DOME_WIDTH / domes).ceil() as usize, stepover: domes });
        let mut machine = machine.clone();
        machine.compensation_z = 0.0;
        Ok(Self { version: VERSION, cutter, bands, machine })
    }

    /// What `coupon.toml` says.
    ///
    /// # Errors
    /// It is no such file, or of another version.
    pub fn from_toml(text: &str) -> Result<Self, CouponError> {
        let coupon: Self = toml::from_str(text).map_err(|error| CouponError::Toml(error.to_string()))?;
        if coupon.version != VERSION {
            return Err(CouponError::Version(coupon.version));
        }
        coupon.machine.check().map_err(|error| CouponError::Toml(error.to_string()))?;
        let bands = &coupon.bands;
        let sound = |band: &Band| (4..=10_000).contains(&band.passes) && (1e-3..=10.0).contains(&band.stepover);
        let kinds = [Kind::OneWay, Kind::ToAndFro];
        if !(bands.len() <= 20 && bands.iter().all(sound) && kinds.iter().all(|k| bands.iter().any(|b| b.kind == *k))) {
            return Err(CouponError::Toml("its bands of passes are not those of a test piece".into()));
        }
        if coupon.cutter.suits_sheets().is_err() {
            return Err(CouponError::Cutter(coupon.cutter));
        }
        Ok(coupon)
    }

    /// The same as text.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Size along and across the passes, mm.
    pub fn size(&self) -> DVec2 {
        DVec2::new(LENGTH, self.bands.iter().map(Band::width).sum())
    }

    /// Where the bands begin, mm.
    pub fn begins(&self) -> Vec<f64> {
        let mut at = 0.0;
        let begin = |band: &Band| {
            at += band.width();
            at - band.width()
        };
        self.bands.iter().map(begin).collect()
    }

    /// Every pass, from the lowest y on.
    pub fn tracks(&self) -> Vec<Track> {
        let begins = self.begins();
        let mut tracks = Vec::new();
        for (band, (of, begin)) in self.bands.iter().zip(begins).enumerate() {
            tracks.extend((0..of.passes).map(|k| Track {
                y: begin + (k as f64 + 0.5) * of.stepover,
                backward: of.kind == Kind::ToAndFro && k % 2 == 1,
                band,
            }));
        }
        tracks
    }

    /// Places of the passes as they are cut, each with whether it goes from right to left: one more on either side clears the
    /// edges.
    pub fn cuts(&self) -> Vec<(f64, bool)> {
        let tracks = self.tracks();
        let mut cuts: Vec<(f64, bool)> = tracks.iter().map(|track| (track.y, track.backward)).collect();
        if let (Some(first), Some(last)) = (self.bands.first(), self.bands.last()) {
            cuts.insert(0, (-0.5 * first.stepover, false));
            cuts.push((self.size().y + 0.5 * last.stepover, false));
        }
        cuts
    }

    /// How far apart passes are at the most, mm.
    pub fn widest(&self) -> f64 {
        self.bands.iter().map(|band| band.stepover).fold(0.0, f64::max)
    }

    /// The ways of the finishing passes that `machining` cuts over `tips`.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn ways(&self, machining: &Machining, tips: &TipHeights, progress: &Progress) -> Result<Ways, Cancelled> {
        let steps = [machining.place(), machining.machine.quantum()];
        Ways::along_x(tips, (self.size(), self.widest()), &self.cuts(), steps, progress)
    }

    /// The finishing passes, as far as they are alike.
    pub fn passes(&self) -> Passes {
        Passes { angle: 0.0, stepover: self.widest(), zigzag: false }
    }

    /// Height of the surface that is meant, mm.
    pub fn height(&self, at: DVec2) -> f64 {
        let begins = self.begins();
        let domed = self
            .bands
            .iter()
            .zip(&begins)
            .find(|(band, begin)| band.kind == Kind::Domes && at.y >= **begin && at.y <= **begin + band.width());
        match domed {
            Some((band, begin)) => {
                let middle = begin + 0.5 * band.width();
                let dome = |x: f64| {
                    let share = (at - DVec2::new(x, middle)).length() / (0.5 * DOME_WIDTH);
                    DOME_HEIGHT * (1.0 - share * share).max(0.0)
                };
                DOMES.into_iter().map(dome).sum()
            }
            None => level(at.x),
        }
    }

    /// The surface that is meant.
    pub fn relief(&self) -> OpenRelief {
        let size = self.size();
        let squares = [(size.x / NODE).round(), (size.y / NODE).ceil()];
        let step = size / DVec2::from_array(squares);
        let nodes = squares.map(|n| n as usize + 1);
        OpenRelief::from_fn(nodes, step, |from_middle| self.height(from_middle + 0.5 * size))
    }

    /// The lines across the passes that a scan is asked for: x in mm, and what lies there.
    pub fn lines(&self) -> Vec<(f64, Place)> {
        let mut lines = Vec::new();
        for (at, way) in &BUMPS[..4] {
            let [rising, falling] =
                if *way > 0.0 { [0.5 * RAMP, 1.5 * RAMP + TOP] } else { [1.5 * RAMP + TOP, 0.5 * RAMP] };
            lines.push((at + rising, Place::Up));
            lines.push((at + falling, Place::Down));
            let after = 2.0 * RAMP + TOP + 0.6;
            lines.push((at + after, if *way > 0.0 { Place::AfterHill } else { Place::AfterValley }));
        }
        lines.extend([22.0, 24.5, 27.0].map(|x| (x, Place::Polished)));
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        lines.iter().map(|(x, place)| ((1000.0 * x).round() / 1000.0, *place)).collect()
    }

    /// What lies at x = `x` mm, if anything does that is read.
    pub fn place(&self, x: f64) -> Option<Place> {
        let level_to = BUMPS[4].0 + 2.0 * RAMP + TOP + 1.0;
        if x > level_to && x < LENGTH - 0.5 {
            return Some(Place::Polished);
        }
        let (near, place) = self.lines().into_iter().min_by(|a, b| (a.0 - x).abs().total_cmp(&(b.0 - x).abs()))?;
        ((near - x).abs() <= ASIDE).then_some(place)
    }

    /// Where along x the tip has been down and up last, in words.
    pub fn in_words(place: Place) -> &'static str {
        match place {
            Place::AfterHill => "level, after a hill",
            Place::AfterValley => "level, after a valley",
            Place::Up => "a ramp up",
            Place::Down => "a ramp down",
            Place::Polished => "level, polished half",
        }
    }
}

/// Height along x where there is no dome, mm.
fn level(x: f64) -> f64 {
    let bump = |(at, way): (f64, f64)| {
        let along = x - at;
        let share = along.min(2.0 * RAMP + TOP - along) / RAMP;
        way * HEIGHT * share.clamp(0.0, 1.0)
    };
    BUMPS.into_iter().map(bump).sum()
}

/// How steep ramps are.
pub fn ramp() -> f64 {
    HEIGHT / RAMP
}

/// No test piece.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CouponError {
    /// A cutter whose grooves tell nothing.
    #[error(
        "a test piece is read by its round grooves: name with --for-cutter a ball of 0.1 to 10 mm, such as ball:0.5, in place of {0}"
    )]
    Cutter(Cutter),
    /// Heights scatter more than grooves are deep.
    #[error("with {cutter} grooves are too shallow for a machine that scatters by {scatter:.1} µm: take a larger ball")]
    Scatter {
        /// The machine's scatter, µm.
        scatter: f64,
        /// The cutter.
        cutter: Cutter,
    },
    /// Not the file of a test piece.
    #[error("{0}")]
    Toml(String),
    /// Another version.
    #[error(
        "this test piece is of version {0}, and this program reads version {VERSION}: read it with the program that wrote it"
    )]
    Version(u32),
}

#[cfg(test)]
mod tests;
