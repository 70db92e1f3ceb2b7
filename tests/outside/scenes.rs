//! The scenes of `--scene-files` rendered by Mitsuba 3 as they are, beside the program's own images.
//!
//! FACETMILL_PYTHON names a Python that has Mitsuba, `python3` if unset. Where it has none the tests are skipped,
//! visibly; with FACETMILL_REQUIRE_CHECKERS=1 that is a failure.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::asking;

fn facetmill(home: &Path, line: &str) {
    let run = Command::new(env!("CARGO_BIN_EXE_facetmill")).current_dir(home).args(line.split_whitespace()).output();
    let run = run.unwrap();
    assert!(run.status.success(), "{line}: {}", String::from_utf8_lossy(&run.stderr));
}

/// A plate and how its image is measured: blur in pixels, whether the scene is seen from the plate's side.
struct Plate {
    picture: &'static str,
    flags: &'static str,
    measured: &'static str,
    image: &'static str,
    blur: f64,
    flipped: bool,
    /// The most that the images may differ by.
    tv: f64,
}

/// An image is 256 pixels wide. At 20° either way 1° is 6.5 pixels; of 700 mm at 1 m 0.5° is 3.2.
const PLATES: [Plate; 5] = [
    Plate {
        picture: "ring",
        flags: "--facets 30x30",
        measured: "",
        image: "highlight.tiff",
        blur: 6.5,
        flipped: false,
        tv: 0.003,
    },
    Plate {
        picture: "letter",
        flags: "--grid 96 --cells 2 --size 20x20",
        measured: "",
        image: "highlight.tiff",
        blur: 6.5,
        flipped: false,
        tv: 0.003,
    },
    Plate {
        picture: "star",
        flags: "--grid 96 --cells 2 --size 20x20 --light 35,130 --projection equidistant --seen on-wall --lobe 0.4",
        measured: "--rays 8000000",
        image: "highlight.tiff",
        blur: 6.4,
        flipped: true,
        tv: 0.003,
    },
    Plate {
        picture: "letter",
        flags: "--facets 40x20 --size 40x20 --light 20,200 --light-radius 0.2665 --projection screen --level",
        measured: "--rays 8000000",
        image: "highlight.tiff",
        blur: 6.1,
        flipped: false,
        // A lamp with an extent is a sheet of tiles that shine one way each: 0.0039 were measured, whatever their number.
        tv: 0.005,
    },
    Plate {
        picture: "word",
        flags: "--grid 64 --size 20x20 --light 45,90 --lamp-distance 500 --lamp-radius 2.5 --wall 1000 \
                --picture-width 700",
        measured: "--rays 8000000 --wall 1000 --wall-width 700 --lamp-distance 500 --lamp-radius 2.5",
        image: "wall.tiff",
        blur: 3.2,
        flipped: true,
        tv: 0.003,
    },
];

#[test]
fn mitsuba_shows_the_image_of_the_proof() {
    let home = tempfile::tempdir().unwrap();
    for (k, plate) in PLATES.iter().enumerate() {
        let picture = format!("{}/examples/highlights/{}.png", env!("CARGO_MANIFEST_DIR"), plate.picture);
        facetmill(home.path(), &format!("design {picture} -o {k} --no-verify --quiet --scene-files {}", plate.flags));
        facetmill(home.path(), &format!("measure {k} -o {k}m --quiet {}", plate.measured));
        let [folder, image] = [format!("{k}"), format!("{k}m/{}", plate.image)].map(|name| home.path().join(name));
        let flip = u8::from(plate.flipped).to_string();
        let arguments =
            [folder.into_os_string(), image.into(), plate.blur.to_string().into(), flip.into(), "256".into()];
        let said = match asking::ask("scene_in_mitsuba.py", &arguments) {
            Ok(said) => said,
            Err(why) => return asking::skip("Mitsuba", &why),
        };
        let report: Value = serde_json::from_str(said.lines().last().unwrap_or_default()).unwrap();
        println!("{} {}: {report}", plate.picture, plate.flags);
        assert!(report["tv"].as_f64().unwrap() <= plate.tv, "{} {}: {report}", plate.picture, plate.flags);
        // All light that meets the plate is 1, and most of it falls into the picture.
        assert!((0.9..1.02).contains(&report["light"].as_f64().unwrap()), "{report}");
    }
}
