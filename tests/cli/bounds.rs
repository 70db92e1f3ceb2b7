//! Memory, threads and time: refused before work or kept to, never run into.

use std::fs;
use std::path::Path;
use std::process::Command;

use image::{GrayImage, Luma};

use super::program::{Outcome, facetmill, finish, home, run_line};
use super::{SHEET, SMALL, assert_done, assert_refused, json};

#[test]
fn a_cutter_too_fine_for_a_sheet_is_refused_with_one_that_would_do() {
    let home = home();
    for line in [
        "--for-cutter ball:0.001",
        "--for-cutter ball:0.01 --size 100x100",
        "--for-cutter ball:0.1 --grid 16 --cells 1 --size 100x100",
        "--for-cutter ball:0.001 --dry-run",
    ] {
        let refused = run_line(home.path(), &format!("design ring.png -o plate {line}"));
        assert_refused(&refused, 4, &["too small to be followed", "mm or more in --for-cutter"]);
    }
    let wide = run_line(home.path(), "design ring.png -o plate --facets 2000x2000 --size 1x1 --for-cutter ball:100");
    assert_refused(&wide, 4, &["too wide to be followed", "--for-cutter"]);
    assert!(!home.path().join("plate").exists());
}

#[test]
fn what_needs_more_memory_than_allowed_is_refused_before_work_with_figures_and_remedy() {
    let home = home();
    assert_done(&run_line(home.path(), &format!("design ring.png -o plate {SMALL} --no-verify")));
    GrayImage::from_pixel(5000, 4000, Luma([200])).save(home.path().join("large.png")).unwrap();
    fs::write(home.path().join("large.stl"), solid_of(200_000)).unwrap();
    for (line, remedy) in [
        ("design ring.png -o new --surface sheet --grid 1024 --cells 1 --memory 300M", "--grid"),
        ("design ring.png -o new --for-cutter ball:0.1 --memory 200M", "--for-cutter"),
        ("design ring.png -o new --facets 1000x1000 --memory 0.2G", "--facets"),
        ("design large.png -o new --memory 200M", "picture smaller"),
        ("design large.png --dry-run --memory 200M", "picture smaller"),
        ("measure plate -o new --resolution 4096 --memory 2GB", "--resolution"),
        ("measure plate -o new --wall 500 --resolution 2048 --memory 500M", "--resolution"),
        ("measure plate -o new --look --light-radius 1 --resolution 4096 --memory 1G", "--resolution"),
        ("measure plate -o new --brdf --half-vectors 2048x2048 --polar 2 --azimuths 1 --memory 500M", "--half-vectors"),
        ("measure plate -o new --lamp large.png --memory 200M", "picture smaller"),
        ("measure large.stl -o new --resolution 16 --memory 50M", "mesh"),
        ("verify large.stl --against ring.png -o new --memory 50M", "mesh"),
        ("verify plate/plate.stl --against large.png -o new --memory 200M", "picture smaller"),
    ] {
        let refused = run_line(home.path(), line);
        assert_refused(&refused, 4, &["of memory", "B may be taken", remedy, "--memory"]);
        assert!(!home.path().join("new").exists(), "{line}");
    }
}

#[test]
fn the_dry_run_tells_the_memory_and_whether_it_would_be_refused() {
    let home = home();
    let told = run_line(home.path(), &format!("design ring.png {SHEET} --dry-run --memory 1G"));
    assert_done(&told);
    assert!(told.stdout.contains("memory") && !told.stdout.contains("would be refused"), "{told:?}");
    let large = "design ring.png --dry-run --surface sheet --grid 4096 --cells 1 --max-triangles 200000000 --memory 1G";
    let told = run_line(home.path(), large);
    assert_done(&told);
    assert!(told.stdout.contains("This would be refused") && told.stdout.contains("lower --grid"), "{told:?}");
    let told = run_line(home.path(), &format!("{large} --json"));
    let report: serde_json::Value = serde_json::from_str(&told.stdout).unwrap();
    assert!(report["memory_bytes_about"].as_f64().unwrap() > 2e9, "{report}");
}

#[test]
fn the_bound_on_memory_never_changes_a_result() {
    let home = home();
    let line = format!("design ring.png {SHEET} --for-cutter ball:1");
    assert_done(&run_line(home.path(), &format!("{line} -o a")));
    assert_done(&run_line(home.path(), &format!("{line} -o b --memory 1T --threads 1")));
    let stl = |folder: &str| fs::read(home.path().join(folder).join("plate.stl")).unwrap();
    assert!(stl("a") == stl("b"));
    // All but the time that it took.
    let report = |folder: &str| {
        let mut report = json(home.path().join(folder).join("report.json"));
        assert!(report["design"]["seconds"]["total"].as_f64().unwrap() > 0.0);
        report["design"]["seconds"].take();
        report
    };
    assert_eq!(report("a"), report("b"));
}

/// A text with many triangles of one corner, as binary STL.
fn solid_of(triangles: u32) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(triangles.to_le_bytes());
    for k in 0..triangles {
        let corners = [[0.0; 3], [1.0, k as f32, 0.0], [1.0, k as f32 + 1.0, 0.5]];
        bytes.extend([0; 12]);
        bytes.extend(corners.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Runs a line where only so many kilobytes can be addressed.
#[cfg(target_os = "linux")]
fn run_within(home: &Path, kilobytes: u64, line: &str) -> Outcome {
    let program = facetmill().get_program().to_owned();
    let script = format!("ulimit -v {kilobytes} && exec \"$0\" {line}");
    let mut shell = Command::new("sh");
    shell.current_dir(home).arg("-c").arg(script).arg(program);
    shell.stdin(std::process::Stdio::null()).stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    finish(shell.spawn().unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn within_a_limit_on_addresses_a_run_is_done_or_refused_and_never_aborts() {
    let home = home();
    assert_done(&run_line(home.path(), &format!("design ring.png -o plate {SMALL} --no-verify")));
    GrayImage::from_pixel(3000, 2000, Luma([200])).save(home.path().join("large.png")).unwrap();
    let mut codes = Vec::new();
    for line in [
        format!("design ring.png -o new --force {SMALL}"),
        "design ring.png -o new --force --facets 300x300 --sample random --arrange random --no-verify".into(),
        format!("design large.png -o new --force {SMALL} --no-verify"),
        "measure plate -o new --force --resolution 1024 --rays 20000".into(),
        "measure plate -o new --force --look --light-radius 1 --resolution 256 --rays 4".into(),
        "measure plate -o new --force --look --light-radius 1 --resolution 4096 --rays 4".into(),
    ] {
        for megabytes in [200, 350, 500, 900] {
            let outcome = run_within(home.path(), megabytes << 10, &line);
            assert!(matches!(outcome.code, Some(0 | 4)), "{megabytes} MB: {line}: {outcome:?}");
            codes.push(outcome.code);
        }
    }
    assert!([Some(0), Some(4)].iter().all(|code| codes.contains(code)), "{codes:?}");
}

#[test]
fn any_number_of_threads_that_the_environment_asks_for_is_taken_within_reason() {
    let home = home();
    for threads in ["1000000000", "99999999999999999999999", "-3", "many", "0", " 2 "] {
        let line = format!("design ring.png -o plate --force {SMALL} --no-verify");
        let run = facetmill().current_dir(home.path()).args(line.split(' ')).env("RAYON_NUM_THREADS", threads).spawn();
        let outcome = finish(run.unwrap());
        assert_eq!(outcome.code, Some(0), "{threads}: {outcome:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn threads_that_cannot_be_started_are_done_without() {
    let home = home();
    let strace = |inject: &str, line: &str| {
        let mut strace = Command::new("strace");
        strace.current_dir(home.path()).args(["-f", "-q", "-o", "/dev/null", "-e", "trace=clone,clone3"]);
        strace.arg("-e").arg(format!("inject=clone,clone3:error=EAGAIN:{inject}"));
        strace.arg(facetmill().get_program()).args(line.split(' '));
        strace.stdin(std::process::Stdio::null());
        strace.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
        strace.spawn().ok().map(finish)
    };
    assert_done(&run_line(home.path(), &format!("design ring.png -o plate {SMALL} --no-verify --threads 4")));
    let mut fewer = 0;
    for nth in 1..8 {
        for when in [format!("when={nth}"), format!("when={nth}+")] {
            for line in [
                format!("design ring.png -o new --force {SMALL} --no-verify --threads 4"),
                "measure plate -o seen --force --resolution 64 --rays 20000 --threads 4".to_owned(),
            ] {
                let Some(outcome) = strace(&when, &line) else {
                    eprintln!("SKIPPED: strace is not installed");
                    return;
                };
                assert_eq!(outcome.code, Some(0), "{when} {line}: {outcome:?}");
                fewer += usize::from(outcome.stderr.contains("threads only"));
            }
        }
        let same = |name: &str| fs::read(home.path().join(name).join("plate.stl")).unwrap();
        assert!(same("new") == same("plate"));
    }
    assert!(fewer > 3, "{fewer}");
}

#[cfg(target_os = "linux")]
#[test]
fn help_that_cannot_be_written_is_told() {
    let home = home();
    for line in
        ["--help", "design --help", "--version", "design ring.png --dry-run", "design ring.png --dry-run --json"]
    {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let run = facetmill().current_dir(home.path()).args(line.split(' ')).stdout(full).spawn().unwrap();
        assert_refused(&finish(run), 5, &["standard output cannot be written"]);
    }
}
