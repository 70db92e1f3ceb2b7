//! How far the work has come, on stderr: a line that moves on a terminal, a line for each stage elsewhere.

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use facetmill::progress::{Event, Stage};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::args::RunningArgs;
use crate::console::a_thread_can_start;
use crate::wrapping::{cut, wrapped};

/// Letters of a stage's name beside its bar, and once it is over.
const BESIDE: usize = 32;
const ALONE: usize = 60;

/// Positions of a bar. The last is shown only once the stage is over: what ends a stage, such as a cutter led over the whole
/// relief, tells of no share.
const WHOLE: u64 = 1000;
const LAST: u64 = 990;

/// What a person sees of the work.
#[derive(Default)]
pub struct Stages {
    how: How,
    present: Mutex<Option<(ProgressBar, Instant)>>,
}

#[derive(Clone, Copy, Default, PartialEq)]
enum How {
    /// Nothing.
    #[default]
    Silent,
    /// A line when a stage begins.
    Lines,
    /// A bar.
    Bar,
}

impl Stages {
    /// A bar on a terminal, lines in a file or pipe; nothing where --quiet or --json asks for nothing.
    pub fn new(running: &RunningArgs) -> Self {
        let how = match (running.quiet, io::stderr().is_terminal(), running.json) {
            (true, ..) | (false, false, true) => How::Silent,
            (false, true, _) => How::Bar,
            (false, false, false) => How::Lines,
        };
        Self { how, present: Mutex::default() }
    }

    /// Takes an event of the library.
    pub fn hear(&self, event: Event<'_>) {
        match (self.how, event) {
            (How::Lines, Event::Stage(stage, note)) => {
                let note = note.map(|note| format!(" ({note})")).unwrap_or_default();
                let _ = writeln!(io::stderr(), "  {}{note}", stage.words());
            }
            (How::Bar, Event::Stage(stage, note)) => self.begin(stage, note),
            (How::Bar, Event::Fraction(done)) => {
                if let Some((bar, _)) = self.present().as_ref() {
                    bar.set_position(((WHOLE as f64 * done) as u64).min(LAST));
                }
            }
            // Without a bar nothing tells how far a stage has come.
            _ => {}
        }
    }

    fn present(&self) -> MutexGuard<'_, Option<(ProgressBar, Instant)>> {
        self.present.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn begin(&self, stage: Stage, note: Option<&str>) {
        let mut present = self.present();
        close(&mut present);
        let bar = ProgressBar::with_draw_target(Some(WHOLE), ProgressDrawTarget::stderr());
        if let Some(note) = note {
            bar.suspend(|| write!(io::stderr(), "{}", wrapped("  Note: ", note)).unwrap_or_default());
        }
        // 80 columns at the most, with "  about 100 min left".
        if let Ok(style) = ProgressStyle::with_template("  {spinner} {msg} {bar:16} {percent:>3}%{left}") {
            bar.set_style(style.with_key("left", time_left));
        }
        bar.set_message(format!("{:BESIDE$}", cut(stage.words(), BESIDE)));
        // Ticks come from a thread, for want of which the bar would panic; without them it moves with the work.
        if a_thread_can_start() {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        *present = Some((bar, Instant::now()));
    }

    /// Ends the last stage's line.
    pub fn finish(&self) {
        let mut present = self.present();
        if present.is_some() {
            close(&mut present);
            // The line was filled up to its end but not ended.
            let _ = writeln!(io::stderr());
        }
    }

    /// Takes an unfinished line away.
    pub fn clear(&self) {
        if let Some((bar, _)) = self.present().take() {
            bar.finish_and_clear();
        }
    }

    /// Says something beside the work that goes on.
    pub fn say(&self, what: &str) {
        let tell = || {
            let mut err = io::stderr();
            // What a terminal echoes of Ctrl-C may stand there.
            let clear = if err.is_terminal() { "\r\x1b[2K" } else { "" };
            let _ = writeln!(err, "{clear}{what}");
        };
        match self.present().as_ref() {
            Some((bar, _)) => bar.suspend(tell),
            None => tell(),
        }
    }
}

/// Writes how long the rest of the stage takes, once there is enough to tell it from: as long a share as so far.
fn time_left(state: &ProgressState, out: &mut dyn fmt::Write) {
    let (spent, done) = (state.elapsed().as_secs_f64(), f64::from(state.fraction()));
    if spent > 2.0 && (0.05..LAST as f64 / WHOLE as f64).contains(&done) {
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
        let name = bar.message().trim_end().to_owned();
        bar.finish_with_message(format!("{name:ALONE$} {:6.2} s", since.elapsed().as_secs_f64()));
    }
}
