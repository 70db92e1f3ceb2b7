//! How a Python script beside the tests is asked, and what happens where its packages are missing.
//!
//! FACETMILL_PYTHON names the Python, `python3` if unset.

use std::ffi::OsStr;
use std::io::Write;
use std::path::Path;
use std::process::Command;

/// Tells on the terminal itself, past the test harness, that `whom` was not asked; a failure if checkers are required.
#[allow(clippy::explicit_write, reason = "the harness hides what a passing test says with eprintln")]
pub fn skip(whom: &str, why: &str) {
    let required = std::env::var("FACETMILL_REQUIRE_CHECKERS").is_ok_and(|value| value == "1");
    assert!(!required, "{whom} is required but missing: {why}");
    writeln!(std::io::stderr(), "SKIPPED: no opinion of {whom} ({why})").unwrap();
}

/// What a script in `tests/` prints, or why it cannot run: exit code 3 means that a package is missing.
pub fn ask<S: AsRef<OsStr>>(script: &str, arguments: &[S]) -> Result<String, String> {
    let python = std::env::var("FACETMILL_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/outside").join(script);
    let run = Command::new(&python).arg(script).args(arguments).output().map_err(|why| format!("{python}: {why}"))?;
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    if run.status.code() == Some(3) {
        return Err(said.trim().into());
    }
    assert!(run.status.success(), "{said}{}", String::from_utf8_lossy(&run.stderr));
    Ok(said)
}
