//! One track of the cutter: from where its tip should be to where a machine puts it.
//!
//! A program has straight segments with rounded ends; a drive follows them in whole steps and rounds corners; a slide with
//! play lags where it turns; each track is a little too high or too low; and a cutter whose teeth cut one after another
//! leaves the shape of its tip only where each of them passes.

use super::machine::Machine;
use super::random::{normal, stream};

/// How far a segment of a program may lie from the cutter's way, mm: a fiftieth of what a good machine's tracks differ by.
const CHORD: f64 = 5e-5;

/// A drive that rounds its way by less than this, in samples, is taken to follow each of its steps: nothing is smoothed.
const LEAST_SMOOTHING: f64 = 0.5;

/// One that rounds it more is looked at in so many parts of a sample. Looked at once a sample, steps of a way whose slope
/// keeps step with the samples all count half a sample early, or late: by up to 0.15 µm, where parts leave 0.02.
const PARTS: usize = 8;

/// Heights of the tip along a straight track, evenly spaced.
pub(super) struct Way {
    /// Place of the first along the track, mm.
    pub(super) from: f64,
    /// From one to the next, mm.
    pub(super) step: f64,
    /// Heights, mm.
    pub(super) heights: Vec<f64>,
}

/// Which track it is.
#[derive(Clone, Copy)]
pub(super) struct Which {
    /// Its number.
    pub(super) index: u64,
    /// Whether it is cut against the direction in which places count.
    pub(super) backward: bool,
}

/// Where the samples of a cut track lie: `count` of them from `from` mm, `step` mm apart, every `tooth`-th of them a cut.
#[derive(Clone, Copy)]
pub(super) struct Samples {
    pub(super) from: f64,
    pub(super) step: f64,
    pub(super) count: usize,
    pub(super) tooth: usize,
}

impl Way {
    /// The ends of a program's segments, (place, height) in mm, as it is written: on a chord as long as allowed, in as many
    /// decimals as the machine's programs have, and beyond its play as far as they make up for that.
    pub(super) fn programmed(&self, machine: &Machine, backward: bool) -> Vec<[f64; 2]> {
        let last = self.heights.len() - 1;
        let steps = |length: f64| length / self.step;
        // A share of a step that rounding adds is none.
        let shortest = ((steps(machine.shortest_segment()) - 1e-9).ceil() as usize).max(1);
        let longest = (steps(machine.segment).round() as usize).max(shortest);
        let quantum = machine.quantum();
        let point = |k: usize| {
            let place = whole(self.from + self.step * k as f64, quantum);
            [place, whole(self.height(place), quantum)]
        };
        let mut ends = vec![point(0)];
        let mut at = 0;
        while at < last {
            at = self.chord_end(at, shortest, longest).min(last);
            ends.push(point(at));
        }
        if machine.compensation_z == 0.0 {
            return ends;
        }
        if backward {
            ends.reverse();
        }
        let mut ends = compensated(&ends, machine);
        if backward {
            ends.reverse();
        }
        ends
    }

    /// Height at a place, mm, on the straight line between the samples beside it.
    fn height(&self, place: f64) -> f64 {
        let last = self.heights.len() - 1;
        let k = ((place - self.from) / self.step).clamp(0.0, last as f64);
        let before = (k as usize).min(last.saturating_sub(1));
        let (low, high) = (self.heights[before], self.heights[(before + 1).min(last)]);
        low + (k - before as f64) * (high - low)
    }

    /// The farthest sample to which a chord from sample `at` keeps within [`CHORD`] of those between.
    fn chord_end(&self, at: usize, shortest: usize, longest: usize) -> usize {
        let rise = |k: usize, aside: f64| (self.heights[k] + aside - self.heights[at]) / (k - at) as f64;
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut end = at + shortest;
        for k in at + 1..self.heights.len().min(at + longest + 1) {
            if (low..=high).contains(&rise(k, 0.0)) {
                end = end.max(k);
            }
            (low, high) = (low.max(rise(k, -CHORD)), high.min(rise(k, CHORD)));
            if low > high {
                break;
            }
        }
        end
    }

    /// Heights of the tip where it truly passes, mm; infinite where no tooth cuts.
    pub(super) fn cut(&self, machine: &Machine, seed: u64, which: Which, samples: Samples) -> Vec<f32> {
        let mut heights = followed(&self.programmed(machine, which.backward), machine, which, samples);
        if which.backward {
            heights.reverse();
        }
        lag(&mut heights, machine.backlash_z);
        if which.backward {
            heights.reverse();
        }
        let mut random = stream(seed, which.index);
        let offset = machine.track_scatter * normal(&mut random);
        // Teeth keep no step with the tracks.
        let first = (rand::RngExt::random::<f64>(&mut random) * samples.tooth as f64) as usize % samples.tooth;
        let mut cuts = vec![f32::INFINITY; samples.count];
        for k in (first..samples.count).step_by(samples.tooth) {
            cuts[k] = (heights[k] + offset + machine.tooth_scatter * normal(&mut random)) as f32;
        }
        cuts
    }
}

/// The same way with half of the play above it where it rises and below it where it falls, so that a slide with that play
/// goes where it should; a way begins after a plunge, falling. At a turn the slide stands while the program goes from one flank
/// to the other, straight up or down.
fn compensated(ends: &[[f64; 2]], machine: &Machine) -> Vec<[f64; 2]> {
    let (half, quantum) = (0.5 * machine.compensation_z, machine.quantum());
    let mut made = Vec::with_capacity(ends.len() + ends.len() / 8);
    let (mut side, mut turn) = (-half, ends[0][1]);
    let at = |[x, z]: [f64; 2], side: f64| [x, whole(z + side, quantum)];
    made.push(at(ends[0], side));
    for pair in ends.windows(2) {
        let ([x0, z0], [x1, z1]) = (pair[0], pair[1]);
        // A turn by less than the last decimal is none.
        turn = if side > 0.0 { f64::max(turn, z0) } else { f64::min(turn, z0) };
        if (z1 - turn) * side < -1.5 * quantum * half {
            (side, turn) = (-side, z1);
            made.push(at([x0, z0], side));
        }
        made.push(at([x1, z1], side));
    }
    made
}

/// The nearest multiple of `step`, if that is any length.
pub(super) fn whole(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

/// The segments of a program, their ends in whole steps, as drives follow them.
fn followed(ends: &[[f64; 2]], machine: &Machine, which: Which, samples: Samples) -> Vec<f64> {
    let Samples { from, step, count, .. } = samples;
    // On the way back the slide is behind by its play.
    let behind = if which.backward { machine.backlash_xy } else { 0.0 };
    let sigma = machine.smoothing / step;
    let parts = if sigma >= LEAST_SMOOTHING && machine.step > 0.0 { PARTS } else { 1 };
    let end = |k: usize| ends[k.min(ends.len() - 1)].map(|place| whole(place, machine.step));
    let (mut segment, mut pair) = (1, [end(0), end(1)]);
    let mut height = |x: f64| {
        while segment + 1 < ends.len() && pair[1][0] < x {
            segment += 1;
            pair = [pair[1], end(segment)];
        }
        let [[x0, z0], [x1, z1]] = pair;
        let share = if x1 > x0 { ((x - x0) / (x1 - x0)).clamp(0.0, 1.0) } else { 0.0 };
        whole(z0 + share * (z1 - z0), machine.step)
    };
    let first = 0.5 / parts as f64 - 0.5;
    let mean = |k: usize| {
        let place = |part: usize| from + step * (k as f64 + first + part as f64 / parts as f64) + behind;
        (0..parts).map(|part| height(place(part))).sum::<f64>() / parts as f64
    };
    let heights: Vec<f64> = (0..count).map(mean).collect();
    if sigma < LEAST_SMOOTHING {
        return heights;
    }
    // Means over a sample are smoothed already, as far as the variance of its parts goes.
    let done = (1.0 - (parts as f64).powi(-2)) / 12.0;
    smoothed(&heights, (sigma * sigma - done).max(0.0).sqrt())
}

/// Smoothed by a Gaussian whose standard deviation is `sigma` samples; the ends stay where they are.
fn smoothed(heights: &[f64], sigma: f64) -> Vec<f64> {
    let taps = super::polish::taps(sigma);
    let last = heights.len() as isize - 1;
    let at = |k: isize| heights[k.clamp(0, last) as usize];
    (0..=last)
        .map(|k| {
            let beside = |(j, tap): (usize, &f64)| tap * (at(k - j as isize) + at(k + j as isize));
            taps[0] * at(k) + taps.iter().enumerate().skip(1).map(beside).sum::<f64>()
        })
        .collect()
}

/// A slide with `play` mm between its flanks, pushed along `heights` after it came down to them: it stays where it is until
/// a flank takes it along.
fn lag(heights: &mut [f64], play: f64) {
    let Some(mut at) = heights.first().map(|z| z + 0.5 * play) else { return };
    for z in heights {
        at = at.clamp(*z - 0.5 * play, *z + 0.5 * play);
        *z = at;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORWARD: Which = Which { index: 0, backward: false };

    fn way(height: impl Fn(f64) -> f64) -> Way {
        Way { from: -0.2, step: 0.01, heights: (0..240).map(|k| height(-0.2 + 0.01 * f64::from(k))).collect() }
    }

    fn samples(tooth: usize) -> Samples {
        Samples { from: 0.0, step: 0.005, count: 400, tooth }
    }

    #[test]
    fn segments_are_as_long_as_the_chord_allows_and_no_shorter_than_a_control_takes() {
        // A parabola of radius 1 mm: chords of 40 µm lie 0.2 µm off, of 20 µm 0.05 µm off, too short for a control.
        let round = way(|x| 0.5 * x * x);
        let ends = round.programmed(&Machine { decimals: 9, ..Machine::ideal() }, false);
        assert!(ends.windows(2).rev().skip(1).all(|pair| pair[1][0] - pair[0][0] > 0.0249), "{ends:?}");
        // Radius 100 mm: the chord allows 0.2 mm, a segment may have 0.1.
        let flat = way(|x| 0.005 * x * x).programmed(&Machine { decimals: 9, ..Machine::ideal() }, false);
        assert!(flat.windows(2).take(20).all(|pair| (pair[1][0] - pair[0][0] - 0.1).abs() < 1e-9), "{flat:?}");
        for pair in flat.windows(2) {
            let middle = 0.5 * (pair[0][0] + pair[1][0]);
            let off = 0.5 * (pair[0][1] + pair[1][1]) - 0.005 * middle * middle;
            assert!(off.abs() <= CHORD, "{off}");
        }
    }

    #[test]
    fn a_machine_without_faults_is_where_it_should_be() {
        let slanted = way(|x| 0.1 + 0.2 * x);
        let cut = slanted.cut(&Machine { decimals: 9, ..Machine::ideal() }, 1, FORWARD, samples(1));
        for (k, z) in cut.iter().enumerate() {
            assert!((f64::from(*z) - 0.1 - 0.2 * 0.005 * k as f64).abs() < 1e-7);
        }
    }

    #[test]
    fn heights_come_in_whole_steps_and_slides_lag_where_they_turn() {
        let slanted = way(|x| 0.1 + 0.2 * x);
        let stepping = Machine { step: 0.00125, ..Machine::ideal() };
        let cut = slanted.cut(&stepping, 1, FORWARD, samples(1));
        assert!(cut.iter().all(|z| (z / 0.00125 - (z / 0.00125).round()).abs() < 1e-3));
        // Up and down again: below while it rises, above while it falls.
        let hill = way(|x| 0.1 * (1.0 - (x - 1.0).abs()));
        let loose = Machine { backlash_z: 0.01, decimals: 9, ..Machine::ideal() };
        let cut = hill.cut(&loose, 1, FORWARD, samples(1));
        let off = |k: usize, x: f64| f64::from(cut[k]) - 0.1 * (1.0 - (x - 1.0).abs());
        assert!((off(100, 0.5) + 0.005).abs() < 1e-6 && (off(300, 1.5) - 0.005).abs() < 1e-6);
        let back = hill.cut(&loose, 1, Which { index: 0, backward: true }, samples(1));
        assert!((f64::from(back[100]) - 0.1 * 0.5 - 0.005).abs() < 1e-6);
        // A program that makes up for it leaves next to nothing of it, whichever way it goes.
        let known = Machine { compensation_z: 0.01, ..loose };
        for backward in [false, true] {
            let cut = hill.cut(&known, 1, Which { index: 0, backward }, samples(1));
            let off = |k: usize| f64::from(cut[k]) - 0.1 * (1.0 - (0.005 * k as f64 - 1.0).abs());
            // The samples begin within the way, as if after a plunge: the play is taken up by then.
            let most = (100..300).map(|k| off(k).abs()).fold(0.0, f64::max);
            // A segment over the ridge, 30 µm long, leaves half a micrometre of it by itself.
            assert!(most < 0.6e-3 && off(120).abs() < 1e-6 && off(290).abs() < 1e-6, "{most}");
        }
    }

    #[test]
    fn steps_of_a_way_that_keeps_step_with_the_samples_are_as_high_as_it_on_the_mean() {
        // A step every two samples: where a sample meets the middle between two steps, all of them count half a sample early.
        let machine = Machine { step: 0.000_625, smoothing: 0.02, decimals: 9, ..Machine::ideal() };
        let cut = way(|x| 0.1 + 0.0625 * x).cut(&machine, 1, FORWARD, samples(1));
        let off = |k: usize| f64::from(cut[k]) - (0.1 + 0.0625 * 0.005 * k as f64);
        let most = (50..350).map(|k| off(k).abs()).fold(0.0, f64::max);
        assert!(most < 2e-5, "{most}");
    }

    #[test]
    fn teeth_cut_at_their_distance_each_with_its_own_error() {
        let level = way(|_| 0.25);
        let machine = Machine { tooth_scatter: 0.001, track_scatter: 0.002, ..Machine::ideal() };
        let offsets: Vec<f64> = (0..400)
            .map(|index| {
                let cut = level.cut(&machine, 3, Which { index, backward: false }, samples(4));
                let cuts: Vec<f64> = cut.iter().filter(|z| z.is_finite()).map(|z| f64::from(*z) - 0.25).collect();
                assert_eq!(cuts.len(), 100);
                let mean = cuts.iter().sum::<f64>() / 100.0;
                let spread = (cuts.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / 99.0).sqrt();
                // 0.001 within five standard errors of a hundred.
                assert!((spread - 0.001).abs() < 5.0 * 0.001 / 198f64.sqrt(), "{spread}");
                mean
            })
            .collect();
        let spread = (offsets.iter().map(|z| z * z).sum::<f64>() / 400.0).sqrt();
        assert!((spread - 0.002).abs() < 4.0 * 0.002 / 800f64.sqrt(), "{spread}");
    }

    #[test]
    fn a_drive_rounds_a_corner_by_its_width() {
        let corner = way(|x| (x - 1.0).max(0.0));
        let soft = Machine { smoothing: 0.05, decimals: 9, ..Machine::ideal() };
        let cut = corner.cut(&soft, 1, FORWARD, samples(1));
        // At the corner a Gaussian of width s leaves s/√2π.
        let expected = 0.05 / std::f64::consts::TAU.sqrt();
        assert!((f64::from(cut[200]) - expected).abs() < 0.01 * expected, "{}", cut[200]);
    }
}
