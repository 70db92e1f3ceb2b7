//! What is said of a plate: every report as a type, with the keys that its JSON has.
//!
//! `report.json` and `--json` are these types as serde writes them, and the tables that a person sees are made from them.
//! Keys are only ever added. `None` is written as null, unless the key came later or belongs to one kind of plate: then
//! it is left out.

pub mod scores;

pub mod on_wall;

pub mod made;

pub mod goal;

pub mod windows;

pub mod fit;

pub mod thinned;

pub mod design;

pub mod estimate;

pub mod measure;

pub mod verify;

pub mod mill;

pub mod plan;

pub mod patches;

pub mod coupon;

use serde::{Serialize, Serializer};
use serde_json::Value;

use crate::picture::Picture;

/// The program and its version, as every report begins.
pub const PROGRAM: &str = concat!("facetmill ", env!("CARGO_PKG_VERSION"));

/// A report as the text of `report.json`: indented, with a line end.
pub fn text(report: &impl Serialize) -> String {
    // Only a map whose keys are no text can fail, and no report has one.
    let mut value = serde_json::to_value(report).unwrap_or_default();
    without_rounding(&mut value);
    format!("{value:#}\n")
}

/// Below this a figure of a report is what rounding left of nothing: shares, mm, degrees and seconds are all far above.
const NOTHING: f64 = 1e-12;

/// Takes figures that are only rounding for the 0 that they stand for; a recipe keeps what it was given.
fn without_rounding(value: &mut Value) {
    match value {
        Value::Number(number) if number.as_f64().is_some_and(|v| v != 0.0 && v.abs() < NOTHING) => *value = 0.0.into(),
        Value::Array(values) => values.iter_mut().for_each(without_rounding),
        Value::Object(values) => {
            values.iter_mut().filter(|(key, _)| *key != "recipe").for_each(|(_, value)| without_rounding(value));
        }
        _ => {}
    }
}

/// The picture that a highlight was drawn in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureFacts {
    /// Its file, as it was named.
    pub file: Option<String>,
    /// Columns, before it was fitted to a square.
    pub width: usize,
    /// Rows, before it was fitted to a square.
    pub height: usize,
    /// What a person should know of how it was read.
    pub notes: Vec<String>,
}

impl PictureFacts {
    /// Of a picture that was read from `file`.
    pub fn new(picture: &Picture, file: Option<String>) -> Self {
        let (width, height) = picture.original_size;
        Self { file, width, height, notes: picture.notes.clone() }
    }
}

/// A mesh that was read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshFacts {
    /// Its file.
    pub file: String,
    /// Unit of its lengths.
    pub units: &'static str,
    /// Triangles.
    pub triangles: usize,
    /// Those without area.
    pub degenerate_triangles: usize,
    /// Edges without a partner.
    pub open_edges: usize,
    /// The box around it, mm.
    pub size_mm: [f64; 3],
    /// From the lowest to the highest point of the relief, mm.
    pub relief_height_mm: f64,
    /// What the relief was found to be.
    pub traced_as: &'static str,
}

/// Numbers under names, in an order of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Named(pub Vec<(String, f64)>);

impl Named {
    /// The number of that name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(own, _)| own == name).map(|(_, value)| *value)
    }
}

impl<N: ToString> FromIterator<(N, f64)> for Named {
    fn from_iter<I: IntoIterator<Item = (N, f64)>>(pairs: I) -> Self {
        Self(pairs.into_iter().map(|(name, value)| (name.to_string(), value)).collect())
    }
}

impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_never_holds_what_only_rounding_left() {
        let report = serde_json::json!({
            "blocked": -2.220446049250313e-16,
            "designed": { "error": [1e-17, 0.25, -1e-9], "rays": 2_000_000 },
            "recipe": { "min-feature": 1e-13 },
        });
        let told: Value = serde_json::from_str(&text(&report)).unwrap();
        assert_eq!(told["blocked"], 0.0);
        assert_eq!(told["designed"], serde_json::json!({ "error": [0.0, 0.25, -1e-9], "rays": 2_000_000 }));
        assert_eq!(told["recipe"], report["recipe"]);
    }
}
