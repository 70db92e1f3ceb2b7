//! Known answers, brute force, and rays aimed where meshes are weakest.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::slope::{Slope, direction, mirror};

const WIDTH: f64 = 3.0;

/// A prism of the given (x, z) profile, x ascending, 3 mm along y, standing on z = 0. Steps leave triangles without area.
fn prism(profile: &[(f32, f32)]) -> Mesh {
    let mut mesh = Mesh::default();
    for &(x, z) in profile {
        let w = WIDTH as f32;
        mesh.vertices.extend([[x, 0.0, z], [x, w, z], [x, w, 0.0], [x, 0.0, 0.0]]);
    }
    let mut quad = |[a, b, c, d]: [u32; 4]| mesh.triangles.extend([[a, b, c], [a, c, d]]);
    let last = 4 * (profile.len() as u32 - 1);
    quad([0, 1, 2, 3]);
    quad([last, last + 3, last + 2, last + 1]);
    for i in (0..last).step_by(4) {
        for side in 0..4 {
            let next = (side + 1) % 4;
            quad([i + side, i + 4 + side, i + 4 + next, i + next]);
        }
    }
    mesh
}

/// A solid of n × n squares of 1 mm under a surface of random heights from 1 mm up, closed, its vertices shared.
fn field(n: u32, climb: f32, random: &mut Xoshiro256PlusPlus) -> Mesh {
    let mut mesh = Mesh::default();
    for top in [1.0, 0.0] {
        for k in 0..(n + 1) * (n + 1) {
            let z = top * (1.0 + climb * random.random::<f32>());
            mesh.vertices.push([(k % (n + 1)) as f32, (k / (n + 1)) as f32, z]);
        }
    }
    let under = (n + 1) * (n + 1);
    let at = |i, j| j * (n + 1) + i;
    let mut quad = |[a, b, c, d]: [u32; 4]| mesh.triangles.extend([[a, b, c], [a, c, d]]);
    for k in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [at(k, j), at(k + 1, j), at(k + 1, j + 1), at(k, j + 1)];
            quad([a, b, c, d]);
            quad([a + under, d + under, c + under, b + under]);
        }
        for (a, b) in [(at(k, 0), at(k + 1, 0)), (at(n, k), at(n, k + 1))] {
            quad([a, a + under, b + under, b]);
        }
        for (a, b) in [(at(k, n), at(k + 1, n)), (at(0, k), at(0, k + 1))] {
            quad([b, b + under, a + under, a]);
        }
    }
    mesh
}

/// Follows mirrors to the end; every hit must be on a front and not below `floor`. Returns the hits and the way out.
fn follow(surface: &MeshSurface, start: Hit<u32>, along: DVec3, floor: f64) -> (usize, DVec3) {
    let (mut hit, mut along) = (start, along);
    for bounce in 1..100 {
        assert!(surface.normal(hit.place).dot(along) < 0.0, "back at {} after {bounce}", hit.point);
        assert!(hit.point.z > floor - 1e-9, "inside at {} after {bounce}", hit.point);
        along = mirror(-along, surface.normal(hit.place));
        match surface.next(&hit, along) {
            Some(next) => hit = next,
            None => return (bounce, along),
        }
    }
    panic!("caught");
}

#[test]
fn a_tilted_plane_sends_the_mirrored_ray_on_its_way() {
    for climb in [0.0, 0.25, -1.0] {
        let mesh = prism(&[(0.0, 5.0), (4.0, 5.0 + 4.0 * climb)]);
        let surface = MeshSurface::new(&mesh, 0.5).unwrap();
        assert_eq!(surface.optical_area(), (DVec2::splat(0.5), DVec2::new(3.5, WIDTH - 0.5)));
        let end = 5.0 + 4.0 * f64::from(climb);
        assert_eq!(surface.height_range(), (5.0f64.min(end), 5.0f64.max(end)));
        let light = direction(0.3, 1.0);
        let target = DVec3::new(1.0, 0.7, 5.0 + f64::from(climb));
        let hit = surface.first(target + 20.0 * light, -light).unwrap();
        assert!((hit.point - target).length() < 1e-12 && surface.kind(hit.place) == PieceKind::Relief);
        assert!((surface.normal(hit.place) - Slope::new(f64::from(climb), 0.0).normal()).length() < 1e-15);
        assert!(surface.next(&hit, mirror(light, surface.normal(hit.place))).is_none());
    }
}

#[test]
fn right_angles_send_light_back_after_two_bounces_even_from_their_edge() {
    let groove = MeshSurface::new(&prism(&[(0.0, 3.0), (1.0, 2.0), (2.0, 3.0), (3.0, 2.0), (4.0, 3.0)]), 0.0).unwrap();
    let slot = [(0.0, 3.0), (1.0, 3.0), (1.0, 2.0), (2.0, 2.0), (2.0, 3.0), (3.0, 3.0)];
    let slot = MeshSurface::new(&prism(&slot), 0.0).unwrap();
    for k in 0..1000 {
        let y = 1.0 + f64::from(k) / 1000.0;
        for x in [1.0, 3.0, 1.0 - y / 4.0, 3.0 + y / 4.0] {
            let hit = groove.first(DVec3::new(x, y, 9.0), -DVec3::Z).unwrap();
            assert_eq!(follow(&groove, hit, -DVec3::Z, 2.0).0, 2, "{x}");
            assert!((follow(&groove, hit, -DVec3::Z, 2.0).1 - DVec3::Z).length() < 1e-12);
        }
        let light = direction(0.1 + 0.6 * f64::from(k) / 1000.0, 0.0);
        let hit = slot.first(DVec3::new(1.0, y, 2.0) + 9.0 * light, -light).unwrap();
        assert!((follow(&slot, hit, -light, 2.0).1 - light).length() < 1e-12);
        // Along the wall: its upper edge is the end of the way.
        let hit = slot.first(DVec3::new(1.0, y, 9.0), DVec3::new(0.0, 0.05, -1.0)).unwrap();
        assert!(slot.kind(hit.place) == PieceKind::Relief && (hit.point.z - 3.0).abs() < 1e-12);
        // From the ridge all goes straight up.
        let hit = groove.first(DVec3::new(2.0, y, 9.0), -DVec3::Z).unwrap();
        assert!(follow(&groove, hit, -DVec3::Z, 2.0).0 <= 2);
    }
}

#[test]
fn steps_are_walls_sides_are_outer_and_triangles_without_area_are_counted() {
    let mesh = prism(&[(0.0, 2.0), (1.0, 2.0), (1.0, 1.0), (2.0, 1.0)]);
    let surface = MeshSurface::new(&mesh, 0.0).unwrap();
    // The step's underside has none, nor has one half of its front and of its back.
    assert_eq!(surface.degenerate(), 2 + 2 * 2);
    assert_eq!(surface.triangles.len(), mesh.triangles.len() - 6);
    let kind = |from: [f64; 3], to: [f64; 3]| {
        let (from, to) = (DVec3::from(from), DVec3::from(to));
        surface.first(from, to - from).map(|hit| surface.kind(hit.place))
    };
    assert_eq!(kind([1.5, 1.0, 9.0], [1.5, 1.0, 0.0]), Some(PieceKind::Relief));
    assert_eq!(kind([9.0, 1.0, 1.5], [0.0, 1.0, 1.5]), Some(PieceKind::Wall));
    assert_eq!(kind([9.0, 1.0, 0.5], [0.0, 1.0, 0.5]), Some(PieceKind::Outer));
    assert_eq!(kind([1.5, -9.0, 0.5], [1.5, 9.0, 0.5]), Some(PieceKind::Outer));
    assert_eq!(kind([1.5, 1.0, -9.0], [1.5, 1.0, 9.0]), Some(PieceKind::Outer));
    assert_eq!(kind([9.0, 9.0, 9.0], [9.0, 9.0, 0.0]), None);
    assert_eq!(surface.height_range(), (1.0, 2.0));
}

/// Distance to the nearest triangle (Möller and Trumbore 1997), all tried in turn.
fn brute_force(mesh: &Mesh, origin: DVec3, along: DVec3) -> f64 {
    let distance = |k| {
        let [a, b, c] = mesh.corners(k);
        let (ab, ac) = (b - a, c - a);
        let p = along.cross(ac);
        let (s, q) = ((origin - a) / ab.dot(p), (origin - a).cross(ab) / ab.dot(p));
        let (u, v, t) = (s.dot(p), along.dot(q), ac.dot(q));
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-7 { t } else { f64::INFINITY }
    };
    (0..mesh.triangles.len()).map(distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_tree_finds_what_brute_force_finds() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    for (climb, rays) in [(0.3, 40_000), (3.0, 40_000), (1e-3, 20_000)] {
        let mesh = field(8, climb, &mut random);
        let surface =
            if rays == 20_000 { MeshSurface::in_tree(&mesh, 0.0) } else { MeshSurface::new(&mesh, 0.0) }.unwrap();
        assert_eq!(surface.is_field(), rays != 20_000);
        for k in 0..rays {
            let target = DVec3::new(random.random(), random.random(), random.random())
                * DVec3::new(8.0, 8.0, 1.0 + f64::from(climb));
            let mut along = direction((2.0 * random.random::<f64>() - 1.0).acos(), 7.0 * random.random::<f64>());
            match k % 4 {
                0 => along.z *= 1e-3,
                1 => along[k / 4 % 3] = 0.0,
                _ => {}
            }
            let along = along.normalize();
            let origin = target - 30.0 * along;
            let hit = surface.first(origin, along);
            let expected = brute_force(&mesh, origin, along);
            let Some(hit) = hit else {
                assert_eq!(expected, f64::INFINITY, "{origin} {along}");
                continue;
            };
            assert!((hit.point - origin - expected * along).length() < 1e-9, "{origin} {along}");
            let thrown = mirror(-along, surface.normal(hit.place));
            let expected = brute_force(&mesh, hit.point, thrown);
            match surface.next(&hit, thrown) {
                None => assert_eq!(expected, f64::INFINITY, "{} {thrown}", hit.point),
                Some(next) => assert!((next.point - hit.point - expected * thrown).length() < 1e-9),
            }
        }
    }
}

#[test]
fn nothing_slips_through_edges_and_vertices() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let mesh = field(20, 0.4, &mut random);
    let surface = MeshSurface::new(&mesh, 0.0).unwrap();
    let corner = |i: u32, j: u32| DVec3::from(mesh.vertices[(j * 21 + i) as usize].map(f64::from));
    for k in 0..100_000 {
        let (i, j) = (random.random_range(1..19), random.random_range(1..19));
        let share = if k % 3 == 0 { 0.0 } else { random.random::<f64>() };
        let (di, dj) = [(1, 0), (0, 1), (1, 1)][k % 3];
        let target = corner(i, j).lerp(corner(i + di, j + dj), share);
        // Up to 45° no edge of this relief is a silhouette: what is aimed at must be met.
        let steepest = if k % 2 == 0 { 0.7 } else { 1.55 };
        let light = if k % 5 == 0 {
            DVec3::Z
        } else {
            direction(steepest * random.random::<f64>(), 7.0 * random.random::<f64>())
        };
        let Some(hit) = surface.first(target + 50.0 * light, -light) else {
            assert!(steepest > 1.0, "{k}: {target} {light}");
            continue;
        };
        assert!(steepest > 1.0 || (hit.point - target).dot(-light) < 3e-8, "{k}: {target} {light}");
        follow(&surface, hit, -light, 1.0);
    }
}

#[test]
fn rays_that_are_none_meet_nothing() {
    let surface = MeshSurface::new(&prism(&[(0.0, 2.0), (1.0, 1.0), (2.0, 2.0)]), 0.0).unwrap();
    let above = DVec3::new(0.5, 1.0, 9.0);
    let hit = surface.first(above, -DVec3::Z).unwrap();
    for bad in [f64::NAN, f64::INFINITY, 0.0, 1e-320, 1e300] {
        assert!(surface.first(above, DVec3::splat(bad)).is_none());
        assert!(surface.next(&hit, DVec3::splat(bad)).is_none());
        assert!(surface.first(DVec3::splat(bad) + 50.0, DVec3::Z).is_none());
    }
    for small in [1e-320, -1e-320, -0.0, 1e-40, -1e-10] {
        let hit = surface.first(above, DVec3::new(small, -small, -1.0)).unwrap();
        assert!((hit.point - DVec3::new(0.5, 1.0, 1.5)).length() < 1e-8);
        assert_eq!(surface.kind(surface.next(&hit, DVec3::new(1.0, small, small)).unwrap().place), PieceKind::Relief);
    }
}

#[test]
fn open_and_impossible_meshes_are_told() {
    let good = prism(&[(0.0, 2.0), (2.0, 2.0)]);
    let fail = |mesh: &Mesh, margin| MeshSurface::new(mesh, margin).err();
    assert_eq!(fail(&Mesh::default(), 0.0), Some(MeshSurfaceError::Empty));
    assert_eq!(fail(&good, 0.9), None);
    for margin in [1.0, -0.1, f64::NAN] {
        assert!(matches!(fail(&good, margin), Some(MeshSurfaceError::Margin { .. })));
    }
    let mut bad = good.clone();
    bad.triangles[3][1] = 8;
    assert_eq!(fail(&bad, 0.0), Some(MeshSurfaceError::NoSuchVertex { triangle: 3 }));
    bad.vertices[5][2] = f32::NAN;
    assert_eq!(fail(&bad, 0.0), Some(MeshSurfaceError::NotFinite { vertex: 5 }));
    let mut inside_out = good.clone();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    // Its underside faces up now.
    let surface = MeshSurface::new(&inside_out, 0.0).unwrap();
    let hit = surface.first(DVec3::new(1.2, 1.0, 9.0), -DVec3::Z).unwrap();
    assert!(surface.normal(hit.place).z < 0.0 && (hit.point.z - 2.0).abs() < 1e-12);
    inside_out.triangles.retain(|t| t.iter().any(|&v| v % 4 < 2));
    assert_eq!(fail(&inside_out, 0.0), Some(MeshSurfaceError::NoRelief));
}

#[test]
fn a_tree_deeper_than_the_crate_allows_is_searched_all_the_same() {
    let mut mesh = Mesh::default();
    for k in 0..1500 {
        let (s, z) = (0.995f32.powi(k), 1.0 - 2e-7 * k as f32);
        mesh.vertices.extend([[-s, -s, z], [s, -s, z], [0.0, s, z]]);
        mesh.triangles.push([3 * k as u32, 3 * k as u32 + 1, 3 * k as u32 + 2]);
    }
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    for triangles in [1500, 4, 3, 2, 1] {
        mesh.triangles.truncate(triangles);
        let surface = MeshSurface::in_tree(&mesh, 0.0).unwrap();
        let levels = surface.tree.as_ref().unwrap().levels();
        assert!(triangles < 1500 || levels > 96, "{levels}");
        for _ in 0..2000 {
            let target = DVec3::new(
                random.random::<f64>() - 0.5,
                random.random::<f64>() - 0.5,
                1.0 - 4e-4 * random.random::<f64>(),
            );
            let along = direction(1.6 + 1.5 * random.random::<f64>(), 7.0 * random.random::<f64>());
            let origin = target - 9.0 * along;
            let distance = surface.first(origin, along).map_or(f64::INFINITY, |hit| (hit.point - origin).length());
            let expected = brute_force(&mesh, origin, along);
            assert!(distance == expected || (distance - expected).abs() < 1e-9, "{origin} {along}");
        }
    }
}

/// `mesh` turned about z, so that its edges run along no axis.
fn turned(mesh: &Mesh, angle: f64) -> Mesh {
    let about = DVec2::from_angle(angle);
    let turn = |&[x, y, z]: &[f32; 3]| {
        let at = about.rotate(DVec2::new(f64::from(x), f64::from(y))).as_vec2();
        [at.x, at.y, z]
    };
    Mesh { vertices: mesh.vertices.iter().map(turn).collect(), triangles: mesh.triangles.clone() }
}

/// Slots 1 mm deep between flat tops, closed, in the square from 0 to 24 mm: walls that nothing shares an edge with from above.
fn slots() -> Mesh {
    let profile: Vec<(f32, f32)> = (0..24)
        .flat_map(|k| [k as f32, k as f32 + 1.0].map(|x| (x, if k % 2 == 0 { 2.0 } else { 1.0 + 0.02 * k as f32 })))
        .collect();
    let mut mesh = prism(&profile);
    mesh.vertices.iter_mut().for_each(|vertex| vertex[1] *= 24.0 / WIDTH as f32);
    mesh
}

#[test]
fn cells_and_tree_find_the_same_hits_and_the_same_ways_out() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    let mut meshes: Vec<Mesh> = [0.1, 0.4, 2.0].map(|climb| field(24, climb, &mut random)).into();
    meshes.extend([turned(&meshes[1], 0.52), slots(), turned(&slots(), 0.3)]);
    for mesh in meshes {
        let (cells, tree) = (MeshSurface::new(&mesh, 0.0).unwrap(), MeshSurface::in_tree(&mesh, 0.0).unwrap());
        assert!(cells.is_field() && !tree.is_field());
        for k in 0..40_000 {
            let light = if k % 2 == 0 {
                DVec3::Z
            } else {
                direction(1.5 * random.random::<f64>(), 7.0 * random.random::<f64>())
            };
            let target = DVec3::new(24.0 * random.random::<f64>(), 24.0 * random.random::<f64>(), 1.0);
            let origin = target + 40.0 * light;
            let (mut a, mut b) = (cells.first(origin, -light), tree.first(origin, -light));
            let mut along = -light;
            for _ in 0..6 {
                assert_eq!(a.is_some(), b.is_some(), "{origin} {light}");
                let (Some(hit), Some(other)) = (a, b) else { break };
                assert!((hit.point - other.point).length() < 1e-9, "{origin} {light}");
                along = mirror(-along, cells.normal(hit.place));
                (a, b) = (cells.next(&hit, along), tree.next(&other, along));
            }
        }
    }
}
