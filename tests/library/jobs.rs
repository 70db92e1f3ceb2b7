//! Jobs side by side, and jobs that are ended from outside.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use facetmill::job::clock::{Spent, on_own_threads};
use facetmill::job::{Job, Outcome, Product};
use facetmill::memory::MemoryLimit;
use facetmill::picture::{Picture, Reading, from_raster};
use facetmill::progress::{CancelToken, Event, Progress};
use facetmill::projection::View;
use facetmill::raster::Raster;
use facetmill::recipe::Recipe;

fn ring() -> Picture {
    let light = Raster::from_fn(64, 64, |column, row| {
        let uv = View::pixel_centre(column, row, 64, 64);
        f64::from(u8::from((0.5..0.8).contains(&uv.length())))
    });
    from_raster(light, &Reading::default()).unwrap()
}

/// A sheet of one small cell for a ball, proved.
fn small(grid: usize) -> Recipe {
    let mut recipe = Recipe::default();
    recipe.plate.size = [6.0, 6.0];
    (recipe.plate.cells, recipe.plate.grid) = (Some(1.into()), Some(grid));
    recipe.design.sheet.cutter = "ball:0.5".parse().ok();
    recipe.plate.facets = None;
    recipe.verify.rays = 20_000;
    recipe
}

fn done(recipe: &Recipe, cancel: &CancelToken) -> (Outcome, Spent) {
    let picture = ring();
    let listen = |_: Event<'_>| {};
    let progress = Progress::new(&listen, cancel);
    let job = Job { recipe, picture: &picture, proved: true, memory: MemoryLimit::NONE };
    let (outcome, spent) = on_own_threads(Some(1), || job.run(None, &mut |_, _| {}, &progress)).unwrap();
    (outcome.unwrap(), spent)
}

/// The mesh and the figures of the proof.
fn essence(product: Product) -> (Vec<[f32; 3]>, String) {
    let verdict = format!("{:?}", product.proof.unwrap().verdict);
    (product.design.mesh.vertices, verdict)
}

/// A token that does `what` to itself at question number `at`, and how often it was asked.
fn ending_at(at: u64, what: fn(&CancelToken)) -> (CancelToken, Arc<AtomicU64>) {
    let (asked, own) = (Arc::new(AtomicU64::new(0)), Arc::new(OnceLock::<CancelToken>::new()));
    let (count, itself) = (asked.clone(), own.clone());
    let token = CancelToken::watched(move || {
        if count.fetch_add(1, Ordering::Relaxed) + 1 == at
            && let Some(token) = itself.get()
        {
            what(token);
        }
    });
    let _ = own.set(token.clone());
    (token, asked)
}

#[test]
fn of_two_jobs_at_once_one_is_abandoned_and_the_other_is_as_alone() {
    let recipe = small(32);
    let (alone, cost) = done(&recipe, &CancelToken::default());
    let alone = essence(alone.product().unwrap());
    let token = CancelToken::default();
    let (beside, other) = std::thread::scope(|scope| {
        let other = scope.spawn(|| done(&small(256), &token));
        let beside = done(&recipe, &CancelToken::default());
        token.abandon();
        (beside, other.join().unwrap())
    });
    assert!(matches!(other.0, Outcome::Abandoned));
    assert!(essence(beside.0.product().unwrap()) == alone);
    // Both worked all the time; with both bills on one it would be twice as much.
    assert!(beside.1.cpu < cost.cpu.mul_f64(1.6), "{:?} beside another, {:?} alone", beside.1, cost);
}

#[test]
fn a_job_abandoned_at_any_question_ends_abandoned() {
    let recipe = small(32);
    let (token, asked) = ending_at(u64::MAX, CancelToken::abandon);
    assert!(matches!(done(&recipe, &token).0, Outcome::Finished(_)));
    let all = asked.load(Ordering::Relaxed);
    assert!(all > 200, "{all}");
    for k in 0..12 {
        let at = 1 + k * (all - 1) / 12;
        let (token, asked) = ending_at(at, CancelToken::abandon);
        let (outcome, _) = done(&recipe, &token);
        let more = asked.load(Ordering::Relaxed) - at;
        assert!(matches!(outcome, Outcome::Abandoned), "at {at} of {all}");
        // Loops may each ask once more on the way out.
        assert!(more < all / 2 + 100, "{more} questions after {at} of {all}");
    }
}

#[test]
fn a_job_told_to_finish_ends_with_a_proved_plate() {
    let recipe = small(32);
    let mut early = 0;
    for at in [1, 2, 10, 40, 100_000_000] {
        let (token, _) = ending_at(at, CancelToken::finish);
        let outcome = done(&recipe, &token).0;
        early += u32::from(matches!(outcome, Outcome::FinishedEarly(_)));
        let product = outcome.product().unwrap();
        assert!(product.proof.is_some() && !product.design.mesh.triangles.is_empty());
    }
    assert_eq!(early, 4);
}
