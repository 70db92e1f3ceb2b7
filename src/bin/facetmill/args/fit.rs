//! The flags of `facetmill fit`.

use std::path::PathBuf;

use clap::Args;

use super::RunningArgs;

#[derive(Debug, Args)]
pub struct FitArgs {
    /// A MERL .binary, an RGL .bsdf, a brdf.csv, or the folder of `measure --brdf`
    pub data: PathBuf,
    /// Folder for the results; made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,

    #[command(flatten)]
    pub running: RunningArgs,
}
