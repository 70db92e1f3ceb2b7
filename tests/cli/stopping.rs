//! Ctrl-C, snapshots, and going on from them.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::program::{facetmill, finish, home, listing, ring, run_line};
use super::{ALL_FILES, SHEET, assert_done, assert_refused, names};

/// Until the program has set up what it does about Ctrl-C.
#[cfg(unix)]
fn await_handler(process: u32) {
    let caught = || {
        let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    };
    // SIGINT is signal 2; where there is no /proc, a second will do.
    for _ in 0..1000 {
        if caught().is_some_and(|mask| mask & 2 != 0) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(if caught().is_some() { 10 } else { 1 }));
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_quickly_and_leaves_nothing() {
    let home = home();
    for wait in [0, 700] {
        let line = "design ring.png -o deep/er/plate --facets 1000x1000 --no-verify --json";
        let child = facetmill().current_dir(home.path()).args(line.split(' ')).spawn().unwrap();
        await_handler(child.id());
        std::thread::sleep(std::time::Duration::from_millis(wait));
        let told = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(told.success());
        // The design would take longer than the watch beside it has patience.
        let outcome = finish(child);
        assert_refused(&outcome, 130, &["stopped"]);
        assert_eq!(serde_json::from_str::<Value>(&outcome.stdout).unwrap()["exit_code"], 130);
        assert_eq!(names(home.path()), ["ring.png"]);
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_finishes_a_continuous_design_and_twice_stops_it() {
    let home = home();
    let big = "--surface continuous --grid 256 --cells 1 --size 10x10 --rays 20000";
    for (folder, times) in [("once", 1), ("twice", 2)] {
        let line = format!("design ring.png -o {folder} {big} --snapshots --json");
        let child = facetmill().current_dir(home.path()).args(line.split(' ')).spawn().unwrap();
        let state = home.path().join(folder).join("snapshots/state");
        for _ in 0..6000 {
            if state.exists() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        for _ in 0..times {
            std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
            std::thread::sleep(std::time::Duration::from_millis(60));
        }
        let outcome = finish(child);
        assert!(outcome.stderr.starts_with("facetmill: finishing the best so far"), "{outcome:?}");
        if times == 2 {
            assert_eq!(outcome.code, Some(130), "{outcome:?}");
            assert!(outcome.stderr.contains("--resume goes on from twice/snapshots"), "{outcome:?}");
            assert_eq!(fs::read_dir(home.path().join("twice")).unwrap().count(), 1, "only snapshots");
        } else {
            assert_eq!(outcome.code, Some(0), "{outcome:?}");
            let report: Value = serde_json::from_str(&outcome.stdout).unwrap();
            let stopped = &report["design"]["continuous"]["stopped_early"];
            assert!(stopped["steps_done"].as_u64().unwrap() >= 1, "{stopped}");
            assert!(stopped["steps_done"].as_u64() < stopped["steps"].as_u64(), "{stopped}");
            assert!(report["designed"]["tv_incident"]["1"].as_f64().unwrap() < 0.2, "{report}");
            assert!(home.path().join("once/plate.stl").exists());
        }
    }
}

#[test]
fn a_design_resumed_from_its_snapshots_ends_in_the_same_bytes() {
    let home = home();
    assert_done(&run_line(home.path(), &format!("design ring.png -o whole {SHEET}")));
    assert_done(&run_line(home.path(), &format!("design ring.png -o kept {SHEET} --snapshots")));
    let stl = |name: &str| fs::read(home.path().join(name).join("plate.stl")).unwrap();
    assert!(stl("whole") == stl("kept"));
    let kept = names(&home.path().join("kept/snapshots"));
    assert_eq!(kept.last().unwrap(), "state");
    assert!(kept.len() > 4 && kept[0] == "01-tries.png" && kept[1] == "02-descent.png", "{kept:?}");
    let picture = image::open(home.path().join("kept/snapshots").join(&kept[kept.len() - 2])).unwrap().into_luma8();
    assert_eq!(picture.dimensions(), (256, 256));
    // The ring is lit, its middle is not.
    assert!(picture.get_pixel(192, 128).0[0] > 150 && picture.get_pixel(128, 128).0[0] < 60);

    // Stopped at once after some step, as by a second Ctrl-C: only snapshots are left, and they are enough.
    let snapshots = home.path().join("stopped/snapshots");
    for wait in 0..2 {
        let line = format!("design ring.png -o stopped {SHEET} {}", if wait == 0 { "--snapshots" } else { "--resume" });
        let mut child = facetmill().current_dir(home.path()).args(line.split(' ')).spawn().unwrap();
        let seen = ["02-descent.png", "03-descent.png"][wait];
        while !snapshots.join(seen).exists() && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let _ = child.kill();
        let _ = child.wait();
        if home.path().join("stopped/plate.stl").exists() {
            // A machine so quick that there was nothing left to stop.
            break;
        }
    }
    let flags = if home.path().join("stopped/plate.stl").exists() { "--resume --force" } else { "--resume" };
    clear_hidden(&home.path().join("stopped"));
    assert_done(&run_line(home.path(), &format!("design ring.png -o stopped {SHEET} {flags}")));
    assert!(stl("whole") == stl("stopped"));
}

/// What a killed program may leave of the file that it was writing.
fn clear_hidden(folder: &Path) {
    for path in listing(folder) {
        if path.file_name().unwrap().to_string_lossy().starts_with('.') && path.is_dir() {
            fs::remove_dir_all(path).unwrap();
        }
    }
}

#[test]
fn what_cannot_be_resumed_is_refused_by_name() {
    let home = home();
    assert_refused(
        &run_line(home.path(), &format!("design ring.png -o plate {SHEET} --resume")),
        3,
        &["plate/snapshots/state", "no such file"],
    );
    assert!(!home.path().join("plate").exists());
    assert_done(&run_line(home.path(), &format!("design ring.png -o plate {SHEET} --snapshots")));
    let folder = home.path().join("plate");
    let resumed = |flags: &str| run_line(home.path(), &format!("design ring.png -o plate {SHEET} --resume {flags}"));
    // There is more than snapshots.
    assert_refused(&resumed(""), 5, &["--force"]);
    for name in ALL_FILES {
        let _ = fs::remove_file(folder.join(name));
    }
    assert_refused(&resumed("--seed 2"), 4, &["plate/snapshots/state", "design.seed is 1", "2"]);
    let mut other = ring();
    other.put_pixel(0, 0, image::Luma([9]));
    other.save(home.path().join("other.png")).unwrap();
    let line = format!("design other.png -o plate {SHEET} --resume");
    assert_refused(&run_line(home.path(), &line), 4, &["another picture"]);
    let state = folder.join("snapshots/state");
    let bytes = fs::read(&state).unwrap();
    for (broken, part) in [
        (&bytes[..bytes.len() - 1], "too early"),
        (&bytes[..40], "no state"),
        (b"solid plate\n".as_slice(), "no state"),
    ] {
        fs::write(&state, broken).unwrap();
        assert_refused(&resumed(""), 3, &["plate/snapshots/state", part]);
    }
    fs::write(&state, &bytes).unwrap();
    assert_done(&resumed(""));
    assert_refused(
        &run_line(home.path(), "design ring.png -o flat --surface flat --snapshots"),
        2,
        &["--snapshots", "continuous"],
    );
}
