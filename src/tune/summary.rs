//! `summary.json`.

use serde_json::{Map, Value, json};

use super::held_out::Held;
use super::objective::broken_in_the_mean;
use super::search::{Search, Trial};
use super::sensitivity::{against, rank_correlation};
use super::trials::{mean, metrics};
use super::verdict::{broken_by, verdict_words};
use crate::scenario::study_file::StudyFile;
use crate::sweep::table::Row;

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
            "outcome": held.outcome(study).word(), "default": {"metrics": means(study, &held.default), "broken": told(&held.default)},
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
