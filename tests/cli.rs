//! The program as a whole, from the command line to the files.

mod program;

use std::fs;
use std::path::Path;
use std::process::Stdio;

use program::{Outcome, facetmill, finish, home, listing, run, run_line};
use serde_json::Value;

/// A plate that takes a moment.
const SMALL: &str = "--facets 8x6 --rays 20000";

const ALL_FILES: [&str; 9] = [
    "comparison.png",
    "heightmap.json",
    "heightmap.png",
    "plate.stl",
    "recipe.toml",
    "relief.png",
    "report.json",
    "simulated.png",
    "target.png",
];

fn names(folder: &Path) -> Vec<String> {
    listing(folder).iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect()
}

fn json(path: impl AsRef<Path>) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn assert_done(outcome: &Outcome) {
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
}

fn assert_refused(outcome: &Outcome, code: i32, parts: &[&str]) {
    assert_eq!(outcome.code, Some(code), "{outcome:?}");
    assert!(outcome.stderr.starts_with("facetmill: ") && outcome.stderr.lines().count() == 1, "{outcome:?}");
    assert!(parts.iter().all(|part| outcome.stderr.contains(part)), "{parts:?} in {outcome:?}");
}

/// Files of two designs that must be the same bytes; the report differs in its seconds.
fn assert_same_plate(a: &Path, b: &Path, but: &[&str]) {
    for name in ALL_FILES.iter().filter(|name| **name != "report.json" && !but.contains(name)) {
        assert!(fs::read(a.join(name)).unwrap() == fs::read(b.join(name)).unwrap(), "{name} differs");
    }
    let facts = |folder: &Path| {
        let mut report = json(folder.join("report.json"));
        report["design"].as_object_mut().unwrap().remove("seconds");
        report
    };
    if but.is_empty() {
        assert_eq!(facts(a), facts(b));
    }
}

#[test]
fn a_design_writes_every_file_and_says_what_it_made() {
    let home = home();
    let done = run_line(home.path(), &format!("design ring.png -o new/plate {SMALL}"));
    assert_done(&done);
    let folder = home.path().join("new/plate");
    assert_eq!(names(&folder), ALL_FILES);
    for word in ["Wrote new/plate", "8 × 6 facets", "relief", "valleys", "misplaced (TV)", "likeness (SSIM)", "Note: "]
    {
        assert!(done.stdout.contains(word), "{word} in {}", done.stdout);
    }
    assert!(done.stdout.lines().all(|line| line.chars().count() < 140), "{}", done.stdout);
    let report = json(folder.join("report.json"));
    for key in ["step_rms_mm", "wall_area_ratio", "valleys"] {
        assert!(report["design"][key].is_number(), "{key}");
    }
    assert!(report["design"]["seconds"]["total"].is_number());
    for key in ["tv", "tv_incident", "ssim"] {
        for blur in ["0.5", "1", "2"] {
            assert!(report["designed"][key][blur].is_number(), "{key} {blur}");
        }
    }
    for key in ["w1_deg", "efficiency", "multi_bounce", "blocked", "rays"] {
        assert!(report["designed"][key].is_number(), "{key}");
    }
    assert_eq!(report["stl"]["bytes"], fs::metadata(folder.join("plate.stl")).unwrap().len());
    assert_eq!(image::open(folder.join("heightmap.png")).unwrap().color(), image::ColorType::L16);

    // The folder is not touched again without leave.
    let before = fs::read(folder.join("report.json")).unwrap();
    let again = run_line(home.path(), &format!("design ring.png -o new/plate {SMALL}"));
    assert_refused(&again, 5, &["new/plate", "--force"]);
    assert_eq!(fs::read(folder.join("report.json")).unwrap(), before);
}

#[test]
fn force_replaces_our_files_and_leaves_those_of_others() {
    let home = home();
    let folder = home.path().join("plate");
    fs::create_dir(&folder).unwrap();
    for name in ["notes.txt", "plate.stl", "simulated.png"] {
        fs::write(folder.join(name), "mine").unwrap();
    }
    let line = format!("design ring.png -o plate {SMALL} --no-verify --quiet");
    assert_refused(&run_line(home.path(), &line), 5, &["plate", "--force"]);
    let done = run_line(home.path(), &(line + " --force"));
    assert_done(&done);
    assert_eq!(done.stdout, "");
    // simulated.png told of an earlier plate: it goes.
    let left =
        ["heightmap.json", "heightmap.png", "notes.txt", "plate.stl", "recipe.toml", "relief.png", "report.json"];
    assert_eq!(names(&folder), left.iter().copied().chain(["target.png"]).collect::<Vec<_>>());
    assert_eq!(fs::read(folder.join("notes.txt")).unwrap(), b"mine");
    assert!(fs::metadata(folder.join("plate.stl")).unwrap().len() > 84);
    assert!(json(folder.join("report.json")).get("designed").is_none());

    // A failure leaves the old files as they are.
    let before = listing(&folder);
    let failed = run_line(home.path(), "design ring.png -o plate --force --half-field 80 --light 60,0 --no-verify");
    assert_refused(&failed, 4, &["below the plate"]);
    assert_eq!(listing(&folder), before);
    // A folder in the place of one of our files is nothing to replace.
    fs::remove_file(folder.join("relief.png")).unwrap();
    fs::create_dir_all(folder.join("relief.png/precious")).unwrap();
    let refused = run_line(home.path(), &format!("design ring.png -o plate {SMALL} --no-verify --force"));
    assert_refused(&refused, 5, &["relief.png", "is a folder"]);
    assert!(folder.join("relief.png/precious").is_dir());
}

#[test]
fn a_recipe_gives_the_same_bytes_and_flags_override_it() {
    let home = home();
    let flags = "--facets 8x4 --size 20x10.5 --cells 2 --arrange anneal --light 20,45 --light-radius 0.3 --level \
                 --projection equidistant --quantity intensity --seen on-wall --rotate 30 --half-field 12.5 --border 1 \
                 --seed 7 --rays 20000 --sample sobol --invert=false --thickness 3.25 --slope-cap 50";
    // What a person would write: only what differs from the defaults.
    fs::write(home.path().join("mine.toml"), "[design.annealing]\nswaps = 50000\n").unwrap();
    assert_done(&run_line(home.path(), &format!("design ring.png --recipe mine.toml -o a {flags}")));
    assert_done(&run_line(home.path(), "design --recipe a/recipe.toml -o b"));
    assert_same_plate(&home.path().join("a"), &home.path().join("b"), &[]);

    assert_done(&run_line(home.path(), "design --recipe a/recipe.toml -o c --seed 8 --level=false --no-verify"));
    let [a, c] = ["a", "c"].map(|folder| fs::read_to_string(home.path().join(folder).join("recipe.toml")).unwrap());
    assert_eq!(c, a.replace("seed = 7", "seed = 8").replace("level = true", "level = false"));
    assert!(fs::read(home.path().join("a/plate.stl")).unwrap() != fs::read(home.path().join("c/plate.stl")).unwrap());
}

#[test]
fn threads_do_not_change_a_byte() {
    let home = home();
    let annealed =
        "[design]\narrange = 'anneal'\n[design.annealing]\nenergy = 'weyrich2009'\nswaps = 50000\nstarts = 2\n";
    fs::write(home.path().join("mine.toml"), annealed).unwrap();
    // More facets than one exact assignment takes, so that windows are solved side by side.
    for flags in ["--facets 36x36", "--recipe mine.toml --facets 12x9"] {
        for threads in ["1", "2"] {
            let line = format!("design ring.png -o t{threads} --force --threads {threads} --rays 20000 {flags}");
            assert_done(&run_line(home.path(), &line));
        }
        assert_same_plate(&home.path().join("t1"), &home.path().join("t2"), &[]);
    }
}

#[test]
fn json_is_the_report_and_errors_are_json_too() {
    let home = home();
    let done = run_line(home.path(), &format!("design ring.png -o plate {SMALL} --json"));
    assert_done(&done);
    assert_eq!(done.stdout, fs::read_to_string(home.path().join("plate/report.json")).unwrap());
    let done = run_line(home.path(), "verify plate/plate.stl --against ring.png -o proof --rays 20000 --json --quiet");
    assert_done(&done);
    assert_eq!(done.stdout, fs::read_to_string(home.path().join("proof/report.json")).unwrap());
    for (line, code) in [
        ("design ring.png -o q --json --cells 7", 4),
        ("design nothing.png -o q --json", 3),
        ("design ring.png -o plate --json", 5),
        ("design ring.png -o q --json --rays 1", 2),
        ("design ring.png -o q --json --bogus", 2),
    ] {
        let failed = run_line(home.path(), line);
        assert_refused(&failed, code, &[]);
        let said: Value = serde_json::from_str(&failed.stdout).unwrap();
        assert_eq!(said["exit_code"], code, "{line}");
        assert_eq!(format!("facetmill: {}\n", said["error"].as_str().unwrap()), failed.stderr, "{line}");
    }
}

#[test]
fn a_dry_run_needs_no_folder_and_writes_nothing() {
    let home = home();
    let line = "design ring.png --dry-run --size 30x20 --border 2 --facets 30x20 --rays 100000";
    let told = run_line(home.path(), line);
    assert_done(&told);
    assert!(told.stdout.contains("34 × 24 mm") && told.stdout.contains("MB"), "{}", told.stdout);
    let told = run_line(home.path(), &format!("{line} -o plate --json"));
    assert_done(&told);
    assert_eq!(names(home.path()), ["ring.png"]);
    let about: Value = serde_json::from_str(&told.stdout).unwrap();
    assert_eq!(about["plate_mm"], serde_json::json!([34.0, 24.0]));
    assert_done(&run_line(home.path(), &line.replace("--dry-run", "-o plate --no-verify")));
    let bytes = json(home.path().join("plate/report.json"))["stl"]["bytes"].as_f64().unwrap();
    let ratio = about["stl_bytes_about"].as_f64().unwrap() / bytes;
    assert!((0.7..1.3).contains(&ratio), "{ratio}");
    assert_refused(&run_line(home.path(), "design nothing.png --dry-run"), 3, &["nothing.png"]);
}

#[test]
fn verifying_our_own_plate_agrees_with_the_designs_figures() {
    let home = home();
    for (k, flags) in
        ["--arrange random", "--light 25,130 --projection screen --quantity flux --light-radius 0.27 --lobe 0.4"]
            .into_iter()
            .enumerate()
    {
        let rays = "--rays 300000";
        assert_done(&run_line(home.path(), &format!("design ring.png -o d{k} --facets 12x12 {rays} {flags}")));
        let optics = flags.replace("--arrange random", "");
        let line = format!("verify d{k}/plate.stl --against ring.png -o v{k} {rays} {optics}");
        assert_done(&run_line(home.path(), &line));
        assert_eq!(
            names(&home.path().join(format!("v{k}"))),
            ["comparison.png", "report.json", "simulated.png", "target.png"]
        );
        let designed = &json(home.path().join(format!("d{k}/report.json")))["designed"];
        let measured = &json(home.path().join(format!("v{k}/report.json")))["measured"];
        let number = |v: &Value| v.as_f64().unwrap();
        let compare = |pick: &dyn Fn(&Value) -> f64, name: &str| {
            let error = pick(&designed["error"]).hypot(pick(&measured["error"]));
            let (a, b) = (pick(designed), pick(measured));
            // Single precision of the file moves borderline rays; 2e-4 is far below what anyone can see.
            assert!((a - b).abs() < 4.0 * error + 2e-4, "{name}: {a} and {b} ± {error}");
        };
        for key in ["tv", "tv_incident", "ssim"] {
            ["0.5", "1", "2"].iter().for_each(|blur| compare(&|v| number(&v[key][blur]), key));
        }
        ["w1_deg", "efficiency", "multi_bounce", "blocked"].iter().for_each(|key| compare(&|v| number(&v[key]), key));
    }
}

#[test]
fn unusual_names_are_names() {
    let home = home();
    fs::create_dir(home.path().join("mes dessins")).unwrap();
    fs::copy(home.path().join("ring.png"), home.path().join("mes dessins/Кольцо ✨.png")).unwrap();
    let quick = ["--facets", "4x4", "--no-verify"];
    let done =
        run(home.path(), ["design", "mes dessins/Кольцо ✨.png", "-o", "résultat du jour/1"].iter().chain(&quick));
    assert_done(&done);
    assert!(done.stdout.starts_with("Wrote résultat du jour/1"), "{}", done.stdout);
    // The recipe's picture is looked for from the working folder, wherever the recipe is.
    let again = ["design", "--recipe", "résultat du jour/1/recipe.toml", "-o", "-dash", "--no-verify"];
    assert_done(&run(home.path(), again.map(|word| word.replace("-dash", "./-dash"))));
    assert_same_plate(
        &home.path().join("résultat du jour/1"),
        &home.path().join("-dash"),
        &["simulated.png", "comparison.png"],
    );
    fs::create_dir(home.path().join("elsewhere")).unwrap();
    let lost = run(&home.path().join("elsewhere"), ["design", "--recipe", "../-dash/recipe.toml", "-o", "x"]);
    assert_refused(&lost, 3, &["Кольцо"]);
    // A name cannot write to the terminal or break the line.
    assert_refused(&run(home.path(), ["design", "no\n\u{1b}[31msuch.png", "-o", "x"]), 3, &["such.png"]);
}

#[cfg(unix)]
#[test]
fn names_that_are_not_unicode_are_names_too() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    let home = home();
    let (picture, folder) = (OsStr::from_bytes(b"r\xffng.png"), OsStr::from_bytes(b"f\xfelder"));
    if let Err(error) = fs::copy(home.path().join("ring.png"), home.path().join(picture)) {
        eprintln!("skipped: this file system takes no such names ({error})");
        return;
    }
    let [design, o, facets, four, no_verify] = ["design", "-o", "--facets", "4x4", "--no-verify"].map(OsStr::new);
    assert_done(&run(home.path(), [design, picture, o, folder, facets, four, no_verify]));
    // The recipe cannot hold the name, and says nothing wrong instead.
    let recipe = home.path().join(folder).join("recipe.toml");
    let again = [design, OsStr::new("--recipe"), recipe.as_os_str(), o, OsStr::new("again"), no_verify];
    assert_refused(&run(home.path(), again), 3, &["names no picture"]);
    assert_done(&run(home.path(), again.iter().chain(&[picture])));
    let plate = |folder: &OsStr| fs::read(home.path().join(folder).join("plate.stl")).unwrap();
    assert!(plate(folder) == plate(OsStr::new("again")));
}

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

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let home = home();
    for line in ["--help", "design --help", "design ring.png --dry-run", "design ring.png --dry-run --json"] {
        let mut child = facetmill().current_dir(home.path()).args(line.split(' ')).spawn().unwrap();
        drop(child.stdout.take());
        let outcome = finish(child);
        assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{line}");
    }
    if let Ok(full) = fs::OpenOptions::new().write(true).open("/dev/full") {
        let mut command = facetmill();
        command.current_dir(home.path()).args(["design", "ring.png", "--dry-run"]).stdout(Stdio::from(full));
        assert_refused(&finish(command.spawn().unwrap()), 5, &["standard output"]);
    }
}

#[test]
fn help_names_every_flag_of_the_contract() {
    let home = home();
    let told = run_line(home.path(), "design --help");
    assert_done(&told);
    for flag in
        "half-field projection quantity seen light light-radius lobe size facets cells thickness border surface grid \
                 for-cutter min-feature max-triangles levelling max-depth snapshots resume \
                 invert rotate fit sample arrange method level recipe seed threads force json quiet no-verify dry-run"
            .split_whitespace()
    {
        assert!(told.stdout.contains(&format!("--{flag}")), "{flag}");
    }
    let told = run_line(home.path(), "verify -h");
    assert_done(&told);
    assert!(told.stdout.contains("--against <PICTURE>") && told.stdout.contains("--rays"));
    let told = run_line(home.path(), "--version");
    assert_eq!(told.stdout, concat!("facetmill ", env!("CARGO_PKG_VERSION"), "\n"));
    let told = run_line(home.path(), "");
    assert_eq!(told.code, Some(2));
    assert!(told.stderr.contains("design") && told.stderr.contains("Usage"));
}

#[test]
fn a_continuous_plate_is_the_same_with_any_threads_and_tells_what_a_cutter_leaves() {
    let home = home();
    let small = "--surface continuous --grid 64 --cells 2 --size 20x20 --rays 20000 --for-cutter ball:0.5";
    for threads in [1, 2] {
        let line = format!("design ring.png -o plate{threads} --threads {threads} {small}");
        assert_done(&run_line(home.path(), &line));
    }
    let [one, two] = ["plate1", "plate2"].map(|name| home.path().join(name));
    assert_eq!(names(&one), ALL_FILES);
    assert_same_plate(&one, &two, &[]);
    let report = json(one.join("report.json"));
    // Two triangles a square, and a base.
    assert!(report["stl"]["triangles"].as_u64().unwrap() > 2 * 128 * 128, "{}", report["stl"]);
    assert!(report["design"]["valleys"].is_null());
    assert_eq!(report["design"]["continuous"]["grid"], 64);
    let [designed, milled] = ["designed", "as_milled"].map(|key| report[key]["tv_incident"]["1"].as_f64().unwrap());
    assert!(designed < 0.05 && milled < 0.1, "{designed} {milled}");
    assert_eq!(report["designed"]["multi_bounce"], 0.0);

    let dry = run_line(home.path(), &format!("design ring.png --dry-run --json {small}"));
    let facts: Value = serde_json::from_str(&dry.stdout).unwrap();
    let about = facts["stl_triangles_about"].as_f64().unwrap();
    assert!((about / report["stl"]["triangles"].as_f64().unwrap() - 1.0).abs() < 0.1, "{facts}");

    for (flags, code, parts) in [
        ("--grid 63", 4, ["--grid 64", "63"]),
        ("--for-cutter drill:3", 2, ["drill:3", "ball:0.5"]),
        ("--for-cutter ball:90", 4, ["90", "cell"]),
        ("--max-triangles 100", 2, ["--max-triangles", "100"]),
    ] {
        let line = format!("design ring.png -o none --surface continuous {flags}");
        assert_refused(&run_line(home.path(), &line), code, &parts);
        assert!(!home.path().join("none").exists());
    }
}

/// A continuous design that takes a moment.
const SHEET: &str = "--surface continuous --grid 64 --cells 2 --size 20x20 --no-verify";

#[test]
fn a_design_resumed_from_its_snapshots_ends_in_the_same_bytes() {
    let home = home();
    assert_done(&run_line(home.path(), &format!("design ring.png -o whole {SHEET}")));
    assert_done(&run_line(home.path(), &format!("design ring.png -o kept {SHEET} --snapshots")));
    let stl = |name: &str| fs::read(home.path().join(name).join("plate.stl")).unwrap();
    assert!(stl("whole") == stl("kept"));
    let kept = names(&home.path().join("kept/snapshots"));
    assert_eq!(kept.last().unwrap(), "state");
    assert!(kept.len() > 4 && kept[0] == "01-tries.png" && kept[1] == "02-matching.png", "{kept:?}");
    let picture = image::open(home.path().join("kept/snapshots").join(&kept[kept.len() - 2])).unwrap().into_luma8();
    assert_eq!(picture.dimensions(), (256, 256));
    // The ring is lit, its middle is not.
    assert!(picture.get_pixel(192, 128).0[0] > 150 && picture.get_pixel(128, 128).0[0] < 60);

    // Stopped at once after some step, as by a second Ctrl-C: only snapshots are left, and they are enough.
    let snapshots = home.path().join("stopped/snapshots");
    for wait in 0..2 {
        let line = format!("design ring.png -o stopped {SHEET} {}", if wait == 0 { "--snapshots" } else { "--resume" });
        let mut child = facetmill().current_dir(home.path()).args(line.split(' ')).spawn().unwrap();
        let seen = ["02-matching.png", "04-descent.png"][wait];
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
    let mut other = program::ring();
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
    assert_refused(&run_line(home.path(), "design ring.png -o flat --snapshots"), 2, &["--snapshots", "continuous"]);
}

#[test]
fn depth_and_levelling_are_obeyed_or_refused() {
    let home = home();
    let free = run_line(home.path(), &format!("design ring.png -o free {SHEET} --json"));
    let depth = |outcome: &Outcome| {
        let report: Value = serde_json::from_str(&outcome.stdout).unwrap();
        report["design"]["continuous"]["depth_mm"].as_f64().unwrap()
    };
    let allowed = 0.6 * depth(&free);
    let shallow = run_line(home.path(), &format!("design ring.png -o shallow {SHEET} --json --max-depth {allowed}"));
    assert_done(&shallow);
    assert!(depth(&shallow) <= 1.02 * allowed, "{} {allowed}", depth(&shallow));
    let line = format!("design ring.png -o none {SHEET} --levelling 2.5");
    assert_refused(&run_line(home.path(), &line), 4, &["--levelling", "quarter"]);
    for flag in ["--levelling -1", "--max-depth 0", "--max-depth -3"] {
        let line = format!("design ring.png -o none {SHEET} {flag}");
        assert_refused(&run_line(home.path(), &line), 2, &[flag.split(' ').next().unwrap()]);
    }
    assert!(!home.path().join("none").exists());
    assert_done(&run_line(home.path(), &format!("design ring.png -o levelled {SHEET} --levelling 0.1")));
    let stl = |name: &str| fs::read(home.path().join(name).join("plate.stl")).unwrap();
    assert!(stl("free") != stl("levelled"));
}

#[cfg(unix)]
#[test]
fn ctrl_c_finishes_a_continuous_design_and_twice_stops_it() {
    let home = home();
    let big = "--surface continuous --grid 512 --cells 1 --size 10x10 --rays 20000";
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
