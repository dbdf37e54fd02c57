//! The page of a study: convergence, parameters against the cost, and the find against the default on what was held out.

use minijinja::{Environment, Value, context};

use super::plot::{Level, Plot, Series, Style};
use super::{ReportError, STYLE};
use crate::scenario::study_file::{Objective, Over, StudyFile};
use crate::scenario::sweep_file::SweepFile;
use crate::tune::comparison::Comparison;
use crate::tune::search::Search;
use crate::tune::summary::{Held, Trajectories, against, rank_correlation, verdict_words};
use crate::tune::trials::{mean, metrics};
use crate::tune::{candidate, front};

const PAGE: &str = include_str!("tune.html");

/// The page.
///
/// # Errors
/// Where the template fails.
pub fn html(
    study: &StudyFile,
    search: &Search,
    held: Option<&Held>,
    paths: Option<&Trajectories>,
) -> Result<String, ReportError> {
    let several = study.objectives.len() > 1;
    let pairs = (0..study.objectives.len()).flat_map(|x| (x + 1..study.objectives.len()).map(move |y| [x, y]));
    let fronts: Vec<Value> = pairs.filter_map(|pair| front_plot(study, search, pair)).map(drawing).collect();
    let mut environment = Environment::new();
    environment.add_template("tune.html", PAGE)?;
    Ok(environment.get_template("tune.html")?.render(context! {
        style => Value::from_safe_string(STYLE.to_owned()),
        name => study.name.as_str(), about => study.about.as_str(),
        words => verdict_words(study, search, held),
        is_better => held.is_some_and(Held::is_better),
        optimiser => search.optimiser.as_str(), seed => study.seed,
        objectives => study.objectives.iter().map(objective_words).collect::<Vec<_>>(),
        names => study.objectives.iter().map(|objective| objective.name.clone()).collect::<Vec<_>>(),
        train => names(&study.train), held_out => names(&study.held_out), several => several,
        convergence => if several { volume(search) } else { convergence(search) }.map(drawing),
        fronts => fronts,
        parameters => (0..study.parameters.len()).map(|index| parameter(study, search, index)).collect::<Vec<_>>(),
        comparisons => held.map(|held| comparisons(study, held)),
        metrics => metric_rows(study, search, held),
        paths => paths.and_then(trajectories).map(drawing), paths_label => paths.map(|paths| paths.label.clone()),
    })?)
}

fn drawing(plot: Plot) -> Value {
    Value::from_safe_string(plot.svg())
}

/// What an objective is, in words.
fn objective_words(objective: &Objective) -> String {
    let over = match objective.over {
        Over::Mean => "the mean over the runs".to_owned(),
        Over::Worst => "the worst of the runs".to_owned(),
        Over::Quantile(share) => format!("the {share} quantile over the runs"),
    };
    let terms: Vec<String> = objective.weights.iter().map(|(metric, weight)| format!("{weight} {metric}")).collect();
    let relative = if objective.relative { " as a share of the default's own run" } else { "" };
    format!("{}: {}{relative}, {over}", objective.name, terms.join(" + "))
}

fn names(sweep: &SweepFile) -> String {
    let names: Vec<&str> = sweep.bases.iter().map(|base| base.name.as_str()).collect();
    format!("{} ({} seeds of each)", names.join(", "), sweep.replicates)
}

/// A parameter's row and its plots, one an objective.
fn parameter(study: &StudyFile, search: &Search, index: usize) -> Value {
    let parameter = &study.parameters[index];
    let best = search.best.and_then(|best| search.trials[best].values.as_ref());
    let by: Vec<Value> = study
        .objectives
        .iter()
        .enumerate()
        .map(|(at, objective)| {
            let points = against(search, index, at);
            context! {
                correlation => rank_correlation(&points).map(|rho| format!("{rho:+.2}")),
                plot => scatter(&parameter.path, &parameter.unit, &objective.name, &points).map(drawing),
            }
        })
        .collect();
    context! {
        path => parameter.path.as_str(), unit => parameter.unit.as_str(),
        default => candidate::default(study, parameter).map(crate::scenario::shown),
        found => best.map(|values| values[index].shown()), by => by,
    }
}

/// The figures on what was held out: a row for each that stands for what was found, and each objective.
fn comparisons(study: &StudyFile, held: &Held) -> Vec<Value> {
    let number = |value: f64| format!("{value:.4e}").parse::<f64>().map_or_else(|_| "-".to_owned(), crate::scenario::shown);
    let row = |trial: usize, objective: &Objective, held: &Comparison| {
        context! {
            trial => trial, objective => objective.name.as_str(), pairs => held.pairs, better => held.better,
            default => number(held.default_cost), best => number(held.best_cost), gain => number(held.gain),
            least => number(held.interval[0]), most => number(held.interval[1]), p => format!("{:.4}", held.p_value),
        }
    };
    let of = |found: &crate::tune::summary::HeldTrial| -> Vec<Value> {
        let each = study.objectives.iter().zip(&found.comparisons);
        each.filter_map(|(objective, held)| Some(row(found.trial, objective, held.as_ref()?))).collect()
    };
    held.found.iter().flat_map(of).collect()
}

/// Means of the metrics, of default and best, over the training runs and those held out.
fn metric_rows(study: &StudyFile, search: &Search, held: Option<&Held>) -> Vec<Value> {
    let number = |value: Option<f64>| value.map(|value| format!("{value:.5}"));
    let rows = |index: usize| &search.trials[index].rows;
    let found = held.and_then(|held| held.found.first());
    let row = |metric: String| {
        context! {
            default => number(mean(rows(0), &metric)), best => search.best.and_then(|best| number(mean(rows(best), &metric))),
            held_default => held.and_then(|held| number(mean(&held.default, &metric))),
            held_best => found.and_then(|found| number(mean(&found.rows, &metric))), metric => metric,
        }
    };
    metrics(study).into_iter().map(row).collect()
}

/// Two objectives against each other: all candidates, those that no other betters, the default and the compromise.
fn front_plot(study: &StudyFile, search: &Search, [x, y]: [usize; 2]) -> Option<Plot> {
    let at = |index: usize| (search.trials[index].costs.objectives[x], Some(search.trials[index].costs.objectives[y]));
    let all: Vec<(f64, Option<f64>)> = (0..search.trials.len())
        .filter(|index| search.trials[*index].is_full && search.trials[*index].costs.is_feasible())
        .map(at)
        .collect();
    let mut front: Vec<(f64, Option<f64>)> = search.front.iter().map(|index| at(*index)).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    // What is far behind would press the front into a corner: the dearest tenth is drawn at the edge.
    let ends = |values: Vec<f64>| {
        let mut values = values;
        values.sort_by(f64::total_cmp);
        Some(about(*values.first()?, *values.get((values.len() - 1) * 9 / 10)?))
    };
    let series = |label: &str, class: &'static str, points: Vec<(f64, Option<f64>)>| Series {
        label: label.into(),
        class,
        style: Style::Dots,
        points,
    };
    Some(Plot {
        x_label: study.objectives[x].name.clone(),
        y_label: study.objectives[y].name.clone(),
        x: ends(all.iter().map(|point| point.0).collect())?,
        y: ends(all.iter().filter_map(|point| point.1).collect())?,
        height: 320.0,
        bands: Vec::new(),
        levels: Vec::new(),
        series: vec![
            series("candidates", "estimate", all),
            series("front", "truth", front),
            series("default", "fault", vec![at(0)]),
        ],
    })
}

/// How much of the box between the least of each objective and the worst of each the front covers, over the trials.
fn volume(search: &Search) -> Option<Plot> {
    let feasible = search.trials.iter().filter(|trial| trial.is_full && trial.costs.is_feasible());
    let scaled = front::scaled(&feasible.map(|trial| trial.costs.clone()).collect::<Vec<_>>());
    let reference = vec![1.0; search.trials.first()?.costs.objectives.len()];
    let points: Vec<(f64, Option<f64>)> =
        (0..scaled.len()).map(|last| (last as f64, Some(front::hypervolume(&scaled[..=last], &reference)))).collect();
    let most = points.last()?.1?;
    Some(Plot {
        x_label: "candidate that keeps the constraints".into(),
        y_label: "share covered".into(),
        x: [0.0, points.len().max(2) as f64],
        y: [0.0, (1.05 * most).max(f64::MIN_POSITIVE)],
        height: 260.0,
        bands: Vec::new(),
        levels: Vec::new(),
        series: vec![Series { label: "hypervolume of the front".into(), class: "truth", style: Style::Steps, points }],
    })
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
        .filter(|trial| trial.is_full && trial.costs.is_feasible())
        .map(|trial| (trial.number as f64, trial.costs.objectives[0]))
        .collect();
    let default = &search.trials.first()?.costs;
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
        true => vec![Level { y: default.objectives[0], class: "bound", label: "default".into() }],
        false => Vec::new(),
    };
    Some(Plot {
        x_label: "candidate".into(),
        y_label: "cost".into(),
        x: [0.0, search.trials.len().max(2) as f64],
        y: about(costs[0].min(default.objectives[0]), usual.max(default.objectives[0])),
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

fn scatter(path: &str, unit: &str, objective: &str, points: &[[f64; 2]]) -> Option<Plot> {
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
        y_label: objective.to_owned(),
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
