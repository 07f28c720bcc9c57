//! The JSON Schema of our own format: what is written satisfies it, and it names no key that is never written.
//!
//! The check knows the words that the schema uses, and refuses any other.

use ballstick::bonds::{self, BondOptions};
use ballstick::element::Element;
use ballstick::export::json;
use ballstick::import::{Format, ImportOptions, read_bytes, read_path};
use ballstick::structure::{
    AtomRecord, Bond, BondKind, BondOrder, BondSource, Cell, Diagnostics, Structure, StructureBuilder, atom_flags,
};
use glam::DVec3;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

fn data() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data")
}

fn schema() -> Value {
    let text = std::fs::read_to_string(data().join("ballstick.schema.json")).expect("the schema is there");
    serde_json::from_str(&text).expect("the schema is JSON")
}

/// Where and how a value does not satisfy a schema. Notes the keys that occur, by the place of their schema.
fn check(root: &Value, schema: &Value, value: &Value, place: &str, keys: &mut BTreeSet<String>) -> Vec<String> {
    let mut wrong = Vec::new();
    for (word, rule) in schema.as_object().expect("a schema is an object") {
        let ok = match word.as_str() {
            "$schema" | "$id" | "$defs" | "title" | "description" | "default" => true,
            "$ref" => {
                let name = rule.as_str().and_then(|rule| rule.strip_prefix("#/$defs/")).expect("a local definition");
                wrong.extend(check(root, &root["$defs"][name], value, name, keys));
                true
            }
            "type" => {
                let is = |name: &Value| match name.as_str().expect("a type is a text") {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "number" => value.is_number(),
                    "integer" => value.is_i64() || value.is_u64(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    other => panic!("type {other}"),
                };
                rule.as_array().map_or_else(|| is(rule), |names| names.iter().any(is))
            }
            "enum" => rule.as_array().expect("a list").iter().any(|one| match (one.as_f64(), value.as_f64()) {
                (Some(one), Some(value)) => one == value,
                _ => one == value,
            }),
            "required" => value.as_object().is_none_or(|object| {
                rule.as_array().expect("a list").iter().all(|key| object.contains_key(key.as_str().unwrap_or("")))
            }),
            "properties" => {
                for (key, value) in value.as_object().into_iter().flatten() {
                    keys.insert(format!("{place}.{key}"));
                    match rule.get(key) {
                        Some(schema) => wrong.extend(check(root, schema, value, place, keys)),
                        None => wrong.push(format!("{place}: no key {key}")),
                    }
                }
                true
            }
            "additionalProperties" => *rule == Value::Bool(false), // what `properties` checks
            "items" => {
                for value in value.as_array().into_iter().flatten() {
                    wrong.extend(check(root, rule, value, place, keys));
                }
                true
            }
            "minItems" => value.as_array().is_none_or(|list| list.len() as u64 >= rule.as_u64().unwrap_or(u64::MAX)),
            "maxItems" => value.as_array().is_none_or(|list| list.len() as u64 <= rule.as_u64().unwrap_or(0)),
            "maxLength" => value.as_str().is_none_or(|text| text.chars().count() as u64 <= rule.as_u64().unwrap_or(0)),
            "minimum" => value.as_f64().is_none_or(|number| number >= rule.as_f64().unwrap_or(f64::MAX)),
            "maximum" => value.as_f64().is_none_or(|number| number <= rule.as_f64().unwrap_or(f64::MIN)),
            other => panic!("the schema says `{other}`, which is not checked yet"),
        };
        if !ok {
            wrong.push(format!("{place}: {word} {rule} is not kept by {value}"));
        }
    }
    wrong
}

fn written(structure: &Structure) -> Value {
    let mut bytes = Vec::new();
    json::write(structure, &mut bytes).expect("a vector takes everything");
    serde_json::from_slice(&bytes).expect("what is written is JSON")
}

/// A structure with all that our JSON has a key for.
fn everything() -> Structure {
    let mut builder = StructureBuilder::new();
    builder.set_title("all");
    builder.set_cell(Cell::from_vectors(DVec3::Y, DVec3::Z, DVec3::X));
    builder.push_atom(&AtomRecord {
        element: Element::C,
        name: "CA",
        serial: Some(42),
        residue: Some(("A", -3, b'B', "ALA")),
        flags: atom_flags::HETERO | atom_flags::PARTICLE,
        altloc: b'B',
        occupancy: 0.5,
        b_factor: 12.5,
        formal_charge: -2,
        partial_charge: Some(-0.125),
        isotope: 13,
        radical: 2,
        ..AtomRecord::default()
    });
    builder.push_atom(&AtomRecord { position: DVec3::X, ..AtomRecord::default() });
    let bond = Bond::new(0, 1, BondOrder::Quadruple, BondSource::Link);
    builder.push_bond(Bond { kind: BondKind::Dative, aromatic: true, image: [0, -1, 2], ..bond });
    builder.build(&mut Diagnostics::default())
}

#[test]
fn what_is_written_satisfies_the_schema() {
    let schema = schema();
    let (mut checked, mut wrong) = (0, Vec::new());
    for entry in std::fs::read_dir(data()).expect("data is there").flatten() {
        let Ok(document) = read_path(&entry.path(), &ImportOptions::default()) else { continue };
        for record in document.records.into_iter().take(8) {
            let molecule = bonds::assign(record, &BondOptions::default());
            let name = entry.file_name().to_string_lossy().into_owned();
            wrong.extend(check(&schema, &schema, &written(&molecule), &name, &mut BTreeSet::new()));
            checked += 1;
        }
    }
    assert!(checked > 10, "only {checked} structures were checked");
    assert!(wrong.is_empty(), "{:#?}", &wrong[..wrong.len().min(20)]);
}

#[test]
fn the_schema_names_exactly_the_keys_that_are_written() {
    let schema = schema();
    let mut keys = BTreeSet::new();
    let wrong = check(&schema, &schema, &written(&everything()), "top", &mut keys);
    assert!(wrong.is_empty(), "{wrong:#?}");
    let mut named = BTreeSet::new();
    let places = schema["$defs"].as_object().expect("definitions").iter().map(|(name, part)| (name.as_str(), part));
    for (place, part) in places.chain([("top", &schema)]) {
        for key in part["properties"].as_object().into_iter().flat_map(|properties| properties.keys()) {
            named.insert(format!("{place}.{key}"));
        }
    }
    assert_eq!(named, keys);
}

#[test]
fn the_schema_refuses_what_is_wrong() {
    let schema = schema();
    for text in [
        r#"{}"#,
        r#"{"atoms": [{"element": "C"}]}"#,
        r#"{"atoms": [{"element": "C", "position": [0, 0]}]}"#,
        r#"{"atoms": [{"element": "C", "position": [0, 0, 0], "radical": 4}]}"#,
        r#"{"atoms": [], "bonds": [{"atoms": [0, 1], "kind": "ionic"}]}"#,
        r#"{"atoms": [], "bonds": [{"atoms": [0, -1]}]}"#,
        r#"{"atoms": [], "cell": {"a": 1}}"#,
        r#"{"atoms": [], "atom": []}"#,
    ] {
        let value = serde_json::from_str(text).expect("JSON");
        assert!(!check(&schema, &schema, &value, "top", &mut BTreeSet::new()).is_empty(), "{text}");
    }
}

#[test]
fn every_key_of_the_schema_is_read() {
    let whole = everything();
    let mut bytes = Vec::new();
    json::write(&whole, &mut bytes).expect("a vector takes everything");
    let options = ImportOptions { format: Some(Format::BallstickJson), ..ImportOptions::default() };
    let document = read_bytes(&bytes, "", &options).expect("what is written is read");
    assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
    assert_eq!(written(&document.records[0]), written(&whole));
}
