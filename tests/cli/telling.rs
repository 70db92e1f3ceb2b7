//! What the program says: reports, estimates, help, errors.

use std::fs;
use std::process::Stdio;

use serde_json::Value;

use super::measure::floats;
use super::program::{facetmill, finish, home, run_line};
use super::{SMALL, assert_done, assert_refused, json, names};

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
        ("design ring.png -o q --json --surface flat --cells 7", 4),
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

    // What a cutter cannot keep dark is known beforehand: least_stray of a design says the same.
    image::GrayImage::from_fn(48, 48, |x, _| image::Luma([if (8..40).contains(&x) { 0 } else { 255 }]))
        .save(home.path().join("bars.png"))
        .unwrap();
    let line = "design bars.png --size 9x9 --grid 32 --for-cutter ball:1";
    let told = run_line(home.path(), &format!("{line} --dry-run"));
    assert_done(&told);
    assert!(told.stdout.contains("straying"), "{}", told.stdout);
    let about: Value =
        serde_json::from_str(&run_line(home.path(), &format!("{line} --dry-run --json")).stdout).unwrap();
    assert_done(&run_line(home.path(), &format!("{line} -o bars --no-verify")));
    let made = json(home.path().join("bars/report.json"));
    assert!(about["least_stray_share"].as_f64().unwrap() > 0.01, "{about}");
    assert_eq!(about["least_stray_share"], made["design"]["continuous"]["least_stray"]["share"]);
    let lost = run_line(home.path(), "design ring.png --for-cutter ball:1 --dry-run --half-field 80 --light 60,0");
    assert_refused(&lost, 4, &["below the plate"]);
}

#[test]
fn a_rim_counts_as_it_is_finished_and_the_shop_is_told() {
    let home = home();
    let plate = |finish: &str| {
        let line = "design ring.png --size 30x30 --facets 10x10 --projection screen --rays 40000 --border 3";
        let done = run_line(home.path(), &format!("{line} -o {finish} --border-finish {finish}"));
        assert_done(&done);
        let report = json(home.path().join(finish).join("report.json"));
        (report["rim"].clone(), report["designed"]["tv_incident"]["1"].as_f64().unwrap(), done.stdout)
    };
    let (matt, tv, said) = plate("matt");
    let share = matt["into_picture_if_polished"].as_f64().unwrap();
    // 36 x 36 mm without 30 x 30.
    assert!((share - 0.44).abs() < 0.01 && matt["into_picture"] == 0.0, "{matt}");
    assert!(said.contains("Leave the rim of 3 mm dull"), "{said}");
    let sidecar = json(home.path().join("matt/heightmap.json"));
    assert!(sidecar["rim"].as_str().unwrap().contains("left dull"), "{sidecar}");
    let (polished, bright, said) = plate("polished");
    assert_eq!(polished["into_picture"], polished["into_picture_if_polished"]);
    assert!((bright - tv - share).abs() < 0.03 && said.contains("--border-finish matt"), "{bright} {tv} {said}");
    assert!(
        fs::read(home.path().join("matt/plate.stl")).unwrap()
            == fs::read(home.path().join("polished/plate.stl")).unwrap()
    );
    let (sloped, tv_sloped, _) = plate("sloped");
    assert!(sloped["into_picture"].as_f64().unwrap() < 0.002 && sloped["slope_deg"].as_f64().unwrap() > 10.0);
    assert!((tv_sloped - tv).abs() < 0.01, "{tv_sloped} {tv}");
    // A proof of the file says the same of its margin, and light on the plate as it lies leaves a dull rim out.
    assert_done(&run_line(
        home.path(),
        "verify matt/plate.stl --against ring.png -o v --margin 3 --projection screen --rays 40000",
    ));
    let told = json(home.path().join("v/report.json"));
    assert!((told["margin_into_picture_if_polished"].as_f64().unwrap() - share).abs() < 0.01, "{told}");
    assert_done(&run_line(home.path(), "measure matt -o m --rays 40000"));
    assert_done(&run_line(home.path(), "measure polished -o n --rays 40000"));
    let brightest = |folder: &str| {
        let light = floats(home.path().join(folder).join("highlight.tiff"), 256);
        light.into_iter().fold(0.0, f64::max)
    };
    // What a flat rim mirrors falls on few pixels in the middle.
    assert!(brightest("n") > 0.1 && brightest("m") < 0.01, "{} {}", brightest("m"), brightest("n"));
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
            ["0.27", "0.5", "1", "2"].iter().for_each(|blur| compare(&|v| number(&v[key][blur]), key));
        }
        ["w1_deg", "efficiency", "multi_bounce", "blocked"].iter().for_each(|key| compare(&|v| number(&v[key]), key));
    }
}

#[test]
fn a_verdict_comes_first_then_five_lines_and_the_rest_on_request() {
    let home = home();
    let line = "design ring.png -o plate --facets 12x12 --size 10x10 --rays 20000 --for-cutter ball:0.3";
    let told = run_line(home.path(), line);
    assert_done(&told);
    let lines: Vec<&str> = told.stdout.lines().collect();
    assert!(lines[0].starts_with("Cut by ball:0.3, ") && lines[0].contains("% of the light falls"), "{}", told.stdout);
    let figures =
        lines.iter().filter(|line| line.starts_with("  ") && !line.starts_with("   ") && !line.contains("Note"));
    let names: Vec<&str> = figures.map(|line| line.split_whitespace().next().unwrap()).collect();
    assert_eq!(names, ["plate", "stock", "light", "file", "look"]);
    assert!(told.told().contains("look at plate/comparison_milled.png first"), "{}", told.stdout);
    assert!(lines.iter().all(|line| line.chars().count() <= 80), "{}", told.stdout);
    assert_eq!(json(home.path().join("plate/report.json"))["verdict"], told.told().split(" plate ").next().unwrap());
    let all = run_line(home.path(), &format!("{line} --force --verbose"));
    assert!(all.told().starts_with(told.told().split(" Note:").next().unwrap()) && all.stdout.contains("shift (W1)"));
    assert!(!told.stdout.contains("shift (W1)"));

    let told = run_line(home.path(), "verify plate/plate.stl --against ring.png -o proof --rays 20000");
    assert_done(&told);
    assert!(told.stdout.starts_with("On plate.stl, ") && told.told().contains("at proof/comparison.png first"));
    let bare = run_line(home.path(), "design ring.png -o bare --facets 8x8 --no-verify");
    assert!(bare.stdout.starts_with("Designed; no light was sent") && bare.told().contains("at bare/relief.png first"));
}

#[test]
fn a_run_into_a_pipe_says_a_line_for_each_stage_unless_a_machine_reads() {
    let home = home();
    let line = format!("design ring.png -o plate {SMALL} --force");
    let told = run_line(home.path(), &line);
    assert_done(&told);
    let first = ["reading slopes off the highlight", "drawing facets", "arranging facets", "raising facets"];
    assert_eq!(told.stages[..4], first, "{told:?}");
    assert_eq!(told.stages.last().unwrap(), "writing files");
    for silent in ["--quiet", "--json"] {
        assert_eq!(run_line(home.path(), &format!("{line} {silent}")).stages, [""; 0], "{silent}");
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
    let told = run_line(home.path(), "design --help-all");
    assert_done(&told);
    for flag in
        "half-field projection quantity seen light light-radius lobe size facets cells thickness border border-finish surface grid \
                 for-cutter min-feature max-triangles polish max-depth snapshots resume \
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
    // Its indented lines are taken for stages.
    assert!(told.stderr.contains("Usage") && told.stages.iter().any(|line| line.starts_with("design ")), "{told:?}");
}
