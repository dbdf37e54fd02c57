//! The search: generation by generation, each a sweep of its own, so that all that carries out sweeps carries out a study.
//!
//! All candidates meet the same ducts with the same seeds (common random numbers). With `halving`, a generation is first run with one seed
//! of each scenario, or where there is only one, on the first half of the scenarios; its worse half is not run any further (K. Jamieson and
//! A. Talwalkar, *Non-stochastic Best Arm Identification*, AISTATS 2016). It is halved once, since an evolution strategy learns from the order
//! of its better half. What a candidate of the worse half cost is never reported as if it had had all of its runs, and never the best.
//!
//! Of several objectives the front is sought: candidates that no other betters in every objective. Nobody can say of those which half is
//! worse before they are run, so there is no halving.
//!
//! Everything follows from the study and the outcomes, so a study that was broken off goes on by being begun again: what was run is found.

use super::ask_tell::{AskTell, Lost};
use super::front::Costs;
use super::objective::{costs, rank};
use super::{candidate, front};
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
    pub costs: Costs,
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
    /// Who proposes has nothing more to propose.
    Finished,
}

impl Ended {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Budget => "its runs are used",
            Self::AtRest => "its steps are smaller than asked for",
            Self::NoGain => "no candidate was better for as many generations as allowed",
            Self::Finished => "the optimiser proposed nothing more",
        }
    }
}

/// All that was tried.
#[derive(Clone, Debug)]
pub struct Search {
    /// Who proposed.
    pub optimiser: String,
    /// In the order in which they were proposed; the default first.
    pub trials: Vec<Trial>,
    /// Number of the best that keeps all constraints; of several objectives the front's compromise.
    pub best: Option<usize>,
    /// Numbers of all that keep the constraints and that no other betters in every objective, by the first objective; of one objective the
    /// best alone.
    pub front: Vec<usize>,
    /// Runs that were taken.
    pub runs: u64,
    /// Why it ended.
    pub ended: Ended,
}

/// How candidates are run: all, and what their first stage is where there are two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stages {
    bases: usize,
    replicates: u32,
    /// Scenarios and seeds of each before the worse half is dropped.
    first: Option<(usize, u32)>,
}

impl Stages {
    fn of(study: &StudyFile) -> Self {
        let (bases, replicates) = (study.train.bases.len(), study.train.replicates);
        let first = match (bases, replicates) {
            (bases, 2..) => Some((bases, 1)),
            (2.., _) => Some((bases.div_ceil(2), 1)),
            _ => None,
        };
        Self { bases, replicates, first: first.filter(|_| study.halving && study.objectives.len() == 1) }
    }

    /// Those of so many candidates; a pair is not halved.
    fn first_of(self, candidates: usize) -> Option<(usize, u32)> {
        self.first.filter(|_| candidates > 2)
    }

    /// Runs of so many candidates.
    fn runs_of(self, candidates: usize) -> u64 {
        let all = self.bases as u64 * u64::from(self.replicates);
        match self.first_of(candidates) {
            None => candidates as u64 * all,
            Some((bases, replicates)) => {
                let first = bases as u64 * u64::from(replicates);
                candidates as u64 * first + candidates.div_ceil(2) as u64 * (all - first)
            }
        }
    }
}

/// A sweep over these candidates on the first so many scenarios, with so many seeds of each.
pub fn sweep_of(study: &StudyFile, candidates: &[Vec<Level>], (bases, replicates): (usize, u32)) -> SweepFile {
    let factors = study.parameters.iter().enumerate().map(|(index, parameter)| Factor {
        levels: Levels::List(candidates.iter().map(|candidate| candidate[index].clone()).collect()),
        ..parameter.clone()
    });
    let bases = study.train.bases[..bases].to_vec();
    SweepFile { bases, factors: factors.collect(), design: Design::Listed, replicates, ..study.train.clone() }
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
/// What `carry_out` ends with, or that who proposes is lost.
pub fn search<E: From<Lost>>(
    study: &StudyFile,
    optimiser: &mut dyn AskTell,
    mut carry_out: impl FnMut(SweepFile) -> Result<Vec<Row>, E>,
    mut watch: impl FnMut(&Search),
) -> Result<Search, E> {
    let default = carry_out(SweepFile { factors: Vec::new(), ..study.train.clone() })?;
    let costs_of = |rows: &[Row]| costs(study, rows, &default);
    let runs = default.len() as u64;
    let first = Trial { number: 0, generation: 0, values: None, costs: costs_of(&default), is_full: true, rows: default.clone() };
    let own: Vec<Option<f64>> = study.parameters.iter().map(|parameter| candidate::default(study, parameter)).collect();
    optimiser.begin(&first, &own)?;
    let name = optimiser.name();
    let mut found = Search { optimiser: name, trials: vec![first], best: None, front: Vec::new(), runs, ended: Ended::Budget };
    found.look();
    watch(&found);
    let stages = Stages::of(study);
    let (mut generation, mut last_gain) = (0, 0);
    loop {
        if study.stop.step.is_some() && optimiser.is_at_rest() {
            found.ended = Ended::AtRest;
            return Ok(found);
        }
        if study.stop.generations_without_gain.is_some_and(|most| generation - last_gain >= u64::from(most)) {
            found.ended = Ended::NoGain;
            return Ok(found);
        }
        let left = study.runs.saturating_sub(found.runs);
        if stages.runs_of(1) > left {
            return Ok(found);
        }
        generation += 1;
        let mut candidates = optimiser.ask()?;
        if candidates.is_empty() {
            found.ended = Ended::Finished;
            return Ok(found);
        }
        // The last ones are as many as the budget has left.
        while stages.runs_of(candidates.len()) > left {
            candidates.pop();
        }
        let trials = generation_of(study, stages, candidates, &mut carry_out, &costs_of)?;
        let first = found.trials.len();
        for (index, (values, costs, is_full, rows)) in trials.into_iter().enumerate() {
            let number = (first + index) as u64;
            found.trials.push(Trial { number, generation, values: Some(values), costs, is_full, rows });
        }
        found.runs += stages.runs_of(found.trials.len() - first);
        optimiser.tell(&found.trials[first..])?;
        let before = found.front.clone();
        found.look();
        if found.front != before {
            last_gain = generation;
        }
        watch(&found);
    }
}

/// A candidate's values, what it came to, whether it had all of its runs, and these.
type Tried = (Vec<Level>, Costs, bool, Vec<Row>);

/// Runs a generation.
fn generation_of<E>(
    study: &StudyFile,
    stages: Stages,
    candidates: Vec<Vec<Level>>,
    carry_out: &mut impl FnMut(SweepFile) -> Result<Vec<Row>, E>,
    costs_of: &impl Fn(&[Row]) -> Costs,
) -> Result<Vec<Tried>, E> {
    let all = (stages.bases, stages.replicates);
    let first = stages.first_of(candidates.len());
    let rows = by_candidate(carry_out(sweep_of(study, &candidates, first.unwrap_or(all)))?, candidates.len());
    let tried = |(values, rows): (Vec<Level>, Vec<Row>)| (values, costs_of(&rows), first.is_none(), rows);
    let mut trials: Vec<Tried> = candidates.into_iter().zip(rows).map(tried).collect();
    if first.is_some() {
        let mut order: Vec<usize> = (0..trials.len()).collect();
        order.sort_by(|a, b| rank(&trials[*a].1).total_cmp(&rank(&trials[*b].1)));
        let kept = &order[..trials.len().div_ceil(2)];
        let go_on: Vec<Vec<Level>> = kept.iter().map(|index| trials[*index].0.clone()).collect();
        let rows = by_candidate(carry_out(sweep_of(study, &go_on, all))?, go_on.len());
        for (index, rows) in kept.iter().zip(rows) {
            let (_, costs, is_full, own) = &mut trials[*index];
            (*costs, *is_full, *own) = (costs_of(&rows), true, rows);
        }
    }
    Ok(trials)
}

impl Search {
    /// Looks for the best among all that were tried.
    fn look(&mut self) {
        let first_cost = |index: &usize| self.trials[*index].costs.objectives[0];
        let costs_of = |of: &[usize]| -> Vec<Costs> { of.iter().map(|index| self.trials[*index].costs.clone()).collect() };
        let has_several = self.trials[0].costs.objectives.len() > 1;
        let full: Vec<usize> = (0..self.trials.len()).filter(|index| self.trials[*index].is_full).collect();
        let first = front::fronts(&costs_of(&full)).into_iter().next().unwrap_or_default();
        let mut front: Vec<usize> =
            first.into_iter().map(|at| full[at]).filter(|index| self.trials[*index].costs.is_feasible()).collect();
        // Of equal ones the first that was tried.
        front.sort_by(|a, b| first_cost(a).total_cmp(&first_cost(b)));
        if !has_several {
            front.truncate(1);
        }
        // A compromise is sought beside the default, where there is one.
        let beside: Vec<usize> = front.iter().copied().filter(|index| *index > 0).collect();
        let choice = if has_several && !beside.is_empty() { &beside } else { &front };
        let best = front::compromise(&costs_of(choice)).map(|at| choice[at]);
        (self.front, self.best) = (front, best);
    }
}

#[cfg(test)]
mod tests;
