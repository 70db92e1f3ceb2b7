//! Broken and hostile inputs, each through the whole program: the right exit code, one clear sentence that names the
//! culprit, no file left behind, no panic, an end.

mod flags;
mod measure;
mod outputs;
mod pictures;
mod plates;
mod recipes;

use std::path::Path;

use crate::program::{self, Outcome, listing, run};
use tempfile::TempDir;

/// Hostile runs in one folder; all are made before any failure is told.
struct Trials {
    home: TempDir,
    failures: Vec<String>,
}

impl Trials {
    /// In a folder with `ring.png`.
    fn new() -> Self {
        Self { home: program::home(), failures: Vec::new() }
    }

    fn home(&self) -> &Path {
        self.home.path()
    }

    /// Runs the program and holds it to what every refusal owes its user.
    fn refused(&mut self, args: &[&str], code: i32, names: &[&str]) {
        let before = listing(self.home());
        let outcome = run(self.home(), args);
        let problem = match listing(self.home()) {
            after if after != before => Some(format!("left something behind: {after:?}")),
            _ => wrong_with(&outcome, code, names),
        };
        // So that one failure is one failure.
        let _ = std::fs::remove_dir_all(self.home().join("out"));
        self.failures.extend(problem.map(|problem| format!("{args:?} {problem}\n  {outcome:?}")));
    }

    /// Fails if any trial did.
    fn judge(self) {
        assert!(self.failures.is_empty(), "{} failures:\n{}", self.failures.len(), self.failures.join("\n"));
    }
}

/// What is wrong with a refusal that should have this exit code and name these things, if anything is.
fn wrong_with(outcome: &Outcome, code: i32, names: &[&str]) -> Option<String> {
    let Outcome { stdout, stderr, .. } = outcome;
    if std::env::var_os("FACETMILL_SHOW_REFUSALS").is_some() {
        eprint!("{code} {stderr}");
    }
    let one_sentence = stderr.starts_with("facetmill: ") && stderr.ends_with('\n') && stderr.lines().count() == 1;
    if outcome.code != Some(code) {
        Some(format!("should end with {code}"))
    } else if !one_sentence || stderr.contains("panicked") || stderr.len() > 600 || !stdout.is_empty() {
        Some("should say one sentence".into())
    } else {
        names.iter().find(|name| !stderr.contains(**name)).map(|name| format!("should name {name}"))
    }
}

/// `line` split into words; `''` is an empty word.
fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().map(|word| if word == "''" { "" } else { word }).collect()
}
