//! STEP files as Open CASCADE reads them.
//!
//! FACETMILL_PYTHON names a Python that has its package cadquery-ocp-novtk (380 MB), `python3` if unset. Where it has none
//! the test is skipped, visibly; with FACETMILL_REQUIRE_CHECKERS=1 that is a failure.

use std::fs::File;
use std::io::Write;

use facetmill::export::solid::solid;
use facetmill::export::step::write_step;
use facetmill::progress::Progress;
use facetmill::relief::mesh::Mesh;
use serde_json::Value;

use crate::asking;
use crate::plates::{ALL, plate};

fn volume(mesh: &Mesh) -> f64 {
    let under = |k: usize| {
        let [a, b, c] = mesh.corners(k);
        a.dot(b.cross(c)) / 6.0
    };
    (0..mesh.triangles.len()).map(under).sum()
}

#[test]
fn open_cascade_reads_one_closed_solid_of_planes_in_millimetres() {
    let folder = tempfile::tempdir().unwrap();
    for (k, shape) in ALL.into_iter().enumerate() {
        let relief = plate(shape, 9, 7, 1.0, 0.0, 5).with_rim(if k % 2 == 0 { 0.0 } else { 1.5 });
        let path = folder.path().join(format!("{k}.step"));
        let mut file = File::create(&path).unwrap();
        write_step(&relief, 2.0, "a plate", &mut file, &Progress::silent()).unwrap();
        file.flush().unwrap();
        let said = match asking::ask("step_in_occ.py", &[path]) {
            Ok(said) => said,
            Err(why) => return asking::skip("Open CASCADE", &why),
        };
        let found: Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
        let number = |key: &str| found[key].as_f64().unwrap();
        for fact in ["read", "valid", "closed"] {
            assert_eq!(found[fact], true, "{shape:?} {fact}: {found}");
        }
        assert_eq!((&found["solids"], &found["planes"]), (&1.into(), &found["faces"]), "{shape:?}: {found}");
        let mesh = solid(&relief, 2.0, &Progress::silent()).unwrap();
        assert!((number("volume") / volume(&mesh) - 1.0).abs() < 1e-5, "{shape:?}: {found} {}", volume(&mesh));
        let (low, high) = mesh.bounds();
        for (at, is) in low.to_array().into_iter().chain(high.to_array()).enumerate() {
            assert!((found["bounds"][at].as_f64().unwrap() - is).abs() < 1e-4, "{shape:?}: {found}");
        }
        assert!(number("off_plane") <= 3e-6, "{shape:?}: {found}");
    }
}
