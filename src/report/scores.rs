//! The figures of a highlight that was measured against a drawing, values and standard errors apart.

use serde::Serialize;

use super::Named;
use crate::verify::verdict::{AtBlur, Figure, MAIN_BLUR, Verdict};

/// The figures of a [`Verdict`]; those that depend on a blur under its degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// Total variation inside the image.
    pub tv: Named,
    /// Total variation as a share of upward light.
    pub tv_up: Named,
    /// Total variation as a share of incident light.
    pub tv_incident: Named,
    /// Structural similarity.
    pub ssim: Named,
    /// Share of the drawing's own contrast that the blur leaves.
    pub contrast_kept: Named,
    /// Wasserstein distance, degrees.
    pub w1_deg: f64,
    /// Share of incident light that lands where the drawing is lit.
    pub efficiency: f64,
    /// Share of upward light that bounced more than once.
    pub multi_bounce: f64,
    /// Share of incident light that never leaves upward.
    pub blocked: f64,
    /// Share of incident light that left upward but beyond the image.
    pub outside_image: f64,
    /// Share of incident light that met a wall first.
    pub first_hit_wall: f64,
    /// Share of incident light that met a face from behind.
    pub backface: f64,
    /// Rays that came in.
    pub rays: u64,
    /// One standard error of each traced figure.
    pub error: ScoreErrors,
}

/// The standard errors of [`Scores`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoreErrors {
    /// Of the figure of that name.
    pub tv: Named,
    /// Of the figure of that name.
    pub tv_up: Named,
    /// Of the figure of that name.
    pub tv_incident: Named,
    /// Of the figure of that name.
    pub ssim: Named,
    /// Of the figure of that name.
    pub w1_deg: f64,
    /// Of the figure of that name.
    pub efficiency: f64,
    /// Of the figure of that name.
    pub multi_bounce: f64,
    /// Of the figure of that name.
    pub blocked: f64,
}

impl Scores {
    /// One of the figures that depend on a blur, at the main one: `Scores::main(&scores.ssim)`.
    pub fn main(by_blur: &Named) -> f64 {
        by_blur.get(&MAIN_BLUR.to_string()).unwrap_or(f64::NAN)
    }
}

impl From<&Verdict> for Scores {
    fn from(verdict: &Verdict) -> Self {
        let by_blur = |part: fn(Figure) -> f64, figure: fn(&AtBlur) -> Figure| -> Named {
            verdict.at_blur.iter().map(|scores| (scores.blur, part(figure(scores)))).collect()
        };
        let values = |figure| by_blur(|figure| figure.value, figure);
        let errors = |figure| by_blur(|figure| figure.error, figure);
        Self {
            tv: values(|s| s.tv),
            tv_up: values(|s| s.tv_up),
            tv_incident: values(|s| s.tv_incident),
            ssim: values(|s| s.ssim),
            contrast_kept: verdict.at_blur.iter().map(|scores| (scores.blur, scores.kept)).collect(),
            w1_deg: verdict.w1.value,
            efficiency: verdict.efficiency.value,
            multi_bounce: verdict.multi_bounce.value,
            blocked: verdict.blocked.value,
            outside_image: verdict.outside_image,
            first_hit_wall: verdict.first_hit_wall,
            backface: verdict.backface,
            rays: verdict.rays,
            error: ScoreErrors {
                tv: errors(|s| s.tv),
                tv_up: errors(|s| s.tv_up),
                tv_incident: errors(|s| s.tv_incident),
                ssim: errors(|s| s.ssim),
                w1_deg: verdict.w1.error,
                efficiency: verdict.efficiency.error,
                multi_bounce: verdict.multi_bounce.error,
                blocked: verdict.blocked.error,
            },
        }
    }
}
