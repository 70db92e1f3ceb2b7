//! A lamp, the plate and a wall with the picture on it: what the light of a place of the plate meets, in millimetres.
//!
//! ```text
//!        wall                      The frame is the plate's, its origin the middle of the optical area at its mean
//!   v  |/                          height: x right, y up on the plate, z out of it. A place of the plate is a point of
//!    \ C  u                        this frame.
//!      |\      o        lamp       C is the middle of the picture. Its image coordinates (u, v) are 0 there and ±1 on
//!      | . . _          /          its rims; v points up on the wall and u to the left of someone who looks at the wall
//!             . .  _  / l          from the plate's side, so that seen from above the plate u runs to the right: the
//!   __________________X______      drawing is read mirrored, as `--seen on-wall` does.
//!               plate
//! ```
//!
//! Lamp, wall or both may be endlessly far; then places no longer matter and what is left is the far scene,
//! [`Setup`](crate::setup::Setup). Neither lamp nor wall casts a shadow here.

pub mod room;

use glam::{DMat2, DVec2, DVec3};
use thiserror::Error;

use crate::lamp::{DistantLamp, Lamp, LocalLight};
use crate::projection::{Projection, View, carried_axes};
use crate::slope::{Slope, flat_mirror, mirror};

/// One lamp and the picture that the plate shall throw.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    lamp: Lamp,
    screen: Screen,
}

/// Where the picture is.
#[derive(Clone, Debug, PartialEq)]
pub enum Screen {
    /// In directions: endlessly far.
    Endless(View),
    /// On a wall.
    Wall(WallPicture),
}

/// A square on a wall that holds the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallPicture {
    /// Its middle, mm.
    pub centre: DVec3,
    /// Unit vector along u, to the left as seen from the plate's side.
    pub u: DVec3,
    /// Unit vector along v, up.
    pub v: DVec3,
    /// Half of its side, mm.
    pub half: f64,
}

impl WallPicture {
    /// Unit normal of the wall, away from the plate.
    pub fn normal(&self) -> DVec3 {
        self.u.cross(self.v)
    }

    /// The point of the wall at image position `uv`, mm.
    pub fn point(&self, uv: DVec2) -> DVec3 {
        self.centre + self.half * (uv.x * self.u + uv.y * self.v)
    }

    /// The same picture on a wall `times` as far away, as large to the plate's middle.
    pub fn moved(&self, times: f64) -> Self {
        Self { centre: times * self.centre, half: times * self.half, ..*self }
    }

    /// How far `place` lies in front of the wall, mm.
    pub fn depth(&self, place: DVec3) -> f64 {
        (self.centre - place).dot(self.normal())
    }

    /// Where a ray from `place` along `o` meets the wall, as an image position, inside [-1, 1]² or not.
    pub fn met(&self, place: DVec3, o: DVec3) -> Option<DVec2> {
        let (depth, speed) = (self.depth(place), o.dot(self.normal()));
        let way = depth / speed;
        let at = place + way * o - self.centre;
        (speed > 0.0 && depth > 0.0 && way.is_finite()).then(|| DVec2::new(at.dot(self.u), at.dot(self.v)) / self.half)
    }
}

impl Scene {
    /// The smallest tilt of a wall from being seen edge-on, degrees, and of lamp and picture from the plate's own plane.
    pub const LEAST_ANGLE: f64 = 5.0;

    /// `lamp` and `screen` in the plate's frame.
    pub const fn new(lamp: Lamp, screen: Screen) -> Self {
        Self { lamp, screen }
    }

    /// A wall across the direction in which the flat plate mirrors the lamp, `distance` mm from the plate's middle, with
    /// a picture `2 half` mm wide in the middle. `tilt` (radians) turns it about its u axis, its upper edge away from the
    /// plate.
    pub fn across_mirror(lamp: Lamp, distance: f64, tilt: f64, half: f64) -> Self {
        let c = flat_mirror(lamp.at(DVec3::ZERO).direction);
        let (e1, e2) = carried_axes(c);
        let v = tilt.cos() * e2 + tilt.sin() * c;
        Self { lamp, screen: Screen::Wall(WallPicture { centre: distance * c, u: e1, v, half }) }
    }

    /// A picture endlessly far, on a screen of `half_field` (radians) across the direction in which the flat plate
    /// mirrors the lamp.
    pub fn endless(lamp: Lamp, half_field: f64) -> Self {
        let view = View::new(Projection::Screen, half_field, flat_mirror(lamp.at(DVec3::ZERO).direction));
        Self { lamp, screen: Screen::Endless(view) }
    }

    /// The lamp.
    pub const fn lamp(&self) -> &Lamp {
        &self.lamp
    }

    /// Where the picture is.
    pub const fn screen(&self) -> &Screen {
        &self.screen
    }

    /// The picture on the wall, if there is a wall.
    pub const fn wall(&self) -> Option<&WallPicture> {
        match &self.screen {
            Screen::Wall(wall) => Some(wall),
            Screen::Endless(_) => None,
        }
    }

    /// The same lamp with the picture on another wall.
    pub fn with_wall(&self, wall: WallPicture) -> Self {
        Self { lamp: self.lamp.clone(), screen: Screen::Wall(wall) }
    }

    /// From the plate's middle to the lamp, mm; infinite if it is endlessly far.
    pub fn lamp_distance(&self) -> f64 {
        match &self.lamp {
            Lamp::Ball { middle, .. } => middle.length(),
            Lamp::Distant(_) => f64::INFINITY,
        }
    }

    /// From the plate's middle to that of the picture, mm; infinite if it is endlessly far.
    pub fn wall_distance(&self) -> f64 {
        self.wall().map_or(f64::INFINITY, |wall| wall.centre.length())
    }

    /// Focal length of the bowl that lamp and wall ask for, mm: 1/f = 1/a + 1/b, infinite in the far scene.
    pub fn focal_length(&self) -> f64 {
        1.0 / (1.0 / self.lamp_distance() + 1.0 / self.wall_distance())
    }

    /// From the picture's middle to where the flat plate's middle throws the lamp, mm on the wall; `None` without a wall or
    /// if that light passes it.
    pub fn mirror_miss(&self) -> Option<f64> {
        let uv = self.thrown(DVec3::ZERO, Slope::FLAT)?;
        self.wall().map(|wall| wall.half * uv.length())
    }

    /// The lamp as it is from `place`: unit vector to its middle, irradiance across the beam, extent.
    pub fn light(&self, place: DVec3) -> LocalLight<'_> {
        self.lamp.at(place)
    }

    /// The image as it is seen from the plate's middle.
    pub fn view(&self) -> Option<View> {
        match &self.screen {
            Screen::Endless(view) => Some(*view),
            Screen::Wall(wall) => View::onto_plane(wall.centre, wall.half * wall.u, wall.half * wall.v),
        }
    }

    /// The lamp as it is from the plate's middle, for the far scene.
    pub fn lamp_from_middle(&self) -> DistantLamp {
        let light = self.light(DVec3::ZERO);
        DistantLamp { direction: light.direction, extent: light.extent.into_owned() }
    }

    /// Unit vector from `place` to the image position `uv`, if one leads there.
    pub fn direction_to(&self, place: DVec3, uv: DVec2) -> Option<DVec3> {
        match &self.screen {
            Screen::Endless(view) => view.inverse(uv),
            Screen::Wall(wall) => (wall.point(uv) - place).try_normalize(),
        }
    }

    /// The image position that light leaving `place` along `o` meets, inside [-1, 1]² or not.
    pub fn image_of(&self, place: DVec3, o: DVec3) -> Option<DVec2> {
        match &self.screen {
            Screen::Endless(view) => view.forward(o),
            Screen::Wall(wall) => wall.met(place, o),
        }
    }

    /// The image position that `slope` at `place` lights.
    pub fn thrown(&self, place: DVec3, slope: Slope) -> Option<DVec2> {
        self.image_of(place, mirror(self.light(place).direction, slope.normal()))
    }

    /// The slope that lights image position `uv` from `place`.
    pub fn slope_for(&self, place: DVec3, uv: DVec2) -> Option<Slope> {
        Slope::reflecting(self.light(place).direction, self.direction_to(place, uv)?)
    }

    /// Light that a unit of the plate's area at `place` takes with this slope, relative to that of the flat plate's
    /// middle; zero or less where it looks away from the lamp.
    pub fn mass(&self, place: DVec3, slope: Slope) -> f64 {
        let (here, middle) = (self.light(place), self.light(DVec3::ZERO));
        here.irradiance * slope.intercept(here.direction) / (middle.irradiance * middle.direction.z)
    }

    /// How the image position moves with the slope at `place`: columns for p and q.
    pub fn jacobian(&self, place: DVec3, slope: Slope) -> Option<DMat2> {
        const STEP: f64 = 1e-5;
        let derivative = |step: DVec2| {
            let at = |s: DVec2| self.thrown(place, Slope::from_vec(slope.to_vec() + s));
            Some((at(step)? - at(-step)?) / (2.0 * STEP))
        };
        Some(DMat2::from_cols(derivative(DVec2::X * STEP)?, derivative(DVec2::Y * STEP)?))
    }

    /// Whether a plate of `size` mm, its heights within `depth` of the mean, can throw the picture at all.
    ///
    /// # Errors
    /// A lamp or a picture behind the plate or nearly in its plane, a wall seen from behind or from the side, or one that
    /// cuts the plate.
    pub fn check(&self, size: DVec2, depth: f64) -> Result<(), SceneError> {
        let above = |way: DVec3| way.normalize_or_zero().z.clamp(-1.0, 1.0).asin().to_degrees();
        let light = self.light(DVec3::ZERO);
        let angle = above(light.direction);
        if angle.is_nan() || angle < Self::LEAST_ANGLE {
            return Err(SceneError::LampBehind { angle });
        }
        if let Lamp::Ball { middle, radius } = self.lamp {
            let reach = 0.5 * size.length();
            if middle.z - radius <= depth || middle.length() - radius <= 0.1 * reach {
                return Err(SceneError::LampInPlate { distance: middle.length(), radius });
            }
        }
        let Some(wall) = self.wall() else { return Ok(()) };
        let (distance, facing) = (wall.centre.length(), wall.centre.normalize_or_zero().dot(wall.normal()));
        let angle = above(wall.centre);
        if angle.is_nan() || angle < Self::LEAST_ANGLE {
            return Err(SceneError::PictureBehind { angle });
        }
        let edge = facing.clamp(-1.0, 1.0).asin().to_degrees();
        if edge < 0.0 {
            return Err(SceneError::WrongSide);
        }
        if edge < Self::LEAST_ANGLE {
            return Err(SceneError::EdgeOn { angle: edge });
        }
        let corner = |k: usize| [-0.5, 0.5][k & 1] * size.x * DVec3::X + [-0.5, 0.5][k >> 1] * size.y * DVec3::Y;
        let nearest = (0..8).map(|k| wall.depth(corner(k & 3) + [-depth, depth][k >> 2] * DVec3::Z));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        if nearest <= 0.0 {
            return Err(SceneError::WallInPlate { distance, beyond: -nearest });
        }
        Ok(())
    }
}

/// Why a plate cannot throw a picture in a scene.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SceneError {
    /// The lamp is below the plate's plane, or nearly in it.
    #[error(
        "the lamp stands {angle:.1}° above the plate's plane and must stand at least {least}° above it: raise it, or turn \
         the plate toward it",
        least = Scene::LEAST_ANGLE
    )]
    LampBehind {
        /// Degrees.
        angle: f64,
    },
    /// The lamp is as near as the plate itself.
    #[error(
        "a lamp of radius {radius} mm {distance:.1} mm from the plate's middle would touch the plate: move it away; \
         distances are in mm"
    )]
    LampInPlate {
        /// From the plate's middle, mm.
        distance: f64,
        /// mm.
        radius: f64,
    },
    /// The picture's middle is below the plate's plane, or nearly in it.
    #[error(
        "the picture's middle lies {angle:.1}° above the plate's plane and must lie at least {least}° above it: move the \
         picture, or turn the plate toward it",
        least = Scene::LEAST_ANGLE
    )]
    PictureBehind {
        /// Degrees.
        angle: f64,
    },
    /// The plate is behind the wall.
    #[error(
        "the plate stands behind the wall, which faces away from it: turn the wall's `facing` round, or move the plate"
    )]
    WrongSide,
    /// The wall is seen from the side.
    #[error(
        "the plate sees the wall at {angle:.1}°, nearly edge-on, and needs {least}° at least: turn the wall, or lower \
         --wall-tilt",
        least = Scene::LEAST_ANGLE
    )]
    EdgeOn {
        /// Degrees between the way to the picture and the wall.
        angle: f64,
    },
    /// A corner of the plate is behind the wall.
    #[error(
        "the wall {distance:.0} mm away would cut the plate, by {beyond:.1} mm: move it away or turn it back; distances are \
         in mm"
    )]
    WallInPlate {
        /// From the plate's middle to the picture's, mm.
        distance: f64,
        /// mm.
        beyond: f64,
    },
}

#[cfg(test)]
mod tests;
