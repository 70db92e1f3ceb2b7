//! Scales beside pictures: round steps, and where on an image axis an angle lies.

use glam::DVec2;

use crate::projection::View;
use crate::slope::angle_between;

/// Round steps in degrees, with the finer step that divides each.
const STEPS: [(f64, f64); 14] = [
    (0.01, 0.002),
    (0.02, 0.01),
    (0.05, 0.01),
    (0.1, 0.02),
    (0.2, 0.1),
    (0.5, 0.1),
    (1.0, 0.2),
    (2.0, 1.0),
    (5.0, 1.0),
    (10.0, 5.0),
    (15.0, 5.0),
    (20.0, 10.0),
    (30.0, 10.0),
    (45.0, 15.0),
];

/// A mark on an image axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tick {
    /// Signed angle from the image's centre, degrees: positive toward +u or +v.
    pub angle: f64,
    /// u or v, in [-1, 1].
    pub position: f64,
    /// Whether it carries a label.
    pub labelled: bool,
}

/// Ticks along the image axis `along` (`DVec2::X` for u, `DVec2::Y` for v) through the image's centre, ascending.
///
/// The position of a tick is where the direction seen there really stands that far from the centre's direction,
/// found through the view itself, so that the scale is true for every projection and lamp.
pub(crate) fn ticks(view: &View, along: DVec2) -> Vec<Tick> {
    let half_field = view.half_field().to_degrees();
    let (coarse, fine) =
        STEPS.into_iter().find(|(step, _)| 2.0 * half_field / step <= 6.0 + 1e-9).unwrap_or(STEPS[STEPS.len() - 1]);
    // Under a slanting lamp one side of an orthographic image reaches farther than the half field.
    let most = (180.0 / fine).min(4.0 * half_field / fine) as i64 + 1;
    let per_label = (coarse / fine).round() as i64;
    (-most..=most)
        .filter_map(|k| {
            let angle = k as f64 * fine;
            let position = position(view, along, angle.to_radians())?;
            Some(Tick { angle, position, labelled: k % per_label == 0 })
        })
        .collect()
}

/// Where along the image axis `along` the direction seen stands `angle` radians (signed) from the centre's;
/// `None` outside [-1, 1].
pub fn position(view: &View, along: DVec2, angle: f64) -> Option<f64> {
    let side = if angle < 0.0 { -1.0 } else { 1.0 };
    // Where nothing projects, everything has been passed.
    let reached = |t: f64| {
        view.inverse(along * (side * t)).map_or(f64::INFINITY, |o| angle_between(o, view.centre())) - angle.abs()
    };
    if angle == 0.0 {
        return Some(0.0);
    }
    // The rim itself belongs to the image; the angle grows steadily along the axis in every projection.
    let edge = reached(1.0);
    if edge.abs() < 1e-9 {
        return Some(side);
    }
    if edge.is_nan() || edge < 0.0 {
        return None;
    }
    let (mut near, mut far) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (near + far);
        if reached(middle) < 0.0 { near = middle } else { far = middle }
    }
    // The bisection also ends on the brink of the hemisphere, where no direction has the angle. The square root
    // there makes the angle steep in the position, hence the wide tolerance.
    (reached(near).abs() < 1e-4).then_some(side * near)
}

/// The largest of 1, 2, 5 × 10^k not above `limit`; `None` unless `limit` is a positive number.
pub(crate) fn round_below(limit: f64) -> Option<f64> {
    if !(limit > 0.0 && limit.is_finite()) {
        return None;
    }
    let decade = 10f64.powf(limit.log10().floor());
    [10.0, 5.0, 2.0, 1.0, 0.5].into_iter().map(|m| m * decade).find(|v| *v <= limit * (1.0 + 1e-9))
}

/// `value` with as many decimals as it needs, three at most, and a true minus sign: "0.5", "20", "−7.25".
pub fn number(value: f64) -> String {
    let text = format!("{:.3}", value.abs());
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if value < 0.0 && text != "0" { format!("−{text}") } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::Projection;
    use crate::slope::{direction, flat_mirror};
    use glam::DVec3;

    #[test]
    fn positions_are_the_closed_forms_of_the_projections() {
        let h = f64::to_radians(20.0);
        for degrees in [-20.0f64, -10.0, -0.5, 0.0, 5.0, 19.0, 20.0] {
            let a = degrees.to_radians();
            for (projection, expected) in [
                (Projection::Orthographic, a.sin() / h.sin()),
                (Projection::Equidistant, a / h),
                (Projection::Screen, a.tan() / h.tan()),
            ] {
                for along in [DVec2::X, DVec2::Y] {
                    let found = position(&View::new(projection, h, DVec3::Z), along, a).unwrap();
                    assert!((found - expected).abs() < 1e-9, "{projection:?} {degrees} {found} {expected}");
                }
            }
        }
        assert_eq!(position(&View::new(Projection::Screen, h, DVec3::Z), DVec2::X, 0.36), None);
    }

    #[test]
    fn under_a_slanting_lamp_the_orthographic_scale_is_lopsided() {
        // Lamp at 40° from +x: c leans toward -x, and u follows the sine of the angle from the plate's normal.
        let (lean, h) = (f64::to_radians(40.0), f64::to_radians(20.0));
        let view = View::new(Projection::Orthographic, h, flat_mirror(direction(lean, 0.0)));
        for degrees in [-15.0f64, -5.0, 5.0, 10.0] {
            let a = degrees.to_radians();
            let expected = ((a - lean).sin() + lean.sin()) / h.sin();
            assert!((position(&view, DVec2::X, a).unwrap() - expected).abs() < 1e-9);
        }
        // At 60° part of the image lies beyond the horizon: no tick may stand there.
        let view = View::new(Projection::Orthographic, h, flat_mirror(direction(lean * 1.5, 0.0)));
        assert_eq!(position(&view, DVec2::X, f64::to_radians(-31.0)), None);
        assert!(ticks(&view, DVec2::X).iter().all(|t| view.inverse(DVec2::X * t.position).is_some()));
    }

    #[test]
    fn ticks_ascend_reach_the_rim_and_carry_round_labels() {
        for (half, labels) in [(20.0, 5), (15.0, 7), (30.0, 7), (5.0, 5), (0.5, 5), (45.0, 7)] {
            let view = View::new(Projection::Orthographic, f64::to_radians(half), DVec3::Z);
            let all = ticks(&view, DVec2::Y);
            assert!(all.windows(2).all(|w| w[0].position < w[1].position && w[0].angle < w[1].angle));
            let labelled: Vec<_> = all.iter().filter(|t| t.labelled).collect();
            assert_eq!(labelled.len(), labels, "{half}");
            assert!(labelled.iter().any(|t| t.angle == 0.0 && t.position == 0.0));
        }
        let view = View::new(Projection::Screen, f64::to_radians(20.0), DVec3::Z);
        assert_eq!(ticks(&view, DVec2::X).last().unwrap().position, 1.0);
        for odd in [0.0, 1e-9, std::f64::consts::FRAC_PI_2, 3.0, f64::NAN] {
            for projection in [Projection::Orthographic, Projection::Equidistant, Projection::Screen] {
                let _ = ticks(&View::new(projection, odd, DVec3::Z), DVec2::X);
            }
        }
    }

    #[test]
    fn numbers_are_round_and_short() {
        let cases = [(7.0, 5.0), (10.0, 10.0), (9.99, 5.0), (0.3, 0.2), (1e-3, 1e-3), (2.0, 2.0)];
        for (limit, expected) in cases {
            assert!((round_below(limit).unwrap() / expected - 1.0).abs() < 1e-9, "{limit}");
        }
        assert_eq!(round_below(0.0), None);
        assert_eq!(round_below(f64::NAN), None);
        assert_eq!([-20.0, 0.0, -0.0, 0.5, -7.25, 1000.0].map(number), ["−20", "0", "0", "0.5", "−7.25", "1000"]);
    }
}
