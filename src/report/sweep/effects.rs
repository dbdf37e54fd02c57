//! Main effects as plots: the pass rate with its interval, and each metric from its least to its greatest value.

use super::Shown;
use crate::report::plot::{Plot, Series, Style};
use crate::sweep::figures::{Effect, Group};

/// The plots of a factor whose levels are numbers; none of another, for which its table says it all.
pub(super) fn plots(effect: &Effect, metrics: &[Shown]) -> Vec<Plot> {
    let levels: Vec<(f64, &Group)> = effect.levels.iter().filter_map(|group| Some((group.at?, group))).collect();
    let (Some((first, _)), Some((last, _))) = (levels.first(), levels.last()) else { return Vec::new() };
    if !effect.is_numeric || levels.len() < 2 {
        return Vec::new();
    }
    let margin = 0.02 * (last - first);
    let x = [first - margin, last + margin];
    let label = if effect.unit.is_empty() { effect.factor.clone() } else { format!("{} / {}", effect.factor, effect.unit) };
    let percent = |share: f64| 100.0 * share;
    let mut plots = vec![Plot {
        x_label: label.clone(),
        y_label: "passed / %".into(),
        x,
        y: [0.0, 100.0],
        height: 220.0,
        bands: Vec::new(),
        levels: Vec::new(),
        series: vec![
            area("95 % interval", levels.iter().map(|(x, group)| (*x, Some(group.interval().map(percent)))).collect()),
            line("passed", levels.iter().map(|(x, group)| (*x, group.pass_rate().map(percent))).collect()),
        ],
    }];
    for metric in metrics {
        let spread = |group: &Group| group.metrics[metric.index];
        let most = levels.iter().filter_map(|(_, group)| Some(spread(group)?.greatest * metric.scale)).fold(0.0, f64::max);
        if most <= 0.0 {
            continue;
        }
        let between =
            levels.iter().map(|(x, group)| (*x, spread(group).map(|s| [s.least, s.greatest].map(|v| v * metric.scale))));
        let medians = levels.iter().map(|(x, group)| (*x, spread(group).map(|s| s.median * metric.scale)));
        plots.push(Plot {
            x_label: label.clone(),
            y_label: metric.title.into(),
            x,
            y: [0.0, 1.05 * most],
            height: 220.0,
            bands: Vec::new(),
            levels: Vec::new(),
            series: vec![area("least to greatest", between.collect()), line("median", medians.collect())],
        });
    }
    plots
}

fn line(label: &str, points: Vec<(f64, Option<f64>)>) -> Series {
    Series { label: label.into(), class: "truth", style: Style::Line, points }
}

/// The outline of a band: along its lower edge and back along its upper one.
fn area(label: &str, ends: Vec<(f64, Option<[f64; 2]>)>) -> Series {
    let known: Vec<(f64, [f64; 2])> = ends.into_iter().filter_map(|(x, ends)| Some((x, ends?))).collect();
    let lower = known.iter().map(|(x, [low, _])| (*x, Some(*low)));
    let upper = known.iter().rev().map(|(x, [_, high])| (*x, Some(*high)));
    Series { label: label.into(), class: "swept", style: Style::Area, points: lower.chain(upper).collect() }
}
