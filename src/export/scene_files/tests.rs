use std::f64::consts::FRAC_PI_2;

use super::*;
use crate::export::solid::solid;
use crate::lamp::{DistantLamp, Extent};
use crate::projection::Projection;
use crate::relief::faceted::{Facet, FacetedRelief};
use crate::setup::Setup;
use crate::slope::{Slope, direction};

const FLAT: Facet = Facet { height: 0.0, slope: Slope::FLAT };

/// A plate of 4 × 2 mm with a rim, under a lamp, seen far away.
fn lit(setup: &Setup, lamp: &Lamp, rim_shines: bool) -> LitPlate {
    let relief = FacetedRelief::uniform(4, 2, DVec2::new(4.0, 2.0), vec![FLAT; 8]).with_rim(1.0);
    let mesh = solid(&relief, 2.0, &Progress::silent()).unwrap();
    let area = relief.optical_area();
    let origin = (0.5 * (area.0 + area.1)).extend(0.0);
    let plate = MirrorPlate { mesh: &mesh, area, origin, rim_shines, roughness: 0.0 };
    LitPlate::new(&plate, lamp, &Shown::Far(setup, Facing::FromAbove), &Progress::silent()).unwrap()
}

fn area_of(mesh: &Mesh) -> f64 {
    let area = |k: usize| {
        let [a, b, c] = mesh.corners(k);
        0.5 * (b - a).cross(c - a).length()
    };
    (0..mesh.triangles.len()).map(area).sum()
}

#[test]
fn the_optical_area_mirrors_and_the_rest_is_dull_unless_the_rim_shines() {
    let setup = Setup::new(0.0, 0.0, 0.0, Projection::Orthographic, 0.3);
    let lamp = setup.lamp().into();
    for (rim_shines, bright) in [(false, 8.0), (true, 24.0)] {
        let lit = lit(&setup, &lamp, rim_shines);
        assert!((area_of(&lit.mirror) - bright).abs() < 1e-5, "{}", area_of(&lit.mirror));
        // Top, base and sides of 6 × 4 × 2 mm.
        assert!((area_of(&lit.mirror) + area_of(&lit.body) - 88.0).abs() < 1e-4);
    }
}

/// Where a camera sees a point, in image coordinates of a map seen from above.
fn seen(camera: &Camera, point: DVec3) -> DVec2 {
    let ahead = (camera.target - camera.eye).normalize();
    let left = camera.up.cross(ahead);
    let way = point - camera.eye;
    let at = DVec2::new(way.dot(left), way.dot(camera.up)) / way.dot(ahead) / (0.5 * camera.field).tan();
    if camera.mirrored { at } else { DVec2::new(-at.x, at.y) }
}

#[test]
fn a_camera_sees_every_direction_where_the_image_has_it() {
    for projection in [Projection::Orthographic, Projection::Equidistant, Projection::Screen] {
        let flat = Setup::new(0.6, 2.0, 0.0, projection, 0.35);
        for setup in [flat.clone(), flat.mounted(direction(0.2, -1.0))] {
            let lit = lit(&setup, &setup.lamp().into(), false);
            let mut met = 0;
            for vertex in &lit.screen.mesh.vertices {
                let point = DVec3::from(vertex.map(f64::from));
                let o = (point - lit.middle).normalize_or_zero();
                // Rims may lie a rounding beside the image, and a place that no light can reach lies by the plate.
                let Some(uv) = setup.image_of(o) else { continue };
                assert!((seen(&lit.camera, point) - uv).length() < 2e-3, "{projection:?} {uv}");
                met += 1;
            }
            // Corners of an image may lie beyond the horizon.
            let there = |i: usize, j: usize| setup.viewer_at(DVec2::new(i as f64, j as f64) / 48.0 - 1.0).is_some();
            let directions = (0..97 * 97).filter(|k| there(k % 97, k / 97)).count();
            assert!(met <= directions && met as f64 > 0.95 * directions as f64, "{met} of {directions}");
            let filled = 2.0 * lit.screen.mesh.triangles.len() as f64 / (96.0 * 96.0);
            // Every triangle looks to the plate, and seen by the camera they fill the image.
            let mut area = 0.0;
            for k in 0..lit.screen.mesh.triangles.len() {
                let corners = lit.screen.mesh.corners(k);
                let [a, b, c] = corners.map(|corner| seen(&lit.camera, corner));
                area += 0.5 * (b - a).perp_dot(c - a).abs();
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                assert!(normal.dot(lit.middle - corners[0]) > 0.0);
            }
            assert!((area - filled).abs() < 0.01, "{area} {filled}");
            assert!(lit.screen.reflectance.iter().all(|share| (0.0..=0.01).contains(share)));
        }
    }
}

#[test]
fn a_sheet_shines_on_all_of_the_plate_from_every_part_of_the_lamp() {
    let toward = direction(0.7, 1.0);
    for extent in [Extent::Point, Extent::round(0.05)] {
        let setup = Setup::under(DistantLamp { direction: toward, extent: extent.clone() }, Projection::Screen, 0.3);
        let lit = lit(&setup, &setup.lamp().into(), false);
        let Beam::Parallel(sheet) = &lit.beam else { panic!() };
        let mut mean = DVec3::ZERO;
        for k in 0..sheet.mesh.triangles.len() {
            let [a, b, c] = sheet.mesh.corners(k);
            let shines = (b - a).cross(c - a).normalize();
            // Single precision turns a tile of a 512th of the sheet by up to 0.02°.
            assert!(shines.angle_between(-toward) <= extent.reach() + 4e-4);
            mean += shines / sheet.mesh.triangles.len() as f64;
        }
        assert!(mean.angle_between(-toward) < 1e-3, "{mean}");
        // What crosses the flat plate is the flux of the image's unit.
        let across = sheet.irradiance * 8.0 * toward.z;
        assert!((across / lit.screen.flux() - 1.0).abs() < 1e-9);
        // Its shadow along the beam holds the plate's corners.
        let (e1, e2) = crate::projection::carried_axes(toward);
        let flat = |v: DVec3| DVec2::new(v.dot(e1), v.dot(e2));
        let places = sheet.mesh.vertices.iter().map(|v| flat(DVec3::from(v.map(f64::from))));
        let (low, high) =
            places.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        for corner in [(0.0, 0.0), (4.0, 0.0), (0.0, 2.0), (4.0, 2.0)] {
            let at = flat(DVec3::new(corner.0, corner.1, 0.0));
            assert!((at.cmpge(low - 1e-4) & at.cmple(high + 1e-4)).all());
        }
    }
}

#[test]
fn spots_of_a_ball_shine_on_all_of_the_plate() {
    let setup = Setup::new(0.0, 0.0, 0.0, Projection::Screen, 0.3);
    for middle in [DVec3::new(30.0, 10.0, 40.0), DVec3::new(0.0, 1000.0, 4000.0)] {
        let lit = lit(&setup, &Lamp::Ball { middle, radius: 2.0 }, false);
        let Beam::Spots { places, cone, .. } = &lit.beam else { panic!() };
        assert!(*cone < FRAC_PI_2);
        for place in places {
            assert!((*place - lit.middle - middle).length() <= 2.01);
            for corner in [(0.0, 0.0), (4.0, 0.0), (0.0, 2.0), (4.0, 2.0)] {
                let way = DVec3::new(corner.0, corner.1, 0.0) - *place;
                assert!(way.angle_between(lit.middle - *place) < *cone);
            }
        }
    }
    assert!(Beam::is_parallel(&Lamp::Ball { middle: DVec3::new(0.0, 0.0, 5000.0), radius: 1.0 }, 4.5));
}

#[test]
fn a_gltf_file_counts_its_bytes_and_is_the_same_every_time() {
    let setup = Setup::new(0.3, 0.0, 0.0, Projection::Orthographic, 0.3);
    let lit = lit(&setup, &setup.lamp().into(), false);
    let mut file = Vec::new();
    lit.write_gltf("a plate", &mut file).unwrap();
    let word = |at: usize| u32::from_le_bytes(*file[at..].first_chunk().unwrap()) as usize;
    assert_eq!((&file[..4], word(4), word(8)), (b"glTF".as_slice(), 2, file.len()));
    let text = word(12);
    let json: serde_json::Value = serde_json::from_slice(&file[20..20 + text]).unwrap();
    assert_eq!(word(20 + text), file.len() - 28 - text);
    assert_eq!(json["buffers"][0]["byteLength"], word(20 + text));
    assert_eq!(json["accessors"][0]["count"], lit.mirror.vertices.len());
    let mut again = Vec::new();
    lit.write_gltf("a plate", &mut again).unwrap();
    assert_eq!(file, again);
    let mut xml = Vec::new();
    lit.write_mitsuba("a plate -- with dashes", &mut xml).unwrap();
    let xml = String::from_utf8(xml).unwrap();
    assert!(xml.contains("a plate - - with") && xml.contains("scene_lamp.ply") && xml.ends_with("</scene>\n"));
}
