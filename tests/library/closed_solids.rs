//! Whatever the relief, its solid is closed, exact and true to the slopes.

use std::collections::HashMap;
use std::io::Cursor;

use crate::plates::{ALL, Shape, plate};
use facetmill::export::solid::{SolidError, solid};
use facetmill::export::stl::{read_stl, write_stl};
use facetmill::progress::Progress;
use facetmill::relief::faceted::FacetedRelief;
use facetmill::relief::mesh::Mesh;
use facetmill::slope::Slope;
use glam::DVec2;

/// Every edge once each way, every vertex one ring of triangles, positions distinct, no triangle degenerate.
fn assert_manifold(mesh: &Mesh, name: &str) {
    let mut positions: Vec<_> = mesh.vertices.iter().map(|v| v.map(f32::to_bits)).collect();
    positions.sort_unstable();
    positions.dedup();
    assert_eq!(positions.len(), mesh.vertices.len(), "{name}: two vertices at one position");
    // Around each vertex, which edge end follows which: a permutation by the edges' uniqueness.
    let mut follows: Vec<HashMap<u32, u32>> = vec![HashMap::new(); mesh.vertices.len()];
    for (k, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        let [u, v, w] = mesh.corners(k);
        assert!((v - u).cross(w - u).length() > 0.0, "{name}: triangle {k} is degenerate");
        for (at, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            assert_eq!(follows[at as usize].insert(from, to), None, "{name}: an edge is used twice one way");
        }
    }
    for (v, ring) in follows.iter().enumerate() {
        let (&start, &next) = ring.iter().next().unwrap_or_else(|| panic!("{name}: vertex {v} is not used"));
        let (mut at, mut length) = (next, 1);
        while at != start {
            at = *ring.get(&at).unwrap_or_else(|| panic!("{name}: an edge at vertex {v} is open"));
            length += 1;
        }
        assert_eq!(length, ring.len(), "{name}: the triangles around vertex {v} are several rings");
    }
    assert_eq!(mesh.open_edges(), 0, "{name}");
    assert_closed_to_stl_io(mesh, name);
}

/// The parser of STL files finds no open edge either, nor two triangles that run along one the same way.
fn assert_closed_to_stl_io(mesh: &Mesh, name: &str) {
    let mut bytes = Vec::new();
    write_stl(mesh, &mut bytes).unwrap();
    let mut read = stl_io::read_stl(&mut Cursor::new(&bytes)).unwrap();
    assert_eq!((read.vertices.len(), read.faces.len()), (mesh.vertices.len(), mesh.triangles.len()), "{name}");
    // It refuses areas below 1e-7, which a low wall may have: enlarged by a power of two the body is exactly the same.
    read.vertices.iter_mut().flat_map(|vertex| &mut vertex.0).for_each(|c| *c *= 65_536.0);
    read.validate().unwrap_or_else(|error| panic!("{name}: {error}"));
}

/// The volume between facets and base.
fn prisms(relief: &FacetedRelief, base: f64) -> f64 {
    let cells = (0..relief.rows()).flat_map(|j| (0..relief.columns()).map(move |i| (i, j)));
    let area = |i: usize, j: usize| (relief.x[i + 1] - relief.x[i]) * (relief.y[j + 1] - relief.y[j]);
    cells.map(|(i, j)| area(i, j) * (relief.facet(i, j).height - base)).sum()
}

fn volume(mesh: &Mesh) -> f64 {
    // From a corner of the box, so that nothing large cancels.
    let origin = mesh.bounds().0;
    let tetrahedron = |k| {
        let [a, b, c] = mesh.corners(k).map(|v| v - origin);
        a.dot(b.cross(c)) / 6.0
    };
    (0..mesh.triangles.len()).map(tetrahedron).sum()
}

/// Upward triangles have the slopes of their cells, all others are exactly vertical or the base.
fn assert_true_to(relief: &FacetedRelief, mesh: &Mesh, name: &str) {
    let (low, high) = mesh.bounds();
    let mut seen = 0.0;
    for k in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(k);
        let normal = (b - a).cross(c - a);
        if normal.z == 0.0 {
            assert!((a.x == b.x && b.x == c.x) || (a.y == b.y && b.y == c.y), "{name}: a wall off the grid");
            continue;
        }
        if normal.z < 0.0 {
            assert!(a.z == low.z && b.z == low.z && c.z == low.z, "{name}: an overhang");
            continue;
        }
        let middle = (a + b + c) / 3.0;
        let (i, j) = (relief.x.partition_point(|&x| x < middle.x) - 1, relief.y.partition_point(|&y| y < middle.y) - 1);
        let cell = DVec2::new(relief.x[i + 1] - relief.x[i], relief.y[j + 1] - relief.y[j]);
        seen += 0.5 * normal.z;
        // The least height of the triangle in plan: slivers turn by the rounding of their vertices.
        let longest = [b - a, c - b, a - c].map(|side| side.truncate().length()).into_iter().fold(0.0, f64::max);
        if normal.z / longest > 0.05 * cell.min_element() {
            let slope = Slope::from_normal(normal).unwrap();
            let turned = slope.normal().angle_between(relief.facet(i, j).slope.normal());
            assert!(turned < 1e-4, "{name}: triangle {k} of cell {i}, {j} is turned by {turned}");
        }
    }
    let whole = (high.x - low.x) * (high.y - low.y);
    assert!((seen / whole - 1.0).abs() < 1e-6, "{name}: facets cover {seen} of {whole}");
}

fn check(relief: &FacetedRelief, thickness: f64, name: &str) {
    let mesh = solid(relief, thickness, &Progress::silent()).unwrap_or_else(|why| panic!("{name}: {why}"));
    assert_manifold(&mesh, name);
    let base = relief.height_range().0 - thickness;
    assert_eq!(mesh.bounds().0.z, f64::from(base as f32), "{name}");
    let (measured, expected) = (volume(&mesh), prisms(relief, base));
    assert!((measured / expected - 1.0).abs() < 1e-5, "{name}: volume {measured}, prisms {expected}");
    assert_true_to(relief, &mesh, name);
}

#[test]
fn every_shape_of_every_proportion_is_closed_and_true() {
    for shape in ALL {
        for (columns, rows) in [(1, 1), (1, 7), (6, 1), (2, 2), (3, 2), (5, 8), (17, 13)] {
            for seed in 0..6 {
                let relief = plate(shape, columns, rows, 1.0, 0.0, seed);
                check(&relief, 1.5, &format!("{shape:?} {columns} x {rows}, seed {seed}"));
            }
        }
    }
}

#[test]
fn rims_small_cells_and_high_levels_are_closed_and_true() {
    for shape in ALL {
        check(&plate(shape, 9, 6, 1.0, 0.0, 1).with_rim(2.5), 1.0, &format!("{shape:?} with a rim"));
        check(&plate(shape, 11, 10, 0.03, 0.0, 2), 3.0, &format!("{shape:?} of small cells"));
        check(&plate(shape, 7, 12, 2.0, 25.0, 3), 1.0, &format!("{shape:?} at a height"));
    }
    let mut relief = plate(Shape::Random, 8, 8, 1.0, 0.0, 4);
    relief.x.iter_mut().chain(&mut relief.y).for_each(|v| *v -= 4.0);
    check(&relief, 1.0, "grid lines on both sides of zero");
}

#[test]
fn many_small_random_plates_are_closed() {
    for seed in 0..1500 {
        let shape = ALL[3 + seed as usize % 5];
        let (columns, rows) = (1 + seed as usize % 4, 1 + seed as usize / 4 % 4);
        check(&plate(shape, columns, rows, 1.0, 0.0, seed), 0.5, &format!("{shape:?} {columns} x {rows}, seed {seed}"));
    }
}

#[test]
fn large_plates_with_coarse_single_precision_are_closed() {
    // Cells so fine, so far from x = 0, that only 16 floats lie between grid lines: the form suffers, topology does not.
    for shape in [Shape::Random, Shape::Eighths, Shape::Nudged, Shape::Dome] {
        let mut relief = plate(shape, 20, 20, 0.002, 0.01, 5);
        relief.x.iter_mut().for_each(|x| *x += 8000.0);
        assert!(matches!(solid(&relief, 0.01, &Progress::silent()), Err(SolidError::GridLines(..))));
        relief.x.iter_mut().for_each(|x| *x -= 6000.0);
        assert_manifold(&solid(&relief, 0.01, &Progress::silent()).unwrap(), &format!("{shape:?} far out"));
    }
}

#[test]
fn a_flat_plate_is_its_facets_sides_and_base() {
    let mesh = solid(&plate(Shape::Flat, 3, 2, 1.0, 0.0, 0), 1.0, &Progress::silent()).unwrap();
    assert_eq!(mesh.triangles.len(), 2 * 6 + 2 * 10 + 10);
    assert_eq!(mesh.vertices.len(), 12 + 10 + 1);
}

#[test]
fn the_written_file_is_read_back_as_the_same_body() {
    let mesh = solid(&plate(Shape::Random, 12, 9, 0.8, 0.0, 8).with_rim(1.0), 2.0, &Progress::silent()).unwrap();
    let mut bytes = Vec::new();
    write_stl(&mesh, &mut bytes).unwrap();
    let read = read_stl(&mut Cursor::new(&bytes)).unwrap();
    assert_manifold(&read, "read back");
    assert_eq!((read.vertices.len(), read.triangles.len()), (mesh.vertices.len(), mesh.triangles.len()));
    assert!((0..mesh.triangles.len()).all(|k| read.corners(k) == mesh.corners(k)));
    // What was read has its vertices in the order of the file: read once more, nothing changes.
    bytes.clear();
    write_stl(&read, &mut bytes).unwrap();
    assert_eq!(read_stl(&mut Cursor::new(&bytes)).unwrap(), read);
}

#[test]
fn a_relief_without_a_solid_is_refused_in_one_sentence() {
    let good = plate(Shape::Random, 3, 3, 1.0, 0.0, 1);
    let with = |change: fn(&mut FacetedRelief)| {
        let mut relief = good.clone();
        change(&mut relief);
        solid(&relief, 1.0, &Progress::silent()).map(|_| ()).unwrap_err()
    };
    assert_eq!(with(|r| r.facets[5].height = f64::NAN), SolidError::NotFinite { column: 2, row: 1 });
    assert_eq!(with(|r| r.facets[3].slope.p = f64::INFINITY), SolidError::NotFinite { column: 0, row: 1 });
    assert_eq!(with(|r| r.facets[0].height = 1e39), SolidError::NotFinite { column: 0, row: 0 });
    assert_eq!(with(|r| r.facets.truncate(8)), SolidError::Shape);
    assert_eq!(with(|r| r.x.clear()), SolidError::Shape);
    assert_eq!(with(|r| (r.x.truncate(1), r.facets.clear()).1), SolidError::Shape);
    assert_eq!(with(|r| r.x[1] = 0.0), SolidError::GridLines(0.0, 0.0));
    assert_eq!(with(|r| r.y[2] = 0.5), SolidError::GridLines(1.0, 0.5));
    assert_eq!(with(|r| r.y[3] = f64::NAN).to_string().split(' ').next(), Some("the"));
    assert!(matches!(with(|r| r.x.iter_mut().for_each(|x| *x += 1e8)), SolidError::GridLines(..)));
    assert!(matches!(with(|r| r.y[3] = 1e60), SolidError::GridLines(..)));
    assert!(matches!(with(|r| r.facets[0].height = 1e9), SolidError::Heights { .. }));
    for thickness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(solid(&good, thickness, &Progress::silent()), Err(SolidError::Thickness(_))));
    }
    assert!(matches!(solid(&good, 1e-6, &Progress::silent()), Err(SolidError::Thin { .. })));
    assert!(matches!(solid(&good, 1e300, &Progress::silent()), Err(SolidError::Heights { .. })));
    let Err(SolidError::Thin { least, .. }) = solid(&good, 1e-9, &Progress::silent()) else { panic!("not too thin") };
    assert_manifold(&solid(&good, least, &Progress::silent()).unwrap(), "the thinnest base");
}
