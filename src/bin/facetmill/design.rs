//! `facetmill design`: a picture becomes a plate.

use std::path::{Path, PathBuf};

use facetmill::export::heightmap::height_map;
use facetmill::export::shading::relief_picture;
use facetmill::export::stl::{stl_bytes, write_stl};
use facetmill::highlight::scored_target;
use facetmill::picture::{self, Picture};
use facetmill::progress::Progress;
use facetmill::recipe::report::report;
use facetmill::recipe::run::{Design, Proof, design, prove};
use facetmill::recipe::{Arrangement, Recipe, RecipeError};
use serde_json::{Value, json};

use crate::STOP;
use crate::args::DesignArgs;
use crate::console::{Failure, Stages, print_json, print_line, print_table, verdict_rows};
use crate::files::Staged;
use crate::outputs::{write_png, write_proof, write_target};

/// Pixels along the longer side of the height map, at the most.
const HEIGHT_MAP_SIDE: usize = 2048;

/// Pixels along the longer side of the relief's picture.
const RELIEF_PICTURE_SIDE: usize = 960;

/// Does what `args` say.
pub fn run(args: &DesignArgs) -> Result<(), Failure> {
    let (recipe, path) = recipe(args)?;
    // Before any work: a folder that cannot be written should not cost a minute.
    let staged = match (&args.output, args.dry_run) {
        (Some(folder), false) => Some(Staged::new(folder, args.running.force)?),
        _ => None,
    };
    let picture = picture::read(&path, &recipe.reading())?;
    let Some(mut staged) = staged else {
        let facts = dry_run(&recipe);
        if args.running.json {
            print_json(&facts);
        } else if !args.running.quiet {
            print_dry_run(&recipe, &facts);
        }
        return Ok(());
    };
    let stages = Stages::new(args.running.quiet);
    let listen = |event: facetmill::progress::Event<'_>| stages.hear(event);
    let progress = Progress::new(&listen, &STOP);
    let made = design(&recipe, &picture.light, &progress)?;
    let proof = match args.no_verify {
        true => None,
        false => Some(prove(&recipe, &picture.light, &made, &progress)?),
    };
    progress.stage("writing files");
    let report = report(&recipe, &picture, &made, proof.as_ref());
    write(&mut staged, &recipe, &picture, &made, proof.as_ref(), &report)?;
    if progress.is_cancelled() {
        return Err(Failure::Stopped);
    }
    staged.publish()?;
    stages.finish();
    if args.running.json {
        print_json(&report);
    } else if !args.running.quiet {
        print_result(
            args.output.as_deref().unwrap_or(Path::new(".")),
            &recipe,
            &picture,
            &made,
            proof.as_ref(),
            &report,
        );
    }
    Ok(())
}

/// The effective recipe, and the file of its picture.
fn recipe(args: &DesignArgs) -> Result<(Recipe, PathBuf), Failure> {
    let mut from_file = false;
    let mut recipe = match &args.recipe {
        None => args.base(),
        Some(file) => {
            from_file = true;
            let cannot = |what: String| Failure::Input(format!("{}: {what}", file.display()));
            let text = std::fs::read_to_string(file).map_err(|error| cannot(format!("cannot be read: {error}")))?;
            let recipe = Recipe::from_toml(&text).map_err(|error| cannot(error.to_string()))?;
            recipe.check().map_err(|error| cannot(error.to_string()))?;
            recipe
        }
    };
    args.apply(&mut recipe);
    recipe.check().map_err(|error| match error {
        error if error.is_impossible() => Failure::Impossible(error.to_string()),
        RecipeError::OutOfRange { .. } => Failure::Usage(format!("--{error}")),
        error => Failure::Input(error.to_string()),
    })?;
    let path = match (&args.picture, &recipe.picture) {
        (Some(path), _) => path.clone(),
        (None, Some(name)) => PathBuf::from(name),
        (None, None) if from_file => {
            return Err(Failure::Input("the recipe names no picture: give one on the command line".into()));
        }
        (None, None) => return Err(Failure::Usage("no picture was given".into())),
    };
    Ok((recipe, path))
}

fn write(
    staged: &mut Staged,
    recipe: &Recipe,
    picture: &Picture,
    made: &Design,
    proof: Option<&Proof>,
    report: &Value,
) -> Result<(), Failure> {
    let setup = &made.distribution.setup;
    staged.write("plate.stl", |out| write_stl(&made.mesh, out))?;
    let map = height_map(&made.relief, HEIGHT_MAP_SIDE);
    write_png(staged, "heightmap.png", &map.image)?;
    staged.write_bytes("heightmap.json", format!("{:#}\n", json!(map.sidecar)).as_bytes())?;
    write_png(staged, "relief.png", &relief_picture(&made.relief, RELIEF_PICTURE_SIDE))?;
    match proof {
        Some(proof) => {
            write_target(staged, &proof.target, recipe)?;
            write_proof(staged, proof, recipe, setup.view(), plate_line(recipe, made))?;
        }
        None => {
            let target = scored_target(&picture.light, recipe.highlight.quantity, setup, 256);
            write_target(staged, &target, recipe)?;
        }
    }
    staged.write_bytes("recipe.toml", recipe.to_toml().as_bytes())?;
    staged.write_bytes("report.json", format!("{report:#}\n").as_bytes())?;
    Ok(())
}

/// The plate in one line, for captions.
fn plate_line(recipe: &Recipe, made: &Design) -> String {
    let [width, height] = recipe.plate.size;
    let [columns, rows] = recipe.plate.facets;
    let (low, high) = made.relief.height_range();
    format!(
        "{width} × {height} mm, {columns} × {rows} facets, relief {:.2} mm   ·   light at {}°, {}°   ·   half field {}°",
        high - low,
        recipe.light.theta,
        recipe.light.phi,
        recipe.highlight.half_field
    )
}

/// What a design would be, from its sizes alone.
fn dry_run(recipe: &Recipe) -> Value {
    let [columns, rows] = recipe.plate.facets;
    let facets = (columns * rows) as f64;
    let pitch = recipe.pitch();
    // Measured on photographs and logos: with steps that change sign along most edges a facet takes about 13
    // triangles, with tall walls about 7. The rest is sides and base.
    let per_facet = if recipe.design.arrange == Arrangement::Random { 7.0 } else { 13.0 };
    let triangles = (per_facet * facets + 8.0 * (columns + rows) as f64).round() as usize;
    // CPU seconds a facet, with the part that does not depend on facets.
    let design = match recipe.design.arrange {
        Arrangement::Transport => 0.15 + 2.5e-4 * facets,
        Arrangement::Anneal => 0.15 + 8e-4 * facets,
        Arrangement::Random => 0.15 + 1e-4 * facets,
    };
    let verify = 1.5 + 2e-7 * recipe.verify.rays as f64;
    json!({
        "dry_run": true,
        "plate_mm": [
            recipe.plate.size[0] + 2.0 * recipe.plate.border,
            recipe.plate.size[1] + 2.0 * recipe.plate.border
        ],
        "pitch_mm": [pitch.x, pitch.y],
        "facets": columns * rows,
        "stl_triangles_about": triangles,
        "stl_bytes_about": stl_bytes(triangles),
        "design_cpu_seconds_about": design,
        "verify_cpu_seconds_about": verify,
    })
}

fn print_dry_run(recipe: &Recipe, facts: &Value) {
    let number = |key: &str| facts[key].as_f64().unwrap_or(0.0);
    let pair = |key: &str, digits: usize| {
        let side = |k: usize| facts[key][k].as_f64().unwrap_or(0.0);
        format!("{:.digits$} × {:.digits$}", side(0), side(1))
    };
    let row = |name: &str, value: String, meaning: &str| [name.to_owned(), value, meaning.to_owned()];
    let rows = [
        row("plate", pair("plate_mm", 1), "mm with its border"),
        row("facet", pair("pitch_mm", 4), "mm"),
        row("facets", format!("{}", recipe.plate.facets[0] * recipe.plate.facets[1]), ""),
        row("STL", format!("{:.1}", number("stl_bytes_about") / 1e6), "MB, about"),
        row("design", format!("{:.1}", number("design_cpu_seconds_about")), "CPU seconds, about"),
        row("verify", format!("{:.1}", number("verify_cpu_seconds_about")), "CPU seconds, about"),
    ];
    print_table("Dry run: nothing is designed or written", &rows);
}

fn print_result(
    folder: &Path,
    recipe: &Recipe,
    picture: &Picture,
    made: &Design,
    proof: Option<&Proof>,
    report: &Value,
) {
    let row = |name: &str, value: String, meaning: &str| [name.to_owned(), value, meaning.to_owned()];
    let [width, height] = recipe.plate.size;
    let pitch = recipe.pitch();
    let (low, high) = made.relief.height_range();
    let mut rows = vec![
        row("plate", format!("{width} × {height}"), &format!("mm, facets of {:.3} × {:.3} mm", pitch.x, pitch.y)),
        row("relief", format!("{:.3}", high - low), "mm from lowest to highest point"),
        row("steps", format!("{:.4}", made.steps.rms), "mm between neighbours, root mean square; 0 is seamless"),
        row("valleys", made.steps.inner_valleys.to_string(), "inside the plate, which a cutter would fill"),
    ];
    let normal = made.distribution.setup.plate_normal();
    if normal.z < 1.0 {
        let meaning =
            format!("° toward azimuth {:.1}°: mount the plate tilted so", normal.y.atan2(normal.x).to_degrees());
        rows.push(row("mount", format!("{:.2}", normal.z.acos().to_degrees()), &meaning));
    }
    if let Some(proof) = proof {
        rows.extend(verdict_rows(&proof.verdict));
    }
    let cpu: f64 = made.seconds.iter().map(|(_, s)| s).sum();
    rows.push(row("design", format!("{cpu:.2}"), "CPU seconds"));
    print_table(
        &format!(
            "Wrote {}: plate.stl ({} triangles), comparison and report",
            folder.display(),
            made.mesh.triangles.len()
        ),
        &rows,
    );
    let sentences = picture
        .notes
        .iter()
        .map(String::as_str)
        .chain(report["advice"].as_array().into_iter().flatten().filter_map(Value::as_str));
    sentences.for_each(|sentence| print_line(&format!("  Note: {sentence}")));
}
