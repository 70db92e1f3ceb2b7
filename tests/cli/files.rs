//! What a design writes, and what it leaves alone.

use std::fs;

use serde_json::Value;

use super::program::{home, listing, run_line};
use super::{ALL_FILES, SMALL, assert_done, assert_refused, assert_same_plate, json, names};

#[test]
fn a_design_writes_every_file_and_says_what_it_made() {
    let home = home();
    let done = run_line(home.path(), &format!("design ring.png -o new/plate {SMALL} --verbose"));
    assert_done(&done);
    let folder = home.path().join("new/plate");
    assert_eq!(names(&folder), ALL_FILES);
    for word in
        ["new/plate/plate.stl, ", "8 × 6 facets", "relief", "valleys", "misplaced (TV)", "likeness (SSIM)", "Note: "]
    {
        assert!(done.stdout.contains(word), "{word} in {}", done.stdout);
    }
    assert!(done.stdout.lines().all(|line| line.chars().count() <= 80), "{}", done.stdout);
    let report = json(folder.join("report.json"));
    for key in ["step_rms_mm", "wall_area_ratio", "valleys"] {
        assert!(report["design"][key].is_number(), "{key}");
    }
    assert!(report["design"]["seconds"]["total"].is_number());
    for key in ["tv", "tv_incident", "ssim"] {
        for blur in ["0.27", "0.5", "1", "2"] {
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
fn other_formats_are_written_when_they_are_asked_for_and_the_recipe_keeps_them() {
    let home = home();
    assert_done(&run_line(home.path(), &format!("design ring.png -o one {SMALL} --no-verify --also 3mf,tiff,ply,obj")));
    let (one, two) = (home.path().join("one"), home.path().join("two"));
    assert_done(&run_line(home.path(), "design --recipe one/recipe.toml --threads 1 --no-verify -o two"));
    for name in ["plate.obj", "plate.ply", "plate.3mf", "heightmap.tiff", "plate.stl", "heightmap.png"] {
        assert_eq!(fs::read(one.join(name)).unwrap(), fs::read(two.join(name)).unwrap(), "{name}");
    }
    let recipe = fs::read_to_string(one.join("recipe.toml")).unwrap();
    assert!(recipe.contains("also = [\"obj\", \"ply\", \"3mf\", \"tiff\"]"), "{recipe}");
    // The light of each is that of the STL; only 3MF says its unit.
    let tv = |file: &str| {
        let done = run_line(home.path(), &format!("verify two/{file} --against ring.png --rays 5000 --json"));
        assert_done(&done);
        serde_json::from_str::<Value>(&done.stdout).unwrap()["measured"]["tv"]["1"].clone()
    };
    let stl = tv("plate.stl");
    assert!(stl.is_number());
    assert_eq!(["plate.obj", "plate.ply", "plate.3mf"].map(tv), [stl.clone(), stl.clone(), stl]);
    // What is no longer asked for goes.
    assert_done(&run_line(home.path(), &format!("design ring.png -o one {SMALL} --no-verify --also obj --force")));
    assert!(one.join("plate.obj").exists() && !one.join("plate.ply").exists() && !one.join("heightmap.tiff").exists());
    assert_done(&run_line(home.path(), &format!("design ring.png -o cad {SMALL} --no-verify --also step")));
    let step = fs::read_to_string(home.path().join("cad/plate.step")).unwrap();
    assert!(step.contains("MANIFOLD_SOLID_BREP") && step.ends_with("END-ISO-10303-21;\n"));
    for (flags, words) in [("--surface sheet", "--surface facets"), ("--facets 200x100", "fewer --facets")] {
        let refused = run_line(home.path(), &format!("design ring.png -o three {flags} --also step"));
        assert_refused(&refused, 4, &["step", "3mf", words]);
    }
    let refused = run_line(home.path(), "design ring.png -o three --also obj,stl");
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("'stl'") && refused.stderr.contains("3mf") && !home.path().join("three").exists());
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
