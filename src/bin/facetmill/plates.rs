//! Plates from files: an STL, or the folder of a design.

use std::path::{Path, PathBuf};

use facetmill::export::stl::{open_edges, read_stl};
use facetmill::recipe::Recipe;
use facetmill::slope::direction;
use facetmill::trace::Surface;
use facetmill::trace::mesh::MeshSurfaceError;
use facetmill::trace::plate::{Plate, Task};
use glam::DVec3;
use serde_json::{Value, json};

use crate::console::Failure;
use crate::inputs;

/// Lengths between which a plate is believed, mm.
const SMALLEST: f64 = 1e-3;
const LARGEST: f64 = 1e7;

/// A plate that was read, and what is to be said of its file.
pub struct Opened {
    pub plate: Plate,
    /// The box around it, mm.
    pub size: DVec3,
    pub triangles: usize,
    /// Lowest and highest point of the relief, mm.
    pub heights: (f64, f64),
    /// What a person should know of the file.
    pub advice: Vec<String>,
    facts: Value,
}

impl Opened {
    /// Facts for the report.
    pub fn facts(&self) -> Value {
        self.facts.clone()
    }
}

struct Heights;

impl Task for Heights {
    type Output = (f64, f64);
    fn on<S: Surface>(self, surface: &S) -> (f64, f64) {
        surface.height_range()
    }
}

/// Reads the STL at `path`; its rim of `margin` mm is no optical area.
pub fn open(path: &Path, margin: f64) -> Result<Opened, Failure> {
    if !(0.0..=10_000.0).contains(&margin) {
        return Err(Failure::Usage(format!("--margin is {margin}: it must be from 0 to 10000")));
    }
    let name = path.display();
    let mesh = read_stl(&mut inputs::open(path)?).map_err(|error| Failure::Input(format!("{name}: {error}")))?;
    let (low, high) = mesh.bounds();
    let size = high - low;
    let length = size.max_element();
    if !(SMALLEST..=LARGEST).contains(&length) {
        return Err(Failure::Input(format!(
            "{name}: the plate is {length:.1e} mm long: STL has no units, so scale it to millimetres"
        )));
    }
    let plate = Plate::new(&mesh, margin).map_err(|error| match error {
        MeshSurfaceError::Margin { .. } if margin > 0.0 => Failure::Impossible(format!(
            "{name}: a --margin of {margin} mm leaves nothing of the plate: check units, and lower --margin"
        )),
        MeshSurfaceError::Margin { .. } => Failure::Input(format!(
            "{name}: all points of the plate lie on a line, seen from above: nothing can reflect"
        )),
        error => Failure::Input(format!("{name}: {error}")),
    })?;
    let mut advice = Vec::new();
    let open = open_edges(&mesh);
    if open > 0 {
        advice.push(format!("{open} edges of the mesh have no partner: it is not closed, and slicers will guess."));
    }
    if length < 1.0 {
        advice.push(format!("The plate is only {length:.3} mm long: STL has no units, is it in metres?"));
    }
    let heights = plate.run(Heights);
    let facts = json!({
        "file": path.to_string_lossy(),
        "units": "mm",
        "triangles": mesh.triangles.len(),
        "degenerate_triangles": mesh.degenerate(),
        "open_edges": open,
        "size_mm": [size.x, size.y, size.z],
        "relief_height_mm": heights.1 - heights.0,
        "traced_as": plate.kind(),
    });
    Ok(Opened { plate, size, triangles: mesh.triangles.len(), heights, advice, facts })
}

/// What a person named: an STL, or the folder that `design` left, whose recipe then stands for flags that are not given.
pub struct Named {
    pub stl: PathBuf,
    pub recipe: Recipe,
    /// The normal of a plate that is mounted tilted, in the drawing's frame.
    pub mount: Option<DVec3>,
}

/// Finds the STL, and settings beside it.
pub fn named(path: &Path) -> Result<Named, Failure> {
    if !path.is_dir() {
        return Ok(Named { stl: path.to_owned(), recipe: Recipe::default(), mount: None });
    }
    let stl = path.join("plate.stl");
    if !stl.exists() {
        let name = path.display();
        return Err(Failure::Input(format!(
            "{name}: no plate.stl stands in this folder; name an STL or a design's folder"
        )));
    }
    let recipe = match path.join("recipe.toml") {
        file if file.exists() => inputs::recipe(&file)?,
        _ => Recipe::default(),
    };
    Ok(Named { stl, recipe, mount: mount_of(&path.join("report.json")) })
}

/// The mounting angles that a design's report tells, if the plate is to be mounted tilted.
fn mount_of(report: &Path) -> Option<DVec3> {
    let text = std::fs::read_to_string(report).ok()?;
    let design = serde_json::from_str::<Value>(&text).ok()?["design"].take();
    let [theta, phi] = ["mount_theta_deg", "mount_phi_deg"].map(|key| design[key].as_f64());
    let (theta, phi) = (theta?, phi?);
    (theta > 0.0 && theta <= 80.0 && phi.abs() <= 360.0).then(|| direction(theta.to_radians(), phi.to_radians()))
}
