//! Programs in the manner of common CAM programs, read: the moves are those that were drawn (`tests/corpus/gcode/draw.py`).

use std::fs;
use std::path::Path;

use facetmill::gcode::program::Kind;
use facetmill::gcode::read::read;
use glam::DVec3;

use crate::moves::going;

/// Digits of the places that were drawn, mm.
const DIGITS: f64 = 1e-6;

/// Half-way along an arc the programs' own rounding shows, of three decimals at the coarsest, mm.
const ROUNDING: f64 = 1e-3;

fn point(words: &[&str]) -> DVec3 {
    let numbers: Vec<f64> = words.iter().map(|word| word.parse().unwrap()).collect();
    DVec3::from_slice(&numbers)
}

#[test]
fn thirty_one_programs_of_other_origin_are_read_as_they_were_drawn() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/gcode");
    let mut programs = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "ngc") {
            continue;
        }
        programs += 1;
        let name = path.display();
        let read = read(&fs::read(&path).unwrap(), None).unwrap();
        assert_eq!(read.fault_count, 0, "{name}: {:?}", read.faults);
        let drawn = fs::read_to_string(path.with_extension("moves")).unwrap();
        let drawn = going(drawn.lines(), |line| {
            let words: Vec<&str> = line.split(' ').collect();
            (words[0] == "A", point(&words[1..4]))
        });
        let made = going(read.program.motions.iter(), |motion| (matches!(motion.kind, Kind::Arc(_)), motion.to));
        assert_eq!(drawn.len(), made.len(), "{name}");
        for (motion, line) in made.into_iter().zip(drawn) {
            let words: Vec<&str> = line.split(' ').collect();
            let kind = match motion.kind {
                Kind::Rapid => "R",
                Kind::Line => "L",
                Kind::Arc(_) => "A",
            };
            assert_eq!(kind, words[0], "{name}:{}", motion.line);
            assert!(
                (motion.to - point(&words[1..4])).length() < DIGITS,
                "{name}:{}: {} {line}",
                motion.line,
                motion.to
            );
            if let Some(arc) = read.program.arc(motion) {
                let half = arc.at(0.5);
                assert!((half - point(&words[4..7])).length() < ROUNDING, "{name}:{}: {half} {line}", motion.line);
            }
        }
    }
    assert_eq!(programs, 31);
}
