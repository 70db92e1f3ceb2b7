//! How long a job goes without asking whether it is to end: `cargo run --release --example answers [-- ROW [LIMIT]]`.
//!
//! Runs jobs on one thread each and takes that thread's CPU time from question to question. A wish to finish or to
//! abandon is obeyed at the next question, so that the longest gap is the longest that a caller waits. ROW is one of the
//! names below; with LIMIT, in ms, the program fails if a gap is longer.

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use cpu_time::ThreadTime;
use facetmill::job::Job;
use facetmill::job::clock::on_own_threads;
use facetmill::memory::MemoryLimit;
use facetmill::picture::read;
use facetmill::progress::{CancelToken, Cancelled, Event, Progress, Stage};
use facetmill::recipe::Recipe;

/// Name, allowed gap in ms, and what is unlike the default recipe.
type Row = (&'static str, f64, fn(&mut Recipe));

const ROWS: [Row; 5] = [
    ("default", 100.0, |_| {}),
    ("ball", 100.0, ball),
    ("nodes", 500.0, |recipe| {
        ball(recipe);
        (recipe.plate.grid, recipe.plate.cells) = (Some(1024), Some(1.into()));
    }),
    ("facets", 100.0, |recipe| recipe.plate.facets = Some([30, 30])),
    ("million", 500.0, |recipe| recipe.plate.facets = Some([1000, 1000])),
];

fn ball(recipe: &mut Recipe) {
    recipe.design.sheet.cutter = "ball:0.5".parse().ok();
}

/// Gaps between questions, by the stage in which they fell.
#[derive(Default)]
struct Gaps {
    stage: Option<Stage>,
    last: Duration,
    longest: BTreeMap<&'static str, Duration>,
    questions: u64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let only = arguments.next();
    let limit: Option<f64> = arguments.next().map(|ms| ms.parse()).transpose()?;
    let mut late = Vec::new();
    for (name, allowed, change) in ROWS {
        if only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        let mut recipe = Recipe::default();
        change(&mut recipe);
        let gaps = watched(&recipe)?;
        println!("{name}: {} questions; longest gaps, ms of CPU", gaps.questions);
        for (stage, gap) in &gaps.longest {
            let ms = 1000.0 * gap.as_secs_f64();
            let mark = if ms > allowed { "  longer than it should be" } else { "" };
            println!("  {stage:14} {ms:8.1}{mark}");
            if ms > limit.unwrap_or(f64::INFINITY) {
                late.push(format!("{name}: {stage} takes {ms:.0} ms"));
            }
        }
    }
    if late.is_empty() { Ok(()) } else { Err(late.join("; ").into()) }
}

/// A whole job of `recipe`, files included, and the gaps in it.
fn watched(recipe: &Recipe) -> Result<Gaps, Box<dyn Error>> {
    let picture = read("examples/highlights/portrait.png".as_ref(), &recipe.reading())?;
    let gaps = Arc::new(Mutex::new(Gaps::default()));
    let asked = gaps.clone();
    let token = CancelToken::watched(move || note(&asked, None));
    let listen = |event: Event<'_>| {
        if let Event::Stage(stage, _) = event {
            note(&gaps, Some(stage));
        }
    };
    let progress = Progress::new(&listen, &token);
    let job = Job { recipe, picture: &picture, proved: true, memory: MemoryLimit::of_system(1) };
    let (done, _) = on_own_threads(Some(1), || {
        gaps.lock().unwrap_or_else(PoisonError::into_inner).last = ThreadTime::now().as_duration();
        let outcome = job.run(None, &mut |_, _| {}, &progress).map_err(|error| error.to_string())?;
        let product = outcome.product().ok_or("nobody abandoned it")?;
        let written = product.write(&picture, &mut |_, content| Ok(content(&mut std::io::sink())?), &progress);
        written.map_err(|error: WriteError| error.to_string())
    })?;
    done?;
    // The rest after the last question.
    note(&gaps, None);
    let gaps = std::mem::take(&mut *gaps.lock().unwrap_or_else(PoisonError::into_inner));
    Ok(gaps)
}

/// Notes the time since the last question, and that a stage begins if one does.
fn note(gaps: &Mutex<Gaps>, begins: Option<Stage>) {
    let now = ThreadTime::now().as_duration();
    let mut gaps = gaps.lock().unwrap_or_else(PoisonError::into_inner);
    let name = gaps.stage.map_or("before any", Stage::id);
    match begins {
        // No question by itself: the gap goes on, and counts for the stage in which it ends.
        Some(stage) => gaps.stage = Some(stage),
        None => {
            let gap = now.saturating_sub(gaps.last);
            let longest = gaps.longest.entry(name).or_default();
            *longest = gap.max(*longest);
            gaps.last = now;
            gaps.questions += 1;
        }
    }
}

/// What can go wrong when files are made.
#[derive(Debug)]
enum WriteError {
    Cancelled(Cancelled),
    File(std::io::Error),
}

impl std::fmt::Display for WriteError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Cancelled(error) => error.fmt(out),
            Self::File(error) => error.fmt(out),
        }
    }
}

impl From<Cancelled> for WriteError {
    fn from(error: Cancelled) -> Self {
        Self::Cancelled(error)
    }
}

impl From<std::io::Error> for WriteError {
    fn from(error: std::io::Error) -> Self {
        Self::File(error)
    }
}
