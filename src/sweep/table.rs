//! The table of a sweep: a row a case, in the order of the cases, and `results.parquet`.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use arrow_array::{ArrayRef, BooleanArray, Float64Array, RecordBatch, StringArray, UInt32Array, UInt64Array};
use parquet::errors::ParquetError;

use super::case::{Case, CaseHash};
use super::ledger::{self, Damaged};
use super::outcome::Outcome;
use super::pass_rate::enough;
use super::plan::Plan;
use super::store::{Store, StoreError};
use crate::metrics::Verdict;
use crate::output::frames::{table_writer, to_parquet};
use crate::scenario::sweep_file::SweepFile;

/// A case with what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The case.
    pub case: Case,
    /// Its outcome.
    pub outcome: Outcome,
}

/// All that is known of a sweep.
#[derive(Debug)]
pub struct Table {
    /// Rows in the order of their cases.
    pub rows: Vec<Row>,
    /// Cases that are not done and have to be.
    pub missing: u64,
    /// Cases that need not be done: their point has been repeated enough.
    pub spared: u64,
    /// Parts that cannot be read.
    pub damaged: Vec<Damaged>,
}

impl Table {
    /// Reads a plan's results. Of a case that was done twice one result counts: they are the same, unless one machine was too slow for it;
    /// then the other's counts. Points that are equal, as drawn ones may be, share their results, each with rows of its own.
    ///
    /// # Errors
    /// Where the store cannot be read.
    pub fn read(plan: &Plan, store: &Store) -> Result<Self, StoreError> {
        let mut outcomes: BTreeMap<CaseHash, Outcome> = BTreeMap::new();
        let damaged = ledger::read(store, |outcome, _| match outcomes.entry(outcome.hash) {
            Entry::Occupied(mut there) if there.get().verdict == Verdict::Timeout => {
                there.insert(outcome);
            }
            Entry::Occupied(_) => {}
            Entry::Vacant(place) => {
                place.insert(outcome);
            }
        })?;
        let cases = plan.cases();
        let mut table = Self { rows: Vec::new(), missing: 0, spared: 0, damaged };
        for point in 0..cases.points() {
            let all = (0..cases.replicates()).map(|replicate| cases.replicate(point, replicate));
            // In the order of the replicates up to the first that is not there: that is what the rule sees.
            let known = |case: &Case| outcomes.get(&case.hash).map(Outcome::passed);
            let counted = plan.sweep.stop.and_then(|rule| enough(&rule, all.clone().map_while(|case| known(&case))));
            for case in all {
                if counted.is_some_and(|count| case.replicate >= count) {
                    table.spared += 1;
                } else if let Some(outcome) = outcomes.get(&case.hash).cloned() {
                    table.rows.push(Row { case, outcome });
                } else {
                    table.missing += 1;
                }
            }
        }
        Ok(table)
    }

    /// `results.parquet`: number, point, replicate, seed and hash of the case; base and factors, those that are numbers as such; verdict,
    /// `reasons` (metrics whose bounds did not hold), `end_state`, `completed`; the sweep's metrics in SI; `run_hash`, `error`; then
    /// what depends on the machine, `wall_time_s`, `real_time_factor` and `host`.
    ///
    /// # Errors
    /// None that is known of: the file is made in memory.
    pub fn parquet(&self, sweep: &SweepFile) -> Result<Vec<u8>, ParquetError> {
        let rows = &self.rows;
        let text =
            |value: &dyn Fn(&Row) -> Option<String>| -> ArrayRef { Arc::new(rows.iter().map(value).collect::<StringArray>()) };
        let number =
            |value: &dyn Fn(&Row) -> Option<f64>| -> ArrayRef { Arc::new(rows.iter().map(value).collect::<Float64Array>()) };
        let mut columns = case_columns(sweep, &rows.iter().map(|row| &row.case).collect::<Vec<_>>());
        let completed = rows.iter().map(|row| row.outcome.end_state.as_ref().map(|state| state == "finished"));
        columns.extend([
            ("verdict", text(&|row| Some(row.outcome.verdict.word().to_owned())), false),
            ("reasons", text(&|row| Some(row.outcome.reasons.clone())), false),
            ("end_state", text(&|row| row.outcome.end_state.clone()), true),
            ("completed", Arc::new(completed.collect::<BooleanArray>()) as ArrayRef, true),
        ]);
        for metric in &sweep.metrics {
            columns.push((metric, number(&|row| row.outcome.metric(metric)), true));
        }
        columns.extend([
            ("run_hash", text(&|row| row.outcome.run_hash.clone()), true),
            ("error", text(&|row| row.outcome.error.clone()), true),
            ("wall_time_s", number(&|row| Some(row.outcome.wall_time_s)), false),
            ("real_time_factor", number(&|row| row.outcome.real_time_factor()), true),
            ("host", text(&|row| Some(row.outcome.host.clone())), false),
        ]);
        to_parquet(&RecordBatch::try_from_iter_with_nullable(columns)?)
    }
}

/// Cases whose list is made at a time.
const CASES_AT_A_TIME: u64 = 16_384;

/// `cases.parquet`, the list of a plan: the columns of `results.parquet` up to the factors.
///
/// # Errors
/// None that is known of: the file is made in memory.
pub fn list(plan: &Plan) -> Result<Vec<u8>, ParquetError> {
    let cases = plan.cases();
    let batch = |from: u64| {
        let some: Vec<Case> = (from..(from + CASES_AT_A_TIME).min(cases.count())).map(|index| cases.case(index)).collect();
        RecordBatch::try_from_iter_with_nullable(case_columns(&plan.sweep, &some.iter().collect::<Vec<_>>()))
    };
    let mut from = 0;
    let mut writer = table_writer(batch(0)?.schema())?;
    while from < cases.count() {
        writer.write(&batch(from)?)?;
        from += CASES_AT_A_TIME;
    }
    writer.into_inner()
}

/// What is known of cases before they are run.
fn case_columns<'s>(sweep: &'s SweepFile, cases: &[&Case]) -> Vec<(&'s str, ArrayRef, bool)> {
    let text = |value: &dyn Fn(&Case) -> Option<String>| -> ArrayRef {
        Arc::new(cases.iter().map(|case| value(case)).collect::<StringArray>())
    };
    let count =
        |value: fn(&Case) -> u64| -> ArrayRef { Arc::new(UInt64Array::from_iter_values(cases.iter().map(|case| value(case)))) };
    let mut columns: Vec<(&str, ArrayRef, bool)> = vec![
        ("case", count(|case| case.index), false),
        ("point", count(|case| case.point), false),
        ("replicate", Arc::new(UInt32Array::from_iter_values(cases.iter().map(|case| case.replicate))), false),
        ("seed", count(|case| case.seed), false),
        ("hash", text(&|case| Some(format!("{:032x}", case.hash))), false),
        ("base", text(&|case| Some(sweep.bases[case.at.base].name.clone())), false),
    ];
    for (index, factor) in sweep.factors.iter().enumerate() {
        let column: ArrayRef = if factor.is_numeric() {
            Arc::new(cases.iter().map(|case| case.at.values[index].as_ref()?.number()).collect::<Float64Array>())
        } else {
            text(&|case| Some(case.at.values[index].as_ref()?.shown()))
        };
        columns.push((&factor.path, column, true));
    }
    columns
}
