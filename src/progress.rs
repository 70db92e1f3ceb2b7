//! How long work reports on itself and is stopped: the library never prints.

use std::sync::atomic::{AtomicBool, Ordering};

/// A listener for long work, handed down by the caller.
///
/// ```
/// use facetmill::progress::Progress;
/// let silent = Progress::silent();
/// silent.stage("sampling");
/// silent.fraction(0.5);
/// assert!(!silent.is_cancelled());
/// ```
pub struct Progress<'a> {
    listen: Option<&'a (dyn Fn(Event<'_>) + Sync)>,
    cancel: Option<&'a AtomicBool>,
}

/// What long work says of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// A named stage begins; the one before it is over.
    Stage(&'a str),
    /// The share of the present stage that is done, 0 to 1.
    Fraction(f64),
}

impl<'a> Progress<'a> {
    /// Nobody listens and nothing cancels.
    pub const fn silent() -> Self {
        Self { listen: None, cancel: None }
    }

    /// `listen` hears every event; raising `cancel` asks the work to stop at its next convenience.
    pub fn new(listen: &'a (dyn Fn(Event<'_>) + Sync), cancel: &'a AtomicBool) -> Self {
        Self { listen: Some(listen), cancel: Some(cancel) }
    }

    /// Stopped by the same flag, but nobody listens: for a part of work whose whole reports on itself.
    pub const fn hushed(&self) -> Self {
        Self { listen: None, cancel: self.cancel }
    }

    /// Announces the next stage.
    pub fn stage(&self, name: &str) {
        if let Some(listen) = self.listen {
            listen(Event::Stage(name));
        }
    }

    /// Says how far the present stage has come, 0 to 1.
    pub fn fraction(&self, done: f64) {
        if let Some(listen) = self.listen {
            listen(Event::Fraction(done));
        }
    }

    /// Whether the caller wants the work to end early.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}
