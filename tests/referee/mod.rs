//! Where the independent referee is, how it is asked, and what happens where it is missing.
//!
//! The referee is a folder outside this repository (FACETMILL_REFEREE, or `../shared/referee`); FACETMILL_PYTHON names
//! the Python that its setup.sh prints.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Tells on the terminal itself, past the test harness, that the referee was not asked.
#[allow(clippy::explicit_write, reason = "the harness hides what a passing test says with eprintln")]
pub fn skip(why: &str) {
    let required = std::env::var("FACETMILL_REQUIRE_CHECKERS").is_ok_and(|value| value == "1");
    assert!(!required, "the referee is required but missing: {why}");
    writeln!(std::io::stderr(), "SKIPPED: no opinion of the referee ({why})").unwrap();
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

/// What a script of this folder's parent prints, or why it cannot run: exit code 3 means that a package is missing.
pub fn ask<S: AsRef<OsStr>>(script: &str, arguments: &[S]) -> Result<String, String> {
    let python = std::env::var("FACETMILL_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(script);
    let run = Command::new(&python).arg(script).args(arguments).output().map_err(|why| format!("{python}: {why}"))?;
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    if run.status.code() == Some(3) {
        return Err(said.trim().into());
    }
    assert!(run.status.success(), "{said}{}", String::from_utf8_lossy(&run.stderr));
    Ok(said)
}
