//! How often a highlight is repeated along x and y.

use std::fmt;

use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

/// Cells along x and y. In a recipe, one number stands for both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells(pub [usize; 2]);

impl Default for Cells {
    fn default() -> Self {
        Self([1, 1])
    }
}

impl From<usize> for Cells {
    fn from(both: usize) -> Self {
        Self([both; 2])
    }
}

impl Serialize for Cells {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            [x, y] if x == y => x.serialize(serializer),
            both => both.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Cells {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrTwo;

        impl<'de> Visitor<'de> for OneOrTwo {
            type Value = Cells;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a whole number, or two such as [5, 3]")
            }

            fn visit_u64<E: Error>(self, both: u64) -> Result<Cells, E> {
                usize::try_from(both).map(Cells::from).map_err(E::custom)
            }

            fn visit_i64<E: Error>(self, both: i64) -> Result<Cells, E> {
                usize::try_from(both).map(Cells::from).map_err(E::custom)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Cells, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = sequence.next_element::<usize>()? {
                    values.push(value);
                }
                values.try_into().map(Cells).map_err(|v: Vec<usize>| A::Error::invalid_length(v.len(), &self))
            }
        }

        deserializer.deserialize_any(OneOrTwo)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::Recipe;

    #[test]
    fn one_number_stands_for_both_and_two_for_each() {
        for (text, cells) in [("3", [3, 3]), ("[5, 3]", [5, 3]), ("[2, 2]", [2, 2])] {
            let recipe = Recipe::from_toml(&format!("[plate]\ncells = {text}\n")).unwrap();
            assert_eq!((recipe.plate.cells, recipe.cells()), (Some(Cells(cells)), cells));
            assert_eq!(Recipe::from_toml(&recipe.to_toml()), Ok(recipe));
        }
        for text in ["[1, 2, 3]", "[4]", "-1", "1.5", "'many'"] {
            assert!(Recipe::from_toml(&format!("[plate]\ncells = {text}\n")).is_err(), "{text}");
        }
    }
}
