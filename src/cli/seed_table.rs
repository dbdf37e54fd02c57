//! What `run --seeds` ends with: a line a scenario, and the seeds that did not pass, the worst first.

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{Cell, CellAlignment, Table};
use ductloop::Verdict;

use super::run::Finished;
use super::seed_verdict::{SeedVerdict, Spread};
use super::verdict_table;

/// How many seeds that did not pass are told of a scenario.
const TOLD: usize = 3;

/// A row a scenario, then the worst of the seeds that did not pass with their reasons.
pub(crate) fn show(scenarios: &[SeedVerdict<'_>]) -> String {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY).set_header([
        "scenario",
        "verdict",
        "passed",
        "must",
        "lateral RMS, median",
        "worst",
        "heading RMS, median",
        "worst",
        "worst seed",
    ]);
    for scenario in scenarios {
        let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
        let of = |spread: Option<Spread>, scale: f64, digits: usize, unit: &str| {
            let value = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{:.digits$} {unit}", v * scale));
            [right(value(spread.map(|s| s.median))), right(value(spread.map(|s| s.worst)))]
        };
        let lateral = of(scenario.spread(|run| run.summary.metrics.lateral_rms_m), 1e3, 3, "mm");
        let heading = of(scenario.spread(|run| run.summary.metrics.heading_rms_rad), 1f64.to_degrees(), 3, "deg");
        let worst = scenario.worst_first().first().map_or("-".to_owned(), |run| run.summary.seed.to_string());
        let mut row = vec![
            Cell::new(&scenario.scenario.name),
            scenario.verdict().map_or(Cell::new("-"), verdict_table::cell),
            right(format!("{}/{}", scenario.passed(), scenario.seeds)),
            right(scenario.at_least.to_string()),
        ];
        row.extend(lateral);
        row.extend(heading);
        row.push(right(worst));
        table.add_row(row);
    }
    let mut text = table.to_string();
    for scenario in scenarios {
        let missed: Vec<_> = not_passed(scenario);
        if missed.is_empty() {
            continue;
        }
        let (name, count) = (&scenario.scenario.name, missed.len());
        text += &format!("\n{name}: {count} of {} seeds did not pass, and {} must", scenario.seeds, scenario.at_least);
        for run in missed.iter().take(TOLD) {
            text += &format!("\n{}", verdict_table::reasons(&run.name, scenario.scenario, &run.summary));
        }
        if count > TOLD {
            text += &format!("\nand {} more of {name}", count - TOLD);
        }
    }
    text
}

/// The runs whose reports are worth a look where there are too many to name all: those that [`show`] names, and where all passed the
/// worst.
pub(crate) fn notable<'a>(scenario: &'a SeedVerdict<'_>) -> Vec<&'a Finished> {
    let missed = not_passed(scenario);
    if missed.is_empty() { scenario.worst_first().into_iter().take(1).collect() } else { missed.into_iter().take(TOLD).collect() }
}

fn not_passed<'a>(scenario: &'a SeedVerdict<'_>) -> Vec<&'a Finished> {
    scenario.worst_first().into_iter().filter(|run| run.summary.verdict != Verdict::Pass).collect()
}
