//! Light over any STL, whoever made it, against a drawing:
//!
//!     cargo run --release --example prove_any_stl -- plate.stl examples/highlights/ring.png

use std::error::Error;
use std::fs::File;
use std::path::PathBuf;

use facetmill::export::stl::read_stl;
use facetmill::highlight::scored_target;
use facetmill::picture::read;
use facetmill::progress::Progress;
use facetmill::recipe::Recipe;
use facetmill::trace::traced_plate::TracedPlate;
use facetmill::verify::experiment::Measuring;
use facetmill::verify::measure::Mirrored;
use facetmill::verify::verdict::Verdict;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let stl = arguments.next().ok_or("name an STL file, in mm, its relief toward +z")?;
    let drawing = arguments.next().ok_or("name the drawing that its reflection should be")?;
    // Lamp, field and meaning of the drawing; all defaults: light from straight above, 20° from the middle to the rim.
    let recipe = Recipe::default();
    let setup = recipe.setup();
    let mesh = read_stl(&mut File::open(&stl)?)?;
    let plate = TracedPlate::new(&mesh, 0.0, &Progress::silent())?;
    println!("{} triangles, traced as {}", mesh.triangles.len(), plate.kind());

    let (metal, measuring, progress) = (recipe.metal(), Measuring::default(), Progress::silent());
    let mirrored = Mirrored { setup: &setup, metal: &metal, measuring: &measuring, progress: &progress };
    let measurement = plate.run(mirrored)?;
    let light = read(&drawing, &recipe.reading())?.light;
    let target = scored_target(&light, recipe.highlight.quantity, &setup, measuring.resolution);
    let verdict = Verdict::new(&measurement, &target, setup.view(), &progress)?;
    let main = verdict.main();
    println!("TV(1°)     {:.4} ± {:.4}", main.tv_incident.value, main.tv_incident.error);
    println!("SSIM(1°)   {:.3}", main.ssim.value);
    println!("W1         {:.3}°", verdict.w1.value);
    println!("efficiency {:.1} %", 100.0 * verdict.efficiency.value);
    Ok(())
}
