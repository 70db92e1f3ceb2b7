//! The command line.

pub mod settings;

mod design;

mod fit;

mod measure;

mod plan;

mod mill;

mod coupon;

mod cutters;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use facetmill::goal::spec::GoalSpec;
use facetmill::job::clock::wanted_threads;
use facetmill::memory::MemoryLimit;
use facetmill::recipe::Recipe;

use crate::values::{GoalPartArg, Limit, UnitArg, UpArg, goal, memory, threads};

pub use coupon::CouponArgs;
pub use cutters::CuttersArgs;
pub use design::DesignArgs;
pub use fit::FitArgs;
pub use measure::MeasureArgs;
pub use mill::MillArgs;
pub use plan::PlanArgs;
use settings::{ByVerify, SettingFlags};

/// Turns a drawn highlight into a relief that can be milled and that really reflects it.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 110, arg_required_else_help = true)]
#[command(after_help = "\
First steps:
  facetmill design ring.png -o ring     then look at ring/comparison.png and mill ring/plate.stl
  facetmill design --help               the flags that most people need
  facetmill design --help-all           every flag, in millimetres and degrees, by groups

Exit codes: 0 done, 1 worse than --at-most or a program that should not be run, 2 wrong usage, 3 input cannot be read or
makes no sense, 4 cannot be made as asked, 5 output cannot be written, 130 stopped by Ctrl-C. After an error nothing is left behind but --snapshots.")]
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
    /// Trace light over any closed mesh (mm) and score it against a picture
    ///
    /// The plate lies in the xy plane with its relief toward +z; who made it does not matter. The folder receives
    /// target.png, simulated.png, comparison.png and report.json.
    #[command(after_help = "\
Examples:
  facetmill verify ring/plate.stl --against ring.png -o proof --half-field 20
  facetmill verify ring --at-most 0.02          exit code 1 if more than 2 % of the light goes astray as milled")]
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
    /// Find the plate, cutter, passes and polish that bring a drawing out best on a machine in so many hours
    ///
    /// A fast model tells what is to be expected of hundreds of ways; the best three are designed and proved as made. What
    /// a flag says of size, cells, cutter, polish and direction of passes is kept, the rest is searched for. The folder
    /// receives plan.png (light over hours, a line a cutter), recipe-1.toml to recipe-3.toml, the best first, for
    /// `facetmill design --recipe`, and report.json.
    #[command(after_help = "\
Examples:
  facetmill plan ring.png --machine vmc --hours 1 -o plan            then design --recipe plan/recipe-1.toml -o ring
  facetmill plan ring.png --machine desktop --hours 4 --size 100x100 -o plan
  facetmill plan ring.png --machine vmc --wanted 0.01 -o plan        how long it takes at the least")]
    #[command(allow_negative_numbers = true)]
    Plan(Box<PlanArgs>),
    /// Write the programs by which a machine makes the plate: an air cut, roughing and finishing, each read back and judged
    ///
    /// PLATE is a closed mesh in mm, or the folder of a design. The folder receives, one tool a file, air-cut (the outline
    /// above the stock, spindle standing), roughing (levels with an allowance) and finishing (the passes that
    /// `verify --machine` proves), as .nc, .ngc or .tap, and report.json. Every file bears its stock, zero, bounds, hours
    /// and a checksum.
    ///
    /// Zero is the stock's lower left corner and its upper face. Feeds and speeds are starting values. A program that cuts
    /// into the plate, goes through material, leaves the stock or comes faster than its control reads is not written (exit
    /// code 4).
    #[command(after_help = "\
Examples:
  facetmill mill ring --machine desktop-good -o shop                      GRBL: air-cut.nc, roughing.nc, finishing.nc
  facetmill mill ring --machine vmc --dialect linuxcnc --polish 0.04 --stepover 0.04 -o shop
  facetmill mill plate.stl --machine mine.toml --cutter ball:1 --material brass --rough-cutter flat:3 -o shop")]
    #[command(allow_negative_numbers = true)]
    Mill(Box<MillArgs>),
    /// Write a test piece for a machine, or read from a finished one how the machine scatters, its play, its tip, the polish
    ///
    /// The folder receives plate.stl, its programs as `mill` writes them, setup.html (how to cut it, which half to polish,
    /// how to scan or photograph it), coupon.toml and report.json. About 20 minutes of cutting.
    ///
    /// With --read a scan or photographs of the finished piece become machine.toml, each value with its standard error, for
    /// --machine of every other command.
    #[command(after_help = "\
Examples:
  facetmill coupon --machine desktop-good --for-cutter ball:0.5 -o piece
  facetmill coupon --read scan.csv --against piece -o mine                then design --machine mine/machine.toml")]
    #[command(allow_negative_numbers = true)]
    Coupon(Box<CouponArgs>),
    /// List the cutters that --for-cutter and --cutter know by name: shape, flutes, neck, wear
    #[command(after_help = "\
Examples:
  facetmill cutters
  facetmill cutters --cutters shop.toml                     with your own: \"mine\" = { shape = \"ball:0.5\", flutes = 1.5 }
  facetmill design ring.png --for-cutter ball-0.5 -o ring")]
    Cutters(CuttersArgs),
    /// Fit models of reflectance to a measured BRDF, and print each as a SPEC for --goal and --material
    ///
    /// Eleven models, one lobe each over an even base, the best three with up to three lobes, ranked by the root of the mean
    /// squared difference of log(1 + BRDF x cosine). The folder receives report.json (numbers with their standard errors) and
    /// fit.png, fit_2.png, fit_3.png: data and the three best fits.
    #[command(after_help = "\
Examples:
  facetmill fit gold-metallic-paint.binary -o fit       a MERL file
  facetmill measure ring -o brdf --brdf && facetmill fit brdf -o fit      what material a plate looks like")]
    Fit(FitArgs),
    /// Print what a shell needs to complete this program's flags
    #[command(
        after_help = "Example: facetmill completions bash > ~/.local/share/bash-completion/completions/facetmill"
    )]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page
    #[command(after_help = "Example: facetmill man > facetmill.1; man ./facetmill.1")]
    Man,
}

#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// A closed mesh in mm, relief toward +z: STL, OBJ, PLY, 3MF or OFF; or the folder of a design
    ///
    /// A folder's recipe gives light, field, metal and picture or goal, its report the mounting, and its cutter is led over
    /// the plate once more. A portrait's viewer looks at it. Flags that are given count before the recipe.
    pub plate: PathBuf,
    /// The picture that the light is scored against  [default: that of the folder's recipe]
    #[arg(long, value_name = "PICTURE")]
    pub against: Option<PathBuf>,
    /// Reflectance in place of a picture, as `design --goal` takes it: ward:0.1,0.3, merl:FILE, ndf:PICTURE and others
    ///
    /// The slice at the lamp is scored as a picture is, and the whole BRDF of the plate is set against the goal's under lamps
    /// from 0° to 60°. Without --half-field the field of a file holds 99 % of the goal's light.
    #[arg(long, value_name = "SPEC", value_parser = goal, conflicts_with_all = ["against", "scene"])]
    pub goal: Option<GoalSpec>,
    /// Which part of the goal is wanted: specular or all  [default: that of the folder's recipe, else specular]
    #[arg(long, value_enum, value_name = "PART", hide_possible_values = true, conflicts_with = "against")]
    pub goal_part: Option<GoalPartArg>,
    /// Folder for the results; made if it does not exist. Without it nothing is written
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Exit code 1 if more of the light than this is misplaced or lost, seen through a blur in degrees
    ///
    /// 0.02 and 2% mean 2 % at a blur of 1°, 0.02@0.5 the same at 0.5°. Of a folder with a cutter the plate as milled
    /// counts; of a goal its slice at the lamp; of a portrait the light in other patches, without a blur.
    #[arg(long = "at-most", value_name = "SHARE[@DEG]", value_parser = crate::values::limit)]
    pub at_most: Option<Limit>,

    #[command(flatten)]
    pub settings: SettingFlags<ByVerify>,

    /// Rim that is not optical area, mm  [default: 0; of a folder its border]
    #[arg(long, value_name = "MM", help_heading = "Plate", value_parser = crate::values::number)]
    pub margin: Option<f64>,
    /// Plate, lamp or sun, wall and picture in the room's own coordinates, as `design --scene` takes them
    #[arg(long, value_name = "FILE", help_heading = "Lamp and wall nearby", conflicts_with_all = ["light", "light-radius", "half-field", "mount"])]
    pub scene: Option<PathBuf>,
    /// Tilt at which the plate is mounted, degrees from +z and azimuth, as a --level design reports it
    #[arg(long, value_name = "THETA,PHI", help_heading = "Plate", value_parser = crate::values::angles, allow_hyphen_values = true)]
    pub mount: Option<[f64; 2]>,
    #[command(flatten)]
    pub placing: PlacingArgs,
    #[command(flatten)]
    pub machining: MachiningArgs,
    #[command(flatten)]
    pub running: RunningArgs,
}

impl VerifyArgs {
    /// Names in `recipe` the goal that was given, in place of its own or of a picture.
    pub fn aim(&self, recipe: &mut Recipe) {
        if let Some(goal) = &self.goal {
            recipe.name_goal(goal);
        }
        if let Some(part) = self.goal_part {
            recipe.goal_part = part.into();
        }
    }
}

/// By what the plate is made.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "As a machine makes it")]
pub struct MachineArgs {
    /// Prove the plate as a machine makes it too: desktop, desktop-good, vmc, vmc-good, ultraprecision, or a TOML file
    ///
    /// The cutter is led over the triangles of the file pass by pass, with the machine's steps, rounding, play and scatter;
    /// what it leaves is polished, lit and scored (as_made, comparison_made.png). What the presets assume stands in
    /// docs/milling.md. A TOML file has the same keys, and its values are kept in recipe.toml. none: not so, whatever a
    /// recipe says.
    #[arg(long, value_name = "NAME|FILE")]
    pub machine: Option<String>,
    /// Cutters by name besides those that `facetmill cutters` lists, over which they count: a TOML file
    ///
    /// A line each: "mine" = { shape = "ball:0.5", flutes = 1.5, neck = 4, worn-tip = 0.05 }, all but the shape optional.
    /// recipe.toml keeps what it says of the cutter that is named.
    #[arg(long, value_name = "FILE")]
    pub cutters: Option<PathBuf>,
}

/// What a plate that is there is made with, where that is not what its recipe says.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "As a machine makes it")]
pub struct MachiningArgs {
    #[command(flatten)]
    pub by: MachineArgs,
    /// The cutter: a name, or ball:D, bull:D,CORNER, flat:D, cone:ANGLE,TIP or tapered:TIP,ANGLE  [default: the recipe's]
    ///
    /// `facetmill cutters` lists the names.
    #[arg(long, alias = "for-cutter", value_name = "CUTTER")]
    pub cutter: Option<String>,
    /// Polish afterwards, mm: the standard deviation of the Gaussian that smooths heights  [default: the recipe's]
    ///
    /// 0 is none.
    #[arg(long, value_name = "MM", value_parser = crate::values::number)]
    pub polish: Option<f64>,
}

/// How a mesh from elsewhere is to be laid down.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Plate")]
pub struct PlacingArgs {
    /// Turn the plate over, about its x axis: for one that lies upside down
    #[arg(long, conflicts_with = "up")]
    pub flip: bool,
    /// The axis of the mesh along which its relief looks  [default: z]
    #[arg(long, value_enum, value_name = "AXIS", allow_hyphen_values = true, hide_possible_values = true)]
    pub up: Option<UpArg>,
    /// The unit of the mesh, mm, in, cm, m or um  [default: mm]
    #[arg(long, value_enum, value_name = "UNIT", hide_possible_values = true)]
    pub unit: Option<UnitArg>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Running")]
pub struct RunningArgs {
    /// Threads; results do not depend on it  [default: one a core]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// The most memory to take, such as 4G: what needs more is refused  [default: 70 % of what there is]
    ///
    /// What there is: the least of the machine's memory, of the control group's and of the limit on addresses. It never
    /// changes a result.
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    pub memory: Option<u64>,
    /// Replace the files of an earlier run; files of other names are left alone
    #[arg(long)]
    pub force: bool,
    /// Print the report, or the error, as JSON on standard output
    #[arg(long)]
    pub json: bool,
    /// No progress and no table; errors are still told
    #[arg(long)]
    pub quiet: bool,
    /// Tell every figure, not only the verdict and what matters most
    #[arg(long, conflicts_with_all = ["quiet", "json"])]
    pub verbose: bool,
}

impl RunningArgs {
    /// The most memory that may be taken: as asked, or as usual.
    pub fn memory(&self) -> MemoryLimit {
        let usual = || MemoryLimit::of_system(wanted_threads(self.threads));
        self.memory.map_or_else(usual, MemoryLimit::of_bytes)
    }
}
