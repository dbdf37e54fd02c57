//! The format as JSON Schema: a scenario's, of which the grid may give what is missing, with the tables of a study.

use serde_json::{Map, Value, json};

use super::criteria::BOUNDS;
use super::drawn::DRAWN;
use super::reader::OF_THE_FILE;
use super::{KIND, MOST_POSES};
use crate::scenario::Pipeline;
use crate::scenario::schema as scenario;

/// JSON Schema (draft 2020-12) of a file of kind `accuracy`.
///
/// A file that it rejects is rejected when read. The reverse does not hold: that what neither the file nor its grid gives is missing, what
/// fields say of each other, and values at paths with an index are beyond it.
pub fn schema() -> Value {
    let mut root = scenario::headed(scenario::part(), "ductloop accuracy study");
    root["description"] = json!("A grid of poses, each rendered, read and held against the truth.");
    root["required"] = json!(["format", "kind", "name", "poses"]);
    let pipelines: Vec<&str> = [Pipeline::Robust, Pipeline::Paper].map(Pipeline::word).into();
    let own = json!({
        "kind": { "const": KIND, "description": "What this file is." },
        "pipelines": {
            "type": "array",
            "items": { "enum": pipelines },
            "minItems": 1,
            "uniqueItems": true,
            "description": "What reads the frames.",
            "default": pipelines,
        },
        "poses": poses(),
        "grid": grid(),
        "pass": pass(&pipelines),
    });
    if let (Some(properties), Value::Object(own)) = (root["properties"].as_object_mut(), own) {
        properties.extend(own);
    }
    root
}

fn grid() -> Value {
    let mut grid = scenario::levels(&OF_THE_FILE, &[]);
    grid["description"] = json!("Fields of the scenario, each with the values that it takes; all combinations are measured.");
    grid
}

fn poses() -> Value {
    let range = |[least, most]: [f64; 2]| {
        let end = json!({ "type": "number", "minimum": least, "maximum": most });
        json!({ "type": "array", "items": end, "minItems": 2, "maxItems": 2 })
    };
    let mut properties = Map::new();
    let count = "How many poses there are in each cell of the grid.";
    let bounds = json!({ "type": "integer", "minimum": 1, "maximum": MOST_POSES, "default": 1, "description": count });
    properties.insert("count".to_owned(), bounds);
    for drawn in &DRAWN {
        let mut schema = range(drawn.bounds);
        schema["description"] = json!(format!("{} Drawn evenly between two ends; if absent, the scenario's own.", drawn.about));
        schema["x-unit"] = json!(drawn.unit);
        properties.insert(drawn.key.to_owned(), schema);
    }
    json!({
        "type": "object",
        "description": "What is drawn for each pose.",
        "properties": properties,
        "additionalProperties": false,
    })
}

fn pass(pipelines: &[&str]) -> Value {
    let sentence = |bound: &super::Bound| {
        let end = if bound.is_least() { "Least" } else { "Largest" };
        format!("{end} {}.", bound.about)
    };
    let bounds: Map<String, Value> =
        BOUNDS.iter().map(|bound| (bound.key.to_owned(), json!({ "type": "number", "description": sentence(bound) }))).collect();
    let of_pipeline = json!({ "type": "object", "properties": bounds, "additionalProperties": false });
    let properties: Map<String, Value> = pipelines.iter().map(|pipeline| ((*pipeline).to_owned(), of_pipeline.clone())).collect();
    json!({
        "type": "object",
        "description": "What the figures over all cells must be.",
        "properties": properties,
        "additionalProperties": false,
    })
}
