//! The end of a sweep: table, summary and report in its folder, a table for people, an exit code.

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, Table as Grid};
use ductloop::Verdict;
use ductloop::scenario::sweep_file::SweepFile;
use ductloop::sweep::figures::{self, Group};
use ductloop::sweep::ledger::Damaged;
use ductloop::sweep::plan::Plan;
use ductloop::sweep::repeat;
use ductloop::sweep::store::Store;
use ductloop::sweep::table::Table;
use serde_json::Value;

use super::args::SayingArgs;
use crate::cli::problem::Problem;
use crate::cli::streams::{note, print, print_json};

/// Points that the table lists; of more, it lists the levels of each factor.
const LISTED_POINTS: usize = 40;
/// Cases that are named with their commands.
const WORST: usize = 3;

/// Tells of parts that cannot be read.
pub(super) fn tell_damage(store: &Store, damaged: &[Damaged]) {
    for part in damaged {
        note(&format!("warning: {}/{}: {}; `sweep work` runs its cases again", store.place(), part.name, part.error));
    }
}

/// Writes what comes of a sweep, shows it, and returns the exit code.
pub(super) fn conclude(plan: &Plan, store: &Store, table: &Table, saying: SayingArgs) -> Result<u8, Problem> {
    let sweep = &plan.sweep;
    let summary = figures::summary(sweep, table, &plan.build, &plan.renderer);
    write(plan, store, table, &summary)
        .map_err(|error| Problem::new(Problem::CANNOT_GO_ON, format!("{error:#}")).about(store.place()))?;
    if saying.json {
        print_json(&summary)?;
    }
    if !saying.quiet {
        let mut text = shown(sweep, table);
        for row in figures::worst(table, WORST).iter().filter(|row| !row.outcome.passed()) {
            let why = row.outcome.error.as_deref().unwrap_or(&row.outcome.reasons);
            text += &format!("\n{}: {why}\n  {}", row.outcome.verdict.word(), repeat::command(sweep, &row.case, &plan.renderer));
        }
        if table.missing > 0 {
            text += &format!("\nINCOMPLETE {} cases are missing", table.missing);
        }
        for reason in summary["reasons"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            text += &format!("\nFAIL {reason}");
        }
        text += &format!("\n{}/report.html", store.place());
        if saying.json { note(&text) } else { print(&text)? }
    }
    // What is not whole has not passed.
    let passed = summary["verdict"] == "pass";
    Ok(if passed { Verdict::Pass } else { Verdict::Fail }.exit_code())
}

fn write(plan: &Plan, store: &Store, table: &Table, summary: &Value) -> anyhow::Result<()> {
    store.replace("results.parquet", table.parquet(&plan.sweep)?)?;
    store.replace("report.html", ductloop::report::sweep::html(plan, table, summary)?.into_bytes())?;
    for (name, picture) in ductloop::report::sweep::pictures(plan, table) {
        store.replace(&format!("plots/{name}"), picture.into_bytes())?;
    }
    store.replace("summary.json", format!("{summary:#}\n").into_bytes())?;
    Ok(())
}

/// The table for people: a row a point, or a row a level of each factor, then all.
fn shown(sweep: &SweepFile, table: &Table) -> String {
    let points = figures::points(sweep, table);
    let metrics: Vec<(usize, &str, f64)> =
        [("lateral_rms_m", "lateral RMS / mm", 1e3), ("heading_rms_rad", "heading RMS / °", 1f64.to_degrees())]
            .into_iter()
            .filter_map(|(name, title, scale)| Some((sweep.metrics.iter().position(|other| other == name)?, title, scale)))
            .collect();
    let mut grid = Grid::new();
    let head = ["", "passed", "95 % interval"].into_iter().chain(metrics.iter().map(|(_, title, _)| *title));
    grid.load_style(UTF8_HORIZONTAL_ONLY).set_header(head);
    let mut add = |label: &str, group: &Group| {
        let [low, high] = group.interval();
        let mut cells = vec![
            label.to_owned(),
            format!("{}/{}", group.passed(), group.cases()),
            format!("{:.0} to {:.0} %", 100.0 * low, 100.0 * high),
        ];
        cells.extend(metrics.iter().map(|(index, _, scale)| {
            group.metrics[*index].map_or("-".to_owned(), |s| format!("{:.3} ({:.3})", s.median * scale, s.greatest * scale))
        }));
        grid.add_row(cells);
    };
    if points.len() <= LISTED_POINTS {
        points.iter().for_each(|(_, group)| add(&group.label, group));
    } else {
        for effect in figures::effects(sweep, table) {
            effect.levels.iter().for_each(|group| add(&format!("{} = {}", effect.factor, group.label), group));
        }
    }
    add("all", &figures::overall(sweep, table));
    grid.column_iter_mut().skip(1).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    let text = grid.to_string();
    let trimmed: Vec<_> = text.lines().map(str::trim_end).collect();
    format!("medians, the greatest in brackets\n{}", trimmed.join("\n"))
}
