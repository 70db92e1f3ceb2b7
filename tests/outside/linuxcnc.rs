//! Programs as LinuxCNC's own interpreter reads them: positions, feeds, centres and senses of arcs.
//!
//! The Debian package `linuxcnc-uspace` has it. Where it is missing the tests are skipped, visibly.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use facetmill::gcode::dialect::Dialect;
use facetmill::gcode::program::{Kind, Program};
use facetmill::gcode::read::read;
use facetmill::gcode::write::{Cutting, body, sealed};
use facetmill::milling::swept::{Stroke, Swept};
use glam::{DVec2, DVec3};

use crate::asking::{ask, skip};
use crate::moves::going;
use crate::shop::{finishing, shop, wavy};

/// What interpreters print of positions, mm; LinuxCNC's reckons in inches.
const DIGITS: f64 = 2e-8;

/// Whether `program` is what another interpreter said, in lines as `moves_of_linuxcnc.py` prints them.
pub fn compare(name: &str, program: &Program, said: &str) {
    let said = going(said.lines(), |line| {
        let numbers: Vec<f64> = line[2..].split(' ').map(|number| number.parse().unwrap()).collect();
        (line.starts_with('A'), DVec3::from_slice(&numbers[..3]))
    });
    let made = going(program.motions.iter(), |motion| (matches!(motion.kind, Kind::Arc(_)), motion.to));
    assert_eq!(said.len(), made.len(), "{name}");
    for (motion, line) in made.into_iter().zip(said) {
        let (kind, numbers) = line.split_once(' ').unwrap();
        let numbers: Vec<f64> = numbers.split(' ').map(|number| number.parse().unwrap()).collect();
        let mut ours = motion.to.to_array().to_vec();
        if motion.kind != Kind::Rapid {
            ours.push(motion.feed);
        }
        let letter = match program.arc(motion) {
            None => ["L", "R"][usize::from(motion.kind == Kind::Rapid)],
            Some(arc) => {
                ours.extend(arc.centre);
                ours.push(numbers[6].abs() * arc.turn.signum());
                "A"
            }
        };
        assert_eq!((letter, ours.len()), (kind, numbers.len()), "{name}:{}", motion.line);
        for (ours, theirs) in ours.iter().zip(&numbers) {
            assert!((ours - theirs).abs() <= DIGITS, "{name}:{}: {ours} {theirs} in {line}", motion.line);
        }
    }
}

#[test]
fn thirty_programs_of_other_origin_are_read_as_linuxcnc_reads_them() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/gcode");
    let mut programs = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path: PathBuf = entry.unwrap().path();
        // Line ends of old (CR) are none to LinuxCNC.
        let is_old = path.ends_with("old-line-ends-1.ngc");
        if is_old || path.extension().is_none_or(|extension| extension != "ngc") {
            continue;
        }
        let said = match ask("moves_of_linuxcnc.py", &[&path]) {
            Ok(said) => said,
            Err(why) => return skip("LinuxCNC", &why),
        };
        let program = read(&fs::read(&path).unwrap(), Some(Dialect::LinuxCnc)).unwrap().program;
        compare(&path.display().to_string(), &program, &said);
        programs += 1;
    }
    assert_eq!(programs, 30);
}

#[test]
fn what_is_written_is_read_by_linuxcnc_as_by_ourselves() {
    let place = |row: usize, k: usize| {
        let x = 0.05 * k as f64;
        DVec3::new(x, 0.31 * row as f64, -0.2 - 0.1 * (2.0 * x + row as f64).sin())
    };
    let tracks: Vec<Vec<DVec3>> = (0..30).map(|row| (0..100).map(|k| place(row, k)).collect()).collect();
    let folder = tempfile::tempdir().unwrap();
    for dialect in [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Mach3] {
        let cutting =
            Cutting { dialect, decimals: 5, feed: 600.0, plunge: 100.0, speed: 9000.0, safe: 5.0, travel: 1.0 };
        let text = sealed(dialect, &["Written by a test".into()], &body(&tracks, &cutting).unwrap());
        let path = folder.path().join("track.ngc");
        fs::write(&path, &text).unwrap();
        let said = match ask("moves_of_linuxcnc.py", &[&path]) {
            Ok(said) => said,
            Err(why) => return skip("LinuxCNC", &why),
        };
        let mut name = String::new();
        write!(name, "{dialect}").unwrap();
        compare(&name, &read(text.as_bytes(), Some(dialect)).unwrap().program, &said);
    }
}

/// A finishing program of ours: the interpreter accepts it, says the positions that we read, and along those positions a
/// sweep that shares nothing with ours leaves the surface that was simulated.
#[test]
fn a_finishing_program_leaves_the_simulated_surface_by_linuxcnc_s_positions_and_a_sweep_of_others() {
    let mesh = wavy();
    let shop = shop(&mesh, 0.0, Dialect::LinuxCnc);
    let (file, _, ways) = finishing(&shop, &mesh);
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("finishing.ngc"), &file.text).unwrap();
    let said = match ask("moves_of_linuxcnc.py", &[at("finishing.ngc")]) {
        Ok(said) => said,
        Err(why) => return skip("LinuxCNC", &why),
    };
    compare("finishing", &read(file.text.as_bytes(), Some(Dialect::LinuxCnc)).unwrap().program, &said);
    let accepted = std::process::Command::new("rs274").arg("-g").arg(at("finishing.ngc")).output();
    match accepted {
        Ok(run) => assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr)),
        Err(why) => skip("rs274", &why.to_string()),
    }
    fs::write(at("moves"), &said).unwrap();
    // Places over the plate that keep no step with passes, as the program counts.
    let places: Vec<DVec2> = (0..400)
        .map(|k| {
            DVec2::new((f64::from(k) * 0.618_033_988_7).fract() * 6.0, (f64::from(k) * 0.754_877_666_2).fract() * 4.0)
        })
        .collect();
    let listed: String = places.iter().map(|place| format!("{} {}\n", place.x, place.y)).collect();
    fs::write(at("places"), listed).unwrap();
    let arguments = [at("moves").into_os_string(), at("places").into_os_string(), "0.5".into()];
    let theirs = match ask("sweep_in_python.py", &arguments) {
        Ok(said) => said,
        Err(why) => return skip("NumPy", &why),
    };
    // Of the passes before they became a program.
    let machining = shop.finishing();
    let tracks = ways.programs(&machining.machine);
    let pairs = tracks.iter().flat_map(|track| track.windows(2));
    let strokes: Vec<Stroke> = pairs.map(|pair| Stroke { from: pair[0], to: pair[1], line: 0 }).collect();
    let simulated = Swept::new(&strokes, machining.cutter.profile());
    let heights: Vec<f64> = theirs.lines().map(|line| line.parse().unwrap()).collect();
    assert_eq!(heights.len(), places.len());
    for (place, theirs) in places.iter().zip(heights) {
        let ours = simulated.height(*place).unwrap() - shop.blank.top();
        assert!((ours - theirs).abs() < 1e-4, "{place}: {ours} {theirs} mm");
    }
}
