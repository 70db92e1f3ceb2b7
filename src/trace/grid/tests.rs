//! Known answers, brute force, and rays aimed where grids are weakest.

use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::relief::faceted::Facet;
use crate::slope::{Slope, direction, mirror};

fn relief(columns: usize, rows: usize, facet: impl Fn(usize, usize) -> (f64, f64, f64)) -> GridSurface {
    let facets = (0..columns * rows)
        .map(|k| {
            let (height, p, q) = facet(k % columns, k / columns);
            Facet { height, slope: Slope::new(p, q) }
        })
        .collect();
    GridSurface::new(
        &FacetedRelief::uniform(columns, rows, DVec2::new(columns as f64, rows as f64), facets),
        &Progress::silent(),
    )
    .unwrap()
}

fn random(columns: usize, rows: usize, seed: u64) -> GridSurface {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let values: Vec<f64> = (0..3 * columns * rows).map(|_| rng.random::<f64>() - 0.5).collect();
    relief(columns, rows, |i, j| {
        let k = 3 * (j * columns + i);
        (values[k], values[k + 1], values[k + 2])
    })
}

#[test]
fn a_flat_plate_is_hit_where_the_ray_points_and_mirrors_it_away() {
    let plate = relief(4, 3, |_, _| (0.5, 0.0, 0.0));
    let l = direction(0.8, 2.0);
    let target = DVec3::new(2.3, 1.7, 0.5);
    let hit = plate.first(target + 2.0 * l, -l).unwrap();
    assert!(hit.point.distance(target) < 1e-12);
    assert_eq!((plate.kind(hit.place), plate.normal(hit.place)), (PieceKind::Relief, DVec3::Z));
    assert!(plate.next(&hit, mirror(l, plate.normal(hit.place))).is_none());
}

#[test]
fn a_right_angled_groove_sends_light_back_after_two_bounces() {
    let plate = relief(2, 1, |i, _| if i == 0 { (0.5, -1.0, 0.0) } else { (0.5, 1.0, 0.0) });
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    for _ in 0..1000 {
        let x = 2.0 * rng.random::<f64>();
        let mut d = -DVec3::Z;
        let mut hit = plate.first(DVec3::new(x, 0.5, 3.0), d).unwrap();
        let mut bounces = 0;
        loop {
            d = mirror(-d, plate.normal(hit.place));
            bounces += 1;
            let Some(next) = plate.next(&hit, d) else { break };
            hit = next;
        }
        assert_eq!(bounces, 2, "x = {x}");
        assert!(d.distance(DVec3::Z) < 1e-12);
    }
}

#[test]
fn walls_and_outer_sides_are_what_they_are() {
    let plate = relief(2, 1, |i, _| (i as f64, 0.0, 0.0));
    // Low from the left over the lower facet against the wall of the higher one.
    let d = DVec3::new(1.0, 0.0, -0.2).normalize();
    let hit = plate.first(DVec3::new(-1.0, 0.5, 0.5), d).unwrap();
    assert_eq!((plate.kind(hit.place), plate.normal(hit.place)), (PieceKind::Wall, -DVec3::X));
    assert_eq!(hit.point.x, 1.0);
    let back = plate.next(&hit, mirror(-d, plate.normal(hit.place))).unwrap();
    assert_eq!(plate.kind(back.place), PieceKind::Relief);
    let outer = plate.first(DVec3::new(3.0, 0.5, 0.6), -d.with_z(0.2 * d.x)).unwrap();
    assert_eq!((plate.kind(outer.place), plate.normal(outer.place)), (PieceKind::Outer, DVec3::X));
}

#[test]
fn every_downward_ray_over_the_plate_hits_even_at_corners_and_along_walls() {
    let plate = random(9, 7, 3);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(17);
    let mut whole = |n: u64| rng.next_u64() % n;
    for _ in 0..100_000 {
        // Half of the rays aim exactly at grid corners, half of the rest at points on grid lines; a third run
        // exactly along an axis.
        let on = |k: u64, f: f64| k as f64 + f;
        let fraction = |k: u64| if k < 3 { 0.0 } else { k as f64 / 7.0 };
        let (x, y) = (on(whole(8) + 1, -fraction(whole(7))), on(whole(6) + 1, -fraction(whole(7))));
        // Below every facet: the ray must have met something on its way.
        let target = DVec3::new(x, y, plate.heights.0 - 0.01);
        let (theta, phi) = (whole(89) as f64, whole(360) as f64);
        let phi = if whole(3) == 0 { (phi / 90.0).floor() * 90.0 } else { phi };
        let l = direction(theta.to_radians(), phi.to_radians());
        let l = if phi % 180.0 == 0.0 {
            l.with_y(0.0)
        } else if phi % 90.0 == 0.0 {
            l.with_x(0.0)
        } else {
            l
        };
        let start = target + l * (4.0 / l.z);
        let mut hit = plate.first(start, -l).expect("a ray toward the plate meets it");
        let mut d = -l;
        for _ in 0..50 {
            assert!(hit.point.is_finite() && plate.normal(hit.place).dot(d) <= 0.0, "met a face from behind");
            d = mirror(-d, plate.normal(hit.place));
            let Some(next) = plate.next(&hit, d) else { break };
            hit = next;
        }
    }
}

#[test]
fn the_walk_finds_what_fine_steps_along_the_ray_find() {
    let plate = random(6, 6, 11);
    let height = |at: DVec3| plate.field.height(plate.x.interval(at.x), plate.y.interval(at.y), at.x, at.y);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(23);
    let mut unit = || rng.random::<f64>();
    for _ in 0..300 {
        let l = direction(1.3 * unit(), std::f64::consts::TAU * unit());
        let from = DVec3::new(6.0 * unit(), 6.0 * unit(), plate.heights.1 + 1e-6);
        let step = 1e-4;
        let marched = (0..400_000).map(|k| from - l * (step * k as f64)).find(|at| {
            let inside = at.x > 0.0 && at.x < 6.0 && at.y > 0.0 && at.y < 6.0;
            !inside || at.z < height(*at)
        });
        match (marched, plate.first(from, -l)) {
            (Some(at), Some(hit)) => assert!(at.distance(hit.point) < 3.0 * step, "{at} {}", hit.point),
            (Some(at), None) => assert!(at.min_element() <= 0.0 || at.truncate().max_element() >= 6.0),
            (None, _) => panic!("the march did not end"),
        }
    }
}
