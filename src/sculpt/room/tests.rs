use std::f64::consts::TAU;

use glam::DVec2;

use super::exact::exact;
use super::landing::wanted;
use super::milling::{filled, lattice_relief, milled, usual_tool};
use super::objective::PlateObjective;
use super::placed::placed;
use super::plate_grid::PlateGrid;
use crate::cutter::Cutter;
use crate::lamp::Lamp;
use crate::near::{NearField, Warping};
use crate::progress::Progress;
use crate::raster::Raster;
use crate::relief::open::{NodeGrid, OpenRelief};
use crate::relief::periodic::PeriodicRelief;
use crate::scene::Scene;
use crate::sculpt::filling::Filling;
use crate::sculpt::settings::SheetSettings;
use crate::sculpt::slope_loss::LossScale;
use crate::slope::{Slope, direction};

const SIZE: DVec2 = DVec2::new(12.0, 8.0);

fn near() -> NearField {
    let lamp = Lamp::Ball { middle: 300.0 * direction(0.6, 1.2), radius: 0.0 };
    NearField::new(&Scene::across_mirror(lamp, 400.0, 0.2, 120.0), SIZE, Slope::FLAT).unwrap()
}

/// 3 × 2 cells of waves.
fn cells() -> PeriodicRelief {
    let n = 16;
    let wave = |k: usize| TAU * k as f64 / n as f64;
    let height = |k: usize| (0.1 * wave(k % n).cos() * (1.0 + 0.3 * wave(k / n).sin())) as f32;
    PeriodicRelief {
        nodes: n,
        heights: (0..n * n).map(height).collect(),
        cell: DVec2::splat(4.0),
        cells: [3, 2],
        tilt: Slope::FLAT,
    }
}

fn flux() -> Raster {
    Raster::from_fn(32, 32, |x, y| if (8..24).contains(&x) && y > 5 { 1.0 + x as f64 } else { 0.0 }).normalised()
}

#[test]
fn cells_keep_their_triangles_on_the_base_and_meet_everywhere_when_warped() {
    let (near, cells) = (near(), cells());
    let based = placed(&cells, &near, Warping::Base);
    assert_eq!((based.nodes, based.size()), ([49, 33], SIZE));
    for (i, j) in [(0, 0), (17, 5), (48, 32), (31, 16)] {
        let at = based.node(i, j).truncate() - 0.5 * SIZE;
        let above = based.node(i, j).z - near.base(at);
        assert!((above - cells.node(i, j).z).abs() < 1e-6);
    }
    let warped = placed(&cells, &near, Warping::Warp);
    let at = DVec2::new(5.0, -3.0);
    let (asked, gain) = near.warped(at);
    assert!((asked - at).length() > 1e-4 && (gain - 1.0).abs() > 1e-4);
    let apart = warped.heights.iter().zip(&based.heights).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart > 1e-4 && apart < 0.02, "{apart}");
}

#[test]
fn a_plate_survives_its_lattice() {
    let relief = placed(&cells(), &near(), Warping::Base);
    for cutter in [None, Some(Cutter::ball(1.0))] {
        let grid = PlateGrid::of(&relief, cutter);
        assert_eq!(grid.plate(&grid.embedded(&relief)), relief);
        assert!(grid.lattice.n > 49 && grid.lattice.n.is_multiple_of(2));
    }
}

#[test]
fn the_gradient_is_that_of_the_loss() {
    let near = near();
    let start = placed(&cells(), &near, Warping::Base);
    for (cutter, polish) in [(None, None), (Some(Cutter::ball(0.8)), None), (Some(Cutter::ball(0.8)), Some(0.05))] {
        let settings = SheetSettings { cutter, polish, max_depth: Some(0.2), ..SheetSettings::default() };
        let scale = LossScale { blur: 1.0, alpha: 0.3, weighed: true };
        let target = wanted(near.scene(), &flux(), Slope::FLAT, 0.5).unwrap();
        let mut objective = PlateObjective::new(&start, &near, target, scale, &settings);
        objective.set_penalties(0.3);
        let n = objective.unknowns();
        let y: Vec<f32> = (0..n).map(|k| 1e-3 * (k as f32 * 0.7).sin()).collect();
        let mut gradient = vec![0.0; n];
        objective.loss(&y, &mut gradient);
        let way: Vec<f32> = gradient.iter().enumerate().map(|(k, g)| g * (1.0 + 0.5 * (k as f32).sin())).collect();
        let expected: f64 = way.iter().zip(&gradient).map(|(w, g)| f64::from(*w) * f64::from(*g)).sum();
        let largest = way.iter().fold(0.0f32, |m, w| m.max(w.abs()));
        let step = 2e-4 / largest;
        let at = |t: f32| {
            let y: Vec<f32> = y.iter().zip(&way).map(|(y, w)| y + t * step * w).collect();
            objective.loss(&y, &mut vec![0.0; n])
        };
        let measured = (at(1.0) - at(-1.0)) / (2.0 * f64::from(step));
        assert!((measured / expected - 1.0).abs() < 0.03, "{cutter:?} {polish:?}: {measured} {expected}");
    }
}

#[test]
fn the_descent_puts_light_where_it_is_wanted_and_the_cutter_reaches_it() {
    let near = near();
    let start = placed(&cells(), &near, Warping::Base);
    for cutter in [None, Some(Cutter::ball(1.0))] {
        let settings = SheetSettings { cutter, ..SheetSettings::default() };
        let sheet = exact(start.clone(), &near, &flux(), &settings, &Progress::silent()).unwrap().unwrap();
        let (before, after) = (sheet.misplaced[0], sheet.misplaced[sheet.misplaced.len() - 1]);
        assert!(after < 0.25 * before, "{cutter:?}: {:?}", sheet.misplaced);
        let Some(cutter) = cutter else { continue };
        let grid = PlateGrid::of(&sheet.relief, Some(cutter));
        let cut =
            milled(&grid, &grid.embedded(&sheet.relief), &usual_tool(&grid, cutter), &Progress::silent()).unwrap();
        assert!(cut.most_left() <= 0.5e-3, "{}", cut.most_left());
    }
}

#[test]
fn a_ditch_is_filled_as_far_as_the_cutter_needs() {
    let mut relief = OpenRelief::from_fn([41, 41], DVec2::splat(0.1), |at| 0.2 * at.x.abs());
    let cutter = Cutter::ball(1.0);
    let grid = PlateGrid::of(&relief, Some(cutter));
    let tool = usual_tool(&grid, cutter);
    let z = grid.embedded(&relief);
    let before = milled(&grid, &z, &tool, &Progress::silent()).unwrap().most_left();
    // R s²/2 of a valley between slopes of ±s.
    assert!((before / (0.25 * 0.04) - 1.0).abs() < 0.05, "{before}");
    let mut lattice = lattice_relief(&grid, &z);
    assert!(
        !Filling::new(tool.clone(), filled(&grid), 1e-3).fill(&mut lattice, &Progress::silent()).unwrap().is_empty()
    );
    relief = grid.plate(&lattice.heights);
    let after = milled(&grid, &grid.embedded(&relief), &tool, &Progress::silent()).unwrap();
    assert!(after.most_left() <= 1e-3 && after.relief().node(0, 0).truncate() == DVec2::ZERO);
    assert_eq!(relief.node(0, 3).z, f64::from(relief.heights[3 * 41]));
}
