//! The flags of `facetmill mill`.

use std::path::PathBuf;

use clap::Args;
use facetmill::cutter::Cutter;
use facetmill::gcode::dialect::Dialect;
use facetmill::shop::feeds::Stock;

use super::settings::{ByMill, SettingFlags};
use super::{MachineArgs, MachiningArgs, PlacingArgs, RunningArgs};
use crate::values::number;

#[derive(Debug, Args)]
pub struct MillArgs {
    /// A closed mesh in mm, relief toward +z: STL, OBJ, PLY, 3MF or OFF; or the folder of a design
    ///
    /// A folder's recipe gives cutter, polish and rim. Flags that are given count before the recipe.
    pub plate: PathBuf,
    /// Folder for the programs; made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,
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
    /// Most turns of the spindle a minute
    #[arg(long, value_name = "RPM", help_heading = "Machine", default_value = "24000", value_parser = number)]
    pub spindle: f64,

    /// The finishing cutter: ball:D, bull:D,CORNER, flat:D, cone:ANGLE,TIP or tapered:TIP,ANGLE  [default: the recipe's]
    #[arg(long, value_name = "CUTTER", help_heading = "Finishing")]
    pub cutter: Option<Cutter>,
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
    pub rough_cutter: Option<Cutter>,
    /// What roughing leaves standing over the optical area, mm, 0.01 to 5
    #[arg(long, value_name = "MM", help_heading = "Roughing", default_value = "0.1", value_parser = number)]
    pub allowance: f64,
    /// From one level of roughing to the next, mm  [default: a tenth of its cutter]
    #[arg(long, value_name = "MM", help_heading = "Roughing", value_parser = number)]
    pub rough_step: Option<f64>,
    /// From one pass of roughing to the next, mm  [default: four tenths of its cutter]
    #[arg(long, value_name = "MM", help_heading = "Roughing", value_parser = number)]
    pub rough_stepover: Option<f64>,

    /// Rim that is not optical area, mm  [default: 0; of a folder its border]
    #[arg(long, value_name = "MM", help_heading = "Plate", value_parser = number)]
    pub margin: Option<f64>,
    #[command(flatten)]
    pub placing: PlacingArgs,
    #[command(flatten)]
    pub running: RunningArgs,
}

impl MillArgs {
    /// How the finishing passes go, as `verify --machine` takes it.
    pub fn machining(&self) -> MachiningArgs {
        MachiningArgs { by: MachineArgs { machine: self.machine.clone() }, cutter: self.cutter, polish: self.polish }
    }
}
