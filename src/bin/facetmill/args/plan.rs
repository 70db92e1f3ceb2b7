//! The flags of `facetmill plan`.

use std::path::PathBuf;

use clap::Args;

use super::settings::{ByPlan, SettingFlags};
use super::{MachineArgs, RunningArgs};

#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The drawing, or the folder of a design, whose drawing, lamp and field are taken
    pub picture: PathBuf,
    /// Folder for the results; made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,
    #[command(flatten)]
    pub machine: MachineArgs,
    /// The most hours of finishing, at the machine's feed
    #[arg(long, value_name = "H", help_heading = "As a machine makes it", required_unless_present = "wanted", conflicts_with = "wanted", value_parser = crate::values::number)]
    pub hours: Option<f64>,
    /// Ask the other way round: the fewest hours for no more misplaced light than this, such as 0.01, at a blur of 1°
    #[arg(long, value_name = "TV", help_heading = "As a machine makes it", value_parser = crate::values::number)]
    pub wanted: Option<f64>,
    /// By what share the polish may be narrower or wider than meant  [default: 0.25]
    ///
    /// Ways are chosen by the mean over both and over a polish as meant: the wider a polish, the more it must be even.
    #[arg(long, value_name = "SHARE", help_heading = "As a machine makes it", value_parser = crate::values::number)]
    pub polish_tolerance: Option<f64>,

    #[command(flatten)]
    pub settings: SettingFlags<ByPlan>,
    #[command(flatten)]
    pub running: RunningArgs,
}
