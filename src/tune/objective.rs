//! What a candidate's runs come to: a cost, and by how much they break the constraints.

use super::front::Costs;
use crate::metrics::Verdict;
use crate::scenario::study_file::{Constraints, Objective, Over, StudyFile};
use crate::sweep::outcome::Outcome;
use crate::sweep::table::Row;

/// Most that a bound counts for, in violations, however far it is missed.
const MOST_EXCESS: f64 = 10.0;
/// What a run that could not go on counts for: more than one that misses bounds.
const NO_RUN: f64 = 100.0;
/// What a figure that was not measured counts for.
const NO_FIGURE: f64 = MOST_EXCESS;

/// One number to order candidates of one objective by: those that keep the constraints by their cost, behind all of them the others by how much
/// they break them (Deb, Computer Methods in Applied Mechanics and Engineering 186, 2000).
pub fn rank(costs: &Costs) -> f64 {
    /// More than any cost of a run.
    const BROKEN: f64 = 1e300;
    if costs.is_feasible() { costs.objectives[0] } else { BROKEN * (1.0 + costs.violation / (1.0 + costs.violation)) }
}

/// The weighted sum of a run's metrics, as a share of the default's own run where it is `relative`; `None` if one was not measured, or the
/// default's is not above zero.
pub fn cost(objective: &Objective, outcome: &Outcome, default: Option<&Outcome>) -> Option<f64> {
    let sum = |outcome: &Outcome| -> Option<f64> {
        objective.weights.iter().map(|(metric, weight)| Some(weight * outcome.metric(metric)?)).sum()
    };
    if !objective.relative {
        return sum(outcome);
    }
    let own = sum(default?).filter(|own| *own > 0.0)?;
    Some(sum(outcome)? / own)
}

/// The default's run on the same duct with the same seed.
pub fn counterpart<'a>(default: &'a [Row], row: &Row) -> Option<&'a Outcome> {
    let is_same = |other: &&Row| other.case.at.base == row.case.at.base && other.case.seed == row.case.seed;
    default.iter().find(is_same).map(|row| &row.outcome)
}

/// Which constraints a run breaks, each with the excess as a share of its bound; `default` is the default's run on the same duct with the same
/// seed.
pub fn broken(constraints: &Constraints, outcome: &Outcome, default: Option<&Outcome>) -> Vec<(String, f64)> {
    let mut broken = Vec::new();
    if matches!(outcome.verdict, Verdict::Error | Verdict::Timeout) {
        broken.push(("a run that could not go on".to_owned(), NO_RUN));
    }
    if constraints.finishes && outcome.end_state.as_deref() != Some("finished") {
        broken.push(("finishes".to_owned(), 1.0));
    }
    for (metric, most) in &constraints.most {
        match outcome.metric(metric) {
            Some(value) if value <= *most => {}
            Some(value) => broken.push((format!("most {metric}"), share(value - most, *most))),
            None => broken.push((format!("most {metric}"), NO_FIGURE)),
        }
    }
    for (metric, times) in &constraints.of_default {
        // Where the default has no figure there is nothing to hold against.
        let Some(most) = default.and_then(|default| default.metric(metric)).map(|value| times * value) else { continue };
        match outcome.metric(metric) {
            Some(value) if value <= most => {}
            Some(value) => broken.push((format!("{times} times the default's {metric}"), share(value - most, most))),
            None => broken.push((format!("{times} times the default's {metric}"), NO_FIGURE)),
        }
    }
    for (metric, least) in &constraints.least {
        match outcome.metric(metric) {
            Some(value) if value >= *least => {}
            Some(value) => broken.push((format!("least {metric}"), share(least - value, *least))),
            None => broken.push((format!("least {metric}"), NO_FIGURE)),
        }
    }
    broken
}

/// Which constraints on means runs break together, each with the excess as a share of its bound; of the default's runs those on the same ducts
/// with the same seeds count.
pub fn broken_in_the_mean(constraints: &Constraints, rows: &[Row], default: &[Row]) -> Vec<(String, f64)> {
    let mut broken = Vec::new();
    for (metric, times) in &constraints.mean_of_default {
        let name = format!("{times} times the default's mean {metric}");
        let own = rows.iter().map(|row| counterpart(default, row)?.metric(metric)).sum::<Option<f64>>();
        // Where the default has no figure there is nothing to hold against.
        let Some(most) = own.map(|own| times * own) else { continue };
        match rows.iter().map(|row| row.outcome.metric(metric)).sum::<Option<f64>>() {
            Some(sum) if sum <= most => {}
            Some(sum) => broken.push((name, share(sum - most, most))),
            None => broken.push((name, NO_FIGURE)),
        }
    }
    broken
}

/// Which objectives have no figure in how many runs: what was not measured is not for nothing.
pub fn unmeasured(study: &StudyFile, rows: &[Row], default: &[Row]) -> Vec<(String, f64)> {
    let of = |objective: &Objective| {
        let without = rows.iter().filter(|row| cost(objective, &row.outcome, counterpart(default, row)).is_none()).count();
        let of_default = if objective.relative { ", or the default's" } else { "" };
        (without > 0).then(|| (format!("a figure for {}{of_default}", objective.name), NO_FIGURE * without as f64))
    };
    study.objectives.iter().filter_map(of).collect()
}

/// An excess as a share of its bound, where that is zero of a thousandth.
fn share(excess: f64, bound: f64) -> f64 {
    (excess / bound.abs().max(1e-3)).min(MOST_EXCESS)
}

/// The costs of several runs as one.
pub fn over(rule: Over, costs: &[f64]) -> f64 {
    let mut sorted = costs.to_vec();
    sorted.sort_by(f64::total_cmp);
    match (rule, sorted.len()) {
        (_, 0) => f64::INFINITY,
        (Over::Mean, count) => sorted.iter().sum::<f64>() / count as f64,
        (Over::Worst, count) => sorted[count - 1],
        // Between the two values that it falls between (Hyndman and Fan's definition 7).
        (Over::Quantile(share), count) => {
            let place = share * (count - 1) as f64;
            let below = place.floor() as usize;
            let above = (below + 1).min(count - 1);
            sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
        }
    }
}

/// What these runs of a candidate come to, `default` being the default's runs.
pub fn costs(study: &StudyFile, rows: &[Row], default: &[Row]) -> Costs {
    let mut violation = 0.0;
    let objectives = study.objectives.iter().map(|objective| {
        let measured: Vec<f64> = rows.iter().filter_map(|row| cost(objective, &row.outcome, counterpart(default, row))).collect();
        over(objective.over, &measured)
    });
    let objectives = objectives.collect();
    for row in rows {
        let broken = broken(&study.constraints, &row.outcome, counterpart(default, row));
        violation += broken.iter().map(|(_, excess)| excess).sum::<f64>();
    }
    violation += unmeasured(study, rows, default).iter().map(|(_, excess)| excess).sum::<f64>();
    violation += broken_in_the_mean(&study.constraints, rows, default).iter().map(|(_, excess)| excess).sum::<f64>();
    Costs { objectives, violation }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_put_together_as_the_study_says() {
        let costs = [4.0, 1.0, 2.0, 3.0];
        for (rule, value) in [
            (Over::Mean, 2.5),
            (Over::Worst, 4.0),
            (Over::Quantile(0.5), 2.5),
            (Over::Quantile(1.0), 4.0),
            (Over::Quantile(0.0), 1.0),
        ] {
            assert_eq!(over(rule, &costs), value, "{rule:?}");
        }
        assert_eq!(over(Over::Mean, &[]), f64::INFINITY);
    }

    #[test]
    fn who_breaks_a_constraint_is_behind_all_who_do_not() {
        assert!(share(1.0, 0.0) < NO_RUN, "a touch is less than no run at all");
        let [good, dear, off] =
            [(0.1, 0.0), (1e6, 0.0), (0.0, 0.1)].map(|(cost, violation)| Costs { objectives: vec![cost], violation });
        assert!(rank(&good) < rank(&dear) && rank(&dear) < rank(&off));
        assert!(rank(&off) < rank(&Costs { objectives: vec![0.0], violation: 0.2 }));
    }
}
