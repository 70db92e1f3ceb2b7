//! Plates from files: a mesh, or the folder of a design.

use std::io::Read;
use std::path::{Path, PathBuf};

use facetmill::export::mesh_files::read_mesh;
use facetmill::memory::{MemoryLimit, Need, TooMuchMemory};
use facetmill::progress::Progress;
use facetmill::recipe::Recipe;
use facetmill::relief::mesh::Mesh;
use facetmill::relief::placement::{Axis, faces_turned, is_inside_out, relief_side, scaled, upright};
use facetmill::report::MeshFacts;
use facetmill::report::design::Mount;
use facetmill::slope::direction;
use facetmill::trace::Surface;
use facetmill::trace::mesh::MeshSurfaceError;
use facetmill::trace::traced_plate::{Task, TracedPlate, TracedPlateError};
use glam::DVec3;

use crate::args::PlacingArgs;
use crate::console::Failure;
use crate::inputs;
use crate::ranges::within;

/// Lengths between which a plate is believed, mm.
const SMALLEST: f64 = 1e-3;
const LARGEST: f64 = 1e7;

/// A plate that was read, and what is to be said of its file.
pub struct Opened {
    pub plate: TracedPlate,
    /// Its optical area alone, if that stands on a grid and the margin shades nothing.
    pub bare: Option<TracedPlate>,
    /// The box around it, mm.
    pub size: DVec3,
    pub triangles: usize,
    /// What a person should know of the file.
    pub advice: Vec<String>,
    /// What the report says of it.
    pub facts: MeshFacts,
    /// Its triangles, as they were laid down.
    pub mesh: Mesh,
}

struct Heights;

impl Task for Heights {
    type Output = (f64, f64);
    fn on<S: Surface>(self, surface: &S) -> (f64, f64) {
        surface.height_range()
    }
}

/// Bytes for each 50 of a mesh's file, which are a triangle of a binary one: its mesh and the tree over it as it is built.
const TRIANGLE: f64 = 400.0;

/// Bytes for each triangle of a plate once it is there.
const KEPT_TRIANGLE: f64 = 150.0;

/// Bytes of the program itself.
const GROUND: f64 = 4e7;

/// Refuses a plate of `bytes` in a file that would take too much memory to read, or beside what is to be done with it.
fn admit(bytes: u64, limit: MemoryLimit, then: Need) -> Result<(), TooMuchMemory> {
    let triangles = bytes as f64 / 50.0;
    let read = Need::new(GROUND + TRIANGLE * triangles, "a plate of so many triangles", "decimate its mesh");
    let beside = Need { bytes: then.bytes.saturating_add((GROUND + KEPT_TRIANGLE * triangles) as u64), ..then };
    limit.admit(read)?;
    limit.admit(beside)
}

/// What a rim that is no optical area may be, mm.
pub const MARGIN: (f64, f64) = (0.0, 10_000.0);

/// A plate shorter than this may be in another unit than millimetres, mm.
const SHORT: f64 = 5.0;

/// The rim of a plate that is no optical area, mm: as `given`, else that of the design's folder that `plate` is.
pub fn margin(given: Option<f64>, plate: &Path, recipe: &Recipe) -> f64 {
    given.unwrap_or(if plate.is_dir() { recipe.plate.border } else { 0.0 })
}

/// Reads the mesh at `path`, if that and what is to be done then may take so much memory, and lays it down; its rim of
/// `margin` mm is no optical area.
pub fn open(
    path: &Path,
    margin: f64,
    placing: &PlacingArgs,
    memory: (MemoryLimit, Need),
    progress: &Progress,
) -> Result<Opened, Failure> {
    within("margin", Some(margin), MARGIN)?;
    let name = path.display();
    admit(path.metadata().map_or(0, |about| about.len()), memory.0, memory.1)?;
    let (mesh, mut advice) = laid_down(path, placing)?;
    let (low, high) = mesh.bounds();
    let size = high - low;
    let length = size.max_element();
    if !(SMALLEST..=LARGEST).contains(&length) {
        return Err(Failure::Input(format!(
            "{name}: the plate is {length:.1e} mm long: meshes have no unit, so say with --unit which it is"
        )));
    }
    let plate = TracedPlate::new(&mesh, margin, progress).map_err(|error| match error {
        TracedPlateError::Cancelled(cancelled) => cancelled.into(),
        TracedPlateError::Mesh(MeshSurfaceError::Margin { .. }) if margin > 0.0 => Failure::Impossible(format!(
            "{name}: a --margin of {margin} mm leaves nothing of the plate: check units, and lower --margin"
        )),
        TracedPlateError::Mesh(MeshSurfaceError::Margin { .. }) => Failure::Input(format!(
            "{name}: all points of the plate lie on a line, seen from above: nothing can reflect"
        )),
        error => Failure::Input(format!("{name}: {error}")),
    })?;
    let open = mesh.open_edges();
    if open > 0 {
        advice.push(format!("{open} edges of the mesh have no partner: it is not closed, and slicers will guess."));
    }
    advice.extend(placement(&mesh, placing));
    let heights = plate.run(Heights);
    let facts = MeshFacts {
        file: path.to_string_lossy().into_owned(),
        units: "mm",
        triangles: mesh.triangles.len(),
        degenerate_triangles: mesh.degenerate(),
        open_edges: open,
        size_mm: size.to_array(),
        relief_height_mm: heights.1 - heights.0,
        traced_as: plate.kind(),
    };
    let bare = if margin > 0.0 { TracedPlate::without_rim(&mesh, margin, progress)? } else { None };
    Ok(Opened { plate, bare, size, triangles: mesh.triangles.len(), advice, facts, mesh })
}

/// The mesh of a file in mm, its relief toward +z and its faces outward as far as was said; and what is to be said of it.
fn laid_down(path: &Path, placing: &PlacingArgs) -> Result<(Mesh, Vec<String>), Failure> {
    let name = path.display();
    let read = read_mesh(&mut inputs::open(path)?).map_err(|error| Failure::Input(format!("{name}: {error}")))?;
    let (mut mesh, mut notes) = (read.mesh, read.notes);
    if let Some(unit) = placing.unit {
        if read.has_unit {
            return Err(Failure::Usage(format!(
                "{name}: a {} file says its unit by itself: leave out --unit",
                read.format
            )));
        }
        mesh = scaled(mesh, unit.mm());
    }
    let up = if placing.flip { Axis::MinusZ } else { placing.up.map_or(Axis::Z, |up| up.axis()) };
    mesh = upright(mesh, up);
    if mesh.open_edges() == 0 && is_inside_out(&mesh) {
        notes.push("The mesh was inside out, its faces looking inward: they were turned outward.".into());
        mesh = faces_turned(mesh);
    }
    Ok((mesh, notes))
}

/// What is to be said of how a mesh lies, each with the flag that mends it.
fn placement(mesh: &Mesh, placing: &PlacingArgs) -> Vec<String> {
    let mut advice = Vec::new();
    // Flags that were given have had their say: the mesh lies as they put it.
    let told = if placing.flip || placing.up.is_some() { "without --flip and --up, or " } else { "" };
    match relief_side(mesh) {
        None | Some(Axis::Z) => {}
        Some(Axis::MinusZ) if told.is_empty() => {
            advice.push("The plate lies upside down, its flat side up: turn it over with --flip.".into());
        }
        Some(Axis::MinusZ) => {
            advice.push(format!("The plate lies upside down, its flat side up: lay it {told}otherwise."))
        }
        Some(axis) if told.is_empty() => advice.push(format!(
            "The plate stands on edge, its relief toward {}: lay it down with --up {}.",
            axis.name(),
            axis.name()
        )),
        Some(_) => advice.push(format!("The plate stands on edge: lay it {told}otherwise.")),
    }
    let (low, high) = mesh.bounds();
    let length = (high - low).max_element();
    if length < SHORT && placing.unit.is_none() {
        advice.push(format!(
            "The plate is only {length:.3} mm long: meshes have no unit. If it is in inches, say --unit in; in metres, \
             --unit m."
        ));
    }
    advice
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
    let recipe = match path.join(RECIPE) {
        file if file.exists() => {
            let recipe = inputs::recipe(&file)?;
            recipe.check().map_err(|error| Failure::Input(format!("{}: {error}", file.display())))?;
            recipe
        }
        _ => Recipe::default(),
    };
    let report = path.join("report.json");
    let mount = if report.exists() { mount_of(&report)? } else { None };
    if recipe.design.distribution.level && mount.is_none() {
        return Err(Failure::Input(format!(
            "{}: a design with level = true tells here how its plate is mounted, and this does not; \
             name the STL itself to light it unmounted",
            report.display()
        )));
    }
    Ok(Named { stl, recipe, mount })
}

/// What shows that a folder is a design's.
const RECIPE: &str = "recipe.toml";

/// Largest report read, bytes.
const LARGEST_REPORT: u64 = 16 << 20;

/// The mounting angles that a design's report tells, if the plate is to be mounted tilted.
fn mount_of(path: &Path) -> Result<Option<DVec3>, Failure> {
    let broken = |what: String| {
        Failure::Input(format!(
            "{}: this is no report of a design ({what}); restore it, or name the STL itself",
            path.display()
        ))
    };
    let mut text = String::new();
    let read = inputs::open(path)?.take(LARGEST_REPORT).read_to_string(&mut text);
    read.map_err(|error| broken(error.to_string()))?;
    match Mount::read(&text).map_err(|error| broken(error.to_string()))? {
        None => Ok(None),
        Some(Mount { theta, phi }) if (0.0..=80.0).contains(&theta) && phi.abs() <= 360.0 => {
            Ok(Some(direction(theta.to_radians(), phi.to_radians())))
        }
        Some(_) => Err(broken("mount_theta_deg and mount_phi_deg are no angles at which a plate is mounted".into())),
    }
}

/// Refuses to measure or verify into the very folder of the design: its report, which tells of the plate, would be replaced.
pub fn spare_design(plate: &Path, output: &Path) -> Result<(), Failure> {
    let folder = |path: &Path| path.canonicalize().ok();
    let home =
        folder(plate).and_then(|plate| if plate.is_dir() { Some(plate) } else { plate.parent().map(Into::into) });
    match (home, folder(output)) {
        (Some(home), Some(output)) if home == output && home.join(RECIPE).exists() => Err(Failure::Usage(format!(
            "-o {} is the design's own folder, whose report.json would be lost: choose another folder",
            output.display()
        ))),
        _ => Ok(()),
    }
}

/// The last part of a path, as a heading says it.
pub fn name(path: &Path) -> String {
    let last = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    last(path).or_else(|| last(&path.canonicalize().ok()?)).unwrap_or_else(|| path.display().to_string())
}
