//! Rays over the exact faceted relief: a walk from cell to cell of its grid, walls where heights differ.
//!
//! A path never meets its own facet again by rounding: it starts in the cell it left, and a ray that climbs away from
//! a plane does not meet that plane. Nothing leaks between facets: a ray leaves a cell only through a grid line, where
//! the neighbour's height at that very point decides between wall and passage.

use glam::{DVec2, DVec3};

use super::{Hit, Kind, Surface};
use crate::relief::faceted::FacetedRelief;

/// A faceted relief, ready for rays.
#[derive(Clone, Debug)]
pub struct GridSurface {
    x: Vec<f64>,
    y: Vec<f64>,
    planes: Vec<Plane>,
    optical: (DVec2, DVec2),
    heights: (f64, f64),
}

/// z = z0 + p x + q y.
#[derive(Clone, Copy, Debug)]
struct Plane {
    z0: f64,
    p: f64,
    q: f64,
}

impl Plane {
    fn height(self, x: f64, y: f64) -> f64 {
        self.z0 + self.p * x + self.q * y
    }
}

/// The cell in which a path stands: on its facet, or against a wall that rises from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    i: u32,
    j: u32,
}

impl GridSurface {
    /// Takes over the planes of `relief`.
    pub fn new(relief: &FacetedRelief) -> Self {
        let planes = (0..relief.facets.len())
            .map(|k| {
                let (i, j) = (k % relief.columns(), k / relief.columns());
                let (facet, middle) = (relief.facets[k], relief.middle(i, j));
                let (p, q) = (facet.slope.p, facet.slope.q);
                Plane { z0: facet.height - p * middle.x - q * middle.y, p, q }
            })
            .collect();
        Self {
            x: relief.x.clone(),
            y: relief.y.clone(),
            planes,
            optical: relief.optical_area(),
            heights: relief.height_range(),
        }
    }

    fn columns(&self) -> usize {
        self.x.len() - 1
    }

    fn rows(&self) -> usize {
        self.y.len() - 1
    }

    /// Follows the ray from `from` (inside cell (i, j), on or above its plane) to its next hit.
    fn walk(&self, mut i: usize, mut j: usize, from: DVec3, d: DVec3) -> Option<Hit<Cell>> {
        let inverse = DVec2::new(1.0 / d.x, 1.0 / d.y);
        let top = if d.z > 0.0 { (self.heights.1 - from.z) / d.z } else { f64::INFINITY };
        let mut entered = 0.0;
        // A straight line crosses each grid line once at the most.
        for _ in 0..=self.columns() + self.rows() {
            let plane = self.planes[j * self.columns() + i];
            let to_x = leave(self.x[i], self.x[i + 1], from.x, d.x, inverse.x);
            let to_y = leave(self.y[j], self.y[j + 1], from.y, d.y, inverse.y);
            let left = to_x.min(to_y).max(entered);
            let above = from.z - plane.height(from.x, from.y);
            let climb = d.z - plane.p * d.x - plane.q * d.y;
            if climb < 0.0 && above + left * climb < 0.0 {
                let t = (-above / climb).clamp(entered, left);
                let normal = DVec3::new(-plane.p, -plane.q, 1.0).normalize();
                return Some(self.hit(from + t * d, normal, Kind::Relief, i, j));
            }
            if left >= top || !left.is_finite() {
                return None;
            }
            // Through the nearer grid line; at a corner through x first, then through y at the same point.
            let mut point = from + left * d;
            let (mut next_i, mut next_j, mut normal) = (i, j, DVec3::ZERO);
            if to_x <= to_y {
                point.x = if d.x > 0.0 { self.x[i + 1] } else { self.x[i] };
                next_i = if d.x > 0.0 { i + 1 } else { i.wrapping_sub(1) };
                normal.x = -d.x.signum();
            } else {
                point.y = if d.y > 0.0 { self.y[j + 1] } else { self.y[j] };
                next_j = if d.y > 0.0 { j + 1 } else { j.wrapping_sub(1) };
                normal.y = -d.y.signum();
            }
            if next_i >= self.columns() || next_j >= self.rows() {
                return None;
            }
            let beyond = self.planes[next_j * self.columns() + next_i].height(point.x, point.y);
            if point.z < beyond - SEAM {
                return Some(self.hit(point, normal, Kind::Wall, i, j));
            }
            (i, j, entered) = (next_i, next_j, left);
        }
        None
    }

    fn hit(&self, point: DVec3, normal: DVec3, kind: Kind, i: usize, j: usize) -> Hit<Cell> {
        Hit { point, normal, kind, place: Cell { i: i as u32, j: j as u32 } }
    }
}

/// Steps lower than this, in mm, are rounding and not walls.
const SEAM: f64 = 1e-12;

/// Distance along the ray to the line by which it leaves the interval, infinite if it runs along it.
fn leave(low: f64, high: f64, from: f64, d: f64, inverse: f64) -> f64 {
    if d > 0.0 {
        (high - from) * inverse
    } else if d < 0.0 {
        (low - from) * inverse
    } else {
        f64::INFINITY
    }
}

/// The interval of `lines` that holds `at`, or the nearest.
fn interval(lines: &[f64], at: f64) -> usize {
    lines.partition_point(|&line| line <= at).clamp(1, lines.len() - 1) - 1
}

impl Surface for GridSurface {
    type Place = Cell;

    fn first(&self, origin: DVec3, direction: DVec3) -> Option<Hit<Cell>> {
        let low = DVec2::new(self.x[0], self.y[0]);
        let high = DVec2::new(self.x[self.columns()], self.y[self.rows()]);
        // To the box that holds the relief, from above or from the side.
        let mut entry = if origin.z > self.heights.1 { (self.heights.1 - origin.z) / direction.z } else { 0.0 };
        let mut side = DVec3::ZERO;
        for (axis, normal) in [(0, DVec3::X), (1, DVec3::Y)] {
            let (d, at) = (direction[axis], origin[axis]);
            let near = if d > 0.0 { low[axis] } else { high[axis] };
            let outside = if d > 0.0 { at < near } else { at > near };
            if outside && (near - at) / d > entry {
                (entry, side) = ((near - at) / d, -d.signum() * normal);
            }
        }
        if !(entry >= 0.0 && entry.is_finite()) {
            return None;
        }
        let point = origin + entry * direction;
        let slack = 1e-9 * (high - low).max_element();
        if (point.truncate().cmplt(low - slack) | point.truncate().cmpgt(high + slack)).any() {
            return None;
        }
        let point = point.truncate().clamp(low, high).extend(point.z);
        let (i, j) = (interval(&self.x, point.x), interval(&self.y, point.y));
        let above = point.z - self.planes[j * self.columns() + i].height(point.x, point.y);
        if above < -SEAM && side != DVec3::ZERO {
            return Some(self.hit(point, side, Kind::Outer, i, j));
        }
        self.walk(i, j, point, direction)
    }

    fn next(&self, from: &Hit<Cell>, direction: DVec3) -> Option<Hit<Cell>> {
        self.walk(from.place.i as usize, from.place.j as usize, from.point, direction)
    }

    fn optical_area(&self) -> (DVec2, DVec2) {
        self.optical
    }

    fn height_range(&self) -> (f64, f64) {
        self.heights
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
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
        GridSurface::new(&FacetedRelief::uniform(columns, rows, DVec2::new(columns as f64, rows as f64), facets))
    }

    fn random(columns: usize, rows: usize, seed: u64) -> GridSurface {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let values: Vec<f64> =
            (0..3 * columns * rows).map(|_| (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 0.5).collect();
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
        assert_eq!((hit.kind, hit.normal), (Kind::Relief, DVec3::Z));
        assert!(plate.next(&hit, mirror(l, hit.normal)).is_none());
    }

    #[test]
    fn a_right_angled_groove_sends_light_back_after_two_bounces() {
        let plate = relief(2, 1, |i, _| if i == 0 { (0.5, -1.0, 0.0) } else { (0.5, 1.0, 0.0) });
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        for _ in 0..1000 {
            let x = 2.0 * (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            let mut d = -DVec3::Z;
            let mut hit = plate.first(DVec3::new(x, 0.5, 3.0), d).unwrap();
            let mut bounces = 0;
            loop {
                d = mirror(-d, hit.normal);
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
        assert_eq!((hit.kind, hit.normal), (Kind::Wall, -DVec3::X));
        assert_eq!(hit.point.x, 1.0);
        let back = plate.next(&hit, mirror(-d, hit.normal)).unwrap();
        assert_eq!(back.kind, Kind::Relief);
        let outer = plate.first(DVec3::new(3.0, 0.5, 0.6), -d.with_z(0.2 * d.x)).unwrap();
        assert_eq!((outer.kind, outer.normal), (Kind::Outer, DVec3::X));
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
                assert!(hit.point.is_finite() && hit.normal.dot(d) <= 0.0, "met a face from behind");
                d = mirror(-d, hit.normal);
                let Some(next) = plate.next(&hit, d) else { break };
                hit = next;
            }
        }
    }

    #[test]
    fn the_walk_finds_what_fine_steps_along_the_ray_find() {
        let plate = random(6, 6, 11);
        let height = |at: DVec3| {
            let (i, j) = (interval(&plate.x, at.x), interval(&plate.y, at.y));
            plate.planes[j * 6 + i].height(at.x, at.y)
        };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(23);
        let mut unit = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
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
}
