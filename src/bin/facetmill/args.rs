//! The command line, and how it becomes a recipe.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand};
use facetmill::cutter::Cutter;
use facetmill::picture::Encoding;
use facetmill::recipe::{Recipe, SurfaceKind};

use crate::measure::args::MeasureArgs;
use crate::values::*;

/// Turns a drawn highlight into a relief that can be milled and that really reflects it.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 110, arg_required_else_help = true)]
#[command(after_help = "\
First steps:
  facetmill design ring.png -o ring     then look at ring/comparison.png and mill ring/plate.stl
  facetmill design --help               what each setting means, in millimetres and degrees

Exit codes: 0 done, 2 wrong usage, 3 input cannot be read or makes no sense, 4 cannot be made as asked,
5 output cannot be written, 130 stopped by Ctrl-C. After an error nothing is left behind but --snapshots.")]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Design a plate whose reflection is the picture; write STL, pictures and a report
    ///
    /// The folder receives plate.stl (closed solid, mm), heightmap.png with heightmap.json, target.png, simulated.png,
    /// comparison.png (look at this one first; comparison_milled.png with a cutter), relief.png, report.json, and
    /// recipe.toml: every setting, so that `facetmill design --recipe recipe.toml -o DIR` makes the same files again.
    ///
    /// Ctrl-C while a sheet is sculpted finishes the best so far, proof and files included, once the first
    /// tries are done; a second one stops at once and leaves nothing.
    #[command(after_help = "\
Examples:
  facetmill design ring.png -o ring --half-field 20 --size 30x30 --for-cutter ball:0.5
  facetmill design logo.png -o logo --projection screen --quantity flux --seen on-wall   a logo thrown on a wall
  facetmill design ring.png -o facets --facets 30x30           900 flat mirrors instead of one sheet
  facetmill design ring.png --facets 200x200 --dry-run                                   how large, how long?")]
    #[command(allow_negative_numbers = true)]
    Design(Box<DesignArgs>),
    /// Trace light over any closed STL (mm) and score it against a picture
    ///
    /// The plate lies in the xy plane with its relief toward +z; who made it does not matter. The folder receives
    /// target.png, simulated.png, comparison.png and report.json.
    #[command(after_help = "Example: facetmill verify ring/plate.stl --against ring.png -o proof --half-field 20")]
    #[command(allow_negative_numbers = true)]
    Verify(Box<VerifyArgs>),
    /// Measure what light does on a plate: highlight, BRDF, normals, a wall, or what a person sees
    ///
    /// Light is sent over the plate ray by ray, with every bounce, shadow and loss. By itself this measures the
    /// highlight of one lamp: highlight.png, highlight.tiff with all digits (shares of the light that leaves upward,
    /// 32-bit float) and highlight_error.tiff (the standard error of each pixel). report.json always holds the figures.
    /// One of --brdf, --ndf, --wall and --look measures something else instead.
    ///
    /// PLATE is any closed STL, or the folder of a design, whose lamp and field are then the defaults; a --level design
    /// is lit as mounted. Lengths are in mm, angles in degrees; --light-radius 0.2665 is the sun.
    #[command(after_help = "\
Examples:
  facetmill measure ring -o seen --material aluminium:ggx:0.05       the highlight that worn aluminium shows
  facetmill measure ring -o fine --light-radius 0.2665 --error 0.002   under the sun, to a stated error
  facetmill measure ring -o brdf --brdf --material brass:ggx:0.1     .bsdf for Mitsuba, CSV, polar slices, maps
  facetmill measure ring/plate.stl -o normals --ndf                  slopes, and how much is hidden from where
  facetmill measure ring -o wall --wall 1000 --lamp-distance 1500 --lamp-radius 5
  facetmill measure ring -o ball --look --wrap sphere:40 --material aluminium:ggx:0.05 --light 30,90")]
    #[command(allow_negative_numbers = true)]
    Measure(Box<MeasureArgs>),
}

#[derive(Debug, Args)]
pub struct DesignArgs {
    /// The highlight: PNG, JPEG, TIFF or WebP, bright where light shall be
    #[arg(required_unless_present = "recipe")]
    pub picture: Option<PathBuf>,
    /// Folder for the results; made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR", required_unless_present = "dry_run")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub optics: OpticsArgs,

    /// Optical area along x and y, mm  [default: 30x30]
    #[arg(long, value_name = "WxH", help_heading = "Plate", value_parser = size, allow_hyphen_values = true)]
    size: Option<[f64; 2]>,
    /// Facets along x and y on the whole plate  [default: 30x30]
    ///
    /// Each is one flat mirror and one spot of light: 30x30 facets on 30x30 mm are 900 mirrors of 1 mm. More facets
    /// show finer detail, smaller ones need a smaller cutter.
    #[arg(long, value_name = "NxM", help_heading = "Plate", value_parser = counts, allow_hyphen_values = true)]
    facets: Option<[usize; 2]>,
    /// Repeat the whole highlight in K x K cells  [default: 3; 1 with flat facets]
    ///
    /// One cell is a single dome, which seen from near by lights up in one place only. 3 x 3 cells of 10 mm each hold
    /// the whole highlight, so the plate looks the same all over. Numbers of facets must be divisible by K.
    #[arg(long, value_name = "K", help_heading = "Plate", value_parser = count)]
    cells: Option<usize>,
    /// Solid metal under the lowest point, mm  [default: 5]
    #[arg(long, value_name = "MM", help_heading = "Plate", value_parser = number)]
    thickness: Option<f64>,
    /// Flat rim around the optical area, mm  [default: 0]
    #[arg(long, value_name = "MM", help_heading = "Plate", value_parser = number)]
    border: Option<f64>,
    /// Kind of relief  [default: continuous; flat with --facets or another flag that only facets have]
    ///
    /// One sheet has no steps and puts ten times less light in the wrong place than 900 facets; its STL is large. Flags
    /// that the kind does not have are refused.
    #[arg(long, value_enum, value_name = "KIND", help_heading = "Plate")]
    surface: Option<SurfaceArg>,
    /// Nodes along each side of a cell of a sheet  [default: as suits cutter and file]
    #[arg(long, value_name = "N", help_heading = "Plate", value_parser = count)]
    grid: Option<usize>,
    /// Triangles of a sheet at the most  [default: 3000000]
    #[arg(long, value_name = "N", help_heading = "Plate", value_parser = count)]
    max_triangles: Option<usize>,

    /// Cutter whose work is proved too: ball:DIAMETER in mm; a sheet is shaped for it
    ///
    /// A ball leaves its radius in valleys and at the foot of walls. Facets stay as they are, and the report says what
    /// becomes of their light; a sheet is shaped so that its light is right as the cutter leaves it.
    #[arg(long, value_name = "CUTTER", help_heading = "Design")]
    for_cutter: Option<Cutter>,
    /// Leave out details of a sheet narrower than this, mm  [default: 0]
    ///
    /// A mirror of 0.1 mm spreads light by about 0.3°: detail that lives on smaller ones is lost to diffraction.
    #[arg(long, value_name = "MM", help_heading = "Design", value_parser = number)]
    min_feature: Option<f64>,
    /// Polish or paint after the cutter, as a Gaussian over the heights of this standard deviation, mm  [default: 0]
    ///
    /// Both fill valleys and round ridges. The relief is shaped so that its light is right afterwards; with --for-cutter
    /// the proof as milled counts it too. 0.02 mm blunts what is narrower than about 0.05 mm.
    #[arg(long, value_name = "MM", help_heading = "Design", value_parser = number, alias = "levelling")]
    polish: Option<f64>,
    /// The most that a cell of a sheet may rise about its mean plane, mm
    ///
    /// Shallow reliefs need many hills, and each hill valleys: light is less exact, more so for a wide cutter. A relief
    /// that stays too deep is refused. Smaller cells (--cells) are shallower by themselves.
    #[arg(long, value_name = "MM", help_heading = "Design", value_parser = number)]
    max_depth: Option<f64>,
    /// How facets are drawn from the highlight  [default: voronoi]
    #[arg(long, value_enum, value_name = "HOW", help_heading = "Design")]
    sample: Option<SampleArg>,
    /// Which facet goes where  [default: transport]
    #[arg(long, value_enum, value_name = "HOW", help_heading = "Design")]
    arrange: Option<ArrangeArg>,
    /// How heights follow from slopes  [default: free, cyclic with --arrange anneal]
    #[arg(long, value_enum, value_name = "HOW", help_heading = "Design")]
    heights: Option<HeightsArg>,
    /// Set every choice to a published method's; flags beside it override it
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Design", conflicts_with = "recipe")]
    pub method: Option<MethodArg>,
    /// Mount the plate tilted so that its mean slope is zero
    ///
    /// An off-centre highlight tilts the whole relief: a mean slope of 5° climbs 2.6 mm over 30 mm. Levelled, the plate
    /// stays thin and is mounted at that angle instead, which the table and the report tell.
    #[arg(long, help_heading = "Design", num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL", action = ArgAction::Set, hide_possible_values = true)]
    level: Option<bool>,
    /// Steepest facet, degrees; light that needs steeper ones is cut  [default: 65]
    #[arg(long, value_name = "DEG", help_heading = "Design", value_parser = number)]
    slope_cap: Option<f64>,
    /// Seed of everything random  [default: 1]
    #[arg(long, value_name = "N", help_heading = "Design", value_parser = whole)]
    seed: Option<u64>,
    /// Start from the settings of a recipe.toml; flags beside it override it
    ///
    /// A picture that the recipe names is looked for from the folder you are in.
    #[arg(long, value_name = "FILE", help_heading = "Design")]
    pub recipe: Option<PathBuf>,

    #[command(flatten)]
    pub running: RunningArgs,
    /// Keep a picture of the highlight after each step of a sheet, and the state to go on from
    ///
    /// They come into DIR/snapshots while the design runs and stay there whatever happens. Each picture shows the light
    /// of one cell at its first bounce, as bright as simulated.png.
    #[arg(long, help_heading = "Running", conflicts_with = "dry_run")]
    pub snapshots: bool,
    /// Go on from DIR/snapshots of an earlier run of the same settings, and keep snapshots
    ///
    /// The result is the same, byte for byte, as without the break. Only --rays and --no-verify may differ.
    #[arg(long, help_heading = "Running", conflicts_with = "dry_run")]
    pub resume: bool,
    /// Do not trace light over the result
    #[arg(long, help_heading = "Running")]
    pub no_verify: bool,
    /// Tell sizes, STL bytes and time without designing; needs no -o
    #[arg(long, help_heading = "Running")]
    pub dry_run: bool,
}

#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// A closed STL in mm, relief toward +z
    pub plate: PathBuf,
    /// The picture that the light is scored against
    #[arg(long, value_name = "PICTURE")]
    pub against: PathBuf,
    /// Folder for the results; made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,

    #[command(flatten)]
    pub optics: OpticsArgs,

    /// Rim that is not optical area, mm  [default: 0]
    #[arg(long, value_name = "MM", help_heading = "Plate", value_parser = number)]
    pub margin: Option<f64>,
    /// Tilt at which the plate is mounted, degrees from +z and azimuth, as a --level design reports it
    #[arg(long, value_name = "THETA,PHI", help_heading = "Plate", value_parser = angles, allow_hyphen_values = true)]
    pub mount: Option<[f64; 2]>,
    /// Seed of the rays  [default: 1]
    #[arg(long, value_name = "N", help_heading = "Running", value_parser = whole)]
    pub seed: Option<u64>,

    #[command(flatten)]
    pub running: RunningArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Highlight and light")]
pub struct OpticsArgs {
    /// Angle from the picture's middle to its rim, degrees  [default: 20]
    ///
    /// On a wall at a distance D the picture is 2·D·tan(angle) wide: 20° give 0.73 m at 1 m.
    #[arg(long, value_name = "DEG", value_parser = number)]
    half_field: Option<f64>,
    /// How directions are laid out on the picture  [default: orthographic]
    #[arg(long, value_enum, value_name = "NAME")]
    projection: Option<ProjectionArg>,
    /// What a pixel's value says  [default: radiance]
    #[arg(long, value_enum, value_name = "NAME")]
    quantity: Option<QuantityArg>,
    /// From which side the picture is looked at  [default: from-above]
    ///
    /// Thrown on a wall or ceiling, a picture meant to be seen from above the plate is mirrored; on-wall turns it right.
    #[arg(long, value_enum, value_name = "SIDE")]
    seen: Option<SeenArg>,
    /// The lamp: degrees from the plate's normal, azimuth from +x  [default: 0,0]
    ///
    /// The azimuth counts counter-clockwise seen from above: 30,90 is a lamp 30° off the normal toward +y.
    #[arg(long, value_name = "THETA,PHI", value_parser = angles, allow_hyphen_values = true)]
    light: Option<[f64; 2]>,
    /// Angular radius of the lamp, degrees; the sun has 0.2665  [default: 0]
    ///
    /// A disc of 10 mm at 1 m has 0.29. It blurs the highlight by as much. The design sharpens the light it asks of the
    /// mirrors to make up for that, as far as light can be sharpened, and the proof counts it.
    #[arg(long, value_name = "DEG", value_parser = number)]
    light_radius: Option<f64>,
    /// Scatter of the polished base metal, degrees: standard deviation of its deflections, 0 to 10  [default: 0]
    ///
    /// No metal is a perfect mirror: milled and polished aluminium spreads light by about 1, which is 2.35 between the
    /// points of half brightness. As with --light-radius, the design sharpens its light against it and the proof is of
    /// such metal. If unsure say less: against too wide a lobe light is sharpened until it shows. Small tilts by t throw
    /// light 2t aside: a lobe of 1 is Beckmann's roughness alpha = sqrt(2) (lobe/2 in radians) = 0.0123.
    #[arg(long, value_name = "DEG", value_parser = number)]
    lobe: Option<f64>,
    /// Dark parts of the picture are the light
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL", action = ArgAction::Set, hide_possible_values = true)]
    invert: Option<bool>,
    /// Turn the drawing counter-clockwise, degrees  [default: 0]
    #[arg(long, value_name = "DEG", value_parser = number)]
    rotate: Option<f64>,
    /// How a picture that is not square fills the field  [default: pad]
    #[arg(long, value_enum, value_name = "HOW")]
    fit: Option<FitArg>,
    /// Pixel values are proportional to light  [default: only in 16-bit and float pictures]
    #[arg(long, conflicts_with = "srgb")]
    linear: bool,
    /// Pixel values are sRGB  [default: only in 8-bit pictures]
    #[arg(long)]
    srgb: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Running")]
pub struct RunningArgs {
    /// Rays sent over the plate  [default: 2000000]
    #[arg(long, value_name = "N", value_parser = whole)]
    rays: Option<u64>,
    /// Threads; results do not depend on it  [default: one a core]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Replace the files of an earlier run; files of other names are left alone
    #[arg(long)]
    pub force: bool,
    /// Print the report, or the error, as JSON on standard output
    #[arg(long)]
    pub json: bool,
    /// No progress and no table; errors are still told
    #[arg(long)]
    pub quiet: bool,
}

impl DesignArgs {
    /// Lays the flags over `recipe`.
    pub fn apply(&self, recipe: &mut Recipe) {
        if let Some(picture) = &self.picture {
            // A name that is not Unicode cannot stand in the recipe; none is better than a wrong one.
            recipe.picture = picture.to_str().map(Into::into);
        }
        self.optics.apply(recipe);
        let (plate, design) = (&mut recipe.plate, &mut recipe.design);
        set(&mut plate.size, self.size);
        plate.facets = self.facets.or(plate.facets);
        plate.cells = self.cells.or(plate.cells);
        plate.grid = self.grid.or(plate.grid);
        plate.max_triangles = self.max_triangles.or(plate.max_triangles);
        set(&mut plate.thickness, self.thickness);
        set(&mut plate.border, self.border);
        plate.surface = self.surface().or(plate.surface);
        design.cutter = self.for_cutter.or(design.cutter);
        set(&mut design.polish, self.polish);
        set(&mut design.min_feature, self.min_feature);
        design.max_depth = self.max_depth.or(design.max_depth);
        design.sample = self.sample.map(Into::into).or(design.sample);
        design.arrange = self.arrange.map(Into::into).or(design.arrange);
        design.heights = self.heights.map(Into::into).or(design.heights);
        set(&mut design.distribution.level, self.level);
        set(&mut design.distribution.slope_cap, self.slope_cap);
        set(&mut design.seed, self.seed);
        self.running.apply(recipe);
    }

    /// The kind of relief, if the flag was given.
    pub fn surface(&self) -> Option<SurfaceKind> {
        self.surface.map(Into::into)
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
    /// Lays the flags over `recipe`.
    pub fn apply(&self, recipe: &mut Recipe) {
        let (highlight, light) = (&mut recipe.highlight, &mut recipe.light);
        set(&mut highlight.half_field, self.half_field);
        set(&mut highlight.projection, self.projection.map(Into::into));
        set(&mut highlight.quantity, self.quantity.map(Into::into));
        set(&mut highlight.seen, self.seen.map(Into::into));
        set(&mut highlight.invert, self.invert);
        set(&mut highlight.rotate, self.rotate);
        set(&mut highlight.fit, self.fit.map(Into::into));
        if self.linear {
            highlight.encoding = Encoding::Linear;
        }
        if self.srgb {
            highlight.encoding = Encoding::Srgb;
        }
        if let Some([theta, phi]) = self.light {
            (light.theta, light.phi) = (theta, phi);
        }
        set(&mut light.radius, self.light_radius);
        set(&mut recipe.plate.lobe, self.lobe);
    }
}

impl RunningArgs {
    /// Rays, if the flag was given.
    pub fn rays(&self) -> Option<u64> {
        self.rays
    }

    /// Lays the flags over `recipe`.
    pub fn apply(&self, recipe: &mut Recipe) {
        set(&mut recipe.verify.rays, self.rays);
    }
}

fn set<T>(place: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *place = value;
    }
}
