//! `trials.parquet`: a row a candidate.

use std::sync::Arc;

use arrow_array::{ArrayRef, BooleanArray, Float64Array, RecordBatch, UInt64Array};
use parquet::errors::ParquetError;

use super::search::{Search, Trial};
use crate::output::frames::to_parquet;
use crate::scenario::study_file::{Constraints, StudyFile};
use crate::sweep::table::Row;

/// Number, generation, whether it had all of its runs and is on the front, violation, runs; its cost by each objective (`cost`, or of several
/// `cost_NAME`); each parameter (null for the default, which has the scenarios' own); and of every metric that an objective or a constraint
/// names the mean over its runs, null where a run did not measure it.
///
/// # Errors
/// None that is known of: the file is made in memory.
pub fn parquet(study: &StudyFile, search: &Search) -> Result<Vec<u8>, ParquetError> {
    let trials = &search.trials;
    let number =
        |value: &dyn Fn(&Trial) -> Option<f64>| -> ArrayRef { Arc::new(trials.iter().map(value).collect::<Float64Array>()) };
    let count = |value: fn(&Trial) -> u64| -> ArrayRef { Arc::new(UInt64Array::from_iter_values(trials.iter().map(value))) };
    let on_front = |trial: &Trial| Some(search.front.contains(&(trial.number as usize)));
    let is_on_front: ArrayRef = Arc::new(trials.iter().map(on_front).collect::<BooleanArray>());
    let mut columns: Vec<(String, ArrayRef, bool)> = vec![
        ("trial".into(), count(|trial| trial.number), false),
        ("generation".into(), count(|trial| trial.generation), false),
        ("is_full".into(), Arc::new(trials.iter().map(|trial| Some(trial.is_full)).collect::<BooleanArray>()), false),
        ("is_on_front".into(), is_on_front, false),
        ("violation".into(), number(&|trial| Some(trial.costs.violation)), false),
        ("runs".into(), count(|trial| trial.rows.len() as u64), false),
    ];
    for (index, objective) in study.objectives.iter().enumerate() {
        let name = if study.objectives.len() == 1 { "cost".to_owned() } else { format!("cost_{}", objective.name) };
        columns.push((name, number(&|trial| Some(trial.costs.objectives[index]).filter(|cost| cost.is_finite())), true));
    }
    for (index, parameter) in study.parameters.iter().enumerate() {
        columns.push((parameter.path.clone(), number(&|trial| trial.values.as_ref()?[index].number()), true));
    }
    for metric in metrics(study) {
        columns.push((format!("mean_{metric}"), number(&|trial| mean(&trial.rows, &metric)), true));
    }
    let columns = columns.iter().map(|(name, column, nullable)| (name.as_str(), Arc::clone(column), *nullable));
    to_parquet(&RecordBatch::try_from_iter_with_nullable(columns)?)
}

/// Metrics that the study names, each once.
pub fn metrics(study: &StudyFile) -> Vec<String> {
    let Constraints { most, least, of_default, mean_of_default, .. } = &study.constraints;
    let weights = study.objectives.iter().flat_map(|objective| &objective.weights);
    let named = weights.chain(most).chain(least).chain(of_default).chain(mean_of_default);
    let mut metrics: Vec<String> = Vec::new();
    for (metric, _) in named {
        if !metrics.contains(metric) {
            metrics.push(metric.clone());
        }
    }
    metrics
}

/// Mean of a metric over runs; `None` where one did not measure it.
pub fn mean(rows: &[Row], metric: &str) -> Option<f64> {
    let sum: Option<f64> = rows.iter().map(|row| row.outcome.metric(metric)).sum();
    Some(sum? / rows.len() as f64).filter(|mean| mean.is_finite())
}
