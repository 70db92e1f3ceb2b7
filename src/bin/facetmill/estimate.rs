//! What a design would be, told from its sizes alone.

use facetmill::job::estimate::estimate;
use facetmill::recipe::{Recipe, SurfaceKind};
use facetmill::sculpt::bound::Unavoidable;
use serde_json::{Value, json};

use crate::console::{print_json, print_table, rays, row};
use crate::files::OutputError;

/// Tells the estimate, as JSON or as a table.
pub fn tell(
    recipe: &Recipe,
    stray: Option<Unavoidable>,
    proved: bool,
    to_json: bool,
    quiet: bool,
) -> Result<(), OutputError> {
    let mut facts = estimate(recipe, proved);
    if let Some(stray) = stray {
        facts["least_stray_share"] = json!(stray.share);
    }
    if to_json {
        print_json(&facts)
    } else if quiet {
        Ok(())
    } else {
        print(recipe, &facts)
    }
}

fn print(recipe: &Recipe, facts: &Value) -> Result<(), OutputError> {
    let number = |key: &str| facts[key].as_f64().unwrap_or(0.0);
    let [width, height] = recipe.plate.size.map(|side| side + 2.0 * recipe.plate.border);
    let pieces = match recipe.surface() {
        SurfaceKind::Facets => {
            let ([columns, rows], pitch) = (recipe.facets(), recipe.pitch());
            row("facets", format!("{columns} × {rows}"), format!("each {:.3} × {:.3} mm", pitch.x, pitch.y))
        }
        SurfaceKind::Sheet => {
            let sculpting = recipe.sculpting();
            let [across, up] = sculpting.cells;
            row("cells", format!("{across} × {up}"), format!("of {0} × {0} nodes", sculpting.grid))
        }
    };
    let megabytes = number("stl_bytes_about") / 1e6;
    let [design, proof, files] =
        ["design", "verify", "files"].map(|stage| number(&format!("{stage}_cpu_seconds_about")));
    let mut table = vec![
        row("plate", format!("{width} × {height} mm"), "with its rim"),
        pieces,
        row("plate.stl", format!("about {megabytes:.1} MB"), format!("{} triangles", facts["stl_triangles_about"])),
        row("design", format!("about {design:.1} s"), "of CPU time"),
        row(
            "proof",
            format!("about {proof:.1} s"),
            if proof > 0.0 { format!("for {} rays", rays(recipe.verify.rays)) } else { "not asked for".into() },
        ),
        row("files", format!("about {files:.1} s"), "mostly for pictures"),
    ];
    if let Some(share) = facts["least_stray_share"].as_f64() {
        let meaning = "of the light at least falls into gaps of the drawing, since the ball must turn there";
        table.push(row("straying", format!("{:.2} %", 100.0 * share), meaning));
    }
    print_table("Dry run: nothing was designed or written", &table, &[])
}
