//! How deep a relief is, its tilt as a whole aside.

use glam::{DMat2, DVec2, DVec3};

/// From the lowest to the highest of `points` about the plane that fits them best, mm; 0 of none.
///
/// A cutter meets no deeper walls than these: stock over a plate that is tilted as a whole is roughed away.
pub fn depth_about_plane(points: impl Iterator<Item = DVec3> + Clone) -> f64 {
    let count = points.clone().count().max(1) as f64;
    let mean = points.clone().sum::<DVec3>() / count;
    let (mut spread, mut rise) = (DMat2::ZERO, DVec2::ZERO);
    for point in points.clone() {
        let from = point - mean;
        spread += DMat2::from_cols(from.x * from.truncate(), from.y * from.truncate());
        rise += from.z * from.truncate();
    }
    // Of points on one line no plane is known.
    let flat = spread.determinant() <= 1e-9 * (spread.x_axis.x + spread.y_axis.y).powi(2);
    let slope = if flat { DVec2::ZERO } else { spread.inverse() * rise };
    let above = points.map(|point| point.z - slope.dot((point - mean).truncate()));
    let (low, high) = above.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
    (high - low).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilt_is_no_depth() {
        let tilted = |bump: f64| {
            (0..121).map(move |k| {
                let (x, y) = (f64::from(k % 11), f64::from(k / 11));
                // A wave of whole periods over its eleven points has no tilt of its own.
                DVec3::new(x, y, 3.0 + 0.2 * x - 0.1 * y + bump * (std::f64::consts::TAU * x / 5.0).cos())
            })
        };
        assert!(depth_about_plane(tilted(0.0)) < 1e-12);
        assert!((depth_about_plane(tilted(0.5)) - 0.5 * (1.0 + (0.2 * std::f64::consts::PI).cos())).abs() < 0.02);
        assert_eq!(depth_about_plane(std::iter::empty()), 0.0);
        assert_eq!(depth_about_plane([DVec3::ZERO, DVec3::new(1.0, 0.0, 2.0)].into_iter()), 2.0);
    }
}
