//! The plots of a study.

use crate::report::plot::{Level, Plot, Series, Style};
use crate::scenario::study_file::StudyFile;
use crate::scenario::sweep_file::{Factor, Levels};
use crate::tune::front;
use crate::tune::held_out::Trajectories;
use crate::tune::search::Search;

/// Two objectives against each other: all candidates, those that no other betters, the default and the compromise.
pub(super) fn front_plot(study: &StudyFile, search: &Search, [x, y]: [usize; 2]) -> Option<Plot> {
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
            series("default", "collision", vec![at(0)]),
        ],
    })
}

/// How much of the box between the least of each objective and the worst of each the front covers, over the trials.
pub(super) fn volume(search: &Search) -> Option<Plot> {
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
pub(super) fn convergence(search: &Search) -> Option<Plot> {
    let full: Vec<(f64, f64)> = search
        .trials
        .iter()
        .filter(|trial| trial.is_full && trial.costs.is_feasible())
        .map(|trial| (trial.number as f64, trial.costs.objectives[0]))
        .collect();
    let default = &search.trials.first()?.costs;
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
    let levels = match default.is_feasible() {
        true => vec![Level { y: scale * default.objectives[0], class: "bound", label: "default".into() }],
        false => Vec::new(),
    };
    Some(Plot {
        x_label: "candidate".into(),
        y_label,
        x: [0.0, search.trials.len().max(2) as f64],
        y: about(scale * costs[0].min(default.objectives[0]), scale * usual.max(default.objectives[0])),
        height: 260.0,
        bands: Vec::new(),
        levels,
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
