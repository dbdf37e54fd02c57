//! The plots of a study.

use crate::report::plot::{Level, Plot, Series, Style};
use crate::scenario::study_file::StudyFile;
use crate::scenario::sweep_file::{Factor, Levels};
use crate::tune::front;
use crate::tune::held_out::Trajectories;
use crate::tune::search::{Search, Trial};

/// Two objectives against each other: all candidates, those that no other betters, the default and the compromise.
pub(super) fn front_plot(study: &StudyFile, search: &Search, [x, y]: [usize; 2]) -> Option<Plot> {
    let at = |index: usize| (search.trials[index].costs.objectives[x], Some(search.trials[index].costs.objectives[y]));
    let is_shown = |index: &usize| {
        let costs = &search.trials[*index].costs;
        search.trials[*index].is_full && costs.is_feasible() && costs.is_measured()
    };
    let all: Vec<usize> = (0..search.trials.len()).filter(is_shown).collect();
    // What is far behind would press the front into a corner: the dearest tenth is drawn at the edge, but nothing of the front.
    let ends = |objective: usize| {
        let cost = |index: &usize| search.trials[*index].costs.objectives[objective];
        let mut values: Vec<f64> = all.iter().map(cost).collect();
        values.sort_by(f64::total_cmp);
        let most = search.front.iter().map(cost).fold(*values.get(values.len().saturating_sub(1) * 9 / 10)?, f64::max);
        Some(about(*values.first()?, most))
    };
    let [ends_x, ends_y] = [ends(x)?, ends(y)?];
    let series = |label: &str, class: &'static str, shown: Vec<usize>| Series {
        label: label.into(),
        class,
        style: Style::Dots,
        points: shown.into_iter().map(at).map(|(x, y)| (x.min(ends_x[1]), y)).collect(),
    };
    let default = all.iter().copied().filter(|index| *index == 0).collect();
    Some(Plot {
        x_label: study.objectives[x].name.clone(),
        y_label: study.objectives[y].name.clone(),
        x: ends_x,
        y: ends_y,
        height: 320.0,
        bands: Vec::new(),
        levels: Vec::new(),
        series: vec![
            series("candidates", "estimate", all.clone()),
            series("front", "truth", search.front.clone()),
            series("compromise", "sigma", search.best.into_iter().collect()),
            series("default", "collision", default),
        ],
    })
}

/// How much of the box between the least of each objective and the worst of each the front covers, over the trials.
pub(super) fn volume(search: &Search) -> Option<Plot> {
    let shown = |trial: &&Trial| trial.is_full && trial.costs.is_feasible() && trial.costs.is_measured();
    let feasible = search.trials.iter().filter(shown);
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
pub(super) fn convergence(search: &Search) -> Option<Plot> {
    let full: Vec<(f64, f64)> = search
        .trials
        .iter()
        .filter(|trial| trial.is_full && trial.costs.is_feasible() && trial.costs.is_measured())
        .map(|trial| (trial.number as f64, trial.costs.objectives[0]))
        .collect();
    // Where it breaks constraints, or has no figures, there is no level to draw.
    let default = full.first().filter(|(number, _)| *number == 0.0).map(|(_, cost)| *cost);
    if full.is_empty() {
        return violations(search);
    }
    let mut costs: Vec<f64> = full.iter().map(|(_, cost)| *cost).collect();
    costs.sort_by(f64::total_cmp);
    let usual = *costs.get(costs.len().saturating_sub(1) * 9 / 10)?;
    let (scale, y_label) = readable("cost", usual);
    let mut least = f64::INFINITY;
    let so_far: Vec<(f64, Option<f64>)> = full
        .iter()
        .map(|(number, cost)| {
            least = least.min(*cost);
            (*number, Some(scale * least))
        })
        .collect();
    let level = |cost: f64| Level { y: scale * cost, class: "bound", label: "default".into() };
    let ends = [costs[0], usual].map(|cost| scale * cost);
    Some(Plot {
        x_label: "candidate".into(),
        y_label,
        x: [0.0, search.trials.len().max(2) as f64],
        y: default.map_or(about(ends[0], ends[1]), |cost| about(ends[0].min(scale * cost), ends[1].max(scale * cost))),
        height: 260.0,
        bands: Vec::new(),
        levels: default.map(level).into_iter().collect(),
        series: vec![
            Series {
                label: "candidates".into(),
                class: "estimate",
                style: Style::Dots,
                points: full.iter().map(|(number, cost)| (*number, Some(scale * cost))).collect(),
            },
            Series { label: "best so far".into(), class: "truth", style: Style::Steps, points: so_far },
        ],
    })
}

/// By how much candidates break the constraints, where none keeps them.
fn violations(search: &Search) -> Option<Plot> {
    let all: Vec<(f64, f64)> = search.trials.iter().map(|trial| (trial.number as f64, trial.costs.violation)).collect();
    let most = all.iter().map(|(_, violation)| *violation).fold(0.0, f64::max);
    (most > 0.0 && most.is_finite()).then(|| Plot {
        x_label: "candidate".into(),
        y_label: "violation".into(),
        x: [0.0, search.trials.len().max(2) as f64],
        y: [0.0, 1.05 * most],
        height: 260.0,
        bands: Vec::new(),
        levels: Vec::new(),
        series: vec![Series {
            label: "how far from keeping the constraints".into(),
            class: "estimate",
            style: Style::Dots,
            points: all.into_iter().map(|(number, violation)| (number, Some(violation))).collect(),
        }],
    })
}

/// A parameter against an objective: all candidates, and the best.
pub(super) fn scatter(parameter: &Factor, objective: &str, points: &[[f64; 2]], best: Option<f64>) -> Option<Plot> {
    let log = matches!(parameter.levels, Levels::Range { log: true, .. });
    let place = |value: f64| if log { libm::log10(value) } else { value };
    let values = || points.iter().map(|point| place(point[0]));
    let [from, to] = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
    if points.len() < 2 || from >= to {
        return None;
    }
    let margin = 0.02 * (to - from);
    let mut costs: Vec<f64> = points.iter().map(|point| point[1]).collect();
    costs.sort_by(f64::total_cmp);
    let usual = costs[(costs.len() - 1) * 9 / 10];
    let (scale, y_label) = readable(objective, usual);
    let (path, unit) = (&parameter.path, &parameter.unit);
    let name = if unit.is_empty() { path.clone() } else { format!("{path} / {unit}") };
    let dots = |is_best: bool| -> Vec<(f64, Option<f64>)> {
        let chosen = points.iter().filter(|[value, _]| !is_best || best == Some(*value));
        chosen.map(|[value, cost]| (place(*value), Some(scale * cost))).collect()
    };
    Some(Plot {
        x_label: if log { format!("log10 of {name}") } else { name },
        y_label,
        x: [from - margin, to + margin],
        y: about(scale * costs[0], scale * usual),
        height: 220.0,
        bands: Vec::new(),
        levels: Vec::new(),
        series: [("candidates", "truth", false), ("best", "collision", true)]
            .map(|(label, class, is_best)| Series { label: label.into(), class, style: Style::Dots, points: dots(is_best) })
            .into(),
    })
}

/// A factor that makes small numbers short enough for an axis, and the label that says so.
fn readable(name: &str, usual: f64) -> (f64, String) {
    if usual.abs() < 0.1 && usual != 0.0 { (1e3, format!("1000 {name}")) } else { (1.0, name.to_owned()) }
}

/// Both paths over the way.
pub(super) fn trajectories(paths: &Trajectories) -> Option<Plot> {
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
