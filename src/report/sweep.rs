//! The page of a sweep: how often its cases pass and what its metrics are, by factor and by pairs of factors; its worst cases, each with the
//! command that repeats it.

use minijinja::{Environment, Value, context};
use serde_json::Value as Json;

use super::{ReportError, STYLE};
use crate::sweep::figures::{self, Effect, Group};
use crate::sweep::plan::Plan;
use crate::sweep::repeat;
use crate::sweep::table::Table;

mod effects;
mod interactions;
mod pairs;

const PAGE: &str = include_str!("sweep.html");
/// Worst cases that are listed.
const WORST: usize = 12;
/// Points that are listed.
const LISTED_POINTS: usize = 100;

/// A metric as the page shows it.
#[derive(Clone, Copy, Debug)]
struct Shown {
    /// Its place among the sweep's metrics.
    index: usize,
    name: &'static str,
    title: &'static str,
    scale: f64,
}

/// The metrics that the page shows, of those that the sweep keeps.
fn shown(plan: &Plan) -> Vec<Shown> {
    const ALL: [(&str, &str, f64); 4] = [
        ("lateral_rms_m", "lateral RMS / mm", 1e3),
        ("heading_rms_rad", "heading RMS / °", 180.0 / std::f64::consts::PI),
        ("lateral_estimate_rms_m", "measured lateral, error / mm", 1e3),
        ("estimates_valid", "frames measured", 1.0),
    ];
    ALL.into_iter()
        .filter_map(|(name, title, scale)| {
            let index = plan.sweep.metrics.iter().position(|other| other == name)?;
            Some(Shown { index, name, title, scale })
        })
        .collect()
}

/// The page.
///
/// # Errors
/// Where the template fails.
pub fn html(plan: &Plan, table: &Table, summary: &Json) -> Result<String, ReportError> {
    let sweep = &plan.sweep;
    let metrics = shown(plan);
    let overall = figures::overall(sweep, table);
    let points = figures::points(sweep, table);
    let all_effects = figures::effects(sweep, table);
    let drawing = |svg: String| Value::from_safe_string(svg);
    let groups = |groups: &mut dyn Iterator<Item = &Group>| groups.map(|group| row(group, &metrics)).collect::<Vec<_>>();
    let effects: Vec<Value> = all_effects
        .iter()
        .map(|effect: &Effect| {
            let plots: Vec<Value> = effects::plots(effect, &metrics).into_iter().map(|plot| drawing(plot.svg())).collect();
            context! { factor => effect.factor.as_str(), unit => effect.unit.as_str(), rows => groups(&mut effect.levels.iter()), plots => plots }
        })
        .collect();
    let worst: Vec<Value> = figures::worst(table, WORST)
        .into_iter()
        .map(|row| {
            let why = row.outcome.error.clone().unwrap_or_else(|| row.outcome.reasons.clone());
            context! {
                case => row.case.index, label => figures::point_label(sweep, row), seed => row.case.seed,
                verdict => row.outcome.verdict.word(), why => why,
                lateral => row.outcome.metric("lateral_rms_m").map(|m| format!("{:.3}", 1e3 * m)),
                command => repeat::command(sweep, &row.case, &plan.renderer),
            }
        })
        .collect();
    let listed = if points.len() <= LISTED_POINTS { groups(&mut points.iter().map(|(_, group)| group)) } else { Vec::new() };
    let reasons: Vec<String> =
        summary["reasons"].as_array().into_iter().flatten().filter_map(Json::as_str).map(str::to_owned).collect();
    let mut environment = Environment::new();
    environment.add_template("sweep.html", PAGE)?;
    Ok(environment.get_template("sweep.html")?.render(context! {
        style => drawing(STYLE.to_owned()),
        name => sweep.name.as_str(), about => sweep.about.as_str(),
        verdict => summary["verdict"].as_str().map(str::to_owned), reasons => reasons,
        bases => sweep.bases.iter().map(|base| base.name.clone()).collect::<Vec<_>>(),
        design => sweep.design.word(), points_count => plan.points, cases => overall.cases(), seed => sweep.seed,
        replicates => sweep.replicates, common => sweep.common_random_numbers,
        missing => table.missing, spared => table.spared,
        titles => metrics.iter().map(|metric| metric.title).collect::<Vec<_>>(),
        overall => row(&overall, &metrics),
        effects => effects,
        interactions => interactions::plots(plan, table, &metrics).iter().map(|(_, plot)| drawing(plot.svg())).collect::<Vec<_>>(),
        maps => pairs::maps(plan, table, &metrics).iter().map(|map| drawing(map.svg())).collect::<Vec<_>>(),
        worst => worst,
        points => listed,
        build => plan.build.as_str(), version => plan.version.as_str(), renderer => plan.renderer.as_str(),
    })?)
}

/// The plots of a factor over another as pictures of their own, each with its file's name.
pub fn pictures(plan: &Plan, table: &Table) -> Vec<(String, String)> {
    let plots = interactions::plots(plan, table, &shown(plan));
    plots.iter().map(|(name, plot)| (format!("{name}.svg"), interactions::standalone(plot))).collect()
}

/// A group as a row of a table.
fn row(group: &Group, metrics: &[Shown]) -> Value {
    let [low, high] = group.interval();
    let [_, fail, error, timeout] = group.verdicts;
    let figures: Vec<Value> = metrics
        .iter()
        .map(|metric| match &group.metrics[metric.index] {
            Some(spread) => {
                let text = |value: f64| format!("{:.3}", value * metric.scale);
                context! { median => text(spread.median), least => text(spread.least), greatest => text(spread.greatest) }
            }
            None => Value::UNDEFINED,
        })
        .collect();
    context! {
        label => group.label.as_str(), passed => group.passed(), cases => group.cases(), fail => fail, error => error, timeout => timeout,
        interval => format!("{:.0} to {:.0} %", 100.0 * low, 100.0 * high), metrics => figures,
    }
}
