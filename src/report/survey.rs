//! The report's section on what lies on the floor.

use minijinja::{Value, context};

use crate::output::words::number;
use crate::record::RunRecord;
use crate::scenario::Scenario;
use crate::survey::Survey;

/// The section; nothing where no deposit was found and none was missed.
pub(super) fn section(scenario: &Scenario, run: &RunRecord) -> Value {
    let Some(survey) = Survey::of(scenario, run) else { return Value::from(()) };
    let missed = survey.deposits_missed.unwrap_or(0);
    if missed == 0 && survey.ducts.iter().all(|duct| duct.deposits.is_empty()) {
        return Value::from(());
    }
    let mm = |value_m: f64| format!("{} mm", number(value_m * 1e3, 2));
    let rows: Vec<Value> = survey
        .ducts
        .iter()
        .enumerate()
        .flat_map(|(number, duct)| duct.deposits.iter().map(move |deposit| (number, deposit)))
        .map(|(duct, deposit)| {
            context! {
                duct => duct + 1,
                along => format!("{} to {} m", number(deposit.from_m, 3), number(deposit.to_m, 3)),
                left => format!("{} to {} m", number(deposit.right_edge_m, 3), number(deposit.left_edge_m, 3)),
                mean => format!("{} ± {}", mm(deposit.mean_m), mm(deposit.mean_sigma_m)),
                largest => mm(deposit.largest_m),
                truth => deposit.true_m.map_or_else(|| "nothing".to_owned(), mm),
                error => deposit.error_m.map(mm),
                is_none => deposit.true_m.is_none(),
            }
        })
        .collect();
    context! { rows => rows, missed => missed, resolved => mm(survey.deposits_resolved_m) }
}
