//! The screen that light falls on, and the camera that looks at it.

use std::io::{self, Write};

use glam::{DVec2, DVec3};

use crate::export::ply::write_grey_ply;
use crate::projection::Projection;
use crate::relief::mesh::Mesh;
use crate::scene::WallPicture;
use crate::setup::Setup;

/// From the plate to a screen that stands for viewers endlessly far, diagonals of the plate: places on the plate then
/// differ by 0.0014° either way. At 1000 a dome of 900 facets, whose place goes with their slope, is seen too large by 0.1 %:
/// TV(1°) 0.0048 beside the proof, and 0.0008 at 20,000.
const FAR: f64 = 20_000.0;

/// From such a screen to its camera, in ways from the plate to the screen: what is nearer looks larger by 0.03 %.
const CAMERA_FAR: f64 = 1000.0;

/// Squares along a side of such a screen.
const SQUARES: usize = 96;

/// Share of light that a screen throws back where it is brightest. A curved one lights itself; this much of that is left.
const REFLECTANCE: f64 = 0.01;

/// The flattest that a screen may lie to its camera, as a cosine.
const FLATTEST: f64 = 0.02;

/// Step for differences, in image coordinates.
const STEP: f64 = 1e-4;

/// From a wall to its camera, in widths of the picture.
const CAMERA_OF_WALL: f64 = 1.0;

/// Where the light is looked at.
#[derive(Clone, Copy, Debug)]
pub enum Shown<'a> {
    /// Endlessly far: the highlight image of this setup.
    Far(&'a Setup, Facing),
    /// On a wall, as someone in front of it sees it.
    Wall(&'a WallPicture),
}

/// From which side a far image is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// As a map of viewers, from above the plate.
    FromAbove,
    /// From the plate's side.
    FromPlate,
}

/// A matt surface.
#[derive(Clone, Debug)]
pub struct Screen {
    /// Its triangles look to the plate.
    pub mesh: Mesh,
    /// Share of the light that each vertex throws back.
    pub reflectance: Vec<f32>,
    /// Whether it is a wall nearby.
    pub is_wall: bool,
    /// What its brightest part throws back.
    pub most: f64,
    /// Area of the image as the camera sees it, mm².
    pub area: f64,
}

impl Screen {
    /// Writes it as PLY, what it throws back as colours.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write(&self, mut out: &mut dyn Write) -> io::Result<()> {
        write_grey_ply(&self.mesh, &self.reflectance, &mut out)
    }

    /// The flux that, spread evenly over the image, looks as bright as 1.
    pub(super) fn flux(&self) -> f64 {
        std::f64::consts::PI * self.area / self.most
    }
}

/// A pinhole that looks at the screen.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Where it stands, mm.
    pub eye: DVec3,
    /// A point that it looks at.
    pub target: DVec3,
    /// What is up in its image.
    pub up: DVec3,
    /// Whole angle of its image, radians.
    pub field: f64,
    /// Whether left and right are exchanged.
    pub mirrored: bool,
    /// Nearest and furthest that it sees, mm.
    pub clip: [f64; 2],
}

impl Shown<'_> {
    /// The screen and its camera for a plate of `diagonal` mm whose light is measured from `origin`.
    pub(super) fn of(&self, origin: DVec3, diagonal: f64) -> (Screen, Camera) {
        match *self {
            Self::Far(setup, facing) => far(setup, facing, origin, FAR * diagonal),
            Self::Wall(wall) => on_wall(wall, origin),
        }
    }
}

fn on_wall(wall: &WallPicture, origin: DVec3) -> (Screen, Camera) {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(u, v)| wall.point(DVec2::new(u, v)));
    let vertices = corners.map(|corner| (origin + corner).as_vec3().to_array()).to_vec();
    // u runs to the left: turned so, triangles look to the plate.
    let mesh = Mesh { vertices, triangles: vec![[0, 2, 1], [0, 3, 2]] };
    let side = 2.0 * wall.half;
    let reflectance = vec![REFLECTANCE as f32; 4];
    let screen = Screen { mesh, reflectance, is_wall: true, most: REFLECTANCE, area: side * side };
    let away = CAMERA_OF_WALL * side;
    let target = origin + wall.centre;
    let camera = Camera {
        eye: target - away * wall.normal(),
        target,
        up: wall.v,
        field: 2.0 * (wall.half / away).atan(),
        mirrored: false,
        clip: [0.5 * away, 2.0 * away],
    };
    (screen, camera)
}

/// A screen `away` mm from the plate's middle.
fn far(setup: &Setup, facing: Facing, origin: DVec3, away: f64) -> (Screen, Camera) {
    let [_, e2, axis] = setup.image_axes();
    // A point of the screen: toward o, as far off the axis as its place in the image.
    let place = |uv: DVec2| {
        let o = setup.viewer_at(uv)?;
        let along = o.dot(axis);
        let times = match setup.view().projection() {
            Projection::Orthographic => 1.0,
            Projection::Screen => 1.0 / along,
            Projection::Equidistant => {
                let sine = o.cross(axis).length();
                if sine > 1e-9 { sine.atan2(along) / sine } else { 1.0 }
            }
        };
        (along > FLATTEST).then(|| away * times * o)
    };
    let slant = |uv: DVec2| {
        let difference = |step: DVec2| Some(place(uv + step)? - place(uv - step)?);
        let normal = difference(STEP * DVec2::X)?.cross(difference(STEP * DVec2::Y)?).normalize_or_zero();
        Some(normal.dot(axis)).filter(|cosine| *cosine > FLATTEST)
    };
    let side = SQUARES + 1;
    let at = |k: usize| 2.0 * DVec2::new((k % side) as f64, (k / side) as f64) / SQUARES as f64 - 1.0;
    let points: Vec<Option<(DVec3, f64)>> = (0..side * side).map(|k| Some((place(at(k))?, slant(at(k))?))).collect();
    let flattest = points.iter().flatten().map(|point| point.1).fold(1.0, f64::min);
    let mut mesh = Mesh::default();
    let mut reflectance = Vec::new();
    for point in &points {
        // A place that no light can reach has no square either.
        let (at, cosine) = point.unwrap_or((DVec3::ZERO, 1.0));
        mesh.vertices.push((origin + at).as_vec3().to_array());
        // What is seen slanting gathers more pixels' light to the mm².
        reflectance.push((REFLECTANCE * flattest / cosine) as f32);
    }
    for k in (0..SQUARES * SQUARES).map(|k| k / SQUARES * side + k % SQUARES) {
        let corners = [k, k + 1, k + side + 1, k + side];
        if corners.iter().all(|corner| points[*corner].is_some()) {
            let [a, b, c, d] = corners.map(|corner| corner as u32);
            // Seen along the axis from the plate u and v turn clockwise: so these look to the plate.
            mesh.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    let half = away * setup.view().image_scale();
    let screen = Screen { mesh, reflectance, is_wall: false, most: REFLECTANCE * flattest, area: 4.0 * half * half };
    let middle = setup.viewer_at(DVec2::ZERO).unwrap_or(axis);
    let behind = CAMERA_FAR * away;
    // Beside the axis by as much as the image's middle.
    let beside = away * (middle - middle.dot(axis) * axis);
    let camera = Camera {
        eye: origin + beside - behind * axis,
        target: origin + beside,
        up: e2,
        field: 2.0 * (half / (behind + away * middle.dot(axis))).atan(),
        mirrored: facing == Facing::FromAbove,
        clip: [0.5 * behind, 2.0 * behind],
    };
    (screen, camera)
}
