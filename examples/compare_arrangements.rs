//! The same facets in three orders: `cargo run --release --example compare_arrangements [PICTURE]`.
//!
//! Which slopes a plate has decides its highlight; which slope goes where decides its walls, valleys and second
//! bounces. A_v is the area of all vertical walls over the plate's area, V the number of concave neighbour pairs
//! (Weyrich et al. 2009), both over the cyclic grid for `anneal` and over inner pairs for the others.

use std::error::Error;
use std::path::PathBuf;

use facetmill::job::design::design;
use facetmill::job::proof::prove;
use facetmill::picture;
use facetmill::progress::Progress;
use facetmill::recipe::{Arrangement, Recipe};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("examples/highlights/ring.png"), PathBuf::from);
    let mut recipe = Recipe::default();
    recipe.verify.rays = 500_000;
    let picture = picture::read(&path, &recipe.reading())?;

    println!(
        "{:10} {:>12} {:>7} {:>6} {:>9} {:>14} {:>8}",
        "", "step, pitch", "A_v", "V", "relief", "bounced twice", "TV(1°)"
    );
    for arrange in [Arrangement::Random, Arrangement::Anneal, Arrangement::Transport] {
        recipe.design.arrange = Some(arrange);
        let plate = design(&recipe, &picture.light, &Progress::silent())?;
        let proof = prove(&recipe, &picture.light, &plate, &Progress::silent())?;
        let (low, high) = plate.relief.height_range();
        let steps = plate.facets.as_ref().map(|facets| facets.steps).unwrap_or_default();
        let valleys = if recipe.heights().is_cyclic() { steps.valleys } else { steps.inner_valleys };
        println!(
            "{:10} {:>12.4} {:>7.4} {:>6} {:>6.2} mm {:>12.2} % {:>8.4}",
            format!("{arrange:?}").to_lowercase(),
            steps.rms / recipe.pitch().min_element(),
            steps.wall_area_ratio,
            valleys,
            high - low,
            100.0 * proof.verdict.multi_bounce.value,
            proof.verdict.main().tv_incident.value,
        );
    }
    Ok(())
}
