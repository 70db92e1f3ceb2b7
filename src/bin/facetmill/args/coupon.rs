//! The flags of `facetmill coupon`.

use std::path::PathBuf;

use clap::Args;
use facetmill::gcode::dialect::Dialect;
use facetmill::shop::feeds::Stock;

use super::RunningArgs;
use crate::values::number;

#[derive(Debug, Args)]
pub struct CouponArgs {
    /// The machine: desktop, desktop-good, vmc, vmc-good, ultraprecision, or a TOML file
    ///
    /// It says feed, rapids and how far heights are thought to scatter, from which follows how far apart passes are.
    #[arg(
        long,
        value_name = "NAME|FILE",
        help_heading = "Machine",
        required_unless_present = "read",
        conflicts_with = "read"
    )]
    pub machine: Option<String>,
    /// The control: grbl, linuxcnc, mach3 or iso  [default: grbl for desktop machines, else iso]
    #[arg(long, value_name = "NAME", help_heading = "Machine", conflicts_with = "read")]
    pub dialect: Option<Dialect>,
    /// Most turns of the spindle a minute
    #[arg(long, value_name = "RPM", help_heading = "Machine", default_value = "24000", value_parser = number)]
    pub spindle: f64,
    /// Teeth of the cutters
    #[arg(long, value_name = "N", help_heading = "Machine", default_value = "2", value_parser = number)]
    pub teeth: f64,
    /// The cutter, which is measured with the machine: a name (`facetmill cutters`), ball:D or tapered:TIP,ANGLE
    #[arg(long, value_name = "CUTTER", help_heading = "Machine", default_value = "ball:0.5")]
    pub for_cutter: String,
    /// Your own cutters by name, besides those that `facetmill cutters` lists: a TOML file
    #[arg(long, value_name = "FILE", help_heading = "Machine", requires = "for_cutter", conflicts_with = "read")]
    pub cutters: Option<PathBuf>,
    /// What it is cut from: aluminium, brass, copper, steel or plastic; for feeds and speeds to start from
    #[arg(long, value_name = "NAME", help_heading = "Stock", default_value = "brass")]
    pub material: Stock,
    /// From the finished piece's highest point up to the stock's upper face, mm, 0 to 20
    #[arg(long, value_name = "MM", help_heading = "Stock", default_value = "0.2", value_parser = number)]
    pub stock_over: f64,

    /// Read a finished piece: a scan (CSV of x, y, z) or photographs, as the piece's own setup.html asks for them
    ///
    /// Scans are lines across the passes, or a grid of heights, in mm or in the unit that the column's name has, such as
    /// z_um. What cannot be told from what is given is said so, and keeps the value that the machine was thought to have.
    #[arg(long, value_name = "FILE", help_heading = "Reading", num_args = 1.., requires = "against")]
    pub read: Vec<PathBuf>,
    /// The folder that the piece was written into
    #[arg(long, value_name = "DIR", help_heading = "Reading", requires = "read")]
    pub against: Option<PathBuf>,

    /// Folder for the piece's files, or for what was read (machine.toml, report.json); made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR", required_unless_present = "read")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub running: RunningArgs,
}
