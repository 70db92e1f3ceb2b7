//! Programs for a shop: written, read back, judged; and what is refused.

use std::fs;

use facetmill::gcode::dialect::Dialect;
use facetmill::gcode::program::Seal;
use facetmill::gcode::read::read;

use super::program::{home, run_line};
use super::{assert_done, assert_refused, json, names};

/// A sheet of 12 × 8 mm that takes a moment.
pub const PLATE: &str =
    "design ring.png -o plate --grid 32 --cells 1 --size 12x8 --border 1 --for-cutter ball:1 --no-verify --quiet";

/// Machine and passes that take a moment.
pub const PASSES: &str = "--machine vmc --stepover 0.2 --polish 0.1 --rough-cutter flat:2";

#[test]
fn programs_come_one_tool_a_file_in_every_dialect_with_all_that_a_shop_asks_for() {
    let home = home();
    assert_done(&run_line(home.path(), PLATE));
    for (dialect, end) in [("grbl", "nc"), ("linuxcnc", "ngc"), ("mach3", "tap"), ("iso", "nc")] {
        let outcome = run_line(home.path(), &format!("mill plate {PASSES} --dialect {dialect} -o {dialect}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        assert!(outcome.told().contains("each was read back"), "{outcome:?}");
        let folder = home.path().join(dialect);
        let expected = ["air-cut", "finishing", "roughing"].map(|stem| format!("{stem}.{end}"));
        assert_eq!(names(&folder)[..3], expected);
        let report = json(folder.join("report.json"));
        // 12 × 8 mm and a rim of 1 mm around it.
        assert_eq!(report["stock_mm"][0].as_f64().unwrap().round(), 14.0);
        for program in report["programs"].as_array().unwrap() {
            let text = fs::read(folder.join(program["file"].as_str().unwrap())).unwrap();
            let read = read(&text, Some(dialect.parse::<Dialect>().unwrap())).unwrap();
            assert_eq!((read.fault_count, read.program.seal), (0, Seal::Whole), "{program}");
            let text = String::from_utf8(text).unwrap();
            for said in ["(Machine vmc, control", "(Zero: x and y at the lower left", "(Bounds: X", "(Takes"] {
                assert!(text.contains(said), "{said} in {text}");
            }
            let air = program["part"] == "air cut";
            let low = read.program.motions.iter().map(|motion| motion.to.z).fold(f64::INFINITY, f64::min);
            assert!(if air { low >= 1.0 } else { low < -0.2 }, "{low}");
            assert_eq!(text.contains(" M3\n"), !air);
            assert!(dialect != "grbl" || program["lines_per_second"].as_f64().unwrap() <= 400.0);
        }
    }
    let finishing = fs::read_to_string(home.path().join("linuxcnc/finishing.ngc")).unwrap();
    for said in ["G64 P0.0005 Q0", "one tool: ball:1", "Assumes a polish of 100 um", "starting values"] {
        assert!(finishing.contains(said), "{said}");
    }
    // The same bytes however many threads work, and nothing of other names is touched.
    let again = run_line(home.path(), &format!("mill plate {PASSES} --dialect linuxcnc -o again --threads 1 --quiet"));
    assert_done(&again);
    assert_eq!(fs::read_to_string(home.path().join("again/finishing.ngc")).unwrap(), finishing);
}

#[test]
fn what_makes_no_program_is_refused_in_a_sentence_and_leaves_nothing() {
    let home = home();
    assert_done(&run_line(home.path(), &PLATE.replace("--for-cutter ball:1 ", "")));
    for (flags, code, parts) in [
        ("", 2, &["--machine", "vmc"][..]),
        ("--machine lathe", 2, &["--machine", "lathe", "desktop"]),
        ("--machine vmc", 2, &["cutter"]),
        ("--machine vmc --cutter ball:1 --dialect fanuc", 2, &["--dialect", "grbl, linuxcnc"]),
        ("--machine vmc --cutter ball:1 --material cheese", 2, &["--material", "aluminium"]),
        ("--machine vmc --cutter ball:1 --allowance 9", 2, &["--allowance is 9", "0.01 to 5"]),
        ("--machine vmc --cutter ball:1 --rough-cutter flat:2 --rough-stepover 3", 2, &["--rough-stepover is 3"]),
        ("--machine vmc --cutter ball:30", 4, &["ball:30", "plate's smaller side"]),
        ("--machine vmc --cutter ball:1 --rough-cutter flat:40", 4, &["flat:40", "--rough-cutter"]),
        ("--machine vmc --cutter ball:1 --stepover 0.8", 4, &["--stepover"]),
    ] {
        let outcome = run_line(home.path(), &format!("mill plate {flags} -o shop"));
        assert_refused(&outcome, code, parts);
        assert!(!home.path().join("shop").exists(), "{flags}");
    }
    let outcome = run_line(home.path(), "mill plate --machine vmc --cutter ball:1 -o plate --force");
    assert_refused(&outcome, 2, &["design's own folder"]);
}
