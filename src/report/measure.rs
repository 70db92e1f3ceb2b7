//! The report of a measurement.

use serde::Serialize;

use super::{MeshFacts, Named};
use crate::brdf::material::Material;
use crate::export::bsdf::BsdfFacts;
use crate::projection::Projection;
use crate::recipe::LightSettings;

/// What light does on a plate.
#[derive(Clone, Debug, Serialize)]
pub struct MeasureReport {
    /// The program and its version.
    pub program: &'static str,
    /// The mesh.
    pub plate: MeshFacts,
    /// Whether the plate ends or goes on without end.
    pub extent: &'static str,
    /// What it is made of.
    pub material: Material,
    /// The distant lamp; `None` where light comes from all sides or from none.
    pub light: Option<LightSettings>,
    /// The picture that the lamp looks like, if it is one.
    pub lamp: Option<LampFacts>,
    /// Bounces followed.
    pub max_bounces: u32,
    /// Seed of the rays.
    pub seed: u64,
    /// The figures.
    pub measured: Measured,
    /// What a person should know; empty if nothing is off.
    pub advice: Vec<String>,
}

/// A lamp that looks like a picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LampFacts {
    /// Its file.
    pub picture: String,
    /// From its middle to its rim, degrees.
    pub half_field: f64,
}

/// The figures of one kind of measurement; `kind` says of which.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Measured {
    /// The highlight of one lamp.
    Highlight(HighlightImageFacts),
    /// The BRDF over all directions.
    Brdf(BrdfFacts),
    /// The distribution of normals.
    Ndf(NdfFacts),
    /// The reflection on a wall.
    Wall(WallFacts),
    /// What a camera sees.
    #[serde(rename = "look")]
    View(ViewFacts),
}

/// The highlight of one lamp.
#[derive(Clone, Debug, Serialize)]
pub struct HighlightImageFacts {
    /// How directions are laid out on the image.
    pub projection: Projection,
    /// From its middle to its rim, degrees.
    pub half_field: f64,
    /// Pixels along a side.
    pub resolution: usize,
    /// What the files' pixels hold.
    pub pixels: &'static str,
    /// Rays that came in.
    pub rays: u64,
    /// Share of the light that chance alone puts into a wrong pixel.
    pub image_noise_tv: f64,
    /// What the light came to, as shares of incident light.
    pub shares_of_incident: Named,
    /// Their standard errors.
    pub standard_errors: Named,
    /// Share of incident light that met a face from behind.
    pub backface: f64,
    /// All shares together, which is 1 but for rounding.
    pub balance: f64,
}

/// The BRDF over all directions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BrdfFacts {
    /// Rays from each direction of light.
    pub rays_each: u64,
    /// Cells of half vectors, along the polar angle and around.
    pub half_vectors: [usize; 2],
    /// Smallest value, 1/sr.
    pub least: f64,
    /// Greatest albedo.
    pub greatest_albedo: f64,
    /// Its standard error.
    pub greatest_albedo_error: f64,
    /// Mean difference when light and viewer change places.
    pub reciprocity_error: f64,
    /// About how much of that is noise of the rays.
    pub reciprocity_noise: f64,
    /// About how many rays from each direction bring that noise to 5 %.
    pub rays_each_for_5_percent: u64,
    /// What brdf.bsdf holds of it.
    pub bsdf: BsdfFacts,
    /// What light from each direction came to.
    pub directions: Vec<DirectionFacts>,
}

/// What light from one direction came to, as shares of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DirectionFacts {
    /// Polar angle, degrees.
    pub theta_deg: f64,
    /// Azimuth, degrees.
    pub phi_deg: f64,
    /// Left upward.
    pub albedo: f64,
    /// Of what left upward, after more than one bounce.
    pub multi_bounce: f64,
    /// Taken by the material.
    pub taken: f64,
    /// Still bouncing after the last bounce followed.
    pub trapped: f64,
    /// Left past the plate's edges.
    pub past_edges: f64,
    /// Left so near the horizon that no cell holds it.
    pub unheld: f64,
}

/// The distribution of normals.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NdfFacts {
    /// Rays from each direction of view.
    pub rays_each: u64,
    /// Root mean square of the slope along x and y.
    pub rms_slope: [f64; 2],
    /// Roughness of the Beckmann lobe with these slopes.
    pub beckmann_alpha: [f64; 2],
    /// Share of the surface's area beyond that of the plate.
    pub excess_area: f64,
    /// Slope at the rim of the picture.
    pub picture_rim_slope: f64,
    /// Share of what faces the viewer that is seen, under the viewer's polar angle in degrees.
    pub seen_at_deg: Named,
}

/// The reflection on a wall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WallFacts {
    /// From the plate's middle, mm.
    pub wall_distance_mm: f64,
    /// Turn about its horizontal axis, degrees.
    pub wall_tilt_deg: f64,
    /// From the plate's middle to the lamp, mm; `None` if it is distant.
    pub lamp_distance_mm: Option<f64>,
    /// Radius of the lamp, mm.
    pub lamp_radius_mm: f64,
    /// Width of the picture, mm.
    pub width_mm: f64,
    /// Pixels along a side.
    pub resolution: usize,
    /// What the files' pixels hold.
    pub pixels: &'static str,
    /// Whether wall.png is turned left for right.
    pub mirrored: bool,
    /// Share of the light that lands in the picture.
    pub in_picture: f64,
    /// Its standard error.
    pub in_picture_error: f64,
    /// Share that lands on the wall beyond the picture.
    pub beside_picture: f64,
    /// Share that meets no wall.
    pub on_no_wall: f64,
    /// Spot that a flat mirror in the plate's place would throw, mm.
    pub blur_by_plate_mm: [f64; 2],
    /// The lamp's image as through a pinhole, mm.
    pub blur_by_lamp_mm: [f64; 2],
    /// The former as angles, degrees.
    pub blur_by_plate_deg: [f64; 2],
    /// The latter as an angle, degrees.
    pub blur_by_lamp_deg: f64,
    /// Share of the light that chance alone puts into a wrong pixel.
    pub image_noise_tv: f64,
    /// Rays that came in.
    pub rays: u64,
}

/// What a camera sees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViewFacts {
    /// Where it stands: polar angle and azimuth, degrees.
    pub camera_deg: [f64; 2],
    /// From the plate's middle, mm.
    pub distance_mm: f64,
    /// Angle across the picture, degrees.
    pub field_of_view_deg: f64,
    /// What the relief is wrapped on.
    pub shape: ShapeFacts,
    /// Radiance of the surroundings, 1/sr.
    pub ambient: f64,
    /// Paths for each pixel.
    pub paths_a_pixel: u32,
    /// What the files' pixels hold.
    pub pixels: &'static str,
    /// Mean over the picture, 1/sr.
    pub mean_radiance: f64,
    /// Mean standard error of a pixel, 1/sr.
    pub mean_error: f64,
    /// In the brightest pixel, 1/sr.
    pub greatest_radiance: f64,
    /// Mean share of light still bouncing at the end.
    pub mean_trapped: f64,
}

/// What a relief is wrapped on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub enum ShapeFacts {
    /// Nothing.
    #[serde(rename = "flat")]
    Flat,
    /// A ball of this radius, mm.
    #[serde(rename = "sphere_radius_mm")]
    Sphere(f64),
    /// A cylinder of this radius, mm.
    #[serde(rename = "cylinder_radius_mm")]
    Cylinder(f64),
}
