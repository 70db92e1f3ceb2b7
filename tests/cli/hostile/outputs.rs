//! Results that cannot be written: exit code 5, and nothing half-written.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use super::{Trials, wrong_with};
use crate::program::{facetmill, finish, listing};

#[test]
fn places_that_cannot_be_written_are_named() {
    let mut trials = Trials::new();
    let home = trials.home().to_owned();
    fs::create_dir_all(home.join("full/plate.stl")).unwrap();
    fs::write(home.join("full/report.json"), "mine").unwrap();
    fs::copy(home.join("ring.png"), home.join("plate.stl")).unwrap();
    let long = format!("new/{}/x", "n".repeat(300));
    let deep = "d/".repeat(3000);
    let mut cases =
        vec!["ring.png", "ring.png/out", "ring.png/out/deep", "full", "full/report.json", ".", &long, &deep];
    if cfg!(target_os = "linux") {
        cases.extend(["/proc/out", "/proc/self/out", "/sys/out", "/dev/null", "/dev/null/out", "/dev/full"]);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(home.join("nowhere"), home.join("dangling")).unwrap();
        std::os::unix::fs::symlink("loop", home.join("loop")).unwrap();
        cases.extend(["dangling", "loop", "loop/out"]);
    }
    for place in cases {
        let names = [if place.len() > 200 { "cannot be written" } else { place.split('/').next().unwrap() }];
        trials.refused(&["design", "ring.png", "-o", place], 5, &names);
        trials.refused(&["verify", "plate.stl", "--against", "ring.png", "-o", place], 5, &names);
    }
    trials.refused(&["design", "ring.png", "-o", "full", "--force"], 5, &["full/plate.stl", "is a folder"]);
    assert_eq!(fs::read(home.join("full/report.json")).unwrap(), b"mine");
    trials.judge();
}

/// The shell lets no file grow beyond a size, for which the system would send a signal: told like a full disk.
#[cfg(unix)]
#[test]
fn files_that_cannot_grow_leave_nothing() {
    let trials = Trials::new();
    fs::create_dir(trials.home().join("old")).unwrap();
    fs::write(trials.home().join("old/plate.stl"), "mine").unwrap();
    let before = listing(trials.home());
    for (blocks, folder) in [(1, "new/deep"), (200, "new/deep"), (200, "old")] {
        let program = facetmill().get_program().to_owned();
        let script = format!("ulimit -f {blocks}; exec \"$@\"");
        let mut command = Command::new("sh");
        command.current_dir(trials.home()).arg("-c").arg(script).arg("sh").arg(program);
        let args = ["design", "ring.png", "-o", folder, "--facets", "9x9", "--no-verify", "--force"];
        command.args(args).stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
        let outcome = finish(command.spawn().unwrap());
        assert_eq!(wrong_with(&outcome, 5, &[folder, "cannot be written"]), None, "{outcome:?}");
        assert_eq!(listing(trials.home()), before);
        assert_eq!(fs::read(trials.home().join("old/plate.stl")).unwrap(), b"mine");
    }
}

/// A file system of 64 kB, where this user may mount one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing() {
    struct Mounted(PathBuf);
    impl Drop for Mounted {
        fn drop(&mut self) {
            let _ = Command::new("umount").arg(&self.0).status();
        }
    }
    let mut trials = Trials::new();
    let disk = trials.home().join("disk");
    fs::create_dir(&disk).unwrap();
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(&disk).output();
    if !mount.is_ok_and(|done| done.status.success()) {
        eprintln!("skipped: no file system can be mounted here");
        return;
    }
    let mounted = Mounted(disk);
    let quick = ["--facets", "9x9", "--no-verify"];
    for place in ["disk", "disk/new/deep"] {
        let args = [&["design", "ring.png", "-o", place][..], &quick].concat();
        trials.refused(&args, 5, &[place, "cannot be written"]);
    }
    drop(mounted);
    trials.judge();
}
