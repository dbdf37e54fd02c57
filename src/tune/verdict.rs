//! What a study comes to, in a few sentences.

use super::comparison::Comparison;
use super::held_out::Held;
use super::objective::{broken, broken_in_the_mean, counterpart};
use super::search::Search;
use crate::scenario::study_file::StudyFile;
use crate::sweep::table::Row;

/// Pairs of which all signs are the same by chance in less than one of twenty cases: 2 / 2^6.
const LEAST_PAIRS: usize = 6;

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
