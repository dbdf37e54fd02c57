//! The table of verdicts that `run` ends with.

use std::io::IsTerminal;

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{Cell, CellAlignment, Color, Table};
use ductloop::Verdict;
use ductloop::output::{Summary, words};
use ductloop::scenario::Scenario;

/// A row a run; with `seeds` one scenario has several, told apart by their seeds.
pub(crate) fn show<'a>(runs: impl Iterator<Item = &'a Summary>, seeds: bool) -> String {
    let mut table = Table::new();
    let mut header =
        vec!["scenario", "seed", "verdict", "lateral RMS", "heading RMS", "collisions", "distance", "time", "real time"];
    if !seeds {
        header.remove(1);
    }
    table.load_style(UTF8_HORIZONTAL_ONLY).set_header(header);
    for summary in runs {
        let metrics = &summary.metrics;
        let number = |value: Option<f64>, scale: f64, digits: usize, unit: &str| {
            let text = value.map_or("-".to_owned(), |v| format!("{:.digits$} {unit}", v * scale));
            Cell::new(text).set_alignment(CellAlignment::Right)
        };
        let mut row = vec![
            Cell::new(&summary.scenario),
            Cell::new(summary.seed).set_alignment(CellAlignment::Right),
            cell(summary.verdict),
            number(metrics.lateral_rms_m, 1e3, 2, "mm"),
            number(metrics.heading_rms_rad, 1f64.to_degrees(), 3, "deg"),
            Cell::new(metrics.collisions).set_alignment(CellAlignment::Right),
            number(Some(metrics.distance_m), 1.0, 2, "m"),
            number(Some(metrics.sim_time_s), 1.0, 1, "s"),
            number(metrics.real_time_factor, 1.0, 1, "x"),
        ];
        if !seeds {
            row.remove(1);
        }
        table.add_row(row);
    }
    table.to_string()
}

/// A verdict in a table, coloured on a terminal.
pub(crate) fn cell(verdict: Verdict) -> Cell {
    let cell = Cell::new(verdict.word());
    let colour = if verdict == Verdict::Pass { Color::Green } else { Color::Red };
    if std::io::stdout().is_terminal() { cell.fg(colour) } else { cell }
}

/// Why a run did not pass: its name and verdict, then a line a reason.
pub(crate) fn reasons(name: &str, scenario: &Scenario, summary: &Summary) -> String {
    let mut text = format!("{name}: {}", summary.verdict.word());
    if let Some(message) = &summary.message {
        text += &format!("\n  {message}");
    }
    for reason in &summary.reasons {
        text += &format!("\n  {}", words::reason(scenario, &summary.metrics, reason));
    }
    text
}
