//! How fast this machine is beside the one on which times were measured.

use std::hint::black_box;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;

/// CPU seconds of [`kernel`] on the machine on which the constants of `estimate` were measured, with nothing beside it.
const REFERENCE: f64 = 3.4e-4;

/// The longest that measuring may take.
const LONGEST: Duration = Duration::from_millis(40);

/// Runs of the kernel at the most, for 34 ms where nothing is beside it: on a machine with three times as much work as cores,
/// the fastest of twelve was sometimes half as slow again as most others.
const RUNS: usize = 100;

/// Nodes a side of the kernel's grid; with its table it takes as much of the cache as the first descents do.
const SIDE: usize = 256;

/// Bins of the kernel's table.
const BINS: usize = 1 << 14;

/// How many times as fast a thread of this machine is as one of the machine on which times were measured, by the fastest of
/// some runs of a small piece of what designs do. Takes at most 50 ms, and changes nothing else.
pub fn relative_speed() -> f64 {
    let begun = Instant::now();
    let (mut heights, mut table) = start();
    let mut fastest = f64::INFINITY;
    for _ in 0..RUNS {
        let from = ThreadTime::now();
        kernel(&mut heights, &mut table);
        fastest = fastest.min(from.elapsed().as_secs_f64());
        if begun.elapsed() > LONGEST {
            break;
        }
    }
    black_box((&heights, &table));
    // A clock too coarse for the kernel says nothing.
    if fastest > 0.0 { REFERENCE / fastest } else { 1.0 }
}

/// Heights and a table for the kernel to begin with.
fn start() -> (Vec<f32>, Vec<f32>) {
    ((0..SIDE * SIDE).map(|k| (k * 7919 % 1013) as f32 * 1e-3).collect(), vec![0.0; BINS])
}

/// Slopes of a grid of heights, their lengths, a histogram of them, and heights moved by what is read from it.
fn kernel(heights: &mut [f32], table: &mut [f32]) {
    for row in 0..SIDE - 1 {
        for column in 0..SIDE - 1 {
            let at = row * SIDE + column;
            let (x, y) = (heights[at + 1] - heights[at], heights[at + SIDE] - heights[at]);
            let length = (1.0 + x * x + y * y).sqrt();
            let bin = ((x.abs() + 61.0 * y.abs()) * 97.0 / length) as usize % BINS;
            table[bin] = 0.99 * table[bin] + 0.01 / length;
            heights[at] += 1e-4 * (table[bin] - heights[at]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // How fast it is and how much it varies hangs on what else the machine does: `cargo bench --bench design` shows both.
    #[test]
    fn a_machine_has_a_speed_and_the_kernel_does_the_same_work_each_time() {
        let speed = relative_speed();
        assert!(speed.is_finite() && speed > 0.0, "{speed}");
        let [first, second] = [(); 2].map(|()| {
            let (mut heights, mut table) = start();
            kernel(&mut heights, &mut table);
            (heights, table)
        });
        assert_eq!(first, second);
        assert!(first.0 != start().0 && first.1.iter().any(|value| *value != 0.0), "the kernel does something");
    }
}
