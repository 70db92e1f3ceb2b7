//! What blurs a highlight between the mirrors and the eye: the lamp's disc and the metal's lobe.

use glam::{DMat2, DVec2, DVec3};

use crate::projection::carried_axes;
use crate::setup::Setup;
use crate::slope::{Slope, mirror};

/// The blur by a lamp's disc and by a metal's lobe on the image plane, as it is around the image's centre.
///
/// It is taken to be the same all over the image. At the centre it is exact to first order for any projection and lamp:
/// a lamp seen at a slant is narrower on an orthographic image, and where light comes in at θ a tilt across its plane
/// deflects it by cos θ less than one along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlurKernel {
    /// (u, v) of a point of the unit disc.
    pub(super) disc: DMat2,
    /// (u, v) of a point of the normal distribution of variance 1.
    pub(super) lobe: DMat2,
    /// (u, v) by which a viewer moves for a degree.
    pub(super) degree: DMat2,
}

impl BlurKernel {
    /// The blur under the lamp of `setup`, in metal that adds deflections of standard deviation `lobe` (radians, along
    /// each axis, at normal incidence).
    ///
    /// `None` if there is neither disc nor lobe.
    pub fn new(setup: &Setup, lobe: f64) -> Option<Self> {
        if !(setup.light_radius() > 0.0 || lobe > 0.0) {
            return None;
        }
        let (l, m) = (setup.light(), setup.slope_at(DVec2::ZERO).unwrap_or(Slope::FLAT).normal());
        let lamp = derivative(l, |l| setup.image_of(mirror(l, m)))?;
        let tilt = derivative(m, |m| setup.image_of(mirror(l, m)))?;
        let degree = derivative(mirror(l, m), |o| setup.image_of(o))? * 1f64.to_radians();
        // A tilt deflects by twice as much.
        let (disc, lobe) = (lamp * setup.light_radius(), tilt * (0.5 * lobe));
        (disc + lobe + degree).is_finite().then_some(Self { disc, lobe, degree })
    }
}

/// (u, v) by which `image` moves when the unit vector `at` turns by a radian along its carried axes.
fn derivative(at: DVec3, image: impl Fn(DVec3) -> Option<DVec2>) -> Option<DMat2> {
    const STEP: f64 = 1e-5;
    let along = |axis: DVec3| {
        let [up, down] = [STEP, -STEP].map(|step| image((at + step * axis).normalize()));
        Some((up? - down?) / (2.0 * STEP))
    };
    let (e1, e2) = carried_axes(at);
    Some(DMat2::from_cols(along(e1)?, along(e2)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::Projection;

    /// Half axes of the ellipse that a matrix makes of the unit disc, the longer first.
    fn axes(m: DMat2) -> [f64; 2] {
        let (square, area) = (m.x_axis.length_squared() + m.y_axis.length_squared(), m.determinant().abs());
        let (sum, difference) = ((square + 2.0 * area).sqrt(), (square - 2.0 * area).max(0.0).sqrt());
        [0.5 * (sum + difference), 0.5 * (sum - difference)]
    }

    #[test]
    fn slanted_light_foreshortens_disc_and_lobe_as_geometry_has_it() {
        let (radius, lobe, half_field) = (f64::to_radians(0.5), f64::to_radians(0.7), f64::to_radians(20.0));
        for theta in [0.0, f64::to_radians(30.0), f64::to_radians(60.0)] {
            let slant = theta.cos();
            // Along and across the plane of incidence; an orthographic image shows its direction foreshortened.
            for (projection, plane, seen) in [
                (Projection::Equidistant, half_field, [1.0, 1.0]),
                (Projection::Screen, half_field.tan(), [1.0, 1.0]),
                (Projection::Orthographic, half_field.sin(), [slant, 1.0]),
            ] {
                let setup = Setup::new(theta, 0.4, radius, projection, half_field);
                let blur = BlurKernel::new(&setup, lobe).unwrap();
                let expected = |along: f64, across: f64| {
                    let [a, b] = [along * seen[0] / plane, across * seen[1] / plane];
                    [a.max(b), a.min(b)]
                };
                let degree = 1f64.to_radians();
                for (matrix, expected) in [
                    (blur.disc, expected(radius, radius)),
                    (blur.lobe, expected(lobe, lobe * slant)),
                    (blur.degree, expected(degree, degree)),
                ] {
                    for (found, expected) in axes(matrix).into_iter().zip(expected) {
                        assert!((found / expected - 1.0).abs() < 1e-4, "{projection:?} {theta}: {found} {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn nothing_blurs_where_there_is_neither_disc_nor_lobe() {
        let setup = |radius| Setup::new(0.3, 0.4, radius, Projection::Orthographic, 0.3);
        assert_eq!(BlurKernel::new(&setup(0.0), 0.0), None);
        assert_eq!(BlurKernel::new(&setup(0.0), f64::NAN), None);
        assert!(BlurKernel::new(&setup(0.01), 0.0).is_some() && BlurKernel::new(&setup(0.0), 0.01).is_some());
    }
}
