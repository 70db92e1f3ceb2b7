//! What a person sees of a design: the plate itself, a ball that wears its relief, and the reflection on a wall.
//!
//!     cargo run --release --example look_and_wall -- examples/highlights/ring.png /tmp/views

use std::error::Error;
use std::path::PathBuf;

use facetmill::export::pixels::encode_png;
use facetmill::export::rendered_view::{Exposure, view_page, wall_page};
use facetmill::job::design::design;
use facetmill::lamp::{Extent, Lamp};
use facetmill::picture::read;
use facetmill::progress::Progress;
use facetmill::recipe::Recipe;
use facetmill::trace::grid::GridSurface;
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::render::{Shape, ViewSettings, render};
use facetmill::verify::wall::{WallSettings, wall_image};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let picture = arguments.next().unwrap_or_else(|| "examples/highlights/ring.png".into());
    let folder = arguments.next().unwrap_or_else(|| "views".into());
    std::fs::create_dir_all(&folder)?;
    let mut recipe = Recipe::default();
    // Many small cells: the eye takes them for one surface, and each holds the whole highlight.
    recipe.plate.facets = Some([120, 120]);
    recipe.plate.cells = Some(4.into());
    recipe.light.theta = 30.0;
    recipe.light.phi = 90.0;
    let light = read(&picture, &recipe.reading())?.light;
    let plate = design(&recipe, &light, &Progress::silent())?;
    let setup = recipe.setup();
    let save = |name: &str, page: &image::RgbImage| -> Result<(), Box<dyn Error>> {
        Ok(std::fs::write(folder.join(name), encode_png(page)?)?)
    };

    // A lamp of 10 mm radius and a wall, both a metre away.
    let surface = GridSurface::new(&plate.relief, &Progress::silent())?;
    let mirror = Experiment::new(&surface, &setup);
    let settings = WallSettings { half_width: 450.0, ..WallSettings::default() };
    let image =
        wall_image(&mirror.clone().under_ball(1000.0, 10.0), &settings, &Measuring::default(), &Progress::silent())?;
    let exposure = Exposure { mirrored: true, heading: "WallImage on a wall".into(), ..Exposure::default() };
    save("wall.png", &wall_page(&image, &settings, &exposure))?;

    // The plate in a hand, under a lamp of 3° radius, in a room with a little light of its own.
    let material: facetmill::brdf::material::Material = "aluminium:ggx:0.03".parse()?;
    let lamp: Lamp = setup.lamp().with_extent(Extent::round(f64::to_radians(3.0))).into();
    let finished = Experiment { material: material.clone(), lamp: lamp.clone(), ..mirror };
    let settings = ViewSettings {
        theta: 22.0,
        phi: 270.0,
        distance: 300.0,
        field_of_view: 7.0,
        ambient: 0.05,
        ..ViewSettings::default()
    };
    let view = render(&finished, &settings, &Progress::silent())?;
    save("plate.png", &view_page(&view, &settings, &Exposure { heading: "The plate".into(), ..Exposure::default() }))?;

    // A ball and a cylinder whose whole surface has that relief, too fine to see.
    let panel = GridSurface::panel(&plate.relief, &Progress::silent())?;
    let worn = Experiment { surface: &panel, setup: &setup, material, lamp };
    let shapes = [("ball.png", Shape::Sphere { radius: 40.0 }), ("cylinder.png", Shape::Cylinder { radius: 40.0 })];
    for (name, shape) in shapes {
        let settings = ViewSettings {
            shape,
            distance: 500.0,
            field_of_view: 11.0,
            ambient: 0.02,
            theta: 30.0,
            phi: 270.0,
            ..ViewSettings::default()
        };
        let view = render(&worn, &settings, &Progress::silent())?;
        save(name, &view_page(&view, &settings, &Exposure::default()))?;
    }
    Ok(())
}
