//! How often a highlight is repeated along x and y.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::one_or_two;

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
        one_or_two::write(&self.0, serializer)
    }
}

impl<'de> Deserialize<'de> for Cells {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        one_or_two::read(deserializer, "a whole number, or two such as [5, 3]").map(Self)
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
