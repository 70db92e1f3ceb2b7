//! Signals: what Ctrl-C ends at once and what it brings to an end first, and files that grow too large.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use facetmill::progress::CancelToken;

use crate::console::{Failure, report_failure};
use crate::files::Gate;
use crate::stages::Stages;

/// Beyond a limit on the size of files the system would end the program by a signal: caught, the write fails instead, and
/// is told and cleared away like any other.
pub fn catch_size_limit() {
    #[cfg(unix)]
    // Without the handler the program still ends, only less tidily.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// One run of the program, as Ctrl-C meets it.
#[derive(Default)]
pub struct Run {
    /// Ends its design.
    pub cancel: CancelToken,
    /// What it has on the disk that must not stay.
    pub gate: Arc<Gate>,
    /// What the next Ctrl-C means; locked while it must wait.
    state: Mutex<State>,
    /// What a person sees of its work.
    stages: OnceLock<Arc<Stages>>,
}

#[derive(Default)]
struct State {
    /// A design is under way and has something that is worth finishing.
    keeps: bool,
    /// Where snapshots lie that stay whatever happens.
    snapshots: Option<PathBuf>,
}

impl Run {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What Ctrl-C does: a design that has something to keep is finished early, everything else ends here.
    pub fn interrupted(&self, to_json: bool) {
        // Held to the end, so that nothing is written meanwhile.
        let mut state = self.state();
        if std::mem::take(&mut state.keeps) {
            self.cancel.finish();
            let said = "facetmill: finishing the best so far; Ctrl-C again stops at once";
            self.stages.get().map_or_else(|| Stages::default().say(said), |stages| stages.say(said));
            return;
        }
        let stopped = Failure::Stopped { snapshots: state.snapshots.clone() };
        self.clear_progress();
        self.gate.abandon(|| std::process::exit(report_failure(&stopped, to_json).into()));
    }

    /// Takes what a person sees of the work, so that an interruption can clear it away.
    pub fn shows(&self, stages: Stages) -> Arc<Stages> {
        self.stages.get_or_init(|| Arc::new(stages)).clone()
    }

    /// Takes the progress off the terminal before something else is said there.
    pub fn clear_progress(&self) {
        if let Some(stages) = self.stages.get() {
            stages.clear();
        }
    }

    /// Does `work`, during which Ctrl-C waits, after a step of a design: from now on there is something to keep.
    pub fn keep<T>(&self, work: impl FnOnce() -> T) -> T {
        let mut state = self.state();
        state.keeps = !self.cancel.is_to_finish();
        work()
    }

    /// What a design leaves behind if it is stopped from now on.
    pub fn snapshots_stay(&self, folder: PathBuf) {
        self.state().snapshots = Some(folder);
    }

    /// The design is over: Ctrl-C ends what follows at once, as ever.
    pub fn design_is_over(&self) {
        self.state().keeps = false;
    }
}
