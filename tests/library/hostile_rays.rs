//! Close to two million rays aimed where tracers leak, hang or make numbers that are none: at vertices, along edges and walls and
//! axes, with directions next to zero, from points on the surface itself, over plates from a micrometre to a kilometre.
//!
//! Demanded of each ray and of its bounces: hits lie on the surface and are met from the front; what goes down over the
//! plate meets it; what meets nothing leaves upward or past the rim. Each trial has a seed, which a failure names.

mod reference;

use std::f64::consts::{PI, TAU};

use self::reference::Reference;
use crate::plates::{Shape, plate};
use facetmill::export::sheet::sheet_solid;
use facetmill::export::solid::solid;
use facetmill::progress::Progress;
use facetmill::relief::faceted::Facet;
use facetmill::relief::height_grid::HeightGrid;
use facetmill::relief::periodic::PeriodicRelief;
use facetmill::relief::recognise::{Recognised, recognise};
use facetmill::slope::{Slope, direction, mirror};
use facetmill::trace::grid::GridSurface;
use facetmill::trace::mesh::MeshSurface;
use facetmill::trace::{Hit, PieceKind, Surface};
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Bounces followed.
const BOUNCES: usize = 24;

/// How far a hit may lie off the surface: in sizes of the plate, and, however small it is, in mm.
const ROUNDING: f64 = 1e-10;
const LEAST_ROUNDING: f64 = 2e-12;

/// A trial's random choices.
struct Dice(Xoshiro256PlusPlus);

impl Dice {
    fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    fn unit(&mut self) -> f64 {
        self.0.random()
    }

    fn below(&mut self, n: usize) -> usize {
        self.0.random_range(0..n)
    }

    /// A line, the middle between lines, or anywhere.
    fn on(&mut self, lines: &[f64]) -> f64 {
        let k = self.below(lines.len() - 1);
        match self.below(8) {
            0..4 => lines[k + self.below(2)],
            4 => 0.5 * (lines[k] + lines[k + 1]),
            5 => lines[k].next_up(),
            _ => lines[k] + self.unit() * (lines[k + 1] - lines[k]),
        }
    }

    /// A component next to zero, or zero.
    fn speck(&mut self) -> f64 {
        let sizes = [0.0, -0.0, 5e-324, -5e-324, 1e-310, -1e-308, 1e-300, -1e-200, 1e-100, 1e-30, -1e-17, 1e-9];
        sizes[self.below(sizes.len())]
    }

    /// A unit vector to a light: along axes and diagonals, next to them, straight up, grazing, or any.
    fn light(&mut self) -> DVec3 {
        let theta = match self.below(8) {
            0 => 0.0,
            1 => 89.999f64.to_radians(),
            2 => self.unit() * 1e-7,
            3 => PI / 4.0,
            _ => 1.55 * self.unit(),
        };
        let phi = if self.below(2) == 0 { PI / 4.0 * self.below(8) as f64 } else { TAU * self.unit() };
        let mut l = direction(theta, phi);
        for axis in 0..2 {
            if l[axis].abs() < 1e-6 && self.below(4) > 0 || self.below(16) == 0 {
                l[axis] = self.speck();
            }
        }
        l.normalize()
    }
}

/// Follows mirror bounces from a hit and demands at each what the head of this file says.
fn follow<S: Surface>(surface: &S, reference: &impl Reference, mut hit: Hit<S::Place>, mut d: DVec3, trial: &str) {
    let size = reference.size();
    let (low, high) = reference.corners();
    // A solid keeps surfaces apart that touch at a corner, by up to 2e-5 cells.
    let kept_apart = if surface.facets() == 0 { 2e-5 } else { 0.0 };
    let rounding = ROUNDING * size + LEAST_ROUNDING + kept_apart;
    for bounce in 0..BOUNCES {
        let (normal, kind) = (surface.normal(hit.place), surface.kind(hit.place));
        let what = || format!("{trial}, bounce {bounce}: {kind:?} at {:?} along {d:?}", hit.point);
        assert!(hit.point.is_finite() && (normal.length() - 1.0).abs() < 1e-12, "{}", what());
        assert!(d.dot(normal) < 1e-12, "met from behind, normal {normal}: {}", what());
        if kind == PieceKind::Outer {
            return;
        }
        let (lowest, highest) = reference.range(hit.point.truncate(), surface.is_endless());
        let off = (lowest - hit.point.z).max(hit.point.z - highest);
        assert!(off <= rounding, "{off} off the surface: {}", what());
        let out = mirror(-d, normal).normalize();
        match surface.next(&hit, out) {
            Some(next) => (hit, d) = (next, out),
            None => return leaves(surface, reference, hit.point, out, (low, high), &what()),
        }
    }
}

/// A ray that meets nothing has to leave: upward, or past the rim before it is as low as the lowest point.
fn leaves<S: Surface>(
    s: &S,
    reference: &impl Reference,
    from: DVec3,
    d: DVec3,
    (low, high): (DVec2, DVec2),
    what: &str,
) {
    if d.z > 0.0 {
        return;
    }
    let bottom = s.height_range().0;
    let way = (bottom - from.z).min(0.0) / d.z;
    if s.is_endless() {
        // It may skim along a thousand periods and be let go.
        let periods = way * d.truncate().length() / (high - low).min_element();
        assert!(periods >= 900.0 || !way.is_finite() || d.z == 0.0, "leaks: {what}");
        return;
    }
    let at = from.truncate() + way * d.truncate();
    let slack = 1e-9 * reference.size();
    let inside = (at.cmpgt(low + slack) & at.cmplt(high - slack)).all();
    assert!(d.z == 0.0 || !way.is_finite() || !inside, "leaks at {at} from {from}: {what}");
}

/// `rays` rays from above and, where the surface lists its facets, `rays` from points on them.
fn attack<S: Surface>(name: &str, surface: &S, reference: &impl Reference, rays: u64) {
    let (x, y) = reference.lines();
    let (bottom, top) = surface.height_range();
    let size = reference.size();
    let lift = 1e-3 * size + (top - bottom);
    for seed in 0..rays {
        let trial = format!("{name}, trial {seed}");
        let mut dice = Dice::new(seed);
        let over = DVec2::new(dice.on(x), dice.on(y));
        // Half of the rays aim at the surface itself, half at what lies deep under it: these have to meet it.
        let deep = dice.below(2) == 0;
        let target = over.extend(if deep { bottom - 1e-3 * size } else { reference.range(over, false).0 });
        let l = dice.light();
        let start = target + l * ((top - target.z + lift) / l.z);
        match surface.first(start, -l) {
            Some(hit) => follow(surface, reference, hit, -l, &trial),
            None => {
                let (low, high) = reference.corners();
                // What `start` rounds to may pass the rim.
                let slack = 1e-9 * size;
                let inner = (over.cmpgt(low + slack) & over.cmplt(high - slack)).all();
                // Along a panel a ray may skim past a thousand periods and be let go.
                let periods = size / (high - low).min_element() * l.truncate().length() / l.z;
                let let_go = surface.is_endless() && periods > 100.0;
                assert!(!(deep && inner) || let_go, "{trial}: a ray from {l:?} to {target:?} met nothing");
            }
        }
        if surface.facets() > 0 {
            // From a corner, an edge or the middle of a facet, into the half space above it, specks of angle included.
            let k = dice.below(surface.facets());
            let corner = |dice: &mut Dice| [0.0, 1.0, 0.5, dice.unit()][dice.below(4)];
            let u = [corner(&mut dice), corner(&mut dice)];
            let Some((place, _)) = surface.facet(k) else { continue };
            let hit = Hit { point: surface.point_on(k, u), place };
            let mut d = dice.light();
            if dice.below(4) == 0 {
                d = d.with_z(dice.speck()).normalize_or(DVec3::X);
            }
            if d.dot(surface.normal(place)) <= 0.0 {
                d = -d;
            }
            let trial = format!("{trial}, from facet {k} at {u:?} along {d:?}");
            match surface.next(&hit, d) {
                Some(next) => follow(surface, reference, next, d, &trial),
                None => leaves(surface, reference, hit.point, d, reference.corners(), &trial),
            }
        }
    }
}

/// Shapes whose walls, ties and folds tempt most.
const SHAPES: [Shape; 5] = [Shape::Random, Shape::Integers, Shape::Eighths, Shape::Checkerboard, Shape::Ramp];

#[test]
fn facets_and_walls_do_not_leak() {
    for shape in SHAPES {
        let relief = plate(shape, 9, 7, 1.0, 0.0, 1);
        attack(&format!("{shape:?}"), &GridSurface::new(&relief, &Progress::silent()).unwrap(), &relief, 60_000);
        let rimmed = plate(shape, 5, 6, 0.3, 2.0, 2).with_rim(1.0);
        attack(
            &format!("{shape:?} with a rim"),
            &GridSurface::new(&rimmed, &Progress::silent()).unwrap(),
            &rimmed,
            20_000,
        );
    }
}

#[test]
fn plates_of_a_micrometre_and_of_a_kilometre_do_not_leak() {
    for (shape, cell) in SHAPES.into_iter().flat_map(|shape| [(shape, 1e-4), (shape, 1e5)]) {
        let relief = plate(shape, 9, 7, cell, 0.0, 3);
        attack(
            &format!("{shape:?} of {cell} mm"),
            &GridSurface::new(&relief, &Progress::silent()).unwrap(),
            &relief,
            10_000,
        );
        attack(
            &format!("{shape:?} of {cell} mm, endless"),
            &GridSurface::panel(&relief, &Progress::silent()).unwrap(),
            &relief,
            5_000,
        );
    }
}

#[test]
fn endless_panels_do_not_leak() {
    for shape in SHAPES {
        let relief = plate(shape, 6, 5, 1.0, 0.0, 4);
        attack(
            &format!("{shape:?}, endless"),
            &GridSurface::panel(&relief, &Progress::silent()).unwrap(),
            &relief,
            25_000,
        );
        let one = plate(shape, 1, 1, 1.0, 0.0, 5);
        attack(
            &format!("one {shape:?} cell, endless"),
            &GridSurface::panel(&one, &Progress::silent()).unwrap(),
            &one,
            5_000,
        );
    }
}

/// Nodes at random, on eighths, or all level; squares cut at random.
fn nodes(scale: f64, seed: u64) -> HeightGrid {
    let mut dice = Dice::new(seed);
    let lines =
        |n: usize, first: f64| -> Vec<f64> { (0..=n).map(|k| scale * if k == 1 { first } else { k as f64 }).collect() };
    let (x, y) = (lines(8, 0.5), lines(7, 1.0));
    let height = |dice: &mut Dice| match seed % 3 {
        0 => 2.0 * dice.unit(),
        1 => dice.below(9) as f64 / 8.0,
        _ => 0.25,
    };
    let heights = (0..x.len() * y.len()).map(|_| scale * height(&mut dice)).collect();
    let rising = (0..8 * 7).map(|_| dice.below(2) == 1).collect();
    HeightGrid { x, y, heights, rising }
}

/// The same nodes cut as `rises` says of each square, or along their higher diagonals.
fn cut(grid: &HeightGrid, rises: Option<bool>) -> HeightGrid {
    let HeightGrid { x, y, heights, rising } = grid.clone();
    match rises {
        Some(rises) => HeightGrid { rising: vec![rises; rising.len()], x, y, heights },
        None => HeightGrid::new(x, y, heights, &Progress::silent()).unwrap(),
    }
}

#[test]
fn continuous_reliefs_do_not_leak() {
    for (seed, scale) in (0..9).map(|seed| (seed, [1.0, 1e-4, 1e5][seed as usize / 3])) {
        let grid = nodes(scale, seed);
        attack(
            &format!("nodes {seed} of {scale} mm"),
            &GridSurface::continuous(&grid, &Progress::silent()).unwrap(),
            &grid,
            20_000,
        );
        for (cuts, grid) in [Some(false), Some(true), None].map(|rises| (rises, cut(&grid, rises))) {
            let name = format!("nodes {seed} of {scale} mm, rising {cuts:?}");
            attack(&name, &GridSurface::continuous(&grid, &Progress::silent()).unwrap(), &grid, 8_000);
        }
        let endless =
            GridSurface::continuous(&grid, &Progress::silent()).unwrap().endless(&Progress::silent()).unwrap();
        attack(&format!("nodes {seed} of {scale} mm, endless"), &endless, &grid, 8_000);
    }
}

#[test]
fn meshes_of_solids_do_not_leak() {
    // Shapes whose corners are exact in single precision.
    for shape in [Shape::Integers, Shape::Eighths, Shape::Checkerboard] {
        let mut relief = plate(shape, 9, 7, 1.0, 0.0, 1);
        relief.x[1] = 1.25;
        let mesh = MeshSurface::new(&solid(&relief, 1.0, &Progress::silent()).unwrap(), 0.0).unwrap();
        attack(&format!("mesh of {shape:?}"), &mesh, &relief, 30_000);
    }
}

#[test]
fn a_grid_and_the_mesh_of_its_solid_are_met_alike() {
    // Everything in whole parts of 2⁻¹², so that single precision holds the solid's corners exactly.
    let mut relief = plate(Shape::Random, 12, 10, 1.0, 0.0, 6);
    let whole = |value: f64, parts: f64| (value * parts).round() / parts;
    relief.x[1] = 1.375;
    for facet in &mut relief.facets {
        let slope = Slope::new(whole(facet.slope.p, 64.0), whole(facet.slope.q, 64.0));
        *facet = Facet { height: whole(facet.height, 4096.0), slope };
    }
    let mesh = MeshSurface::new(&solid(&relief, 1.0, &Progress::silent()).unwrap(), 0.0).unwrap();
    assert!(bounces_alike(&GridSurface::new(&relief, &Progress::silent()).unwrap(), &mesh) > 50_000);
}

#[test]
fn a_sheet_and_the_mesh_that_is_written_are_met_alike() {
    // In parts of 2⁻¹² again, the tilt too; steep enough for many bounces.
    let mut dice = Dice::new(9);
    let heights = (0..64).map(|_| dice.below(2048) as f32 / 4096.0).collect();
    let tilt = Slope::new(0.125, -0.25);
    let sheet = PeriodicRelief { nodes: 8, heights, cell: DVec2::new(2.0, 1.5), cells: [5, 4], tilt };
    let [columns, rows] = sheet.plate_nodes().map(|nodes| nodes - 1);
    let lines = |n: usize, step: f64| (0..=n).map(|k| k as f64 * step).collect();
    let nodes = (0..(columns + 1) * (rows + 1)).map(|k| sheet.node(k % (columns + 1), k / (columns + 1)).z);
    let rising = (0..columns * rows).map(|k| sheet.rises(k % columns, k / columns)).collect();
    let step = sheet.step();
    let grid = HeightGrid { x: lines(columns, step.x), y: lines(rows, step.y), heights: nodes.collect(), rising };
    let written = sheet_solid(&sheet, 1.0, 0.0, &Progress::silent()).unwrap();
    assert_eq!(recognise(&written, &Progress::silent()).unwrap(), Some(Recognised::Heights(grid.clone())));
    let mesh = MeshSurface::new(&written, 0.0).unwrap();
    let bounces = bounces_alike(&GridSurface::continuous(&grid, &Progress::silent()).unwrap(), &mesh);
    assert!(bounces > 30_000, "{bounces}");
}

/// Follows the same rays over a grid and over a mesh and demands that they meet the same; how often they do.
fn bounces_alike(grid: &impl Surface, mesh: &MeshSurface) -> usize {
    let size = grid.optical_area().1;
    let mut bounces = 0;
    for seed in 0..50_000 {
        let mut dice = Dice::new(seed);
        let l = direction((1.0 - dice.unit().powi(2)) * 1.55, TAU * dice.unit());
        let target = DVec3::new(size.x * dice.unit(), size.y * dice.unit(), grid.height_range().0);
        let (start, mut d) = (target + l * 20.0 / l.z, -l);
        let (mut a, mut b) = (grid.first(start, d), mesh.first(start, d));
        let mut here = 0;
        while let (Some(ours), Some(theirs)) = (a, b) {
            let (at, there) = (ours.point, theirs.point);
            assert!(at.distance(there) < 1e-6 * size.max_element(), "trial {seed}: {at}, {there}");
            let (normal, kind) = (grid.normal(ours.place), grid.kind(ours.place));
            let other = (mesh.normal(theirs.place), mesh.kind(theirs.place));
            let alike = normal.distance(other.0) < 1e-6 && kind == other.1;
            assert!(alike, "trial {seed}: {normal} {kind:?}, {other:?} at {at}, {there}, along {d}");
            if kind == PieceKind::Outer || here == BOUNCES {
                (a, b) = (None, None);
                continue;
            }
            (bounces, here) = (bounces + 1, here + 1);
            d = mirror(-d, normal);
            (a, b) = (grid.next(&ours, d), mesh.next(&theirs, d));
        }
        let ends = (a.map(|hit| hit.point), b.map(|hit| hit.point));
        assert_eq!(a.is_some(), b.is_some(), "trial {seed}: only one of them is met: {ends:?}");
    }
    bounces
}

#[test]
fn numbers_that_are_none_meet_nothing_or_something_finite() {
    let relief = plate(Shape::Random, 4, 3, 1.0, 0.0, 7);
    let specks = [0.0, -0.0, 5e-324, 1.0, -1.0, 1e300, -1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
    fn check<S: Surface>(surface: &S, specks: &[f64]) {
        let (bottom, top) = surface.height_range();
        let mut dice = Dice::new(8);
        let hit = surface.first(DVec3::new(0.5, 0.5, top + 1.0), -DVec3::Z).unwrap();
        assert!(hit.point.z >= bottom);
        for trial in 0..100_000 {
            let mut any = |plain: f64| if dice.below(2) == 0 { specks[dice.below(specks.len())] } else { plain };
            let origin = DVec3::new(any(1.5), any(1.5), any(top + 1.0));
            let d = DVec3::new(any(0.6), any(0.0), any(-0.8));
            let finite = |hit: Option<Hit<S::Place>>| hit.is_none_or(|hit| hit.point.is_finite());
            assert!(finite(surface.first(origin, d)), "trial {trial}: from {origin:?} along {d:?}");
            assert!(finite(surface.next(&hit, d)), "trial {trial}: from a facet along {d:?}");
        }
    }
    check(&GridSurface::new(&relief, &Progress::silent()).unwrap(), &specks);
    check(&GridSurface::panel(&relief, &Progress::silent()).unwrap(), &specks);
    check(&GridSurface::continuous(&nodes(1.0, 0), &Progress::silent()).unwrap(), &specks);
    let mesh = MeshSurface::new(&solid(&relief, 1.0, &Progress::silent()).unwrap(), 0.0).unwrap();
    check(&mesh, &specks);
}
