//! A milling machine, by what it does to the path that it is told to follow.
//!
//! The sizes of the presets are assumptions that machines of their kinds come near, not measurements of one of them; each
//! field says where its figures are from.

use serde::{Deserialize, Serialize};

/// What a machine does to its path, and how fast it is. Lengths in mm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Machine {
    /// What it is called.
    pub name: String,
    /// Decimals of the coordinates in its programs. Senders for small controls cut to 4 or even 3.
    pub decimals: u32,
    /// Longest segment of its programs, mm.
    pub segment: f64,
    /// One step of a drive, mm. Small controls are shipped with 250 to 1000 steps a mm in z.
    pub step: f64,
    /// The drive rounds its path along the way as a Gaussian of this standard deviation does, mm. Assumed.
    pub smoothing: f64,
    /// Play of x and y when they turn, mm. Assumed.
    pub backlash_xy: f64,
    /// Play of z when it turns, mm. A good small z axis was measured with 0.015.
    pub backlash_z: f64,
    /// Play of z that its programs make up for, mm: what was measured of this machine, or 0.
    #[serde(default, skip_serializing_if = "is_none")]
    pub compensation_z: f64,
    /// Standard deviation of the height from one track to the next, mm. Assumed.
    pub track_scatter: f64,
    /// Standard deviation of the height from one cut of a tooth to the next, mm. Assumed.
    pub tooth_scatter: f64,
    /// Way between two cuts of a tooth, mm.
    pub feed_per_tooth: f64,
    /// Radius of the flat that wear leaves on the tip, which is touched off on it, mm.
    pub tip_flat: f64,
    /// By how much the cutter is larger all around than it is thought to be, mm.
    pub radius_error: f64,
    /// Distance of the cutter's axis from the spindle's, mm.
    pub runout: f64,
    /// Feed while cutting, mm/min.
    pub feed: f64,
    /// Speed while not, mm/min.
    pub rapid: f64,
    /// Acceleration of each axis, mm/s².
    pub acceleration: f64,
    /// Lines of a program that the control takes a second. 400 are told of small controls by their makers.
    pub lines_per_second: f64,
    /// Standard deviation of the polish that its plates get, mm, where that was measured on a test piece.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polish: Option<f64>,
}

/// A machine without faults; others are written as what they have more.
fn faultless(name: &str) -> Machine {
    Machine {
        name: name.into(),
        decimals: 6,
        segment: 0.1,
        step: 0.0,
        smoothing: 0.0,
        backlash_xy: 0.0,
        backlash_z: 0.0,
        compensation_z: 0.0,
        track_scatter: 0.0,
        tooth_scatter: 0.0,
        feed_per_tooth: 0.0,
        tip_flat: 0.0,
        radius_error: 0.0,
        runout: 0.0,
        feed: 600.0,
        rapid: 3000.0,
        acceleration: 300.0,
        lines_per_second: 400.0,
        polish: None,
    }
}

/// Whether a length is none.
fn is_none(length: &f64) -> bool {
    *length == 0.0
}

/// The names of all presets, roughest first.
pub const PRESETS: [&str; 5] = ["desktop", "desktop-good", "vmc", "vmc-good", "ultraprecision"];

/// Other spellings of presets.
const ALSO: [(&str, &str); 3] =
    [("desktop_good", "desktop-good"), ("vmc_good", "vmc-good"), ("ultra", "ultraprecision")];

impl Machine {
    /// A machine without any fault.
    pub fn ideal() -> Self {
        faultless("ideal")
    }

    /// One of [`PRESETS`].
    pub fn preset(name: &str) -> Option<Self> {
        let name = ALSO.iter().find(|(also, _)| *also == name).map_or(name, |(_, name)| name);
        let um = 1e-3;
        Some(match name {
            // A router or a small mill of extrusions and belts or light screws, steppers, a hobby spindle.
            "desktop" => Machine {
                decimals: 3,
                step: 1.25 * um,
                smoothing: 20.0 * um,
                backlash_xy: 10.0 * um,
                backlash_z: 5.0 * um,
                track_scatter: 2.0 * um,
                tooth_scatter: 1.0 * um,
                feed_per_tooth: 15.0 * um,
                ..faultless(name)
            },
            // The same with preloaded screws, a good spindle and four decimals.
            "desktop-good" => Machine {
                decimals: 4,
                step: 0.625 * um,
                smoothing: 20.0 * um,
                backlash_xy: 2.0 * um,
                backlash_z: 1.0 * um,
                track_scatter: 1.0 * um,
                tooth_scatter: 0.5 * um,
                feed_per_tooth: 15.0 * um,
                ..faultless(name)
            },
            // A vertical machining centre of a shop.
            "vmc" => Machine {
                decimals: 4,
                step: 0.1 * um,
                smoothing: 20.0 * um,
                backlash_xy: 1.0 * um,
                backlash_z: 0.5 * um,
                track_scatter: 0.5 * um,
                tooth_scatter: 0.3 * um,
                feed_per_tooth: 10.0 * um,
                ..faultless(name)
            },
            // One with scales on every axis and a warm spindle.
            "vmc-good" => Machine {
                decimals: 5,
                step: 0.01 * um,
                smoothing: 10.0 * um,
                track_scatter: 0.2 * um,
                tooth_scatter: 0.1 * um,
                feed_per_tooth: 5.0 * um,
                ..faultless(name)
            },
            // A machine for optics, with air bearings and a diamond.
            "ultraprecision" => Machine {
                decimals: 6,
                segment: 0.05,
                step: 0.001 * um,
                track_scatter: 0.005 * um,
                tooth_scatter: 0.003 * um,
                feed_per_tooth: 2.0 * um,
                ..faultless(name)
            },
            _ => return None,
        })
    }

    /// The machine that a TOML file describes.
    ///
    /// # Errors
    /// It is no TOML, has a key too many or too few, or a value that no machine has.
    pub fn from_toml(text: &str) -> Result<Self, MachineError> {
        let machine: Self = toml::from_str(text).map_err(|error| MachineError::Toml(error.to_string()))?;
        machine.check()?;
        Ok(machine)
    }

    /// The machine as TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Refuses values that no machine has.
    pub fn check(&self) -> Result<(), MachineError> {
        // Lengths to a millimetre are generous by a factor of ten for every one of these.
        let lengths = [
            ("step", self.step),
            ("smoothing", self.smoothing),
            ("backlash-xy", self.backlash_xy),
            ("backlash-z", self.backlash_z),
            ("compensation-z", self.compensation_z),
            ("track-scatter", self.track_scatter),
            ("tooth-scatter", self.tooth_scatter),
            ("feed-per-tooth", self.feed_per_tooth),
            ("tip-flat", self.tip_flat),
            ("runout", self.runout),
        ];
        let within = lengths.into_iter().map(|(key, value)| (key, value, [0.0, 1.0])).chain([
            ("decimals", f64::from(self.decimals), [1.0, 9.0]),
            ("segment", self.segment, [0.001, 10.0]),
            ("radius-error", self.radius_error, [-1.0, 1.0]),
            ("feed", self.feed, [1.0, 1e5]),
            ("rapid", self.rapid, [1.0, 1e6]),
            ("acceleration", self.acceleration, [1.0, 1e5]),
            ("lines-per-second", self.lines_per_second, [1.0, 1e6]),
            ("polish", self.polish.unwrap_or_default(), [0.0, 1.0]),
        ]);
        for (key, value, [least, most]) in within {
            if !(least..=most).contains(&value) {
                return Err(MachineError::Range { key, value, least, most });
            }
        }
        Ok(())
    }

    /// Shortest segment of its programs, mm: at its feed its control takes no more lines a second.
    pub fn shortest_segment(&self) -> f64 {
        self.feed / 60.0 / self.lines_per_second
    }

    /// One unit of the last decimal of its programs, mm.
    pub fn quantum(&self) -> f64 {
        10f64.powi(-(self.decimals as i32))
    }

    /// Standard deviation of heights that differ from track to track and from cut to cut, with steps and play, mm: how far
    /// one cut may lie below its neighbours, about.
    pub fn scatter(&self) -> f64 {
        let quantum = self.quantum().max(self.step);
        [self.track_scatter, self.tooth_scatter, 0.5 * self.backlash_z, 0.3 * quantum].into_iter().fold(0.0, f64::hypot)
    }
}

/// Not a machine.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineError {
    /// The text itself.
    #[error("{0}")]
    Toml(String),
    /// A value beyond what a machine can have.
    #[error("{key} is {value}, where {least} to {most} would do (lengths in mm)")]
    Range {
        /// The key.
        key: &'static str,
        /// What it was.
        value: f64,
        /// The least.
        least: f64,
        /// The most.
        most: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_written_and_read_and_get_better() {
        let mut before = f64::INFINITY;
        for name in PRESETS {
            let machine = Machine::preset(name).unwrap();
            assert_eq!(Machine::from_toml(&machine.to_toml()), Ok(machine.clone()));
            assert!(machine.scatter() < before, "{name}");
            before = machine.scatter();
        }
        assert_eq!(Machine::preset("ultra").unwrap().name, "ultraprecision");
        assert!(Machine::preset("lathe").is_none());
    }

    #[test]
    fn values_that_no_machine_has_are_named() {
        let of = |line: &str, instead: &str| {
            Machine::from_toml(&Machine::preset("vmc").unwrap().to_toml().replace(line, instead))
                .unwrap_err()
                .to_string()
        };
        assert!(of("step = 0.0001", "step = -1.0").starts_with("step is -1, where 0 to 1 would do"));
        assert!(of("feed = 600.0", "feed = 0.0").starts_with("feed is 0"));
        assert!(of("feed = 600.0", "speed = 600.0").contains("speed"));
        assert!(of("step = 0.0001", "step = nan").starts_with("step is NaN"));
    }
}
