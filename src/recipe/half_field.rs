//! How far the picture reaches from its middle, the same both ways or not.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::one_or_two;
use crate::projection::Projection;

/// Angles from the picture's middle to its rims along x and y, degrees. In a recipe, one number stands for both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfField(pub [f64; 2]);

impl HalfField {
    /// The larger angle, degrees: half of the square field that light is counted in. Where the picture does not reach,
    /// that square is black.
    pub fn reach(self) -> f64 {
        self.0[0].max(self.0[1])
    }

    /// Height of the picture over its width, as `projection` lays out angles; `None` for a square.
    pub fn aspect(self, projection: Projection) -> Option<f64> {
        let [x, y] = self.0.map(|degrees| projection.plane_length(degrees.to_radians()));
        (x != y).then_some(y / x)
    }
}

impl From<f64> for HalfField {
    fn from(both: f64) -> Self {
        Self([both; 2])
    }
}

impl fmt::Display for HalfField {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [x, y] = self.0;
        if x == y { x.fmt(f) } else { write!(f, "{x}x{y}") }
    }
}

impl Serialize for HalfField {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        one_or_two::write(&self.0, serializer)
    }
}

impl<'de> Deserialize<'de> for HalfField {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        one_or_two::read(deserializer, "a number of degrees, or two such as [30.0, 18.0]").map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::Recipe;

    #[test]
    fn one_angle_stands_for_both_and_two_for_each() {
        for (text, angles) in [("30.0", [30.0, 30.0]), ("30", [30.0, 30.0]), ("[30.0, 18.5]", [30.0, 18.5])] {
            let recipe = Recipe::from_toml(&format!("[highlight]\nhalf-field = {text}\n")).unwrap();
            assert_eq!(recipe.highlight.half_field, HalfField(angles));
            assert_eq!(Recipe::from_toml(&recipe.to_toml()), Ok(recipe));
        }
        for text in ["[1.0, 2.0, 3.0]", "[4.0]", "'wide'"] {
            assert!(Recipe::from_toml(&format!("[highlight]\nhalf-field = {text}\n")).is_err(), "{text}");
        }
    }

    #[test]
    fn the_shape_of_the_picture_is_that_of_its_projection() {
        let wide = HalfField([30.0, 18.0]);
        for (projection, aspect) in [
            (Projection::Equidistant, 0.6),
            (Projection::Orthographic, 18f64.to_radians().sin() / 0.5),
            (Projection::Screen, 18f64.to_radians().tan() / 30f64.to_radians().tan()),
        ] {
            assert!((wide.aspect(projection).unwrap() - aspect).abs() < 1e-12);
            assert_eq!(HalfField::from(20.0).aspect(projection), None);
        }
        assert_eq!((wide.reach(), HalfField([10.0, 12.0]).reach()), (30.0, 12.0));
    }
}
