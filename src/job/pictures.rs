//! The pictures of a proof, the way the user drew.

use image::{GrayImage, RgbImage};

use crate::export::comparison::{Captions, ComparisonPage};
use crate::export::pixels::{common_white, tone_mapped};
use crate::job::proof::Proof;
use crate::projection::View;
use crate::raster::Raster;
use crate::recipe::{Recipe, Seen};
use crate::verify::score::blurred;
use crate::verify::verdict::{MAIN_BLUR, Verdict};

/// `raster` the way the user drew: a picture seen on a wall was mirrored on its way in.
fn as_drawn(raster: &Raster, recipe: &Recipe) -> Raster {
    match recipe.highlight.seen {
        Seen::FromAbove => raster.clone(),
        Seen::OnWall => Raster::from_fn(raster.width, raster.height, |x, y| raster.at(raster.width - 1 - x, y)),
    }
}

/// `raster` through the main blur, the way the user drew.
pub fn as_seen(raster: &Raster, recipe: &Recipe, view: &View) -> Raster {
    as_drawn(&blurred(raster, view, MAIN_BLUR.to_radians()), recipe)
}

/// `target.png`: what was asked for.
pub fn target_picture(target: &Raster, recipe: &Recipe) -> GrayImage {
    let drawn = as_drawn(target, recipe);
    tone_mapped(&drawn, common_white(&drawn))
}

/// The pictures of a proof, all seen through the main blur.
pub struct ProofPictures {
    /// `simulated.png`: what the light did.
    pub simulated: GrayImage,
    /// `comparison.png`: that beside what was asked for.
    pub comparison: RgbImage,
    /// `comparison_milled.png`: the same of the plate as its cutter leaves it, if there is a cutter or polish.
    pub milled: Option<RgbImage>,
}

impl ProofPictures {
    /// Of `proof`, laid out by `view`; `footer` stands under the pages.
    pub fn new(proof: &Proof, recipe: &Recipe, view: &View, footer: &str) -> Self {
        let see = |raster: &Raster| as_seen(raster, recipe, view);
        let (target, simulated) = (see(&proof.target), see(&proof.measurement.whole.lit_image()));
        let compare = |simulated: &Raster, verdict: &Verdict, how: &str| {
            let captions = captions(verdict, how, footer);
            let blur = MAIN_BLUR.to_radians();
            ComparisonPage { target: &target, simulated, view, blur, captions: &captions }.picture()
        };
        let milled = proof.milled.as_ref().map(|milled| {
            let how = recipe.design.sheet.cutter.map_or("polished, ".into(), |cutter| format!("cut by {cutter}, "));
            compare(&see(&milled.measurement.whole.lit_image()), &milled.verdict, &how)
        });
        Self {
            comparison: compare(&simulated, &proof.verdict, ""),
            simulated: tone_mapped(&simulated, common_white(&target)),
            milled,
        }
    }
}

fn captions(verdict: &Verdict, how: &str, footer: &str) -> Captions {
    let main = verdict.main();
    Captions {
        numbers: [
            format!("as drawn, blurred by {MAIN_BLUR}°"),
            format!("{how}{} rays, blurred by {MAIN_BLUR}°", rays(verdict.rays)),
            format!(
                "TV({MAIN_BLUR}°) {:.4}   SSIM {:.3}   W1 {:.2}°",
                main.tv_incident.value, main.ssim.value, verdict.w1.value
            ),
        ],
        footer: footer.to_owned(),
        ..Captions::default()
    }
}

/// How many rays, for people.
pub fn rays(number: u64) -> String {
    if number < 1_000_000 { number.to_string() } else { format!("{:.1} million", number as f64 / 1e6) }
}
