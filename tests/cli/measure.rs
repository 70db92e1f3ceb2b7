//! `facetmill measure` as a whole, from the command line to the files: each of its five ways.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use image::{GrayImage, Luma};
use serde_json::Value;
use tempfile::TempDir;
use tiff::decoder::{Decoder, DecodingResult};

use super::program::{Outcome, home, listing, run_line};

/// Each way on few rays, and the files that it writes beside report.json, sorted.
const WAYS: [(&str, &[&str]); 5] = [
    (
        "--resolution 32 --rays 5000 --material aluminium:ggx:0.1",
        &["highlight.png", "highlight.tiff", "highlight_error.tiff"],
    ),
    (BRDF, &["brdf.binary", "brdf.bsdf", "brdf.csv", "maps.png", "slices.png"]),
    ("--ndf --rays 2000 --resolution 64", &["masking.csv", "ndf.csv", "ndf.png"]),
    ("--wall 1000 --rays 5000 --resolution 32", &["wall.png", "wall.tiff", "wall_error.tiff"]),
    (LOOK, &["look.png", "look.tiff", "look_error.tiff"]),
];

const BRDF: &str = "--brdf --polar 3 --azimuths 4 --half-vectors 16x8 --rays 2000 --material brass:ggx:0.2";
const LOOK: &str = "--look --resolution 24 --rays 10000 --material aluminium:ggx:0.1";

/// A folder with `ring`, a design of 12 x 12 facets on 30 x 30 mm, and its plate alone as `plain.stl`.
fn designed() -> TempDir {
    /// Designed once: what `measure` reads of it.
    static DESIGN: LazyLock<[(&str, Vec<u8>); 3]> = LazyLock::new(|| {
        let home = home();
        assert_done(&run_line(home.path(), "design ring.png -o ring --facets 12x12 --no-verify"));
        ["plate.stl", "recipe.toml", "report.json"]
            .map(|name| (name, fs::read(home.path().join("ring").join(name)).unwrap()))
    });
    let home = home();
    fs::create_dir(home.path().join("ring")).unwrap();
    for (name, bytes) in &*DESIGN {
        fs::write(home.path().join("ring").join(name), bytes).unwrap();
    }
    fs::write(home.path().join("plain.stl"), &DESIGN[0].1).unwrap();
    home
}

fn names(folder: &Path) -> Vec<String> {
    listing(folder).iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect()
}

fn report(folder: impl AsRef<Path>) -> Value {
    serde_json::from_slice(&fs::read(folder.as_ref().join("report.json")).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn assert_near(value: &Value, wanted: f64, tolerance: f64) {
    assert!((number(value) - wanted).abs() <= tolerance, "{value} is not {wanted} ± {tolerance}");
}

fn assert_done(outcome: &Outcome) {
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
}

fn assert_refused(outcome: &Outcome, code: i32, parts: &[&str]) {
    assert_eq!(outcome.code, Some(code), "{outcome:?}");
    assert!(outcome.stderr.starts_with("facetmill: ") && outcome.stderr.lines().count() == 1, "{outcome:?}");
    assert!(parts.iter().all(|part| outcome.stderr.contains(part)), "{parts:?} in {outcome:?}");
}

/// The numbers of a square float TIFF, by a reader that is not ours.
pub fn floats(path: impl AsRef<Path>, side: u32) -> Vec<f64> {
    let mut decoder = Decoder::new(fs::File::open(path).unwrap()).unwrap();
    assert_eq!(decoder.dimensions().unwrap(), (side, side));
    match decoder.read_image().unwrap() {
        DecodingResult::F32(values) => {
            assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0));
            values.into_iter().map(f64::from).collect()
        }
        _ => panic!("not 32-bit floats"),
    }
}

fn measured(home: &Path, line: &str) -> Value {
    assert_done(&run_line(home, &format!("measure {line} --quiet")));
    let folder = line.split_whitespace().skip_while(|word| *word != "-o").nth(1).unwrap();
    report(home.join(folder))["measured"].take()
}

#[test]
fn rays_of_a_look_are_for_each_pixel_and_one_is_enough() {
    let home = designed();
    let line = |rays: u64| format!("ring -o look{rays} --look --light-radius 2 --resolution 16 --rays {rays}");
    // From as many as there are pixels on, the number is that of all of them together, as it always was.
    for (rays, each) in [(1, 1.0), (64, 64.0), (255, 255.0), (25_600, 100.0)] {
        assert_eq!(number(&measured(home.path(), &line(rays))["paths_a_pixel"]), each, "{rays}");
    }
    let refused = run_line(home.path(), "measure ring -o none --look --light-radius 2 --rays 0");
    assert_refused(&refused, 2, &["--rays is 0", "from 1"]);
}

#[test]
fn each_way_leaves_the_files_it_says_for_a_design_and_for_a_plain_stl() {
    let home = designed();
    for (k, (flags, files)) in WAYS.iter().enumerate() {
        for plate in ["ring", "plain.stl"] {
            let done = run_line(home.path(), &format!("measure {plate} -o {plate}{k}/deep {flags}"));
            assert_done(&done);
            let folder = home.path().join(format!("{plate}{k}/deep"));
            let mut wanted: Vec<&str> = files.iter().copied().chain(["report.json"]).collect();
            wanted.sort_unstable();
            assert_eq!(names(&folder), wanted, "{flags}");
            let title = format!("Wrote {plate}{k}/deep; look at ");
            assert!(done.stdout.starts_with(&title) && done.stdout.contains(" first\n"), "{}", done.stdout);
            assert!(done.stdout.lines().all(|line| line.chars().count() <= 80), "{}", done.stdout);
            for name in files.iter().filter(|name| name.ends_with(".png")) {
                let picture = image::open(folder.join(name)).unwrap().to_luma8();
                let (low, high) = (picture.pixels().map(|p| p.0[0]).min(), picture.pixels().map(|p| p.0[0]).max());
                assert!(low < Some(100) && high > Some(150), "{name} shows nothing: {low:?} to {high:?}");
            }
            let report = report(&folder);
            for key in ["program", "plate", "extent", "material", "light", "max_bounces", "seed", "measured", "advice"]
            {
                assert!(report.get(key).is_some(), "{key}");
            }
            assert_eq!(report["plate"]["traced_as"], "a plane over each rectangle of a grid");
            assert_eq!(report["plate"]["open_edges"], 0);
            assert_near(&report["plate"]["size_mm"][0], 30.0, 1e-4);
            assert_eq!(report["seed"], 1);
        }
        // A folder lends its plate only lamp and field, which here are the defaults.
        for name in files.iter().filter(|name| !name.ends_with(".png") && !name.ends_with(".bsdf")) {
            let [a, b] =
                ["ring", "plain.stl"].map(|p| fs::read(home.path().join(format!("{p}{k}/deep/{name}"))).unwrap());
            assert!(a == b, "{name} differs");
        }
    }
}

#[test]
fn a_highlights_pixels_add_up_to_what_the_report_says() {
    let home = designed();
    let facts = measured(home.path(), "ring -o a --half-field 10 --rays 20000 --resolution 48 --material gold:ggx:0.1");
    assert_eq!(facts["kind"], "highlight");
    let shares = &facts["shares_of_incident"];
    let [up, single, multi, outside, taken] =
        ["up", "up_single", "up_multi", "outside_image", "taken"].map(|key| number(&shares[key]));
    assert!((up - single - multi).abs() < 1e-12 && up < 1.0 && taken > 0.02 && outside > 0.1 && outside < up);
    assert_near(&facts["balance"], 1.0, 1e-9);
    let image = floats(home.path().join("a/highlight.tiff"), 48);
    assert!((image.iter().sum::<f64>() - (up - outside) / up).abs() < 1e-5);
    let errors = floats(home.path().join("a/highlight_error.tiff"), 48);
    let noise = 0.5 * (2.0 / std::f64::consts::PI).sqrt() * errors.iter().sum::<f64>();
    assert_near(&facts["image_noise_tv"], noise, 1e-6 + 1e-5 * noise);
    for (key, share) in shares.as_object().unwrap() {
        let error = number(&facts["standard_errors"][key]);
        assert!((0.0..0.05).contains(&error) && (0.0..=1.0).contains(&number(share)), "{key}");
    }
    assert_eq!((&facts["resolution"], &facts["half_field"]), (&48.into(), &10.0.into()));
}

#[test]
fn a_mirror_panel_reflects_all_light_from_every_side() {
    let home = designed();
    let facts = measured(home.path(), "ring -o a --brdf --polar 4 --azimuths 1 --half-vectors 24x12 --rays 5000");
    assert_eq!(
        (&facts["kind"], &facts["rays_each"], &facts["half_vectors"]),
        (&"brdf".into(), &5000.into(), &serde_json::json!([24, 12]))
    );
    assert!(number(&facts["least"]) >= 0.0, "{}", facts["least"]);
    let (albedo, error) = (number(&facts["greatest_albedo"]), number(&facts["greatest_albedo_error"]));
    assert!(albedo > 0.9 && albedo <= 1.0 + 3.0 * error + 1e-6, "{albedo} ± {error}");
    let directions = facts["directions"].as_array().unwrap();
    assert_eq!(directions.len(), 4);
    for ends in directions {
        let all: f64 = ["albedo", "taken", "trapped", "past_edges"].iter().map(|key| number(&ends[key])).sum();
        // A panel has no edges; what closed forms send down at grazing light, rays take back but for their noise.
        assert!((all - 1.0).abs() < 1e-9 && number(&ends["past_edges"]).abs() < 1e-3, "{ends:#}");
    }
    assert_eq!(
        (&directions[0]["theta_deg"], report(home.path().join("a"))["extent"].as_str()),
        (&0.0.into(), Some("endless"))
    );
    // Light from one azimuth only: MERL holds such a table, and a plate with an edge loses light past it.
    assert!(home.path().join("a/brdf.binary").exists());
    let csv = fs::read_to_string(home.path().join("a/brdf.csv")).unwrap();
    assert!(csv.lines().any(|line| line == "theta_i,phi_i,theta_o,phi_o,brdf,error") && csv.lines().count() > 50);
}

#[test]
fn a_brushed_plate_is_not_written_as_merl() {
    let home = designed();
    measured(home.path(), &format!("ring -o a {BRDF} --force").replace("brass:ggx:0.2", "brass:ggx:0.05,0.5"));
    assert!(!home.path().join("a/brdf.binary").exists());
    let advice = report(home.path().join("a"))["advice"].take();
    assert!(advice[0].as_str().unwrap().contains("No brdf.binary was written"), "{advice}");
}

#[test]
fn normals_of_a_plate_have_the_slopes_of_its_design() {
    let home = designed();
    let facts = measured(home.path(), "ring -o a --ndf --rays 2000");
    let [p, q] = [0, 1].map(|axis| number(&facts["rms_slope"][axis]));
    // The ring lies 0.35 to 0.65 of sin 20° from the middle: slopes are about half of that.
    assert!((0.03..0.12).contains(&p) && (p / q - 1.0).abs() < 0.1, "{p}, {q}");
    assert_near(&facts["beckmann_alpha"][0], p * 2f64.sqrt(), 1e-12);
    assert!((0.0..0.02).contains(&number(&facts["excess_area"])));
    let seen = ["0", "30", "60", "80"].map(|angle| number(&facts["seen_at_deg"][angle]));
    assert!(seen.is_sorted_by(|a, b| a >= b) && seen[0] > 0.99 && seen[3] > 0.5, "{seen:?}");
    let csv = fs::read_to_string(home.path().join("a/masking.csv")).unwrap();
    assert!(csv.contains("theta,phi,seen,error,endless,both\n"));
}

#[test]
fn a_wall_is_blurred_by_closed_forms_and_its_pixels_add_up() {
    let home = designed();
    let near = "--wall 1000 --lamp-distance 1500 --lamp-radius 5 --rays 20000 --resolution 40";
    let facts = measured(home.path(), &format!("ring -o near {near}"));
    for axis in [0, 1] {
        assert_near(&facts["blur_by_plate_mm"][axis], 30.0 * (1.0 + 1000.0 / 1500.0), 1e-3);
        assert_near(&facts["blur_by_lamp_mm"][axis], 2000.0 * (5f64 / 1500.0).asin().tan(), 1e-6);
        assert_near(&facts["blur_by_plate_deg"][axis], 2.0 * 0.025f64.atan().to_degrees(), 1e-5);
    }
    assert_near(&facts["blur_by_lamp_deg"], 2.0 * (5f64 / 1500.0).asin().to_degrees(), 1e-9);
    assert_near(&facts["in_picture"], 1.0, 1e-9);

    let far = "--wall 400 --light-radius 0.5 --wall-width 160 --rays 40000 --resolution 40 --seen on-wall";
    let facts = measured(home.path(), &format!("ring -o far {far}"));
    assert_near(&facts["blur_by_plate_mm"][0], 30.0, 1e-4);
    assert_near(&facts["blur_by_lamp_mm"][1], 800.0 * 0.5f64.to_radians().tan(), 1e-6);
    assert_eq!((&facts["mirrored"], &facts["width_mm"]), (&true.into(), &160.0.into()));
    assert!(facts["lamp_distance_mm"].is_null());
    let (landed, error) = (number(&facts["in_picture"]), number(&facts["in_picture_error"]));
    assert!(landed > 0.1 && landed < 0.9, "{landed}");
    assert_near(&facts["beside_picture"], 1.0 - landed, 1e-3);
    // Irradiance as a multiple of that on 900 mm² of plate, over pixels of 4 mm.
    let sum = floats(home.path().join("far/wall.tiff"), 40).iter().sum::<f64>() * 16.0 / 900.0;
    assert!((sum - landed).abs() < 4.0 * error + 0.01 * landed, "{sum} and {landed} ± {error}");
    floats(home.path().join("far/wall_error.tiff"), 40);
}

#[test]
fn a_look_is_in_the_units_it_says() {
    let home = designed();
    // A matt plate under a lamp 60° off: albedo / pi · cos 60°, but for what neighbouring facets add and hide.
    let line = "ring -o flat --look --material diffuse:0.5 --light 60,30 --field 1 --resolution 16 --rays 20000";
    let facts = measured(home.path(), line);
    assert_near(&facts["mean_radiance"], 0.25 / std::f64::consts::PI, 0.02);
    let image = floats(home.path().join("flat/look.tiff"), 16);
    assert_near(&facts["mean_radiance"], image.iter().sum::<f64>() / 256.0, 1e-6);
    assert_near(&facts["greatest_radiance"], image.iter().copied().fold(0.0, f64::max), 1e-6);
    assert_eq!(facts["paths_a_pixel"], 78);
    assert_eq!(facts["shape"], "flat");

    let line = format!("ring -o ball {LOOK} --wrap sphere:40 --ambient 0.25 --light 20,0 --camera 10,90");
    let facts = measured(home.path(), &line);
    assert_eq!(facts["shape"]["sphere_radius_mm"], 40.0);
    // Beside the ball its surroundings.
    assert!((floats(home.path().join("ball/look.tiff"), 24)[0] - 0.25).abs() < 1e-6);
    assert_eq!(report(home.path().join("ball"))["extent"], "endless");

    // A mirror shows its surroundings alone, and the report says why.
    measured(home.path(), "ring -o mirror --look --resolution 16 --rays 1000 --ambient 0.25");
    let advice = report(home.path().join("mirror"))["advice"].take();
    assert!(advice[0].as_str().unwrap().contains("--light-radius"), "{advice}");
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_threads_and_json_is_the_report() {
    let home = designed();
    for (k, (flags, _)) in WAYS.iter().enumerate() {
        for (name, more) in [("one", "--threads 1"), ("two", "--threads 2"), ("other", "--seed 7")] {
            let done = run_line(home.path(), &format!("measure ring -o {name}{k} {flags} {more} --json"));
            assert_done(&done);
            let folder = home.path().join(format!("{name}{k}"));
            assert_eq!(done.stdout, fs::read_to_string(folder.join("report.json")).unwrap());
        }
        let [one, two, other] = ["one", "two", "other"].map(|name| {
            let files = listing(&home.path().join(format!("{name}{k}")));
            files.iter().map(|file| fs::read(file).unwrap()).collect::<Vec<_>>()
        });
        assert!(one == two, "{flags}");
        assert!(one != other, "{flags}");
    }
}

#[test]
fn a_measurement_goes_on_until_its_error_is_reached() {
    let home = designed();
    for (way, rays) in [("--half-field 20", 1000), ("--wall 1000", 1000)] {
        let line = format!("ring --material aluminium:ggx:0.1 --resolution 16 --rays {rays} {way}");
        let rough = measured(home.path(), &format!("{line} -o rough --force"));
        let fine = measured(home.path(), &format!("{line} -o fine --force --error 0.02"));
        assert!(number(&rough["image_noise_tv"]) > 0.04, "{rough}");
        assert!(number(&fine["image_noise_tv"]) <= 0.02, "{fine}");
        let more = number(&fine["rays"]) / number(&rough["rays"]);
        assert!(more > 3.0 && more < 300.0, "{more}");
    }
}

#[test]
fn rounds_until_an_error_leave_the_units_alone() {
    let home = designed();
    let line = "--wall 1000 --material aluminium:ggx:0.1 --resolution 16 --wall-width 1600";
    let facts = measured(home.path(), &format!("ring -o a {line} --rays 1000 --error 0.02"));
    assert!(number(&facts["rays"]) > 3000.0, "{facts}");
    let sum = floats(home.path().join("a/wall.tiff"), 16).iter().sum::<f64>() * 1e4 / 900.0;
    // Incident light is the plate's 900 mm², found by rays, of which some pass it by.
    assert_near(&facts["in_picture"], sum, 0.03);
}

#[test]
fn a_designs_folder_supplies_lamp_field_and_mount() {
    let home = home();
    let optics = "--light 20,90 --light-radius 0.3 --lobe 0.4 --half-field 12 --projection screen";
    let design = format!("design ring.png -o sun --facets 12x12 --no-verify --seed 5 --rays 3000 {optics}");
    assert_done(&run_line(home.path(), &design));
    let small = "--rays 20000 --resolution 32";
    let facts = measured(home.path(), &format!("sun -o a {small}"));
    let whole = report(home.path().join("a"));
    assert_eq!(whole["light"], serde_json::json!({ "theta": 20.0, "phi": 90.0, "radius": 0.3 }));
    assert_eq!(
        (&facts["half_field"], &facts["projection"], &whole["seed"]),
        (&12.0.into(), &"screen".into(), &1.into())
    );
    measured(home.path(), &format!("sun/plate.stl -o b {small} {optics}"));
    let tiff = |folder: &str| fs::read(home.path().join(folder).join("highlight.tiff")).unwrap();
    assert!(tiff("a") == tiff("b"));
    // Flags override the recipe; its rays and seed were those of the design.
    assert_eq!(measured(home.path(), &format!("sun -o c {small} --half-field 30"))["half_field"], 30.0);
    let usual = measured(home.path(), "sun -o d --resolution 16 --material diffuse:0");
    assert!(number(&usual["rays"]) > 1e6, "{usual}");

    // Light in one corner: polished, the plate throws it there only as mounted.
    let corner = GrayImage::from_fn(32, 32, |x, y| Luma([if x > 22 && y < 10 { 255 } else { 0 }]));
    corner.save(home.path().join("corner.png")).unwrap();
    assert_done(&run_line(home.path(), "design corner.png -o level --facets 12x12 --no-verify --level"));
    let centroid = |folder: &str| {
        let image = floats(home.path().join(folder).join("highlight.tiff"), 32);
        let sum: f64 = image.iter().sum();
        let mean = |at: &dyn Fn(usize) -> f64| image.iter().enumerate().map(|(k, v)| v * at(k)).sum::<f64>() / sum;
        (mean(&|k| (k % 32) as f64), mean(&|k| (k / 32) as f64))
    };
    measured(home.path(), &format!("level -o mounted {small}"));
    measured(home.path(), &format!("level/plate.stl -o flat {small}"));
    let ((x, y), (u, v)) = (centroid("mounted"), centroid("flat"));
    assert!(x > 23.0 && y < 9.0, "{x}, {y}");
    assert!((u - 15.5).abs() < 1.5 && (v - 15.5).abs() < 1.5, "{u}, {v}");
}

#[test]
fn force_replaces_every_earlier_measurement_and_nothing_else() {
    let home = designed();
    let folder = home.path().join("out");
    for (flags, _) in WAYS {
        assert_done(&run_line(home.path(), &format!("measure ring -o out --force --quiet {flags}")));
        fs::write(folder.join("notes.txt"), "mine").unwrap();
    }
    assert_eq!(names(&folder), ["look.png", "look.tiff", "look_error.tiff", "notes.txt", "report.json"]);
    let before = fs::read(folder.join("report.json")).unwrap();
    let small = "--resolution 16 --rays 1000";
    assert_refused(&run_line(home.path(), &format!("measure ring -o out {small}")), 5, &["out", "--force"]);
    // Refused late, after the plate was read.
    assert_refused(&run_line(home.path(), "measure ring -o out --force --look"), 4, &["--light-radius", "--material"]);
    // So is what cuts the plate.
    for (flags, name) in [
        ("--look --material diffuse:1 --distance 0.001", "--distance"),
        ("--wall 0.01", "--wall"),
        ("--wall 1000 --lamp-distance 0.001", "--lamp-distance"),
    ] {
        assert_refused(&run_line(home.path(), &format!("measure ring -o out --force {flags}")), 4, &[name]);
    }
    assert_eq!(fs::read(folder.join("report.json")).unwrap(), before);
    // The design's own report is not to be lost.
    let all = listing(home.path());
    for plate in ["ring", "ring/plate.stl", "./ring/../ring"] {
        let line = format!("measure {plate} -o ring --force {small}");
        assert_refused(&run_line(home.path(), &line), 2, &["-o", "report.json", "another folder"]);
    }
    assert_eq!(listing(home.path()), all);
    let failed = run_line(home.path(), "measure ring -o q --json --look");
    assert_refused(&failed, 4, &["--light-radius"]);
    let said: Value = serde_json::from_str(&failed.stdout).unwrap();
    assert_eq!(said["exit_code"], 4);
}
