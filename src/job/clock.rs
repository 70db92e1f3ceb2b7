//! What a job costs, measured on its own threads: two jobs in one process do not bill each other.

use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use rayon::ThreadPoolBuildError;

use crate::progress::Stage;

/// Time that work took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// From beginning to end.
    pub wall: Duration,
    /// Of all its threads together.
    pub cpu: Duration,
}

/// Stack of a worker, bytes: as much as a program's first thread has on most systems.
const STACK: usize = 8 << 20;

/// Does `work` on threads of its own, `threads` or one a core, which end with it; and says what it cost.
pub fn on_own_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<(T, Spent), ThreadPoolBuildError> {
    let begun = Instant::now();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).stack_size(STACK).build()?;
    let done = pool.install(|| {
        let from = cpu();
        let done = work();
        (done, cpu().saturating_sub(from))
    });
    Ok((done.0, Spent { wall: begun.elapsed(), cpu: done.1 }))
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
    fn jobs_side_by_side_pay_for_their_own_threads_only() {
        let [little, much] = [40, 160].map(Duration::from_millis);
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
        // Two threads each; what it takes to wake and to end them comes on top.
        assert!(a >= 2 * little && a < 2 * little + Duration::from_millis(60), "{a:?}");
        assert!(b >= 2 * much && b < 2 * much + Duration::from_millis(60), "{b:?}");
    }
}
