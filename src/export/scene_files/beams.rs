//! What a lamp sends over a plate, by lights that renderers have and without wasting any: parallel light from a sheet as wide
//! as the plate, or spots that shine on nothing else.

use std::f64::consts::TAU;
use std::io::{self, Write};

use glam::{DVec2, DVec3};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::MirrorPlate;
use crate::export::ply::write_ply;
use crate::golden::golden;
use crate::lamp::{Extent, Lamp, LocalLight, on_cap};
use crate::projection::carried_axes;
use crate::relief::mesh::Mesh;

/// Lamps further away than this many diagonals of the plate send parallel light: directions over the plate differ by
/// 0.03° either way. Spots that narrow are also the last that single precision can draw rays from.
const PARALLEL: f64 = 1000.0;

/// How far away the sheet stands that sends parallel light, diagonals of the plate.
const SHEET_AWAY: f64 = 3.0;

/// Tiles along a side of the sheet of a lamp with an extent, each of which shines one way: a facet of a thirtieth of the
/// plate sees about 240 directions.
const TILES: u32 = 512;

/// The plastic number, whose powers fill a square evenly as the golden section fills an interval.
const PLASTIC: f64 = 1.324_717_957_244_746;

/// Spots that stand for a ball nearby: 5 mm of it are then 0.4 mm apart.
const SPOTS: usize = 128;

/// By how much a spot's cone is wider than the plate, and what its 1 - cos is made larger by: two steps of single precision
/// at 1, by which a renderer may round it.
const WIDER: f64 = 1.05;
const ROUNDED: f64 = 1.2e-7;

/// What a lamp sends.
#[derive(Clone, Debug)]
pub enum Beam {
    /// Light of a lamp far away.
    Parallel(LampSheet),
    /// Light of a ball nearby: points, each of which shines alike within a cone about the plate's middle.
    Spots {
        /// Where they are, mm.
        places: Vec<DVec3>,
        /// Half angle of the cone, radians.
        cone: f64,
        /// Flux per steradian of each, in the unit of the image.
        intensity: f64,
        /// The ball's middle, mm.
        middle: DVec3,
    },
}

/// A sheet that shines along the normals of its triangles.
#[derive(Clone, Debug)]
pub struct LampSheet {
    /// One tile, or many where the lamp has an extent, each turned toward another part of it.
    pub mesh: Mesh,
    /// Flux per mm² across the beam, in the unit of the image.
    pub irradiance: f64,
    /// Unit vector to the lamp's middle.
    pub direction: DVec3,
}

impl Beam {
    /// Whether a lamp's light is taken as parallel over a plate of `diagonal` mm.
    pub fn is_parallel(lamp: &Lamp, diagonal: f64) -> bool {
        match lamp {
            Lamp::Ball { middle, .. } => middle.length() > PARALLEL * diagonal,
            Lamp::Distant(_) => true,
        }
    }

    /// Writes the sheet that shines as PLY, if there is one.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write(&self, mut out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Parallel(sheet) => write_ply(&sheet.mesh, &mut out),
            Self::Spots { .. } => Ok(()),
        }
    }

    /// The light of `lamp` that sends `flux` over the flat plate.
    pub(super) fn of(lamp: &Lamp, plate: &MirrorPlate, flux: f64) -> Self {
        let size = plate.area.1 - plate.area.0;
        let area = size.x * size.y;
        let seen = lamp.at(DVec3::ZERO);
        match *lamp {
            Lamp::Ball { middle, .. } if !Self::is_parallel(lamp, size.length()) => {
                let distance = middle.length();
                // On a disc across the way to the ball, in directions even over what is seen of it.
                let place = |l: DVec3| plate.origin + l * distance / l.dot(seen.direction);
                let places: Vec<DVec3> = directions(&seen, SPOTS).into_iter().map(place).collect();
                let widest = |at: &DVec3| {
                    let way = plate.origin - *at;
                    corners(plate).into_iter().map(|corner| way.angle_between(corner - *at)).fold(0.0, f64::max)
                };
                let cone = WIDER * places.iter().map(widest).fold(0.0, f64::max);
                let versed = 2.0 * (0.5 * cone).sin().powi(2) + ROUNDED;
                let cone = 2.0 * (0.5 * versed).sqrt().min(1.0).asin();
                let received = area * seen.direction.z / (distance * distance);
                let intensity = flux / (received * places.len() as f64);
                Self::Spots { cone: cone.min(1.5), intensity, middle: plate.origin + middle, places }
            }
            _ => Self::Parallel(LampSheet {
                mesh: sheet(&seen, plate),
                irradiance: flux / (area * seen.direction.z),
                direction: seen.direction,
            }),
        }
    }
}

/// The corners of a box around the optical area.
fn corners(plate: &MirrorPlate) -> [DVec3; 8] {
    let (low, high) = plate.mesh.bounds();
    let [x, y, z] = [[plate.area.0.x, plate.area.1.x], [plate.area.0.y, plate.area.1.y], [low.z, high.z]];
    std::array::from_fn(|k| DVec3::new(x[k & 1], y[(k >> 1) & 1], z[k >> 2]))
}

/// Unit vectors toward a lamp, even over it: one of a point, else `count`.
fn directions(light: &LocalLight, count: usize) -> Vec<DVec3> {
    match &*light.extent {
        Extent::Point => vec![light.direction],
        Extent::Disc { radius } => (0..count)
            .map(|k| on_cap(light.direction, *radius, (k as f64 + 0.5) / count as f64, TAU * golden(k)))
            .collect(),
        Extent::Picture(_) => {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
            (0..count).map(|_| light.sample(&mut random)).collect()
        }
    }
}

/// A sheet across the beam, wide enough for the plate; its triangles look along the light.
fn sheet(light: &LocalLight, plate: &MirrorPlate) -> Mesh {
    let (e1, e2) = carried_axes(light.direction);
    let away = SHEET_AWAY * (plate.area.1 - plate.area.0).length();
    let across =
        corners(plate).map(|corner| DVec2::new((corner - plate.origin).dot(e1), (corner - plate.origin).dot(e2)));
    let spread = DVec2::splat(away * light.extent.reach().tan().min(1.0));
    let low = across.into_iter().fold(DVec2::INFINITY, DVec2::min) - spread;
    let high = across.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max) + spread;
    let tiles = if light.extent.is_point() { 1 } else { TILES };
    let step = (high - low) / f64::from(tiles);
    let mut mesh = Mesh::default();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    for (i, j) in (0..tiles * tiles).map(|k| (k % tiles, k / tiles)) {
        // Tiles next to each other are near each other on the curve: so few of them hold the lamp evenly.
        let on_curve = fast_hilbert::xy2h(i, j, TILES.ilog2() as u8);
        let tile = match &*light.extent {
            Extent::Disc { radius } => on_disc(light.direction, *radius, on_curve as f64),
            Extent::Point | Extent::Picture(_) => light.sample(&mut random),
        };
        let first = low + step * DVec2::new(f64::from(i), f64::from(j));
        let from = |at: DVec2| plate.origin + away * light.direction + at.x * e1 + at.y * e2;
        let centre = from(first + 0.5 * step);
        let vertex = mesh.vertices.len() as u32;
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let corner = from(first + step * DVec2::new(x, y));
            // Along the beam onto the plane across this tile's own way.
            let turned = corner + light.direction * (centre - corner).dot(tile) / light.direction.dot(tile);
            mesh.vertices.push(turned.as_vec3().to_array());
        }
        // Clockwise seen from the lamp: their normals look to the plate.
        mesh.triangles.extend([[vertex, vertex + 2, vertex + 1], [vertex, vertex + 3, vertex + 2]]);
    }
    mesh
}

/// The `k`-th of a sequence of which any run fills a disc of angular `radius` (radians) evenly.
fn on_disc(middle: DVec3, radius: f64, k: f64) -> DVec3 {
    let [share, turn] = [k / PLASTIC, k / PLASTIC.powi(2)].map(f64::fract);
    on_cap(middle, radius, share, TAU * turn)
}
