//! The scene as glTF 2.0 in one binary file: plate, lamp, what its light falls on, and cameras.
//!
//! glTF is in metres, y up: meshes stay as they are in the plate's file, mm and z up, under nodes that scale and turn them;
//! lights and cameras, which must not be scaled, are put in place in metres.

use std::io::{self, BufWriter, Write};

use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};

use super::{Beam, LitPlate};
use crate::relief::mesh::Mesh;

/// Metres to a millimetre.
const METRES: f64 = 1e-3;

/// From x right, y away, z up to x right, y up, z toward the viewer: a quarter turn back about x.
const UPRIGHT: [f64; 4] = [-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];

/// What the plate gets of its lamp, lux: a bright room.
const LUX: f64 = 1000.0;

/// From the plate to the camera that looks at it, diagonals of the plate, and whole angle of its image, radians.
const VIEWER: f64 = 8.0;
const VIEW: f64 = 0.2;

/// Component types and targets of glTF.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34_962;
const INDICES: u32 = 34_963;

/// Bytes of a header of the file or of a chunk.
const FILE_HEADER: u64 = 12;
const CHUNK_HEADER: u64 = 8;

impl LitPlate {
    /// Writes the scene; `about` says what it is, for people.
    ///
    /// # Errors
    /// When writing fails; `InvalidInput` when it would be larger than such a file can be, 4 GiB.
    pub fn write_gltf(&self, about: &str, out: &mut dyn Write) -> io::Result<()> {
        let meshes = [&self.mirror, &self.body, &self.screen.mesh];
        let binary: u64 = meshes.into_iter().map(bytes).sum();
        let mut text = self.gltf(about, &meshes, binary).to_string();
        // Chunks end on whole words; every number before was a word.
        text += &" ".repeat(text.len().next_multiple_of(4) - text.len());
        let whole = FILE_HEADER + 2 * CHUNK_HEADER + text.len() as u64 + binary;
        let Ok(whole) = u32::try_from(whole) else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "more bytes than a glTF file can count"));
        };
        let mut out = BufWriter::with_capacity(1 << 16, out);
        let word = |number: u32| number.to_le_bytes();
        out.write_all(&[*b"glTF", word(2), word(whole), word(text.len() as u32), *b"JSON"].concat())?;
        out.write_all(text.as_bytes())?;
        out.write_all(&[word(binary as u32), *b"BIN\0"].concat())?;
        for mesh in meshes {
            for number in mesh.vertices.as_flattened() {
                out.write_all(&number.to_le_bytes())?;
            }
            for corner in mesh.triangles.as_flattened() {
                out.write_all(&corner.to_le_bytes())?;
            }
        }
        out.flush()
    }

    /// All but the numbers of its meshes.
    fn gltf(&self, about: &str, meshes: &[&Mesh; 3], binary: u64) -> Value {
        let (mut views, mut accessors) = (Vec::new(), Vec::new());
        let mut offset = 0;
        for mesh in meshes {
            let (low, high) = mesh.bounds();
            let [vertices, corners] = [12 * mesh.vertices.len(), 12 * mesh.triangles.len()];
            let view = views.len();
            views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": vertices, "target": VERTICES }));
            offset += vertices;
            views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": corners, "target": INDICES }));
            offset += corners;
            accessors.push(json!({
                "bufferView": view, "componentType": FLOAT, "count": mesh.vertices.len(), "type": "VEC3",
                "min": low.to_array(), "max": high.to_array(),
            }));
            accessors.push(json!({
                "bufferView": view + 1, "componentType": UNSIGNED_INT, "count": 3 * mesh.triangles.len(),
                "type": "SCALAR",
            }));
        }
        let piece = |k: usize| json!({ "attributes": { "POSITION": 2 * k }, "indices": 2 * k + 1, "material": k });
        let (cameras, mut nodes) = self.cameras();
        let lamp = json!({ "KHR_lights_punctual": { "light": 0 } });
        let (place, turn) = self.lamp_place();
        nodes.push(json!({ "name": "lamp", "translation": place, "rotation": turn, "extensions": lamp }));
        for (mesh, name) in ["plate", "screen"].into_iter().enumerate() {
            nodes.push(json!({ "name": name, "mesh": mesh, "rotation": UPRIGHT, "scale": [METRES, METRES, METRES] }));
        }
        json!({
            "asset": {
                "version": "2.0",
                "generator": concat!("facetmill ", env!("CARGO_PKG_VERSION")),
                "extras": { "about": about, "unit": "m; meshes are in mm, z up, under nodes that scale and turn them" },
            },
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": { "KHR_lights_punctual": { "lights": [self.light()] } },
            "scene": 0,
            "scenes": [{ "name": "plate, lamp and screen", "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
            "nodes": nodes,
            "cameras": cameras,
            "meshes": [
                { "name": "plate", "primitives": [piece(0), piece(1)] },
                { "name": "screen", "primitives": [piece(2)] },
            ],
            "materials": self.materials(),
            "accessors": accessors,
            "bufferViews": views,
            "buffers": [{ "byteLength": binary }],
        })
    }

    /// Metal, what takes all light, and the screen.
    fn materials(&self) -> Value {
        let matt = |grey: f64| json!({ "baseColorFactor": [grey, grey, grey, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0 });
        // glTF's roughness is the root of α.
        let metal = json!({ "metallicFactor": 1.0, "roughnessFactor": self.roughness.sqrt().min(1.0) });
        json!([
            { "name": "mirror", "pbrMetallicRoughness": metal },
            { "name": "dull", "pbrMetallicRoughness": matt(0.0) },
            { "name": "screen", "pbrMetallicRoughness": matt(0.8), "doubleSided": true },
        ])
    }

    fn light(&self) -> Value {
        match &self.beam {
            Beam::Parallel(_) => json!({ "type": "directional", "intensity": LUX }),
            Beam::Spots { middle, .. } => {
                let distance = METRES * (*middle - self.middle).length();
                json!({ "type": "point", "intensity": LUX * distance * distance })
            }
        }
    }

    /// Where the lamp is, metres, and its turn. A directional light shines along its -z.
    fn lamp_place(&self) -> ([f64; 3], [f64; 4]) {
        match &self.beam {
            Beam::Parallel(sheet) => {
                let away = self.middle + VIEWER * self.diagonal * sheet.direction;
                (metres(away), looking(-sheet.direction, DVec3::Y))
            }
            Beam::Spots { middle, .. } => (metres(*middle), DQuat::IDENTITY.to_array()),
        }
    }

    /// Cameras and their nodes: one that looks at the plate from where a flat plate would throw the light, and where the
    /// screen is a wall, one that looks at it.
    fn cameras(&self) -> (Vec<Value>, Vec<Value>) {
        let away = VIEWER * self.diagonal;
        let camera = |name: &str, field: f64, clip: [f64; 2]| {
            let [znear, zfar] = clip.map(|mm| METRES * mm);
            let lens = json!({ "yfov": field, "aspectRatio": 1.0, "znear": znear, "zfar": zfar });
            json!({ "name": name, "type": "perspective", "perspective": lens })
        };
        let node = |k: usize, name: &str, eye: DVec3, toward: DVec3, up: DVec3| json!({ "name": name, "camera": k, "translation": metres(eye), "rotation": looking(toward, up) });
        let name = "viewer of the plate";
        let mut cameras = vec![camera(name, VIEW, [0.1 * away, 10.0 * away])];
        let mut nodes = vec![node(0, name, self.middle + away * self.viewer, -self.viewer, DVec3::Y)];
        if self.screen.is_wall {
            let (name, seen) = ("viewer of the wall", &self.camera);
            cameras.push(camera(name, seen.field, seen.clip));
            nodes.push(node(1, name, seen.eye, seen.target - seen.eye, seen.up));
        }
        (cameras, nodes)
    }
}

/// Bytes of a mesh.
fn bytes(mesh: &Mesh) -> u64 {
    12 * (mesh.vertices.len() as u64 + mesh.triangles.len() as u64)
}

/// The axes of glTF.
fn upright(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.z, -v.y)
}

fn metres(mm: DVec3) -> [f64; 3] {
    (METRES * upright(mm)).to_array()
}

/// The turn that takes -z to `toward` and y as near to `up` as can be, as glTF has it.
fn looking(toward: DVec3, up: DVec3) -> [f64; 4] {
    let ahead = upright(toward).normalize_or_zero();
    let right = ahead.cross(upright(up)).try_normalize().unwrap_or(DVec3::X);
    let axes = DMat3::from_cols(right, right.cross(ahead), -ahead);
    DQuat::from_mat3(&axes).normalize().to_array()
}
