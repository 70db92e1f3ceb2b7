//! Changed digits: what a program without its checksum does wrong shows in its moves.

use facetmill::gcode::check::extent;
use facetmill::gcode::dialect::Dialect;
use facetmill::gcode::program::Program;
use facetmill::gcode::read::read;
use facetmill::glam::DVec2;
use facetmill::milling::swept::Swept;
use facetmill::progress::Progress;
use facetmill::shop::check::{Against, judged};
use facetmill::shop::programs::Shop;
use facetmill::shop::surface::{Wanted, strokes};
use rayon::prelude::*;

use crate::shop::{finishing, shop, wavy};

const CHANGES: usize = 1000;

/// Heights on a dense grid over the plate, mm; the stock's where nothing has passed.
fn heights(shop: &Shop, program: &Program) -> Vec<f64> {
    let swept = Swept::new(&strokes(program, shop.blank.origin_of_optical()), shop.machining.cutter.profile());
    let size = shop.blank.optical_size();
    let place = |k: usize| size * DVec2::new((k % 240) as f64 / 239.0, (k / 240) as f64 / 159.0);
    (0..240 * 160).map(|k| swept.height(place(k)).unwrap_or(0.0)).collect()
}

/// The lowest that any rapid goes sideways, mm.
fn lowest_rapid(program: &Program) -> f64 {
    let sideways =
        program.moves().filter(|one| !one.cuts() && one.is_known() && one.from.truncate() != one.motion.to.truncate());
    sideways.map(|one| one.from.z.min(one.motion.to.z)).fold(f64::INFINITY, f64::min)
}

#[test]
fn of_a_thousand_changed_digits_that_do_harm_at_least_990_are_caught_without_the_checksum() {
    let (mesh, progress) = (wavy(), Progress::silent());
    let shop = shop(&mesh, 0.0, Dialect::Grbl);
    let (file, tips, _) = finishing(&shop, &mesh);
    let machining = shop.finishing();
    let origin = shop.blank.origin_of_optical();
    let against = Against {
        tips: &tips,
        origin,
        blank: &shop.blank,
        cutter: machining.cutter,
        machine: &machining.machine,
        dialect: Some(Dialect::Grbl),
        tolerance: 1e-3,
        flutes: None,
    };
    let wanted = Wanted { tips: &tips, origin, optical: [DVec2::ZERO, shop.blank.optical_size()] };
    let body = &file.text[file.text.find("\nG21").unwrap() + 1..];
    let caught = |text: &[u8]| {
        let Ok(read) = read(text, Some(Dialect::Grbl)) else { return true };
        if !judged(&read, &against).troubles.is_empty() {
            return true;
        }
        let swept = Swept::new(&strokes(&read.program, origin), machining.cutter.profile());
        let left = wanted.left(&swept, &progress).unwrap();
        left.untouched > 0.0 || !wanted.missed(&read.program, (&swept, &left), 1e-3, &progress).unwrap().is_none()
    };
    assert!(!caught(body.as_bytes()), "the program itself is sound");
    let good = read(body.as_bytes(), None).unwrap().program;
    let (surface, clear) = (heights(&shop, &good), lowest_rapid(&good));
    let digits: Vec<usize> = body.bytes().enumerate().filter(|(_, b)| b.is_ascii_digit()).map(|(at, _)| at).collect();
    let does_harm = |changed: &[u8]| match read(changed, None) {
        Err(_) => true,
        Ok(read) if read.fault_count > 0 || extent(&read.program).cuts.is_none() => true,
        Ok(read) => {
            let off =
                heights(&shop, &read.program).iter().zip(&surface).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            off > 1e-3 || lowest_rapid(&read.program) < clear
        }
    };
    let mut state = 7_u64;
    let mut change = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mut changed = body.as_bytes().to_vec();
        let at = digits[(state >> 33) as usize % digits.len()];
        changed[at] = b'0' + (changed[at] - b'0' + 1 + (state >> 20) as u8 % 9) % 10;
        (at, changed)
    };
    let (mut harmful, mut missed) = (0, Vec::new());
    while harmful < CHANGES {
        // So many at once, for all threads, and counted in their order.
        let some: Vec<(usize, Vec<u8>)> = (0..64).map(|_| change()).collect();
        let outcomes = some.par_iter().map(|(_, changed)| does_harm(changed).then(|| caught(changed)));
        let outcomes: Vec<Option<bool>> = outcomes.collect();
        let of_harm = some.iter().zip(outcomes).filter_map(|(one, caught)| Some((one, caught?)));
        for ((at, changed), caught) in of_harm.take(CHANGES - harmful) {
            harmful += 1;
            if !caught {
                let line = changed[..*at].iter().filter(|byte| **byte == b'\n').count();
                missed.push(String::from_utf8_lossy(changed).lines().nth(line).unwrap_or_default().to_owned());
            }
        }
    }
    assert!(missed.len() <= CHANGES / 100, "{} of {CHANGES}: {missed:?}", missed.len());
}
