//! One plate under many lamps: `cargo run --release --example light_sweep [PICTURE]`.
//!
//! The plate is designed for a lamp overhead, then traced as the lamp goes down toward +y. The highlight stays about
//! the mirror direction, but a plate is right for one lamp only: the figures say how fast it goes wrong, beside those
//! of a plate designed for each lamp.

use std::error::Error;
use std::path::PathBuf;

use facetmill::highlight::scored_target;
use facetmill::job::design::design;
use facetmill::job::proof::prove;
use facetmill::picture;
use facetmill::progress::Progress;
use facetmill::projection::Projection;
use facetmill::recipe::Recipe;
use facetmill::trace::grid::GridSurface;
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::measure::measure;
use facetmill::verify::verdict::Verdict;

fn main() -> Result<(), Box<dyn Error>> {
    let path =
        std::env::args_os().nth(1).map_or_else(|| PathBuf::from("examples/highlights/letter.png"), PathBuf::from);
    let silent = Progress::silent();
    let measuring = Measuring { rays: 500_000, ..Measuring::default() };
    let mut recipe = Recipe::default();
    recipe.plate.facets = Some([30, 30]);
    recipe.highlight.half_field = 15.0.into();
    recipe.highlight.projection = Projection::Equidistant;
    recipe.light.phi = 90.0;
    recipe.verify.rays = measuring.rays;
    let picture = picture::read(&path, &recipe.reading())?;
    let overhead = GridSurface::new(&design(&recipe, &picture.light, &silent)?.relief, &silent)?;

    println!("  lamp    plate for a lamp overhead     plate for this lamp");
    for theta in [0.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0] {
        recipe.light.theta = theta;
        let setup = recipe.setup();
        let seen = measure(&Experiment::new(&overhead, &setup), &measuring, &silent)?;
        let target = scored_target(&picture.light, recipe.highlight.quantity, &setup, measuring.resolution);
        let kept = Verdict::new(&seen, &target, setup.view(), &silent)?;
        let own = prove(&recipe, &picture.light, &design(&recipe, &picture.light, &silent)?, &silent)?.verdict;
        print!("{theta:5}°");
        for verdict in [&kept, &own] {
            let main = verdict.main();
            print!("   TV(1°) {:.3}  W1 {:.2}° ", main.tv_incident.value, verdict.w1.value);
        }
        println!();
    }
    Ok(())
}
