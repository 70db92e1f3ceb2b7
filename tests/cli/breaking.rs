//! The program under files and command lines drawn at random, and under calls of the system that fail: an answer each
//! time, with a stated exit code, no panic, soon, and within a bound on memory.
//!
//! The short form is among the tests. The long form, some hours of CPU:
//!
//! ```text
//! FACETMILL_BREAKING=full cargo test --release --locked --test cli breaking:: -- --nocapture --test-threads 1
//! ```
//!
//! FACETMILL_BREAKING=100 draws 1 in 100 of the long form. Trial k is the same in every run.

mod lines;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::mutate::mutant;
use super::program::{Outcome, facetmill, finish_within, home, run_line};
use super::{SMALL, assert_done, strace_may_trace};

/// CPU seconds of one run, by the system's own limit, and address space, KiB.
const WITHIN: &str = "ulimit -t 20 && ulimit -v 4000000 && exec \"$0\" \"$@\"";

/// Wall clock of one run: many times its CPU, since the long form runs beside other work.
const PATIENCE: Duration = Duration::from_secs(600);

/// How many trials of `all` are drawn: a few, or as the environment asks.
fn trials(all: u64, few: u64) -> u64 {
    match std::env::var("FACETMILL_BREAKING").as_deref() {
        Err(_) => few,
        Ok("full") => all,
        Ok(one_in) => all.div_ceil(one_in.parse().unwrap()),
    }
}

/// What trials of one kind came to, by exit code.
#[derive(Default)]
struct Count {
    codes: std::collections::BTreeMap<i32, u64>,
    slowest: Duration,
}

impl Count {
    fn judge(&mut self, trial: &str, begun: Instant, outcome: &Outcome) {
        let code = outcome.code.unwrap_or(-1);
        assert!([0, 1, 2, 3, 4, 5].contains(&code), "{trial}: {outcome:?}");
        assert!(!outcome.stderr.contains("panicked") && !outcome.stderr.contains("allocation"), "{trial}: {outcome:?}");
        if code > 0 {
            // Lines that tell of stages may stand before it.
            let said = outcome.stderr.lines().last();
            let usage = code == 2 && outcome.stderr.contains("Usage");
            assert!(usage || said.is_some_and(|said| said.starts_with("facetmill: ")), "{trial}: {outcome:?}");
        }
        *self.codes.entry(code).or_default() += 1;
        self.slowest = self.slowest.max(begun.elapsed());
    }

    fn tell(&self, kind: &str) {
        let of = |(code, times): (&i32, &u64)| format!("{times} with {code}");
        let codes: Vec<String> = self.codes.iter().map(of).collect();
        println!("{kind}: {}; slowest {:.1} s, {}", codes.join(", "), self.slowest.as_secs_f64(), largest());
    }
}

/// The peak of resident memory over all runs so far.
#[cfg(target_os = "linux")]
fn largest() -> String {
    // SAFETY: a struct of numbers, for which zeros are a value; the call fills it in.
    let usage = unsafe {
        let mut usage: libc::rusage = std::mem::zeroed();
        assert_eq!(libc::getrusage(libc::RUSAGE_CHILDREN, &raw mut usage), 0);
        usage
    };
    format!("largest {} MiB", usage.ru_maxrss >> 10)
}

#[cfg(not(target_os = "linux"))]
fn largest() -> String {
    "peak of memory not asked".into()
}

/// A run under the limits.
fn run_limited(home: &Path, words: &[String]) -> Outcome {
    let mut command = if cfg!(unix) {
        let mut shell = Command::new("sh");
        shell.args(["-c", WITHIN]).arg(facetmill().get_program());
        shell
    } else {
        facetmill()
    };
    command.current_dir(home).args(words).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    finish_within(command.spawn().unwrap(), PATIENCE)
}

fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(Into::into).collect()
}

fn corpus(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name);
    let mut paths: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

/// Mutants of `corpus`, each written to `place` and given to the program as the lines say, in turn.
fn break_with(kind: &str, home: &Path, corpus: &[Vec<u8>], place: &str, lines: &[&str], many: u64) {
    let mut count = Count::default();
    for k in 0..many {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(k);
        fs::write(home.join(place), mutant(corpus, &mut rng)).unwrap();
        let begun = Instant::now();
        let outcome = run_limited(home, &words(lines[k as usize % lines.len()]));
        count.judge(&format!("{kind} {k}"), begun, &outcome);
    }
    count.tell(kind);
}

#[test]
fn mutated_pictures_get_an_answer() {
    let home = home();
    let mut all = corpus("picture");
    all.push(fs::read(home.path().join("ring.png")).unwrap());
    let lines = ["design odd.png --dry-run", "design odd.png -o d --force --facets 4x4 --no-verify --threads 1"];
    break_with("pictures", home.path(), &all, "odd.png", &lines, trials(10_000, 30));
}

#[test]
fn mutated_stls_get_an_answer() {
    let home = home();
    assert_done(&run_line(home.path(), &format!("design ring.png -o plate {SMALL} --no-verify")));
    let mut all = corpus("stl");
    all.push(fs::read(home.path().join("plate/plate.stl")).unwrap());
    let lines = [
        "measure odd.stl -o m --force --resolution 16 --rays 2000",
        "verify odd.stl --against ring.png -o v --force --rays 2000",
        "measure odd.stl -o m --force --ndf --resolution 16 --rays 2000",
    ];
    break_with("STLs", home.path(), &all, "odd.stl", &lines, trials(2000, 30));
}

#[test]
fn mutated_programs_of_machines_get_an_answer() {
    let home = home();
    assert_done(&run_line(home.path(), &format!("design ring.png -o plate {SMALL} --no-verify")));
    let lines =
        ["mill --check odd.nc --against plate --cutter ball:1 --no-verify", "mill --check odd.nc --against plate"];
    break_with("programs of machines", home.path(), &corpus("gcode"), "odd.nc", &lines, trials(2000, 20));
}

#[test]
fn mutated_recipes_get_an_answer() {
    let home = home();
    let lines = ["design ring.png --recipe odd.toml --dry-run"];
    break_with("recipes", home.path(), &corpus("recipe"), "odd.toml", &lines, trials(2000, 40));
}

#[test]
fn mutated_folders_of_designs_get_an_answer() {
    let home = home();
    let lines = ["measure plate -o m --force --resolution 16 --rays 2000"];
    let all = trials(1000, 30);
    for (k, name) in ["recipe.toml", "report.json"].into_iter().enumerate() {
        let level = if k == 0 { "" } else { "--level" };
        assert_done(&run_line(home.path(), &format!("design ring.png -o plate --force {SMALL} --no-verify {level}")));
        let whole = fs::read(home.path().join("plate").join(name)).unwrap();
        break_with(name, home.path(), &[whole], &format!("plate/{name}"), &lines, all / 2);
    }
}

#[test]
fn mutated_states_of_designs_get_an_answer() {
    let home = home();
    let sheet = "design ring.png -o plate --surface sheet --grid 16 --cells 1 --no-verify --threads 1";
    assert_done(&run_line(home.path(), &format!("{sheet} --snapshots")));
    let state = fs::read(home.path().join("plate/snapshots/state")).unwrap();
    let lines = [&*format!("{sheet} --force --resume")];
    break_with("states", home.path(), &[state], "plate/snapshots/state", &lines, trials(1000, 15));
}

#[test]
fn command_lines_of_flags_and_extremes_get_an_answer() {
    let home = home();
    assert_done(&run_line(home.path(), &format!("design ring.png -o plate {SMALL} --no-verify")));
    let mut count = Count::default();
    for k in 0..trials(5000, 40) {
        let line = lines::drawn(&mut Xoshiro256PlusPlus::seed_from_u64(k));
        let begun = Instant::now();
        let outcome = run_limited(home.path(), &line);
        count.judge(&format!("line {k}: {}", line.join(" ")), begun, &outcome);
    }
    count.tell("command lines");
}

/// Every n-th call of each kind fails, alone and from then on: the folder is wholly old or wholly new, and it is told.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn calls_that_fail_are_told_and_leave_the_folder_old_or_new() {
    if !strace_may_trace() {
        return;
    }
    let home = home();
    let design = |folder: &str, seed: u32| {
        format!(
            "design ring.png -o {folder} --facets 4x3 --sample random --threads 2 --no-verify --quiet --seed {seed}"
        )
    };
    assert_done(&run_line(home.path(), &design("old", 1)));
    assert_done(&run_line(home.path(), &design("new", 2)));
    let plate = |folder: &str| fs::read(home.path().join(folder).join("plate.stl")).unwrap_or_default();
    let (old, new) = (plate("old"), plate("new"));
    let mut count = Count::default();
    for (call, error) in [
        ("write", "ENOSPC"),
        ("openat", "EMFILE"),
        ("rename", "EIO"),
        ("unlink", "EACCES"),
        ("fsync", "EIO"),
        ("mkdir", "EDQUOT"),
        ("clone3", "EAGAIN"),
    ] {
        let every = trials(1, 5) as usize;
        for at in (1..3).chain((3..).step_by(every)) {
            let mut struck = false;
            for lasting in ["", "+"] {
                let _ = fs::remove_dir_all(home.path().join("d"));
                fs::create_dir(home.path().join("d")).unwrap();
                for name in ["plate.stl", "recipe.toml", "report.json"] {
                    fs::copy(home.path().join("old").join(name), home.path().join("d").join(name)).unwrap();
                }
                let log = home.path().join("log");
                let mut command = Command::new("strace");
                command.current_dir(home.path()).args(["-f", "-qq", "-o"]).arg(&log);
                command.args(["-e", &format!("trace={call}")]);
                command.args(["-e", &format!("inject={call}:error={error}:when={at}{lasting}")]);
                command.arg(facetmill().get_program()).args(design("d", 2).split(' ')).arg("--force");
                command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
                let begun = Instant::now();
                let mut outcome = finish_within(command.spawn().unwrap(), PATIENCE);
                struck |= fs::read_to_string(&log).unwrap().contains("INJECTED");
                let trial = format!("{call} {at}{lasting}");
                // Before the program begins its libraries are opened, and told of where standard error can be written.
                let loading = outcome.code == Some(127) && call == "openat";
                // Nor can it tell of anything where no call of write succeeds.
                if loading || call == "write" && outcome.stderr.is_empty() && outcome.code != Some(0) {
                    outcome = Outcome { code: Some(5), stderr: "facetmill: mute".into(), ..outcome };
                }
                count.judge(&trial, begun, &outcome);
                // Whoever comes next sees one or the other.
                run_line(home.path(), "design none.png -o d --force");
                let found = plate("d");
                assert!(found == if outcome.code == Some(0) { &new[..] } else { &old[..] } || found == new, "{trial}");
            }
            if !struck {
                break;
            }
        }
    }
    count.tell("calls that fail");
}
