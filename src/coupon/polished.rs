//! The polish, from the half that was polished beside the half that was not.
//!
//! The same passes go through both. So the polished half is the other one smoothed by a Gaussian, and the width is sought at
//! which that is so.

use super::layout::{Coupon, Kind, Place};
use super::least_squares::linear_fit;
use super::lines::{Grooves, apart, even, wide};
use super::told::{BLOCKS, Told};
use crate::milling::polish::taps;

/// Widths that are tried, mm: from what leaves cusps as they are to what leaves nothing of them.
const WIDTHS: usize = 72;
const NARROWEST: f64 = 1.5e-3;
const WIDEST: f64 = 0.4;

/// Places between two passes.
const STEPS: f64 = 40.0;

/// A polish that explains less of the difference than this is none: of what is left without it.
const EXPLAINS: f64 = 0.02;

/// Lines of both halves on the same places across the passes.
pub struct Polished {
    /// Squares that each width leaves, for each part of the passes, mm².
    left: Vec<Vec<f64>>,
    /// The same for no polish.
    bare: Vec<f64>,
}

impl Polished {
    /// The polish of the right half.
    pub fn told(coupon: &Coupon, lines: &[Grooves]) -> Told {
        let of = |places: &[Place]| lines.iter().filter(|line| places.contains(&line.place)).collect::<Vec<_>>();
        let (bare, polished) = (of(&[Place::AfterHill, Place::AfterValley]), of(&[Place::Polished]));
        if bare.is_empty() || polished.is_empty() {
            return Told::Untold("it takes a level line in each half, the polished and the unpolished one".into());
        }
        let own = Self::new(coupon, &bare, &polished);
        let Some(width) = own.best(None) else {
            return Told::Untold("the right half is not polished: its grooves are those of the left half".into());
        };
        let without: Vec<f64> = (0..BLOCKS).map(|block| own.best(Some(block)).unwrap_or(width)).collect();
        if width > 0.9 * WIDEST {
            return Told::Untold(format!(
                "nothing is left of the grooves: it is wider than {WIDEST} mm or the tape was too"
            ));
        }
        Told::jackknife(width, &without)
    }

    fn new(coupon: &Coupon, bare: &[&Grooves], polished: &[&Grooves]) -> Self {
        let step = apart(coupon) / STEPS;
        let tracks = wide(coupon);
        let end = tracks.last().map_or(0.0, |track| track.y);
        let domes = coupon.bands.iter().zip(coupon.begins()).find(|(band, _)| band.kind == Kind::Domes);
        let count = (domes.map_or(end, |(_, begin)| begin) / step) as usize;
        // What is read: whole parts of the passes far apart, away from the piece's edge.
        let (from, to) = ((0.5 / step) as usize, (end / step) as usize);
        let meant = mean(&bare.iter().map(|line| level(&even(&line.points, 0.0, step, count), to)).collect::<Vec<_>>());
        let part = |k: usize| BLOCKS * (k - from) / (to - from).max(1);
        let compare = |smooth: &[f64]| {
            let mut left = vec![0.0; BLOCKS];
            for line in polished {
                let seen = even(&line.points, 0.0, step, count);
                let off: Vec<f64> = seen.iter().zip(smooth).map(|(a, b)| a - b).collect();
                let off = level(&off[..to.min(off.len())], to);
                for (k, off) in off.iter().enumerate().skip(from).filter(|(_, off)| off.is_finite()) {
                    left[part(k).min(BLOCKS - 1)] += off * off;
                }
            }
            left
        };
        let left = (0..WIDTHS).map(|k| compare(&smoothed(&meant, width(k) / step))).collect();
        Self { left, bare: compare(&meant) }
    }

    /// The width that leaves least, mm, all but a part of the passes looked at; none if it is none.
    fn best(&self, without: Option<usize>) -> Option<f64> {
        let sum =
            |parts: &[f64]| parts.iter().enumerate().filter(|(k, _)| Some(*k) != without).map(|(_, v)| v).sum::<f64>();
        let sums: Vec<f64> = self.left.iter().map(|parts| sum(parts)).collect();
        let (k, least) = sums.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let bare = sum(&self.bare);
        if *least > (1.0 - EXPLAINS) * bare || k == 0 {
            return None;
        }
        let (before, after) = (sums[k - 1], *sums.get(k + 1).unwrap_or(least));
        let bend = before - 2.0 * least + after;
        let aside = if bend > 0.0 { (0.5 * (before - after) / bend).clamp(-1.0, 1.0) } else { 0.0 };
        Some(width(0) * (width(1) / width(0)).powf(k as f64 + aside))
    }
}

/// Width number `k` that is tried, mm.
fn width(k: usize) -> f64 {
    NARROWEST * (WIDEST / NARROWEST).powf(k as f64 / (WIDTHS - 1) as f64)
}

/// Heights less level, tilt and bow of their first `to` places.
fn level(heights: &[f64], to: usize) -> Vec<f64> {
    let basis = |k: usize| {
        let share = k as f64 / to.max(1) as f64 - 0.5;
        nalgebra::Vector3::new(1.0, share, share * share)
    };
    let known = heights.iter().enumerate().take(to).filter(|(_, z)| z.is_finite());
    let fit = linear_fit(known.map(|(k, z)| (basis(k), *z)), 0.0).map_or_else(nalgebra::Vector3::zeros, |fit| fit.of);
    heights.iter().enumerate().map(|(k, z)| z - fit.dot(&basis(k))).collect()
}

/// The mean of lines, where any is known.
fn mean(lines: &[Vec<f64>]) -> Vec<f64> {
    let at = |k: usize| {
        let known: Vec<f64> = lines.iter().map(|line| line[k]).filter(|z| z.is_finite()).collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    (0..lines[0].len()).map(at).collect()
}

/// Heights smoothed by a Gaussian of `sigma` places; gaps and ends count for nothing.
fn smoothed(heights: &[f64], sigma: f64) -> Vec<f64> {
    // Narrower than this a Gaussian of single samples is none: the three nearest keep its variance.
    let taps = if sigma < 0.7 { vec![1.0 - sigma * sigma, 0.5 * sigma * sigma] } else { taps(sigma) };
    let at = |k: usize| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (j, tap) in taps.iter().enumerate() {
            let sides = if j == 0 { [Some(k), None] } else { [k.checked_sub(j), Some(k + j)] };
            for z in sides.into_iter().flatten().filter_map(|k| heights.get(k)).filter(|z| z.is_finite()) {
                sum += tap * z;
                weights += tap;
            }
        }
        sum / weights
    };
    (0..heights.len()).map(at).collect()
}
