//! Our programs as a second interpreter reads them, pygcode from PyPI: positions, how fast lines come, and the heading's
//! bounds. Where it is missing the tests are skipped, visibly.

use std::fs;

use facetmill::gcode::dialect::Dialect;
use facetmill::gcode::read::read;
use facetmill::milling::machine::Machine;
use facetmill::progress::Progress;
use facetmill::shop::programs::ShopFile;
use glam::DVec3;

use crate::asking::{ask, skip};
use crate::linuxcnc::compare;
use crate::shop::{shop, wavy};

/// Lines a second that GRBL takes, and the moves that it holds in store: over as many its lines may come no faster.
const LINES: f64 = 400.0;
const STORE: usize = 16;

/// Bounds are told in so many mm.
const TOLD: f64 = 5e-4;

/// A move as the interpreter says it: where to, and how fast, mm/min; a rapid at the machine's own speed.
fn moves(said: &str, rapid: f64) -> Vec<(DVec3, f64)> {
    let one = |line: &str| {
        let numbers: Vec<f64> = line[2..].split(' ').map(|number| number.parse().unwrap()).collect();
        (DVec3::from_slice(&numbers), numbers.get(3).copied().unwrap_or(rapid))
    };
    said.lines().map(one).collect()
}

/// Most lines a second over any [`STORE`] moves, were all of them at full feed from beginning to end, which no machine is.
fn line_rate(moves: &[(DVec3, f64)]) -> f64 {
    let seconds: Vec<f64> = moves.windows(2).map(|pair| (pair[1].0 - pair[0].0).length() * 60.0 / pair[1].1).collect();
    let shortest = seconds.windows(STORE).map(|few| few.iter().sum::<f64>()).fold(f64::INFINITY, f64::min);
    STORE as f64 / shortest
}

/// Lower and upper bounds of a heading, mm.
fn told_bounds(text: &str) -> [DVec3; 2] {
    let comments = text.lines().filter_map(|line| line.strip_prefix('(')?.strip_suffix(')'));
    let all = comments.collect::<Vec<_>>().join(" ");
    let words: Vec<&str> = all.split_once("Bounds: ").unwrap().1.split_whitespace().take(12).collect();
    let [low, high] = [1, 3].map(|at| {
        let axis = |k: usize| words[4 * k + at].trim_end_matches(',').parse().unwrap();
        DVec3::new(axis(0), axis(1), axis(2))
    });
    assert_eq!([words[0], words[4], words[8]], ["X", "Y", "Z"], "{words:?}");
    [low, high]
}

/// Whether a file of ours is what pygcode says of it.
fn agrees(name: &str, file: &ShopFile, dialect: Dialect, said: &str, rapid: f64) {
    let program = read(file.text.as_bytes(), Some(dialect)).unwrap().program;
    compare(name, &program, said);
    let moves = moves(said, rapid);
    // Where it stands before the first line moves it is nobody's: all three axes are named by the third move.
    let known = &moves[3..];
    let (low, high) = known.iter().fold((known[0].0, known[0].0), |(low, high), (at, _)| (low.min(*at), high.max(*at)));
    let [told_low, told_high] = told_bounds(&file.text);
    for (seen, told) in [(low, told_low), (high, told_high)] {
        assert!((seen - told).abs().max_element() <= TOLD + 1e-9, "{name}: {seen}, told {told}");
    }
    let rate = line_rate(&moves);
    println!("{name}: {} moves, at most {rate:.1} lines a second", moves.len());
    if dialect == Dialect::Grbl {
        assert!(rate <= LINES * (1.0 + 1e-9), "{name}: {rate} lines a second");
    }
}

#[test]
fn a_second_interpreter_reads_our_programs_as_we_do_and_finds_them_within_their_bounds_and_grbl_s_pace() {
    let mesh = wavy();
    let folder = tempfile::tempdir().unwrap();
    // Passes along x and across; machines that are slow, as fast as GRBL's lines allow, and with play made up for.
    for (dialect, preset, degrees, stepover, feed) in [
        (Dialect::Grbl, "desktop", 0.0, 0.15, 600.0),
        (Dialect::Grbl, "desktop-good", 90.0, 0.15, 2400.0),
        (Dialect::LinuxCnc, "vmc", 180.0, 0.4, 600.0),
        (Dialect::Mach3, "vmc-good", 0.0, 0.4, 1200.0),
    ] {
        let mut shop = shop(&mesh, degrees, dialect);
        let preset = Machine::preset(preset).unwrap();
        let play = if dialect == Dialect::Grbl { preset.backlash_z } else { 0.0 };
        shop.machining.machine = Machine { compensation_z: play, feed, feed_per_tooth: 0.0, ..preset };
        shop.machining.passes.stepover = stepover;
        let (machining, progress) = (shop.finishing(), Progress::silent());
        let tips = machining.tips(&mesh);
        let ways = machining.ways_over(&tips, shop.blank.optical_size(), &progress).unwrap();
        for file in shop.programs(&mesh, &tips, &ways, &progress).unwrap() {
            let path = folder.path().join(file.name);
            fs::write(&path, &file.text).unwrap();
            let said = match ask("moves_of_pygcode.py", &[&path]) {
                Ok(said) => said,
                Err(why) => return skip("pygcode", &why),
            };
            let name = format!("{dialect} {} {}", file.part.name(), machining.machine.name);
            agrees(&name, &file, dialect, &said, machining.machine.rapid);
        }
    }
}
