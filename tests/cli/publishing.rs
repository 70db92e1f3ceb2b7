//! Folders that a run writes into: wholly old or wholly new, whatever stops the run, and nobody's input lost.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::program::{facetmill, finish, home, listing, run_line};
use super::{SHEET, SMALL, assert_done, assert_refused, names, strace_may_trace};

/// Every file below a folder, by its path.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let all = listing(folder).into_iter().filter(|path| path.is_file());
    all.map(|path| (path.strip_prefix(folder).unwrap().display().to_string(), fs::read(&path).unwrap())).collect()
}

#[test]
fn force_never_replaces_what_the_run_reads() {
    let home = home();
    let folder = home.path().join("d");
    assert_done(&run_line(home.path(), &format!("design ring.png -o d {SMALL} --no-verify")));
    fs::copy(home.path().join("ring.png"), folder.join("target.png")).unwrap();
    fs::create_dir(home.path().join("views")).unwrap();
    fs::copy(home.path().join("ring.png"), home.path().join("views/look.png")).unwrap();
    fs::create_dir(folder.join("snapshots")).unwrap();
    fs::copy(home.path().join("ring.png"), folder.join("snapshots/01-tries.png")).unwrap();
    fs::copy(folder.join("recipe.toml"), home.path().join("mine.toml")).unwrap();
    let named = fs::read_to_string(home.path().join("mine.toml")).unwrap().replace("ring.png", "d/target.png");
    fs::write(home.path().join("mine.toml"), named).unwrap();
    let before = contents(home.path());
    for (line, lost) in [
        (format!("design d/target.png -o d --force {SMALL}"), "d/target.png"),
        (format!("design ./d/../d/target.png -o d/. --force {SMALL}"), "target.png"),
        ("design --recipe mine.toml -o d --force".into(), "d/target.png"),
        ("design ring.png --recipe d/recipe.toml -o d --force".into(), "d/recipe.toml"),
        (format!("design d/snapshots/01-tries.png -o d --force --snapshots {SHEET}"), "snapshots"),
        ("verify ring.png --against d/target.png -o d --force".into(), "d/target.png"),
        ("verify d/plate.stl --against ring.png -o d --force".into(), "the design's own folder"),
        ("measure d/plate.stl --look --lamp views/look.png -o views --force".into(), "views/look.png"),
    ] {
        assert_refused(&run_line(home.path(), &line), 2, &[lost, "choose another folder"]);
        assert!(contents(home.path()) == before, "{line}");
    }
}

#[test]
fn of_two_runs_into_one_folder_the_second_is_refused() {
    let home = home();
    let line = "design ring.png -o plate --facets 1000x1000 --no-verify --threads 1";
    let mut first = facetmill().current_dir(home.path()).args(line.split(' ')).spawn().unwrap();
    let lock = home.path().join("plate/.facetmill-lock");
    while !lock.exists() && first.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    // Made, and locked a moment later.
    std::thread::sleep(std::time::Duration::from_millis(200));
    let second = format!("design ring.png -o plate --force {SMALL} --no-verify");
    assert_refused(&run_line(home.path(), &second), 5, &["plate", "another run"]);
    first.kill().unwrap();
    let _ = first.wait();
    // What a killed run leaves makes no folder somebody's, and goes with the next run.
    assert_done(&run_line(home.path(), &second.replace(" --force", "")));
    assert!(names(&home.path().join("plate")).iter().all(|name| !name.starts_with('.')));
}

#[cfg(unix)]
#[test]
fn all_files_have_the_permissions_that_the_user_asks_for() {
    use std::os::unix::fs::PermissionsExt;
    let home = home();
    let program = facetmill().get_program().to_owned();
    let mut command = std::process::Command::new("sh");
    command.current_dir(home.path()).args(["-c", "umask 027; exec \"$@\"", "sh"]).arg(program);
    command.args(format!("design ring.png -o plate {SHEET} --snapshots --quiet").split(' '));
    command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    assert_done(&finish(command.spawn().unwrap()));
    let files = listing(&home.path().join("plate"));
    assert!(files.iter().any(|path| path.ends_with("snapshots/state")));
    for path in files {
        let mode = fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode, if path.is_dir() { 0o750 } else { 0o640 }, "{}", path.display());
    }
}

/// The system kills the program as it enters the n-th call of a kind, for every n and every kind that changes folders.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn a_program_killed_at_any_call_leaves_its_folder_wholly_old_or_wholly_new() {
    if !strace_may_trace() {
        return;
    }
    let home = home();
    let design = |folder: &str, seed: u32| {
        format!(
            "design ring.png -o {folder} --facets 4x3 --sample random --threads 1 --no-verify --quiet --seed {seed}"
        )
    };
    assert_done(&run_line(home.path(), &design("earlier", 1)));
    fs::write(home.path().join("earlier/simulated.png"), "of an earlier plate").unwrap();
    fs::write(home.path().join("earlier/mine.txt"), "mine").unwrap();
    let mut later = designed(home.path(), &design("later", 2));
    let old = contents(&home.path().join("earlier"));
    later.insert("mine.txt".into(), b"mine".to_vec());
    let told = |files: &BTreeMap<String, Vec<u8>>| {
        // Seconds differ from run to run.
        let report = String::from_utf8_lossy(&files["report.json"]).into_owned();
        let mut others = files.clone();
        others.remove("report.json");
        (others, report.contains("\"seed\": 2"))
    };
    let (mut olds, mut news) = (0, 0);
    for call in ["rename", "unlink", "rmdir", "mkdir", "fsync", "flock"] {
        for at in 1.. {
            let folder = home.path().join("d");
            let _ = fs::remove_dir_all(&folder);
            fs::create_dir(&folder).unwrap();
            old.iter().for_each(|(name, bytes)| fs::write(folder.join(name), bytes).unwrap());
            let mut command = std::process::Command::new("strace");
            command.current_dir(home.path()).args(["-f", "-qq", "-o", "/dev/null"]);
            command.args(["-e", &format!("trace={call}"), "-e", &format!("inject={call}:signal=KILL:when={at}")]);
            command.arg(facetmill().get_program()).args(design("d", 2).split(' ')).arg("--force");
            let ended = command.output().unwrap();
            // The next run finds no picture, after it has put the folder right.
            assert_refused(&run_line(home.path(), "design none.png -o d --force"), 3, &["none.png"]);
            let found = contents(&folder);
            if found == old {
                olds += 1;
            } else {
                assert!(told(&found) == told(&later), "{call} {at}: {:?}", found.keys());
                news += 1;
            }
            assert!(names(&folder).iter().all(|name| !name.starts_with('.')), "{call} {at}");
            if ended.status.success() {
                break;
            }
            assert!(at < 200, "{call}: {ended:?}");
        }
    }
    assert!(olds > 10 && news > 10, "{olds} {news}");
}

/// Files of a design into a new folder `later`.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn designed(home: &Path, line: &str) -> BTreeMap<String, Vec<u8>> {
    assert_done(&run_line(home, line));
    contents(&home.join("later"))
}
