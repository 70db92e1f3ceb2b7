//! Ctrl-C: what ends at once, and what is brought to an end first.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::console::{Failure, report_failure};
use crate::files;

/// Raised while a design is to end with its best so far; lowered again for what follows, or that would stop too.
pub static EARLY: AtomicBool = AtomicBool::new(false);

/// What the next Ctrl-C means. Global, since it comes from outside; locked while it must wait.
static STATE: Mutex<State> = Mutex::new(State { keeps: false, snapshots: None });

struct State {
    /// A design is under way and has something that is worth finishing.
    keeps: bool,
    /// Where snapshots lie that stay whatever happens.
    snapshots: Option<PathBuf>,
}

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What Ctrl-C does: a design that has something to keep is finished early, everything else ends here.
pub fn arrived(to_json: bool) {
    // Held to the end, so that nothing is written meanwhile.
    let mut state = state();
    if std::mem::take(&mut state.keeps) {
        EARLY.store(true, Ordering::Relaxed);
        let mut err = io::stderr();
        let clear = if err.is_terminal() { "\r\x1b[2K" } else { "" };
        let _ = writeln!(err, "{clear}facetmill: finishing the best so far; Ctrl-C again stops at once");
        return;
    }
    let stopped = Failure::Stopped { snapshots: state.snapshots.clone() };
    files::abandon(|| std::process::exit(report_failure(&stopped, to_json).into()));
}

/// Does `work`, during which Ctrl-C waits, after a step of a design: from now on there is something to keep.
pub fn keep<T>(work: impl FnOnce() -> T) -> T {
    let mut state = state();
    state.keeps = !EARLY.load(Ordering::Relaxed);
    work()
}

/// What a design leaves behind if it is stopped from now on.
pub fn snapshots_stay(folder: PathBuf) {
    state().snapshots = Some(folder);
}

/// The design is over: Ctrl-C ends what follows at once, as ever.
pub fn design_is_over() {
    let mut state = state();
    state.keeps = false;
    EARLY.store(false, Ordering::Relaxed);
}
