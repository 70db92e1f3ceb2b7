//! How long work reports on itself and is stopped: the library never prints.
//!
//! A caller hands a [`Progress`] down. What it may hear is an [`Event`] at a time, and a relief that is under way if it
//! says that it wants one. What it may ask for goes through a [`CancelToken`], in two strengths: *finish* with the best
//! so far, or *abandon* everything. Work that was abandoned ends in [`Cancelled`]; work that was told to finish ends as
//! ever, only sooner and less well.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::time::Instant;

use glam::DVec2;

/// Time between two reliefs that are shown, ms.
const BETWEEN_RELIEFS: u64 = 150;

/// Items of a long loop between two questions: what takes a microsecond each is asked every 16 ms.
const STRETCH: usize = 1 << 14;

/// A part of the work that takes a while. Its [id](Stage::id) never changes, its [words](Stage::words) may.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Stage {
    /// Slopes are read off the drawing.
    Distribution,
    /// The light is sharpened against what lamp and metal will blur.
    Sharpening,
    /// A sheet is shaped.
    Sculpting,
    /// A sheet is led over the whole plate to where its light lands on the wall.
    Room,
    /// Facets are drawn from the slopes wanted.
    Sampling,
    /// Facets are put in their places.
    Arrangement,
    /// Facets are raised so that neighbours meet.
    Heights,
    /// The relief becomes a closed body.
    Solid,
    /// A plate is read from a file.
    Reading,
    /// Light is sent over the plate.
    Tracing,
    /// What came back is compared with the drawing.
    Scoring,
    /// The cutter is led over the plate, and light sent over what it leaves.
    Milling,
    /// What a plate would be, if it were made in hundreds of ways.
    Planning,
    /// Programs for a machine are made, read back and judged.
    Programs,
    /// Flat facets of the same recipe are made and judged.
    Comparison,
    /// Flat facets are made after all.
    Facets,
    /// Light is sent over the plate from every side.
    Goniometer,
    /// Normals are counted.
    Normals,
    /// Light is thrown on a wall.
    Wall,
    /// The plate is looked at.
    View,
    /// Files are made and written.
    Files,
}

impl Stage {
    /// A name for programs, which stays the same.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Distribution => "distribution",
            Self::Sharpening => "sharpening",
            Self::Sculpting => "sculpting",
            Self::Room => "room",
            Self::Sampling => "sampling",
            Self::Arrangement => "arrangement",
            Self::Heights => "heights",
            Self::Solid => "solid",
            Self::Reading => "reading",
            Self::Tracing => "tracing",
            Self::Scoring => "scoring",
            Self::Milling => "milling",
            Self::Planning => "planning",
            Self::Programs => "programs",
            Self::Comparison => "comparison",
            Self::Facets => "facets",
            Self::Goniometer => "goniometer",
            Self::Normals => "normals",
            Self::Wall => "wall",
            Self::View => "view",
            Self::Files => "files",
        }
    }

    /// What is done, for people.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Distribution => "reading slopes off the highlight",
            Self::Sharpening => "sharpening what lamp and metal will blur",
            Self::Sculpting => "sculpting the relief",
            Self::Room => "fitting it to lamp and wall",
            Self::Sampling => "drawing facets",
            Self::Arrangement => "arranging facets",
            Self::Heights => "raising facets",
            Self::Solid => "closing the solid",
            Self::Reading => "reading the plate",
            Self::Tracing => "tracing light over the plate",
            Self::Scoring => "scoring",
            Self::Milling => "milling it, and tracing that",
            Self::Planning => "looking for the best way to make it",
            Self::Programs => "making programs, and reading them back",
            Self::Comparison => "comparing with flat facets",
            Self::Facets => "making flat facets, which are better here",
            Self::Goniometer => "lighting the plate from all sides",
            Self::Normals => "counting normals",
            Self::Wall => "throwing light on the wall",
            Self::View => "looking at the plate",
            Self::Files => "writing files",
        }
    }
}

/// What long work says of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A stage begins, the one before it is over; and what is to be said of it, if anything.
    Stage(Stage, Option<&'a str>),
    /// The share of the present stage that is done, 0 to 1.
    Fraction(f64),
}

/// A sheet that is under way: heights of one cell about its mean plane.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetSoFar {
    /// Nodes along each side.
    pub nodes: usize,
    /// Size of the cell along x and y, mm.
    pub cell: DVec2,
    /// Heights, mm, rows of constant y, the lowest first.
    pub heights: Vec<f32>,
}

/// Whoever listens to long work. A closure that takes an [`Event`] is one that wants no reliefs.
pub trait Listener: Sync {
    /// Hears an event; on whichever thread it happens.
    fn hear(&self, event: Event<'_>);

    /// Whether a relief that is under way is wanted now. Asked often: nothing is computed while the answer is no.
    fn wants_relief(&self) -> bool {
        false
    }

    /// Looks at a relief that is under way, at most every 150 ms.
    fn see(&self, _relief: &SheetSoFar) {}
}

impl<F: Fn(Event<'_>) + Sync> Listener for F {
    fn hear(&self, event: Event<'_>) {
        self(event);
    }
}

const GO_ON: u8 = 0;
const FINISH: u8 = 1;
const ABANDON: u8 = 2;

/// Ends work from outside, from any thread. Clones are the same token.
///
/// ```
/// use facetmill::progress::CancelToken;
/// let token = CancelToken::default();
/// let elsewhere = token.clone();
/// elsewhere.finish();
/// assert!(token.is_to_finish() && !token.is_abandoned());
/// elsewhere.abandon();
/// elsewhere.finish(); // too late
/// assert!(token.is_abandoned());
/// ```
#[derive(Clone, Default)]
pub struct CancelToken(Arc<Wish>);

#[derive(Default)]
struct Wish {
    strength: AtomicU8,
    /// Told of every question: how often one is asked can be measured so.
    watch: Option<Box<dyn Fn() + Send + Sync>>,
}

impl CancelToken {
    /// A token that calls `watch` whenever work asks whether it is to end, on the thread that asks: to measure how often
    /// that is, or to end work at one certain question.
    pub fn watched(watch: impl Fn() + Send + Sync + 'static) -> Self {
        Self(Arc::new(Wish { strength: AtomicU8::new(GO_ON), watch: Some(Box::new(watch)) }))
    }

    /// Asks for the best so far: the design ends early, and all that follows of it is done as ever.
    pub fn finish(&self) {
        self.0.strength.fetch_max(FINISH, Ordering::Relaxed);
    }

    /// Asks for nothing more.
    pub fn abandon(&self) {
        self.0.strength.fetch_max(ABANDON, Ordering::Relaxed);
    }

    /// Whether the work is to come to an end, in either strength.
    pub fn is_to_finish(&self) -> bool {
        self.asked() >= FINISH
    }

    /// Whether nothing more is wanted.
    pub fn is_abandoned(&self) -> bool {
        self.asked() >= ABANDON
    }

    fn asked(&self) -> u8 {
        if let Some(watch) = &self.0.watch {
            watch();
        }
        self.0.strength.load(Ordering::Relaxed)
    }
}

/// Work was abandoned, as its caller asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("abandoned as asked")]
pub struct Cancelled;

/// What the caller of long work hands down: who listens, and who may end it.
///
/// ```
/// use facetmill::progress::{Progress, Stage};
/// let silent = Progress::silent();
/// silent.stage(Stage::Sampling);
/// silent.fraction(0.5);
/// assert!(silent.check().is_ok());
/// ```
pub struct Progress<'a> {
    listener: Option<&'a dyn Listener>,
    cancel: Option<&'a CancelToken>,
    /// The weakest wish that ends the work with the best so far, and the weakest that ends it with nothing.
    finished_by: u8,
    abandoned_by: u8,
    since: Option<Instant>,
    /// When the last relief was shown, ms after `since`; one more, so that 0 is never.
    shown: AtomicU64,
}

impl<'a> Progress<'a> {
    /// Nobody listens and nothing cancels.
    pub const fn silent() -> Self {
        Self {
            listener: None,
            cancel: None,
            finished_by: FINISH,
            abandoned_by: ABANDON,
            since: None,
            shown: AtomicU64::new(0),
        }
    }

    /// `listener` hears every event; `cancel` ends the work.
    pub fn new(listener: &'a dyn Listener, cancel: &'a CancelToken) -> Self {
        Self { listener: Some(listener), cancel: Some(cancel), since: Some(Instant::now()), ..Self::silent() }
    }

    /// Ended by the same token, but nobody listens: for a part of work whose whole reports on itself.
    pub const fn hushed(&self) -> Self {
        Self { listener: None, since: None, ..self.again() }
    }

    /// Ended only by a wish to abandon: for work that has no best so far.
    pub const fn to_the_end(&self) -> Self {
        Self { finished_by: self.abandoned_by, ..self.again() }
    }

    /// Abandoned by either wish, and nobody listens: for a try that is dropped when the work is to finish, while the best
    /// before it is kept.
    pub const fn until_finish(&self) -> Self {
        Self { abandoned_by: self.finished_by, ..self.hushed() }
    }

    /// The same once more; only reliefs are counted anew.
    const fn again(&self) -> Self {
        let Self { listener, cancel, finished_by, abandoned_by, since, .. } = *self;
        Self { listener, cancel, finished_by, abandoned_by, since, shown: AtomicU64::new(0) }
    }

    /// Announces the next stage.
    pub fn stage(&self, stage: Stage) {
        self.say(Event::Stage(stage, None));
    }

    /// Announces the next stage, and something that is to be said of it.
    pub fn stage_with(&self, stage: Stage, note: &str) {
        self.say(Event::Stage(stage, Some(note)));
    }

    /// Says how far the present stage has come, 0 to 1.
    pub fn fraction(&self, done: f64) {
        self.say(Event::Fraction(done));
    }

    fn say(&self, event: Event<'_>) {
        if let Some(listener) = self.listener {
            listener.hear(event);
        }
    }

    /// Shows a relief that is under way, if somebody wants one and the last was shown a while ago; else it is not made.
    pub fn offer_relief(&self, relief: impl FnOnce() -> SheetSoFar) {
        let (Some(listener), Some(since)) = (self.listener, self.since) else { return };
        if !listener.wants_relief() {
            return;
        }
        let now = since.elapsed().as_millis() as u64 + 1;
        let last = self.shown.load(Ordering::Relaxed);
        let is_due = last == 0 || now >= last + BETWEEN_RELIEFS;
        // Of two threads at once one shows.
        if is_due && self.shown.compare_exchange(last, now, Ordering::Relaxed, Ordering::Relaxed).is_ok() {
            listener.see(&relief());
        }
    }

    /// Whether the caller wants the work to end, with the best so far or at all.
    pub fn is_to_finish(&self) -> bool {
        self.is_ended_by(self.finished_by)
    }

    /// Whether the caller wants nothing more.
    pub fn is_abandoned(&self) -> bool {
        self.is_ended_by(self.abandoned_by)
    }

    fn is_ended_by(&self, weakest: u8) -> bool {
        self.cancel.is_some_and(|token| token.asked() >= weakest)
    }

    /// Ends work that was abandoned.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_abandoned() { Err(Cancelled) } else { Ok(()) }
    }

    /// The numbers below `count` in short stretches, and the question whether to go on before each.
    ///
    /// ```
    /// use facetmill::progress::{CancelToken, Cancelled, Progress};
    /// fn sum(progress: &Progress) -> Result<usize, Cancelled> {
    ///     let mut sum = 0;
    ///     for stretch in progress.stretches(100_000) {
    ///         sum += stretch?.sum::<usize>();
    ///     }
    ///     Ok(sum)
    /// }
    /// assert_eq!(sum(&Progress::silent()), Ok(4_999_950_000));
    /// let (listen, token) = (|_: facetmill::progress::Event<'_>| {}, CancelToken::default());
    /// token.abandon();
    /// assert_eq!(sum(&Progress::new(&listen, &token)), Err(Cancelled));
    /// ```
    pub fn stretches(&self, count: usize) -> impl Iterator<Item = Result<Range<usize>, Cancelled>> {
        let stretch = move |from: usize| self.check().map(|()| from..count.min(from + STRETCH));
        (0..count).step_by(STRETCH).map(stretch)
    }
}

#[cfg(test)]
mod tests;
