//! `measure` under flags that mean nothing or too much, and of plates that are none.

use std::fs;

use super::plates::{block, moved, stl};
use super::{Trials, words};
use crate::program::{run, run_line};

/// Flags that take a number, whatever goes with them, and which of `NUMBERS` do.
const NUMERIC: &[(&str, &str, &[&str])] = &[
    ("--margin", "", &["0", "1e-300"]),
    ("--light-radius", "", &["0", "1e-300"]),
    ("--lobe", "", &["0", "1e-300"]),
    ("--lamp-half-field", "--lamp ring.png", &[]),
    ("--half-field", "", &[]),
    ("--resolution", "", &[]),
    ("--polar", "--brdf", &[]),
    ("--azimuths", "--brdf", &[]),
    ("--wall", "", &[]),
    ("--lamp-distance", "--wall 1000", &[]),
    ("--lamp-radius", "--wall 1000 --lamp-distance 900", &["0"]),
    ("--wall-tilt", "--wall 1000", &["0", "-1", "1e-300"]),
    ("--wall-width", "--wall 1000", &[]),
    ("--distance", "--look --material diffuse:1", &[]),
    ("--field", "--look --material diffuse:1", &[]),
    ("--ambient", "--look --material diffuse:1", &["0", "1e-300"]),
    ("--error", "", &[]),
    ("--max-bounces", "", &[]),
    ("--rays", "", &[]),
    ("--seed", "", &["0"]),
    ("--threads", "", &[]),
];

const NUMBERS: [&str; 8] = ["nan", "inf", "-1", "1e300", "1e-300", "0", "", "99999999999999999999999"];

/// Flags, exit code, what the sentence must name.
const FLAGS: &[(&str, i32, &str)] = &[
    ("--brdf --ndf", 2, "--ndf"),
    ("--wall 1000 --look", 2, "--look"),
    ("--material goldd", 2, "goldd"),
    ("--material ''", 2, "--material"),
    ("--material ggx:9", 2, "--material"),
    ("--material aluminium:ggx:9", 2, "--material"),
    ("--material aluminium:ggx:nan", 2, "--material"),
    ("--material aluminium:ggx:0", 2, "--material"),
    ("--material aluminium:phong:1", 2, "ggx or beckmann"),
    ("--material diffuse:0.5:ggx:0.1", 2, "paint"),
    ("--material conductor:0,0", 2, "--material"),
    ("--material gold@1e300", 2, "--material"),
    ("--material brass --lobe 1", 2, "--lobe"),
    ("--ndf --lobe 1", 2, "--lobe"),
    ("--lobe 10.5", 2, "--lobe"),
    ("--extent round", 2, "finite, endless"),
    ("--light 90,0", 2, "--light"),
    ("--light nan,0", 2, "--light"),
    ("--light 0,1e300", 2, "--light"),
    ("--light 60,0 --light-radius 30", 2, "--light-radius"),
    ("--lamp missing.png", 3, "missing.png"),
    ("--lamp dark.png", 3, "dark.png"),
    ("--lamp plate.stl", 3, "plate.stl"),
    ("--lamp ring.png --light-radius 1", 2, "--light-radius"),
    ("--lamp-half-field 3", 2, "--lamp"),
    ("--half-field 80 --light 60,0 --projection fish-eye", 2, "orthographic, equidistant, screen"),
    ("--resolution 4097", 2, "--resolution"),
    ("--wall 1000 --resolution 4096", 2, "--resolution"),
    ("--polar 5", 2, "--brdf"),
    ("--brdf --polar 1", 2, "--polar"),
    ("--brdf --azimuths 2", 2, "--azimuths"),
    ("--brdf --half-vectors 0x0", 2, "--half-vectors"),
    ("--brdf --half-vectors 100000x100000", 2, "--half-vectors"),
    ("--brdf --half-vectors 18446744073709551615x18446744073709551615", 2, "--half-vectors"),
    ("--brdf --half-vectors 4294967296x4294967296", 2, "--half-vectors"),
    ("--brdf --half-vectors 8000x7000 --polar 2 --azimuths 1", 2, "--half-vectors"),
    ("--brdf --half-vectors 12", 2, "--half-vectors"),
    ("--brdf --light 30,0", 2, "--light"),
    ("--brdf --resolution 64", 2, "--resolution"),
    ("--ndf --material gold", 2, "--material"),
    ("--ndf --error 0.1", 2, "--error"),
    ("--look --half-field 5", 2, "--half-field"),
    ("--look --error 0.1", 2, "--error"),
    ("--wall-tilt 5", 2, "--wall"),
    ("--wall 1000 --wall-tilt 86", 2, "--wall-tilt"),
    ("--wall 1000 --lamp-radius 5", 2, "--lamp-distance"),
    ("--wall 1000 --lamp-distance 500 --light-radius 1", 2, "--light-radius"),
    ("--wall 1000 --lamp-distance 500 --lamp ring.png", 2, "--lamp"),
    ("--wall 1000 --lamp-distance 10 --lamp-radius 20", 4, "--lamp-distance"),
    ("--wall 2 --light 60,0", 4, "--wall"),
    ("--wall 10 --wall-tilt 80", 4, "--wall-tilt"),
    ("--wall 1e9 --lamp-distance 0.1", 4, "--wall-width"),
    ("--look", 4, "--light-radius"),
    ("--look --material gold", 4, "--material gold:ggx:0.1"),
    ("--look --camera 90,0", 2, "--camera"),
    ("--look --camera nan,0", 2, "--camera"),
    ("--look --camera 0,1e300", 2, "--camera"),
    ("--look --camera 10", 2, "--camera"),
    ("--look --wrap cube:4", 2, "sphere or cylinder"),
    ("--look --wrap sphere", 2, "sphere:40"),
    ("--look --wrap sphere:nan", 2, "--wrap"),
    ("--look --wrap sphere:0", 2, "--wrap"),
    ("--look --wrap cylinder:-4", 2, "--wrap"),
    ("--look --wrap sphere:600 --material diffuse:1", 4, "--distance"),
    ("--look --wrap cylinder:30 --camera 60,90 --distance 50 --material diffuse:1", 4, "--distance"),
    ("--look --wrap sphere:40 --extent finite --material diffuse:1", 4, "--extent"),
    ("--wrap sphere:40", 2, "--look"),
    ("--look --rays 18446744073709551615", 2, "--rays"),
    ("--look --rays 99999999999 --resolution 16 --material diffuse:1", 2, "--rays"),
    ("--rays 18446744073709551615", 2, "--rays"),
    ("--margin 10", 4, "--margin"),
    ("--against ring.png", 2, "--against"),
    ("--spam", 2, "measure --help"),
];

#[test]
fn flags_of_measure_without_meaning_are_named() {
    let mut trials = Trials::new();
    fs::write(trials.home().join("plate.stl"), stl(&block([20.0, 20.0, 5.0]))).unwrap();
    image::GrayImage::new(32, 32).save(trials.home().join("dark.png")).unwrap();
    for (flags, code, name) in FLAGS {
        trials.refused(&[&["measure", "plate.stl", "-o", "out/deep"][..], &words(flags)].concat(), *code, &[name]);
    }
    for (flag, with, fine) in NUMERIC {
        for number in NUMBERS.iter().filter(|number| !fine.contains(number)) {
            let both = [&["measure", "plate.stl", "-o", "out"][..], &words(with), &[*flag, *number]].concat();
            trials.refused(&both, 2, &[flag]);
        }
    }
    for (line, name) in [
        ("measure", "PLATE"),
        ("measure plate.stl", "--output"),
        ("measure plate.stl ring.png -o out", "ring.png"),
        ("measure -o out", "PLATE"),
    ] {
        trials.refused(&words(line), 2, &[name]);
    }
    trials.judge();
}

/// What is extreme but has a meaning ends with results.
#[test]
fn extreme_measurements_end() {
    let trials = Trials::new();
    fs::write(trials.home().join("plate.stl"), stl(&block([20.0, 20.0, 5.0]))).unwrap();
    let matt = "--material diffuse:1 --rays 1000 --resolution 16";
    for flags in [
        format!("{matt} --light 85,-360 --lamp ring.png --lamp-half-field 60"),
        format!("{matt} --light-radius 89"),
        format!("{matt} --half-field 85 --light 85,0 --projection screen"),
        format!("{matt} --max-bounces 1000 --seed 0 --extent endless"),
        format!("{matt} --wall 1e9 --lamp-distance 1e9"),
        format!("{matt} --wall 1e9 --wall-width 0.002 --wall-tilt -85"),
        format!("{matt} --wall 15 --wall-width 2e9 --lamp-distance 20 --lamp-radius 10"),
        format!("{matt} --look --distance 1e9"),
        format!("{matt} --look --distance 2.6 --field 160 --ambient 1e9"),
        format!("{matt} --look --camera 89.9,0 --light 85,180"),
        format!("{matt} --look --wrap sphere:1e8 --distance 1e9 --ambient 1"),
        format!("{matt} --look --wrap cylinder:0.001 --camera 89.9,90"),
        "--brdf --polar 2 --azimuths 1 --half-vectors 4x4 --rays 1000 --material diffuse:0".into(),
        "--brdf --polar 2 --azimuths 4 --half-vectors 4x4 --rays 1000 --extent finite --margin 9.99".into(),
        "--material diffuse:0 --rays 1000 --resolution 16".into(),
        "--ndf --resolution 16 --rays 1000 --extent endless".into(),
        "--rays 1000 --resolution 16 --error 0.999".into(),
    ] {
        let outcome = run_line(trials.home(), &format!("measure plate.stl -o out --force {flags}"));
        assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{flags}: {outcome:?}");
        assert!(!outcome.stdout.contains("NaN") && !outcome.stdout.contains("null"), "{flags}: {}", outcome.stdout);
    }
}

#[test]
fn what_cannot_be_measured_is_refused_by_name() {
    let mut trials = Trials::new();
    let home = trials.home().to_owned();
    let ways: [&[&str]; 5] =
        [&[], &["--ndf"], &["--wall", "1000"], &["--look", "--material", "diffuse:1"], &["--brdf"]];
    let nan = {
        let mut bytes = stl(&block([20.0, 20.0, 5.0]));
        bytes[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
        bytes
    };
    fs::create_dir(home.join("bare")).unwrap();
    for (name, bytes) in [("empty.stl", Vec::new()), ("none.stl", stl(&[])), ("nan.stl", nan)] {
        fs::write(home.join(name), bytes).unwrap();
    }
    for way in ways {
        for (plate, name) in [
            ("missing.stl", "missing.stl"),
            ("bare", "no plate.stl"),
            ("ring.png", "ring.png"),
            ("empty.stl", "empty.stl"),
            ("none.stl", "none.stl"),
            ("nan.stl", "nan.stl"),
        ] {
            trials.refused(&[&["measure", plate, "-o", "out"][..], way].concat(), 3, &[name]);
        }
    }
    // On no grid: turned about the vertical.
    let (sin, cos) = 0.4f32.sin_cos();
    let turned: Vec<_> =
        block([20.0, 20.0, 5.0]).iter().map(|t| t.map(|[x, y, z]| [cos * x - sin * y, sin * x + cos * y, z])).collect();
    fs::write(home.join("turned.stl"), stl(&turned)).unwrap();
    for (flags, code, name) in [
        ("--extent endless", 4, "--extent finite"),
        ("--brdf --extent endless", 4, "--extent finite"),
        ("--ndf", 4, "--ndf"),
        ("--look --wrap sphere:40 --material diffuse:1", 4, "--wrap"),
    ] {
        trials.refused(&[&["measure", "turned.stl", "-o", "out"][..], &words(flags)].concat(), code, &[name]);
    }
    // A design's folder whose other files are broken.
    let plate = stl(&block([20.0, 20.0, 5.0]));
    let level = "[design.distribution]\nlevel = true\n";
    for (name, recipe, report, code, says) in [
        ("a", "[light", "{}", 3, "a/recipe.toml"),
        ("b", "[light]\ntheta = 300\n", "{}", 3, "b/recipe.toml"),
        ("c", "[light]\ntheta = nan\n", "{}", 3, "c/recipe.toml"),
        ("d", "", "{", 3, "d/report.json"),
        ("e", "", "", 3, "e/report.json"),
        ("f", "", r#"{"design":{"mount_theta_deg":89,"mount_phi_deg":0}}"#, 3, "f/report.json"),
        ("g", "", r#"{"design":{"mount_theta_deg":"steep","mount_phi_deg":0}}"#, 3, "g/report.json"),
        ("h", "", r#"{"design":{"mount_theta_deg":10}}"#, 3, "h/report.json"),
        ("i", level, "{}", 3, "i/report.json"),
        ("j", level, r#"{"design":[1,2]}"#, 3, "j/report.json"),
        ("k", "[light]\ntheta = 80\n", r#"{"design":{"mount_theta_deg":80,"mount_phi_deg":180}}"#, 4, "--light"),
    ] {
        fs::create_dir(home.join(name)).unwrap();
        for (file, bytes) in
            [("plate.stl", &plate[..]), ("recipe.toml", recipe.as_bytes()), ("report.json", report.as_bytes())]
        {
            fs::write(home.join(name).join(file), bytes).unwrap();
        }
        trials.refused(&["measure", name, "-o", "out"], code, &[says]);
    }
    fs::create_dir_all(home.join("l/report.json")).unwrap();
    fs::create_dir_all(home.join("m/plate.stl")).unwrap();
    fs::write(home.join("l/plate.stl"), &plate).unwrap();
    trials.refused(&["measure", "l", "-o", "out"], 3, &["l/report.json"]);
    trials.refused(&["measure", "m", "-o", "out"], 3, &["m/plate.stl"]);
    trials.refused(&["measure", "turned.stl", "-o", "ring.png"], 5, &["ring.png"]);
    trials.refused(&["measure", "turned.stl", "-o", "/proc/none"], 5, &["/proc/none"]);
    trials.judge();
}

/// Odd plates in every way: results or a clear refusal, and an end.
#[test]
fn odd_plates_are_measured_or_refused() {
    let trials = Trials::new();
    let plate = block([20.0, 20.0, 5.0]);
    let ring = |k: usize, j: usize| {
        let (sin, cos) = (j as f32 * 30.0).to_radians().sin_cos();
        let r = k as f32;
        [r * cos, r * sin, 0.25 * r * r]
    };
    // Concave, without a grid, facing up.
    let bowl: Vec<_> = (0..8)
        .flat_map(|k| {
            (0..12).flat_map(move |j| [[(k, j), (k + 1, j), (k + 1, j + 1)], [(k, j), (k + 1, j + 1), (k, j + 1)]])
        })
        .map(|t| t.map(|(k, j)| ring(k, j)))
        .collect();
    let plates = [
        ("bowl", bowl),
        ("huge", block([1e7, 1e6, 1e3])),
        ("tiny", block([1e-3; 3])),
        ("far", moved(&plate, [1e6, -1e6, 1e6])),
        ("two", [plate.clone(), moved(&plate, [1e4, 0.0, 0.0])].concat()),
        ("sheet", vec![[[0.0; 3], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]]]),
    ];
    for (name, triangles) in plates {
        fs::write(trials.home().join(format!("{name}.stl")), stl(&triangles)).unwrap();
        for (k, flags) in [
            "--resolution 16",
            "--wall 1000 --resolution 16",
            "--look --resolution 16 --light-radius 5 --distance 1e8",
            "--brdf --polar 2 --azimuths 4 --half-vectors 8x8",
            "--ndf --resolution 16",
        ]
        .iter()
        .enumerate()
        {
            let line = format!("measure {name}.stl -o {name}{k} --rays 1000 {flags}");
            let outcome = run(trials.home(), line.split_whitespace());
            let clear = outcome.stderr.starts_with("facetmill: ") && outcome.stderr.lines().count() == 1;
            match outcome.code {
                Some(0) => assert!(outcome.stderr.is_empty() && !outcome.stdout.contains("NaN"), "{line}: {outcome:?}"),
                Some(4) => assert!(clear && k != 0 && k != 3, "{line}: {outcome:?}"),
                _ => panic!("{line}: {outcome:?}"),
            }
        }
    }
}
