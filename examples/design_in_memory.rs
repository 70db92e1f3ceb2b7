//! A highlight drawn in code becomes an STL file: `cargo run --release --example design_in_memory -- plate.stl`.
//!
//! No picture file is read and no folder is made: the library works on numbers, the caller writes what it wants.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};

use facetmill::export::stl::write_stl;
use facetmill::job::design::design;
use facetmill::job::proof::prove;
use facetmill::picture::{Reading, from_raster};
use facetmill::progress::Progress;
use facetmill::projection::View;
use facetmill::raster::Raster;
use facetmill::recipe::Recipe;

const SIDE: usize = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("name the STL file to be written")?;
    // A rosette of five petals; 1 is full brightness, values are proportional to light.
    let drawing = Raster::from_fn(SIDE, SIDE, |column, row| {
        let uv = View::pixel_centre(column, row, SIDE, SIDE);
        let petals = 0.55 + 0.3 * (5.0 * uv.to_angle()).cos();
        (20.0 * (petals - uv.length())).clamp(0.0, 1.0)
    });
    let picture = from_raster(drawing, &Reading::default())?;

    let mut recipe = Recipe::default();
    recipe.highlight.half_field = 15.0.into(); // degrees from the middle of the drawing to its rim
    recipe.plate.size = [40.0, 40.0]; // mm
    recipe.plate.facets = Some([40, 40]);
    recipe.plate.border = 3.0; // mm

    let silent = Progress::silent();
    let plate = design(&recipe, &picture.light, &silent)?;
    let proof = prove(&recipe, &picture.light, &plate, &silent)?;
    let mut file = BufWriter::new(File::create(&path)?);
    write_stl(&plate.mesh, &mut file)?;
    file.flush()?;

    let (low, high) = plate.relief.height_range();
    let main = proof.verdict.main();
    println!("{} triangles, relief {:.2} mm", plate.mesh.triangles.len(), high - low);
    println!("TV(1°) {:.4} ± {:.4}, SSIM {:.3}", main.tv.value, main.tv.error, main.ssim.value);
    Ok(())
}
