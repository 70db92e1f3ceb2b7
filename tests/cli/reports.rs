//! Every report is what the published schema says.

use std::path::Path;

use serde_json::{Map, Value};

use super::program::{home, run_line};
use super::{SMALL, assert_done};

/// The part of JSON Schema that `docs/report.schema.json` is written in.
struct Schema(Value);

impl Schema {
    fn published() -> Self {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/report.schema.json");
        Self(serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap())
    }

    fn definition(&self, name: &str) -> &Value {
        &self.0["$defs"][name]
    }

    /// A schema itself, or what it refers to.
    fn resolved<'a>(&'a self, schema: &'a Value) -> &'a Value {
        match schema["$ref"].as_str() {
            Some(name) => self.definition(name.strip_prefix("#/$defs/").unwrap()),
            None => schema,
        }
    }

    /// What is wrong with `value`, if anything is.
    fn wrong(&self, schema: &Value, value: &Value, at: &str) -> Option<String> {
        let schema = self.resolved(schema);
        let is = |kind: &str| match kind {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "null" => value.is_null(),
            "number" => value.is_number(),
            "integer" => value.is_u64() || value.is_i64(),
            other => panic!("the schema has a type {other}"),
        };
        let typed = match &schema["type"] {
            Value::Null => true,
            Value::Array(kinds) => kinds.iter().any(|kind| is(kind.as_str().unwrap())),
            kind => is(kind.as_str().unwrap()),
        };
        if !typed {
            return Some(format!("{at} is {value}, and should be {}", schema["type"]));
        }
        if schema.get("const").is_some_and(|wanted| wanted != value) {
            return Some(format!("{at} is {value}, and should be {}", schema["const"]));
        }
        if schema["minimum"].as_f64().zip(value.as_f64()).is_some_and(|(least, value)| value < least) {
            return Some(format!("{at} is {value}"));
        }
        self.wrong_within(schema, value, at).or_else(|| {
            let empty = Vec::new();
            let parts = |key: &str| schema[key].as_array().unwrap_or(&empty);
            let of_all = parts("allOf").iter().find_map(|part| self.wrong(part, value, at));
            let of_any: Vec<_> = parts("anyOf").iter().map(|part| self.wrong(part, value, at)).collect();
            let none = !of_any.is_empty() && of_any.iter().all(Option::is_some);
            of_all.or_else(|| none.then(|| of_any.into_iter().flatten().collect::<Vec<_>>().join("; or ")))
        })
    }

    /// The same of what an object or a list holds.
    fn wrong_within(&self, schema: &Value, value: &Value, at: &str) -> Option<String> {
        if let Some(list) = value.as_array() {
            let count = |key: &str| schema[key].as_u64().map(|n| n as usize);
            if count("minItems").is_some_and(|n| list.len() < n) || count("maxItems").is_some_and(|n| list.len() > n) {
                return Some(format!("{at} has {} values", list.len()));
            }
            let items = schema.get("items")?;
            return list.iter().enumerate().find_map(|(k, value)| self.wrong(items, value, &format!("{at}[{k}]")));
        }
        let object = value.as_object()?;
        let required = schema["required"].as_array().into_iter().flatten().map(|key| key.as_str().unwrap());
        if let Some(key) = required.into_iter().find(|key| !object.contains_key(*key)) {
            return Some(format!("{at} lacks {key}"));
        }
        object.iter().find_map(|(key, value)| {
            let own = schema["properties"].get(key).or_else(|| schema.get("additionalProperties"))?;
            self.wrong(own, value, &format!("{at}.{key}"))
        })
    }

    /// The keys that an object of this schema is known to have.
    fn known(&self, schema: &Value, known: &mut Map<String, Value>) {
        let schema = self.resolved(schema);
        if let Some(properties) = schema["properties"].as_object() {
            known.extend(properties.iter().map(|(key, value)| (key.clone(), value.clone())));
        }
        for part in ["allOf", "anyOf"].iter().filter_map(|key| schema[*key].as_array()).flatten() {
            self.known(part, known);
        }
    }

    /// A key of `value` that the schema does not speak of, if there is one.
    fn unknown(&self, schema: &Value, value: &Value, at: &str) -> Option<String> {
        let mut known = Map::new();
        self.known(schema, &mut known);
        match value {
            Value::Object(object) if !known.is_empty() => object.iter().find_map(|(key, value)| {
                let at = format!("{at}.{key}");
                known.get(key).map_or_else(|| Some(at.clone()), |schema| self.unknown(schema, value, &at))
            }),
            Value::Array(list) => {
                let items = &self.resolved(schema)["items"];
                list.iter().find_map(|value| self.unknown(items, value, at))
            }
            _ => None,
        }
    }
}

/// Asserts that `report` is what the schema says of its kind.
pub fn assert_published(report: &Value, kind: &str) {
    let schema = Schema::published();
    assert_eq!(schema.wrong(&schema.0, report, "report"), None, "{kind}");
    assert_eq!(schema.wrong(schema.definition(kind), report, "report"), None, "{kind}");
    assert_eq!(schema.unknown(schema.definition(kind), report, "report"), None, "{kind}");
}

#[test]
fn every_report_is_what_the_published_schema_says() {
    let home = home();
    let schema = Schema::published();
    let sheet = "--grid 32 --cells 2x1 --size 12x6 --rays 20000";
    for (line, kind) in [
        (format!("design ring.png -o facets {SMALL}"), "DesignReport"),
        (format!("design ring.png -o sheet {sheet} --for-cutter ball:0.5 --border 1 --lobe 0.5"), "DesignReport"),
        (format!("design ring.png -o bare {SMALL} --no-verify"), "DesignReport"),
        (format!("design --goal ggx:0.2 -o goal {SMALL}"), "DesignReport"),
        (format!("design ring.png --dry-run {SMALL}"), "EstimateReport"),
        (format!("design ring.png --dry-run {sheet} --for-cutter ball:0.5"), "EstimateReport"),
        (format!("design ring.png -o room {sheet} --lamp-distance 300 --wall 300 --polish 0.01"), "DesignReport"),
        ("mill sheet --machine vmc --stepover 0.2 --polish 0.1 --rough-cutter flat:1 -o shop".into(), "MillReport"),
        ("verify facets/plate.stl --against ring.png -o proof --rays 20000".into(), "VerifyReport"),
        (
            "verify sheet -o made --rays 20000 --machine vmc --polish 0.03 --pass-angle best --draws 2 --at-most 0.9"
                .into(),
            "VerifyReport",
        ),
        ("verify sheet/plate.stl --against ring.png -o wall --rays 20000 --wall 300 --margin 1".into(), "VerifyReport"),
        ("measure facets -o m1 --rays 20000".into(), "MeasureReport"),
        ("measure facets -o m2 --brdf --polar 2 --azimuths 4 --half-vectors 8x8 --rays 1000".into(), "MeasureReport"),
        ("fit m2 -o fit".into(), "FitReport"),
        ("measure facets -o m3 --ndf --rays 1000".into(), "MeasureReport"),
        ("measure facets -o m4 --wall 1000 --rays 20000 --resolution 32".into(), "MeasureReport"),
        ("measure facets -o m5 --look --light-radius 1 --resolution 16 --rays 1".into(), "MeasureReport"),
    ] {
        let told = run_line(home.path(), &format!("{line} --json"));
        assert_done(&told);
        let report: Value = serde_json::from_str(&told.stdout).unwrap();
        assert_published(&report, kind);
        // What rounding leaves of nothing is told as nothing.
        assert!(!told.stdout.contains("e-16") && !told.stdout.contains("e-17"), "{line}");

        let mut broken = report.clone();
        let first = broken.as_object().unwrap().keys().next().unwrap().clone();
        broken.as_object_mut().unwrap().remove(&first);
        assert!(schema.wrong(&schema.0, &broken, "report").is_some(), "{line} without {first}");
    }
}
