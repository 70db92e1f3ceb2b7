//! Why hardly any light of a plate is where it is wanted.

use facetmill::highlight::scored_target;
use facetmill::job::findings::Proof;
use facetmill::picture::Picture;
use facetmill::recipe::Recipe;
use facetmill::setup::Setup;
use facetmill::verify::score::blurred_scores;
use facetmill::verify::verdict::MAIN_BLUR;

use crate::tables::percent;

/// A turned or mirrored drawing explains it if it leaves this share of what is misplaced.
const EXPLAINED: f64 = 0.3;

/// What may be wrong where hardly any light is where it is wanted: a drawing that is turned or mirrored, or anything.
pub fn astray(misplaced: f64, proof: &Proof, recipe: &Recipe, (picture, setup): (&Picture, &Setup)) -> String {
    let whole = &proof.measurement.whole;
    let turned = |quarters: usize, mirrored: bool| {
        let mut light = picture.light.clone();
        let n = light.width;
        if mirrored {
            light.values.chunks_exact_mut(n).for_each(<[f64]>::reverse);
        }
        for _ in 0..quarters {
            let before = light.clone();
            for (k, value) in light.values.iter_mut().enumerate() {
                *value = before.at(n - 1 - k / n, k % n);
            }
        }
        let target = scored_target(&light, recipe.highlight.quantity, setup, whole.image.width);
        let scores = blurred_scores(&whole.share_image(), whole.up(), &target, setup.view(), MAIN_BLUR.to_radians());
        scores.map_or(1.0, |scores| scores.tv_incident)
    };
    let ways = (0..8).map(|k| (k % 4, k > 3)).skip(1);
    let best = ways.map(|way| (turned(way.0, way.1), way)).min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((left, (quarters, mirrored))) if left < EXPLAINED * misplaced => {
            let how = match (quarters, mirrored) {
                (0, true) => "mirrored (--seen says from which side)".to_owned(),
                (quarters, true) => format!("mirrored and turned by {}° (--seen, --rotate)", 90 * quarters),
                (quarters, false) => format!("turned by {}° (--rotate)", 90 * quarters),
            };
            format!(
                "{} of the light is misplaced, but only {} if the drawing is {how}.",
                percent(misplaced),
                percent(left)
            )
        }
        _ => format!(
            "{} of the light is misplaced: plate, picture, light and field may not belong together; look at --light, \
             --half-field, --projection, --unit, and which side is up.",
            percent(misplaced)
        ),
    }
}
