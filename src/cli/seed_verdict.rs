//! What a scenario came to over its seeds.

use std::cmp::Ordering;

use ductloop::{Scenario, Verdict};
use serde_json::{Value, json};

use super::run::Finished;

/// The runs of one scenario with several seeds.
pub(crate) struct SeedVerdict<'a> {
    /// The scenario; its own seed is of no account here.
    pub(crate) scenario: &'a Scenario,
    /// How many seeds there are.
    pub(crate) seeds: usize,
    /// How many of them must pass.
    pub(crate) at_least: usize,
    /// Those that are over, in the order of the seeds; an interrupt leaves some out.
    pub(crate) runs: Vec<&'a Finished>,
}

/// A figure over the seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spread {
    /// The middle one; of an even number the mean of the two in the middle.
    pub(crate) median: f64,
    /// The largest.
    pub(crate) worst: f64,
}

impl SeedVerdict<'_> {
    /// How many seeds passed.
    pub(crate) fn passed(&self) -> usize {
        self.runs.iter().filter(|run| run.summary.verdict == Verdict::Pass).count()
    }

    /// Whether as many passed as have to.
    pub(crate) fn enough_passed(&self) -> bool {
        self.passed() >= self.at_least
    }

    /// The scenario's verdict. A run that could not go on, or was not given the time, is not made up for by others. `None` where an
    /// interrupt has left seeds out.
    pub(crate) fn verdict(&self) -> Option<Verdict> {
        let broken = self.runs.iter().map(|run| run.summary.verdict).max().filter(|worst| *worst > Verdict::Fail);
        let by_count = if self.enough_passed() { Verdict::Pass } else { Verdict::Fail };
        (self.runs.len() == self.seeds).then(|| broken.unwrap_or(by_count))
    }

    /// A figure over the seeds whose runs came to their end; `None` where it was measured in none.
    pub(crate) fn spread(&self, figure: impl Fn(&Finished) -> Option<f64>) -> Option<Spread> {
        let ended = self.runs.iter().filter(|run| run.summary.verdict <= Verdict::Fail);
        let mut values: Vec<f64> = ended.filter_map(|run| figure(run)).collect();
        values.sort_by(f64::total_cmp);
        let worst = *values.last()?;
        let (low, high) = (values[(values.len() - 1) / 2], values[values.len() / 2]);
        Some(Spread { median: low + (high - low) / 2.0, worst })
    }

    /// The runs, the worst first: by verdict, then by what they were off the centreline; what was not measured is worse than
    /// anything that was. Equals stay in the order of the seeds.
    pub(crate) fn worst_first(&self) -> Vec<&Finished> {
        let mut runs = self.runs.clone();
        runs.sort_by(|a, b| worse(b, a));
        runs
    }

    /// `{"scenario", "seeds", "passed", "at_least", "verdict"}`.
    pub(crate) fn to_json(&self) -> Value {
        json!({
            "scenario": self.scenario.name,
            "seeds": self.seeds,
            "passed": self.passed(),
            "at_least": self.at_least,
            "verdict": self.verdict().map(Verdict::word),
        })
    }
}

fn worse(a: &Finished, b: &Finished) -> Ordering {
    let off = |run: &Finished| [run.summary.metrics.lateral_rms_m, run.summary.metrics.heading_rms_rad];
    let figure = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
    let by_figures = || off(a).into_iter().zip(off(b)).map(|(a, b)| figure(a).total_cmp(&figure(b)));
    a.summary.verdict.cmp(&b.summary.verdict).then_with(|| by_figures().fold(Ordering::Equal, Ordering::then))
}
