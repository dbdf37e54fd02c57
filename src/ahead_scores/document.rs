//! The scores of a run, as `summary.json` has them.

use ductloop_nav::ahead::Fitting;
use serde::Serialize;

use super::approach::FittingScore;
use super::confusion::{Confusion, false_alarms};
use super::glance::Glance;
use super::way::{Thing, Way};
use crate::record::RunRecord;
use crate::scenario::Scenario;

/// How what lay ahead was named. Fields in this order.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AheadScores {
    /// What the robot came to, in order.
    pub fittings: Vec<FittingScore>,
    /// What these were against what they were named last.
    pub by_fittings: Confusion,
    /// What was within reach against what was named, frame by frame.
    pub by_frames: Confusion,
    /// How often something was named in a duct that goes straight on as far as can be seen; null where nothing was ever said.
    pub false_alarms: Option<u32>,
}

impl AheadScores {
    /// Of a run; nothing if the scenario's duct is none, which no scenario that was read has.
    pub fn of(scenario: &Scenario, run: &RunRecord) -> Self {
        let Ok(network) = scenario.duct.network() else { return Self::default() };
        let way = Way::new(scenario, &network);
        let glances: Vec<Glance> = run.frames.iter().filter_map(Glance::of).collect();
        // The arc by which the robot left the duct that it was in, the so manieth by its own count.
        let radius_m = |ducts: usize| {
            let duct = run.notes.ducts.get(ducts.checked_sub(1)?)?;
            Some(duct.radius_m).filter(|radius_m| matches!(duct.by, Some(Fitting::Elbow(_))) && radius_m.is_finite())
        };
        Self::of_glances(way.things(), &glances, radius_m)
    }

    /// Of frames on the path, in order.
    pub fn of_glances(things: &[Thing], glances: &[Glance], radius_m: impl Fn(usize) -> Option<f64>) -> Self {
        let approaches = glances.chunk_by(|a, b| a.truth.thing == b.truth.thing);
        let score = |approach: &[Glance]| FittingScore::of(things.get(approach[0].truth.thing)?, approach, &radius_m);
        let fittings: Vec<FittingScore> = approaches.filter_map(score).collect();
        Self {
            by_fittings: Confusion::of_fittings(&fittings),
            by_frames: Confusion::of_frames(glances),
            false_alarms: glances.iter().any(|glance| glance.named.is_some()).then(|| false_alarms(glances)),
            fittings,
        }
    }

    /// Share of fittings that were named rightly before they were entered; `None` where there was none.
    pub fn named_share(&self) -> Option<f64> {
        let right = self.fittings.iter().filter(|score| score.right).count();
        (!self.fittings.is_empty()).then(|| right as f64 / self.fittings.len() as f64)
    }

    /// Least detection distance of elbows, tees, crosses and dead ends that could be seen from two widths, in widths.
    pub fn detection_widths_min(&self) -> Option<f64> {
        self.fittings.iter().filter(|score| score.has_goal).map(|score| score.detected_widths).reduce(f64::min)
    }

    /// Longest time from when a fitting could be seen to when it was named.
    pub fn latency_max_s(&self) -> Option<f64> {
        self.fittings.iter().map(|score| score.latency_s).reduce(f64::max)
    }

    /// Largest error of a named distance.
    pub fn distance_error_max_m(&self) -> Option<f64> {
        self.fittings.iter().filter_map(|score| score.distance_error_m).map(f64::abs).reduce(f64::max)
    }
}
