//! A plate with its lamp and the screen that its light falls on, for renderers of others: Mitsuba 3 and glTF.
//!
//! Mitsuba's particle tracer sends light from the lamp over the plate onto a matt screen, at which a camera looks. The screen
//! is a wall nearby, or stands for viewers endlessly far: then it is 20,000 plates away, curved so that the camera,
//! which looks along one axis from a thousand times as far again, sees the highlight image undistorted, and painted so
//! that what it sees of each pixel is in proportion to the light that falls there. So the rendered image is the proof's:
//! light per pixel, 1 where all light of the plate would fall evenly over the image.

mod beams;

mod screen;

pub mod mitsuba;

mod gltf;

#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3};

pub use beams::{Beam, LampSheet};
pub use screen::{Camera, Facing, Screen, Shown};

use crate::lamp::Lamp;
use crate::progress::{Cancelled, Progress};
use crate::relief::mesh::Mesh;
use crate::slope::flat_mirror;

/// A plate as it is lit: mm, in the frame of its file.
#[derive(Clone, Copy, Debug)]
pub struct MirrorPlate<'a> {
    /// The closed solid.
    pub mesh: &'a Mesh,
    /// Lower-left and upper-right corner of the optical area.
    pub area: (DVec2, DVec2),
    /// Middle of the optical area at its mean height: from there lamps and walls are measured.
    pub origin: DVec3,
    /// Whether light counts that the rim throws.
    pub rim_shines: bool,
    /// Beckmann's α of its metal; 0 is smooth.
    pub roughness: f64,
}

/// All that a renderer needs: mm, in the frame of the plate's file.
#[derive(Clone, Debug)]
pub struct LitPlate {
    /// What mirrors, with open rims.
    pub mirror: Mesh,
    /// The rest of the solid, which takes all light.
    pub body: Mesh,
    /// Beckmann's α of the mirror; 0 is smooth.
    pub roughness: f64,
    /// What the lamp sends.
    pub beam: Beam,
    /// What the light falls on.
    pub screen: Screen,
    /// Who looks at the screen.
    pub camera: Camera,
    /// Middle of the optical area at its mean height.
    pub middle: DVec3,
    /// Diagonal of the optical area.
    pub diagonal: f64,
    /// Unit vector to where a flat plate would throw the light.
    pub viewer: DVec3,
}

/// Triangles between two questions whether to go on.
const TRIANGLES_AT_A_TIME: usize = 1 << 16;

impl LitPlate {
    /// `plate` under `lamp`, whose places count from the plate's origin, its light on what is `shown`.
    pub fn new(plate: &MirrorPlate, lamp: &Lamp, shown: &Shown, progress: &Progress) -> Result<Self, Cancelled> {
        let (mirror, body) = parted(plate, progress)?;
        let diagonal = (plate.area.1 - plate.area.0).length();
        let (screen, camera) = shown.of(plate.origin, diagonal);
        let beam = Beam::of(lamp, plate, screen.flux());
        let viewer = flat_mirror(lamp.at(DVec3::ZERO).direction);
        let (middle, roughness) = (plate.origin, plate.roughness);
        Ok(Self { mirror, body, roughness, beam, screen, camera, middle, diagonal, viewer })
    }
}

/// The triangles that mirror, and the others: those that look up within the optical area and the walls between them, with
/// the rim where it shines; not the sides.
fn parted(plate: &MirrorPlate, progress: &Progress) -> Result<(Mesh, Mesh), Cancelled> {
    let MirrorPlate { mesh, area, rim_shines, .. } = *plate;
    let (low, high) = mesh.bounds();
    let (low, high) = (low.truncate(), high.truncate());
    // Single precision of the plate's size.
    let slack = 1e-6 * (high - low).max_element();
    let within = |at: DVec2, (from, to): (DVec2, DVec2)| (at.cmpge(from - slack) & at.cmple(to + slack)).all();
    let on_side = |corners: [DVec3; 3]| {
        (0..2).any(|axis| {
            corners.iter().all(|c| c[axis] <= low[axis] + slack)
                || corners.iter().all(|c| c[axis] >= high[axis] - slack)
        })
    };
    let (mut mirror, mut body) = (Part::of(mesh), Part::of(mesh));
    for (k, triangle) in mesh.triangles.iter().enumerate() {
        if k % TRIANGLES_AT_A_TIME == 0 {
            progress.check()?;
        }
        let corners = mesh.corners(k);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let shines = rim_shines || corners.iter().all(|corner| within(corner.truncate(), area));
        // Walls are vertical to single precision; the base looks straight down.
        let part = if shines && normal.z > -0.5 && !on_side(corners) { &mut mirror } else { &mut body };
        part.add(*triangle);
    }
    Ok((mirror.mesh, body.mesh))
}

/// Some triangles of a mesh, with the vertices that they need.
struct Part<'a> {
    whole: &'a Mesh,
    names: Vec<u32>,
    mesh: Mesh,
}

impl<'a> Part<'a> {
    fn of(whole: &'a Mesh) -> Self {
        Self { whole, names: vec![u32::MAX; whole.vertices.len()], mesh: Mesh::default() }
    }

    fn add(&mut self, triangle: [u32; 3]) {
        let corners = triangle.map(|v| {
            let name = &mut self.names[v as usize];
            if *name == u32::MAX {
                *name = self.mesh.vertices.len() as u32;
                self.mesh.vertices.push(self.whole.vertices[v as usize]);
            }
            *name
        });
        self.mesh.triangles.push(corners);
    }
}
