//! The find and the default on what was held out: their runs in pairs, their costs, their paths.

use std::ops::ControlFlow;

use super::candidate;
use super::comparison::{Comparison, together};
use super::objective::cost;
use super::search::Search;
use crate::closed_loop::{RunError, run_unscored};
use crate::engine::Engine;
use crate::pilot::Pilot;
use crate::scenario::study_file::{Objective, StudyFile};
use crate::scenario::sweep_file::Base;
use crate::sweep::table::Row;

/// Runs on what was held out, of the default and of what was found.
#[derive(Clone, Debug)]
pub struct Held {
    /// The default's runs.
    pub default: Vec<Row>,
    /// Those of the best, and of several objectives of the front's ends.
    pub found: Vec<HeldTrial>,
}

/// What was found, on what was held out.
#[derive(Clone, Debug)]
pub struct HeldTrial {
    /// Its number.
    pub trial: usize,
    /// Its runs, in the default's order: same ducts, same seeds.
    pub rows: Vec<Row>,
    /// It against the default by each objective, over the pairs that both measured; `None` without any.
    pub comparisons: Vec<Option<Comparison>>,
}

/// Lateral error along the way, of the default and of the find.
#[derive(Clone, Debug)]
pub struct Trajectories {
    /// What was run: scenario and seed.
    pub label: String,
    /// Distance along the duct and offset to the left of its middle, in metres, frame by frame.
    pub paths: [Vec<[f64; 2]>; 2],
}

/// Why two paths cannot be laid over each other.
#[derive(Debug, thiserror::Error)]
pub enum TrajectoryError {
    /// What was a scenario is none any more.
    #[error("{0}")]
    Scenario(#[from] crate::scenario::Diagnostics),
    /// The run could not begin or go on.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// What the default and another cost on one duct, in pairs with the same seed, where both measured it.
fn costs_on(base: usize, objective: &Objective, default: &[Row], rows: &[Row]) -> Vec<[f64; 2]> {
    let of = |row: &Row, own: &Row| cost(objective, &row.outcome, Some(&own.outcome));
    let pairs = default.iter().zip(rows).filter(|(own, _)| own.case.at.base == base);
    pairs.filter_map(|(own, row)| Some([of(own, own)?, of(row, own)?])).collect()
}

impl Held {
    /// Of the rows of all, in the same order.
    pub fn of(study: &StudyFile, default: Vec<Row>, found: Vec<(usize, Vec<Row>)>) -> Self {
        let compared = |rows: &[Row]| {
            let against = |objective: &Objective| {
                let ducts = (0..study.held_out.bases.len()).map(|base| costs_on(base, objective, &default, rows));
                Comparison::of(&ducts.collect::<Vec<_>>(), objective.over, study.seed)
            };
            study.objectives.iter().map(against).collect()
        };
        let found = found.into_iter().map(|(trial, rows)| HeldTrial { trial, comparisons: compared(&rows), rows }).collect();
        Self { default, found }
    }

    /// Costs by an objective of the default and of what was found, scenario by scenario, over the pairs that both measured.
    pub fn by_scenario(&self, study: &StudyFile, rows: &[Row], objective: &Objective) -> Vec<(String, [f64; 2])> {
        let of = |(base, scenario): (usize, &Base)| {
            let pairs = costs_on(base, objective, &self.default, rows);
            (!pairs.is_empty()).then(|| (scenario.name.clone(), together(objective.over, &pairs)))
        };
        study.held_out.bases.iter().enumerate().filter_map(of).collect()
    }

    /// Runs that the default measured and this did not, and the other way round, by any objective.
    pub fn unpaired(&self, study: &StudyFile, rows: &[Row]) -> [usize; 2] {
        let has_all =
            |row: &Row, own: &Row| study.objectives.iter().all(|one| cost(one, &row.outcome, Some(&own.outcome)).is_some());
        // As a share of the default nothing is measured where the default is not: its own figures are looked at as they are.
        let plain = |row: &Row| {
            let is_measured =
                |objective: &Objective| objective.weights.iter().all(|(metric, _)| row.outcome.metric(metric).is_some());
            study.objectives.iter().all(is_measured)
        };
        let pairs = || self.default.iter().zip(rows);
        let lost = pairs().filter(|(own, row)| has_all(own, own) && !has_all(row, own)).count();
        [lost, pairs().filter(|(own, row)| !plain(own) && plain(row)).count()]
    }

    /// Runs the first pair of default and best once more, frame by frame.
    ///
    /// # Errors
    /// Where a scenario or a renderer is not there any more.
    pub fn trajectories(
        &self,
        study: &StudyFile,
        search: &Search,
        engine: &Engine,
    ) -> Result<Option<Trajectories>, TrajectoryError> {
        let Some(values) = search.best.and_then(|best| search.trials[best].values.as_ref()) else { return Ok(None) };
        let Some(case) = self.default.first().map(|row| &row.case) else { return Ok(None) };
        let path = |settings: &[String]| -> Result<Vec<[f64; 2]>, TrajectoryError> {
            let scenario = study.held_out.scenario(case.at.base, settings, case.seed)?;
            let mut renderer = engine.renderer(&scenario, 1)?;
            let record = run_unscored(&scenario, Pilot::of(&scenario), renderer.as_mut(), |_, _| ControlFlow::Continue(()))
                .map_err(|failure| failure.error)?;
            Ok(record.frames.iter().map(|frame| [frame.truth.distance_m, frame.truth.lateral_m]).collect())
        };
        let found = candidate::settings(&study.parameters, values);
        let base = &study.held_out.bases[case.at.base];
        Ok(Some(Trajectories { label: format!("{}, seed {}", base.name, case.seed), paths: [path(&[])?, path(&found)?] }))
    }
}

/// What stands for the front: the best, and of several objectives the least of each; without the default.
pub fn representatives(search: &Search) -> Vec<usize> {
    let mut chosen: Vec<usize> = search.best.into_iter().collect();
    let objectives = search.trials.first().map_or(0, |trial| trial.costs.objectives.len());
    for objective in 0..objectives {
        let cost = |index: &usize| search.trials[*index].costs.objectives[objective];
        chosen.extend(search.front.iter().copied().min_by(|a, b| cost(a).total_cmp(&cost(b))));
    }
    let mut unique = Vec::new();
    for index in chosen.into_iter().filter(|index| search.trials[*index].values.is_some()) {
        if !unique.contains(&index) {
            unique.push(index);
        }
    }
    unique
}
