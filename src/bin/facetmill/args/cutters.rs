//! The flags of `facetmill cutters`.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub struct CuttersArgs {
    /// Your own cutters besides, over those of the same name: a TOML file
    #[arg(long, value_name = "FILE")]
    pub cutters: Option<PathBuf>,
    /// Print them as JSON
    #[arg(long)]
    pub json: bool,
}
