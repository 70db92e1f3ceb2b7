//! The figures of a measured highlight, each with its standard error.

use serde::Serialize;

use super::score::{BlurredTarget, contrast_kept, efficiency};
use super::tally::{MeasureError, Measurement, Tally};
use super::wasserstein::exact_w1;
use crate::progress::Progress;
use crate::projection::View;
use crate::raster::Raster;

/// Blurs at which light is compared, degrees: the sun's disc on a perfect mirror, very good polish, the lobe of polished metal,
/// a glance.
pub const BLURS: [f64; 4] = [0.27, 0.5, 1.0, 2.0];

/// The blur of the efficiency's support and of the pictures, degrees.
pub const MAIN_BLUR: f64 = 1.0;

/// Share of its contrast that a drawing must keep to be told by its scores at a blur. Measured through 1°: letters, discs,
/// faces and photographs keep 0.58 to 0.92, words and spirals 0.37 to 0.45, a QR code 0.22, a page of small text 0.02.
const STILL_DRAWN: f64 = 0.33;

/// Pixels a side at which W1 is computed exactly.
const W1_RESOLUTION: usize = 64;

/// A figure and its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figure {
    /// The value.
    pub value: f64,
    /// One standard error, from the rays' own scatter.
    pub error: f64,
}

/// The scores at one blur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtBlur {
    /// The blur, degrees.
    pub blur: f64,
    /// Total variation inside the image.
    pub tv: Figure,
    /// Total variation as a share of upward light: what misses the image counts.
    pub tv_up: Figure,
    /// Total variation as a share of incident light: what is lost counts too.
    pub tv_incident: Figure,
    /// Structural similarity.
    pub ssim: Figure,
    /// Share of the drawing's own contrast that the blur leaves, from 0 to 1; see [`contrast_kept`].
    pub kept: f64,
}

/// What is said of a measured highlight.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Scores at each of [`BLURS`].
    pub at_blur: [AtBlur; BLURS.len()],
    /// Exact Wasserstein distance between the drawn and the measured light, degrees.
    pub w1: Figure,
    /// Share of incident light that lands where the drawing is lit.
    pub efficiency: Figure,
    /// Share of upward light that bounced more than once.
    pub multi_bounce: Figure,
    /// Share of incident light that never leaves upward.
    pub blocked: Figure,
    /// Share of incident light that left upward but beyond the image.
    pub outside_image: f64,
    /// Share of incident light that met a wall first.
    pub first_hit_wall: f64,
    /// Share of incident light that met a face from behind: above 1e-4 the mesh leaks.
    pub backface: f64,
    /// Rays that came in.
    pub rays: u64,
}

const FIGURES: usize = 4 * BLURS.len() + 3;

impl Verdict {
    /// Scores `measurement` against `target` (flux per pixel, sum 1, of the measurement's resolution).
    ///
    /// Fails if no light fell into the image.
    pub fn new(
        measurement: &Measurement,
        target: &Raster,
        view: &View,
        progress: &Progress,
    ) -> Result<Self, MeasureError> {
        let wanted = Wanted::new(target, view).ok_or(MeasureError::NoLight)?;
        let values = wanted.figures(&measurement.whole).ok_or(MeasureError::NoLight)?;
        let errors = measurement.standard_errors(|tally| {
            let figures = if progress.is_abandoned() { None } else { wanted.figures(tally) };
            figures.unwrap_or([f64::NAN; FIGURES])
        });
        progress.check()?;
        progress.fraction(0.5);
        let figure = |k: usize| Figure { value: values[k], error: errors[k] };
        let at_blur = std::array::from_fn(|b| AtBlur {
            blur: BLURS[b],
            tv: figure(4 * b),
            tv_up: figure(4 * b + 1),
            tv_incident: figure(4 * b + 2),
            ssim: figure(4 * b + 3),
            kept: contrast_kept(target, view, BLURS[b].to_radians()),
        });
        let whole = &measurement.whole;
        let other = 4 * BLURS.len();
        Ok(Self {
            at_blur,
            w1: w1(measurement, target, view, progress)?,
            efficiency: figure(other),
            multi_bounce: figure(other + 1),
            blocked: figure(other + 2),
            outside_image: whole.outside_image / whole.incident,
            first_hit_wall: whole.first_hit_wall / whole.incident,
            backface: whole.backface / whole.incident,
            rays: whole.rays,
        })
    }

    /// The scores at the main blur.
    pub fn main(&self) -> &AtBlur {
        self.at(MAIN_BLUR)
    }

    /// The scores at one of [`BLURS`], else at the finest.
    pub fn at(&self, blur: f64) -> &AtBlur {
        self.at_blur.iter().find(|scores| scores.blur == blur).unwrap_or(&self.at_blur[0])
    }

    /// The scores to judge by: at the main blur, or at the widest blur below it that the drawing's own detail outlives.
    pub fn decisive(&self) -> &AtBlur {
        let below = self.at_blur.iter().rev().skip_while(|scores| scores.blur > MAIN_BLUR);
        below.into_iter().find(|scores| scores.kept >= STILL_DRAWN).unwrap_or(&self.at_blur[0])
    }

    /// Whether the main blur wipes out the drawing's own detail, so that scores at it say little.
    pub fn blurs_the_drawing_away(&self) -> bool {
        self.main().kept < STILL_DRAWN
    }
}

/// What is wanted, looked at once for all the tallies that are marked beside it.
struct Wanted<'a> {
    target: &'a Raster,
    view: &'a View,
    at_blur: Vec<BlurredTarget>,
}

impl<'a> Wanted<'a> {
    fn new(target: &'a Raster, view: &'a View) -> Option<Self> {
        let at_blur =
            BLURS.iter().map(|blur| BlurredTarget::new(target, view, blur.to_radians())).collect::<Option<_>>()?;
        Some(Self { target, view, at_blur })
    }

    /// All figures that follow from one tally by quick arithmetic, in [`Verdict::new`]'s order.
    fn figures(&self, tally: &Tally) -> Option<[f64; FIGURES]> {
        let Self { target, view, ref at_blur } = *self;
        let (image, up) = (tally.share_image(), tally.up());
        let lit = tally.lit_image();
        if (lit.width, lit.height) != (target.width, target.height) {
            return None;
        }
        let mut values = [0.0; FIGURES];
        for (b, wanted) in at_blur.iter().enumerate() {
            let scores = wanted.scores(&lit, up)?;
            values[4 * b..4 * b + 4].copy_from_slice(&[scores.tv, scores.tv_up, scores.tv_incident, scores.ssim]);
        }
        let efficiency = efficiency(&image, up, target, view, MAIN_BLUR.to_radians());
        values[4 * BLURS.len()..].copy_from_slice(&[efficiency, tally.multi_bounce(), tally.blocked()]);
        Some(values)
    }
}

/// W1 of the whole; its error from the two halves, whose difference is twice the whole's standard error on average.
fn w1(measurement: &Measurement, target: &Raster, view: &View, progress: &Progress) -> Result<Figure, MeasureError> {
    let of = |tally: &Tally| exact_w1(&tally.lit_image(), target, view, W1_RESOLUTION, progress);
    if measurement.is_exact() {
        return Ok(Figure { value: of(&measurement.whole)?, error: 0.0 });
    }
    let (value, halves) = rayon::join(|| of(&measurement.whole), || measurement.halves().map(|half| of(&half)));
    let error = match halves {
        [Ok(a), Ok(b)] => 0.5 * (a - b).abs(),
        _ => f64::NAN,
    };
    Ok(Figure { value: value?, error })
}
