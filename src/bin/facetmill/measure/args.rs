//! The flags of `facetmill measure`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{ArgGroup, Args};
use facetmill::brdf::material::Material;
use facetmill::verify::look::Shape;

use crate::args::RunningArgs;
use crate::values::*;

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("what").args(["brdf", "ndf", "wall", "look"])))]
pub struct MeasureArgs {
    /// A closed STL in mm, relief toward +z; or the folder of a design, whose light and field then are the defaults
    pub plate: PathBuf,
    /// Folder for the results; made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,

    /// The BRDF over all directions of light and viewer, as by a gonioreflectometer
    #[arg(long, help_heading = "What to measure (default: the highlight of one lamp)")]
    pub brdf: bool,
    /// The distribution of the relief's normals, and how much of it is seen from where
    #[arg(long, help_heading = "What to measure (default: the highlight of one lamp)")]
    pub ndf: bool,
    /// The reflection on a wall this far from the plate's middle, mm
    #[arg(long, value_name = "MM", help_heading = "What to measure (default: the highlight of one lamp)", value_parser = number)]
    pub wall: Option<f64>,
    /// A picture of the plate as a person sees it
    #[arg(long, help_heading = "What to measure (default: the highlight of one lamp)")]
    pub look: bool,

    /// What the plate is made of  [default: mirror]
    ///
    /// A substance, and if its surface is not smooth a lobe: `aluminium`, `brass:ggx:0.2`, `gold:beckmann:0.1,0.3`,
    /// `acrylic`, `paint:0.8:ggx:0.3`, `diffuse:0.5`, `conductor:1.2,6.9`, `mirror:ggx:0.1`. Metals: aluminium, brass,
    /// chrome, copper, gold, iron, nickel, silver, steel; `gold@650` is gold in light of 650 nm instead of 550.
    #[arg(long, value_name = "MATERIAL", help_heading = "Plate", value_parser = material)]
    pub material: Option<Material>,
    /// Rim that is not optical area, mm  [default: 0]
    #[arg(long, value_name = "MM", help_heading = "Plate", value_parser = number)]
    pub margin: Option<f64>,
    /// The plate as it is, or repeated without end  [default: endless for --brdf, finite for all else]
    #[arg(long, value_enum, value_name = "EXTENT", help_heading = "Plate")]
    pub extent: Option<ExtentArg>,

    /// The lamp: degrees from the plate's normal, azimuth from +x  [default: 0,0]
    #[arg(long, value_name = "THETA,PHI", help_heading = "Light", value_parser = angles, allow_hyphen_values = true)]
    pub light: Option<[f64; 2]>,
    /// Angular radius of a distant lamp, degrees; the sun has 0.2665  [default: 0]
    #[arg(long, value_name = "DEG", help_heading = "Light", value_parser = number)]
    pub light_radius: Option<f64>,
    /// A lamp as bright as this picture, laid out like a highlight image around the lamp's middle
    #[arg(long, value_name = "PICTURE", help_heading = "Light", conflicts_with = "light_radius")]
    pub lamp: Option<PathBuf>,
    /// Angle from the middle of --lamp to its rim, degrees  [default: 5]
    #[arg(long, value_name = "DEG", help_heading = "Light", value_parser = number, requires = "lamp")]
    pub lamp_half_field: Option<f64>,

    /// Angle from the image's middle to its rim, degrees  [default: 20]
    #[arg(long, value_name = "DEG", help_heading = "Highlight", value_parser = number)]
    pub half_field: Option<f64>,
    /// How directions are laid out on the image  [default: orthographic]
    #[arg(long, value_enum, value_name = "HOW", help_heading = "Highlight")]
    pub projection: Option<ProjectionArg>,
    /// Pixels a side of any picture  [default: 256]
    #[arg(long, value_name = "N", help_heading = "Highlight", value_parser = count)]
    pub resolution: Option<usize>,

    /// Polar angles of light, from 0 to 88 degrees  [default: 16]
    #[arg(long, value_name = "N", help_heading = "BRDF", value_parser = count, requires = "brdf")]
    pub polar: Option<usize>,
    /// Azimuths of light; 1 for a plate that looks the same however it is turned  [default: 16]
    #[arg(long, value_name = "N", help_heading = "BRDF", value_parser = count, requires = "brdf")]
    pub azimuths: Option<usize>,
    /// Cells of half vectors: along the polar angle (finer toward the normal), around the azimuth  [default: 128x64]
    #[arg(long, value_name = "NxM", help_heading = "BRDF", value_parser = counts, requires = "brdf")]
    pub half_vectors: Option<[usize; 2]>,

    /// From the plate's middle to the lamp, mm  [default: endlessly far]
    #[arg(long, value_name = "MM", help_heading = "Wall", value_parser = number, requires = "wall", conflicts_with = "lamp")]
    pub lamp_distance: Option<f64>,
    /// Radius of a lamp at --lamp-distance, mm  [default: 0]
    #[arg(long, value_name = "MM", help_heading = "Wall", value_parser = number, requires = "lamp_distance")]
    pub lamp_radius: Option<f64>,
    /// Turn of the wall about its horizontal axis, its upper edge away from the plate, degrees  [default: 0]
    #[arg(long, value_name = "DEG", help_heading = "Wall", value_parser = number, requires = "wall")]
    pub wall_tilt: Option<f64>,
    /// Width of the wall's picture, mm  [default: as wide as the highlight]
    #[arg(long, value_name = "MM", help_heading = "Wall", value_parser = number, requires = "wall")]
    pub wall_width: Option<f64>,
    /// Thrown on a wall, a picture meant to be seen from above the plate is mirrored; on-wall shows it as it is seen there
    #[arg(long, value_enum, value_name = "SIDE", help_heading = "Wall", requires = "wall")]
    pub seen: Option<SeenArg>,

    /// Where the camera stands: degrees from the plate's normal, azimuth from +x  [default: 0,0]
    #[arg(long, value_name = "THETA,PHI", help_heading = "Look", value_parser = angles, allow_hyphen_values = true, requires = "look")]
    pub camera: Option<[f64; 2]>,
    /// From the camera to the plate's middle, or to the centre of what it is wrapped on, mm  [default: 500]
    #[arg(long, value_name = "MM", help_heading = "Look", value_parser = number, requires = "look")]
    pub distance: Option<f64>,
    /// Angle across the picture, degrees  [default: all of the plate]
    #[arg(long, value_name = "DEG", help_heading = "Look", value_parser = number, requires = "look")]
    pub field: Option<f64>,
    /// Wrap the relief, repeated without end, on a ball or a cylinder: `sphere:40`, `cylinder:25`, radius in mm
    #[arg(long, value_name = "SHAPE:MM", help_heading = "Look", requires = "look")]
    pub wrap: Option<Wrap>,
    /// Radiance of the surroundings, 1/sr, for a lamp of irradiance 1  [default: 0]
    #[arg(long, value_name = "L", help_heading = "Look", value_parser = number, requires = "look")]
    pub ambient: Option<f64>,

    #[command(flatten)]
    pub running: RunningArgs,
    /// Go on until the rays' own noise in the image is this small (total variation), at most 4000 times --rays
    #[arg(long, value_name = "TV", help_heading = "Running", value_parser = number)]
    pub error: Option<f64>,
    /// Bounces followed; what wants more is told  [default: 8]
    #[arg(long, value_name = "N", help_heading = "Running", value_parser = whole)]
    pub max_bounces: Option<u64>,
    /// Seed of the rays  [default: 1]
    #[arg(long, value_name = "N", help_heading = "Running", value_parser = whole)]
    pub seed: Option<u64>,
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
