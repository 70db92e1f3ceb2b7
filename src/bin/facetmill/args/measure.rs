//! The flags of `facetmill measure`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Arg, ArgGroup, Args};
use facetmill::brdf::material::Material;
use facetmill::recipe::settings::Setting;
use facetmill::verify::render::Shape;

use super::settings::{SettingFlags, Takes, explained, seed_of_rays};
use super::{PlacingArgs, RunningArgs};
use crate::values::*;

/// Heading of the flags that say what is measured.
const WHAT: &str = "What to measure, one of (default: the highlight of one lamp)";

/// What --rays means here.
const RAYS: &str = "Rays sent over the plate  \
    [default: 2000000; --brdf: 200000 for each light; --ndf: 200000 for each viewer; --look: 256, which is for each pixel]";

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("what").args(["brdf", "ndf", "wall", "look"])))]
pub struct MeasureArgs {
    /// A closed mesh in mm (STL, OBJ, PLY, 3MF, OFF), relief toward +z; or the folder of a design, whose recipe then gives
    /// lamp and field
    pub plate: PathBuf,
    /// Folder for the results; made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,

    /// The BRDF in 1/sr over all directions of light and viewer, as by a gonioreflectometer
    ///
    /// Writes brdf.bsdf (RGL, which Mitsuba's `measured` loads), brdf.csv, slices.png and maps.png, and brdf.binary
    /// (MERL) if the plate looks the same however it is turned. Lamp flags have no say: light comes from all sides.
    #[arg(long, help_heading = WHAT)]
    pub brdf: bool,
    /// The distribution of the relief's normals (NDF), and how much of it is seen from where
    ///
    /// Writes ndf.png (slopes, x right, y up), ndf.csv and masking.csv. The material has no say.
    #[arg(long, help_heading = WHAT)]
    pub ndf: bool,
    /// The reflection on a wall this far from the plate's middle, mm
    ///
    /// The wall stands square to where a flat plate would throw the light. Writes wall.png with a scale in mm, wall.tiff
    /// (irradiance as a multiple of that on the plate) and wall_error.tiff; tells by how much finite distances blur.
    #[arg(long, value_name = "MM", help_heading = WHAT, value_parser = number)]
    pub wall: Option<f64>,
    /// A picture of the plate, or of a ball or cylinder that wears its relief, as a person sees it
    ///
    /// Writes look.png, look.tiff (radiance in 1/sr for a lamp of irradiance 1) and look_error.tiff. A mirror shows a
    /// lamp without size nowhere: give --light-radius or a rough --material.
    #[arg(long, help_heading = WHAT)]
    pub look: bool,

    /// What the plate is made of, such as aluminium or brass:ggx:0.2  [default: a mirror with the --lobe]
    ///
    /// A substance, and if its surface is not smooth, how rough it is. Smooth: `mirror` (takes no light), a metal,
    /// `acrylic`, `dielectric:1.5` (index of refraction), `conductor:1.2,6.9` (index and absorption), `paint:0.8` (a
    /// glossy coat over a matt base of that albedo). Matt: `diffuse:0.5`. Rough: `brass:ggx:0.2`,
    /// `gold:beckmann:0.1,0.3`; the number is the roughness alpha, two are along x and y: polished 0.02, worn 0.1,
    /// brushed 0.1,0.3. Metals: aluminium, brass, chrome, copper, gold, iron, nickel, silver, steel; `gold@650` is gold
    /// in light of 650 nm instead of 550. Or a model by name: `ward:0.1,0.3:0.8` (the last is the share that it reflects),
    /// `lambert:0.3+ggx:0.2:schlick=0.04`; docs/goals.md has all of them.
    #[arg(long, value_name = "MATERIAL", help_heading = "Plate", value_parser = material, conflicts_with = "ndf")]
    pub material: Option<Material>,
    /// Rim that is no optical area and is not lit, mm  [default: the design's --border if left dull, else 0]
    #[arg(long, value_name = "MM", help_heading = "Plate", value_parser = number)]
    pub margin: Option<f64>,
    #[command(flatten)]
    pub placing: PlacingArgs,
    /// The plate as it is, or repeated without end  [default: endless for --brdf and --wrap, else finite]
    ///
    /// Only a relief on a rectangular grid, as `design` makes, can be repeated; any other is measured as it is.
    #[arg(long, value_enum, value_name = "EXTENT", help_heading = "Plate")]
    pub extent: Option<ExtentArg>,

    /// A distant lamp that looks like this picture: a window, a softbox, a neon sign
    ///
    /// The picture is laid on the sky around --light, as seen from above the plate. Any kind of picture that `design` takes.
    #[arg(long, value_name = "PICTURE", help_heading = "Light", conflicts_with_all = ["light-radius", "brdf", "ndf"])]
    pub lamp: Option<PathBuf>,
    /// Angle from the middle of the --lamp picture to its rim, degrees, 0.01 to 60  [default: 5]
    #[arg(long, value_name = "DEG", help_heading = "Light", value_parser = number, requires = "lamp")]
    pub lamp_half_field: Option<f64>,

    /// Pixels a side of the picture, 16 to 4096 (--wall: 2048)  [default: 256]
    #[arg(long, value_name = "N", help_heading = "Image", value_parser = count, conflicts_with = "brdf")]
    pub resolution: Option<usize>,

    /// How many polar angles light comes from, spread over 0 to 88 degrees, at least 2  [default: 16]
    #[arg(long, value_name = "N", help_heading = "BRDF", value_parser = count, requires = "brdf")]
    pub polar: Option<usize>,
    /// How many azimuths it comes from: 4 to 360, or 1 for a plate that looks the same however turned  [default: 16]
    #[arg(long, value_name = "N", help_heading = "BRDF", value_parser = count, requires = "brdf")]
    pub azimuths: Option<usize>,
    /// How finely viewers are told apart: cells of half vectors  [default: 128x64]
    ///
    /// A half vector points midway between light and viewer. The first number is along its angle from the normal (finer
    /// toward the normal), the second around it. More cells resolve finer lobes and need more --rays.
    #[arg(long, value_name = "NxM", help_heading = "BRDF", value_parser = counts, requires = "brdf")]
    pub half_vectors: Option<[usize; 2]>,

    /// From the plate's middle to the lamp, mm; --light says in which direction  [default: endlessly far]
    #[arg(long, value_name = "MM", help_heading = "Wall", value_parser = number, requires = "wall", conflicts_with = "lamp")]
    pub lamp_distance: Option<f64>,
    /// Radius of a lamp at --lamp-distance, mm  [default: 0, a point]
    #[arg(long, value_name = "MM", help_heading = "Wall", value_parser = number, requires = "lamp_distance")]
    pub lamp_radius: Option<f64>,
    /// Turn of the wall about its horizontal axis, its upper edge away from the plate, degrees, -85 to 85  [default: 0]
    #[arg(long, value_name = "DEG", help_heading = "Wall", value_parser = number, requires = "wall")]
    pub wall_tilt: Option<f64>,
    /// Width of the wall's picture, mm  [default: all of the highlight image and its blur]
    #[arg(long, value_name = "MM", help_heading = "Wall", value_parser = number, requires = "wall")]
    pub wall_width: Option<f64>,
    /// Where the camera stands: degrees from the plate's normal, 0 to 89.9, azimuth from +x  [default: 0,0]
    #[arg(long, value_name = "THETA,PHI", help_heading = "Look", value_parser = angles, allow_hyphen_values = true, requires = "look")]
    pub camera: Option<[f64; 2]>,
    /// From the camera to the plate's middle, or to the centre of what it is wrapped on, mm  [default: 500]
    #[arg(long, value_name = "MM", help_heading = "Look", value_parser = number, requires = "look")]
    pub distance: Option<f64>,
    /// Angle across the picture, degrees, up to 160  [default: all of the plate]
    #[arg(long, value_name = "DEG", help_heading = "Look", value_parser = number, requires = "look")]
    pub field: Option<f64>,
    /// Wrap the relief, repeated without end, on a ball or a cylinder: sphere:40, cylinder:25, radius in mm
    ///
    /// The relief stands for a material, much finer than the shape. The cylinder lies along y.
    #[arg(long, value_name = "SHAPE:MM", help_heading = "Look", requires = "look")]
    pub wrap: Option<Wrap>,
    /// Radiance of the surroundings, 1/sr, for a lamp of irradiance 1  [default: 0]
    ///
    /// 0.05 is a lit room around a spotlight: facets that miss the lamp are no longer black.
    #[arg(long, value_name = "L", help_heading = "Look", value_parser = number, requires = "look")]
    pub ambient: Option<f64>,

    #[command(flatten)]
    pub running: RunningArgs,
    /// Go on until the rays' own noise is this small, such as 0.002  [default: stop after --rays]
    ///
    /// The noise is the share of light (total variation) that chance alone puts into the wrong pixel or cell. Rays are
    /// doubled until it is reached, at most to 4096 times --rays.
    #[arg(long, value_name = "TV", help_heading = "Running", value_parser = number, conflicts_with_all = ["ndf", "look"])]
    pub error: Option<f64>,
    /// Bounces followed, 1 to 1000; light that wants more is told as trapped  [default: 8]
    #[arg(long, value_name = "N", help_heading = "Running", value_parser = whole, conflicts_with = "ndf")]
    pub max_bounces: Option<u64>,

    #[command(flatten)]
    pub settings: SettingFlags<ByMeasure>,
}

impl MeasureArgs {
    /// Rays, if the flag was given.
    pub fn rays(&self) -> Option<u64> {
        self.settings.has("rays").then(|| self.settings.alone().verify.rays)
    }
}

/// `facetmill measure` takes what the lamp, the metal and the image are, and how light is sent.
#[derive(Clone, Copy, Debug)]
pub struct ByMeasure;

impl Takes for ByMeasure {
    fn takes(setting: &Setting) -> bool {
        ["half-field", "projection", "seen", "light", "light-radius", "lobe", "seed", "rays"].contains(&setting.name)
    }

    fn shown(setting: &Setting, flag: Arg) -> Arg {
        // Before what this command alone has under the same heading.
        let flag = flag.display_order(0);
        let usual = |flag| explained(flag, setting, "the design's, else ");
        match setting.name {
            "rays" => flag.help(RAYS),
            "seed" => seed_of_rays(flag, setting),
            "lobe" => usual(flag).help_heading("Plate").conflicts_with_all(["material", "ndf"]),
            "light" => usual(flag).help_heading("Light").conflicts_with_all(["brdf", "ndf"]),
            "light-radius" => usual(flag).help_heading("Light").conflicts_with_all(["brdf", "ndf", "lamp_distance"]),
            "half-field" => usual(flag).help_heading("Image").conflicts_with_all(["brdf", "ndf", "look"]),
            "projection" => usual(flag).help_heading("Image").conflicts_with_all(["brdf", "ndf", "wall", "look"]),
            _ => usual(flag).help_heading("Wall").requires("wall"),
        }
    }
}

/// What a relief is wrapped on.
#[derive(Clone, Copy, Debug)]
pub struct Wrap(Shape);

impl From<Wrap> for Shape {
    fn from(wrap: Wrap) -> Self {
        wrap.0
    }
}

impl FromStr for Wrap {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (shape, radius) = text.split_once(':').ok_or("write a shape and its radius in mm, such as sphere:40")?;
        let radius = number(radius)?;
        match shape {
            "sphere" => Ok(Self(Shape::Sphere { radius })),
            "cylinder" => Ok(Self(Shape::Cylinder { radius })),
            _ => Err("write sphere or cylinder and a radius in mm, such as sphere:40".into()),
        }
    }
}

/// What the plate is made of; what would do is in the library's own sentence.
fn material(text: &str) -> Result<Material, String> {
    text.parse().map_err(|error: facetmill::brdf::material::MaterialError| error.to_string())
}
