use super::*;
use crate::export::solid::solid;
use crate::relief::faceted::Facet;
use crate::slope::Slope;

/// Facets that step, cross, meet and stand alternately, with a rim.
fn plate(columns: usize, rows: usize) -> FacetedRelief {
    let facets = (0..columns * rows)
        .map(|k| Facet {
            height: [0.0, 0.02, 0.02, 0.1, 0.0][k * 7 % 5],
            slope: Slope::new(0.1 * ((k * 5 % 7) as f64 - 3.0), 0.1 * ((k * 3 % 5) as f64 - 2.0)),
        })
        .collect();
    let size = glam::DVec2::new(columns as f64, rows as f64);
    FacetedRelief::uniform(columns, rows, size, facets).with_rim(0.5)
}

/// Each edge is used once each way, faces are planar, and the volume is that of the mesh.
fn assert_closed(relief: &FacetedRelief) {
    let brep = Brep::under(relief, 2.0, &Progress::silent()).unwrap();
    let mut used = vec![[0, 0]; brep.edges.len()];
    let mut volume = 0.0;
    for face in &brep.faces {
        assert!(face.border.len() >= 3);
        let corners: Vec<_> = face
            .border
            .iter()
            .map(|&(edge, forward)| {
                used[edge as usize][usize::from(forward)] += 1;
                brep.vertices[brep.edges[edge as usize][usize::from(!forward)] as usize]
            })
            .collect();
        let mut area = glam::DVec3::ZERO;
        for (k, corner) in corners.iter().enumerate() {
            assert!((*corner - face.point).dot(face.normal).abs() <= 1.5 * SNAP, "{face:?}");
            area += 0.5 * (*corner - face.point).cross(corners[(k + 1) % corners.len()] - face.point);
            assert!(corner.distance(corners[(k + 1) % corners.len()]) > ACCURACY);
        }
        assert!(area.dot(face.normal) > 0.0 && face.normal.dot(face.along).abs() < 1e-12, "{face:?}");
        volume += area.dot(face.point) / 3.0;
    }
    assert!(used.iter().all(|ways| *ways == [1, 1]));
    let mesh = solid(relief, 2.0, &Progress::silent()).unwrap();
    let of_mesh = |k: usize| {
        let [a, b, c] = mesh.corners(k);
        a.dot(b.cross(c)) / 6.0
    };
    let meshed: f64 = (0..mesh.triangles.len()).map(of_mesh).sum();
    assert!((volume / meshed - 1.0).abs() < 1e-5, "{volume} {meshed}");
}

#[test]
fn the_shell_is_closed_its_faces_are_planar_and_its_volume_is_that_of_the_mesh() {
    for (columns, rows) in [(1, 1), (5, 1), (9, 7)] {
        assert_closed(&plate(columns, rows));
    }
    // Alternating corners, at one height.
    let mut checkerboard = plate(4, 4);
    for (k, facet) in checkerboard.facets.iter_mut().enumerate() {
        *facet = Facet { height: ((k % 6 + k / 6) % 2) as f64, slope: Slope::FLAT };
    }
    assert_closed(&checkerboard);
}

#[test]
fn a_file_names_every_entity_once_and_none_that_is_not_there() {
    let mut file = Vec::new();
    write_step(&plate(3, 2), 2.0, "3 × 2 'facets'", &mut file, &Progress::silent()).unwrap();
    let file = String::from_utf8(file).unwrap();
    assert!(file.is_ascii() && file.contains("3 \\X2\\00D7\\X0\\ 2 ''facets''"), "{file}");
    let mut made: Vec<&str> =
        file.lines().filter_map(|line| line.strip_prefix('#')?.split_once('=')).map(|l| l.0).collect();
    let count = made.len();
    made.sort_unstable();
    made.dedup();
    assert_eq!(made.len(), count);
    for word in file.split('#').skip(1).map(|rest| rest.split(|c: char| !c.is_ascii_digit()).next().unwrap()) {
        assert!(made.binary_search(&word).is_ok(), "#{word}");
    }
    // 20 facets with the rim, sides, base, and walls.
    assert!(file.matches("=ADVANCED_FACE").count() > 20 + 18 + 1);
    assert!(file.contains("SI_UNIT(.MILLI.,.METRE.)") && file.contains("LENGTH_MEASURE(1.E-6)"));
    let many =
        FacetedRelief::uniform(101, 100, glam::DVec2::ONE, vec![Facet { height: 0.0, slope: Slope::FLAT }; 10_100]);
    let mut nothing = Vec::new();
    let error = write_step(&many, 2.0, "", &mut nothing, &Progress::silent()).unwrap_err();
    assert!(nothing.is_empty() && error.to_string().contains("10100") && error.to_string().contains("3MF"), "{error}");
}
