//! A rim around the optical area: how wide, and how steeply it falls outward.

use crate::setup::Setup;
use crate::slope::{Slope, angle_between, mirror};

/// A rim that starts level with the relief's lowest point, so that it shades nothing, and is flat or falls outward.
///
/// ```text
///              ___/\_/\/\__
///        _____|            |_____        flat          ,-|            |-.
///                                                  _.-'  |            |  '-._    falling
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rim {
    /// Width on each side, mm; 0: there is none.
    pub width: f64,
    /// Tangent of the angle by which its four sides fall outward; its corners fall along both axes at once.
    pub fall: f64,
}

/// Steps in which an angle that sends light past the picture is looked for, and the steepest, degrees.
const STEP: f64 = 0.25;
const STEEPEST: f64 = 60.0;

impl From<f64> for Rim {
    /// A flat rim of that width, mm.
    fn from(width: f64) -> Self {
        Self { width, fall: 0.0 }
    }
}

impl Rim {
    /// The slopes of its pieces: west, east, south, north, then the corners.
    pub fn slopes(self) -> [Slope; 8] {
        let f = self.fall;
        [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)]
            // Adding zero turns -0 into 0.
            .map(|(p, q)| Slope::new(f64::from(p) * f + 0.0, f64::from(q) * f + 0.0))
    }

    /// Height that it falls from the relief's foot to its lowest point, which is at its corners, mm.
    pub fn depth(self) -> f64 {
        2.0 * self.width.max(0.0) * self.fall
    }

    /// A rim of `width` mm that falls by the least angle at which every piece of it sends light `clear` radians past
    /// the image of `setup`; by the steepest that is tried, 60°, if none does.
    pub fn past_image(setup: &Setup, width: f64, clear: f64) -> Self {
        let rim = |degrees: f64| Self { width, fall: degrees.to_radians().tan() };
        let passes = |rim: &Self| rim.slopes().into_iter().all(|slope| beside_image(setup, slope) >= clear);
        let steps = (STEEPEST / STEP) as u32;
        (1..=steps).map(|k| rim(f64::from(k) * STEP)).find(passes).unwrap_or_else(|| rim(STEEPEST))
    }
}

/// By what angle the light of `slope` passes the image of `setup`, radians: 0 within it, infinite in no light and where no
/// image is.
fn beside_image(setup: &Setup, slope: Slope) -> f64 {
    if slope.intercept(setup.light()) <= 0.0 {
        return f64::INFINITY;
    }
    let o = mirror(setup.light(), slope.normal());
    let Some(uv) = setup.image_of(o) else { return f64::INFINITY };
    let nearest = uv.clamp(glam::DVec2::NEG_ONE, glam::DVec2::ONE);
    setup.viewer_at(nearest).map_or(f64::INFINITY, |viewer| if nearest == uv { 0.0 } else { angle_between(o, viewer) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::Projection;

    #[test]
    fn the_least_fall_that_clears_the_image_is_taken() {
        // Overhead, a tilt t throws light 2t aside: 20° of field and 2° of clearance ask for 11°.
        let setup = Setup::new(0.0, 0.0, 0.0, Projection::Screen, f64::to_radians(20.0));
        let rim = Rim::past_image(&setup, 3.0, f64::to_radians(2.0));
        assert!((rim.fall.atan().to_degrees() - 11.0).abs() < 1e-9, "{rim:?}");
        assert!((rim.depth() - 6.0 * f64::to_radians(11.0).tan()).abs() < 1e-12);
        // Aslant every piece must pass, and those across the plane of incidence throw light less far.
        for (theta, projection) in [(45.0f64, Projection::Screen), (60.0, Projection::Orthographic)] {
            let setup = Setup::new(theta.to_radians(), 1.2, 0.0, projection, f64::to_radians(20.0));
            let rim = Rim::past_image(&setup, 3.0, 0.0349);
            assert!(rim.slopes().into_iter().all(|slope| beside_image(&setup, slope) >= 0.0349), "{theta}");
            let less = Rim { fall: (rim.fall.atan() - f64::to_radians(STEP)).tan(), ..rim };
            assert!(less.slopes().into_iter().any(|slope| beside_image(&setup, slope) < 0.0349), "{theta}");
        }
        assert_eq!(beside_image(&setup, Slope::FLAT), 0.0);
    }
}
