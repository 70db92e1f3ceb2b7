//! Where light went, in parts from which every figure's error follows.

use rayon::prelude::*;

use crate::progress::Cancelled;
use crate::raster::Raster;
use crate::trace::path::{End, Fate};

/// Where light went. Only ratios matter; each ray stands for the piece of the beam that it samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    /// Light that came in.
    pub incident: f64,
    /// Rays that came in.
    pub rays: u64,
    /// Left upward after one bounce.
    pub up_single: f64,
    /// Left upward after more than one.
    pub up_multi: f64,
    /// Of what left upward, beyond the image.
    pub outside_image: f64,
    /// Left downward past the plate's edge.
    pub escaped_down: f64,
    /// Met the plate's outer sides after a bounce.
    pub absorbed: f64,
    /// Was taken by the material at bounces.
    pub taken: f64,
    /// Still bouncing after the last bounce followed.
    pub trapped: f64,
    /// Met a face from behind: the mesh leaks or is turned inside out.
    pub backface: f64,
    /// Of what came in, met a wall first.
    pub first_hit_wall: f64,
    /// What left upward, by pixel of the image or screen.
    pub image: Raster,
    /// Light of a polished rim around the optical area, by pixel of the same: it lies over the image and is part of no
    /// other figure here.
    pub rim: Option<Raster>,
}

impl Tally {
    /// Whether it holds the same light as another, by however many rays.
    fn finds_as(&self, other: &Self) -> bool {
        let fates = |tally: &Self| {
            let Self { incident, up_single, up_multi, outside_image, escaped_down, .. } = *tally;
            let Self { absorbed, taken, trapped, backface, first_hit_wall, .. } = *tally;
            let up = [incident, up_single, up_multi, outside_image, escaped_down];
            (up, [absorbed, taken, trapped, backface, first_hit_wall])
        };
        fates(self) == fates(other) && self.image == other.image && self.rim == other.rim
    }

    /// Nothing yet, for an image of `width` × `height` pixels.
    pub fn empty((width, height): (usize, usize)) -> Self {
        Self {
            incident: 0.0,
            rays: 0,
            up_single: 0.0,
            up_multi: 0.0,
            outside_image: 0.0,
            escaped_down: 0.0,
            absorbed: 0.0,
            taken: 0.0,
            trapped: 0.0,
            backface: 0.0,
            first_hit_wall: 0.0,
            image: Raster::zeros(width, height),
            rim: None,
        }
    }

    fn size(&self) -> (usize, usize) {
        (self.image.width, self.image.height)
    }

    /// Counts the end of light of `weight`; `pixel` is where it fell on the image, if it did.
    #[inline]
    pub fn count(&mut self, end: &End, weight: f64, pixel: Option<usize>) {
        let left = weight * end.weight;
        self.taken += weight - left;
        match end.fate {
            Fate::Up => {
                *(if end.bounces == 1 { &mut self.up_single } else { &mut self.up_multi }) += left;
                match pixel {
                    Some(pixel) => self.image.values[pixel] += left,
                    None => self.outside_image += left,
                }
            }
            Fate::Down => self.escaped_down += left,
            Fate::Taken => {}
            Fate::Outer => self.absorbed += left,
            Fate::Trapped => self.trapped += left,
            Fate::Backface => self.backface += left,
        }
    }

    /// Adds `factor` times the light of another, 1 or -1.
    pub(super) fn add(&mut self, other: &Self, factor: f64) {
        self.incident += factor * other.incident;
        self.rays = self.rays.wrapping_add_signed(factor as i64 * other.rays as i64);
        self.up_single += factor * other.up_single;
        self.up_multi += factor * other.up_multi;
        self.outside_image += factor * other.outside_image;
        self.escaped_down += factor * other.escaped_down;
        self.absorbed += factor * other.absorbed;
        self.taken += factor * other.taken;
        self.trapped += factor * other.trapped;
        self.backface += factor * other.backface;
        self.first_hit_wall += factor * other.first_hit_wall;
        add(&mut self.image, &other.image, factor);
        if let Some(more) = &other.rim {
            add(self.rim.get_or_insert_with(|| Raster::zeros(more.width, more.height)), more, factor);
        }
    }

    /// Half of all light, of as many rays.
    fn halve(&mut self) {
        let figures = [
            &mut self.incident,
            &mut self.up_single,
            &mut self.up_multi,
            &mut self.outside_image,
            &mut self.escaped_down,
            &mut self.absorbed,
            &mut self.taken,
            &mut self.trapped,
            &mut self.backface,
            &mut self.first_hit_wall,
        ];
        let rim = self.rim.iter_mut().flat_map(|rim| &mut rim.values);
        figures.into_iter().chain(&mut self.image.values).chain(rim).for_each(|light| *light *= 0.5);
    }

    /// Share of incident light that leaves upward.
    pub fn up(&self) -> f64 {
        (self.up_single + self.up_multi) / self.incident
    }

    /// Share of upward light that bounced more than once.
    pub fn multi_bounce(&self) -> f64 {
        self.up_multi / (self.up_single + self.up_multi).max(f64::MIN_POSITIVE)
    }

    /// Share of incident light that does not leave upward.
    pub fn blocked(&self) -> f64 {
        1.0 - self.up()
    }

    /// All ends of light as a share of what came in: 1 unless the accounting leaks.
    pub fn balance(&self) -> f64 {
        let ends = self.escaped_down + self.absorbed + self.taken + self.trapped + self.backface;
        self.up() + ends / self.incident
    }

    /// The image as shares of upward light: with light outside it, the pixels sum to less than 1.
    pub fn share_image(&self) -> Raster {
        let up = (self.up_single + self.up_multi).max(f64::MIN_POSITIVE);
        self.image.clone().scaled(1.0 / up)
    }

    /// The same with the light of a polished rim over it, still as shares of what the optical area sends upward: the
    /// pixels may sum to more than 1.
    pub fn lit_image(&self) -> Raster {
        let mut image = self.share_image();
        if let Some(rim) = &self.rim {
            add(&mut image, rim, 1.0 / (self.up_single + self.up_multi).max(f64::MIN_POSITIVE));
        }
        image
    }
}

/// Adds `factor` times another raster of the same size.
fn add(sum: &mut Raster, more: &Raster, factor: f64) {
    sum.values.iter_mut().zip(&more.values).for_each(|(sum, v)| *sum += factor * v);
}

/// A measurement in parts, so that every figure drawn from it has an error.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// All light.
    pub whole: Tally,
    parts: Vec<Tally>,
}

/// Parts of a measurement, each an interleaved share of its rays.
pub(crate) const PARTS: usize = 16;

/// What a measurement on `pixels` pixels takes, bytes: each part and their whole have an image, and what is drawn from
/// them has two more.
pub fn bytes(pixels: usize) -> f64 {
    (8 * (PARTS + 4)) as f64 * pixels as f64
}

impl Measurement {
    /// From [`PARTS`] tallies; fails if no light came in.
    pub(crate) fn of_parts(parts: Vec<Tally>) -> Result<Self, MeasureError> {
        let mut whole = Tally::empty(parts.first().ok_or(MeasureError::NoLight)?.size());
        parts.iter().for_each(|part| whole.add(part, 1.0));
        // Where closed forms gave light and rays took all of it back, rounding stays: far less than any ray, of either sign.
        let rounding = 1e-13 * whole.incident;
        whole.image.values.iter_mut().filter(|light| light.abs() < rounding).for_each(|light| *light = 0.0);
        if whole.incident > 0.0 { Ok(Self { whole, parts }) } else { Err(MeasureError::NoLight) }
    }

    /// Takes in another measurement of the same by as many rays, made with other random numbers: of the light the mean,
    /// so that mm² of light stay what one of them would have, and of rays the sum.
    pub(crate) fn merge(&mut self, other: &Self) {
        let mean = |tally: &mut Tally, more: &Tally| {
            tally.add(more, 1.0);
            tally.halve();
        };
        mean(&mut self.whole, &other.whole);
        self.parts.iter_mut().zip(&other.parts).for_each(|(part, more)| mean(part, more));
    }

    /// The same with another view of every tally.
    pub(super) fn mapped(&self, view: impl Fn(&Tally) -> Tally) -> Self {
        Self { whole: view(&self.whole), parts: self.parts.iter().map(&view).collect() }
    }

    /// Its tallies.
    pub(super) fn into_parts(self) -> Vec<Tally> {
        self.parts
    }

    /// The same with the light of a rim over its image, part by part; `rim` is as this would be of the rim alone.
    pub(super) fn with_rim(mut self, rim: &[Tally]) -> Self {
        for (part, rim) in self.parts.iter_mut().zip(rim) {
            part.rim = Some(rim.image.clone());
        }
        let (width, height) = self.whole.size();
        let mut all = Raster::zeros(width, height);
        rim.iter().for_each(|rim| add(&mut all, &rim.image, 1.0));
        self.whole.rim = Some(all);
        self
    }

    /// The whole without part `k`, for k below [`parts`](Self::parts).
    pub fn without(&self, k: usize) -> Tally {
        let mut rest = self.whole.clone();
        rest.add(&self.parts[k], -1.0);
        rest
    }

    /// The light of the even and of the odd parts.
    pub fn halves(&self) -> [Tally; 2] {
        [0, 1].map(|first| {
            let mut half = Tally::empty(self.whole.size());
            self.parts.iter().skip(first).step_by(2).for_each(|part| half.add(part, 1.0));
            half
        })
    }

    /// Parts that can be left out.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Whether all parts found the same light: nothing shadows a facet, none bounces again, and no figure has an error.
    pub fn is_exact(&self) -> bool {
        let [first, rest @ ..] = self.parts.as_slice() else { return true };
        rest.iter().all(|part| part.finds_as(first))
    }

    /// Standard error of each figure of `figures`, by leaving out one part after the other (Quenouille, Tukey).
    /// The parts interleave as strata of the whole do, so the estimate errs on the safe side.
    pub fn standard_errors<const N: usize>(&self, figures: impl Fn(&Tally) -> [f64; N] + Sync) -> [f64; N] {
        let n = self.parts();
        if self.is_exact() {
            return [0.0; N];
        }
        let each: Vec<[f64; N]> = (0..n).into_par_iter().map(|k| figures(&self.without(k))).collect();
        std::array::from_fn(|f| {
            let mean = each.iter().map(|e| e[f]).sum::<f64>() / n as f64;
            let squares: f64 = each.iter().map(|e| (e[f] - mean).powi(2)).sum();
            (squares * (n - 1) as f64 / n as f64).sqrt()
        })
    }

    /// Standard error of each pixel of [`Tally::share_image`], by the spread of the parts.
    pub fn pixel_errors(&self) -> Raster {
        let n = self.parts() as f64;
        let ups: Vec<f64> =
            self.parts.iter().map(|part| (part.up_single + part.up_multi).max(f64::MIN_POSITIVE)).collect();
        let mut errors = Raster::zeros(self.whole.image.width, self.whole.image.height);
        for (pixel, error) in errors.values.iter_mut().enumerate() {
            // Most pixels of most highlights are dark.
            if self.whole.image.values[pixel] == 0.0 {
                continue;
            }
            let shares = || self.parts.iter().zip(&ups).map(|(part, up)| part.image.values[pixel] / up);
            let mean = shares().sum::<f64>() / n;
            let squares: f64 = shares().map(|share| (share - mean).powi(2)).sum();
            *error = (squares / (n * (n - 1.0))).sqrt();
        }
        errors
    }

    /// The total variation that the rays' own scatter is expected to add to the unblurred image: half the sum of the
    /// pixels' mean deviations, √(2/π) of their standard errors.
    pub fn image_noise(&self) -> f64 {
        0.5 * (2.0 / std::f64::consts::PI).sqrt() * self.pixel_errors().values.iter().sum::<f64>()
    }
}

/// Why light has no measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// None falls where it is measured.
    #[error("no light falls where it is measured")]
    NoLight,
    /// The caller wanted nothing more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
