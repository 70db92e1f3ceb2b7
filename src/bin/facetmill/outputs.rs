//! The pictures that design and verify both write.

use facetmill::export::comparison::{Captions, ComparisonPage};
use facetmill::export::pixels::{common_white, encode_png, tone_mapped};
use facetmill::projection::View;
use facetmill::raster::Raster;
use facetmill::recipe::proof::Proof;
use facetmill::recipe::{Recipe, Seen};
use facetmill::verify::score::blurred;
use facetmill::verify::verdict::{MAIN_BLUR, Verdict};

use crate::console::{Failure, rays};
use crate::files::Staged;

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

/// Writes `target.png`: what was asked for.
pub fn write_target(staged: &mut Staged, target: &Raster, recipe: &Recipe) -> Result<(), Failure> {
    let drawn = as_drawn(target, recipe);
    write_png(staged, "target.png", &tone_mapped(&drawn, common_white(&drawn)))
}

/// Writes `simulated.png` and `comparison.png`, and `comparison_milled.png` if there is a cutter or polish, all seen through
/// the main blur.
pub fn write_proof(
    staged: &mut Staged,
    proof: &Proof,
    recipe: &Recipe,
    view: &View,
    footer: &str,
) -> Result<(), Failure> {
    let see = |raster: &Raster| as_seen(raster, recipe, view);
    let (target, simulated) = (see(&proof.target), see(&proof.measurement.whole.share_image()));
    write_png(staged, "simulated.png", &tone_mapped(&simulated, common_white(&target)))?;
    let compare = |simulated: &Raster, verdict: &Verdict, how: &str| {
        let captions = captions(verdict, how, footer);
        let blur = MAIN_BLUR.to_radians();
        ComparisonPage { target: &target, simulated, view, blur, captions: &captions }.picture()
    };
    write_png(staged, "comparison.png", &compare(&simulated, &proof.verdict, ""))?;
    if let Some(milled) = &proof.milled {
        let how = recipe.design.cutter.map_or("polished, ".into(), |cutter| format!("cut by {cutter}, "));
        let simulated = see(&milled.measurement.whole.share_image());
        write_png(staged, "comparison_milled.png", &compare(&simulated, &milled.verdict, &how))?;
    }
    Ok(())
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

/// Encodes and writes one picture.
pub fn write_png<P>(
    staged: &mut Staged,
    name: &'static str,
    image: &image::ImageBuffer<P, Vec<P::Subpixel>>,
) -> Result<(), Failure>
where
    P: image::PixelWithColorType,
    [P::Subpixel]: image::EncodableLayout,
{
    let bytes = encode_png(image).map_err(|error| Failure::Impossible(format!("{name} cannot be encoded: {error}")))?;
    Ok(staged.write_bytes(name, &bytes)?)
}
