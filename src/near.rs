//! What a lamp and a wall nearby change in a far design: a bowl, a warp of its cells, and what both leave.
//!
//! A far design gives each slope one point of the image, wherever on the plate it is. Near by, the light of a slope also
//! depends on its place x. The slope that a place needs for image position W is, with σ its difference from the slope for
//! W at the plate's middle less that for the focus W0,
//!
//! ```text
//!     s_i(x, W) ≈ ∂_i base(x) + σ_i + T_ijk x_k σ_j
//! ```
//!
//! - **base** is the surface on which every point sends the lamp to W0: |L - X| + |W0 - X| is the same all over it, an
//!   ellipsoid; a paraboloid where lamp or wall is endlessly far, and at normal incidence nearly z = |x|²/4f,
//!   1/f = 1/a + 1/b.
//! - **T** is symmetric in i and k up to δ_ij g_k, since s_i are derivatives of one function; so that
//!   z(x) = base(x) + (1 + g·x) cells(φ(x)), φ_j = x_j + ½ Q_jik x_i x_k, has these slopes with Q_jik = T_ijk - δ_ij g_k.
//!
//! T is taken from differences of the exact map, over a part of the plate and of the image, so that it also holds what it
//! can of higher orders. What is left is quadratic in σ, and no warp removes it.

use glam::{DVec2, DVec3};

use crate::lamp::Lamp;
use crate::scene::{Scene, Screen};
use crate::slope::Slope;

/// Where differences for T are taken, as shares of the plate's side and of the image's half field: about the root mean
/// square of an even spread over each.
const AT_PLATE: f64 = 0.29;
const AT_IMAGE: f64 = 0.5;

/// Places along a side of the plate, and image positions along a side of the image, at which the miss is looked at.
const LOOKED_AT: usize = 7;

/// What makes a far design one for a lamp and a wall nearby.
#[derive(Clone, Debug, PartialEq)]
pub struct NearField {
    scene: Scene,
    /// Size of the plate, mm.
    size: DVec2,
    /// The image position to which the base sends all light.
    focus: DVec2,
    /// The slope at the plate's middle that lights it.
    mean: DVec2,
    /// Height of the base at the plate's middle, mm, with which its mean height is 0.
    middle: f64,
    /// g of the warp, per mm.
    gain: DVec2,
    /// Q of the warp, per mm: `q[j][i][k]`, symmetric in i and k.
    q: [[[f64; 2]; 2]; 2],
}

/// How far a design is to follow lamp and wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warping {
    /// Cells as they are, on the base.
    Base,
    /// Cells warped, on the base.
    Warp,
}

impl NearField {
    /// For a plate of `size` mm in `scene`, about the slope `mean` at its middle, the mean of a design.
    ///
    /// `None` if the plate sends no light to the picture from everywhere.
    pub fn new(scene: &Scene, size: DVec2, mean: Slope) -> Option<Self> {
        let focus = scene.thrown(DVec3::ZERO, mean)?;
        let mean = mean.to_vec();
        let mut near =
            Self { scene: scene.clone(), size, focus, mean, middle: 0.0, gain: DVec2::ZERO, q: [[[0.0; 2]; 2]; 2] };
        near.middle = -near.mean_height();
        let t = near.cross_derivatives()?;
        // T_0j1 - T_1j0 = δ_0j g_1 - δ_1j g_0.
        near.gain = DVec2::new(t[1][1][0] - t[0][1][1], t[0][0][1] - t[1][0][0]);
        for (j, plane) in near.q.iter_mut().enumerate() {
            for (i, row) in plane.iter_mut().enumerate() {
                for (k, q) in row.iter_mut().enumerate() {
                    *q = t[i][j][k] - if i == j { near.gain[k] } else { 0.0 };
                }
            }
        }
        Some(near)
    }

    /// The scene.
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The slope of the base at the plate's middle.
    pub const fn mean(&self) -> Slope {
        Slope::from_vec(self.mean)
    }

    /// T_ijk as `t[i][j][k]`, per mm.
    fn cross_derivatives(&self) -> Option<[[[f64; 2]; 2]; 2]> {
        let mut t = [[[0.0; 2]; 2]; 2];
        let view = self.scene.view()?;
        let sigma = AT_IMAGE * 0.5 * view.half_field().tan();
        for (j, along_image) in DVec2::AXES.into_iter().enumerate() {
            for (k, along_plate) in DVec2::AXES.into_iter().enumerate() {
                let (way, step) = (along_plate * AT_PLATE * self.size, along_image * sigma);
                let mut sum = DVec2::ZERO;
                for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    let uv = self.scene.thrown(DVec3::ZERO, Slope::from_vec(self.mean + b * step))?;
                    sum += a * b * self.scene.slope_for(self.place(a * way), uv)?.to_vec();
                }
                let rate = sum / (4.0 * sigma * way.length());
                (t[0][j][k], t[1][j][k]) = (rate.x, rate.y);
            }
        }
        Some(t)
    }

    /// The place of the base over `at`, mm from the plate's middle.
    pub fn place(&self, at: DVec2) -> DVec3 {
        at.extend(self.base(at))
    }

    /// Mean height of the base over the plate, mm.
    fn mean_height(&self) -> f64 {
        let part = |k: usize| (k as f64 + 0.5) / LOOKED_AT as f64 - 0.5;
        let each = LOOKED_AT * LOOKED_AT;
        let at = |k: usize| self.size * DVec2::new(part(k % LOOKED_AT), part(k / LOOKED_AT));
        (0..each).map(|k| self.base(at(k))).sum::<f64>() / each as f64
    }

    /// Height of the base at `at`, mm from the plate's middle; its mean over the plate is 0.
    pub fn base(&self, at: DVec2) -> f64 {
        // Newton: the way from lamp to focus changes with the height by -(l + o)_z. It is nearly linear over a base's
        // sag, and three steps are exact to rounding.
        let whole = self.way(self.middle * DVec3::Z);
        let mut z = self.middle + self.mean.dot(at);
        for _ in 0..4 {
            let place = at.extend(z);
            let toward =
                self.scene.light(place).direction.z + self.scene.direction_to(place, self.focus).map_or(1.0, |o| o.z);
            z += (self.way(place) - whole) / toward;
        }
        z
    }

    /// From the lamp over `place` to the focus, mm, up to a constant where one of them is endlessly far.
    fn way(&self, place: DVec3) -> f64 {
        let from = match self.scene.lamp() {
            Lamp::Ball { middle, .. } => middle.distance(place),
            Lamp::Distant(lamp) => -lamp.direction.dot(place),
        };
        let to = match self.scene.screen() {
            Screen::Wall(wall) => wall.point(self.focus).distance(place),
            Screen::Endless(view) => view.inverse(self.focus).map_or(0.0, |o| -o.dot(place)),
        };
        from + to
    }

    /// The slope of the base at `at`.
    pub fn base_slope(&self, at: DVec2) -> Option<Slope> {
        self.scene.slope_for(self.place(at), self.focus)
    }

    /// Where the cells are asked for the height at `at`, and by how much it is multiplied.
    pub fn warped(&self, at: DVec2) -> (DVec2, f64) {
        let form = |q: [[f64; 2]; 2]| {
            0.5 * (q[0][0] * at.x * at.x + (q[0][1] + q[1][0]) * at.x * at.y + q[1][1] * at.y * at.y)
        };
        (at + DVec2::new(form(self.q[0]), form(self.q[1])), 1.0 + self.gain.dot(at))
    }

    /// By how many degrees the light of a far design misses its image position, as seen from the plate: root mean square
    /// over plate and image. Infinite if some of it misses the wall.
    pub fn miss(&self, warping: Option<Warping>) -> f64 {
        let mut sum = 0.0;
        let grid = |k: usize| (2.0 * (k as f64 + 0.5) / LOOKED_AT as f64 - 1.0, k);
        let each = LOOKED_AT * LOOKED_AT;
        for p in 0..each {
            let at = 0.5 * self.size * DVec2::new(grid(p % LOOKED_AT).0, grid(p / LOOKED_AT).0);
            for w in 0..each {
                let uv = DVec2::new(grid(w % LOOKED_AT).0, grid(w / LOOKED_AT).0);
                match self.missed(at, uv, warping) {
                    Some(missed) => sum += missed.length_squared(),
                    None => return f64::INFINITY,
                }
            }
        }
        let per_degree = self.scene.view().map_or(f64::NAN, |view| view.blur_pixels(1f64.to_radians(), 2));
        (sum / (each * each) as f64).sqrt() / per_degree
    }

    /// By how much the light for `uv` at `at` misses it; without a base where `warping` is `None`.
    fn missed(&self, at: DVec2, uv: DVec2, warping: Option<Warping>) -> Option<DVec2> {
        let sigma = self.scene.slope_for(DVec3::ZERO, uv)?.to_vec() - self.mean;
        let slope = match warping {
            None => self.mean + sigma,
            Some(Warping::Base) => self.base_slope(at)?.to_vec() + sigma,
            Some(Warping::Warp) => {
                let turned = |i: usize| {
                    let q = |j: usize| self.q[j][i][0] * at.x + self.q[j][i][1] * at.y;
                    q(0) * sigma.x + q(1) * sigma.y
                };
                let gain = 1.0 + self.gain.dot(at);
                self.base_slope(at)?.to_vec() + gain * sigma + DVec2::new(turned(0), turned(1))
            }
        };
        let place = if warping.is_some() { self.place(at) } else { at.extend(self.mean.dot(at)) };
        Some(self.scene.thrown(place, Slope::from_vec(slope))? - uv)
    }

    /// Height of the base between its lowest and its highest point on the plate about its mean plane, mm.
    pub fn sag(&self) -> f64 {
        let corner = |k: usize| 0.5 * self.size * DVec2::new((k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0);
        let heights = (0..9).map(|k| self.base(corner(k)) - self.mean.dot(corner(k)));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |r, z| (r.0.min(z), r.1.max(z)));
        high - low
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lamp::DistantLamp;
    use crate::slope::direction;

    fn scene(theta: f64, a: f64, b: f64, tilt: f64) -> Scene {
        let toward = direction(theta.to_radians(), f64::to_radians(90.0));
        let lamp = match a.is_finite() {
            true => Lamp::Ball { middle: a * toward, radius: 0.0 },
            false => DistantLamp::round(toward, 0.0).into(),
        };
        Scene::across_mirror(lamp, b, tilt.to_radians(), b * f64::to_radians(20.0).tan())
    }

    fn near(theta: f64, a: f64, b: f64, tilt: f64) -> NearField {
        NearField::new(&scene(theta, a, b, tilt), DVec2::splat(30.0), Slope::FLAT).unwrap()
    }

    #[test]
    fn every_point_of_the_base_sends_the_lamp_to_the_focus() {
        for near in
            [near(0.0, 500.0, 1000.0, 0.0), near(45.0, f64::INFINITY, 700.0, 0.0), near(60.0, 500.0, 500.0, -20.0)]
        {
            for at in [DVec2::new(15.0, 15.0), DVec2::new(-9.0, 4.0)] {
                let step = 1e-4;
                let rise = |way: DVec2| (near.base(at + way * step) - near.base(at - way * step)) / (2.0 * step);
                let slope = Slope::new(rise(DVec2::X), rise(DVec2::Y));
                assert!(near.scene.thrown(near.place(at), slope).unwrap().length() < 1e-6);
            }
        }
        let bowl = near(0.0, 500.0, 1000.0, 0.0);
        let f = bowl.scene.focal_length();
        let rise = bowl.base(DVec2::new(15.0, 0.0)) - bowl.base(DVec2::ZERO);
        assert!((rise / (225.0 / (4.0 * f)) - 1.0).abs() < 1e-3);
        assert!(bowl.mean_height().abs() < 1e-4 && bowl.base(DVec2::ZERO) < 0.0);
        assert!((bowl.sag() / (450.0 / (4.0 * f)) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn the_warp_is_the_closed_form_where_lamp_and_wall_are_on_the_mirror_direction() {
        // l in the plane of y: g = -l (1/a - 1/b)/2, and Q of room.md's derivation.
        let (a, b, theta) = (500.0, 1000.0, 45f64);
        let near = near(theta, a, b, 0.0);
        let (s, c) = theta.to_radians().sin_cos();
        let [ia, ib] = [1.0 / a, 1.0 / b];
        assert!((near.gain.y / (-0.5 * s * (ia - ib)) - 1.0).abs() < 0.1, "{}", near.gain.y);
        let l = [0.0, s];
        for j in 0..2 {
            for i in 0..2 {
                for k in 0..2 {
                    let d = |a: usize, b: usize| f64::from(u8::from(a == b));
                    let across = d(i, k) - l[i] * l[k];
                    let form = -(d(i, j) * l[k] + d(k, j) * l[i]) * ib + l[j] * (ia + ib) * across / (2.0 * c * c);
                    assert!((near.q[j][i][k] - form).abs() < 1e-4, "{j}{i}{k}: {} {form}", near.q[j][i][k]);
                }
            }
        }
    }

    #[test]
    fn base_and_warp_leave_what_was_measured() {
        // mm on the wall, of trials outside this program: without a base, with it, with the warp.
        for (theta, a, b, expected) in [
            (0.0, 1000.0, 1000.0, [25.4, 0.54, 0.54]),
            (45.0, 1000.0, 1000.0, [22.0, 3.5, 0.58]),
            (60.0, 1000.0, 1000.0, [20.0, 5.3, 1.6]),
            (45.0, f64::INFINITY, 1000.0, [10.7, 2.8, 0.60]),
        ] {
            let near = near(theta, a, b, 0.0);
            let miss = [None, Some(Warping::Base), Some(Warping::Warp)].map(|w| b * near.miss(w).to_radians());
            for (miss, expected) in miss.into_iter().zip(expected) {
                assert!(miss < 1.25 * expected && miss > 0.6 * expected, "{theta} {a}: {miss} {expected}");
            }
        }
    }
}
