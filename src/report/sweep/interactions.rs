//! A factor that is a word against one that is a number: how often cases pass, and how well they track, over the number, a line a word.

use super::Shown;
use crate::report::STYLE;
use crate::report::plot::{Plot, Series, Style};
use crate::scenario::sweep_file::SweepFile;
use crate::sweep::figures::{self, Group};
use crate::sweep::plan::Plan;
use crate::sweep::table::{Row, Table};

/// Colours of the lines.
const CLASSES: [&str; 7] = ["truth", "estimate", "right", "rms", "nominal", "degraded", "stopped"];
/// Plots of a page.
const MOST: usize = 12;

/// The plots, each with a name for its file.
pub(super) fn plots(plan: &Plan, table: &Table, metrics: &[Shown]) -> Vec<(String, Plot)> {
    let sweep = &plan.sweep;
    let mut plots = Vec::new();
    let factors = sweep.factors.iter().enumerate();
    let worded = factors.filter(|(_, factor)| !factor.is_numeric()).map(|(index, _)| Word::Factor(index));
    for word in (sweep.bases.len() > 1).then_some(Word::Base).into_iter().chain(worded) {
        let name = word.name(sweep);
        for (index, factor) in sweep.factors.iter().enumerate().filter(|(_, factor)| factor.is_numeric()) {
            let x_label = if factor.unit.is_empty() { factor.path.clone() } else { format!("{} / {}", factor.path, factor.unit) };
            let lines = lines(plan, table, index, word);
            if lines.len() < 2 || lines.len() > CLASSES.len() || lines.iter().any(|(_, groups)| groups.len() < 2) {
                continue;
            }
            let file = |what: &str| format!("{what}-over-{}-by-{}", factor.path, name).replace(['.', '[', ']'], "-");
            let plot = |y_label: &str, value: &dyn Fn(&Group) -> Option<f64>| over(&lines, &x_label, y_label, None, value);
            let rate = |group: &Group| group.pass_rate().map(|rate| 100.0 * rate);
            plots.extend(over(&lines, &x_label, "passed / %", Some(100.0), &rate).map(|p| (file("pass-rate"), p)));
            for metric in metrics.iter().take(2) {
                let median = |group: &Group| group.metrics[metric.index].map(|spread| spread.median * metric.scale);
                plots.extend(plot(&format!("{}, median", metric.title), &median).map(|p| (file(metric.name), p)));
            }
        }
    }
    plots.truncate(MOST);
    plots
}

/// What of a case is a word.
#[derive(Clone, Copy, Debug)]
enum Word {
    /// Its base, where there are several.
    Base,
    /// The value of a factor that is no number.
    Factor(usize),
}

impl Word {
    fn name(self, sweep: &SweepFile) -> &str {
        match self {
            Self::Base => "base",
            Self::Factor(index) => &sweep.factors[index].path,
        }
    }

    fn of(self, sweep: &SweepFile, row: &Row) -> Option<String> {
        match self {
            Self::Base => Some(sweep.bases[row.case.at.base].name.clone()),
            Self::Factor(index) => Some(row.case.at.values[index].as_ref()?.shown()),
        }
    }
}

/// For each word, the groups of its cases by the factor's value.
type Lines = Vec<(String, Vec<(f64, Group)>)>;

fn lines(plan: &Plan, table: &Table, index: usize, word: Word) -> Lines {
    let of_row = |row: &Row| word.of(&plan.sweep, row);
    let mut names: Vec<String> = Vec::new();
    for name in table.rows.iter().filter_map(of_row) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let of = |name: &String| {
        let rows: Vec<&Row> = table.rows.iter().filter(|row| of_row(row).as_ref() == Some(name)).collect();
        (name.clone(), figures::over_factor(&plan.sweep, &rows, index))
    };
    names.iter().map(of).collect()
}

/// A plot of a value over the factor, up to `most` or the greatest; `None` where no group has it.
fn over(lines: &Lines, x_label: &str, y_label: &str, most: Option<f64>, value: &dyn Fn(&Group) -> Option<f64>) -> Option<Plot> {
    let all = || lines.iter().flat_map(|(_, groups)| groups);
    let (first, last) =
        (all().map(|(x, _)| *x).fold(f64::INFINITY, f64::min), all().map(|(x, _)| *x).fold(f64::NEG_INFINITY, f64::max));
    let most = most.unwrap_or_else(|| 1.05 * all().filter_map(|(_, group)| value(group)).fold(0.0, f64::max));
    if first >= last || most <= 0.0 {
        return None;
    }
    let series = lines.iter().zip(CLASSES).map(|((name, groups), class)| {
        let points = groups.iter().map(|(x, group)| (*x, value(group))).collect();
        Series { label: name.clone(), class, style: Style::Line, points }
    });
    let margin = 0.02 * (last - first);
    Some(Plot {
        x_label: x_label.into(),
        y_label: y_label.into(),
        x: [first - margin, last + margin],
        y: [0.0, most],
        height: 260.0,
        bands: Vec::new(),
        levels: Vec::new(),
        series: series.collect(),
    })
}

/// A plot as a picture of its own, with the colours of the page.
pub(super) fn standalone(plot: &Plot) -> String {
    let style = format!("<style>{STYLE}\nsvg {{ background: var(--card); }}</style>");
    let svg = plot.svg();
    match svg.split_once('>') {
        Some((head, rest)) => format!("{} xmlns=\"http://www.w3.org/2000/svg\">\n{style}{rest}", head),
        None => svg,
    }
}
