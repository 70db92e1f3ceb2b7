use std::sync::atomic::AtomicUsize;

use super::*;

/// Counts the reliefs that it is shown.
struct Watcher {
    wants: bool,
    seen: AtomicUsize,
}

impl Listener for Watcher {
    fn hear(&self, _: Event<'_>) {}

    fn wants_relief(&self) -> bool {
        self.wants
    }

    fn see(&self, _: &SheetSoFar) {
        self.seen.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn reliefs_are_made_only_for_who_wants_them_and_not_too_often() {
    let token = CancelToken::default();
    for wants in [false, true] {
        let watcher = Watcher { wants, seen: AtomicUsize::new(0) };
        let progress = Progress::new(&watcher, &token);
        let made = AtomicUsize::new(0);
        let from = Instant::now();
        for _ in 0..1000 {
            progress.offer_relief(|| {
                made.fetch_add(1, Ordering::Relaxed);
                SheetSoFar { nodes: 1, cell: DVec2::ONE, heights: vec![0.0] }
            });
        }
        let most = if wants { 1 + from.elapsed().as_millis() as usize / 150 } else { 0 };
        let (made, seen) = (made.into_inner(), watcher.seen.into_inner());
        assert!(made == seen && seen <= most && (seen > 0) == wants, "{made} {seen} {most}");
    }
}

#[test]
fn work_without_a_best_so_far_hears_only_the_stronger_wish() {
    let token = CancelToken::default();
    let listen = |_: Event<'_>| {};
    let progress = Progress::new(&listen, &token);
    let whole = progress.to_the_end();
    token.finish();
    assert!(progress.is_to_finish() && progress.hushed().is_to_finish() && !whole.is_to_finish());
    assert_eq!((progress.check(), whole.check()), (Ok(()), Ok(())));
    let tries = [progress.until_finish(), progress.hushed().until_finish()];
    assert!(tries.iter().all(|drop| drop.check() == Err(Cancelled)));
    assert_eq!(whole.until_finish().check(), Ok(()), "what is done to its end has no tries to drop");
    token.abandon();
    assert_eq!(whole.until_finish().check(), Err(Cancelled));
    assert_eq!((progress.check(), whole.check(), whole.is_to_finish()), (Err(Cancelled), Err(Cancelled), true));
}

#[test]
fn ids_of_stages_are_words_of_their_own() {
    use Stage::*;
    let all = [
        Distribution,
        Sharpening,
        Sculpting,
        Sampling,
        Arrangement,
        Heights,
        Solid,
        Reading,
        Tracing,
        Scoring,
        Milling,
        Comparison,
        Facets,
        Goniometer,
        Normals,
        Wall,
        View,
        Files,
    ];
    let ids: std::collections::HashSet<_> = all.iter().map(|stage| stage.id()).collect();
    assert_eq!(ids.len(), all.len());
}

#[test]
fn stretches_cover_all_and_end_with_the_wish_to_abandon() {
    let (token, listen) = (CancelToken::default(), |_: Event<'_>| {});
    let progress = Progress::new(&listen, &token);
    for count in [0, 1, STRETCH - 1, STRETCH, STRETCH + 1, 5 * STRETCH + 7] {
        let all: Vec<usize> = progress.stretches(count).flat_map(Result::unwrap).collect();
        assert!(all.into_iter().eq(0..count));
    }
    let mut stretches = progress.stretches(5 * STRETCH);
    assert_eq!(stretches.next(), Some(Ok(0..STRETCH)));
    token.abandon();
    assert_eq!(stretches.next(), Some(Err(Cancelled)));
}

#[test]
fn work_to_the_end_is_heard_of() {
    let (token, heard) = (CancelToken::default(), AtomicUsize::new(0));
    let listen = |_: Event<'_>| {
        heard.fetch_add(1, Ordering::Relaxed);
    };
    let progress = Progress::new(&listen, &token);
    progress.to_the_end().stage(Stage::Sampling);
    progress.to_the_end().hushed().stage(Stage::Sampling);
    progress.until_finish().stage(Stage::Sampling);
    assert_eq!(heard.into_inner(), 1);
}
