use std::f64::consts::FRAC_PI_2;

use super::spec::{GoalFile, GoalSpecError};
use super::*;
use crate::projection::Projection;
use crate::setup::Setup;
use crate::slope::direction;

fn read(text: &str, part: GoalPart, light: DVec3) -> Goal {
    Goal::read(&text.parse().unwrap(), part, light).unwrap()
}

#[test]
fn a_goal_is_written_as_it_is_read_and_nonsense_is_told() {
    for text in [
        "ward:0.1,0.3",
        "ggx:0.2,0.05,30",
        "lambert:0.2+ggx:0.2:0.5",
        "lafortune:-0.9,-0.9,1,20",
        "lafortune:lobes.toml",
        "merl:a/gold.binary",
        "csv:brdf.csv",
        "ndf:star.png",
        "ndf:star, mine.png,45",
    ] {
        assert_eq!(text.parse::<GoalSpec>().unwrap().to_string(), text);
    }
    let star: GoalSpec = "ndf:star, mine.png,45".parse().unwrap();
    assert_eq!(star, GoalSpec::File { kind: GoalFile::Ndf, path: "star, mine.png".into(), tilt: Some(45.0) });
    assert_eq!("merl:".parse::<GoalSpec>(), Err(GoalSpecError::NoFile("merl")));
    assert_eq!("ndf:a.png,95".parse::<GoalSpec>(), Err(GoalSpecError::Tilt(95.0)));
    for (text, part) in [("bras", "'bras' is no goal; known are the models lambert"), ("ward:x", "'x' in a model")] {
        assert!(text.parse::<GoalSpec>().unwrap_err().to_string().contains(part), "{text}");
    }
    let missing = Goal::read(&"merl:nowhere.binary".parse().unwrap(), GoalPart::All, DVec3::Z).unwrap_err();
    assert_eq!(missing.to_string(), "nowhere.binary: there is no such file; check the path");
    let even = Goal::read(&"lambert:0.5".parse().unwrap(), GoalPart::Specular, DVec3::Z).unwrap_err();
    assert!(even.to_string().contains("--goal-part all"));
}

#[test]
fn the_field_holds_the_light_and_the_hemisphere_the_albedo() {
    let light = direction(0.3, 1.0);
    for (text, projection) in [("ward:0.1,0.3", Projection::Orthographic), ("ggx:0.1", Projection::Equidistant)] {
        let goal = read(text, GoalPart::Specular, light);
        let half_field = goal.half_field(&Setup::new(0.3, 1.0, 0.0, projection, 0.5)).unwrap();
        let setup = Setup::new(0.3, 1.0, 0.0, projection, half_field.to_radians());
        let picture = goal.picture(&setup).unwrap();
        // f cosθ dω over the picture's pixels.
        let side = picture.light.width;
        let inside: f64 = (0..side * side)
            .map(|k| {
                let uv = crate::projection::View::pixel_centre(k % side, k / side, side, side);
                let share = setup.view().solid_angle_density(uv) * 4.0 / (side * side) as f64;
                setup.viewer_at(uv).map_or(0.0, |o| picture.light.values[k] * o.z * share)
            })
            .sum();
        let whole = goal.hemisphere(light, 360).sum();
        assert!((0.985..0.996).contains(&(inside / whole)), "{text} {half_field}: {}", inside / whole);
        let [all, wanted] = goal.albedos(light);
        assert!((all - wanted).abs() < 1e-12 && (all - whole).abs() < 1e-9);
        let model: crate::brdf::model::named::Named = text.parse().unwrap();
        assert!((model.albedo(light) - whole).abs() < 5e-3, "{text}: {whole}");
    }
    // An even base is told apart.
    let [all, wanted] = read("lambert:0.3+ggx:0.1:0.5", GoalPart::Specular, light).albedos(light);
    assert!((all - wanted - 0.3).abs() < 5e-3, "{all} {wanted}");
}

#[test]
fn mirrors_follow_what_is_made_of_mirrors_and_not_wards_own_factor() {
    let (first, side) = (DVec3::Z, 128);
    let setup = Setup::new(0.0, 0.0, 0.0, Projection::Orthographic, 1.4);
    let apart = |text: &str, theta: f64| {
        let goal = read(text, GoalPart::Specular, first);
        let light = direction(theta, FRAC_PI_2);
        let (a, b) = (goal.hemisphere(light, side).normalised(), goal.mirrored(&setup, light, side).normalised());
        a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs()).sum::<f64>() / 2.0
    };
    for text in ["ggx:0.2", "ward:0.1,0.3", "blinn-phong:40"] {
        assert!(apart(text, 0.0) < 0.012, "{text}: {}", apart(text, 0.0));
    }
    let (ward, smith) = (apart("ward:0.1,0.3", 0.5), apart("beckmann:0.1,0.3", 0.5));
    assert!(ward > 0.03 && smith < 0.01, "{ward} {smith}");
    let even = read("lambert:0.5", GoalPart::All, first).hemisphere(first, side);
    assert!((in_plane(&even, 0.3, 1.0).unwrap() - 0.5 / std::f64::consts::PI).abs() < 1e-3);
    assert_eq!(in_plane(&even, FRAC_PI_2, 1.0), None);
}
