//! The reflection on a wall: a lamp nearby, a flat screen at a stated distance and tilt, all in millimetres.
//!
//! ```text
//!      lamp                        wall      The wall stands square to c, the flat plate's mirror direction, `wall`
//!        \                        / |        mm from the plate's middle. Its picture has u along e1 and v along e2,
//!     D   \            W      . '   | v      which are the plate's x and y carried to c: far away it is the highlight
//!          \            . '   c     |        image in `screen` projection. A tilt turns the wall about its u axis;
//!   ________\____. '_________       |        a positive one leans its upper edge (v > 0) away from the plate.
//!             plate
//! ```
//!
//! What finite distances blur: every point of the plate sends its own picture, so that a flat mirror's spot is as large
//! as the plate itself, times 1 + W/D; and a lamp of radius r is spread to r W/D, as by a pinhole. [`WallBlur`] has both.
//! Neither lamp nor wall casts a shadow on the other's light.

use glam::{DMat3, DVec2, DVec3};
use thiserror::Error;

use super::experiment::{Experiment, Measuring};
use super::follow::{Collection, follow_all};
use super::measure::until_error;
use super::tally::{MeasureError, Measurement, Tally};
use super::thrown::plate_origin;
use crate::lamp::Lamp;
use crate::progress::{Cancelled, Progress};
use crate::projection::{View, carried_axes};
use crate::raster::Raster;
use crate::scene::WallPicture;
use crate::trace::Surface;
use crate::trace::path::{End, Fate};

/// Where the wall is: across the direction in which a flat plate mirrors the setup's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallSettings {
    /// From the plate's middle to the wall along the mirror direction, mm.
    pub wall_distance: f64,
    /// Degrees by which the wall is turned about its u axis, its upper edge away from the plate.
    pub wall_tilt: f64,
    /// From the middle of the wall's picture to its rim, mm.
    pub half_width: f64,
    /// A picture that stands elsewhere, as in a [`Scene`](crate::scene::Scene), in whose frame this is: its middle and its
    /// axes count in place of distance and tilt.
    pub elsewhere: Option<WallPicture>,
}

impl Default for WallSettings {
    /// A metre of wall a metre away.
    fn default() -> Self {
        Self { wall_distance: 1000.0, wall_tilt: 0.0, half_width: 500.0, elsewhere: None }
    }
}

impl From<WallPicture> for WallSettings {
    /// The wall of a scene, its picture with a rim of a quarter around it.
    fn from(picture: WallPicture) -> Self {
        let toward = picture.centre.normalize_or_zero();
        Self {
            wall_distance: picture.centre.length(),
            wall_tilt: toward.dot(picture.normal()).clamp(-1.0, 1.0).acos().to_degrees(),
            half_width: 1.25 * picture.half,
            elsewhere: Some(picture),
        }
    }
}

/// Full widths along u and v of what finite sizes and distances make of a point of the highlight, mm on the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallBlur {
    /// The whole plate's own image, were it a flat mirror under a point of light.
    pub plate: DVec2,
    /// The lamp's image through the plate's middle, as by a pinhole; that of a distant lamp's reach.
    pub lamp: DVec2,
    /// The angle of the former as the highlight image measures angles, radians.
    pub plate_angle: DVec2,
    /// The lamp's full angle seen from the plate's middle, radians.
    pub lamp_angle: f64,
}

/// Light on the wall.
#[derive(Clone, Debug, PartialEq)]
pub struct WallImage {
    /// All light. `up` is what meets the wall, within its picture or beyond; `escaped_down` what meets no wall.
    pub measurement: Measurement,
    /// What the distances blur.
    pub blur: WallBlur,
    /// From the plate's middle to that of the lamp, mm; infinite for a distant one.
    pub lamp_distance: f64,
    /// Radius of a lamp nearby, mm; 0 for a point and for a distant lamp.
    pub lamp_radius: f64,
    /// From the middle of the picture to its rim, mm.
    pub half_width: f64,
}

impl WallSettings {
    /// What values may be in general; lengths in mm.
    pub const LENGTH: std::ops::RangeInclusive<f64> = 1e-3..=1e9;
    /// The steepest wall, degrees.
    pub const MOST_TILT: f64 = 85.0;
    /// Pixels along a side of the picture.
    pub const MOST_PIXELS: usize = 2048;

    /// Whether light of the experiment's lamp can reach the wall so.
    ///
    /// # Errors
    /// A value out of its range, a lamp that dips into the plate or a wall that cuts it.
    pub fn check<S: Surface>(&self, experiment: &Experiment<'_, S>, measuring: &Measuring) -> Result<(), WallError> {
        let length = |what, value: f64| {
            if Self::LENGTH.contains(&value) { Ok(()) } else { Err(WallError::Length { what, value }) }
        };
        length("distance of the wall", self.wall_distance)?;
        length("half width of the wall's picture", self.half_width)?;
        let (lamp_distance, lamp_radius) = lamp_size(experiment);
        if lamp_radius != 0.0 {
            length("radius of the lamp", lamp_radius)?;
        }
        if !(-Self::MOST_TILT..=Self::MOST_TILT).contains(&self.wall_tilt) {
            return Err(WallError::Tilt(self.wall_tilt));
        }
        if !(1..=Self::MOST_PIXELS).contains(&measuring.resolution) || measuring.rays == 0 {
            return Err(WallError::Measuring);
        }
        let wall = Wall::new(self, experiment);
        if let Lamp::Ball { .. } = experiment.lamp {
            // How near it may be depends on its direction and size: see below.
            if lamp_distance.is_nan() || lamp_distance > Self::LENGTH.end() * (1.0 + 1e-9) {
                return Err(WallError::Length { what: "distance of the lamp", value: lamp_distance });
            }
            if !experiment.lamp_is_above() {
                return Err(WallError::LampInPlate { distance: lamp_distance });
            }
        }
        let (bottom, top) = experiment.surface.height_range();
        let behind = |corner: DVec2| [bottom, top].into_iter().any(|z| wall.depth(corner.extend(z)) <= 0.0);
        if experiment.surface.corners().into_iter().any(behind) {
            return Err(WallError::WallInPlate { distance: self.wall_distance, tilt: self.wall_tilt });
        }
        Ok(())
    }

    /// By how much finite distances and sizes blur; all closed forms.
    ///
    /// Meaningful only for values that pass [`check`](Self::check).
    pub fn blur<S: Surface>(&self, experiment: &Experiment<'_, S>) -> WallBlur {
        let wall = Wall::new(self, experiment);
        // What a flat mirror in the plate's place shows of a lamp nearby: its mirror image below.
        let image = match experiment.lamp {
            Lamp::Ball { middle, .. } => Some(middle.with_z(2.0 * wall.middle.z - middle.z)),
            Lamp::Distant(_) => None,
        };
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in experiment.surface.corners() {
            let point = corner.extend(wall.middle.z);
            let at = wall.meets(point, image.map_or(wall.c, |image| point - image));
            // What passes the wall's horizon is spread without end.
            let at = at.unwrap_or(DVec2::INFINITY);
            (low, high) = (low.min(at), high.max(at));
        }
        let plate = if high.is_finite() { high - low } else { DVec2::INFINITY };
        let half = experiment.lamp.at(wall.middle).extent.reach();
        let (sin, cos) = self.wall_tilt.to_radians().sin_cos();
        let w = self.wall_distance;
        // The ellipse in which a cone of that half angle around c cuts the wall.
        let up = |angle: f64| w * (cos * (angle + self.wall_tilt.to_radians()).tan() - sin);
        let spread = half.tan();
        let under = cos * cos - (spread * sin).powi(2);
        let lamp = if under > 0.0 {
            DVec2::new(2.0 * w * spread * cos / under.sqrt(), up(half) - up(-half))
        } else {
            DVec2::INFINITY
        };
        let plate_angle = DVec2::new(plate.x, plate.y * cos).map(|width| 2.0 * (0.5 * width / w).atan());
        WallBlur { plate, lamp, plate_angle, lamp_angle: 2.0 * half }
    }
}

/// The wall in the plate's frame.
struct Wall {
    middle: DVec3,
    c: DVec3,
    centre: DVec3,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
    half_width: f64,
}

impl Wall {
    fn new<S: Surface>(settings: &WallSettings, experiment: &Experiment<'_, S>) -> Self {
        if let Some(WallPicture { centre, u, v, .. }) = settings.elsewhere {
            let middle = plate_origin(experiment.surface);
            let (c, normal) = (centre.normalize_or_zero(), u.cross(v));
            return Self { middle, c, centre: middle + centre, u, v, normal, half_width: settings.half_width };
        }
        let middle = experiment.surface.middle();
        // The highlight image lives in the drawing's frame; rays in that of the plate, which may be mounted tilted.
        let (x, y) = carried_axes(experiment.setup.plate_normal());
        let to_plate = DMat3::from_cols(x, y, experiment.setup.plate_normal()).transpose();
        let centre = experiment.setup.view().centre();
        let (e1, e2) = carried_axes(centre);
        let (c, e1, e2) = (to_plate * centre, to_plate * e1, to_plate * e2);
        let (sin, cos) = settings.wall_tilt.to_radians().sin_cos();
        Self {
            middle,
            c,
            centre: middle + settings.wall_distance * c,
            u: e1,
            v: cos * e2 + sin * c,
            normal: cos * c - sin * e2,
            half_width: settings.half_width,
        }
    }

    /// How far a point lies in front of the wall, mm.
    fn depth(&self, point: DVec3) -> f64 {
        (self.centre - point).dot(self.normal)
    }

    /// Where on the wall a ray arrives, mm along u and v.
    fn meets(&self, point: DVec3, direction: DVec3) -> Option<DVec2> {
        let (depth, speed) = (self.depth(point), direction.dot(self.normal));
        let way = depth / speed;
        if !(speed > 0.0 && depth > 0.0 && way.is_finite()) {
            return None;
        }
        let at = point + way * direction - self.centre;
        Some(DVec2::new(at.dot(self.u), at.dot(self.v)))
    }
}

/// Distance of the lamp from the plate's middle and its radius, mm; infinite and 0 for a distant lamp.
fn lamp_size<S: Surface>(experiment: &Experiment<'_, S>) -> (f64, f64) {
    match experiment.lamp {
        Lamp::Ball { middle, radius } => (middle.distance(experiment.surface.middle()), radius),
        Lamp::Distant(_) => (f64::INFINITY, 0.0),
    }
}

impl WallImage {
    /// Shares of incident light that land in the picture, on the wall beyond it, and nowhere on the wall, each with
    /// its standard error. The rest is taken by the material, by the plate's sides or is still bouncing.
    pub fn shares(&self) -> [(f64, f64); 3] {
        let shares = |tally: &Tally| {
            [tally.image.sum(), tally.outside_image, tally.escaped_down].map(|light| light / tally.incident)
        };
        let (values, errors) = (shares(&self.measurement.whole), self.measurement.standard_errors(shares));
        std::array::from_fn(|k| (values[k], errors[k]))
    }

    /// Area of a pixel, mm².
    pub(crate) fn pixel_area(&self) -> f64 {
        (2.0 * self.half_width / self.measurement.whole.image.width as f64).powi(2)
    }

    /// Irradiance on the wall, as a multiple of that on the plate's middle (on a horizontal mm²).
    pub fn irradiance(&self) -> Raster {
        self.measurement.whole.image.clone().scaled(1.0 / self.pixel_area())
    }

    /// Standard error of each pixel of [`irradiance`](Self::irradiance).
    pub fn errors(&self) -> Raster {
        let whole = &self.measurement.whole;
        self.measurement.pixel_errors().scaled((whole.up_single + whole.up_multi) / self.pixel_area())
    }
}

/// Sends the lamp's light over the surface and collects it on the wall; the same for any number of threads.
///
/// The picture has `measuring.resolution` pixels a side, and goes on until `measuring.error`, if any; an endless panel is
/// lit, and sends light, within one period.
///
/// # Errors
/// See [`WallSettings::check`]; also if no ray met the plate, or the work was cancelled.
pub fn wall_image<S: Surface>(
    experiment: &Experiment<'_, S>,
    settings: &WallSettings,
    measuring: &Measuring,
    progress: &Progress,
) -> Result<WallImage, WallError> {
    settings.check(experiment, measuring)?;
    let wall = Wall::new(settings, experiment);
    let n = measuring.resolution;
    let pixel_of = |end: &mut End| {
        if !matches!(end.fate, Fate::Up | Fate::Down) {
            return None;
        }
        let at = wall.meets(end.point, end.direction);
        end.fate = if at.is_some() { Fate::Up } else { Fate::Down };
        View::pixel_at(at? / wall.half_width, n, n).map(|(x, y)| y * n + x)
    };
    let collection = Collection { size: (n, n), wanted: |_| true, landing: || pixel_of };
    let round = |measuring: &Measuring| {
        let parts = follow_all(experiment, measuring, &collection, progress)?;
        Measurement::of_parts(parts)
    };
    let measurement = until_error(measuring, round)?;
    let (lamp_distance, lamp_radius) = lamp_size(experiment);
    let blur = settings.blur(experiment);
    Ok(WallImage { measurement, blur, lamp_distance, lamp_radius, half_width: settings.half_width })
}

/// Why there is no picture of a wall.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum WallError {
    /// A length out of range.
    #[error("the {what} must be {low} to {high} mm, not {value}", low = WallSettings::LENGTH.start(), high = WallSettings::LENGTH.end())]
    Length {
        /// Which.
        what: &'static str,
        /// What it is, mm.
        value: f64,
    },
    /// A wall seen from the side.
    #[error("the wall's tilt must be within ±{most} degrees, not {0}", most = WallSettings::MOST_TILT)]
    Tilt(f64),
    /// No pixels, too many, or no rays.
    #[error("the wall's picture must be 1 to {most} pixels wide, with at least one ray", most = WallSettings::MOST_PIXELS)]
    Measuring,
    /// The lamp is too near for its size and angle.
    #[error(
        "a lamp of that size {distance} mm away would dip below the top of the plate: move it away or make it smaller"
    )]
    LampInPlate {
        /// From the plate's middle, mm.
        distance: f64,
    },
    /// The wall is too near for the plate's size and its tilt.
    #[error("a wall {distance} mm away, tilted by {tilt} degrees, would cut the plate: move it away or turn it back")]
    WallInPlate {
        /// From the plate's middle, mm.
        distance: f64,
        /// Degrees.
        tilt: f64,
    },
    /// Nothing was met.
    #[error("no light of the lamp meets the plate")]
    Unlit,
    /// The caller wanted nothing more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<MeasureError> for WallError {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::NoLight => Self::Unlit,
            MeasureError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}

#[cfg(test)]
mod tests;
