//! What is said of a scene itself: its lamp and wall in words, the bowl that they ask for, and whether the lamp is in the way.

use glam::{DVec2, DVec3};

use crate::lamp::Lamp;
use crate::projection::View;
use crate::raster::Raster;
use crate::scene::Scene;
use crate::slope::Slope;

/// Half the width of a lamp's housing where the lamp itself is smaller, mm: a pocket lamp.
const HOUSING: f64 = 15.0;

/// Share of the picture's light that a lamp nearby stops: rays from places all over the plate to the drawing's lit points.
pub(super) fn stopped_by_lamp(scene: &Scene, size: DVec2, target: &Raster) -> f64 {
    let Lamp::Ball { middle, radius } = *scene.lamp() else { return 0.0 };
    let radius = radius.max(HOUSING);
    let drawn = target.resampled(64, 64);
    let (mut stopped, mut all) = (0.0, 0.0);
    for place in (0..25).map(|k| DVec2::new((k % 5) as f64, (k / 5) as f64) / 5.0 - 0.4) {
        let place = (place * size).extend(0.0);
        for (k, light) in drawn.values.iter().enumerate().filter(|(_, light)| **light > 0.0) {
            let uv = View::pixel_centre(k % 64, k / 64, 64, 64);
            let Some(o) = scene.direction_to(place, uv) else { continue };
            all += light;
            let along = (middle - place).dot(o);
            let met = scene.wall().is_none_or(|wall| along < wall.depth(place) / o.dot(wall.normal()));
            if along > 0.0 && met && (middle - place - along * o).length() < radius {
                stopped += light;
            }
        }
    }
    if all > 0.0 { stopped / all } else { 0.0 }
}

/// How deep the bowl is that lamp and wall ask of a plate of `size`, mm: of the paraboloid that touches the ellipsoid with
/// foci at lamp and picture.
pub(super) fn sag(scene: &Scene, size: DVec2) -> f64 {
    let l = scene.light(DVec3::ZERO).direction;
    let (cos, along) = (l.z.max(1e-3), l.truncate().try_normalize().unwrap_or(DVec2::X));
    let height = |at: DVec2| {
        let (t, u) = (at.dot(along), at.perp_dot(along));
        (cos * t * t + u * u / cos) / (4.0 * scene.focal_length())
    };
    let corners = [size, DVec2::new(size.x, -size.y)].map(|corner| height(0.5 * corner));
    corners[0].max(corners[1])
}

/// From the picture's middle to where the flat plate would throw the lamp's light, mm on the wall.
pub(super) fn mirror_miss(scene: &Scene) -> Option<f64> {
    let uv = scene.thrown(DVec3::ZERO, Slope::FLAT)?;
    scene.wall().map(|wall| uv.length() * wall.half)
}

/// Lamp and wall in words.
pub(super) fn in_words(scene: &Scene) -> [String; 2] {
    let l = scene.light(DVec3::ZERO).direction;
    let (theta, phi) = (l.z.clamp(-1.0, 1.0).acos().to_degrees(), l.y.atan2(l.x).to_degrees());
    let angles = if theta < 0.05 {
        "straight above the plate".into()
    } else {
        format!("{theta:.0}° off the plate's normal toward {phi:.0}°")
    };
    let lamp = match *scene.lamp() {
        Lamp::Ball { radius, .. } if radius > 0.0 => {
            format!("lamp of {:.1} mm across, {:.2} m away, {angles}", 2.0 * radius, 1e-3 * scene.lamp_distance())
        }
        Lamp::Ball { .. } => format!("point of light {:.2} m away, {angles}", 1e-3 * scene.lamp_distance()),
        Lamp::Distant(_) => format!("distant lamp, {angles}"),
    };
    let wall = scene.wall().map_or("endlessly far screen".into(), |wall| {
        let slant = wall.centre.normalize_or_zero().dot(wall.normal()).clamp(-1.0, 1.0).acos().to_degrees();
        let tilt = if slant < 0.05 { String::new() } else { format!(", met at {slant:.0}° from its normal") };
        format!("wall {:.2} m away{tilt}, picture {:.0} mm wide", 1e-3 * scene.wall_distance(), 2.0 * wall.half)
    });
    [lamp, wall]
}
