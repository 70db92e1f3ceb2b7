//! Values of settings: read as on the command line, and written so that they read back.

use std::num::IntErrorKind;
use std::str::FromStr;

use serde::Serialize;
use serde::de::value::Error;
use serde::de::{DeserializeOwned, IntoDeserializer};

use crate::cutter::Cutter;
use crate::facets::arrange::anneal::Annealing;
use crate::facets::sample::Sampling;
use crate::highlight::Quantity;
use crate::milling::machine::Machine;
use crate::picture::{Encoding, PictureFit};
use crate::projection::Projection;
use crate::scene::room::Room;

use super::super::{
    Angles, Arrangement, BorderFinish, Cells, FormatError, Formats, HalfField, Heights, LightSettings, NearMethod,
    PassAngle, PassOrder, Seen, SurfaceKind,
};

/// A number with or without a fraction.
pub fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| match with_unit(text) {
        Some((number, unit)) => format!("leave out the unit '{unit}' and write {number}"),
        None => "write a number, such as 12.5".into(),
    })
}

/// A number and the letters after it, if it is that.
fn with_unit(text: &str) -> Option<(&str, &str)> {
    let (number, unit) = text.trim().split_at(text.trim().find(|c: char| c.is_alphabetic() || c == '°')?);
    (number.trim_end().parse::<f64>().is_ok() && !unit.contains(|c: char| c.is_ascii_digit()))
        .then_some((number.trim_end(), unit))
}

/// A whole number.
pub fn whole(text: &str) -> Result<u64, String> {
    text.trim().parse().map_err(|error: std::num::ParseIntError| match error.kind() {
        IntErrorKind::PosOverflow => format!("{text} is too large"),
        _ => "write a whole number, such as 30".into(),
    })
}

/// A whole number of things in memory.
pub fn count(text: &str) -> Result<usize, String> {
    whole(text)?.try_into().map_err(|_| format!("{text} is too large"))
}

/// Two values with a sign between them.
pub fn pair<T>(text: &str, between: char, each: impl Fn(&str) -> Result<T, String>) -> Result<[T; 2], String> {
    let (first, second) = text
        .split_once(between)
        .ok_or_else(|| format!("write two numbers with '{between}' between them, such as 30{between}20"))?;
    Ok([each(first)?, each(second)?])
}

/// What a setting can be set to.
pub trait Value {
    /// Takes what `text` says; whether it makes sense is for ranges to say.
    fn read(&mut self, text: &str) -> Result<(), String>;

    /// The text that would be read; `None` if nothing is given.
    fn written(&self) -> Option<String>;

    /// Its numbers, for ranges.
    fn numbers(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Takes back what was given, if it need not be.
    fn clear(&mut self) {}
}

impl<T: Value + Default> Value for Option<T> {
    fn read(&mut self, text: &str) -> Result<(), String> {
        let mut value = T::default();
        value.read(text)?;
        *self = Some(value);
        Ok(())
    }

    fn written(&self) -> Option<String> {
        self.as_ref().and_then(T::written)
    }

    fn numbers(&self) -> Vec<f64> {
        self.as_ref().map(T::numbers).unwrap_or_default()
    }

    fn clear(&mut self) {
        *self = None;
    }
}

/// One number, or two with an x between them.
macro_rules! numbers {
    ($($number:ty: $parse:ident, $two:ident);+ $(;)?) => {$(
        impl Value for $number {
            fn read(&mut self, text: &str) -> Result<(), String> {
                $parse(text).map(|value| *self = value)
            }

            fn written(&self) -> Option<String> {
                Some(self.to_string())
            }

            fn numbers(&self) -> Vec<f64> {
                vec![*self as f64]
            }
        }

        impl Value for [$number; 2] {
            fn read(&mut self, text: &str) -> Result<(), String> {
                $two(text, $parse).map(|values| *self = values)
            }

            fn written(&self) -> Option<String> {
                let [x, y] = self;
                Some(format!("{x}x{y}"))
            }

            fn numbers(&self) -> Vec<f64> {
                self.iter().map(|value| *value as f64).collect()
            }
        }
    )+};
}

numbers!(f64: number, one_or_two; u64: whole, two; usize: count, two);

/// Two numbers with an x between them.
fn two<T>(text: &str, parse: fn(&str) -> Result<T, String>) -> Result<[T; 2], String> {
    pair(text, 'x', parse)
}

/// The same, or one for both sides.
fn one_or_two<T: Copy>(text: &str, parse: fn(&str) -> Result<T, String>) -> Result<[T; 2], String> {
    if text.contains('x') { pair(text, 'x', parse) } else { Ok([parse(text)?; 2]) }
}

/// One number for both sides, or two with an x between them.
impl Value for Cells {
    fn read(&mut self, text: &str) -> Result<(), String> {
        self.0 = one_or_two(text, count)?;
        Ok(())
    }

    fn written(&self) -> Option<String> {
        let [x, y] = self.0;
        Some(if x == y { x.to_string() } else { format!("{x}x{y}") })
    }

    fn numbers(&self) -> Vec<f64> {
        self.0.iter().map(|value| *value as f64).collect()
    }
}

/// One angle both ways, or two with an x between them.
impl Value for HalfField {
    fn read(&mut self, text: &str) -> Result<(), String> {
        self.0 = one_or_two(text, number)?;
        Ok(())
    }

    fn written(&self) -> Option<String> {
        Some(self.to_string())
    }

    fn numbers(&self) -> Vec<f64> {
        self.0.to_vec()
    }
}

impl Value for bool {
    fn read(&mut self, text: &str) -> Result<(), String> {
        text.trim().parse().map(|value| *self = value).map_err(|_| "write true or false".into())
    }

    fn written(&self) -> Option<String> {
        Some(self.to_string())
    }
}

impl Value for Formats {
    fn read(&mut self, text: &str) -> Result<(), String> {
        text.parse().map(|formats| *self = formats).map_err(|error: FormatError| error.to_string())
    }

    fn written(&self) -> Option<String> {
        Some(self.to_string())
    }
}

/// The lamp's direction, two angles with a comma between them.
impl Value for LightSettings {
    fn read(&mut self, text: &str) -> Result<(), String> {
        pair(text, ',', number).map(|[theta, phi]| (self.theta, self.phi) = (theta, phi))
    }

    fn written(&self) -> Option<String> {
        Some(format!("{},{}", self.theta, self.phi))
    }

    fn numbers(&self) -> Vec<f64> {
        vec![self.theta, self.phi]
    }
}

/// A direction, two angles with a comma between them.
impl Value for Angles {
    fn read(&mut self, text: &str) -> Result<(), String> {
        pair(text, ',', number).map(|angles| self.0 = angles)
    }

    fn written(&self) -> Option<String> {
        let [theta, phi] = self.0;
        Some(format!("{theta},{phi}"))
    }

    fn numbers(&self) -> Vec<f64> {
        self.0.to_vec()
    }
}

impl Value for Option<Cutter> {
    fn read(&mut self, text: &str) -> Result<(), String> {
        Cutter::from_str(text).map(|cutter| *self = Some(cutter)).map_err(|error| error.to_string())
    }

    fn written(&self) -> Option<String> {
        self.map(|cutter| cutter.to_string())
    }

    fn numbers(&self) -> Vec<f64> {
        self.iter().map(|cutter| cutter.diameter()).collect()
    }

    fn clear(&mut self) {
        *self = None;
    }
}

impl Value for Option<PassAngle> {
    fn read(&mut self, text: &str) -> Result<(), String> {
        PassAngle::from_str(text).map(|angle| *self = Some(angle)).map_err(|error| error.to_string())
    }

    fn written(&self) -> Option<String> {
        self.map(|angle| angle.to_string())
    }

    fn numbers(&self) -> Vec<f64> {
        match self {
            Some(PassAngle::Degrees(degrees)) => vec![*degrees],
            _ => Vec::new(),
        }
    }

    fn clear(&mut self) {
        *self = None;
    }
}

impl Value for Option<BorderFinish> {
    fn read(&mut self, text: &str) -> Result<(), String> {
        BorderFinish::from_str(text).map(|finish| *self = Some(finish)).map_err(|error| error.to_string())
    }

    fn written(&self) -> Option<String> {
        self.map(|finish| finish.to_string())
    }

    fn numbers(&self) -> Vec<f64> {
        match self {
            Some(BorderFinish::Sloped(degrees)) => degrees.iter().copied().collect(),
            _ => Vec::new(),
        }
    }

    fn clear(&mut self) {
        *self = None;
    }
}

/// A place, three numbers with commas between them.
impl Value for [f64; 3] {
    fn read(&mut self, text: &str) -> Result<(), String> {
        let numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
        let three = "write three numbers with ',' between them, such as 0,350,350";
        numbers.try_into().map(|place| *self = place).map_err(|_| three.into())
    }

    fn written(&self) -> Option<String> {
        let [x, y, z] = self;
        Some(format!("{x},{y},{z}"))
    }

    fn numbers(&self) -> Vec<f64> {
        self.to_vec()
    }
}

/// Tables that no flag gives.
macro_rules! tables {
    ($($library:ty),+ $(,)?) => {$(
        impl Value for Option<$library> {
            fn read(&mut self, _: &str) -> Result<(), String> {
                Err("this can only be given in a recipe".into())
            }

            fn written(&self) -> Option<String> {
                self.as_ref().map(|_| "as the recipe says".into())
            }

            fn clear(&mut self) {
                *self = None;
            }
        }
    )+};
}

tables!(Annealing, Machine, Room);

/// Words, spelled as in a recipe.
macro_rules! words {
    ($($library:ty),+ $(,)?) => {$(
        impl Value for $library {
            fn read(&mut self, text: &str) -> Result<(), String> {
                read_word(text).map(|word| *self = word)
            }

            fn written(&self) -> Option<String> {
                written_word(self)
            }
        }
    )+};
}

words!(Arrangement, Encoding, PictureFit, Projection, Quantity, Sampling, Seen);

/// Words of which none is usual.
macro_rules! optional_words {
    ($($library:ty),+ $(,)?) => {$(
        impl Value for Option<$library> {
            fn read(&mut self, text: &str) -> Result<(), String> {
                read_word(text).map(|word| *self = Some(word))
            }

            fn written(&self) -> Option<String> {
                self.as_ref().and_then(written_word)
            }

            fn clear(&mut self) {
                *self = None;
            }
        }
    )+};
}

optional_words!(Heights, NearMethod, PassOrder, SurfaceKind);

fn read_word<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    T::deserialize(text.into_deserializer()).map_err(|error: Error| error.to_string())
}

fn written_word(word: &impl Serialize) -> Option<String> {
    serde_json::to_value(word).ok()?.as_str().map(Into::into)
}
