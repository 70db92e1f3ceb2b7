//! A plate that was written as a solid is known as the relief that it was, and its light is the same.

use std::f64::consts::{PI, TAU};

use crate::plates::waves::waves;
use crate::plates::{ALL, Shape, plate};
use facetmill::brdf::material::Material;
use facetmill::export::solid::solid;
use facetmill::lamp::Extent;
use facetmill::progress::Progress;
use facetmill::projection::Projection;
use facetmill::relief::faceted::FacetedRelief;
use facetmill::relief::mesh::Mesh;
use facetmill::relief::recognise::{Recognised, recognise};
use facetmill::setup::Setup;
use facetmill::trace::Surface;
use facetmill::trace::grid::GridSurface;
use facetmill::trace::mesh::MeshSurface;
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::measure::measure;
use facetmill::verify::tally::{Measurement, Tally};
use glam::DVec3;

/// Heights of a solid nearer than this share of the finest pitch become one, or are kept as far apart where surfaces only
/// touch.
const SNAP: f64 = 2e-5;

fn finest(lines: &[f64]) -> f64 {
    lines.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
}

fn lit<S: Surface>(surface: &S, theta: f64) -> Measurement {
    let setup = Setup::new(f64::to_radians(theta), 0.7, 0.0, Projection::Equidistant, f64::to_radians(60.0));
    let experiment = Experiment {
        surface,
        setup: &setup,
        material: Material::MIRROR,
        lamp: setup.lamp().with_extent(Extent::Point).into(),
    };
    measure(&experiment, &Measuring { rays: 200_000, resolution: 8, ..Measuring::default() }, &Progress::silent())
        .unwrap()
}

fn figures(t: &Tally) -> [f64; 4] {
    [t.up_single / t.incident, t.up_multi / t.incident, t.first_hit_wall / t.incident, t.blocked()]
}

/// Demands equal light within three errors of both, or within what a tilt of `tilt` of some facets may change.
fn same_light(what: &str, a: &Measurement, b: &Measurement, tilt: f64) {
    let (da, db) = (a.standard_errors(figures), b.standard_errors(figures));
    for (k, (x, y)) in figures(&a.whole).into_iter().zip(figures(&b.whole)).enumerate() {
        let combined = da[k].hypot(db[k]);
        assert!((x - y).abs() <= 3.0 * combined + tilt, "figure {k} of {what}: {x} and {y}, error {combined}");
        assert!(combined < 0.01, "figure {k} of {what}: an error of {combined} tells nothing");
    }
}

/// What `recognise` gives back of the solid of `relief`, held against it.
fn known_again(what: &str, relief: &FacetedRelief) -> FacetedRelief {
    let mesh = solid(relief, 1.0, &Progress::silent()).unwrap();
    let Some(Recognised::Facets(back)) = recognise(&mesh, &Progress::silent()).unwrap() else {
        panic!("{what} is not known again")
    };
    assert_eq!((back.columns(), back.rows()), (relief.columns(), relief.rows()), "{what}");
    let (low, high) = mesh.bounds();
    let single = f64::from(f32::EPSILON) * low.abs().max(high.abs()).max_element();
    for (a, b) in back.x.iter().chain(&back.y).zip(relief.x.iter().chain(&relief.y)) {
        assert!((a - b).abs() <= single, "{what}: a line at {a}, not {b}");
    }
    let pitch = finest(&relief.x).min(finest(&relief.y));
    let off = 2.0 * (SNAP * pitch + single);
    for (k, (a, b)) in back.facets.iter().zip(&relief.facets).enumerate() {
        assert!((a.height - b.height).abs() <= off, "{what}: facet {k} at {}, not {}", a.height, b.height);
        let turned = (a.slope.to_vec() - b.slope.to_vec()).length();
        assert!(turned <= 2.0 * off / pitch, "{what}: facet {k} is {:?}, not {:?}", a.slope, b.slope);
    }
    back
}

#[test]
fn facets_of_every_shape_come_back_from_their_solid() {
    for (shape, seed) in ALL.into_iter().flat_map(|shape| (0..12u64).map(move |seed| (shape, seed))) {
        let (columns, rows) = (1 + (7 * seed as usize + 3) % 17, 1 + (5 * seed as usize) % 13);
        let cell = [0.05, 1.0, 1.016, 12.0][seed as usize % 4];
        let level = [0.0, 3.0 * cell, -20.0 * cell][seed as usize % 3];
        let what = format!("{shape:?} {columns} × {rows} of {cell} mm, seed {seed}");
        let relief = plate(shape, columns, rows, cell, level, seed);
        known_again(&what, &relief);
        known_again(&format!("{what}, with a rim"), &relief.with_rim(1.3 * cell));
    }
}

#[test]
fn the_relief_known_again_sends_light_as_the_relief_and_the_mesh_do() {
    for (shape, seed) in [(Shape::Random, 1), (Shape::Eighths, 2), (Shape::Nudged, 3), (Shape::Checkerboard, 4)] {
        let relief = plate(shape, 14, 11, 1.0, 0.0, seed).with_rim(1.5);
        let back = known_again("traced plate", &relief);
        let mesh = MeshSurface::new(&solid(&relief, 1.0, &Progress::silent()).unwrap(), 1.5).unwrap();
        let grid = GridSurface::new(&relief, &Progress::silent()).unwrap();
        let again = GridSurface::new(&back, &Progress::silent()).unwrap().lit_within(relief.optical_area());
        for theta in [0.0, 35.0, 70.0] {
            let what = format!("{shape:?} at {theta}");
            let (a, b, c) = (lit(&grid, theta), lit(&again, theta), lit(&mesh, theta));
            same_light(&format!("{what}, known again"), &a, &b, 1e-4);
            same_light(&format!("{what}, as triangles"), &a, &c, 1e-4);
        }
    }
}

#[test]
fn a_continuous_mesh_is_known_node_for_node_and_sends_the_same_light() {
    let mesh = waves();
    let Some(Recognised::Heights(grid)) = recognise(&mesh, &Progress::silent()).unwrap() else { panic!("not known") };
    assert_eq!((grid.x.len(), grid.y.len()), (49, 49));
    assert!(grid.rising.iter().all(|&rises| !rises));
    for (k, z) in grid.heights.iter().enumerate() {
        let vertex = mesh.vertices[49 * 49 + k].map(f64::from);
        assert_eq!([grid.x[k % 49], grid.y[k / 49], *z], vertex, "node {k}");
    }
    let (surface, triangles) =
        (GridSurface::continuous(&grid, &Progress::silent()).unwrap(), MeshSurface::new(&mesh, 0.0).unwrap());
    for theta in [0.0, 40.0, 75.0] {
        same_light(&format!("waves at {theta}"), &lit(&surface, theta), &lit(&triangles, theta), 1e-6);
    }
}

/// Every vertex moved.
fn moved(mesh: &Mesh, to: impl Fn(DVec3) -> DVec3) -> Mesh {
    let moved = |v: &[f32; 3]| to(DVec3::from_array(v.map(f64::from))).as_vec3().to_array();
    Mesh { vertices: mesh.vertices.iter().map(moved).collect(), triangles: mesh.triangles.clone() }
}

#[test]
fn what_is_no_relief_on_a_grid_is_left_alone() {
    let relief = plate(Shape::Random, 8, 6, 1.0, 0.0, 1);
    let (faceted, continuous) = (solid(&relief, 1.0, &Progress::silent()).unwrap(), waves());
    for mesh in [&faceted, &continuous] {
        for degrees in [0.1, 10.0, 45.0f64] {
            let turned = moved(mesh, |v| glam::DMat3::from_rotation_z(degrees.to_radians()) * v);
            assert_eq!(recognise(&turned, &Progress::silent()).unwrap(), None, "turned by {degrees} degrees");
            let tilted = moved(mesh, |v| glam::DMat3::from_rotation_x(degrees.to_radians()) * v);
            assert_eq!(recognise(&tilted, &Progress::silent()).unwrap(), None, "tilted by {degrees} degrees");
        }
        assert!(
            recognise(&moved(mesh, |v| v + DVec3::new(100.0, -50.0, 8.0)), &Progress::silent()).unwrap().is_some(),
            "only moved"
        );
    }
    // A quarter turn maps a grid to a grid; its squares are then cut the other way.
    let quarter = |v: DVec3| DVec3::new(-v.y, v.x, v.z);
    assert!(matches!(recognise(&moved(&faceted, quarter), &Progress::silent()).unwrap(), Some(Recognised::Facets(_))));
    let Some(Recognised::Heights(turned)) = recognise(&moved(&continuous, quarter), &Progress::silent()).unwrap()
    else {
        panic!("not known")
    };
    assert!(turned.rising.iter().all(|&rises| rises));

    let (rings, around) = (12u32, 24u32);
    let mut sphere = Mesh::default();
    for (ring, k) in (0..=rings).flat_map(|ring| (0..around).map(move |k| (ring, k))) {
        let (theta, phi) = (PI * f64::from(ring) / f64::from(rings), TAU * f64::from(k) / f64::from(around));
        let v = 5.0 * facetmill::slope::direction(theta, phi);
        sphere.vertices.push(v.as_vec3().to_array());
    }
    for (ring, k) in (0..rings).flat_map(|ring| (0..around).map(move |k| (ring, k))) {
        let at = |ring: u32, k: u32| ring * around + k % around;
        let [a, b, c, d] = [at(ring, k), at(ring + 1, k), at(ring + 1, k + 1), at(ring, k + 1)];
        sphere.triangles.extend([[a, b, c], [a, c, d]]);
    }
    assert_eq!(recognise(&sphere, &Progress::silent()).unwrap(), None);
}
