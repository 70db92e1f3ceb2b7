//! The flags of `facetmill mill`.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use facetmill::gcode::dialect::Dialect;
use facetmill::shop::feeds::Stock;

use super::settings::{ByMill, SettingFlags};
use super::{MachineArgs, MachiningArgs, PlacingArgs, RunningArgs};
use crate::values::{number, place};

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("the_plate").args(["plate", "against"])))]
pub struct MillArgs {
    /// A closed mesh in mm, relief toward +z: STL, OBJ, PLY, 3MF or OFF; or the folder of a design
    ///
    /// A folder's recipe gives cutter, polish and rim. Flags that are given count before the recipe.
    #[arg(required_unless_present_any = ["check", "against"], conflicts_with = "against")]
    pub plate: Option<PathBuf>,
    /// Folder for the programs; made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR", required_unless_present = "check")]
    pub output: Option<PathBuf>,

    /// Judge a program of any origin in place of writing one: exit code 1 if it should not be run
    ///
    /// Its moves are read (G0 to G3 in three planes, inches and steps too), the cutter is led along them, and what is left
    /// is compared with the plate: cuts below it, material left standing, rapids through what still stands, moves off or
    /// below the stock, the light of the surface, hours. Each finding has its line. Tool and control of our own programs
    /// are read from their heading.
    #[arg(long, value_name = "FILE", help_heading = "Check", requires = "the_plate")]
    pub check: Option<PathBuf>,
    /// The plate that it is judged against: a mesh, or the folder of a design
    #[arg(long, value_name = "DIR|PLATE", help_heading = "Check", requires = "check")]
    pub against: Option<PathBuf>,
    /// Where the program's zero lies, mm from the stock's lower left corner and its upper face  [default: 0,0,0]
    #[arg(long, value_name = "X,Y,Z", help_heading = "Check", requires = "check", allow_hyphen_values = true, value_parser = place)]
    pub zero: Option<[f64; 3]>,
    /// How far the surface may be off before it counts, µm, 0.1 to 1000
    #[arg(long, value_name = "UM", help_heading = "Check", requires = "check", default_value = "1", value_parser = number)]
    pub tolerance: f64,
    /// Length of the cutter's teeth, mm: deeper cuts are told
    #[arg(long, value_name = "MM", help_heading = "Check", requires = "check", value_parser = number)]
    pub flutes: Option<f64>,
    /// The machine: desktop, desktop-good, vmc, vmc-good, ultraprecision, or a TOML file  [default: the recipe's]
    ///
    /// It says feed, rapids, acceleration, decimals, how far apart teeth cut and how many lines a second the control takes.
    /// What the presets assume stands in docs/milling.md.
    #[arg(long, value_name = "NAME|FILE", help_heading = "Machine")]
    pub machine: Option<String>,
    /// The control: grbl, linuxcnc, mach3 or iso  [default: grbl for desktop machines, else iso]
    ///
    /// Files end as its shops expect: .nc, .ngc, .tap, .nc. For grbl no % and M6 are written, and no more than 400 lines a
    /// second come.
    #[arg(long, value_name = "NAME", help_heading = "Machine")]
    pub dialect: Option<Dialect>,
    /// Make up for the machine's play of z (its backlash-z) where heights turn: for a play that was measured
    #[arg(long, help_heading = "Machine", conflicts_with = "check")]
    pub compensate: bool,
    /// Most turns of the spindle a minute
    #[arg(long, value_name = "RPM", help_heading = "Machine", default_value = "24000", value_parser = number)]
    pub spindle: f64,

    /// The finishing cutter: a name, ball:D, bull:D,CORNER, flat:D, cone:ANGLE,TIP or tapered:TIP,ANGLE  [default: the recipe's]
    ///
    /// `facetmill cutters` lists the names. A relief deeper than a named one reaches is refused.
    #[arg(long, alias = "for-cutter", value_name = "CUTTER", help_heading = "Finishing")]
    pub cutter: Option<String>,
    /// Your own cutters by name, besides those that `facetmill cutters` lists: a TOML file
    #[arg(long, value_name = "FILE", help_heading = "Finishing")]
    pub cutters: Option<PathBuf>,
    #[command(flatten)]
    pub settings: SettingFlags<ByMill>,
    /// Polish that is assumed afterwards, mm: the standard deviation of the Gaussian that smooths heights  [default: the recipe's]
    ///
    /// It only chooses how far apart passes are, and stands in the heading. 0 is none.
    #[arg(long, value_name = "MM", help_heading = "Finishing", value_parser = number)]
    pub polish: Option<f64>,
    /// Teeth of the cutters
    #[arg(long, value_name = "N", help_heading = "Finishing", default_value = "2", value_parser = number)]
    pub teeth: f64,

    /// What it is cut from: aluminium, brass, copper, steel or plastic; for feeds and speeds to start from
    #[arg(long, value_name = "NAME", help_heading = "Stock", default_value = "aluminium")]
    pub material: Stock,
    /// From the finished plate's highest point up to the stock's upper face, mm, 0 to 20
    #[arg(long, value_name = "MM", help_heading = "Stock", default_value = "0.2", value_parser = number)]
    pub stock_over: f64,

    /// The cutter that takes the stock away  [default: a flat end of a tenth of the plate, 1 to 6 mm]
    #[arg(long, value_name = "CUTTER", help_heading = "Roughing")]
    pub rough_cutter: Option<String>,
    /// What roughing leaves standing over the optical area, mm, 0.01 to 5  [default: 0.1; --check: 0]
    #[arg(long, value_name = "MM", help_heading = "Roughing", value_parser = number)]
    pub allowance: Option<f64>,
    /// From one level of roughing to the next, mm  [default: a tenth of its cutter]
    #[arg(long, value_name = "MM", help_heading = "Roughing", value_parser = number)]
    pub rough_step: Option<f64>,
    /// From one pass of roughing to the next, mm  [default: four tenths of its cutter]
    #[arg(long, value_name = "MM", help_heading = "Roughing", value_parser = number)]
    pub rough_stepover: Option<f64>,

    /// Do not prove the light of the plate as the machine makes it
    #[arg(long, help_heading = "Running")]
    pub no_verify: bool,
    /// Rim that is not optical area, mm  [default: 0; of a folder its border]
    #[arg(long, value_name = "MM", help_heading = "Plate", value_parser = number)]
    pub margin: Option<f64>,
    #[command(flatten)]
    pub placing: PlacingArgs,
    #[command(flatten)]
    pub running: RunningArgs,
}

impl MillArgs {
    /// The plate that is milled or judged against; one of the two is there.
    pub fn the_plate(&self) -> &Path {
        let given = self.plate.as_ref().or(self.against.as_ref());
        given.map_or(Path::new(""), PathBuf::as_path)
    }

    /// How the finishing passes go, as `verify --machine` takes it.
    pub fn machining(&self) -> MachiningArgs {
        let by = MachineArgs { machine: self.machine.clone(), cutters: self.cutters_of_finishing() };
        MachiningArgs { by, cutter: self.cutter.clone(), polish: self.polish }
    }

    /// The user's cutters, unless only the roughing cutter is one of them.
    fn cutters_of_finishing(&self) -> Option<PathBuf> {
        self.cutters.clone().filter(|_| self.cutter.is_some() || self.rough_cutter.is_none())
    }
}
