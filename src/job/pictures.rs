//! The pictures of a proof, the way the user drew.

use image::{GrayImage, RgbImage};

use crate::export::comparison::{Comparison, ComparisonPage};
use crate::export::pixels::{common_white, tone_mapped};
use crate::job::findings::Proof;
use crate::job::wall_pictures::wall_page;
use crate::milling::polish::in_words;
use crate::progress::{Cancelled, Progress};
use crate::projection::View;
use crate::raster::Raster;
use crate::recipe::{Recipe, Seen};
use crate::verify::score::blurred;
use crate::verify::verdict::{BLURS, MAIN_BLUR, Verdict};

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

/// The pictures of a proof.
pub struct ProofPictures {
    /// `simulated.png`: what the light did, as sharp as it was traced.
    pub simulated: GrayImage,
    /// `comparison.png`: that beside what was asked for, sharp and through the main blur.
    pub comparison: RgbImage,
    /// `comparison_milled.png`: the same of the plate as its cutter leaves it, if there is a cutter or polish.
    pub milled: Option<RgbImage>,
    /// `comparison_made.png`: the same of the plate as a machine makes it, if one is named.
    pub made: Option<RgbImage>,
}

impl ProofPictures {
    /// Of `proof`, laid out by `view`; `footer` stands under the pages.
    pub fn new(
        proof: &Proof,
        recipe: &Recipe,
        view: &View,
        footer: &str,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let drawn = Drawn { view, footer, sharp: as_drawn(&proof.target, recipe) };
        let simulated = as_drawn(&proof.measurement.whole.lit_image(), recipe);
        let milled = proof.milled.as_ref().map(|milled| {
            let how = recipe.design.sheet.cutter.map_or("polished, ".into(), |cutter| format!("cut by {cutter}, "));
            let image = as_drawn(&milled.measurement.whole.lit_image(), recipe);
            drawn.beside(&image, &milled.verdict, &how)
        });
        let made = proof.made.as_ref().map(|made| {
            let polish = made.machining.polish.map_or(String::new(), |sigma| format!(", {}", in_words(Some(sigma))));
            let how = format!("by {}{polish}", made.machining.machine.name);
            match (&proof.wall, &made.on_wall) {
                (Some(wall), Some(light)) => wall_page(wall, light, view, &how, footer),
                _ => {
                    let image = as_drawn(&made.measurement.whole.lit_image(), recipe);
                    drawn.beside(&image, &made.verdict, &format!("{how}, "))
                }
            }
        });
        progress.check()?;
        let simulated_picture = tone_mapped(&simulated, common_white(&drawn.sharp));
        if let Some(wall) = &proof.wall {
            let how = recipe.design.sheet.cutter.map_or("polished".into(), |cutter| format!("cut by {cutter}"));
            return Ok(Self {
                comparison: wall_page(wall, &wall.designed, view, "", footer),
                simulated: simulated_picture,
                milled: wall.milled.as_ref().map(|light| wall_page(wall, light, view, &how, footer)).or(milled),
                made,
            });
        }
        let comparison = drawn.beside(&simulated, &proof.verdict, "");
        progress.check()?;
        Ok(Self { comparison, simulated: simulated_picture, milled, made })
    }
}

/// What was asked for, and how it is laid out.
struct Drawn<'a> {
    view: &'a View,
    footer: &'a str,
    /// The drawing, unblurred.
    sharp: Raster,
}

impl Drawn<'_> {
    /// The page that shows it beside `simulated`, which was made `how`: sharp above, through the main blur below.
    fn beside(&self, simulated: &Raster, verdict: &Verdict, how: &str) -> RgbImage {
        let (view, sharp) = (self.view, &self.sharp);
        let rays = rays(verdict.rays);
        let figures = |blur: f64| {
            let scores = verdict.at(blur);
            format!("TV({blur}°) {:.4}   SSIM({blur}°) {:.3}", scores.tv_incident.value, scores.ssim.value)
        };
        let above = Comparison {
            target: sharp.clone(),
            simulated: simulated.clone(),
            titles: ["Target", "Simulated", "Difference"].map(str::to_owned),
            numbers: ["as drawn, sharp".into(), format!("{how}{rays} rays, sharp"), figures(BLURS[0])],
        };
        let titles = above.titles.clone().map(|title| format!("{title}, blurred by {MAIN_BLUR}°"));
        let see = |raster: &Raster| blurred(raster, view, MAIN_BLUR.to_radians());
        let below = Comparison {
            target: see(sharp),
            simulated: see(simulated),
            titles,
            numbers: [
                "about what polished metal blurs".into(),
                format!("{how}{rays} rays"),
                format!("{}   W1 {:.2}°", figures(MAIN_BLUR), verdict.w1.value),
            ],
        };
        ComparisonPage { rows: &[above, below], view, on_wall: None, heading: "", footer: self.footer }.picture()
    }
}

/// How many rays, for people.
pub fn rays(number: u64) -> String {
    if number < 1_000_000 { number.to_string() } else { format!("{:.1} million", number as f64 / 1e6) }
}
