//! The table of verdicts that `run` ends with.

use std::io::IsTerminal;

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{Cell, CellAlignment, Color, Table};
use ductloop::Verdict;
use ductloop::output::{Summary, words};
use ductloop::scenario::Scenario;

/// A row a run, then the reasons of those that did not pass.
pub(crate) fn show(runs: &[(&Scenario, &Summary)]) -> String {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY).set_header([
        "scenario",
        "verdict",
        "lateral RMS",
        "heading RMS",
        "collisions",
        "distance",
        "time",
        "real time",
    ]);
    let styled = std::io::stdout().is_terminal();
    for (_, summary) in runs {
        let metrics = &summary.metrics;
        let number = |value: Option<f64>, scale: f64, digits: usize, unit: &str| {
            let text = value.map_or("-".to_owned(), |v| format!("{:.digits$} {unit}", v * scale));
            Cell::new(text).set_alignment(CellAlignment::Right)
        };
        let verdict = Cell::new(summary.verdict.word());
        let colour = if summary.verdict == Verdict::Pass { Color::Green } else { Color::Red };
        table.add_row([
            Cell::new(&summary.scenario),
            if styled { verdict.fg(colour) } else { verdict },
            number(metrics.lateral_rms_m, 1e3, 2, "mm"),
            number(metrics.heading_rms_rad, 1f64.to_degrees(), 3, "deg"),
            Cell::new(metrics.collisions).set_alignment(CellAlignment::Right),
            number(Some(metrics.distance_m), 1.0, 2, "m"),
            number(Some(metrics.sim_time_s), 1.0, 1, "s"),
            number(metrics.real_time_factor, 1.0, 1, "x"),
        ]);
    }
    let mut text = table.to_string();
    for (scenario, summary) in runs.iter().filter(|(_, summary)| summary.verdict != Verdict::Pass) {
        text += &format!("\n{}: {}", summary.scenario, summary.verdict.word());
        if let Some(message) = &summary.message {
            text += &format!("\n  {message}");
        }
        for reason in &summary.reasons {
            text += &format!("\n  {}", words::reason(scenario, &summary.metrics, reason));
        }
    }
    text
}
