//! 3MF (3D Manufacturing Format, core specification and the production extension): a zip archive of XML models, in which
//! objects are meshes or are put together of other objects, and a list says which of them are to be made, and where.
//!
//! Read with the crates `zip` and `quick-xml`, piece by piece, so that a model is never in memory as text. The crates that
//! read 3MF as such hold all of it there, or need a newer Rust.

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read, Seek};

use glam::{DAffine3, DMat3, DVec3};
use quick_xml::events::{BytesStart, Event};
use zip::ZipArchive;

use super::{MergedTriangles, MeshFileError};

/// The most that is unpacked of an archive, bytes.
const MOST_UNPACKED: u64 = 4 << 30;

/// The most triangles that are made of an archive, in which few can stand for many.
const MOST_TRIANGLES: usize = 100_000_000;

/// Objects within objects, and how many objects in all, each as often as it is named.
const DEEPEST: usize = 16;
const MOST_PARTS: usize = 100_000;

/// The model that an archive without relations has, too.
const USUAL: &str = "3D/3dmodel.model";

/// What an object is made of.
#[derive(Default)]
struct Object {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Other objects, by the model that holds them and their number there, and where they stand.
    parts: Vec<Part>,
}

/// An object in its place.
#[derive(Clone)]
struct Part {
    model: String,
    number: u32,
    place: DAffine3,
}

/// A model as it was read.
#[derive(Default)]
struct Model {
    objects: HashMap<u32, Object>,
    items: Vec<Part>,
    /// mm to a unit.
    unit: f64,
}

/// Reads a whole archive; also what is to be said of it.
pub(crate) fn read(file: &mut (impl Read + Seek)) -> Result<(MergedTriangles, Vec<String>), MeshFileError> {
    let mut archive = ZipArchive::new(file).map_err(damaged)?;
    let names: Vec<String> = archive.file_names().map(str::to_owned).collect();
    let Some(root) = root(&names) else {
        let remedy = "unpack it and name the mesh in it";
        return Err(MeshFileError::Other { found: "a zip archive without a 3D model", remedy });
    };
    let mut models: HashMap<String, Model> = HashMap::new();
    let mut left = MOST_UNPACKED;
    let mut wanted = vec![root.clone()];
    while let Some(name) = wanted.pop() {
        if models.contains_key(&name) {
            continue;
        }
        let entry = archive.by_name(&name).map_err(damaged)?;
        let model = model(BufReader::new(Counted { entry, left: &mut left }), &name, &names)?;
        let parts = model.objects.values().flat_map(|object| &object.parts).chain(&model.items);
        wanted.extend(parts.map(|part| part.model.clone()).filter(|name| !models.contains_key(name)));
        models.insert(name, model);
    }
    let Some(model) = models.get(&root) else { return Err(broken("its model is missing")) };
    let mut triangles = MergedTriangles::default();
    let scale = DAffine3::from_scale(DVec3::splat(model.unit));
    let mut steps = 0;
    for item in &model.items {
        add(&models, item, scale, &mut triangles, (0, &mut steps))?;
    }
    let mut notes = Vec::new();
    if model.unit != 1.0 {
        notes.push(format!("The file's unit is {} mm: it was scaled to millimetres.", model.unit));
    }
    if model.items.len() > 1 {
        notes.push(format!(
            "The file puts {} objects on the bed: all of them were taken as one plate.",
            model.items.len()
        ));
    }
    Ok((triangles, notes))
}

/// The name of the model that the archive begins with.
fn root(names: &[String]) -> Option<String> {
    let usual = names.iter().find(|name| name.eq_ignore_ascii_case(USUAL));
    let any = || names.iter().find(|name| name.to_ascii_lowercase().ends_with(".model"));
    usual.or_else(any).cloned()
}

/// Adds the triangles of a part in its place.
fn add(
    models: &HashMap<String, Model>,
    part: &Part,
    outer: DAffine3,
    triangles: &mut MergedTriangles,
    (depth, steps): (usize, &mut usize),
) -> Result<(), MeshFileError> {
    *steps += 1;
    let place = outer * part.place;
    let object = models.get(&part.model).and_then(|model| model.objects.get(&part.number));
    let object = object.ok_or_else(|| broken("a part that it names is missing"))?;
    if depth > DEEPEST || *steps > MOST_PARTS || triangles.len() + object.triangles.len() > MOST_TRIANGLES {
        return Err(broken("its objects are within each other too deeply, or too many"));
    }
    let mirrored = place.matrix3.determinant() < 0.0;
    for corners in &object.triangles {
        let corner = |k: usize| {
            let vertex = object.vertices.get(corners[k] as usize)?.map(f64::from);
            Some(place.transform_point3(DVec3::from(vertex)).as_vec3().to_array())
        };
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
            return Err(broken("a triangle names a vertex that is not there"));
        };
        triangles.add(if mirrored { [a, c, b] } else { [a, b, c] })?;
    }
    object.parts.iter().try_for_each(|inner| add(models, inner, place, triangles, (depth + 1, steps)))
}

/// Reads one model.
fn model(text: impl BufRead, own: &str, names: &[String]) -> Result<Model, MeshFileError> {
    let mut reader = quick_xml::Reader::from_reader(text);
    let mut model = Model { unit: 1.0, ..Model::default() };
    let (mut number, mut object) = (0, Object::default());
    let mut buffer = Vec::new();
    loop {
        let event = reader.read_event_into(&mut buffer).map_err(|error| broken(&plain(&error)))?;
        match &event {
            Event::Start(tag) | Event::Empty(tag) => match tag.local_name().as_ref() {
                "model" => model.unit = unit(&attribute(tag, "unit").unwrap_or_default())?,
                "object" => {
                    number = whole(tag, "id")?;
                    object = Object::default();
                }
                "vertex" => object.vertices.push([real(tag, "x")?, real(tag, "y")?, real(tag, "z")?]),
                "triangle" => object.triangles.push([whole(tag, "v1")?, whole(tag, "v2")?, whole(tag, "v3")?]),
                "component" => object.parts.push(part(tag, own, names)?),
                "item" => model.items.push(part(tag, own, names)?),
                _ => {}
            },
            Event::End(tag) if tag.local_name().as_ref() == "object" => {
                model.objects.insert(number, std::mem::take(&mut object));
            }
            Event::Eof => return Ok(model),
            _ => {}
        }
        buffer.clear();
    }
}

/// What a `component` or an `item` says.
fn part(tag: &BytesStart, own: &str, names: &[String]) -> Result<Part, MeshFileError> {
    let model = match attribute(tag, "path") {
        None => own.to_owned(),
        Some(path) => {
            let path = path.trim_start_matches('/');
            let named = names.iter().find(|name| name.eq_ignore_ascii_case(path));
            named.ok_or_else(|| broken("a model that it names is missing"))?.clone()
        }
    };
    let place = match attribute(tag, "transform") {
        None => DAffine3::IDENTITY,
        Some(text) => {
            let numbers: Vec<f64> = text.split_whitespace().map_while(|word| word.parse().ok()).collect();
            let numbers: [f64; 12] = numbers.try_into().map_err(|_| broken("a place is not twelve numbers"))?;
            let row = |k: usize| DVec3::new(numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]);
            // Rows of the file are what the axes become.
            DAffine3 { matrix3: DMat3::from_cols(row(0), row(1), row(2)), translation: row(3) }
        }
    };
    Ok(Part { model, number: whole(tag, "objectid")?, place })
}

/// mm to a unit of that name.
fn unit(name: &str) -> Result<f64, MeshFileError> {
    Ok(match name {
        "micron" => 0.001,
        "" | "millimeter" => 1.0,
        "centimeter" => 10.0,
        "inch" => 25.4,
        "foot" => 304.8,
        "meter" => 1000.0,
        _ => return Err(broken("its unit is unknown")),
    })
}

/// An attribute by its name without prefix.
fn attribute(tag: &BytesStart, name: &str) -> Option<String> {
    let mut attributes = tag.attributes().flatten();
    let found = attributes.find(|attribute| attribute.key.local_name().as_ref() == name)?;
    Some(found.value.into_owned())
}

fn whole(tag: &BytesStart, name: &str) -> Result<u32, MeshFileError> {
    let number = attribute(tag, name).and_then(|text| text.trim().parse().ok());
    number.ok_or_else(|| broken("a number in it is none"))
}

fn real(tag: &BytesStart, name: &str) -> Result<f32, MeshFileError> {
    let number = attribute(tag, name).and_then(|text| text.trim().parse().ok());
    number.ok_or_else(|| broken("a number in it is none"))
}

/// An entry of an archive, as far as there is still something to be unpacked.
struct Counted<'a, R> {
    entry: R,
    left: &'a mut u64,
}

impl<R: Read> Read for Counted<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.entry.read(buffer)?;
        *self.left =
            self.left.checked_sub(read as u64).ok_or_else(|| std::io::Error::other("it unpacks to too much"))?;
        Ok(read)
    }
}

fn broken(reason: &str) -> MeshFileError {
    MeshFileError::Damaged { format: "3MF", reason: reason.into() }
}

fn damaged(error: zip::result::ZipError) -> MeshFileError {
    broken(&plain(&error))
}

/// Words of others, on one line.
fn plain(error: &dyn std::fmt::Display) -> String {
    error.to_string().chars().filter(|c| !c.is_control()).take(120).collect()
}
