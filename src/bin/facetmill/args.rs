//! The command line, and how it becomes a recipe.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand, ValueEnum};
use facetmill::facets::sample::Sampling;
use facetmill::highlight::Quantity;
use facetmill::picture::{Encoding, Fit};
use facetmill::projection::Projection;
use facetmill::recipe::{Arrangement, Heights, Recipe, Seen, SurfaceKind};

/// Turns a drawn highlight into a relief that can be milled and that really reflects it.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 110, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Design a plate whose reflection is the picture; write STL, pictures and a report
    ///
    /// Exit codes: 0 done, 2 wrong usage, 3 input cannot be read or makes no sense, 4 cannot be made as asked,
    /// 5 output cannot be written.
    #[command(after_help = "Example: facetmill design ring.png -o ring --half-field 20 --size 30x30 --facets 30x30")]
    Design(Box<DesignArgs>),
    /// Trace light over any closed STL (mm) and score it against a picture
    #[command(after_help = "Example: facetmill verify ring/plate.stl --against ring.png -o proof --half-field 20")]
    Verify(Box<VerifyArgs>),
}

#[derive(Debug, Args)]
pub struct DesignArgs {
    /// The highlight: PNG, JPEG, TIFF or WebP, bright where light shall be
    #[arg(required_unless_present = "recipe")]
    pub picture: Option<PathBuf>,
    /// Folder for the results
    #[arg(short = 'o', long = "output", value_name = "DIR", required_unless_present = "dry_run")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub optics: OpticsArgs,

    /// Optical area along x and y, mm  [default: 30x30]
    #[arg(long, value_name = "WxH", help_heading = "Plate")]
    size: Option<Pair<f64, 'x'>>,
    /// Facets along x and y on the whole plate  [default: 30x30]
    #[arg(long, value_name = "NxM", help_heading = "Plate")]
    facets: Option<Pair<usize, 'x'>>,
    /// Repeat the whole highlight in K x K cells  [default: 1]
    #[arg(long, value_name = "K", help_heading = "Plate")]
    cells: Option<usize>,
    /// Solid metal under the lowest point, mm  [default: 5]
    #[arg(long, value_name = "MM", help_heading = "Plate", allow_negative_numbers = true)]
    thickness: Option<f64>,
    /// Flat rim around the optical area, mm  [default: 0]
    #[arg(long, value_name = "MM", help_heading = "Plate", allow_negative_numbers = true)]
    border: Option<f64>,
    /// Kind of relief: planar facets  [default: flat]
    #[arg(long, value_enum, help_heading = "Plate")]
    surface: Option<SurfaceArg>,

    /// How facets are drawn from the highlight  [default: voronoi]
    #[arg(long, value_enum, help_heading = "Design")]
    sample: Option<SampleArg>,
    /// Which facet goes where  [default: transport]
    #[arg(long, value_enum, help_heading = "Design")]
    arrange: Option<ArrangeArg>,
    /// How heights follow from slopes  [default: free, cyclic with --arrange anneal]
    #[arg(long, value_enum, help_heading = "Design")]
    heights: Option<HeightsArg>,
    /// Set every choice to a published method's; flags beside it override it
    #[arg(long, value_enum, help_heading = "Design", conflicts_with = "recipe")]
    method: Option<MethodArg>,
    /// Mount the plate tilted so that its mean slope is zero
    #[arg(long, help_heading = "Design")]
    level: bool,
    /// Steepest facet, degrees  [default: 65]
    #[arg(long, value_name = "DEG", help_heading = "Design", allow_negative_numbers = true)]
    slope_cap: Option<f64>,
    /// Seed of everything random  [default: 1]
    #[arg(long, help_heading = "Design", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: Option<u64>,
    /// Start from the settings of a recipe.toml; flags beside it override it
    #[arg(long, value_name = "FILE", help_heading = "Design")]
    pub recipe: Option<PathBuf>,

    #[command(flatten)]
    pub running: RunningArgs,
    /// Do not trace the result
    #[arg(long, help_heading = "Running")]
    pub no_verify: bool,
    /// Tell sizes, STL bytes and time without designing
    #[arg(long, help_heading = "Running")]
    pub dry_run: bool,
}

#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// A closed STL in mm, +z toward the light
    pub plate: PathBuf,
    /// The picture that the light is scored against
    #[arg(long, value_name = "PICTURE")]
    pub against: PathBuf,
    /// Folder for the results
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,

    #[command(flatten)]
    pub optics: OpticsArgs,

    /// Rim that is not optical area, mm
    #[arg(long, value_name = "MM", default_value_t = 0.0, help_heading = "Plate", allow_negative_numbers = true)]
    pub margin: f64,
    /// Tilt at which the plate is mounted, degrees from +z and azimuth, as a --level design reports it
    #[arg(long, value_name = "THETA,PHI", help_heading = "Plate", allow_hyphen_values = true)]
    pub mount: Option<Pair<f64, ','>>,
    /// Seed of the rays  [default: 1]
    #[arg(long, help_heading = "Running", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: Option<u64>,

    #[command(flatten)]
    pub running: RunningArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Highlight and light")]
pub struct OpticsArgs {
    /// Angle from the picture's middle to its rim, degrees  [default: 20]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    half_field: Option<f64>,
    /// How directions are laid out on the picture  [default: orthographic]
    #[arg(long, value_enum)]
    projection: Option<ProjectionArg>,
    /// What a pixel's value says  [default: radiance]
    #[arg(long, value_enum)]
    quantity: Option<QuantityArg>,
    /// From which side the picture is looked at  [default: from-above]
    #[arg(long, value_enum)]
    seen: Option<SeenArg>,
    /// The lamp: degrees from the plate's normal, azimuth from +x  [default: 0,0]
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true)]
    light: Option<Pair<f64, ','>>,
    /// Angular radius of the lamp, degrees; the sun has 0.2665  [default: 0]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    light_radius: Option<f64>,
    /// Dark parts of the picture are the light
    #[arg(long)]
    invert: bool,
    /// Turn the drawing counter-clockwise, degrees  [default: 0]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    rotate: Option<f64>,
    /// How a picture that is not square fills the field  [default: pad]
    #[arg(long, value_enum)]
    fit: Option<FitArg>,
    /// Pixel values are proportional to light, whatever their depth
    #[arg(long, conflicts_with = "srgb")]
    linear: bool,
    /// Pixel values are sRGB, whatever their depth
    #[arg(long)]
    srgb: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Running")]
pub struct RunningArgs {
    /// Rays sent over the plate  [default: 2000000]
    #[arg(long)]
    rays: Option<u64>,
    /// Threads  [default: one a core]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Replace the files of an earlier run
    #[arg(long)]
    pub force: bool,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Say nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

impl DesignArgs {
    /// Lays the flags over `recipe`.
    pub fn apply(&self, recipe: &mut Recipe) {
        if let Some(picture) = &self.picture {
            recipe.picture = Some(picture.to_string_lossy().into_owned());
        }
        self.optics.apply(recipe);
        let (plate, design) = (&mut recipe.plate, &mut recipe.design);
        set(&mut plate.size, self.size.map(Pair::array));
        set(&mut plate.facets, self.facets.map(Pair::array));
        set(&mut plate.cells, self.cells);
        set(&mut plate.thickness, self.thickness);
        set(&mut plate.border, self.border);
        set(&mut plate.surface, self.surface.map(Into::into));
        set(&mut design.sample, self.sample.map(Into::into));
        set(&mut design.arrange, self.arrange.map(Into::into));
        if let Some(heights) = self.heights {
            design.heights = Some(heights.into());
        }
        design.distribution.level |= self.level;
        set(&mut design.distribution.slope_cap, self.slope_cap);
        set(&mut design.seed, self.seed);
        self.running.apply(recipe);
    }

    /// The recipe that the other flags are laid over, if it is not one from a file.
    pub fn base(&self) -> Recipe {
        match self.method {
            Some(MethodArg::Weyrich2009) => Recipe::weyrich2009(),
            None => Recipe::default(),
        }
    }
}

impl OpticsArgs {
    pub fn apply(&self, recipe: &mut Recipe) {
        let (highlight, light) = (&mut recipe.highlight, &mut recipe.light);
        set(&mut highlight.half_field, self.half_field);
        set(&mut highlight.projection, self.projection.map(Into::into));
        set(&mut highlight.quantity, self.quantity.map(Into::into));
        set(&mut highlight.seen, self.seen.map(Into::into));
        highlight.invert |= self.invert;
        set(&mut highlight.rotate, self.rotate);
        set(&mut highlight.fit, self.fit.map(Into::into));
        if self.linear {
            highlight.encoding = Encoding::Linear;
        }
        if self.srgb {
            highlight.encoding = Encoding::Srgb;
        }
        if let Some(Pair([theta, phi])) = self.light {
            (light.theta, light.phi) = (theta, phi);
        }
        set(&mut light.radius, self.light_radius);
    }
}

impl RunningArgs {
    pub fn apply(&self, recipe: &mut Recipe) {
        set(&mut recipe.verify.rays, self.rays);
    }
}

fn set<T>(place: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *place = value;
    }
}

/// Two numbers with a separator between: `30x20`, `45,90`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<T, const BETWEEN: char>(pub [T; 2]);

impl<T, const BETWEEN: char> Pair<T, BETWEEN> {
    fn array(self) -> [T; 2] {
        self.0
    }
}

impl<T: FromStr, const BETWEEN: char> FromStr for Pair<T, BETWEEN> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = || format!("write two numbers with a '{BETWEEN}' between them, such as 30{BETWEEN}20");
        let (first, second) = text.split_once(BETWEEN).ok_or_else(wanted)?;
        let number = |part: &str| part.trim().parse().map_err(|_| wanted());
        Ok(Self([number(first)?, number(second)?]))
    }
}

/// A flag's words for a library enum: names and meaning here, science there.
macro_rules! words {
    ($arg:ident for $library:ident { $($(#[$doc:meta])* $word:ident),+ $(,)? }) => {
        #[derive(Clone, Copy, Debug, ValueEnum)]
        pub enum $arg { $($(#[$doc])* $word),+ }

        impl From<$arg> for $library {
            fn from(arg: $arg) -> Self {
                match arg { $($arg::$word => Self::$word),+ }
            }
        }
    };
}

words!(ProjectionArg for Projection {
    /// Sines of the angles from the plate's normal
    Orthographic,
    /// Equal angles from the mirror direction
    Equidistant,
    /// A flat screen across the mirror direction
    Screen,
});
words!(QuantityArg for Quantity {
    /// How bright the plate looks from there
    Radiance,
    /// Flux per steradian
    Intensity,
    /// Flux per pixel; on a screen, irradiance
    Flux,
});
words!(SeenArg for Seen {
    /// A map of viewers, from above the plate
    FromAbove,
    /// Thrown on a wall, from the plate's side
    OnWall,
});
words!(FitArg for Fit {
    /// Black bars
    Pad,
    /// Cut what is longer
    Crop,
    /// Distort
    Stretch,
});
words!(SurfaceArg for SurfaceKind {
    /// Planar facets
    Flat,
});
words!(SampleArg for Sampling {
    /// Centroidal cells of equal mass
    Voronoi,
    /// Independent draws
    Random,
    /// A Sobol sequence
    Sobol,
});
words!(ArrangeArg for Arrangement {
    /// Optimal transport: a dome, no valleys
    Transport,
    /// The 2009 paper's annealing
    Anneal,
    /// No order
    Random,
});
words!(HeightsArg for Heights {
    /// Smallest steps, edges free
    Free,
    /// Smallest steps on a plate that continues into itself
    Cyclic,
    /// As printed in the 2009 paper
    Weyrich2009,
});

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodArg {
    /// Weyrich et al., SIGGRAPH 2009
    #[value(name = "weyrich2009")]
    Weyrich2009,
}
