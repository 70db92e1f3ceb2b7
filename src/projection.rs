//! Directions to the image plane and back.
//!
//! The highlight image is the hemisphere of viewers as a map seen from above the plate: u right, v up,
//! both in [-1, 1], the half field H at |u| = 1 and |v| = 1, the flat plate's mirror direction c at the centre.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// How directions are laid out on the image plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Projection {
    /// o.xy - c.xy = sin H · (u, v), in the plate's own axes.
    #[default]
    Orthographic,
    /// The angle from c is H·|(u, v)|.
    Equidistant,
    /// Gnomonic: a flat screen across c, scaled by tan H.
    Screen,
}

/// A projection with its centre and half field: directions `o` to (u, v) and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    projection: Projection,
    half_field: f64,
    scale: f64,
    centre: DVec3,
    e1: DVec3,
    e2: DVec3,
    /// Of a picture on a wall: from (u, v, 1) to a vector along the direction, and back.
    plane: Option<[DMat3; 2]>,
}

impl View {
    /// `half_field` in radians; `centre` is the unit vector at u = v = 0, above the plate.
    pub fn new(projection: Projection, half_field: f64, centre: DVec3) -> Self {
        let (e1, e2) = carried_axes(centre);
        let scale = projection.plane_length(half_field);
        Self { projection, half_field, scale, centre, e1, e2, plane: None }
    }

    /// The picture on a wall as it is seen from one place: a parallelogram whose middle is `middle` away from there and
    /// whose rims at u = 1 and v = 1 are `u` and `v` away from its middle; any unit of length. `None` if it is seen
    /// from the side.
    ///
    /// Its projection is [`Screen`](Projection::Screen), and its half field and blurs are those of a screen that stands
    /// across the direction of its middle at the same distance, with |u| as half of its width.
    pub fn onto_plane(middle: DVec3, u: DVec3, v: DVec3) -> Option<Self> {
        let (centre, scale) = (middle.normalize_or_zero(), u.length() / middle.length());
        let outward = DMat3::from_cols(u, v, middle);
        let volume = outward.determinant().abs();
        let seen = volume > 1e-9 * u.length() * v.length() * middle.length() && volume.is_finite();
        let (e1, e2) = carried_axes(centre);
        let (projection, half_field) = (Projection::Screen, scale.atan());
        let plane = Some([outward, outward.inverse()]);
        seen.then_some(Self { projection, half_field, scale, centre, e1, e2, plane })
    }

    /// The projection's kind.
    pub const fn projection(&self) -> Projection {
        self.projection
    }

    /// From the image's middle to its rim across the axis, in distances to its middle: sin H, H or tan H.
    pub const fn image_scale(&self) -> f64 {
        self.scale
    }

    /// Half field H in radians.
    pub const fn half_field(&self) -> f64 {
        self.half_field
    }

    /// The direction at u = v = 0.
    pub const fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Image position of direction `o`, whether or not it falls inside [-1, 1]²; `None` where the projection has none.
    pub fn forward(&self, o: DVec3) -> Option<DVec2> {
        if let Some([_, back]) = self.plane {
            let at = back * o;
            return (at.z * self.plane_distance() > 1e-9).then(|| at.truncate() / at.z);
        }
        let (a, b, w) = (o.dot(self.e1), o.dot(self.e2), o.dot(self.centre));
        let plane = match self.projection {
            Projection::Orthographic if o.z > 0.0 => o.truncate() - self.centre.truncate(),
            Projection::Screen if w > 1e-9 => DVec2::new(a, b) / w,
            Projection::Orthographic | Projection::Screen => return None,
            Projection::Equidistant => {
                let sine = a.hypot(b);
                let stretch = if sine > 1e-300 { sine.atan2(w) / sine } else { 1.0 };
                DVec2::new(a, b) * stretch
            }
        };
        Some(plane / self.scale)
    }

    /// Direction seen at image position `uv`; `None` where no direction projects there.
    pub fn inverse(&self, uv: DVec2) -> Option<DVec3> {
        if let Some([outward, _]) = self.plane {
            return Some((outward * uv.extend(1.0)).normalize());
        }
        let plane = uv * self.scale;
        match self.projection {
            Projection::Orthographic => {
                let xy = plane + self.centre.truncate();
                let rest = 1.0 - xy.length_squared();
                (rest > 0.0).then(|| xy.extend(rest.sqrt()))
            }
            Projection::Screen => Some((self.centre + plane.x * self.e1 + plane.y * self.e2).normalize()),
            Projection::Equidistant => {
                let angle = plane.length();
                let shrink = sinc(angle);
                (angle <= PI)
                    .then(|| angle.cos() * self.centre + shrink * plane.x * self.e1 + shrink * plane.y * self.e2)
            }
        }
    }

    /// dω/(du dv), steradians per unit of image area; zero where no direction projects.
    pub fn solid_angle_density(&self, uv: DVec2) -> f64 {
        if let Some([outward, _]) = self.plane {
            // The triple product of both sides and the way is area times foreshortening times distance.
            return outward.determinant().abs() / (outward * uv.extend(1.0)).length().powi(3);
        }
        let plane = uv * self.scale;
        let density = match self.projection {
            Projection::Orthographic => self.inverse(uv).map_or(0.0, |o| 1.0 / o.z.max(1e-9)),
            Projection::Screen => (1.0 + plane.length_squared()).powf(-1.5),
            Projection::Equidistant if plane.length() > PI => 0.0,
            Projection::Equidistant => sinc(plane.length()),
        };
        density * self.scale * self.scale
    }

    /// From the place that looks to the middle of a picture on a wall.
    fn plane_distance(&self) -> f64 {
        self.plane.map_or(1.0, |[outward, _]| outward.z_axis.length())
    }

    /// Standard deviation, in pixels of an image `resolution` pixels wide, of a blur of `angle` radians at the image centre.
    pub fn blur_pixels(&self, angle: f64, resolution: usize) -> f64 {
        self.projection.plane_length(angle) / self.scale * resolution as f64 / 2.0
    }

    /// Image position of the centre of pixel (column, row) of a `width` × `height` image, row 0 at the top (v = +1).
    pub fn pixel_centre(column: usize, row: usize, width: usize, height: usize) -> DVec2 {
        DVec2::new((column as f64 + 0.5) / width as f64 * 2.0 - 1.0, 1.0 - (row as f64 + 0.5) / height as f64 * 2.0)
    }

    /// Pixel (column, row) of a `width` × `height` image in which `uv` falls, if inside.
    pub fn pixel_at(uv: DVec2, width: usize, height: usize) -> Option<(usize, usize)> {
        let inside = uv.x >= -1.0 && uv.x < 1.0 && uv.y > -1.0 && uv.y <= 1.0;
        (inside && width > 0 && height > 0).then(|| {
            let column = ((uv.x + 1.0) * 0.5 * width as f64) as usize;
            let row = ((1.0 - uv.y) * 0.5 * height as f64) as usize;
            (column.min(width - 1), row.min(height - 1))
        })
    }
}

impl Projection {
    /// Length on the image plane, before scaling, of an angle from the centre.
    pub(crate) fn plane_length(self, angle: f64) -> f64 {
        match self {
            Self::Orthographic => angle.sin(),
            Self::Equidistant => angle,
            Self::Screen => angle.tan(),
        }
    }
}

/// x and y carried along by the smallest rotation that takes +z to `c` (c.z > -1).
pub fn carried_axes(c: DVec3) -> (DVec3, DVec3) {
    let a = 1.0 / (1.0 + c.z);
    (DVec3::new(1.0 - c.x * c.x * a, -c.x * c.y * a, -c.x), DVec3::new(-c.x * c.y * a, 1.0 - c.y * c.y * a, -c.y))
}

fn sinc(x: f64) -> f64 {
    if x.abs() > 1e-9 { x.sin() / x } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slope::{direction, flat_mirror};

    const ALL: [Projection; 3] = [Projection::Orthographic, Projection::Equidistant, Projection::Screen];

    #[test]
    fn inverse_undoes_forward_and_the_jacobian_is_the_solid_angle() {
        for projection in ALL {
            for (theta, phi) in [(0.0, 0.0), (30.0, 137.0), (50.0, 250.0f64)] {
                let centre = flat_mirror(direction(f64::to_radians(theta), f64::to_radians(phi)));
                let view = View::new(projection, f64::to_radians(15.0), centre);
                for uv in [(0.0, 0.0), (0.3, -0.8), (-1.0, 1.0)].map(|(u, v)| DVec2::new(u, v)) {
                    let o = view.inverse(uv).unwrap();
                    assert!((o.length() - 1.0).abs() < 1e-12);
                    assert!((view.forward(o).unwrap() - uv).length() < 1e-9);
                    let d = 1e-5;
                    let du = view.inverse(uv + DVec2::X * d).unwrap() - view.inverse(uv - DVec2::X * d).unwrap();
                    let dv = view.inverse(uv + DVec2::Y * d).unwrap() - view.inverse(uv - DVec2::Y * d).unwrap();
                    let measured = (du / (2.0 * d)).cross(dv / (2.0 * d)).length();
                    assert!((measured / view.solid_angle_density(uv) - 1.0).abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn every_projection_shows_the_half_field_at_the_rim() {
        for projection in ALL {
            let view = View::new(projection, f64::to_radians(20.0), DVec3::Z);
            let o = view.inverse(DVec2::X).unwrap();
            assert!((o.angle_between(DVec3::Z).to_degrees() - 20.0).abs() < 1e-9);
            assert!(o.x > 0.0);
            let o = view.inverse(DVec2::Y).unwrap();
            assert!(o.y > 0.0);
        }
    }

    #[test]
    fn directions_below_the_plate_have_no_orthographic_or_screen_image() {
        let view = View::new(Projection::Orthographic, 1.0, DVec3::Z);
        assert_eq!(view.forward(-DVec3::Z), None);
        assert_eq!(view.inverse(DVec2::new(1.0, 1.0)), None);
        let view = View::new(Projection::Screen, 1.0, DVec3::Z);
        assert_eq!(view.forward(DVec3::new(1.0, 0.0, -0.1).normalize()), None);
    }

    #[test]
    fn pixels_tile_the_image_with_row_zero_on_top() {
        assert_eq!(View::pixel_at(DVec2::new(-1.0, 1.0), 4, 4), Some((0, 0)));
        assert_eq!(View::pixel_at(DVec2::new(0.99, -0.99), 4, 4), Some((3, 3)));
        assert_eq!(View::pixel_at(DVec2::new(1.0, 0.0), 4, 4), None);
        for k in 0..5 {
            let uv = View::pixel_centre(k, 2, 5, 7);
            assert_eq!(View::pixel_at(uv, 5, 7), Some((k, 2)));
        }
    }
}
