//! What a study comes to: the find against the default on what was held out, as figures, words and paths.

use std::ops::ControlFlow;

use serde_json::{Value, json};

use super::comparison::Comparison;
use super::objective::{broken, cost, counterpart};
use super::search::{Search, Trial};
use super::trials::{mean, metrics};
use crate::closed_loop::{RunError, run_unscored};
use crate::engine::Engine;
use crate::pilot::Pilot;
use crate::scenario::study_file::StudyFile;
use crate::sweep::table::Row;

/// Pairs of which all signs are the same by chance in less than one of twenty cases: 2 / 2^6.
const LEAST_PAIRS: usize = 6;

/// Runs of the default and of the find on the same ducts with the same seeds.
#[derive(Clone, Debug)]
pub struct Held {
    /// Pairs of costs, default and find, of runs that both measured.
    pub pairs: Vec<[f64; 2]>,
    /// Both runs of each pair.
    pub rows: Vec<[Row; 2]>,
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

impl Held {
    /// Of the rows of both, in the same order.
    pub fn of(study: &StudyFile, default: Vec<Row>, best: Vec<Row>) -> Self {
        let rows: Vec<[Row; 2]> = default.into_iter().zip(best).map(|(default, best)| [default, best]).collect();
        let cost = |row: &Row| cost(&study.objective, &row.outcome);
        let pairs = rows.iter().filter_map(|[default, best]| Some([cost(default)?, cost(best)?])).collect();
        Self { pairs, rows }
    }

    /// Runs the first pair once more, frame by frame.
    ///
    /// # Errors
    /// Where one of the two cannot be run any more.
    pub fn trajectories(&self, study: &StudyFile, search: &Search, engine: &Engine) -> Result<Trajectories, TrajectoryError> {
        let Some(pair) = self.rows.first() else { return Ok(Trajectories { label: String::new(), paths: Default::default() }) };
        let values = search.best.and_then(|best| search.trials[best].values.as_ref());
        let found = values.map(|values| super::candidate::settings(&study.parameters, values)).unwrap_or_default();
        let path = |settings: &[String]| -> Result<Vec<[f64; 2]>, TrajectoryError> {
            let case = &pair[0].case;
            let scenario = study.held_out.scenario(case.at.base, settings, case.seed)?;
            let mut renderer = engine.renderer(&scenario, 1)?;
            let record = run_unscored(&scenario, Pilot::of(&scenario), renderer.as_mut(), |_, _| ControlFlow::Continue(()))
                .map_err(|failure| failure.error)?;
            Ok(record.frames.iter().map(|frame| [frame.truth.distance_m, frame.truth.lateral_m]).collect())
        };
        let base = &study.held_out.bases[pair[0].case.at.base];
        Ok(Trajectories { label: format!("{}, seed {}", base.name, pair[0].case.seed), paths: [path(&[])?, path(&found)?] })
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

/// Value of a parameter and cost, of all candidates that had all of their runs and kept the constraints.
pub fn against(search: &Search, parameter: usize) -> Vec<[f64; 2]> {
    let of = |trial: &Trial| Some([trial.values.as_ref()?[parameter].number()?, trial.score.cost]);
    search.trials.iter().filter(|trial| trial.is_full && trial.score.is_feasible()).filter_map(of).collect()
}

/// Constraints that candidates broke, each with how many, the most first.
pub fn broken_by(study: &StudyFile, search: &Search) -> Vec<(String, usize)> {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for trial in &search.trials {
        let default = search.trials.first().map_or(&[][..], |trial| &trial.rows);
        let of = |row: &Row| broken(&study.constraints, &row.outcome, counterpart(default, row));
        let mut names: Vec<String> = trial.rows.iter().flat_map(of).map(|(name, _)| name).collect();
        names.sort();
        names.dedup();
        for name in names {
            match counts.iter_mut().find(|(other, _)| *other == name) {
                Some((_, count)) => *count += 1,
                None => counts.push((name, 1)),
            }
        }
    }
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts
}

/// The study in a few sentences.
pub fn verdict_words(study: &StudyFile, search: &Search, held: Option<&Comparison>) -> Vec<String> {
    let mut words =
        vec![format!("{} candidates in {} runs; it ended because {}", search.trials.len(), search.runs, search.ended.words())];
    let Some(best) = search.best else {
        let most = broken_by(study, search);
        let told: Vec<String> = most.iter().map(|(name, count)| format!("{name} ({count} of {})", search.trials.len())).collect();
        words.push(format!("NO CANDIDATE keeps the constraints; broken were: {}", told.join(", ")));
        return words;
    };
    if search.trials[best].values.is_none() {
        words.push("NO GAIN: no candidate is better than the default on the training ducts".to_owned());
        return words;
    }
    if let Some(held) = held {
        let share = |value: f64| 100.0 * value / held.default_cost;
        let figures = format!(
            "{:.1} % ({:.1} to {:.1} %, p = {:.4}, better in {} of {} pairs)",
            share(held.gain),
            share(held.interval[0]),
            share(held.interval[1]),
            held.p_value,
            held.better,
            held.pairs
        );
        words.push(match held.is_better() {
            true => format!("on the held-out ducts the best costs less than the default by {figures}"),
            false => format!("NO GAIN on the held-out ducts beyond noise: the best costs less than the default by {figures}"),
        });
        if held.pairs < LEAST_PAIRS {
            words.push(format!("{} pairs cannot show a gain at 5 %: hold out {LEAST_PAIRS} runs or more", held.pairs));
        }
    }
    words
}

/// `summary.json`.
pub fn summary(study: &StudyFile, search: &Search, held: Option<&Held>, comparison: Option<&Comparison>) -> Value {
    let trial = |trial: &Trial| {
        let values: serde_json::Map<String, Value> = study
            .parameters
            .iter()
            .zip(trial.values.iter().flatten())
            .map(|(parameter, value)| (parameter.path.clone(), json!(value.number())))
            .collect();
        let metrics: serde_json::Map<String, Value> =
            metrics(study).into_iter().map(|metric| (metric.clone(), json!(mean(trial, &metric)))).collect();
        json!({
            "trial": trial.number, "values": values, "cost": finite(trial.score.cost), "violation": trial.score.violation,
            "metrics": metrics,
        })
    };
    let sensitivity: serde_json::Map<String, Value> = (0..study.parameters.len())
        .map(|index| (study.parameters[index].path.clone(), json!(rank_correlation(&against(search, index)))))
        .collect();
    let held_out = held.map(|held| {
        let violations = |which: usize| {
            let of = |pair: &[Row; 2]| broken(&study.constraints, &pair[which].outcome, Some(&pair[0].outcome));
            held.rows.iter().flat_map(of).map(|(_, excess)| excess).fold(0.0, std::ops::Add::add)
        };
        json!({
            "comparison": comparison, "is_better": comparison.is_some_and(Comparison::is_better),
            "violation": {"default": violations(0), "best": violations(1)},
        })
    });
    json!({
        "format": 1, "study": study.name, "seed": study.seed, "optimiser": study.optimiser.word(), "trials": search.trials.len(),
        "runs": search.runs, "ended": search.ended.words(), "default": search.trials.first().map(trial),
        "best": search.best.map(|best| trial(&search.trials[best])), "sensitivity": sensitivity, "held_out": held_out,
        "broken": broken_by(study, search).into_iter().map(|(name, count)| (name, json!(count))).collect::<serde_json::Map<String, Value>>(),
        "verdict": verdict_words(study, search, comparison),
    })
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
