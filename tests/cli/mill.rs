//! Programs for a shop: written, read back, judged; and what is refused.

use std::fs;

use facetmill::gcode::dialect::Dialect;
use facetmill::gcode::program::Seal;
use facetmill::gcode::read::read;

use super::program::{home, run_line};
use super::{assert_done, assert_refused, json, names};

/// A sheet of 12 × 8 mm that takes a moment.
pub const PLATE: &str = "design ring.png -o plate --grid 32 --cells 1 --size 12x8 --border 1 --for-cutter ball:1 --rays 20000 --no-verify --quiet";

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
        let mut expected = ["air-cut", "finishing", "roughing"].map(|stem| format!("{stem}.{end}")).to_vec();
        expected.extend(["comparison_made.png", "report.json", "setup.html"].map(str::to_owned));
        expected.sort_unstable();
        assert_eq!(names(&folder), expected);
        let report = json(folder.join("report.json"));
        // Hours of the program itself, and why they are more than those of passes alone.
        assert!(report["advice"].to_string().contains("where design, verify and plan tell"), "{report}");
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
    let sheet = fs::read_to_string(home.path().join("linuxcnc/setup.html")).unwrap();
    for said in
        ["<svg", "data:image/png;base64,", "finishing.ngc", "flat rim of 1 mm", "% of the light falls", "flat:2"]
    {
        assert!(sheet.contains(said), "{said}");
    }
    // One page by itself: nothing is fetched.
    assert!(!sheet.contains("http") && !sheet.contains("<script"), "{sheet}");
    // The same bytes however many threads work, and nothing of other names is touched.
    let again = run_line(home.path(), &format!("mill plate {PASSES} --dialect linuxcnc -o again --threads 1 --quiet"));
    assert_done(&again);
    assert_eq!(fs::read_to_string(home.path().join("again/finishing.ngc")).unwrap(), finishing);
    // Passes in any direction end beside the plate, within the stock; each was read back and judged.
    assert_done(&run_line(home.path(), &format!("mill plate {PASSES} --pass-angle 30 -o aslant --quiet")));
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
        ("--machine vmc --cutter ball:1 --pass-angle best", 2, &["--pass-angle best", "degrees"]),
        ("--machine vmc --cutter ball:1 --pass-angle north", 2, &["north", "best"]),
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

#[test]
fn a_program_that_makes_up_for_play_says_so_and_is_judged_as_a_slide_with_that_play_follows_it() {
    let home = home();
    assert_done(&run_line(home.path(), PLATE));
    let line = "mill plate --machine desktop --compensate --stepover 0.2 --polish 0.1 --rough-cutter flat:2 --no-verify -o shop --quiet";
    assert_done(&run_line(home.path(), line));
    let text = fs::read_to_string(home.path().join("shop/finishing.nc")).unwrap();
    assert!(text.contains("(Makes up for 5 um of play in z"), "{text}");
    let checked = |text: &str| {
        fs::write(home.path().join("one.nc"), text).unwrap();
        run_line(home.path(), "mill --check one.nc --against plate/plate.stl --margin 1 --quiet")
    };
    assert_done(&checked(&text));
    // Followed to the letter it would cut 2.5 µm too deep wherever it falls.
    let open = text.split_once('\n').unwrap().1.replace("Makes up for 5 um", "Makes up for 0 um");
    assert_refused(&checked(&open), 1, &["below the plate"]);
}

/// The kinds of trouble that a check tells, each with its line.
fn troubles(report: &serde_json::Value) -> Vec<(String, u64)> {
    let list = report["read"]["troubles"].as_array().unwrap();
    list.iter().map(|one| (one["kind"].as_str().unwrap().to_owned(), one["line"].as_u64().unwrap_or(0))).collect()
}

/// Line of `text` (from 1) and its content, of the first line of cutting that is about half-way.
fn half_way(text: &str, is: impl Fn(&str) -> bool) -> (usize, String) {
    let all: Vec<&str> = text.lines().collect();
    let found = all.iter().enumerate().skip(all.len() / 2).find(|(_, line)| is(line)).unwrap();
    (found.0 + 1, (*found.1).to_owned())
}

#[test]
fn what_is_planted_in_a_program_is_found_with_its_line_and_the_program_as_written_can_be_run() {
    let home = home();
    assert_done(&run_line(home.path(), PLATE));
    assert_done(&run_line(home.path(), &format!("mill plate {PASSES} --dialect grbl -o shop --quiet")));
    let check = |file: &str| {
        let line = format!("mill --check {file} --against plate --polish 0.1 --margin 1 --json");
        let outcome = run_line(home.path(), &line);
        (outcome.code, serde_json::from_str::<serde_json::Value>(outcome.stdout.trim()).unwrap())
    };
    let (code, report) = check("shop/finishing.nc");
    assert_eq!((code, troubles(&report)), (Some(0), vec![]), "{report}");
    assert!(report["light"]["tv_incident"]["1"].as_f64().unwrap() < 0.5, "{report}");
    let left = &report["surface"];
    // Cusps of 0.2 mm with a ball of radius 0.5 are 10 µm high, a third of that on the mean.
    assert!((2.0..4.5).contains(&left["left_mean_um"].as_f64().unwrap()), "{left}");
    assert!(left["below_um"].as_f64().unwrap() < 0.2 && left["untouched"] == 0.0, "{left}");

    let text = fs::read_to_string(home.path().join("shop/finishing.nc")).unwrap();
    // The checksum stands in the first line: without it nothing but the moves themselves can tell.
    let open = text.split_once('\n').unwrap().1.to_owned();
    let (_, cut) = half_way(&open, |line| line.starts_with('X') && line.contains('Z') && !line.contains('F'));
    let (_, retract) = half_way(&open, |line| line == "G0Z1");
    let z = |line: &str, by: f64| {
        let (x, z) = line.split_once('Z').unwrap();
        format!("{x}Z{:.4}", z.parse::<f64>().unwrap() + by)
    };
    for (from, to, kind) in [
        (&cut, z(&cut, -0.003), "gouge"),
        (&cut, z(&cut, 0.05), "left-standing"),
        (&cut, format!("X200{}", &cut[cut.find('Z').unwrap()..]), "out-of-stock"),
        (&cut, z(&cut, -9.0), "below-floor"),
        (&retract, "G0Z-0.3".into(), "rapid-in-material"),
        (&cut, format!("{cut}E2"), "unread"),
        (&cut, format!("{cut}F0"), "unread"),
    ] {
        let (line, _) = half_way(&open, |line| line == from);
        // A single point too high changes next to nothing, since its neighbours pass beside it: all to the pass's end.
        let end = line + open.lines().skip(line).position(|line| line.starts_with("G0")).unwrap();
        let changed = |(k, old): (usize, &str)| match k + 1 {
            k if k == line => to.clone(),
            k if kind == "left-standing" && k > line && k <= end && old.contains('Z') => z(old, 0.05),
            _ => old.to_owned(),
        };
        let all: Vec<String> = open.lines().enumerate().map(changed).collect();
        fs::write(home.path().join("changed.nc"), all.join("\n")).unwrap();
        let (code, report) = check("changed.nc");
        assert_eq!((code, &report["refused"]), (Some(1), &serde_json::Value::Bool(true)), "{kind}: {report}");
        // What a rapid passes is told where it passes, in the next line; of a pass the worst of its lines.
        let last = if kind == "left-standing" { end } else { line } as u64 + 1;
        let near = |found: &(String, u64)| found.0 == kind && (line as u64..=last).contains(&found.1);
        assert!(troubles(&report).iter().any(near), "{kind} in line {line}: {report}");
        assert!(report["verdict"].as_str().unwrap().contains("should not be run"));
    }
    // With the checksum any digit tells, in a sentence that says so first.
    fs::write(home.path().join("broken.nc"), text.replacen("G4 P4", "G4 P5", 1)).unwrap();
    let told = run_line(home.path(), "mill --check broken.nc --against plate --quiet");
    assert_refused(&told, 1, &["broken.nc", "checksum"]);
    // No feed at all.
    fs::write(home.path().join("still.nc"), "G21 G90 G0Z5\nX2Y2 S1000M3\nG1Z-0.1\nM2\n").unwrap();
    let told = run_line(home.path(), "mill --check still.nc --against plate --quiet");
    assert_refused(&told, 1, &["line 3", "no feed"]);
}

#[test]
fn programs_that_are_none_and_plates_that_are_not_there_are_told() {
    let home = home();
    assert_done(&run_line(home.path(), PLATE));
    fs::write(home.path().join("binary.nc"), b"G21\nG1 X\x00\x01").unwrap();
    fs::write(home.path().join("empty.nc"), b"(nothing)\n").unwrap();
    for (line, code, parts) in [
        ("mill --check binary.nc --against plate", 3, &["binary.nc", "line 2", "0x00"][..]),
        ("mill --check empty.nc --against plate", 3, &["empty.nc", "no word"]),
        ("mill --check none.nc --against plate", 3, &["none.nc", "no such file"]),
        ("mill --check empty.nc", 2, &["--against"]),
        ("mill --check empty.nc --against plate --zero 1,2", 2, &["--zero", "0,0,-1.5"]),
        ("mill --check empty.nc --against plate --tolerance 0", 2, &["--tolerance is 0"]),
        ("mill plate --machine vmc", 2, &["--output"]),
    ] {
        assert_refused(&run_line(home.path(), line), code, parts);
    }
}
