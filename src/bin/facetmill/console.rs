//! What a person sees: progress, tables, errors.

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use facetmill::job::design::DesignError;
use facetmill::picture::PictureError;
use facetmill::progress::{Cancelled, Event};
use facetmill::report::text;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use serde::Serialize;
use serde_json::json;

use crate::args::RunningArgs;
use crate::files::OutputError;
use crate::tables::Row;

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
    /// The work is done, and its figure is worse than was allowed.
    #[error("{0}")]
    Beyond(String),
    /// Results cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Ctrl-C.
    #[error("{}", stopped(snapshots.as_deref()))]
    Stopped {
        /// Where snapshots were left.
        snapshots: Option<PathBuf>,
    },
}

impl Failure {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Beyond(_) => 1,
            Self::Usage(_) | Self::Output(OutputError::OwnInput(..)) => 2,
            Self::Input(_) => 3,
            Self::Impossible(_) => 4,
            Self::Output(_) => 5,
            Self::Stopped { .. } => 130,
        }
    }
}

fn stopped(snapshots: Option<&Path>) -> String {
    match snapshots {
        None => "stopped; nothing was written".into(),
        Some(folder) => format!("stopped; the same command with --resume goes on from {}", folder.display()),
    }
}

impl From<PictureError> for Failure {
    fn from(error: PictureError) -> Self {
        match error {
            // The picture is sound; the flags cut off what it holds.
            PictureError::CutAway { .. } => Self::Impossible(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::Stopped { snapshots: None }
    }
}

impl From<DesignError> for Failure {
    fn from(error: DesignError) -> Self {
        match error {
            DesignError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Impossible(other.to_string()),
        }
    }
}

/// Says why on stderr, and to machines on stdout; the exit code.
pub fn report_failure(failure: &Failure, to_json: bool) -> u8 {
    let code = failure.exit_code();
    let mut err = io::stderr();
    // A progress line may stand there, and what a terminal echoes of Ctrl-C.
    let clear = if err.is_terminal() { "\r\x1b[2K" } else { "" };
    let _ = writeln!(err, "{clear}facetmill: {}", one_line(&failure.to_string()));
    // The report has been printed, and says the same.
    if to_json && !matches!(failure, Failure::Beyond(_)) {
        let _ = print_json(&json!({ "error": failure.to_string(), "exit_code": code }));
    }
    code
}

/// Names of files can hold anything, line ends and commands to the terminal too, and be thousands of letters long.
fn one_line(text: &str) -> String {
    const MOST: usize = 500;
    let clean = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let letters: Vec<char> = text.chars().map(clean).collect();
    if letters.len() <= MOST {
        return letters.into_iter().collect();
    }
    let (start, end) = (&letters[..MOST / 2], &letters[letters.len() - MOST / 2..]);
    start.iter().chain(&['…']).chain(end).collect()
}

/// A report as JSON.
fn print_json(report: &impl Serialize) -> Result<(), OutputError> {
    print(&text(report))
}

/// What a person is told at the end, in place of a report.
pub struct Table {
    /// What was done.
    pub title: String,
    /// Its figures.
    pub rows: Vec<Row>,
    /// What there is to know besides.
    pub notes: Vec<String>,
}

/// Tells of what was done, as --json and --quiet ask: the report, its table, or nothing.
pub fn tell<R: Serialize>(
    running: &RunningArgs,
    report: &R,
    table: impl FnOnce(&R) -> Table,
) -> Result<(), OutputError> {
    match (running.json, running.quiet) {
        (true, _) => print_json(report),
        (false, true) => Ok(()),
        (false, false) => print_table(&table(report)),
    }
}

fn print_table(Table { title, rows, notes }: &Table) -> Result<(), OutputError> {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let (first, second) = (width(0), width(1));
    let mut text = one_line(title) + "\n";
    for [name, value, meaning] in rows {
        text += format!("  {name:first$}  {value:>second$}  {meaning}").trim_end();
        text.push('\n');
    }
    for note in notes {
        text += &format!("  Note: {}\n", one_line(note));
    }
    print(&text)
}

/// To stdout. A reader that has gone away has read what it wanted.
fn print(text: &str) -> Result<(), OutputError> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(OutputError::StandardOutput(error)),
        _ => Ok(()),
    }
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
            Event::Stage(stage, note) => {
                close(&mut present);
                let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
                if let Ok(style) = ProgressStyle::with_template("  {spinner} {msg:36} {bar:24} {percent:>3}%{left}") {
                    bar.set_style(style.with_key("left", time_left));
                }
                let note = note.map(|note| format!(" ({note})")).unwrap_or_default();
                bar.set_message(format!("{}{note}", stage.words()));
                bar.enable_steady_tick(Duration::from_millis(100));
                *present = Some((bar, Instant::now()));
            }
            Event::Fraction(done) => {
                if let Some((bar, _)) = present.as_ref() {
                    bar.set_position((1000.0 * done) as u64);
                }
            }
            _ => {}
        }
    }

    /// Ends the last stage's line.
    pub fn finish(&self) {
        if let Ok(mut present) = self.present.lock()
            && present.is_some()
        {
            close(&mut present);
            // The line was filled up to its end but not ended.
            let _ = writeln!(io::stderr());
        }
    }
}

/// Writes how long the rest takes, once there is enough to tell it from: as long a share as so far.
fn time_left(state: &ProgressState, out: &mut dyn fmt::Write) {
    let (spent, done) = (state.elapsed().as_secs_f64(), f64::from(state.fraction()));
    if spent > 2.0 && (0.02..1.0).contains(&done) {
        let left = (spent * (1.0 - done) / done).ceil() as u64;
        let _ = match left {
            0..60 => write!(out, "  about {left} s left"),
            _ => write!(out, "  about {} min left", left.div_ceil(60)),
        };
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
