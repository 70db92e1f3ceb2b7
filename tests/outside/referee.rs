//! Where the independent referee is, how it is asked, and what happens where it is missing.
//!
//! The referee is a folder outside this repository (FACETMILL_REFEREE, or `../shared/referee`); FACETMILL_PYTHON names
//! the Python that its setup.sh prints.

use std::path::{Path, PathBuf};

use crate::asking;
pub use crate::asking::ask;

/// Tells that the referee was not asked.
pub fn skip(why: &str) {
    asking::skip("the referee", why);
}

/// The referee's folder; if there is none, that has been said.
pub fn folder() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/referee");
    let folder = std::env::var("FACETMILL_REFEREE").map_or_else(|_| beside(), PathBuf::from);
    if folder.join("referee.py").exists() {
        return Some(folder);
    }
    skip(&format!("nothing at {}", folder.display()));
    None
}
