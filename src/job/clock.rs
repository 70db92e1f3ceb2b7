//! What a job costs, measured on its own threads: two jobs in one process do not bill each other.

use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::progress::Stage;

/// Time that work took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// From beginning to end.
    pub wall: Duration,
    /// Of all its threads together.
    pub cpu: Duration,
    /// Threads that it had.
    pub threads: usize,
}

/// Stack of a worker, bytes: as much as a program's first thread has on most systems.
const STACK: usize = 8 << 20;

/// The most threads that work is given, whatever is asked: more than any machine that this was tried on has cores.
pub const MOST_THREADS: usize = 1024;

/// Threads that work is given: as many as asked, else as `RAYON_NUM_THREADS` says, else one a core; from 1 to
/// [`MOST_THREADS`].
pub fn wanted_threads(asked: Option<usize>) -> usize {
    let said = std::env::var("RAYON_NUM_THREADS").ok();
    within_reason(asked, said.as_deref(), || std::thread::available_parallelism().map_or(1, usize::from))
}

/// The same, by what the environment says and what the machine has.
fn within_reason(asked: Option<usize>, said: Option<&str>, cores: impl Fn() -> usize) -> usize {
    // A number beyond all counting is as good as none, and 0 has always meant one a core.
    let said = || said?.trim().parse().ok().filter(|n| *n > 0);
    asked.filter(|n| *n > 0).or_else(said).unwrap_or_else(cores).clamp(1, MOST_THREADS)
}

/// Does `work` on threads of its own, [as many as wanted](wanted_threads), which end with it; and says what it cost.
///
/// Where the system does not let so many start, work is done on half of them, and so on; results do not depend on it.
///
/// # Errors
/// Not even one can be had.
pub fn on_own_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<(T, Spent), ThreadPoolBuildError> {
    let begun = Instant::now();
    let pool = pool(wanted_threads(threads))?;
    let done = pool.install(|| {
        let from = cpu();
        let done = work();
        (done, cpu().saturating_sub(from))
    });
    Ok((done.0, Spent { wall: begun.elapsed(), cpu: done.1, threads: pool.current_num_threads() }))
}

/// A pool of `wanted` threads, or of as many as can be started.
fn pool(wanted: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    let mut threads = wanted;
    loop {
        match ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build() {
            Err(_) if threads > 1 => threads /= 2,
            // Not one more: the thread that is here does the work.
            Err(_) => return ThreadPoolBuilder::new().num_threads(1).use_current_thread().build(),
            pool => return pool,
        }
    }
}

/// CPU time, so far, of this thread and of all workers of its pool.
fn cpu() -> Duration {
    let own = |_| ThreadTime::now().as_duration();
    let workers: Duration = rayon::broadcast(|_| own(())).into_iter().sum();
    // A worker has been counted with the others.
    if rayon::current_thread_index().is_some() { workers } else { workers + own(()) }
}

/// CPU seconds of stages in order.
pub(crate) struct Clock {
    last: Duration,
    laps: Vec<(&'static str, f64)>,
}

impl Clock {
    /// Starts now.
    pub fn start() -> Self {
        Self { last: cpu(), laps: Vec::new() }
    }

    /// Bills `stage` for the time since the last call.
    pub(crate) fn lap(&mut self, stage: Stage) {
        let now = cpu();
        self.laps.push((stage.id(), now.saturating_sub(self.last).as_secs_f64()));
        self.last = now;
    }

    /// All bills.
    pub(crate) fn into_laps(self) -> Vec<(&'static str, f64)> {
        self.laps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keeps a thread busy for `time` of its own.
    fn burn(time: Duration) {
        let from = ThreadTime::now();
        let mut x = 1u64;
        while from.elapsed() < time {
            x = std::hint::black_box(x.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 1);
        }
    }

    #[test]
    fn threads_are_as_many_as_asked_said_or_there_within_reason() {
        for (asked, said, threads) in [
            (Some(3), Some("5"), 3),
            (None, Some(" 5 "), 5),
            (None, Some("0"), 2),
            (None, Some("99999999999999999999999"), 2),
            (None, Some("-1"), 2),
            (None, Some("4000000000"), MOST_THREADS),
            (Some(usize::MAX), None, MOST_THREADS),
            (Some(0), None, 2),
            (None, None, 2),
        ] {
            assert_eq!(within_reason(asked, said, || 2), threads, "{asked:?} {said:?}");
        }
        assert_eq!(
            on_own_threads(Some(3), rayon::current_num_threads).map(|(n, spent)| (n, spent.threads)).ok(),
            Some((3, 3))
        );
    }

    #[test]
    fn jobs_side_by_side_pay_for_their_own_threads_only() {
        let [little, much] = [20, 200].map(Duration::from_millis);
        let job = |each: Duration| {
            let work = || {
                rayon::broadcast(|_| burn(each));
            };
            on_own_threads(Some(2), work).unwrap().1.cpu
        };
        let (a, b) = std::thread::scope(|scope| {
            let other = scope.spawn(|| job(much));
            (job(little), other.join().unwrap())
        });
        // Two threads each; what it takes to wake and to end them comes on top. Paying for both would be 440 ms.
        assert!(a >= 2 * little && a < much, "{a:?}");
        assert!(b >= 2 * much, "{b:?}");
    }
}
