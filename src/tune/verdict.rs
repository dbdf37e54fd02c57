//! What a study comes to, in a few sentences.

use super::comparison::Comparison;
use super::held_out::Held;
use super::objective::{broken, broken_in_the_mean, counterpart, unmeasured};
use super::search::Search;
use crate::scenario::study_file::StudyFile;
use crate::sweep::table::Row;

/// How probable chance may be at most where a gain is told, of all objectives together.
const LEVEL: f64 = 0.05;

/// Constraints that candidates broke, each with how many, the most first.
pub fn broken_by(study: &StudyFile, search: &Search) -> Vec<(String, usize)> {
    let default = search.trials.first().map_or(&[][..], |trial| &trial.rows);
    counted(search.trials.iter().map(|trial| {
        let each = trial.rows.iter().flat_map(|row| broken(&study.constraints, &row.outcome, counterpart(default, row)));
        let means = broken_in_the_mean(&study.constraints, &trial.rows, default);
        each.chain(unmeasured(study, &trial.rows, default)).chain(means).collect()
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
    /// The best is better than the default by more than noise in one objective and worse in none, breaks constraints in no more runs, and
    /// measures all that the default does.
    Gain,
    /// It is better in one objective and worse in another.
    TradeOff,
    /// It is better, but breaks constraints, or loses figures, more than the default does.
    Broken,
    /// It is not better by more than noise.
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
        let Some(best) = self.found.first() else { return Outcome::NoGain };
        // Of several objectives each has its share of the level (Bonferroni); the front's ends are told of and decide nothing.
        let level = level(study);
        let any = |is: &dyn Fn(&Comparison) -> bool| best.comparisons.iter().flatten().any(is);
        let [lost, _] = self.unpaired(study, &best.rows);
        if !any(&|held| held.is_better(level)) {
            Outcome::NoGain
        } else if lost > 0 || self.breaks(study, &best.rows) > self.breaks(study, &self.default) {
            Outcome::Broken
        } else if any(&|held| held.is_worse(level)) {
            Outcome::TradeOff
        } else {
            Outcome::Gain
        }
    }

    /// How often constraints are broken, each in each run and in the mean.
    fn breaks(&self, study: &StudyFile, rows: &[Row]) -> usize {
        let each: usize = self.broken(study, rows).iter().map(|(_, count, _)| count).sum();
        each + broken_in_the_mean(&study.constraints, rows, &self.default).len()
    }
}

/// The level of one objective's test.
fn level(study: &StudyFile) -> f64 {
    LEVEL / study.objectives.len() as f64
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
            Some(comparison) => compared(&objective.name, comparison, level(study)),
            None => format!("{}: not measured", objective.name),
        });
        words.push(format!("held out, candidate {} against the default: {}", found.trial, told.collect::<Vec<_>>().join("; ")));
        let [lost, won] = held.unpaired(study, &found.rows);
        for (count, who) in [(lost, "the default has figures and it has none"), (won, "it has figures and the default has none")]
        {
            if count > 0 {
                words.push(format!("held out, candidate {}: in {count} of {} runs {who}", found.trial, found.rows.len()));
            }
        }
        for (name, excess) in broken_in_the_mean(&study.constraints, &found.rows, &held.default) {
            words.push(format!("held out, candidate {} breaks \"{name}\" by {:.1} %", found.trial, 100.0 * excess));
        }
        let default = held.broken(study, &held.default);
        for (name, count, most) in held.broken(study, &found.rows) {
            let own = default.iter().find(|(other, ..)| *other == name).map_or(0, |(_, count, _)| *count);
            words.push(format!(
                "held out, candidate {} breaks \"{name}\" in {count} of {} runs (the default in {own}), by {:.1} % of the bound at most (1000 % are the most that count)",
                found.trial,
                found.rows.len(),
                100.0 * most
            ));
        }
    }
    let comparisons = held.found.iter().flat_map(|found| found.comparisons.iter().flatten());
    if let Some(held) = comparisons.min_by_key(|comparison| comparison.units) {
        // Signs that are all the same by chance: 2 in 2^n.
        let least = (1..).find(|n| 2.0 / libm::exp2(f64::from(*n)) < level(study)).unwrap_or(1) as usize;
        if held.units < least {
            let unit = if held.by_duct { "ducts" } else { "pairs" };
            words.push(format!("{} {unit} cannot show a gain at 5 %: hold out {least} or more", held.units));
        }
        if !held.by_duct {
            words.push("one duct alone was held out: what is said holds there, with other seeds".to_owned());
        }
    }
    words
}

/// What a comparison says: how much less or more the find costs, and how sure that is.
fn compared(objective: &str, held: &Comparison, level: f64) -> String {
    let (sign, word) = if held.gain >= 0.0 { (1.0, "less") } else { (-1.0, "more") };
    // Of a cost that can be below zero there are no shares.
    let relative = held.default_cost > 0.0;
    let told = |value: f64| match relative {
        true => format!("{:.1}", 100.0 * sign * value / held.default_cost),
        false => format!("{:.4e}", sign * value),
    };
    let mut interval = held.interval.map(|end| sign * end);
    interval.sort_by(f64::total_cmp);
    let (unit, units) = (if relative { " %" } else { "" }, if held.by_duct { "ducts" } else { "pairs" });
    let noise = if held.is_better(level) || held.is_worse(level) { "" } else { ", no more than noise" };
    format!(
        "{objective} {}{unit} {word} ({} to {}{unit}, p = {:.4}, better on {} of {} {units}{noise})",
        told(held.gain),
        told(sign * interval[0]),
        told(sign * interval[1]),
        held.p_value,
        held.better,
        held.units
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::study_file::Over;

    fn told(pairs: &[[f64; 2]]) -> String {
        compared("cost", &Comparison::of(&[pairs.to_vec()], Over::Mean, 1).expect("pairs"), 0.05)
    }

    #[test]
    fn a_comparison_says_which_way_it_goes_and_how_sure_it_is() {
        let pairs =
            |default: f64, found: f64| -> Vec<[f64; 2]> { (0..8).map(|i| [default + 0.01 * f64::from(i), found]).collect() };
        assert_eq!(told(&pairs(2.0, 1.0)), "cost 50.9 % less (50.1 to 51.7 %, p = 0.0078, better on 8 of 8 pairs)");
        assert!(told(&pairs(1.0, 2.0)).starts_with("cost 93.2 % more (91."), "{}", told(&pairs(1.0, 2.0)));
        let even = [[1.0, 1.1], [1.1, 1.0], [1.0, 1.2], [1.2, 1.0]];
        assert!(told(&even).contains("0.0 % less") && told(&even).contains("no more than noise"), "{}", told(&even));
        // A cost below zero has no shares.
        assert!(told(&[[-3.0, -4.0]; 6]).starts_with("cost 1.0000e0 less"), "{}", told(&[[-3.0, -4.0]; 6]));
    }
}
