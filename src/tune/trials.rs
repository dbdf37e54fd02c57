//! `trials.parquet`: a row a candidate.

use std::sync::Arc;

use arrow_array::{ArrayRef, BooleanArray, Float64Array, RecordBatch, UInt64Array};
use parquet::errors::ParquetError;

use super::search::Trial;
use crate::output::frames::to_parquet;
use crate::scenario::study_file::{Constraints, StudyFile};

/// Number, generation, whether it had all of its runs, cost, violation, runs; each parameter (null for the default, which has the scenarios'
/// own); and of every metric that the objective or a constraint names the mean over its runs, null where a run did not measure it.
///
/// # Errors
/// None that is known of: the file is made in memory.
pub fn parquet(study: &StudyFile, trials: &[Trial]) -> Result<Vec<u8>, ParquetError> {
    let number =
        |value: &dyn Fn(&Trial) -> Option<f64>| -> ArrayRef { Arc::new(trials.iter().map(value).collect::<Float64Array>()) };
    let count = |value: fn(&Trial) -> u64| -> ArrayRef { Arc::new(UInt64Array::from_iter_values(trials.iter().map(value))) };
    let mut columns: Vec<(String, ArrayRef, bool)> = vec![
        ("trial".into(), count(|trial| trial.number), false),
        ("generation".into(), count(|trial| trial.generation), false),
        ("is_full".into(), Arc::new(trials.iter().map(|trial| Some(trial.is_full)).collect::<BooleanArray>()), false),
        ("cost".into(), number(&|trial| Some(trial.score.cost).filter(|cost| cost.is_finite())), true),
        ("violation".into(), number(&|trial| Some(trial.score.violation)), false),
        ("runs".into(), count(|trial| trial.rows.len() as u64), false),
    ];
    for (index, parameter) in study.parameters.iter().enumerate() {
        columns.push((parameter.path.clone(), number(&|trial| trial.values.as_ref()?[index].number()), true));
    }
    for metric in metrics(study) {
        columns.push((format!("mean_{metric}"), number(&|trial| mean(trial, &metric)), true));
    }
    let columns = columns.iter().map(|(name, column, nullable)| (name.as_str(), Arc::clone(column), *nullable));
    to_parquet(&RecordBatch::try_from_iter_with_nullable(columns)?)
}

/// Metrics that the study names, each once.
pub fn metrics(study: &StudyFile) -> Vec<String> {
    let Constraints { most, least, of_default, .. } = &study.constraints;
    let named = study.objective.weights.iter().chain(most).chain(least).chain(of_default);
    let mut metrics: Vec<String> = Vec::new();
    for (metric, _) in named {
        if !metrics.contains(metric) {
            metrics.push(metric.clone());
        }
    }
    metrics
}

/// Mean of a metric over a trial's runs; `None` where one did not measure it.
pub fn mean(trial: &Trial, metric: &str) -> Option<f64> {
    let sum: Option<f64> = trial.rows.iter().map(|row| row.outcome.metric(metric)).sum();
    Some(sum? / trial.rows.len() as f64).filter(|mean| mean.is_finite())
}
