//! The pictures on top of the README: a wall in a room as drawn, lit by a plate that does not know the room, and lit by one
//! that does.
//!
//!     cargo run --release --example wall_in_a_room -- examples/highlights/photograph.png docs/images/room-photograph.png
//!
//! A plate of 30 mm, a lamp of 5 mm across half a metre away and 45° aslant, a wall a metre away; as an eye sees it 3 m from
//! the wall. Both plates are designed for the same lamp direction and the same picture, without a cutter.

use std::env;
use std::error::Error;

use facetmill::export::pixels::{common_white, tone_mapped};
use facetmill::highlight::{Quantity, scored_target};
use facetmill::image::{GrayImage, Luma, imageops};
use facetmill::job::design::design;
use facetmill::picture::{self, Picture};
use facetmill::progress::Progress;
use facetmill::raster::Raster;
use facetmill::recipe::{Recipe, SceneSettings};
use facetmill::scene::Scene;
use facetmill::setup::Setup;
use facetmill::trace::traced_plate::TracedPlate;
use facetmill::verify::experiment::Measuring;
use facetmill::verify::score::blurred;
use facetmill::verify::thrown::{ACROSS, Throwing, cropped};
use facetmill::verify::wall_verdict::eye_blur;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [drawing, out] = arguments.as_slice() else { return Err("name a picture and the file to write".into()) };
    let mut knows = Recipe::default();
    (knows.light.theta, knows.light.phi) = (45.0, 90.0);
    knows.scene.lamp_distance = Some(500.0);
    knows.scene.lamp_radius = Some(2.5);
    knows.scene.wall = Some(1000.0);
    // Nodes every 0.05 mm: a quarter of the default's triangles, and of its time.
    knows.plate.grid = Some(200);
    let knows = knows.with_implied();
    let scene = knows.scene()?.ok_or("no scene")?;
    let far = Recipe { scene: SceneSettings::default(), ..knows.clone() };
    let drawing = picture::read(drawing.as_ref(), &knows.reading())?;

    let setup = Setup::from_middle(&scene).ok_or("the wall is seen from the side")?;
    let target = scored_target(&drawing.light, Quantity::Flux, &setup, ACROSS);
    let panels = [target, on_the_wall(&far, &drawing, &scene)?, on_the_wall(&knows, &drawing, &scene)?];
    let blur = (eye_blur(3000.0) / scene.wall_distance()).atan();
    let panels = panels.map(|panel| blurred(&panel, setup.view(), blur));
    // As someone sees it who looks at the wall from where the plate is.
    let panels = panels.map(|p| Raster::from_fn(p.width, p.height, |x, y| p.at(p.width - 1 - x, y)));
    let white = common_white(&panels[0]);
    let (side, gap) = (320, 8);
    let mut page = GrayImage::from_pixel(3 * side + 2 * gap, side, Luma([255]));
    for (k, panel) in panels.iter().enumerate() {
        let panel = imageops::resize(&tone_mapped(panel, white), side, side, imageops::FilterType::Triangle);
        imageops::replace(&mut page, &panel, i64::from((side + gap) * k as u32), 0);
    }
    Ok(page.save(out)?)
}

/// The light that the plate of `recipe` throws into the picture on the wall of `scene`, as shares of the light on the plate.
fn on_the_wall(recipe: &Recipe, drawing: &Picture, scene: &Scene) -> Result<Raster, Box<dyn Error>> {
    let progress = Progress::silent();
    let plate = design(recipe, &drawing.light, &progress)?;
    let (metal, measuring) = (recipe.metal(), Measuring::default());
    let throwing = Throwing { scene, metal: &metal, measuring: &measuring, within: None, progress: &progress };
    let thrown = TracedPlate::new(&plate.mesh, 0.0, &progress)?.run(throwing).ok_or("no light meets the plate")?;
    Ok(cropped(&thrown.whole.image).scaled(1.0 / thrown.whole.incident))
}
