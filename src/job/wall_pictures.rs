//! The pictures of a proof on a wall: in millimetres, sharp, as an eye sees them, and through a blur of 0.5°.

use image::RgbImage;

use super::findings::{WallLight, WallProof};
use super::scene_facts::in_words;
use crate::export::comparison::{Comparison, ComparisonPage};
use crate::projection::View;
use crate::raster::Raster;
use crate::verify::score::blurred;
use crate::verify::thrown::cropped;
use crate::verify::wall_verdict::{AtWallBlur, WALL_BLURS};

/// The page that shows the drawing beside `light` on the wall, as someone in front of it sees both; `how` says of which
/// plate it is, `footer` what plate that is.
pub(super) fn wall_page(wall: &WallProof, light: &WallLight, view: &View, how: &str, footer: &str) -> RgbImage {
    let WallProof { scene, eye_distance, target, .. } = wall;
    let facing =
        |raster: &Raster| Raster::from_fn(raster.width, raster.height, |x, y| raster.at(raster.width - 1 - x, y));
    let (drawn, thrown) = (facing(target), facing(&cropped(&light.thrown.whole.lit_image())));
    let angle = |at: &AtWallBlur| (at.mm / scene.wall_distance()).atan();
    let titled = |what: &str| ["Target", "On the wall", "Difference"].map(|title| format!("{title}{what}"));
    let figures = |at: &AtWallBlur| format!("TV {:.4}   SSIM {:.3}", at.tv.value, at.ssim.value);
    let row = |at: &AtWallBlur, what: String, seen: String| Comparison {
        target: blurred(&drawn, view, angle(at)),
        simulated: blurred(&thrown, view, angle(at)),
        titles: titled(&what),
        numbers: [seen, how.to_owned(), figures(at)],
    };
    let (eye, half_degree) = (&light.verdict.eye, &light.verdict.at[0]);
    let sharp = Comparison {
        target: drawn.clone(),
        simulated: thrown.clone(),
        titles: titled(", sharp"),
        numbers: ["as drawn".into(), how.to_owned(), format!("grain {:.1} %", 100.0 * light.verdict.grain.value)],
    };
    let seen = row(eye, format!(", blurred by {:.1} mm", eye.mm), format!("an eye {:.1} m away", 1e-3 * eye_distance));
    let wide = format!(", blurred by {}°, {:.1} mm", WALL_BLURS[0], half_degree.mm);
    let far = row(half_degree, wide, "a glance, or polished metal".into());
    let footer = format!("{}\n{footer}", in_words(scene).join("   ·   "));
    let on_wall = scene.wall().map(|wall| wall.half);
    ComparisonPage { rows: &[sharp, seen, far], view, on_wall, heading: "", footer: &footer }.picture()
}
