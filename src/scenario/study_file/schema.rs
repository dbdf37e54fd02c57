//! The format as JSON Schema.

use serde_json::{Map, Value, json};

use super::MOST_RUNS;
use super::reader::MOST_OBJECTIVES;
use crate::metrics::Metrics;
use crate::scenario::schema as scenario;
use crate::scenario::sweep_file::MOST_REPLICATES;
use crate::scenario::sweep_file::reader::OF_THE_FILE;

/// JSON Schema (draft 2020-12) of a file of kind `study`.
///
/// A file that it rejects is rejected when read. The reverse does not hold: whether the bases are there, and which ends a parameter can have,
/// are beyond it.
pub fn schema() -> Value {
    let whole = |least: i64, most: i64, about: &str| json!({ "type": "integer", "minimum": least, "maximum": most, "description": about });
    let table = |about: &str, properties: Value| json!({ "type": "object", "description": about, "properties": properties, "additionalProperties": false });
    let metrics = |about: &str| {
        let each: Map<String, Value> =
            Metrics::NUMBERS.iter().map(|name| ((*name).to_owned(), json!({ "type": "number" }))).collect();
        table(about, Value::Object(each))
    };
    let set = |about: &str| {
        let path = json!({ "type": "string" });
        let mut set = table(
            about,
            json!({
                "base": {
                    "oneOf": [path, { "type": "array", "items": path, "minItems": 1 }],
                    "description": "Scenario files, from this file's folder.",
                },
                "replicates": whole(1, MOST_REPLICATES, "Runs of each, with the seeds `seed`, `seed + 1` and so on."),
                "seed": whole(0, i64::MAX, "Seed of the first run of each; if absent, the study's."),
            }),
        );
        set["required"] = json!(["base"]);
        set
    };
    let mut laid_over = scenario::part();
    laid_over["description"] = json!("Laid over every base, as `--with` lays a file.");
    let range = json!({
        "type": "object",
        "properties": { "from": { "type": "number" }, "to": { "type": "number" }, "scale": { "enum": ["linear", "log"] } },
        "required": ["from", "to"],
        "additionalProperties": false,
    });
    let mut parameter = scenario::levels(&OF_THE_FILE, &[range]);
    parameter["description"] = json!("Numbers of the scenario, each with the ends between which it is sought.");
    let mut one = table(
        "What is made small.",
        json!({
            "weights": metrics("Metrics, in SI, each with its weight; their sum is what a run costs."),
            "relative": {
                "type": "boolean", "default": false,
                "description": "Whether a run costs its share of what the default's own run costs, on the same duct with the same seed.",
            },
            "over": {
                "oneOf": [{ "enum": ["mean", "worst"] }, { "type": "number", "minimum": 0, "maximum": 1 }],
                "default": "mean", "description": "How the runs of a candidate make one number; a number is a quantile.",
            },
        }),
    );
    one["required"] = json!(["weights"]);
    let several = json!({
        "type": "object", "minProperties": 1, "maxProperties": MOST_OBJECTIVES, "additionalProperties": one,
        "description": "Several, each below its name: their front is found.",
    });
    let objective = json!({ "oneOf": [one, several] });
    let properties = json!({
        "format": { "const": 1, "description": "Version of the file format; this program reads format 1." },
        "kind": { "const": "study", "description": "What this file is." },
        "name": { "type": "string", "pattern": "^[A-Za-z0-9_-]{1,64}$", "description": "Its name, and its folder's." },
        "about": { "type": "string", "description": "What it is for, in one sentence." },
        "seed": whole(0, i64::MAX, "Seed of the optimiser."),
        "optimiser": { "enum": ["cma-es", "sobol", "random"], "default": "cma-es", "description": "Who proposes candidates." },
        "runs": whole(1, MOST_RUNS, "Runs that the search may take, held-out ones not counted."),
        "halving": {
            "type": "boolean", "default": true,
            "description": "Whether a candidate in the worse half after one seed of each scenario is run no further.",
        },
        "wall_limit_s": { "type": "number", "minimum": 1e-3, "maximum": 1e9, "x-unit": "s", "description": "Wall-clock limit of a run." },
        "parameter": parameter,
        "train": set("What candidates are run on."),
        "held_out": set("What the find is held against the default on; the optimiser never sees it."),
        "objective": objective,
        "constraints": table("What every run must keep; a candidate that does not is worse than all that do.", json!({
            "finishes": { "type": "boolean", "default": true, "description": "Whether it must pass the finishing line." },
            "most": metrics("Metrics, in SI, with the most that they may be."),
            "least": metrics("Metrics, in SI, with the least that they must be."),
            "mean_of_default": metrics("Metrics of which the mean over the runs may be at most so many times the mean over the default's."),
            "of_default": metrics("Metrics with the most that they may be, in times what the default has on the same duct with the same seed."),
        })),
        "stop": table("When to stop before the budget is used.", json!({
            "step": { "type": "number", "minimum": 1e-12, "maximum": 1, "description": "Step of every parameter, as a share of its range, that is rest." },
            "generations_without_gain": whole(1, 1_000_000, "Generations without a better candidate."),
        })),
        "scenario": laid_over,
    });
    let mut root = table("Parameters sought on some ducts and held against the default on others.", properties);
    root["required"] = json!(["format", "kind", "name", "parameter", "train", "held_out", "objective"]);
    scenario::headed(root, "ductloop tune")
}
