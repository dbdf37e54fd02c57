//! The page of an accuracy study: figures of each pipeline and cell, and maps of where the errors are ([`super::accuracy_maps`]).

use minijinja::{Environment, Value, context};
use serde_json::Value as Json;

use super::accuracy_maps::CellMaps;
use super::{ReportError, STYLE};
use crate::scenario::Pipeline;
use crate::scenario::accuracy_file::AccuracyFile;

const PAGE: &str = include_str!("accuracy.html");

/// The page. `summary` is the study's document.
///
/// # Errors
/// None that is known of.
pub fn html(file: &AccuracyFile, summary: &Json, maps: &[CellMaps]) -> Result<String, ReportError> {
    let mut environment = Environment::new();
    environment.add_template("accuracy.html", PAGE)?;
    let mut rows = Vec::new();
    if file.cells.len() > 1 {
        for (index, cell) in file.cells.iter().enumerate() {
            let values: Vec<_> = cell.values.iter().map(|(_, value)| value.as_str()).collect();
            rows.extend(table_rows(file, &values.join(", "), &summary["cells"][index]["pipelines"]));
        }
    }
    rows.extend(table_rows(file, "all", &summary["pipelines"]));
    let fields: Vec<&str> =
        file.cells.first().map_or(Vec::new(), |cell| cell.values.iter().map(|(path, _)| path.as_str()).collect());
    let drawings = maps.iter().map(|cell| {
        let maps = cell.maps.iter().map(|(_, map)| Value::from_safe_string(map.svg()));
        context! { label => &cell.label, poses => cell.poses, maps => maps.collect::<Vec<_>>() }
    });
    Ok(environment.get_template("accuracy.html")?.render(context! {
        style => Value::from_safe_string(STYLE.to_owned()),
        name => &file.name,
        about => &file.about,
        verdict => summary["verdict"].as_str(),
        reasons => summary["reasons"].as_array().into_iter().flatten().map(reason).collect::<Vec<_>>(),
        poses => summary["poses"].as_u64(),
        seed => file.seed,
        fields => fields.join(", "),
        rows => rows,
        maps => drawings.collect::<Vec<_>>(),
        unmapped => file.cells.len() - maps.iter().map(|cell| cell.cells).sum::<usize>(),
    })?)
}

fn reason(reason: &Json) -> String {
    let word = |key: &str| reason[key].as_str().unwrap_or("?").to_owned();
    let value = reason["value"].as_f64().map_or("not measured".to_owned(), |value| format!("{value:.4}"));
    format!("{}: {} is {value}, the bound {}", word("pipeline"), word("bound"), reason["limit"])
}

fn table_rows(file: &AccuracyFile, label: &str, pipelines: &Json) -> Vec<Value> {
    let row = |pipeline: &Pipeline| {
        let figures = &pipelines[pipeline.word()];
        let number = |value: &Json, per_unit: f64, decimals: usize| {
            value.as_f64().map_or("–".to_owned(), |value| format!("{:.decimals$}", value * per_unit))
        };
        let spread = |key: &str, per_unit: f64, decimals: usize| {
            ["bias", "rms", "worst", "bound", "bound_ratio"].map(|what| match what {
                "bound_ratio" => number(&figures[key][what], 1.0, 2),
                _ => number(&figures[key][what], per_unit, decimals),
            })
        };
        context! {
            label => label,
            pipeline => pipeline.word(),
            shown => number(&figures["shown"], 1.0, 0),
            detection => number(&figures["detection"], 100.0, 1),
            wall => spread("wall_distance_m", 1e3, 3),
            heading => spread("heading_rad", 1_f64.to_degrees(), 4),
            lateral => spread("lateral_m", 1e3, 3),
            centres => number(&figures["centres_rms_px"], 1.0, 3),
            precision => number(&figures["centres"]["precision"], 100.0, 1),
            recall => number(&figures["centres"]["recall"], 100.0, 1),
            nees => number(&figures["nees"], 1.0, 2),
            within => number(&figures["within_3_sigma"], 100.0, 1),
            beyond => number(&figures["beyond_6_sigma"], 1.0, 0),
        }
    };
    file.pipelines.iter().map(row).collect()
}
