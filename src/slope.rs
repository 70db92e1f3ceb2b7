//! Slopes, normals and mirror directions: the only home of signs.
//!
//! ```text
//!        z (out of the plate, toward light and viewer)
//!        |   y (up on the plate)           height  z = f(x, y)
//!        |  /                              slope   s = (p, q) = (df/dx, df/dy)
//!        | /                               normal  m = (-p, -q, 1) / sqrt(1 + p² + q²)
//!        |/________ x (right)
//! ```
//!
//! `l` points from the plate to the light, `o` from the plate to the viewer, both unit vectors.
//! A surface that climbs toward +x throws the light of a lamp overhead toward -x.

use glam::{DVec2, DVec3};

/// The gradient (p, q) of the height over the plate, dimensionless (mm of climb per mm of way).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slope {
    /// Climb along +x.
    pub p: f64,
    /// Climb along +y.
    pub q: f64,
}

impl Slope {
    /// The slope of a plate lying flat.
    pub const FLAT: Self = Self { p: 0.0, q: 0.0 };

    /// The slope with climb `p` along +x and `q` along +y.
    pub const fn new(p: f64, q: f64) -> Self {
        Self { p, q }
    }

    /// As a vector in the plane of the plate.
    pub const fn to_vec(self) -> DVec2 {
        DVec2::new(self.p, self.q)
    }

    /// From a vector in the plane of the plate.
    pub const fn from_vec(v: DVec2) -> Self {
        Self { p: v.x, q: v.y }
    }

    /// The unit normal, on the side of the light.
    pub fn normal(self) -> DVec3 {
        DVec3::new(-self.p, -self.q, 1.0).normalize()
    }

    /// The slope whose normal is along `m` (any length), if `m` points out of the plate.
    pub fn from_normal(m: DVec3) -> Option<Self> {
        (m.z > 1e-9 * m.length()).then(|| Self::new(-m.x / m.z, -m.y / m.z))
    }

    /// The slope of the mirror that sends light from `l` toward `o`: its normal is halfway between them.
    pub fn reflecting(l: DVec3, o: DVec3) -> Option<Self> {
        Self::from_normal(l + o)
    }

    /// Angle between the normal and the plate's own, radians.
    pub fn tilt(self) -> f64 {
        self.to_vec().length().atan()
    }

    /// Beam area that a unit of plate area under this slope intercepts, (l·m)/(m·z) = l_z - p l_x - q l_y.
    /// Zero or less: the slope looks away from the light.
    pub fn intercept(self, l: DVec3) -> f64 {
        l.z - self.p * l.x - self.q * l.y
    }
}

/// Where a mirror of unit normal `m` sends light that comes from `l`: 2 (l·m) m - l.
pub fn mirror(l: DVec3, m: DVec3) -> DVec3 {
    2.0 * l.dot(m) * m - l
}

/// The unit vector at polar angle `theta` from +z and azimuth `phi` from +x, counter-clockwise seen from above; radians.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// The polar angle of a direction from +z, radians; exact for tiny angles, where an arc cosine is not.
pub fn polar_angle(w: DVec3) -> f64 {
    w.x.hypot(w.y).atan2(w.z)
}

/// Where the flat plate sends light from `l`: the centre of every highlight image.
pub fn flat_mirror(l: DVec3) -> DVec3 {
    DVec3::new(-l.x, -l.y, l.z)
}

/// Angle between two unit vectors, radians; exact for tiny angles, where an arc cosine is not.
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    2.0 * (0.5 * (a - b).length()).min(1.0).asin()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_tilted_by_t_deflects_by_twice_t() {
        for (tilt, azimuth) in [(1.0, 0.0), (10.0, 90.0), (30.0, 213.0f64)] {
            let (t, a) = (f64::to_radians(tilt), f64::to_radians(azimuth));
            let slope = Slope::new(t.tan() * a.cos(), t.tan() * a.sin());
            let thrown = mirror(DVec3::Z, slope.normal());
            let expected = direction(2.0 * t, a + std::f64::consts::PI);
            assert!(angle_between(thrown, expected) < 1e-12, "{tilt} {azimuth}");
        }
    }

    #[test]
    fn the_reflecting_slope_reflects() {
        let l = direction(0.5, 2.0);
        for (theta, phi) in [(0.0, 0.0), (0.4, 1.0), (1.2, -2.0)] {
            let o = direction(theta, phi);
            let slope = Slope::reflecting(l, o).unwrap();
            assert!(angle_between(mirror(l, slope.normal()), o) < 1e-12);
            let m = slope.normal();
            assert!((slope.intercept(l) - l.dot(m) / m.z).abs() < 1e-12);
        }
        assert_eq!(Slope::reflecting(DVec3::Z, -DVec3::Z), None);
    }
}
