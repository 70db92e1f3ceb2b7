use super::room::{Room, RoomError, RoomFault};
use super::*;
use crate::setup::Setup;
use crate::slope::direction;

/// The lamp of a plate on a table, 0.5 m away at 45°.
fn lamp(radius: f64) -> Lamp {
    Lamp::Ball { middle: 500.0 * direction(f64::to_radians(45.0), f64::to_radians(90.0)), radius }
}

fn scenes() -> [Scene; 3] {
    let sun = DistantLamp::round(direction(0.4, 1.0), 0.0);
    [
        Scene::across_mirror(lamp(0.0), 1414.0, f64::to_radians(-20.0), 350.0),
        Scene::across_mirror(sun.into(), 700.0, 0.3, 200.0),
        Scene::endless(lamp(0.0), f64::to_radians(20.0)),
    ]
}

const TABLE_TOP: &str = "\
[plate]
at = [0, 0, 750]
facing = [0, 0, 1]
top = [0, 1, 0]
[lamp]
at = [0, 353.5534, 1103.5534]
radius = 2.5
[wall]
through = [0, -1000, 0]
facing = [0, 1, 0]
[picture]
centre = [0, -1000, 1750]
width = 700
up = [0, 0, 1]
";

#[test]
fn slopes_and_image_positions_are_inverse_at_every_place() {
    for scene in scenes() {
        for place in [DVec3::ZERO, DVec3::new(15.0, -15.0, 0.4), DVec3::new(-7.0, 12.0, -0.2)] {
            for uv in [DVec2::ZERO, DVec2::new(0.7, -0.2), DVec2::new(-0.9, 0.9)] {
                let slope = scene.slope_for(place, uv).unwrap();
                assert!((scene.thrown(place, slope).unwrap() - uv).length() < 1e-9);
            }
        }
        assert!(scene.slope_for(DVec3::ZERO, DVec2::ZERO).unwrap().to_vec().length() < 1e-12);
    }
}

#[test]
fn the_jacobian_says_where_a_slope_nearby_throws() {
    for scene in scenes() {
        let (place, slope) = (DVec3::new(10.0, -4.0, 0.1), Slope::new(0.05, -0.08));
        let jacobian = scene.jacobian(place, slope).unwrap();
        let step = DVec2::new(3e-4, -2e-4);
        let there = scene.thrown(place, Slope::from_vec(slope.to_vec() + step)).unwrap();
        let expected = scene.thrown(place, slope).unwrap() + jacobian * step;
        assert!((there - expected).length() < 1e-3 * (jacobian * step).length());
    }
}

#[test]
fn the_view_from_the_middle_is_what_slopes_there_light() {
    for scene in scenes() {
        let view = scene.view().unwrap();
        for uv in [DVec2::ZERO, DVec2::new(0.7, -0.2), DVec2::new(-0.9, 0.9)] {
            let o = scene.direction_to(DVec3::ZERO, uv).unwrap();
            assert!((view.inverse(uv).unwrap() - o).length() < 1e-12);
            assert!((view.forward(o).unwrap() - uv).length() < 1e-9);
        }
    }
}

#[test]
fn far_lamps_and_walls_are_the_far_scene() {
    // Of a lamp 10 km and a wall 20 km away, with the picture as large as 20° see it.
    let (theta, phi, half_field) = (0.6, 2.0, f64::to_radians(20.0));
    let far = Setup::new(theta, phi, 0.0, Projection::Screen, half_field);
    let lamp = Lamp::Ball { middle: 1e7 * direction(theta, phi), radius: 0.0 };
    let near = Scene::across_mirror(lamp, 2e7, 0.0, 2e7 * half_field.tan());
    let endless = Scene::endless(DistantLamp::round(direction(theta, phi), 0.0).into(), half_field);
    for place in [DVec3::ZERO, DVec3::new(15.0, -15.0, 0.4)] {
        for slope in [Slope::FLAT, Slope::new(0.1, -0.05)] {
            let expected = far.image_of_slope(slope).unwrap();
            assert!((near.thrown(place, slope).unwrap() - expected).length() < 1e-5);
            assert!((endless.thrown(place, slope).unwrap() - expected).length() < 1e-12);
            let share = slope.intercept(far.light()) / far.light().z;
            assert!((near.mass(place, slope) / share - 1.0).abs() < 1e-5);
            assert!((endless.mass(place, slope) / share - 1.0).abs() < 1e-12);
        }
    }
    assert_eq!(endless.focal_length(), f64::INFINITY);
    assert!((scenes()[0].focal_length() - 1.0 / (1.0 / 500.0 + 1.0 / 1414.0)).abs() < 1e-9);
}

#[test]
fn a_flat_mirror_throws_a_lamp_to_where_its_mirror_image_shows() {
    // The lamp's image lies as far below the plate; the ray through a place comes from there.
    let scene = Scene::across_mirror(lamp(0.0), 1000.0, 0.0, 300.0);
    let Lamp::Ball { middle, .. } = *scene.lamp() else { panic!() };
    let image = middle * DVec3::new(1.0, 1.0, -1.0);
    let (wall, place) = (scene.wall().unwrap(), DVec3::new(9.0, -6.0, 0.0));
    let at = wall.point(scene.thrown(place, Slope::FLAT).unwrap());
    assert!((at - image).normalize().dot((place - image).normalize()) > 1.0 - 1e-12);
    assert!(wall.depth(at).abs() < 1e-9);
}

#[test]
fn a_room_is_the_same_scene_as_flags_say() {
    // 45° to the lamp toward the plate's y, so that the mirror direction rises at 45° toward -y: 1414 mm to a wall 1 m away.
    let room = Room::from_toml(TABLE_TOP).unwrap();
    let measured = room.scene(1.0).unwrap();
    let flags = Scene::across_mirror(lamp(2.5), 2f64.sqrt() * 1000.0, f64::to_radians(45.0), 350.0);
    let (a, b) = (measured.wall().unwrap(), flags.wall().unwrap());
    assert!((a.centre - b.centre).length() < 1e-3);
    // With a lamp toward +y the picture is upright once seen on the wall: u to the left, v up.
    assert!((a.u - b.u).length() < 1e-6 && (a.v - b.v).length() < 1e-6, "{a:?} {b:?}");
    assert!((a.normal() - DVec3::new(0.0, -1.0, 0.0)).length() < 1e-9);
    let found = Room { picture: super::room::RoomPicture { centre: None, ..room.picture }, ..room };
    assert!((found.scene(1.0).unwrap().wall().unwrap().centre - a.centre).length() < 1e-3);
    assert_eq!(room.scene(1.5).unwrap().wall().unwrap().half, 525.0);
    assert_eq!(measured.check(DVec2::splat(30.0), 1.0), Ok(()));
    assert_eq!(toml::from_str::<Room>(&toml::to_string(&room).unwrap()).unwrap(), room);
}

#[test]
fn what_is_wrong_with_a_room_is_told_with_its_line() {
    let faulty = |from: &str, to: &str| Room::from_toml(&TABLE_TOP.replace(from, to)).unwrap_err();
    let fault = |from: &str, to: &str| match faulty(from, to) {
        RoomError::Fault { line, fault } => (line, fault),
        other => panic!("{other}"),
    };
    assert!(matches!(faulty("top =", "tops ="), RoomError::Unreadable { line: 4, .. }));
    assert!(matches!(faulty("width = 700\n", ""), RoomError::Unreadable { .. }));
    assert_eq!(fault("-1000, 1750", "-998, 1750"), (12, RoomFault::OffWall { off: 2.0 }));
    assert_eq!(fault("up = [0, 0, 1]", "up = [0, 2, 0]").0, 14);
    assert_eq!(fault("top = [0, 1, 0]", "top = [0, 0, -3]"), (4, RoomFault::Parallel { table: "plate", key: "top" }));
    assert_eq!(fault("facing = [0, 1, 0]", "facing = [0, 0, 0]").0, 10);
    assert_eq!(fault("radius = 2.5", "sun = [0, 0]"), (5, RoomFault::LampOrSun));
    assert_eq!(fault("radius = 2.5", "radius = -1"), (7, RoomFault::Radius { radius: -1.0 }));
    assert_eq!(fault("width = 700", "width = nan").0, 13);
}

#[test]
fn scenes_that_cannot_be_are_refused_with_a_figure() {
    let size = DVec2::splat(30.0);
    let refused = |scene: &Scene| scene.check(size, 1.0).unwrap_err();
    let behind = Lamp::Ball { middle: DVec3::new(300.0, 0.0, -20.0), radius: 0.0 };
    assert!(matches!(refused(&Scene::endless(behind, 0.3)), SceneError::LampBehind { angle } if angle < -3.0));
    let touching = Lamp::Ball { middle: DVec3::new(0.0, 0.0, 20.0), radius: 19.5 };
    assert!(matches!(refused(&Scene::endless(touching, 0.3)), SceneError::LampInPlate { .. }));
    let edge = Scene::across_mirror(lamp(0.0), 1000.0, f64::to_radians(88.0), 300.0);
    assert!(matches!(refused(&edge), SceneError::EdgeOn { angle } if (angle - 2.0).abs() < 1e-6));
    let near = Scene::across_mirror(lamp(0.0), 9.0, 0.0, 3.0);
    assert!(matches!(refused(&near), SceneError::WallInPlate { beyond, .. } if beyond > 1.0));
    let WallPicture { centre, u, v, half } = *scenes()[0].wall().unwrap();
    let turned = WallPicture { centre, u: v, v: u, half };
    assert_eq!(refused(&Scene::new(lamp(0.0), Screen::Wall(turned))), SceneError::WrongSide);
    let below = WallPicture { centre: DVec3::new(0.0, -1000.0, -50.0), u, v, half };
    assert!(matches!(refused(&Scene::new(lamp(0.0), Screen::Wall(below))), SceneError::PictureBehind { .. }));
    scenes().iter().for_each(|scene| assert_eq!(scene.check(size, 1.0), Ok(())));
}
