//! Plates for `verify` that are broken, hostile or no plates at all.

use std::fs;

use super::Trials;
use crate::program::run;

type Triangle = [[f32; 3]; 3];

pub fn stl(triangles: &[Triangle]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// A closed box from the origin, faces outward.
pub fn block([x, y, z]: [f32; 3]) -> Vec<Triangle> {
    let corner = |k: usize| [(k & 1) as f32 * x, (k >> 1 & 1) as f32 * y, (k >> 2) as f32 * z];
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t| t.map(corner)).collect()
}

fn turned(triangles: &[Triangle]) -> Vec<Triangle> {
    triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
}

pub fn moved(triangles: &[Triangle], by: [f32; 3]) -> Vec<Triangle> {
    triangles.iter().map(|t| t.map(|v| [v[0] + by[0], v[1] + by[1], v[2] + by[2]])).collect()
}

fn patched(mut bytes: Vec<u8>, at: usize, with: &[u8]) -> Vec<u8> {
    bytes[at..at + with.len()].copy_from_slice(with);
    bytes
}

const TEXT: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\nendloop\nendfacet\n\
                    endsolid a\n";

/// Name, bytes, exit code.
fn plates() -> Vec<(&'static str, Vec<u8>, i32)> {
    let whole = || stl(&block([20.0, 20.0, 5.0]));
    let text = |from: &str, to: &str| TEXT.replace(from, to).into_bytes();
    let downward = |n: usize| stl(&block([20.0, 20.0, 5.0])[..n]);
    vec![
        ("empty", vec![], 3),
        ("one byte", vec![0], 3),
        ("a short header", vec![0; 83], 3),
        ("no triangles", vec![0; 84], 3),
        ("cut in a triangle", whole()[..300].to_vec(), 3),
        ("cut between triangles", whole()[..84 + 3 * 50].to_vec(), 3),
        ("cut in the count", whole()[..82].to_vec(), 3),
        ("count of none", patched(whole(), 80, &[0; 4]), 3),
        ("count of one more", patched(whole(), 80, &13u32.to_le_bytes()), 3),
        ("count of one less", patched(whole(), 80, &11u32.to_le_bytes()), 3),
        ("count of four billion", patched(whole(), 80, &[255; 4]), 3),
        ("not a number", patched(whole(), 84 + 12, &f32::NAN.to_le_bytes()), 3),
        ("infinite", patched(whole(), 84 + 50 + 12, &f32::INFINITY.to_le_bytes()), 3),
        ("solid alone", b"solid".to_vec(), 3),
        ("solid without facets", b"solid a\nendsolid a\n".to_vec(), 3),
        ("text cut in the header", TEXT.as_bytes()[..20].to_vec(), 3),
        ("text cut in a facet", TEXT.as_bytes()[..60].to_vec(), 3),
        ("text without end", text("endsolid a\n", ""), 3),
        ("text of four corners", text("endloop", "vertex 9 9 0\nendloop"), 3),
        ("text of two corners", text("vertex 0 9 0\n", ""), 3),
        ("text with a decimal comma", text("9 0 0", "9,5 0 0"), 3),
        ("text of nan", text("9 0 0", "nan 0 0"), 3),
        ("text of 1e99", text("9 0 0", "1e99 0 0"), 3),
        ("text on one line", TEXT.replace('\n', " ").into_bytes(), 3),
        ("text of one endless line", [b"solid ".to_vec(), vec![b'a'; 1 << 20]].concat(), 3),
        ("step", b"ISO-10303-21;\nHEADER;\n".to_vec(), 3),
        ("only a base", downward(2), 3),
        ("only sides", stl(&block([20.0, 20.0, 5.0])[4..]), 3),
        ("a single point", stl(&[[[1.0; 3]; 3]; 4]), 3),
        ("a line", stl(&[[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]; 2]), 3),
        ("a sheet on edge", stl(&[[[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 0.0, 5.0]]]), 3),
        ("slivers without area", stl(&[[[0.0, 0.0, 0.0], [9.0, 9.0, 0.0], [9.0, 9.0, 0.0]]]), 3),
        ("huge", stl(&block([1e30, 1e30, 1e29])), 3),
        ("as large as can be", stl(&moved(&block([3e38, 3e38, 1.0]), [-1.5e38, -1.5e38, 0.0])), 3),
        ("tiny", stl(&block([1e-30; 3])), 3),
        ("subnormal", stl(&block([1e-44; 3])), 3),
        ("two far apart", stl(&[block([9.0; 3]), moved(&block([9.0; 3]), [1e9, 0.0, 0.0])].concat()), 3),
        ("mirror tilted away", stl(&[[[0.0, 0.0, 0.0], [0.1, 0.0, 20.0], [0.0, 9.0, 0.0]]]), 4),
    ]
}

#[test]
fn what_is_no_plate_is_refused_by_name() {
    let mut trials = Trials::new();
    for (name, bytes, code) in plates() {
        let file = format!("{name}.stl");
        fs::write(trials.home().join(&file), bytes).unwrap();
        let args = ["verify", &file, "--against", "ring.png", "-o", "out/deep", "--rays", "1000"];
        trials.refused(&args, code, &[&file]);
        fs::remove_file(trials.home().join(&file)).unwrap();
    }
    for file in ["missing.stl", ".", "ring.png", "ring.png/plate.stl", "/dev/zero", "/dev/null"] {
        if !file.starts_with("/dev") || cfg!(unix) {
            trials.refused(&["verify", file, "--against", "ring.png", "-o", "out"], 3, &[file]);
        }
    }
    fs::write(trials.home().join("plate.stl"), stl(&block([20.0, 20.0, 5.0]))).unwrap();
    let verify = ["verify", "plate.stl", "--against", "ring.png", "-o", "out"];
    for (flags, code, name) in [
        (&["--margin", "10"][..], 4, "--margin"),
        (&["--margin", "9999"], 4, "--margin"),
        (&["--margin", "1e30"], 2, "--margin"),
        // A flat plate is a mirror: its light goes past a field that lies elsewhere.
        (&["--light", "60,0", "--half-field", "89"], 2, "--half-field"),
    ] {
        trials.refused(&[&verify[..], flags].concat(), code, &[name]);
    }
    for (name, code) in [("missing.png", 3), ("plate.stl", 3), (".", 3)] {
        trials.refused(&["verify", "plate.stl", "--against", name, "-o", "out"], code, &[name]);
    }
    trials.judge();
}

/// Odd, but light can be sent over it: done, with a note where something is wrong, and an end.
#[test]
fn odd_plates_are_traced() {
    let trials = Trials::new();
    let plate = block([20.0, 20.0, 5.0]);
    let sheet = vec![[[0.0; 3], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]]];
    for (name, triangles, note) in [
        ("plate", plate.clone(), ""),
        ("of ten kilometres", block([1e7, 1e6, 1e3]), ""),
        ("in metres", block([0.02, 0.02, 0.005]), "metres"),
        ("of a micrometre", block([1e-3; 3]), "metres"),
        ("far out", moved(&plate, [1e6, -1e6, 1e6]), ""),
        ("paper-thin", block([20.0, 20.0, 1e-6]), ""),
        ("sheet", sheet, "not closed"),
        ("holed", plate[..10].to_vec(), "not closed"),
        ("inside out", turned(&plate), "inside out"),
        ("doubled", [plate.clone(), plate.clone()].concat(), ""),
        ("two", [plate.clone(), moved(&plate, [1e4, 0.0, 0.0])].concat(), ""),
    ] {
        let file = format!("{name}.stl");
        fs::write(trials.home().join(&file), stl(&triangles)).unwrap();
        let args = ["verify", &file, "--against", "ring.png", "-o", name, "--rays", "1000"];
        let outcome = run(trials.home(), args);
        assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{name}: {outcome:?}");
        assert!(outcome.told().contains(note), "{name}: {}", outcome.stdout);
    }
}
