//! The minimum Rust that Cargo.toml states is the one that the locked packages need.

use std::process::Command;

use serde_json::Value;

use crate::source::root;

/// A version as numbers, so that 1.100 is above 1.88.
fn version(text: &str) -> Vec<u32> {
    let mut numbers: Vec<u32> = text.split('.').map(|part| part.parse().unwrap()).collect();
    numbers.resize(3, 0);
    numbers
}

/// What Cargo knows of the packages in Cargo.lock without asking a registry; none, and the reason told, if it does not.
fn packages() -> Option<Vec<Value>> {
    let run = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--offline", "--format-version", "1"])
        .current_dir(root())
        .output();
    let why = match run {
        Ok(run) if run.status.success() => {
            let metadata: Value = serde_json::from_slice(&run.stdout).unwrap();
            return Some(metadata["packages"].as_array().unwrap().clone());
        }
        Ok(run) => String::from_utf8_lossy(&run.stderr).trim().replace('\n', " "),
        Err(why) => why.to_string(),
    };
    tell(&format!("SKIPPED: the minimum Rust of the locked packages ({why})"));
    None
}

/// On the terminal itself, past the test harness, which hides what a passing test says with eprintln.
#[allow(clippy::explicit_write, reason = "the harness hides what a passing test says with eprintln")]
fn tell(line: &str) {
    use std::io::Write;
    writeln!(std::io::stderr(), "{line}").unwrap();
}

#[test]
fn the_stated_minimum_rust_is_that_of_the_locked_packages() {
    let Some(packages) = packages() else { return };
    let needed = |package: &Value| Some((version(package["rust_version"].as_str()?), package["name"].clone()));
    let (ours, others): (Vec<_>, Vec<_>) = packages.iter().partition(|package| package["name"] == "facetmill");
    let stated = ours[0]["rust_version"].as_str().unwrap();
    let most = others.into_iter().filter_map(needed).max_by_key(|(version, _)| version.clone()).unwrap();
    assert!(version(stated) >= most.0, "{} needs Rust {:?}, Cargo.toml says {stated}", most.1, most.0);
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.contains(&format!("Rust {stated} or newer")), "README.md does not say 'Rust {stated} or newer'");
    let workflow = std::fs::read_to_string(root().join(".github/workflows/ci.yml")).unwrap();
    assert!(workflow.contains(&format!("toolchain: '{stated}'")), "the workflow does not try Rust {stated}");
}

#[test]
fn panics_unwind_in_every_profile_so_that_the_fence_around_decoders_holds() {
    let text = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let manifest: toml::Table = text.parse().unwrap();
    for (name, profile) in manifest["profile"].as_table().unwrap() {
        let panic = profile.get("panic").and_then(toml::Value::as_str).unwrap_or("unwind");
        assert_eq!(panic, "unwind", "profile.{name}");
    }
}
