//! What a sweep comes to: over all cases, at each point, and at each level of each factor (its main effect: all else averaged).

use serde_json::{Map, Value, json};

use super::pass_rate::wilson;
use super::table::{Row, Table};
use crate::metrics::Verdict;
use crate::scenario::sweep_file::{Factor, Levels, SweepFile};

/// Values of a factor that are told one by one.
const MOST_LEVELS: usize = 32;
/// Bins that more values are cut into: as many cases in each.
const BINS: usize = 8;

/// Cases that have something in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// What they have in common, as people read it.
    pub label: String,
    /// The same as a number: for a range its middle.
    pub at: Option<f64>,
    /// How many cases ended with each verdict: pass, fail, error, timeout.
    pub verdicts: [u64; 4],
    /// Figures of each of the sweep's metrics, over the cases that have it.
    pub metrics: Vec<Option<Spread>>,
}

/// How a metric is spread over cases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Cases that have it.
    pub count: usize,
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// Least.
    pub least: f64,
    /// Greatest.
    pub greatest: f64,
}

/// A factor's main effect: its levels in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// The factor's path, or `base`.
    pub factor: String,
    /// Its unit.
    pub unit: String,
    /// Whether its levels are numbers.
    pub is_numeric: bool,
    /// The levels.
    pub levels: Vec<Group>,
}

impl Group {
    /// Of some rows.
    fn of<'r>(label: String, at: Option<f64>, sweep: &SweepFile, rows: impl Iterator<Item = &'r Row> + Clone) -> Self {
        let mut verdicts = [0; 4];
        for row in rows.clone() {
            verdicts[row.outcome.verdict as usize] += 1;
        }
        let spread = |metric: &String| Spread::of(rows.clone().filter_map(|row| row.outcome.metric(metric)).collect());
        Self { label, at, verdicts, metrics: sweep.metrics.iter().map(spread).collect() }
    }

    /// How many cases there are.
    pub fn cases(&self) -> u64 {
        self.verdicts.iter().sum()
    }

    /// How many passed.
    pub fn passed(&self) -> u64 {
        self.verdicts[Verdict::Pass as usize]
    }

    /// Share that passed; `None` of no cases.
    pub fn pass_rate(&self) -> Option<f64> {
        (self.cases() > 0).then(|| self.passed() as f64 / self.cases() as f64)
    }

    /// 95 % interval of the pass rate.
    pub fn interval(&self) -> [f64; 2] {
        wilson(self.passed(), self.cases())
    }

    /// As a document has it.
    pub fn to_json(&self, sweep: &SweepFile) -> Value {
        let [pass, fail, error, timeout] = self.verdicts;
        let metrics: Map<String, Value> = sweep
            .metrics
            .iter()
            .zip(&self.metrics)
            .map(|(name, spread)| {
                let figures = |s: &Spread| json!({"mean": s.mean, "median": s.median, "min": s.least, "max": s.greatest});
                (name.clone(), spread.as_ref().map_or(Value::Null, figures))
            })
            .collect();
        json!({
            "cases": self.cases(), "pass": pass, "fail": fail, "error": error, "timeout": timeout,
            "pass_rate": self.pass_rate(), "pass_rate_interval": self.interval(), "metrics": metrics,
        })
    }
}

impl Spread {
    /// Of some values; `None` of none.
    fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let (least, greatest) = (*values.first()?, *values.last()?);
        let half = values.len() / 2;
        let median = if values.len() % 2 == 1 { values[half] } else { (values[half - 1] + values[half]) / 2.0 };
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Some(Self { count: values.len(), mean, median, least, greatest })
    }
}

/// All cases as one group.
pub fn overall(sweep: &SweepFile, table: &Table) -> Group {
    Group::of("all".into(), None, sweep, table.rows.iter())
}

/// The groups of the points, in their order, each with the number of its point.
pub fn points(sweep: &SweepFile, table: &Table) -> Vec<(u64, Group)> {
    let of_a_point = table.rows.chunk_by(|a, b| a.case.point == b.case.point);
    of_a_point.map(|rows| (rows[0].case.point, Group::of(point_label(sweep, &rows[0]), None, sweep, rows.iter()))).collect()
}

/// A point in a line: the values of its factors, and its base where there are several.
pub fn point_label(sweep: &SweepFile, row: &Row) -> String {
    let base = (sweep.bases.len() > 1).then(|| sweep.bases[row.case.at.base].name.clone());
    let values = sweep.factors.iter().zip(&row.case.at.values);
    let values = values.filter_map(|(factor, value)| Some(format!("{} = {}", short(&factor.path), value.as_ref()?.shown())));
    let label = base.into_iter().chain(values).collect::<Vec<_>>().join(", ");
    if label.is_empty() { "the base itself".into() } else { label }
}

/// The last step of a path.
fn short(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}

/// The main effect of each factor; of the bases, too, where there are several.
pub fn effects(sweep: &SweepFile, table: &Table) -> Vec<Effect> {
    let mut effects = Vec::new();
    if sweep.bases.len() > 1 {
        let of = |base: usize| table.rows.iter().filter(move |row| row.case.at.base == base);
        let levels = sweep.bases.iter().enumerate();
        let levels = levels.map(|(index, base)| Group::of(base.name.clone(), None, sweep, of(index))).collect();
        effects.push(Effect { factor: "base".into(), unit: String::new(), is_numeric: false, levels });
    }
    for (index, factor) in sweep.factors.iter().enumerate() {
        effects.push(Effect {
            factor: factor.path.clone(),
            unit: factor.unit.clone(),
            is_numeric: factor.is_numeric(),
            levels: levels(sweep, table, index, factor),
        });
    }
    effects
}

fn levels(sweep: &SweepFile, table: &Table, index: usize, factor: &Factor) -> Vec<Group> {
    if factor.is_numeric() {
        return over_factor(sweep, &table.rows.iter().collect::<Vec<_>>(), index).into_iter().map(|(_, group)| group).collect();
    }
    let Levels::List(list) = &factor.levels else { return Vec::new() };
    let of = |level| table.rows.iter().filter(move |row| row.case.at.values[index].as_ref() == Some(level));
    list.iter().map(|level| Group::of(level.shown(), None, sweep, of(level))).collect()
}

/// Rows by the value of a factor whose values are numbers, in their order: a group a value, or where there are more than
/// 32 of them, bins with as many cases each.
pub fn over_factor(sweep: &SweepFile, rows: &[&Row], index: usize) -> Vec<(f64, Group)> {
    let value = |row: &Row| row.case.at.values[index].as_ref().and_then(|level| level.number());
    let mut rows: Vec<(f64, &Row)> = rows.iter().filter_map(|row| Some((value(row)?, *row))).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let by_value: Vec<&[(f64, &Row)]> = rows.chunk_by(|a, b| a.0 == b.0).collect();
    if by_value.len() <= MOST_LEVELS {
        let of = |rows: &[(f64, &Row)]| {
            let at = rows[0].0;
            (at, Group::of(crate::scenario::shown(at), Some(at), sweep, rows.iter().map(|(_, row)| *row)))
        };
        return by_value.into_iter().map(of).collect();
    }
    (0..BINS)
        .filter_map(|bin| {
            let within = &rows[bin * rows.len() / BINS..(bin + 1) * rows.len() / BINS];
            let (from, to) = (within.first()?.0, within.last()?.0);
            let middle = within.iter().map(|(value, _)| value).sum::<f64>() / within.len() as f64;
            Some((middle, Group::of(format!("{from:.4} to {to:.4}"), Some(middle), sweep, within.iter().map(|(_, row)| *row))))
        })
        .collect()
}

/// Cases that are the worst: errors, then timeouts, then failures; within each those furthest from the centreline first.
pub fn worst(table: &Table, count: usize) -> Vec<&Row> {
    let key = |row: &&Row| {
        let rank = match row.outcome.verdict {
            Verdict::Error => 3,
            Verdict::Timeout => 2,
            Verdict::Fail => 1,
            Verdict::Pass => 0,
        };
        (rank, row.outcome.metric("lateral_rms_m").unwrap_or(f64::INFINITY))
    };
    let mut rows: Vec<&Row> = table.rows.iter().collect();
    rows.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    rows.truncate(count);
    rows
}

/// What of the sweep's own bounds does not hold, in words; empty where all do.
pub fn misses(sweep: &SweepFile, overall: &Group, points: &[(u64, Group)]) -> Vec<String> {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let mut misses = Vec::new();
    if let (Some(least), Some(rate)) = (sweep.pass.pass_rate_min, overall.pass_rate())
        && rate < least
    {
        misses.push(format!("{} of the cases pass; {} are the least", percent(rate), percent(least)));
    }
    if let Some(least) = sweep.pass.point_pass_rate_min {
        for (_, group) in points.iter().filter(|(_, group)| group.pass_rate().is_some_and(|rate| rate < least)) {
            let rate = group.pass_rate().unwrap_or_default();
            misses.push(format!(
                "{} of the cases pass at {}; {} are the least at any point",
                percent(rate),
                group.label,
                percent(least)
            ));
        }
    }
    let [.., errors, timeouts] = overall.verdicts;
    for (most, found, what) in
        [(sweep.pass.errors, errors, "could not go on"), (sweep.pass.timeouts, timeouts, "reached the wall-clock limit")]
    {
        if let Some(most) = most.filter(|most| found > *most) {
            misses.push(format!("{found} cases {what}; {most} are the most"));
        }
    }
    misses
}

/// Points that a summary lists one by one.
const LISTED_POINTS: usize = 1000;

/// `summary.json`.
pub fn summary(sweep: &SweepFile, table: &Table, build: &str, renderer: &str) -> Value {
    let overall = overall(sweep, table);
    let points = points(sweep, table);
    let misses = misses(sweep, &overall, &points);
    let complete = table.missing == 0;
    let factors = |row: &Row| -> Map<String, Value> {
        let values = sweep.factors.iter().zip(&row.case.at.values);
        values
            .map(|(factor, value)| {
                let value =
                    value.as_ref().map_or(Value::Null, |value| value.number().map_or_else(|| json!(value.shown()), |n| json!(n)));
                (factor.path.clone(), value)
            })
            .collect()
    };
    let listed: Vec<Value> = if points.len() <= LISTED_POINTS {
        let rows = table.rows.chunk_by(|a, b| a.case.point == b.case.point);
        rows.zip(&points)
            .map(|(rows, (number, group))| {
                let mut point =
                    json!({"point": number, "base": sweep.bases[rows[0].case.at.base].name, "factors": factors(&rows[0])});
                merge(&mut point, group.to_json(sweep));
                point
            })
            .collect()
    } else {
        Vec::new()
    };
    let effects: Vec<Value> = effects(sweep, table)
        .iter()
        .map(|effect| {
            let levels = effect.levels.iter().map(|group| {
                let mut level = json!({"level": group.label, "at": group.at});
                merge(&mut level, group.to_json(sweep));
                level
            });
            json!({"factor": effect.factor, "unit": effect.unit, "levels": levels.collect::<Vec<_>>()})
        })
        .collect();
    let verdict = match (complete, misses.is_empty()) {
        (_, false) => "fail",
        (false, true) => "incomplete",
        (true, true) => "pass",
    };
    json!({
        "format": 1, "sweep": sweep.name, "verdict": verdict, "reasons": misses, "seed": sweep.seed, "renderer": renderer, "build": build,
        "missing": table.missing, "spared": table.spared, "all": overall.to_json(sweep), "effects": effects, "points": listed,
    })
}

fn merge(into: &mut Value, from: Value) {
    if let (Value::Object(into), Value::Object(from)) = (into, from) {
        into.extend(from);
    }
}
