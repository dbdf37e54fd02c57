//! The format as JSON Schema, for editors, made from the table of fields.

use serde_json::{Map, Value, json};

use super::fields::{self, Default, Field, Kind, Shape, TableShape};
use super::parse;
use super::tree;

/// JSON Schema (draft 2020-12) of a scenario file.
///
/// A file that it rejects is rejected when read. The reverse does not hold: rules between fields, such as that the robot fits
/// the duct, are beyond it.
pub fn schema() -> Value {
    headed(table(fields::root(), Whole::Yes), "ductloop scenario")
}

/// A scenario that something else completes: nothing is required, and a fitting may be of no kind yet.
pub(super) fn part() -> Value {
    table(fields::root(), Whole::No)
}

/// With the dialect and a title.
pub(super) fn headed(mut schema: Value, title: &str) -> Value {
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!(title);
    schema
}

/// Whether what must be there is there, or may be given from elsewhere.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Whole {
    Yes,
    No,
}

fn table(shape: &TableShape, whole: Whole) -> Value {
    let properties: Map<String, Value> =
        shape.children.iter().map(|(key, child)| ((*key).to_owned(), of(child, whole))).collect();
    // What another key may stand for, is not required by itself: a run that is drawn.
    let is_required = |key: &str, child: &Shape| child.is_required() && (shape.row.path, key) != ("duct", "run");
    let required: Vec<&str> = shape.children.iter().filter(|(key, child)| is_required(key, child)).map(|(key, _)| *key).collect();
    let mut schema = json!({
        "type": "object",
        "description": shape.row.about,
        "properties": properties,
        "additionalProperties": false,
    });
    // A surface or laser that overrides a preset's needs only what it changes.
    if whole == Whole::Yes && !required.is_empty() && !shape.row.path.ends_with(".*") {
        schema["required"] = json!(required);
    }
    let one = |key: &&str| json!({ "required": [key] });
    if whole == Whole::Yes && !shape.row.exactly_one.is_empty() {
        schema["oneOf"] = shape.row.exactly_one.iter().map(one).collect();
    }
    if whole == Whole::Yes && shape.row.path == "duct" {
        schema["oneOf"] = ["run", "random"].iter().map(one).collect();
    }
    if !shape.row.at_most_one.is_empty() {
        schema["not"] = json!({ "required": shape.row.at_most_one });
    }
    schema
}

fn of(shape: &Shape, whole: Whole) -> Value {
    match shape {
        Shape::Leaf(field) => leaf(field),
        Shape::Table(inner) => table(inner, whole),
        Shape::Named(inner) => json!({
            "type": "object",
            "description": inner.row.about,
            "patternProperties": { NAME: table(inner, whole) },
            "additionalProperties": false,
        }),
        Shape::List(inner) => {
            let least = if whole == Whole::Yes { inner.row.min_len } else { 0 };
            json!({ "type": "array", "items": table(inner, whole), "minItems": least })
        }
    }
}

/// Values that fields take in turn: the tables of a scenario, with an array of values in the place of each. Where a path has an index
/// it is a key in quotes, of which no more is said. `others` are other ways to say which values.
pub(super) fn levels(without: &[&str], others: &[Value]) -> Value {
    let mut schema = levels_of(fields::root(), others);
    if let Some(properties) = schema["properties"].as_object_mut() {
        properties.retain(|key, _| !without.contains(&key.as_str()));
    }
    schema
}

fn levels_of(shape: &TableShape, others: &[Value]) -> Value {
    let values = |array: Value| match others {
        [] => array,
        _ => json!({ "oneOf": std::iter::once(array).chain(others.iter().cloned()).collect::<Vec<_>>() }),
    };
    let any = || values(json!({ "type": "array", "minItems": 1 }));
    let of = |shape: &Shape| match shape {
        Shape::Leaf(field) => Some(values(json!({ "type": "array", "items": leaf(field), "minItems": 1 }))),
        Shape::Table(inner) => Some(levels_of(inner, others)),
        Shape::Named(inner) => Some(json!({
            "type": "object",
            "patternProperties": { PATH: any(), NAME: levels_of(inner, others) },
            "additionalProperties": false,
        })),
        Shape::List(_) => None,
    };
    let properties: Map<String, Value> =
        shape.children.iter().filter_map(|(key, child)| Some(((*key).to_owned(), of(child)?))).collect();
    json!({
        "type": "object",
        "properties": properties,
        "patternProperties": { PATH: any() },
        "additionalProperties": false,
    })
}

/// A key that is a path: only so can it have an index.
const PATH: &str = "[.\\[]";
const NAME: &str = "^[A-Za-z0-9_-]{1,64}$";

fn leaf(field: &Field) -> Value {
    let number = |min: f64, max: f64| json!({ "type": "number", "minimum": min, "maximum": max });
    let mut schema = match field.kind {
        Kind::Number { min, max } => number(min, max),
        Kind::NumberOr { min, max, word } => json!({ "oneOf": [number(min, max), { "const": word }] }),
        Kind::Choice(numbers) => json!({ "enum": numbers }),
        Kind::Integer { min, max } if min == max => json!({ "const": min }),
        Kind::Integer { min, max } => json!({ "type": "integer", "minimum": min, "maximum": max }),
        Kind::Numbers { len, min, max, single } => {
            let array = json!({ "type": "array", "items": number(min, max), "minItems": len, "maxItems": len });
            if single { json!({ "oneOf": [number(min, max), array] }) } else { array }
        }
        Kind::Integers { len, min, max } => {
            let item = json!({ "type": "integer", "minimum": min, "maximum": max });
            json!({ "type": "array", "items": item, "minItems": len, "maxItems": len })
        }
        Kind::List { min, max } => json!({ "type": "array", "items": number(min, max) }),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Word(words) => json!({ "enum": words }),
        Kind::Words(words) => json!({ "type": "array", "items": { "enum": words } }),
        Kind::Name => json!({ "type": "string", "pattern": NAME }),
        Kind::Text => json!({ "type": "string" }),
    };
    let beyond = match field.default {
        Default::Required(_) | Default::Value(_) => String::new(),
        Default::Preset => " Default: the preset's.".to_owned(),
        Default::Computed(how) => format!(" Default: {how}."),
        Default::Absent(meaning) => format!(" If absent: {meaning}."),
    };
    schema["description"] = json!(format!("{}{beyond}", field.sentence()));
    if !field.unit.is_empty() {
        schema["x-unit"] = json!(field.unit);
    }
    if let Default::Value(toml) = field.default {
        schema["default"] = parse::value(toml, 0, 0).map_or(Value::Null, |node| to_json(&node.value));
    }
    schema
}

fn to_json(value: &tree::Value) -> Value {
    match value {
        tree::Value::Text(text) => json!(text),
        tree::Value::Integer(x) => json!(x),
        tree::Value::Number(x) => json!(x),
        tree::Value::Flag(flag) => json!(flag),
        tree::Value::List(list) => list.iter().map(|n| to_json(&n.value)).collect(),
        tree::Value::Table(_) | tree::Value::Other(_) => Value::Null,
    }
}
