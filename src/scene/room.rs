//! A room as a person measures it with a tape: plate, lamp or sun, wall and picture in the room's own coordinates.
//!
//! Room axes are right-handed with z up, in millimetres; where x and y point is the person's choice.
//!
//! ```toml
//! [plate]
//! at = [0, 0, 750]            # middle of the optical area
//! facing = [0, 0, 1]          # out of the relief
//! top = [0, 1, 0]             # toward the plate's upper edge
//! [lamp]
//! at = [0, 354, 1104]         # or: sun = [30, 180], degrees from the room's z, and from its x toward y
//! radius = 2.5                # mm of a lamp, degrees of a sun; 0 if not said
//! [wall]
//! through = [0, -1000, 0]     # any point of the wall
//! facing = [0, 1, 0]          # into the room
//! [picture]
//! centre = [0, -1000, 1750]   # without it, where the flat plate would throw the lamp's light
//! width = 700                 # of the drawing
//! up = [0, 0, 1]
//! ```

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{Scene, Screen, WallPicture};
use crate::lamp::{DistantLamp, Lamp};
use crate::slope::{direction, flat_mirror};

/// Everything in a room.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// The plate.
    pub plate: PlatePose,
    /// What shines.
    pub lamp: RoomLamp,
    /// Where the picture shall be thrown.
    pub wall: RoomWall,
    /// The picture on it.
    pub picture: RoomPicture,
}

/// Where the plate is and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlatePose {
    /// Middle of the optical area at its mean height, mm.
    pub at: [f64; 3],
    /// Out of the relief.
    pub facing: [f64; 3],
    /// Toward the plate's upper edge; what it has along `facing` is taken off.
    pub top: [f64; 3],
}

/// A lamp in the room, or the sun.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoomLamp {
    /// Its middle, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
    /// Where the sun stands: degrees from the room's z, and from its x toward its y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sun: Option<[f64; 2]>,
    /// Radius of a lamp, mm, or of a sun, degrees.
    #[serde(default)]
    pub radius: f64,
}

/// A flat wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoomWall {
    /// Any point of it, mm.
    pub through: [f64; 3],
    /// Into the room, away from the wall.
    pub facing: [f64; 3],
}

/// The drawing on the wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoomPicture {
    /// Its middle, mm; without it, where the flat plate would throw the lamp's light.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre: Option<[f64; 3]>,
    /// Width of the drawing, mm.
    pub width: f64,
    /// Up on the picture; what it has along the wall's `facing` is taken off.
    pub up: [f64; 3],
}

/// How far a picture's centre may lie off its wall, mm.
const OFF_WALL: f64 = 1.0;

/// Directions are parallel when the sine of their angle is less than this.
const PARALLEL: f64 = 1e-3;

/// Lengths that are believed, mm.
const LARGEST: f64 = 1e7;

impl Room {
    /// From the text of a scene file.
    ///
    /// # Errors
    /// What is not TOML, an unknown or a missing key, or numbers that describe no room; with the line.
    pub fn from_toml(text: &str) -> Result<Self, RoomError> {
        let room: Self = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let line = text.as_bytes().iter().take(at).filter(|b| **b == b'\n').count() + 1;
            RoomError::Unreadable { line, what: error.message().lines().next().unwrap_or_default().to_owned() }
        })?;
        room.check().map_err(|fault| RoomError::Fault { line: fault.line(text), fault })?;
        Ok(room)
    }

    /// Whether its numbers describe a room.
    ///
    /// # Errors
    /// See [`RoomFault`].
    pub fn check(&self) -> Result<(), RoomFault> {
        let Self { plate, lamp, wall, picture } = self;
        let point = |table, key, v: [f64; 3]| match v.iter().all(|v| v.abs() <= LARGEST) {
            true => Ok(()),
            false => Err(RoomFault::Point { table, key }),
        };
        point("plate", "at", plate.at)?;
        lamp.at.map_or(Ok(()), |at| point("lamp", "at", at))?;
        point("wall", "through", wall.through)?;
        picture.centre.map_or(Ok(()), |centre| point("picture", "centre", centre))?;
        unit("plate", "facing", plate.facing)?;
        across("plate", "top", plate.top, plate.facing)?;
        let facing = unit("wall", "facing", wall.facing)?;
        across("picture", "up", picture.up, wall.facing)?;
        if lamp.at.is_some() == lamp.sun.is_some() {
            return Err(RoomFault::LampOrSun);
        }
        let widest = if lamp.sun.is_some() { 80.0 } else { LARGEST };
        if !(0.0..=widest).contains(&lamp.radius) {
            return Err(RoomFault::Radius { radius: lamp.radius });
        }
        if let Some([theta, phi]) = lamp.sun.filter(|[theta, phi]| !(0.0..=180.0).contains(theta) || phi.abs() > 360.0)
        {
            return Err(RoomFault::Sun { theta, phi });
        }
        if !(1e-3..=LARGEST).contains(&picture.width) {
            return Err(RoomFault::Width { width: picture.width });
        }
        if let Some(centre) = picture.centre {
            let off = (DVec3::from(centre) - DVec3::from(wall.through)).dot(facing);
            if off.abs() > OFF_WALL {
                return Err(RoomFault::OffWall { off });
            }
        }
        Ok(())
    }

    /// The scene in the plate's frame; the picture's square is `square` times as wide as the drawing itself, which may be
    /// padded.
    ///
    /// # Errors
    /// What [`check`](Self::check) refuses, or a picture without a centre where the mirror direction meets no wall.
    pub fn scene(&self, square: f64) -> Result<Scene, RoomFault> {
        self.check()?;
        let z = unit("plate", "facing", self.plate.facing)?;
        let y = across("plate", "top", self.plate.top, self.plate.facing)?;
        let to_plate = DMat3::from_cols(y.cross(z), y, z).transpose();
        let at = DVec3::from(self.plate.at);
        let place = |v: [f64; 3]| to_plate * (DVec3::from(v) - at);
        let lamp = match (self.lamp.at, self.lamp.sun) {
            (Some(at), _) => Lamp::Ball { middle: place(at), radius: self.lamp.radius },
            (None, sun) => {
                let [theta, phi] = sun.unwrap_or_default().map(f64::to_radians);
                DistantLamp::round(to_plate * direction(theta, phi), self.lamp.radius.to_radians()).into()
            }
        };
        let facing = unit("wall", "facing", self.wall.facing)?;
        let v = across("picture", "up", self.picture.up, self.wall.facing)?;
        // Right on the wall is up × facing for someone in front of it; u is left.
        let (u, v, outward) = (to_plate * facing.cross(v), to_plate * v, to_plate * -facing);
        let through = place(self.wall.through);
        let centre = match self.picture.centre {
            Some(centre) => place(centre),
            None => {
                let c = flat_mirror(lamp.at(DVec3::ZERO).direction);
                let way = through.dot(outward) / c.dot(outward);
                if !(way > 0.0 && way <= LARGEST) {
                    return Err(RoomFault::NoMirrorPoint);
                }
                way * c
            }
        };
        let half = 0.5 * square * self.picture.width;
        Ok(Scene::new(lamp, Screen::Wall(WallPicture { centre, u, v, half })))
    }
}

/// A direction as a unit vector.
fn unit(table: &'static str, key: &'static str, v: [f64; 3]) -> Result<DVec3, RoomFault> {
    let v = DVec3::from(v);
    match v.try_normalize() {
        Some(unit) if v.length() > 1e-9 => Ok(unit),
        _ => Err(RoomFault::Zero { table, key }),
    }
}

/// The part of a direction across another one, as a unit vector.
fn across(table: &'static str, key: &'static str, v: [f64; 3], facing: [f64; 3]) -> Result<DVec3, RoomFault> {
    let (v, facing) = (unit(table, key, v)?, DVec3::from(facing).normalize_or_zero());
    let rest = v - v.dot(facing) * facing;
    if rest.length() > PARALLEL { Ok(rest.normalize()) } else { Err(RoomFault::Parallel { table, key }) }
}

/// Numbers that describe no room.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RoomFault {
    /// A coordinate that is no number or too large.
    #[error("{key} of [{table}] must be three numbers of mm within ±{LARGEST:e}")]
    Point {
        /// The table.
        table: &'static str,
        /// The key.
        key: &'static str,
    },
    /// A direction without length.
    #[error("{key} of [{table}] is no direction: give three numbers that are not all zero, such as [0, 0, 1]")]
    Zero {
        /// The table.
        table: &'static str,
        /// The key.
        key: &'static str,
    },
    /// A direction along the one that it must be across.
    #[error("{key} of [{table}] points along the facing that it lies across: turn it, by a quarter best")]
    Parallel {
        /// The table.
        table: &'static str,
        /// The key.
        key: &'static str,
    },
    /// Neither or both.
    #[error("[lamp] needs `at`, three mm, or `sun`, two degrees, and not both")]
    LampOrSun,
    /// The lamp's size.
    #[error("radius of [lamp] is {radius}: it must be 0 or more, in mm of a lamp, up to 80 in degrees of a sun")]
    Radius {
        /// As given.
        radius: f64,
    },
    /// The sun's angles.
    #[error("sun of [lamp] is [{theta}, {phi}]: 0 to 180 degrees from the room's z, and -360 to 360 from its x")]
    Sun {
        /// Degrees.
        theta: f64,
        /// Degrees.
        phi: f64,
    },
    /// The picture's width.
    #[error("width of [picture] is {width}: it must be 0.001 to {LARGEST:e} mm")]
    Width {
        /// mm.
        width: f64,
    },
    /// The picture is not on the wall.
    #[error(
        "centre of [picture] lies {off:.1} mm off the wall's plane, and {OFF_WALL} mm is the most: move it there, or name \
         it as `through` of [wall]"
    )]
    OffWall {
        /// mm, positive in front of the wall.
        off: f64,
    },
    /// Without a centre, the mirror direction decides, and it meets no wall.
    #[error(
        "the flat plate would throw the lamp's light past the wall: give centre of [picture], or turn plate or wall"
    )]
    NoMirrorPoint,
}

impl RoomFault {
    /// The line of `text` in which the key stands that is at fault, or the heading of its table.
    pub fn line(&self, text: &str) -> usize {
        let (table, key) = match self {
            Self::Point { table, key } | Self::Zero { table, key } | Self::Parallel { table, key } => (*table, *key),
            Self::LampOrSun => ("lamp", ""),
            Self::Radius { .. } => ("lamp", "radius"),
            Self::Sun { .. } => ("lamp", "sun"),
            Self::Width { .. } => ("picture", "width"),
            Self::OffWall { .. } => ("picture", "centre"),
            Self::NoMirrorPoint => ("picture", ""),
        };
        let (mut within, mut found) = (false, 1);
        for (k, line) in text.lines().enumerate() {
            let line = line.trim();
            if let Some(heading) = line.strip_prefix('[') {
                within = heading.trim_start().split(']').next().is_some_and(|name| name.trim() == table);
                found = if within { k + 1 } else { found };
            } else if within && !key.is_empty() && line.split('=').next().is_some_and(|name| name.trim() == key) {
                return k + 1;
            }
        }
        found
    }
}

/// Why a scene file cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RoomError {
    /// No TOML, or not these tables and keys.
    #[error(
        "line {line}: {what}; [plate] at, facing, top; [lamp] at or sun, radius; [wall] through, facing; [picture] centre, width, up"
    )]
    Unreadable {
        /// From 1.
        line: usize,
        /// What the reader says.
        what: String,
    },
    /// Numbers that describe no room.
    #[error("line {line}: {fault}")]
    Fault {
        /// From 1.
        line: usize,
        /// What is wrong.
        fault: RoomFault,
    },
}
