//! Models fitted to measured reflectance, one to three lobes over an even base, ranked by how well they do.
//!
//! The error is that of Ngan, Durand, Matusik, "Experimental analysis of BRDF models" (EGSR 2005), the root of the mean
//! squared difference of f_r cosθi over all pairs of directions, weighted with their solid angles; compressed as
//! log(1 + f_r cosθi), so that a mirror's peak does not drown all else.

mod least_squares;

mod shape;

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DVector;
use rayon::prelude::*;

use least_squares::minimum;
use shape::{Shape, term};

use crate::brdf::model::Model;
use crate::brdf::model::named::{Named, Term};
use crate::brdf::model::parts::Share;
use crate::progress::{Cancelled, Progress};
use crate::slope::{direction, mirror};

/// Models that are tried, one lobe each.
const TRIED: [&str; 11] = [
    "ggx",
    "beckmann",
    "shifted-gamma",
    "blinn-phong",
    "gaussian",
    "cook-torrance",
    "ward",
    "ward-bounded",
    "ashikhmin-shirley",
    "phong",
    "lafortune",
];
/// Models, the best ones first, that are tried with more lobes.
const WITH_MORE: usize = 3;
/// One more lobe is believed if it takes this share of the error.
const WORTH_A_LOBE: f64 = 0.15;
/// Reflectance below which an even base counts as none.
const NO_BASE: f64 = 1e-5;
/// Polar angles of the light, degrees.
const POLAR: [f64; 6] = [2.0, 15.0, 30.0, 45.0, 60.0, 75.0];
/// Half vectors of every light: tilts, closer together toward the normal, and azimuths of a turn.
const TILTS: usize = 24;
const AROUND: usize = 24;

/// One pair of directions.
#[derive(Clone, Copy, Debug)]
struct Sample {
    wi: DVec3,
    wo: DVec3,
    /// log(1 + f_r cosθi).
    value: f64,
    /// √ of its share of all.
    weight: f64,
}

/// Reflectance, sampled where lobes are.
#[derive(Clone, Debug)]
pub struct Samples {
    samples: Vec<Sample>,
    isotropic: bool,
    /// Slope at which the lobe has fallen to half, and f_r on top of it under light from near the normal.
    width: f64,
    peak: f64,
    /// Least value there.
    base: f64,
}

impl Samples {
    /// Samples `f`, f_r in 1/sr, of a material that looks the same however it is turned, or not. `None` if it is dark.
    pub fn new(f: impl Fn(DVec3, DVec3) -> f64 + Sync, isotropic: bool) -> Option<Self> {
        let turns = if isotropic { 1 } else { 4 };
        let mut samples = Vec::new();
        for theta in POLAR {
            for turn in 0..turns {
                let wi = direction(theta.to_radians(), PI * turn as f64 / turns as f64);
                for k in 0..TILTS * AROUND {
                    let rise = (k % TILTS) as f64 + 0.5;
                    let tilt = 0.5 * PI * (rise / TILTS as f64).powi(2);
                    let h = direction(tilt, 2.0 * PI * ((k / TILTS) as f64 + 0.5) / AROUND as f64);
                    let (cosine, wo) = (wi.dot(h), mirror(wi, h));
                    let value = f(wi, wo);
                    if cosine > 0.0 && wo.z > 0.03 && value.is_finite() && value >= 0.0 {
                        let area = 4.0 * cosine * tilt.sin() * rise;
                        samples.push(Sample { wi, wo, value: (value * wi.z).ln_1p(), weight: area.sqrt() });
                    }
                }
            }
        }
        let whole: f64 = samples.iter().map(|sample| sample.weight.powi(2)).sum();
        samples.iter_mut().for_each(|sample| sample.weight /= whole.sqrt());
        let (peak, base, width) = lobe(&f);
        (peak > 0.0 && !samples.is_empty()).then_some(Self { samples, isotropic, width, peak, base })
    }

    /// How many pairs of directions.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Whether the material was taken to look the same however it is turned.
    pub fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    fn residuals(&self, model: &Named) -> DVector<f64> {
        let residual = |sample: &Sample| {
            let value = model.value(sample.wi, sample.wo) * sample.wi.z;
            sample.weight * (value.max(0.0).ln_1p() - sample.value)
        };
        DVector::from_iterator(self.samples.len(), self.samples.iter().map(residual))
    }
}

/// Top, least value and width (slope at half height) of the lobe under light 2° from the normal.
fn lobe(f: &impl Fn(DVec3, DVec3) -> f64) -> (f64, f64, f64) {
    let wi = direction(f64::to_radians(POLAR[0]), 0.0);
    let mean = |tilt: f64| {
        let around = (0..16).map(|k| f(wi, mirror(wi, direction(tilt, 2.0 * PI * k as f64 / 16.0))));
        let sound: Vec<f64> = around.filter(|value| value.is_finite()).collect();
        sound.iter().sum::<f64>() / sound.len().max(1) as f64
    };
    let curve: Vec<(f64, f64)> = (0..200).map(|k| 0.7 * (k as f64 / 200.0).powi(2)).map(|t| (t, mean(t))).collect();
    let peak = curve.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    let base = curve.iter().map(|(_, value)| *value).fold(f64::INFINITY, f64::min).max(0.0);
    let half = curve.iter().find(|(_, value)| *value < base + 0.5 * (peak - base)).map_or(0.5, |(tilt, _)| *tilt);
    (peak, base, half.tan().max(2e-3))
}

/// A model fitted.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// It, whose words can stand behind `--goal` and `--material`.
    pub model: Named,
    /// Lobes besides the even base.
    pub lobes: usize,
    /// Root of the mean squared difference of log(1 + f_r cosθi).
    pub error: f64,
    /// Every free number, its value and its standard error from the Jacobian.
    pub parameters: Vec<(String, f64, f64)>,
}

/// Fits every model to `samples`, the best ones with up to three lobes; best first.
///
/// # Errors
/// It is cancelled.
pub fn fit(samples: &Samples, progress: &Progress) -> Result<Vec<Fitted>, Cancelled> {
    let one: Vec<Fitted> = TRIED
        .par_iter()
        .filter_map(|name| if progress.is_abandoned() { None } else { single(samples, name) })
        .collect();
    progress.check()?;
    let mut all = ranked(one);
    let best: Vec<Fitted> = all.iter().take(WITH_MORE).cloned().collect();
    let more: Vec<Vec<Fitted>> = best
        .into_par_iter()
        .map(|mut last| {
            let mut found = Vec::new();
            while last.lobes < 3 && !progress.is_abandoned() {
                let Some(next) = with_another(samples, &last) else { break };
                if next.error > (1.0 - WORTH_A_LOBE) * last.error {
                    break;
                }
                found.push(next.clone());
                last = next;
            }
            found
        })
        .collect();
    progress.check()?;
    all.extend(more.into_iter().flatten());
    Ok(ranked(all))
}

fn ranked(mut all: Vec<Fitted>) -> Vec<Fitted> {
    all.sort_by(|a, b| a.error.total_cmp(&b.error));
    all
}

/// The best fit of one lobe of the model called `name`, from several starts.
fn single(samples: &Samples, name: &str) -> Option<Fitted> {
    let base = (PI * samples.base).clamp(1e-4, 0.95);
    let mut best: Option<Fitted> = None;
    for wide in [1.0, 2.0] {
        for lobe in starts(samples, name, wide * samples.width) {
            let terms = vec![term("lambert", vec![base], Share::Even(1.0))?, lobe];
            let Some(found) = descended(samples, terms) else { continue };
            if best.as_ref().is_none_or(|best| found.error < best.error) {
                best = Some(found);
            }
        }
    }
    best
}

/// Lobes to begin with, for a slope of `width` at half height: d falls to half at 0.64 α of GGX and 0.83 α of a Gaussian.
fn starts(samples: &Samples, name: &str, width: f64) -> Vec<Term> {
    let alpha = (width / 0.75).clamp(2e-3, 1.5);
    let exponent = (2.0 / (alpha * alpha)).clamp(1.0, 5e4);
    let both = |number: f64| if samples.isotropic { vec![number] } else { vec![number, 0.8 * number] };
    // The height of a lobe of facets straight on is 1/(4π α²).
    let share = (samples.peak * 4.0 * PI * alpha * alpha).clamp(1e-3, 1.0);
    let (even, fresnel) = (Share::Even(share), Share::Schlick(share.clamp(0.02, 0.9)));
    let made = |numbers: Vec<f64>, shares: &[Share]| -> Vec<Term> {
        shares.iter().filter_map(|share| term(name, numbers.clone(), *share)).collect()
    };
    match name {
        "ggx" | "beckmann" | "cook-torrance" => made(both(alpha), &[even, fresnel]),
        "ward" | "ward-bounded" => made(both(alpha), &[even]),
        "blinn-phong" => made(vec![exponent], &[even, fresnel]),
        "gaussian" => made(vec![alpha], &[even, fresnel]),
        "phong" => made(vec![0.25 * exponent], &[even]),
        "ashikhmin-shirley" => made(vec![exponent, if samples.isotropic { exponent } else { 1.5 * exponent }], &[even]),
        "shifted-gamma" => [made(vec![alpha, 1.5], &[even]), made(vec![alpha * alpha, 0.3], &[even])].concat(),
        "lafortune" => {
            let n = (0.25 * exponent).clamp(1.0, 2e4);
            let c = samples.peak.max(1e-6).powf(1.0 / n);
            made(vec![-c, if samples.isotropic { -c } else { -0.99 * c }, c, n], &[Share::Even(1.0)])
        }
        _ => Vec::new(),
    }
}

/// `last` with one more lobe of its kind, three times as wide or a third as wide as its own last one.
fn with_another(samples: &Samples, last: &Fitted) -> Option<Fitted> {
    let mut best: Option<Fitted> = None;
    for factor in [3.0, 1.0 / 3.0] {
        let mut terms = last.model.terms().to_vec();
        if !terms.iter().any(|term| term.kind.is_base) {
            terms.insert(0, term("lambert", vec![1e-3], Share::Even(1.0))?);
        }
        let mut lobe = terms.last()?.clone();
        let wide = ["ggx", "beckmann", "cook-torrance", "ward", "ward-bounded", "gaussian", "shifted-gamma"];
        match lobe.kind.name {
            "lafortune" => lobe.numbers[3] *= f64::powi(factor, -2),
            "shifted-gamma" => lobe.numbers[0] *= factor,
            name if wide.contains(&name) => lobe.numbers.iter_mut().for_each(|number| *number *= factor),
            _ => lobe.numbers.iter_mut().for_each(|number| *number *= f64::powi(factor, -2)),
        }
        lobe.numbers.iter_mut().zip(lobe.kind.numbers).for_each(|(value, of)| *value = value.clamp(of.low, of.high));
        lobe.share = match lobe.share {
            Share::Even(share) => Share::Even(0.3 * share),
            Share::Schlick(share) => Share::Schlick(0.3 * share),
            other => other,
        };
        terms.push(lobe);
        let Some(found) = descended(samples, terms) else { continue };
        if best.as_ref().is_none_or(|best| found.error < best.error) {
            best = Some(found);
        }
    }
    best
}

fn descended(samples: &Samples, terms: Vec<Term>) -> Option<Fitted> {
    let shape = Shape::new(terms);
    let found = minimum(&shape.start(), |at| Some(samples.residuals(&shape.model(at)?)))?;
    let lobes = shape.terms(&found.at).iter().filter(|term| !term.kind.is_base).count();
    Some(Fitted {
        model: rounded(&shape, &found.at)?,
        lobes,
        error: found.sum.sqrt(),
        parameters: shape.told(&found.at, &found.errors),
    })
}

/// With six digits of each number: more than any measurement has.
fn rounded(shape: &Shape, at: &[f64]) -> Option<Named> {
    let round = |value: f64| format!("{value:.5e}").parse().unwrap_or(value);
    let mut terms = shape.terms(at);
    for term in &mut terms {
        term.numbers.iter_mut().for_each(|number| *number = round(*number));
        term.share = match term.share {
            Share::Even(share) => Share::Even(round(share)),
            Share::Schlick(share) => Share::Schlick(round(share)),
            Share::Index(eta) => Share::Index(round(eta)),
        };
    }
    // A base that is not there need not be written.
    if terms.iter().any(|term| !term.kind.is_base) {
        terms.retain(|term| !term.kind.is_base || term.numbers[0] > NO_BASE);
    }
    Named::new(terms).ok()
}

#[cfg(test)]
mod tests;
