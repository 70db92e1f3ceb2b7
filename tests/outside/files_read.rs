//! Files beside STL as programs of others read them: trimesh, manifold3d, Pillow, tifffile.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::asking;

/// Designs a ring in `home` and gives its folder.
fn designed(home: &Path, flags: &str) -> String {
    let picture = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/highlights/ring.png");
    let run = Command::new(env!("CARGO_BIN_EXE_facetmill"))
        .current_dir(home)
        .args(["design", picture])
        .args("-o plate --force --quiet --no-verify --also obj,ply,3mf,tiff".split(' '))
        .args(flags.split(' '))
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    home.join("plate").to_string_lossy().into_owned()
}

#[test]
fn others_read_the_same_closed_plate_in_millimetres_and_its_heights() {
    let home = tempfile::tempdir().unwrap();
    // A height map shows the plane through the middles of each square's sides: facets are planes, squares of a sheet
    // nearly, with nodes every 0.2 mm within 0.0054 mm.
    for (flags, sides, bend) in [
        ("--facets 20x10 --size 30x15 --border 2", [34.0, 19.0], 1e-6),
        ("--grid 48 --cells 2 --size 20x20 --light 30,90", [20.0, 20.0], 0.008),
    ] {
        let folder = designed(home.path(), flags);
        let said = match asking::ask("read_files.py", &[folder]) {
            Ok(said) => said,
            Err(why) => return asking::skip("trimesh and tifffile", &why),
        };
        let report: Value = serde_json::from_str(&said).unwrap();
        let number = |value: &Value| value.as_f64().unwrap();
        for name in ["plate.obj", "plate.ply", "plate.3mf"] {
            let read = &report[name];
            for fact in ["same", "watertight", "manifold"] {
                assert_eq!(read[fact], true, "{name} {fact}: {report}");
            }
            assert!((0..2).all(|k| (number(&read["extents"][k]) - sides[k]).abs() < 1e-5), "{report}");
        }
        assert_eq!(report["plate.3mf"]["units"], "millimeter", "{report}");
        let map = &report["heightmap.tiff"];
        assert_eq!((&map["bits"], &map["alike"]), (&16.into(), &true.into()), "{report}");
        assert!(number(&map["worst_mm"]) <= 0.5 * number(&map["step_mm"]) + bend, "{report}");
        assert!((number(&map["pixels_per_cm"]) * number(&map["mm_per_pixel"][0]) - 10.0).abs() < 1e-4, "{report}");
    }
}
