//! What a person sees: tables and errors.

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use facetmill::job::clock::wanted_threads;
use facetmill::job::design::DesignError;
use facetmill::memory::TooMuchMemory;
use facetmill::picture::PictureError;
use facetmill::progress::Cancelled;
use facetmill::recipe::RecipeError;
use facetmill::report::text;
use facetmill::verify::tally::MeasureError;
use serde::Serialize;
use serde_json::json;

use crate::args::RunningArgs;
use crate::files::OutputError;
use crate::tables::Row;
use crate::wrapping::wrapped;

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
    /// Of a measurement that did not come about: what `unlit` says where no light fell.
    pub fn of_measure(error: MeasureError, unlit: impl Into<String>) -> Self {
        match error {
            MeasureError::Cancelled(cancelled) => cancelled.into(),
            _ => Self::Impossible(unlit.into()),
        }
    }

    /// Of a recipe that flags made what it is.
    pub fn of_flags(error: RecipeError) -> Self {
        match error.is_impossible() {
            true => Self::Impossible(error.to_string()),
            false => Self::Usage(format!("--{error}")),
        }
    }

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

impl From<TooMuchMemory> for Failure {
    fn from(error: TooMuchMemory) -> Self {
        Self::Impossible(error.to_string())
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
    let said = one_line(&failure.to_string());
    let _ = match err.is_terminal() {
        // What a terminal echoes of Ctrl-C may stand there.
        true => write!(err, "\r\x1b[2K{}", wrapped("facetmill: ", &said)),
        false => writeln!(err, "facetmill: {said}"),
    };
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
#[derive(Default)]
pub struct Table {
    /// What was done, or what came of it.
    pub title: String,
    /// What matters most, in a few lines.
    pub rows: Vec<Row>,
    /// All figures, for --verbose.
    pub more: Vec<Row>,
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
        (false, false) => print_table(&table(report), running.verbose),
    }
}

fn print_table(Table { title, rows, more, notes }: &Table, verbose: bool) -> Result<(), OutputError> {
    let mut text = wrapped("", &one_line(title)) + &block(rows);
    if verbose {
        text += &block(more);
    }
    for note in notes {
        text += &wrapped("  Note: ", &one_line(note));
    }
    print(&text)
}

/// Rows below each other, what each figure means wrapped beside it.
fn block(rows: &[Row]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let (first, second) = (width(0), width(1));
    let line = |[name, value, meaning]: &Row| {
        let figure =
            if second > 0 { format!("  {name:first$}  {value:>second$}  ") } else { format!("  {name:first$}  ") };
        wrapped(&figure, &one_line(meaning))
    };
    rows.iter().map(line).collect()
}

/// To stdout. A reader that has gone away has read what it wanted.
pub fn print(text: &str) -> Result<(), OutputError> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(OutputError::StandardOutput(error)),
        _ => Ok(()),
    }
}

/// Says so if fewer threads work than were wanted.
pub fn tell_threads(running: &RunningArgs) {
    let (wanted, started) = (wanted_threads(running.threads), rayon::current_num_threads());
    if started < wanted && !running.quiet {
        let _ = writeln!(
            io::stderr(),
            "facetmill: of {wanted} threads only {started} can be started: it takes longer, and the result is the same"
        );
    }
}

/// Whether the system lets one more thread start.
pub fn a_thread_can_start() -> bool {
    std::thread::Builder::new().spawn(|| {}).is_ok_and(|thread| thread.join().is_ok())
}
