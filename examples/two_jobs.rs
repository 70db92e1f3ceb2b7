//! Two jobs at once in one program, one of them abandoned: `cargo run --release --example two_jobs`.
//!
//! Shows how soon the abandoned job answers, that the other makes the bytes that it makes alone, and that neither is
//! billed for the other's CPU time.

use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use facetmill::job::clock::{Spent, on_own_threads};
use facetmill::job::design::DesignError;
use facetmill::job::{Job, Outcome};
use facetmill::memory::MemoryLimit;
use facetmill::picture::{Picture, read};
use facetmill::progress::{CancelToken, Event, Progress};
use facetmill::recipe::Recipe;

/// One job on one thread of its own.
fn work(
    recipe: &Recipe,
    picture: &Picture,
    cancel: &CancelToken,
) -> Result<(Outcome, Spent), Box<dyn Error + Send + Sync>> {
    let listen = |_: Event<'_>| {};
    let progress = Progress::new(&listen, cancel);
    let job = Job { recipe, picture, proved: true, memory: MemoryLimit::of_system(1) };
    let (outcome, spent) = on_own_threads(Some(1), || job.run(None, &mut |_, _| {}, &progress))?;
    Ok((outcome.map_err(|error: DesignError| error.to_string())?, spent))
}

/// The plate's heights and the first proof's figures: what must not depend on who else is at work.
fn essence(outcome: Outcome) -> Option<(Vec<[f32; 3]>, f64)> {
    let product = outcome.product()?;
    let tv = product.proof.as_ref().map_or(f64::NAN, |proof| proof.verdict.main().tv_incident.value);
    Some((product.design.mesh.vertices.clone(), tv))
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let path = std::env::args_os().nth(1).map_or_else(|| "examples/highlights/ring.png".into(), PathBuf::from);
    let mut recipe = Recipe::default();
    recipe.design.sheet.cutter = Some("ball:0.5".parse()?);
    recipe.plate.size = [10.0, 10.0]; // mm
    (recipe.plate.cells, recipe.plate.grid) = (Some(1.into()), Some(128));
    recipe.verify.rays = 200_000;
    let picture = read(&path, &recipe.reading())?;

    let (alone, spent_alone) = work(&recipe, &picture, &CancelToken::default())?;
    println!(
        "alone:     {:6.2} s of CPU, {:6.2} s in all",
        spent_alone.cpu.as_secs_f64(),
        spent_alone.wall.as_secs_f64()
    );

    // A larger one beside it is abandoned on its way.
    let mut large = recipe.clone();
    large.plate.grid = Some(512);
    let token = CancelToken::default();
    let (beside, abandoned, answer) = std::thread::scope(|scope| {
        let other = scope.spawn(|| {
            let done = work(&large, &picture, &token);
            (done, Instant::now())
        });
        let killer = scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(1500));
            token.abandon();
            Instant::now()
        });
        let beside = work(&recipe, &picture, &CancelToken::default());
        let told = killer.join().map_err(|_| "the thread that abandons a job died")?;
        let (abandoned, ended) = other.join().map_err(|_| "the thread of a job died")?;
        Ok::<_, Box<dyn Error + Send + Sync>>((beside?, abandoned?, ended.saturating_duration_since(told)))
    })?;
    let (outcome, spent) = abandoned;
    let ended = if matches!(outcome, Outcome::Abandoned) { "abandoned" } else { "done before it was abandoned" };
    let answer = 1000.0 * answer.as_secs_f64();
    println!("beside it: {:6.2} s of CPU, {ended}; it answered after {answer:.0} ms", spent.cpu.as_secs_f64());
    let (outcome, spent) = beside;
    println!("the first: {:6.2} s of CPU, {:6.2} s in all", spent.cpu.as_secs_f64(), spent.wall.as_secs_f64());
    let same = essence(alone).is_some_and(|alone| essence(outcome) == Some(alone));
    println!("the same plate and the same figures as alone: {}", if same { "yes" } else { "no" });
    if same { Ok(()) } else { Err("a job depends on its neighbour".into()) }
}
