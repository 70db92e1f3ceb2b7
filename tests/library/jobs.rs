//! Jobs side by side, and jobs that are ended from outside.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use facetmill::job::clock::{Spent, on_own_threads};
use facetmill::job::plan::{Goal, Task};
use facetmill::job::{Content, Job, Outcome, Product};
use facetmill::memory::MemoryLimit;
use facetmill::milling::machine::Machine;
use facetmill::picture::{Picture, Reading, from_raster};
use facetmill::progress::{CancelToken, Cancelled, Event, Progress, Stage};
use facetmill::projection::View;
use facetmill::raster::Raster;
use facetmill::recipe::{Recipe, SurfaceKind};
use facetmill::relief::recognise::recognise;
use facetmill::trace::grid::GridSurface;
use facetmill::trace::traced_plate::{TracedPlate, TracedPlateError};
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::measure::measure;
use facetmill::verify::tally::MeasureError;
use facetmill::verify::verdict::Verdict;
use facetmill::verify::wasserstein::exact_w1;

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
    heard(recipe, cancel, |_| {})
}

/// The same with somebody who listens.
fn heard(recipe: &Recipe, cancel: &CancelToken, listen: impl Fn(Event<'_>) + Sync) -> (Outcome, Spent) {
    let picture = ring();
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
    let alone = essence(done(&recipe, &CancelToken::default()).0.product().unwrap());
    let token = CancelToken::default();
    let (beside, other) = std::thread::scope(|scope| {
        let other = scope.spawn(|| done(&small(256), &token));
        let beside = done(&recipe, &CancelToken::default());
        token.abandon();
        (beside, other.join().unwrap())
    });
    assert!(matches!(other.0, Outcome::Abandoned));
    assert!(essence(beside.0.product().unwrap()) == alone);
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

#[test]
fn every_stage_asks_many_times() {
    // Questions and the stage in which they are asked; how many they are depends on the work alone, not on the machine.
    let asked = Arc::new(Mutex::new((Stage::Distribution, BTreeMap::<&str, u64>::new())));
    let (count, stage) = (asked.clone(), asked.clone());
    let token = CancelToken::watched(move || {
        let (stage, asked) = &mut *count.lock().unwrap();
        *asked.entry(stage.id()).or_default() += 1;
    });
    let listen = |event: Event<'_>| {
        if let Event::Stage(begins, _) = event {
            stage.lock().unwrap().0 = begins;
        }
    };
    let product = heard(&small(32), &token, listen).0.product().unwrap();
    let progress = Progress::new(&listen, &token);
    let mut into_nothing = |_: &str, content: Content| -> Result<(), Cancelled> {
        content(&mut std::io::sink()).unwrap();
        Ok(())
    };
    product.write(&ring(), &mut into_nothing, &progress).unwrap();
    let asked = std::mem::take(&mut asked.lock().unwrap().1);
    // A row of the sheet, of the tool's places, of a picture each ask; an evaluation asks four times.
    for (stage, least) in [
        ("sculpting", 1000),
        ("solid", 60),
        ("tracing", 60),
        ("scoring", 500),
        ("milling", 1000),
        ("comparison", 1000),
        ("files", 1000),
    ] {
        assert!(asked.get(stage).is_some_and(|asked| *asked >= least), "{stage}: {asked:?}");
    }
}

#[test]
fn facets_chosen_instead_of_a_sheet_report_on_themselves() {
    // Told to finish at once, a sheet is the first one tried, and facets are better.
    let mut recipe = small(32);
    recipe.design.sheet.cutter = None;
    // What only a sheet has would ask for a sheet.
    (recipe.plate.cells, recipe.plate.grid) = (None, None);
    let (token, _) = ending_at(1, CancelToken::finish);
    let stages = Mutex::new(Vec::new());
    let outcome = heard(&recipe, &token, |event| {
        if let Event::Stage(stage, _) = event {
            stages.lock().unwrap().push(stage);
        }
    });
    let product = outcome.0.product().unwrap();
    assert!(product.design.facets.is_some() && product.design.ended_early);
    let stages = stages.into_inner().unwrap();
    let chosen = stages.iter().position(|stage| *stage == Stage::Facets).unwrap();
    let after =
        [Stage::Distribution, Stage::Sampling, Stage::Arrangement, Stage::Heights, Stage::Solid, Stage::Tracing];
    assert_eq!(stages[chosen + 1..][..after.len()], after);
    let before = &stages[..chosen];
    assert!(
        before.ends_with(&[Stage::Comparison]) && !before.contains(&Stage::Sampling),
        "the comparison's own are not told"
    );
}

#[test]
fn facets_told_to_finish_before_they_are_grouped_need_no_grouping() {
    let mut recipe = small(32);
    recipe.plate.surface = Some(SurfaceKind::Facets);
    (recipe.plate.cells, recipe.plate.grid, recipe.plate.facets) = (None, None, Some([40, 40]));
    recipe.design.sheet.cutter = None;
    let (token, asked) = ending_at(1, CancelToken::finish);
    let picture = ring();
    let listen = |_: Event<'_>| {};
    let progress = Progress::new(&listen, &token);
    let plate = facetmill::job::design::design(&recipe, &picture.light, &progress).unwrap();
    assert!(plate.ended_early);
    // Grouping 1600 facets asks as often; closing the solid asks once a row.
    let asked = asked.load(Ordering::Relaxed);
    assert!(asked < 200, "{asked}");
    // Still every facet has a slope of the ring's.
    let slopes = &plate.facets.unwrap().grid.slopes;
    let lit = |slope: &facetmill::slope::Slope| {
        (0.3..0.9).contains(&(2.0 * slope.tilt().to_degrees() / recipe.highlight.half_field.reach()))
    };
    assert!(slopes.len() == 1600 && slopes.iter().filter(|slope| lit(slope)).count() > 1550);
}

#[test]
fn what_is_cancelled_says_so_and_what_is_dark_says_that() {
    let mut recipe = small(32);
    recipe.plate.surface = Some(SurfaceKind::Facets);
    (recipe.plate.cells, recipe.plate.grid, recipe.plate.facets) = (None, None, Some([8, 8]));
    recipe.design.sheet.cutter = None;
    let silent = Progress::silent();
    let plate = facetmill::job::design::design(&recipe, &ring().light, &silent).unwrap();
    let (token, listen) = (CancelToken::default(), |_: Event<'_>| {});
    token.abandon();
    let abandoned = Progress::new(&listen, &token);
    assert_eq!(recognise(&plate.mesh, &abandoned), Err(Cancelled));
    assert_eq!(TracedPlate::new(&plate.mesh, 0.0, &abandoned).err(), Some(TracedPlateError::Cancelled(Cancelled)));
    assert_eq!(GridSurface::new(&plate.relief, &abandoned).err(), Some(Cancelled));
    let (surface, setup) = (GridSurface::new(&plate.relief, &silent).unwrap(), recipe.setup());
    let measuring = Measuring { rays: 10_000, resolution: 64, ..Measuring::default() };
    let seen = |progress: &Progress| measure(&Experiment::new(&surface, &setup), &measuring, progress);
    let cancelled = MeasureError::Cancelled(Cancelled);
    assert_eq!(seen(&abandoned), Err(cancelled));
    let (image, dark, view) = (seen(&silent).unwrap(), Raster::zeros(64, 64), setup.view());
    let target = image.whole.share_image();
    let judged = |target: &Raster, progress: &Progress| Verdict::new(&image, target, view, progress);
    assert_eq!(judged(&target, &abandoned), Err(cancelled));
    assert_eq!(judged(&dark, &silent), Err(MeasureError::NoLight));
    let elsewhere = Raster::from_fn(64, 64, |x, y| (x * y) as f64);
    assert_eq!(exact_w1(&target, &elsewhere, view, 16, &abandoned), Err(cancelled));
    assert_eq!(exact_w1(&target, &dark, view, 16, &silent), Err(MeasureError::NoLight));
    assert!(judged(&target, &silent).is_ok() && exact_w1(&target, &elsewhere, view, 16, &silent).is_ok());
}

/// Of the three numbers of cells that there are, one is designed when the wish to finish comes.
#[test]
fn a_plan_told_to_finish_ends_with_the_ways_that_are_proved() {
    let mut recipe = small(32);
    (recipe.plate.cells, recipe.plate.grid, recipe.plate.max_triangles) = (None, None, Some(6000));
    let (picture, machine, cancel) = (ring(), Machine::preset("vmc").unwrap(), CancelToken::default());
    let task = Task {
        recipe: &recipe,
        any_size: false,
        picture: &picture,
        machine: &machine,
        goal: Goal::Within(0.05),
        tolerance: 0.0,
        memory: MemoryLimit::NONE,
    };
    let (hears, heard) = (|_: Event<'_>| {}, AtomicU64::new(0));
    let enough = |_: &_| {
        heard.fetch_add(1, Ordering::Relaxed);
        cancel.finish();
    };
    let plan = task.plan(enough, &Progress::new(&hears, &cancel)).unwrap();
    assert!(plan.ended_early && plan.best.len() == 1 && heard.load(Ordering::Relaxed) == 1, "{:?}", plan.best);
    cancel.abandon();
    let abandoned = task.plan(|_| {}, &Progress::new(&hears, &cancel)).unwrap_err();
    assert_eq!(abandoned.to_string(), "abandoned as asked");
}
