//! Pairs of factors as heat maps: the share of cases that fail, and the metric of tracking.

use super::Shown;
use crate::report::heat_map::{HeatMap, Mean};
use crate::scenario::sweep_file::{Factor, Levels};
use crate::sweep::plan::Plan;
use crate::sweep::table::{Row, Table};

/// Pairs that are shown; a sweep of more factors shows those of the first.
const MOST_PAIRS: usize = 6;
/// Fields along an axis whose values are drawn, at most.
const MOST_FIELDS: usize = 12;

/// The maps of all pairs of factors whose values are numbers.
pub(super) fn maps(plan: &Plan, table: &Table, metrics: &[Shown]) -> Vec<HeatMap> {
    let factors: Vec<(usize, &Factor)> =
        plan.sweep.factors.iter().enumerate().filter(|(_, factor)| factor.is_numeric()).collect();
    let mut maps = Vec::new();
    for (nth, first) in factors.iter().enumerate() {
        for second in &factors[nth + 1..] {
            if maps.len() / 2 >= MOST_PAIRS {
                return maps;
            }
            let map = |title: &str, value: &dyn Fn(&Row) -> Option<f64>| of_pair(title, [*first, *second], table, value);
            maps.extend(map("share that does not pass", &|row| Some(if row.outcome.passed() { 0.0 } else { 1.0 })));
            if let Some(metric) = metrics.first() {
                maps.extend(map(metric.title, &|row| row.outcome.metric(metric.name).map(|value| value * metric.scale)));
            }
        }
    }
    maps
}

fn of_pair(title: &str, factors: [(usize, &Factor); 2], table: &Table, value: &dyn Fn(&Row) -> Option<f64>) -> Option<HeatMap> {
    let at = |row: &Row, axis: usize| row.case.at.values[factors[axis].0].as_ref()?.number();
    let mut points: Vec<[f64; 3]> = table.rows.iter().filter_map(|row| Some([at(row, 0)?, at(row, 1)?, value(row)?])).collect();
    let mut axes = [0, 1].map(|axis| Axis::of(factors[axis].1, points.iter().map(|point| point[axis])));
    for axis in &axes {
        axis.as_ref()?;
    }
    for point in &mut points {
        for axis in 0..2 {
            point[axis] = axes[axis].as_ref()?.place(point[axis]);
        }
    }
    let [x, y] = [axes[0].take()?, axes[1].take()?];
    let labels = [x.label.as_str(), y.label.as_str()];
    Some(HeatMap::of(title, labels, [x.range, y.range], [x.fields, y.fields], Mean::Plain, points.into_iter()))
}

/// An axis of a map.
struct Axis {
    label: String,
    range: [f64; 2],
    fields: usize,
    /// The values of a factor that lists them, in their order; each has a field.
    listed: Vec<f64>,
}

impl Axis {
    fn of(factor: &Factor, values: impl Iterator<Item = f64>) -> Option<Self> {
        let label = if factor.unit.is_empty() { factor.path.clone() } else { format!("{} / {}", factor.path, factor.unit) };
        let mut listed: Vec<f64> = values.collect();
        listed.sort_by(f64::total_cmp);
        listed.dedup();
        let (first, last) = (*listed.first()?, *listed.last()?);
        if first >= last {
            return None;
        }
        if matches!(factor.levels, Levels::List(_)) && listed.len() <= 3 * MOST_FIELDS {
            // A field a value: half a step beyond the outermost, as wide as if the steps were even.
            let fields = listed.len();
            let half = (last - first) / (2 * (fields - 1)) as f64;
            return Some(Self { label, range: [first - half, last + half], fields, listed });
        }
        Some(Self { label, range: [first, last], fields: MOST_FIELDS, listed: Vec::new() })
    }

    /// Where a value is drawn: one of a list in the middle of its own field, whatever the steps.
    fn place(&self, value: f64) -> f64 {
        match self.listed.iter().position(|other| *other == value) {
            Some(nth) => self.range[0] + (nth as f64 + 0.5) / self.fields as f64 * (self.range[1] - self.range[0]),
            None => value,
        }
    }
}
