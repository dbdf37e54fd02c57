//! The search: generation by generation, each a sweep of its own, so that all that carries out sweeps carries out a study.
//!
//! All candidates meet the same ducts with the same seeds (common random numbers). With `halving`, a generation is first run with one seed
//! of each scenario; its worse half is not run any further (K. Jamieson and A. Talwalkar, *Non-stochastic Best Arm Identification*, AISTATS
//! 2016). What a candidate of that half cost is never reported as if it had had all of its runs, and never the best.
//!
//! Everything follows from the study and the outcomes, so a study that was broken off goes on by being begun again: what was run is found.

use super::candidate;
use super::objective::{Score, score};
use super::proposer::Proposer;
use crate::scenario::study_file::StudyFile;
use crate::scenario::sweep_file::{Design, Factor, Level, Levels, SweepFile};
use crate::sweep::table::Row;

/// A candidate with what it came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Its number; 0 is the default.
    pub number: u64,
    /// Generation, from 1; 0 is the default's.
    pub generation: u64,
    /// Its parameters; `None` is the scenarios' own.
    pub values: Option<Vec<Level>>,
    /// What it came to.
    pub score: Score,
    /// Whether it was run with all seeds: only then it may be the best.
    pub is_full: bool,
    /// Its runs.
    pub rows: Vec<Row>,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The budget is used.
    Budget,
    /// Steps are smaller than the study asks for.
    AtRest,
    /// There was no better candidate for as many generations as the study allows.
    NoGain,
}

impl Ended {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Budget => "its runs are used",
            Self::AtRest => "its steps are smaller than asked for",
            Self::NoGain => "no candidate was better for as many generations as allowed",
        }
    }
}

/// All that was tried.
#[derive(Clone, Debug)]
pub struct Search {
    /// In the order in which they were proposed; the default first.
    pub trials: Vec<Trial>,
    /// Number of the best that keeps all constraints.
    pub best: Option<usize>,
    /// Runs that were taken.
    pub runs: u64,
    /// Why it ended.
    pub ended: Ended,
}

/// A sweep over these candidates with so many seeds of each scenario.
pub fn sweep_of(study: &StudyFile, candidates: &[Vec<Level>], replicates: u32) -> SweepFile {
    let factors = study.parameters.iter().enumerate().map(|(index, parameter)| Factor {
        levels: Levels::List(candidates.iter().map(|candidate| candidate[index].clone()).collect()),
        ..parameter.clone()
    });
    SweepFile { factors: factors.collect(), design: Design::Listed, replicates, ..study.train.clone() }
}

/// The rows of a sweep over candidates, by candidate: bases come first, then points, then replicates.
fn by_candidate(rows: Vec<Row>, candidates: usize) -> Vec<Vec<Row>> {
    let mut all = vec![Vec::new(); candidates];
    for row in rows {
        all[(row.case.point % candidates as u64) as usize].push(row);
    }
    all
}

/// Searches. `carry_out` runs a sweep and gives its rows, in the order of its cases; `watch` sees the search after each generation.
///
/// # Errors
/// What `carry_out` ends with.
pub fn search<E>(
    study: &StudyFile,
    mut carry_out: impl FnMut(SweepFile) -> Result<Vec<Row>, E>,
    mut watch: impl FnMut(&[Trial], Option<usize>, u64),
) -> Result<Search, E> {
    let default = carry_out(SweepFile { factors: Vec::new(), ..study.train.clone() })?;
    let mut runs = default.len() as u64;
    let score_of = |rows: &[Row]| score(study, rows, &default);
    let first = Trial { number: 0, generation: 0, values: None, score: score_of(&default), is_full: true, rows: default.clone() };
    let mut best = first.score.is_feasible().then_some(0);
    let mut trials = vec![first];
    watch(&trials, best, runs);
    let mut proposer = Proposer::of(study);
    let all = study.train.replicates;
    let bases = study.train.bases.len() as u64;
    let (mut generation, mut last_gain) = (0, 0);
    let ended = loop {
        if runs >= study.runs {
            break Ended::Budget;
        }
        if study.stop.step.is_some() && proposer.is_at_rest() {
            break Ended::AtRest;
        }
        if study.stop.generations_without_gain.is_some_and(|most| generation - last_gain >= u64::from(most)) {
            break Ended::NoGain;
        }
        generation += 1;
        let candidates: Vec<Vec<Level>> =
            proposer.ask().iter().map(|point| candidate::values(&study.parameters, point)).collect();
        // One seed of each scenario first, where there are more.
        let halves = study.halving && all > 1 && candidates.len() > 2;
        let rows = carry_out(sweep_of(study, &candidates, if halves { 1 } else { all }))?;
        runs += rows.len() as u64;
        let mut runs_of = by_candidate(rows, candidates.len());
        let mut scores: Vec<Score> = runs_of.iter().map(|rows| score_of(rows)).collect();
        let mut is_full = vec![!halves; candidates.len()];
        if halves {
            let mut order: Vec<usize> = (0..candidates.len()).collect();
            order.sort_by(|a, b| scores[*a].rank().total_cmp(&scores[*b].rank()));
            let kept = &order[..candidates.len().div_ceil(2)];
            let goes_on: Vec<Vec<Level>> = kept.iter().map(|index| candidates[*index].clone()).collect();
            let rows = carry_out(sweep_of(study, &goes_on, all))?;
            runs += rows.len() as u64 - kept.len() as u64 * bases;
            for (index, rows) in kept.iter().zip(by_candidate(rows, goes_on.len())) {
                scores[*index] = score_of(&rows);
                runs_of[*index] = rows;
                is_full[*index] = true;
            }
        }
        proposer.tell(&told(&scores, &is_full));
        for (((values, score), is_full), rows) in candidates.into_iter().zip(scores).zip(is_full).zip(runs_of) {
            let number = trials.len();
            let is_better = is_full && score.is_feasible() && best.is_none_or(|best: usize| score.cost < trials[best].score.cost);
            trials.push(Trial { number: number as u64, generation, values: Some(values), score, is_full, rows });
            if is_better {
                (best, last_gain) = (Some(number), generation);
            }
        }
        watch(&trials, best, runs);
    };
    Ok(Search { trials, best, runs, ended })
}

/// What the proposer is told: of those that had all of their runs what orders them; the others are behind, in the order that one seed gave.
fn told(scores: &[Score], is_full: &[bool]) -> Vec<f64> {
    let of = |full: bool| scores.iter().zip(is_full).filter(move |(_, is)| **is == full).map(|(score, _)| score.rank());
    let worst = of(true).fold(f64::NEG_INFINITY, f64::max);
    let first = of(false).fold(f64::INFINITY, f64::min);
    scores.iter().zip(is_full).map(|(score, full)| if *full { score.rank() } else { worst + (score.rank() - first) }).collect()
}

#[cfg(test)]
mod tests;
