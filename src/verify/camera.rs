//! Where a person stands, and the shape the relief is wrapped on.
//!
//! The picture's right and up are the plate's x and y, carried along by the smallest rotation that takes +z to the
//! direction of the viewer, so that the plate is seen as on its drawing: x to the right, y up.

use glam::{DMat3, DVec2, DVec3};

use crate::projection::carried_axes;

/// What the relief is on. Wrapped reliefs are endless panels too fine to see: every point of the shape has all of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Shape {
    /// The plate itself, every facet in its place.
    #[default]
    Flat,
    /// A ball, mm. Wrapped as a map on a globe: y points to the pole in the direction of +y, x to the east.
    Sphere {
        /// From the centre, mm.
        radius: f64,
    },
    /// An endless cylinder along y, x around it.
    Cylinder {
        /// From the axis, mm.
        radius: f64,
    },
}

impl Shape {
    /// The radius of what is not flat, mm.
    pub const fn radius(self) -> Option<f64> {
        match self {
            Self::Flat => None,
            Self::Sphere { radius } | Self::Cylinder { radius } => Some(radius),
        }
    }

    /// East, north and outward at the point where a ray from outside first meets the shape around the origin, as
    /// columns; `None` past it, and for the plane.
    pub fn frame(self, from: DVec3, direction: DVec3) -> Option<DMat3> {
        let (radius, flatten) = match self {
            Self::Flat => return None,
            Self::Sphere { radius } => (radius, DVec3::ONE),
            Self::Cylinder { radius } => (radius, DVec3::new(1.0, 0.0, 1.0)),
        };
        let (o, d) = (from * flatten, direction * flatten);
        let (a, b) = (d.length_squared(), o.dot(d));
        // From the point of the ray nearest to the centre: no difference of large numbers.
        let nearest = o - b / a * d;
        let rest = radius * radius - nearest.length_squared();
        if !(rest > 0.0 && b < 0.0) {
            return None;
        }
        let normal = ((nearest - (rest / a).sqrt() * d) / radius).normalize();
        let east = DVec3::Y.cross(normal);
        // At the poles every direction is east.
        let east = if east.length_squared() > 1e-24 { east.normalize() } else { DVec3::X };
        Some(DMat3::from_cols(east, normal.cross(east), normal))
    }
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is, mm.
    pub position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    reach: DVec2,
}

impl Camera {
    /// Looks at `target` from `distance` mm away in the direction `toward` (unit, not -z); `field_of_view` (radians) is
    /// the whole angle across the longer side of the picture of `size` pixels.
    pub fn new(target: DVec3, toward: DVec3, distance: f64, field_of_view: f64, size: [usize; 2]) -> Self {
        let (right, up) = carried_axes(toward);
        let size = DVec2::new(size[0] as f64, size[1] as f64);
        let reach = size / size.max_element() * (0.5 * field_of_view).tan();
        Self { position: target + distance * toward, right, up, forward: -toward, reach }
    }

    /// The uv at which the place `point` (mm) is seen, the inverse of [`direction`](Self::direction); `None` behind the camera.
    pub fn uv(&self, point: DVec3) -> Option<DVec2> {
        let way = point - self.position;
        let ahead = way.dot(self.forward);
        (ahead > 0.0).then(|| DVec2::new(way.dot(self.right), way.dot(self.up)) / ahead / self.reach)
    }

    /// The unit direction seen at `uv` in [-1, 1]², u right, v up.
    #[inline]
    pub fn direction(&self, uv: DVec2) -> DVec3 {
        let at = uv * self.reach;
        (self.forward + at.x * self.right + at.y * self.up).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slope::direction;

    #[test]
    fn the_camera_sees_its_target_in_the_middle_and_x_to_the_right() {
        let target = DVec3::new(3.0, 2.0, 1.0);
        for toward in [DVec3::Z, direction(0.8, 4.0)] {
            let camera = Camera::new(target, toward, 200.0, 0.5, [40, 30]);
            assert!((camera.position + 200.0 * camera.direction(DVec2::ZERO) - target).length() < 1e-9);
            let angle = camera.direction(DVec2::X).angle_between(camera.direction(-DVec2::X));
            assert!((angle - 0.5).abs() < 1e-12);
            let uv = DVec2::new(0.3, -0.8);
            assert!((camera.uv(camera.position + 7.0 * camera.direction(uv)).unwrap() - uv).length() < 1e-12);
            assert_eq!(camera.uv(camera.position + toward), None);
            let up = camera.direction(DVec2::Y).angle_between(-toward);
            assert!((up.tan() - 0.75 * f64::tan(0.25)).abs() < 1e-12);
        }
        let camera = Camera::new(target, DVec3::Z, 200.0, 0.5, [10, 10]);
        assert!(camera.direction(DVec2::X).x > 0.2 && camera.direction(DVec2::Y).y > 0.2);
    }

    #[test]
    fn shapes_are_met_from_outside_with_axes_of_a_globe() {
        let from = DVec3::new(0.0, 0.0, 50.0);
        for shape in [Shape::Sphere { radius: 10.0 }, Shape::Cylinder { radius: 10.0 }] {
            let frame = shape.frame(from, -DVec3::Z).unwrap();
            assert!((frame - DMat3::IDENTITY).to_cols_array().iter().all(|v| v.abs() < 1e-12));
            assert_eq!(shape.frame(from, DVec3::Z), None);
            assert_eq!(shape.frame(from, DVec3::X), None);
            let d = (DVec3::new(6.0, 0.0, 8.0) - from).normalize();
            let frame = shape.frame(from, d).unwrap();
            assert!((frame.z_axis - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-12);
            assert!((frame.x_axis - DVec3::new(0.8, 0.0, -0.6)).length() < 1e-12);
            assert!((frame.y_axis - DVec3::Y).length() < 1e-12);
        }
        // Of a cylinder the height plays no part.
        let d = (DVec3::new(6.0, 20.0, 8.0) - from).normalize();
        let frame = Shape::Cylinder { radius: 10.0 }.frame(from, d).unwrap();
        assert!((frame.z_axis - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-12);
        let pole = Shape::Sphere { radius: 1.0 }.frame(DVec3::Y * 9.0, -DVec3::Y).unwrap();
        assert!(pole.is_finite() && (pole.determinant() - 1.0).abs() < 1e-12);
        assert_eq!(Shape::Flat.frame(from, -DVec3::Z), None);
    }
}
