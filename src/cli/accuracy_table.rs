//! The figures of an accuracy study as a table for people.

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, Table};
use ductloop::scenario::accuracy_file::AccuracyFile;
use serde_json::Value;

const HEAD: [&str; 11] =
    ["", "pipeline", "shown", "detected", "wall / mm", "heading / °", "lateral / mm", "× bound", "NEES", "in 3 σ", "> 6 σ"];

/// RMS (and in brackets the worst) of each cell, and of all.
pub(crate) fn show(file: &AccuracyFile, summary: &Value) -> String {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY).set_header(HEAD);
    if file.cells.len() > 1 {
        for (index, cell) in file.cells.iter().enumerate() {
            let values: Vec<_> = cell.values.iter().map(|(_, value)| value.as_str()).collect();
            rows(&mut table, file, &values.join(", "), &summary["cells"][index]["pipelines"]);
        }
    }
    rows(&mut table, file, "all", &summary["pipelines"]);
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let text = table.to_string();
    let trimmed: Vec<_> = text.lines().map(str::trim_end).collect();
    format!(
        "RMS error, the worst in brackets; × bound: wall, heading, lateral RMS over the Cramer-Rao bound\n{}",
        trimmed.join("\n")
    )
}

fn rows(table: &mut Table, file: &AccuracyFile, label: &str, pipelines: &Value) {
    for pipeline in &file.pipelines {
        let figures = &pipelines[pipeline.word()];
        let spread = |key: &str, per_unit: f64, decimals: usize| {
            let of = |what: &str| figures[key][what].as_f64().map(|value| value * per_unit);
            of("rms").zip(of("worst")).map_or("-".to_owned(), |(rms, worst)| format!("{rms:.decimals$} ({worst:+.decimals$})"))
        };
        let number =
            |value: &Value, decimals: usize| value.as_f64().map_or("-".to_owned(), |value| format!("{value:.decimals$}"));
        let share = |value: &Value| value.as_f64().map_or("-".to_owned(), |value| format!("{:.1} %", 100.0 * value));
        let ratios = ["wall_distance", "heading", "lateral"].map(|key| number(&figures["bound_ratio"][key], 2));
        table.add_row([
            label.to_owned(),
            pipeline.word().to_owned(),
            number(&figures["shown"], 0),
            share(&figures["detection"]),
            spread("wall_distance_m", 1e3, 3),
            spread("heading_rad", 1_f64.to_degrees(), 4),
            spread("lateral_m", 1e3, 3),
            ratios.join(" "),
            number(&figures["nees"], 2),
            share(&figures["within_3_sigma"]),
            number(&figures["beyond_6_sigma"], 0),
        ]);
    }
}
