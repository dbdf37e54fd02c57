//! The page of a study: convergence, parameters against the cost, and the find against the default on what was held out.

use minijinja::{Environment, Value, context};
use serde_json::Value as Json;

use super::plot::{Level, Plot, Series, Style};
use super::{ReportError, STYLE};
use crate::scenario::study_file::{Over, StudyFile};
use crate::tune::search::Search;
use crate::tune::summary::{Trajectories, against, rank_correlation};

const PAGE: &str = include_str!("tune.html");

/// The page.
///
/// # Errors
/// Where the template fails.
pub fn html(study: &StudyFile, search: &Search, summary: &Json, paths: Option<&Trajectories>) -> Result<String, ReportError> {
    let drawing = |plot: Plot| Value::from_safe_string(plot.svg());
    let best = search.best.and_then(|best| search.trials[best].values.as_ref());
    let parameters: Vec<Value> = study
        .parameters
        .iter()
        .enumerate()
        .map(|(index, parameter)| {
            let points = against(search, index);
            let found = best.map(|values| &values[index]);
            context! {
                path => parameter.path.as_str(), unit => parameter.unit.as_str(),
                found => found.map(|value| value.shown()),
                correlation => rank_correlation(&points).map(|rho| format!("{rho:+.2}")),
                plot => scatter(&parameter.path, &parameter.unit, &points).map(drawing),
            }
        })
        .collect();
    let over = match study.objective.over {
        Over::Mean => "the mean over the runs".to_owned(),
        Over::Worst => "the worst of the runs".to_owned(),
        Over::Quantile(share) => format!("the {share} quantile over the runs"),
    };
    let terms: Vec<String> = study.objective.weights.iter().map(|(metric, weight)| format!("{weight} {metric}")).collect();
    let names = |sweep: &crate::scenario::sweep_file::SweepFile| {
        let names: Vec<&str> = sweep.bases.iter().map(|base| base.name.as_str()).collect();
        format!("{} ({} seeds of each)", names.join(", "), sweep.replicates)
    };
    let mut environment = Environment::new();
    environment.add_template("tune.html", PAGE)?;
    Ok(environment.get_template("tune.html")?.render(context! {
        style => Value::from_safe_string(STYLE.to_owned()),
        name => study.name.as_str(), about => study.about.as_str(),
        words => summary["verdict"].as_array().into_iter().flatten().filter_map(Json::as_str).map(str::to_owned).collect::<Vec<_>>(),
        is_better => summary["held_out"]["is_better"].as_bool().unwrap_or(false),
        optimiser => study.optimiser.word(), seed => study.seed, objective => terms.join(" + "), over => over,
        train => names(&study.train), held_out => names(&study.held_out),
        convergence => convergence(search).map(drawing),
        parameters => parameters,
        comparison => comparison(&summary["held_out"]["comparison"]),
        metrics => metrics(summary),
        paths => paths.and_then(trajectories).map(drawing), paths_label => paths.map(|paths| paths.label.clone()),
    })?)
}

/// The figures on what was held out; none where nothing was.
fn comparison(held: &Json) -> Value {
    let number = |value: &Json, digits: usize| value.as_f64().map(|value| format!("{value:.digits$}"));
    if held.is_null() {
        return Value::UNDEFINED;
    }
    context! {
        pairs => held["pairs"].as_u64(), better => held["better"].as_u64(),
        default => number(&held["default_cost"], 5), best => number(&held["best_cost"], 5), gain => number(&held["gain"], 5),
        least => number(&held["interval"][0], 5), most => number(&held["interval"][1], 5), p => number(&held["p_value"], 4),
    }
}

/// Means of the metrics over the training runs, of default and best.
fn metrics(summary: &Json) -> Vec<Value> {
    let of = |which: &str, metric: &str| summary[which]["metrics"][metric].as_f64().map(|value| format!("{value:.5}"));
    let names = summary["default"]["metrics"].as_object().into_iter().flat_map(|metrics| metrics.keys());
    names.map(|metric| context! { metric => metric, default => of("default", metric), best => of("best", metric) }).collect()
}

/// From a little below the least to a little above the largest.
fn about(least: f64, most: f64) -> [f64; 2] {
    let margin = (0.1 * (most - least)).max(0.01 * most.abs()).max(f64::MIN_POSITIVE);
    [least - margin, most + margin]
}

/// Costs over the trials that had all of their runs, and the best so far. Dear ones are drawn at the edge.
fn convergence(search: &Search) -> Option<Plot> {
    let full: Vec<(f64, f64)> = search
        .trials
        .iter()
        .filter(|trial| trial.is_full && trial.score.is_feasible())
        .map(|trial| (trial.number as f64, trial.score.cost))
        .collect();
    let default = search.trials.first()?.score;
    let mut least = f64::INFINITY;
    let so_far: Vec<(f64, Option<f64>)> = full
        .iter()
        .map(|(number, cost)| {
            least = least.min(*cost);
            (*number, Some(least))
        })
        .collect();
    let mut costs: Vec<f64> = full.iter().map(|(_, cost)| *cost).collect();
    costs.sort_by(f64::total_cmp);
    let usual = *costs.get(costs.len().saturating_sub(1) * 9 / 10)?;
    let levels = match default.is_feasible() {
        true => vec![Level { y: default.cost, class: "bound", label: "default".into() }],
        false => Vec::new(),
    };
    Some(Plot {
        x_label: "candidate".into(),
        y_label: "cost".into(),
        x: [0.0, search.trials.len().max(2) as f64],
        y: about(costs[0].min(default.cost), usual.max(default.cost)),
        height: 260.0,
        bands: Vec::new(),
        levels,
        series: vec![
            Series {
                label: "candidates".into(),
                class: "estimate",
                style: Style::Dots,
                points: full.iter().map(|(number, cost)| (*number, Some(*cost))).collect(),
            },
            Series { label: "best so far".into(), class: "truth", style: Style::Steps, points: so_far },
        ],
    })
}

fn scatter(path: &str, unit: &str, points: &[[f64; 2]]) -> Option<Plot> {
    let ends = |which: usize| {
        let values = || points.iter().map(|point| point[which]);
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    };
    let [from, to] = ends(0);
    if points.len() < 2 || from >= to {
        return None;
    }
    let margin = 0.02 * (to - from);
    let mut costs: Vec<f64> = points.iter().map(|point| point[1]).collect();
    costs.sort_by(f64::total_cmp);
    Some(Plot {
        x_label: if unit.is_empty() { path.to_owned() } else { format!("{path} / {unit}") },
        y_label: "cost".into(),
        x: [from - margin, to + margin],
        y: about(costs[0], costs[(costs.len() - 1) * 9 / 10]),
        height: 220.0,
        bands: Vec::new(),
        levels: Vec::new(),
        series: vec![Series {
            label: "candidates".into(),
            class: "truth",
            style: Style::Dots,
            points: points.iter().map(|[value, cost]| (*value, Some(*cost))).collect(),
        }],
    })
}

/// Both paths over the way.
fn trajectories(paths: &Trajectories) -> Option<Plot> {
    let all = || paths.paths.iter().flatten();
    let most = all().map(|[_, lateral]| 1e3 * lateral.abs()).fold(0.0, f64::max).max(1.0);
    let far = all().map(|[distance, _]| *distance).fold(0.0, f64::max);
    let near = all().map(|[distance, _]| *distance).fold(f64::INFINITY, f64::min);
    (far > near).then(|| Plot {
        x_label: "distance / m".into(),
        y_label: "lateral / mm".into(),
        x: [near, far],
        y: [-1.05 * most, 1.05 * most],
        height: 260.0,
        bands: Vec::new(),
        levels: vec![Level { y: 0.0, class: "bound", label: "middle of the duct".into() }],
        series: [("default", "estimate", 0), ("best", "truth", 1)]
            .map(|(label, class, which)| Series {
                label: label.into(),
                class,
                style: Style::Line,
                points: paths.paths[which].iter().map(|[distance, lateral]| (*distance, Some(1e3 * lateral))).collect(),
            })
            .into(),
    })
}
