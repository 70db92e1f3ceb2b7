//! A fence around code of others that reads hostile bytes: a panic in it becomes an error and says nothing on stderr.
//!
//! Only panics are caught. A stack that overflows or memory that runs out ends the process: what is read is checked for
//! its size and its nesting before.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;
use std::thread;

use thiserror::Error;

thread_local! {
    /// Whether this thread is within the fence.
    static FENCED: Cell<bool> = const { Cell::new(false) };
}

static HOOK: Once = Once::new();

/// What `work` returns, or [`Panicked`] if it panics. What it was changing must not be used after that.
///
/// The first call puts a panic hook before the process's own; it is silent for threads within the fence and passes on
/// everything else. A program built to abort at a panic aborts here too.
///
/// # Errors
/// `work` panics.
pub fn fenced<T>(work: impl FnOnce() -> T) -> Result<T, Panicked> {
    // A thread that is panicking already may not change hooks.
    if !thread::panicking() {
        HOOK.call_once(silence_fenced_threads);
    }
    let outer = FENCED.replace(true);
    let done = panic::catch_unwind(AssertUnwindSafe(work));
    FENCED.set(outer);
    done.map_err(|_| Panicked)
}

fn silence_fenced_threads() {
    let others = panic::take_hook();
    panic::set_hook(Box::new(move |about| {
        // A thread that is ending has no flag left; it is not within the fence.
        if !FENCED.try_with(Cell::get).unwrap_or(false) {
            others(about);
        }
    }));
}

/// The code within the fence panicked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("its decoder failed on them")]
pub struct Panicked;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_within_the_fence_is_an_error_and_one_outside_stays_a_panic() {
        assert_eq!(fenced(|| 3), Ok(3));
        assert_eq!(fenced(|| panic!("within")).map(|()| 0), Err(Panicked));
        assert!(!FENCED.get());
        assert!(panic::catch_unwind(|| fenced(|| 3).map(|_| panic!("outside, as this test asks for"))).is_err());
    }

    #[test]
    fn a_fence_within_a_fence_leaves_the_outer_one_standing() {
        let inner = fenced(|| {
            let inner = fenced(|| panic!("within"));
            (inner, FENCED.get())
        });
        assert_eq!(inner, Ok((Err::<(), _>(Panicked), true)));
        assert!(!FENCED.get());
    }

    #[test]
    fn threads_are_fenced_each_for_itself() {
        thread::scope(|scope| {
            let all: Vec<_> = (0..8).map(|k| scope.spawn(move || fenced(|| assert!(k % 2 == 0)))).collect();
            for (k, one) in all.into_iter().enumerate() {
                assert_eq!(one.join().unwrap().is_ok(), k % 2 == 0);
            }
        });
        assert!(!FENCED.get());
    }
}
