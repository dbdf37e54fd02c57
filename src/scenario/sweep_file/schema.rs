//! The format as JSON Schema.

use serde_json::{Value, json};

use super::reader::OF_THE_FILE;
use super::{MOST_LEVELS, MOST_REPLICATES, MOST_SAMPLES};
use crate::metrics::Metrics;
use crate::scenario::schema as scenario;

/// JSON Schema (draft 2020-12) of a file of kind `sweep`.
///
/// A file that it rejects is rejected when read. The reverse does not hold: which factor a design can draw, whether the bases are there,
/// and values at paths with an index are beyond it.
pub fn schema() -> Value {
    let share = |about: &str| json!({ "type": "number", "minimum": 0, "maximum": 1, "description": about });
    let count = |about: &str| json!({ "type": "integer", "minimum": 0, "description": about });
    let whole = |least: i64, most: i64, about: &str| json!({ "type": "integer", "minimum": least, "maximum": most, "description": about });
    let table = |about: &str, properties: Value| json!({ "type": "object", "description": about, "properties": properties, "additionalProperties": false });
    let path = json!({ "type": "string" });
    let mut laid_over = scenario::part();
    laid_over["description"] = json!("Laid over every base, as `--with` lays a file.");
    let properties = json!({
        "format": { "const": 1, "description": "Version of the file format; this program reads format 1." },
        "kind": { "const": "sweep", "description": "What this file is." },
        "name": { "type": "string", "pattern": "^[A-Za-z0-9_-]{1,64}$", "description": "Its name, and its folder's." },
        "about": { "type": "string", "description": "What it is for, in one sentence." },
        "seed": whole(0, i64::MAX, "Seed of the design, and of the first replicate."),
        "base": {
            "oneOf": [path, { "type": "array", "items": path, "minItems": 1 }],
            "description": "The scenario files that are varied, from this file's folder.",
        },
        "design": {
            "enum": ["grid", "one-at-a-time", "listed", "sobol", "latin-hypercube", "random"], "default": "grid",
            "description": "Which combinations of the factors' values are run.",
        },
        "samples": whole(1, MOST_SAMPLES, "Points of a design that draws them."),
        "replicates": whole(1, MOST_REPLICATES, "Runs of each point, each with a seed of its own."),
        "common_random_numbers": { "type": "boolean", "default": true, "description": "Whether all points have the same seeds." },
        "metrics": {
            "type": "array", "items": { "enum": Metrics::NUMBERS }, "minItems": 1, "uniqueItems": true,
            "description": "Metrics of a run that are kept; if absent, all.",
        },
        "wall_limit_s": { "type": "number", "minimum": 1e-3, "maximum": 1e9, "x-unit": "s", "description": "Wall-clock limit of a case." },
        "factor": factors(),
        "scenario": laid_over,
        "stop": table("When a point has been repeated often enough.", json!({
            "pass_rate_half_width": {
                "type": "number", "minimum": 1e-3, "maximum": 0.5,
                "description": "Half the 95 % interval of the pass rate that is enough.",
            },
            "least_replicates": { "type": "integer", "minimum": 1, "maximum": MOST_REPLICATES, "description": "Replicates of every point." },
        })),
        "pass": table("What the sweep as a whole must come to.", json!({
            "pass_rate_min": share("Least share of cases that pass."),
            "point_pass_rate_min": share("Least share of cases that pass at any point."),
            "errors": count("Most cases that could not go on."),
            "timeouts": count("Most cases that reached their wall-clock limit."),
        })),
    });
    let mut root = table("Scenarios varied over a design of experiments.", properties);
    root["required"] = json!(["format", "kind", "name", "base"]);
    scenario::headed(root, "ductloop sweep")
}

fn factors() -> Value {
    let number = json!({ "type": "number" });
    let range = json!({
        "type": "object",
        "properties": {
            "from": number, "to": number, "scale": { "enum": ["linear", "log"] },
            "levels": { "type": "integer", "minimum": 2, "maximum": MOST_LEVELS },
        },
        "required": ["from", "to"],
        "additionalProperties": false,
    });
    let normal = json!({
        "type": "object",
        "properties": { "mean": number, "deviation": number, "least": number, "most": number },
        "required": ["mean", "deviation"],
        "additionalProperties": false,
    });
    let mut schema = scenario::levels(&OF_THE_FILE, &[range, normal]);
    schema["description"] =
        json!("Fields of the scenario: the values that each takes, the range between two, or a distribution.");
    schema
}
