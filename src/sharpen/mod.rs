//! The wanted light made sharper by as much as lamp and metal will blur it.
//!
//! The drawing is what shall be seen. A lamp with an extent and the lobe of the base metal blur what the mirrors send;
//! both are known, so the mirrors are asked for the drawing deconvolved by them: a step that Weyrich et al. 2009 name and
//! skip. The method is that of Richardson (*J. Opt. Soc. Am.* 62, 1972) and Lucy (*Astron. J.* 79, 1974), whose light is
//! never negative and in sum what it was, with the leaps of Biggs and Andrews (*Applied Optics* 36, 1997).
//!
//! What is finer than the blur stays lost: no light can be sent that is seen so. Nor is it wise to come as near as light
//! can: it then gathers in lines and spots that only the full blur melts together, and where the metal is better than was
//! said, they show. So light is sharpened against a little less than the blur. `docs/sharpening.md` has measurements.

mod blur;

mod grid;

pub use blur::BlurKernel;

use crate::progress::Progress;
use crate::raster::Raster;
use grid::{Grid, cut};

/// What sharpening is worth: shares of the light that are seen in the wrong place, the total variation between what is
/// seen and the drawing, both through a further blur of [`SCORED_AT`]. Light seen past the rim of the image counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sharpening {
    /// If the mirrors send the drawing itself.
    pub before: f64,
    /// If they send the sharpened light. Never more than before.
    pub after: f64,
    /// Steps that led there; 0 if the drawing was left as it is.
    pub steps: usize,
}

/// The blur through which light is judged, degrees: the finest at which highlights are scored.
pub const SCORED_AT: f64 = 0.5;

/// The blur through which sharpened light is to agree with the drawing, degrees. Asked to agree without one, the light
/// overshoots at edges for the sake of what nobody sees: a ring under a lamp of 1° then keeps 0.020 of the light in the
/// wrong place instead of 0.008. And a disc's own waves have zeros, which nothing can be divided by.
const AIM: f64 = 0.25;

/// The part of the blur against which light is sharpened. A photograph in metal of 1° then has TV 0.034 and SSIM 0.90 at
/// half a degree, sharpened against the whole 0.036 and 0.87, against none 0.066 and 0.80; and if the metal is one of
/// 0.7° in truth 0.048 and 0.80, against the whole 0.074 and 0.69.
const AGAINST: f64 = 0.9;

/// Steps at the most. The best is kept and all are made, since hard edges rest for some steps before they get better
/// again; twice as many would take away a twentieth of what is left.
const STEPS: usize = 40;

/// What a leap leaves at least, as a share of where its step led.
const LEAST_OF_STEP: f64 = 0.1;

/// Misplaced light that is not worth a step.
const ENOUGH: f64 = 1e-4;

/// Sharpens `flux` (light per pixel, not negative) so that through `blur` it is seen as it was, as nearly as can be.
///
/// The sum stays, dark pixels stay dark, and what is seen is never farther from the drawing than it was. Detail of the
/// drawing that is too fine for the blur is kept as it is; pixels that are too wide for it are cut into equal parts, so
/// that there may be more of them afterwards. Cancelled, it leaves the best so far.
pub fn sharpen(flux: &mut Raster, blur: &BlurKernel, progress: &Progress) -> Sharpening {
    let mut fine = cut(flux, blur);
    let grid = Grid::new(blur, &fine);
    let drawn = grid.laid_out(&fine);
    let whole: f64 = drawn.iter().sum();
    let is_lit = whole > 0.0 && whole.is_finite();
    if !is_lit {
        return Sharpening::default();
    }
    let [judge, aim] = [SCORED_AT, AIM].map(|degrees| grid.gaussian(degrees));
    let (judged, wanted) = (grid.through(&judge, &drawn), grid.through(&aim, &drawn));
    let (to_judge, to_aim) = (grid.blurred(1.0, &judge), grid.blurred(AGAINST, &aim));
    // Below this a sum of waves is rounding.
    let least = 1e-12 * wanted.iter().fold(0.0, |most: f64, light| most.max(*light));
    let mut guess = Guess::new(drawn.clone());
    let mut worth = Sharpening::default();
    let mut sharp = Vec::new();
    for k in 0..=STEPS {
        let seen = grid.through(&to_judge, &guess.light);
        let off = 0.5 * seen.iter().zip(&judged).map(|(seen, drawn)| (seen - drawn).abs()).sum::<f64>() / whole;
        if k == 0 {
            worth.before = off;
        }
        if k == 0 || off < worth.after {
            (worth.after, worth.steps) = (off, k);
            sharp.clone_from(&guess.light);
        }
        if off <= ENOUGH || k == STEPS || progress.is_to_finish() {
            break;
        }
        progress.fraction(k as f64 / STEPS as f64);
        // x ← x Hᵀ(y / H x); blurs are even, so that H is its own transpose.
        let mut ratio = grid.through(&to_aim, &guess.light);
        ratio.iter_mut().zip(&wanted).for_each(|(ratio, wanted)| *ratio = wanted.max(0.0) / ratio.max(least));
        guess.multiply(&grid.through(&to_aim, &ratio));
    }
    if worth.steps > 0 {
        grid.carry_over(&mut fine, &drawn, &sharp);
        *flux = fine;
    }
    worth
}

/// `sent` (light per pixel) as it is seen through `blur`; light past the rim of the image is gone.
pub fn seen(sent: &Raster, blur: &BlurKernel) -> Raster {
    let fine = cut(sent, blur);
    let grid = Grid::new(blur, &fine);
    let light = grid.through(&grid.blurred(1.0, &[]), &grid.laid_out(&fine));
    grid.picture(&light, &fine).resampled(sent.width, sent.height)
}

/// Light that is brought to agree step by step, and leaps as far ahead as its last two steps were alike.
struct Guess {
    light: Vec<f64>,
    /// Where the last step led, before its leap.
    landed: Vec<f64>,
    step: Vec<f64>,
}

impl Guess {
    fn new(light: Vec<f64>) -> Self {
        Self { landed: light.clone(), step: vec![0.0; light.len()], light }
    }

    fn multiply(&mut self, ratio: &[f64]) {
        let landed: Vec<f64> = self.light.iter().zip(ratio).map(|(light, ratio)| light * ratio.max(0.0)).collect();
        let step: Vec<f64> = landed.iter().zip(&self.light).map(|(to, from)| to - from).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let before = dot(&self.step, &self.step);
        let leap = if before > 0.0 { (dot(&step, &self.step) / before).clamp(0.0, 1.0) } else { 0.0 };
        for ((light, to), from) in self.light.iter_mut().zip(&landed).zip(&self.landed) {
            // A pixel put out would stay dark.
            *light = (to + leap * (to - from)).max(LEAST_OF_STEP * to);
        }
        (self.landed, self.step) = (landed, step);
    }
}

#[cfg(test)]
mod tests;
