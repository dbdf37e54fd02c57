//! What a study comes to: the find against the default on what was held out, as figures, words and paths.

use std::ops::ControlFlow;

use serde_json::{Map, Value, json};

use super::candidate;
use super::comparison::Comparison;
use super::objective::{broken, broken_in_the_mean, cost, counterpart};
use super::search::{Search, Trial};
use super::trials::{mean, metrics};
use crate::closed_loop::{RunError, run_unscored};
use crate::engine::Engine;
use crate::pilot::Pilot;
use crate::scenario::study_file::{Objective, StudyFile};
use crate::sweep::table::Row;

/// Pairs of which all signs are the same by chance in less than one of twenty cases: 2 / 2^6.
const LEAST_PAIRS: usize = 6;

/// Runs on what was held out, of the default and of what was found.
#[derive(Clone, Debug)]
pub struct Held {
    /// The default's runs.
    pub default: Vec<Row>,
    /// Those of the best, and of several objectives of the front's ends.
    pub found: Vec<HeldTrial>,
}

/// What was found, on what was held out.
#[derive(Clone, Debug)]
pub struct HeldTrial {
    /// Its number.
    pub trial: usize,
    /// Its runs, in the default's order: same ducts, same seeds.
    pub rows: Vec<Row>,
    /// It against the default by each objective, over the pairs that both measured; `None` without any.
    pub comparisons: Vec<Option<Comparison>>,
}

/// Lateral error along the way, of the default and of the find.
#[derive(Clone, Debug)]
pub struct Trajectories {
    /// What was run: scenario and seed.
    pub label: String,
    /// Distance along the duct and offset to the left of its middle, in metres, frame by frame.
    pub paths: [Vec<[f64; 2]>; 2],
}

/// Why two paths cannot be laid over each other.
#[derive(Debug, thiserror::Error)]
pub enum TrajectoryError {
    /// What was a scenario is none any more.
    #[error("{0}")]
    Scenario(#[from] crate::scenario::Diagnostics),
    /// The run could not begin or go on.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// What a pair of runs costs, the default's and another on the same duct with the same seed, if both measured it.
fn costs_of(objective: &Objective, (own, row): (&Row, &Row)) -> Option<[f64; 2]> {
    let of = |row: &Row| cost(objective, &row.outcome, Some(&own.outcome));
    Some([of(own)?, of(row)?])
}

impl Held {
    /// Of the rows of all, in the same order.
    pub fn of(study: &StudyFile, default: Vec<Row>, found: Vec<(usize, Vec<Row>)>) -> Self {
        let compared = |rows: &[Row]| {
            let against = |objective| {
                let pairs: Vec<[f64; 2]> = default.iter().zip(rows).filter_map(|pair| costs_of(objective, pair)).collect();
                Comparison::of(&pairs, study.seed)
            };
            study.objectives.iter().map(against).collect()
        };
        let found = found.into_iter().map(|(trial, rows)| HeldTrial { trial, comparisons: compared(&rows), rows }).collect();
        Self { default, found }
    }

    /// Mean costs by an objective of the default and of what was found, scenario by scenario, over the pairs that both measured.
    pub fn by_scenario(&self, study: &StudyFile, rows: &[Row], objective: &Objective) -> Vec<(String, [f64; 2])> {
        let of = |base: usize| {
            let pairs: Vec<[f64; 2]> = self
                .default
                .iter()
                .zip(rows)
                .filter(|(own, _)| own.case.at.base == base)
                .filter_map(|pair| costs_of(objective, pair))
                .collect();
            let mean = |which: usize| pairs.iter().map(|pair| pair[which]).sum::<f64>() / pairs.len() as f64;
            (!pairs.is_empty()).then(|| (study.held_out.bases[base].name.clone(), [mean(0), mean(1)]))
        };
        (0..study.held_out.bases.len()).filter_map(of).collect()
    }

    /// Runs the first pair of default and best once more, frame by frame.
    ///
    /// # Errors
    /// Where a scenario or a renderer is not there any more.
    pub fn trajectories(
        &self,
        study: &StudyFile,
        search: &Search,
        engine: &Engine,
    ) -> Result<Option<Trajectories>, TrajectoryError> {
        let Some(values) = search.best.and_then(|best| search.trials[best].values.as_ref()) else { return Ok(None) };
        let Some(case) = self.default.first().map(|row| &row.case) else { return Ok(None) };
        let path = |settings: &[String]| -> Result<Vec<[f64; 2]>, TrajectoryError> {
            let scenario = study.held_out.scenario(case.at.base, settings, case.seed)?;
            let mut renderer = engine.renderer(&scenario, 1)?;
            let record = run_unscored(&scenario, Pilot::of(&scenario), renderer.as_mut(), |_, _| ControlFlow::Continue(()))
                .map_err(|failure| failure.error)?;
            Ok(record.frames.iter().map(|frame| [frame.truth.distance_m, frame.truth.lateral_m]).collect())
        };
        let found = candidate::settings(&study.parameters, values);
        let base = &study.held_out.bases[case.at.base];
        Ok(Some(Trajectories { label: format!("{}, seed {}", base.name, case.seed), paths: [path(&[])?, path(&found)?] }))
    }
}

/// Spearman's rank correlation; `None` where one of the two does not vary.
pub fn rank_correlation(pairs: &[[f64; 2]]) -> Option<f64> {
    let ranks = |which: usize| {
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|a, b| pairs[*a][which].total_cmp(&pairs[*b][which]));
        let mut ranks = vec![0.0; pairs.len()];
        let mut from = 0;
        while from < order.len() {
            // Equal ones share their mean rank.
            let equal = order[from..].iter().take_while(|i| pairs[**i][which] == pairs[order[from]][which]).count();
            for index in &order[from..from + equal] {
                ranks[*index] = from as f64 + (equal - 1) as f64 / 2.0;
            }
            from += equal;
        }
        ranks
    };
    let (x, y) = (ranks(0), ranks(1));
    let middle = (pairs.len() as f64 - 1.0) / 2.0;
    let sum = |of: &dyn Fn(usize) -> f64| (0..pairs.len()).map(of).sum::<f64>();
    let covariance = sum(&|i| (x[i] - middle) * (y[i] - middle));
    let spread = (sum(&|i| (x[i] - middle) * (x[i] - middle)) * sum(&|i| (y[i] - middle) * (y[i] - middle))).sqrt();
    (spread > 0.0).then(|| covariance / spread)
}

/// What stands for the front: the best, and of several objectives the least of each; without the default.
pub fn representatives(search: &Search) -> Vec<usize> {
    let mut chosen: Vec<usize> = search.best.into_iter().collect();
    let objectives = search.trials.first().map_or(0, |trial| trial.costs.objectives.len());
    for objective in 0..objectives {
        let cost = |index: &usize| search.trials[*index].costs.objectives[objective];
        chosen.extend(search.front.iter().copied().min_by(|a, b| cost(a).total_cmp(&cost(b))));
    }
    let mut unique = Vec::new();
    for index in chosen.into_iter().filter(|index| search.trials[*index].values.is_some()) {
        if !unique.contains(&index) {
            unique.push(index);
        }
    }
    unique
}

/// Value of a parameter and cost by an objective, of all candidates that had all of their runs and kept the constraints.
pub fn against(search: &Search, parameter: usize, objective: usize) -> Vec<[f64; 2]> {
    let of = |trial: &Trial| Some([trial.values.as_ref()?[parameter].number()?, trial.costs.objectives[objective]]);
    search.trials.iter().filter(|trial| trial.is_full && trial.costs.is_feasible()).filter_map(of).collect()
}

/// Constraints that candidates broke, each with how many, the most first.
pub fn broken_by(study: &StudyFile, search: &Search) -> Vec<(String, usize)> {
    let default = search.trials.first().map_or(&[][..], |trial| &trial.rows);
    counted(search.trials.iter().map(|trial| {
        let each = trial.rows.iter().flat_map(|row| broken(&study.constraints, &row.outcome, counterpart(default, row)));
        each.chain(broken_in_the_mean(&study.constraints, &trial.rows, default)).collect()
    }))
    .into_iter()
    .map(|(name, count, _)| (name, count))
    .collect()
}

/// Constraints by how many broke them, the most first, and by what share of the bound at most.
fn counted(all: impl Iterator<Item = Vec<(String, f64)>>) -> Vec<(String, usize, f64)> {
    let mut counts: Vec<(String, usize, f64)> = Vec::new();
    for mut broken in all {
        broken.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        broken.dedup_by(|a, b| a.0 == b.0);
        for (name, excess) in broken {
            match counts.iter_mut().find(|(other, ..)| *other == name) {
                Some((_, count, most)) => (*count, *most) = (*count + 1, most.max(excess)),
                None => counts.push((name, 1, excess)),
            }
        }
    }
    counts.sort_by_key(|(_, count, _)| std::cmp::Reverse(*count));
    counts
}

impl Held {
    /// Constraints on runs that a candidate breaks on what was held out: how many runs do, and by what share of the bound at most.
    pub fn broken(&self, study: &StudyFile, rows: &[Row]) -> Vec<(String, usize, f64)> {
        counted(rows.iter().map(|row| broken(&study.constraints, &row.outcome, counterpart(&self.default, row))))
    }

    /// Whether something that was found is better than the default by more than noise: in one objective at least, and worse in none.
    pub fn is_better(&self) -> bool {
        self.found.iter().any(|found| {
            let each = || found.comparisons.iter().flatten();
            each().any(Comparison::is_better) && !each().any(Comparison::is_worse)
        })
    }
}

/// The study in a few sentences.
pub fn verdict_words(study: &StudyFile, search: &Search, held: Option<&Held>) -> Vec<String> {
    let mut words =
        vec![format!("{} candidates in {} runs; it ended because {}", search.trials.len(), search.runs, search.ended.words())];
    let Some(best) = search.best else {
        let most = broken_by(study, search);
        let told: Vec<String> = most.iter().map(|(name, count)| format!("{name} ({count} of {})", search.trials.len())).collect();
        words.push(format!("NO CANDIDATE keeps the constraints; broken were: {}", told.join(", ")));
        return words;
    };
    if search.front.len() > 1 {
        words.push(format!(
            "{} candidates are bettered by no other in every objective; the compromise is candidate {best}",
            search.front.len()
        ));
    }
    let Some(held) = held.filter(|held| !held.found.is_empty()) else {
        words.push("NO GAIN: no candidate is better than the default on the training ducts".to_owned());
        return words;
    };
    for found in &held.found {
        for (objective, comparison) in study.objectives.iter().zip(&found.comparisons) {
            let Some(comparison) = comparison else {
                words.push(format!(
                    "NO GAIN: no held-out run of candidate {} and the default measured {}",
                    found.trial, objective.name
                ));
                continue;
            };
            words.push(compared(study, found.trial, &objective.name, comparison));
        }
        let default = held.broken(study, &held.default);
        for (name, excess) in broken_in_the_mean(&study.constraints, &found.rows, &held.default) {
            words.push(format!("held out, candidate {} breaks \"{name}\" by {:.1} %", found.trial, 100.0 * excess));
        }
        for (name, count, most) in held.broken(study, &found.rows) {
            let own = default.iter().find(|(other, ..)| *other == name).map_or(0, |(_, count, _)| *count);
            words.push(format!(
                "held out, candidate {} breaks \"{name}\" in {count} of {} runs (the default in {own}), by {:.1} % of the bound at most",
                found.trial,
                found.rows.len(),
                100.0 * most
            ));
        }
    }
    let pairs = held.found.iter().flat_map(|found| found.comparisons.iter().flatten()).map(|comparison| comparison.pairs).min();
    if let Some(pairs) = pairs.filter(|pairs| *pairs < LEAST_PAIRS) {
        words.push(format!("{pairs} pairs cannot show a gain at 5 %: hold out {LEAST_PAIRS} runs or more"));
    }
    words
}

/// What a comparison says.
fn compared(study: &StudyFile, trial: usize, objective: &str, held: &Comparison) -> String {
    // Of a cost that can be below zero there are no shares.
    let relative = held.default_cost > 0.0;
    let told = |value: f64| if relative { format!("{:.1}", 100.0 * value / held.default_cost) } else { format!("{value:.4e}") };
    let unit = if relative { " %" } else { "" };
    let figures = format!(
        "{}{unit} ({} to {}{unit}, p = {:.4}, better in {} of {} pairs)",
        told(held.gain),
        told(held.interval[0]),
        told(held.interval[1]),
        held.p_value,
        held.better,
        held.pairs
    );
    let (who, of) = match study.objectives.len() {
        1 => ("the best".to_owned(), String::new()),
        _ => (format!("candidate {trial}"), format!(" in {objective}")),
    };
    if held.is_better() {
        format!("on the held-out ducts {who} costs less than the default{of} by {figures}")
    } else if held.is_worse() {
        format!("WORSE on the held-out ducts: {who} costs less than the default{of} by {figures}")
    } else {
        format!("NO GAIN on the held-out ducts beyond noise: {who} costs less than the default{of} by {figures}")
    }
}

/// `summary.json`.
pub fn summary(study: &StudyFile, search: &Search, held: Option<&Held>) -> Value {
    let by_objective = |of: &dyn Fn(usize) -> Value| -> Map<String, Value> {
        study.objectives.iter().enumerate().map(|(index, objective)| (objective.name.clone(), of(index))).collect()
    };
    let trial = |trial: &Trial| {
        let values: Map<String, Value> = study
            .parameters
            .iter()
            .zip(trial.values.iter().flatten())
            .map(|(parameter, value)| (parameter.path.clone(), json!(value.number())))
            .collect();
        json!({
            "trial": trial.number, "values": values, "costs": by_objective(&|index| json!(finite(trial.costs.objectives[index]))),
            "violation": trial.costs.violation, "metrics": means(study, &trial.rows),
        })
    };
    let sensitivity: Map<String, Value> = study
        .parameters
        .iter()
        .enumerate()
        .map(|(at, parameter)| {
            (parameter.path.clone(), json!(by_objective(&|index| json!(rank_correlation(&against(search, at, index))))))
        })
        .collect();
    let held_out = held.map(|held| {
        let told = |rows: &[Row]| -> Map<String, Value> {
            let broken = held.broken(study, rows);
            let mut told: Map<String, Value> =
                broken.into_iter().map(|(name, count, most)| (name, json!({"runs": count, "most_share": most}))).collect();
            for (name, excess) in broken_in_the_mean(&study.constraints, rows, &held.default) {
                told.insert(name, json!({"most_share": excess}));
            }
            told
        };
        let found: Vec<Value> = held
            .found
            .iter()
            .map(|found| {
                json!({
                    "trial": found.trial, "comparisons": by_objective(&|index| json!(found.comparisons[index])),
                    "by_scenario": by_objective(&|index| {
                        let means = held.by_scenario(study, &found.rows, &study.objectives[index]);
                        means.into_iter().map(|(name, [default, found])| (name, json!({"default": default, "found": found}))).collect::<Map<_, _>>().into()
                    }),
                    "metrics": means(study, &found.rows), "broken": told(&found.rows),
                })
            })
            .collect();
        json!({
            "is_better": held.is_better(), "default": {"metrics": means(study, &held.default), "broken": told(&held.default)},
            "found": found,
        })
    });
    json!({
        "format": 1, "study": study.name, "seed": study.seed, "optimiser": search.optimiser, "trials": search.trials.len(),
        "runs": search.runs, "ended": search.ended.words(), "default": search.trials.first().map(trial),
        "best": search.best.map(|best| trial(&search.trials[best])),
        "front": search.front.iter().map(|index| trial(&search.trials[*index])).collect::<Vec<_>>(),
        "sensitivity": sensitivity, "held_out": held_out,
        "broken": broken_by(study, search).into_iter().map(|(name, count)| (name, json!(count))).collect::<Map<String, Value>>(),
        "verdict": verdict_words(study, search, held),
    })
}

/// Means over runs of the metrics that the study names.
fn means(study: &StudyFile, rows: &[Row]) -> Map<String, Value> {
    metrics(study).into_iter().map(|metric| (metric.clone(), json!(mean(rows, &metric)))).collect()
}

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_correlated() {
        let of = |values: &[[f64; 2]]| rank_correlation(values);
        assert_eq!(of(&[[1.0, 10.0], [2.0, 100.0], [3.0, 1e6]]), Some(1.0));
        assert_eq!(of(&[[1.0, 3.0], [2.0, 2.0], [3.0, 1.0]]), Some(-1.0));
        assert_eq!(of(&[[1.0, 3.0], [2.0, 3.0]]), None);
        // Spearman 1904's formula with one tie: ranks 0, 1.5, 1.5, 3 against 0 to 3.
        let tied = of(&[[1.0, 0.0], [2.0, 1.0], [2.0, 2.0], [3.0, 3.0]]).expect("they vary");
        assert!((tied - 4.5 / (4.5_f64 * 5.0).sqrt()).abs() < 1e-12, "{tied}");
    }
}
