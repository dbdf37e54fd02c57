//! What a study comes to, in a few sentences.

use super::comparison::Comparison;
use super::held_out::{Held, HeldTrial};
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

/// What a find is worth on what was held out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Something is better than the default by more than noise in one objective, worse in none, and keeps the constraints.
    Gain,
    /// Something is better in one objective and worse in another.
    TradeOff,
    /// Something is better, but breaks constraints more than the default does.
    Broken,
    /// Nothing is better by more than noise.
    NoGain,
}

impl Outcome {
    /// A word or two for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Gain => "gain",
            Self::TradeOff => "trade-off",
            Self::Broken => "constraints broken",
            Self::NoGain => "no gain",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Gain => "A GAIN on the held-out ducts",
            Self::TradeOff => "A TRADE-OFF on the held-out ducts: what is better in one objective is worse in another",
            Self::Broken => "NO GAIN: what is better on the held-out ducts breaks constraints there",
            Self::NoGain => "NO GAIN on the held-out ducts beyond noise",
        }
    }
}

impl Held {
    /// What the best of what was found is worth.
    pub fn outcome(&self, study: &StudyFile) -> Outcome {
        let breaks = |rows: &[Row]| -> usize {
            let each: usize = self.broken(study, rows).iter().map(|(_, count, _)| count).sum();
            each + broken_in_the_mean(&study.constraints, rows, &self.default).len()
        };
        let own = breaks(&self.default);
        let any = |is: &dyn Fn(&Comparison) -> bool, found: &HeldTrial| found.comparisons.iter().flatten().any(is);
        let better: Vec<&HeldTrial> = self.found.iter().filter(|found| any(&Comparison::is_better, found)).collect();
        let (worse, whole): (Vec<&HeldTrial>, _) = better.into_iter().partition(|found| any(&Comparison::is_worse, found));
        if whole.iter().any(|found| breaks(&found.rows) <= own) {
            Outcome::Gain
        } else if !worse.is_empty() {
            Outcome::TradeOff
        } else if !whole.is_empty() {
            Outcome::Broken
        } else {
            Outcome::NoGain
        }
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
    words.push(held.outcome(study).words().to_owned());
    for found in &held.found {
        let told = study.objectives.iter().zip(&found.comparisons).map(|(objective, comparison)| match comparison {
            Some(comparison) => compared(&objective.name, comparison),
            None => format!("{}: not measured", objective.name),
        });
        words.push(format!("held out, candidate {} against the default: {}", found.trial, told.collect::<Vec<_>>().join("; ")));
        for (name, excess) in broken_in_the_mean(&study.constraints, &found.rows, &held.default) {
            words.push(format!("held out, candidate {} breaks \"{name}\" by {:.1} %", found.trial, 100.0 * excess));
        }
        let default = held.broken(study, &held.default);
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

/// What a comparison says: how much less or more the find costs, and how sure that is.
fn compared(objective: &str, held: &Comparison) -> String {
    let (sign, word) = if held.gain >= 0.0 { (1.0, "less") } else { (-1.0, "more") };
    // Of a cost that can be below zero there are no shares.
    let relative = held.default_cost > 0.0;
    let told = |value: f64| match relative {
        true => format!("{:.1}", 100.0 * sign * value / held.default_cost),
        false => format!("{:.4e}", sign * value),
    };
    let mut interval = held.interval.map(|end| sign * end);
    interval.sort_by(f64::total_cmp);
    let unit = if relative { " %" } else { "" };
    let noise = if held.is_better() || held.is_worse() { "" } else { ", no more than noise" };
    format!(
        "{objective} {}{unit} {word} ({} to {}{unit}, p = {:.4}, better in {} of {} pairs{noise})",
        told(held.gain),
        told(sign * interval[0]),
        told(sign * interval[1]),
        held.p_value,
        held.better,
        held.pairs
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(pairs: &[[f64; 2]]) -> String {
        compared("cost", &Comparison::of(pairs, 1).expect("pairs"))
    }

    #[test]
    fn a_comparison_says_which_way_it_goes_and_how_sure_it_is() {
        let pairs = |default: f64, found: f64| -> Vec<[f64; 2]> { (0..8).map(|i| [default + 0.01 * f64::from(i), found]).collect() };
        assert_eq!(told(&pairs(2.0, 1.0)), "cost 50.9 % less (50.0 to 51.7 %, p = 0.0078, better in 8 of 8 pairs)");
        assert!(told(&pairs(1.0, 2.0)).starts_with("cost 93.2 % more (91."), "{}", told(&pairs(1.0, 2.0)));
        let even = [[1.0, 1.1], [1.1, 1.0], [1.0, 1.2], [1.2, 1.0]];
        assert!(told(&even).contains("0.0 % less") && told(&even).contains("no more than noise"), "{}", told(&even));
        // A cost below zero has no shares.
        assert!(told(&[[-3.0, -4.0]; 6]).starts_with("cost 1.0000e0 less"), "{}", told(&[[-3.0, -4.0]; 6]));
    }
}
