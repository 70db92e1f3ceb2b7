use std::f64::consts::TAU;

use glam::DVec2;

use super::*;
use crate::export::sheet::{sheet_solid, thinned_solid};
use crate::relief::mesh::Mesh;
use crate::relief::open::{NodeGrid, OpenRelief};
use crate::relief::periodic::{PeriodicRelief, drawn};
use crate::relief::recognise::{Recognised, recognise};
use crate::relief::rim::Rim;
use crate::slope::Slope;

/// A smooth hill with a valley across it and a ridge.
fn hill() -> PeriodicRelief {
    let height = |x: f64, y: f64| {
        let waves = 0.02 * ((TAU * x).sin() + (TAU * y).cos());
        waves + 0.05 * (x - 0.43).abs() - 0.03 * (x + y - 1.0).abs() + 0.04 * (x - y).abs()
    };
    PeriodicRelief {
        nodes: 64,
        heights: drawn(64, height),
        cell: DVec2::new(2.0, 3.0),
        cells: [2, 3],
        tilt: Slope::new(0.03, -0.02),
    }
}

fn open_sides(mesh: &Mesh) -> usize {
    let mut sides: HashMap<[u32; 2], i32> = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *sides.entry([*from.min(to), *from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    sides.values().filter(|balance| **balance != 0).count()
}

#[test]
fn fewer_triangles_are_closed_and_nearest_where_slopes_change() {
    let (relief, silent) = (hill(), Progress::silent());
    let mut cover = Bisection::new(&relief, HALF_LOST).unwrap();
    assert_eq!(cover.count(), 32);
    let mut before = f32::INFINITY;
    for most in [101, 400, 1500] {
        cover.refine(most, &silent).unwrap();
        let thinned = cover.thinned();
        assert!(thinned.triangles.len() == cover.count() && (most - 20..=most).contains(&cover.count()));
        // Heights are nearer to the sheet's the more there are, and a corner's own are the sheet's.
        let apart = |k: usize| (thinned.relief.heights[k] - relief.heights[k]).abs();
        let now = (0..64 * 64).map(apart).sum::<f32>() / (64.0 * 64.0);
        assert!(now < 0.6 * before, "{now} {before}");
        before = now;
        assert!(thinned.triangles.iter().flatten().all(|[i, j]| apart((j % 64 * 64 + i % 64) as usize) == 0.0));
        for border in [0.0, 1.5] {
            let mesh = thinned_solid(&thinned, 2.0, border, &silent).unwrap();
            assert_eq!(open_sides(&mesh), 0);
            assert!(mesh.triangles.len() < sheet_solid(&relief, 2.0, border, &silent).unwrap().triangles.len());
            assert_eq!(mesh.bounds(), sheet_solid(&thinned.relief, 2.0, border, &silent).unwrap().bounds());
        }
    }
    // On the folds triangles are small, elsewhere some are left as large as at first.
    let area = |[a, b, c]: &[[u32; 2]; 3]| {
        let to = |end: &[u32; 2]| [0, 1].map(|axis| f64::from(end[axis]) - f64::from(c[axis]));
        let ([ax, ay], [bx, by]) = (to(a), to(b));
        0.5 * (ax * by - bx * ay)
    };
    let areas: Vec<f64> = cover.thinned().triangles.iter().map(area).collect();
    assert_eq!(areas.iter().sum::<f64>(), 64.0 * 64.0);
    let (least, most) = areas.iter().fold((f64::MAX, 0.0f64), |(a, b), area| (a.min(*area), b.max(*area)));
    assert!(least <= 1.0 && most >= 8.0, "{least} {most}");
}

#[test]
fn an_open_sheet_is_thinned_up_to_its_rims_and_comes_back_from_its_file() {
    // A hill beside the middle: corners along opposite rims are not alike.
    let height = |at: DVec2| 0.4 * (-((at - DVec2::new(0.6, 0.3)) / 0.4).length_squared()).exp() + 0.02 * at.x.abs();
    let relief = OpenRelief::from_fn([97, 65], DVec2::new(0.03, 0.04), height);
    let silent = Progress::silent();
    let mut cover = Bisection::new(&relief, HALF_LOST).unwrap();
    assert_eq!(cover.count(), 2 * 6 * 4);
    cover.refine(1500, &silent).unwrap();
    let thinned = cover.thinned();
    assert!((1450..=1500).contains(&thinned.count()));
    let [south, east, north, west] = thinned.along_rim();
    assert!(south.len() != north.len() && east.len() != west.len());
    for rim in [Rim::from(0.0), Rim::from(1.5), Rim { width: 1.5, fall: 0.2 }] {
        let mesh = thinned_solid(&thinned, 2.0, rim, &silent).unwrap();
        assert_eq!(open_sides(&mesh), 0);
        assert_eq!(mesh.bounds(), sheet_solid(&thinned.relief, 2.0, rim, &silent).unwrap().bounds());
    }
    let mesh = thinned_solid(&thinned, 2.0, 0.0, &silent).unwrap();
    let Some(Recognised::Heights(grid)) = recognise(&mesh, &silent).unwrap() else { panic!("not recognised") };
    assert_eq!((grid.x.len(), grid.y.len()), (97, 65));
    for (k, z) in grid.heights.iter().enumerate() {
        assert!((z - thinned.relief.node(k % 97, k / 97).z).abs() < 1e-6, "{k}");
    }
}

#[test]
fn a_thinned_sheet_comes_back_from_its_file() {
    let (relief, silent) = (hill(), Progress::silent());
    let mut cover = Bisection::new(&relief, HALF_LOST).unwrap();
    cover.refine(1200, &silent).unwrap();
    let thinned = cover.thinned();
    let mesh = thinned_solid(&thinned, 2.0, 0.0, &silent).unwrap();
    let Some(Recognised::Heights(grid)) = recognise(&mesh, &silent).unwrap() else { panic!("not recognised") };
    assert_eq!((grid.x.len(), grid.y.len()), (129, 193));
    for (k, z) in grid.heights.iter().enumerate() {
        assert!((z - thinned.relief.node(k % 129, k / 129).z).abs() < 1e-6, "{k}");
    }
    // A hole is no plate, nor is a corner that lies off its place.
    let mut torn = mesh.clone();
    torn.triangles.remove(700);
    assert!(!matches!(recognise(&torn, &silent).unwrap(), Some(Recognised::Heights(_))));
    let mut bent = mesh;
    bent.vertices[200][0] += 0.01;
    assert!(!matches!(recognise(&bent, &silent).unwrap(), Some(Recognised::Heights(_))));
}
