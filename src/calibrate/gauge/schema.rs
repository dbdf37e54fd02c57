//! The format of [`GaugeFile`](super::file::GaugeFile) as JSON Schema: a scenario's, and `[gauge]`.

use serde_json::{Value, json};

use crate::scenario;

/// No number of `[gauge]` is as large.
pub(super) const BEYOND: f64 = 1e5;
/// Least and greatest size of the block's face, in millimetres.
pub(super) const SIZE_MM: [f64; 2] = [10.0, 5000.0];
/// Fewest and most lines on either side of a point.
pub(super) const WINDOW_PX: [usize; 2] = [2, 200];

/// JSON Schema (draft 2020-12) of a file of kind `gauge`.
///
/// A file that it rejects is rejected when read. The reverse does not hold: that names name something, that the block stands before the
/// gauge's origin, and that `[gauge]` comes last are beyond it.
pub fn schema() -> Value {
    let mut root = scenario::schema();
    root["title"] = json!("ductloop gauge experiment");
    root["description"] = json!("A calibration with a simulated block gauge.");
    root["properties"]["kind"] = json!({ "const": "gauge", "description": "What this file is." });
    root["properties"]["gauge"] = gauge();
    if let Some(required) = root["required"].as_array_mut() {
        required.push(json!("gauge"));
    }
    root
}

fn gauge() -> Value {
    let number = || json!({ "type": "number", "minimum": -BEYOND, "maximum": BEYOND });
    let numbers = |len: Option<usize>, unit: &str, about: &str| {
        let mut array = json!({ "type": "array", "items": number(), "description": about, "x-unit": unit });
        if let Some(len) = len {
            (array["minItems"], array["maxItems"]) = (json!(len), json!(len));
        }
        array
    };
    let mut size = numbers(Some(2), "mm", "Size of the block's face, across and upright.");
    size["items"] = json!({ "type": "number", "minimum": SIZE_MM[0], "maximum": SIZE_MM[1] });
    let mark = json!({
        "type": "number", "minimum": 0.0, "maximum": BEYOND, "x-unit": "px",
        "description": "Standard deviation of a point's place along the stripe.",
    });
    let window = json!({
        "type": "integer", "minimum": WINDOW_PX[0], "maximum": WINDOW_PX[1], "x-unit": "px",
        "description": "Lines of the image on either side of a point that its centre is taken from.",
    });
    let laser = table(
        "A laser, alight alone.",
        json!({
            "name": { "type": "string", "description": "Its name in the sensor." },
            "paper_misses_mm": numbers(None, "mm", "Misses of the paper's own estimates of these points, if there are such."),
            "points_mm": {
                "type": "array", "items": numbers(Some(2), "mm", "Height and depth of a point."),
                "description": "The points of the calibration.",
            },
        }),
        &["name", "points_mm"],
    );
    let test = table(
        "Where T is tested: every height at every depth.",
        json!({ "heights_mm": numbers(None, "mm", "Heights."), "depths_mm": numbers(None, "mm", "Depths.") }),
        &["heights_mm", "depths_mm"],
    );
    let shift = "The camera in the gauge's frame, p_camera = Rot(turn) p_gauge + shift: the shift.";
    table(
        "The experiment; it comes after the scene.",
        json!({
            "surface": { "type": "string", "description": "The block's surface, by its name." },
            "size_mm": size,
            "origin_m": numbers(Some(3), "m", "Where the gauge's origin is in the duct. Its x is up, its y right, its z along the duct."),
            "turn_rad": numbers(Some(3), "rad", "The camera in the gauge's frame: axis times angle of the turn."),
            "shift_mm": numbers(Some(3), "mm", shift),
            "mark_sigma_px": mark,
            "window_px": window,
            "laser": { "type": "array", "items": laser, "minItems": 1 },
            "test": test,
        }),
        &["surface", "size_mm", "origin_m", "turn_rad", "shift_mm", "mark_sigma_px", "window_px", "laser", "test"],
    )
}

fn table(about: &str, properties: Value, required: &[&str]) -> Value {
    json!({
        "type": "object", "description": about, "properties": properties, "required": required, "additionalProperties": false,
    })
}
