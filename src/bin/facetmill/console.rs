//! What a person sees: progress, tables, errors.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use facetmill::picture::PictureError;
use facetmill::progress::Event;
use facetmill::recipe::run::DesignError;
use facetmill::verify::verdict::Verdict;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use crate::files::OutputError;

/// Why the program ends without its result; each kind has an exit code of its own.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The command line asks for what no flag can mean.
    #[error("{0}")]
    Usage(String),
    /// A file cannot be read or makes no sense.
    #[error("{0}")]
    Input(String),
    /// Everything is readable, but no plate can be made so.
    #[error("{0}")]
    Impossible(String),
    /// Results cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Ctrl-C.
    #[error("stopped; nothing was written")]
    Stopped,
}

impl Failure {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Input(_) => 3,
            Self::Impossible(_) => 4,
            Self::Output(_) => 5,
            Self::Stopped => 130,
        }
    }
}

impl From<PictureError> for Failure {
    fn from(error: PictureError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<DesignError> for Failure {
    fn from(error: DesignError) -> Self {
        match error {
            DesignError::Cancelled => Self::Stopped,
            other => Self::Impossible(other.to_string()),
        }
    }
}

/// Says why on stderr, and to machines on stdout.
pub fn report_failure(failure: &Failure, to_json: bool) -> ExitCode {
    let code = failure.exit_code();
    let _ = writeln!(io::stderr(), "facetmill: {failure}");
    if to_json {
        print_json(&json!({ "error": failure.to_string(), "exit_code": code }));
    }
    ExitCode::from(code)
}

/// One line of JSON facts, indented.
pub fn print_json(value: &Value) {
    // A reader that has gone away is no reason to fail: the files are what counts.
    let _ = writeln!(io::stdout(), "{value:#}");
}

/// Rows of name, value and meaning.
pub fn print_table(title: &str, rows: &[[String; 3]]) {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let (first, second) = (width(0), width(1));
    let mut out = io::stdout().lock();
    let _ = writeln!(out, "{title}");
    for [name, value, meaning] in rows {
        let line = format!("  {name:first$}  {value:>second$}  {meaning}");
        let _ = writeln!(out, "{}", line.trim_end());
    }
}

/// The figures of a verdict as rows of a table.
pub fn verdict_rows(verdict: &Verdict) -> Vec<[String; 3]> {
    let row = |name: &str, value: String, meaning: &str| [name.to_owned(), value, meaning.to_owned()];
    let main = verdict.main();
    let percent = |share: f64| format!("{:.2}", 100.0 * share);
    vec![
        row(
            "TV at 1°",
            format!("{:.4}", main.tv_incident.value),
            "share of light in the wrong place, losses counted; 0 is perfect",
        ),
        row("SSIM at 1°", format!("{:.3}", main.ssim.value), "likeness to the drawing; 1 is the same picture"),
        row("W1", format!("{:.3}", verdict.w1.value), "° by which light is off its place on average"),
        row("efficiency", percent(verdict.efficiency.value), "% of the light lands where the drawing is lit"),
        row("bounced twice", percent(verdict.multi_bounce.value), "% of the light that leaves"),
        row("blocked", percent(verdict.blocked.value), "% of the light that falls on the plate"),
    ]
}

/// A sentence on its own line.
pub fn print_line(sentence: &str) {
    let _ = writeln!(io::stdout(), "{sentence}");
}

/// A progress line per stage on stderr, if somebody looks.
pub struct Stages {
    present: Mutex<Option<(ProgressBar, Instant)>>,
    visible: bool,
}

impl Stages {
    /// Hidden when `quiet` or when stderr is not a terminal.
    pub fn new(quiet: bool) -> Self {
        Self { present: Mutex::new(None), visible: !quiet && io::stderr().is_terminal() }
    }

    /// Takes an event of the library.
    pub fn hear(&self, event: Event<'_>) {
        if !self.visible {
            return;
        }
        let Ok(mut present) = self.present.lock() else { return };
        match event {
            Event::Stage(name) => {
                close(&mut present);
                let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
                if let Ok(style) = ProgressStyle::with_template("  {spinner} {msg:36} {bar:24} {percent:>3}%") {
                    bar.set_style(style);
                }
                bar.set_message(name.to_owned());
                bar.enable_steady_tick(Duration::from_millis(100));
                *present = Some((bar, Instant::now()));
            }
            Event::Fraction(done) => {
                if let Some((bar, _)) = present.as_ref() {
                    bar.set_position((1000.0 * done) as u64);
                }
            }
        }
    }

    /// Ends the last stage's line.
    pub fn finish(&self) {
        if let Ok(mut present) = self.present.lock() {
            close(&mut present);
        }
    }
}

fn close(present: &mut Option<(ProgressBar, Instant)>) {
    if let Some((bar, since)) = present.take() {
        if let Ok(style) = ProgressStyle::with_template("  {msg}") {
            bar.set_style(style);
        }
        bar.finish_with_message(format!("{:38} {:6.2} s", bar.message(), since.elapsed().as_secs_f64()));
    }
}
